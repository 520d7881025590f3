"""Closed poses of a mechanism, one or a batch, with the determinants of their equations."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .terms import Value


@dataclass(frozen=True, eq=False)
class Pose:
    """A closed position: its state, how it follows the drives, and the determinants of its equations.

    Attributes
    ----------
    state
        State of all joints.
    follow
        Velocity of each unknown per unit of each drive, drive by drive.
    determinants
        Of the blocks of equations.
    first_step, last_step
        Largest change that the first and the last Newton step made.
    """

    state: list[float]
    follow: list[float]
    determinants: list[float]
    first_step: float
    last_step: float = math.inf


@dataclass(frozen=True, eq=False)
class Closed:
    """Closed positions of a batch: state entries, where they are trusted, their first step and determinants."""

    state: list[Value]
    trusted: NDArray[np.bool_]
    converged: NDArray[np.bool_]
    determinants: list[Value]


@dataclass(frozen=True, eq=False)
class ClosedOne:
    """A closed position: its state, and the determinants of its equations."""

    state: list[float]
    determinants: list[float]


@dataclass(frozen=True, eq=False)
class Poses:
    """As `Pose`, of all members of a batch, and which of them are found."""

    state: list[Value]
    follow: list[Value]
    determinants: list[Value]
    first_step: Array
    good: NDArray[np.bool_]
