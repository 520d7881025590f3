"""LDLᵀ of small matrices against NumPy's solver and against what the factors of a semidefinite matrix must make."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.ldl import factorised, substituted


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
    factor = np.moveaxis(factorised(matrix.copy(), 1e-9, raised=False), -1, 0)
    inverse = np.diagonal(factor, axis1=1, axis2=2)
    np.testing.assert_array_equal(inverse > 0.0, np.tile(np.arange(5) < 2, (7, 1)))
    lower = np.tril(factor, -1)[:, :, :2] + np.eye(5, 2)
    np.testing.assert_allclose(
        (lower / inverse[:, None, :2]) @ np.swapaxes(lower, 1, 2), np.moveaxis(matrix, -1, 0), atol=1e-12
    )
