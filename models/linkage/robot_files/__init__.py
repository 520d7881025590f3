"""Linkages in formats of robotics: MJCF (MuJoCo) is written and read, URDF and SDF are written."""
