"""Newton's method on the loops of a mechanism: for one pose in floats, for all poses in arrays."""

from __future__ import annotations

import math
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ....framework.program.calculation import worth_compiling
from ....framework.program.recording import choose
from .blocks import MEMBERS, blocks, cut_all, members_of
from .closing import Closing
from .equations import Equations
from .linear import Linear
from .mechanism import Mechanism
from .terms import Value

# A step below this ends the iteration: the next would be below rounding.
LAST_STEP = 1e-9
ITERATIONS = 12
# Newton's method is trusted where the guess lies no farther off, and each step is at most this share of the one before.
FIRST_STEP = 0.15
CONTRACTION = 0.5


@dataclass(frozen=True, eq=False)
class Pose:
    """A closed position: its state, how it follows the drives, and the determinants of its equations.

    Attributes
    ----------
    state
        State of all joints.
    follow
        Velocity of each unknown per unit of each drive, drive by drive.
    determinants
        Of the blocks of equations.
    first_step
        Largest change that the first Newton step made.
    """

    state: list[float]
    follow: list[float]
    determinants: list[float]
    first_step: float


@dataclass(frozen=True, eq=False)
class Closed:
    """Closed positions of a batch: state entries, where they are trusted, their first step and determinants."""

    state: list[Value]
    trusted: NDArray[np.bool_]
    converged: NDArray[np.bool_]
    determinants: list[Value]


@dataclass(frozen=True, eq=False)
class ClosedOne:
    """A closed position: its state, and the determinants of its equations."""

    state: list[float]
    determinants: list[float]


@dataclass(frozen=True, eq=False)
class Poses:
    """As `Pose`, of all members of a batch, and which of them are found."""

    state: list[Value]
    follow: list[Value]
    determinants: list[Value]
    first_step: Array
    good: NDArray[np.bool_]


class Loops:
    """The closing equations of a mechanism as a system in its unknown coordinates.

    Parameters
    ----------
    mechanism
        The compiled linkage.
    rank
        Rank of the equations; full where None.
    tolerance
        Greatest gap of a closed pose, in units of the mechanism's size, where that is more than rounding.

    Attributes
    ----------
    kept
        The last paths of a single drive, ahead (True) and back, and what they depended on.
    guide
        The last paths of which a guide was made, and that.
    derivatives
        Those at the reference configuration, once they are known. The continuation finds all three and puts them here,
        so that they live as long as the loops.
    """

    def __init__(self, mechanism: Mechanism, rank: int | None = None, tolerance: float = 0.0) -> None:
        self.mechanism, self.tolerance = mechanism, tolerance
        self.linear = Linear(mechanism.pattern, rank)
        self.rows, self.columns = len(mechanism.active), len(mechanism.unknown)
        self.kept: dict[bool, tuple[object, Any]] = {}
        self.guide: tuple[object, Any] | None = None
        self.derivatives: tuple[Pose, Any] | None = None
        self.singles: list[tuple[int, int]] = []
        self.spherical: list[tuple[int, int]] = []
        self.driven_states: list[int] = []
        self.driven_spherical: list[int] = []
        order = {k: position for position, k in enumerate(mechanism.driven)}
        self._driven: dict[int, int] = {}
        for name, those in mechanism.velocities.items():
            place = mechanism.states[name].start
            if mechanism.linkage.joint(name).kind.name == "spherical":
                if those.start in mechanism.driven:
                    self.driven_spherical.append(place)
                    self._driven[place] = order[those.start]
                else:
                    self.spherical.append((place, mechanism.unknown.index(those.start)))
                continue
            for offset, k in enumerate(range(those.start, those.stop)):
                if k in mechanism.driven:
                    self._driven[place + offset] = order[k]
                else:
                    self.singles.append((place + offset, mechanism.unknown.index(k)))

        for place in sorted(self._driven, key=self._driven.__getitem__):
            self.driven_states += range(place, place + (4 if place in self.driven_spherical else 1))

    def anew(self) -> Loops:
        """The same loops, of which no path is known."""
        other = copy(self)
        other.kept, other.guide = {}, None
        return other

    @property
    def determined(self) -> bool:
        """True where the drives and the closing equations leave nothing free."""
        return self.linear.rank == self.columns

    @property
    def unknown_states(self) -> list[int]:
        """Entries of the state that the drives do not give."""
        return [place for place in range(len(self.mechanism.state_names)) if place not in self.driven_states]

    @cached_property
    def reference_state(self) -> list[float]:
        """State of the drawing."""
        state = [0.0] * len(self.mechanism.state_names)
        for name, those in self.mechanism.states.items():
            if self.mechanism.linkage.joint(name).kind.name == "spherical":
                state[those.start] = 1.0
        return state

    def advance(self, state: list[Value], step: Sequence[Value], *, sign: float = 1.0) -> list[Value]:
        """State after the unknowns have moved by `sign` times `step`; balls keep unit Euler parameters."""
        out = list(state)
        for place, k in self.singles:
            out[place] = state[place] + sign * step[k]
        for place, k in self.spherical:
            change = euler_parameter_rate(state[place : place + 4], [sign * x for x in step[k : k + 3]])
            out[place : place + 4] = _unit([x + y for x, y in zip(state[place : place + 4], change, strict=True)])
        return out

    def unit(self, state: list[Value]) -> list[Value]:
        """`state` with unit Euler parameters of all balls."""
        for place in self.driven_spherical + [place for place, _ in self.spherical]:
            state[place : place + 4] = _unit(state[place : place + 4])
        return state

    def state_rate(self, state: Sequence[Value], unknown: Sequence[Value]) -> list[Value]:
        """Rate of the state at rates of the unknowns; 0 for the drives."""
        out: list[Value] = [0.0] * len(state)
        for place, k in self.singles:
            out[place] = unknown[k]
        for place, k in self.spherical:
            out[place : place + 4] = euler_parameter_rate(state[place : place + 4], unknown[k : k + 3])
        return out

    def state_bend(self, state: Sequence[Value], velocity: Sequence[Value], change: Sequence[Value]) -> list[Value]:
        """Second derivative of the state at velocity coordinates and their derivative; 0 for the drives."""
        unknown = self.mechanism.unknown
        v, w = [velocity[k] for k in unknown], [change[k] for k in unknown]
        out: list[Value] = [0.0] * len(state)
        for place, k in self.singles:
            out[place] = w[k]
        for place, k in self.spherical:
            e = state[place : place + 4]
            turning = euler_parameter_rate(euler_parameter_rate(e, v[k : k + 3]), v[k : k + 3])
            out[place : place + 4] = [
                x + y for x, y in zip(turning, euler_parameter_rate(e, w[k : k + 3]), strict=True)
            ]
        return out

    def drive_velocities(self, state: Sequence[Value], rates: Sequence[Value]) -> list[Value]:
        """Driven velocity coordinates at rates of the driven states."""
        out: list[Value] = [0.0] * len(self.mechanism.driven)
        rate = dict(zip(self.driven_states, rates, strict=True))
        for place, k in self._driven.items():
            if place in self.driven_spherical:
                out[k : k + 3] = angular_velocity_of(state[place : place + 4], [rate[place + i] for i in range(4)])
            else:
                out[k] = rate[place]
        return out

    iterations = ITERATIONS

    def gaps(self, state: Sequence[Value], parameters: Sequence[Value], shape: Shape) -> Array | None:
        """Closure errors of a long batch; None where machine code does not pay, or does not have all of them."""
        made = self.closing.gap().run([state, parameters], shape) if worth_compiling(math.prod(shape)) else None
        if made is None:
            return None
        error: Array = made[0][0][0]
        return None if np.isnan(error).any() else error

    @property
    def closing(self) -> Closing:
        """Programs of the closure, for long batches."""
        return Closing(self)

    def at_once(self, shape: Shape, *, followed: bool = False) -> bool:
        """Whether `close_all`, or `poses` where `followed`, is done by machine code, which takes a batch whole."""
        if not worth_compiling(math.prod(shape)):
            return False
        written = self.closing.poses() if followed else self.closing.close()
        return written is not None and written.choice(shape).compiled

    @cached_property
    def equations(self) -> Equations:
        """Programs of the Newton step."""
        return Equations(self.mechanism, self.linear)

    def is_rotation(self, drive: int) -> bool:
        """True where a full turn of a driven state, counted in `driven_states`, leads back to the same place."""
        return self.is_angle(self.driven_states[drive])

    def is_angle(self, place: int) -> bool:
        """True where an entry of the state is an angle that comes round again after a full turn."""
        joint = next(name for name, those in self.mechanism.states.items() if those.start <= place < those.stop)
        kind = self.mechanism.linkage.joint(joint).kind
        if kind.name in ("screw", "spherical"):
            return False
        return bool(kind.coordinates[place - self.mechanism.states[joint].start][0] == "r")

    # -- one pose ---------------------------------------------------------------------------------------------------

    def close(self, state: list[float], parameters: Sequence[float], *, far: float = FIRST_STEP) -> Pose | None:
        """The closed pose near `state`; None where Newton's method does not contract from there."""
        step_at, pose_at, n = self.equations.step[0], self.equations.pose[0], self.columns
        first = last = 0.0
        try:
            for iteration in range(ITERATIONS):
                step = step_at(state, parameters)[:n]
                size = max(map(abs, step), default=0.0)
                first = first or size
                if not size <= far or (iteration > 0 and last > 1e-6 and size > CONTRACTION * last):
                    return None
                state = self.advance(state, step, sign=-1.0)  # type: ignore[arg-type, assignment]
                last = size
                if size < 1e-3:
                    break
            else:
                return None
            found = pose_at(state, parameters)
        except (ZeroDivisionError, np.linalg.LinAlgError, OverflowError):
            return None
        step, last = found[:n], max(map(abs, found[:n]), default=0.0)
        if not last <= max(CONTRACTION * size, 1e-12):
            return None
        state = self.advance(state, step, sign=-1.0)  # type: ignore[arg-type, assignment]
        behind = n + n * len(self.mechanism.driven)
        return Pose(state, list(found[n:behind]), list(found[behind:]), first)

    # -- rates ------------------------------------------------------------------------------------------------------

    def velocities(self, state: Sequence[Value], parameters: Sequence[Value], drives: Sequence[Value]) -> list[Value]:
        """All velocity coordinates v from those of the drives: J v = 0."""
        with np.errstate(all="ignore"):
            return self.velocities_of(self.mechanism.full[1](state, parameters), drives)

    def velocities_of(self, entries: Sequence[Any], drives: Sequence[Any]) -> list[Any]:
        """`velocities` from the results of ``mechanism.full``, which may be written down."""
        n, m, f = self.columns, self.rows, len(self.mechanism.driven)
        behind = m + m * n
        right = [-sum((entries[behind + i * f + k] * drives[k] for k in range(f)), start=0.0) for i in range(m)]
        return self._all(self.linear.solve(entries[m:behind], right), drives)

    def accelerations(
        self, state: Sequence[Value], parameters: Sequence[Value], v: Sequence[Value], drives: Sequence[Value] | None
    ) -> list[Value]:
        """Time derivative of all velocity coordinates from those of the drives, 0 where None: J v' = -J' v."""
        own = [0.0] * len(self.mechanism.driven) if drives is None else drives
        with np.errstate(all="ignore"):
            bias = self.mechanism.bias[1](state, parameters, v, self.standing(own))
            entries = self.mechanism.newton[1](state, parameters)
            return self.accelerations_of(entries[self.rows :], bias, own)

    def standing(self, drives: Sequence[Any]) -> list[Any]:
        """Derivatives of the velocity coordinates from those of the drives, with the unknowns at rest."""
        return self._all([0.0] * self.columns, drives)

    def accelerations_of(self, jacobian: Sequence[Any], bias: Sequence[Any], drives: Sequence[Any]) -> list[Any]:
        """`accelerations` from the Jacobian by the unknowns and the bias, which may be written down."""
        return self._all(self.linear.solve(jacobian, [-x for x in bias]), drives)

    def rates_at_once(
        self,
        state: Sequence[Value],
        parameters: Sequence[Value],
        rates: Sequence[Value],
        changes: Sequence[Value],
        shape: Shape,
    ) -> tuple[list[Value], list[Value]] | None:
        """`velocities` and `accelerations` of a long batch as machine code; None where that does not pay."""
        written = self.closing.rates() if worth_compiling(math.prod(shape)) else None
        made = written and written.run([state, parameters, (), [*rates, *changes]], shape)
        if not made:
            return None
        velocities, accelerations = made[0]
        return velocities, accelerations

    def _all(self, unknown: Sequence[Value], drives: Sequence[Value]) -> list[Value]:
        out: list[Value] = [0.0] * len(self.mechanism.columns)
        for k, x in zip(self.mechanism.unknown, unknown, strict=True):
            out[k] = x
        for k, x in zip(self.mechanism.driven, drives, strict=True):
            out[k] = x
        return out

    # -- all poses --------------------------------------------------------------------------------------------------

    def close_all(self, state: list[Value], parameters: Sequence[Value]) -> Closed:
        """Closed poses of a batch from the guesses `state`; driven entries are kept.

        Each member stops at its own last step, so that its bits do not depend on its neighbours.
        """
        shape = np.broadcast_shapes(*{np.shape(x) for x in (*state, *parameters)})
        if math.prod(shape) <= MEMBERS:
            return self._close_all(state, parameters, shape)
        return self._closed_at_once(state, parameters, shape) or self._in_blocks(state, parameters, shape)

    def _closed_at_once(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Closed | None:
        """`close_all` as machine code, where that pays; what it leaves open is closed by arrays."""
        written = self.closing.close() if worth_compiling(math.prod(shape)) else None
        made = written and written.run([state, parameters, self.closing.shares], shape)
        if not made:
            return None
        (unknown, (trusted,), determinants), _ = made
        found, converged = list(state), trusted
        for place, x in zip(self.unknown_states, unknown, strict=True):
            found[place] = x
        if not trusted.all():
            bad = ~trusted
            begin, own = members_of(state, bad), members_of(parameters, bad)
            rest = self._in_blocks(begin, own, (int(np.count_nonzero(bad)),))
            converged = trusted.copy()
            trusted[bad], converged[bad] = rest.trusted, rest.converged
            for place, x in zip(self.unknown_states, unknown, strict=True):
                x[bad] = rest.state[place]
            for x, y in zip(determinants, rest.determinants, strict=True):
                x[bad] = y
        return Closed(found, trusted, converged, list(determinants))

    def _in_blocks(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Closed:
        found, trusted = list(state), np.empty(shape, dtype=bool)
        for place in self.unknown_states:
            found[place] = np.empty(shape)
        converged, determinants = np.empty(shape, dtype=bool), [np.empty(shape) for _ in range(self.linear.signs)]
        for block in blocks(shape):
            part, own = cut_all(state, block), cut_all(parameters, block)
            here = self._close_all(part, own, np.broadcast_shapes(*{np.shape(x) for x in (*part, *own)}))
            trusted[block], converged[block] = here.trusted, here.converged
            for place in self.unknown_states:
                np.asarray(found[place])[block] = here.state[place]
            for whole, x in zip(determinants, here.determinants, strict=True):
                whole[block] = x
        return Closed(found, trusted, converged, list(determinants))

    def _close_all(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Closed:
        program, n = self.equations.step[1], self.columns
        trusted = np.ones(shape, dtype=bool)
        moving: NDArray[np.bool_] = trusted
        before: Array | float = np.inf
        found: Sequence[Value] = ()
        with np.errstate(all="ignore"):
            for _ in range(ITERATIONS):
                found = program(state, parameters)
                state, trusted, moving, before = self.contracted(found[:n], state, trusted, moving, before)
                if not moving.any():
                    break
        converged = np.asarray(self.converged(before))
        return Closed(state, trusted & converged, converged, list(found[n:]))

    def contracted(
        self, step: Sequence[Any], state: list[Any], trusted: Any, moving: Any, before: Any
    ) -> tuple[list[Any], Any, Any, Any]:
        """One round of `close_all`, on arrays or written down: states a step further, and what is held of them.

        Parameters
        ----------
        step
            The step of each unknown.
        state
            Entries of the state.
        trusted, moving
            Which poses Newton's method has led on so far, and which of them it still moves.
        before
            Size of the last step.
        """
        size = _largest(step)
        bad = ~(size <= FIRST_STEP) | ((before > 1e-5) & (size > CONTRACTION * before))
        trusted = trusted & ~(bad & moving)
        if not (isinstance(moving, np.ndarray) and moving.all()):
            step = [choose(moving, x, 0.0) for x in step]
        state = self.advance(state, step, sign=-1.0)
        before = choose(moving, size, before)
        return state, trusted, moving & (size > LAST_STEP) & (size < 1e3), before

    @staticmethod
    def converged(before: Any) -> Any:
        """Whether the last step was so small that the next would be below rounding."""
        return before <= LAST_STEP

    def close_one(self, state: list[float], parameters: Sequence[float], *, compiled: bool = True) -> ClosedOne | None:
        """`close_all` of a single pose, in the same sums where these are `compiled`; None where it is not trusted."""
        step_at, n = self.equations.step_of_one, self.columns
        before = np.inf
        try:
            for _ in range(ITERATIONS):
                found = step_at(state, parameters, compiled=compiled)
                step = found[:n]
                size = max(map(abs, step), default=0.0)
                if not (sum(map(abs, step)) <= n * FIRST_STEP and size <= FIRST_STEP):
                    return None
                if before > 1e-5 and size > CONTRACTION * before:
                    return None
                state = self.advance(state, step, sign=-1.0)  # type: ignore[arg-type, assignment]
                before = size
                if size <= LAST_STEP:
                    return ClosedOne(state, found[n:])
        except (ArithmeticError, np.linalg.LinAlgError):
            pass
        return None

    def poses(self, state: list[Value], parameters: Sequence[Value]) -> Poses:
        """`close` for all members of a batch: poses near the guesses `state`, as good as the next step needs them.

        Members do not depend on each other.
        """
        shape = np.broadcast_shapes(*{np.shape(x) for x in (*state, *parameters)})
        return self._poses_at_once(state, parameters, shape) or self._poses(state, parameters, shape)

    def _poses_at_once(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Poses | None:
        """`poses` as machine code, where that pays; what it does not find is looked for by arrays."""
        written = self.closing.poses() if worth_compiling(math.prod(shape)) else None
        made = written and written.run([state, parameters, self.closing.shares], shape)
        if not made:
            return None
        (unknown, follow, determinants, (first,), (good,)), _ = made
        found = list(state)
        for place, x in zip(self.unknown_states, unknown, strict=True):
            found[place] = x
        if not good.all():
            bad = ~good
            left = (int(np.count_nonzero(bad)),)
            rest = self._poses(members_of(state, bad), members_of(parameters, bad), left)
            first[bad], good[bad] = rest.first_step, rest.good
            own = [rest.state[place] for place in self.unknown_states]
            for x, y in zip((*unknown, *follow, *determinants), (*own, *rest.follow, *rest.determinants), strict=True):
                x[bad] = y
        return Poses(found, list(follow), list(determinants), first, good)

    def _poses(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Poses:
        step_at, pose_at, n = self.equations.step[1], self.equations.pose[1], self.columns
        good, moving = np.ones(shape, dtype=bool), np.ones(shape, dtype=bool)
        first, last = np.full(shape, -1.0), np.zeros(shape)
        with np.errstate(all="ignore"):
            for _ in range(ITERATIONS):
                step = step_at(state, parameters)[:n]
                state, good, moving, first, last = self.approached(step, state, good, moving, first, last)
                if not moving.any():
                    break
            found = pose_at(state, parameters)
            state, good = self.arrived(found[:n], state, good, moving, last)
        behind = n + n * len(self.mechanism.driven)
        return Poses(state, list(found[n:behind]), list(found[behind:]), first, good)

    def approached(
        self, step: Sequence[Any], state: list[Any], good: Any, moving: Any, first: Any, last: Any
    ) -> tuple[list[Any], Any, Any, Any, Any]:
        """One round of `poses`, on arrays or written down; `first` is -1 before there is a first step.

        Parameters
        ----------
        step
            The step of each unknown.
        state
            Entries of the state.
        good, moving
            Which poses Newton's method has led on so far, and which of them it still moves.
        first, last
            Sizes of the first and the last step.
        """
        size = _largest(step)
        first = choose(first < 0.0, size, first)
        lost = ~(size <= FIRST_STEP) | ((last > 1e-6) & (size > CONTRACTION * last))
        good = good & ~(lost & moving)
        moving = moving & good
        state = self.advance(state, [choose(moving, x, 0.0) for x in step], sign=-1.0)
        return state, good, moving & (size >= 1e-3), first, choose(moving, size, last)

    def arrived(
        self, step: Sequence[Any], state: list[Any], good: Any, moving: Any, last: Any
    ) -> tuple[list[Any], Any]:
        """The last step of `poses`, likewise, and which poses are good then."""
        size = _largest(step)
        good = good & ~moving & (size <= np.maximum(CONTRACTION * last, 1e-12))
        return self.advance(state, [choose(good, x, 0.0) for x in step], sign=-1.0), good


def _largest(step: Sequence[Any]) -> Any:
    """The largest magnitude of entries, NaN where one is, on arrays or written down."""
    sizes = [abs(x) for x in step if not (isinstance(x, float) and x == 0.0)]
    return reduce(np.maximum, sizes) if sizes else np.zeros(())


def _unit(e: Sequence[Value]) -> list[Value]:
    square = sum((x * x for x in e), start=0.0)
    norm = math.sqrt(square) if isinstance(square, float) else np.sqrt(square)
    return [x / norm for x in e]


def euler_parameter_rate(e: Sequence[Value], omega: Sequence[Value]) -> list[Value]:
    """Rate of Euler parameters at an angular velocity along the axes on the first link: half of (0, ω) times e."""
    a, b, c, d = e
    x, y, z = omega
    return [
        -0.5 * (x * b + y * c + z * d),
        0.5 * (x * a + y * d - z * c),
        0.5 * (y * a + z * b - x * d),
        0.5 * (z * a + x * c - y * b),
    ]


def angular_velocity_of(e: Sequence[Value], rate: Sequence[Value]) -> list[Value]:
    """Angular velocity, along the axes on the first link, at a rate of the Euler parameters: inverse of
    `euler_parameter_rate`."""
    (a, b, c, d), (p, q, r, s) = e, rate
    return [
        2.0 * (q * a - p * b - r * d + s * c),
        2.0 * (r * a - p * c - s * b + q * d),
        2.0 * (s * a - p * d - q * c + r * b),
    ]
