"""What the framework asks of an element; it knows nothing else about beams, joints or masses.

All arrays are stacks: batch axes first, components last. Forces and displacements of a line
element are in its local axes, start node before end node, each ``ux uy uz rx ry rz``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Changes a parameter; the number says how many of its last axes are no batch axes.
Change = Callable[[Array, int], Array]


class LineElement(ABC):
    """A straight member between two nodes: stiffness, mass and recovery in its own axes.

    Attributes
    ----------
    segments
        Number of equal parts into which the framework cuts the member.
    releases
        Released end components as ``(end, component)``, end 0 or 1, component 0 to 5.
    """

    segments: int
    releases: tuple[tuple[int, int], ...]

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @property
    @abstractmethod
    def kind(self) -> Hashable:
        """Equal for two elements whose stacks may be evaluated together."""

    @property
    @abstractmethod
    def exact(self) -> bool:
        """Whether in statics one piece is exact, so that segments change nothing."""

    @property
    def roundings(self) -> float:
        """Roundings, half a unit in the last place each, that the stiffnesses of `springs` may be off.

        What derives a section's properties from its sizes counts as well.
        """
        return 100.0

    @property
    @abstractmethod
    def quadrature(self) -> int:
        """Gauss points that integrate a linear load times the shape functions to rounding."""

    @abstractmethod
    def part(self, index: int, count: int) -> LineElement:
        """Part `index` of `count` equal parts, with the releases and taper that fall to it."""

    def cut(self, change: Change) -> Self:
        """The element at some entries of its batch: with every parameter that is an array changed.

        This is for dataclasses that hold nothing but their fields; metadata ``{"trailing": 1}`` tells of a field that
        its last axis is no batch axis.
        """
        found: Self = changed(self, change)
        return found

    @abstractmethod
    def check(self, chord: Array) -> None:
        """Raise FrameError where the member cannot lie along `chord` (..., 3)."""

    @abstractmethod
    def axes(self, chord: Array) -> Array:
        """Local axes as rows, (..., 3, 3), of a member along `chord` (..., 3)."""

    @abstractmethod
    def stiffness_matrix(self, length: Array) -> Array:
        """Stiffness, (..., 12, 12)."""

    @abstractmethod
    def springs(self, length: Array) -> tuple[Array, Array]:
        """The stiffness as six springs k (..., 6) on deformations b (..., 6, 12): ``K = sum_i k_i b_i b_i^T``.

        The deformations come in the precision of `length`, as do `axes` in that of the chord.
        """

    @abstractmethod
    def mass_matrix(self, length: Array) -> Array:
        """Consistent mass, (..., 12, 12)."""

    @abstractmethod
    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        """Geometric stiffness under the axial force `axial` (tension positive), (..., 12, 12)."""

    @abstractmethod
    def end_forces(self, length: Array, displacement: Array) -> Array:
        """Stiffness times `displacement` (..., 12), by way of the deformations, (..., 12)."""

    @abstractmethod
    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacement at distance `x` from the start for unit end displacements, (..., 6, 12)."""

    @abstractmethod
    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz`` at `fraction` of the length, (..., 6)."""

    @abstractmethod
    def mass_per_length(self, fraction: Array) -> Array:
        """Mass per length at `fraction` of the length, (...)."""

    @abstractmethod
    def stress(self, fraction: Array, forces: Array) -> Array:
        """Least and greatest normal stress and greatest von Mises stress, (..., 3).

        `forces` (..., 6) are ``N Vy Vz T My Mz`` at `fraction` of the length.
        """


class JointElement(ABC):
    """Six springs between two coincident nodes, in the joint's own axes.

    Attributes
    ----------
    stiffness
        (..., 6), each 0 (free) to inf (ideal).
    axes
        (..., 3, 3), the joint's axes as columns in global components; None for the global axes.
    clearance
        (...), radius of the ball inside which the components in `play` are free; 0 for none.
    play
        Indices of these components, of equal stiffness; empty for none.
    pitch
        (...), advance along z per turn about z: the spring along z acts on what differs from it.
    """

    stiffness: Array
    axes: Array | None
    clearance: Array
    play: tuple[int, ...]
    pitch: Array

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def matrix(self) -> Array:
        """Stiffness of the two nodes in global axes, (..., 12, 12)."""

    @abstractmethod
    def typical(self) -> JointElement:
        """The joint without clearance, its springs those that are stiffest in the batch: what has no batch of its own
        but that of its geometry."""


class PointElement(ABC):
    """Inertia at one node."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def mass_matrix(self) -> Array:
        """Mass in global axes, (..., 6, 6)."""


def changed(described: Any, change: Change) -> Any:
    """A dataclass with its arrays changed, and those of the dataclasses in it; its numbers are not checked again."""
    twin = object.__new__(type(described))
    for each in fields(described):
        value = getattr(described, each.name)
        if isinstance(value, np.ndarray):
            value = change(value, each.metadata.get("trailing", 0))
        elif is_dataclass(value):
            value = changed(value, change)
        object.__setattr__(twin, each.name, value)
    return twin
