"""What scikit-fem's forms, and quadrature over them, ask of a beam."""

from __future__ import annotations

from typing import Protocol

from ..framework.protocol import Array
from .cross_section import CrossSection
from .parameters import Real


class ShapedBeam(Protocol):
    """A member that gives shape functions, and sections along it, as `linkframe.elements.Beam` does."""

    @property
    def section(self) -> CrossSection:
        """Section, at the start where it is tapered."""
        ...

    @property
    def end(self) -> CrossSection | None:
        """Section at the end; None where prismatic."""
        ...

    @property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of the stiffness per length."""
        ...

    def axes(self, chord: Array) -> Array:
        """Local axes as rows, (..., 3, 3), of a chord (..., 3)."""
        ...

    def shape_rows(self, length: Real, fraction: Real) -> tuple[Array, Array]:
        """Displacements by those of the ends, local, (..., 6, 12), and their derivatives along the member."""
        ...

    def section_flexibility(self, fraction: Array | float) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz``, (..., 6)."""
        ...

    def section_inertia(self, fraction: Array | float) -> Array:
        """Inertia per length, (..., 6)."""
        ...

    def section_sway(self, fraction: Array | float) -> Array:
        """Weights of ``ux' .. rz'`` squared in twice the work of a unit axial force, (..., 6)."""
        ...
