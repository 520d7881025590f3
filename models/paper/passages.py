"""Samples that large displacement takes past the line of coupler and rocker."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..job.tables import readable
from .result import Result

# Samples of a pose that are named one by one.
MOST_NAMED = 5


def passages(result: Result) -> Iterator[str]:
    """A sentence for each pose at which samples ended near the other branch, and what they do to the spread."""
    large = result.large
    assert large.passed is not None
    for pose in np.flatnonzero(large.passed.any(axis=1)):
        passed, moved = large.passed[pose], large.samples[pose, :, :2]
        others = moved[~passed & np.isfinite(moved).all(axis=-1)]
        rest = others.std(axis=0, ddof=1) if len(others) > 1 else np.full(2, np.nan)
        numbers = np.flatnonzero(passed)
        named = ", ".join(map(str, numbers[:MOST_NAMED])) + (" ..." if len(numbers) > MOST_NAMED else "")
        farthest = 1e3 * np.linalg.norm(moved[passed], axis=-1).max()
        without = " and ".join(readable(value, ".2e") for value in rest)
        one = len(numbers) == 1
        yield (
            f"At {result.degrees[pose]:g}° {len(numbers)} of {len(passed)} samples at large displacement"
            f" {'has' if one else 'have'} passed through the line of coupler and rocker and {'ends' if one else 'end'}"
            f" on the side of the other branch, P up to {farthest:.1f} mm from its rigid position (number {named} of"
            f" samples.npz, counted from 0); without {'it' if one else 'them'} σ_x and σ_y are {without} m."
        )
