"""The geometrically exact rod, integrated as an initial value problem and met by shooting: no finite elements.

Position r, rotation R (a quaternion), internal force n and moment m along the arc length s (Antman, Nonlinear Problems
of Elasticity, 2nd ed., 2005, ch. 8; Simo & Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986) 79-116)::

    r' = R (e1 + Γ),   R' = R [κ0 + κ]x,   n' = 0,   m' = -r' x n

with the strains Γ = (n1/EA, n2/GA2, n3/GA3) and the curvatures κ = (m1/GJ, m2/EI2, m3/EI3) in the rod's own axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, sin

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.optimize import root

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Rod:
    """Stiffnesses (EA, GA2, GA3) and (GJ, EI2, EI3), length, and curvature at rest in its own axes."""

    stretch: Sequence[float]
    bend: Sequence[float]
    length: float
    curvature: Sequence[float] = (0.0, 0.0, 0.0)

    def shot(self, start: Array, axes: Array, force: Array, moment: Array, length: float | None = None) -> Array:
        """Position (3), quaternion (4) and moment (3) at the end, from those at the start; `force` is n, constant."""
        first, second, third = force.tolist()

        def rates(_: float, y: Array) -> list[float]:
            w, a, b, c, *turning = y[3:].tolist()
            turn = matrix(w, a, b, c)
            x1, x2, x3 = turn
            gamma = [
                (p * first + q * second + r * third) / k for p, q, r, k in zip(x1, x2, x3, self.stretch, strict=True)
            ]
            gamma[0] += 1.0
            ahead = [sum(p * q for p, q in zip(row, gamma, strict=True)) for row in turn]
            own = [sum(p * q for p, q in zip(column, turning, strict=True)) for column in zip(*turn, strict=True)]
            k1, k2, k3 = (k + m / stiff for k, m, stiff in zip(self.curvature, own, self.bend, strict=True))
            spun = [
                -a * k1 - b * k2 - c * k3,
                w * k1 + b * k3 - c * k2,
                w * k2 + c * k1 - a * k3,
                w * k3 + a * k2 - b * k1,
            ]
            dx, dy, dz = ahead
            lever = [dz * second - dy * third, dx * third - dz * first, dy * first - dx * second]
            return [dx, dy, dz, *(0.5 * rate for rate in spun), *lever]

        begin = np.concatenate([start, axes, moment])
        span = (0.0, self.length if length is None else length)
        return np.asarray(solve_ivp(rates, span, begin, method="DOP853", rtol=1e-10, atol=1e-10).y[:, -1])


def matrix(w: float, x: float, y: float, z: float) -> list[list[float]]:
    """Rotation matrix of a quaternion, scalar first, row by row."""
    k = 2.0 / (w * w + x * x + y * y + z * z)
    return [
        [1.0 - k * (y * y + z * z), k * (x * y - w * z), k * (x * z + w * y)],
        [k * (x * y + w * z), 1.0 - k * (x * x + z * z), k * (y * z - w * x)],
        [k * (x * z - w * y), k * (y * z + w * x), 1.0 - k * (x * x + y * y)],
    ]


def cantilever(rod: Rod, force: Array, steps: int = 3) -> Array:
    """Position of the free end of a rod clamped at the origin along x, under a dead force there."""
    guess = np.zeros(3)
    still = np.array([1.0, 0.0, 0.0, 0.0])
    end = np.zeros(10)
    for share in np.arange(1, steps + 1) / steps:
        found = root(
            lambda m, share=share: rod.shot(np.zeros(3), still, share * force, m)[7:], guess, method="hybr", tol=1e-12
        )
        assert np.abs(found.fun).max() < 1e-8 * np.abs(guess).max(initial=1.0), found.message
        guess = found.x
        end = rod.shot(np.zeros(3), still, force, guess)
    return end[:3]


@dataclass(frozen=True)
class PlaneRod:
    """The same rod in the plane, without shear: stiffnesses EA and EI."""

    EA: float
    EI: float

    def shot(self, start: Array, force: Array, length: float, curvature: float = 0.0) -> Array:
        """x, y, angle and moment at the end, from those at the start; `force` is n, constant."""

        push, lift = force.tolist()

        def rates(_: float, y: Array) -> list[float]:
            *_, angle, moment = y.tolist()
            x, y = cos(angle), sin(angle)
            stretch = 1.0 + (x * push + y * lift) / self.EA
            return [stretch * x, stretch * y, curvature + moment / self.EI, stretch * (push * y - lift * x)]

        return np.asarray(solve_ivp(rates, (0.0, length), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1])


def solved(equations: Callable[[Array], Array], guess: Array, tolerance: float = 1e-9) -> Array:
    """Root of some equations, checked: their values are given in units in which one is large."""
    found = root(equations, guess, method="hybr", options={"xtol": 1e-14})
    assert np.abs(found.fun).max() < tolerance, (found.message, found.fun)
    return np.asarray(found.x)
