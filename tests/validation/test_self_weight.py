"""Beams under their own weight: statics and the elementary closed forms (Gere and Goodno, appendix H)."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, PointMass, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose

LENGTH, WIDTH, DEPTH = 1.5, 0.02, 0.03
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Rectangle(y=WIDTH, z=DEPTH)
LINE = 7850.0 * WIDTH * DEPTH * 9.81


def cantilever(direction: tuple[float, float, float], segments: int = 1) -> Frame:
    """A cantilever along `direction`."""
    frame = Frame()
    frame.node("wall", (0.0, 0.0, 0.0))
    frame.node("tip", LENGTH * np.array(direction))
    frame.add("beam", Beam(BAR, STEEL, segments=segments), "wall", "tip")
    frame.fix("wall")
    frame.gravity((0.0, 0.0, -9.81))
    return frame


@pytest.mark.parametrize("segments", [1, 5])
def test_horizontal(segments: int) -> None:
    """Tip w L^4/8EI down, slope w L^3/6EI, wall w L and w L^2/2; moment w (L-x)^2/2 along the beam."""
    solution = cantilever((1.0, 0.0, 0.0), segments).solve()
    rigidity = 200e9 * WIDTH * DEPTH**3 / 12
    tip = solution.displacement("tip")
    assert_allclose(tip[[2, 4]], [-LINE * LENGTH**4 / (8 * rigidity), LINE * LENGTH**3 / (6 * rigidity)], rtol=1e-12)
    assert_allclose(solution.reaction("wall")[[2, 4]], [LINE * LENGTH, -LINE * LENGTH**2 / 2], rtol=1e-12)
    x = np.linspace(0.0, LENGTH, 7)
    forces = solution.forces("beam", x)
    assert_allclose(forces[:, 4], LINE * (LENGTH - x) ** 2 / 2, rtol=1e-11, atol=1e-11)
    assert_allclose(forces[:, 2], -LINE * (LENGTH - x), rtol=1e-11, atol=1e-11)
    sag = -LINE * x**2 * (6 * LENGTH**2 - 4 * LENGTH * x + x**2) / (24 * rigidity)
    assert_allclose(solution.displacement_along("beam", x)[:, 2], sag, rtol=1e-11, atol=1e-20)


def test_hanging() -> None:
    """A bar hanging by its upper end lengthens by rho g L^2/2E; N = w (L - x), and u = w x (2L - x)/2EA."""
    solution = cantilever((0.0, 0.0, -1.0)).solve()
    x = np.linspace(0.0, LENGTH, 5)
    assert_allclose(solution.displacement("tip")[2], -7850.0 * 9.81 * LENGTH**2 / (2 * 200e9), rtol=1e-12)
    assert_allclose(solution.forces("beam", x)[:, 0], LINE * (LENGTH - x), rtol=1e-12, atol=1e-12)
    along = -LINE * x * (2 * LENGTH - x) / (2 * 200e9 * WIDTH * DEPTH)
    assert_allclose(solution.displacement_along("beam", x)[:, 2], along, rtol=1e-12, atol=1e-25)


def test_inclined_equals_the_line_load() -> None:
    """Weight is the line load rho g A in the direction of gravity; a mass adds m g."""
    direction = (0.48, 0.6, 0.64)
    heavy = cantilever(direction)
    heavy.add("ball", PointMass(3.0), "tip")
    loaded = cantilever(direction)
    loaded.gravity((0.0, 0.0, 0.0))
    loaded.line_load("beam", fz=-LINE)
    loaded.load("tip", fz=-3.0 * 9.81)
    ours, theirs = heavy.solve(), loaded.solve()
    assert_allclose(ours.displacement("tip"), theirs.displacement("tip"), rtol=1e-12, atol=1e-15)
    assert_allclose(ours.reaction("wall"), theirs.reaction("wall"), rtol=1e-12, atol=1e-12 * LINE * LENGTH)
    assert_allclose(ours.reaction("wall")[2], LINE * LENGTH + 3.0 * 9.81, rtol=1e-12)
