"""Linear equations of a Newton step, solved block by block: small blocks by Cramer's rule, others by LAPACK."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Any

import numpy as np
import scipy

from ....framework.batch import Array
from ....framework.cache import ORDERS
from .terms import Value

Blocks = list[tuple[list[int], list[int]]]
Pattern = np.ndarray[tuple[int, int], np.dtype[np.bool_]]


class Linear:
    """Solver of J x = r for entries that are floats or arrays.

    Square equations are brought to block triangular form (Dulmage and Mendelsohn 1958). Blocks of one and two are
    solved by Cramer's rule, whose rounding Newton's method corrects. Other equations are solved as a whole by least
    squares, with the step of least norm.

    Parameters
    ----------
    pattern
        Which entries of J can differ from zero, (rows, columns).
    rank
        Rank of J.

    Attributes
    ----------
    projection
        For more equations than unknowns, combinations of them (n, m) with a determinant; its sign tells branches apart.
    order
        Order in which the equations can be eliminated without pivoting; None if there is none, or before `start` has
        found it from one of their matrices.
    """

    def __init__(self, pattern: Pattern, rank: int | None = None) -> None:
        self.pattern = pattern
        self.rows, self.columns = self.pattern.shape
        self.rank = min(self.rows, self.columns) if rank is None else rank
        self.projection: Array | None = None
        self.order: Any = None

    @cached_property
    def compact(self) -> bool:
        """Whether the equations are solved by Cramer's rule alone, which can be recorded."""
        return self.square and max((len(rows) for rows, _ in self.blocks), default=0) <= 2

    @cached_property
    def square(self) -> bool:
        """Whether there are as many independent equations as unknowns, with a complete matching."""
        return self.rows == self.columns == self.rank and sum(len(rows) for rows, _ in self.blocks) == self.rows

    @cached_property
    def blocks(self) -> Blocks:
        """Rows and columns of each block in the order of solution; none if rows and columns cannot be matched."""
        key = "blocks of equations", self.pattern.shape, self.pattern.tobytes()
        blocks: Blocks = ORDERS.found(key, self._blocks, self.pattern.size)
        return blocks

    def _blocks(self) -> Blocks:
        if self.rows != self.columns or self.rows == 0:
            return []
        match = scipy.sparse.csgraph.maximum_bipartite_matching(scipy.sparse.csr_matrix(self.pattern), perm_type="row")
        if np.any(match < 0):
            return []
        # row match[j] is solved for column j; an entry (match[j], k) makes column j depend on column k
        waits = self.pattern[match]
        _, label = scipy.sparse.csgraph.connected_components(
            scipy.sparse.csr_matrix(waits.astype(np.int8)), directed=True, connection="strong"
        )
        members = [np.flatnonzero(label == name) for name in range(label.max() + 1)]
        done: set[int] = set()
        blocks: Blocks = []
        while len(blocks) < len(members):
            for those in members:
                mine = set(those.tolist())
                if not mine & done and set(np.flatnonzero(waits[those].any(axis=0)).tolist()) <= mine | done:
                    blocks.append(([int(match[j]) for j in those], those.tolist()))
                    done |= mine
        return blocks

    def reached(self, sides: Pattern) -> Pattern:
        """Which entries of x, (columns, k), can differ from zero where those of r do that are in `sides`, (rows, k)."""
        out = np.ones((self.columns, sides.shape[1]), dtype=bool)
        if not self.square:
            return out
        for rows, columns in self.blocks:
            before = [k for i in rows for k in self._solved_before[i]]
            out[columns] = sides[rows].any(axis=0) | out[before].any(axis=0)
        return out

    @property
    def signs(self) -> int:
        """Number of determinants."""
        return len(self.blocks) if self.square else int(self.projection is not None)

    def determinants(self, entries: Sequence[Any]) -> list[Any]:
        """Determinant of each block; for more equations than unknowns, that of their `projection`."""
        n = self.columns
        if self.projection is not None:
            a = matrices([list(entries[i * n : i * n + n]) for i in range(self.rows)])
            return [np.linalg.det(self.projection @ a)]
        if not self.square:
            return []
        return [self._determinant([[entries[i * n + j] for j in cs] for i in rs]) for rs, cs in self.blocks]

    @staticmethod
    def _determinant(block: list[list[Any]]) -> Any:
        if len(block) == 1:
            return block[0][0]
        if len(block) == 2:
            return block[0][0] * block[1][1] - block[0][1] * block[1][0]
        found = np.linalg.det(matrices(block))
        return float(found) if found.ndim == 0 else found

    def solve(self, entries: Sequence[Any], right: Sequence[Any]) -> list[Any]:
        """x of J x = r, for the entries of J row by row: floats, arrays or terms.

        Raises
        ------
        ZeroDivisionError
            If a single system of floats is singular; arrays get inf or NaN.
        """
        return self.solve_all(entries, [right])[0]

    def solve_all(self, entries: Sequence[Any], rights: Sequence[Sequence[Any]]) -> list[list[Any]]:
        """`solve` for several right sides."""
        if not self.square:
            return self._least(entries, rights)
        n = self.columns
        outputs: list[list[Any]] = [[0.0] * n for _ in rights]
        for rows, columns in self.blocks:
            block = [[entries[i * n + j] for j in columns] for i in rows]
            known = [
                [self._known(entries, right, out, i) for i in rows] for right, out in zip(rights, outputs, strict=True)
            ]
            for out, found in zip(outputs, _block(block, known), strict=True):
                for j, x in zip(columns, found, strict=True):
                    out[j] = x
        return outputs

    def solve_floats(self, entries: Sequence[float], rights: Sequence[Sequence[float]]) -> list[list[float]]:
        """`solve_all` for one matrix, with the bits that it gives in a stack of matrices.

        Raises
        ------
        ZeroDivisionError, LinAlgError
            If the matrix is singular.
        """
        m, n = self.rows, self.columns
        if not self.square:
            if not m or not n:
                return [[0.0] * n for _ in rights]
            found: list[list[float]] = least_squares(self._matrix(entries), np.array(rights).T, self.rank).T.tolist()
            return found
        matrix, outputs = self._matrix(entries), [[0.0] * n for _ in rights]
        for (rows, columns), places in zip(self.blocks, self._places, strict=True):
            known = [
                [self._known(entries, right, out, i) for i in rows] for right, out in zip(rights, outputs, strict=True)
            ]
            if len(rows) > 2:
                solved = np.linalg.solve(matrix[places], np.array(known).T).T.tolist()
            else:
                solved = _block(matrix[places].tolist(), known)
            for out, x in zip(outputs, solved, strict=True):
                for j, value in zip(columns, x, strict=True):
                    out[j] = value
        return outputs

    def determinants_of_floats(self, entries: Sequence[float]) -> list[float]:
        """`determinants` of one matrix, with the bits that they have in a stack of matrices."""
        if self.projection is not None:
            return [float(np.linalg.det(self.projection @ self._matrix(entries)))]
        if not self.square:
            return []
        matrix = self._matrix(entries)
        return [self._determinant(matrix[places].tolist()) for places in self._places]

    def _matrix(self, entries: Sequence[float]) -> Array:
        return np.array(entries, dtype=np.float64).reshape(self.rows, self.columns)

    @cached_property
    def _places(self) -> list[tuple[Any, ...]]:
        """Index of each block in the matrix."""
        return [np.ix_(rows, columns) for rows, columns in self.blocks]

    def project(self, jacobian: Array) -> None:
        """Set `projection` from one of the matrices (m, n), if the equations are redundant but determine x."""
        if not self.square and self.rank == self.columns > 0:
            self.projection = np.asarray(np.linalg.pinv(jacobian), dtype=np.float64)

    def _known(self, entries: Sequence[Any], right: Sequence[Any], out: Sequence[Any], i: int) -> Any:
        value = right[i]
        for k in self._solved_before[i]:
            value = value - entries[i * self.columns + k] * out[k]
        return value

    @cached_property
    def _solved_before(self) -> list[list[int]]:
        """By row, what it has of the unknowns of earlier blocks, in the order of solution."""
        found: list[list[int]] = [[] for _ in range(self.rows)]
        solved: list[int] = []
        for rows, columns in self.blocks:
            for i in rows:
                found[i] = [solved[k] for k in np.flatnonzero(self.pattern[i, solved])]
            solved += columns
        return found

    def _least(self, entries: Sequence[Any], rights: Sequence[Sequence[Any]]) -> list[list[Any]]:
        m, n = self.rows, self.columns
        if not m or not n:
            return [[0.0] * n for _ in rights]
        a = matrices([list(entries[i * n : i * n + n]) for i in range(m)])
        return _columns(least_squares(a, _sides(a, rights), self.rank))


def _sides(a: Array, rights: Sequence[Sequence[Value]]) -> Array:
    """Right sides as columns of matrices (..., m, k) of the batch shape of the matrices a."""
    flat = np.broadcast_arrays(a[..., 0, 0], *(x for right in rights for x in right))[1:]
    return np.swapaxes(np.stack(flat, axis=-1).reshape(*flat[0].shape, len(rights), len(rights[0])), -1, -2)


def _columns(x: Array) -> list[list[Any]]:
    """Columns of matrices (..., n, k), each as a list of its entries."""
    return [[x[..., i, k] for i in range(x.shape[-2])] for k in range(x.shape[-1])]


def _block(block: list[list[Any]], rights: list[list[Any]]) -> list[list[Any]]:
    if len(block) == 1:
        return [[right[0] / block[0][0]] for right in rights]
    if len(block) == 2:
        (a, b), (c, d) = block
        det = a * d - b * c
        return [[(r * d - s * b) / det, (s * a - r * c) / det] for r, s in rights]
    a = matrices(block)
    return _columns(stacked_solve(a, _sides(a, rights)))


def matrices(entries: list[list[Value]]) -> Array:
    """Matrices (..., m, n) of entries that broadcast."""
    shape = np.broadcast_shapes(*(entry.shape for row in entries for entry in row if isinstance(entry, np.ndarray)))
    if not shape:
        return np.array(entries, dtype=np.float64)
    out = np.zeros((*shape, len(entries), len(entries[0])))
    for i, row in enumerate(entries):
        for j, entry in enumerate(row):
            if isinstance(entry, np.ndarray) or entry != 0.0:
                out[..., i, j] = entry
    return out


def stacked_solve(a: Array, b: Array) -> Array:
    """X (..., n, k) of A X = B; NaN where A is singular."""
    try:
        return np.asarray(np.linalg.solve(a, b))
    except np.linalg.LinAlgError:
        bad = (np.linalg.det(a) == 0.0)[..., None, None]
        return np.where(bad, np.nan, np.linalg.solve(np.where(bad, np.eye(a.shape[-1]), a), b))


def least_squares(a: Array, b: Array, rank: int) -> Array:
    """X (..., n, k) of least |A x - b| and, among these, least |x|, for matrices (..., m, n) of the given rank.

    If the rank is full, by the normal equations of the first or second kind; Newton's method corrects their error.
    """
    m, n = a.shape[-2:]
    transposed = np.swapaxes(a, -1, -2)
    if rank == n:
        return stacked_solve(transposed @ a, transposed @ b)
    if rank == m:
        return np.asarray(transposed @ stacked_solve(a @ transposed, b))
    ok = np.isfinite(a).all(axis=(-1, -2), keepdims=True)
    return np.where(ok, by_singular_values(np.where(ok, a, 0.0), b, rank), np.nan)


def by_singular_values(a: Array, b: Array, rank: int) -> Array:
    """The same of finite matrices, by their singular values whatever the rank, so that no digits are lost."""
    u, s, vt = np.linalg.svd(a, full_matrices=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.einsum("...ij,...ik->...jk", u, b)[..., :rank, :] / s[..., :rank, None]
        return np.asarray(np.einsum("...ij,...ik->...jk", vt[..., :rank, :], along))
