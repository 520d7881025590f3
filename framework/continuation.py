"""Continuation: paths of solutions, followed by predictor and corrector in steps of their own choice.

A step is tried. Where the corrector finds no point, or none that can be the next of the same path, half the step is
tried, until it is too short: there the path has stalled. From a point that was found, the path itself says how long the
next step may be (Allgower and Georg, Introduction to Numerical Continuation Methods, 2003, ch. 6). Whether a step is a
change of a parameter or a length of arc is for predictor and corrector to say.

Events between two points are located by changes of sign.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np
from numpy.typing import NDArray

from .batch import Array

Index = NDArray[np.intp]
Mask = NDArray[np.bool_]
Point = TypeVar("Point")
Points = TypeVar("Points")


def follow(
    attempt: Callable[[float], Point | None],
    accept: Callable[[Point, float], float | None],
    step: float,
    shortest: float,
) -> bool:
    """Follow one path from point to point.

    Parameters
    ----------
    attempt
        Predictor and corrector: the point that lies a given step ahead, None where none is found.
    accept
        Accepts a point, found by a given step, and returns the next step to try; None if the path is to end.
    step
        The first step to try.
    shortest
        Length of a step below which the path has stalled.

    Returns
    -------
    bool
        True if `accept` ended the path, False if it has stalled.
    """
    while True:
        point = attempt(step)
        if point is None:
            step *= 0.5
            if not step > shortest:
                return False
        else:
            further = accept(point, step)
            if further is None:
                return True
            step = further


class PathBatch(ABC, Generic[Points]):
    """Paths that are followed side by side, each in steps of its own, as `follow` does one.

    Parameters
    ----------
    step
        For each path the next step to try, (paths,).
    shortest
        Length of a step below which a path has stalled; one for all, or (paths,).

    Attributes
    ----------
    stalled
        Paths whose steps have become too short, (paths,).
    """

    def __init__(self, step: Array, shortest: float | Array) -> None:
        self.step, self.shortest = step, np.broadcast_to(shortest, step.shape)
        self.stalled: Mask = np.zeros(step.shape, dtype=bool)

    @abstractmethod
    def wanted(self) -> Index:
        """Paths that are to be taken further."""

    @abstractmethod
    def attempt(self, paths: Index) -> tuple[Points, Mask]:
        """Predictor and corrector: points a step ahead on some paths, and which of these are good to go on from."""

    @abstractmethod
    def accept(self, paths: Index, points: Points, good: Mask) -> None:
        """Go on to the `good` ones of some points, which lie on these paths, and set their next steps."""

    def shortened(self, paths: Index) -> None:
        """Do what is due on paths whose steps have just been halved."""

    def run(self) -> None:
        """Follow all paths as far as wanted, or until they have stalled."""
        while (paths := self.wanted()).size:
            points, good = self.attempt(paths)
            self.accept(paths[good], points, good)
            failed = paths[~good]
            if failed.size:
                self.step[failed] *= 0.5
                self.shortened(failed)
                self.stalled[failed] = ~(self.step[failed] > self.shortest[failed])


# -- what happens on the way ------------------------------------------------------------------------------------------


def sign_change(
    value: Callable[[float], float], before: tuple[float, float], after: tuple[float, float], rounds: int
) -> float:
    """Where a value that changes its sign between two points of a path is about zero, as `Zeros` finds it.

    Parameters
    ----------
    value
        The value at a place on the path; NaN or zero end the search.
    before, after
        Place and value at the two points, of opposite signs.
    rounds
        How many values are asked for, at most.

    Returns
    -------
    float
        The last place that was tried.
    """
    zero = Zeros(np.array([*before]), np.array([*after]))
    place = before[0]
    for _ in range(rounds):
        place = float(zero.place())
        middle = value(place)
        if not abs(middle) > 0.0:
            break
        zero.narrow(np.array([place, middle]), np.ones((), dtype=bool))
    return place


class Zeros:
    """Zeros of values between two places of opposite sign each, by false position, side by side (...).

    The value at the end that stays is halved each time, so that both ends come nearer (as by the Illinois rule, which
    does so from the second time on; Dowell and Jarratt, BIT 11 (1971) 168-174).

    Parameters
    ----------
    left, right
        Points on both sides, (k, ...): the place first, the value last.
    """

    def __init__(self, left: Array, right: Array) -> None:
        self.left, self.right = left, right
        self.low, self.high = left[-1], right[-1]

    def place(self) -> Array:
        """Places to try next (...)."""
        out: Array = (self.left[0] * self.high - self.right[0] * self.low) / (self.high - self.low)
        return out

    def narrow(self, middle: Array, which: Mask) -> None:
        """Go on with the points that were found at these places (k, ...), of some zeros (...); others stay.

        Where the value is NaN, the next place is one nearer to the left.
        """
        left = which & (middle[-1] * self.low > 0.0)
        right = which & (middle[-1] * self.low <= 0.0)
        low = np.where(left, middle[-1], np.where(which, 0.5 * self.low, self.low))
        self.high = np.where(left, 0.5 * self.high, np.where(right, middle[-1], self.high))
        self.low = low
        self.left, self.right = np.where(left, middle, self.left), np.where(right, middle, self.right)
