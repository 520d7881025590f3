"""Sections: areas and second moments by polygons and catalogues, shear coefficients by strain energy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Circle, CrossSection, ISection, Rectangle, Section, Tube
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose
from scipy.integrate import quad

SIZE = st.floats(1e-3, 1e3)


def polygon(points: list[tuple[float, float]]) -> tuple[float, float, float]:
    """A, Iy and Iz of a polygon (y, z), by Green's theorem on its sides."""
    y, z = np.array([*points, points[0]]).T
    cross = y[:-1] * z[1:] - y[1:] * z[:-1]
    return (
        float(cross.sum() / 2),
        float((cross * (z[:-1] ** 2 + z[:-1] * z[1:] + z[1:] ** 2)).sum() / 12),
        float((cross * (y[:-1] ** 2 + y[:-1] * y[1:] + y[1:] ** 2)).sum() / 12),
    )


@given(y=SIZE, z=SIZE)
def test_rectangle_is_a_polygon(y: float, z: float) -> None:
    section = Rectangle(y=y, z=z)
    corners = [(-y / 2, -z / 2), (y / 2, -z / 2), (y / 2, z / 2), (-y / 2, z / 2)]
    assert_allclose((section.A, section.Iy, section.Iz), polygon(corners), rtol=1e-13)


@given(h=SIZE, slender=st.floats(0.1, 3.0), web=st.floats(0.02, 0.4), flange=st.floats(0.02, 0.45))
def test_i_section_is_a_polygon(h: float, slender: float, web: float, flange: float) -> None:
    b = slender * h
    tf = flange * min(h, b)
    tw = web * min(b, 4 * tf)
    section = ISection(height=h, width=b, web=tw, flange=tf)
    right = [
        (b / 2, -h / 2),
        (b / 2, tf - h / 2),
        (tw / 2, tf - h / 2),
        (tw / 2, h / 2 - tf),
        (b / 2, h / 2 - tf),
        (b / 2, h / 2),
    ]
    outline = right + [(-y, -z) for y, z in right]
    assert_allclose((section.A, section.Iy, section.Iz), polygon(outline), rtol=1e-12)


@given(outer=SIZE, ratio=st.floats(1e-3, 0.5))
def test_tube_is_a_circle_less_a_circle(outer: float, ratio: float) -> None:
    tube = Tube(outer=outer, thickness=ratio * outer)
    full = Circle(diameter=outer)
    hole = (1 - 2 * ratio) * outer
    # the difference of the circles loses the digits that the wall's own formula keeps
    assert_allclose(tube.A, full.A - np.pi * hole**2 / 4, rtol=1e-12)
    assert_allclose(tube.Iy, full.Iy - np.pi * hole**4 / 64, rtol=1e-12)
    assert tube.Iz == tube.Iy
    assert 2 * tube.Iy == tube.J


def test_a_tube_with_the_thickest_wall_is_a_circle() -> None:
    tube, circle = Tube(outer=0.3, thickness=0.15), Circle(diameter=0.3)
    for name in ("A", "Iy", "Iz", "J", "ky", "kz"):
        assert getattr(tube, name) == pytest.approx(getattr(circle, name), rel=1e-15)


@pytest.mark.parametrize(
    ("sizes", "catalogue"),
    [
        ((0.300, 0.150, 0.0071, 0.0107), (53.81e-4, 8356e-8, 603.8e-8)),  # IPE 300
        ((0.200, 0.200, 0.0090, 0.0150), (78.08e-4, 5696e-8, 2003e-8)),  # HE 200 B
    ],
)
def test_rolled_sections(sizes: tuple[float, float, float, float], catalogue: tuple[float, float, float]) -> None:
    """EN 10365 tables give the rolled sections with their fillets, a few per cent of the area."""
    section = ISection(**dict(zip(("height", "width", "web", "flange"), sizes, strict=True)))
    properties = np.array((section.A, section.Iy, section.Iz))
    assert np.all(properties < catalogue)
    assert_allclose(properties, catalogue, rtol=0.05)


def cowper_i(h: float, b: float, tw: float, tf: float, nu: float) -> float:
    """Cowper (1966), Table 1, thin-walled I-section."""
    m, n = 2 * b * tf / ((h - tf) * tw), b / (h - tf)
    return (10 * (1 + nu) * (1 + 3 * m) ** 2) / (
        (12 + 72 * m + 150 * m**2 + 90 * m**3)
        + nu * (11 + 66 * m + 135 * m**2 + 90 * m**3)
        + 30 * n**2 * (m + m**2)
        + 5 * nu * n**2 * (8 * m + 9 * m**2)
    )


def cowper_tube(m: float, nu: float) -> float:
    """Cowper (1966), Table 1, hollow circle, m = inner / outer."""
    s = (1 + m**2) ** 2
    return 6 * (1 + nu) * s / ((7 + 6 * nu) * s + (20 + 12 * nu) * m**2)


def test_shear_coefficients_are_cowpers_at_nu_0() -> None:
    i_section = ISection(height=0.3, width=0.15, web=0.007, flange=0.011)
    assert i_section.kz == pytest.approx(cowper_i(0.3, 0.15, 0.007, 0.011, 0.0), rel=1e-14)
    assert Tube(outer=1.0, thickness=0.1).ky == pytest.approx(cowper_tube(0.8, 0.0), rel=1e-14)
    assert Circle(diameter=2.0).kz == pytest.approx(cowper_tube(0.0, 0.0), rel=1e-15)
    assert Rectangle(y=1.0, z=3.0).ky == pytest.approx(10 / 12, rel=1e-15)


def test_shear_coefficients_change_little_with_nu() -> None:
    """What the docstring states of nu = 0.3."""
    assert pytest.approx(1.02, abs=2e-3) == 10 * 1.3 / (12 + 11 * 0.3) / (5 / 6)
    assert cowper_tube(1.0, 0.3) / cowper_tube(1.0, 0.0) == pytest.approx(1.06, abs=2e-3)


def test_shear_coefficient_of_a_web_is_the_energy_of_its_shear_flow() -> None:
    """1 / k = A / I^2 int q^2 / t ds on the centre lines, with the shear flow q of a unit shear force times I."""
    h0, b, tw, tf = 0.4, 0.3, 0.004, 0.006
    section = ISection(height=h0 + tf, width=b, web=tw, flange=tf)
    area = h0 * tw + 2 * b * tf
    inertia = tw * h0**3 / 12 + b * tf * h0**2 / 2
    flange = 4 * quad(lambda s: (tf * h0 / 2 * s) ** 2 / tf, 0, b / 2)[0]
    web = quad(lambda z: (b * tf * h0 / 2 + tw / 2 * (h0**2 / 4 - z**2)) ** 2 / tw, -h0 / 2, h0 / 2)[0]
    assert section.kz == pytest.approx(inertia**2 / (area * (flange + web)), rel=1e-12)


def test_shear_coefficient_of_a_rectangle_is_its_energy() -> None:
    """Shear stress 3/2 (1 - (2 y / h)^2) of the mean one."""
    energy = quad(lambda t: (1.5 * (1 - t**2)) ** 2, -1, 1)[0] / 2
    assert Rectangle(y=1.0, z=2.0).ky == pytest.approx(1 / energy, rel=1e-13)


SHAPES: list[tuple[CrossSection, CrossSection]] = [
    (Rectangle(y=0.2, z=0.1), Rectangle(y=0.1, z=0.3)),
    (Circle(diameter=0.2), Circle(diameter=0.1)),
    (Tube(outer=0.2, thickness=0.1), Tube(outer=0.1, thickness=0.05)),
    (ISection(height=0.3, width=0.15, web=0.01, flange=0.02), ISection(height=0.2, width=0.2, web=0.02, flange=0.01)),
    (Section(A=1.0, Iy=2.0, Iz=3.0, J=4.0), Section(A=2.0, Iy=1.0, Iz=5.0, J=1.0)),
]


@pytest.mark.parametrize(("start", "end"), SHAPES)
def test_sizes_between_two_sections_are_linear(start: CrossSection, end: CrossSection) -> None:
    fraction = np.array([[0.0], [0.25], [1.0]])
    between = start.between(end, fraction)
    for name, here in start.sizes().items():
        there = end.sizes()[name]
        expected = np.interp(fraction, [0.0, 1.0], [float(here), float(there)])
        assert_allclose(getattr(between, name), expected, rtol=1e-15)
    for name in ("A", "Iy", "Iz", "J"):
        assert getattr(between, name)[0, 0] == pytest.approx(getattr(start, name), rel=4e-16)
        assert getattr(between, name)[-1, 0] == pytest.approx(getattr(end, name), rel=4e-16)


@pytest.mark.parametrize(("start", "end"), SHAPES)
def test_a_batch_is_its_members(start: CrossSection, end: CrossSection) -> None:
    fraction = np.linspace(0.0, 1.0, 5)
    batch = start.between(end, fraction)
    assert batch.shape == (5,)
    for index, value in enumerate(fraction):
        one = start.between(end, float(value))
        for name in ("A", "Iy", "Iz", "J", "ky", "kz"):
            of_batch = np.broadcast_to(getattr(batch, name), (5,))[index]
            assert_allclose(of_batch, getattr(one, name), rtol=1e-14)


def test_sizes_broadcast() -> None:
    section = Rectangle(y=np.linspace(1.0, 2.0, 3), z=np.linspace(1.0, 2.0, 4)[:, None])
    assert section.shape == np.shape(section.J) == (4, 3)
    assert isinstance(Rectangle(y=1, z=2).J, float)


I300 = ISection(height=0.3, width=0.15, web=0.007, flange=0.011)


@pytest.mark.parametrize(
    ("make", "told"),
    [
        (lambda: Rectangle(y=0.0, z=1.0), "Rectangle: y = 0 must be above zero"),
        (lambda: Rectangle(y=1.0, z=[1.0, -2.0]), "Rectangle: z = -2 must be above zero"),
        (lambda: Rectangle(y=float("nan"), z=1.0), "Rectangle: y = nan must be finite"),
        (lambda: Rectangle(y=float("inf"), z=1.0), "Rectangle: y = inf must be finite"),
        (lambda: Rectangle(y=np.ones(2), z=np.ones(3)), r"shapes do not broadcast: y \(2,\), z \(3,\)"),
        (lambda: Circle(diameter=-1.0), "Circle: diameter = -1"),
        (lambda: Tube(outer=1.0, thickness=0.6), "thickness = 0.6 must be at most half"),
        (lambda: Tube(outer=1.0, thickness=0.0), "thickness = 0 must be above zero"),
        (lambda: replace(I300, web=0.15, flange=0.1), "web = 0.15 must be below the width"),
        (lambda: replace(I300, web=0.03), "web = 0.03 must be at most twice the flange"),
        (lambda: replace(I300, height=0.02), "flange = 0.011 must be below half of the height"),
        (lambda: replace(I300, width=0.02), "flange = 0.011 must be at most half of the width"),
        (lambda: Section(A=1.0, Iy=1.0, Iz=0.0, J=1.0), "Section: Iz = 0 must be above zero"),
        (lambda: Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0, ky=-1.0), "Section: ky = -1 must be above zero"),
        (lambda: Section(A=1.0, Iy=1.0, Iz=1.0, J="x"), "J is 'x': give a number"),  # type: ignore[arg-type]
    ],
)
def test_what_cannot_be_is_refused(make: Any, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        make()
