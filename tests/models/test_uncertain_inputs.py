"""What may be said of an uncertain input, and what inputs that depend on each other become."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.errors import FrameError
from linkframe.models import GaussianCopula, propagate, tolerance
from linkframe.models.distributions import Interval, Normal
from linkframe.models.given_deviations import deviation
from linkframe.models.given_distributions import continuous, distribution_of
from linkframe.models.propagation.correlation import by_quadrature, nataf
from linkframe.models.propagation.inputs import JointInputs
from linkframe.models.quantiles import at_scores, log_density, normal_scores
from linkframe.models.sampling import draw
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

PAIR = ("a", "b")


class OnlyPpf:
    """A distribution of somebody's own: triangular, from 0 to 1, most likely 1."""

    def ppf(self, q):
        return np.sqrt(q)


@pytest.mark.parametrize(
    ("given", "low", "high"),
    [
        ((0.9, 1.1), 0.9, 1.1),
        ([2, 3], 2.0, 3.0),
        ("100 ± 5 %", 95.0, 105.0),
        ("-100 ± 5%", -105.0, -95.0),
        ("0.1 +/- 0.002", 0.098, 0.102),
        ("2e-3 +1e-4/-5e-4", 1.5e-3, 2.1e-3),
        ("10 +1 % -2 %", 9.8, 10.1),
    ],
)
def test_intervals_and_tolerances_are_uniform_between_their_limits(given, low, high):
    law = distribution_of("x", given)
    assert_allclose(law.ppf(np.array([0.0, 0.25, 1.0])), [low, low + 0.25 * (high - low), high], rtol=1e-14)
    assert_allclose(law.isf(np.array([0.25])), high - 0.25 * (high - low), rtol=1e-14)
    samples = draw({"x": given}, 2000, 0)["x"]
    assert stats.kstest(samples, stats.uniform(low, high - low).cdf).pvalue > 1e-3


@pytest.mark.parametrize(
    ("given", "law"),
    [
        ("norm(1, 2)", stats.norm(1, 2)),
        (" norm(1.0, scale=0.5) ", stats.norm(1, 0.5)),
        ("uniform(1, 2)", stats.uniform(1, 2)),
        ("gamma(2, 0, 1e-3)", stats.gamma(2, 0, 1e-3)),
    ],
)
def test_a_distribution_may_be_written_as_a_call(given, law):
    assert_array_equal(draw({"x": given}, 100, 0)["x"], draw({"x": law}, 100, 0)["x"])


def test_a_normal_tolerance_is_three_standard_deviations():
    law = distribution_of("x", "10 +1/-0.5 normal")
    assert law == Normal(10.25, 0.25)
    assert tolerance(10.0, "± 10 %", "normal", sigmas=2.0) == Normal(10.0, 0.5)
    assert tolerance(10.0, "+1/-0.5") == Interval(9.5, 11.0)
    assert_allclose(law.cdf(law.ppf(np.array([0.1, 0.9]))), [0.1, 0.9], rtol=1e-14)


@pytest.mark.parametrize(
    ("text", "low", "high"),
    [
        ("-0.007/-0.020", 24.98, 24.993),  # ISO 286: g6 of 25 mm
        ("-0.020/-0.007", 24.98, 24.993),
        ("-0.007 -0.020", 24.98, 24.993),
        ("0/-0.013", 24.987, 25.0),  # h6
        ("+0.021/0", 25.0, 25.021),  # H7
        ("+0.035/+0.022", 25.022, 25.035),  # p6
        ("+2 %/+1 %", 25.25, 25.5),
    ],
)
def test_limits_on_one_side_as_on_a_drawing(text: str, low: float, high: float) -> None:
    for found in (
        tolerance(25.0, text),
        distribution_of("pin", f"25 {text}"),
        deviation("pin", 25.0, text).about(25.0),
    ):
        assert isinstance(found, Interval)
        assert_allclose((found.low, found.high), (low, high), rtol=1e-15)
    normal = distribution_of("pin", f"25 {text} normal")
    assert_allclose((normal.mean(), normal.std()), (0.5 * (low + high), (high - low) / 6.0), rtol=1e-12)


@pytest.mark.parametrize("text", ["-0.10", "+0.1", "0.2/0.1", "0/0.1", "0"])
def test_one_limit_or_limits_without_sign_are_no_tolerance(text: str) -> None:
    with pytest.raises(FrameError, match=r"write it as '± 0\.1'"):
        tolerance(25.0, text)


@pytest.mark.parametrize("text", ["+5/-2 %", "+5 %/-2 %", "+5% -2%"])
def test_limits_in_percent(text):
    """A sign of percent behind both stands for both: 5 % of 200 is 10, not 5."""
    assert tolerance(200.0, text) == Interval(196.0, 210.0)
    assert distribution_of("x", f"200 {text}") == Interval(196.0, 210.0)
    assert deviation("x", 200.0, f"{text} normal").about(200.0) == Normal(203.0, 14.0 / 6.0)


def test_a_limit_in_percent_beside_one_that_is_not_is_refused():
    with pytest.raises(FrameError, match=r"'\+5 %/-2' has one limit in percent: give both so"):
        tolerance(200.0, "+5 %/-2")


@pytest.mark.parametrize("nominal", [-50.0, 50.0])
@pytest.mark.parametrize(
    "text", ["norm(1 %, 5 %)", "uniform(-5 %, 20 %)", "expon(scale=5 %)", "triang(0.8, -5 %, 10 %)"]
)
def test_shares_of_a_number_below_zero_scale_it(text, nominal):
    """The number times one and the share, as the samples of a file have it, whatever its sign."""
    found = deviation("x", nominal, text)
    probabilities = np.linspace(0.05, 0.95, 7)
    shares = found.distribution.ppf(probabilities if nominal > 0.0 else 1.0 - probabilities)
    assert_allclose(found.about(nominal).ppf(probabilities), nominal * (1.0 + shares), rtol=1e-13)


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("± 5 %", "has no nominal value: write it as '0.1 ± 5 %'"),
        ("0 ± 5 %", "in percent of a nominal value of zero"),
        ("about 3", "write it as '0.1 ± 5 %'"),
        ("3 ± 0", "leaves no room"),
        ("3 ± 0.1 gamma", "distribution 'gamma' of tolerance"),
        ("norm(3, 5 %)", r"'x' is 'norm\(3, 5 %\)', and there is no nominal value .* write it as '0.1 ± 5 %'"),
        ("norm(3, 1, 2)", "norm takes loc, scale, and there is one more number: 2"),
        ("nrm(3, 1)", r"'x' is 'nrm\(3, 1\)': there is no distribution 'nrm'"),
        ("gamma(b=3)", r"'x' is 'gamma\(b=3\)': gamma does not take b"),
        ("norm(1, -2)", r"'x' is 'norm\(1, -2\)': norm is not defined for loc = 1, scale = -2: scale must be above 0"),
        ("gamma(-2)", "gamma is not defined for a = -2: see scipy.stats.gamma for its range"),
        (stats.norm(1, -2), "'x' has the median nan: give .* such as a scale above 0"),
        ((1.0, 1.0), "give two finite bounds, the lower one first"),
        ((1.0, np.inf), "give two finite bounds"),
        ((1.0, 2.0, 3.0), "an interval such as"),
    ],
)
def test_what_is_no_input_is_refused(given, told):
    with pytest.raises(FrameError, match=told):
        draw({"x": given}, 10, 0)


def test_random_variables_and_objects_with_ppf():
    """SciPy's newer random variables give the bits of its older ones to rounding; any quantile function will do."""
    if hasattr(stats, "Normal"):
        assert_allclose(
            draw({"x": stats.Normal(mu=2.0, sigma=0.5)}, 3000, 1, "sobol")["x"],
            draw({"x": stats.norm(2.0, 0.5)}, 3000, 1, "sobol")["x"],
            rtol=1e-12,
        )
    found = propagate(lambda x: x, {"x": OnlyPpf()}, n=4096, rng=0, sampler="sobol")
    assert_allclose([found.mean, found.std], [2 / 3, np.sqrt(1 / 18)], rtol=1e-3)


# -- correlated inputs ------------------------------------------------------------------------------------------------

LAWS = {
    "normal": stats.norm(3.0, 2.0),
    "uniform": stats.uniform(4.0, 2.0),
    "narrow": stats.lognorm(0.2, scale=5.0),
    "wide": stats.lognorm(0.7, scale=2.0),
}


@pytest.mark.parametrize("rho", [-0.5, 0.3, 0.8])
@pytest.mark.parametrize(("one", "other"), [(a, b) for a in LAWS for b in LAWS if a <= b])
def test_closed_change_of_correlation_is_that_of_the_integral(one, other, rho):
    closed = nataf(PAIR, rho, LAWS[one], LAWS[other])
    assert_allclose(by_quadrature(PAIR, rho, LAWS[one], LAWS[other]), closed, atol=1e-13)


def test_change_of_correlation_against_thirty_digits():
    """Exponential beside uniform: E[-log(1 - Phi(z1)) Phi(z2)] by mpmath at the correlation that was found."""
    r = by_quadrature(PAIR, 0.4, stats.expon(), stats.uniform())
    with mpmath.workdps(30):
        # E[Phi(r z + s y)] over y is Phi(r z/sqrt(1 + s²)).
        inner = lambda z: mpmath.ncdf(r * z / mpmath.sqrt(2 - mpmath.mpf(r) ** 2))  # noqa: E731
        mean = mpmath.quad(lambda z: -mpmath.log(mpmath.ncdf(-z)) * inner(z) * mpmath.npdf(z), [-12, -4, 0, 4, 9, 14])
        rho = (mean - mpmath.mpf(1) / 2) * mpmath.sqrt(12)
    assert abs(float(rho) - 0.4) < 1e-12


def test_nataf_of_a_published_example():
    """Lognormal, lognormal and uniform with 0.3, 0.2, 0.2, of the manual of CalRel: samples have these correlations."""
    s1, s2 = (np.sqrt(np.log1p((d / m) ** 2)) for m, d in ((500, 100), (2000, 400)))
    laws = {
        "x1": stats.lognorm(s1, scale=500 * np.exp(-(s1**2) / 2)),
        "x2": stats.lognorm(s2, scale=2000 * np.exp(-(s2**2) / 2)),
        "x3": stats.uniform(5 - 0.5 * np.sqrt(3), np.sqrt(3)),
    }
    wanted = np.array([[1, 0.3, 0.2], [0.3, 1, 0.2], [0.2, 0.2, 1]])
    scores = GaussianCopula(wanted).of_scores(laws)
    assert_allclose(scores[0, 1], np.log1p(0.3 * 0.04) / np.log1p(0.04), rtol=1e-14)
    found = propagate(
        lambda x1, x2, x3: np.stack([x1, x2, x3], axis=-1), laws, n=2**15, rng=0, sampler="sobol", correlation=wanted
    )
    assert_allclose(found.correlation, wanted, atol=2e-4)
    assert_allclose(found.mean, [500, 2000, 5], rtol=1e-4)
    assert_allclose(found.std, [100, 400, 0.5], rtol=2e-3)


def test_correlation_of_ranks_and_of_scores():
    laws = {"a": stats.gamma(0.5), "b": stats.beta(2, 3)}
    for of, rank in (("ranks", 0.6), ("scores", 6 / np.pi * np.arcsin(0.3))):
        inputs = JointInputs.of(laws, GaussianCopula({PAIR: 0.6}, of=of))
        samples = inputs.samples(stats.qmc.Sobol(2, rng=0).random(2**13))
        assert_allclose(stats.spearmanr(samples["a"], samples["b"])[0], rank, atol=2e-3)


def test_inputs_that_depend_on_none_before_them_keep_their_bits():
    laws = {name: stats.norm() for name in "abc"}
    alone = propagate(lambda a, b, c: np.stack([a, b, c], -1), laws, n=2000, rng=4)
    found = propagate(lambda a, b, c: np.stack([a, b, c], -1), laws, n=2000, rng=4, correlation={("a", "c"): 0.5})
    assert_array_equal(found.samples[:, :2], alone.samples[:, :2])
    assert_allclose(found.samples[:, 2], 0.5 * alone.samples[:, 0] + np.sqrt(0.75) * alone.samples[:, 2], rtol=1e-9)


@settings(max_examples=25, deadline=None)
@given(rho=st.floats(-0.85, 0.85), kinds=st.tuples(*[st.sampled_from(["normal", "uniform", "narrow"])] * 2))
def test_correlation_comes_back(rho, kinds):
    """The double sum over products of conditional quantiles, on another grid, has the wanted correlation."""
    one, other = (LAWS[kind] for kind in kinds)
    r = nataf(PAIR, rho, one, other)
    x, w = np.polynomial.hermite_e.hermegauss(40)
    w = w / w.sum()
    within = lambda z: stats.norm.cdf(np.clip(z, -8.0, 8.0))  # noqa: E731
    a = one.ppf(within(x))
    b = other.ppf(within(r * x[:, None] + np.sqrt(1 - r * r) * x))
    weights = w[:, None] * w
    sum_ab = np.sum(weights * (a[:, None] - one.mean()) * (b - other.mean()))
    assert_allclose(sum_ab / (one.std() * other.std()), rho, atol=1e-7)


@pytest.mark.parametrize(
    ("correlation", "told"),
    [
        ({("a", "d"): 0.3}, "name two different inputs of a, b, c"),
        ({("a", "a"): 0.3}, "name two different inputs"),
        ({("a", "b"): 1.0}, "between -1 and 1"),
        (np.eye(2), r"give a symmetric \(3, 3\)"),
        ({("a", "b"): 0.9, ("b", "c"): 0.9, ("a", "c"): -0.9}, "the correlations contradict each other"),
        (GaussianCopula({("a", "b"): 0.1}, of="tails"), "choose one of inputs, ranks, scores"),
    ],
)
def test_what_is_no_correlation_is_refused(correlation, told):
    with pytest.raises(FrameError, match=told):
        JointInputs.of({name: stats.norm() for name in "abc"}, correlation)


@pytest.mark.parametrize("law", [stats.lognorm(1.5), stats.expon()])
def test_a_correlation_out_of_reach_names_the_inputs(law):
    """A skew input and a symmetric one cannot be correlated as closely as one likes."""
    with pytest.raises(FrameError, match=r"inputs 'a' and 'b' cannot have the correlation 0\.95 by a Gaussian copula"):
        JointInputs.of({"a": law, "b": stats.norm()}, {PAIR: 0.95})


def test_the_usual_distributions_are_those_of_scipy():
    q = np.concatenate([[1e-3, 1.0 - 1e-3], np.random.default_rng(0).random(50)])
    for name, loc, scale in (("norm", 2.0, 0.5), ("uniform", -3.0, 7.0)):
        ours, theirs = continuous(name, {"loc": loc, "scale": scale}), getattr(stats, name)(loc, scale)
        assert isinstance(ours, Normal | Interval)
        assert_allclose(ours.ppf(q), theirs.ppf(q), rtol=1e-15)
        assert_allclose(ours.cdf(ours.ppf(q)), q, rtol=1e-12)
        assert_allclose(
            [ours.mean(), ours.std(), *ours.support()], [theirs.mean(), theirs.std(), *theirs.support()], rtol=1e-15
        )


def test_the_usual_distributions_hold_in_both_tails():
    """Failures of one in 10^19 and rarer lie nine standard deviations off, whichever way the distribution was given."""
    scores = np.array([-37.0, -9.0, -6.0, 0.0, 6.0, 9.0, 37.0])
    for name, loc, scale in (("norm", 2.0, 0.5), ("uniform", -3.0, 7.0)):
        ours, theirs = continuous(name, {"loc": loc, "scale": scale}), getattr(stats, name)(loc, scale)
        assert_allclose(at_scores(ours, scores), at_scores(theirs, scores), rtol=1e-13)
        x = theirs.ppf([1e-20, 1e-3, 0.7, 0.999])
        assert_allclose(normal_scores(name, ours, x), normal_scores(name, theirs, x), rtol=1e-10)
    far = 2.0 + 0.5 * scores
    assert_allclose(normal_scores("norm", Normal(2.0, 0.5), far), scores, rtol=1e-12)
    assert_allclose(log_density("norm", Normal(2.0, 0.5), 30.0 + far), stats.norm(2.0, 0.5).logpdf(30.0 + far))


def test_what_the_usual_distributions_cannot_mean_is_left_to_scipy():
    assert np.isnan(continuous("norm", {"scale": -1.0}).ppf(np.array(0.5)))
    assert continuous("norm", {"loc": 1.0, "scale": 1e-20}).mean() == 1.0
    assert continuous("uniform", {"loc": 1.0, "scale": 1e-20}).mean() == 1.0
    assert continuous("gamma", {"a": 2.0}).mean() == 2.0
    assert continuous("qmc", {}) is None
    with pytest.raises(TypeError):
        continuous("norm", {"shape": 1.0})
