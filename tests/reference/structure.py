"""A frame as plain data: what the reference, the usual assembly and linkframe are all given."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf
from typing import Any

COMPONENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
LOADS = ("fx", "fy", "fz", "mx", "my", "mz")

# A float or a 50-digit number; both are taken as exact.
Number = Any
Vector = tuple[Number, Number, Number]


@dataclass(frozen=True)
class Member:
    """A uniform beam; `ky` and `kz` are shear coefficients, inf for a beam that does not shear."""

    start: str
    end: str
    E: float
    G: float
    A: float
    Iy: float
    Iz: float
    J: float
    ky: float = inf
    kz: float = inf
    up: Vector = (0.0, 0.0, 1.0)

    @property
    def shear(self) -> bool:
        """Whether the member deforms in shear."""
        return self.ky < inf


@dataclass(frozen=True)
class Spring:
    """A joint: six springs between two coincident nodes, along the columns of `axes`; a screw where it has a pitch."""

    first: str
    second: str
    stiffness: tuple[float, ...]
    axes: tuple[Vector, Vector, Vector] = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    pitch: float = 0.0


@dataclass(frozen=True)
class Structure:
    """Nodes, members, joints, rigid links (master, slave), supports and prescribed displacements, nodal loads."""

    nodes: Mapping[str, Vector]
    members: Mapping[str, Member]
    joints: Mapping[str, Spring] = field(default_factory=dict)
    rigid: tuple[tuple[str, str], ...] = ()
    supports: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    loads: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
