"""All poses of a batch: each closed on the branch of the drawing, or told why not."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ..kinematics.blocks import blocks, cut, cut_all
from ..kinematics.loops import Closed, Loops
from ..kinematics.mechanism import Mechanism
from ..kinematics.nearest import nearest, open_by
from ..kinematics.tape import Value
from .change_point import Patch, patched
from .driven import check_driven
from .drives import Drives
from .further import further
from .guess import Guess
from .start import nominal_parameters, started
from .ways import guesses

Mask = NDArray[np.bool_]
# Closed means a residual below this share of the size.
CLOSED = 1e-13
# Where Newton's method is not trusted from the nominal pose, the dimensions are changed in so many steps.
STAGES = (4, 32)


@dataclass(eq=False)
class Assembly:
    """Closed states of a batch.

    Attributes
    ----------
    loops
        The loops.
    shape
        Batch shape of the states.
    state
        Entries of the state, which broadcast to `shape`.
    closed
        Where the loops close, (...).
    verified
        Where they do so on the branch that continues the drawing, (...).
    apart, left
        Where the way begins anew behind a gap; where it has left the drawing's branch for a smoother one, (...).
    gap
        Closure error, a length, (...).
    row
        Closing row with the largest error, (...).
    patches
        Poses in change points; their rates are those of the branch on both sides.
    """

    loops: Loops
    shape: Shape
    state: list[Value]
    closed: Mask
    verified: Mask
    apart: Mask
    left: Mask
    gap: Array
    row: NDArray[np.intp]
    patches: list[Patch]

    @cached_property
    def all_closed(self) -> bool:
        """Whether the loops close everywhere."""
        return bool(self.closed.all())


def assembled(mechanism: Mechanism, drives: Drives, switch: bool, tolerance: float = 0.0) -> Assembly:
    """Close the loops at all values of the drives, up to a tolerance in units of the mechanism's size."""
    if mechanism.begun is None or mechanism.begun[1].tolerance != tolerance:
        nominal = nominal_parameters(mechanism)
        loops, start = started(mechanism, nominal, tolerance)
        check_driven(loops, nominal, start)
        mechanism.begun = nominal, loops, start
    nominal, loops, start = mechanism.begun
    guess = guesses(loops, nominal, start, drives, switch)
    shape = np.broadcast_shapes(drives.shape, mechanism.linkage.shape)
    found = close_batch(loops, guess, mechanism.parameters, nominal, shape)
    found.patches = patched(loops, guess, mechanism.parameters, found)
    _measure(found, mechanism.parameters)
    return found


def close_batch(
    loops: Loops, guess: Guess, parameters: Sequence[Value], nominal: Sequence[float], shape: Shape
) -> Assembly:
    """Close all members of a batch from their guesses, block by block.

    Where the drawing has no batch, and the guesses are closed, that is done.
    """
    unknown = loops.unknown_states
    state: list[Value] = list(guess.state)
    same = guess.closed and not loops.mechanism.linkage.shape
    for place in () if same else unknown:
        state[place] = np.empty(shape)
    out = Assembly(
        loops,
        shape,
        state,
        np.full(shape, same),
        np.array(np.broadcast_to(guess.sure & same, shape)),
        np.broadcast_to(guess.apart, shape),
        np.broadcast_to(guess.reached & ~guess.sure & ~guess.apart, shape),
        np.zeros(shape),
        np.zeros(shape, dtype=np.intp),
        [],
    )
    for block in () if same else blocks(shape):
        begin, dimensions = cut_all(guess.state, block), cut_all(parameters, block)
        size = np.broadcast_shapes(*(np.shape(x) for x in begin), *(np.shape(x) for x in dimensions))
        found = loops.close_all(begin, dimensions)
        reached = np.asarray(cut(guess.reached.astype(np.float64), block)) > 0.0
        signs = cut_all(guess.signs, block)
        good = np.asarray(found.trusted & reached & _same_signs(found, signs))
        closed = good.copy()
        if not good.all():
            there, states = further(loops, guess, block, ~good & ~reached, dimensions, nominal)
            _put(found.state, there, there[there], list(states.T), good.shape)
            good[there] = closed[there] = True
        if not good.all():
            may_be = np.broadcast_to(reached, size) & (_same_signs(found, signs) | ~found.converged)
            _gradually(loops, found, good, closed, (begin, dimensions, signs), nominal, may_be)
        for place in unknown:
            np.asarray(out.state[place])[block] = found.state[place]
        sure = np.asarray(cut(guess.sure.astype(np.float64), block)) > 0.0
        out.closed[block], out.verified[block] = closed, good & sure
    return out


def _same_signs(found: Closed, signs: Sequence[Value]) -> Mask:
    same: Mask = np.ones((), dtype=bool)
    for determinant, sign in zip(found.determinants, signs, strict=True):
        same = same & (np.asarray(determinant) * sign >= 0.0)
    return same


def _gradually(
    loops: Loops,
    found: Closed,
    good: Mask,
    closed: Mask,
    given: tuple[Sequence[Value], Sequence[Value], Sequence[Value]],
    nominal: Sequence[float],
    may_be: Mask,
) -> None:
    """Second tries for the members of a block that are not `good`: small steps, then the least gap.

    `given` are their guesses, dimensions and signs; only where they `may_be` good can they still become it.
    """
    begin, dimensions, signs = given
    shape = good.shape
    for stages in STAGES if any(np.ndim(x) for x in dimensions) else ():
        bad = ~good & may_be
        if not bad.any():
            break
        state, target = _members(begin, bad, shape), _members(dimensions, bad, shape)
        trusted = np.ones(np.count_nonzero(bad), dtype=bool)
        for t in np.arange(1, stages + 1) / stages:
            between = [p + t * (q - p) for p, q in zip(nominal, target, strict=True)]
            step = loops.close_all(state, between)
            state = step.state
            trusted &= step.trusted
        trusted &= _same_signs(step, _members(signs, bad, shape))
        _put(found.state, bad, trusted, state, shape)
        good[bad] = closed[bad] = trusted
    bad = ~good
    if bad.any():
        state, target = _members(begin, bad, shape), _members(dimensions, bad, shape)
        best, error = nearest(loops, state, target)
        _put(found.state, bad, np.ones(error.shape, dtype=bool), best, shape)
        tight = error < max(CLOSED, loops.tolerance)
        closed[bad] = tight
        away = np.max([np.abs(x - y) for x, y in zip(best, state, strict=True)], axis=0, initial=0.0)
        good[bad] = tight & (away < 1e-2) & may_be[bad]


def _members(values: Sequence[Value], chosen: Mask, shape: Shape) -> list[Value]:
    return [np.broadcast_to(x, shape)[chosen] for x in values]


def _put(state: list[Value], chosen: Mask, which: Mask, values: Sequence[Value], shape: Shape) -> None:
    for place, value in enumerate(values):
        whole = np.broadcast_to(state[place], shape).copy()
        whole[chosen] = np.where(which, value, whole[chosen])
        state[place] = whole


def _measure(found: Assembly, parameters: Sequence[Value]) -> None:
    """Closure error of every pose; what does not close after all is not closed."""
    for block in blocks(found.shape):
        error, row = open_by(found.loops, cut_all(found.state, block), cut_all(parameters, block))
        found.gap[block] = error * found.loops.mechanism.size
        found.row[block] = row
        found.closed[block] &= error < max(10.0 * CLOSED, found.loops.tolerance)
    found.verified &= found.closed
