"""LDLᵀ of small matrices against NumPy's solver and against what the factors of a semidefinite matrix must make."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.ldl import eliminated, factorised, sparse_steps, substitute, substituted


def stack(size: int, rank: int, count: int) -> np.ndarray:
    """Semidefinite matrices (size, size, count)."""
    rows = np.random.default_rng(size).standard_normal((count, rank, size))
    return np.moveaxis(np.swapaxes(rows, 1, 2) @ rows, 0, -1).copy()


@pytest.mark.parametrize("size", [1, 2, 5, 9])
def test_it_solves_as_numpy_does(size: int) -> None:
    matrix, load = stack(size, size + 6, 7), np.random.default_rng(1).standard_normal((size, 7))
    expected = np.linalg.solve(np.moveaxis(matrix, -1, 0), load.T[..., None])[..., 0].T
    np.testing.assert_allclose(substituted(factorised(matrix.copy(), 1e-15), load), expected, rtol=1e-11)


def test_what_is_rounding_is_left_out() -> None:
    matrix = stack(5, 2, 7)
    columns = factorised(matrix.copy(), 1e-9, raised=False)
    inverse = np.stack([over for _, over in columns], axis=-1)
    np.testing.assert_array_equal(inverse > 0.0, np.tile(np.arange(5) < 2, (7, 1)))
    lower = np.zeros((7, 5, 2)) + np.eye(5, 2)
    for k, (column, _) in enumerate(columns[:2]):
        lower[:, k + 1 :, k] = column.T
    np.testing.assert_allclose(
        (lower / inverse[:, None, :2]) @ np.swapaxes(lower, 1, 2), np.moveaxis(matrix, -1, 0), atol=1e-12
    )


def test_sparse_matrices_in_any_order_of_elimination() -> None:
    """An arrow, a ring and a chain, with the fill that a dense elimination in that order makes."""
    random = np.random.default_rng(4)
    size, count = 7, 5
    ring = {(i, (i + 1) % size) for i in range(size)} | {(0, i) for i in range(size)}
    matrix = np.zeros((size, size, count))
    for i, j in ring:
        matrix[i, j] = matrix[j, i] = random.standard_normal(count)
    matrix[range(size), range(size)] += 9.0
    for _ in range(4):
        left, coupled, pivots = list(range(size)), (matrix != 0.0).any(axis=-1), []
        for k in random.permutation(size).tolist():
            left.remove(k)
            below = [i for i in left if coupled[i, k]]
            coupled[np.ix_(below, below)] = True
            pivots.append((k, below))
        place = {(i, j): n for n, (i, j) in enumerate(zip(*np.nonzero(np.tril(matrix.any(axis=-1))), strict=True))}
        steps = sparse_steps(pivots, place)
        work = np.zeros((len(place), count), dtype=np.longdouble)
        for (i, j), n in place.items():
            work[n] = matrix[i, j]
        load = random.standard_normal((size, 2, count))
        found = load.astype(np.longdouble)
        substitute(steps, eliminated(work, steps), found)
        expected = np.linalg.solve(np.moveaxis(matrix, -1, 0), np.moveaxis(load, -1, 0))
        np.testing.assert_allclose(np.moveaxis(found, -1, 0).astype(float), expected, rtol=1e-12)
