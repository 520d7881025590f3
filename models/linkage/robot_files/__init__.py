"""Linkages in formats of robotics: MJCF (MuJoCo) is written and read, URDF and SDF are written."""

from ....framework.lazily import loaded_later

# Few linkages come from there or go there.
__getattr__, __dir__ = loaded_later(__name__, {}, modules=["formats", "left_out", "mjcf_read"])
