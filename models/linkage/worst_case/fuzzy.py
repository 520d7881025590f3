"""The worst case at each level of membership of fuzzy clearances and tolerances, exact to first order."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...fuzzy.cuts import FuzzyResult
from ...fuzzy.number import FuzzyNumber, fuzzy_of, levels_of
from ..description.parts import unit_vector
from ..poses.classified import ClassifiedPoses
from .limits import Given, given_of
from .worst_case import WorstCase, worst_case

# Limits that are intervals about the nominal value. Of all others a cut is given by its upper end; of bearing lengths,
# which allow more tilt the shorter they are, by its lower end.
INTERVALS = ("lengths", "drives")
BEARINGS = "journals"
# Limits of which a universal joint, which has two pins, may have a pair.
OF_EACH_PIN = (BEARINGS, "end_play")


@dataclass(frozen=True, eq=False, repr=False)
class FuzzyReach:
    """Where a point can be at each level of membership; made by `Motion.fuzzy`.

    Attributes
    ----------
    levels
        Levels of membership, rising from 0 to 1, (a,).
    worst
        The worst case at each level, of batch shape (a, ...): regions of higher levels lie within those of lower ones.
    """

    levels: Array
    worst: WorstCase

    def __repr__(self) -> str:
        of, greatest = self.worst.sensitivity, self.worst.greatest.reshape(len(self.levels), -1)
        if not np.isfinite(greatest).any():
            return f"<FuzzyReach of {of.point} on {of.link}: no pose is regular>"
        told = f"displaced by up to {np.nanmax(greatest[-1]):.4g} possible, {np.nanmax(greatest[0]):.4g} at all"
        return f"<FuzzyReach of {of.point} on {of.link} at {len(self.levels)} levels: {told}>"

    def along(self, direction: ArrayLike) -> FuzzyResult:
        """Give the cuts of the displacement in a direction.

        Parameters
        ----------
        direction
            Directions, (..., 2 or 3), that broadcast with the poses.

        Returns
        -------
        FuzzyResult
            Cuts of the displacement, lengths, (a, ...).
        """
        n = unit_vector(direction, "direction")
        lower, upper = 0.0 - self.worst.support(-n), self.worst.support(n)
        return FuzzyResult(self.levels, lower, upper, {}, {}, "first order")


def fuzzy_reach(
    motion: ClassifiedPoses, point: str, link: str | None, levels: int | ArrayLike, deviations: Mapping[str, Any]
) -> FuzzyReach:
    """Where a point can be at each level of membership; see `Motion.fuzzy`."""
    at, asked = levels_of(levels), given_of(deviations)
    axes = (len(at), *(1,) * _axes_of_entries(motion, asked))
    given = {
        name: {key: _cuts(name, key, value, at, axes) for key, value in some.items()}
        for name, some in vars(asked).items()
    }
    return FuzzyReach(at, worst_case(motion, point, link, Given(**given)))


def _axes_of_entries(motion: ClassifiedPoses, given: Given) -> int:
    """Number of batch axes of the poses and limits together, which follow the axis of the levels."""
    values = [value for some in vars(given).values() for value in some.values()]
    ends = [end for value in values for end in (value if isinstance(value, tuple) else (value,)) if not _is_fuzzy(end)]
    own = [pair.clearance for pair in motion.linkage.joints.values() if pair.clearance is not None]
    return max(len(motion.shape), *(np.ndim(end) for end in (*ends, *own)), 0)


def _is_fuzzy(value: Any) -> bool:
    return isinstance(value, FuzzyNumber) or (isinstance(value, tuple) and len(value) in (3, 4))


def _cuts(kind: str, key: object, value: Any, levels: Array, axes: tuple[int, ...]) -> Any:
    """A limit at each level: cuts of a fuzzy one, and the same value at all levels for any other, (a, ...)."""
    if kind in OF_EACH_PIN and isinstance(value, tuple) and len(value) == 2:
        return tuple(_cuts(kind, key, each, levels, axes) for each in value)
    if not _is_fuzzy(value):
        # the axis of the levels is there even if no limit is fuzzy
        one = np.ones(axes)
        return tuple(one * end for end in value) if isinstance(value, tuple) else one * np.asarray(value)
    number = fuzzy_of(f"{kind} {key}", value)
    lower, upper = (end.reshape(axes) for end in number.cut(levels))
    if kind in INTERVALS:
        return lower, upper
    if number.lower[0] < 0.0:
        raise FrameError(f"{kind} of {key!r} are fuzzy down to {number.lower[0]:g}: give zero or more")
    return lower if kind == BEARINGS else upper
