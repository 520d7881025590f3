"""Propagation of uncertainty against distributions whose moments are known."""

from __future__ import annotations

import pickle

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.framework.errors import FrameError
from linkframe.models import propagate, sobol_indices
from linkframe.models.moments import Moments
from linkframe.models.sampling import BLOCK, draw
from linkframe.models.sensitivity import _saltelli
from linkframe.models.spread import Spread
from numpy.testing import assert_allclose, assert_array_equal
from scipy import stats

GAP = {"eps": stats.norm(1e-3, 5e-5), "gamma": stats.norm(np.pi, 1.0)}
SAMPLERS = ["random", "sobol", "lhs"]


def contact(eps, gamma):
    return np.stack([eps * np.cos(gamma), eps * np.sin(gamma)], axis=-1)


def contact_moments(mean, std, angle, spread):
    """Mean and standard deviation of eps cos(gamma) and eps sin(gamma) for independent normal eps and gamma.

    E cos(k gamma) = cos(k m) exp(-k² s²/2), from the normal characteristic function.
    """
    fade = np.exp(-(spread**2) / 2)
    first = mean * fade * np.array([np.cos(angle), np.sin(angle)])
    half = 0.5 * np.cos(2 * angle) * fade**4
    second = (mean**2 + std**2) * np.array([0.5 + half, 0.5 - half])
    return first, np.sqrt(second - first**2)


# -- known moments ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_clearance_components_have_their_exact_moments(seed):
    result = propagate(contact, GAP, n=20_000, rng=seed)
    mean, std = contact_moments(1e-3, 5e-5, np.pi, 1.0)
    assert np.all(np.abs(result.mean - mean) < 4 * result.standard_error)
    assert np.all(np.abs(result.std - std) < 4 * result.std_standard_error)


def test_standard_errors_are_the_scatter_of_repeated_runs():
    runs = [propagate(contact, GAP, n=500, rng=seed, progress=False) for seed in range(300)]
    for statistic in ("mean", "std"):
        error = "standard_error" if statistic == "mean" else "std_standard_error"
        scatter = np.std([getattr(run, statistic) for run in runs], axis=0, ddof=1)
        claimed = np.mean([getattr(run, error) for run in runs], axis=0)
        # 300 runs give a scatter to 1/sqrt(600) = 4 %.
        assert_allclose(claimed, scatter, rtol=4 / np.sqrt(600))


@pytest.mark.parametrize("sampler", ["sobol", "lhs"])
def test_quasi_random_samples_are_closer(sampler):
    """Mean of a sum of uniforms: Latin and Sobol errors are far below the random standard error."""
    inputs = {name: stats.uniform(0, 1) for name in "abc"}
    result = propagate(lambda a, b, c: a + b + c, inputs, n=4096, rng=1, sampler=sampler)
    assert abs(result.mean - 1.5) < 0.05 * result.standard_error
    assert_allclose(result.std, 0.5, rtol=0.02)


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize("law", [stats.norm(2, 3), stats.uniform(-1, 4), stats.triang(0.3), stats.truncnorm(-1, 2)])
def test_samples_follow_their_distribution(sampler, law):
    samples = draw({"other": stats.norm(), "x": law}, 2000, 3, sampler)["x"]
    assert stats.kstest(samples, law.cdf).pvalue > 1e-4


def test_inputs_are_independent():
    samples = draw({name: stats.norm() for name in "abcd"}, 10_000, 0)
    correlation = np.corrcoef(list(samples.values())) - np.eye(4)
    assert np.abs(correlation).max() < 4 / np.sqrt(10_000)


def test_quantiles_are_those_of_the_distribution():
    result = propagate(lambda x: x, {"x": stats.norm(1, 2)}, n=20_000, rng=0, sampler="sobol")
    assert_allclose(result.quantile([0.1, 0.5, 0.99]), stats.norm(1, 2).ppf([0.1, 0.5, 0.99]), atol=0.02)


def test_a_uniform_number_of_zero_gives_a_finite_sample(monkeypatch):
    monkeypatch.setattr("linkframe.models.sampling._RandomPoints._block", lambda _: np.zeros((BLOCK, 1)))
    samples = draw({"x": stats.norm()}, 3, 0)["x"]
    assert_allclose(samples, stats.norm.ppf(2.0**-54))


# -- same bits --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_same_bits_for_any_chunk_and_whether_kept(sampler):
    wanted = propagate(contact, GAP, n=5000, rng=7, sampler=sampler)
    for chunk, keep in ((1, True), (2048, False), (10**6, False)):
        found = propagate(contact, GAP, n=5000, rng=7, sampler=sampler, chunk=chunk, keep_samples=keep)
        assert_array_equal(found.mean, wanted.mean)
        assert_array_equal(found.std, wanted.std)
        if keep:
            assert_array_equal(found.samples, wanted.samples)


@pytest.mark.parametrize("n", [900, 3 * BLOCK + 1, 5 * BLOCK])
def test_same_bits_of_a_frame_for_any_chunk(n):
    bar = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3))

    def sway(stiffness, force):
        frame = Frame()
        for name, place in {"A": (0, 0, 0), "B": (1, 0.2, 0.1), "C": (1, 0.2, 0.1), "D": (2, 0.5, 0.9)}.items():
            frame.node(name, place)
        frame.add("AB", bar, "A", "B")
        frame.add("joint", Joint(np.stack([stiffness] * 6, axis=-1)), "B", "C")
        frame.add("CD", bar, "C", "D")
        frame.fix("A")
        frame.load("D", fy=force)
        return frame.solve().displacement("D")[:, 1]

    inputs = {"stiffness": stats.uniform(1e5, 1e5), "force": stats.norm(10, 1)}
    wanted, *others = (propagate(sway, inputs, n=n, rng=0, chunk=chunk).samples for chunk in (10**6, 1, 2500, 4096))
    for found in others:
        assert_array_equal(found, wanted)


@pytest.mark.parametrize("sampler", ["random", "lhs"])
def test_an_input_more_does_not_change_the_others(sampler):
    alone = draw({"x": stats.norm()}, 3000, 5, sampler)["x"]
    assert_array_equal(draw({"new": stats.norm(), "x": stats.norm()}, 3000, 5, sampler)["x"], alone)


def test_seeds_as_in_scipy():
    inputs = {"x": stats.norm()}
    assert_array_equal(draw(inputs, 10, 5)["x"], draw(inputs, 10, np.random.SeedSequence(5))["x"])
    generator = np.random.default_rng(5)
    first, second = draw(inputs, 10, generator)["x"], draw(inputs, 10, generator)["x"]
    assert not np.any(first == second)
    assert not np.any(draw(inputs, 10, None)["x"] == draw(inputs, 10, None)["x"])
    assert_array_equal(first, draw(inputs, 10, np.random.default_rng(5))["x"])


# -- moments of a stream ----------------------------------------------------------------------------------------------


def test_merged_moments_are_those_of_all_samples():
    samples = np.random.default_rng(0).gamma(2.0, size=(1000, 3)) + 1e3
    parts = np.split(samples, [1, 17, 400, 401])
    merged = Moments.of(parts[0])
    for part in parts[1:]:
        merged = merged.merge(Moments.of(part))
    assert merged.n == 1000
    assert_allclose(merged.mean, samples.mean(axis=0), rtol=1e-14)
    assert_allclose(merged.std, samples.std(axis=0, ddof=1), rtol=1e-12)
    assert_allclose(merged.third / 1000, stats.moment(samples, 3, axis=0), rtol=1e-9)
    assert_allclose(merged.fourth / 1000, stats.moment(samples, 4, axis=0), rtol=1e-9)


# -- Sobol indices ----------------------------------------------------------------------------------------------------


def test_sobol_indices_of_the_ishigami_function():
    """Ishigami & Homma, 1990: f = sin x1 + 7 sin² x2 + 0.1 x3⁴ sin x1; variance shares in closed form."""
    inputs = {name: stats.uniform(-np.pi, 2 * np.pi) for name in ("x1", "x2", "x3")}
    found = sobol_indices(
        lambda x1, x2, x3: np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1), inputs, n=8192, rng=0
    )
    one = 0.5 * (1 + 0.1 * np.pi**4 / 5) ** 2
    two, both = 49 / 8, 0.01 * np.pi**8 * (1 / 18 - 1 / 50)
    variance = one + two + both
    assert_allclose(found.first, np.array([one, two, 0.0]) / variance, atol=0.02)
    assert_allclose(found.total, np.array([one + both, two, both]) / variance, atol=0.02)


def test_intervals_of_sobol_indices_hold_the_exact_ones():
    """Of the Ishigami function, in at least 90 of 100 seeds; and they are not so wide that they say nothing."""
    inputs = {name: stats.uniform(-np.pi, 2 * np.pi) for name in ("x1", "x2", "x3")}
    one, two, both = 0.5 * (1 + 0.1 * np.pi**4 / 5) ** 2, 49 / 8, 0.01 * np.pi**8 * (1 / 18 - 1 / 50)
    exact = {"first": np.array([one, two, 0.0]), "total": np.array([one + both, two, both])}
    inside = {"first": np.zeros(3), "total": np.zeros(3)}
    for seed in range(100):
        found = sobol_indices(
            lambda x1, x2, x3: np.sin(x1) + 7 * np.sin(x2) ** 2 + 0.1 * x3**4 * np.sin(x1), inputs, n=512, rng=seed
        )
        for of, wanted in exact.items():
            low, high = found.confidence_interval(0.95, of)
            assert np.all(high - low < 0.5)
            inside[of] += (low <= wanted / (one + two + both)) & (wanted / (one + two + both) <= high)
    assert min(np.min(times) for times in inside.values()) >= 90
    assert [line.split()[0] for line in repr(found).splitlines()] == ["input", "x1", "x2", "x3"]
    with pytest.raises(FrameError, match="choose 'first' or 'total'"):
        found.confidence_interval(of="second")


def test_standard_errors_of_indices_are_the_scatter_of_random_samples():
    """With independent points in place of the sequence, for which they are meant."""
    rng = np.random.default_rng(0)
    found = []
    for _ in range(300):
        a, b = rng.normal(size=(2, 1, 256)), rng.normal(size=(2, 1, 256))
        fn = lambda x: x[0] + 2 * x[1] + x[0] * x[1]  # noqa: E731
        f_a, f_b = fn(a), fn(b)
        mean = np.mean([f_a, f_b])
        f_ab = np.stack([fn([b[0], a[1]]), fn([a[0], b[1]])])
        found.append(_saltelli(f_a - mean, f_b - mean, f_ab - mean))
    first, total, first_error, total_error = (np.array(each)[:, 0] for each in zip(*found, strict=True))
    assert_allclose(first_error.mean(axis=0), first.std(axis=0), rtol=0.15)
    assert_allclose(total_error.mean(axis=0), total.std(axis=0), rtol=0.15)


def test_indices_need_independent_inputs():
    result = propagate(
        lambda a, b: a + b, {"a": stats.norm(), "b": stats.norm()}, n=8, rng=0, correlation={("a", "b"): 0.5}
    )
    with pytest.raises(FrameError, match="Sobol indices need independent inputs"):
        _ = result.sobol


def test_propagation_offers_indices_over_the_shape_of_the_result():
    def sums(a, b):
        return np.stack([a + 2 * b, np.hypot(3, 4) * a], axis=0)

    result = propagate(sums, {"a": stats.norm(), "b": stats.norm()}, n=5000, rng=0, axis=1)
    assert result.sobol.inputs == ("a", "b")
    assert_allclose(result.sobol.first, [[0.2, 0.8], [1.0, 0.0]], atol=0.03)


def test_a_single_input_has_all_shares():
    result = propagate(lambda x: x**2, {"x": stats.uniform(0.0, 1.0)}, n=2048, rng=0)
    assert_allclose([*result.sobol.first, *result.sobol.total], 1.0, atol=0.02)


# -- what a result is -------------------------------------------------------------------------------------------------


def test_a_result_can_be_sent_to_another_process():
    """With the function, if that can be: then Sobol indices come out the same there."""
    result = propagate(contact, GAP, n=64, rng=0)
    again = pickle.loads(pickle.dumps(result))
    assert_array_equal(again.samples, result.samples)
    assert_array_equal(again.sobol.total, result.sobol.total)


def test_results_are_the_callers_to_read_and_the_functions_to_use_again():
    """A function may return the same array each time, filled anew; what was kept cannot be written to."""
    held = np.empty(2 * BLOCK)

    def filled(x):
        held[: len(x)] = x
        return held[: len(x)]

    result = propagate(filled, {"x": stats.norm()}, n=4 * BLOCK, rng=0, chunk=2 * BLOCK)
    assert_array_equal(result.samples, propagate(lambda x: x, {"x": stats.norm()}, n=4 * BLOCK, rng=0).samples)
    with pytest.raises(ValueError, match="read-only"):
        result.samples[0] = 1.0


# -- what cannot be ---------------------------------------------------------------------------------------------------


def test_samples_that_were_not_kept_are_not_to_be_had():
    result = propagate(contact, GAP, n=100, rng=0, keep_samples=False)
    with pytest.raises(FrameError, match="keep_samples=True"):
        result.quantile(0.5)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"n": 1}, "number of samples n is 1"),
        ({"n": 10.0}, "number of samples n is 10.0"),
        ({"rng": -1}, "rng is -1"),
        ({"rng": "seed"}, "rng is 'seed'"),
        ({"sampler": "grid"}, "sampler is 'grid': choose one of random, sobol, lhs, halton"),
        ({"distributions": {"eps": 1.0, "gamma": stats.norm()}}, "distribution of 'eps' is 1.0"),
        ({"distributions": {"eps": stats.norm([1, 2], 1)}}, "give finite scalar parameters"),
        ({"axis": 1}, r"returned shape \(100, 2\) for 100 samples: it must have them along axis 1"),
        ({"distributions": {}}, "no input"),
        ({"chunk": 0}, "chunk is 0"),
        ({"chunk": 2.5}, "chunk is 2.5: give a whole number"),
        ({"distributions": [("eps", stats.norm())]}, "give a mapping of names"),
        ({"fn": lambda eps, gamma: 1j * eps}, r"function returned for 100 samples is array.* \.\.\.: give a number"),
        ({"fn": lambda eps, gamma: "wide"}, "function returned .* is 'wide'"),
    ],
)
def test_bad_input_is_refused(change, message):
    given = {"fn": contact, "distributions": GAP, "n": 100, "rng": 0} | change
    with pytest.raises(FrameError, match=message):
        propagate(given.pop("fn"), given.pop("distributions"), **given)


def test_indices_need_a_power_of_two():
    for n, told in ((100, "power of two"), (8.0, "whole number"), (0, "whole number")):
        with pytest.raises(FrameError, match=told):
            sobol_indices(contact, GAP, n=n)
    for inputs, chunk, told in (
        ({}, 1, "no input"),
        ({"eps": 1.0}, 1, "distribution of 'eps' is 1.0"),
        (GAP, 0, "chunk"),
    ):
        with pytest.raises(FrameError, match=told):
            sobol_indices(contact, inputs, chunk=chunk)


@pytest.mark.parametrize("p", [-0.1, 1.5, [0.5, np.nan], "half"])
def test_a_quantile_has_a_probability(p):
    result = propagate(contact, GAP, n=8, rng=0)
    with pytest.raises(FrameError, match="probability p of a quantile"):
        result.quantile(p)
    with pytest.raises(FrameError, match="probability p of a quantile"):
        Spread(result.samples).quantile(p)


def test_memory_is_flat_when_samples_are_not_kept():
    """The function is called with a chunk at a time, what is left over with the last; only moments are held."""
    seen = []

    def wide(x):
        seen.append(len(x))
        return x

    result = propagate(wide, {"x": stats.norm()}, n=10 * BLOCK + 1, rng=0, chunk=BLOCK, keep_samples=False)
    assert seen == [2 * BLOCK] * 4 + [2 * BLOCK + 1]
    assert sum(seen) == result.n == 10 * BLOCK + 1
    assert result.kept is None
