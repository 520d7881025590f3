"""Inputs whose quantiles jump: counts, measured histograms, mixtures. Against sums over their values."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import polynomial_chaos, reliability, taylor_moments
from numpy.testing import assert_allclose
from scipy import stats

BATCHES = np.histogram(np.r_[np.linspace(-2.5, -1.5, 40), np.linspace(2.0, 4.0, 70)], bins=13)
COUNTS = {
    "die": stats.randint(1, 7),
    "balls": stats.binom(10, 0.3),
    "half": stats.binom(10, 0.5),  # with a step at the median
    "hits": stats.poisson(3.0),
    "pin": stats.rv_discrete(values=([1, 2, 5], [0.2, 0.3, 0.5])),
}


def moments_of_square(law: Any) -> tuple[float, float]:
    """Mean and standard deviation of x² where x is a count, by the sum over its values."""
    x = np.arange(0.0, 200.0)
    p = law.pmf(x)
    mean = p @ x**2
    return mean, np.sqrt(p @ (x**2 - mean) ** 2)


@pytest.mark.parametrize("name", COUNTS)
def test_moments_by_counts(name: str) -> None:
    law = COUNTS[name]
    expected = moments_of_square(law)
    found = taylor_moments(lambda x: x**2, {"x": law}, order=2)
    assert_allclose((found.mean, found.std), expected, rtol=1e-9)
    for method in ("regression", "quadrature"):
        chaos = polynomial_chaos(lambda x: x**2, {"x": law}, degree=2, method=method, rng=0)
        assert_allclose((chaos.mean, chaos.std), expected, rtol=1e-9)


def test_moments_by_a_histogram_with_a_gap() -> None:
    counts, edges = BATCHES
    share, middle = counts / counts.sum(), 0.5 * (edges[1:] + edges[:-1])
    mean = share @ middle
    variance = share @ ((middle - mean) ** 2 + np.diff(edges) ** 2 / 12.0)
    found = taylor_moments(lambda x: 3.0 * x, {"x": stats.rv_histogram(BATCHES, density=False)})
    assert_allclose(found.mean, 3.0 * mean, rtol=1e-12)
    assert_allclose(found.std, 3.0 * np.sqrt(variance), rtol=1e-9)


def test_moments_with_a_kink() -> None:
    """The triangle's density has a kink at its peak; its moments are rational."""
    found = taylor_moments(lambda x: x, {"x": stats.triang(0.3)})
    assert_allclose(found.mean, 1.3 / 3.0, rtol=1e-12)
    assert_allclose(found.std, np.sqrt((1.0 - 0.3 + 0.09) / 18.0), rtol=1e-9)


def test_a_count_beside_a_normal_input() -> None:
    """Regression keeps to polynomials of a count itself: its normal scores are not normally distributed."""
    laws = {"x": stats.poisson(3.0), "y": stats.norm(2.0, 0.5)}
    chaos = polynomial_chaos(lambda x, y: np.exp(0.2 * x) * y, laws, degree=6, rng=0)
    grown = np.exp(3.0 * np.expm1(0.2))
    square = np.exp(3.0 * np.expm1(0.4))
    assert_allclose(chaos.mean, 2.0 * grown, rtol=1e-5)
    assert_allclose(chaos.variance, square * 4.25 - (2.0 * grown) ** 2, rtol=5e-4)


def test_what_has_no_slope_is_refused() -> None:
    laws = {"x": stats.poisson(3.0), "y": stats.norm()}
    for method in ("form", "sorm"):
        with pytest.raises(FrameError, match=f"{method}: 'x' takes separate values only.*'importance'"):
            reliability(lambda v: 9.0 - v["x"] - v["y"], laws, method=method)
    found = reliability(lambda v: 9.0 - v["x"] - v["y"], laws, method="importance", rng=0)
    k = np.arange(60)
    expected = stats.poisson(3.0).pmf(k) @ stats.norm.sf(9.0 - k)
    assert abs(found.probability - expected) < 3.0 * found.standard_error
    with pytest.raises(FrameError, match="'x' takes separate values only and is correlated"):
        polynomial_chaos(lambda x, y: x + y, laws, correlation={("x", "y"): 0.5})
