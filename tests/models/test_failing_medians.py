"""Probabilities of failure where the median fails, where limit states have steps, and where nothing fails."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.models import reliability
from numpy.typing import NDArray
from scipy import stats
from scipy.special import ndtr

Array = NDArray[np.float64]
Limit = Callable[[dict[str, Array]], Array]
NORMAL = {"u": stats.norm(0.0, 1.0), "v": stats.norm(0.0, 1.0)}


def slab(x: dict[str, Array]) -> Array:
    """Fails in the middle."""
    return np.abs(x["u"]) - 0.5


def far_and_near(x: dict[str, Array]) -> Array:
    """Fails in the middle as well; one edge is near, the other far."""
    return np.maximum(x["u"] - 0.5, -4.0 - x["u"])


def corner(x: dict[str, Array]) -> Array:
    """What is safe lies beyond either of two planes."""
    return np.maximum(x["u"] - 1.0, x["v"] - 1.0)


@pytest.mark.parametrize("method", ["form", "sorm"])
@pytest.mark.parametrize(
    ("limit", "wanted"),
    [
        (slab, ndtr(0.5) - ndtr(-0.5)),
        (far_and_near, ndtr(0.5) - ndtr(-4.0)),
        (corner, ndtr(1.0) ** 2),
    ],
)
def test_planes_about_a_failing_median(limit: Limit, wanted: float, method: str) -> None:
    found = reliability(limit, NORMAL, method=method, rng=0)
    assert found.probability == pytest.approx(wanted, abs=0.005)
    assert np.isfinite(found.beta)
    if limit is far_and_near:
        assert found.points is not None
        assert found.points.beta[0] == pytest.approx(-0.5)
        assert found.likeliest["u"] == pytest.approx(0.5)


def test_anywhere_with_a_failing_median_at_some_poses() -> None:
    """Two slabs that both fail in the middle, and a plane; against the closed form of independent scores."""

    def limit(x: dict[str, Array], pose: NDArray[np.int64]) -> Array:
        return np.select([pose == 0, pose == 1], [np.abs(x["u"]) - 0.5, np.abs(x["u"]) - 0.3], x["v"] + 1.0)

    middle = ndtr(0.5) - ndtr(-0.5)
    found = reliability(limit, NORMAL, method="form", poses=3, anywhere=True, starts=5, rng=0)
    assert found.probability == pytest.approx(1.0 - (1.0 - middle) * ndtr(1.0), abs=0.01)


@pytest.mark.parametrize("safe", [1.0, 1e-6])
@pytest.mark.parametrize("failed", [-1.0, np.nan])
def test_subset_simulation_of_a_step(safe: float, failed: float) -> None:
    """Whether something fails is all that is known: no level leads there."""
    found = reliability(lambda x: np.where(x["u"] > 2.0, failed, safe), NORMAL, method="subset", rng=0)
    low, high = found.confidence_interval(0.999)
    assert low < ndtr(-2.0) < high
    assert found.probability == pytest.approx(ndtr(-2.0), rel=0.5)


def test_subset_simulation_with_a_plateau_on_the_way() -> None:
    """A third of the samples are alike: the chains start from a fair choice of them."""

    def limit(x: dict[str, Array]) -> Array:
        return np.where(x["u"] < 0.5, 3.0, np.where(x["u"] < 2.5, 1.0, 3.5 - x["u"]))

    found = reliability(limit, NORMAL, method="subset", rng=0, samples=4000)
    assert found.probability == pytest.approx(ndtr(-3.5), rel=0.4)


@pytest.mark.parametrize("method", ["importance", "subset", "random"])
def test_where_nothing_fails_a_bound_is_left(method: str) -> None:
    found = reliability(lambda x: 1.0 + 0.0 * x["u"], NORMAL, method=method, rng=0, samples=1000)
    low, high = found.confidence_interval()
    assert found.probability == low == 0.0
    assert 0.0 < high < 0.1


@pytest.mark.parametrize("value", [-1.0, np.nan])
@pytest.mark.parametrize("method", ["importance", "subset", "random"])
def test_where_everything_fails_it_is_certain(method: str, value: float) -> None:
    found = reliability(lambda x: value + 0.0 * x["u"], NORMAL, method=method, rng=1)
    assert 0.95 < found.probability <= 1.0
