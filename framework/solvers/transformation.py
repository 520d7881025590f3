"""What the displacements of nodes and springs are made of, as arrays: ``u = T q + G s`` row by row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..structure.parts import Row, Value, is_zero
from ..structure.topology import Index


class Transformation:
    """Rows of T and G side by side; springs follow the displacements, and the right-hand-side parameters these, as rows
    of their own.

    Parameters
    ----------
    dofs
        Number of displacements.
    nodes
        Of nodes on edges, what their displacements are made of, six rows each.
    springs
        What the displacements of the springs are made of.
    unknown
        Numbers of the unknowns.
    parameters
        Number of right-hand-side parameters.

    Attributes
    ----------
    start
        Where each row starts, and at last where they end, (rows + 1,).
    column
        Places of the unknowns; of a right-hand-side parameter the number of unknowns plus its own.
    share
        Factors, 1 where they vary over the batch.
    varying
        Numbers of `factors` by which a share is multiplied as well; -1 for none.
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
        """Row, column, factor and number of the varying factor of all that combinations are made of."""
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
    """All that some rows are made of: which of `rows` it belongs to, and its place in `column` and `share`.

    `start` is that of `Transformation`.
    """
    times = start[rows + 1] - start[rows]
    item = np.repeat(np.arange(len(rows)), times)
    place = start[rows][item] + np.arange(len(item)) - np.repeat(np.cumsum(times) - times, times)
    return item, place
