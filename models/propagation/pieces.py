"""Quadrature over the normal score of an input whose quantiles jump or have kinks, such as counts and histograms."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Points of a piece, and the width of the pieces to begin with, in which smooth quantiles are exact to rounding.
POINTS, WIDTH = 9, 0.25
# Number of halvings after which a jump is left within its piece; that has a probability of 1e-14 or less.
HALVINGS = 44
# Accepted change of mean and variance by halving a piece, relative to the standard deviation and to the variance.
CLOSE = 1e-14


def resolved(values: Array, weights: Array, close: float = 1e-10) -> bool:
    """Whether mean and variance by every second of equidistant scores are those by all, so that values are smooth.

    Parameters
    ----------
    values, weights
        Values of an input at the scores and their weights, (m,).
    close
        Accepted difference, relative to the standard deviation and to the variance.
    """
    mean, variance = _moments(values, weights)
    half = weights[::2] / weights[::2].sum()
    other, spread = _moments(values[::2], half)
    return bool(abs(other - mean) <= close * np.sqrt(variance) and abs(spread - variance) <= close * variance)


def by_pieces(quantile: Callable[[Array], Array], far: float) -> tuple[Array, Array]:
    """Values of an input and their weights by Lobatto rules on pieces of its normal score, (m,) each.

    Pieces are halved until that changes neither mean nor variance, so that jumps and kinks come to lie between them.

    Parameters
    ----------
    quantile
        Values of the input at normal scores (...).
    far
        Largest score of either sign.
    """
    count = int(np.ceil(2.0 * far / WIDTH))
    start, width = np.linspace(-far, far, count, endpoint=False), np.full(count, 2.0 * far / count)
    values, weights = _on(quantile, start, width)
    mean, variance = _moments(values.ravel(), weights.ravel() / weights.sum())
    deviation = np.sqrt(variance) or 1.0
    found: list[tuple[Array, Array]] = []
    for _ in range(HALVINGS):
        halves = np.stack([start, start + 0.5 * width], axis=-1)
        finer = _on(quantile, halves, np.repeat(0.5 * width[:, None], 2, axis=-1))
        off, fine_off = ((each - mean) / deviation for each in (values, finer[0]))
        change = [
            np.sum(finer[1] * fine_off**power, axis=(-2, -1)) - np.sum(weights * off**power, axis=-1)
            for power in (1, 2)
        ]
        rough = np.max(np.abs(change), axis=0) > CLOSE
        found.append((finer[0][~rough].ravel(), finer[1][~rough].ravel()))
        if not rough.any():
            break
        start, width = halves[rough].ravel(), np.repeat(0.5 * width[rough], 2)
        values, weights = (each[rough].reshape(-1, POINTS) for each in finer)
    else:
        found.append((values.ravel(), weights.ravel()))
    values, weights = (np.concatenate(each) for each in zip(*found, strict=True))
    return values, np.asarray(weights / weights.sum())


def _on(quantile: Callable[[Array], Array], start: Array, width: Array) -> tuple[Array, Array]:
    """Values and weights at the points of pieces (...), (..., POINTS) each."""
    points, weights = _lobatto()
    scores = start[..., None] + width[..., None] * (0.5 + 0.5 * points)
    return quantile(scores.ravel()).reshape(scores.shape), width[..., None] * weights * np.exp(-0.5 * scores**2)


@cache
def _lobatto() -> tuple[Array, Array]:
    """Points of Lobatto's rule, with both ends so that no jump hides, and weights (Abramowitz & Stegun, 25.4.32)."""
    last = np.polynomial.Legendre.basis(POINTS - 1)
    points = np.concatenate([[-1.0], last.deriv().roots().real, [1.0]])
    return points, 1.0 / (POINTS * (POINTS - 1) * last(points) ** 2)


def _moments(values: Array, weights: Array) -> tuple[float, float]:
    mean = float(weights @ values)
    return mean, float(weights @ (values - mean) ** 2)
