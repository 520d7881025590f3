"""Rare failures of odd shapes: within a small sphere, at a corner of the limit state."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import reliability
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
LAWS = {name: stats.norm() for name in "abc"}


def within(x: dict[str, Array]) -> Array:
    """A sphere about the median fails."""
    return np.asarray(np.sqrt(x["a"] ** 2 + x["b"] ** 2 + x["c"] ** 2) - 0.02)


def test_subset_simulation_keeps_pace_with_sets_that_narrow() -> None:
    """Each level is half as wide as that before: the steps of the chains become as short at once."""
    exact = stats.chi(3).cdf(0.02)
    found = [reliability(within, LAWS, method="subset", rng=seed) for seed in range(3)]
    for each in found:
        low, high = each.confidence_interval(0.95)
        assert low <= exact <= high
    assert 0.6 * exact < np.median([each.probability for each in found]) < 1.6 * exact


def test_second_order_refuses_what_no_paraboloid_touches() -> None:
    two = {name: LAWS[name] for name in "ab"}
    with pytest.raises(FrameError, match=r"the design point, at a distance of 4\.24 .* edge of the limit state"):
        reliability(lambda x: np.maximum(3.0 - x["a"], 3.0 - x["b"]), two, method="sorm")
    for seed in (0, 5, 22):
        with pytest.raises(FrameError, match=r"the median fails, .* a small closed surface"):
            reliability(within, LAWS, method="sorm", rng=seed)
