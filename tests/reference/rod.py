"""The geometrically exact rod, integrated as an initial value problem and met by shooting: no finite elements.

Position r, rotation R (a quaternion), internal force n and moment m along the arc length s (Antman, Nonlinear Problems
of Elasticity, 2nd ed., 2005, ch. 8; Simo & Vu-Quoc, Comput. Methods Appl. Mech. Engrg. 58 (1986) 79-116)::

    r' = R (e1 + Γ),   R' = R [κ0 + κ]x,   n' = 0,   m' = -r' x n

with the strains Γ = (n1/EA, n2/GA2, n3/GA3) and the curvatures κ = (m1/GJ, m2/EI2, m3/EI3) in the rod's own axes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

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
        flexible = 1.0 / np.asarray(self.stretch), 1.0 / np.asarray(self.bend)

        def rates(_: float, y: Array) -> Array:
            w, v = y[3], y[4:7]
            turn = matrix(y[3:7])
            ahead = turn @ (np.array([1.0, 0.0, 0.0]) + flexible[0] * (turn.T @ force))
            kappa = np.asarray(self.curvature) + flexible[1] * (turn.T @ y[7:])
            spun = np.concatenate([[-0.5 * v @ kappa], 0.5 * (w * kappa + np.cross(v, kappa))])
            return np.concatenate([ahead, spun, -np.cross(ahead, force)])

        begin = np.concatenate([start, axes, moment])
        span = (0.0, self.length if length is None else length)
        return np.asarray(solve_ivp(rates, span, begin, method="DOP853", rtol=1e-10, atol=1e-10).y[:, -1])


def matrix(q: Array) -> Array:
    """Rotation matrix of a quaternion, scalar first."""
    w, v = q[0], q[1:]
    cross = np.array([[0.0, -v[2], v[1]], [v[2], 0.0, -v[0]], [-v[1], v[0], 0.0]])
    return np.asarray(((w * w - v @ v) * np.eye(3) + 2.0 * np.outer(v, v) + 2.0 * w * cross) / (q @ q))


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

        def rates(_: float, y: Array) -> Array:
            along = np.array([np.cos(y[2]), np.sin(y[2])])
            ahead = along * (1.0 + along @ force / self.EA)
            return np.array([*ahead, curvature + y[3] / self.EI, force[0] * ahead[1] - force[1] * ahead[0]])

        return np.asarray(solve_ivp(rates, (0.0, length), start, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1])


def solved(equations: Callable[[Array], Array], guess: Array, tolerance: float = 1e-9) -> Array:
    """Root of some equations, checked: their values are given in units in which one is large."""
    found = root(equations, guess, method="hybr", options={"xtol": 1e-14})
    assert np.abs(found.fun).max() < tolerance, (found.message, found.fun)
    return np.asarray(found.x)
