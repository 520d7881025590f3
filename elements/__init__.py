"""Elements of a frame: material, cross-sections, beam, joint, spring, point mass."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

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

if TYPE_CHECKING:
    from .arc_length import ArcLengthMapping
    from .line_frame import ElementLineFrame

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

# These are scikit-fem's: it is loaded where they are first asked for.
_LATER = {"ArcLengthMapping": ".arc_length", "ElementLineFrame": ".line_frame"}


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_LATER[name], __name__), name)


def __dir__() -> list[str]:
    return [*globals(), *_LATER]
