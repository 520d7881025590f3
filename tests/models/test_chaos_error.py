"""What a polynomial chaos says of its own error holds at samples that it has not seen."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from linkframe.models import polynomial_chaos
from numpy.testing import assert_allclose
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]
UNIFORM = {"a": stats.uniform(-np.pi, 2.0 * np.pi), "b": stats.uniform(-np.pi, 2.0 * np.pi)}
NORMAL = {"a": stats.norm(), "b": stats.norm()}
FUNCTIONS: dict[str, Callable[[Array, Array], Array]] = {
    "wave": lambda a, b: np.sin(a) + 7.0 * np.sin(b) ** 2,
    "edge": lambda a, b: np.abs(a) + b,
    "step": lambda a, b: (a > 0.5) * 1.0 + b,
    "exponential": lambda a, b: np.exp(0.5 * a) * (1.0 + 0.3 * b),
}


def left(chaos: Any, fn: Callable[[Array, Array], Array], laws: dict[str, Any]) -> float:
    """Share of the variance that is left at 10^5 fresh samples."""
    fresh = {name: law.rvs(100_000, random_state=k) for k, (name, law) in enumerate(laws.items(), 7)}
    values = fn(**fresh)
    return float(np.mean((values - chaos(**fresh)) ** 2) / np.var(values))


@pytest.mark.parametrize("laws", [UNIFORM, NORMAL])
@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_quadrature_tells_what_it_leaves(name: str, laws: dict[str, Any]) -> None:
    """It goes through its own nodes, at which nothing is left however bad it is."""
    fn = FUNCTIONS[name]
    for degree in (3, 5):
        chaos = polynomial_chaos(fn, laws, degree=degree, method="quadrature")
        low, high = chaos.confidence_interval(0.999, of="unexplained")
        assert low <= left(chaos, fn, laws) <= high
        assert chaos.n == (degree + 1) ** 2 + 256


@pytest.mark.parametrize("name", FUNCTIONS)
def test_a_regression_tells_what_it_leaves(name: str) -> None:
    """In at least nine of ten seeds the upper end of the 95 % interval is not below what is left."""
    fn, hold = FUNCTIONS[name], 0
    for seed in range(30):
        chaos = polynomial_chaos(fn, UNIFORM, degree=3, rng=seed, n=60)
        hold += bool(left(chaos, fn, UNIFORM) <= chaos.confidence_interval(0.95, of="unexplained").high)
    assert hold >= 27


def test_what_is_printed() -> None:
    def two(a: Array, b: Array) -> Array:
        return np.stack([a + b, np.abs(a)], axis=-1)

    text = repr(polynomial_chaos(two, UNIFORM, degree=2, method="quadrature"))
    assert "265 calls, left 25.4 % of the variance of entry [1], the worst, at 256 random points" in text
    assert repr(polynomial_chaos(FUNCTIONS["edge"], UNIFORM, degree=2, rng=0)).endswith(
        "left out of the fit one after the other"
    )


def test_a_constant_leaves_nothing_and_a_failure_is_told() -> None:
    steady = polynomial_chaos(lambda a, b: 3.0 + 0.0 * a, UNIFORM, degree=2, method="quadrature")
    assert_allclose(steady.unexplained, 0.0)
    lost = polynomial_chaos(lambda a, b: np.where(a > 0.0, np.nan, a), UNIFORM, degree=2, method="quadrature")
    assert np.isnan(lost.unexplained)
