"""Integrals of the section's flexibility along a member, from its start to a distance x."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from ..framework.protocol import Array
from .bending import Curve
from .cross_section import CrossSection
from .parameters import Real

POINTS = 24

Six = tuple[Real, Real, Real, Real, Real, Real]


@dataclass(frozen=True, eq=False)
class Uniform:
    """One section all along: the integrals are polynomials.

    Parameters
    ----------
    section
        Strain and curvature per unit ``N Vy Vz T My Mz``, six of shape (...).
    """

    section: Six

    def bar(self, component: int, x: Real, length: Real) -> Real:
        """Integral of the flexibility, (...)."""
        return self.section[component] * x

    def centre(self, bending: int, length: Real) -> Real:
        """Distance of the elastic centre from the start, (...)."""
        return 0.5 * length

    def curve(self, bending: int, shearing: int, x: Real, length: Real, centre: Real) -> Curve:
        """Deflection curve at x for the moment about `centre`."""
        turn = self.section[bending] * x
        return Curve(
            turn,
            turn * (0.5 * x - centre),
            turn * x * 0.5,
            turn * x * (x / 6.0 - 0.5 * centre) - self.section[shearing] * x,
        )


@dataclass(frozen=True, eq=False)
class Tapered:
    """Sizes linear from `start` to `end`: Gauss quadrature on points spread geometrically.

    With ``x ~ expm1(g t) / expm1(g)`` a size that is linear in x and grows by exp(g) is
    exponential in t: its powers are entire functions, which Gauss's rule integrates to rounding
    even where the member comes close to a point. The quadrature axis leads.

    Parameters
    ----------
    start, end
        Sections at the two ends.
    section
        Function of the fraction of the length, giving the six flexibilities.
    """

    start: CrossSection
    end: CrossSection
    section: Callable[[Real], Six]

    def bar(self, component: int, x: Real, length: Real) -> Real:
        """Integral of the flexibility, (...)."""
        xi, weight = self._points(x, length)
        return np.asarray(np.sum(weight * self.section(xi / length)[component], axis=0))

    def centre(self, bending: int, length: Real) -> Real:
        """Distance of the elastic centre from the start, (...)."""
        xi, weight = self._points(length, length)
        turn = weight * self.section(xi / length)[bending]
        return np.asarray(np.sum(turn * xi, axis=0) / np.sum(turn, axis=0))

    def curve(self, bending: int, shearing: int, x: Real, length: Real, centre: Real) -> Curve:
        """Deflection curve at x for the moment about `centre`."""
        xi, weight = self._points(x, length)
        flexibility = self.section(xi / length)
        turn = weight * flexibility[bending]
        arm, lever = xi - centre, x - xi
        return Curve(
            np.asarray(np.sum(turn, axis=0)),
            np.asarray(np.sum(turn * arm, axis=0)),
            np.asarray(np.sum(turn * lever, axis=0)),
            np.asarray(np.sum(turn * lever * arm - weight * flexibility[shearing], axis=0)),
        )

    def _points(self, x: Real, length: Real) -> tuple[Array, Array]:
        """Distances and weights of a rule on (0, x), (POINTS, ...)."""
        nodes, weights = gauss(POINTS)
        there = self.start.between(self.end, np.asarray(x / length))
        growth = np.log(there.Iy / self.start.Iy * (there.Iz / self.start.Iz)) / 8.0
        # an even spread is the limit of no growth, reached well before this
        growth = np.where(growth == 0.0, 1e-200, growth)
        lead = (POINTS,) + (1,) * max(np.ndim(growth), np.ndim(x), np.ndim(length))
        t, w = nodes.reshape(lead), weights.reshape(lead)
        return x * np.expm1(growth * t) / np.expm1(growth), x * w * growth * np.exp(growth * t) / np.expm1(growth)


@cache
def gauss(count: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on (0, 1)."""
    nodes, weights = np.polynomial.legendre.leggauss(count)
    return 0.5 * (nodes + 1.0), 0.5 * weights
