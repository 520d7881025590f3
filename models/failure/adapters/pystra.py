"""Limit states and their inputs for Pystra (https://pystra.github.io/pystra)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.optional import imported
from ...distributions import Uncertain
from ...propagation.correlation import GaussianCopula, Pairs
from ..limit_state import Function
from .input_function import InputFunction
from .marginal import Marginal

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class PystraProblem:
    """A limit state and its inputs as objects of Pystra; made by `to_pystra`.

    Attributes
    ----------
    stochastic_model
        Distributions of the inputs and their correlation.
    options
        Options of an analysis, set to use the derivatives of the limit state.
    """

    stochastic_model: Any
    options: Any
    _of: InputFunction

    def limit_state(self, pose: int | None = None) -> Any:
        """The limit state at one pose; values of zero or less are failures.

        Parameters
        ----------
        pose
            Number of the pose, counted from 0; may be None if there is only one.

        Returns
        -------
        pystra.LimitState
            The limit state for the analyses of Pystra.

        Raises
        ------
        FrameError
            If there is no such pose, or there are several and `pose` is None.
        """
        pystra = imported("pystra", "to_pystra")
        one = self._of.only(pose)
        made = pystra.LimitState()

        def expression(**samples: Array) -> Any:
            points = np.stack([samples[name] for name in one.names], axis=1)
            values = one(points)[:, 0]
            # Pystra asks for derivatives at one point at a time.
            if len(points) > 1 or made.options.getDiffMode() != "ddm":
                return values
            return values, one.slopes(points)[0]

        made.setExpression(expression)
        return made


def to_pystra(
    function: Function,
    distributions: Mapping[str, Uncertain],
    *,
    correlation: GaussianCopula | Pairs | ArrayLike | None = None,
    gradient: Function | None = None,
    poses: int | None = None,
    anywhere: bool = False,
    by_keyword: bool = False,
) -> PystraProblem:
    """Convert a limit state and the distributions of its inputs to objects of Pystra.

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
        Number of poses, with a limit state for each; None if the limit state does not depend on a pose.
    anywhere
        Whether the only limit state is the smallest over all poses.
    by_keyword
        Whether the inputs are passed by keyword.

    Returns
    -------
    PystraProblem
        The limit state, the stochastic model of its inputs, and options of an analysis.

    Raises
    ------
    FrameError
        If Pystra is not installed, or an argument is invalid.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = {"strength": stats.norm(7.0, 1.0), "load": stats.norm(2.0, 1.0)}
    >>> problem = to_pystra(lambda x: x["strength"] - x["load"], inputs)  # doctest: +SKIP
    >>> search = pystra.Form(problem.stochastic_model, problem.limit_state(), problem.options)  # doctest: +SKIP
    >>> search.run(); search.getBeta()  # doctest: +SKIP
    3.5355339059327378
    """
    pystra = imported("pystra", "to_pystra")
    found = InputFunction.of(function, distributions, correlation, gradient, poses, anywhere, by_keyword)
    model = pystra.StochasticModel()
    for marginal in found.marginals:
        model.addVariable(_variable(pystra, marginal))
    if found.inputs.scores is not None:
        model.setCorrelation(pystra.CorrelationMatrix(found.inputs.correlation()))
    options = pystra.AnalysisOptions()
    options.setDiffMode("ddm")
    return PystraProblem(model, options, found)


def _variable(pystra: Any, marginal: Marginal) -> Any:
    """Pystra's own variable if its transformation to scores is in closed form, exact in the tails, or a general one."""
    kind, numbers = marginal.named() or ("", ())
    if kind == "norm":
        return pystra.Normal(marginal.name, *numbers)
    if kind == "lognorm" and numbers[1] == 0.0:
        # Its first two arguments are then parameters, not moments.
        return pystra.Lognormal(marginal.name, float(np.log(numbers[2])), numbers[0], input_type="parameters")
    return pystra.Distribution(marginal.name, dist_obj=marginal)
