"""Axes, matrices, loads and end forces of a member, by scikit-fem forms over its shape functions and section law.

All arrays have batch axes first and components last, in the member's local axes.
"""

from __future__ import annotations

import numpy as np

from .batch import Array
from .orientation import default_axes
from .scikit_fem import integrals
from .section_law import SectionLaw
from .shape_rules import spring_forces, summed


class MemberForms(SectionLaw):
    """What follows from a section law, or springs, by scikit-fem forms; base of `linkframe.framework.LineElement`."""

    @property
    def has_end_forces(self) -> bool:
        """Whether the element overrides `end_forces`, by a closed form."""
        return type(self).end_forces is not MemberForms.end_forces

    def axes(self, chord: Array) -> Array:
        """Local axes of a member as rows x, y, z.

        By default z is as near to global z as can be; a member along global z has its local y along global y.

        Parameters
        ----------
        chord
            Vector from the first node to the second, (..., 3), length.

        Returns
        -------
        ndarray
            Unit vectors in global components, (..., 3, 3), in the precision of the chord.
        """
        return default_axes(chord)

    def stiffness_matrix(self, length: Array) -> Array:
        """Stiffness in local axes, summed from the element's `springs` or integrated from its section law.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Forces and moments at both ends per unit displacement and rotation of the ends, (..., 12, 12).
        """
        if not self.has_springs:
            found: Array = integrals.integrated_stiffness(self, length)
            return found
        stiffness, rows = self.springs(np.asarray(length, dtype=np.float64))
        return summed(stiffness, rows)

    def mass_matrix(self, length: Array) -> Array:
        """Consistent mass in local axes, integrated from `section_inertia`.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Mass matrix by the displacements and rotations of both ends, (..., 12, 12).
        """
        found: Array = integrals.integrated_mass(self, length)
        return found

    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        """Geometric stiffness under an axial force in local axes, integrated from `section_sway`.

        Parameters
        ----------
        length
            Length of the member, (...).
        axial
            Axial force, (...), tension positive.

        Returns
        -------
        ndarray
            Forces and moments at both ends per unit displacement and rotation of the ends, (..., 12, 12).
        """
        found: Array = integrals.integrated_geometric(self, length, axial)
        return found

    def consistent_loads(self, length: Array, x: Array, forces: Array) -> Array:
        """End forces that do the same work as forces and moments on the member, integrated with its shape functions.

        Frames sum over the shape functions themselves, for all members and batch entries at once; an override must give
        the same.

        Parameters
        ----------
        length
            Length of the member, (...).
        x
            Distances from the start, (points, ...).
        forces
            ``fx fy fz mx my mz`` at each of them in local axes, (points, ..., 6): for a distributed load, the load per
            length times the weight of a quadrature over its stretch.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12), in local axes.
        """
        found: Array = integrals.integrated_loads(self, length, np.asarray(x), np.asarray(forces))
        return found

    def strain_loads(self, length: Array) -> Array:
        """End forces that are equivalent to the free strain, integrated from `restrained_forces`.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12), in local axes; zero without free strain.
        """
        if self.free_strain(np.full((1,) * (np.ndim(length) + 1), 0.5)) is None:
            return np.zeros((*np.shape(length), 12))
        found: Array = integrals.integrated_strain(self, length)
        return found

    def end_forces(self, length: Array, displacement: Array) -> Array:
        """Force and moment on each end of the member, from its `springs` or integrated from its section law.

        Frames compute those of an element without an override from its springs, those of the section law included.

        Parameters
        ----------
        length
            Length of the member, (...).
        displacement
            End displacements in local axes, (..., 12).

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12), in local axes: the stiffness times the
            displacement.
        """
        if not self.has_springs:
            found: Array = integrals.integrated_forces(self, length, np.asarray(displacement))
            return found
        return spring_forces(*self.springs(np.asarray(length, dtype=np.float64)), displacement)
