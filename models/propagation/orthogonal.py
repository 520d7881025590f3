"""Polynomials that are orthonormal under the distribution of an input, whatever it is, and its Gauss quadrature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError
from ..distributions import Distribution
from .correlation import over_scores

Array = NDArray[np.float64]

# Largest degree: beyond it the tails of a normal distribution, which the grid of scores cuts off, begin to count.
MOST = 20


@dataclass(frozen=True, eq=False)
class Orthonormal:
    """Polynomials p_0 ... p_d of x with E[p_i p_j] = 1 for i = j and 0 otherwise, by their three-term recurrence.

    With t = (x − mean)/deviation:  √b_{k+1} p_{k+1} = (t − a_k) p_k − √b_k p_{k−1}  (Gautschi, Orthogonal Polynomials,
    2004, section 1.3; the coefficients by Stieltjes' procedure, section 2.2.3, under the discrete measure of the
    trapezoidal rule over the normal score).

    Parameters
    ----------
    mean, deviation
        Of the input.
    a, b
        Coefficients of the recurrence, (d + 1,) each.
    """

    mean: float
    deviation: float
    a: Array
    b: Array

    @classmethod
    def of(cls, name: str, distribution: Distribution, degree: int) -> Orthonormal:
        """Polynomials up to a degree under the distribution of an input."""
        values, weights = over_scores(name, distribution)
        mean = float(weights @ values)
        deviation = float(np.sqrt(weights @ (values - mean) ** 2))
        if deviation == 0.0:
            raise FrameError(f"{name!r} does not vary: give it as a number of the function's own")
        t = (values - mean) / deviation
        a, b = np.zeros(degree + 1), np.ones(degree + 1)
        before, now = np.zeros(len(t)), np.ones(len(t))
        for k in range(degree + 1):
            a[k] = weights @ (t * now * now)
            then = (t - a[k]) * now - np.sqrt(b[k]) * before * (k > 0)
            if k < degree:
                b[k + 1] = weights @ (then * then)
                if not b[k + 1] > 1e-20:
                    raise FrameError(f"distribution of {name!r} has too few values for degree {degree}")
                before, now = now, then / np.sqrt(b[k + 1])
        return cls(mean, deviation, a, b)

    def __call__(self, x: Array) -> Array:
        """Values of the polynomials, (m, d + 1)."""
        t = (x - self.mean) / self.deviation
        out = np.ones((len(t), len(self.a)))
        for k in range(len(self.a) - 1):
            below = np.sqrt(self.b[k]) * out[:, k - 1] if k else 0.0
            out[:, k + 1] = ((t - self.a[k]) * out[:, k] - below) / np.sqrt(self.b[k + 1])
        return out

    def gauss(self) -> tuple[Array, Array]:
        """Nodes and weights of the Gauss quadrature with d + 1 nodes (Golub & Welsch, 1969), (d + 1,) each."""
        off = np.sqrt(self.b[1:])
        nodes, vectors = np.linalg.eigh(np.diag(self.a) + np.diag(off, 1) + np.diag(off, -1))
        return self.mean + self.deviation * nodes, np.asarray(vectors[0] ** 2)
