"""Straight beam between two nodes."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import KW_ONLY, dataclass, field, replace
from functools import cached_property

import numpy as np

from ..framework.errors import FrameError
from ..framework.orientation import axes_towards, default_axes
from ..framework.protocol import Array, LineElement, proven
from .bending import Plane, bending_plane, plane_forces, plane_rows, stamp_stiffness, start_rows, strain_rows
from .cross_section import CrossSection
from .direction import BARS, DIRECTIONS, BendingPlane, stamp_rows
from .flexibility import Part, Six, UniformPart, spread_points, tapered_part
from .material import Material
from .parameters import Real, array_of, as_real, common_shape, given_state, require, shape_of
from .prismatic import bar_mass, plane_geometric, plane_mass
from .releases import COMPONENTS, ENDS, parse_releases
from .section import Section

_NOTHING: frozenset[int] = frozenset()


@proven
@dataclass(frozen=True, eq=False)
class Beam(LineElement):
    """Straight 3-D beam, Euler-Bernoulli or Timoshenko, prismatic or tapered.

    The stiffness is that of the force method: the end forces (N, T, and in each plane of bending
    the shear force and the moment at the elastic centre) work on six deformations that do not
    mix, so that ``K = sum_i k_i b_i b_i^T``, with ``1 / k_i`` the integral of the section's
    flexibility. For a prismatic beam these are Przemieniecki's (*Theory of Matrix Structural
    Analysis*, 1968, Eq. 5.116): ``E A / L``, ``G J / L``, ``E I / L`` and ``12 E I / (L^3 (1 + phi))``
    with ``phi = 12 E I / (k G A L^2)``, 0 without shear. For a taper the integrals are taken
    by quadrature to rounding, so that one element is exact for forces at its ends.

    Local x runs from the first node to the second. Local z is as near to global z as can be; a member along
    global z has local y along global y. `up` gives another direction for local z. Where both ends are on one body of
    the frame, its axes stand for the global ones.

    Parameters
    ----------
    section : CrossSection
        Section at the start, and all along unless `end` is given.
    material : Material
        Moduli and density, the same all along.
    end : CrossSection, optional
        Section at the end, of the same type; sizes vary linearly in between.
    up : array_like, optional
        Direction (..., 3), global (of a member on one body, in its axes), to which local z is nearest.
    shear : bool
        Timoshenko's shear deformation (True) or none (False).
    segments : int
        Number of equal parts into which the framework cuts the member.
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

    section: CrossSection
    material: Material
    _: KW_ONLY
    end: CrossSection | None = None
    up: Array | None = field(default=None, metadata={"trailing": 1})
    shear: bool = False
    segments: int = 1
    release: Iterable[str] = ()
    releases: tuple[tuple[int, int], ...] = field(init=False, repr=False)

    def __post_init__(self) -> None:
        _check_parts(self)
        if self.up is not None:
            up = array_of("Beam", "up", self.up)
            if up.shape[-1:] != (3,):
                raise FrameError(f"Beam: up has shape {up.shape}; give three numbers, (..., 3)")
            require("Beam", "up", up, np.any(up != 0.0, axis=-1, keepdims=True) & np.isfinite(up), "a direction")
            object.__setattr__(self, "up", up)
        release = (self.release,) if isinstance(self.release, str) else tuple(self.release)
        object.__setattr__(self, "release", release)
        object.__setattr__(self, "releases", parse_releases(release))
        shapes = {"section": self.section.shape, "material": self.material.shape}
        shapes["end"] = () if self.end is None else self.end.shape
        shapes["up"] = () if self.up is None else self.up.shape[:-1]
        common_shape("Beam", shapes)

    def __getstate__(self) -> dict[str, object]:
        return given_state(self)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of section, material, end and up."""
        return shape_of(self.sections_shape, () if self.up is None else self.up.shape[:-1])

    @cached_property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of the stiffness per length: the broadcast of section, material and end."""
        return shape_of(self.section.shape, self.material.shape, () if self.end is None else self.end.shape)

    @property
    def kind(self) -> Hashable:
        """Equal for beams that share section, material, end, up, shear and releases."""
        up = None if self.up is None else (self.up.shape, self.up.tobytes())
        return self.section, self.material, self.end, up, self.shear, self.releases

    @property
    def family(self) -> Hashable | None:
        """Equal for beams of sections of one form that are alike in all but numbers."""
        end = None if self.end is None else self.end.form
        return Beam, self.section.form, end, self.up is None, self.shear, self.releases

    @property
    def exact(self) -> bool:
        """One piece is exact in statics: its shape functions solve the beam's equations."""
        return True

    @property
    def balanced(self) -> bool:
        """A rigid motion deforms nothing."""
        return True

    @property
    def roundings(self) -> float:
        """Roundings in `springs`; of 400 random members the worst had 6, of tapered ones 28."""
        return 12.0 if self.end is None else 100.0

    @property
    def quadrature(self) -> int:
        """Gauss points that integrate a linear load times the shape functions to rounding."""
        return 3 if self.end is None else 40

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Fractions and weights, (points, ...); those of a taper suit its flexibility, which is no polynomial."""
        return super().integration_points if self.end is None else spread_points(self.section, self.end)

    def part(self, index: int, count: int) -> Beam:
        """One of `count` equal parts: its piece of the taper, and the releases of the ends that it keeps.

        Parameters
        ----------
        index
            Which part, from 0.
        count
            Number of parts.

        Returns
        -------
        Beam
            Of one segment, its ends' sections those of the taper there.
        """
        kept = {0: index == 0, 1: index == count - 1}
        release = tuple(f"{ENDS[end]} {COMPONENTS[component]}" for end, component in self.releases if kept[end])
        if self.end is None:
            return replace(self, segments=1, release=release)
        section, end = (self.section.between(self.end, k / count) for k in (index, index + 1))
        return replace(self, section=section, end=end, segments=1, release=release)

    def check(self, chord: Array) -> None:
        """Whether the member can lie along a chord.

        Parameters
        ----------
        chord
            From the first node to the second, global, (..., 3).

        Raises
        ------
        FrameError
            If `up` is parallel to the member.
        """
        if self.up is not None:
            self.axes(chord)

    def axes(self, chord: Array) -> Array:
        """Local axes as rows x, y, z.

        Parameters
        ----------
        chord
            From the first node to the second, global, (..., 3).

        Returns
        -------
        ndarray
            Unit vectors in global components, (..., 3, 3).

        Raises
        ------
        FrameError
            If `up` is parallel to the member.
        """
        return default_axes(chord) if self.up is None else axes_towards(chord, self.up)

    def stiffness_matrix(self, length: Array | float) -> Array:
        """Stiffness in local axes, symmetric to the last bit, zero where components do not meet.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Forces and moments at both ends by their displacements and rotations, (..., 12, 12).

        Examples
        --------
        Two deflections and the rotations beside them, ``12 E I / L^3`` and ``6 E I / L^2`` (Przemieniecki 1968, Eq.
        5.116).

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
        """The stiffness as springs on deformations, ``K = sum_i k_i b_i b_i^T``.

        Parameters
        ----------
        length
            Length of the member, (...); deformations come in its precision.

        Returns
        -------
        tuple of ndarray
            Stiffnesses (..., 6) and deformations by the end displacements, (..., 6, 12), each at the batch shape
            that it varies over.
        """
        arm, length = np.asarray(length), as_real(length)
        shape = shape_of(arm.shape, self.sections_shape)
        planes = [self._plane(direction, length) for direction in DIRECTIONS]
        # With the sections they vary only where these move the elastic centre.
        varying = shape_of(arm.shape, *(plane.fraction for plane in planes))
        # Each number lies in one piece: that is how batches are read and written.
        stiffness = np.zeros((6, *shape))
        rows = np.zeros((6, 12, *varying), np.result_type(arm, np.float64))
        for i in BARS:
            stiffness[i], rows[i, i], rows[i, i + 6] = self._bar(i, length), -1.0, 1.0
        for direction, plane in zip(DIRECTIONS, planes, strict=True):
            v1, r1, v2, r2 = direction.dofs
            stiffness[direction.deflection], stiffness[direction.rotation] = plane.shear, plane.bend
            rows[direction.deflection, v1], rows[direction.deflection, v2] = 1.0, -1.0
            # the parts add up to the length in its precision, so that a rigid turn costs no energy
            before = plane.fraction * arm
            rows[direction.deflection, r1], rows[direction.deflection, r2] = (
                direction.sign * before,
                direction.sign * (arm - before),
            )
            rows[direction.rotation, r1], rows[direction.rotation, r2] = -direction.sign, direction.sign
        return stiffness.transpose(*range(1, stiffness.ndim), 0), rows.transpose(*range(2, rows.ndim), 0, 1)

    def end_forces(self, length: Array | float, displacement: Array) -> Array:
        """Force and moment on each end of the member, by way of its deformations.

        Differences of displacements come first, so that a large motion of the whole costs no digits.

        Parameters
        ----------
        length
            Length of the member, (...).
        displacement
            End displacements in local axes, (..., 12).

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` at the start and then at the end, (..., 12), in local axes.
        """
        length = as_real(length)
        u = np.moveaxis(np.asarray(displacement, dtype=np.float64), -1, 0)
        shape = np.broadcast_shapes(u.shape[1:], np.shape(length), self.sections_shape)
        forces = np.zeros((*shape, 12))
        for i in BARS:
            pull = self._bar(i, length) * (u[i + 6] - u[i])
            forces[..., i], forces[..., i + 6] = -pull, pull
        for direction in DIRECTIONS:
            v1, r1, v2, r2 = direction.dofs
            acting = plane_forces(
                self._plane(direction, length), u[v1], direction.sign * u[r1], u[v2], direction.sign * u[r2]
            )
            for dof, sign, force in zip(direction.dofs, direction.signs, acting, strict=True):
                forces[..., dof] = sign * force
        return forces

    def shape_functions(self, length: Array | float, x: Array | float) -> Array:
        """Displacement at a distance from the start for unit end displacements.

        Interdependent cubics for a prismatic beam (Friedman & Kosmatka, Comput. Struct. 47 (1993)
        473-481); for a taper the exact curves, by quadrature. Released ends follow the member.

        Parameters
        ----------
        length, x
            Length of the member and distance from its start, (...).

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` there by the twelve of the ends, in local axes, (..., 6, 12).
        """
        length, x = as_real(length), as_real(x)
        return self._shapes(length, x / length)[0]

    def shape_gradients(self, length: Array | float, x: Array | float) -> Array:
        """Derivative of `shape_functions` along the member.

        Parameters
        ----------
        length, x
            Length of the member and distance from its start, (...).

        Returns
        -------
        ndarray
            ``ux' .. rz'`` there by the twelve end displacements, (..., 6, 12), per length.
        """
        length, x = as_real(length), as_real(x)
        return self.shape_rows(length, x / length)[1]

    def shape_rows(self, length: Real, fraction: Real) -> tuple[Array, Array]:
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
            # the slope is the shear strain and the rotation together
            slopes[..., direction.deflection, :] += direction.sign * values[..., direction.rotation, :]
        return values, slopes

    def _shapes(self, length: Real, fraction: Real) -> tuple[Array, list[tuple[BendingPlane, Plane]]]:
        """`shape_functions` at a fraction of the length, (..., 6, 12), and the planes in which they bend."""
        shape = np.broadcast_shapes(np.shape(length), np.shape(fraction), self.sections_shape)
        values, part, planes = np.zeros((*shape, 6, 12)), self._part(fraction), []
        for i in BARS:
            # a bar with a released end moves as one, with its other end
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

    def mass_matrix(self, length: Array | float) -> Array:
        """Consistent mass with rotary inertia in local axes.

        The inertia in torsion is ``rho (Iy + Iz)`` per length (Przemieniecki, *Theory of Matrix Structural Analysis*,
        1968, ch. 11). Closed form for a prismatic beam, quadrature for a taper or with releases.

        Parameters
        ----------
        length
            Length of the member, (...).

        Returns
        -------
        ndarray
            Inertia of both ends, (..., 12, 12).

        Examples
        --------
        A motion along the beam moves its whole mass, 3 m of 80 kg/m.

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
        ch. 9). Closed form for a prismatic beam, quadrature (`quadrature`) for a taper or with releases.

        Parameters
        ----------
        length
            Length of the member, (...).
        axial
            Axial force, (...), tension positive.

        Returns
        -------
        ndarray
            By the end displacements, (..., 12, 12).

        Examples
        --------
        A force of 1 N turns a rigid bar of 2 m with 1/2 N/m.

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

    def section_flexibility(self, fraction: Array | float) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz``; the shear terms are 0 without shear.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            One over ``E A``, ``ky G A``, ``kz G A``, ``G J``, ``E Iy`` and ``E Iz`` there, (..., 6).
        """
        return self._stacked(fraction, self._flexibility(as_real(fraction)))

    def section_inertia(self, fraction: Array | float) -> Array:
        """Inertia per length that goes with each of ``ux .. rz``.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            ``rho A`` three times, ``rho (Iy + Iz)``, ``rho Iy``, ``rho Iz`` there, (..., 6).
        """
        return self._stacked(fraction, self._inertia(as_real(fraction)))

    def section_sway(self, fraction: Array | float) -> Array:
        """Weight of each of ``ux' .. rz'`` squared in twice the work of a unit axial force.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            0, 1, 1, ``(Iy + Iz) / A``, 0, 0 there, (..., 6).
        """
        section = self._section(as_real(fraction))
        return self._stacked(fraction, (0.0, 1.0, 1.0, (section.Iy + section.Iz) / section.A, 0.0, 0.0))

    def mass_per_length(self, fraction: Array | float) -> Array:
        """Density times area of the section.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Mass per length there, (...).
        """
        return self.section_inertia(fraction)[..., 0]

    def stress(self, fraction: Array | float, forces: Array) -> Array:
        """Extreme stresses over the section at a fraction of the length.

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
            If the section does not know what stress needs, see `Section`.
        """
        return self._section(as_real(fraction)).stress(forces)

    def _section(self, fraction: Real) -> CrossSection:
        return self.section if self.end is None else self.section.between(self.end, fraction)

    def _flexibility(self, fraction: Real) -> Six:
        section, E, G = self._section(fraction), self.material.E, self.material.G
        shear: tuple[Real, Real] = (0.0, 0.0)
        if self.shear:
            shear = 1.0 / (section.ky * G * section.A), 1.0 / (section.kz * G * section.A)
        return (1.0 / (E * section.A), *shear, 1.0 / (G * section.J), 1.0 / (E * section.Iy), 1.0 / (E * section.Iz))

    def _inertia(self, fraction: Real) -> Six:
        section, density = self._section(fraction), self.material.density
        along, about_y, about_z = density * section.A, density * section.Iy, density * section.Iz
        return along, along, along, about_y + about_z, about_y, about_z

    def _stacked(self, fraction: Array | float, six: Six) -> Array:
        """Six numbers as a trailing axis."""
        shape = np.broadcast_shapes(np.shape(fraction), self.sections_shape)
        return np.stack([np.broadcast_to(part, shape) for part in six], axis=-1)

    def _part(self, fraction: Real) -> Part:
        """Integrals of the flexibility from the start to a fraction of the length."""
        if self.end is None:
            return UniformPart(fraction, self._flexibility(fraction))
        ndim = max(np.ndim(fraction), len(self.sections_shape))
        return tapered_part(self.section, self.end, self._flexibility, fraction, ndim)

    @cached_property
    def _whole(self) -> Part:
        return self._part(1.0)

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
        centre = self._whole.centre(direction.bending)
        bends = self._whole.bends(direction.bending, direction.shearing, centre, length)
        return bending_plane(centre, length, bends, self._released(direction))

    def _released(self, direction: BendingPlane) -> frozenset[int]:
        if not self.releases:
            return _NOTHING
        dofs = (end * 6 + component for end, component in self.releases)
        return frozenset(direction.dofs.index(dof) for dof in dofs if dof in direction.dofs)


def _check_parts(beam: Beam) -> None:
    if not isinstance(beam.shear, bool | np.bool_):
        raise FrameError(f"Beam: shear = {beam.shear!r} must be True (Timoshenko) or False (Euler-Bernoulli)")
    for name, value, kind in (("section", beam.section, CrossSection), ("material", beam.material, Material)):
        if not isinstance(value, kind):
            raise FrameError(f"Beam: {name} is a {type(value).__name__}; give a {kind.__name__}")
    if beam.shear:
        for section in (beam.section, beam.end):
            if isinstance(section, Section):
                section.require("a beam with shear deformation", "ky", "kz")
    if beam.end is not None and type(beam.end) is not type(beam.section):
        text = f"{type(beam.end).__name__} and section a {type(beam.section).__name__}"
        raise FrameError(f"Beam: end is a {text}; give two of one type")
    if not isinstance(beam.segments, (int, np.integer)) or beam.segments < 1:
        raise FrameError(f"Beam: segments = {beam.segments!r} must be a whole number above zero")
