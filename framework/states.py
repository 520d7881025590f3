"""States of the entries of a batch as numbers to count and compare, with a text for each."""

from __future__ import annotations

from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

States = NDArray[np.int8]


class State(IntEnum):
    """A state as a number from 0 on, with its name in words as text."""

    @property
    def text(self) -> str:
        """The state in words."""
        return self.name.lower().replace("_", " ")


class SolutionState(State):
    """State of a solution at one batch entry: `Solution.state` and `LargeSolution.state` hold these numbers.

    Linear solutions have the first six and the last; those at large displacement the other four, the second and
    ``ABSENT``.

    * ``REGULAR``: all results hold.
    * ``STATICALLY_CONSISTENT_MECHANISM``: the frame can move, but the load does no work on its free motion; forces
      hold, displacements along that motion are NaN.
    * ``FREE``: joints can move within their clearances without any force; the results are one of many possible.
    * ``UNRESOLVED``: rounding hides a contact; or results are NaN, as ideal joints close a loop of rigid links that no
      offsets within the clearances satisfy.
    * ``MECHANISM``: the frame is kinematically unstable, loads move it without resistance; results are NaN.
    * ``ABSENT``: the entry was left out; results are NaN.
    * ``STABLE``, ``STABLE_BEYOND_A_SADDLE``, ``UNSTABLE``, ``NOT_CONVERGED``: of equilibria at large displacement.
    * ``POSE_NOT_REGULAR``: a regular solution at a pose of a motion that is not; `status` is that of the motion.

    Examples
    --------
    >>> from linkframe.framework import Frame, SolutionState
    >>> frame = Frame()
    >>> frame.node("A", (0.0, 0.0, 0.0))
    >>> frame.load("A", fx=[1.0, 2.0, 3.0])
    >>> state = frame.solve().state
    >>> int(np.count_nonzero(state == SolutionState.MECHANISM))
    3
    >>> SolutionState(state[0]).text
    'mechanism'
    """

    REGULAR = 0
    STATICALLY_CONSISTENT_MECHANISM = 1
    FREE = 2
    UNRESOLVED = 3
    MECHANISM = 4
    ABSENT = 5
    STABLE = 6
    STABLE_BEYOND_A_SADDLE = 7
    UNSTABLE = 8
    NOT_CONVERGED = 9
    POSE_NOT_REGULAR = 10


class ClearanceState(State):
    """State of a joint with clearance at one batch entry: `Contact.state` holds these numbers.

    * ``CLOSED``: in contact.
    * ``OPEN``: not in contact, at a position that the rest of the frame determines.
    * ``FREE``: not in contact and movable within the clearance without any force, so that displacements that depend on
      it are one choice of many.
    * ``UNRESOLVED``: the load is so small compared with the stiffness against closing the clearance that rounding hides
      the contact; or no offset is compatible, as between rigid links and ideal joints in one line; or, at large
      displacement, no equilibrium was found.
    * ``MECHANISM``: the frame is one even without clearances.
    * ``ABSENT``: the entry was left out.

    Examples
    --------
    >>> from linkframe.framework import ClearanceState
    >>> ClearanceState.CLOSED.text
    'closed'
    """

    CLOSED = 0
    OPEN = 1
    FREE = 2
    UNRESOLVED = 3
    MECHANISM = 4
    ABSENT = 5


def states_of(shape: tuple[int, ...], state: State) -> States:
    """A batch of one state."""
    return np.full(shape, state, dtype=np.int8)


def put(states: States, where: NDArray[np.bool_], state: State) -> States:
    """The states with `state` at the entries `where`; both broadcast."""
    nowhere = where.shape == states.shape and not where.any()
    return states if nowhere else np.where(where, np.int8(state), states)


def among(states: States, *some: State) -> NDArray[np.bool_]:
    """Mask of the entries whose state is one of `some`, (...)."""
    return np.isin(states, some)


def words(states: States, kind: type[State]) -> NDArray[np.str_]:
    """The texts of states, (...); if all are the same, a broadcast view of one."""
    if states.size and states.min() == (most := states.max()):
        return np.broadcast_to(np.array(kind(most).text), states.shape)
    return np.asarray(np.array([state.text for state in kind])[states])
