"""The path of a linkage by arc length, with one drive released: dead points are regular points of it."""

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
# Distance, in extents of the linkage, from which on it is far away, and change of the tangent below which a path that
# has led there is a straight line, on which nothing changes any more.
AWAY, STRAIGHT = 10.0, 1e-9
# Spacing of the states on both sides of a change point from which it is interpolated.
BESIDE = 0.005
# Factor of that spacing if the place is known from one Newton step only, and largest distance of the place.
FEW, FAR = 3.0, 3.0 * STEP
# Distance from its start at which a path runs through it, dimensionless.
MET = 1e-7
# Step of the central difference for the derivative of a singular value.
DIFFERENCE = 1e-5
# Ratio to the largest singular value below which one counts as zero at a crossing, which is known to half the digits.
CROSSING = 1e-5
# Singular value that counts as zero, found by Newton's method.
ZERO = 1e-11
# Singular value that counts as zero, at an interpolated place.
BETWEEN = 1e-8


@dataclass(frozen=True, eq=False)
class PathPoint:
    """A state on the path, with its unit tangent in joint coordinates, (n,).

    `entries` are the Jacobian's entries there if `SparseSteps` found the state.
    """

    state: Array
    tangent: Array
    entries: Array | None = None

    def reversed(self, sign: float) -> PathPoint:
        """The same point with its tangent multiplied by `sign`."""
        return PathPoint(self.state, sign * self.tangent)


Name = tuple[str, str]


@dataclass(frozen=True, eq=False)
class TracedPath:
    """Points of a path in order; whether it closes, and whether it stalled at the last one."""

    places: list[PathPoint]
    closes: bool
    stalled: bool = False


class MotionPath:
    """Connected assembled positions, with one joint coordinate as the drive and other drives locked.

    Parameters
    ----------
    space
        The assembled positions.
    drive
        Joint and component of the driving coordinate.
    locked
        Joint and component of each locked coordinate.
    """

    def __init__(self, space: Configurations, drive: Name, locked: Sequence[Name] = ()) -> None:
        self.space, self.name = space, drive
        self.drive = space.mechanism.columns.index(drive)
        self.locked = tuple(space.mechanism.columns.index(name) for name in locked)

    @property
    def unit(self) -> float:
        """Unit of the driving coordinate: the mechanism's size, or one radian."""
        return self.space.size if self.name[1][0] == "u" else 1.0

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
        # the motion with the largest share of the drive, in which idle degrees of freedom rest
        tangent = free @ free[self.drive]
        if np.linalg.norm(tangent) < 1e-9:
            tangent = free[:, 0]
        return PathPoint(self.space.reference_state, tangent / np.linalg.norm(tangent))

    @cached_property
    def sparse(self) -> SparseSteps | None:
        """Steps with sparse matrices, if only one motion is possible."""
        steps = SparseSteps(self.space, self.drive, self.locked)
        alone = self.space.free(self.start.state, self.locked).shape[1] == 1
        return steps if steps.regular and alone and not self.space.tolerance else None

    def stepped(self, place: PathPoint, step: float) -> PathPoint | None:
        """`onwards` by sparse matrices if possible, which is quicker and accurate to fewer digits."""
        found = self.sparse and self.sparse.onwards(place.state, place.tangent, step)
        return PathPoint(found.state, found.tangent, found.entries) if found else self.onwards(place, step)

    def near_singular(self, places: list[PathPoint]) -> list[PathPoint]:
        """Those of successive points near which something may move with the drive locked."""
        if self.sparse is not None:
            entries = [self.sparse.at(x.state)[1] if x.entries is None else x.entries for x in places]
            return [places[k] for k in self.sparse.near_zero(np.array(entries))]
        values = np.array([np.linalg.svd(self.locked_equations(place.state), compute_uv=False) for place in places])
        least = values[:, self.rank - 1] / values[:, 0]
        framed = np.concatenate([[np.inf], least, [np.inf]])
        near = (least <= framed[:-2]) & (least <= framed[2:]) & (least < 0.5)
        return [places[k] for k in np.flatnonzero(near)]

    def onwards(self, place: PathPoint, step: float) -> PathPoint | None:
        """The point one step ahead along the tangent; None if none is found."""
        aim = self.space.advanced(place.state, step * place.tangent)
        state = self.space.closed(aim, self.locked)
        if state is None:
            return None
        free = self.space.free(state, self.locked)
        tangent = free @ (free.T @ place.tangent)
        size = np.linalg.norm(tangent)
        return None if size < 0.7 else PathPoint(state, tangent / size)

    def traced_both_ways(self) -> list[PathPoint]:
        """Points of the whole path through the reference configuration."""
        traced = self.trace(self.start)
        back = [] if traced.closes else self.trace(self.start.reversed(-1.0)).places[:0:-1]
        return [*back, *traced.places]

    def meets(self, place: PathPoint, start: Array) -> bool:
        """Whether the path near a point runs through the places `start` of the links, rather than past them.

        A link on a screw passes by at each turn, at the advance of that turn.
        """
        away, least = start - self.link_places(place), max(MET, 10.0 * self.space.tolerance)
        while (distance := np.abs(away).max()) > least:
            beside = self.stepped(place, DIFFERENCE)
            speed = None if beside is None else (self.link_places(beside) - self.link_places(place)) / DIFFERENCE
            nearer = None if speed is None else self.stepped(place, float(np.vdot(speed, away) / np.vdot(speed, speed)))
            if nearer is None:
                return True  # at a crossing, where the one is not told from the other
            place, away = nearer, start - self.link_places(nearer)
            if np.abs(away).max() > 0.5 * distance:
                return False
        return True

    def trace(self, place: PathPoint, until: Callable[[PathPoint], bool] | None = None) -> TracedPath:
        """Follow the path until it closes, stalls or gets too long, or to the first point for which `until` is true."""
        trace = _Trace(self, place, until)
        arrived = follow(trace.attempt, trace.accept, STEP, SHORTEST)
        if not arrived:
            self._refuse_few_digits(trace.places[-1])
        if trace.unfinished:
            self._refuse_unfinished(trace.places[-1])
        return TracedPath(trace.places, trace.closes, stalled=not arrived)

    def _refuse_few_digits(self, place: PathPoint) -> None:
        """Raise an error if the path has stalled because the linkage is described with too few digits."""
        aim = self.space.advanced(place.state, STEP * place.tangent)
        if self.space.closed(aim, self.locked, ALIKE) is not None:
            at = self.coordinate(place.state)
            raise FrameError(f"joint {self.name[0]!r} cannot move beyond {at:.6g}: {FEW_DIGITS}")

    def _refuse_unfinished(self, place: PathPoint) -> None:
        """Raise an error if a path is too long to follow, as that of a crank that climbs on a fine screw."""
        at = self.coordinate(place.state) - self.coordinate(self.start.state)
        far = f"{at / (2.0 * np.pi):+.4g} turns" if self.name[1][0] == "r" else f"{at:+.4g} of its way"
        raise FrameError(
            f"joint {self.name[0]!r} neither stops nor comes back in {far}, the {LONGEST_WAY} steps that are followed: "
            "its range and dead points are not known; move the linkage by values of the drive, whose status tells "
            "where it cannot go"
        )

    def link_places(self, place: PathPoint) -> Array:
        """Reference points and axes of the links, without the axes of spindles and of links that turn idly."""
        places = self.space.places(place.state)
        places[self._turning, 3:] = 0.0
        return places

    @cached_property
    def _turning(self) -> list[int]:
        names = list(self.space.mechanism.linkage.links)
        return [names.index(name) for name in (*self.space.idle(self.space.reference_state), *self.space.spindles)]

    # -- singular places --------------------------------------------------------------------------------------------

    def locked_equations(self, state: Array) -> Array:
        """Jacobian of the closing equations with the drive and the locked columns at rest, (m + l, n)."""
        return self.space.locked_equations(state, (*self.locked, self.drive))

    @cached_property
    def rank(self) -> int:
        """Generic rank of the equations with the drive locked: the largest at some points near the start."""
        near = (self.onwards(self.start, step) for step in (-STEP, 0.0, STEP))
        return max(_rank(self.locked_equations(place.state)) for place in near if place is not None)

    def singular_place(self, place: PathPoint) -> PathPoint | None:
        """The point near `place` where a motion remains with the drive locked: singular value number `rank` vanishes.

        The fold equations ``Φ = 0``, ``J v = 0``, ``|v| = 1``, with J the Jacobian with the drive locked, are solved
        along the curve: for singular vectors u and v of J, ``u J v`` has a simple zero there, which Newton's method
        finds. If the curve crosses another one there, the point is interpolated from both sides.
        """
        found, first = self._by_newton(place)
        if found is not None and not self._crosses(found):
            return found
        return self._between(place, first) or found

    def _by_newton(self, place: PathPoint) -> tuple[PathPoint | None, float]:
        """The singular point, None if Newton's method does not find one; and its first step."""
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
        """Whether another motion than that along the curve starts at a point, to half the digits."""
        motions = null_space(self.space.locked_equations(place.state, self.locked), share=CROSSING).shape[1]
        return bool(motions > self.space.free(self.start.state, self.locked).shape[1])

    def _between(self, place: PathPoint, ahead: float) -> PathPoint | None:
        """The singular point about `ahead` of a point, interpolated; None if no singular value vanishes there.

        On both sides of a crossing, states and the signed singular value are smooth functions of the step, so
        polynomials through them give the root, the state and the tangent. A second round with a smaller spacing makes
        the interpolation exact to rounding.
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
        """Singular value number `rank` with the drive locked at successive points, signed so as to cross zero."""
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

        Near a crossing of two branches the closing equations determine a state only poorly. So the coordinate is
        interpolated as a function of the signed singular value, from states on both sides.
        """
        steps = BESIDE * SIDES
        near = [(step, found) for step in steps if (found := self.onwards(place, step)) is not None]
        least_values = [
            np.linalg.svd(self.locked_equations(each.state), compute_uv=False)[self.rank - 1] for _, each in near
        ]
        abscissas = np.array([np.sign(step) * value for (step, _), value in zip(near, least_values, strict=True)])
        return float(weights(abscissas, 0.0) @ [self.coordinate(each.state) for _, each in near])


class _Trace:
    """Steps along a path by its arc length, in none of which a link moves far.

    Attributes
    ----------
    places
        Points of the path, from the first on.
    closes
        Whether the path has returned to the first point.
    unfinished
        Whether the path is too long to follow, and has not left for infinity.
    """

    def __init__(self, path: MotionPath, place: PathPoint, until: Callable[[PathPoint], bool] | None) -> None:
        self.path, self.until = path, until
        self.places, self.closes, self.unfinished = [place], False, False
        self._straight = True
        self._start = self._here = path.link_places(place)
        self._last, self._away = 0.0, False

    def attempt(self, step: float) -> tuple[PathPoint, Array] | None:
        """The point one step ahead, and where its links are; None if the step fails or is too long."""
        found = self.path.stepped(self.places[-1], step)
        if found is None:
            return None
        there = self.path.link_places(found)
        return None if np.abs(there - self._here).max() > 4.0 * STEP else (found, there)

    def accept(self, point: tuple[PathPoint, Array], step: float) -> float | None:
        """Append a point; the next step length, or None if the path closes, is long enough, or `until` is true."""
        found, there = point
        moved, distance = np.abs(there - self._here).max(), np.abs(there - self._start).max()
        self.places.append(found)
        near = self._away and distance < max(moved, self._last)
        self.closes = bool(near and self.path.meets(found, self._start))
        if self.closes or (self.until is not None and self.until(found)):
            return None
        self._straight = self._straight and bool(np.abs(found.tangent - self.places[0].tangent).max() < STRAIGHT)
        if len(self.places) >= LONGEST_WAY or (self._straight and distance > AWAY):
            self.unfinished = bool(distance < AWAY)
            return None
        self._away = self._away or bool(distance > 4.0 * STEP)
        self._here, self._last = there, moved
        return min(STEP, 2.0 * step)


def _rank(matrix: Array) -> int:
    values = np.linalg.svd(matrix, compute_uv=False)
    return int(np.count_nonzero(values > DEPENDENT * values[0]))
