"""Pivots in units of the stiffness whose rounding they carry, against NumPy's factors of each matrix by itself."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from linkframe.framework.batched.order import order, pattern_of
from linkframe.framework.batched.stage import Stage
from linkframe.framework.structure.parts import Grid, add, mask_of

SHAPE, SIZE = (3, 2), 7
# Of each term of the stiffness the axes over which it varies, its shape, and the unknowns that it is about.
TERMS = ((0, (), range(SIZE)), (1, (3, 1), range(4)), (2, (1, 2), range(2, SIZE)), (1, (3, 1), (6,)))


def test_an_eliminated_unknown_leaves_its_rounding_in_those_that_are_left() -> None:
    """Of ``A = L D L^T`` the diagonal i carries ``w_i = a_ii + sum_k l_ik^2 w_k``; over how much varies what it has."""
    rng, stage, whole = np.random.default_rng(0), Stage(), np.zeros((*SHAPE, SIZE, SIZE))
    for mask, shape, unknowns in TERMS:
        half = rng.standard_normal((*shape, len(unknowns), 9)) * 10.0 ** rng.uniform(-2.0, 2.0, (len(unknowns), 1))
        term = half @ np.swapaxes(half, -1, -2)
        for (a, i), (b, j) in product(enumerate(unknowns), repeat=2):
            whole[..., i, j] += term[..., a, b]
            if j >= i:
                stage.put(i, j, mask, term[..., a, b])
    grid = Grid(SHAPE)
    found = order(pattern_of(stage.matrix, ()), range(SIZE), grid)
    first = found.pivots[0]
    assert found.masks[first] == 2
    # rounding of its own, over another axis than its stiffness
    more = 10.0 * whole[0, 0, first, first] * np.array([[1.0], [2.0], [3.0]])
    add(stage.scale[first], 1, more)
    stage.eliminate(found, [True] * len(grid.sizes))

    square = np.linalg.cholesky(whole[..., found.pivots, :][..., found.pivots])
    pivots = np.diagonal(square, axis1=-2, axis2=-1) ** 2
    lower = square / np.sqrt(pivots)[..., None, :]
    carried = np.diagonal(whole, axis1=-2, axis2=-1)[..., found.pivots].copy()
    carried[..., 0] += more
    weight = np.zeros_like(carried)
    for i in range(SIZE):
        weight[..., i] = carried[..., i] + (lower[..., i, :i] ** 2 * weight[..., :i]).sum(axis=-1)
    assert all(mask_of(value) == mask for mask, value in stage.pivot_ratio.items() if mask)
    least = np.min(np.broadcast_arrays(np.full(SHAPE, np.inf), *stage.pivot_ratio.values()), axis=0)
    np.testing.assert_allclose(least, (pivots / weight).min(axis=-1), rtol=1e-9)


@pytest.mark.parametrize(("shape", "sizes"), [((), (1,)), ((5,), (1, 5)), ((3, 4), (1, 3, 4, 12))])
def test_entries_over_each_choice_of_axes(shape: tuple[int, ...], sizes: tuple[int, ...]) -> None:
    assert Grid(shape).sizes == sizes
