"""Elements of a frame: material, cross-sections, beam, joint, spring, point mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ..framework.lazily import loaded_later

if TYPE_CHECKING:
    from ..framework.scikit_fem.arc_length import ArcLengthMapping
    from ..framework.scikit_fem.line_frame import ElementLineFrame
    from .beam import Beam
    from .circle import Circle
    from .cross_section import CrossSection
    from .i_section import ISection
    from .joint import Joint
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

# Each module is imported when a name of it is first used, to keep the import of the package short.
_LATER = {
    "ArcLengthMapping": "..framework.scikit_fem.arc_length",
    "Beam": ".beam",
    "Circle": ".circle",
    "CrossSection": ".cross_section",
    "ElementLineFrame": "..framework.scikit_fem.line_frame",
    "ISection": ".i_section",
    "Joint": ".joint",
    "Material": ".material",
    "PointMass": ".point_mass",
    "Rectangle": ".rectangle",
    "Section": ".section",
    "Spring": ".spring",
    "Tube": ".tube",
}

__getattr__, __dir__ = loaded_later(__name__, _LATER)
