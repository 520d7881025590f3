"""Tapered beams: one element against integrals in 20 digits, at mild and at extreme ratios."""

from __future__ import annotations

from functools import cache
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, CrossSection, ISection, Material, Rectangle, Section, Tube
from numpy.testing import assert_allclose

E, G, L = 70e9, 26e9, 1.7
ALLOY = Material(E=E, G=G, density=2700.0)


def rectangle(y: Any, z: Any) -> dict[str, Any]:
    # beyond n = 31 the hyperbolic tangent of sides not below 2/3 of one another is 1 to 28 digits
    odd = range(1, 32, 2)
    series = mp.mpf(31) / 32 * mp.zeta(5) - mp.fsum((1 - mp.tanh(n * mp.pi * z / (2 * y))) / n**5 for n in odd)
    J = z * y**3 / 3 * (1 - 192 / mp.pi**5 * y / z * series)
    return {"A": y * z, "Iy": y * z**3 / 12, "Iz": z * y**3 / 12, "J": J, "k": mp.mpf(5) / 6}


def circle(d: Any) -> dict[str, Any]:
    inertia = mp.pi * d**4 / 64
    return {"A": mp.pi * d**2 / 4, "Iy": inertia, "Iz": inertia, "J": 2 * inertia, "k": mp.mpf(6) / 7}


def tip_flexibility(properties: Any, start: list[float], end: list[float]) -> np.ndarray:
    """Flexibility of the tip of a cantilever, (6, 6), by Mohr's integrals of the sizes' linear course."""

    @cache  # all integrals take the same points
    def at(x: Any) -> dict[str, Any]:
        return properties(
            *[mp.mpf(a) + (mp.mpf(b) - mp.mpf(a)) * x / mp.mpf(L) for a, b in zip(start, end, strict=True)]
        )

    def integral(function: Any) -> float:
        return float(mp.quad(function, [mp.mpf(L) * i / 4 for i in range(5)]))

    F = np.zeros((6, 6))
    F[0, 0] = integral(lambda x: 1 / (E * at(x)["A"]))
    F[3, 3] = integral(lambda x: 1 / (G * at(x)["J"]))
    sway = integral(lambda x: 1 / (at(x)["k"] * G * at(x)["A"]))
    for moved, turned, sign, name in ((1, 5, 1, "Iz"), (2, 4, -1, "Iy")):
        F[moved, moved] = integral(lambda x, n=name: (mp.mpf(L) - x) ** 2 / (E * at(x)[n])) + sway
        F[turned, turned] = integral(lambda x, n=name: 1 / (E * at(x)[n]))
        F[moved, turned] = F[turned, moved] = sign * integral(lambda x, n=name: (mp.mpf(L) - x) / (E * at(x)[n]))
    return F


@pytest.mark.parametrize(
    ("section", "end", "properties"),
    [
        (Rectangle(y=0.05, z=0.15), Rectangle(y=0.04, z=0.06), rectangle),
        (Rectangle(y=0.05, z=0.15), Rectangle(y=0.03, z=0.45), rectangle),
        (Circle(diameter=0.1), Circle(diameter=0.05), circle),
        (Circle(diameter=0.01), Circle(diameter=0.5), circle),
    ],
)
def test_tip_of_a_tapered_cantilever(section: CrossSection, end: CrossSection, properties: Any) -> None:
    """One element, both ways round, to rounding even at the ratio 50."""
    for start, stop in ((section, end), (end, section)):
        with mp.workdps(20):
            F = tip_flexibility(
                properties, [float(s) for s in start.sizes().values()], [float(s) for s in stop.sizes().values()]
            )
        K = Beam(start, ALLOY, end=stop, shear=True).stiffness_matrix(L)[6:, 6:]
        size = np.sqrt(np.diag(F))
        assert_allclose(np.linalg.inv(K * np.outer(size, size)), F / np.outer(size, size), atol=2e-12)


@pytest.mark.parametrize("thin", [0.09, 0.05, 1e-3])
def test_cone_in_closed_form(thin: float) -> None:
    """Clamped at d0: 4 F L / (pi E d0 d1) (Gere & Goodno, Mechanics of Materials, 7th ed., example 2-4), and
    64 F L^3 / (3 pi E d0^3 d1).

    That is 64 / (pi E) int s^2 / d^4 ds with s from the tip, of which ((d - d1) / d)^3 / (3 d1) is the integral.
    """
    thick = 0.1
    K = Beam(Circle(diameter=thick), ALLOY, end=Circle(diameter=thin), release=("end rz",)).stiffness_matrix(L)
    assert K[6, 6] == pytest.approx(np.pi * E * thick * thin / (4 * L), rel=1e-13)
    assert K[7, 7] == pytest.approx(3 * np.pi * E * thick**3 * thin / (64 * L**3), rel=1e-13)


@pytest.mark.parametrize(
    ("section", "end"),
    [
        (Tube(outer=0.1, thickness=0.01), Tube(outer=0.05, thickness=0.004)),
        (
            ISection(height=0.3, width=0.15, web=0.007, flange=0.011),
            ISection(height=0.5, width=0.2, web=0.01, flange=0.016),
        ),
        (
            Section(A=1e-2, Iy=2e-5, Iz=1e-5, J=1e-5, ky=0.8, kz=0.5),
            Section(A=2e-2, Iy=9e-5, Iz=3e-5, J=3e-5, ky=0.6, kz=0.5),
        ),
    ],
)
def test_flexibility_of_other_shapes(section: CrossSection, end: CrossSection) -> None:
    """Their own properties under mpmath's quadrature."""
    beam = Beam(section, ALLOY, end=end, shear=True)

    def mohr(component: int, power: int) -> float:
        def strain(s: Any) -> Any:
            return s**power * mp.mpf(float(beam.section_flexibility(1.0 - float(s) / L)[component]))

        return float(mp.quad(strain, [0, L / 4, L / 2, 3 * L / 4, L]))

    F = np.linalg.inv(beam.stiffness_matrix(L)[6:, 6:])
    expected = [mohr(0, 0), mohr(5, 2) + mohr(1, 0), mohr(4, 2) + mohr(2, 0), mohr(3, 0), mohr(4, 0), mohr(5, 0)]
    assert_allclose(np.diag(F), expected, rtol=1e-11)


def test_a_taper_to_the_same_section_is_none() -> None:
    bar = Rectangle(y=0.1, z=0.06)
    for shear in (False, True):
        taper, straight = Beam(bar, ALLOY, end=Rectangle(y=0.1, z=0.06), shear=shear), Beam(bar, ALLOY, shear=shear)
        for mine, closed in (
            (taper.stiffness_matrix(L), straight.stiffness_matrix(L)),
            (taper.mass_matrix(L), straight.mass_matrix(L)),
            (taper.geometric_matrix(L, -3.0), straight.geometric_matrix(L, -3.0)),
            (taper.shape_functions(L, 0.4 * L), straight.shape_functions(L, 0.4 * L)),
        ):
            assert_allclose(mine, closed, rtol=1e-13, atol=1e-14 * np.abs(closed).max())


@pytest.mark.parametrize("ratio", [0.5, 8.0, 30.0])
def test_mass_of_a_taper(ratio: float) -> None:
    """Moved as a whole it weighs as the frustum of a cone, rho pi L (d0^2 + d0 d1 + d1^2) / 12, with its moments."""
    d0, d1 = 0.05, 0.05 * ratio
    M = Beam(Circle(diameter=d0), ALLOY, end=Circle(diameter=d1)).mass_matrix(L)
    rigid = np.tile(np.eye(6), (2, 1))
    rigid[8, 4], rigid[7, 5] = -L, L
    inertia = rigid.T @ M @ rigid
    x, w = np.polynomial.legendre.leggauss(6)
    x, w = (x + 1) / 2 * L, w / 2 * L * 2700.0
    area, second = np.pi / 4 * (d0 + (d1 - d0) * x / L) ** 2, np.pi / 64 * (d0 + (d1 - d0) * x / L) ** 4
    expected = np.diag([w @ area] * 3 + [w @ (2 * second)] + [w @ (second + x**2 * area)] * 2)
    expected[1, 5] = expected[5, 1] = w @ (x * area)
    expected[2, 4] = expected[4, 2] = -expected[1, 5]
    assert inertia[0, 0] == pytest.approx(2700.0 * np.pi * L * (d0**2 + d0 * d1 + d1**2) / 12, rel=1e-13)
    assert_allclose(inertia, expected, rtol=1e-12, atol=1e-13 * expected.max())


def test_part_of_a_taper() -> None:
    beam = Beam(Rectangle(y=0.1, z=0.06), ALLOY, end=Rectangle(y=0.05, z=0.09), segments=3)
    sizes = [(beam.part(i, 3).section.sizes(), beam.part(i, 3).end.sizes()) for i in range(3)]  # type: ignore[union-attr]
    assert sizes[0][0] == beam.section.sizes()
    assert sizes[2][1] == beam.end.sizes()  # type: ignore[union-attr]
    assert all(sizes[i][1] == sizes[i + 1][0] for i in range(2))
    assert sizes[0][1]["y"] == pytest.approx(0.1 - 0.05 / 3)
    x = np.linspace(0.0, 1.0, 4)
    np.testing.assert_allclose(beam.part(1, 3).mass_per_length(x), beam.mass_per_length((1 + x) / 3), rtol=1e-14)
    forces = np.array([1e3, 2e2, 3e2, 40.0, 50.0, 60.0])
    np.testing.assert_allclose(beam.part(1, 3).stress(x, forces), beam.stress((1 + x) / 3, forces), rtol=1e-13)


def test_one_modulus_for_each_of_as_many_beams_as_there_are_points() -> None:
    """A batch of the length of a quadrature rule must not meet the axis of its points."""
    section, end = Rectangle(y=0.1, z=0.06), Rectangle(y=0.05, z=0.09)
    for count in (24, 12, 48):
        moduli = np.linspace(1.0, 2.0, count)
        batch = Beam(section, Material(E=moduli, nu=0.3, density=moduli), end=end, shear=True)
        one = Beam(section, Material(E=1.0, nu=0.3, density=1.0), end=end, shear=True)
        assert_allclose(batch.stiffness_matrix(L), moduli[:, None, None] * one.stiffness_matrix(L), rtol=1e-12)
        assert_allclose(batch.mass_matrix(L), moduli[:, None, None] * one.mass_matrix(L), rtol=1e-12)
        assert_allclose(batch.geometric_matrix(L, 1.0), [one.geometric_matrix(L, 1.0)] * count, rtol=1e-10, atol=1e-14)


@pytest.mark.parametrize("ratio", [3.0, 30.0, 1e3, 1e5])
def test_sizes_that_grow_and_shrink_together(ratio: float) -> None:
    """Elongation and twist per unit length are log(r) / (r - 1) of those of the weaker end; here these are opposite
    ends, and bending about y does not vary."""
    thick = Beam(
        Section(A=1.0, Iy=1.0, Iz=1.0, J=ratio), ALLOY, end=Section(A=ratio, Iy=1.0, Iz=ratio, J=1.0)
    ).stiffness_matrix(L)
    mean = np.log(ratio) / (ratio - 1.0)
    assert_allclose([E / (L * thick[6, 6]), G / (L * thick[9, 9])], mean, rtol=2e-13)
    assert_allclose(thick[8, 8], 12.0 * E / L**3, rtol=2e-13)


@pytest.mark.parametrize("ratio", [30.0, 1e3])
def test_a_rectangle_of_one_growing_side(ratio: float) -> None:
    """Tip of a cantilever under a force along the constant side, Iy ~ x, and along the growing one, Iz ~ x^3."""
    beam = Beam(Rectangle(y=1.0, z=1.0), ALLOY, end=Rectangle(y=ratio, z=1.0))
    with mp.workdps(30):
        # Inverted in many digits: double precision would lose four of them, more or fewer by the processor's kernels.
        F = np.array((mp.matrix(beam.stiffness_matrix(L)[6:, 6:].tolist()) ** -1).tolist(), dtype=float)
        at = [mp.mpf(2) ** -k for k in range(14, -1, -1)]

        def tip(power: int) -> float:
            grown = mp.mpf(ratio) - 1
            return float(
                mp.mpf(L) ** 3 * mp.quad(lambda x: 12 * (1 - x) ** 2 / (E * (1 + grown * x) ** power), [0, *at])
            )

        assert_allclose([F[2, 2], F[1, 1]], [tip(1), tip(3)], rtol=1e-11)


@pytest.mark.parametrize("thin", ["start", "end"])
@pytest.mark.parametrize("ratio", [1e3, 1e5, 1e6])
def test_a_hinge_at_the_thin_end_of_a_steep_cone(ratio: float, thin: str) -> None:
    """A hinge where the cone all but ends: ``1 / k`` is the integral of ``x^2 / E I`` from there on."""
    sizes = (1.0, ratio) if thin == "start" else (ratio, 1.0)
    beam = Beam(Circle(diameter=sizes[0]), ALLOY, end=Circle(diameter=sizes[1]), release=(f"{thin} rz",))
    with mp.workdps(40):
        grown = mp.mpf(ratio) - 1

        def flexibility(y: mp.mpf) -> mp.mpf:
            """Over the logarithm of the diameter."""
            d = mp.exp(y)
            return ((d - 1) / grown) ** 2 * 64 / (mp.pi * E * d**4) * d / grown

        marks = [mp.log(ratio) * k / 8 for k in range(9)]
        wanted = float(1 / (mp.mpf(L) ** 3 * mp.quad(flexibility, marks, method="gauss-legendre")))
    assert_allclose(beam.stiffness_matrix(L)[1, 1], wanted, rtol=1e-14)


@pytest.mark.parametrize("release", [("start rz",), ("end rz",), ("start uy",), ("end uy",)])
@pytest.mark.parametrize("shear", [False, True])
def test_a_steep_cone_is_as_stiff_from_either_end(release: tuple[str, ...], shear: bool) -> None:
    """Turned end for end, which turns x and y round."""
    other = {"start": "end", "end": "start"}
    turned = tuple(f"{other[end]} {name}" for end, name in (text.split() for text in release))
    thin, thick = Circle(diameter=1.0), Circle(diameter=1e5)
    ahead = Beam(thin, ALLOY, end=thick, release=release, shear=shear).stiffness_matrix(L)
    back = Beam(thick, ALLOY, end=thin, release=turned, shear=shear).stiffness_matrix(L)
    swap, signs = np.roll(np.arange(12), 6), np.tile([-1.0, -1.0, 1.0, -1.0, -1.0, 1.0], 2)
    assert_allclose(back[np.ix_(swap, swap)] * np.outer(signs, signs), ahead, rtol=2e-13)
