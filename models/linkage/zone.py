"""How likely it is that a point of a linkage leaves its zone."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import Array
from ...framework.errors import FrameError
from ..distributions import Uncertain
from ..failure.reliability import Reliability, reliability
from .poses.coordinates import coordinate_of
from .poses.kinematics import Kinematics

# Points from which likely failures are sought: the middle of the zone has no slope, and the zone is left on all sides.
STARTS = 5


class Movable(Protocol):
    """What is asked of a linkage."""

    def move(self, drives: Mapping[str, ArrayLike], /) -> Kinematics:
        """Its motion at values of its drives."""


Build = Callable[..., Movable]


def reliability_of(
    motion: Kinematics,
    point: str,
    limit: float,
    build: Build,
    distributions: Mapping[str, Uncertain],
    **options: Any,
) -> Reliability:
    """Probability that a point leaves a ball about its nominal position; see `Motion.reliability`."""
    margin = margin_of(motion, point, limit, build)
    return reliability(margin, distributions, poses=margin.poses, **{"starts": STARTS, **options})


def margin_of(motion: Kinematics, point: str, limit: float, build: Build) -> Margin:
    """The limit state that a point leaves a ball about its nominal position, checked."""
    if len(motion.shape) > 1:
        raise FrameError(f"reliability of a motion of shape {motion.shape}: give it one axis of poses")
    if not (np.ndim(limit) == 0 and np.isfinite(limit) and limit > 0.0):
        raise FrameError(f"limit of point {point!r} is {limit!r}: give the radius of its zone, a length above zero")
    lost = np.flatnonzero(np.isnan(np.atleast_2d(motion.position(point))).any(axis=-1))
    if lost.size:
        raise FrameError(
            f"the nominal motion has no position of {point!r} at pose number {lost[0]}, where it cannot be assembled: "
            "leave that pose out"
        )
    return Margin(motion, point, float(limit), build)


def relative_margin(motion: Kinematics, point: str, limit: float, build: Build) -> Margin:
    """The same as a share of the zone, as others hold limit states against tolerances that know no units."""
    margin = margin_of(motion, point, limit, build)
    margin.unit = margin.limit
    return margin


class Margin:
    """What is left of the zone, smooth at its middle: ``(limit² - off²) / limit`` of the distance off."""

    def __init__(self, motion: Kinematics, point: str, limit: float, build: Build) -> None:
        self.point, self.limit, self.build = point, limit, build
        self.poses = motion.shape[0] if motion.shape else None
        self.unit = 1.0
        self.nominal = motion.position(point)
        self.drives = {name: driven_values(motion, name) for name in motion.linkage.drives}

    def __call__(self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None = None) -> Array:
        at = () if pose is None else pose
        moved = self.build(**samples).move({name: values[at] for name, values in self.drives.items()})
        off = moved.position(self.point) - self.nominal[at]
        left: Array = self.limit - np.sum(off * off, axis=-1) / self.limit
        return left / self.unit


def driven_values(motion: Kinematics, name: str) -> Array:
    """Values of a drive as `move` takes them, (...) or (..., f)."""
    pair, driven = motion.linkage.joint(name), motion.linkage.drives[name]
    values = coordinate_of(motion, pair)[..., [pair.kind.coordinates.index(each) for each in driven]]
    return values[..., 0] if len(driven) == 1 else values
