"""Limit states and their inputs for OpenTURNS (M. Baudin et al., doi:10.1007/978-3-319-12385-1_64)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.optional import imported
from ...distributions import Uncertain
from ...propagation.correlation import GaussianCopula, Pairs
from ...propagation.inputs import JointInputs
from ..limit_state import Function
from .input_function import InputFunction
from .marginal import Marginal

Array = NDArray[np.float64]

# Distributions of OpenTURNS from shape parameters, location and scale, by their names in scipy.stats.
NAMED: Mapping[str, Callable[..., Any]] = {
    "norm": lambda ot, loc, scale: ot.Normal(loc, scale),
    "uniform": lambda ot, loc, scale: ot.Uniform(loc, loc + scale),
    "lognorm": lambda ot, s, loc, scale: ot.LogNormal(float(np.log(scale)), s, loc),
    "expon": lambda ot, loc, scale: ot.Exponential(1.0 / scale, loc),
    "gamma": lambda ot, a, loc, scale: ot.Gamma(a, 1.0 / scale, loc),
    "beta": lambda ot, a, b, loc, scale: ot.Beta(a, b, loc, loc + scale),
    "triang": lambda ot, c, loc, scale: ot.Triangular(loc, loc + c * scale, loc + scale),
    "weibull_min": lambda ot, c, loc, scale: ot.WeibullMin(scale, c, loc),
    "gumbel_r": lambda ot, loc, scale: ot.Gumbel(scale, loc),
    "logistic": lambda ot, loc, scale: ot.Logistic(loc, scale),
    "t": lambda ot, df, loc, scale: ot.Student(df, loc, scale),
}


@dataclass(frozen=True, eq=False)
class OpenTURNSProblem:
    """A function and its inputs as objects of OpenTURNS; made by `to_openturns`.

    Attributes
    ----------
    function
        Function of k inputs with p results, called once for all points of a sample; NaN where there is no result.
    distribution
        Joint distribution of the inputs, with a Gaussian copula if they are correlated.
    """

    function: Any
    distribution: Any
    _of: InputFunction

    def event(self, result: int | None = None) -> Any:
        """Event of failure: a result is zero or less, or NaN.

        Parameters
        ----------
        result
            Number of the result, such as that of the pose, counted from 0; may be None if there is only one.

        Returns
        -------
        openturns.ThresholdEvent
            The event for the algorithms of OpenTURNS.

        Raises
        ------
        FrameError
            If there is no such result, or there are several and `result` is None.
        """
        ot = imported("openturns", "to_openturns")
        one = _function(ot, self._of.only(result))
        vector = ot.CompositeRandomVector(one, ot.RandomVector(self.distribution))
        return ot.ThresholdEvent(vector, ot.LessOrEqual(), 0.0)


def to_openturns(
    function: Function,
    distributions: Mapping[str, Uncertain],
    *,
    correlation: GaussianCopula | Pairs | ArrayLike | None = None,
    gradient: Function | None = None,
    poses: int | None = None,
    anywhere: bool = False,
    by_keyword: bool = False,
) -> OpenTURNSProblem:
    """Convert a function of uncertain inputs and their distributions to objects of OpenTURNS.

    The function is called with whole samples. It has first and second derivatives, by differences if there is no
    `gradient`; their steps fit the spread of each input, whereas the default step of OpenTURNS is fixed.

    Parameters
    ----------
    function
        Limit state as for `reliability`, or with `by_keyword` a function as for `propagate` whose results have the
        samples along the first axis.
    distributions
        Distributions of the inputs by name, as for `propagate`: frozen `scipy.stats` distributions, intervals or
        tolerances.
    correlation
        Correlation of the inputs, as for `propagate`.
    gradient
        Gradient of the limit state, as for `reliability`.
    poses
        Number of poses, with a result for each; None if the limit state does not depend on a pose.
    anywhere
        Whether the only result is the smallest over all poses.
    by_keyword
        Whether the inputs are passed by keyword.

    Returns
    -------
    OpenTURNSProblem
        The function, the joint distribution of its inputs, and the event of failure.

    Raises
    ------
    FrameError
        If OpenTURNS is not installed, an argument is invalid, or a distribution has no ``cdf``.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = {"strength": stats.norm(7.0, 1.0), "load": stats.norm(2.0, 1.0)}
    >>> problem = to_openturns(lambda x: x["strength"] - x["load"], inputs)  # doctest: +SKIP
    >>> way = ot.AbdoRackwitz()  # doctest: +SKIP
    >>> way.setStartingPoint(problem.distribution.getMean())  # doctest: +SKIP
    >>> search = ot.FORM(way, problem.event())  # doctest: +SKIP
    >>> search.run(); search.getResult().getHasoferReliabilityIndex()  # doctest: +SKIP
    3.5355339059327378
    """
    ot = imported("openturns", "to_openturns")
    found = InputFunction.of(function, distributions, correlation, gradient, poses, anywhere, by_keyword)
    return OpenTURNSProblem(_function(ot, found), _joint(ot, found.inputs), found)


def _function(ot: Any, found: InputFunction) -> Any:
    def values(points: ArrayLike) -> Array:
        return found(np.array(points, dtype=np.float64))

    def slopes(point: ArrayLike) -> list[list[float]]:
        return found.slopes(np.array(point, dtype=np.float64)[None])[0].tolist()  # type: ignore[no-any-return]

    def curvature(point: ArrayLike) -> list[list[list[float]]]:
        return found.curvature(np.array(point, dtype=np.float64)).tolist()  # type: ignore[no-any-return]

    made = ot.PythonFunction(len(found.names), found.outputs, func_sample=values, gradient=slopes, hessian=curvature)
    made.setInputDescription(list(found.names))
    return made


def _joint(ot: Any, inputs: JointInputs) -> Any:
    marginals = [_marginal(ot, Marginal(name, distribution)) for name, distribution in inputs.distributions.items()]
    joint = ot.JointDistribution(marginals)
    if inputs.scores is not None:
        correlation = ot.CorrelationMatrix(len(marginals), np.ravel(inputs.scores).tolist())
        joint = ot.JointDistribution(marginals, ot.NormalCopula(correlation))
    joint.setDescription(list(inputs.names))
    return joint


def _marginal(ot: Any, marginal: Marginal) -> Any:
    """The distribution of OpenTURNS of the same name, or else one that calls the methods of `marginal`."""
    named = marginal.named()
    if named is not None and named[0] in NAMED:
        return NAMED[named[0]](ot, *named[1])
    return ot.Distribution(_asking(ot, marginal))


def _asking(ot: Any, marginal: Marginal) -> Any:
    low, high = marginal.support
    finite = np.isfinite([low, high])
    least, most = low if finite[0] else float(marginal.ppf(1e-14)), high if finite[1] else float(marginal.isf(1e-14))
    marginal.cdf(marginal.middle[0])  # raises here if the distribution has no cdf

    class Asking(ot.PythonDistribution):  # type: ignore[misc]
        def getRange(self) -> Any:
            return ot.Interval([least], [most], [bool(finite[0])], [bool(finite[1])])

        def computePDF(self, x: Any) -> float:
            return float(marginal.pdf(x[0]))

        def computeCDF(self, x: Any) -> float:
            return float(marginal.cdf(x[0]))

        def computeComplementaryCDF(self, x: Any) -> float:
            return float(marginal.sf(x[0]))

        def computeScalarQuantile(self, p: float, tail: bool = False) -> float:
            return float(marginal.isf(p) if tail else marginal.ppf(p))

        def computeQuantile(self, p: float, tail: bool = False) -> list[float]:
            return [self.computeScalarQuantile(p, tail)]

        def getSample(self, size: int) -> Any:
            return marginal.ppf(np.array(ot.RandomGenerator.Generate(size)))[:, None]

        def getMean(self) -> list[float]:
            return [marginal.mean()]

        def getStandardDeviation(self) -> list[float]:
            return [marginal.std()]

    return Asking(1)
