"""Statistics of a stream against those of the samples, and how sure they are against the truth."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError, SampleWarning
from linkframe.models import propagate
from linkframe.models.intervals import by_error, quantile_ranks
from linkframe.models.propagation.comoments import Comoments
from linkframe.models.sampling import BLOCK
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

ALSO = ("covariance", "histogram")
PAIR = {"a": stats.norm(3.0, 2.0), "b": stats.expon()}
P = [1e-3, 0.1, 0.5, 0.9, 0.999]


def both(a, b):
    return np.stack([a + b, a - 2 * b, 1e-6 * b + 1.0], axis=-1)


def runs(fn, inputs, n=20_000, **more):
    """The same run with samples kept, and with statistics alone."""
    quiet = {"n": n, "rng": 0, "progress": False, **more}
    return propagate(fn, inputs, **quiet), propagate(fn, inputs, keep_samples=False, also=ALSO, chunk=3000, **quiet)


def test_a_stream_has_the_covariance_and_extremes_of_its_samples():
    kept, streamed = runs(both, PAIR)
    assert streamed.kept is None
    assert_allclose(streamed.covariance, np.cov(kept.samples.T), rtol=1e-9)
    assert_array_equal(streamed.covariance, kept.covariance)
    assert_allclose(streamed.correlation, np.corrcoef(kept.samples.T), rtol=1e-9)
    assert_array_equal(streamed.envelope, [kept.samples.min(axis=0), kept.samples.max(axis=0)])


def test_quantiles_of_a_stream_are_within_their_stated_bounds():
    kept, streamed = runs(both, PAIR)
    low, high = streamed.quantile_bounds(P)
    exact = kept.quantile(P)
    assert np.all((low <= exact) & (exact <= high))
    assert np.all(high - low < 0.08 * kept.std)
    assert np.all(high[1:4] - low[1:4] < 0.03 * kept.std)
    assert np.all(np.abs(streamed.quantile(P) - exact) < 0.03 * kept.std)
    assert_array_equal(kept.quantile_bounds(P), [exact, exact])


@pytest.mark.parametrize("law", [stats.cauchy(), stats.lognorm(2.0), stats.uniform(), stats.bernoulli(0.3)])
def test_quantiles_of_a_stream_of_any_law(law):
    """Heavy tails, a bounded law, and one of two values."""
    kept, streamed = runs(lambda x: x, {"x": law})
    low, high = streamed.quantile_bounds(P)
    exact = kept.quantile(P)
    assert np.all((low <= exact) & (exact <= high))
    assert streamed.histogram().counts.sum() == streamed.n
    assert_array_equal(streamed.histogram().counts, kept.histogram().counts)


def test_a_histogram_estimates_the_density():
    _, streamed = runs(lambda x: x, {"x": stats.norm(5.0, 0.1)}, n=200_000, sampler="sobol")
    found = streamed.histogram()
    # Twenty bins together are wide enough to hold many samples.
    edges, counts = found.edges[::16], np.add.reduceat(found.counts, np.arange(0, found.counts.size, 16))
    expected = 200_000 * np.diff(stats.norm.cdf(edges, 5.0, 0.1))
    assert_allclose(counts, expected, atol=15.0)
    assert_allclose(np.sum(found.density * np.diff(found.edges)), 1.0, rtol=1e-12)


def test_results_that_do_not_vary_or_are_missing():
    def fn(x):
        return np.stack([np.full_like(x, 7.0), np.full_like(x, np.nan), np.where(x > 4, np.nan, x), 0.0 * x], axis=-1)

    with pytest.warns(SampleWarning):
        kept, streamed = runs(fn, {"x": stats.norm(3.0, 1.0)}, n=5000)
    assert_array_equal(streamed.quantile(0.5)[[0, 1, 3]], [7.0, np.nan, 0.0])
    low, high = streamed.quantile_bounds([0.2, 0.99])
    assert np.all((low <= kept.quantile([0.2, 0.99]))[:, 2] & (kept.quantile([0.2, 0.99]) <= high)[:, 2])
    assert_array_equal(streamed.envelope[1], [7.0, np.nan, kept.samples[:, 2][kept.samples[:, 2] <= 4].max(), 0.0])
    with pytest.warns(SampleWarning):
        strict = propagate(
            fn, {"x": stats.norm(3.0, 1.0)}, n=5000, rng=0, nan_policy="propagate", also=ALSO, keep_samples=False
        )
    assert_array_equal(np.isnan(strict.quantile(0.5)), [False, True, True, False])
    assert_array_equal(np.isnan(strict.envelope[0]), [False, True, True, False])


def test_covariance_leaves_out_samples_with_a_hole():
    samples = np.random.default_rng(0).normal(size=(1500, 2, 3))
    samples[samples > 2.5] = np.nan
    parts = [Comoments.of(part, "omit") for part in np.split(samples, [BLOCK])]
    found = parts[0].merge(parts[1])
    for k in range(2):
        left = samples[~np.isnan(samples[:, k]).any(axis=-1), k]
        assert_allclose(found.covariance[k], np.cov(left.T), rtol=1e-11)
        assert found.n[k] == len(left)
    assert np.isnan(Comoments.of(samples, "propagate").covariance).any()


def test_what_was_not_kept_is_not_to_be_had():
    found = propagate(both, PAIR, n=100, rng=0, keep_samples=False)
    for ask in (lambda: found.quantile(0.5), lambda: found.histogram(), lambda: found.confidence_interval(of=0.5)):
        with pytest.raises(FrameError, match=r"keep_samples=True, or with also=\('histogram',\)"):
            ask()
    with pytest.raises(FrameError, match=r"also=\('covariance',\)"):
        _ = found.covariance
    for also in ("histogram", ["skewness"]):
        with pytest.raises(FrameError, match="give some of covariance, histogram"):
            propagate(both, PAIR, also=also)


# -- confidence intervals ---------------------------------------------------------------------------------------------

ASKED = {"mean": 1.0, "std": 1.0, 0.9: -np.log(0.1), "covariance": 1.0}


@pytest.mark.parametrize("of", ASKED)
def test_intervals_hold_the_truth_as_often_as_they_say(of):
    """90 % intervals of an exponential law: of 300 seeds 270 ± 5.2; of so skew a law that of `std` is a little low."""
    inside = 0
    for seed in range(300):
        found = propagate(lambda x: x, {"x": stats.expon()}, n=1024, rng=seed, progress=False)
        low, high = found.confidence_interval(0.9, of=of)
        inside += bool(low <= ASKED[of] <= high)
    assert 250 <= inside <= 288


def test_intervals_of_a_stream_hold_those_of_its_samples():
    kept, streamed = runs(both, PAIR)
    for p in (0.01, 0.5, 0.999):
        exact, wide = (each.confidence_interval(0.95, of=p) for each in (kept, streamed))
        assert np.all(wide.low <= exact.low)
        assert np.all(wide.high >= exact.high)
        assert np.all(wide.high - wide.low < 1.3 * (exact.high - exact.low) + 0.03 * kept.std)
    for of in ("mean", "std", "covariance"):
        assert_array_equal(kept.confidence_interval(of=of), streamed.confidence_interval(of=of))


def test_ranks_of_a_quantile_by_the_binomial_distribution():
    for n, p in ((10, 0.5), (100, 0.9), (1000, 0.01)):
        low, high = (int(each) for each in quantile_ranks(n, p, 0.95))
        below = stats.binom(n, p)
        covered = below.cdf(high) - below.cdf(low)
        assert covered >= 0.95
        assert below.cdf(low) <= 0.025
        assert below.sf(high) <= 0.025
        assert below.cdf(low + 1) > 0.025
    low, high = quantile_ranks(10, 0.999, 0.95)
    assert high == 10


def test_too_few_samples_have_no_bound():
    found = propagate(lambda x: x, {"x": stats.norm()}, n=50, rng=0)
    low, high = found.confidence_interval(0.95, of=0.999)
    assert np.isfinite(low)
    assert high == np.inf
    streamed = propagate(lambda x: x, {"x": stats.norm()}, n=50, rng=0, keep_samples=False, also=["histogram"])
    assert streamed.confidence_interval(0.95, of=0.999).high == np.inf


def test_students_interval():
    found = stats.t.interval(0.9, df=4, loc=2.0, scale=0.5)
    assert_allclose(by_error(2.0, 0.5, 0.9, 4), found, rtol=1e-12)
    assert_allclose(by_error(2.0, 0.5, 0.9), stats.norm.interval(0.9, 2.0, 0.5), rtol=1e-12)


@pytest.mark.parametrize(
    ("level", "of", "told"),
    [(95, "mean", "between 0 and 1"), (0.9, "median", "choose 'mean', 'std'"), (0.9, 1.5, "from 0 to 1")],
)
def test_what_is_no_interval_is_refused(level, of, told):
    found = propagate(lambda x: x, {"x": stats.norm()}, n=50, rng=0)
    with pytest.raises(FrameError, match=told):
        found.confidence_interval(level, of=of)


def test_a_result_shows_a_short_table():
    lines = repr(propagate(both, PAIR, n=1000, rng=0)).splitlines()
    assert lines[0] == "Propagation of a, b: 1000 samples (random)"
    assert lines[1].split() == ["mean", "±", "s.e.", "std", "±", "s.e.", "least", "greatest"]
    assert [line.split()[0] for line in lines[2:]] == ["[0]", "[1]", "[2]"]
    many = propagate(lambda x: np.stack([x] * 40, axis=-1), {"x": stats.norm()}, n=10, rng=0)
    assert repr(many).splitlines()[-1].split() == ["...", "34", "more", "of", "shape", "(40,)"]
