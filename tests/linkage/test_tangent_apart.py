"""Frequencies under load that lie far apart, and how many a linkage has."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose

INF = np.inf
MASS, LENGTH, WEIGHT = 2.0, 0.5, 9.81


def arms(*drives: float) -> Linkage:
    """Point masses on rigid arms side by side, upright on springs of the pivots."""
    linkage = Linkage()
    for k, drive in enumerate(drives):
        linkage.point(f"A{k}", (k, 0.0))
        linkage.point(f"B{k}", (k, LENGTH))
        linkage.link(f"arm{k}", f"A{k}", f"B{k}", mass=MASS, centre=(k, LENGTH), inertia=0.0)
        linkage.revolute(f"A{k}", "ground", f"arm{k}", drive=True, stiffness=(INF,) * 5 + (drive,))
    linkage.gravity((0.0, -WEIGHT))
    return linkage


@pytest.mark.parametrize("stiff", [1e3, 1e6, 1e10])
@pytest.mark.parametrize("least", [-5.0, 1e-2])
def test_arms_that_swing_each_by_itself(stiff: float, least: float) -> None:
    """``m l^2 w^2 = k - m g l`` for each, the one that falls over without a frequency."""
    net = np.array([least, 0.7, stiff])
    found = arms(*(net + MASS * WEIGHT * LENGTH)).move().frequencies(3)
    wanted = np.sqrt(np.where(net > 0.0, np.abs(net), np.nan) / (MASS * LENGTH**2)) / (2.0 * np.pi)
    assert_allclose(found, wanted, rtol=1e-6 if stiff == 1e10 else 1e-9)


def crank(stiffness: float, load: float, density: float = 7850.0, pin: float = INF) -> Linkage:
    """A crank on a soft spring with a rod and a rocker, whose end alone is heavy."""
    bar = Beam(Circle(diameter=0.01), Material(E=2e11, nu=0.3, density=density))
    linkage = Linkage(A=(0, 0), B=(0, 0.1), C=(0.3, 0.15), D=(0.25, 0.0))
    linkage.link("crank", "A", "B", beam=bar)
    linkage.link("rod", "B", "C", beam=bar)
    linkage.link("rocker", "C", "D", beam=bar, mass=2.0, centre=(0.3, 0.15), inertia=(2e-4,) * 3 + (0.0,) * 3)
    linkage.revolute("A", "ground", "crank", drive=True, stiffness=(INF,) * 5 + (stiffness,))
    springs = (pin,) * 3 + (pin * 1e-7,) * 2 + (0.0,)
    linkage.revolute("B", "crank", "rod", stiffness=springs)
    linkage.revolute("C", "rod", "rocker", stiffness=springs)
    linkage.revolute("D", "rocker", "ground", stiffness=springs)
    if load:
        linkage.load("B", fx=load)
    return linkage


@pytest.mark.parametrize("spring", [1e-8, 1e-4, 200.0])
def test_a_vanishing_load_leaves_all_frequencies_but_the_softest(spring: float) -> None:
    found, wanted = (crank(spring, load).move(A=0.1).frequencies(12) for load in (1e-12, 0.0))
    assert_allclose(found[1:], wanted[1:], rtol=1e-9)


@pytest.mark.parametrize("load", [0.0, 1e-6])
@pytest.mark.parametrize("pin", [INF, 1e13])
def test_a_mass_on_links_without_mass_has_six_modes(load: float, pin: float) -> None:
    motion = crank(200.0, load, 0.0, pin).move(A=0.1)
    assert np.isfinite(motion.frequencies(6)).all()
    for count in (7, 8, 12):
        with pytest.raises(FrameError, match="fewer modes with mass"):
            motion.frequencies(count)


def cantilever(bob: bool, load: float) -> Linkage:
    """A bar that is held at its root, perhaps with a link without mass that hangs loose from its end."""
    bar = Beam(Circle(diameter=0.01), Material(E=2e11, nu=0.3, density=7850.0), segments=2)
    linkage = Linkage(A=(0, 0), B=(0.3, 0.1), C=(0.3, -0.2))
    linkage.link("bar", "A", "B", beam=bar)
    linkage.fixed("A", "ground", "bar")
    if bob:
        linkage.link("bob", "B", "C")
        linkage.spherical("B", "bar", "bob")
    linkage.load("B", link="bar", fx=load)
    return linkage


@pytest.mark.parametrize("load", [1e-9, -500.0])
def test_a_loose_link_without_mass_is_no_mode(load: float) -> None:
    found, wanted = (cantilever(bob, load).move().frequencies(4) for bob in (True, False))
    assert_allclose(found, wanted, rtol=1e-9)
    swinging = cantilever(True, load)
    swinging.revolute("A", "ground", "bar", name="A", replace=True)
    assert np.isnan(swinging.move().frequencies(1)).all()


def test_what_cannot_move_has_no_compliance_under_load() -> None:
    linkage = Linkage(A=(0, 0), B=(0.3, 0.1))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.load("B", fx=10.0)
    motion = linkage.move(A=[0.0, 0.5])
    assert_allclose(motion.compliance_matrix("B"), 0.0, atol=0.0)
    with pytest.raises(FrameError, match="its stiffness is infinite there"):
        motion.stiffness("B")
    with pytest.raises(FrameError, match=r"frequencies\(1\): the frame has no unknowns"):
        motion.frequencies(1)


def test_what_nothing_holds_has_no_stiffness_and_warns_of_nothing() -> None:
    """An arm that no drive holds and a load swings is kinematically unstable, beside its rigid pivot."""
    linkage = Linkage(A=(0, 0), B=(0.3, 0.1))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm")
    for load in (0.0, 10.0):
        linkage.load("B", fy=load, replace=True)
        assert np.isnan(linkage.move().stiffness("A", "arm")).any()
