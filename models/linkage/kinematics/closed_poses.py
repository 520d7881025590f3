"""Results of Newton's method on the closing equations: closed poses, of one linkage or of a batch."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .terms import Value


@dataclass(frozen=True, eq=False)
class Pose:
    """A closed pose with its derivatives by the drives.

    Attributes
    ----------
    state
        State of all joints, (n,).
    follow
        Velocities of the `Equations.followers` per unit velocity of their drives.
    determinants
        Determinants of the blocks of equations.
    first_step, last_step
        Largest change of a coordinate in the first and in the last Newton step.
    """

    state: list[float]
    follow: list[float]
    determinants: list[float]
    first_step: float
    last_step: float = math.inf


@dataclass(frozen=True, eq=False)
class Closed:
    """Closed poses of a batch.

    Attributes
    ----------
    state
        Entries of the state, (...) each.
    trusted
        Whether Newton's method converged, and contracted from the first step on, (...).
    converged
        Whether its last step was small enough, (...).
    determinants
        Determinants of the blocks of equations, (...) each.
    """

    state: list[Value]
    trusted: NDArray[np.bool_]
    converged: NDArray[np.bool_]
    determinants: list[Value]


class ClosedOne(NamedTuple):
    """A closed pose: its state, and the determinants of the blocks of equations."""

    state: list[float]
    determinants: list[float]


@dataclass(frozen=True, eq=False)
class Poses:
    """As `Pose` for a batch, entries of shape (...); `good` marks the poses that are found, (...)."""

    state: list[Value]
    follow: list[Value]
    determinants: list[Value]
    first_step: Array
    last_step: Array
    good: NDArray[np.bool_]
