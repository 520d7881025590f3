"""Intervals between independent randomisations of a sampler: as narrow as a sequence deserves, and they hold."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework.errors import FrameError, SampleWarning
from linkframe.models import propagate, sobol_indices
from linkframe.models.sampling import BLOCK, points_of
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats
from scipy.stats import qmc

Array = np.ndarray[Any, np.dtype[np.float64]]
INPUTS = {"a": stats.norm(1.0, 0.5), "b": stats.norm(2.0, 0.25)}
# Of the sum of both, which is normal.
MEAN, STD = 3.0, np.hypot(0.5, 0.25)


def total(a: Array, b: Array) -> Array:
    return a + b


@pytest.mark.parametrize(("sampler", "narrower"), [("random", 0.5), ("lhs", 5.0), ("sobol", 5.0), ("halton", 3.0)])
def test_intervals_hold_and_are_as_narrow_as_the_sampler(sampler: str, narrower: float) -> None:
    """Mean, standard deviation and a quantile beside exact ones: 95 % intervals in at least 54 of 60 seeds.

    The interval of the mean is that many times as narrow as the one of as many independent samples.
    """
    hold, widths = np.zeros(3), []
    exact = MEAN, STD, stats.norm(MEAN, STD).ppf(0.9)
    for seed in range(60):
        found = propagate(total, INPUTS, n=1024, rng=seed, sampler=sampler, replicates=16, progress=False)
        for k, (of, value) in enumerate(zip(("mean", "std", 0.9), exact, strict=True)):
            low, high = found.confidence_interval(0.95, of=of)
            hold[k] += bool(low <= value <= high)
            widths += [float(high - low)] if k == 0 else []
    assert np.all(hold >= 54)
    independent = 2.0 * 1.96 * STD / np.sqrt(1024)
    assert np.mean(widths) < independent / narrower


def test_one_randomisation_is_as_it_was() -> None:
    """The same bits, and the interval of independent samples."""
    plain = propagate(total, INPUTS, n=2048, rng=5, sampler="sobol", progress=False)
    one = propagate(total, INPUTS, n=2048, rng=5, sampler="sobol", replicates=1, progress=False)
    assert_array_equal(plain.samples, one.samples)
    assert_allclose(one.standard_error, one.std / np.sqrt(2048), rtol=1e-14)


@pytest.mark.parametrize("sampler", ["random", "lhs", "sobol", "halton"])
def test_points_of_replicates(sampler: str) -> None:
    """From any block on the same points; each replicate is a randomisation of its own, evenly spread by itself."""
    root, n = np.random.SeedSequence(3), 10 * BLOCK
    ordered = points_of(["a", "b"], n, root, sampler, 8)
    wanted = [ordered.take(start, BLOCK).copy() for start in range(0, n, BLOCK)]
    jumping = points_of(["a", "b"], n, root, sampler, 8)
    for block in (9, 4, 1, 2, 0, 8):
        assert_array_equal(jumping.take(block * BLOCK, BLOCK), wanted[block])
    points = np.concatenate(wanted)
    assert len(np.unique(points[:, 0])) == n
    if sampler == "lhs":
        for k in range(8):
            assert_array_equal(np.sort(points[k::8, 1] * n // 8), np.arange(n // 8))


def test_chunks_checkpoints_and_what_is_not_kept(tmp_path: Path) -> None:
    """The same bits by chunks, from stored chunks, extended, and without samples; failed samples left out."""

    def some(a: Array, b: Array) -> Array:
        return np.stack([a + b, np.where(a > 2.5, np.nan, a * b)], axis=-1)

    options: dict[str, Any] = {"rng": 1, "sampler": "sobol", "replicates": 8, "progress": False}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SampleWarning)
        whole = propagate(some, INPUTS, n=8192, **options)
        parts = propagate(some, INPUTS, n=8192, chunk=2048, keep_samples=False, **options)
        stored = propagate(some, INPUTS, n=4096, chunk=2048, checkpoint=tmp_path / "run", **options)
        longer = propagate(some, INPUTS, n=8192, chunk=2048, checkpoint=tmp_path / "run", **options)
    for other in (parts, longer):
        assert_array_equal(other.standard_error, whole.standard_error)
        assert_array_equal(other.std_standard_error, whole.std_standard_error)
    assert np.all(whole.standard_error < stored.standard_error)
    each = [np.nanmean(whole.samples[k::8], axis=0) for k in range(8)]
    assert_allclose(whole.standard_error, np.std(each, axis=0, ddof=1) / np.sqrt(8), rtol=1e-9)
    with pytest.raises(FrameError, match="the number of replicates differs"):
        propagate(some, INPUTS, n=4096, checkpoint=tmp_path / "run", **options | {"replicates": 4})


def test_sobol_indices_between_replicates() -> None:
    """Of a sum the shares of the variances: intervals hold, and are narrower than those of independent samples."""
    shares = np.array([0.5, 0.25]) ** 2 / STD**2
    hold, ratio = 0, []
    for seed in range(10):
        found = sobol_indices(total, INPUTS, n=1024, rng=seed, replicates=16)
        low, high = found.confidence_interval(0.95)
        hold += int(np.count_nonzero((low <= shares) & (shares <= high)))
        ratio.append(found.total_standard_error / sobol_indices(total, INPUTS, n=1024, rng=seed).total_standard_error)
    assert hold >= 17
    assert np.mean(ratio) < 0.8
    by_result = propagate(total, INPUTS, n=1024, rng=0, sampler="sobol", replicates=16, progress=False).sobol
    assert by_result.freedom == 15


def test_what_is_refused() -> None:
    with pytest.raises(FrameError, match="replicates is 5: choose one of 1, 4, 8"):
        propagate(total, INPUTS, n=1000, replicates=5)
    with pytest.raises(FrameError, match="number of samples n is 1000: give a multiple of the 16 replicates"):
        propagate(total, INPUTS, n=1000, replicates=16)
    with pytest.raises(FrameError, match="an engine has one randomisation"):
        propagate(total, INPUTS, n=1024, replicates=8, sampler=qmc.Sobol(2))
    with pytest.raises(FrameError, match="multiple of the 16 replicates"):
        sobol_indices(total, INPUTS, n=1000, replicates=16)
