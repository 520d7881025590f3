"""Protocol of a member for scikit-fem forms and quadrature."""

from __future__ import annotations

from typing import Protocol

from ..batch import Array, Shape

Real = float | Array


class Shaped(Protocol):
    """A member that gives shape functions and a section law, as `linkframe.framework.LineElement` does."""

    @property
    def sections_shape(self) -> Shape:
        """Batch shape of the section law."""
        ...

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Fractions of the length and weights, (points, ...), of the quadrature."""
        ...

    def axes(self, chord: Array) -> Array:
        """Local axes as rows, (..., 3, 3), of a chord (..., 3)."""
        ...

    def shape_rows(self, length: Array, fraction: Array) -> tuple[Array, Array]:
        """Displacements by those of the ends, local, (..., 6, 12), and their derivatives along the member."""
        ...

    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz``, (..., 6)."""
        ...

    def section_inertia(self, fraction: Array) -> Array:
        """Inertia per length, (..., 6)."""
        ...

    def restrained_forces(self, fraction: Array) -> Array | None:
        """Section forces that would cause the free strain, (..., 6); None for none."""
        ...

    def section_sway(self, fraction: Array) -> Array:
        """Weights of ``ux' .. rz'`` squared in twice the work of a unit axial force, (..., 6)."""
        ...
