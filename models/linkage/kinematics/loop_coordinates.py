"""The unknown coordinates of the loops of a mechanism: states and rates, and Newton's method for one pose."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from functools import cached_property
from operator import add, sub
from typing import Any, Self

import numpy as np

from .closed_poses import ClosedOne, Pose
from .equations import Equations
from .euler_parameters import angular_velocity_of, euler_parameter_rate, unit_length
from .linear import Linear
from .mechanism import Mechanism
from .terms import Value, dot

# Step below which the iteration ends: the next step would be below rounding.
LAST_STEP = 1e-9
ITERATIONS = 12
# Newton's method is trusted if its first step is at most this, and each later one at most the given share of the one
# before.
FIRST_STEP = 0.15
CONTRACTION = 0.5


class LoopCoordinates:
    """The unknown coordinates of a mechanism, determined by its closing equations and drives."""

    def __init__(self, mechanism: Mechanism, rank: int | None = None, tolerance: float = 0.0) -> None:
        self.mechanism, self.tolerance = mechanism, tolerance
        self.linear = Linear(mechanism.pattern, rank)
        self.rows, self.columns = len(mechanism.active), len(mechanism.unknown)
        # whether the drives and the closing equations leave nothing free
        self.determined = self.linear.rank == self.columns
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
            if mechanism.linkage.joints[name].kind.name == "spherical":
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

        # where the Euler parameters of balls begin
        self.balls = self.driven_spherical + [place for place, _ in self.spherical]
        for place in sorted(self._driven, key=self._driven.__getitem__):
            self.driven_states += range(place, place + (4 if place in self.driven_spherical else 1))

    def anew(self) -> Self:
        """The same loops without the paths that have been found."""
        other = copy(self)
        other.kept, other.guide = {}, None
        return other

    @cached_property
    def equations(self) -> Equations:
        """Programs of the Newton step."""
        return Equations(self.mechanism, self.linear)

    @cached_property
    def unknown_states(self) -> list[int]:
        """Indices of the entries of the state that are not driven."""
        return [place for place in range(self.mechanism.entries) if place not in self.driven_states]

    def placed(self, unknown: Sequence[Any], state: Sequence[Any]) -> list[Any]:
        """A state with these values of the unknowns."""
        out = list(state)
        for place, x in zip(self.unknown_states, unknown, strict=True):
            out[place] = x
        return out

    @cached_property
    def reference_state(self) -> list[float]:
        """State in the reference configuration."""
        state = [0.0] * self.mechanism.entries
        for name, those in self.mechanism.states.items():
            if self.mechanism.linkage.joints[name].kind.name == "spherical":
                state[those.start] = 1.0
        return state

    def advance(self, state: list[Value], step: Sequence[Value], *, back: bool = False) -> list[Value]:
        """State after the unknowns have moved by `step`, or `back` by it; Euler parameters of unit length."""
        out, moved = list(state), sub if back else add
        for place, k in self.singles:
            out[place] = moved(state[place], step[k])
        for place, k in self.spherical:
            change = euler_parameter_rate(state[place : place + 4], step[k : k + 3])
            out[place : place + 4] = unit_length(list(map(moved, state[place : place + 4], change)))
        return out

    def unit(self, state: list[Value]) -> list[Value]:
        """`state`, in place, with the Euler parameters of all spherical joints scaled to unit length."""
        for place in self.balls:
            state[place : place + 4] = unit_length(state[place : place + 4])
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
        """Second time derivative of the state at velocity coordinates and their derivatives; 0 for the drives."""
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

    def rate_along(self, state: Sequence[Value], direction: Sequence[Value], follow: Sequence[Value]) -> list[Value]:
        """Derivative of the state as the driven states move in a direction.

        `follow` holds the velocities of the `Equations.followers` per unit of their drives.
        """
        drives = self.drive_velocities(state, direction)
        unknown: list[Value] = [0.0] * self.columns
        for (drive, k), x in zip(self.equations.followers, follow, strict=True):
            unknown[k] = unknown[k] + drives[drive] * x
        rate = self.state_rate(state, unknown)
        for place, slope in zip(self.driven_states, direction, strict=True):
            rate[place] = slope
        return rate

    def is_rotation(self, drive: int) -> bool:
        """Whether a full turn of a driven state, by its index in `driven_states`, leads back to the same position."""
        return self.is_angle(self.driven_states[drive])

    def is_angle(self, place: int) -> bool:
        """Whether an entry of the state is an angle of period 2 pi."""
        joint = next(name for name, those in self.mechanism.states.items() if those.start <= place < those.stop)
        kind = self.mechanism.linkage.joint(joint).kind
        if kind.name in ("screw", "spherical"):
            return False
        return bool(kind.coordinates[place - self.mechanism.states[joint].start][0] == "r")

    # -- one pose ---------------------------------------------------------------------------------------------------

    def close(self, state: list[float], parameters: Sequence[float], *, far: float = FIRST_STEP) -> Pose | None:
        """The closed pose near `state`, with the bits of `Loops.poses`; None if Newton's method does not contract."""
        (step_at, pose_at, following), n = self.equations.of_one, self.columns
        first = last = 0.0
        try:
            for iteration in range(ITERATIONS):
                step = step_at(state, parameters)[:n]
                size = max(map(abs, step), default=0.0)
                first = first or size
                if not size <= far or (iteration > 0 and last > 1e-6 and size > CONTRACTION * last):
                    return None
                state = self.advance(state, step, back=True)  # type: ignore[arg-type, assignment]
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
        state = self.advance(state, step, back=True)  # type: ignore[arg-type, assignment]
        behind = n + following
        return Pose(state, list(found[n:behind]), list(found[behind:]), first, last)

    def close_one(self, state: list[float], parameters: Sequence[float]) -> ClosedOne | None:
        """`close_all` of a single pose, with the same bits; None if it is not trusted."""
        step_at, n = self.equations.step_of_one, self.columns
        before = np.inf
        try:
            for _ in range(ITERATIONS):
                found = step_at(state, parameters)
                step = found[:n]
                size = max(map(abs, step), default=0.0)
                if not (sum(map(abs, step)) <= n * FIRST_STEP and size <= FIRST_STEP):
                    return None
                if before > 1e-5 and size > CONTRACTION * before:
                    return None
                state = self.advance(state, step, back=True)  # type: ignore[arg-type, assignment]
                before = size
                if size <= LAST_STEP:
                    return ClosedOne(state, found[n:])
        except (ArithmeticError, np.linalg.LinAlgError):
            pass
        return None

    # -- rates ------------------------------------------------------------------------------------------------------

    def velocities(self, state: Sequence[Value], parameters: Sequence[Value], drives: Sequence[Value]) -> list[Value]:
        """All velocity coordinates v from those of the drives: J v = 0."""
        with np.errstate(all="ignore"):
            return self.velocities_of(self.mechanism.full[1](state, parameters), drives)

    def velocities_of(self, entries: Sequence[Any], drives: Sequence[Any]) -> list[Any]:
        """`velocities` from the results of ``mechanism.full``, numbers or recorded terms."""
        n, m, f = self.columns, self.rows, len(self.mechanism.driven)
        behind = m + m * n
        right = [-dot(entries[behind + i * f : behind + i * f + f], drives) for i in range(m)]
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
        """Derivatives of all velocity coordinates if only those of the drives differ from zero."""
        return self._all([0.0] * self.columns, drives)

    def accelerations_of(self, jacobian: Sequence[Any], bias: Sequence[Any], drives: Sequence[Any]) -> list[Any]:
        """`accelerations` from the Jacobian by the unknowns and the bias, numbers or recorded terms."""
        return self._all(self.linear.solve(jacobian, [-x for x in bias]), drives)

    def _all(self, unknown: Sequence[Value], drives: Sequence[Value]) -> list[Value]:
        out: list[Value] = [0.0] * len(self.mechanism.columns)
        for k, x in zip(self.mechanism.unknown, unknown, strict=True):
            out[k] = x
        for k, x in zip(self.mechanism.driven, drives, strict=True):
            out[k] = x
        return out
