"""Parameters of a model from measurements, by weighted least squares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.checked import check_gradient
from ...framework.errors import FrameError
from ..intervals import ConfidenceInterval, by_error
from .table import checked_uncertainty

Array = NDArray[np.float64]
# Function of the parameters by name, (m,) each; returns the predicted measurements for each set, (m, ...).
Predict = Callable[..., Any]
Gradient = Callable[..., Mapping[str, ArrayLike]]

# Step of the central differences, as a share of a parameter's scale: the cube root of rounding.
STEP = 6e-6
# Relative change of a prediction over a step that may be rounding.
ROUNDING = 64.0 * np.finfo(np.float64).eps
# Singular value, as a share of the largest, below which the data do not determine a combination of parameters: well
# above the error of differences. And the coefficient in a combination below which a parameter counts as not part of it.
LEAST, PART = 1e-7, 0.03


@dataclass(frozen=True, eq=False)
class Calibration:
    """Parameters found from measurements; made by `calibrate`.

    Attributes
    ----------
    values
        Parameters by name, in their units.
    covariance
        Covariance of the parameters in their order, (p, p); infinite variance if the data do not determine a parameter.
    residual
        Measured minus predicted values, (...) as measured; NaN where nothing was measured.
    chi_squared
        Sum of the squares of the residuals over their uncertainties.
    freedom
        Number of measured values minus number of determined combinations of parameters.
    known_uncertainty
        Whether the uncertainty of the measurements was given; else it is estimated from the residuals.
    undetermined
        Combinations of parameters that the data do not determine: for each the coefficients of its parameters, by name.
    """

    values: Mapping[str, float]
    covariance: Array
    residual: Array
    chi_squared: float
    freedom: int
    known_uncertainty: bool
    undetermined: tuple[Mapping[str, float], ...]

    @property
    def standard_error(self) -> dict[str, float]:
        """Standard errors of the parameters by name, in their units."""
        return dict(zip(self.values, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the parameters, (p, p); NaN if one of the two is not determined."""
        error = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore"):
            return np.asarray(self.covariance / np.outer(error, error))

    def confidence_interval(self, level: float = 0.95) -> dict[str, ConfidenceInterval]:
        """Confidence interval of each parameter.

        Parameters
        ----------
        level
            Confidence level, between 0 and 1.

        Returns
        -------
        dict
            Bounds by name, in the parameters' units; infinite if the data do not determine a parameter.
        """
        freedom = np.inf if self.known_uncertainty else self.freedom
        return {name: by_error(self.values[name], error, level, freedom) for name, error in self.standard_error.items()}

    def __repr__(self) -> str:
        """A line for each parameter and for each combination of parameters that is not determined."""
        rows = [f"{name} = {value:.6g} ± {self.standard_error[name]:.2g}" for name, value in self.values.items()]
        rows += [f"not told by the data: {' with '.join(each)}" for each in self.undetermined]
        return "\n  ".join([f"Calibration: chi squared {self.chi_squared:.4g} of {self.freedom}", *rows])


def calibrate(
    predict: Predict,
    start: Mapping[str, float],
    measured: ArrayLike,
    *,
    uncertainty: ArrayLike | None = None,
    scales: Mapping[str, float] | None = None,
    gradient: Gradient | None = None,
) -> Calibration:
    """Find the parameters for which a model agrees best with measurements.

    Parameters
    ----------
    predict
        Called with the parameters by keyword, (m,) each; returns the predicted values for each set, (m, ...).
    start
        Initial values by name, such as the nominal ones.
    measured
        Measured values (...), NaN where nothing was measured.
    uncertainty
        Standard uncertainty of the measured values, in a shape that broadcasts to (...). If None all values are taken
        as equally uncertain, with the spread of the residuals.
    scales
        Typical changes of the parameters, by name, in their units. By default the sizes of the parameters themselves,
        which must then not be 0 in `start`.
    gradient
        Called with the parameters by keyword, one number each; returns the derivatives of the prediction with respect
        to each parameter, by name, (...). If None, or if a derivative is NaN, differences are taken.

    Returns
    -------
    Calibration
        Values with their covariance ``(JᵀWJ)⁻¹`` (Å. Björck, *Numerical Methods for Least Squares Problems*, 1996),
        and the combinations of parameters that the data do not determine.

    Raises
    ------
    FrameError
        If a name or shape does not match, the model predicts no value at the start, or the search does not converge.

    Examples
    --------
    >>> x = np.linspace(0.0, 1.0, 5)
    >>> line = lambda a, b: a[:, None] + b[:, None] * x
    >>> found = calibrate(line, {"a": 1.0, "b": 1.0}, 0.5 + 3.0 * x, uncertainty=0.1)
    >>> round(found.values["a"], 9), round(found.values["b"], 9)
    (0.5, 3.0)
    """
    from scipy.optimize import least_squares

    start = checked_start(start)
    target = numbers(measured, "measured values")
    there = np.isfinite(target)
    spread = checked_uncertainty(uncertainty, target.shape)
    weight = (np.ones(target.shape) if spread is None else 1.0 / spread)[there]
    given = np.array([scales is not None and name in scales for name in start])
    model = _Model(predict, start, checked_scales(scales, start), target.shape, there, weight, given, gradient)
    if not np.isfinite(model.residual(np.zeros(len(start)))).all():
        raise FrameError("the model predicts no value at the start for something measured: begin elsewhere")

    def off(changes: Array) -> Array:
        return model.off(changes, target)

    with np.errstate(invalid="ignore"):
        found = least_squares(off, np.zeros(len(start)), model.slopes, xtol=1e-15, ftol=1e-15, gtol=1e-15)
    if found.status < 1:
        raise FrameError(
            f"the search for the parameters did not end after {found.nfev} steps, at {model.told(found.x)}: begin "
            "nearer, or give scales"
        )
    return _calibration(model, found.x, target, known=spread is not None)


def checked_start(start: object) -> dict[str, float]:
    """Check the initial values of the parameters and return them as floats, by name."""
    if not isinstance(start, Mapping) or not start:
        raise FrameError(f"calibrate was given {start!r} for start: name the parameters to be found, with numbers")
    found = {name: _number(value) for name, value in start.items()}
    for name, value in found.items():
        if not np.isfinite(value):
            raise FrameError(f"parameter {name!r} begins at {start[name]!r}: give one finite number")
    return found


def checked_scales(scales: object, start: Mapping[str, float]) -> dict[str, float]:
    """Scales of the parameters by name: those given, and for the others the sizes of the initial values."""
    given = {} if scales is None else scales
    if not isinstance(given, Mapping):
        raise FrameError(f"scales is {scales!r}: give sizes by the names of parameters")
    for name in given.keys() - start.keys():
        raise FrameError(f"scales names {name!r}, which is not among the parameters {', '.join(start)}")
    found = {name: abs(_number(given.get(name, value))) for name, value in start.items()}
    for name, size in found.items():
        if not 0.0 < size < np.inf:
            if name in given:
                raise FrameError(f"the scale of parameter {name!r} is {given[name]!r}: give one number, and not zero")
            raise FrameError(f"parameter {name!r} begins at {start[name]!r}: give its scale in scales")
    return found


def _number(value: Any) -> float:
    """The value as a number, NaN if it is not one."""
    try:
        return np.nan if isinstance(value, str) or np.ndim(value) else float(value)
    except (TypeError, ValueError):
        return np.nan


@dataclass(frozen=True, eq=False)
class _Model:
    """Prediction of a model as a function of the changes of the parameters divided by their scales."""

    predict: Predict
    start: Mapping[str, float]
    scales: Mapping[str, float]
    shape: tuple[int, ...]
    there: NDArray[np.bool_]
    weight: Array
    given: NDArray[np.bool_]
    gradient: Gradient | None = None

    @property
    def sizes(self) -> Array:
        return np.array(list(self.scales.values()))

    def values(self, changes: Array) -> Array:
        """Parameters at changes (m, p) or (p,), of the same shape."""
        return np.array(list(self.start.values()), dtype=np.float64) + changes * self.sizes

    def told(self, changes: Array) -> str:
        """The parameters at changes (p,), as text."""
        return ", ".join(f"{name} = {value:.6g}" for name, value in zip(self.start, self.values(changes), strict=True))

    def residual(self, changes: Array) -> Array:
        """Predictions of the n measured values at changes (m, p), divided by the uncertainties, (m, n)."""
        several = np.atleast_2d(changes)
        found = numbers(self.predict(**dict(zip(self.start, self.values(several).T, strict=True))), "prediction")
        if found.shape != (len(several), *self.shape):
            raise FrameError(
                f"the model returned shape {found.shape} for {len(several)} sets of parameters and measured values of "
                f"shape {self.shape}: return {(len(several), *self.shape)}"
            )
        return np.asarray(found[:, self.there] * self.weight)

    def off(self, changes: Array, target: Array) -> Array:
        return np.asarray(self.residual(changes)[0] - target[self.there] * self.weight)

    def slopes(self, changes: Array) -> Array:
        """Derivatives of the weighted predictions, (n, p), from the gradient or by differences in one batch."""
        given = None if self.gradient is None else self._given(changes, self.gradient)
        if given is not None and np.isfinite(given).all():
            return given
        size = self._steps(changes)
        steps = np.diag(size)
        found = self.residual(np.concatenate([changes + steps, changes - steps]))
        if not np.isfinite(found).all():
            raise FrameError(
                f"the search for the parameters came to {self.told(changes)}, where the model predicts no value for "
                "something measured: begin elsewhere, or leave out what was measured there"
            )
        return np.asarray((found[: len(steps)] - found[len(steps) :]).T / (2.0 * size))

    def _steps(self, changes: Array) -> Array:
        """Steps of the differences in changes, (p,): relative to given scales, or to the current sizes if larger."""
        grown = np.maximum(1.0, np.abs(self.values(changes)) / self.sizes)
        return STEP * np.where(self.given, 1.0, grown)

    def effects(self, changes: Array) -> tuple[Array, Array]:
        """Columns of derivatives scaled to unit length, (n, p), and the changes of the parameters they stand for, (p,).

        A column that is only rounding is set to zero. With columns of unit length it does not depend on the scales of
        the parameters which combinations count as determined.
        """
        slopes = self.slopes(changes)
        size = np.linalg.norm(slopes, axis=0)
        least = ROUNDING * np.linalg.norm(self.residual(changes)) / self._steps(changes)
        some = size > least
        unit = np.where(some, slopes / np.where(some, size, 1.0), 0.0)
        return unit, self.sizes / np.where(some, size, 1.0)

    def _given(self, changes: Array, gradient: Gradient) -> Array:
        by_name = gradient(**dict(zip(self.start, self.values(changes).tolist(), strict=True)))
        check_gradient(by_name, self.start, "parameter")
        columns = [np.broadcast_to(by_name[name], self.shape)[self.there] * self.weight for name in self.start]
        return np.stack(columns, axis=-1) * self.sizes


def _calibration(model: _Model, changes: Array, target: Array, *, known: bool) -> Calibration:
    names = tuple(model.start)
    effects, units = model.effects(changes)
    _, size, rows = np.linalg.svd(effects, full_matrices=True)
    size = np.concatenate([size, np.zeros(len(names) - len(size))])
    text = size > LEAST * max(float(size[0]), 1e-300)
    values, off = model.values(changes), model.off(changes, target)
    freedom = int(off.size - text.sum())
    chi_squared = float(off @ off)
    variance = 1.0 if known else chi_squared / freedom if freedom else np.nan
    directions = rows[text] * units
    covariance = variance * (directions.T / size[text] ** 2) @ directions
    lost = np.abs(rows[~text]).max(axis=0, initial=0.0) > PART
    covariance[lost] = covariance[:, lost] = np.nan
    covariance[lost, lost] = np.inf
    residual = np.full(target.shape, np.nan)
    residual[model.there] = -off / model.weight
    undetermined = tuple(
        {name: float(share) for name, share in zip(names, row, strict=True) if abs(share) > PART} for row in rows[~text]
    )
    by_name = dict(zip(names, values.tolist(), strict=True))
    return Calibration(by_name, covariance, residual, chi_squared, freedom, known, undetermined)
