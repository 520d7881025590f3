"""States of a pose, as numbers to count and compare, with the text that `Motion.status` begins with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....framework.states import State, States, put, states_of


class PoseState(State):
    """State of a pose: `Motion.state` holds these numbers, `Motion.status` describes each in words.

    * ``REGULAR``
    * ``NEAR_DEAD_POINT``: all results hold, with fewer digits.
    * ``SINGULAR_DIRECT``: a direct-kinematic singularity, of type II: something moves with the drives locked, as in a
      dead point or a change point.
    * ``SINGULAR_INVERSE``: an inverse-kinematic singularity, of type I: the drives move a joint's point in fewer
      directions than elsewhere. Results hold.
    * ``OTHER_MODE``: in another assembly mode, not reachable from the reference configuration; results are NaN unless
      ``move(..., other_modes=True)`` asked for them.
    * ``NOT_ASSEMBLED``: results are NaN.

    Examples
    --------
    >>> import numpy as np
    >>> from linkframe.models import Linkage, PoseState
    >>> linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 0))
    >>> linkage.link("crank", "A", "B"); linkage.link("rod", "B", "C"); linkage.link("piston", "C")
    >>> linkage.revolute("A", "ground", "crank", drive=True)
    >>> linkage.revolute("B", "crank", "rod"); linkage.revolute("C", "rod", "piston")
    >>> linkage.prismatic("C", "ground", "piston", name="slide", axis=(1, 0))
    >>> motion = linkage.move(A=np.radians([-100.0, -90.0, 0.0, 90.0]))
    >>> int(np.count_nonzero(motion.state == PoseState.SINGULAR_INVERSE)), motion.is_regular.tolist()
    (2, [True, False, True, False])
    """

    REGULAR = 0
    NEAR_DEAD_POINT = 1
    SINGULAR_DIRECT = 2
    SINGULAR_INVERSE = 3
    OTHER_MODE = 4
    NOT_ASSEMBLED = 5


def closure_states(reached: NDArray[np.bool_], other: NDArray[np.bool_]) -> States:
    """State of each pose by its closure, (...): regular, in another assembly mode, or not assembled.

    Parameters
    ----------
    reached
        Whether the loops close on the path from the reference configuration, (...).
    other
        Whether they close in another assembly mode, (...).
    """
    states = put(states_of(reached.shape, PoseState.NOT_ASSEMBLED), other, PoseState.OTHER_MODE)
    return put(states, reached, PoseState.REGULAR)


def singular_states(ratio: NDArray[np.float64], near: float, singular: float, lost: NDArray[np.bool_]) -> States:
    """State of each pose by its Jacobian, (...).

    Parameters
    ----------
    ratio
        Conditioning, (...); NaN where the pose is not assembled.
    near, singular
        Conditioning below which a pose is near a dead point, and in one.
    lost
        Whether a joint's point has lost a direction of motion, (...).
    """
    states = put(states_of(ratio.shape, PoseState.REGULAR), lost, PoseState.SINGULAR_INVERSE)
    states = put(states, ratio < near, PoseState.NEAR_DEAD_POINT)
    return put(states, ratio < singular, PoseState.SINGULAR_DIRECT)
