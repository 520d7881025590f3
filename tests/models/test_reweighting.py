"""Other distributions of the same inputs, from the same results."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError, SampleWarning
from linkframe.models import GaussianCopula, propagate
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

WIDE = {"a": stats.norm(1.0, 0.5), "b": (0.0, 2.0)}


class Counted:
    calls = 0

    def __call__(self, a, b):
        self.calls += 1
        return np.stack([a, a * b], axis=-1)


@pytest.fixture(scope="module")
def result():
    fn = Counted()
    found = propagate(fn, WIDE, n=2**15, rng=0, progress=False)
    assert fn.calls == 2
    return found


def test_moments_are_those_of_the_new_distributions(result):
    calls = result._task.fn.calls
    found = result.reweighted({"a": stats.norm(1.2, 0.4), "b": stats.triang(0.5, scale=2.0)})
    assert result._task.fn.calls == calls
    assert np.all(np.abs(found.mean - [1.2, 1.2]) < 4 * found.standard_error)
    second = (1.44 + 0.16) * (1.0 + 1 / 6)
    std = np.array([0.4, np.sqrt(second - 1.44)])
    assert np.all(np.abs(found.std - std) < 4 * found.std_standard_error)
    assert_allclose(found.quantile([0.1, 0.9])[:, 0], stats.norm(1.2, 0.4).ppf([0.1, 0.9]), atol=0.02)


def test_effective_sample_size_is_that_of_the_densities(result):
    """n/E[w²], with E[w²] of two normal densities of one mean s²/(t sqrt(2 s² − t²))."""
    found = result.reweighted({"a": stats.norm(1.0, 0.3)})
    share = 0.3 * np.sqrt(2 * 0.25 - 0.09) / 0.25
    assert_allclose(found.effective_sample_size, 2**15 * share, rtol=0.02)
    assert_allclose(found.weights.sum(), 1.0)
    same = result.reweighted({})
    assert_allclose(same.effective_sample_size, 2**15)
    assert_allclose(same.mean, result.mean, rtol=1e-12)
    assert_allclose(same.std, result.std, rtol=1e-9)
    assert_allclose(same.standard_error, result.standard_error, rtol=1e-4)
    assert_allclose(same.std_standard_error, result.std_standard_error, rtol=1e-3)


def test_a_correlation_may_be_new_or_other(result):
    copula = GaussianCopula({("a", "b"): 0.3})
    found = result.reweighted({}, copula)
    assert np.all(np.abs(found.mean - [1.0, 1.0 + 0.3 * 0.5 * np.sqrt(1 / 3)]) < 4 * found.standard_error)
    dependent = propagate(Counted(), WIDE, n=2**14, rng=0, progress=False, correlation=copula)
    back = dependent.reweighted({})
    assert np.all(np.abs(back.mean - [1.0, 1.0]) < 4 * back.standard_error)


def test_intervals_hold_the_truth():
    inside = np.zeros(3)
    new = stats.norm(0.2, 0.8)
    for seed in range(200):
        result = propagate(lambda x: x, {"x": stats.norm()}, n=400, rng=seed, progress=False)
        found = result.reweighted({"x": new})
        for k, (of, truth) in enumerate({"mean": 0.2, "std": 0.8, 0.75: new.ppf(0.75)}.items()):
            low, high = found.confidence_interval(0.9, of)
            inside[k] += bool(low <= truth <= high)
    assert np.all((inside >= 165) & (inside <= 195))


def test_samples_without_result_do_not_count():
    with pytest.warns(SampleWarning):
        result = propagate(lambda x: np.where(x > 1.0, np.nan, x), {"x": stats.norm()}, n=20_000, rng=0)
    found = result.reweighted({"x": stats.norm(-0.5, 0.9)})
    left = stats.truncnorm(-np.inf, 1.5 / 0.9, -0.5, 0.9)
    assert abs(found.mean - left.mean()) < 4 * found.standard_error
    assert abs(found.std - left.std()) < 4 * found.std_standard_error
    assert_allclose(found.quantile(0.5), left.median(), atol=0.03)
    assert repr(found).startswith("Reweighted, 20000 samples worth ")


class OnlyPpf:
    def ppf(self, q):
        return q


def test_what_cannot_be_reweighted_is_told(result):
    with pytest.raises(FrameError, match=r"the new distribution of 'b' reaches .* where the old one has no density"):
        result.reweighted({"b": stats.norm(1.0, 0.5)})
    with pytest.raises(FrameError, match="'c' is no input of this result: choose of a, b"):
        result.reweighted({"c": stats.norm()})
    with pytest.raises(FrameError, match="distribution of 'b' has no density"):
        result.reweighted({"b": OnlyPpf()})
    forgotten = propagate(Counted(), WIDE, n=100, rng=0, keep_samples=False)
    with pytest.raises(FrameError, match="samples were not kept"):
        forgotten.reweighted({})
    with pytest.raises(FrameError, match="choose 'mean', 'std'"):
        result.reweighted({}).confidence_interval(of="mode")


def test_an_input_without_density_may_keep_its_distribution():
    result = propagate(lambda a, b: a + b, {"a": OnlyPpf(), "b": stats.norm()}, n=4096, rng=0, progress=False)
    assert_array_equal(result.reweighted({"b": stats.norm(0.0, 0.9)}).samples, result.samples)
