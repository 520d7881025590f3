"""Elements of a frame: material, cross-sections, beam, joint, point mass."""

from __future__ import annotations

from .beam import Beam
from .circle import Circle
from .cross_section import CrossSection
from .joint import Joint
from .line_frame import ArcLengthMapping, ElementLineFrame
from .material import Material
from .point_mass import PointMass
from .rectangle import Rectangle

__all__ = [
    "ArcLengthMapping",
    "Beam",
    "Circle",
    "CrossSection",
    "ElementLineFrame",
    "Joint",
    "Material",
    "PointMass",
    "Rectangle",
]
