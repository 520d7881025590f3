"""How far two results are apart, and how far they may be."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
EPS = float(np.finfo(np.float64).eps)


def allowed(scaled_condition_number: ArrayLike) -> Array:
    """Relative error that the numerical contract allows: 1e-12, above kappa = 1e4 100 eps kappa.

    Just below 1e4 that is less than the eps kappa to which the rounding of the matrix itself determines a solution,
    2e-12 (of 400 random frames the worst had 0.53 eps kappa); so eps kappa is allowed at least.
    """
    kappa = np.asarray(scaled_condition_number, dtype=np.float64)
    return np.where(kappa < 1e4, np.maximum(1e-12, EPS * kappa), 100 * EPS * kappa)


# A force is a stiffness times a difference of displacements that are larger than it, and the opening of a stiff joint
# is a force over its spring: of 400 random frames and linkages the worst lost a factor 11 more than the displacements.
FORCES = 30.0


def stacked(vectors: Mapping[str, ArrayLike], names: Iterable[str] | None = None) -> Array:
    """Six-component results of all (or the named) nodes or joints, (..., n, 6)."""
    chosen = [np.asarray(vectors[name], dtype=np.float64) for name in (vectors if names is None else names)]
    return np.stack(np.broadcast_arrays(*chosen), axis=-2)


def apart(result: Array, truth: Array) -> Array:
    """Greatest difference of (..., n, 6), linear and angular components each over their own greatest size, (...)."""
    worst = []
    for part in (slice(0, 3), slice(3, 6)):
        error = np.abs(result[..., part] - truth[..., part]).max(axis=(-1, -2))
        size = np.abs(truth[..., part]).max(axis=(-1, -2))
        worst.append(np.divide(error, size, out=np.zeros_like(error * size), where=error > 0))
    greatest: Array = np.maximum(*worst)
    return greatest
