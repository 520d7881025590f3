"""The path of a linkage with one drive released: through dead points, which are nothing special on it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....framework.batch import Array
from ....framework.continuation import follow
from ....framework.errors import FrameError
from ..continuation.interpolation import SIDES, weights
from .configuration import ALIKE, DEPENDENT, FEW_DIGITS, Configurations, null_space
from .sparse_steps import SparseSteps

STEP = 0.05
SHORTEST = 1e-6
LONGEST_WAY = 6000
NEWTON = 30
# How far apart the states beside a change point are that tell where it is.
BESIDE = 0.005
# How many times as far apart where the place is known by one step of Newton's method only, and how far it may be.
FEW, FAR = 3.0, 3.0 * STEP
# Step of the differences from which the slope of a singular value is taken.
DIFFERENCE = 1e-5
# Singular values below this share of the largest vanish where curves cross, as far as a place there is known.
CROSSING = 1e-5
# Where Newton's method has found a singular value's zero.
ZERO = 1e-11
# The same of a place that is taken from those on both sides.
BETWEEN = 1e-8


@dataclass(frozen=True, eq=False)
class PathPoint:
    """A state on the path, and its tangent: unit rate of the joint coordinates, (n,).

    `entries` are those of the Jacobian there, as `SparseSteps` has them, where it led there.
    """

    state: Array
    tangent: Array
    entries: Array | None = None

    def reversed(self, sign: float) -> PathPoint:
        """The same place, looking the other way where `sign` is -1."""
        return PathPoint(self.state, sign * self.tangent)


Name = tuple[str, str]


@dataclass(frozen=True, eq=False)
class TracedPath:
    """Places in their order; whether the last is where the first was, or the one beyond which no way was found."""

    places: list[PathPoint]
    closes: bool
    stalled: bool = False


class MotionPath:
    """Connected assembled positions when one joint coordinate drives and other drives are locked.

    Parameters
    ----------
    space
        All assembled positions.
    drive
        Joint and component of the coordinate that drives.
    locked
        Those that stand still.
    """

    def __init__(self, space: Configurations, drive: Name, locked: Sequence[Name] = ()) -> None:
        self.space, self.name = space, drive
        self.drive = space.mechanism.columns.index(drive)
        self.locked = tuple(space.mechanism.columns.index(name) for name in locked)

    @property
    def unit(self) -> float:
        """What the driving coordinate is counted in: the mechanism's size, or one radian."""
        return self.space.mechanism.size if self.name[1][0] == "u" else 1.0

    def coordinate(self, state: Array) -> float:
        """Value of the driving coordinate."""
        joint, component = self.name
        mechanism = self.space.mechanism
        pair = mechanism.linkage.joint(joint)
        offset = pair.kind.coordinates.index(component)
        return float(
            self.space.of_entry(pair.reference[..., offset]) + self.unit * state[mechanism.states[joint].start + offset]
        )

    @cached_property
    def start(self) -> PathPoint:
        """The reference configuration."""
        free = self.space.free(self.space.reference_state, self.locked)
        if not free.shape[1]:
            alike = null_space(self.space.locked_equations(self.space.reference_state, self.locked), share=ALIKE)
            few = f"; {FEW_DIGITS}" if alike.shape[1] else ""
            least_values = ", with the other drives locked" if self.locked else ""
            raise FrameError(
                f"joint {self.name[0]!r} cannot move: the linkage has no degree of freedom{least_values}{few}"
            )
        # Of all motions that with the most of the drive: idle degrees of freedom rest in it.
        tangent = free @ free[self.drive]
        if np.linalg.norm(tangent) < 1e-9:
            tangent = free[:, 0]
        return PathPoint(self.space.reference_state, tangent / np.linalg.norm(tangent))

    @cached_property
    def sparse(self) -> SparseSteps | None:
        """Steps at a cost that grows with the linkage only, where one motion alone is possible."""
        steps = SparseSteps(self.space, self.drive, self.locked)
        alone = self.space.free(self.start.state, self.locked).shape[1] == 1
        return steps if steps.regular and alone and not self.space.tolerance else None

    def stepped(self, place: PathPoint, step: float) -> PathPoint | None:
        """As `onwards`, to fewer digits where that is quicker."""
        found = self.sparse and self.sparse.onwards(place.state, place.tangent, step)
        return PathPoint(found.state, found.tangent, found.entries) if found else self.onwards(place, step)

    def near_singular(self, places: list[PathPoint]) -> list[PathPoint]:
        """Places one behind the other beside which something may move with the drive held."""
        if self.sparse is not None:
            entries = [self.sparse.at(x.state)[1] if x.entries is None else x.entries for x in places]
            return [places[k] for k in self.sparse.near_zero(np.array(entries))]
        values = np.array([np.linalg.svd(self.locked_equations(place.state), compute_uv=False) for place in places])
        least = values[:, self.rank - 1] / values[:, 0]
        framed = np.concatenate([[np.inf], least, [np.inf]])
        near = (least <= framed[:-2]) & (least <= framed[2:]) & (least < 0.5)
        return [places[k] for k in np.flatnonzero(near)]

    def onwards(self, place: PathPoint, step: float) -> PathPoint | None:
        """The place a step further along the tangent; None where none is found."""
        aim = self.space.advanced(place.state, step * place.tangent)
        state = self.space.closed(aim, self.locked)
        if state is None:
            return None
        free = self.space.free(state, self.locked)
        tangent = free @ (free.T @ place.tangent)
        size = np.linalg.norm(tangent)
        return None if size < 0.7 else PathPoint(state, tangent / size)

    def traced_both_ways(self) -> list[PathPoint]:
        """Places of the whole path through the reference configuration."""
        traced = self.trace(self.start)
        back = [] if traced.closes else self.trace(self.start.reversed(-1.0)).places[:0:-1]
        return [*back, *traced.places]

    def trace(self, place: PathPoint, until: Callable[[PathPoint], bool] | None = None) -> TracedPath:
        """Places one behind the other, until the path closes, ends, or gets too long, or to the first that is
        wanted."""
        trace = _Trace(self, place, until)
        arrived = follow(trace.attempt, trace.accept, STEP, SHORTEST)
        if not arrived:
            self._refuse_few_digits(trace.places[-1])
        return TracedPath(trace.places, trace.closes, stalled=not arrived)

    def _refuse_few_digits(self, place: PathPoint) -> None:
        """Refuse where a path has stalled because the linkage is described with too few digits to go on."""
        aim = self.space.advanced(place.state, STEP * place.tangent)
        if self.space.closed(aim, self.locked, ALIKE) is not None:
            at = self.coordinate(place.state)
            raise FrameError(f"joint {self.name[0]!r} cannot move beyond {at:.6g}: {FEW_DIGITS}")

    def link_places(self, place: PathPoint) -> Array:
        """Where the links are, but for those that turn by themselves."""
        places = self.space.places(place.state)
        places[self._idle, 3:] = 0.0
        return places

    @cached_property
    def _idle(self) -> list[int]:
        names = list(self.space.mechanism.linkage.links)
        return [names.index(name) for name in self.space.idle(self.space.reference_state)]

    # -- singular places --------------------------------------------------------------------------------------------

    def locked_equations(self, state: Array) -> Array:
        """Equations with the drive and the locked columns standing still, (m + l, n)."""
        return self.space.locked_equations(state, (*self.locked, self.drive))

    @cached_property
    def rank(self) -> int:
        """Rank of the equations with the drive locked, in general: the highest of some places."""
        near = (self.onwards(self.start, step) for step in (-STEP, 0.0, STEP))
        return max(_rank(self.locked_equations(place.state)) for place in near if place is not None)

    def singular_place(self, place: PathPoint) -> PathPoint | None:
        """Where, near `place`, a motion remains with the drive locked: the singular value number `rank` vanishes.

        The fold equations ``Φ = 0``, ``J v = 0``, ``|v| = 1``, J being the equations with the drive locked, are solved
        along the curve: with singular vectors u and v of J, ``u J v`` has a simple zero there, to which Newton's method
        goes. Where the curve crosses another one there, the place is taken from those on both sides.
        """
        found, first = self._by_newton(place)
        if found is not None and not self._crosses(found):
            return found
        return self._between(place, first) or found

    def _by_newton(self, place: PathPoint) -> tuple[PathPoint | None, float]:
        """The singular place, None where Newton's method does not lead to one; and the first step towards it."""
        gone, first = 0.0, np.inf
        for _ in range(NEWTON):
            left, values, right = np.linalg.svd(self.locked_equations(place.state))
            u, v = left[:, self.rank - 1], right[self.rank - 1]
            if values[self.rank - 1] < max(ZERO, 10.0 * self.space.tolerance):
                return place, first if np.isfinite(first) else 0.0
            sides = [self.space.advanced(place.state, sign * DIFFERENCE * place.tangent) for sign in (1.0, -1.0)]
            slope = float(u @ (self.locked_equations(sides[0]) - self.locked_equations(sides[1])) @ v) / (
                2.0 * DIFFERENCE
            )
            step = -values[self.rank - 1] / slope if slope else np.inf
            first = first if np.isfinite(first) else step
            gone += step
            found = self.onwards(place, step) if abs(gone) < FAR else None
            if found is None:
                return None, first
            place = found
        return None, first

    def _crosses(self, place: PathPoint) -> bool:
        """Whether other motions than that along the curve begin at a place, if only to about half the digits."""
        motions = null_space(self.space.locked_equations(place.state, self.locked), share=CROSSING).shape[1]
        return bool(motions > self.space.free(self.start.state, self.locked).shape[1])

    def _between(self, place: PathPoint, ahead: float) -> PathPoint | None:
        """The singular place about `ahead` of a place; None where nothing vanishes there.

        Places aside, where one curve alone is near, are smooth in the step that leads to them, as is the singular value
        once it has a sign: polynomials through them give the root, the state and the tangent. The second time they are
        taken nearer, so that the polynomials are exact to rounding.
        """
        for spacing in (FEW * BESIDE, BESIDE):
            steps = ahead + spacing * SIDES
            near = [self.onwards(place, step) for step in steps] if abs(ahead) < FAR else [None]
            around = [found for found in near if found is not None]
            if len(around) < len(near):
                return None
            signed = self._signed(around)
            if not signed[0] * signed[-1] < 0.0:
                return None
            middle = weights(signed, 0.0)
            state, tangent = middle @ [x.state for x in around], middle @ [x.tangent for x in around]
            place, ahead = PathPoint(self.space.unit(state), tangent / np.linalg.norm(tangent)), 0.0
        least = np.linalg.svd(self.locked_equations(place.state), compute_uv=False)[self.rank - 1]
        return place if least < max(BETWEEN, 10.0 * self.space.tolerance) else None

    def _signed(self, places: Sequence[PathPoint]) -> Array:
        """Least singular value with the drive locked at places one behind the other, with a sign that changes at
        zero."""
        out, sign, last = [], 1.0, None
        for place in places:
            left, values, right = np.linalg.svd(self.locked_equations(place.state))
            u, v = left[:, self.rank - 1], right[self.rank - 1]
            if last is not None:
                sign *= float(np.sign((u @ last[0]) * (v @ last[1])))
            last = u, v
            out.append(sign * values[self.rank - 1])
        return np.array(out)

    def crossing_value(self, place: PathPoint) -> float:
        """The driving coordinate at a change point near `place`.

        Where two branches cross, what the closure says of a state vanishes with its distance from the crossing. So the
        coordinate is taken as a polynomial of the singular value, which changes its sign there, through states aside.
        """
        steps = BESIDE * SIDES
        near = [(step, found) for step in steps if (found := self.onwards(place, step)) is not None]
        least_values = [
            np.linalg.svd(self.locked_equations(each.state), compute_uv=False)[self.rank - 1] for _, each in near
        ]
        abscissas = np.array([np.sign(step) * value for (step, _), value in zip(near, least_values, strict=True)])
        return float(weights(abscissas, 0.0) @ [self.coordinate(each.state) for _, each in near])


class _Trace:
    """Steps along a path by its length of arc, over which no link goes far at once.

    Attributes
    ----------
    places
        Places that were found, the first included.
    closes
        Whether the last is where the first was.
    """

    def __init__(self, path: MotionPath, place: PathPoint, until: Callable[[PathPoint], bool] | None) -> None:
        self.path, self.until = path, until
        self.places, self.closes = [place], False
        self._start = self._here = path.link_places(place)
        self._last, self._away = 0.0, False

    def attempt(self, step: float) -> tuple[PathPoint, Array] | None:
        """The place a step further, and where its links are."""
        found = self.path.stepped(self.places[-1], step)
        if found is None:
            return None
        there = self.path.link_places(found)
        return None if np.abs(there - self._here).max() > 4.0 * STEP else (found, there)

    def accept(self, point: tuple[PathPoint, Array], step: float) -> float | None:
        """Go on to a place, unless the path closes, is long enough, or the place is one that is wanted."""
        found, there = point
        moved, distance = np.abs(there - self._here).max(), np.abs(there - self._start).max()
        self.places.append(found)
        self.closes = bool(self._away and distance < max(moved, self._last))
        if self.closes or (self.until is not None and self.until(found)) or len(self.places) >= LONGEST_WAY:
            return None
        self._away = self._away or bool(distance > 4.0 * STEP)
        self._here, self._last = there, moved
        return min(STEP, 2.0 * step)


def _rank(matrix: Array) -> int:
    values = np.linalg.svd(matrix, compute_uv=False)
    return int(np.count_nonzero(values > DEPENDENT * values[0]))
