"""The beam element: a straight Euler-Bernoulli or Timoshenko beam between two nodes."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..framework.lazily import cached_property
from ..framework.protocol import Array, proven
from ..framework.shape_rules import after_first, summed_work
from .beam_section_law import BeamSectionLaw
from .bending import (
    Plane,
    PlaneSprings,
    bending_plane,
    plane_forces,
    plane_rows,
    stamp_stiffness,
    start_rows,
    strain_rows,
)
from .direction import BARS, DIRECTIONS, BendingPlane, deformations, stamp_rows
from .flexibility import Part, UniformPart, tapered_part
from .parameters import Real, as_real, shape_of
from .prismatic import (
    bar_mass,
    plane_geometric,
    plane_mass,
    prismatic_deformations,
    prismatic_rows,
    prismatic_springs,
)

_NOTHING: frozenset[int] = frozenset()


@proven
@dataclass(frozen=True, eq=False)
class Beam(BeamSectionLaw):
    """Straight 3-D beam, Euler-Bernoulli or Timoshenko, prismatic or tapered.

    The stiffness is that of the force method: normal force, torque, and in each plane of bending
    the shear force and the moment at the elastic centre work on six uncoupled deformations,
    so that ``K = sum_i k_i b_i b_i^T``, with ``1 / k_i`` the integral of the section's
    flexibility. For a prismatic beam these are Przemieniecki's (*Theory of Matrix Structural
    Analysis*, 1968, Eq. 5.116): ``E A / L``, ``G J / L``, ``E I / L`` and ``12 E I / (L^3 (1 + phi))``
    with ``phi = 12 E I / (k G A L^2)``, 0 without shear. For a tapered beam the integrals are computed
    by quadrature to rounding, so that one element is exact for forces at its ends.

    Local x runs from the first node to the second. Local z is as near to global z as can be; a member along
    global z has local y along global y. `up` gives another direction for local z. Where both ends are on one body of
    the frame, the axes of the body take the place of the global ones.

    Parameters
    ----------
    section : CrossSection
        Section at the start, and along the whole beam unless `end` is given.
    material : Material
        Moduli and density, constant along the beam.
    end : CrossSection, optional
        Section at the end, of the same type; sizes vary linearly in between.
    up : array_like, optional
        Direction (..., 3) in global axes (for a member on one body, in its axes), to which local z is as near as can
        be; not along the member.
    shear : bool
        Whether to include shear deformation: True for Timoshenko's theory, False for Euler-Bernoulli's.
    segments : int
        Number of equal parts into which the framework divides the member.
    release : iterable of str
        End components that carry no force, such as ``("start rz", "end ry")``, in local axes.

    Raises
    ------
    FrameError
        If `end` is of another type, `up` is not a direction, `segments` not a whole number above
        zero, a release unknown or too many, or if shapes do not broadcast.

    Examples
    --------
    >>> from linkframe.elements import Beam, Material, Rectangle
    >>> beam = Beam(Rectangle(y=0.1, z=0.05), Material(E=200e9, nu=0.3))
    >>> tip = 1.0 / beam.stiffness_matrix(2.0)[6:, 6:][0, 0]
    >>> bool(abs(tip * 200e9 * 0.005 - 2.0) < 1e-12)
    True
    """

    @property
    def family(self) -> Hashable | None:
        """Key that is equal for beams that differ in numbers alone: same forms of section, shear and releases."""
        end = None if self.end is None else self.end.form
        return Beam, self.section.form, end, self.up is None, self.shear, self.releases

    @property
    def deforms_as(self) -> Hashable | None:
        """Key that is equal for prismatic beams with the same `up` and releases."""
        if type(self) is not Beam or self.end is not None or (self.up is not None and self.up.ndim > 1):
            return None
        return Beam, None if self.up is None else self.up.tobytes(), self.releases

    # -- stiffness --------------------------------------------------------------------------------------------------

    def stiffness_matrix(self, length: Array | float) -> Array:
        """Stiffness in local axes, symmetric to the last bit, with exact zeros between uncoupled components.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Forces and moments at both ends per unit displacement and rotation of the ends, (..., 12, 12).

        Examples
        --------
        The entries of deflection and rotation, ``12 E I / L^3`` and ``6 E I / L^2`` (Przemieniecki 1968, Eq. 5.116).

        >>> from linkframe.elements import Beam, Material, Section
        >>> beam = Beam(Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0), Material(E=1.0, nu=0.3))
        >>> beam.stiffness_matrix(2.0)[1, [1, 5, 7]].round(12).tolist()
        [1.5, 1.5, -1.5]
        """
        length = as_real(length)
        matrix = np.zeros((*np.broadcast_shapes(np.shape(length), self.sections_shape), 12, 12))
        for i in BARS:
            k = self._bar(i, length)
            matrix[..., i, i] = matrix[..., i + 6, i + 6] = k
            matrix[..., i, i + 6] = matrix[..., i + 6, i] = -k
        for direction in DIRECTIONS:
            stamp_stiffness(matrix, self._plane(direction, length), direction.dofs, direction.sign)
        return matrix

    def springs(self, length: Array | float) -> tuple[Array, Array]:
        arm = np.asarray(length)
        # deformations come in the precision of the length
        if self.end is None and not self.releases:
            plain = np.asarray(arm, dtype=np.float64)
            stiffness, rows = prismatic_springs(self._flexibilities, plain), prismatic_rows(arm)
        else:
            length = as_real(arm)
            planes = [self._plane(direction, length) for direction in DIRECTIONS]
            stiffness = self._springs([plane.springs for plane in planes], length)
            # Deformations vary with the sections only if these move the elastic centre.
            varying = shape_of(arm.shape, *(plane.fraction for plane in planes))
            # Batch axes come last in memory, so that the batch of each component is contiguous.
            rows = np.zeros((6, 12, *varying), np.result_type(arm, np.float64))
            for at, number in deformations(planes, arm).items():
                rows[at] = number
        return stiffness.transpose(*range(1, stiffness.ndim), 0), rows.transpose(*range(2, rows.ndim), 0, 1)

    def spring_numbers(self, length: Array | float) -> tuple[list[Array], dict[tuple[int, int], Real]]:
        """The values of `springs` one by one, see `LineElement.spring_numbers`."""
        arm, length = np.asarray(length), as_real(length)
        planes = [self._plane(direction, length) for direction in DIRECTIONS]
        shape = shape_of(arm.shape, self.sections_shape)
        numbers = self._spring_stiffnesses([plane.springs for plane in planes], length)
        return [np.broadcast_to(number, shape) for number in numbers], deformations(planes, arm)

    def deformation_numbers(self, length: Array | float) -> dict[tuple[int, int], Real]:
        if self.end is None and not self.releases:
            return prismatic_deformations(np.asarray(length))
        return super().deformation_numbers(np.asarray(length))

    def spring_stiffness(self, length: Array | float) -> Array:
        if self.end is None and not self.releases:
            stiffness = prismatic_springs(self._flexibilities, np.asarray(length, dtype=np.float64))
        else:
            length = as_real(length)
            stiffness = self._springs([self._plane(direction, length).springs for direction in DIRECTIONS], length)
        return stiffness.transpose(*range(1, stiffness.ndim), 0)

    def _springs(self, planes: list[PlaneSprings], length: Real) -> Array:
        """Stiffness of the springs, (6, ...)."""
        stiffness = np.empty((6, *shape_of(np.shape(length), self.sections_shape)))
        for i, number in enumerate(self._spring_stiffnesses(planes, length)):
            stiffness[i] = number
        return stiffness

    def _spring_stiffnesses(self, planes: list[PlaneSprings], length: Real) -> list[Real]:
        found: list[Real] = [0.0] * 6
        for i in BARS:
            found[i] = self._bar(i, length)
        for direction, (shear, bend) in zip(DIRECTIONS, planes, strict=True):
            found[direction.deflection], found[direction.rotation] = shear, bend
        return found

    def end_forces(self, length: Array | float, displacement: Array) -> Array:
        u = np.moveaxis(np.asarray(displacement, dtype=np.float64), -1, 0)
        forces = np.empty((*np.broadcast_shapes(u.shape[1:], np.shape(length), self.sections_shape), 12))
        for k, force in enumerate(self.end_force_numbers(length, u)):
            forces[..., k] = force
        return forces

    def end_force_numbers(self, length: Array | float, displacement: Sequence[Any] | Array) -> list[Any]:
        # differences of displacements are taken first, so that a large rigid motion costs no digits
        length, u = as_real(length), displacement
        forces: list[Any] = [0.0] * 12
        for i in BARS:
            axial_force = self._bar(i, length) * (u[i + 6] - u[i])
            forces[i], forces[i + 6] = -axial_force, axial_force
        for direction in DIRECTIONS:
            v1, r1, v2, r2 = direction.dofs
            acting = plane_forces(
                self._plane(direction, length), u[v1], direction.sign * u[r1], u[v2], direction.sign * u[r2]
            )
            for dof, sign, force in zip(direction.dofs, direction.signs, acting, strict=True):
                forces[dof] = sign * force
        return forces

    def consistent_loads(self, length: Array | float, x: Array, forces: Array) -> Array:
        return summed_work(self.shape_functions(length, after_first(x, max(x.ndim - 1, np.ndim(length)))), forces)

    # -- shape ------------------------------------------------------------------------------------------------------

    def shape_functions(self, length: Array | float, x: Array | float) -> Array:
        """Displacement at a distance from the start for unit end displacements.

        Interdependent cubics for a prismatic beam (Friedman & Kosmatka, Comput. Struct. 47 (1993)
        473-481); for a tapered beam the exact curves, by quadrature. At a released component the displacement is that
        of the member's end, not of the node.

        Parameters
        ----------
        length, x
            Length of the member and distance from its start, (...).

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` at x per unit of each of the twelve end displacements, in local axes, (..., 6, 12).
        """
        length, x = as_real(length), as_real(x)
        return self._shapes(length, x / length)[0]

    def shape_gradients(self, length: Array | float, x: Array | float) -> Array:
        length, x = as_real(length), as_real(x)
        return self.shape_rows(length, x / length)[1]

    def shape_rows(self, length: Real, fraction: Real) -> tuple[Array, Array]:
        values, planes = self._shapes(length, fraction)
        slopes, flexibility, x = np.zeros_like(values), self._flexibility(fraction), fraction * length
        for i in BARS:
            slopes[..., i, i + 6] = self._bar(i, length) * flexibility[i]
            slopes[..., i, i] = -slopes[..., i, i + 6]
        for direction, plane in planes:
            stamp_rows(
                slopes,
                direction,
                strain_rows(plane, x, flexibility[direction.bending], flexibility[direction.shearing]),
            )
            # the slope is the sum of rotation and shear strain
            slopes[..., direction.deflection, :] += direction.sign * values[..., direction.rotation, :]
        return values, slopes

    def _shapes(self, length: Real, fraction: Real) -> tuple[Array, list[tuple[BendingPlane, Plane]]]:
        """`shape_functions` at a fraction of the length, (..., 6, 12), and the two planes of bending."""
        shape = np.broadcast_shapes(np.shape(length), np.shape(fraction), self.sections_shape)
        values, part, planes = np.zeros((*shape, 6, 12)), self._part(fraction), []
        for i in BARS:
            # a bar with a released end moves as a rigid body with its other end
            constrained, share = (0, i) not in self.releases, self._bar(i, length) * part.bar(i, length)
            values[..., i, i], values[..., i, i + 6] = (1.0 - share, share) if constrained else (0.0, 1.0)
        x = fraction * length
        for direction in DIRECTIONS:
            released, plane = self._released(direction), self._plane(direction, length)
            whole, here = (
                each.curve(direction.bending, direction.shearing, plane.fraction, length)
                for each in (self._whole, part)
            )
            start = start_rows(plane, length, whole, released)
            stamp_rows(values, direction, plane_rows(plane, start, x, here))
            planes.append((direction, plane))
        return values, planes

    # -- mass and geometric stiffness -------------------------------------------------------------------------------

    def mass_matrix(self, length: Array | float) -> Array:
        """Consistent mass with rotary inertia in local axes.

        The inertia in torsion is ``rho (Iy + Iz)`` per length (Przemieniecki, *Theory of Matrix Structural Analysis*,
        1968, ch. 11). Closed form for a prismatic beam, quadrature for a tapered one or one with releases.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Mass matrix by the displacements and rotations of both ends, (..., 12, 12).

        Examples
        --------
        For a motion along the beam it gives the whole mass, 3 m of 80 kg/m.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> beam = Beam(Rectangle(y=0.1, z=0.1), Material(E=200e9, nu=0.3, density=8000.0))
        >>> float(beam.mass_matrix(3.0)[::6, ::6].sum().round(9))
        240.0
        """
        length = as_real(length)
        if self.end is not None or self.releases:
            return super().mass_matrix(np.asarray(length))
        inertia = self._inertia(0.0)
        matrix = np.zeros((*np.broadcast_shapes(np.shape(length), self.sections_shape), 12, 12))
        for i in BARS:
            near, far = bar_mass(inertia[i], length)
            matrix[..., i, i] = matrix[..., i + 6, i + 6] = near
            matrix[..., i, i + 6] = matrix[..., i + 6, i] = far
        for direction in DIRECTIONS:
            rotary = inertia[direction.rotation]
            plane_mass(inertia[direction.deflection], rotary, length, self._phi(direction, length)).stamp(
                matrix, direction.dofs, direction.sign
            )
        return matrix

    def geometric_matrix(self, length: Array | float, axial: Array | float) -> Array:
        """Geometric stiffness under an axial force in local axes.

        From the work ``N / 2 int uy'^2 + uz'^2 + (Iy + Iz) / A rx'^2 dx`` of the axial force (the last
        term is Wagner's, for torsional buckling; McGuire, Gallagher & Ziemian, *Matrix Structural Analysis*, 2nd ed.,
        ch. 9). Closed form for a prismatic beam, quadrature for a tapered one or one with releases.

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

        Examples
        --------
        A tension of 1 N in a rigid bar of 2 m resists the lateral motion of one end with ``N / L``, 1/2 N/m.

        >>> import numpy as np
        >>> from linkframe.elements import Beam, Circle, Material
        >>> turned = np.zeros(12)
        >>> turned[[1, 5, 7, 11]] = 0.0, 0.5, 1.0, 0.5
        >>> beam = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
        >>> float((turned @ beam.geometric_matrix(2.0, 1.0) @ turned).round(12))
        0.5
        """
        length, axial = as_real(length), as_real(axial)
        if self.end is not None or self.releases:
            return super().geometric_matrix(np.asarray(length), np.asarray(axial))
        shape = np.broadcast_shapes(np.shape(length), np.shape(axial), self.sections_shape)
        matrix = np.zeros((*shape, 12, 12))
        wagner = axial * (self.section.Iy + self.section.Iz) / self.section.A / length
        matrix[..., 3, 3] = matrix[..., 9, 9] = wagner
        matrix[..., 3, 9] = matrix[..., 9, 3] = -wagner
        for direction in DIRECTIONS:
            plane_geometric(axial, length, self._phi(direction, length)).stamp(matrix, direction.dofs, direction.sign)
        return matrix

    # -- integrals of the flexibility -------------------------------------------------------------------------------

    def _part(self, fraction: Real) -> Part:
        """Integrals of the flexibility from the start to a fraction of the length."""
        if self.end is None:
            return UniformPart(fraction, self._flexibility(fraction))
        ndim = max(np.ndim(fraction), len(self.sections_shape))
        return tapered_part(self.section, self.end, self._flexibility, fraction, ndim)

    @cached_property
    def _whole(self) -> Part:
        if self.end is None or not self.releases:
            return self._part(1.0)
        ndim = len(self.sections_shape)
        return tapered_part(self.section, self.end, self._flexibility, 1.0, ndim, hinged=True)

    @cached_property
    def _flexibilities(self) -> Array:
        """Flexibility of the section of a prismatic beam, (6, ...)."""
        out = np.empty((6, *self.sections_shape))
        for i, number in enumerate(self._flexibility(0.0)):
            out[i] = number
        return out

    def _phi(self, direction: BendingPlane, length: Real) -> Real:
        """Ratio of the shear to the bending deformation of a prismatic beam."""
        flexibility = self._flexibility(0.0)
        return 12.0 * flexibility[direction.shearing] / (flexibility[direction.bending] * length * length)

    def _bar(self, component: int, length: Real) -> Real:
        """Stiffness in tension (0) or torsion (3)."""
        if (0, component) in self.releases or (1, component) in self.releases:
            return 0.0
        return 1.0 / self._whole.bar(component, length)

    def _plane(self, direction: BendingPlane, length: Real) -> Plane:
        """Stiffness in one plane of bending."""
        centre, rest, *bends = self._whole.bends(direction.bending, direction.shearing, length)
        return bending_plane((centre, rest), length, bends, self._released(direction))

    def _released(self, direction: BendingPlane) -> frozenset[int]:
        if not self.releases:
            return _NOTHING
        dofs = (end * 6 + component for end, component in self.releases)
        return frozenset(direction.dofs.index(dof) for dof in dofs if dof in direction.dofs)
