"""Probability that a point leaves its zone under load: an arm in closed form, a four-bar beside plain sampling."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import Linkage, propagate
from numpy.testing import assert_allclose
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]
SECTION = Rectangle(y=0.02, z=0.01)
BENDING = SECTION.y**3 * SECTION.z / 12.0


def arm(force: Array | float = 10.0, modulus: Array | float = 200e9) -> Linkage:
    """An arm of 1 m that its drive holds, loaded across."""
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B", beam=Beam(SECTION, Material(E=modulus, nu=0.3)))
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.load("B", fy=force)
    return linkage


def test_deflection_of_an_arm() -> None:
    """``F L^3 / (3 E I)`` with F and E lognormal is lognormal: the plane of first order is the limit state."""
    inputs = {"force": stats.lognorm(0.1, scale=10.0), "modulus": stats.lognorm(0.05, scale=200e9)}
    middle, limit = 10.0 / (3.0 * 200e9 * BENDING), 4e-3
    exact = stats.norm.sf(np.log(limit / middle) / np.hypot(0.1, 0.05))
    motion = arm().move(A=[0.0, 0.0])
    found = motion.reliability("B", limit, arm, inputs, compliance=True, method="form")
    assert_allclose(found.probability, exact, rtol=1e-5)
    sampled = motion.reliability("B", limit, arm, inputs, compliance=True, rng=0)
    low, high = sampled.confidence_interval(0.99)
    assert np.all((low < exact) & (exact < high))
    assert sampled.coefficient_of_variation.max() <= 0.05
    # Rigid, it does not leave its place.
    rigid = motion.reliability("B", limit, arm, inputs, method="random", samples=200, rng=0)
    assert not rigid.probability.any()


def four_bar(crank: Array, stiffness: Array, clearance: Array, force: Array) -> Linkage:
    pin = np.stack(np.broadcast_arrays(*[stiffness] * 5, 0.0), axis=-1)
    place = np.stack(np.broadcast_arrays(0.0, crank), axis=-1)
    linkage = Linkage(A=(0, 0), B=place, P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    beam = Beam(SECTION, Material(E=200e9, nu=0.3))
    for name, ends in (("crank", "AB"), ("coupler", "BPD"), ("rocker", "DE")):
        linkage.link(name, *ends, beam=beam)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=pin)
    linkage.revolute("D", "coupler", "rocker", stiffness=pin, clearance=clearance)
    linkage.revolute("E", "rocker", "ground", stiffness=pin)
    linkage.load("P", fy=force)
    return linkage


def test_a_four_bar_with_compliance_and_clearance_beside_sampling() -> None:
    """Dimension, stiffness, clearance and load at once."""
    inputs = {
        "crank": stats.norm(0.1, 1e-5),
        "stiffness": stats.lognorm(0.2, scale=5e6),
        "clearance": stats.uniform(1e-5, 2e-5),
        "force": stats.norm(100.0, 20.0),
    }
    motion = four_bar(0.1, 5e6, 2e-5, 100.0).move(A=np.radians([0.0, 10.0]))
    drive, nominal = np.radians([[0.0], [10.0]]), motion.position("P")

    def off(**samples: Array) -> Array:
        moved = four_bar(**samples).move(A=drive).accuracy("P")
        return np.linalg.norm(moved.rigid + moved.total[..., :3] - nominal[:, None], axis=-1)

    n = 4000
    many = propagate(off, inputs, n=n, rng=1, axis=-1, progress=False).samples.T
    limit = float(np.quantile(many, 0.95))
    found = motion.reliability("P", limit, four_bar, inputs, compliance=True, rng=0, accuracy=0.1, starts=2)
    p = found.probability
    error = np.hypot(found.standard_error, np.sqrt(p * (1.0 - p) / n))
    assert np.all(np.abs(p - (many > limit).mean(axis=-1)) < 3.5 * error)


def test_a_pose_without_a_displacement_is_refused() -> None:
    """A parallelogram whose links lie in one line is assembled there, and no finite force holds it."""
    beam = Beam(SECTION, Material(E=200e9, nu=0.3))

    def parallelogram(load: Array) -> Linkage:
        linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
        for name in ("AB", "BC", "CD"):
            linkage.link(name, *name, beam=beam)
        linkage.revolute("A", "ground", "AB", drive=True)
        for pin, first, second in (("B", "AB", "BC"), ("C", "BC", "CD"), ("D", "CD", "ground")):
            linkage.revolute(pin, first, second)
        linkage.load("C", fy=load)
        return linkage

    motion = parallelogram(1.0).move(A=np.radians([0.0, -90.0]))
    with pytest.raises(FrameError, match="no displacement of 'C' at pose number 1"):
        motion.reliability("C", 1e-3, parallelogram, {"load": stats.norm(1.0, 0.1)}, compliance=True)
