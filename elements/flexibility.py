"""Integrals of the section's flexibility over a part of a member, from its start.

Distances are fractions of the length, so that members of one taper and many lengths share the
integrals, and each length only scales them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..framework.protocol import Array
from ..framework.shape_rules import gauss
from .bending import Curve
from .cross_section import CrossSection
from .parameters import Real

# Number of quadrature points: enough to integrate a taper to a thousandth of the size to rounding.
POINTS = 32

Six = tuple[Real, Real, Real, Real, Real, Real]


@dataclass(frozen=True, eq=False)
class UniformPart:
    """Part of a prismatic member from its start to `fraction` of its length; the integrals are polynomials.

    Parameters
    ----------
    fraction
        Fraction of the length, (...).
    section
        Strain and curvature per unit ``N Vy Vz T My Mz``, six of shape (...).
    """

    fraction: Real
    section: Six

    def bar(self, component: int, length: Real) -> Real:
        """Elongation per unit force (component 0) or twist per unit torque (component 3) of the part, (...)."""
        return self.section[component] * self.fraction * length

    def bends(self, bending: int, shearing: int, length: Real) -> tuple[Real, Real, Real, Real]:
        """Distances of the elastic centre from both ends of the member, (...), as fractions, and of `curve` about it
        rotation by a moment, deflection by a slope."""
        p, turn = self.fraction, self.section[bending] * self.fraction * length
        centre = 0.5 * p
        away = turn * length * length * p * (p / 6.0 - 0.5 * centre) - self.section[shearing] * p * length
        return centre, 1.0 - centre, turn, away

    def curve(self, bending: int, shearing: int, centre: Real, length: Real) -> Curve:
        """Rotation and deflection at the end of the part, for the moment about the fraction `centre`."""
        p, turn = self.fraction, self.section[bending] * self.fraction * length
        return Curve(
            turn,
            turn * length * (0.5 * p - centre),
            turn * length * p * 0.5,
            turn * length * length * p * (p / 6.0 - 0.5 * centre) - self.section[shearing] * p * length,
        )


@dataclass(frozen=True, eq=False)
class TaperedPart:
    """Part of a tapered member from its start to `fraction` of its length; integrals by quadrature.

    Parameters
    ----------
    fraction
        Fraction of the length, (...).
    points, weights
        Quadrature points as fractions of the member's length, and weights, (points, ...).
    rests
        The points as fractions from the member's end, to all digits; None where they are what points leave of 1.
    section
        Strain and curvature per unit ``N Vy Vz T My Mz`` at the points, six of shape (points, ...).
    """

    fraction: Real
    points: Array
    weights: Array
    section: Six
    rests: Array | None = None

    def bar(self, component: int, length: Real) -> Real:
        """Elongation per unit force (component 0) or twist per unit torque (component 3) of the part, (...)."""
        return np.asarray(np.sum(self.weights * self.section[component], axis=0) * length)

    def bends(self, bending: int, shearing: int, length: Real) -> tuple[Real, Real, Real, Real]:
        """Distances of the elastic centre from both ends of the member, (...), as fractions, and of `curve` about it
        rotation by a moment, deflection by a slope."""
        turn = self.weights * self.section[bending]
        total = np.sum(turn, axis=0)
        centre = np.asarray(np.sum(turn * self.points, axis=0) / total)
        # about the elastic centre the lever to the end counts as minus the arm, with which nothing cancels: next to a
        # thin end the arm is far shorter than the lever, and than the distance from the other end
        rest, arm = np.asarray(1.0 - centre), self.points - centre
        if self.rests is not None:
            rest = np.asarray(np.sum(turn * self.rests, axis=0) / total)
            arm = np.where(centre <= rest, arm, rest - self.rests)
        away = np.sum(turn * arm**2, axis=0) * length * length * length
        slide = np.sum(self.weights * self.section[shearing], axis=0) * length
        return centre, rest, np.asarray(total * length), np.asarray(-away - slide)

    def curve(self, bending: int, shearing: int, centre: Real, length: Real) -> Curve:
        """Rotation and deflection at the end of the part, for the moment about the fraction `centre`."""
        turn, slide = self.weights * self.section[bending], self.weights * self.section[shearing]
        arm, lever = self.points - centre, self.fraction - self.points
        return Curve(
            np.sum(turn, axis=0) * length,
            np.sum(turn * arm, axis=0) * length * length,
            np.sum(turn * lever, axis=0) * length * length,
            np.sum(turn * lever * arm, axis=0) * length * length * length - np.sum(slide, axis=0) * length,
        )


Part = UniformPart | TaperedPart


def tapered_part(
    start: CrossSection,
    end: CrossSection,
    section: Callable[[Real, Real | None], Six],
    fraction: Real,
    ndim: int,
    *,
    hinged: bool = False,
) -> TaperedPart:
    """Part, up to `fraction`, of a member whose sizes vary linearly from section `start` to `end`.

    ``section(fraction, rest)`` gives the six flexibilities there. The quadrature points have at least `ndim` axes after
    the leading one. Of a whole member that is `hinged`, distances from its end have all digits; of others the arms are
    those of its parts, with which they cancel.
    """
    points, rests, weights = _spread_points(start, start.between(end, fraction), ndim)
    points, weights = fraction * points, fraction * weights
    left = rests if hinged else None
    return TaperedPart(fraction, points, weights, section(points, left), left)


def spread_points(start: CrossSection, end: CrossSection, ndim: int = 0) -> tuple[Array, Array]:
    """Gauss's rule on (0, 1), its points (points, ...) graded geometrically towards the end where a size is small.

    After the leading axis come those of the sections, at least `ndim`.
    """
    points, _, weights = _spread_points(start, end, ndim)
    return points, weights


def _spread_points(start: CrossSection, end: CrossSection, ndim: int) -> tuple[Array, Array, Array]:
    """Points and weights of `spread_points`, and between them how far each point is from 1.

    With ``x = expm1(g t) / expm1(g)`` a size that is linear in x and grows by exp(g) is
    exponential in t: its powers are entire functions, which Gauss's rule in t integrates to
    rounding even where the member comes close to a point. Where one size grows and another
    shrinks, each half has a rule of its own.
    """
    here, there = start.sizes(), end.sizes()
    shape = np.broadcast_shapes(start.shape, end.shape)
    ratios = np.stack([np.broadcast_to(there[name] / here[name], shape) for name in here])
    grows, shrinks = np.maximum(ratios.max(axis=0), 1.0), np.maximum(1.0 / ratios.min(axis=0), 1.0)
    if not (np.any(grows > 1.0) and np.any(shrinks > 1.0)):
        return _spread(np.log(grows / shrinks), ndim)
    # over half of the length a size grows by half of its whole growth
    points, _, weights = _spread(np.log1p(0.5 * (grows - 1.0)), ndim)
    others, _, theirs = _spread(np.log1p(0.5 * (shrinks - 1.0)), ndim)
    return (
        0.5 * np.concatenate([points, 2.0 - others]),
        0.5 * np.concatenate([2.0 - points, others]),
        0.5 * np.concatenate([weights, theirs]),
    )


def _spread(growth: Array, ndim: int) -> tuple[Array, Array, Array]:
    """Gauss's rule on (0, 1), (POINTS, ...), graded towards the start for a `growth` above zero.

    Points, their distances from 1, weights.
    """
    # without growth the plain rule is the limit, to which this tiny growth comes to the last bit
    growth = np.where(growth == 0.0, 1e-200, growth)
    t, w = (part.reshape((POINTS,) + (1,) * max(growth.ndim, ndim)) for part in gauss(POINTS))
    span = np.expm1(growth)
    rests = np.expm1(-growth * (1.0 - t)) / np.expm1(-growth)
    return np.expm1(growth * t) / span, rests, w * growth * np.exp(growth * t) / span
