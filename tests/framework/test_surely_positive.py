"""Pivots alone tell that a matrix is not singular only where they can: a turning chain hides it in small ones."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.solvers.rounding import SUSPECT, surely_positive, zero_eigenvalue


def least_pivot(nodes: int, turning: float) -> float:
    """Least pivot of a beam of unit pieces, deflections and slopes, on a pin and a rotational spring at its start."""
    piece = np.array([[12.0, 6.0, -12.0, 6.0], [6.0, 4.0, -6.0, 2.0], [-12.0, -6.0, 12.0, -6.0], [6.0, 2.0, -6.0, 4.0]])
    matrix = np.zeros((2 * nodes, 2 * nodes))
    for k in range(0, 2 * nodes - 2, 2):
        matrix[k : k + 4, k : k + 4] += piece
    matrix[1, 1] += turning
    matrix = matrix[1:, 1:]
    scale = 1.0 / np.sqrt(np.diagonal(matrix))
    matrix = matrix * scale[:, None] * scale
    pivots = []
    for k in range(len(matrix)):
        pivots.append(matrix[k, k])
        matrix[k + 1 :] -= matrix[k + 1 :, [k]] * matrix[k] / matrix[k, k]
    return float(min(pivots))


@pytest.mark.parametrize("nodes", [2, 5, 20, 100, 300])
def test_a_beam_that_turns_about_its_pin_is_never_sure(nodes: int) -> None:
    least = least_pivot(nodes, 0.0)
    assert abs(least) < 1e-9
    assert not surely_positive(np.array([least, abs(least)]), 2 * nodes - 1).any()


@pytest.mark.parametrize("nodes", [2, 5, 20, 50])
def test_a_cantilever_is_sure_without_another_solution(nodes: int) -> None:
    assert surely_positive(np.array([least_pivot(nodes, 1e3)]), 2 * nodes - 1).all()


def test_what_hides_one_over_the_cube_of_its_links_is_not_sure() -> None:
    """A motion of length one along 10^4 nodes leaves a pivot of 10^12 roundings."""
    size = 60_000
    hidden = 0.5 * zero_eigenvalue(size) * 1e12
    assert surely_positive(np.array([0.5 * hidden, 4.0 * hidden]), size).tolist() == [False, True]
    few = zero_eigenvalue(60) / SUSPECT
    assert surely_positive(np.array([0.5 * few, 2.0 * few]), 60).tolist() == [False, True]


@pytest.mark.parametrize("size", [20, 200])
def test_rounding_of_a_zero_eigenvalue_counts_as_zero(size: int) -> None:
    """Matrices with unit diagonal that lack one direction: the least eigenvalue is rounding, no other is."""
    factor = np.random.default_rng(size).normal(size=(20, size, size - 1))
    factor /= np.linalg.norm(factor, axis=-1, keepdims=True)
    found = np.linalg.eigvalsh(factor @ np.swapaxes(factor, -1, -2))
    assert np.abs(found[:, 0]).max() < zero_eigenvalue(size) < found[:, 1].min()
