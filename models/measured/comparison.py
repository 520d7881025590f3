"""Comparison of measured with predicted positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError
from ...framework.graphics.style import new_axes, set_title, styled
from . import residual_plot
from .table import Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
# Smallest eigenvalue of a correlation matrix that counts as regular.
LEAST = 1e-10


@dataclass(frozen=True, eq=False)
class Comparison:
    """Residuals of a measurement against a prediction; made by `compare`.

    Attributes
    ----------
    residual
        Measured minus predicted position, (poses, 3), a length; NaN where one of them is missing.
    uncertainty
        Standard deviation of the residual, from measurement and prediction together, (poses, 3).
    level
        Probability that a pose lies within its band.
    covariance
        Covariance of the residual, (poses, 3, 3), or (poses, 3, poses, 3) with the covariance between poses; None if
        all components are independent.
    """

    residual: Array
    uncertainty: Array
    level: float
    covariance: Array | None = None

    @property
    def normalised(self) -> Array:
        """Residual divided by its uncertainty, (poses, 3)."""
        return self.residual / self.uncertainty

    @property
    def count(self) -> int:
        """Number of components compared."""
        return int(np.isfinite(self.residual).sum())

    @property
    def chi_squared(self) -> float:
        """Sum of squares ``r V⁻¹ r`` of the residuals r with covariance V; about `count` if the prediction is right.

        Without a covariance it is the sum of squares of `normalised`.
        """
        if self.covariance is None:
            return float(np.nansum(self.normalised**2))
        return float(_squares(self.residual, self.covariance).sum())

    @property
    def p_value(self) -> float:
        """Probability of a larger sum of squares if the prediction is right and the errors are normal."""
        from scipy.special import chdtrc

        return float(chdtrc(self.count, self.chi_squared))

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Whether each pose lies outside its band, (poses,): its sum of squares exceeds the quantile at `level`."""
        from scipy.special import chdtri

        known = np.isfinite(self.residual)
        most = chdtri(np.maximum(known.sum(axis=1), 1), 1.0 - self.level)
        if self.covariance is None:
            return np.asarray(np.nansum(self.normalised**2, axis=1) > most)
        return np.asarray(_squares(self.residual, _of_poses(self.covariance)) > most)

    @property
    def root_mean_square(self) -> Array:
        """Root mean square of the residuals by component, (3,), a length; NaN if none was compared."""
        count = np.isfinite(self.residual).sum(axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.sqrt(np.nansum(self.residual**2, axis=0) / np.where(count, count, np.nan)))

    @styled
    def plot(
        self,
        ax: Axes | None = None,
        *,
        units: tuple[str, str] = ("m", "N"),
        over: tuple[str, ArrayLike] | None = None,
    ) -> Axes:
        """Draw the residuals by pose with their bands, and mark the poses that lie outside.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on; new ones if None.
        units
            Units of length and force, for the labels.
        over
            Label and values (poses,) of the horizontal axis, such as ``("A [°]", angles)``. The number of the pose is
            used if None, or if the values neither rise nor fall throughout.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, with a band for each component that contains it alone with the probability `level`.

        Raises
        ------
        FrameError
            If nothing was compared, or `over` does not have one value for each pose.
        """
        if not self.count:
            raise FrameError("no component was both measured and predicted: there is nothing to plot")
        found = new_axes(5.6, 3.4) if ax is None else ax
        label, values = ("pose", np.arange(float(len(self.residual)))) if over is None else over
        places = numbers(values, label)
        if places.shape != self.residual.shape[:1]:
            raise FrameError(f"{label} has shape {places.shape} for {len(self.residual)} measured poses: give one each")
        steps = np.diff(places)
        if not ((steps > 0.0).all() or (steps < 0.0).all()):
            label, places = "pose", np.arange(float(len(places)))
        residual_plot.draw_residuals(
            found, (label, places), self.residual, self.uncertainty, self.outside, self.level, units[0]
        )
        ratio = self.chi_squared / self.count
        told = f"χ² = {self.chi_squared:.4g} of {self.count} components, {ratio:.3g} each; p = {self.p_value:.2g}"
        set_title(found, told)
        return found

    def __repr__(self) -> str:
        """The sum of squares, its probability, the largest residual and the poses outside, in a line."""
        poses = np.flatnonzero(self.outside)
        some = ", ".join(map(str, poses[:8])) + (", ..." if poses.size > 8 else "")
        off = f"poses {some} outside the {100.0 * self.level:g} % band" if poses.size else "every pose within its band"
        greatest = float(np.nanmax(np.abs(self.residual)))
        return (
            f"Comparison: chi squared {self.chi_squared:.4g} of {self.count} (p = {self.p_value:.2g}), "
            f"greatest residual {greatest:.3g}, {off}"
        )


def compare(
    predicted: ArrayLike,
    measured: Measured,
    *,
    deviation: ArrayLike = 0.0,
    covariance: ArrayLike | None = None,
    level: float = 0.95,
) -> Comparison:
    """Compare predicted with measured positions.

    Parameters
    ----------
    predicted
        Predicted positions (poses, 3), lengths.
    measured
        Positions measured at the same poses.
    deviation
        Standard deviation of the prediction, such as that due to tolerances, in a shape that broadcasts to (poses, 3).
    covariance
        Covariance of the prediction in place of `deviation`, (poses, 3, 3), a length squared, because a tolerance moves
        a point along a line. Or (poses, 3, poses, 3), with the covariance between poses: a tolerance of one linkage
        moves the point at all poses together, and without this `chi_squared` counts one deviation many times.
    level
        Probability that a pose lies within its band.

    Returns
    -------
    Comparison
        Residuals, their sum of squares, and the poses outside their bands.

    Raises
    ------
    FrameError
        If shapes do not match, no measured pose has a prediction, neither measurement nor prediction has an
        uncertainty, the covariance is invalid or singular, or the level is not between 0 and 1.

    Examples
    --------
    >>> measured = Measured([[0.1, 0.2, 0.0], [0.3, 0.1, 0.0]], 1e-3, {})
    >>> found = compare([[0.1, 0.2, 0.0], [0.304, 0.1, 0.0]], measured)
    >>> round(found.chi_squared, 9), found.outside.tolist()
    (16.0, [False, True])
    """
    place, spread = numbers(predicted, "predicted position"), numbers(deviation, "deviation")
    if place.shape != measured.position.shape:
        raise FrameError(f"predicted position has shape {place.shape}, the measured one {measured.position.shape}")
    if not 0.0 < level < 1.0:
        raise FrameError(f"level is {level!r}: give a probability between 0 and 1, such as 0.95")
    own = 0.0 if measured.uncertainty is None else measured.uncertainty
    both = None if covariance is None else _checked(covariance, spread, place.shape)
    if both is not None:
        spread = np.sqrt(np.maximum(np.diagonal(_of_poses(both), axis1=1, axis2=2), 0.0))
    whole = np.broadcast_to(np.hypot(own, spread), place.shape)
    known = np.isfinite(measured.position) & np.isfinite(place)
    if not known.any():
        raise FrameError("no pose that was measured has a predicted position: check the drives and their units")
    if np.any(whole[known] <= 0.0):
        raise FrameError("neither measurement nor prediction has an uncertainty: give one of them")
    residual, uncertainty = np.where(known, measured.position - place, np.nan), np.where(known, whole, 1.0)
    return Comparison(residual, uncertainty, float(level), None if both is None else _of_both(both, own, known))


def _checked(covariance: ArrayLike, deviation: Array, shape: tuple[int, ...]) -> Array:
    """Covariance of the prediction as an array, after checks of its shape."""
    found, poses = numbers(covariance, "covariance"), shape[0]
    if deviation.any():
        raise FrameError("the prediction was given a deviation and a covariance: give one of them")
    if found.shape not in ((poses, 3, 3), (poses, 3, poses, 3)):
        raise FrameError(f"covariance has shape {found.shape}: give ({poses}, 3, 3) or ({poses}, 3, {poses}, 3)")
    return found


def _of_both(covariance: Array, own: ArrayLike, known: NDArray[np.bool_]) -> Array:
    """Covariance of measurement and prediction together; a missing component has variance 1 and no correlation."""
    matrix = _matrices(covariance)
    there = known.reshape(*matrix.shape[:-1])
    matrix = np.where(there[..., None] & there[..., None, :], matrix, 0.0)
    _check_correlations(matrix)
    k = np.arange(matrix.shape[-1])
    matrix[..., k, k] += np.where(there, (np.broadcast_to(own, known.shape) ** 2).reshape(there.shape), 1.0)
    deviation = np.sqrt(matrix[..., k, k])
    if not np.all(np.linalg.eigvalsh(matrix / deviation[..., None] / deviation[..., None, :])[..., 0] > LEAST):
        raise FrameError(
            "the covariance leaves a direction without uncertainty, in which no residual is possible: give the "
            "measurement an uncertainty that counts beside it, or the prediction its deviation alone"
        )
    return matrix.reshape(covariance.shape)


def _check_correlations(matrix: Array) -> None:
    """Raise an error unless a covariance (..., n, n) is finite and symmetric with correlations within ±1."""
    deviation = np.sqrt(np.maximum(np.diagonal(matrix, axis1=-2, axis2=-1), 0.0))
    with np.errstate(invalid="ignore"):
        most = deviation[..., None] * deviation[..., None, :]
        good = (np.abs(matrix) <= (1.0 + LEAST) * most) & (np.abs(matrix - matrix.mT) <= LEAST * most)
    if not good.all():
        wrong = matrix[~good]
        raise FrameError(
            f"the covariance holds {wrong[np.argmin(np.isfinite(wrong))]}: give finite numbers, symmetric, with "
            "variances of zero or more and correlations between -1 and 1"
        )


def _matrices(covariance: Array) -> Array:
    """Covariance as a matrix for each pose, (poses, 3, 3), or one for all poses, (1, 3 poses, 3 poses)."""
    return covariance if covariance.ndim == 3 else covariance.reshape(1, 3 * len(covariance), -1)


def _of_poses(covariance: Array) -> Array:
    """Covariance of the components of each pose, (poses, 3, 3)."""
    each = np.arange(len(covariance))
    return covariance if covariance.ndim == 3 else covariance[each, :, each]


def _squares(residual: Array, covariance: Array) -> Array:
    """Sums of squares ``r V⁻¹ r``, one for each matrix of the covariance, without the missing components."""
    matrix = _matrices(covariance)
    r = np.nan_to_num(residual).reshape(*matrix.shape[:-1])
    return np.asarray(np.einsum("...i,...i->...", r, np.linalg.solve(matrix, r[..., None])[..., 0]))
