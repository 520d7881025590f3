"""Steps along a path of one degree of freedom by sparse matrices, at a cost proportional to the number of links.

The equations of a loop contain the coordinates of few joints. If they are independent and leave one motion, Newton's
method and the tangent need one sparse factorisation, that of the Jacobian bordered by the last tangent (H. B. Keller,
Numerical solution of bifurcation and nonlinear eigenvalue problems, 1977).
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

# Largest residual of a closed point, dimensionless; largest number of Newton steps, and the longest step.
CLOSED, ITERATIONS, LONGEST = 1e-13, 8, 0.5
# Least cosine of the angle between successive tangents; where they turn more, dense matrices are used.
TURN = 0.9
# A least singular value that is larger than this multiple of its change between points does not vanish near them.
FAR = 10.0
# Largest number of matrix entries whose singular values are computed together.
TOGETHER = 2**20


@dataclass(frozen=True, eq=False)
class Step:
    """A point that was reached: state, tangent, and the entries of the Jacobian there."""

    state: Array
    tangent: Array
    entries: Array


class SparseSteps:
    """Steps from point to point of a path, with some columns at rest.

    Parameters
    ----------
    space
        The assembled positions.
    drive
        The driving column.
    locked
        Columns that do not move.
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
        # the pattern is set up once; each point only fills in numbers
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
        """The point one step ahead along the tangent; None if sparse steps cannot be relied on."""
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
        """Residuals of the acting equations and the entries of their Jacobian, dimensionless."""
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
        """Indices of points near which something may move with the drive locked, from their `entries` (points,
        entries).

        Sets of equations that are solved one after the other become singular one by one: near such a point the least
        singular value of one set has a minimum near zero.
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
        """Least over largest singular value of a set of equations at all points; for one equation, its size."""
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
