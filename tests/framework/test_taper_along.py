"""A taper under its own weight: points of a rule are evaluated together, and bend it as equilibrium wants."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.shape_rules import gauss_legendre
from skfem import LinearForm

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
LENGTH, THICK, THIN, WIDTH, GRAVITY = 0.5, 0.02, 0.01, 0.01, 9.81


def cantilever() -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    beam = Beam(Rectangle(y=THICK, z=WIDTH), STEEL, end=Rectangle(y=THIN, z=WIDTH))
    frame.add("AB", beam, "A", "B")
    frame.fix("A")
    frame.gravity((0.0, -GRAVITY, 0.0))
    return frame


def by_quadrature(at: float) -> float:
    """Deflection of the clamped taper at a distance, by Euler and Bernoulli with Mohr's integral, on a fine grid."""
    x = np.linspace(0.0, at, 20001)
    height = THICK + (THIN - THICK) * x / LENGTH
    rest, slope = LENGTH - x, (THIN - THICK) / LENGTH
    # moment of the weight beyond x: its height there is linear in the distance from x
    moment = -STEEL.density * GRAVITY * WIDTH * (height * rest**2 / 2.0 + slope * rest**3 / 3.0)
    return float(np.trapezoid(moment / (STEEL.E * WIDTH * height**3 / 12.0) * (at - x), x))


def test_deflection_of_a_taper_under_its_weight() -> None:
    stations = np.array([0.1, 0.25, 0.5])
    found = cantilever().solve().displacement_along("AB", stations)[:, 1]
    np.testing.assert_allclose(found, [by_quadrature(at) for at in stations], rtol=1e-7)


def test_masses_of_many_points_are_found_together(monkeypatch: pytest.MonkeyPatch) -> None:
    calls: list[Any] = []
    inertia = Beam.section_inertia

    def counted(beam: Beam, fraction: Any) -> Any:
        calls.append(fraction)
        return inertia(beam, fraction)

    monkeypatch.setattr(Beam, "section_inertia", counted)
    cantilever().solve().displacement_along("AB", np.linspace(0.0, LENGTH, 11))
    assert 0 < len(calls) < 20


@pytest.mark.parametrize("thin", [1e-3, [1e-3, 0.5]])
def test_rotation_along_a_taper_to_a_thousandth(thin: float | list[float]) -> None:
    """Towards its thin end the flexibility grows by 10^12, in another entry hardly at all."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    thinnest = THICK * np.asarray(thin)
    frame.add("AB", Beam(Circle(diameter=THICK), STEEL, end=Circle(diameter=thinnest)), "A", "B")
    frame.fix("A")
    frame.line_load("AB", fy=-5.0, span=(0.1, 0.4))
    stations = np.array([0.2, 0.45, 0.499])
    found = frame.solve().displacement_along("AB", stations)[..., 5].reshape(-1, 3)
    points, weights = np.polynomial.legendre.leggauss(64)
    for ratio, row in zip(np.ravel(thinnest / THICK), found, strict=True):
        for at, rotation in zip(stations, row, strict=True):
            breaks = np.minimum([0.0, 0.1, 0.4], at)
            turned = 0.0
            for begin, end in pairwise(breaks.tolist()):
                s = begin + (end - begin) * (points + 1.0) / 2.0
                beyond, lever = 0.4 - np.maximum(s, 0.1), (0.4 + np.maximum(s, 0.1)) / 2.0 - s
                moment = -5.0 * beyond * lever
                size = THICK * (1.0 + (ratio - 1.0) * s / LENGTH)
                turned += (end - begin) / 2.0 * np.sum(weights * moment / (STEEL.E * np.pi / 64.0 * size**4))
            np.testing.assert_allclose(rotation, turned, rtol=1e-5)


def test_a_line_load_on_a_taper_to_a_thousandth_is_within_the_bound() -> None:
    """The end's rotation, integrated by the logarithm of the diameter, in which it is smooth."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    frame.add("AB", Beam(Circle(diameter=THICK), STEEL, end=Circle(diameter=1e-3 * THICK)), "A", "B")
    frame.fix("A")
    frame.line_load("AB", fy=-5.0)
    solution = frame.solve()
    points, weights = np.polynomial.legendre.leggauss(64)
    size, growth = np.exp(np.log(1e-3) * (points + 1.0) / 2.0), np.log(1e3)
    rest = LENGTH * (size - 1e-3) / 0.999
    bent = -5.0 * rest**2 / 2.0 / (STEEL.E * np.pi / 64.0 * (THICK * size) ** 4)
    exact = np.sum(weights / 2.0 * bent * size * growth * LENGTH / 0.999)
    bound = solution.error_bound("B")[5]
    assert abs(solution.displacement("B")[5] - exact) <= bound + 1e-12 * abs(exact)


@pytest.mark.parametrize("count", [300, 301, 1000])
def test_rules_of_many_points_are_exact(count: int) -> None:
    nodes, weights = gauss_legendre(count)
    np.testing.assert_allclose(weights @ np.exp(nodes), np.e - 1.0 / np.e, rtol=1e-12)
    np.testing.assert_allclose(weights @ nodes ** (2 * count - 2), 2.0 / (2 * count - 1), rtol=1e-9)


def slopes(thin: float, begin: float, end: float, upto: float) -> list[float]:
    """Deflection and rotation at a place of a cantilever that tapers, under 5 N/m between two others.

    ``int M (x - s) / EI ds`` by the logarithm of the diameter.
    """
    with mp.workdps(30):
        first, length, upto = mp.mpf(THICK), mp.mpf(LENGTH), mp.mpf(upto)
        begin, end = mp.mpf(begin), mp.mpf(end)
        slope = (mp.mpf(thin * THICK) - first) / length
        logarithms = [mp.log(first + slope * min(place, upto)) for place in (0, begin, end, length)]

        def curved(log: Any) -> tuple[Any, Any]:
            size = mp.exp(log)
            s = (size - first) / slope
            beyond = end - max(s, begin) if s < end else mp.mpf(0)
            moment = -5 * beyond * ((end + max(s, begin)) / 2 - s)
            return s, moment / (STEEL.E * mp.pi / 64 * size**4) * size / slope

        marks = sorted(set(logarithms), reverse=True)
        turned = mp.quad(lambda log: curved(log)[1], marks)
        moved = mp.quad(lambda log: (upto - curved(log)[0]) * curved(log)[1], marks)
        return [float(moved), float(turned)]


def steep(thin: float, **given: Any) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    frame.add("AB", Beam(Circle(diameter=THICK), STEEL, end=Circle(diameter=thin * THICK), **given), "A", "B")
    frame.fix("A")
    return frame


@LinearForm
def nothing(v: Any, w: Any) -> Any:
    return w.force * v.grad[0]


@pytest.mark.parametrize(
    ("thin", "span", "segments", "form"),
    [
        (1e-3, None, 1, False),
        (1e-5, None, 1, False),
        (1e-3, (0.1, 0.4), 1, False),
        (1e-5, (0.1, 0.4), 1, False),
        (1e-5, None, 2, False),
        (1e-5, None, 1, True),
    ],
)
def test_a_line_load_on_a_steep_taper_to_rounding(
    thin: float, span: tuple[float, float] | None, segments: int, form: bool
) -> None:
    """Deflection and rotation of its thin end; of a taper in pieces, and of one with a form added, too."""
    frame = steep(thin, segments=segments)
    if form:
        frame.add_form(nothing, on="AB", force=0.0)
    frame.line_load("AB", fy=-5.0, span=span)
    found = frame.solve().displacement("B")[[1, 5]]
    exact = slopes(thin, *(span or (0.0, LENGTH)), LENGTH)
    np.testing.assert_allclose(found, exact, rtol=1e-12 if thin == 1e-3 else 1e-10)


@pytest.mark.parametrize("segments", [1, 2])
def test_along_a_steep_taper_to_rounding(segments: int) -> None:
    frame = steep(1e-5, segments=segments)
    frame.line_load("AB", fy=-5.0)
    places = [0.3, 0.45, 0.49]
    found = frame.solve().displacement_along("AB", places)[:, [1, 5]]
    exact = [slopes(1e-5, 0.0, LENGTH, place) for place in places]
    np.testing.assert_allclose(found, exact, rtol=1e-9)


def test_a_member_that_comes_to_a_point_asks_for_no_rule_without_end() -> None:
    ends = np.zeros(1), np.ones(1)
    rules = [Beam(Circle(THICK), STEEL, end=Circle(thin * THICK)).rule_between(*ends) for thin in (0.5, 1e-6, 1e-12)]
    assert all(len(points) < 100 for points, _ in rules)
    np.testing.assert_allclose([weights.sum() for _, weights in rules], 1.0, rtol=1e-13)
    beyond = Beam(Circle(THICK), STEEL, end=Circle(1e-16 * THICK)).rule_between(ends[0], ends[1] + 1e-15)
    np.testing.assert_allclose(beyond[1].sum(), 1.0, rtol=1e-12)
