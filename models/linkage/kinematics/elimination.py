"""Recorded Gaussian elimination: equations of any size solved entry by entry, in an order chosen beforehand.

The order of pivots is chosen from the equations of one pose: of the pivots that are not small there, those that cause
least fill (H. M. Markowitz, The elimination form of the inverse, Management Science 3 (1957) 255). At another pose a
pivot may be small. The program returns all pivots, so that such equations can be solved with pivoting instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.program.recording import Term
from .linear import Linear
from .terms import Scalar

# Least ratio of a pivot to the largest entry of its row and column in the pose from which the order is chosen.
SHARE = 0.2
# Largest number of multiplications of a recorded elimination.
MOST = 1500

Pivots = list[tuple[int, int]]
Matrix = list[list[Scalar]]


@dataclass(frozen=True, eq=False)
class PivotOrder:
    """Order of elimination: for each block its pivots as (row, column), and their sizes in its pose."""

    pivots: list[Pivots]
    sizes: list[list[float]]


def order_of(linear: Linear, jacobian: Array) -> PivotOrder | None:
    """The order of elimination for one matrix (m, n); None if the equations cannot be eliminated in a fixed order."""
    if linear.compact or not linear.square:
        return None
    found = [_pivots(jacobian[np.ix_(*block)], linear.pattern[np.ix_(*block)]) for block in linear.blocks]
    known = [each for each in found if each is not None]
    if len(known) < len(found) or sum(work for _, _, work in known) > MOST:
        return None
    return PivotOrder([pivots for pivots, _, _ in known], [sizes for _, sizes, _ in known])


def _pivots(matrix: Array, pattern: NDArray[np.bool_]) -> tuple[Pivots, list[float], int] | None:
    """Pivots, their sizes, and the number of multiplications; None if the matrix is singular."""
    a, there = matrix.copy(), pattern.copy()
    rows, columns = list(range(len(a))), list(range(len(a)))
    pivots, sizes, work = [], [], 0
    while rows:
        sub, fill = np.abs(a[np.ix_(rows, columns)]), there[np.ix_(rows, columns)]
        largest = np.maximum(sub.max(axis=0)[None, :], sub.max(axis=1)[:, None])
        fit = (sub >= SHARE * largest) & (sub > 0.0) & fill
        if not fit.any():
            return None
        cost = np.outer(fill.sum(axis=1) - 1, fill.sum(axis=0) - 1)
        # among equally sparse pivots the largest, so that the choice does not depend on rounding
        least = fit & (cost == cost[fit].min())
        i, j = np.unravel_index(int(np.argmax(np.where(least, np.round(sub, 6), -1.0))), sub.shape)
        row, column = rows.pop(int(i)), columns.pop(int(j))
        pivots.append((row, column))
        sizes.append(float(abs(a[row, column])))
        work += int(cost[i, j]) + int(fill[i].sum()) + int(fill[:, j].sum())
        below = [r for r in rows if there[r, column]]
        a[np.ix_(below, columns)] -= np.outer(a[below, column] / a[row, column], a[row, columns])
        there[np.ix_(below, columns)] |= there[row, columns]
    return pivots, sizes, work


class Eliminated:
    """Recorded solution of J x = r for several right sides.

    Parameters
    ----------
    linear
        The equations.
    order
        Their order of elimination.
    entries
        Entries of J, row by row.
    rights
        Right sides.

    Attributes
    ----------
    solutions
        x of each right side.
    determinants
        As those of `Linear.determinants`.
    pivots
        All pivots, block by block in the order of elimination.
    """

    def __init__(
        self, linear: Linear, order: PivotOrder, entries: Sequence[Scalar], rights: Sequence[Sequence[Scalar]]
    ) -> None:
        self.solutions: list[list[Scalar]] = [[0.0] * linear.columns for _ in rights]
        self.determinants: list[Scalar] = []
        self.pivots: list[Scalar] = []
        n = linear.columns
        whole = [list(entries[i * n : i * n + n]) for i in range(linear.rows)]
        for (rows, columns), pivots in zip(linear.blocks, order.pivots, strict=True):
            block = [[whole[i][j] for j in columns] for i in rows]
            known = [
                [_rest(right[i], whole[i], x) for i in rows] for right, x in zip(rights, self.solutions, strict=True)
            ]
            found = self._solved(block, known, pivots)
            for x, own in zip(self.solutions, found, strict=True):
                for j, value in zip(columns, own, strict=True):
                    x[j] = value

    def _solved(self, block: Matrix, known: list[list[Scalar]], pivots: Pivots) -> list[list[Scalar]]:
        a, kept = [list(row) for row in block], []
        rows, columns = [i for i, _ in pivots], [j for _, j in pivots]
        for place, (i, j) in enumerate(pivots):
            inverse = 1.0 / a[i][j]
            self.pivots.append(a[i][j])
            kept.append((i, j, inverse))
            for r in rows[place + 1 :]:
                if _nothing(a[r][j]):
                    continue
                factor = a[r][j] * inverse
                for k in columns[place + 1 :]:
                    if not _nothing(a[i][k]):
                        a[r][k] = a[r][k] - factor * a[i][k]
                for right in known:
                    right[r] = right[r] - factor * right[i]
        determinant: Scalar = _sign(pivots)
        for i, j, _ in kept:
            determinant = determinant * a[i][j]
        self.determinants.append(determinant)
        out = []
        for right in known:
            x: list[Scalar] = [0.0] * len(a)
            for place, (i, j, inverse) in reversed(list(enumerate(kept))):
                after = columns[place + 1 :]
                x[j] = (right[i] - _dot([a[i][k] for k in after], [x[k] for k in after])) * inverse
            out.append(x)
        return out


def _rest(right: Scalar, row: Sequence[Scalar], x: Sequence[Scalar]) -> Scalar:
    return right - _dot(row, x)


def _dot(one: Sequence[Scalar], other: Sequence[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for x, y in zip(one, other, strict=True):
        if not (_nothing(x) or _nothing(y)):
            total = total + x * y
    return total


def _nothing(x: Scalar) -> bool:
    return not isinstance(x, Term) and x == 0.0


def _sign(pivots: Pivots) -> float:
    """Sign of the permutation that moves the pivots to the diagonal."""
    k = len(pivots)
    order = np.zeros((k, k))
    for place, (i, _) in enumerate(pivots):
        order[place, i] = 1.0
    columns = np.zeros((k, k))
    for place, (_, j) in enumerate(pivots):
        columns[j, place] = 1.0
    return float(round(np.linalg.det(order) * np.linalg.det(columns)))
