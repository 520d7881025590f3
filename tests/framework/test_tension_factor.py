"""Factors by tensions: within a band as in an order of their own, in whatever order the unknowns are given."""

from __future__ import annotations

import numpy as np
import pytest
import scipy
from linkframe.framework.solvers import tensions

SIZE, SOFT = 120, 1e-7


def deformations(*, held: bool) -> scipy.sparse.csr_matrix:
    """Differences of second order along a line, which is held at its start; in extended precision."""
    rows = [np.eye(SIZE)[0], np.eye(SIZE)[1]] if held else [np.eye(SIZE)[0]]
    rows += [np.eye(SIZE)[k] - 2.0 * np.eye(SIZE)[k + 1] + np.eye(SIZE)[k + 2] for k in range(SIZE - 2)]
    return scipy.sparse.csr_matrix(np.array(rows)).astype(np.longdouble)


def factor(order: np.ndarray, *, held: bool = True) -> tensions.TensionFactor:
    """Of a line whose unknowns are mixed up, and are told in the order along it."""
    mixed = deformations(held=held)[:, np.argsort(order)]
    springs = np.where(np.arange(mixed.shape[0]) % 7, 1.0, SOFT)
    plain = scipy.sparse.csr_matrix(mixed.astype(np.float64))
    matrix = scipy.sparse.csr_matrix(plain.T @ scipy.sparse.diags(springs) @ plain)
    return tensions.TensionFactor(matrix, mixed, springs, order)


@pytest.mark.parametrize("narrow", [100, -1])
def test_solution_where_the_stiffness_is_singular_to_double_precision(
    narrow: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Springs in equilibrium with a load, one after the other, give the displacements without any matrix."""
    monkeypatch.setattr(tensions, "_NARROW", narrow)
    order = np.random.default_rng(0).permutation(SIZE)
    found = factor(order)
    assert not found.singular
    load = np.zeros((SIZE, 1))
    load[order[-1], 0] = 1.0
    table = deformations(held=True).toarray().astype(np.float64)
    # a triangle: whole numbers without rounding
    tension = np.linalg.solve(table.T, np.eye(SIZE)[-1]).round()
    exact = np.linalg.solve(table, tension / np.where(np.arange(SIZE) % 7, 1.0, SOFT))
    assert np.abs(found.solve(load)[order, 0] / exact - 1.0)[2:].max() < 1e-13


def test_the_band_is_narrow_whatever_the_order() -> None:
    for seed in range(3):
        found = factor(np.random.default_rng(seed).permutation(SIZE))
        assert isinstance(found._factor, tensions._InBand)
        assert found._factor._width <= 6


def test_a_mechanism_is_told() -> None:
    assert factor(np.random.default_rng(0).permutation(SIZE), held=False).singular
