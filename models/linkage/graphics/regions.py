"""Regions about points in figures: reachable regions of a worst case and ellipsoids of a covariance, magnified."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ....framework.batch import Array, finite
from ....framework.errors import FrameError
from ....framework.graphics.deformed import round_scale
from ...intervals import checked_level
from ..worst_case.region import ReachableRegion
from ..worst_case.starts import circle
from .places import DrawnPoses, PosePlaces, at_entry

# Size at which the largest region is drawn, as a share of the linkage's size.
SHARE = 0.12
# Number of directions in which the outline of a region is drawn.
AROUND = 180


@dataclass(frozen=True, eq=False)
class DrawnRegion:
    """A region about a point.

    Attributes
    ----------
    point, link
        The point, and the link on which it lies; the first that has it if None.
    text
        Description of the region.
    outermost
        Function of the flat index of a pose and directions (m, 3), which returns the displacements (m, 3) of the
        region's outermost points.
    """

    point: str
    link: str | None
    text: str
    outermost: Callable[[int, Array], Array]


def drawn_regions(motion: DrawnPoses, given: object, level: float) -> list[DrawnRegion]:
    """Regions to draw in figures.

    Parameters
    ----------
    motion
        The motion.
    given
        A `WorstCase`, or by point a `WorstCase`, `ReachableRegion`, covariance (..., 2, 2) or (..., 3, 3), or an object
        with a covariance, such as a `Propagation` of positions; None for no regions.
    level
        Probability with which a normal deviation lies within the ellipsoid of a covariance.

    Raises
    ------
    FrameError
        If one of them is something else, or does not fit the motion.
    """
    if given is None:
        return []
    if not isinstance(given, Mapping):
        by = getattr(given, "sensitivity", None)
        if not isinstance(getattr(given, "position", None), ReachableRegion):
            raise FrameError(f"regions were given as {type(given).__name__}: give a WorstCase, or a mapping by point")
        return [_reachable(motion, by.point, by.link, given)] if by is not None else []
    found = []
    for point, each in given.items():
        region = isinstance(getattr(each, "position", each), ReachableRegion)
        found.append(_reachable(motion, point, None, each) if region else _ellipsoid(motion, point, each, level))
    return found


def _reachable(motion: DrawnPoses, point: str, link: str | None, given: Any) -> DrawnRegion:
    region: ReachableRegion = getattr(given, "position", given)
    _check_shape(motion, region.shape, f"the region of {point}")

    def outermost(pose: int, directions: Array) -> Array:
        here = replace(
            region,
            centre=at_entry(region.centre, motion.shape, pose, 1),
            columns=at_entry(region.columns, motion.shape, pose, 2),
            stress=None if region.stress is None else at_entry(region.stress, motion.shape, pose, 2),
        )
        return here.around(directions)

    return DrawnRegion(point, link, f"worst case of {point}", outermost)


def _ellipsoid(motion: DrawnPoses, point: str, given: Any, level: float) -> DrawnRegion:
    from scipy.special import gammaincinv

    for name in ("result_covariance", "covariance"):
        given = getattr(given, name, given)
    covariance = finite(given, f"covariance of {point}")
    size = covariance.shape[-1] if covariance.ndim > 1 else 0
    if size not in (2, 3) or covariance.shape[-2] != size:
        raise FrameError(
            f"the covariance of {point} has shape {covariance.shape}: give (..., 2, 2) or (..., 3, 3) of its position"
        )
    _check_shape(motion, covariance.shape[:-2], f"the covariance of {point}")
    whole = np.zeros((*covariance.shape[:-2], 3, 3))
    whole[..., :size, :size] = covariance
    # the square of the normalised distance has the chi-squared distribution with `size` degrees of freedom
    reach = float(np.sqrt(2.0 * gammaincinv(0.5 * size, checked_level(level))))

    def outermost(pose: int, directions: Array) -> Array:
        toward = directions @ at_entry(whole, motion.shape, pose, 2)
        length = np.sqrt(np.maximum(np.sum(toward * directions, axis=-1, keepdims=True), 0.0))
        return np.asarray(reach * np.where(length > 0.0, toward / np.where(length > 0.0, length, 1.0), 0.0))

    kind = "ellipse" if size == 2 else "ellipsoid"
    return DrawnRegion(point, None, f"{100.0 * level:g} % {kind} of {point}", outermost)


def _check_shape(motion: DrawnPoses, shape: tuple[int, ...], what: str) -> None:
    try:
        fits = np.broadcast_shapes(motion.shape, shape) == motion.shape
    except ValueError:
        fits = False
    if not fits:
        raise FrameError(f"{what} has batch shape {shape}, the motion {motion.shape}: give one of the same poses")


def magnified(regions: list[DrawnRegion], poses: tuple[int, ...], size: float) -> float:
    """A round factor on all regions, with which the largest at some poses is at most `SHARE` of the linkage's size."""
    ways = np.concatenate([np.eye(3), -np.eye(3)])
    every = [region.outermost(pose, ways) for region in regions for pose in poses]
    return round_scale(np.nan_to_num(np.concatenate([np.zeros((1, 3)), *every])), SHARE * size)


def outline_of(motion: DrawnPoses, region: DrawnRegion, pose: int, flat: tuple[int, int], factor: float) -> Array:
    """Outline of a region about its point in the plane of a figure, (k, 3)."""
    ways = np.zeros((AROUND, 3))
    ways[:, list(flat)] = circle(AROUND)
    return PosePlaces(motion, pose).position(region.point, region.link) + factor * region.outermost(pose, ways)


def told(regions: list[DrawnRegion], factor: float) -> str:
    """Descriptions of the regions, and the factor on them."""
    return f"{', '.join(region.text for region in regions)} × {factor:g}" if regions else ""
