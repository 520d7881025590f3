"""OpenTURNS' methods on the same frame, handed over by `to_openturns`: moments, quantiles, and rare failures."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import openturns as ot
from linkframe.models import to_openturns
from numpy.typing import NDArray

from .monte_carlo import INPUTS

Array = NDArray[np.float64]
Height = Callable[..., Array]
# By kind of number (mean, deviation, quantile) its value, and for how many samples the frame was solved.
Numbers = tuple[tuple[float, ...], int]

ot.Log.Show(ot.Log.NONE)
SAMPLERS: Mapping[str, Callable[[Any, int], Any]] = {
    "random": ot.MonteCarloExperiment,
    "lhs": ot.LHSExperiment,
    "sobol": lambda inputs, n: ot.LowDiscrepancyExperiment(ot.SobolSequence(), inputs, n, True),
}


def sampled(height: Height, sampler: str, n: int, seed: int, high: float) -> Numbers:
    """Mean, standard deviation and quantile of samples."""
    ot.RandomGenerator.SetSeed(seed)
    problem = to_openturns(height, INPUTS, by_keyword=True)
    made = SAMPLERS[sampler](problem.distribution, n)
    if sampler == "sobol":
        made.setRandomize(True)
    found = problem.function(made.generate())
    deviation = found.computeStandardDeviation()[0]
    return (found.computeMean()[0], deviation, found.computeQuantilePerComponent(high)[0]), n


def expanded(height: Height, order: int) -> Numbers:
    """Mean of a Taylor series of first or second order, and the deviation of first order, which is all there is."""
    problem = to_openturns(height, INPUTS, by_keyword=True)
    found = ot.TaylorExpansionMoments(ot.CompositeRandomVector(problem.function, ot.RandomVector(problem.distribution)))
    mean = (found.getMeanFirstOrder() if order == 1 else found.getMeanSecondOrder())[0]
    k = len(INPUTS)
    count = 1 + 2 * k * (1 if order == 1 else 2 * k + 1)
    return (mean, float(np.sqrt(found.getCovariance()[0, 0]))), count


def fitted(height: Height, degree: int, seed: int, high: float, points: int) -> Numbers:
    """Moments of Hermite polynomials of the normal scores by least squares, and the quantile of many values."""
    ot.RandomGenerator.SetSeed(seed)
    problem = to_openturns(height, INPUTS, by_keyword=True)
    k = len(INPUTS)
    basis = ot.OrthogonalProductPolynomialFactory([ot.HermiteFactory()] * k)
    terms = basis.getEnumerateFunction().getStrataCumulatedCardinal(degree)
    n = max(32, 3 * terms)
    made = ot.LowDiscrepancyExperiment(ot.SobolSequence(), problem.distribution, n, True)
    made.setRandomize(True)
    inputs = made.generate()
    way = ot.FunctionalChaosAlgorithm(
        inputs,
        problem.function(inputs),
        problem.distribution,
        ot.FixedStrategy(basis, terms),
        ot.LeastSquaresStrategy(),
    )
    way.run()
    found = way.getResult()
    vector = ot.FunctionalChaosRandomVector(found)
    moments = vector.getMean()[0], float(np.sqrt(vector.getCovariance()[0, 0]))
    if not points:
        return moments, n
    many = ot.LowDiscrepancyExperiment(ot.SobolSequence(), problem.distribution, points, True).generate()
    return (*moments, found.getMetaModel()(many).computeQuantilePerComponent(high)[0]), n


class Failure:
    """The event that the displacement passes a limit, with how often the frame was solved."""

    def __init__(self, left: Callable[..., Array], deviation: float) -> None:
        self.count = 0

        def counted(samples: Mapping[str, Array]) -> Array:
            self.count += len(samples["force"])
            # In units of the deviation: the tolerances of a search know no units.
            return left(samples) / deviation

        self.problem = to_openturns(counted, INPUTS)
        self.event = self.problem.event()

    def searched(self, method: str) -> Any:
        """What FORM or SORM finds."""
        way = ot.AbdoRackwitz()
        way.setStartingPoint(self.problem.distribution.getMean())
        found = {"form": ot.FORM, "sorm": ot.SORM}[method](way, self.event)
        found.run()
        return found.getResult()

    def beta(self, method: str) -> float:
        """Generalised reliability index."""
        found = self.searched(method)
        if method == "form":
            return float(found.getGeneralisedReliabilityIndex())
        return float(found.getGeneralisedReliabilityIndexTvedt())

    def probability(self, method: str, seed: int, effort: float = 0.0) -> float:
        """Probability by FORM, SORM, samples about the design point, or subset simulation."""
        ot.RandomGenerator.SetSeed(seed)
        if method == "form":
            return float(self.searched(method).getEventProbability())
        if method == "sorm":
            return float(self.searched(method).getEventProbabilityTvedt())
        if method == "importance":
            way = ot.PostAnalyticalImportanceSampling(self.searched("form"))
            way.setMaximumCoefficientOfVariation(effort)
            way.setBlockSize(500)
            way.setMaximumOuterSampling(400)
        else:
            way = ot.SubsetSampling(self.event)
            way.setBlockSize(100)
            # As many as five runs of ours have together.
            way.setMaximumOuterSampling(int(5 * effort) // 100)
        way.run()
        return float(way.getResult().getProbabilityEstimate())
