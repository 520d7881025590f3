"""Samples that large displacement takes past a singular configuration."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .outcome import Outcome
from .tables import readable

# Samples of a pose that are named one by one.
MOST_NAMED = 5


def passages(outcome: Outcome) -> Iterator[str]:
    """A sentence for each pose at which samples ended near the other branch, and what they do to the spread."""
    large, axes = outcome.large, list(outcome.axes)
    names = " and ".join(f"σ_{'xyz'[axis]}" for axis in axes)
    for pose in np.flatnonzero(large.passed.any(axis=1)):
        passed, moved = large.passed[pose], large.samples[pose][:, axes]
        others = moved[~passed & np.isfinite(moved).all(axis=-1)]
        rest = others.std(axis=0, ddof=1) if len(others) > 1 else np.full(len(axes), np.nan)
        numbers = np.flatnonzero(passed)
        named = ", ".join(map(str, numbers[:MOST_NAMED])) + (" ..." if len(numbers) > MOST_NAMED else "")
        farthest = 1e3 * np.linalg.norm(moved[passed], axis=-1).max()
        without = " and ".join(readable(value, ".2e") for value in rest)
        one = len(numbers) == 1
        yield (
            f"At {outcome.drives[pose]} {len(numbers)} of {len(passed)} samples at large displacement"
            f" {'has' if one else 'have'} passed through {outcome.singular_place} and {'ends' if one else 'end'}"
            f" on the side of the other branch, {outcome.point} up to {farthest:.1f} mm from its rigid position (number"
            f" {named} of samples.npz, counted from 0); without {'it' if one else 'them'} {names} are {without} m."
        )
