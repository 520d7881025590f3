"""Elements of a frame: material, cross-sections, beam, joint, spring, point mass."""

from __future__ import annotations

from .arc_length import ArcLengthMapping
from .beam import Beam
from .circle import Circle
from .cross_section import CrossSection
from .i_section import ISection
from .joint import Joint
from .line_frame import ElementLineFrame
from .material import Material
from .point_mass import PointMass
from .rectangle import Rectangle
from .section import Section
from .spring import Spring
from .tube import Tube

__all__ = [
    "ArcLengthMapping",
    "Beam",
    "Circle",
    "CrossSection",
    "ElementLineFrame",
    "ISection",
    "Joint",
    "Material",
    "PointMass",
    "Rectangle",
    "Section",
    "Spring",
    "Tube",
]
