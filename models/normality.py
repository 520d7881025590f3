"""Test of samples for a normal distribution."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .moments import Moments

Array = NDArray[np.float64]

# Critical value of the statistic at a significance level of 1 %.
LIMIT = 1.035
# Smallest number of samples that are tested.
FEWEST = 8


def anderson_darling(samples: Array) -> float:
    """Anderson-Darling statistic of samples for the normal distribution with their mean and standard deviation.

    ``A^2 = -n - sum((2 i - 1) (ln F(x_i) + ln(1 - F(x_(n+1-i))))) / n``, times ``1 + 0.75 / n + 2.25 / n^2`` because
    mean and standard deviation are estimated (Stephens, *EDF Statistics for Goodness of Fit*, 1974; D'Agostino &
    Stephens 1986, table 4.7).

    Parameters
    ----------
    samples
        Finite numbers, (n,), not all the same.

    Returns
    -------
    float
        The statistic; one in a hundred sets of normal samples has a value above `LIMIT`.
    """
    from scipy.special import log_ndtr

    moments = Moments.of(samples)
    off = np.sort((samples - moments.mean) / moments.std)
    n = len(samples)
    weight = 2.0 * np.arange(1, n + 1) - 1.0
    sums = float(np.sum(weight * (log_ndtr(off) + log_ndtr(-off[::-1]))))
    return (-n - sums / n) * (1.0 + 0.75 / n + 2.25 / n**2)
