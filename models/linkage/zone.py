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
    check_zone(motion, point, limit)
    margin = _Margin(motion, point, float(limit), build)
    return reliability(
        margin, distributions, poses=motion.shape[0] if motion.shape else None, **{"starts": STARTS, **options}
    )


def check_zone(motion: Kinematics, point: str, limit: float) -> None:
    """Refuse a zone that has no size, or no middle at some pose."""
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


def share_left(motion: Kinematics, point: str, limit: float, build: Build) -> Callable[..., Array]:
    """What is left of the zone as a share of it: other programs hold limit states against tolerances without units."""
    check_zone(motion, point, limit)
    margin = _Margin(motion, point, float(limit), build)
    return lambda samples, pose=None: margin(samples, pose) / margin.limit


class _Margin:
    """What is left of the zone, smooth at its middle: ``(limit² - off²) / limit`` of the distance off."""

    def __init__(self, motion: Kinematics, point: str, limit: float, build: Build) -> None:
        self.point, self.limit, self.build = point, limit, build
        self.nominal = motion.position(point)
        self.drives = {name: driven_values(motion, name) for name in motion.linkage.drives}

    def __call__(self, samples: Mapping[str, Array], pose: NDArray[np.int64] | None = None) -> Array:
        at = () if pose is None else pose
        moved = self.build(**samples).move({name: values[at] for name, values in self.drives.items()})
        off = moved.position(self.point) - self.nominal[at]
        left: Array = self.limit - np.sum(off * off, axis=-1) / self.limit
        return left


def driven_values(motion: Kinematics, name: str) -> Array:
    """Values of a drive as `move` takes them, (...) or (..., f)."""
    pair, driven = motion.linkage.joint(name), motion.linkage.drives[name]
    values = coordinate_of(motion, pair)[..., [pair.kind.coordinates.index(each) for each in driven]]
    return values[..., 0] if len(driven) == 1 else values
