"""Coefficients of sparse linear equations at many poses, their uncoupled blocks, and what is solved after what."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.cache import PATTERNS

Bools = NDArray[np.bool_]
Places = NDArray[np.int64]

# Least number of equations that are solved part by part; fewer are quicker as a whole.
MANY = 30


@dataclass(frozen=True, eq=False)
class Coefficients:
    """Those coefficients of n systems of equations that can differ from zero.

    Attributes
    ----------
    rows, columns
        Where they are, (e,).
    values
        Their values, (n, e).
    shape
        Numbers of equations and of unknowns.
    """

    rows: Places
    columns: Places
    values: Array
    shape: tuple[int, int]

    def at(self, poses: Bools | slice) -> Coefficients:
        """Those of some of the poses."""
        return Coefficients(self.rows, self.columns, self.values[poses], self.shape)

    def of(self, block: EquationBlock, poses: Bools) -> Coefficients:
        """Those of a block of the equations at some of the poses."""
        values = self.values[np.ix_(poses, block.entries)]
        return Coefficients(block.places[0], block.places[1], values, (len(block.rows), len(block.columns)))

    def matrix(self, columns: Bools | None = None) -> Array:
        """Matrices (n, m, k), of all columns or some."""
        out = np.zeros((len(self.values), *self.shape))
        out[:, self.rows, self.columns] = self.values
        return out if columns is None else out[:, :, columns]

    def times(self, unknowns: Array) -> Array:
        """Left-hand sides (n, m) of unknowns (n, k)."""
        order = np.argsort(self.rows, kind="stable")
        there, starts = np.unique(self.rows[order], return_index=True)
        out = np.zeros((len(unknowns), self.shape[0]))
        if len(there):
            products = self.values[:, order] * unknowns[:, self.columns[order]]
            out[:, there] = np.add.reduceat(products, starts, axis=-1)
        return out


class SubstitutionStage(NamedTuple):
    """Equations of a block that are solved together, after those from which they take unknowns.

    Attributes
    ----------
    rows, columns
        Its equations and unknowns in the block.
    known
        Unknowns of earlier stages that are in its equations.
    own, before
        Row, column and number of the coefficients of its unknowns, and of the known ones.
    """

    rows: Places
    columns: Places
    known: Places
    own: tuple[Places, Places, Places]
    before: tuple[Places, Places, Places]


@dataclass(eq=False)
class EquationBlock:
    """Equations that share unknowns with no others.

    Attributes
    ----------
    rows, columns
        Its equations and unknowns.
    entries
        Which of the coefficients are its own, (e,).
    places
        Rows and columns of these in the block, (e,) each.
    """

    rows: Places
    columns: Places
    entries: Places
    places: tuple[Places, Places]

    @cached_property
    def stages(self) -> list[SubstitutionStage]:
        """What is solved after what (Dulmage and Mendelsohn 1958), in an open chain from the tip to the ground.

        None if the block is small, not square, or does not come apart. They follow from where coefficients can be, not
        from their values.
        """
        if len(self.rows) < MANY or len(self.rows) != len(self.columns):
            return []
        labels = _labels(*self.places, len(self.rows))
        return [] if labels is None else _stages(self, *labels)


def blocks(rows: Places, columns: Places, shape: tuple[int, int], used: Bools) -> list[EquationBlock]:
    """Uncoupled blocks of equations, of which the coefficients `used` (e,) at `rows` and `columns` are not zero."""
    key = "blocks", shape, rows.tobytes(), columns.tobytes(), used.tobytes()
    found: list[EquationBlock] = PATTERNS.found(key, lambda: _blocks(rows, columns, shape, used), 4 * used.size)
    return found


def _blocks(rows: Places, columns: Places, shape: tuple[int, int], used: Bools) -> list[EquationBlock]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(used.sum()), (rows[used], shape[0] + columns[used])), shape=(sum(shape),) * 2)
    count, label = connected_components(graph, directed=False)
    of_rows, of_columns = np.split(label.astype(np.int64), [shape[0]])
    # small entries that do not count for the pattern belong to a block all the same, if it has their row and column
    inside = of_rows[rows] == of_columns[columns]
    here = np.empty(sum(shape), dtype=np.int64)
    out = []
    for own_rows, own_columns, entries in zip(
        _members(of_rows, count),
        _members(of_columns, count),
        _members(np.where(inside, of_rows[rows], -1), count),
        strict=True,
    ):
        if len(own_rows):
            here[own_rows], here[shape[0] + own_columns] = np.arange(len(own_rows)), np.arange(len(own_columns))
            places = here[rows[entries]], here[shape[0] + columns[entries]]
            out.append(EquationBlock(own_rows, own_columns, entries, places))
    return out


def _members(labels: Places, count: int) -> list[Places]:
    """Places of each label from 0 to `count`, in order; those of negative labels are left out."""
    order = np.argsort(labels, kind="stable")
    ends = np.searchsorted(labels[order], np.arange(count + 1))
    return [order[first:last] for first, last in pairwise(ends.tolist())]


def _labels(rows: Places, columns: Places, size: int) -> tuple[Places, Places, list[int]] | None:
    """Part of each row, that of each column, and the order of solution; None if there are not several parts."""
    from scipy.sparse import csr_array
    from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

    pattern = csr_array((np.ones(len(rows), dtype=np.int8), (rows, columns)), shape=(size, size))
    match = maximum_bipartite_matching(pattern, perm_type="row")
    if np.any(match < 0):
        return None
    column_of = np.empty(size, dtype=np.int64)
    column_of[match] = np.arange(size)
    # the column that a row is solved for depends on all columns of that row
    waits = csr_array((np.ones(len(rows), dtype=np.int8), (column_of[rows], columns)), shape=(size, size))
    count, found = connected_components(waits, directed=True, connection="strong")
    if count < 2:
        return None
    label = found.astype(np.int64)
    later, sooner = label[column_of[rows]], label[columns]
    return label[column_of], label, _order(later, sooner, count)


def _order(later: Places, sooner: Places, count: int) -> list[int]:
    """Parts in an order in which each follows those for which it waits."""
    from graphlib import TopologicalSorter

    waits: dict[int, set[int]] = {k: set() for k in range(count)}
    for a, b in np.unique(np.stack([later, sooner])[:, later != sooner], axis=1).T.tolist():
        waits[a].add(b)
    return list(TopologicalSorter(waits).static_order())


def _stages(block: EquationBlock, of_rows: Places, of_columns: Places, order: list[int]) -> list[SubstitutionStage]:
    rows, columns = block.places
    count, out = len(order), []
    rows_of, columns_of = _members(of_rows, count), _members(of_columns, count)
    entries_of = _members(of_rows[rows], count)
    here = np.empty((2, len(block.rows)), dtype=np.int64)
    for part in order:
        own_rows, own_columns, entries = rows_of[part], columns_of[part], entries_of[part]
        here[0, own_rows], here[1, own_columns] = np.arange(len(own_rows)), np.arange(len(own_columns))
        inside = of_columns[columns[entries]] == part
        own, before = entries[inside], entries[~inside]
        known, place = np.unique(columns[before], return_inverse=True)
        coefficients = here[0, rows[own]], here[1, columns[own]], own
        out.append(
            SubstitutionStage(own_rows, own_columns, known, coefficients, (here[0, rows[before]], place, before))
        )
    return out


def substituted(given: Coefficients, stages: list[SubstitutionStage], sides: Array) -> tuple[Array, Bools]:
    """Unknowns (n, k, s) of equations with right-hand sides (n, m, s), stage by stage, and where all have one, (n,)."""
    out, regular = np.zeros_like(sides), np.ones(len(sides), dtype=bool)
    for stage in stages:
        own, rest = _small(given, stage.own, len(stage.columns), len(stage.rows)), sides[:, stage.rows]
        if len(stage.known):
            rest = rest - _small(given, stage.before, len(stage.known), len(stage.rows)) @ out[:, stage.known]
        try:
            out[:, stage.columns] = np.linalg.solve(own, rest)
        except np.linalg.LinAlgError:
            singular = np.linalg.slogdet(own)[0] == 0.0
            regular &= ~singular
            out[:, stage.columns] = np.linalg.solve(
                np.where(singular[:, None, None], np.eye(len(stage.rows)), own), rest
            )
    return out, regular


def _small(given: Coefficients, where: tuple[Places, Places, Places], columns: int, rows: int) -> Array:
    """Matrices (n, rows, columns) of some of the coefficients."""
    i, j, entries = where
    out = np.zeros((len(given.values), rows, columns))
    out[:, i, j] = given.values[:, entries]
    return out
