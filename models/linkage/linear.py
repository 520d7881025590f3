"""The linear equations of a Newton step, entry by entry where they fall into small blocks."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components, maximum_bipartite_matching

from ...framework.batch import Array
from .tape import Value

Blocks = list[tuple[list[int], list[int]]]


class Linear:
    """Solver of J x = r for entries that are floats or arrays.

    Where as many equations as unknowns fall into blocks one after the other (a block triangular form, Dulmage and
    Mendelsohn 1958), blocks of one and two are solved by Cramer's rule: Newton's method mends its rounding. Equations
    of any other shape are solved as a whole in the sense of least squares, with the least step.

    Parameters
    ----------
    pattern
        Which entries of J can differ from zero, rows by columns.
    rank
        Rank of J.
    """

    def __init__(self, pattern: Sequence[Sequence[bool]], rank: int | None = None) -> None:
        self.pattern = np.array(pattern, dtype=bool).reshape(len(pattern), -1)
        self.rows, self.columns = self.pattern.shape if len(pattern) else (0, 0)
        self.rank = min(self.rows, self.columns) if rank is None else rank

    @property
    def square(self) -> bool:
        """As many independent equations as unknowns, one for one."""
        return self.rows == self.columns == self.rank and sum(len(rows) for rows, _ in self.blocks) == self.rows

    @cached_property
    def blocks(self) -> Blocks:
        """Rows and columns of each block, in the order of solution; none where rows and columns do not match."""
        if self.rows != self.columns or self.rows == 0:
            return []
        match = maximum_bipartite_matching(csr_matrix(self.pattern), perm_type="row")
        if np.any(match < 0):
            return []
        # Row match[j] belongs to column j; an entry (match[j], k) makes column j wait for column k.
        waits = self.pattern[match]
        _, label = connected_components(csr_matrix(waits), directed=True, connection="strong")
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

    @property
    def determinants_of(self) -> Blocks:
        """Blocks that have a determinant: none where the equations are not square."""
        return self.blocks if self.square else []

    def determinants(self, entries: Sequence[Value]) -> list[Value]:
        """Determinant of each block; none where the equations are not square."""
        n = self.columns
        return [self._determinant([[entries[i * n + j] for j in cs] for i in rs]) for rs, cs in self.determinants_of]

    @staticmethod
    def _determinant(block: list[list[Value]]) -> Value:
        if len(block) == 1:
            return block[0][0]
        if len(block) == 2:
            return block[0][0] * block[1][1] - block[0][1] * block[1][0]
        found = np.linalg.det(matrices(block))
        return float(found) if np.ndim(found) == 0 else found

    def solve(self, entries: Sequence[Value], right: Sequence[Value]) -> list[Value]:
        """x of J x = r, for the entries of J row by row.

        Raises
        ------
        ZeroDivisionError, LinAlgError
            If a single system is singular; arrays get inf or NaN.
        """
        if not self.square:
            return self._least(entries, right)
        out: list[Value] = [0.0] * self.columns
        solved: list[int] = []
        for rows, columns in self.blocks:
            block = [[entries[i * self.columns + j] for j in columns] for i in rows]
            known = []
            for i in rows:
                value = right[i]
                for k in solved:
                    if self.pattern[i, k]:
                        value = value - entries[i * self.columns + k] * out[k]
                known.append(value)
            for j, x in zip(columns, _block(block, known), strict=True):
                out[j] = x
            solved += columns
        return out

    def _least(self, entries: Sequence[Value], right: Sequence[Value]) -> list[Value]:
        if not self.columns:
            return []
        if not self.rows:
            return [0.0] * self.columns
        n = self.columns
        a = matrices([[entries[i * n + j] for j in range(n)] for i in range(self.rows)])
        b = np.stack(np.broadcast_arrays(*right, a[..., 0, 0])[:-1], axis=-1)
        shape = np.broadcast_shapes(a.shape[:-2], b.shape[:-1])
        x = np.broadcast_to(least_squares(a, b, self.rank), (*shape, n))
        return [float(part) for part in x] if x.ndim == 1 else list(np.moveaxis(x, -1, 0))


def _block(block: list[list[Value]], right: list[Value]) -> Sequence[Value]:
    if len(block) == 1:
        return [right[0] / block[0][0]]
    if len(block) == 2:
        (a, b), (c, d) = block
        det = a * d - b * c
        return [(right[0] * d - right[1] * b) / det, (right[1] * a - right[0] * c) / det]
    a = matrices(block)
    b = np.stack(np.broadcast_arrays(*right, a[..., 0, 0])[:-1], axis=-1)
    x = stacked_solve(a, b)
    return [float(part) for part in x] if x.ndim == 1 else list(np.moveaxis(x, -1, 0))


def matrices(entries: list[list[Value]]) -> Array:
    """Matrices (..., m, n) of entries that broadcast."""
    flat = np.broadcast_arrays(*(entry for row in entries for entry in row))
    return np.stack(flat, axis=-1).reshape(*flat[0].shape, len(entries), len(entries[0]))


def stacked_solve(a: Array, b: Array) -> Array:
    """x (..., n) of A x = b; where single systems of a stack are singular they get NaN."""
    try:
        return np.asarray(np.linalg.solve(a, b[..., None])[..., 0])
    except np.linalg.LinAlgError:
        if a.ndim == 2:
            raise
        bad = np.linalg.det(a) == 0.0
        safe = np.where(bad[..., None, None], np.eye(a.shape[-1]), a)
        return np.where(bad[..., None], np.nan, np.linalg.solve(safe, b[..., None])[..., 0])


def least_squares(a: Array, b: Array, rank: int) -> Array:
    """x (..., n) that minimises first |A x - b| and then |x|, for matrices (..., m, n) of the given rank.

    Where the rank is full, by the normal equations of either kind: their error is mended by Newton's method.
    """
    m, n = a.shape[-2:]
    turned = np.swapaxes(a, -1, -2)
    if rank == n:
        return stacked_solve(turned @ a, (turned @ b[..., None])[..., 0])
    if rank == m:
        return np.asarray((turned @ stacked_solve(a @ turned, b)[..., None])[..., 0])
    ok = np.isfinite(a).all(axis=(-1, -2)) & np.isfinite(b).all(axis=-1)
    u, s, vt = np.linalg.svd(np.where(ok[..., None, None], a, 0.0), full_matrices=False)
    with np.errstate(divide="ignore", invalid="ignore"):
        along = np.einsum("...ij,...i->...j", u, b)[..., :rank] / s[..., :rank]
        x = np.einsum("...ij,...i->...j", vt[..., :rank, :], along)
    return np.where(ok[..., None], x, np.nan)


Step = Callable[[Sequence[Value], Sequence[Value]], list[Value]]
