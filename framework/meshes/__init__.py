"""Line meshes of other programs, as nodes, connections and sets."""

from ..lazily import loaded_later

# Few frames are made from meshes.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["lines", "sources"])
