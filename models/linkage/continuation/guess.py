"""What is known of the poses before they are closed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.terms import Value
from .follow import Guide

# Signs of determinants are not compared so near a change point.
NEAR = 0.02


@dataclass(eq=False)
class Guess:
    """Nominal states over the drives' shape.

    Attributes
    ----------
    state
        Entries of the state, (...).
    signs
        Signs that the determinants must have, 0 where they may have either, (...).
    reached
        Where the path leads, (...).
    s
        Value of the only moving drive, (...); None where several move.
    guide
        What led along it.
    drive
        Which of the driven states it is.
    around
        What leads smoothly through each change point.
    switched
        Whether the path takes the other branch there.
    closed
        Whether all states are closed for the nominal dimensions, and borne out.
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
