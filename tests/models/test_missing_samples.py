"""Samples that are NaN: counted, named, and left out, passed on or refused, as the caller says."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.errors import FrameError, SampleWarning
from linkframe.models import propagate, sobol_indices
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.remarks import remarks
from linkframe.models.linkage.job.report import report
from linkframe.models.linkage.job.result import compute
from linkframe.models.linkage.job.table import as_csv
from linkframe.models.moments import Moments
from linkframe.models.sampling import BLOCK, draw
from linkframe.models.spread import Spread
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

NORMAL = {"x": stats.norm(3.0, 2.0)}


def holed(x, bound=6.5):
    """x and x², the first NaN above the bound."""
    return np.stack([np.where(x > bound, np.nan, x), x**2], axis=-1)


def test_statistics_are_those_of_the_other_samples():
    with pytest.warns(SampleWarning, match="the statistics are those of the others"):
        found = propagate(holed, NORMAL, n=3 * BLOCK + 7, rng=0)
    x = draw(NORMAL, 3 * BLOCK + 7, 0)["x"]
    left = x[x <= 6.5]
    lost = len(x) - len(left)
    assert 0 < lost < len(x)
    assert_array_equal(found.missing, [lost, 0])
    assert found.n == len(x)
    assert found.failed == tuple(np.flatnonzero(x > 6.5)[:10])
    assert_allclose(found.mean, [left.mean(), (x**2).mean()], rtol=1e-13)
    assert_allclose(found.std, [left.std(ddof=1), (x**2).std(ddof=1)], rtol=1e-12)
    assert_allclose(found.standard_error[0], left.std(ddof=1) / np.sqrt(len(left)), rtol=1e-12)
    assert_allclose(found.quantile([0.1, 0.9])[:, 0], np.quantile(left, [0.1, 0.9]), rtol=1e-14)


def test_the_warning_counts_and_names_them():
    x = draw(NORMAL, 500, 0)["x"]
    lost = np.flatnonzero(x > 6.5)
    told = rf"{len(lost)} of 500 samples are NaN \(number {lost[0]}, .*; the first with x = {x[lost[0]]:.6g}\)"
    with pytest.warns(SampleWarning, match=told):
        propagate(holed, NORMAL, n=500, rng=0)
    with pytest.warns(SampleWarning, match=told + "; the statistics are NaN, too"):
        found = propagate(holed, NORMAL, n=500, rng=0, nan_policy="propagate")
    assert_array_equal(np.isnan(found.mean), [True, False])
    assert_array_equal(found.missing, [len(lost), 0])
    with pytest.raises(FrameError, match=told + ": find why"):
        propagate(holed, NORMAL, n=500, rng=0, nan_policy="raise")
    with pytest.raises(FrameError, match="nan_policy is 'drop': choose one of omit, propagate, raise"):
        propagate(holed, NORMAL, n=500, rng=0, nan_policy="drop")


@pytest.mark.parametrize("policy", ["omit", "propagate", "raise"])
def test_a_result_that_no_sample_has_is_no_fault_of_a_sample(policy):
    found = propagate(lambda x: np.stack([x, np.nan * x], axis=-1), NORMAL, n=3000, rng=0, nan_policy=policy)
    assert_array_equal(np.isnan(found.mean), [False, True])
    assert_array_equal(np.isnan(found.std_standard_error), [False, True])
    assert_array_equal(found.missing, [0, 3000])


def test_same_bits_for_any_chunk():
    runs = []
    for chunk, keep in ((1, False), (10**6, True)):
        with pytest.warns(SampleWarning):
            runs.append(propagate(holed, NORMAL, n=5 * BLOCK, rng=3, chunk=chunk, keep_samples=keep))
    assert_array_equal(runs[0].mean, runs[1].mean)
    assert_array_equal(runs[0].std_standard_error, runs[1].std_standard_error)
    assert runs[0].failed == runs[1].failed


@settings(max_examples=60, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), share=st.sampled_from([0.0, 0.3, 0.9, 1.0]), parts=st.integers(1, 5))
def test_merged_moments_are_those_of_what_is_there(seed, share, parts):
    """Blocks that hold nothing, one or several samples, against NumPy on what is left of each column."""
    rng = np.random.default_rng(seed)
    samples = rng.normal(1.0, 2.0, (12, 3))
    samples[rng.random((12, 3)) < share] = np.nan
    merged, *others = (Moments.of(part, "omit") for part in np.array_split(samples, parts))
    for other in others:
        merged = merged.merge(other)
    for k in range(3):
        left = samples[np.isfinite(samples[:, k]), k]
        n = np.broadcast_to(merged.n, 3)[k]
        assert n == len(left)
        assert_allclose(merged.mean[k], left.mean() if len(left) else np.nan, rtol=1e-12)
        assert_allclose(merged.std[k], left.std(ddof=1) if len(left) > 1 else np.nan, rtol=1e-10)
        if len(left) > 1:
            assert_allclose(merged.third[k], np.sum((left - left.mean()) ** 3), atol=1e-10)
            assert_allclose(merged.fourth[k], np.sum((left - left.mean()) ** 4), rtol=1e-10)


def test_spread_of_samples_with_holes():
    samples = np.random.default_rng(0).normal(size=(2, 9, 3))
    samples[0, :4] = samples[1, :, 2] = np.nan
    spread = Spread(samples, "omit")
    assert_array_equal(spread.missing, [[4, 4, 4], [0, 0, 9]])
    assert_allclose(spread.mean[0], samples[0, 4:].mean(axis=0), rtol=1e-14)
    assert_allclose(spread.quantile(0.3)[0], np.quantile(samples[0, 4:], 0.3, axis=0), rtol=1e-14)
    assert_array_equal(spread.envelope[0][0], samples[0, 4:].min(axis=0))
    assert np.isnan(spread.quantile(0.3)[1, 2])
    assert np.isnan([spread.mean[1, 2], spread.std[1, 2], spread.envelope[1][1, 2]]).all()
    assert np.isnan(Spread(samples).mean[0]).all()
    with pytest.raises(FrameError, match="4 of 9 samples are NaN"):
        Spread(samples, "raise")


def test_sobol_indices_tell_of_them():
    with pytest.warns(
        SampleWarning, match=r"\d+ of 1024 samples are NaN or infinite somewhere; the Sobol indices are NaN there"
    ):
        found = sobol_indices(lambda x: holed(x), NORMAL, n=256, rng=0)
    assert_array_equal(np.isnan(found.first[:, 0]), [True, False])


# -- in the job of a file ---------------------------------------------------------------------------------------------

SLIDER = """\
[points]
A = [0.0, 0.0]
B = [0.1, 0.0]
C = [0.3236067977499790, 0.0]

[links.crank]
points = ["A", "B"]
beam = "bar"

[links.rod]
points = ["B", "C"]
length = 0.2236067977499790

[links.piston]
points = ["C"]

[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "crank"]
drive = true

[joints.B]
kind = "revolute"
point = "B"
links = ["crank", "rod"]

[joints.C]
kind = "revolute"
point = "C"
links = ["rod", "piston"]

[joints.slide]
kind = "prismatic"
point = "C"
links = ["ground", "piston"]
axis = [1.0, 0.0, 0.0]

[[loads]]
point = "B"
fy = 10.0

[beams.bar]
section = "flat"
material = "steel"

[sections.flat]
shape = "rectangle"
y = 0.01
z = 0.01

[materials.steel]
E = 2e11
nu = 0.3

[run]
points = ["B"]
samples = 60
nan_policy = "omit"

[run.drives.A]
values = [90.0, 0.0]
unit = "deg"

[tolerances.rod]
of = ["links.rod.length"]
distribution = "uniform"
loc = "-60 %"
scale = "120 %"
"""


def job(folder: Path, policy: str):
    path = folder / "slider.toml"
    path.write_text(SLIDER.replace('"omit"', f'"{policy}"'), encoding="utf-8")
    return compute(read_inputs(path))


def test_a_job_counts_names_and_leaves_out_samples_without_result(tmp_path):
    """Rods shorter than the crank cannot follow it when it stands upright."""
    result = job(tmp_path, "omit")
    drawn = draw(result.inputs.distributions, 60, 0)["rod"]
    lost = int(np.count_nonzero(0.05 * 2 * np.sqrt(5.0) * (1 + drawn) < 0.1))
    assert 0 < lost < 60
    spread = result.spread["B"]
    assert_array_equal(spread.missing[:, 0], [lost, 0])
    assert np.isfinite(spread.mean).all()
    assert result.reported_status[0].endswith(f"; no result in {lost} of 60 samples")
    assert "samples" not in result.reported_status[1]
    assert result.lost == {"not assembled": lost}
    told = (
        f"{lost} of 2 × 60 samples have no result (not assembled {lost} times): mean and standard deviation are those"
    )
    assert any(note.startswith(told) for note in remarks(result))
    assert told in report(result).text({}, remarks(result), {})
    assert f"no result in {lost} of 60 samples" in as_csv(result)
    strict = job(tmp_path, "propagate")
    assert_array_equal(np.isnan(strict.spread["B"].mean[:, 0]), [True, False])
    assert any("have no mean" in note for note in remarks(strict))
    with pytest.raises(FrameError, match=rf"line 59, run.nan_policy: {lost} of 60 samples are NaN"):
        _ = job(tmp_path, "raise").spread


def test_covariances_are_those_of_the_samples_that_are_there() -> None:
    """By numpy.cov, a sample that is missing left out; its variances are the squares of the deviations."""
    samples = np.random.default_rng(2).normal(size=(4, 30, 3)) @ np.triu(np.ones((3, 3)))
    assert_allclose(Spread(samples).covariance, [np.cov(each.T) for each in samples], rtol=1e-12)
    samples[1, [3, 17]] = np.nan
    found = Spread(samples, "omit")
    assert_allclose(found.covariance[1], np.cov(np.delete(samples[1], [3, 17], axis=0).T), rtol=1e-12)
    assert_allclose(np.diagonal(found.covariance, axis1=1, axis2=2), found.std**2, rtol=1e-12)
    assert np.isnan(Spread(samples).covariance[1]).all()
