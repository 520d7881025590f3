"""Whether samples can be normal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .moments import Moments

Array = NDArray[np.float64]

# What the statistic of normal samples exceeds once in a hundred times.
LIMIT = 1.035
# Fewer samples than this tell nothing.
FEWEST = 8


def anderson_darling(samples: Array) -> float:
    """Anderson-Darling statistic of samples against the normal distribution of their own mean and deviation.

    ``A^2 = -n - sum((2 i - 1) (ln F(x_i) + ln(1 - F(x_(n+1-i))))) / n``, times ``1 + 0.75 / n + 2.25 / n^2`` for the
    two numbers that come from the samples (Stephens, *EDF Statistics for Goodness of Fit*, 1974; D'Agostino & Stephens
    1986, table 4.7).

    Parameters
    ----------
    samples
        Finite numbers, (n,), not all the same.

    Returns
    -------
    float
        Above `LIMIT` for one in a hundred sets of normal samples.
    """
    from scipy.special import log_ndtr

    moments = Moments.of(samples)
    off = np.sort((samples - moments.mean) / moments.std)
    n = len(samples)
    weight = 2.0 * np.arange(1, n + 1) - 1.0
    sums = float(np.sum(weight * (log_ndtr(off) + log_ndtr(-off[::-1]))))
    return (-n - sums / n) * (1.0 + 0.75 / n + 2.25 / n**2)
