"""Results that have no entries, no spread, no finite sample or no sample at all: answered as NumPy answers."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework.errors import SampleWarning
from linkframe.models import Linkage, polynomial_chaos, propagate, propagate_fuzzy, sobol_indices
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
INPUTS = {"a": stats.norm(), "b": stats.uniform()}


@pytest.mark.parametrize("shape", [(0,), (3, 0), (0, 2)])
def test_no_entries(shape: tuple[int, ...]) -> None:
    def nothing(a: Array, b: Array) -> Array:
        return np.zeros((len(a), *shape))

    found = propagate(nothing, INPUTS, n=64, rng=0, keep_samples=False, also=("histogram", "covariance"))
    assert found.quantile(0.5).shape == found.confidence_interval(of=0.5).low.shape == shape
    assert found.histogram().counts.shape[:-1] == shape
    assert propagate(nothing, INPUTS, n=64, rng=0).histogram().counts.shape[:-1] == shape
    assert sobol_indices(nothing, INPUTS, n=16, rng=0, replicates=4).total.shape == (*shape, 2)
    for method in ("regression", "quadrature"):
        chaos = polynomial_chaos(nothing, INPUTS, degree=2, method=method)
        assert chaos.mean.shape == chaos.unexplained.shape == shape
        assert chaos.sobol.first.shape == (*shape, 2)
    for method in ("search", "corners", "first order"):
        assert propagate_fuzzy(nothing, {"a": (0, 1, 2), "b": (0, 1)}, method=method).lower.shape == (11, *shape)


@pytest.mark.parametrize(
    "options", [{}, {"replicates": 4}, {"keep_samples": False, "also": ("histogram", "covariance")}]
)
def test_infinite_samples(options: dict[str, object]) -> None:
    """The mean is what NumPy has, infinite; so are the quantiles beyond, and no deviation is known."""

    def some(a: Array, b: Array) -> Array:
        each = np.stack([np.where(a > 1.0, np.inf, a), np.where(a < -1.0, -np.inf, b), a], axis=-1)
        both = np.where(a > 1.0, np.inf, np.where(a < -1.0, -np.inf, a))
        return np.concatenate([each, both[:, None]], axis=-1)

    found = propagate(some, INPUTS, n=3072, rng=0, **options)
    a = found.input_samples["a"]
    assert_array_equal(found.mean[[0, 1, 3]], [np.inf, -np.inf, np.nan])
    assert_allclose(found.mean[2], a.mean(), atol=1e-14)
    assert_array_equal(np.isnan(found.std), [True, True, False, True])
    low, high, most = found.quantile([0.01, 0.99, 1.0])
    assert_array_equal([low[1], low[3], high[0], high[3], most[0], most[3]], [-np.inf] * 2 + [np.inf] * 4)
    assert np.isfinite([low[0], high[1], low[2], most[2]]).all()
    assert np.isnan(found.covariance[0, 2])
    assert np.isfinite(found.covariance[2, 2])


def test_what_stands_on_all_samples_names_infinite_ones() -> None:
    def some(a: Array, b: Array) -> Array:
        return np.stack([np.where(a > 1.0, np.inf, a), b], axis=-1)

    with pytest.warns(SampleWarning, match="samples are NaN or infinite somewhere; the Sobol indices are NaN there"):
        assert_array_equal(np.isnan(sobol_indices(some, INPUTS, n=64, rng=0).total[:, 0]), [True, False])
    with pytest.warns(SampleWarning, match="are NaN or infinite and left out of the regression"):
        assert np.isfinite(polynomial_chaos(some, INPUTS, degree=2, rng=0).mean).all()
    found = propagate_fuzzy(lambda a: np.where(a > 0.4, np.inf, a), {"a": (0.0, 0.2, 1.0)}, levels=3)
    assert_array_equal(found.upper, [np.inf, np.inf, 0.2])


@pytest.mark.parametrize("value", [0.0, 0.1, 1e9 / 3.0])
def test_a_constant_has_no_shares(value: float) -> None:
    """However rounding has it, no input has a share of what does not vary, and nothing is left of it."""

    def steady(a: Array, b: Array) -> Array:
        return np.stack([value + 0.0 * a, a], axis=-1)

    by: list[Callable[[], object]] = [
        lambda: sobol_indices(steady, INPUTS, n=64, rng=0),
        lambda: polynomial_chaos(steady, INPUTS, degree=3, rng=0).sobol,
        lambda: polynomial_chaos(steady, INPUTS, degree=3, method="quadrature").sobol,
    ]
    for make in by:
        shares = make()
        for each in ("first", "total"):
            assert_array_equal(getattr(shares, each)[0], 0.0)
            assert_allclose(getattr(shares, each)[1], [1.0, 0.0], atol=0.2)
    chaos = polynomial_chaos(steady, INPUTS, degree=3, rng=0)
    assert chaos.mean[0] == value
    assert chaos.std[0] == chaos.unexplained[0] == 0.0
    assert_array_equal(chaos.confidence_interval(of="std").high[0], 0.0)


def test_no_sample_has_a_result() -> None:
    linkage = Linkage(A=(0, 0), B=(0.1, 0.05))
    linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
    linkage.revolute("A", "ground", "arm", drive=True, stiffness=(0.0, 2e9, 2e9, 2e9, 2e9, 0.0))
    linkage.load("B", fx=-50.0)
    found = linkage.study({"points.B.x": 1e-4}, "B", {"A": [0.1, 0.2]}, n=8, rng=0, progress=False)
    assert repr(found).endswith("none of 8 samples has a result\n         8 mechanism")
    half = propagate(lambda a: np.stack([a, np.nan * a], axis=-1), {"a": stats.norm()}, n=8, rng=0)
    assert repr(half).endswith("none of 8 samples failed\n1 of 2 numbers of the result are NaN in every sample")
