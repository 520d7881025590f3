"""Parameters of a beam, and its section law: flexibility, inertia and stress at any point of its length."""

from __future__ import annotations

from collections.abc import Hashable, Iterable
from dataclasses import KW_ONLY, dataclass, field, replace
from typing import Self

import numpy as np

from ..framework.batch import numbers
from ..framework.errors import FrameError
from ..framework.lazily import cached_property
from ..framework.orientation import axes_towards, default_axes, default_axis_numbers
from ..framework.protocol import Array, LineElement, SpringFormulas, is_proven
from .cross_section import CrossSection
from .flexibility import POINTS, Six, spread_points
from .material import Material
from .parameters import Real, as_real, common_shape, given_state, require, shape_of
from .prismatic import prismatic_deformations, stiffness_of
from .releases import COMPONENTS, ENDS, parse_releases
from .section import Section

# Stiffness of a section that is taken: beyond, matrices and their inverses over- or underflow, and a beam that is there
# counts as missing.
LEAST, MOST = 1e-300, 1e300


@dataclass(frozen=True, eq=False)
class BeamSectionLaw(LineElement):
    """A prismatic or tapered member with a section and a material; `linkframe.elements.Beam` lists its parameters."""

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
            up = numbers(self.up, "Beam: up")
            if up.shape[-1:] != (3,):
                raise FrameError(f"Beam: up has shape {up.shape}; give three numbers, (..., 3)")
            require("Beam", "up", up, np.any(up != 0.0, axis=-1, keepdims=True) & np.isfinite(up), "a direction")
            object.__setattr__(self, "up", up)
        release = (self.release,) if isinstance(self.release, str) else tuple(self.release)
        object.__setattr__(self, "release", release)
        object.__setattr__(self, "releases", parse_releases(release))
        if self.section.shape or self.end is not None or self.up is not None:
            shapes = {"section": self.section.shape, "material": self.material.shape}
            shapes["end"] = () if self.end is None else self.end.shape
            shapes["up"] = () if self.up is None else self.up.shape[:-1]
            common_shape("Beam", shapes)
        _check_stiffness(self)

    def __getstate__(self) -> dict[str, object]:
        return given_state(self)

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of section, material, end and up."""
        return self.sections_shape if self.up is None else shape_of(self.sections_shape, self.up.shape[:-1])

    @cached_property
    def sections_shape(self) -> tuple[int, ...]:
        """Batch shape of the stiffness per length: the broadcast of section, material and end."""
        return shape_of(self.section.shape, self.material.shape, () if self.end is None else self.end.shape)

    @property
    def kind(self) -> Hashable:
        """Key that is equal for beams with the same section, material, end, up, shear and releases."""
        up = None if self.up is None else (self.up.shape, self.up.tobytes())
        return self.section, self.material, self.end, up, self.shear, self.releases

    @property
    def exact(self) -> bool:
        """True: the shape functions solve the beam's differential equation, so one segment is exact in statics."""
        return True

    @property
    def balanced(self) -> bool:
        """True: a rigid motion does not deform the beam."""
        return True

    @property
    def elementwise(self) -> bool:
        """True for a prismatic beam: the integrals of a tapered one are sums whose last bit depends on the batch."""
        return self.end is None

    @property
    def roundings(self) -> float:
        """Bound on the rounding error of `springs` in units of 2^-53.

        The largest error seen in 400 random members was 6 units for prismatic and 28 for tapered ones.
        """
        return 12.0 if self.end is None else 100.0

    @property
    def quadrature(self) -> int:
        """Largest number of quadrature points, see `rule_between`."""
        return 3 if self.end is None else 2 * POINTS

    @property
    def integration_points(self) -> tuple[Array, Array]:
        """Points as fractions of the length, and weights, (points, ...), which suit the flexibility of a taper."""
        return super().integration_points if self.end is None else spread_points(self.section, self.end)

    def rule_between(self, lower: Array, upper: Array) -> tuple[Array, Array]:
        if self.end is None:
            return super().rule_between(lower, upper)
        first, last = (self.section.between(self.end, np.clip(place, 0.0, 1.0)) for place in (lower, upper))
        return spread_points(first, last)

    @cached_property
    def formulas(self) -> SpringFormulas | None:
        """Those of a prismatic beam without `up`, shear deformation and releases."""
        if not is_proven(self) or self.end is not None or self.up is not None or self.shear or self.releases:
            return None
        section, shape = self.section, self.shape
        moduli, sizes = (self.material.E, self.material.G), (section.A, section.Iy, section.Iz, section.J)
        # each stiffness is a product of one of both
        if all(np.shape(each) == shape for each in moduli) or all(np.shape(each) == shape for each in sizes):
            return SpringFormulas((*moduli, *sizes), stiffness_of, prismatic_deformations)
        return None

    def part(self, index: int, count: int) -> Self:
        """Part `index` of `count` equal parts, with its piece of the taper and the releases at ends of the whole beam.

        Parameters
        ----------
        index
            Which part, from 0.
        count
            Number of parts.

        Returns
        -------
        Beam
            Beam of one segment, with the sections that the taper has at its ends.
        """
        kept = {0: index == 0, 1: index == count - 1}
        release = tuple(f"{ENDS[end]} {COMPONENTS[component]}" for end, component in self.releases if kept[end])
        if self.end is None:
            return replace(self, segments=1, release=release)
        section, end = (self.section.between(self.end, k / count) for k in (index, index + 1))
        return replace(self, section=section, end=end, segments=1, release=release)

    def unreleased(self) -> Self:
        return replace(self, release=())

    def check(self, chord: Array) -> None:
        if self.up is not None:
            self.axes(chord)

    def axes(self, chord: Array) -> Array:
        return default_axes(chord) if self.up is None else axes_towards(chord, self.up)

    def axis_numbers(self, chord: Array) -> list[Real]:
        """The components of `axes` one by one, see `LineElement.axis_numbers`."""
        return default_axis_numbers(chord) if self.up is None else super().axis_numbers(chord)

    # -- at a point of the length -----------------------------------------------------------------------------------

    def section_flexibility(self, fraction: Array | float) -> Array:
        """Strain and curvature per unit ``N Vy Vz T My Mz``; the shear terms are 0 without shear.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            Inverses of ``E A``, ``ky G A``, ``kz G A``, ``G J``, ``E Iy`` and ``E Iz`` at that fraction, (..., 6).
        """
        return self._stacked(fraction, self._flexibility(as_real(fraction)))

    def section_inertia(self, fraction: Array | float) -> Array:
        """Inertia per length in each of ``ux .. rz``.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            ``rho A`` three times, ``rho (Iy + Iz)``, ``rho Iy``, ``rho Iz`` at that fraction, (..., 6).
        """
        return self._stacked(fraction, self._inertia(as_real(fraction)))

    def section_sway(self, fraction: Array | float) -> Array:
        """The factors w in the work ``N / 2 int sum_i w_i u_i'^2 dx`` of an axial force, with u' of ``ux' .. rz'``.

        Parameters
        ----------
        fraction
            Distance from the start over the length, 0 to 1, (...).

        Returns
        -------
        ndarray
            0, 1, 1, ``(Iy + Iz) / A``, 0, 0 at that fraction, (..., 6).
        """
        section = self._section(as_real(fraction))
        return self._stacked(fraction, (0.0, 1.0, 1.0, (section.Iy + section.Iz) / section.A, 0.0, 0.0))

    def mass_per_length(self, fraction: Array | float) -> Array:
        return self.section_inertia(fraction)[..., 0]

    def stress(self, fraction: Array | float, forces: Array) -> Array:
        return self._section(as_real(fraction)).stress(forces)

    def _section(self, fraction: Real, rest: Real | None = None) -> CrossSection:
        return self.section if self.end is None else self.section.between(self.end, fraction, rest)

    def _flexibility(self, fraction: Real, rest: Real | None = None) -> Six:
        section, E, G = self._section(fraction, rest), self.material.E, self.material.G
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


def _check_parts(beam: BeamSectionLaw) -> None:
    if not isinstance(beam.shear, (bool, np.bool_)):
        raise FrameError(f"Beam: shear = {beam.shear!r} must be True (Timoshenko) or False (Euler-Bernoulli)")
    if not isinstance(beam.section, CrossSection):
        raise FrameError(f"Beam: section is a {type(beam.section).__name__}; give a CrossSection")
    if not isinstance(beam.material, Material):
        raise FrameError(f"Beam: material is a {type(beam.material).__name__}; give a Material")
    if beam.shear:
        for section in (beam.section, beam.end):
            if isinstance(section, Section):
                section.require("a beam with shear deformation", "ky", "kz")
    if beam.end is not None and type(beam.end) is not type(beam.section):
        text = f"{type(beam.end).__name__} and section a {type(beam.section).__name__}"
        raise FrameError(f"Beam: end is a {text}; give two of one type")
    if not isinstance(beam.segments, (int, np.integer)) or beam.segments < 1:
        raise FrameError(f"Beam: segments = {beam.segments!r} must be a whole number above zero")


def _check_stiffness(beam: BeamSectionLaw) -> None:
    """Refuse stiffness beyond the range of floats; that of torsion, of which a section may be analysed, follows it."""
    softest, stiffest = beam.material._range
    for section in (beam.section,) if beam.end is None else (beam.section, beam.end):
        for name in ("A", "Iy", "Iz"):
            size = getattr(section, name)
            if type(size) is float and softest * size >= LEAST and stiffest * size <= MOST:
                continue
            with np.errstate(over="ignore", under="ignore"):
                found = np.asarray(beam.material.E * size)
            text = f"{LEAST:g} to {MOST:g}, the range in which floats keep their digits; take other units"
            require("Beam", f"E {name}", found, (found >= LEAST) & (found <= MOST), text)
