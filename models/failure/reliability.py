"""Probability of failure by first-order, second-order and sampling methods, down to one in a billion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.checked import whole_number
from ...framework.errors import FrameError
from ..distributions import Uncertain
from ..intervals import ConfidenceInterval, checked_level
from ..propagation.correlation import GaussianCopula, Pairs
from ..propagation.inputs import JointInputs
from ..quantiles import is_stepped
from ..sampling import Seed, root_seed
from .design_points import DesignPoints, design_points
from .limit_state import Function, LimitState, check_called
from .methods import LimitStateProblems
from .probability_plot import plot_probability

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

METHODS = ("form", "sorm", "importance", "subset", "random")


@dataclass(frozen=True, eq=False)
class Reliability:
    """Probability of failure; made by `reliability`.

    Attributes
    ----------
    probability
        Probability of failure, () or at each pose (poses,).
    standard_error
        Its standard error, of the same shape; NaN if it is no estimate from samples (``"form"``, ``"sorm"``).
    freedom
        Degrees of freedom of the standard error.
    method
        Name of the method, as for `reliability`.
    points
        The design points; None if the method has none.
    inputs
        Distributions of the inputs.
    evaluations, batches
        Number of samples for which the limit state was evaluated, and number of calls.
    along, along_label
        Coordinate of the poses in plots, (poses,), and its label; for a motion those of the first drive.
    """

    probability: Array
    standard_error: Array
    freedom: float
    method: str
    points: DesignPoints | None
    inputs: JointInputs
    evaluations: int
    batches: int
    along: Array | None = None
    along_label: str = "pose"

    @property
    def beta(self) -> Array:
        """Generalised reliability index ``-Φ⁻¹(probability)``, () or (poses,) (O. Ditlevsen, 1979)."""
        from scipy.special import ndtri

        return np.asarray(-ndtri(self.probability))

    @property
    def coefficient_of_variation(self) -> Array:
        """Standard error over probability, () or (poses,); infinite where nothing failed."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.probability > 0.0, self.standard_error / self.probability, np.inf)

    @property
    def importance(self) -> dict[str, Array]:
        """Importance of each input at the nearest design point, () or (poses,); the values add up to 1.

        They are the squared direction cosines of the design point. With correlated inputs they belong to the
        independent scores in the order of the inputs.
        """
        first = self._first()
        return dict(zip(self.inputs.names, (first.normals**2).T.reshape(-1, *self.probability.shape), strict=True))

    @property
    def likeliest(self) -> dict[str, Array]:
        """Values of the inputs at the nearest design point, in their units, () or (poses,)."""
        found = self.inputs.at_scores(self._first().scores)
        return {name: values.reshape(self.probability.shape) for name, values in found.items()}

    def _first(self) -> DesignPoints:
        if self.points is None:
            raise FrameError(f"the method {self.method!r} seeks no likeliest failure: choose form, sorm or importance")
        poses = np.arange(self.probability.size) if self.probability.ndim else np.zeros(0, dtype=np.int64)
        if self.probability.ndim == 0:
            return self.points[[int(np.argmin(self.points.beta))]]
        missing = poses[~np.isin(poses, self.points.pose)]
        if missing.size:
            raise FrameError(f"no failure was found at pose number {missing[0]}: see probability")
        return self.points[np.searchsorted(self.points.pose, poses)]

    def confidence_interval(self, level: float = 0.95) -> ConfidenceInterval:
        """Confidence interval of the probability of failure.

        Parameters
        ----------
        level
            Confidence level, between 0 and 1.

        Returns
        -------
        ConfidenceInterval
            Bounds, () or (poses,) each, for a log-normal estimate with the `coefficient_of_variation`. They are NaN if
            the method uses no samples.
        """
        from scipy.special import ndtri, stdtrit

        p = 0.5 + 0.5 * checked_level(level)
        z = float(ndtri(p) if np.isinf(self.freedom) else stdtrit(self.freedom, p))
        with np.errstate(divide="ignore", invalid="ignore"):
            spread = np.exp(z * np.sqrt(np.log1p(self.coefficient_of_variation**2)))
            some = self.probability > 0.0
            low = np.where(some, self.probability / spread, 0.0 * self.standard_error)
            high = np.where(some, self.probability * spread, z * self.standard_error)
        return ConfidenceInterval(low, np.minimum(high, 1.0))

    def plot(self, ax: Axes | None = None, *, level: float = 0.95) -> Axes:
        """Draw the probability of failure over the poses, with the band of its confidence interval.

        Parameters
        ----------
        ax
            Axes of matplotlib; new ones if None.
        level
            Confidence level of the band; only methods that sample have a band.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, with a logarithmic scale of the probability.

        Raises
        ------
        FrameError
            If there is only one probability, or the level is not between 0 and 1.

        Examples
        --------
        >>> from scipy import stats
        >>> found = reliability(lambda x, pose: 3.0 + pose - x["a"], {"a": stats.norm()}, poses=4, method="form")
        >>> found.plot().get_yscale()
        'log'
        """
        if not self.probability.ndim:
            raise FrameError("there is only one probability, and plot shows one for each pose: leave anywhere out")
        x = np.arange(float(self.probability.size)) if self.along is None else self.along
        band = self.confidence_interval(level) if np.isfinite(self.standard_error).all() else None
        return plot_probability(x, self.probability, band, self.along_label, ax)

    def __repr__(self) -> str:
        """The probability in a line; with several poses that of the pose with the largest."""
        at = int(np.argmax(self.probability)) if self.probability.ndim else ()
        off = self.coefficient_of_variation[at]
        error = f" ± {100.0 * off:.2g} %" if np.isfinite(off) else ""
        where = f" at pose number {at} of {self.probability.size}, the worst" if self.probability.ndim else ""
        return (
            f"Reliability: probability of failure {self.probability[at]:.4g}{error}{where} (beta {self.beta[at]:.4g}), "
            f"{self.method}, {self.evaluations} evaluations"
        )


def reliability(
    limit: Function,
    distributions: Mapping[str, Uncertain],
    *,
    method: str = "importance",
    correlation: GaussianCopula | Pairs | ArrayLike | None = None,
    gradient: Function | None = None,
    poses: int | None = None,
    anywhere: bool = False,
    accuracy: float = 0.05,
    starts: int | None = None,
    samples: int | None = None,
    rng: Seed = None,
) -> Reliability:
    """Probability that a limit-state function is zero or less.

    Parameters
    ----------
    limit
        Called with samples of the inputs by name, (m,) each; returns values (m,), above zero where the state is safe.
        NaN, as for a linkage that cannot be assembled, counts as failure. With `poses` the number of the pose of each
        sample, (m,), counted from 0, is passed as well.
    distributions
        Distributions of the inputs by name, as for `propagate`: frozen `scipy.stats` distributions, intervals or
        tolerances.
    method
        ``"form"``: probability beyond the tangent planes at the design points (A. M. Hasofer & N. C. Lind, 1974).
        ``"sorm"``: beyond paraboloids with the curvature there. ``"importance"``: importance sampling about all design
        points found, until `accuracy` is reached. ``"subset"``: subset simulation, for limit states without a useful
        gradient; it may miss failures and then underestimates the probability; a warning is given if a design point
        shows that. ``"random"``: plain Monte Carlo.
    correlation
        Correlation of the inputs, as for `propagate`.
    gradient
        Called like `limit`; returns the derivatives with respect to the inputs, by name, (m,) each, or a pair of the
        values, (m,), and these, which saves a call of `limit`. Differences are taken if None.
    poses
        Number of poses; None if `limit` does not depend on a pose.
    anywhere
        Whether to find the probability of failing at one pose or more instead of that at each pose.
    accuracy
        Coefficient of variation at which ``"importance"`` ends.
    starts
        Number of points from which design points are searched; by default 9, or 1 for every method but
        ``"importance"`` with `poses`.
    samples
        Largest number of samples for each probability, 200 000 by default; for ``"subset"`` the number at a level of
        each of its five runs, 1000 by default.
    rng
        Seed, as in SciPy.

    Returns
    -------
    Reliability
        The probability of failure with its uncertainty.

    Raises
    ------
    FrameError
        If an argument is invalid, a method that needs a design point finds none, or a plane or paraboloid cannot
        represent the limit state at the design point, as where an input takes separate values only.

    Warns
    -----
    SampleWarning
        If subset simulation missed a design point.

    Examples
    --------
    >>> from scipy import stats
    >>> inputs = {"strength": stats.norm(7.0, 1.0), "load": stats.norm(2.0, 1.0)}
    >>> found = reliability(lambda x: x["strength"] - x["load"], inputs, method="form")
    >>> round(float(found.beta), 6)  # 5 / sqrt(2)
    3.535534
    """
    if method not in METHODS:
        raise FrameError(f"method of reliability is {method!r}: choose one of {', '.join(METHODS)}")
    if not 0.0 < accuracy < 1.0:
        raise FrameError(f"accuracy is {accuracy!r}: give a coefficient of variation between 0 and 1, such as 0.05")
    count = None if poses is None else whole_number(poses, "number of poses", 1)
    joint = JointInputs.of(distributions, correlation)
    if not joint.names:
        raise FrameError("reliability was given no distributions: nothing is uncertain")
    for name, distribution in joint.distributions.items():
        if method in ("form", "sorm") and is_stepped(distribution):
            raise FrameError(
                f"{method}: {name!r} takes separate values only, so that the limit state has no slope: use the method "
                "'importance'"
            )
    check_called(limit, joint.names, count is not None)
    if gradient is not None and not callable(gradient):
        raise FrameError(f"gradient is {gradient!r}: give a function that is called like limit, or leave it out")
    state = LimitState(limit, joint, gradient, count)
    run = LimitStateProblems(state, anywhere and count is not None, root_seed(rng))
    most = (
        whole_number(1000 if method == "subset" else 200_000, "", 1)
        if samples is None
        else whole_number(samples, "samples", 100)
    )
    points: DesignPoints | None = None
    if method == "random":
        found = run.random(most)
    else:
        begin = (1 if count and method != "importance" else 9) if starts is None else whole_number(starts, "starts", 1)
        points = design_points(state, begin)
        if method == "subset":
            found = run.subset(most, points)
            points = None
        elif method == "importance":
            points, found = run.importance(points, accuracy, most)
        else:
            found = run.first_order(points) if method == "form" else run.second_order(points)
    shape = () if count is None or anywhere else (count,)
    numbers = found.probability.reshape(shape), found.standard_error.reshape(shape)
    return Reliability(*numbers, found.freedom, method, points, joint, state.evaluations, state.batches)
