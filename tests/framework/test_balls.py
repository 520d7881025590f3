"""Least energy over a product of balls: the conditions of the minimum, for every kind of stiffness."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.clearances import ball_qp
from linkframe.framework.clearances.ball_qp import Quadratic, minimise_in_balls
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import minimize

THREE_PAIRS = np.array([0, 0, 1, 1, 2, 2])


def problems(size: float, rank: int, count: int, seed: int = 0, n: int = 6) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(count, n, rank))
    return np.moveaxis(size * roots @ np.swapaxes(roots, 1, 2), 0, -1), rng.normal(size=(n, count))


def conditions(stiffness: np.ndarray, force: np.ndarray, own: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Imbalance by entry; length and multiplier by ball."""
    x, multiplier = minimise_in_balls(stiffness, force, own)
    rest = force - np.einsum("ijn,jn->in", stiffness, x) - multiplier[own] * x
    lengths = np.stack([np.linalg.norm(x[own == ball], axis=0) for ball in range(own[-1] + 1)])
    return np.abs(rest).max(axis=0), lengths, multiplier


@pytest.mark.parametrize("rank", [1, 2, 4, 6])
@pytest.mark.parametrize("size", [0.0, 1e-12, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e8])
def test_conditions_of_the_minimum(size: float, rank: int) -> None:
    """Convex, so that they are all: balance, inside the ball, multiplier only on the sphere."""
    stiffness, force = problems(size, rank, 500)
    rest, length, multiplier = conditions(stiffness, force, THREE_PAIRS)
    assert rest.max() < 1e-14 * (1.0 + size) * 30.0
    assert length.max() <= 1.0 + 1e-15
    assert multiplier.min() >= 0.0
    assert_allclose(length[multiplier > 0.0], 1.0, rtol=1e-15)


@pytest.mark.parametrize("rank", [2, 6])
@pytest.mark.parametrize("size", [1e-2, 1.0, 1e2])
def test_few_entries_take_the_interior_points_and_the_others_would_find_the_same(
    size: float, rank: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    stiffness, force = problems(size, rank, 500)
    searched, search = [0], ball_qp._any_minimum

    def counted(quadratic: Quadratic) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        searched[0] += len(quadratic.largest)
        return search(quadratic)

    monkeypatch.setattr(ball_qp, "_any_minimum", counted)
    x, multiplier = minimise_in_balls(stiffness, force, THREE_PAIRS)
    assert searched[0] <= 0.1 * 500
    monkeypatch.setattr(ball_qp, "_near_minimum", search)
    expected, others = minimise_in_balls(stiffness, force, THREE_PAIRS)
    assert_allclose(multiplier, others, rtol=0.0, atol=1e-11 * np.abs(force).max())
    # as many digits as the minimum has itself
    assert_allclose(np.einsum("ijn,jn->in", stiffness, x - expected), 0.0, atol=1e-11 * (1.0 + size))


@settings(max_examples=50)
@given(st.integers(0, 2**31), st.lists(st.integers(1, 3), min_size=1, max_size=5), st.floats(-6.0, 6.0))
def test_any_number_of_balls(seed: int, sizes: list[int], power: float) -> None:
    own = np.repeat(np.arange(len(sizes)), sizes)
    stiffness, force = problems(10.0**power, max(1, len(own) - 1), 20, seed, len(own))
    rest, length, multiplier = conditions(stiffness, force, own)
    assert rest.max() < 1e-12 * (1.0 + 10.0**power)
    assert length.max() <= 1.0 + 1e-15
    assert_allclose(length[multiplier > 0.0], 1.0, rtol=1e-15)


@pytest.mark.parametrize("seed", range(5))
def test_against_sequential_quadratic_programming(seed: int) -> None:
    stiffness, force = problems(0.5, 4, 1, seed)
    S, f = stiffness[..., 0], force[:, 0]
    x, _ = minimise_in_balls(stiffness, force, THREE_PAIRS)
    spheres = [
        {"type": "ineq", "fun": lambda y, b=b: 1.0 - y[2 * b : 2 * b + 2] @ y[2 * b : 2 * b + 2]} for b in range(3)
    ]
    start = {"method": "SLSQP", "constraints": spheres, "options": {"ftol": 1e-14, "maxiter": 500}}
    found = minimize(lambda y: 0.5 * y @ S @ y - f @ y, np.zeros(6), jac=lambda y: S @ y - f, **start)
    assert 0.5 * x[:, 0] @ S @ x[:, 0] - f @ x[:, 0] == pytest.approx(found.fun, abs=1e-10)
    assert_allclose(x[:, 0], found.x, atol=1e-5)


def test_entries_do_not_know_of_each_other() -> None:
    """The same bits alone and in a batch of any size."""
    stiffness, force = problems(1.0, 4, 3000)
    whole, multiplier = minimise_in_balls(stiffness, force, THREE_PAIRS)
    for entry in (0, 700, 1500, 2047, 2048, 2999):
        one, own = minimise_in_balls(stiffness[..., [entry]], force[:, [entry]], THREE_PAIRS)
        assert_array_equal(whole[:, entry], one[:, 0])
        assert_array_equal(multiplier[:, entry], own[:, 0])


def test_without_force_nothing_moves() -> None:
    stiffness, force = problems(1.0, 6, 3)
    x, multiplier = minimise_in_balls(stiffness, 0.0 * force, THREE_PAIRS)
    assert not x.any()
    assert not multiplier.any()


@pytest.mark.parametrize("push", [1.0 - 1e-9, 1.0, 1.0 + 1e-9])
def test_force_that_just_reaches_the_sphere(push: float) -> None:
    """Where the sphere is touched without force, and just before and after that."""
    x, multiplier = minimise_in_balls(np.eye(2)[..., None], np.array([[0.6 * push], [0.8 * push]]), np.array([0, 0]))
    assert_allclose(x[:, 0], min(push, 1.0) * np.array([0.6, 0.8]), atol=1e-12)
    assert_allclose(multiplier[0, 0], max(push - 1.0, 0.0), atol=1e-12)


@pytest.mark.parametrize("rank", [3, 6])
def test_spheres_touched_without_force(rank: int) -> None:
    """Made so that half of the balls are touched with a multiplier of zero: the conditions hold all the same."""
    stiffness, start = problems(1.0, rank, 1000)
    rng = np.random.default_rng(1)
    lengths = np.stack([np.linalg.norm(start[ball == THREE_PAIRS], axis=0) for ball in range(3)])
    known = start / lengths[THREE_PAIRS]
    multiplier = np.where(rng.random((3, 1000)) < 0.5, 0.0, rng.random((3, 1000)))
    force = np.einsum("ijn,jn->in", stiffness, known) + multiplier[THREE_PAIRS] * known
    rest, length, _ = conditions(stiffness, force, THREE_PAIRS)
    assert rest.max() < 1e-5
    assert np.quantile(rest, 0.95) < 1e-12
    assert length.max() <= 1.0 + 1e-15
    if rank == 6:
        assert_allclose(minimise_in_balls(stiffness, force, THREE_PAIRS)[0], known, atol=1e-8)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_of_many_minima_one_in_the_middle_is_taken(size: float) -> None:
    """Two points that share what stretches one spring: about where their distances from both ends multiply to most."""
    arms, stretch = np.array([1.0, 3.0]), 1.8
    stiffness, force = size * np.outer(arms, arms)[..., None], size * stretch * arms[:, None]
    x, multiplier = minimise_in_balls(stiffness, force, np.array([0, 1]))
    assert_array_equal(multiplier, 0.0)
    assert_allclose(arms @ x, stretch, rtol=1e-14)
    first = np.linspace(-0.99, 0.99, 1999)
    second = (stretch - first) / 3.0
    middle = np.argmax((1.0 - first**2) * (1.0 - second**2))
    assert_allclose(x[:, 0], [first[middle], second[middle]], atol=0.03)
