"""The four-bar of the accuracy paper as rods between pins of finite stiffness, met by shooting.

Links are extensible elasticas; the five unknowns are the force and moment at the drive and the angles at which coupler
and rocker leave their pins.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .rod import PlaneRod, solved

Array = NDArray[np.float64]

L, FORCE, PIN = 0.1, 100.0, 2e11
E, Y, Z = 200e9, 12.7e-3, 6.35e-3


def shot(theta: float, guess: Array, force: float = FORCE, pin: float = PIN) -> Array:
    """Displacement of P (2,) at a pose in degrees under a force upward there.

    `guess` (5,): force (2) and moment of the crank on the drive, rotations of coupler and rocker at their pins.
    """
    rod = PlaneRod(E * Y * Z, E * Z * Y**3 / 12.0)
    angle = np.radians(theta)
    units = np.array([force, force, force * L, 1.0, 1.0])

    def walk(x: Array) -> tuple[Array, Array]:
        n, ahead = x[:2], x[:2] - np.array([0.0, force])
        crank = rod.shot(np.array([0.0, 0.0, angle, x[2]]), n, L)
        middle = rod.shot(np.array([*(crank[:2] + n / pin), x[3], 0.0]), n, L)
        coupler = rod.shot(middle, ahead, L)
        rocker = rod.shot(np.array([*(coupler[:2] + ahead / pin), angle + np.pi + x[4], 0.0]), ahead, L)
        gap = rocker[:2] + ahead / pin - [2.0 * L, 0.0]
        moments = np.array([crank[3], coupler[3], rocker[3]]) / (force * L)
        return np.concatenate([moments, gap / L]), middle

    found = solved(lambda x: walk(units * x)[0], guess / units)
    at_rest = L * np.array([np.cos(angle) + 1.0, np.sin(angle)])
    return np.asarray(walk(units * found)[1][:2] - at_rest)
