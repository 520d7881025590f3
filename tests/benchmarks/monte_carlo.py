"""A Monte Carlo whose mean is known exactly: the four-bar at one pose, stiffness, load and clearance uncertain.

The linkage is statically determinate, so that the displacement of P is linear in the load, in the clearance and in the
joints' compliances. The mean is thus the displacement at mean load, mean clearance and, since a lognormal stiffness of
median k and shape s has the mean compliance exp(s^2 / 2) / k, at the stiffness k exp(-s^2 / 2): one solution, which
the reference gives in 50 digits.
"""

from __future__ import annotations

from math import exp, radians

import numpy as np
from linkframe.elements import Beam
from linkframe.models import FourBar
from numpy.typing import NDArray
from scipy import stats

from .job import BAR, STEEL, Job

Array = NDArray[np.float64]

THETA = radians(60.0)
MEDIAN, SHAPE, FORCE, SPREAD, GAP, GAP_SPREAD = 2e8, 0.3, 100.0, 10.0, 2e-5, 1e-5
FOUR_BAR = FourBar(beam=Beam(BAR, STEEL))
INPUTS = {joint: stats.lognorm(SHAPE, scale=MEDIAN) for joint in "BDE"} | {
    "force": stats.norm(FORCE, SPREAD),
    "gap": stats.norm(GAP, GAP_SPREAD),
}


def displacement(B: Array, D: Array, E: Array, force: Array, gap: Array) -> Array:
    """Displacement ux, uy of P, (n, 2), for samples (n,) of stiffnesses, load and clearance."""
    stiffness = {joint: springs(k) for joint, k in (("B", B), ("D", D), ("E", E))}
    frame = FourBar(beam=FOUR_BAR.beam, stiffness=stiffness).move(THETA).frame()
    for joint in stiffness:
        frame.offset(joint, ux=gap)
    frame.load("P", fy=force)
    found: Array = frame.solve().displacement("P")[:, :2]
    return found


def springs(k: Array) -> Array:
    """Six springs: all of stiffness k, but free to turn about z."""
    k = np.asarray(k, dtype=np.float64)
    return np.stack([k] * 5 + [np.zeros_like(k)], axis=-1)


def mean() -> Array:
    """The exact mean of `displacement`, (2,)."""
    k = springs(np.array([MEDIAN * exp(-(SHAPE**2) / 2.0)]))
    load = np.array([[0.0, FORCE, 0.0, 0.0, 0.0, 0.0]])
    gap = np.array([[GAP, 0.0]])
    joints = "BDE"
    return Job(np.array([THETA]), dict.fromkeys(joints, k), dict.fromkeys(joints, gap), load).truth(0, 0)[:2]
