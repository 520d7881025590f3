"""Formats of robotics by the ending of the file."""

from __future__ import annotations

from collections.abc import Callable

from ..description.linkage_description import LinkageDescription
from .left_out import acting, not_rigid
from .mjcf_write import mjcf
from .sdf import sdf
from .urdf import urdf

FORMATS: dict[str, tuple[str, Callable[[LinkageDescription, str], str]]] = {
    ".xml": ("MJCF", mjcf),
    ".urdf": ("URDF", urdf),
    ".sdf": ("SDF", sdf),
}


def robot_text(linkage: LinkageDescription, ending: str, title: str) -> tuple[str, str, list[str]]:
    """Text of a file, the name of its format, and the parts of the linkage that it cannot describe.

    Raises
    ------
    FrameError
        If the format cannot describe the linkage at all.
    """
    name, make = FORMATS[ending]
    return make(linkage, title), name, not_rigid(linkage) + (acting(linkage) if name != "MJCF" else [])
