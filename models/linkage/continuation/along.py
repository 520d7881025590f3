"""Poses of a linkage of which one drive moves: interpolated on its path, or on that of each member of a batch."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ..kinematics.blocks import blocks, cut, cut_all, members_of, shape_of, taken
from ..kinematics.closed_poses import Pose
from ..kinematics.loops import Loops
from ..kinematics.terms import Value
from .change_point import Patch, patched
from .ends import SHORT, at_dead_points
from .guess import Guess
from .many_paths import read_off
from .members import Starts, accompanied
from .single_drive import TURN, SingleDrive

Mask = NDArray[np.bool_]


@dataclass(eq=False)
class Found:
    """Closed states of a batch.

    Attributes
    ----------
    state
        Entries of the states, of the batch shape except for the driven ones, which may broadcast.
    reached
        Whether a path from the reference configuration leads to the pose, (...).
    patches
        Poses in change points.
    nearly
        Poses next to a change point where the branches cross only approximately: closed to some digits, (...).
    """

    state: list[Value]
    reached: Mask
    patches: list[Patch] = field(default_factory=list)
    nearly: Mask | None = None


@dataclass(frozen=True, eq=False)
class Along:
    """Finds the poses of one moving drive.

    Attributes
    ----------
    loops
        The loops.
    nominal, start
        Dimensions and reference configuration of the leading member, whose path the others are compared with.
    starts
        Reference configurations of all members; None where all are the same.
    drive
        Which of the driven states moves.
    switch
        Whether the other branch is taken at change points.
    """

    loops: Loops
    nominal: Sequence[float]
    start: Pose
    starts: Starts | None
    drive: int
    switch: bool

    def poses(self, driven: Sequence[Array], parameters: Sequence[Value], shape: Shape) -> Found:
        """Poses at the driven states, which broadcast with the starts to `shape`."""
        s, whole = driven[self.drive] - self.start.state[self.loops.driven_states[self.drive]], shape_of(driven)
        # The other drives do not move, but their values may have batch axes of their own.
        s = s if s.shape == whole else np.broadcast_to(s, whole)
        single = SingleDrive(self.loops, self.nominal, self.start, self.drive, self.switch)
        guess = single.guess(s)
        self._drive(guess.state, driven)
        if self.starts is None:
            found, apart = self._nominal(single, guess), np.zeros(shape, dtype=bool)
        else:
            found, apart = self._members(single, guess, self.starts, parameters, shape)
        patches, nearly = patched(self.loops, guess, parameters, found.state, found.reached, ~apart)
        found.patches += patches
        if nearly is not None:
            found.nearly = nearly if found.nearly is None else found.nearly | nearly
        return found

    def _drive(self, state: list[Value], driven: Sequence[Array]) -> None:
        for place, value in zip(self.loops.driven_states, driven, strict=True):
            state[place] = value
        self.loops.unit(state)

    # -- one set of dimensions ----------------------------------------------------------------------------------------

    def _nominal(self, single: SingleDrive, guess: Guess) -> Found:
        """Close the interpolated guesses; where Newton's method fails, follow the path in short steps."""
        shape = guess.reached.shape
        found = self.loops.close_all(list(guess.state), self.nominal)
        good = np.asarray(found.trusted & guess.reached & same_signs(found.determinants, guess.signs))
        # the entries that Newton's method found are arrays of their own; of a single pose, numbers
        state: list[Value] = [np.asarray(x) for x in found.state]
        if good.all():
            return Found(state, good)
        assert guess.s is not None
        assert guess.guide is not None
        guide = guess.guide
        _put(state, ~good, [np.broadcast_to(x, shape)[~good] for x in guess.state], self.loops)
        places = self.loops.driven_states
        for index in map(tuple, np.argwhere(~good & guess.reached)):
            at = single.exactly(float(guess.s[index]))
            if at is not None:
                at = [float(np.asarray(guess.state[k])[index]) if k in places else x for k, x in enumerate(at)]
                pose = self.loops.close(at, self.nominal)
                _put(state, index, at if pose is None else pose.state, self.loops)
                good[index] = pose is not None
        beyond = np.maximum(guess.s - guide.high, guide.low - guess.s)
        self._at_ends(self.nominal, state, good, np.where(guess.reached, 0.0, beyond))
        return Found(state, good)

    def _at_ends(self, parameters: Sequence[Value], state: list[Value], good: Mask, left: Array) -> None:
        bad = ~good
        if bad.any():
            rows = np.stack([np.broadcast_to(x, good.shape)[bad] for x in state])
            own = members_of(parameters, bad)
            reached = np.zeros(rows.shape[1], dtype=bool)
            at_dead_points(self.loops, own, rows, reached, left[bad], rows[self.loops.driven_states])
            _put(state, bad, list(rows), self.loops)
            good[bad] = reached

    # -- members of a batch -------------------------------------------------------------------------------------------

    def _members(
        self, single: SingleDrive, guess: Guess, starts: Starts, parameters: Sequence[Value], shape: Shape
    ) -> tuple[Found, Mask]:
        """Close all members from the poses of the leading member, or along their own paths where that is not safe.

        The second result marks the poses of members that were found as without the others.
        """
        assert guess.s is not None
        assert guess.guide is not None
        found = self._nominal(single, guess)
        limits = accompanied(self.loops, guess.guide, parameters, self.nominal, starts, guess.s)
        state: list[Value] = list(found.state)
        for place in self.loops.unknown_states:
            state[place] = np.empty(shape)
        good = np.zeros(shape, dtype=bool)
        for block in blocks(shape, math.prod(shape)) if self.loops.at_once(shape) else blocks(shape):
            lead, s = cut_all(found.state, block), cut(guess.s, block)
            reached = cut(found.reached.astype(np.float64), block)
            own, (back, ahead) = cut_all(parameters, block), (cut(limit, block) for limit in limits)
            closed = self.loops.close_all(lead, own)
            same = same_signs(closed.determinants, cut_all(guess.signs, block))
            good[block] = closed.trusted & same & (np.asarray(reached) > 0.0) & (s > back) & (s < ahead)
            for place in self.loops.unknown_states:
                np.asarray(state[place])[block] = closed.state[place]
        found = Found(state, good)
        return found, self._alone(guess, starts, parameters, found)

    def _alone(self, guess: Guess, starts: Starts, parameters: Sequence[Value], found: Found) -> Mask:
        """Find the poses of members that are not yet reached, each along its own path.

        Returns the poses of members with change points of their own, which are found as without the others.
        """
        assert guess.s is not None
        shape = found.reached.shape
        apart = np.zeros(shape, dtype=bool)
        left = np.flatnonzero(np.broadcast_to(~found.reached & starts.closed, shape))
        if not left.size:
            return apart
        member = np.broadcast_to(np.arange(starts.closed.size).reshape(starts.closed.shape), shape).ravel()[left]
        s = np.broadcast_to(guess.s, shape).ravel()[left]
        names, who = np.unique(member, return_inverse=True)
        own = [_members(x, starts.closed.shape, names) if np.ndim(x) else x for x in parameters]
        begin = np.stack([_members(x, starts.closed.shape, names) for x in starts.state])
        own_paths = Paths(self, own, begin)
        states, reached = own_paths.at(who, s)
        given = np.stack([np.broadcast_to(found.state[k], shape).ravel()[left] for k in self.loops.driven_states])
        states[self.loops.driven_states] = given
        dims = taken(own, who)
        closed = self.loops.close_all(self.loops.unit(list(states)), dims)
        sure = closed.trusted & reached
        sure &= same_signs(closed.determinants, list(own_paths.signs))
        states[:, sure] = np.stack(np.broadcast_arrays(*closed.state))[:, sure]
        for k in np.flatnonzero(reached & ~sure):
            at = own_paths.exactly(int(who[k]), float(s[k]), given[:, k])
            if at is not None:
                states[:, k], sure[k] = at, True
        at_dead_points(self.loops, dims, states, sure, np.where(reached, 0.0, own_paths.beyond), given)
        self._store(found, left, states, sure)
        for name in np.flatnonzero(own_paths.alone):
            chosen = np.flatnonzero(who == name)
            apart.ravel()[left[chosen]] = True
            self._as_single(own_paths.single(int(name)), found, left[chosen], given[:, chosen])
        return apart

    def _as_single(self, single: SingleDrive, found: Found, places: NDArray[np.intp], given: Array) -> None:
        """Find the poses of one member at some places of the batch as without the others."""
        along = Along(single.loops, single.parameters, single.start, None, self.drive, self.switch)
        own = along.poses(list(given), single.parameters, places.shape)
        self._store(found, places, np.stack(np.broadcast_arrays(*own.state)), own.reached)
        chosen = np.zeros(found.reached.shape, dtype=bool)
        chosen.ravel()[places] = True
        found.patches += [patch.of(chosen) for patch in own.patches]
        if own.nearly is not None:
            found.nearly = np.zeros_like(chosen) if found.nearly is None else found.nearly
            found.nearly.ravel()[places] = own.nearly

    def _store(self, found: Found, places: NDArray[np.intp], states: Array, reached: Mask) -> None:
        """Put states (n, k) and whether they are reached at some places (k,) of the batch."""
        for place in self.loops.unknown_states:
            whole = np.asarray(found.state[place])
            whole.ravel()[places] = states[place]
            found.state[place] = whole
        found.reached.ravel()[places] = reached


class Paths:
    """The paths of some members, each followed as it would be alone.

    Attributes
    ----------
    signs, beyond
        Of the poses of the last call of `at`: signs of the determinants, (blocks, asked), and distance by which each
        pose lies beyond the end of its path, (asked,).
    alone
        Members that pass a change point or make many turns, whose poses `at` does not find, (members,).
    """

    def __init__(self, along: Along, parameters: Sequence[Value], begin: Array) -> None:
        self.along, self.loops, self.parameters, self.begin = along, along.loops, parameters, begin
        self.singles: dict[int, SingleDrive] = {}
        self.alone = np.zeros(begin.shape[1], dtype=bool)

    def at(self, who: NDArray[np.intp], s: Array) -> tuple[Array, Mask]:
        """States (n, asked) at lengths s of members' paths, or at their ends, and whether each path is that long."""
        states = self.begin[:, who].copy()
        reached, self.beyond = np.zeros(s.shape, dtype=bool), np.full(s.shape, np.inf)
        own = [np.sign(x)[who] for x in self._determinants()]
        self.signs = np.stack(own) if own else np.zeros((0, len(s)))
        many = np.abs(s) > 6.0 * TURN
        self.alone[who[many]] = True
        within = s.copy()
        ends = np.zeros((2, self.begin.shape[1]))
        for _ in range(2):
            for sign, end in zip((1.0, -1.0), ends, strict=True):
                chosen = np.flatnonzero(~reached & ~self.alone[who] & (sign * within >= 0.0))
                if chosen.size:
                    self._one_way(sign, chosen, who, within, states, reached, end)
            if not self.loops.is_rotation(self.along.drive):
                break
            ended = np.where(within >= 0.0, ends[0][who], ends[1][who])
            turns = np.sign(within) * np.ceil((np.abs(within) - ended - SHORT) / TURN)
            within = np.where(reached, within, within - TURN * turns)
        reached &= ~self.alone[who]
        self.beyond[self.alone[who]] = np.inf
        return states, reached

    def exactly(self, who: int, s: float, given: Array) -> list[float] | None:
        """The state of a member at one value of the drive, followed in short steps, with the driven states `given`."""
        single = self.single(who)
        at = single.exactly(s)
        if at is None:
            return None
        for place, value in zip(self.loops.driven_states, given.tolist(), strict=True):
            at[place] = value
        pose = self.loops.close(at, single.parameters)
        return at if pose is None else pose.state

    def _one_way(
        self,
        sign: float,
        chosen: NDArray[np.intp],
        who: NDArray[np.intp],
        s: Array,
        states: Array,
        reached: Mask,
        end: Array,
    ) -> None:
        members, path = np.unique(who[chosen], return_inverse=True)
        direction = np.zeros((len(self.loops.driven_states), len(members)))
        direction[self.along.drive] = sign
        own = taken(self.parameters, members)
        read = read_off(self.loops, own, self.begin[:, members], direction, path, np.abs(s[chosen]))
        end[members] = read.end
        self.alone[members[read.crossing]] = True
        states[:, chosen] = read.states
        reached[chosen] = read.reached
        self.beyond[chosen] = np.abs(s[chosen]) - read.end[path]

    def _determinants(self) -> list[Array]:
        found = self.loops.close_all(list(self.begin.copy()), self.parameters)
        return [np.broadcast_to(x, self.begin.shape[1:]) for x in found.determinants]

    def single(self, who: int) -> SingleDrive:
        """The path of one member, followed by itself."""
        if who not in self.singles:
            own = [float(x) for x in taken(self.parameters, np.array(who))]
            loops = self.loops.anew()
            start = loops.close(self.begin[:, who].tolist(), own)
            assert start is not None
            self.singles[who] = SingleDrive(loops, own, start, self.along.drive, self.along.switch)
        return self.singles[who]


def same_signs(determinants: Sequence[Value], signs: Sequence[Value]) -> Mask | bool:
    """Whether all determinants have the expected signs, (...); a sign of 0 allows both."""
    same: Mask | bool = True
    for determinant, sign in zip(determinants, signs, strict=True):
        same = same & (np.asarray(determinant) * sign >= 0.0)
    return same


def _members(value: Value, shape: Shape, names: NDArray[np.intp]) -> Array:
    return np.broadcast_to(value, shape).ravel()[names]


def _put(state: list[Value], chosen: Mask | tuple[int, ...], values: Sequence[Value], loops: Loops) -> None:
    for place in loops.unknown_states:
        np.asarray(state[place])[chosen] = np.asarray(values[place])
