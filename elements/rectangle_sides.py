"""Greatest von Mises stress along the sides of a rectangle, of bending, shear and Saint-Venant torsion together."""

from __future__ import annotations

from functools import cache, lru_cache
from typing import NamedTuple

import numpy as np

from ..framework.protocol import Array
from .parameters import Real

# Sample points between a corner and the middle of a side: evenly spaced ones, and further ones near the corner. Numbers
# of terms: of a power series that is used up to sqrt(2) - 1, of series in exp(-pi n / 2), and in exp(-pi n), n odd.
EVEN, NEAR, POWERS, SLOW, FAST = 32, 12, 16, 10, 6
# Values of u (1 - s), see `long_side`, at which the torsional stress is half of, and nearly, that at mid-side.
HALF_WAY, NEARLY = 0.7, 7.0
# Batch entries that are evaluated together, so that they stay in the processor's cache.
BLOCK = 4096
OF_SERIES = 8.0 / np.pi**2
CATALAN = 0.915965594177219015054603514932384110774
# Ratio of the torsional stress in the middle of a strip's end face to that in the middle of its long side.
AT_SHORT = OF_SERIES * CATALAN
ROOT3 = np.sqrt(3.0)
SWITCH = np.sqrt(2.0) - 1.0
# Greatest of (1 - s^2)^2 / (1 - s) over s from 0 to 1, at s = 1/3.
PARABOLA = 32.0 / 27.0
# A side is skipped only if its stress stays below that in the corner by more than rounding.
SURELY = 1.0 + 1e-12


class Side(NamedTuple):
    """Sample points along half of a side, from its middle, s = 0, to its end, s = 1.

    Attributes
    ----------
    place
        Coordinates s, (k, ...).
    torsion
        Ratio of the torsional shear stress at s to that at mid-side, (k, ...).
    """

    place: Array
    torsion: Array


def raise_along(worst: Array, ratio: Real, normal: tuple[Real, Real, Real], shear: Real, twist: Real) -> Array:
    """Greatest von Mises stress along two opposite sides, or `worst` where that is greater.

    Parameters
    ----------
    worst
        Greatest von Mises stress so far, which includes corners and mid-sides, (...).
    ratio
        Ratio of the length of these sides to that of the other two, (...).
    normal
        Normal stress by the axial force, by bending that is constant along the side, and by bending that varies along
        it, at its end, (...) each.
    shear, twist
        Shear stress at mid-side by the shear force and by torsion, (...).

    Returns
    -------
    ndarray
        Greatest von Mises stress, force per area, (...).
    """
    axial, across, along = normal
    # A single one of the three is greatest in a corner or at mid-side.
    if sum(bool(np.any(each)) for each in (along, shear, twist)) < 2:
        return worst
    signs = np.sign(axial) * np.sign(across) * np.sign(shear) * np.sign(twist)
    more, less = np.abs(axial) + np.abs(across), np.abs(np.abs(axial) - np.abs(across))
    along, shear, twist = np.abs(along), np.abs(shear), np.abs(twist)
    several = ((along > 0.0) & ((shear > 0.0) | (twist > 0.0))) | ((shear > 0.0) & (twist > 0.0))
    # An upper bound on torsion(s) / sqrt(1 - s).
    steepest = np.sqrt(1.42 + 0.78 * np.asarray(ratio))
    steep = ROOT3 * (np.sqrt(PARABOLA) * shear + steepest * twist)
    wanted = several & (SURELY * steep > np.sqrt(along) * np.sqrt(2.0 * more + along))
    kept = wanted & np.isfinite(worst)
    if not kept.any():
        return worst

    def of(values: Real) -> Array:
        array = np.asarray(values)
        return array if array.ndim == 0 else np.broadcast_to(array, worst.shape)[kept]

    # Stresses are divided by the greatest so far, so that squares do not overflow.
    so_far = worst[kept]
    bent, level, lower = of(along) / so_far, of(more) / so_far, of(less) / so_far
    sheared, turned = ROOT3 * of(shear) / so_far, ROOT3 * of(twist) / so_far
    # The greater normal stress and the greater shear stress may occur on the same side or on opposite sides.
    opposed, lengths = np.broadcast_to(of(signs) < 0.0, so_far.shape), of(ratio)
    signed = np.where(opposed, -turned, turned)
    for start in range(0, so_far.size, BLOCK):
        some = slice(start, start + BLOCK)
        pairs = [(level[some], signed[some])]
        if opposed[some].any():
            pairs.append((lower[some], turned[some]))
        side = _one_side(float(lengths)) if lengths.ndim == 0 else side_of(lengths[some])
        so_far[some] *= np.sqrt(_highest(side, bent[some], sheared[some], pairs))
    raised = worst.copy()
    raised[kept] = so_far
    return raised


def _highest(side: Side, bent: Array, sheared: Array, pairs: list[tuple[Array, Array]]) -> Array:
    """Greatest square of the von Mises stress over the points of a side, at least one, (n,)."""
    found = np.ones_like(bent)
    for s, g in zip(side.place, side.torsion, strict=True):
        rise, force = bent * s, sheared * (1.0 - s * s)
        for level, torque in pairs:
            normal, shear = level + rise, force + torque * g
            np.maximum(found, normal * normal + shear * shear, out=found)
    return found


def side_of(ratio: Array) -> Side:
    """Sample points and torsional stress of a side that is `ratio` times as long as the other.

    Parameters
    ----------
    ratio
        Ratio of the lengths of the sides, above zero, (n,).

    Returns
    -------
    Side
        Sample points and torsional stress there, (k, n) each.
    """
    long, short = long_side(np.maximum(ratio, 1.0)), short_side(np.maximum(1.0 / ratio, 1.0))
    return Side(*(np.where(ratio >= 1.0, one, other) for one, other in zip(long, short, strict=True)))


@lru_cache(maxsize=64)
def _one_side(ratio: float) -> Side:
    return Side(*(each[:, 0] for each in side_of(np.array([ratio]))))


def long_side(ratio: Array) -> Side:
    """A side that is `ratio` >= 1 times as long as the other, with more sample points near its end.

    The sum ``1 - 8 / pi^2 sum_odd cosh(n u s) / (n^2 cosh(n u))`` with ``u = pi ratio / 2`` is split into its slow part
    ``exp(-n u (1 - s))``, which is Legendre's chi function, and terms that fall as ``exp(-n u)``.
    """
    u = 0.5 * np.pi * np.asarray(ratio)
    off = _off(u)
    place = 1.0 - off
    torsion = (_beside_end(u * off) - OF_SERIES * _far_end(u, place)) / (1.0 - OF_SERIES * _middle(u))
    return Side(place, torsion)


def short_side(ratio: Array) -> Side:
    """The shorter side, where the other is `ratio` >= 1 times as long.

    The sum ``sum_odd (-1)^((n - 1) / 2) / n^2 tanh(n pi ratio / 2) cos(n pi s / 2)``, in which the part ``tanh -> 1``,
    independent of the ratio, is summed in closed form.
    """
    ratio = np.asarray(ratio)
    shape = (-1, *(1 for _ in ratio.shape))
    off, endless = _short_places()
    sums, middle = endless[1:].reshape(shape), endless[0]
    for n in range(1, 2 * FAST, 2):
        e = np.exp(-np.pi * n * ratio)
        part = 2.0 * e / (1.0 + e) / n**2
        sums = sums - part * np.sin(0.5 * np.pi * n * off).reshape(shape)
        middle = middle - (2.0 - n % 4) * part
    return Side(1.0 - off.reshape(shape), sums / middle)


def _off(u: Array) -> Array:
    """Distances 1 - s of the sample points from the end, (k, ...): evenly spaced ones, and a geometric series.

    The series covers the range near the end in which the torsional stress rises to nearly that at mid-side, and at
    least that up to the first of the even points.
    """
    farthest = np.maximum(1.0 / EVEN, np.minimum(0.2, NEARLY / u))
    nearest = np.minimum(0.2 * farthest, HALF_WAY / u)
    one_each = (-1, *(1 for _ in u.shape))
    share = ((np.arange(NEAR) + 0.5) / NEAR).reshape(one_each)
    even = (np.arange(1.0, EVEN) / EVEN).reshape(one_each)
    return np.concatenate([nearest ** (1.0 - share) * farthest**share, np.broadcast_to(even, (EVEN - 1, *u.shape))])


def _beside_end(x: Array) -> Array:
    """``1 - 8 / pi^2 sum_odd exp(-n x) / n^2`` for x > 0.

    By Landen's identity ``chi(exp(-x)) + chi(tanh(x / 2)) = pi^2 / 8 + x / 2 log(tanh(x / 2))``.
    """
    q, w = np.exp(-x), np.tanh(0.5 * x)
    near = q > SWITCH
    z = np.where(near, w, q)
    square, total = z * z, np.zeros_like(z)
    for n in range(2 * POWERS - 1, 0, -2):
        total = total * square + 1.0 / n**2
    chi = OF_SERIES * z * total
    return np.where(near, chi - 0.5 * OF_SERIES * x * np.log(w), 1.0 - chi)


def _far_end(u: Array, place: Array) -> Array:
    """Sum over odd n of ``(cosh(n u s) / cosh(n u) - exp(-n u (1 - s))) / n^2``."""
    first, second, both = np.exp(-u * (1.0 + place)), np.exp(-u * (3.0 - place)), np.exp(-2.0 * u)
    total, one, two = np.zeros_like(first), first, second
    for n in range(1, 2 * SLOW, 2):
        total += (one - two) / ((1.0 + both**n) * n**2)
        one, two = one * (first * first), two * (second * second)
    return total


def _middle(u: Array) -> Array:
    """Sum over odd n of ``1 / (n^2 cosh(n u))``."""
    e = np.exp(-u)
    return np.asarray(sum(2.0 * e**n / ((1.0 + e ** (2 * n)) * n**2) for n in range(1, 2 * SLOW + 4, 2)))


@cache
def _short_places() -> tuple[Array, Array]:
    """Distances ``1 - s`` from the end, (k,), and ``sum_odd sin(n t) / n^2`` at ``t = pi (1 - s) / 2``, (k + 1,), at
    mid-side first.

    It is ``-1/2`` of the integral of ``log(tan(t / 2))``, whose smooth part is integrated by Gauss's rule.
    """
    off = _off(np.asarray(0.5 * np.pi))
    t = 0.5 * np.pi * np.concatenate([[1.0], off])
    points, weights = np.polynomial.legendre.leggauss(24)
    half = 0.25 * t[:, None] * (1.0 + points)
    smooth = 0.5 * t * (np.log(np.tan(half) / half) @ weights)
    return off, -0.5 * (t * np.log(0.5 * t) - t + smooth)
