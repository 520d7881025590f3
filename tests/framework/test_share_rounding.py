"""Forces in redundant ideal joints against 50 digits: what rounding may make of them is more than what it makes."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.framework.error_bounds.link_forces import link_forces, link_roundings
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
FIXED = Joint(stiffness=(np.inf,) * 6)


def bracket(apart: Numbers, arm: Numbers, force: Numbers) -> Frame:
    """A rigid bracket, loaded at the end of its arm, on two ideal joints at the end of a rod."""
    frame = Frame()
    for name, place in {"G": (-1.0, 0.0, 0.0), "P": (0.0, 0.0, 0.0), "Q": (0.0, 0.0, 0.0), "R": arm}.items():
        frame.node(name, place)
    for name in ("P2", "Q2"):
        frame.node(name, apart)
    frame.add("rod", ROD, "G", "P")
    frame.fix("G")
    frame.rigid("P", "P2")
    frame.rigid("Q", "Q2")
    frame.rigid("Q", "R")
    frame.add("first", FIXED, "P", "Q")
    frame.add("second", FIXED, "P2", "Q2")
    frame.load("R", fx=force[0], fy=force[1], fz=force[2])
    return frame


def exact(apart: Numbers, arm: Numbers, force: Numbers) -> list[list[mpmath.mpf]]:
    """Least forces, and moments divided by half the distance, of both joints: by the pseudo-inverse in 50 digits."""
    with mpmath.workdps(50):
        away, reach, load = ([mpmath.mpf(float(each)) for each in vector] for vector in (apart, arm, force))
        length = mpmath.sqrt(sum(each**2 for each in away)) / 2
        balance = mpmath.zeros(6, 12)
        for k in range(3):
            balance[k, k] = balance[k, 6 + k] = 1
            balance[3 + k, 3 + k] = balance[3 + k, 9 + k] = length
        whole = mpmath.matrix([*load, *cross(reach, load)])
        for k in range(3):
            unit = [mpmath.mpf(int(k == j)) for j in range(3)]
            for row, moment in enumerate(cross(away, unit)):
                balance[3 + row, 6 + k] = moment
        found = balance.T * mpmath.lu_solve(balance * balance.T, whole)
        return [[found[6 * joint + k] * (1 if k < 3 else length) for k in range(6)] for joint in range(2)]


def cross(a: list[mpmath.mpf], b: list[mpmath.mpf]) -> list[mpmath.mpf]:
    return [a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3] for k in range(3)]


@pytest.mark.parametrize("distance", [1e-4, 1.0])
def test_what_rounding_makes_of_shared_forces_is_within_what_it_may(distance: float) -> None:
    rng, off = np.random.default_rng(3), 0.0
    for _ in range(4):
        apart, arm, force = distance * rng.normal(size=3), rng.normal(size=3), 1e3 * rng.normal(size=3)
        state = bracket(apart, arm, force).solve().bounds.whole()
        ends = [np.zeros((len(each.nodes), 2, 2)) for each in state.springs]
        bounds = link_roundings(state, ends)
        truth = iter(exact(apart, arm, force))
        for link, found, bound in zip(state.kinematics.links, link_forces(state), bounds, strict=True):
            if link.edge.kind == "joint":
                error = np.abs([float(mpmath.mpf(float(f)) - t) for f, t in zip(found, next(truth), strict=True)])
                off = max(off, error.max())
                assert np.all(error <= np.repeat(bound, 3) + 4e-16 * np.abs(found))
                assert np.all(bound <= 1e-10 * np.linalg.norm(force) * (1.0 + 1.0 / distance))
    assert off > 0.0
