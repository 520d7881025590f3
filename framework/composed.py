"""A line element that answers as another does but for what it adds to it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass, replace
from typing import Self

from .batch import Array
from .entries import Change
from .protocol import LineElement


class OfAnother(LineElement):
    """What all elements have of another one that are made of it, whatever else they answer themselves."""

    own: LineElement

    @abstractmethod
    def made_of(self, own: LineElement) -> Self:
        """The same of another element."""

    @property
    def innermost(self) -> LineElement:
        """The element that it is made of, and that is made of no other."""
        return self.own.innermost if isinstance(self.own, OfAnother) else self.own

    def of_innermost(self, own: LineElement) -> Self:
        """The same where the innermost is another element."""
        return self.made_of(self.own.of_innermost(own) if isinstance(self.own, OfAnother) else own)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the parameters."""
        return self.own.shape

    @property
    def exact(self) -> bool:
        """Whether in statics one piece is exact."""
        return self.own.exact

    @property
    def roundings(self) -> float:
        """Roundings that the stiffnesses of `springs` may be off."""
        return self.own.roundings

    @property
    def quadrature(self) -> int:
        """Gauss points for a linear load times the shape functions."""
        return self.own.quadrature

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Fractions and weights by which matrices are integrated."""
        return self.own.integration_points

    @property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of what the section law varies with."""
        return self.own.sections_shape


@dataclass(frozen=True, eq=False)
class Composed(OfAnother):
    """What answers as `own`; a subclass overrides what it changes, and `kind`."""

    own: LineElement

    def __post_init__(self) -> None:
        object.__setattr__(self, "segments", self.own.segments)
        object.__setattr__(self, "releases", self.own.releases)

    @property
    def kind(self) -> Hashable:
        """That of the element, among those that it is composed to."""
        return type(self), type(self.own), self.own.kind

    @property
    def title(self) -> str:
        """How messages name the element."""
        return self.own.title

    @property
    def has_springs(self) -> bool:
        """It has those of the element."""
        return True

    @property
    def balanced(self) -> bool | None:
        """Whether a rigid motion costs nothing."""
        return self.own.balanced

    @property
    def tension(self) -> Array:
        """Axial force at rest with which the frame is loaded, (...)."""
        return self.own.tension

    def made_of(self, own: LineElement) -> Self:
        """The same of another element."""
        return replace(self, own=own)

    def part(self, index: int, count: int) -> LineElement:
        """One of `count` equal parts."""
        return self.made_of(self.own.part(index, count))

    def cut(self, change: Change) -> Self:
        """The element at some entries of its batch."""
        return replace(self, own=self.own.cut(change) if self.own.shape else self.own)

    def check(self, chord: Array) -> None:
        """Whether the member can lie along a chord."""
        self.own.check(chord)

    def axes(self, chord: Array) -> Array:
        """Local axes as rows, (..., 3, 3)."""
        return self.own.axes(chord)

    def stiffness_matrix(self, length: Array) -> Array:
        """Stiffness, (..., 12, 12)."""
        return self.own.stiffness_matrix(length)

    def springs(self, length: Array) -> tuple[Array, Array]:
        """The stiffness as springs on deformations."""
        return self.own.springs(length)

    def mass_matrix(self, length: Array) -> Array:
        """Consistent mass, (..., 12, 12)."""
        return self.own.mass_matrix(length)

    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        """Geometric stiffness under an axial force, (..., 12, 12)."""
        return self.own.geometric_matrix(length, axial)

    def end_forces(self, length: Array, displacement: Array) -> Array:
        """Forces on the ends, (..., 12)."""
        return self.own.end_forces(length, displacement)

    def resistance(self, length: Array, deformation: Array, pick: Change) -> tuple[Array, Array, Array]:
        """Energy, force and tangent at a deformation, of an element with a law of its own."""
        return self.own.resistance(length, deformation, pick)

    @property
    def has_law(self) -> bool:
        """Whether the element has a law of its own."""
        return self.own.has_law

    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacement between the ends, (..., 6, 12)."""
        return self.own.shape_functions(length, x)

    def shape_gradients(self, length: Array, x: Array) -> Array:
        """Derivative of the shape functions, (..., 6, 12)."""
        return self.own.shape_gradients(length, x)

    def shape_rows(self, length: Array, fraction: Array) -> tuple[Array, Array]:
        """Shape functions and their derivatives, (..., 6, 12) each."""
        return self.own.shape_rows(length, fraction)

    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit force, (..., 6)."""
        return self.own.section_flexibility(fraction)

    def section_inertia(self, fraction: Array) -> Array:
        """Inertia per length, (..., 6)."""
        return self.own.section_inertia(fraction)

    def section_sway(self, fraction: Array) -> Array:
        """Weights of the work of a unit axial force, (..., 6)."""
        return self.own.section_sway(fraction)

    def mass_per_length(self, fraction: Array) -> Array:
        """Mass per length, (...)."""
        return self.own.mass_per_length(fraction)

    def free_strain(self, fraction: Array) -> Array | None:
        """Strain and curvature without forces, (..., 6); None for none."""
        return self.own.free_strain(fraction)

    def restrained_forces(self, fraction: Array) -> Array | None:
        """Section forces that undo the free strain, with their sign turned, (..., 6); None for none."""
        return self.own.restrained_forces(fraction)

    def stress(self, fraction: Array, forces: Array) -> Array:
        """Extreme stresses, (..., 3)."""
        return self.own.stress(fraction, forces)
