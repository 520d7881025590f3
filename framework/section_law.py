"""The interface to a member at each point of its length: shape functions, section law, inertia and stress.

All arrays have batch axes first and components last.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from .batch import Array
from .errors import FrameError
from .shape_rules import gauss, gradients, section_springs


class SectionLaw(ABC):
    """Properties of a member at each point of its length, in local axes; base of `linkframe.framework.LineElement`."""

    # -- what every element defines ---------------------------------------------------------------------------------

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacement at a distance from the start for unit end displacements.

        At the ends the displacement must equal that of the nodes; the rotation need not. Where the stiffness follows
        from a section law, the functions must reproduce every rigid motion, in the precision of `length`.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distance from the start, (...).

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` at x per unit of each of the twelve end displacements, in local axes, (..., 6, 12).
        """

    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz`` at a fraction of the length.

        A component with zero flexibility does not deform. The default for an element that defines `springs` is zero:
        between its nodes it is then displaced by the shape functions alone.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Inverse of the section's stiffness in each of the six, such as ``1 / (E A)``, (..., 6).
        """
        if not self.has_springs:
            raise NotImplementedError
        return np.zeros((*np.broadcast_shapes(np.shape(fraction), self.shape), 6))

    def springs(self, length: Array) -> tuple[Array, Array]:
        """The stiffness as any number n of springs k on deformations b of the member.

        ``K = sum_i k_i b_i b_i^T``, as by natural modes (Argyris, *Recent Advances in Matrix Methods of Structural
        Analysis*, 1964). Deformations are computed in the precision of `length`, and `axes` in that of the chord: error
        bounds rely on a rigid motion costing no energy. A beam has six springs. Springs may resist rigid motion where
        something outside the frame supports the member, such as an elastic foundation. By default they are those of the
        section law at the quadrature points.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        tuple of ndarray
            Stiffnesses k, (..., n), and deformations b per unit end displacement, (..., n, 12).
        """
        return section_springs(self, length)

    # -- quadrature -------------------------------------------------------------------------------------------------

    @property
    def has_springs(self) -> bool:
        """Whether the element overrides `springs`, instead of those of the section law."""
        return type(self).springs is not SectionLaw.springs

    @property
    def quadrature(self) -> int:
        """Number of Gauss points that integrate a linear load times the shape functions to rounding.

        By default 4, which suits cubics.
        """
        return 4

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Quadrature points as fractions of the length, and weights, (points, ...), for the integration of matrices."""
        return gauss(max(self.quadrature, 4))

    def rule_between(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """The quadrature rule for loads on a stretch of the member, and for its deformation there.

        Parameters
        ----------
        lower, upper
            Start and end of the stretch as fractions of the member's length, (...).

        Returns
        -------
        tuple of ndarray
            Points as fractions of the stretch, and weights that add up to one, (points, ...); by default Gauss's rule.
        """
        lead = (-1, *(1,) * max(np.ndim(lower), np.ndim(upper)))
        points, weights = gauss(self.quadrature)
        return points.reshape(lead), weights.reshape(lead)

    @property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of the section law, which `shape` may exceed by that of the axes."""
        return self.shape

    # -- along the member -------------------------------------------------------------------------------------------

    def shape_gradients(self, length: Array, x: Array) -> Array:
        """Derivative of `shape_functions` along the member.

        The default is exact for polynomials up to the seventh degree.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distance from the start, (...).

        Returns
        -------
        ndarray
            ``ux' .. rz'`` at x per unit of each of the twelve end displacements, (..., 6, 12), per length.
        """
        return gradients(self, np.asarray(length), np.asarray(x) / length)

    def shape_rows(self, length: Array, fraction: Array) -> tuple[Array, Array]:
        """Both `shape_functions` and `shape_gradients`, at a fraction of the length.

        Parameters
        ----------
        length
            Length of the member, (...).
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        tuple of ndarray
            Values and derivatives, (..., 6, 12) each.
        """
        return self.shape_functions(length, fraction * length), self.shape_gradients(length, fraction * length)

    def section_inertia(self, fraction: Array) -> Array:
        """Inertia per length in each of ``ux .. rz``; by default of translation alone.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Mass per length (three times), and rotary inertia per length about x, y and z, (..., 6).
        """
        mass: Array = np.asarray(self.mass_per_length(fraction))[..., None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        return mass

    def section_sway(self, fraction: Array) -> Array:
        """The factors w in the work ``N / 2 int sum_i w_i u_i'^2 dx`` of an axial force, with u' of ``ux' .. rz'``.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            A factor for each of ``ux' .. rz'``, (..., 6); by default 1 for ``uy'`` and ``uz'`` and 0 for the others.
        """
        across = np.array([0.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        return np.broadcast_to(across, (*np.broadcast_shapes(np.shape(fraction), self.shape), 6))

    def mass_per_length(self, fraction: Array) -> Array:
        """Mass per length at a fraction of the length; zero by default.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Mass per unit of length, (...).
        """
        return np.zeros(np.broadcast_shapes(np.shape(fraction), self.shape))

    def free_strain(self, fraction: Array) -> Array | None:
        """Strain and curvature that arise without forces, such as by heat, at a fraction of the length; None for none.

        They add to the strains by forces and load the frame through `restrained_forces`.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray or None
            The six strains that are work-conjugate to ``N Vy Vz T My Mz``, (..., 6).
        """
        return None

    def restrained_forces(self, fraction: Array) -> Array | None:
        """The internal forces in a fully restrained member, with opposite sign; None where there is no free strain.

        They would produce the free strain: by default the free strain divided by the section flexibility.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray or None
            ``N Vy Vz T My Mz`` at that fraction, (..., 6).
        """
        strain = self.free_strain(fraction)
        if strain is None:
            return None
        flexibility = self.section_flexibility(fraction)
        strain, flexibility = np.broadcast_arrays(strain, flexibility)
        return np.divide(strain, flexibility, out=np.zeros(strain.shape), where=flexibility > 0.0)

    def stress(self, fraction: Array, forces: Array) -> Array:
        """Extreme stresses over the section at a fraction of the length; by default an error.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz`` at that fraction, (..., 6).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., 3), force per area.

        Raises
        ------
        FrameError
            If the element has no section.
        """
        raise FrameError(f"{type(self).__name__}: stress needs a section; ask for its forces")
