"""Remarks that a reader should know before using the numbers of a run."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ...job.large_table import failed_samples
from ...job.remarks import beyond_size, without_result
from ..graphics.plane import ROUNDING

if TYPE_CHECKING:
    from .result import RunResult


def remarks(result: RunResult) -> list[str]:
    """Sentences for the terminal and the report."""
    where = [result.where(pose) for pose in range(result.poses)]
    found: list[str] = []
    for point, accuracy in result.accuracy.items():
        found += beyond_size(point, result.rows(accuracy.total), result.size, where)
    found += without_result(result.lost, result.poses, result.inputs.samples, result.inputs.nan_policy)
    found += failed_samples(result.outcome) if "large" in result.inputs.also else []
    return [*found, *_unmoved(result), *_pose(result)]


def _unmoved(result: RunResult) -> Iterable[str]:
    """Points that the tolerances do not move."""
    for point, spread in result.spread.items():
        known = spread.std[np.isfinite(spread.std)]
        if known.size and np.all(known <= ROUNDING**1.5 * result.size):
            yield f"The tolerances do not move {point}: its standard deviation is 0 at all poses."


def _pose(result: RunResult) -> Iterable[str]:
    """A pose for the figures that is outside the range of the drive."""
    wanted = result.inputs.pose
    if wanted is not None and not result.drive.min() <= wanted <= result.drive.max():
        yield f"The pose {wanted:g} is beyond the drive's values; the figures show {result.where(result.pose)}."
