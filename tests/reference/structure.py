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
    """A beam; `ky` and `kz` are shear coefficients, inf for a beam that does not shear.

    `taper` holds A, Iy, Iz and J at the end where they are others than at the start, linear in between; `release` the
    components of the ends that carry no force, such as ``"start rz"``.
    """

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
    taper: tuple[float, float, float, float] | None = None
    release: tuple[str, ...] = ()

    @property
    def releases(self) -> list[tuple[int, int]]:
        """Released components as end (0 or 1) and number."""
        words = [text.split() for text in self.release]
        return [(("start", "end").index(end), COMPONENTS.index(name)) for end, name in words]

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
class LineLoad:
    """Force per length on a member, linear from `start` to `end` over `span` (the whole member where None)."""

    member: str
    start: Vector
    end: Vector
    span: tuple[Number, Number] | None = None
    local: bool = False


@dataclass(frozen=True)
class PointLoad:
    """Force and moment on a member at a distance from its start."""

    member: str
    at: Number
    force: tuple[Number, ...]
    local: bool = False


@dataclass(frozen=True)
class Structure:
    """Nodes, members, joints, rigid links (master, slave), supports and prescribed displacements, nodal loads; ties
    (master, slave, components), displacements imposed on joints, loads on members."""

    nodes: Mapping[str, Vector]
    members: Mapping[str, Member]
    joints: Mapping[str, Spring] = field(default_factory=dict)
    rigid: tuple[tuple[str, str], ...] = ()
    supports: Mapping[str, Mapping[str, float]] = field(default_factory=dict)
    loads: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    ties: tuple[tuple[str, str, tuple[str, ...]], ...] = ()
    offsets: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    line_loads: tuple[LineLoad, ...] = ()
    point_loads: tuple[PointLoad, ...] = ()
