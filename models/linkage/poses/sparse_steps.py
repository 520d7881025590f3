"""Steps along a curve on which one motion alone is possible, at a cost that grows with the linkage and no faster.

Each loop's equations have the coordinates of few joints in them. Where they are independent and leave one motion,
Newton's method and the tangent take the factors of one sparse matrix, the Jacobian bordered by the last tangent (H. B.
Keller, Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.linear import Linear
from .configuration import Configurations

# So nearly a place is closed, without unit; how many steps that may take, and the longest of them.
CLOSED, ITERATIONS, LONGEST = 1e-13, 8, 0.5
# How little the tangent may turn from one place to the next, by its cosine; what turns more is looked at as a whole.
TURN = 0.9
# A least singular value that lies so many times its change to the next places from zero does not vanish between them.
FAR = 10.0
# Numbers of a set of equations that are looked at together, over places.
TOGETHER = 2**20


@dataclass(frozen=True, eq=False)
class Step:
    """A place that was reached: state, tangent, and the entries of the Jacobian there."""

    state: Array
    tangent: Array
    entries: Array


class SparseSteps:
    """Steps from place to place with some columns standing still.

    Parameters
    ----------
    space
        All assembled positions.
    drive
        The column that drives.
    locked
        Columns that stand still.
    """

    def __init__(self, space: Configurations, drive: int, locked: Sequence[int]) -> None:
        self.space, self.locked = space, tuple(locked)
        self.rows, self.columns = space.mechanism.acting_places
        self.count = len(space.mechanism.columns)
        equations = len(space.mechanism.acting)
        acting = np.array(space.mechanism.acting, dtype=np.intp)
        self._scales = space.row_units[acting[self.rows]] / space.units[self.columns]
        below = equations + len(self.locked)
        rows = np.concatenate([self.rows, np.arange(equations, below), np.full(self.count, below)])
        columns = np.concatenate([self.columns, np.array(self.locked, dtype=np.intp), np.arange(self.count)])
        self.regular = below + 1 == self.count and equations > 0
        if not self.regular:
            return
        # Its pattern is examined once; its numbers are put in place by place.
        self._matrix = scipy.sparse.coo_matrix(
            (np.arange(1.0, len(rows) + 1.0), (rows, columns)), (self.count, self.count)
        ).tocsc()
        self._take = self._matrix.data.astype(np.intp) - 1
        pattern = np.zeros((self.count, self.count), dtype=bool)
        pattern[self.rows, self.columns] = True
        pattern[range(equations, self.count), [*self.locked, drive]] = True
        self._locked = Linear(pattern)
        self.regular = self._locked.square

    def onwards(self, state: Array, tangent: Array, step: float) -> Step | None:
        """The place a step further along the tangent; None where it is not sure to be found so."""
        space, still = self.space, np.zeros(len(self.locked) + 1)
        state = space.advanced(state, step * tangent)
        for _ in range(ITERATIONS):
            gap, entries = self.at(state)
            factors = self._factors(entries, tangent)
            if factors is None:
                return None
            if np.abs(gap).max() < CLOSED:
                along = factors.solve(np.append(np.zeros(self.count - 1), 1.0))
                size = float(np.linalg.norm(along))
                return Step(state, along / size, entries) if TURN * size <= 1.0 else None
            change = factors.solve(np.append(-gap, still))
            if not np.abs(change).max() < LONGEST:
                return None
            state = space.advanced(state, change)
        return None

    def at(self, state: Array) -> tuple[Array, Array]:
        """By how much the acting equations are off, and the entries of their Jacobian, without unit."""
        mechanism = self.space.mechanism
        numbers = np.array(mechanism.acting_closure[0](state.tolist(), self.space.parameters))
        return numbers[: len(mechanism.acting)] * self._gap_units, numbers[len(mechanism.acting) :] * self._scales

    @cached_property
    def _gap_units(self) -> Array:
        return self.space.row_units[self.space.mechanism.acting]

    def _factors(self, entries: Array, tangent: Array) -> Any:
        from scipy.sparse.linalg import splu

        self._matrix.data = np.concatenate([entries, np.ones(len(self.locked)), tangent])[self._take]
        try:
            return splu(self._matrix)
        except RuntimeError:
            return None

    def near_zero(self, entries: Array) -> NDArray[np.intp]:
        """Places (places, entries) beside which something may move with the drive held.

        Sets of equations that are solved one after the other are singular one by one: of each, the least singular value
        comes down to zero there.
        """
        chosen = np.zeros(len(entries), dtype=bool)
        for rows, columns in self._locked.blocks:
            if rows[0] >= len(self.space.mechanism.acting):
                continue
            least = self._least(entries, rows, columns)
            framed = np.concatenate([[np.inf], least, [np.inf]])
            change = np.maximum(framed[:-2], framed[2:]) - least
            lowest = (least <= framed[:-2]) & (least <= framed[2:]) & (least < 0.5)
            chosen |= lowest & (least <= FAR * change)
        return np.flatnonzero(chosen)

    def _least(self, entries: Array, rows: list[int], columns: list[int]) -> Array:
        """Least over greatest singular value of a set of equations at all places; of one alone, its size."""
        inside = np.flatnonzero(np.isin(self.rows, rows) & np.isin(self.columns, columns))
        at_row, at_column = (
            np.searchsorted(np.sort(those), own[inside]) for those, own in ((rows, self.rows), (columns, self.columns))
        )
        out = np.empty(len(entries))
        step = max(1, TOGETHER // len(rows) ** 2)
        for first in range(0, len(entries), step):
            part = entries[first : first + step]
            block = np.zeros((len(part), len(rows), len(rows)))
            block[:, at_row, at_column] = part[:, inside]
            values = np.linalg.svd(block, compute_uv=False)
            out[first : first + step] = values[:, -1] / (np.maximum(values[:, 0], 1e-300) if len(rows) > 1 else 1.0)
        return out
