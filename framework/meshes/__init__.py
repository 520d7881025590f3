"""Line meshes of other programs, as nodes, connections and sets."""
