"""Limit states in OpenTURNS and in Pystra: the same probabilities as here."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, propagate, reliability, to_openturns, to_pystra
from linkframe.models.failure.adapters.input_function import InputFunction
from numpy.testing import assert_allclose
from reference.limit_states import CALREL, PORTAL, TIED, interaction, interaction_slopes, sway
from scipy import stats
from scipy.special import ndtr

Array = np.ndarray[Any, np.dtype[np.float64]]


# -- four problems: limit, inputs, correlation, derivatives, where a search begins ------------------------------------


def margin(x: Mapping[str, Array]) -> Array:
    return x["r"] - x["s"]


def four_bar(crank: Array | float, coupler: Array | float, rocker: Array | float) -> Linkage:
    """Where the pin D is follows from the lengths of coupler and rocker."""
    crank, coupler, rocker = np.broadcast_arrays(crank, coupler, rocker)
    none, ground = 0.0 * crank, 0.22
    across = np.hypot(ground, crank)
    along = (across**2 + coupler**2 - rocker**2) / (2.0 * across)
    high = np.sqrt(coupler**2 - along**2)
    x = (along * ground + high * crank) / across
    y = crank + (-along * crank + high * ground) / across
    linkage = Linkage(
        A=(0, 0),
        B=np.stack([none, crank], -1),
        P=np.stack([0.6 * x, crank + 0.6 * (y - crank)], -1),
        D=np.stack([x, y], -1),
        E=(ground, 0),
    )
    linkage.link("crank", "A", "B")
    linkage.link("coupler", "B", "P", "D")
    linkage.link("rocker", "D", "E")
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage


ZONE = 6e-5
LENGTHS = {"crank": stats.norm(0.1, 1e-5), "coupler": stats.norm(0.25, 2e-5), "rocker": stats.norm(0.16, 2e-5)}
CASES: dict[str, tuple[Any, dict[str, Any], dict[str, Any]]] = {
    "R-S": (margin, {"r": stats.norm(7.0, 1.0), "s": stats.norm(2.0, 1.0)}, {}),
    "CalRel": (interaction, CALREL, {"correlation": TIED}),
    "CalRel with derivatives": (interaction, CALREL, {"correlation": TIED, "gradient": interaction_slopes}),
    "portal": (sway, PORTAL, {}),
}


def ours(name: str, method: str) -> Any:
    if name == "zone":
        motion = four_bar(0.1, 0.25, 0.16).move(A=[0.3, 1.0])
        return motion.reliability("P", ZONE, four_bar, LENGTHS, method=method, rng=0)
    limit, laws, options = CASES[name]
    return reliability(limit, laws, method=method, starts=1, **options)


# -- OpenTURNS --------------------------------------------------------------------------------------------------------


def searched(ot: Any, problem: Any, start: list[float], result: int | None = None) -> tuple[Any, Any]:
    """First and second order by OpenTURNS."""
    way = ot.AbdoRackwitz()
    way.setMaximumIterationNumber(200)
    for limit in ("Absolute", "Relative", "Residual", "Constraint"):
        getattr(way, f"setMaximum{limit}Error")(1e-9)
    way.setStartingPoint(start)
    first = ot.FORM(way, problem.event(result))
    first.run()
    second = ot.SORM(way, problem.event(result))
    second.run()
    return first.getResult(), second.getResult()


@pytest.mark.parametrize("name", CASES)
def test_openturns(name: str) -> None:
    ot = pytest.importorskip("openturns")
    limit, laws, options = CASES[name]
    problem = to_openturns(limit, laws, **options)
    first, second = searched(ot, problem, [float(each.mean()) for each in laws.values()])
    found = ours(name, "form")
    assert_allclose(first.getHasoferReliabilityIndex(), found.beta, rtol=1e-6)
    assert_allclose(first.getEventProbability(), found.probability, rtol=1e-5)
    factors = first.getImportanceFactors(ot.AnalyticalResult.CLASSICAL)
    assert_allclose(np.array(factors), list(found.importance.values()), atol=1e-4)
    assert_allclose(list(first.getPhysicalSpaceDesignPoint()), list(found.likeliest.values()), rtol=1e-4, atol=1e-4)
    # Tvedt's formula has three terms; ours is the exact integral beyond the same paraboloid.
    assert_allclose(second.getEventProbabilityTvedt(), ours(name, "sorm").probability, rtol=5e-3)


def test_a_zone_by_openturns() -> None:
    ot = pytest.importorskip("openturns")
    motion = four_bar(0.1, 0.25, 0.16).move(A=[0.3, 1.0])
    problem = motion.to_openturns("P", ZONE, four_bar, LENGTHS)
    assert problem.function.getOutputDimension() == 2
    found = ours("zone", "form")
    for pose in (0, 1):
        start = [float(law.mean() + 2.0 * law.std()) for law in LENGTHS.values()]
        first, _ = searched(ot, problem, start, pose)
        # The zone is left on two sides, nearly as likely: the search finds one of them.
        at = found.points[found.points.pose == pose]
        scores = np.array(first.getStandardSpaceDesignPoint())
        side = at[[int(np.argmin(np.linalg.norm(at.scores - scores, axis=1)))]]
        assert_allclose(first.getHasoferReliabilityIndex(), side.beta[0], rtol=1e-6)
        factors = first.getImportanceFactors(ot.AnalyticalResult.CLASSICAL)
        assert_allclose(np.array(factors), side.normals[0] ** 2, atol=1e-3)
    ot.RandomGenerator.SetSeed(1)
    way = ot.ProbabilitySimulationAlgorithm(motion.to_openturns("P", 3e-5, four_bar, LENGTHS, anywhere=True).event())
    way.setMaximumOuterSampling(10)
    way.setBlockSize(1000)
    way.setMaximumCoefficientOfVariation(0.0)
    way.run()
    plain = way.getResult()
    mine = motion.reliability("P", 3e-5, four_bar, LENGTHS, anywhere=True, rng=0)
    off = np.hypot(plain.getStandardDeviation(), mine.standard_error)
    assert 0.0 < off < 0.1 * mine.probability
    assert abs(plain.getProbabilityEstimate() - mine.probability) < 4.0 * off


def test_inputs_of_every_kind_in_openturns() -> None:
    """Quantiles, densities and moments, in both tails, of OpenTURNS' own distributions and of those that ask ours."""
    pytest.importorskip("openturns")
    laws = {
        "norm": stats.norm(1.0, 2.0),
        "uniform": stats.uniform(1.0, 2.0),
        "lognorm": stats.lognorm(0.3, loc=1.0, scale=2.0),
        "expon": stats.expon(1.0, 2.0),
        "gamma": stats.gamma(3.0, 1.0, 2.0),
        "beta": stats.beta(2.0, 3.0, loc=1.0, scale=2.0),
        "triang": stats.triang(0.3, 1.0, 2.0),
        "weibull": stats.weibull_min(1.5, 1.0, 2.0),
        "gumbel": stats.gumbel_r(1.0, 2.0),
        "logistic": stats.logistic(1.0, 2.0),
        "t": stats.t(5.0, 1.0, 2.0),
        "interval": (1.0, 3.0),
        "words": "3 ± 5 % normal",
        "skewed": stats.skewnorm(2.0, 1.0, 2.0),
        "newer": stats.Normal(mu=1.0, sigma=2.0),
    }
    problem = to_openturns(lambda **x: x["norm"] + x["t"], laws, by_keyword=True)
    median = problem.distribution.getMarginal(0)
    assert problem.function(list(range(len(laws))))[0] == 10.0
    for k, (name, law) in enumerate(laws.items()):
        each = problem.distribution.getMarginal(k)
        if not isinstance(law, tuple | str):
            wanted = law if hasattr(law, "ppf") else stats.norm(1.0, 2.0)
        else:
            wanted = stats.uniform(1.0, 2.0) if name == "interval" else stats.norm(3.0, 0.05)
        for p in (1e-12, 1e-3, 0.4):
            assert_allclose(each.computeScalarQuantile(p), wanted.ppf(p), rtol=1e-6, err_msg=name)
            assert_allclose(each.computeScalarQuantile(p, True), wanted.isf(p), rtol=1e-6, err_msg=name)
        at = float(wanted.ppf(0.7))
        assert_allclose(each.computePDF(at), wanted.pdf(at), rtol=1e-9, err_msg=name)
        assert_allclose(each.computeCDF(at), 0.7, rtol=1e-9, err_msg=name)
        assert_allclose(each.getMean()[0], wanted.mean(), rtol=1e-9, err_msg=name)
        assert_allclose(each.getStandardDeviation()[0], wanted.std(), rtol=1e-9, err_msg=name)
    assert median.getMean()[0] == 1.0


def test_a_function_of_propagate_in_openturns() -> None:
    """Several results of one call for a whole sample, with the mean and covariance of correlated inputs."""
    ot = pytest.importorskip("openturns")
    calls = []

    def both(a: Array, b: Array) -> tuple[Array, Array]:
        calls.append(len(a))
        return np.stack([a + b, a - b], axis=1), np.full(len(a), "regular")

    inputs, tied = {"a": stats.norm(1.0, 2.0), "b": stats.uniform()}, {("a", "b"): 0.5}
    problem = to_openturns(both, inputs, correlation=tied, by_keyword=True)
    ot.RandomGenerator.SetSeed(0)
    sample = np.array(problem.function(problem.distribution.getSample(20_000)))
    assert calls[-1] == 20_000
    found = propagate(both, inputs, n=20_000, rng=0, correlation=tied, progress=False)
    assert_allclose(sample.mean(axis=0), found.mean, atol=6.0 * float(found.standard_error.max()))
    assert_allclose(sample.std(axis=0), found.std, rtol=0.03)
    assert_allclose(np.array(problem.function.gradient([3.0, 0.5])), [[1.0, 1.0], [1.0, -1.0]], rtol=1e-10)
    vector = ot.ProbabilitySimulationAlgorithm(problem.event(1))
    vector.setBlockSize(2000)
    vector.setMaximumOuterSampling(5)
    vector.run()
    share = float(np.mean(np.subtract(*sample_of(inputs, tied)) <= 0.0))
    assert_allclose(vector.getResult().getProbabilityEstimate(), share, atol=0.03)
    with pytest.raises(FrameError, match="there are 2 results: give the number of one"):
        problem.event()
    with pytest.raises(FrameError, match="result number 2 of 2"):
        problem.event(2)


def sample_of(inputs: Any, tied: Any) -> tuple[Array, Array]:
    kept = propagate(lambda a, b: np.stack([a, b], -1), inputs, n=20_000, rng=1, correlation=tied, progress=False)
    return kept.samples[:, 0], kept.samples[:, 1]


def test_no_result_is_a_failure_in_openturns() -> None:
    ot = pytest.importorskip("openturns")
    problem = to_openturns(lambda x: np.where(x["a"] > -1.0, 1.0, np.nan), {"a": stats.norm()})
    ot.RandomGenerator.SetSeed(0)
    way = ot.ProbabilitySimulationAlgorithm(problem.event())
    way.setBlockSize(10_000)
    way.setMaximumOuterSampling(1)
    way.run()
    assert_allclose(way.getResult().getProbabilityEstimate(), ndtr(-1.0), atol=0.015)


# -- Pystra -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", CASES)
def test_pystra(name: str) -> None:
    pystra = pytest.importorskip("pystra")
    limit, laws, options = CASES[name]
    problem = to_pystra(limit, laws, **options)
    problem.options.e1 = problem.options.e2 = 1e-6
    search = pystra.Form(problem.stochastic_model, problem.limit_state(), problem.options)
    search.run()
    found = ours(name, "form")
    # It solves for Nataf's correlations to four digits.
    near = 1e-4 if options else 1e-6
    assert_allclose(search.getBeta(), found.beta, rtol=near)
    assert_allclose(search.getFailure(), found.probability, rtol=10.0 * near)
    assert_allclose(np.ravel(search.alpha) ** 2, list(found.importance.values()), atol=2e-3)


def test_a_zone_by_pystra() -> None:
    pystra = pytest.importorskip("pystra")
    motion = four_bar(0.1, 0.25, 0.16).move(A=[0.3, 1.0])
    problem = motion.to_pystra("P", ZONE, four_bar, LENGTHS)
    found = ours("zone", "form")
    for name, law in LENGTHS.items():
        problem.stochastic_model.getVariable(name).setStartPoint(law.mean() + 2.0 * law.std())
    for pose in (0, 1):
        search = pystra.Form(problem.stochastic_model, problem.limit_state(pose), problem.options)
        search.run()
        assert_allclose(search.getBeta(), found.points.beta[found.points.pose == pose][0], rtol=1e-3)
    with pytest.raises(FrameError, match="there are 2 results: give the number of one"):
        problem.limit_state()


# -- what both are given ----------------------------------------------------------------------------------------------


def product(x: Mapping[str, Array], pose: Array) -> Array:
    """At pose 0 a² b, at pose 1 three less b."""
    return np.where(pose == 0, x["a"] ** 2 * x["b"], 3.0 - x["b"])


def product_slopes(x: Mapping[str, Array], pose: Array) -> dict[str, Array]:
    first = pose == 0
    return {"a": np.where(first, 2.0 * x["a"] * x["b"], 0.0), "b": np.where(first, x["a"] ** 2, -1.0)}


@pytest.mark.parametrize("gradient", [None, product_slopes])
def test_derivatives_of_every_result(gradient: Any) -> None:
    """In units of 1e-6 as well as of 1e6, and at the edge of what can be drawn."""
    inputs = {"a": stats.norm(2e-6, 1e-7), "b": (1e6, 2e6)}
    every = InputFunction.of(product, inputs, None, gradient, 2, False, False)
    points = np.array([[2e-6, 1.5e6], [1e-6, 2e6]])
    assert_allclose(every(points), [[6e-6, 3.0 - 1.5e6], [2e-6, 3.0 - 2e6]], rtol=1e-12)
    wanted = np.array([[[6.0, 0.0], [4e-12, -1.0]], [[4.0, 0.0], [1e-12, -1.0]]])
    assert_allclose(every.slopes(points), wanted, rtol=1e-6, atol=1e-20)
    assert_allclose(every.curvature(points[0])[..., 0], [[3e6, 4e-6], [4e-6, 0.0]], rtol=1e-5, atol=1e-20)
    least = InputFunction.of(product, inputs, None, gradient, 2, True, False)
    assert_allclose(least(points), [[3.0 - 1.5e6], [3.0 - 2e6]])
    assert_allclose(least.slopes(points), wanted[..., 1:], rtol=1e-6, atol=1e-20)
    assert_allclose(every.only(0).slopes(points), wanted[..., :1], rtol=1e-6, atol=1e-20)


def test_what_cannot_be_handed_on() -> None:
    def of(function: Any, inputs: Any, **options: Any) -> InputFunction:
        given = {"correlation": None, "gradient": None, "poses": None, "anywhere": False, "by_keyword": False}
        return InputFunction.of(function, inputs, **(given | options))

    with pytest.raises(FrameError, match="no distributions were given"):
        of(margin, {})
    with pytest.raises(FrameError, match="by_keyword is for functions of propagate"):
        of(margin, {"r": stats.norm()}, by_keyword=True, poses=2)
    with pytest.raises(FrameError, match=r"returned shape \(\) for 3 samples: one each"):
        of(lambda x: 1.0, {"r": stats.norm()})(np.zeros((3, 1)))


# -- without either ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("hand", "package"), [(to_openturns, "openturns"), (to_pystra, "pystra")])
def test_a_package_that_is_missing_is_told(hand: Any, package: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(FrameError, match=f"{hand.__name__} needs {package}, which is not installed: pip install"):
        hand(margin, {"r": stats.norm(), "s": stats.norm()})
