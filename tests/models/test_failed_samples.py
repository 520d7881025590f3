"""Samples that fail are counted by reason, kept, and can be looked at again."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError, SampleWarning
from linkframe.models import propagate
from linkframe.models.sampling import BLOCK
from numpy.testing import assert_array_equal
from scipy import stats

LAW = {"x": stats.norm()}


def told(x):
    """Two results a sample, with the reason where they are not there."""
    result = np.stack([np.where(x > 1.5, np.nan, x), np.where(x < -2.0, np.nan, x)], axis=-1)
    why = np.where(x > 1.5, "not assembled: a gap of 0.1", np.where(x < -2.0, "singular", "regular"))
    return result, why


@pytest.mark.parametrize("keep", [True, False])
def test_failures_are_counted_by_reason_and_kept(keep):
    with pytest.warns(SampleWarning, match=r"; not assembled \d+ times, singular \d+ times\); the statistics"):
        found = propagate(told, LAW, n=3 * BLOCK + 5, rng=0, keep_samples=keep, chunk=2048)
    x = found.input_samples["x"]
    lost = np.flatnonzero((x > 1.5) | (x < -2.0))
    assert found.failures.count == len(lost)
    assert_array_equal(found.failures.numbers, lost)
    assert_array_equal(found.failures.inputs["x"], x[lost])
    assert found.failures.reasons == {"not assembled": np.sum(x > 1.5), "singular": np.sum(x < -2.0)}
    assert repr(found).splitlines()[-3:] == repr(found.failures).splitlines()
    assert repr(found.failures).startswith(f"{len(lost)} of {3 * BLOCK + 5} samples failed\n")


def test_no_failures():
    found = propagate(lambda x: x, LAW, n=100, rng=0)
    assert repr(found.failures) == "none of 100 samples failed"
    assert found.failures.inputs["x"].shape == (0,)


def test_a_chunk_without_any_result_counts_where_others_have_one():
    """Whether an entry is NaN for the sample's sake is for the whole run to say, not for a chunk of it."""

    def first_only(x):
        first_only.calls += 1
        return np.stack([x, np.full_like(x, np.nan if first_only.calls % 2 else 1.0)], axis=-1)

    first_only.calls = 0
    with pytest.warns(SampleWarning, match=f"{2 * BLOCK} of {4 * BLOCK} samples are NaN"):
        found = propagate(first_only, LAW, n=4 * BLOCK, rng=0, chunk=2 * BLOCK)
    assert found.failures.count == found.missing[1] == 2 * BLOCK
    assert_array_equal(found.failures.numbers, np.arange(2 * BLOCK))
    first_only.calls = 0
    with pytest.raises(FrameError, match=f"{2 * BLOCK} of {4 * BLOCK} samples are NaN"):
        propagate(first_only, LAW, n=4 * BLOCK, rng=0, chunk=2 * BLOCK, nan_policy="raise")


def test_the_status_has_the_axes_of_the_result():
    def fn(x):
        places = np.broadcast_to(x, (3, len(x))).copy()
        places[1, x > 1] = np.nan
        why = np.full(places.shape, "regular", dtype="U20")
        why[1, x > 1] = "other assembly mode"
        return np.stack([places] * 2, axis=-1), why

    with pytest.warns(SampleWarning):
        found = propagate(fn, LAW, n=500, rng=0, axis=1)
    assert found.failures.reasons == {"other assembly mode": np.sum(found.input_samples["x"] > 1)}
    with pytest.raises(FrameError, match="status of shape"):
        propagate(lambda x: (x, np.full(3, "regular")), LAW, n=500)
