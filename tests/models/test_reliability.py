"""Probability of failure beside exact values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.framework.errors import SampleWarning
from linkframe.models import Linkage, reliability
from linkframe.models.failure.second_order import beyond_paraboloid
from numpy.testing import assert_allclose
from reference.limit_states import CALREL, PORTAL, PROBLEMS, TIED, beyond, interaction, interaction_slopes, mean, sway
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]


@pytest.mark.parametrize("name", PROBLEMS)
def test_samples_about_the_likely_failures(name: str) -> None:
    """From 8 in a hundred down to 3 in ten millions, with several likely failures, edges, and limits without slope."""
    problem = PROBLEMS[name]
    found = reliability(problem, problem.laws, rng=1, accuracy=0.1)
    assert abs(found.probability - problem.probability) < 4.0 * found.standard_error
    assert found.coefficient_of_variation <= 0.1


@pytest.mark.parametrize("name", ["R-S", "RP33", "RP110", "RP107"])
def test_planes_have_their_probability(name: str) -> None:
    problem = PROBLEMS[name]
    found = reliability(problem, problem.laws, method="form", rng=0)
    assert_allclose(found.probability, problem.probability, rtol=2e-3 if name == "RP33" else 1e-6)
    assert np.isnan(found.standard_error)
    assert_allclose(sum(found.importance.values()), 1.0, rtol=1e-12)


@pytest.mark.parametrize("name", ["RP57", "RP22", "four branches"])
def test_subset_simulation(name: str) -> None:
    problem = PROBLEMS[name]
    found = reliability(problem, problem.laws, method="subset", rng=3)
    low, high = found.confidence_interval(0.999)
    assert low <= problem.probability <= high
    assert found.coefficient_of_variation < 0.15


@pytest.mark.parametrize(
    ("name", "method"),
    [*((name, "importance") for name in ("R-S", "RP33")), ("RP57", "subset")],
)
def test_intervals_hold_as_often_as_they_say(name: str, method: str) -> None:
    problem, hold = PROBLEMS[name], 0
    for seed in range(100):
        options: dict[str, Any] = {"accuracy": 0.2, "starts": 3} if method == "importance" else {"samples": 300}
        low, high = reliability(problem, problem.laws, method=method, rng=seed, **options).confidence_interval(0.95)
        hold += bool(low <= problem.probability <= high)
    assert hold >= 90


@pytest.mark.parametrize("beta", [-1.0, 0.3, 2.0, 6.0])
@pytest.mark.parametrize("curvature", [-0.15, 0.0, 0.4, 0.9])
def test_beyond_a_paraboloid(beta: float, curvature: float) -> None:
    """Beside Gauss' rule over the curved direction; of two alike the sum of squares is exponential."""
    single = mean(lambda v: beyond(beta + 0.5 * curvature * v * v))
    assert_allclose(beyond_paraboloid(np.array([beta]), np.array([[curvature]])), [single], rtol=1e-9)
    double = mean(lambda t: beyond(beta + 0.5 * curvature * t), law=stats.expon(scale=2.0))
    assert_allclose(beyond_paraboloid(np.array([beta]), np.array([[curvature, curvature]])), [double], rtol=1e-9)
    if beta == 6.0:
        far = beyond(beta) / np.sqrt(1.0 + beta * curvature)  # Breitung, J. Eng. Mech. 110, 1984
        assert_allclose(far, single, rtol=0.05 if curvature >= 0.0 else 0.5)


def test_a_point_that_is_no_nearest_one_has_no_second_order() -> None:
    assert np.isnan(beyond_paraboloid(np.array([2.0]), np.array([[-0.6]]))).all()


def test_correlated_inputs_with_nataf() -> None:
    """Manual of CalRel, example 2: index 1.7724 (1.772397 printed; 1.772763 by OpenTURNS), second order 3.22e-2."""
    found = reliability(interaction, CALREL, method="form", correlation=TIED, starts=1)
    assert_allclose(found.beta, 1.7724, atol=5e-4)
    given = reliability(interaction, CALREL, method="form", correlation=TIED, starts=1, gradient=interaction_slopes)
    assert_allclose(given.beta, found.beta, rtol=1e-10)
    at = found.likeliest
    assert_allclose(interaction({name: np.atleast_1d(value) for name, value in at.items()}), 0.0, atol=1e-6)
    second = reliability(interaction, CALREL, method="sorm", correlation=TIED, starts=1)
    assert_allclose(second.probability, 3.22e-2, rtol=0.02)
    sampled = reliability(interaction, CALREL, correlation=TIED, rng=0, accuracy=0.02)
    assert_allclose(second.probability, sampled.probability, rtol=0.1)


def test_a_frame_of_uncertain_stiffness_place_and_load() -> None:
    """Portal of the OpenSees manual's reliability example; its index to twelve digits in ten batches."""
    found = reliability(sway, PORTAL, method="form", starts=1)
    assert_allclose(found.beta, 2.449600145168, rtol=1e-11)
    assert found.batches <= 10
    assert found.importance["P"] > found.importance["E"] > 0.1 > found.importance["x"]


def test_one_in_a_billion() -> None:
    laws = {"a": stats.norm(), "b": stats.norm()}
    found = reliability(lambda x: 6.0 * np.sqrt(2.0) - x["a"] - x["b"], laws, rng=0)
    assert abs(found.probability - beyond(6.0)) < 4.0 * found.standard_error
    assert found.evaluations < 20_000
    assert found.batches <= 10
    assert found.coefficient_of_variation <= 0.05


def crank(length: Array | float) -> Linkage:
    linkage = Linkage(A=(0, 0), P=np.stack(np.broadcast_arrays(length, 0.0, 0.0), axis=-1))
    linkage.link("crank", "A", "P")
    linkage.revolute("A", "ground", "crank", drive=True)
    return linkage


@pytest.mark.parametrize("anywhere", [False, True])
@pytest.mark.parametrize("method", ["form", "sorm", "importance"])
def test_a_point_leaves_its_zone(method: str, anywhere: bool) -> None:
    """A crank of uncertain length is too long or too short everywhere at once."""
    motion = crank(0.2).move(A=[0.3, 1.0, 2.5])
    laws = {"length": stats.norm(0.2, 1e-5)}
    found = motion.reliability("P", 4.5e-5, crank, laws, method=method, anywhere=anywhere, rng=0)
    assert found.probability.shape == (() if anywhere else (3,))
    exact = 2.0 * beyond(4.5)
    if method == "importance":
        assert np.all(np.abs(found.probability - exact) < 4.0 * found.standard_error)
    else:
        assert_allclose(found.probability, exact, rtol=1e-6)


def slide(a: Array | float, b: Array | float) -> Linkage:
    linkage = Linkage(A=(0, 0), P=np.stack(np.broadcast_arrays(0.3 + a, b, 0.0), axis=-1))
    linkage.link("slide", "A", "P")
    linkage.prismatic("A", "ground", "slide", axis=(1, 0), drive=True)
    return linkage


def test_a_zone_that_is_left_in_every_direction_alike() -> None:
    """Distance of two equal normal errors: Rayleigh's distribution, with as many likely failures as directions."""
    motion = slide(0.0, 0.0).move(A=0.1)
    laws = {"a": stats.norm(0.0, 1e-5), "b": stats.norm(0.0, 1e-5)}
    found = motion.reliability("P", 4e-5, slide, laws, rng=2)
    assert abs(found.probability - np.exp(-8.0)) < 4.0 * found.standard_error
    plain = motion.reliability("P", 1e-5, slide, laws, rng=2, method="random", samples=4000)
    assert abs(plain.probability - np.exp(-0.5)) < 4.0 * plain.standard_error


def test_what_cannot_be_assembled_has_failed() -> None:
    found = reliability(
        lambda x: np.where(x["a"] > -1.0, 1.0, np.nan), {"a": stats.norm()}, method="random", samples=10_000, rng=0
    )
    assert abs(found.probability - beyond(1.0)) < 4.0 * found.standard_error


def test_same_seed_same_bits() -> None:
    problem = PROBLEMS["RP33"]
    first, second, other = (reliability(problem, problem.laws, rng=seed) for seed in (5, 5, 6))
    assert first.probability == second.probability != other.probability
    assert "probability of failure" in repr(first)


def test_what_is_refused() -> None:
    laws = {"a": stats.norm()}
    with pytest.raises(FrameError, match="method of reliability is 'best': choose one of form"):
        reliability(lambda x: x["a"], laws, method="best")
    with pytest.raises(FrameError, match=r"returned shape \(\) for \d+ samples"):
        reliability(lambda x: 1.0, laws)
    with pytest.raises(FrameError, match=r"takes \(a\), but .*: let it take one mapping x, and read x\['a'\] for a"):
        reliability(lambda a: a, {**laws, "b": stats.norm()}, poses=2)
    with pytest.raises(FrameError, match=r"takes \(a, b\), but is called with the samples by name"):
        reliability(lambda a, b: a - b, {**laws, "b": stats.norm()})
    with pytest.raises(FrameError, match="no failure was found: use the method 'importance'"):
        reliability(lambda x: 1.0 + 0.0 * x["a"], laws, method="form")
    with pytest.raises(FrameError, match="limit of point 'P' is -1"):
        crank(0.2).move(A=0.3).reliability("P", -1.0, crank, {"length": stats.norm(0.2, 1e-5)})
    with pytest.raises(FrameError, match="seeks no likeliest failure"):
        _ = reliability(lambda x: x["a"], laws, method="random", samples=100).likeliest


@pytest.mark.parametrize("seed", [1, 7, 37])
def test_searches_begin_from_samples_that_are_not_explained(seed: int) -> None:
    """Four failures alike, of which three searches find two: the others are where samples are worse than expected."""
    problem = PROBLEMS["RP111"]
    found = reliability(problem, problem.laws, rng=seed, accuracy=0.1, starts=3)
    low, high = found.confidence_interval(0.99)
    assert low < problem.probability < high
    assert found.points is not None
    assert sorted(np.sign(found.points.scores[:4]).tolist()) == [[-1, -1], [-1, 1], [1, -1], [1, 1]]


@pytest.mark.parametrize("seed", [7])
def test_subset_simulation_that_is_led_astray_warns(seed: int) -> None:
    """All runs go where the limit state falls first, never to the failure that is a hundred times as likely."""
    problem = PROBLEMS["RP110"]
    with pytest.warns(SampleWarning, match=r"no sample lies beyond .* the probability is 3\.17e-05 to first order"):
        found = reliability(problem, problem.laws, method="subset", rng=seed, samples=500)
    low, high = found.confidence_interval(0.95)
    assert found.probability < 0.1 * problem.probability
    assert low < problem.probability < high
