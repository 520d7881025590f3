"""Mass, centre and inertia of links: solids in closed form, what was given, and what follows from both."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework.arm import cross_matrix
from linkframe.models import Linkage
from linkframe.models.linkage.statics.inertia import inertia
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BLOCK = Beam(Rectangle(y=0.03, z=0.02), STEEL)


def solid(density: float, length: float) -> tuple[float, Array]:
    """Mass and principal inertia of the block of `BLOCK` along x, from the book's m (a^2 + b^2) / 12."""
    mass = density * 0.03 * 0.02 * length
    sides = np.array([length, 0.03, 0.02])
    return mass, mass / 12 * np.diag(np.sum(sides**2) - sides**2)


@pytest.mark.parametrize("end", [(2.0, 1.0, 1.0), (1.5, 3.0, 1.0)])
def test_a_beam_is_a_block(end: tuple[float, float, float]) -> None:
    start = np.array([1.0, 1.0, 1.0])
    linkage = Linkage(A=start, B=end)
    linkage.link("bar", "A", "B", beam=BLOCK)
    found = inertia(linkage, "bar")
    chord = np.array(end) - start
    length = np.linalg.norm(chord)
    mass, principal = solid(7850.0, float(length))
    rows = BLOCK.axes(chord)
    assert_allclose(found.mass, mass, rtol=1e-13)
    assert_allclose(found.centre, (start + np.array(end)) / 2, rtol=1e-13)
    assert_allclose(found.tensor, rows.T @ principal @ rows, rtol=0.0, atol=1e-12 * principal.max())


def test_beams_add_up() -> None:
    """An L of two bars, by the parallel-axis theorem."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 2))
    linkage.link("angle", "A", "B", "C", beam=BLOCK)
    found = inertia(linkage, "angle")
    (m1, i1), (m2, i2) = solid(7850.0, 1.0), solid(7850.0, 2.0)
    centre = (m1 * np.array([0.5, 0, 0]) + m2 * np.array([1.0, 1.0, 0])) / (m1 + m2)
    turned = np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]])
    total = np.zeros((3, 3))
    for mass, tensor, at in ((m1, i1, [0.5, 0, 0]), (m2, turned @ i2 @ turned.T, [1.0, 1.0, 0])):
        arm = cross_matrix(np.array(at) - centre)
        total += tensor - mass * arm @ arm
    assert_allclose(found.mass, m1 + m2, rtol=1e-13)
    assert_allclose(found.centre, centre, rtol=1e-13, atol=1e-15)
    assert_allclose(found.tensor, total, rtol=0.0, atol=1e-11 * total.max())


def test_a_cone_frustum() -> None:
    """Mass and centre of a frustum, r from 2 to 1 cm over 0.5 m: pi h (R^2 + R r + r^2) / 3."""
    linkage = Linkage(A=(0, 0), B=(0.5, 0))
    linkage.link("cone", "A", "B", beam=Beam(Circle(diameter=0.04), STEEL, end=Circle(diameter=0.02)))
    found = inertia(linkage, "cone")
    R, r, h = 0.02, 0.01, 0.5
    assert_allclose(found.mass, 7850.0 * np.pi * h * (R * R + R * r + r * r) / 3, rtol=1e-12)
    wanted = h * (R * R + 2 * R * r + 3 * r * r) / (4 * (R * R + R * r + r * r))
    assert_allclose(found.centre, [wanted, 0, 0], rtol=1e-12, atol=1e-16)


def test_given_numbers_come_first_and_beams_spread_a_given_mass() -> None:
    linkage = Linkage(A=(0, 0), B=(2, 0), C=(0, 2))
    linkage.link("given", "A", "B", beam=BLOCK, mass=3.0, centre=(0.5, 0.1), inertia=(1, 2, 3, 0.1, 0.2, 0.3))
    linkage.link("spread", "A", "B", beam=BLOCK, mass=3.0)
    light = Beam(Rectangle(y=0.03, z=0.02), Material(E=1e9, nu=0.3))
    linkage.link("light", "A", "B", beam=light, mass=3.0)
    linkage.link("empty", "A", "B", beam=light)
    linkage.link("point", "A", "B", "C", mass=3.0)
    given = inertia(linkage, "given")
    assert_allclose(given.tensor, [[1, 0.1, 0.3], [0.1, 2, 0.2], [0.3, 0.2, 3]])
    assert_allclose(given.centre, [0.5, 0.1, 0.0])
    mass, principal = solid(7850.0, 2.0)
    for name in ("spread", "light"):
        found = inertia(linkage, name)
        assert found.mass == 3.0
        assert_allclose(found.tensor, 3.0 / mass * principal, rtol=1e-11, atol=1e-16)
        assert_allclose(found.centre, [1, 0, 0], atol=1e-15)
    empty, point = inertia(linkage, "empty"), inertia(linkage, "point")
    assert empty.mass == 0.0
    assert not empty.tensor.any()
    assert_allclose(point.centre, [2 / 3, 2 / 3, 0])
    assert not point.tensor.any()


def test_true_length_counts() -> None:
    linkage = Linkage(A=(0, 0), B=(2, 0))
    linkage.link("bar", "A", "B", beam=BLOCK, length=np.array([1.0, 3.0]))
    found = inertia(linkage, "bar")
    assert_allclose(found.mass, 7850.0 * 0.03 * 0.02 * np.array([1.0, 3.0]))
    assert_allclose(found.centre[:, 0], [0.5, 1.5])
