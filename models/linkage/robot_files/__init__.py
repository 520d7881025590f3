"""Linkages in the files of robotics: MJCF (MuJoCo) written and read, URDF and SDF written."""
