"""Parameters of a model from what was measured of it, by weighted least squares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.errors import FrameError
from ..intervals import ConfidenceInterval, by_error
from .table import checked_uncertainty

Array = NDArray[np.float64]
# Called with the parameters by name, (m,) each; returns what would be measured with each set, (m, ...).
Predict = Callable[..., Any]
Gradient = Callable[..., Mapping[str, ArrayLike]]

# Step of the central differences, as a share of a parameter's scale: the cube root of rounding.
STEP = 6e-6
# Share of a prediction by which one that a parameter does not change may differ over a step: some times its rounding.
ROUNDING = 64.0 * np.finfo(np.float64).eps
# Singular value, of effects of unit size, below which the data cannot tell a combination of parameters: well above
# what differences leave of one that is zero. And its share of a parameter below which that is not in it.
LEAST, PART = 1e-7, 0.03


@dataclass(frozen=True, eq=False)
class Calibration:
    """Parameters found from measurements; made by `calibrate`.

    Attributes
    ----------
    values
        Parameters by name, in their units.
    covariance
        Of the parameters in their order, (p, p); infinite where the data cannot tell one.
    residual
        Measured less predicted values, (...) as measured; NaN where there is none.
    chi_squared
        Sum of the squares of the residuals over their uncertainties.
    freedom
        Measured numbers less parameters that could be told.
    known_uncertainty
        Whether the uncertainty of the measurements was given; else it is taken from the residuals.
    undetermined
        Combinations of parameters of which the data says nothing: for each the share of every parameter in it, by name.
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
        """Of the parameters by name, in their units."""
        return dict(zip(self.values, np.sqrt(np.diag(self.covariance)).tolist(), strict=True))

    @property
    def correlation(self) -> Array:
        """Correlation matrix of the parameters, (p, p); NaN where one cannot be told."""
        error = np.sqrt(np.diag(self.covariance))
        with np.errstate(invalid="ignore"):
            return np.asarray(self.covariance / np.outer(error, error))

    def confidence_interval(self, level: float = 0.95) -> dict[str, ConfidenceInterval]:
        """Give bounds of each parameter, by name.

        Parameters
        ----------
        level
            Confidence, between 0 and 1.

        Returns
        -------
        dict
            Bounds by name, in the parameters' units; infinite where the data cannot tell one.
        """
        freedom = np.inf if self.known_uncertainty else self.freedom
        return {name: by_error(self.values[name], error, level, freedom) for name, error in self.standard_error.items()}

    def __repr__(self) -> str:
        """One line a parameter, and what the data cannot tell."""
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
    """Find the parameters with which a model predicts best what was measured.

    Parameters
    ----------
    predict
        Called with the parameters by name, (m,) each, as keywords; returns what each set of them predicts, (m, ...).
    start
        Where to begin, such as the nominal values, by name.
    measured
        Measured values (...), NaN where there is none.
    uncertainty
        Their standard uncertainty, (...) or what broadcasts to it. Where it is not given all are taken as equally
        uncertain, by as much as the residuals spread.
    scales
        Sizes by which parameters may change, by name. By default their own sizes in the course of the search, from
        their values in `start` on, which must not be 0 then.
    gradient
        Called with the parameters by name, one number each, as keywords; returns the derivatives of what is predicted
        by each, by name, (...). Left out, and where one of them is NaN, differences are taken.

    Returns
    -------
    Calibration
        Values with their covariance ``(JᵀWJ)⁻¹`` (Å. Björck, *Numerical Methods for Least Squares Problems*, 1996),
        and the combinations that the data cannot tell.

    Raises
    ------
    FrameError
        If a name or shape does not fit, the model predicts nothing at the start, or the search does not end.

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
    """Where the parameters begin, checked."""
    if not isinstance(start, Mapping) or not start:
        raise FrameError(f"calibrate was given {start!r} for start: name the parameters to be found, with numbers")
    found = {name: _number(value) for name, value in start.items()}
    for name, value in found.items():
        if not np.isfinite(value):
            raise FrameError(f"parameter {name!r} begins at {start[name]!r}: give one finite number")
    return found


def checked_scales(scales: object, start: Mapping[str, float]) -> dict[str, float]:
    """Sizes by which the parameters may change: those given, and of the others those with which they begin."""
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
    """One number; NaN of what is none."""
    try:
        return np.nan if isinstance(value, str) or np.ndim(value) else float(value)
    except (TypeError, ValueError):
        return np.nan


@dataclass(frozen=True, eq=False)
class _Model:
    """A prediction as a function of changes of the parameters in terms of their scales."""

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
        """Parameters (m, p) or (p,)."""
        return np.array(list(self.start.values()), dtype=np.float64) + changes * self.sizes

    def told(self, changes: Array) -> str:
        """The parameters in words."""
        return ", ".join(f"{name} = {value:.6g}" for name, value in zip(self.start, self.values(changes), strict=True))

    def residual(self, changes: Array) -> Array:
        """What is predicted at changes (m, p), of what was measured, (m, n), over its uncertainty."""
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
        """Derivatives of the residuals, (n, p): as they are given, or by differences in one batch."""
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
        """Steps of differences, (p,): of scales that are given, or else of what the parameters have grown to."""
        grown = np.maximum(1.0, np.abs(self.values(changes)) / self.sizes)
        return STEP * np.where(self.given, 1.0, grown)

    def effects(self, changes: Array) -> tuple[Array, Array]:
        """Effects on the residuals, of unit size or, where they are rounding, zero, (n, p), and of what changes, (p,).

        So what the data can tell does not depend on the scales of the parameters.
        """
        slopes = self.slopes(changes)
        size = np.linalg.norm(slopes, axis=0)
        least = ROUNDING * np.linalg.norm(self.residual(changes)) / self._steps(changes)
        some = size > least
        unit = np.where(some, slopes / np.where(some, size, 1.0), 0.0)
        return unit, self.sizes / np.where(some, size, 1.0)

    def _given(self, changes: Array, gradient: Gradient) -> Array:
        by_name = gradient(**dict(zip(self.start, self.values(changes).tolist(), strict=True)))
        missing = [name for name in self.start if name not in by_name]
        if missing:
            raise FrameError(f"the gradient has no derivative by {missing[0]!r}: give one for each parameter")
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
