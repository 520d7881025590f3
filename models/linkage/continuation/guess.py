"""Starting values of the poses of one moving drive, before Newton's method closes them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.terms import Value
from .follow import Guide

# Distance from a change point within which signs of determinants are not compared.
NEAR = 0.02


@dataclass(eq=False)
class Guess:
    """Starting values for the leading member, of the batch shape of the drives.

    Attributes
    ----------
    state
        Entries of the state, (...).
    signs
        Signs that the determinants must have, 0 where they may have either, (...).
    reached
        Whether the path leads to the pose, (...).
    s
        Value of the only moving drive, (...); None where several move.
    guide
        The path of that drive.
    drive
        Index of that drive among the driven states.
    around
        By change point, the smooth branch through it.
    switched
        Whether the path takes the other branch at change points.
    closed
        Whether all states are closed, with the expected signs, for the dimensions of the leading member.
    """

    state: list[Value]
    signs: list[Value]
    reached: NDArray[np.bool_]
    s: Array | None = None
    guide: Guide | None = None
    drive: int = 0
    around: dict[float, Guide] = field(default_factory=dict)
    switched: bool = False
    closed: bool = False
