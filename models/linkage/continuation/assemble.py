"""Poses of a batch: each is closed on the path from the reference configuration, or marked as not reached."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ....framework.lazily import cached_property
from ....framework.program.calculation import worth_compiling
from ..kinematics.blocks import blocks, cut_all, members_of, taken
from ..kinematics.closed_poses import Pose
from ..kinematics.loops import Loops
from ..kinematics.mechanism import Mechanism
from ..kinematics.nearest import open_by
from ..kinematics.terms import Value
from .along import Along, Found
from .change_point import Patch
from .driven import check_driven
from .drives import Drives
from .ends import sharpened
from .many_paths import TOGETHER
from .members import Starts, own_starts
from .one_pose import STILL, OnePose, one_pose
from .other_modes import least_gaps
from .predictor_corrector import OPEN
from .rays import along_rays, from_one
from .start import leader
from .sweep import swept

Mask = NDArray[np.bool_]
# Residual, as a share of the mechanism's size, below which loops count as closed.
CLOSED = 1e-12
# Poses up to which a batch is found pose by pose, in floats, and one more for every two unknowns: from there on the
# calls of NumPy take less time.
FEW = 10
# `reached` of a single pose that was found.
_REACHED: Mask = np.ones((), dtype=bool)
_REACHED.setflags(write=False)


@dataclass(eq=False)
class Assembly:
    """Closed states of a batch.

    Attributes
    ----------
    loops
        The loops.
    parameters
        Dimensions.
    shape
        Batch shape of the states.
    state
        Entries of the state, which broadcast to `shape`.
    reached
        Where the loops close on the path that leads there from the reference configuration, (...).
    error
        Closure error there, in units of the mechanism's size, (...).
    patches
        Poses in change points; their rates are those of the branch on both sides.
    other_modes
        Whether poses that are not reached are sought in other assembly modes.
    switch
        Whether the other branch is taken at change points.
    how
        Why machine code found the poses, in words; empty where it did not.
    """

    loops: Loops
    parameters: Sequence[Value]
    shape: Shape
    state: list[Value]
    reached: Mask
    error: Array
    patches: list[Patch]
    other_modes: bool = False
    switch: bool = False
    how: str = ""

    @property
    def closed(self) -> Mask:
        """Whether each pose has a position, (...)."""
        return self.reached | self.other if self.other_modes else self.reached

    @cached_property
    def all_closed(self) -> bool:
        """Whether all poses have a position."""
        return bool(self.closed.all())

    @property
    def told(self) -> str:
        """Which back end found the poses, and why, in words."""
        written = self.loops.closing.close()
        if self.how or written is None:
            return self.how or "by NumPy, as the equations take a choice of pivots at each pose"
        return written.choice(self.shape).reason

    @property
    def other(self) -> Mask:
        """Whether the linkage can be assembled, but in another assembly mode only, (...)."""
        return self._anew[0]

    @property
    def gap(self) -> Array:
        """Closure error, a length, (...); the least one found where the linkage cannot be assembled."""
        return self._anew[1] * self.loops.mechanism.size

    @property
    def open_row(self) -> NDArray[np.intp]:
        """Closing row with the largest error where the linkage cannot be assembled, (...)."""
        return self._anew[2]

    @cached_property
    def _anew(self) -> tuple[Mask, Array, NDArray[np.intp]]:
        """`other`, closure error and its row, where poses that are not reached are assembled from other starting
        states.

        The states found are stored where other modes are asked for.
        """
        other, row = np.zeros(self.shape, dtype=bool), np.zeros(self.shape, dtype=np.intp)
        if self.reached.all():
            return other, self.error, row
        error, left = self.error.copy(), ~self.reached
        own = members_of(self.parameters, left)
        begin = np.stack([np.broadcast_to(x, self.shape)[left] for x in self.state])
        found, error[left], row[left] = least_gaps(self.loops, own, begin, alike=self.other_modes)
        other[left] = error[left] < max(CLOSED, self.loops.tolerance)
        if self.other_modes:
            for place in self.loops.unknown_states:
                whole = np.array(np.broadcast_to(self.state[place], self.shape))
                whole[left] = found[place]
                self.state[place] = whole
        return other, error, row


def assembled(
    mechanism: Mechanism, drives: Drives, switch: bool, tolerance: float = 0.0, other_modes: bool = False
) -> Assembly:
    """Close the loops at all values of the drives, up to a tolerance in units of the mechanism's size."""
    if mechanism.begun is None or mechanism.begun[1].tolerance != tolerance:
        member, nominal, loops, start = leader(mechanism, tolerance)
        check_driven(loops, nominal, start, member)
        mechanism.begun = nominal, loops, start
        mechanism.starts = None
    nominal, loops, start = mechanism.begun
    parameters, varies = mechanism.parameters, mechanism.linkage.shape
    if varies and mechanism.starts is None:
        mechanism.starts = own_starts(loops, parameters, varies)
    shape = np.broadcast_shapes(drives.shape, varies) if varies else drives.shape
    starts = mechanism.starts if varies else None
    out = None
    if not varies and not switch:
        few = _one_by_one(loops, nominal, start, drives.states, shape)
        out = _swept(loops, nominal, start, drives.states, shape) if few is None else few
    if out is None:
        out = _looked_at(loops, nominal, start, starts, parameters, drives.states, shape, switch)
    out.other_modes, out.switch = other_modes, switch
    if other_modes:
        _ = out.closed
    return out


def _one_by_one(
    loops: Loops, parameters: Sequence[float], start: Pose, driven: Sequence[Array], shape: Shape
) -> Assembly | None:
    """A single pose or a few, each by itself, with the bits of a longer batch; None for more.

    None also where one of them takes a closer search.
    """
    limit = max(CLOSED, loops.tolerance)
    if not shape:
        one = one_pose(loops, parameters, start, [float(x) for x in driven], limit)
        if one is None:
            return None
        return Assembly(loops, parameters, shape, list(one.state), _REACHED, np.array(one.error), [])
    if not 0 < math.prod(shape) <= FEW + loops.columns // 2:
        return None
    every = list(zip(*(np.broadcast_to(x, shape).ravel().tolist() for x in driven), strict=True))
    begin = start.state[loops.driven_states[0]] if driven else 0.0
    found: dict[int, OnePose] = {}
    # the farthest first, so that the path of a drive is followed once and not on from each pose to the next
    for k in sorted(range(len(every)), key=lambda k: -abs(every[k][0] - begin)):
        one = one_pose(loops, parameters, start, every[k], limit)
        if one is None:
            return None
        found[k] = one
    poses = [found[k] for k in range(len(every))]
    state: list[Value] = [np.array(entry).reshape(shape) for entry in zip(*(one.state for one in poses), strict=True)]
    error = np.array([one.error for one in poses]).reshape(shape)
    return Assembly(loops, parameters, shape, state, np.ones(shape, dtype=bool), error, [])


def _swept(
    loops: Loops, nominal: Sequence[float], start: Pose, driven: Sequence[Array], shape: Shape
) -> Assembly | None:
    """A long sweep of one drive by machine code; the poses that this leaves open are found as in a short batch."""
    if not worth_compiling(math.prod(shape)):
        return None
    moving = _moving(loops, start, driven)
    if len(moving) != 1 or loops.driven_spherical or not loops.determined:
        return None
    found = swept(loops, nominal, start, moving[0], driven, shape, max(CLOSED, loops.tolerance))
    if found is None:
        return None
    out = Assembly(loops, nominal, shape, found.state, found.good, found.error, [], how=found.reason)
    if not found.good.all():
        left = ~found.good
        aims = [np.broadcast_to(x, shape)[left] for x in driven]
        rest = _looked_at(loops, nominal, start, None, nominal, aims, aims[0].shape, switch=False)
        out.reached[left], out.error[left] = rest.reached, rest.error
        out.patches = [patch.of(left) for patch in rest.patches]
        for place in loops.unknown_states:
            np.asarray(out.state[place])[left] = rest.state[place]
    return out


def _looked_at(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    starts: Starts | None,
    parameters: Sequence[Value],
    driven: Sequence[Array],
    shape: Shape,
    switch: bool,
) -> Assembly:
    """Poses of a batch, with change points, dead points and poses out of reach."""
    found = _found(loops, nominal, start, starts, parameters, driven, shape, switch)
    error = _measured(loops, parameters, found, shape)
    closed = error < max(CLOSED, loops.tolerance)
    if found.nearly is not None:
        closed |= found.nearly & (error < OPEN)
    return Assembly(loops, parameters, shape, found.state, found.reached & closed, error, found.patches)


def _moving(loops: Loops, start: Pose, driven: Sequence[Array]) -> list[int]:
    """Indices of the driven states that move in some pose."""
    begin = [start.state[place] for place in loops.driven_states]
    return [k for k, (x, at) in enumerate(zip(driven, begin, strict=True)) if _farthest(x, at) > STILL]


def _farthest(values: Array, begin: float) -> float:
    """Largest distance of the values from `begin`."""
    return max(float(values.max(initial=begin)) - begin, begin - float(values.min(initial=begin)))


def _found(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    starts: Starts | None,
    parameters: Sequence[Value],
    driven: Sequence[Array],
    shape: Shape,
    switch: bool,
) -> Found:
    """Poses of a batch, grouped by the drives that have moved: poses of one moving drive lie on one path.

    Where the drives determine the whole state, as on open chains, there is no path to follow. Of several drives, a pose
    at which none has moved is the reference configuration, whichever of them moves elsewhere in the batch.
    """
    if not loops.unknown_states:
        return _standing(loops, start, starts, driven, shape)
    moving = _moving(loops, start, driven)
    if len(loops.driven_states) == 1:
        return Along(loops, nominal, start, starts, 0, switch).poses(driven, parameters, shape)
    if not moving:
        return _standing(loops, start, starts, driven, shape)
    moved = [np.abs(x - start.state[place]) > STILL for place, x in zip(loops.driven_states, driven, strict=True)]
    return _apart(loops, nominal, start, starts, parameters, driven, moved, shape, switch)


def _standing(loops: Loops, start: Pose, starts: Starts | None, driven: Sequence[Array], shape: Shape) -> Found:
    given: Sequence[Value] = start.state if starts is None else starts.state
    state: list[Value] = [np.array(np.broadcast_to(x, shape)) for x in given]
    for place, value in zip(loops.driven_states, driven, strict=True):
        state[place] = np.broadcast_to(value, shape)
    reached = np.ones(shape, dtype=bool) if starts is None else np.array(np.broadcast_to(starts.closed, shape))
    return Found(state, reached)


def _apart(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    starts: Starts | None,
    parameters: Sequence[Value],
    driven: Sequence[Array],
    moved: Sequence[Mask],
    shape: Shape,
    switch: bool,
) -> Found:
    """Poses where only one drive has moved, drive by drive, and those where several have moved."""
    out = _standing(loops, start, starts, driven, shape)
    for drive, chosen in _groups(loops, moved, shape):
        own = members_of(parameters, chosen)
        aims = [np.broadcast_to(x, shape)[chosen] for x in driven]
        begin = None if starts is None else _chosen(starts, chosen, shape)
        if drive is not None:
            part = Along(loops, nominal, start, begin, drive, switch).poses(aims, own, aims[0].shape)
            out.patches += [patch.of(chosen) for patch in part.patches]
            if part.nearly is not None:
                out.nearly = np.zeros(shape, dtype=bool) if out.nearly is None else out.nearly
                out.nearly[chosen] = part.nearly
            state, reached = part.state, part.reached
        else:
            state, reached = _on_rays(loops, nominal, start, begin, own, aims)
        out.reached[chosen] = reached
        for place in loops.unknown_states:
            np.asarray(out.state[place])[chosen] = state[place]
    return out


def _groups(loops: Loops, moved: Sequence[Mask], shape: Shape) -> Iterator[tuple[int | None, Mask]]:
    """Each drive with the poses where only it has moved; last None, with the poses where several have moved."""
    count = np.zeros(shape, dtype=int)
    for each in moved:
        count += each
    if not loops.driven_spherical:
        for k, each in enumerate(moved):
            alone = each & (count == 1)
            if alone.any():
                yield k, alone
    rest = count > (0 if loops.driven_spherical else 1)
    if rest.any():
        yield None, rest


def _chosen(starts: Starts, chosen: Mask, shape: Shape) -> Starts:
    state, determinants = (
        [np.broadcast_to(x, shape)[chosen] for x in each] for each in (starts.state, starts.determinants)
    )
    return Starts(list(state), list(determinants), np.broadcast_to(starts.closed, shape)[chosen])


def _on_rays(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    starts: Starts | None,
    parameters: Sequence[Value],
    aims: Sequence[Array],
) -> tuple[list[Value], Mask]:
    """States of the poses (M,) where several drives have moved, and which of them are reached."""
    targets = np.stack(aims)
    if starts is None:
        states, reached, closed = from_one(loops, nominal, start, targets)
    else:
        begun = starts.closed
        states, reached, closed = np.stack(starts.state), np.zeros(begun.shape, dtype=bool), np.zeros_like(begun)
        own = taken(parameters, begun)
        states[:, begun], reached[begun] = along_rays(loops, own, states[:, begun], targets[:, begun])
    states[loops.driven_states] = targets
    rough = reached & ~closed
    for block in blocks(reached.shape, reached.size if loops.at_once(reached.shape) else TOGETHER):
        part = states[:, block[0]]
        begin = loops.unit(list(part)) if loops.driven_spherical else list(part)
        found = loops.close_all(begin, cut_all(parameters, block))
        rough[block] &= ~found.trusted
        better = found.trusted & ~closed[block]
        for row, x in zip(part, found.state, strict=True):
            np.copyto(row, x, where=better)
    sharpened(loops, parameters, states, rough)
    return list(states), reached


def _measured(loops: Loops, parameters: Sequence[Value], found: Found, shape: Shape) -> Array:
    """Closure error of every pose, (...)."""
    error = loops.gaps(found.state, parameters, shape)
    if error is None:
        error = np.empty(shape)
        for block in blocks(shape):
            error[block] = open_by(loops, cut_all(found.state, block), cut_all(parameters, block))
    return error
