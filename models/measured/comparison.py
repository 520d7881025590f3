"""Measured positions beside predicted ones."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError
from ...framework.graphics.style import new_axes, set_title, styled
from .table import Measured

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Comparison:
    """Residuals of a measurement against a prediction; made by `compare`.

    Attributes
    ----------
    residual
        Measured less predicted position, (poses, 3); NaN where one of them is missing.
    uncertainty
        Standard deviation of the residual, of measurement and prediction together, (poses, 3).
    level
        Probability with which a pose lies within its band.
    """

    residual: Array
    uncertainty: Array
    level: float

    @property
    def normalised(self) -> Array:
        """Residual over its uncertainty, (poses, 3)."""
        return self.residual / self.uncertainty

    @property
    def count(self) -> int:
        """Number of components compared."""
        return int(np.isfinite(self.residual).sum())

    @property
    def chi_squared(self) -> float:
        """Sum of the squares of `normalised`; about `count` where the prediction holds."""
        return float(np.nansum(self.normalised**2))

    @property
    def p_value(self) -> float:
        """Probability of a greater sum of squares where the prediction holds and errors are normal."""
        from scipy.special import chdtrc

        return float(chdtrc(self.count, self.chi_squared))

    @property
    def outside(self) -> NDArray[np.bool_]:
        """Poses that lie outside their band: whose own sum of squares is greater than that of `level`, (poses,)."""
        from scipy.special import chdtri

        known = np.isfinite(self.residual)
        most = chdtri(np.maximum(known.sum(axis=1), 1), 1.0 - self.level)
        return np.asarray(np.nansum(self.normalised**2, axis=1) > most)

    @property
    def root_mean_square(self) -> Array:
        """Of the residuals, by component, (3,), lengths; NaN where none was measured."""
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
            Axes of matplotlib to draw on; new ones where None.
        units
            Units of length and force, for the labels.
        over
            Name and values (poses,) of what the poses are drawn over, such as ``("A [°]", angles)``, if it goes only
            forward or only back; the number of the pose otherwise.

        Returns
        -------
        matplotlib.axes.Axes
            What was drawn on: each component with the band that holds it by itself with the probability `level`.

        Raises
        ------
        FrameError
            If nothing was compared, or the values are not one a pose.
        """
        from .residual_plot import draw_residuals  # with what draws, which a comparison in numbers does not need

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
        draw_residuals(found, (label, places), self.residual, self.uncertainty, self.outside, self.level, units[0])
        ratio = self.chi_squared / self.count
        told = f"χ² = {self.chi_squared:.4g} of {self.count} components, {ratio:.3g} each; p = {self.p_value:.2g}"
        set_title(found, told)
        return found

    def __repr__(self) -> str:
        """What it comes to, in a line."""
        poses = np.flatnonzero(self.outside)
        some = ", ".join(map(str, poses[:8])) + (", ..." if poses.size > 8 else "")
        off = f"poses {some} outside the {100.0 * self.level:g} % band" if poses.size else "every pose within its band"
        greatest = float(np.nanmax(np.abs(self.residual)))
        return (
            f"Comparison: chi squared {self.chi_squared:.4g} of {self.count} (p = {self.p_value:.2g}), "
            f"greatest residual {greatest:.3g}, {off}"
        )


def compare(predicted: ArrayLike, measured: Measured, *, deviation: ArrayLike = 0.0, level: float = 0.95) -> Comparison:
    """Compare predicted with measured positions.

    Parameters
    ----------
    predicted
        Positions (poses, 3).
    measured
        What was measured at the same poses.
    deviation
        Standard deviation of the prediction, (poses, 3) or what broadcasts to it, such as that of the tolerances.
    level
        Probability with which a pose should lie within its band.

    Returns
    -------
    Comparison
        Residuals, sum of squares, and what lies outside.

    Raises
    ------
    FrameError
        If shapes do not fit, nothing measured is predicted, neither of the two has an uncertainty, or the level is no
        probability.

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
    whole = np.broadcast_to(np.hypot(own, spread), place.shape)
    known = np.isfinite(measured.position) & np.isfinite(place)
    if not known.any():
        raise FrameError("no pose that was measured has a predicted position: look at the drives and their units")
    if np.any(whole[known] <= 0.0):
        raise FrameError("neither measurement nor prediction has an uncertainty: give one of them")
    return Comparison(np.where(known, measured.position - place, np.nan), np.where(known, whole, 1.0), float(level))
