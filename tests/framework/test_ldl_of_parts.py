"""LDLᵀ of arrays and of sums of parts over several axes of a batch: both in 50 digits against a factorisation in
fractions, and with each other to the last bit."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import mpmath
import numpy as np
import pytest
from linkframe.framework.batched.order import Order, Pattern, in_turn, link, order, pattern_of
from linkframe.framework.batched.stage import Stage, carried
from linkframe.framework.ldl import PivotStep, backward_parts, eliminated, full_steps, sparse_steps, substitute
from linkframe.framework.structure.parts import Grid, Value, add, mask_of
from mpmath import mpf
from numpy.typing import NDArray

Numbers = NDArray[np.object_]
SHAPE, SIZE, DIGITS = (3, 2), 8, mpf("1e-45")
GRID = Grid(SHAPE)
WANTED = [True] * len(GRID.sizes)
# Shapes of parts: constant, over one axis, over the other, over both.
SHAPES = ((), (3, 1), (1, 2), (3, 2))


@pytest.fixture(autouse=True)
def _fifty_digits() -> Iterator[None]:
    with mpmath.workdps(50):
        yield


class Equations(NamedTuple):
    """Symmetric equations as sums of parts, whose numbers are eighths, and as whole arrays in fractions."""

    terms: list[tuple[int, int, Numbers]]
    pushes: list[tuple[int, Numbers]]
    matrix: Numbers
    load: Numbers


def eighths(random: np.random.Generator, shape: tuple[int, ...]) -> Numbers:
    return np.array(random.integers(1, 40, shape) * random.choice([-1, 1], shape), dtype=object) * Fraction(1, 8)


def equations(seed: int, shapes: tuple[tuple[int, ...], ...] = SHAPES, share: float = 0.25) -> Equations:
    """Equations with this share of couplings, of which every entry is a sum of parts over axes chosen at random."""
    random = np.random.default_rng(seed)
    terms, pushes = [], []
    matrix = np.full((SIZE, SIZE, *SHAPE), Fraction(0))
    load = np.full((SIZE, *SHAPE), Fraction(0))
    pairs = [(i, j) for i in range(SIZE) for j in range(i, SIZE) if i == j or random.random() < share]
    for i, j in pairs:
        for k in [0] if random.random() < 0.6 else random.permutation(len(shapes))[:1].tolist():
            value = eighths(random, shapes[k]) + (Fraction(60) if i == j else Fraction(0))
            terms.append((i, j, value))
            matrix[i, j] = matrix[i, j] + value
        matrix[j, i] = matrix[i, j]
    for i in random.permutation(SIZE)[:5].tolist():
        pushes.append((i, eighths(random, shapes[random.integers(len(shapes))])))
        load[i] = load[i] + pushes[-1][1]
    return Equations(terms, pushes, matrix, load)


def in_digits(value: Numbers) -> Numbers:
    """Fractions in 50 digits."""
    return np.vectorize(lambda x: mpf(x.numerator) / x.denominator, otypes=[object])(value)


def staged(given: Equations, kind: type) -> Stage:
    """The equations as a stage with numbers of 50 digits (`object`) or doubles."""
    stage = Stage()

    def part(value: Numbers) -> tuple[int, Numbers]:
        number = in_digits(value) if kind is object else value.astype(kind)
        return mask_of(value), number if number.ndim else number[()]

    for i, j, value in given.terms:
        stage.put(i, j, *part(value))
    for i, value in given.pushes:
        add(stage.force(i, 0), *part(value))
    return stage


def in_fractions(matrix: Numbers, pivots: list[int]) -> tuple[Numbers, Numbers]:
    """L and D column by column, ``d_j = a_jj - sum l_jk^2 d_k`` and ``l_ij = (a_ij - sum l_ik d_k l_jk) / d_j``
    (Golub & Van Loan, Matrix Computations, 4th ed., 2013, sec. 4.1.2), unknowns in order of elimination.
    """
    a = matrix[pivots][:, pivots]
    lower, diagonal = np.full(a.shape, Fraction(0)), np.full(a.shape[1:], Fraction(0))
    for j in range(len(pivots)):
        diagonal[j] = a[j, j] - sum(lower[j, k] * lower[j, k] * diagonal[k] for k in range(j))
        for i in range(j + 1, len(pivots)):
            lower[i, j] = (a[i, j] - sum(lower[i, k] * diagonal[k] * lower[j, k] for k in range(j))) / diagonal[j]
    return lower, diagonal


def solution(lower: Numbers, diagonal: Numbers, load: Numbers) -> Numbers:
    """Solution by ``L y = f``, ``L^T x = y / d``."""
    y = load.copy()
    for i in range(len(y)):
        y[i] = y[i] - sum(lower[i, k] * y[k] for k in range(i))
    x = y / diagonal
    for i in reversed(range(len(x))):
        x[i] = x[i] - sum(lower[k, i] * x[k] for k in range(i + 1, len(x)))
    return x


def close(found: object, expected: Numbers) -> None:
    """Within 45 digits of fractions."""
    error = np.abs(np.broadcast_to(np.asarray(found, dtype=object), expected.shape) - in_digits(expected))
    assert (error <= DIGITS * (1 + np.abs(in_digits(expected)))).all()


def arrays(given: Equations, found: Order) -> tuple[tuple[PivotStep, ...], Numbers]:
    """Steps and entries (entries, ...) of the same equations for `ldl`."""
    place = {(i, j): n for n, (j, i) in enumerate(dict.fromkeys((i, j) for i, j, _ in given.terms))}
    steps = sparse_steps(((k, found.below[k]) for k in found.pivots), place)
    work = np.stack([given.matrix[i, j] for i, j in place])
    return steps, work


@pytest.mark.parametrize("seed", range(12))
def test_parts_over_several_axes_are_eliminated_as_their_sums(seed: int) -> None:
    given = equations(seed)
    stage = staged(given, object)
    found = order(pattern_of(stage.matrix, ()), range(SIZE), GRID)
    lower, diagonal = in_fractions(given.matrix, found.pivots)
    x = solution(lower, diagonal, given.load[found.pivots])

    for some in (found.pivots[: SIZE // 2], found.pivots[SIZE // 2 :]):
        stage.eliminate(replace(found, pivots=some), WANTED)
        stage.forward(replace(found, pivots=some), WANTED)
        # parts vary over so much and no more; those of a load at most over what the whole column varies over
        left = [*(parts for row in stage.matrix.values() for parts in row.values()), *stage.scale.values()]
        assert all(mask_of(value) == mask for parts in left for mask, value in parts.items())
        loads = [parts for by_source in stage.forces.values() for parts in by_source.values()]
        assert all(mask_of(value) & ~mask == 0 for parts in loads for mask, value in parts.items())
    at = {k: n for n, k in enumerate(found.pivots)}
    for k, step in stage.pivots.items():
        close(1 / np.asarray(step.inverse, dtype=object), diagonal[at[k]])
        for i in found.below[k]:
            close(step.lower[i], lower[at[i], at[k]])
        # so much does it vary, and no more
        assert mask_of(np.broadcast_arrays(*map(np.asarray, step.lower.values()), step.inverse)[0]) == found.masks[k]
    known: dict[int, Value] = {}
    backward_parts(found.pivots, stage.pivots, stage.forces, [mpf(1)], known)
    row = {k: mpf(n + 1) for n, k in enumerate(found.pivots[::2])}
    (by_rows,) = carried(found, row, stage).values()
    for k, value in known.items():
        close(value, x[at[k]])
    close(by_rows, sum((n + 1) * x[at[k]] for n, k in enumerate(row)))


@pytest.mark.parametrize("seed", range(12))
def test_arrays_are_eliminated_in_any_order(seed: int) -> None:
    given = equations(seed)
    pattern: Pattern = {}
    for i, j, _ in given.terms:
        link(pattern, i, j, 0)
    found = in_turn(pattern, np.random.default_rng(seed).permutation(SIZE).tolist())
    assert not any(pattern.values())
    lower, diagonal = in_fractions(given.matrix, found.pivots)
    steps, work = arrays(given, found)
    at = {k: n for n, k in enumerate(found.pivots)}
    columns = eliminated(in_digits(work).reshape(len(work), -1), steps)
    for step, (low, over) in zip(steps, columns, strict=True):
        n = at[step.unknown]
        close(1 / over.reshape(SHAPE), diagonal[n])
        close(low.reshape(-1, *SHAPE), lower[[at[i] for i in found.below[step.unknown]], n])
        # the fill is there, and nothing else
        assert {at[i] for i in found.below[step.unknown]} == set(np.flatnonzero((lower[:, n] != 0).any(axis=(1, 2))))
    load = in_digits(given.load).reshape(SIZE, -1)
    substitute(steps, columns, load)
    x = solution(lower, diagonal, given.load[found.pivots])
    close(load[found.pivots].reshape(x.shape), x)


@pytest.mark.parametrize("seed", range(12))
def test_both_storages_give_the_same_bits_for_full_matrices_of_one_shape(seed: int) -> None:
    given = equations(seed, SHAPES[-1:], share=1.0)
    stage = staged(given, float)
    stage.eliminate(in_turn(pattern_of(stage.matrix, ()), range(SIZE)), WANTED)
    steps, work = full_steps(SIZE), given.matrix.reshape(SIZE * SIZE, *SHAPE).astype(float)
    for step, (low, over) in zip(steps, eliminated(work, steps), strict=True):
        own = stage.pivots[step.unknown]
        np.testing.assert_array_equal(over, own.inverse)
        np.testing.assert_array_equal(low, np.array(list(own.lower.values())).reshape(low.shape))
