"""What the framework asks of a member at each point of its length: shape functions, section law, inertia and stress.

All arrays are stacks: batch axes first, components last.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from .batch import Array
from .errors import FrameError
from .shape_rules import gauss, gradients, section_springs


class SectionLaw(ABC):
    """A member as seen at each point of its length, in its own axes; `linkframe.framework.LineElement` is one."""

    # -- what every element gives -----------------------------------------------------------------------------------

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the element's own parameters."""

    @abstractmethod
    def shape_functions(self, length: Array, x: Array) -> Array:
        """Displacement at a distance from the start for unit end displacements.

        At the ends the displacement, not always the rotation, is that of the nodes. Where the stiffness follows from a
        section law they come in the precision of `length`, and hold every rigid motion.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distance from the start, (...).

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` there by the twelve of the ends, in local axes, (..., 6, 12).
        """

    def section_flexibility(self, fraction: Array) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz`` at a fraction of the length.

        A component without flexibility deforms nothing. Of an element that gives `springs` zero by default, so that
        its displacement between the nodes follows its ends.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            One over the stiffness of the section, such as ``1 / (E A)``, in each of the six, (..., 6).
        """
        if not self.has_springs:
            raise NotImplementedError
        return np.zeros((*np.broadcast_shapes(np.shape(fraction), self.shape), 6))

    def springs(self, length: Array) -> tuple[Array, Array]:
        """The stiffness as any number n of springs k on deformations b of the member.

        ``K = sum_i k_i b_i b_i^T``, as by natural modes (Argyris, *Recent Advances in Matrix Methods of Structural
        Analysis*, 1964). The deformations come in the precision of `length`, as do `axes` in that of the
        chord: error bounds rest on it that a rigid motion costs no energy. A beam has six; where something outside the
        frame holds the member, as a foundation does, springs resist its rigid motion. By default they are those of the
        section law at the points of the quadrature.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        tuple of ndarray
            Stiffnesses k, (..., n), and deformations b by the end displacements, (..., n, 12).
        """
        return section_springs(self, length)

    # -- how it is integrated ---------------------------------------------------------------------------------------

    @property
    def has_springs(self) -> bool:
        """Whether `springs` is its own and not that of the section law."""
        return type(self).springs is not SectionLaw.springs

    @property
    def quadrature(self) -> int:
        """Gauss points that integrate a linear load times the shape functions to rounding; by default for cubics."""
        return 4

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Fractions of the length and weights, (points, ...), by which matrices are integrated."""
        return gauss(max(self.quadrature, 4))

    def rule_between(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        """The rule by which loads on a stretch of the member, and what it strains there, are integrated.

        Parameters
        ----------
        lower, upper
            Where the stretch begins and ends, as fractions of the length, (...).

        Returns
        -------
        tuple of ndarray
            Fractions of the stretch and weights, (points, ...), that add up to one; by default Gauss's rule.
        """
        lead = (-1, *(1,) * max(np.ndim(lower), np.ndim(upper)))
        points, weights = gauss(self.quadrature)
        return points.reshape(lead), weights.reshape(lead)

    @property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of what the section law varies with."""
        return self.shape

    # -- along the member -------------------------------------------------------------------------------------------

    def shape_gradients(self, length: Array, x: Array) -> Array:
        """Derivative of `shape_functions` along the member.

        By default that of a polynomial up to the seventh degree.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distance from the start, (...).

        Returns
        -------
        ndarray
            ``ux' .. rz'`` there by the twelve end displacements, (..., 6, 12), per length.
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
        """Inertia per length that goes with each of ``ux .. rz``; by default of translation alone.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Mass per length three times, and its moments about x, y and z, (..., 6).
        """
        mass: Array = np.asarray(self.mass_per_length(fraction))[..., None] * np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
        return mass

    def section_sway(self, fraction: Array) -> Array:
        """Weight of each of ``ux' .. rz'`` squared in twice the work of a unit axial force.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            By default 1 for ``uy'`` and ``uz'`` and 0 for the others, (..., 6).
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
            Mass over length there, (...).
        """
        return np.zeros(np.broadcast_shapes(np.shape(fraction), self.shape))

    def free_strain(self, fraction: Array) -> Array | None:
        """Strain and curvature without forces at a fraction of the length, such as by heat; None for none.

        They work with ``N Vy Vz T My Mz``, and strain the member beside what forces do: by `restrained_forces` they
        load the frame.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray or None
            Of the six that work with ``N Vy Vz T My Mz``, (..., 6).
        """
        return None

    def restrained_forces(self, fraction: Array) -> Array | None:
        """Internal forces that undo the free strain, with their sign turned; None for none.

        By default the free strain divided by the section flexibility.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray or None
            ``N Vy Vz T My Mz`` there, (..., 6).
        """
        strain = self.free_strain(fraction)
        if strain is None:
            return None
        flexibility = self.section_flexibility(fraction)
        strain, flexibility = np.broadcast_arrays(strain, flexibility)
        return np.divide(strain, flexibility, out=np.zeros(strain.shape), where=flexibility > 0.0)

    def stress(self, fraction: Array, forces: Array) -> Array:
        """Extreme stresses over the section at a fraction of the length.

        An element without a section, as by default, refuses.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz`` there, (..., 6).

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
