"""Status of the batch entries of a linear solution, their free motions, and NaN in place of meaningless results."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, one_entry
from ..batched.broadcast import BroadcastSolver
from ..error_bounds.resolved import kinematically_stable
from ..errors import MechanismWarning
from ..provenance import regular_there, with_origin
from ..results.singular import FreeMotion, free_motion
from ..results.status import describe
from ..states import ClearanceState, SolutionState, States, put, states_of, words
from ..structure.parts import Row
from .solved import SolvedFrame


class FrameStates(SolvedFrame):
    """A solved frame with the status of each batch entry, which warns where results do not hold."""

    @property
    def status(self) -> NDArray[np.str_]:
        """State of each batch entry in words, (...).

        ``regular``: all results hold.
        ``mechanism``: kinematically unstable, as judged in extended precision; `distance_to_singularity` is of the
        order of rounding, 1e-15. Results are NaN.
        ``statically consistent mechanism``: the load does no work on the free motion. Forces hold, and displacements
        except those along the free motion, which are NaN (a `MechanismWarning` says so); parts that no load reaches
        have zero displacement, and so has a free motion that at every node goes, and turns, across the others.
        ``free``: a joint can move within its clearance without any force; the results are one choice of many.
        ``unresolved``: rounding hides a contact, or no position of the journals fits between rigid links, as links in
        one line; results are NaN.
        ``absent``: left out by ``frame.exclude``.
        Where the frame was made from a motion, entries at which the motion is not regular carry the motion's status,
        such as ``near dead point``.
        """
        return with_origin(words(self.own_state, SolutionState), self.frame.made_from, self.shape)

    @cached_property
    def state(self) -> States:
        """`status` as numbers, (...): see `linkframe.framework.SolutionState`."""
        special = (self.own_state == SolutionState.REGULAR) & ~regular_there(self.frame.made_from)
        return put(self.own_state.copy(), special, SolutionState.POSE_NOT_REGULAR)

    @cached_property
    def own_state(self) -> States:
        """State of the solution alone, (...), without that of the motion from which the frame was made."""
        if self.pressed is not None:
            return self.pressed.without_clearance.own_state
        moving = self.solver.singular(excited=False)
        if isinstance(self.solver, BroadcastSolver) and moving.any():
            moving = moving & ~kinematically_stable(self.plan, moving)
        state = put(states_of(self.shape, SolutionState.REGULAR), moving, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.consistent_mechanisms is not None:
            state = put(state, self.consistent_mechanisms.mask, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.plan.entry is None:
            state = put(state, self.primary.at_rest, SolutionState.STATICALLY_CONSISTENT_MECHANISM)
        if self.clearances is not None:
            for contact, whole in (
                (ClearanceState.FREE, SolutionState.FREE),
                (ClearanceState.UNRESOLVED, SolutionState.UNRESOLVED),
            ):
                state = put(state, (self.clearances.state == contact).any(axis=0), whole)
        state = put(state, self._singular, SolutionState.MECHANISM)
        return state if self.frame.absent is None else put(state, self.frame.absent, SolutionState.ABSENT)

    @property
    def movable(self) -> NDArray[np.bool_]:
        """Entries at which a loaded part of the frame has a free motion, (...)."""
        return (
            self._singular if self.consistent_mechanisms is None else self._singular | self.consistent_mechanisms.moving
        )

    @cached_property
    def _singular(self) -> NDArray[np.bool_]:
        """Entries that are kinematically unstable under the loads, (...)."""
        if self.pressed is not None:
            return self.pressed.without_clearance.movable
        if self.plan.entry is not None:
            return np.zeros(self.shape, dtype=bool)
        found = self.primary.singular
        if self.resolved is not None:
            found = found & ~self.resolved.mask
        if self.consistent_mechanisms is not None:
            found = found & ~self.consistent_mechanisms.mask
        found = found & ~self.primary.at_rest
        return found if self.frame.absent is None else found & ~self.frame.absent

    def mechanism(self, *entry: int) -> str:
        """Free motions at a batch entry in words: which nodes move in which direction without resistance.

        Parameters
        ----------
        *entry
            Indices of a batch entry, one for each batch axis.

        Returns
        -------
        str
            Such as ``free motion 1: B (+uy +rz), C (+uy)``, nodes that move most first; empty where there is none.

        Raises
        ------
        FrameError
            If the batch has no such entry.
        """
        # free motions do not depend on the contact states
        plan = self.plan if self.pressed is None else self.pressed.without_clearance.plan
        return describe(plan, one_entry(self.shape, entry, "mechanism"))

    def free_motion(self, *entry: int) -> FreeMotion:
        """Free motions at a batch entry: their displacements, the joints that turn, and the work of the loads on them.

        Parameters
        ----------
        *entry
            Indices of a batch entry, one for each batch axis.

        Returns
        -------
        FreeMotion
            The ``count`` independent motions, arrays (count, ...); ``count`` is 0 where everything is constrained.

        Raises
        ------
        FrameError
            If the batch has no such entry.

        Examples
        --------
        A rod on a hinge turns about it without resistance.

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A", "ux", "uy", "uz", "rx", "ry"); frame.load("B", fy=1.0)
        >>> motion = frame.solve().free_motion()
        >>> motion.count, abs(motion.displacement("B")[0]).round(9).tolist()
        (1, [0.0, 1.0, 0.0, 0.0, 0.0, 1.0])
        """
        at = one_entry(self.shape, entry, "free_motion")
        return free_motion(self.plan, at, solvable=not self._singular[at])

    def silenced(self) -> Self:
        """Switch off warnings of mechanisms, for a solution that is only an intermediate step.

        Returns
        -------
        Solution
            This solution.
        """
        self._warned = True
        return self

    # -- results where they hold ------------------------------------------------------------------------------------

    def _read(self, key: object, compute: Any, mask: float = np.nan) -> Array:
        if key not in self._known:
            array = compute()
            self._known[key] = self._present(array) if isinstance(key, str) else self._masked(array, mask)
        found = self._known[key]
        found.flags.writeable = False
        return found

    def _unknown(self, bound: Array) -> Array:
        """An error bound with inf at statically consistent mechanisms: rounding may hide a small stiffness there."""
        if self.consistent_mechanisms is not None:
            bound[self.consistent_mechanisms.moving] = np.inf
        return bound

    def _present(self, array: Array, mask: float = np.nan) -> Array:
        if self.frame.absent is not None:
            array = _own(array)
            array[np.broadcast_to(self.frame.absent, self.shape)] = mask
        return array

    def _masked(self, array: Array, mask: float = np.nan) -> Array:
        array = self._present(array, mask)
        if self.clearances is not None and self.clearances.unfit.any():
            array = _own(array)
            array[self.clearances.unfit] = mask
        if self.clearances is None and (self.plan.entry is not None or self.primary.sound):
            return array  # which is regular
        singular = self._singular
        if self.clearances is not None and not (self._warned or singular.any()):
            self._warn_free()
        if singular.any():
            if not self._warned:
                self._warned = True
                warnings.warn(self._warning(singular), MechanismWarning, stacklevel=_reader())
            array = _own(array)
            array[singular] = mask
        return array

    def _warn_free(self) -> None:
        """Warn where no force determines the contact of a journal, so that results are one choice of many."""
        if self.pressed is not None or self.clearances is None:
            return
        if not (self.clearances.state == ClearanceState.FREE).any():
            return  # without a look at all other states, which takes longer
        free = self.state == SolutionState.FREE
        if free.any():
            self._warned = True
            warnings.warn(
                f"{free.sum()} of {free.size} batch entries are free: no force determines the contact of a journal in "
                "its clearance, so that their results are one choice of many, and statistics of them mean nothing",
                MechanismWarning,
                stacklevel=_reader(),
            )

    def _warning(self, singular: NDArray[np.bool_]) -> str:
        if not singular.ndim:
            return f"the frame is kinematically unstable and its results are NaN: {self.mechanism()}"
        entry = tuple(int(k) for k in np.argwhere(singular)[0])
        moving = 0 if self.consistent_mechanisms is None else int(self.consistent_mechanisms.moving.sum())
        more = f", and {moving} more are statically consistent mechanisms, with displacements NaN along the free motion"
        return (
            f"{singular.sum()} of {singular.size} batch entries are kinematically unstable and their results are NaN"
            f"{more if moving else ''}; the first, {entry}: {self.mechanism(*entry)}"
        )

    def _warning_of_consistent_mechanisms(self) -> str:
        assert self.consistent_mechanisms is not None
        entry = tuple(int(k) for k in np.argwhere(self.consistent_mechanisms.moving)[0])
        return (
            "the frame is a statically consistent mechanism: the load does no work on its free motion, and "
            f"displacements along that are NaN: {self.mechanism(*entry)}"
        )

    def _announced(self, found: Array, moved: Array) -> Array:
        # Where there are unstable entries as well, their warning covers both.
        if (
            self.consistent_mechanisms is not None
            and self.consistent_mechanisms.masked(found, moved)
            and not (self._warned or self._singular.any())
        ):
            self._warned = True
            warnings.warn(self._warning_of_consistent_mechanisms(), MechanismWarning, stacklevel=_reader())
        return found

    def _settled(self, rows: Sequence[Row]) -> Array:
        """Values of `rows`, (..., 6); NaN where they are part of a statically consistent mechanism's free motion."""
        found = self.primary.stacked(rows)
        return (
            found
            if self.consistent_mechanisms is None
            else self._announced(found, self.consistent_mechanisms.motions(rows))
        )


def _own(array: Array) -> Array:
    """The array itself if it is writable, else a copy."""
    return array if array.flags.writeable else array.copy(order="K")


def _reader() -> int:
    """Stack level, for a warning of who called this, of the first caller that is not part of linkframe."""
    frame, level = sys._getframe(1), 1
    # calls of cached properties lie in between
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(("linkframe.", "functools")):
        frame, level = frame.f_back, level + 1
    return level
