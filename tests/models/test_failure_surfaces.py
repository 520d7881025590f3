"""Second order of surfaces that close, and how long importance sampling explores."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from linkframe.models import reliability
from linkframe.models.failure.edges import Edges, union
from linkframe.models.failure.second_order import beyond_paraboloid
from numpy.testing import assert_allclose
from reference.limit_states import PROBLEMS
from scipy import stats

Array = np.ndarray[Any, np.dtype[np.float64]]
LAWS = {"x": stats.norm(), "y": stats.norm()}


def outside(a: float, b: float) -> float:
    """Probability outside an ellipse about the median, by the trapezoidal rule over its angle."""
    t = 2.0 * np.pi * (np.arange(2000) + 0.5) / 2000
    return float(np.mean(np.exp(-0.5 / ((np.cos(t) / a) ** 2 + (np.sin(t) / b) ** 2))))


def ellipse(a: float, b: float) -> Any:
    return lambda x: 1.0 - (x["x"] / a) ** 2 - (x["y"] / b) ** 2


@pytest.mark.parametrize(("a", "b"), [(0.5, 0.65), (0.5, 0.5), (1.0, 1.02), (4.0, 4.0), (3.0, 6.0), (4.0, 40.0)])
def test_a_closed_surface_counts_once(a: float, b: float) -> None:
    """What lies beyond several of the paraboloids around the median fails once; spheres have likely failures all over.

    Points that are few leave out what lies between them, so that the probability is never above the exact one.
    """
    found = reliability(ellipse(a, b), LAWS, method="sorm", rng=0, starts=20)
    exact = outside(a, b)
    assert 0.96 * exact < found.probability < 1.005 * exact


def test_a_surface_around_what_is_safe_far_from_the_median() -> None:
    """The median fails, and a disc is safe: its near side is concave, and its probability is that of all but it."""
    found = reliability(lambda x: 1.0 - (x["x"] - 2.5) ** 2 - x["y"] ** 2, LAWS, method="sorm", rng=0, starts=9)
    safe = stats.ncx2(2, 2.5**2).cdf(1.0)
    assert_allclose(1.0 - found.probability, safe, rtol=0.25)
    inside = reliability(lambda x: x["x"] ** 2 + x["y"] ** 2 - 4.0, LAWS, method="sorm", rng=0, starts=20)
    assert_allclose(inside.probability, 1.0 - np.exp(-2.0), rtol=2e-3)


def test_union_of_paraboloids() -> None:
    """Of two whose regions overlap, by Gauss' rule over the direction across both: u = ± (β + ½ κ v²)."""
    beta, bend = 0.6, -1.2
    edges = Edges(
        np.array([[1.0, 0.0], [-1.0, 0.0]]), np.full(2, beta), np.full((2, 1), bend), np.array([[[0.0], [1.0]]] * 2)
    )
    v, weight = np.polynomial.legendre.leggauss(2000)
    v = 10.0 * v
    edge = beta + 0.5 * bend * v**2
    both = np.where(edge < 0.0, 1.0, 2.0 * stats.norm.sf(edge))
    exact = float(10.0 * np.sum(weight * stats.norm.pdf(v) * both))
    assert 2.0 * edges.probability[0] > 1.05 * exact
    probability, error = union(edges, np.random.default_rng(0))
    assert_allclose(probability, exact, rtol=0.01)
    assert abs(probability - exact) < 4.0 * error < 0.02 * exact


def test_paraboloid_of_a_sphere() -> None:
    """Curvature -1/β, where the contour meets the singularity of the integrand: beside Gauss' rule."""
    v, weight = np.polynomial.legendre.leggauss(400)
    v = 12.0 * v
    for beta in (0.5, 1.0, 4.0):
        for off in (0.0, 1e-6, -1e-6):
            bend = -(1.0 + off) / beta
            exact = 12.0 * np.sum(weight * stats.norm.pdf(v) * stats.norm.sf(beta + 0.5 * bend * v**2))
            assert_allclose(beyond_paraboloid(np.array([beta]), np.array([[bend]])), [exact], rtol=1e-9)


@pytest.mark.parametrize("name", ["R-S", "RP33", "RP107"])
def test_exploration_ends_when_enough_is_known(name: str) -> None:
    """Where the worst samples are where the likely failures have them, one level of 500 samples tells."""
    problem, asked = PROBLEMS[name], []

    def limit(x: Mapping[str, Array]) -> Array:
        found = problem(x)
        asked.append(len(found))
        return found

    found = reliability(limit, problem.laws, rng=1, accuracy=0.1)
    assert abs(found.probability - problem.probability) < 4.0 * found.standard_error
    # One level, and blocks about the likely failures; the chains of further levels come by fifty.
    assert asked.count(500) >= 2
    assert 50 not in asked
