"""Probability beyond several surfaces, standard errors over seeds and without failures, medians that fail."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import reliability
from linkframe.models.failure.edges import Edges, union
from linkframe.models.failure.importance import Mixture, importance_sampling
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
NORMAL = {"x": stats.norm(), "y": stats.norm()}


def test_the_standard_error_of_a_union_is_that_of_the_scatter_over_seeds() -> None:
    """Two planes at right angles: ``1 - (1 - p)(1 - q)``."""
    planes = Edges(np.eye(2), np.array([0.3, 0.8]))
    exact = 1.0 - float(np.prod(stats.norm.cdf([0.3, 0.8])))
    found = np.array([union(planes, np.random.default_rng(seed), samples=2000) for seed in range(300)])
    scores = (found[:, 0] - exact) / found[:, 1]
    assert abs(scores.mean()) < 4.0 / np.sqrt(300.0)
    assert scores.std() == pytest.approx(1.0, abs=0.2)


def test_poses_at_which_the_median_fails_are_safe_beyond_any_of_their_planes() -> None:
    """Pose 0 is safe where x > 2 or y > 2, pose 1 where x > 1.5 or y > 2.5: independent strips of the plane."""

    def limit(given: dict[str, Array], pose: NDArray[np.int64]) -> Array:
        return np.maximum(given["x"] - np.where(pose == 0, 2.0, 1.5), given["y"] - np.where(pose == 0, 2.0, 2.5))

    beyond = stats.norm.sf
    safe = beyond(2.0) + (beyond(1.5) - beyond(2.0)) * beyond(2.0) + stats.norm.cdf(1.5) * beyond(2.5)
    found = reliability(limit, NORMAL, poses=2, anywhere=True, method="form", starts=9, rng=0)
    assert 1.0 - float(found.probability) == pytest.approx(safe, rel=0.03)


def test_a_second_failure_beyond_the_safe_domain_does_not_bound_the_first() -> None:
    """Safe for 1 < x < 2.5 alone: the median fails, and beyond the plane x = 2.5 are further failures."""
    found = reliability(lambda given: (given["x"] - 1.0) * (2.5 - given["x"]), NORMAL, method="form", starts=9, rng=0)
    assert found.points is not None
    assert_allclose(np.sort(found.points.beta), [-1.0, 2.5], atol=1e-6)
    assert float(found.probability) == pytest.approx(stats.norm.cdf(1.0), rel=1e-6)


def test_samples_without_a_failure_bound_the_probability_by_the_rule_of_three() -> None:
    """``p`` for which no failure among n samples has a probability of 5 %, ``1 - 0.05^(1/n)``."""
    found = reliability(lambda given: 10.0 + given["x"], NORMAL, method="random", samples=1000, rng=0)
    assert float(found.probability) == 0.0
    assert 1.96 * float(found.standard_error) == pytest.approx(1.0 - 0.05**1e-3, rel=0.01)


def test_importance_sampling_without_a_failure_counts_the_samples_of_the_normal_density_alone() -> None:
    """A tenth of 5000 samples: the rule of three for 500."""
    mixture = Mixture(np.array([[[0.0, 0.0], [4.0, 0.0]]]), np.array([[0.1, 0.9]]))
    found = importance_sampling(
        lambda scores, which: np.ones(scores.shape[:2]), mixture, np.random.default_rng(0), accuracy=0.05, most=5000
    )
    assert found.samples.tolist() == [5000]
    assert 1.96 * float(found.standard_error[0]) == pytest.approx(1.0 - 0.05 ** (1.0 / 500.0), rel=0.01)
