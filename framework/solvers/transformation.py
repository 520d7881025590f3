"""The displacements of nodes and springs over the unknowns, ``u = T q + G s``, as arrays of sparse rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..structure.parts import Row, Value, is_zero
from ..structure.topology import Index


class Transformation:
    """Rows of T and G side by side: those of the displacements, then of the springs, then of the parameters themselves.

    Parameters
    ----------
    dofs
        Number of displacements of nodes.
    nodes
        By number of a node on edges, the six rows of its displacements.
    springs
        Rows of the displacements of the joint springs.
    unknown
        Numbers of the unknowns.
    parameters
        Number of right-hand-side parameters.

    Attributes
    ----------
    start
        Index at which each row starts, and at last where they end, (rows + 1,).
    column
        Place of the unknown of each entry; for right-hand-side parameter s the number of unknowns plus s.
    share
        Constant factor of each entry, 1 where the factor varies over the batch.
    varying
        Index in `factors` of the varying factor of each entry; -1 for none.
    factors
        Factors that vary over the batch.
    size, known
        Number of unknowns, and of right-hand-side parameters.
    imposed
        Whether displacements of nodes or springs depend on right-hand-side parameters.
    """

    def __init__(
        self, dofs: int, nodes: Mapping[int, Sequence[Row]], springs: Sequence[Row], unknown: Index, parameters: int
    ) -> None:
        self.size, self.known = len(unknown), parameters
        self.factors: list[Value] = []
        free = np.ones(dofs, dtype=bool)
        free.reshape(-1, 6)[list(nodes)] = False
        own, given, first = np.flatnonzero(free), np.arange(parameters), dofs + len(springs)
        rows: list[tuple[int, Row]] = [(6 * n + k, row) for n, six in nodes.items() for k, row in enumerate(six)]
        rows += [(dofs + s, row) for s, row in enumerate(springs)]
        at, columns, shares, numbers = self._combined(rows, unknown)
        self.imposed = bool((columns >= self.size).any())
        where = np.concatenate([own, at, first + given])
        order = np.argsort(where, kind="stable")
        self.start: Index = np.searchsorted(where[order], np.arange(first + parameters + 1))
        self.column: Index = np.concatenate([np.searchsorted(unknown, own), columns, self.size + given])[order]
        self.share: NDArray[np.float64] = np.concatenate([np.ones(len(own)), shares, np.ones(parameters)])[order]
        self.varying: Index = np.concatenate([np.full(len(own), -1), numbers, np.full(parameters, -1)])[order]

    def _combined(self, rows: list[tuple[int, Row]], unknown: Index) -> tuple[Index, Index, NDArray[np.float64], Index]:
        """Row, column, constant factor and index of the varying factor of all entries of some rows."""
        at, columns, shares, numbers = [], [], [], []
        for row, combination in rows:
            for key, value in combination.items():
                if is_zero(value):
                    continue
                fixed = not isinstance(value, np.ndarray)
                at.append(row)
                columns.append(key)
                shares.append(float(value) if fixed else 1.0)
                numbers.append(-1 if fixed else len(self.factors))
                if not fixed:
                    self.factors.append(value)
        keys = np.array(columns, dtype=np.int64)
        places = np.where(keys < 0, self.size - 1 - keys, np.searchsorted(unknown, keys))
        return np.array(at, dtype=np.int64), places, np.array(shares), np.array(numbers, dtype=np.int64)


def expanded(start: Index, rows: Index) -> tuple[Index, Index]:
    """The entries of some rows: for each the index of its row in `rows`, and its index in `column` and `share`.

    `start` is that of `Transformation`.
    """
    times = start[rows + 1] - start[rows]
    item = np.repeat(np.arange(len(rows)), times)
    place = start[rows][item] + np.arange(len(item)) - np.repeat(np.cumsum(times) - times, times)
    return item, place
