"""Mass along the beams of links: inertia forces of tapers in closed form, and masses that are given alone."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.models import Linkage

RHO, START, END = 7800.0, 0.04, 0.02
STEEL = Material(E=200e9, nu=0.3, density=RHO)


def arm(tip: tuple[float, ...], axis: tuple[float, ...] = (0, 0, 1), **given: object) -> Linkage:
    out = Linkage(A=(0, 0, 0), B=tip)
    out.link("arm", "A", "B", **given)  # type: ignore[arg-type]
    out.revolute("A", "ground", "arm", axis=axis, drive=True)
    return out


@pytest.mark.parametrize("tip", [(1.0, 0.0, 0.0), (0.6, 0.0, 0.8)])
@pytest.mark.parametrize("segments", [1, 3])
def test_a_tapered_rod_in_rotation(tip: tuple[float, ...], segments: int) -> None:
    """Forces are integrals of ``rho A a`` over the part ahead; the area is a square of the distance."""
    beam = Beam(Circle(diameter=START), STEEL, end=Circle(diameter=END), segments=segments)
    spin, rise, x = 30.0, 70.0, np.array([0.0, 0.3, 0.5, 0.9])
    motion = arm(tip, (0, 1, 0), beam=beam).move(A=0.2, rates={"A": spin}, accelerations={"A": rise})
    solution = motion.frame(inertia=True).solve()
    area = np.polynomial.Polynomial([START, END - START]) ** 2 * (np.pi / 4.0)
    line = np.polynomial.Polynomial([0.0, 1.0])
    pull, moment = (RHO * area * line).integ(), (RHO * area * line * line).integ()
    ahead, turned = pull(1.0) - pull(x), moment(1.0) - moment(x)
    found = solution.forces("arm", x)
    np.testing.assert_allclose(found[:, 0], spin**2 * ahead, rtol=1e-12)
    np.testing.assert_allclose(np.hypot(found[:, 1], found[:, 2]), rise * ahead, rtol=1e-12)
    # the rotary inertia of the sections, which acts at one end, is of the square of their slenderness
    bending = rise * (turned - x * ahead)
    np.testing.assert_allclose(np.hypot(found[:, 4], found[:, 5]), bending, rtol=0.0, atol=1e-3 * bending[0])


@pytest.mark.parametrize("density", [0.0, RHO])
@pytest.mark.parametrize("degrees", [0.0, 10.0, 33.0, 90.0])
def test_a_mass_that_is_given_alone_is_spread(degrees: float, density: float) -> None:
    """``m g L^3 / (8 E I)`` (Timoshenko, Strength of Materials I), in whichever direction the arm was drawn."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    material, bar = Material(E=200e9, nu=0.3, density=density), Rectangle(y=0.02, z=0.01)
    linkage = arm((c, s, 0.0), beam=Beam(bar, material), mass=2.0)
    linkage.gravity((10.0 * s, -10.0 * c, 0.0))
    tip = linkage.move().frame().solve().displacement("B")[:2]
    np.testing.assert_allclose(tip @ (-s, c), -2.0 * 10.0 / (8.0 * 200e9 * bar.Iz), rtol=1e-10)
    same = arm((c, s, 0.0), beam=Beam(bar, Material(E=200e9, nu=0.3, density=2.0 / bar.A)))
    np.testing.assert_allclose(linkage.move().frequencies(1), same.move().frequencies(1), rtol=1e-2)


@pytest.mark.parametrize("tip", [(0.7, 0.1, 0.0), (0.1, 0.7, 0.3), (0.3, 0.9, 0.1)])
def test_a_mass_in_the_middle_is_at_the_first_point(tip: tuple[float, ...]) -> None:
    """Which end is nearer to the middle of a bar would be rounding, and change with the direction it was drawn in."""
    beam = Beam(Rectangle(y=0.02, z=0.01), STEEL)
    middle = np.mean([(0.1, 0.1, 0.1), np.add(tip, 0.1)], axis=0)
    linkage = Linkage(A=(0.1, 0.1, 0.1), B=np.add(tip, 0.1))
    linkage.link("arm", "A", "B", beam=beam, mass=2.0, centre=middle, inertia=0.0)
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.gravity((0.0, -10.0, 0.0))
    solution = linkage.move().frame().solve()
    assert np.abs(solution.displacement("B")).max() < 1e-15
    np.testing.assert_allclose(solution.joint_force("A")[1], -20.0, rtol=1e-12)
