"""Limit points: where the load factor turns back between the points of a path that was followed by arc length.

There the change of the load factor by arc length goes through zero. A step at whose ends it has other signs holds such
a point; so may one whose cubic, by load factors and their changes at both ends, turns back and forth, and that is cut
in two where this cubic falls most. The zeros of all paths are then found together, by false position, each by points of
equilibrium of its own at steps from the beginning of its step.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..batch import Array
from ..continuation import Zeros
from .arc_length import MOST, ArcLength, ArcPoint
from .newton import Newton
from .state import Index, Mask, StateOfEntries

# How near a limit is to be to the true one, and by how much the load factor turns back at least, as shares of it: once
# by the signs of its change, and twice by a cubic, which holds the rounding of the load factors themselves.
_CLOSE, _LEAST, _LEAST_TWICE = 1e-14, 1e-11, 1e-9
# How often steps are cut in two at most, and how many points are tried for a zero: the first by false position, and
# then in the middle, as where something is met at once the change jumps.
_CUTS, _ROUNDS, _SMOOTH = 8, 70, 20


@dataclass(frozen=True, eq=False)
class Track:
    """Points of the paths of some entries of a model, and the steps between them.

    Attributes
    ----------
    newton
        Newton's method on the model.
    index
        Which entries of the flattened batch these paths are of; all arrays have all entries of the model.
    states, factors
        By point.
    slopes, lengths
        By step: change of the load factor by arc length where it begins, NaN where it is not one by arc length; how
        long it is.
    ends
        By step: the change of the load factor where it ends, by the length along the tangent where it begins.
    """

    newton: Newton
    index: Index
    states: list[StateOfEntries]
    factors: list[Array]
    slopes: list[Array]
    lengths: list[Array]
    ends: list[Array]

    def limits(self) -> Limits:
        """All limit points, in the order of entries and along their paths."""
        turning, unclear = _turning(self, _steps(self))
        value, found = _values(self, turning)
        parts = turning.joined(unclear)
        order = np.lexsort((parts.begin[0], parts.step, parts.entry))
        found = np.concatenate([found, np.zeros(len(unclear.entry), dtype=bool)])
        # a step in which one is not found may have led to another path, and then the others are not on this one
        number = np.stack([parts.entry, parts.step])
        found &= ~(number[:, :, None] == number[:, None, ~found]).all(axis=0).any(axis=1)
        value = np.where(found, np.concatenate([value, np.zeros(len(unclear.entry))]), np.nan)
        return Limits(parts.entry[order], value[order], np.stack([parts.begin[1], parts.end[1]])[:, order])


class Limits(NamedTuple):
    """Limit points: of which entry, the load factor (n,), NaN where it was not found, and those beside it (2, n)."""

    entry: Index
    factor: Array
    between: Array


class _Parts(NamedTuple):
    """Parts of steps: entry and number of the step; length along it, load factor and its change at both ends (3, n)."""

    entry: Index
    step: Index
    begin: Array
    end: Array

    def taken(self, which: Mask) -> _Parts:
        """Some of them."""
        return _Parts(self.entry[which], self.step[which], self.begin[:, which], self.end[:, which])

    def joined(self, other: _Parts) -> _Parts:
        """These and others."""
        return _Parts(*(np.concatenate(pair, axis=-1) for pair in zip(self, other, strict=True)))

    @property
    def turn(self) -> Mask:
        """Where the load factor turns back, by more than rounding."""
        height = np.maximum(np.abs(self.begin[2]), np.abs(self.end[2])) * (self.end[0] - self.begin[0])
        return np.asarray((self.begin[2] * self.end[2] < 0.0) & (height > _LEAST * self.level))

    @property
    def level(self) -> Array:
        """Size of the load factor."""
        out: Array = np.maximum(np.abs(self.begin[1]), np.abs(self.end[1]))
        return out

    def dips(self) -> tuple[Mask, Array]:
        """Where the cubic by both ends turns twice, and where it falls most between."""
        width = self.end[0] - self.begin[0]
        rise, first, last = (self.end[1] - self.begin[1]) / width, self.begin[2], self.end[2]
        linear, square = 2.0 * (3.0 * rise - 2.0 * first - last), 3.0 * (first + last - 2.0 * rise)
        with np.errstate(divide="ignore", invalid="ignore"):
            place = -0.5 * linear / square
            least = first + 0.5 * linear * place
            twice = (first * last > 0.0) & (place > 0.0) & (place < 1.0) & (least * first < 0.0)
            twice &= np.abs(least) * width > _LEAST_TWICE * self.level
        return np.asarray(twice), self.begin[0] + np.where(twice, place, 0.5) * width


class _Points:
    """Points of equilibrium on parts of steps."""

    def __init__(self, track: Track, parts: _Parts) -> None:
        newton, entry, step = track.newton, parts.entry, parts.step
        self.arc = ArcLength(newton, newton.model.where(entry), len(entry))
        state, factor = track.states[0].taken(entry), np.stack(track.factors)[step, entry]
        for k in np.unique(step).tolist():
            here = np.flatnonzero(step == k)
            state.put(here, track.states[k].taken(entry[here]))
        ahead, slope = self.arc.tangent(state, factor)
        sign = np.where(np.stack(track.slopes)[step, entry] < 0.0, -1.0, 1.0)
        self.begin = ArcPoint(state, factor, sign * ahead, sign * slope)

    def at(self, place: Array, which: Mask) -> Array:
        """Points (3, n) as parts have them at their ends, at lengths `place` (n,) along steps; NaN where none is."""
        found = self.arc.corrected(self.begin, place, np.flatnonzero(which))
        ahead, slope = self.arc.tangent(found.state, found.factor)
        good = which & (found.iterations <= MOST)
        across = np.where(good, self.arc.inner(ahead, self.begin.along), np.nan)
        return np.where(good, np.stack([place, found.factor, slope / across]), np.nan)


def _steps(track: Track) -> _Parts:
    """All steps by arc length."""
    if not track.slopes:
        none = np.zeros(0, dtype=np.int64)
        return _Parts(none, none, np.zeros((3, 0)), np.zeros((3, 0)))
    factors, slopes, ends = np.stack(track.factors), np.stack(track.slopes), np.stack(track.ends)
    step, entry = np.nonzero(np.isfinite(factors[1:]) & np.isfinite(slopes) & np.isfinite(ends))
    begin = np.stack([np.zeros(len(step)), factors[step, entry], slopes[step, entry]])
    end = np.stack([np.stack(track.lengths)[step, entry], factors[step + 1, entry], ends[step, entry]])
    return _Parts(entry, step, begin, end)


def _turning(track: Track, parts: _Parts) -> tuple[_Parts, _Parts]:
    """Parts in which the load factor turns back once, and those of which that could not be told."""
    turning, unclear = parts.taken(parts.turn), parts.taken(np.zeros(len(parts.entry), dtype=bool))
    for _ in range(_CUTS):
        twice, place = parts.dips()
        if not twice.any():
            return turning, unclear
        parts = parts.taken(twice)
        middle = _Points(track, parts).at(place[twice], np.ones(len(parts.entry), dtype=bool))
        lost = np.isnan(middle[2])
        unclear, parts, middle = unclear.joined(parts.taken(lost)), parts.taken(~lost), middle[:, ~lost]
        parts = parts._replace(end=middle).joined(parts._replace(begin=middle))
        turning = turning.joined(parts.taken(parts.turn))
    return turning, unclear.joined(parts.taken(parts.dips()[0]))


def _values(track: Track, parts: _Parts) -> tuple[Array, Mask]:
    """Load factors where it turns back (n,), and whether they are as near to that as they are to be."""
    found = np.zeros(len(parts.entry), dtype=bool)
    if not len(found):
        return np.zeros(0), found
    points, level = _Points(track, parts), parts.level
    zeros = Zeros(parts.begin, parts.end)
    for tried in range(_ROUNDS):
        best = np.where(np.abs(zeros.left[2]) < np.abs(zeros.right[2]), zeros.left, zeros.right)
        # the load factor is nowhere steeper between the zero and the nearer point than it is there
        found = np.abs(best[2]) * (zeros.right[0] - zeros.left[0]) <= _CLOSE * level
        if found.all():
            break
        place = zeros.place() if tried < _SMOOTH else 0.5 * (zeros.left[0] + zeros.right[0])
        zeros.narrow(points.at(place, ~found), ~found)
    return best[1], found & ~_jumps(zeros, level)


def _jumps(zeros: Zeros, level: Array) -> Mask:
    """Whether load factors on both sides differ by more than they can on one path."""
    width, steepest = zeros.right[0] - zeros.left[0], np.abs(zeros.left[2]) + np.abs(zeros.right[2])
    return np.asarray(np.abs(zeros.right[1] - zeros.left[1]) > 2.0 * steepest * width + 1e4 * _CLOSE * level)
