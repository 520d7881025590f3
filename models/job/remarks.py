"""Remarks that a reader should know before using the numbers of a job."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Largest number of poses that are named individually.
MOST_NAMED = 4


def beyond_size(point: str, displacement: Array, size: float, where: Sequence[str]) -> list[str]:
    """A sentence if a point is displaced by more than the size of its linkage, which is not a small displacement.

    Parameters
    ----------
    point
        Name of the point.
    displacement
        Its displacement, (poses, 3 or more), metres; NaN where it is not known.
    size
        Extent of the linkage, metres.
    where
        The poses in words.
    """
    lengths = np.linalg.norm(displacement[:, :3], axis=-1)
    far = np.flatnonzero(np.nan_to_num(lengths, nan=0.0) > size).tolist()
    if not far:
        return []
    return [
        f"{point} is displaced by up to {lengths[far].max():.3g} m at {named([where[k] for k in far])}, further than "
        f"the linkage is large ({size:.3g} m): linear mechanics does not hold there; check the units of moduli, "
        "stiffnesses, sections and loads."
    ]


def named(places: Sequence[str]) -> str:
    """List of poses as text, shortened if it is long."""
    more = len(places) - MOST_NAMED
    return ", ".join(places[:MOST_NAMED]) + (f" and {more} more poses" if more > 0 else "")


def without_result(lost: Mapping[str, int], poses: int, samples: int, nan_policy: str) -> list[str]:
    """A sentence on samples that have no result where the nominal linkage has one.

    Parameters
    ----------
    lost
        Number of such samples, by reason, over all poses.
    poses, samples
        Number of poses and of samples.
    nan_policy
        Treatment of such samples.
    """
    if not lost:
        return []
    reasons = ", ".join(f"{reason} {count} times" for reason, count in lost.items())
    omitted = "mean and standard deviation are those of the others"
    end = omitted if nan_policy == "omit" else "their poses have no mean and no standard deviation (nan_policy)"
    return [f"{sum(lost.values())} of {poses} × {samples} samples have no result ({reasons}): {end}."]


def without_equilibrium(lost: int, shape: tuple[int, int], where: Sequence[str], nan_policy: str) -> list[str]:
    """A sentence on samples for which no equilibrium was found at large displacement.

    Parameters
    ----------
    lost
        Number of such samples over all poses.
    shape
        Number of poses, and of samples.
    where
        The poses with such samples, in words.
    nan_policy
        Treatment of such samples.
    """
    if not lost:
        return []
    omitted = "mean and standard deviation there are those of the others"
    end = omitted if nan_policy == "omit" else "these poses have neither mean nor standard deviation (nan_policy)"
    return [
        f"At large displacement {lost} of {shape[0]} × {shape[1]} samples came to no equilibrium (at {named(where)}): "
        f"{end}."
    ]
