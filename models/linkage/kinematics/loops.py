"""Newton's method on the loops of a mechanism for all poses of a batch, by NumPy or by machine code."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ....framework.program.calculation import worth_compiling
from ....framework.program.recording import choose
from .blocks import MEMBERS, blocks, cut_all, members_of, shape_of
from .closed_poses import Closed, Poses
from .closing import Closing
from .loop_coordinates import CONTRACTION, FIRST_STEP, ITERATIONS, LAST_STEP, LoopCoordinates
from .terms import Value


class Loops(LoopCoordinates):
    """The closing equations of a mechanism as a system in its unknown coordinates.

    Parameters
    ----------
    mechanism
        The compiled linkage.
    rank
        Rank of the equations; None for full rank.
    tolerance
        Largest gap of a closed pose, in units of the mechanism's size, if more than rounding is accepted.

    Attributes
    ----------
    kept
        The last paths of a single drive, ahead (True) and back, with the key of what they depend on.
    guide
        The last pair of paths that was joined to a guide, and the guide.
    derivatives
        Derivatives at the reference configuration, once known. The continuation finds these three and stores them here,
        so that they live as long as the loops.
    """

    iterations = ITERATIONS

    def gaps(self, state: Sequence[Value], parameters: Sequence[Value], shape: Shape) -> Array | None:
        """Closure errors of a long batch by machine code; None if that does not pay, or if any is NaN."""
        made = self.closing.gap().run([state, parameters], shape) if worth_compiling(math.prod(shape)) else None
        if made is None:
            return None
        error: Array = made[0][0][0]
        return None if np.isnan(error).any() else error

    @property
    def closing(self) -> Closing:
        """Recorded programs of the closure, for long batches."""
        return Closing(self)

    def at_once(self, shape: Shape, *, followed: bool = False) -> bool:
        """Whether machine code runs `close_all`, or `poses` if `followed`; it takes a batch whole."""
        if not worth_compiling(math.prod(shape)):
            return False
        written = self.closing.poses() if followed else self.closing.close()
        return written is not None and written.choice(shape).compiled

    # -- all poses --------------------------------------------------------------------------------------------------

    def close_all(self, state: list[Value], parameters: Sequence[Value]) -> Closed:
        """Closed poses of a batch from the guesses `state`; driven entries are kept.

        Each member stops at its own last step, so that its bits do not depend on its neighbours.
        """
        shape = shape_of(state, parameters)
        if math.prod(shape) <= MEMBERS:
            return self._close_all(state, parameters, shape)
        return self._closed_at_once(state, parameters, shape) or self._in_blocks(state, parameters, shape)

    def _closed_at_once(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Closed | None:
        """`close_all` by machine code, if that pays; poses that it leaves open are closed by NumPy."""
        written = self.closing.close() if worth_compiling(math.prod(shape)) else None
        made = written and written.run([state, parameters, self.closing.shares], shape)
        if not made:
            return None
        (unknown, (trusted,), determinants), _ = made
        found, converged = self.placed(unknown, state), trusted
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
            here = self._close_all(part, own, shape_of(part, own))
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
        """One iteration of `close_all`, on arrays or recorded terms: the next state, and the updated marks.

        Parameters
        ----------
        step
            The step of each unknown.
        state
            Entries of the state.
        trusted, moving
            Whether each pose has contracted so far, and whether it is still iterated.
        before
            Size of the last step.
        """
        size = _largest(step)
        bad = ~(size <= FIRST_STEP) | ((before > 1e-5) & (size > CONTRACTION * before))
        trusted = trusted & ~(bad & moving)
        if isinstance(moving, np.ndarray) and moving.all():
            before, state = size, self.advance(state, step, back=True)
        else:
            before, state = choose(moving, size, before), self._moved(state, step, moving)
        return state, trusted, moving & (size > LAST_STEP) & (size < 1e3), before

    @staticmethod
    def converged(before: Any) -> Any:
        """Whether the last step was so small that the next one would be below rounding."""
        return before <= LAST_STEP

    def poses(self, state: list[Value], parameters: Sequence[Value]) -> Poses:
        """`close` for all members of a batch: poses near the guesses `state`, accurate enough for continuation.

        Members do not depend on each other.
        """
        shape = shape_of(state, parameters)
        return self._poses_at_once(state, parameters, shape) or self._poses(state, parameters, shape)

    def _poses_at_once(self, state: list[Value], parameters: Sequence[Value], shape: Shape) -> Poses | None:
        """`poses` by machine code, if that pays; poses that it does not find are sought by NumPy."""
        written = self.closing.poses() if worth_compiling(math.prod(shape)) else None
        made = written and written.run([state, parameters, self.closing.shares], shape)
        if not made:
            return None
        (unknown, follow, determinants, (first, last), (good,)), _ = made
        found = self.placed(unknown, state)
        if not good.all():
            bad = ~good
            left = (int(np.count_nonzero(bad)),)
            rest = self._poses(members_of(state, bad), members_of(parameters, bad), left)
            first[bad], last[bad], good[bad] = rest.first_step, rest.last_step, rest.good
            own = [rest.state[place] for place in self.unknown_states]
            for x, y in zip((*unknown, *follow, *determinants), (*own, *rest.follow, *rest.determinants), strict=True):
                x[bad] = y
        return Poses(found, list(follow), list(determinants), first, last, good)

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
            state, good, last = self.arrived(found[:n], state, good, moving, last)
        behind = n + len(self.equations.followers)
        return Poses(state, list(found[n:behind]), list(found[behind:]), first, np.broadcast_to(last, shape), good)

    def approached(
        self, step: Sequence[Any], state: list[Any], good: Any, moving: Any, first: Any, last: Any
    ) -> tuple[list[Any], Any, Any, Any, Any]:
        """One iteration of `poses`, on arrays or recorded terms; `first` is -1 before the first step.

        Parameters
        ----------
        step
            The step of each unknown.
        state
            Entries of the state.
        good, moving
            Whether each pose has contracted so far, and whether it is still iterated.
        first, last
            Sizes of the first and the last step.
        """
        size = _largest(step)
        first = choose(first < 0.0, size, first)
        lost = ~(size <= FIRST_STEP) | ((last > 1e-6) & (size > CONTRACTION * last))
        good = good & ~(lost & moving)
        moving = moving & good
        state = self._moved(state, step, moving)
        return state, good, moving & (size >= 1e-3), first, choose(moving, size, last)

    def arrived(
        self, step: Sequence[Any], state: list[Any], good: Any, moving: Any, last: Any
    ) -> tuple[list[Any], Any, Any]:
        """The last step of `poses`, on arrays or recorded terms, which poses are good, and the size of that step."""
        size = _largest(step)
        good = good & ~moving & (size <= np.maximum(CONTRACTION * last, 1e-12))
        return self._moved(state, step, good), good, size

    def _moved(self, state: list[Any], step: Sequence[Any], where: Any) -> list[Any]:
        """`advance` back by `step` for some poses; the others keep their bits, which scaling to unit length changes."""
        out = self.advance(state, step, back=True)
        for place in self.unknown_states:
            out[place] = choose(where, out[place], state[place])
        return out

    def rates_at_once(
        self,
        state: Sequence[Value],
        parameters: Sequence[Value],
        rates: Sequence[Value],
        changes: Sequence[Value],
        shape: Shape,
    ) -> tuple[list[Value], list[Value]] | None:
        """`velocities` and `accelerations` of a long batch by machine code; None if that does not pay."""
        written = self.closing.rates() if worth_compiling(math.prod(shape)) else None
        made = written and written.run([state, parameters, (), [*rates, *changes]], shape)
        if not made:
            return None
        velocities, accelerations = made[0]
        return velocities, accelerations


def _largest(step: Sequence[Any]) -> Any:
    """The largest magnitude of entries, NaN if one is, for arrays or recorded terms."""
    sizes = [abs(x) for x in step if not (isinstance(x, float) and x == 0.0)]
    return reduce(np.maximum, sizes) if sizes else np.zeros(())
