"""Conjugate gradients for lattices whose factor would be too dear, with a coarse frame of rigid pieces.

The preconditioner adds the answer of each node by itself (block Jacobi) and that of the frame cut into pieces that
are rigid (Nicolaides, SIAM J. Numer. Anal. 24, 1987, 355-365, with the six rigid motions of each piece).
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..structure.topology import Index
from .dissection import bisected
from .factor import MOTIONS, Factor
from .lu import LUFactor
from .radau import least_ritz, stored
from .rounding import SUSPECT, zero_eigenvalue

# Nodes of a rigid piece.
PIECE = 100
# Iterations after which a factor is the better way.
ITERATIONS = 4000
# A random load whose residual comes down to this share has no part in a motion that nothing resists.
_PROBE = 1e-5
# Vectors that lead to the least eigenvalues, and steps.
_BLOCK, _SOFT_STEPS = 4, 40
# Share of a load that is left where a few digits do.
_ROUGH = 1e-3
# Share of its diagonal that is added to the coarse frame's stiffness, lest it be singular where the frame is.
_FLOOR = 1e-12
# Share of the numbers in blocks that are not zero, above which a product by blocks is the quicker one.
_FILLED = 0.65
_EPS = float(np.finfo(float).eps)

# Steps that tell how much energy a load stores; of a lattice the norm then comes out two to three times too large,
# with the least eigenvalue taken as a quarter.
_STEPS = 8

Operator = Callable[[Array], Array]
# Lengths of steps along their directions, and how much of each direction the next one took along.
Steps = tuple[list[float], list[float]]


@dataclass(frozen=True)
class Places:
    """Where unknowns are: node (n,), component (n,), position of the node (n, 3), and whether it is the unknown's own
    displacement in global axes that counts (n,), not one in a joint."""

    node: Index
    component: Index
    points: Array
    free: NDArray[np.bool_]

    def of(self, where: NDArray[np.bool_]) -> Places:
        """Some of the unknowns."""
        return Places(self.node[where], self.component[where], self.points[where], self.free[where])


class Iterative(Factor):
    """Solves by iteration to rounding; by a factor where that does not converge.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    places
        Where its unknowns are.
    direct
        Makes the factor that serves instead.
    """

    def __init__(
        self, matrix: scipy.sparse.csr_matrix, places: Places, direct: Callable[[scipy.sparse.csr_matrix], Factor]
    ) -> None:
        super().__init__(matrix)
        self.matrix, self._direct = matrix, direct
        self._acting = _in_blocks(self.scaled, places)
        self.instead: Factor | None = None
        self.iterations = 0
        self.norm = float(abs(self.scaled).sum(axis=1).max())
        try:
            self.precondition = _preconditioner(self.scaled, self.root, places)
        except np.linalg.LinAlgError:
            self._give_up()

    @property
    def definite(self) -> bool:
        """Whether all pivots are positive: a factor has the word."""
        return self._direct(self.matrix).definite

    def unscaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        return self._found(load, np.zeros(load.shape[1]))

    def solve_to(self, load: Array, share: Array) -> Array:
        """As `solve`, until a `share` (k,) of each load (n, k), scaled, is left unbalanced."""
        found = self._found(self.root[:, None] * load, share)
        return np.full_like(load, np.nan) if found is None else self.root[:, None] * found

    def _found(self, load: Array, share: Array) -> Array | None:
        if self.instead is None:
            columns = [self._column(column, part) for column, part in zip(load.T, share.tolist(), strict=True)]
            found = [column for column in columns if column is not None]
            if len(found) == len(columns):
                return np.stack(found, axis=1)
            if self.singular and self.instead is None:
                return None
            if self.instead is None:  # a matrix that is regular, and a load that does not converge all the same
                self._give_up()
        assert self.instead is not None
        return self.instead.unscaled(load)

    def energies(self, load: Array, margin: float) -> Array:
        """Energy norm (k,) of the solutions for loads (n, k), at most.

        Parameters
        ----------
        load
            The loads.
        margin
            By which the least eigenvalue may be below what the iterations met.
        """
        if self.singular or self.instead is not None:
            return np.full(load.shape[1], np.inf)
        least = self._least_ritz / margin
        scaled = self.root[:, None] * load
        self.iterations += _STEPS * load.shape[1]
        found = [stored(column, self._acting, self.precondition, least, _STEPS) for column in scaled.T]
        out: Array = np.sqrt(np.array(found))
        return out

    def soft(self, *, nearly: bool = False) -> tuple[Array, int]:
        """Vectors (n, 2) near those of the least eigenvalues, by preconditioned steps on a few random ones at once
        (LOBPCG: Knyazev, SIAM J. Sci. Comput. 23, 2001, 517-541); where nearly will do, what the random load of
        `singular` brings about."""
        from scipy.sparse.linalg import LinearOperator, lobpcg

        size = len(self.root)
        if nearly and not self.singular and self.instead is None:
            return self._probed[:, None], 1
        if self.instead is not None or size <= _BLOCK * _BLOCK:
            return super().soft()
        inverse = LinearOperator((size, size), matvec=self.precondition, matmat=self.precondition, dtype=float)
        start = np.random.default_rng(0).standard_normal((size, _BLOCK))
        with warnings.catch_warnings():  # of not having come to rounding
            warnings.simplefilter("ignore")
            _, vectors = lobpcg(self.scaled, start, M=inverse, largest=False, maxiter=_SOFT_STEPS, tol=_EPS)
        return (np.array(vectors[:, :2]), 2) if np.isfinite(vectors).all() else super().soft()

    def roughly(self, load: Array) -> Array | None:
        """As `unscaled`, to a few digits."""
        found = [self._rough(column) for column in load.T] if self.instead is None else [None]
        columns = [column for column in found if column is not None]
        return np.stack(columns, axis=1) if len(columns) == len(found) else self.unscaled(load)

    def _rough(self, load: Array) -> Array | None:
        least = _ROUGH * _norm(load)
        return self._descend(load, lambda _: least)

    @cached_property
    def singular(self) -> bool:
        """Whether a random load meets a motion that nothing resists; where none is found, a factor has the word."""
        if self.instead is None:
            probe = np.random.default_rng(0).standard_normal(len(self.root))
            lengths: list[float] = []
            growths: list[float] = []
            found = self._descend(probe, lambda _: _PROBE * _norm(probe), (lengths, growths))
            if found is not None:
                self._probed, self._least_ritz = found, least_ritz(lengths, growths)
            if found is not None and _norm(found) < SUSPECT / zero_eigenvalue(len(probe)) * _norm(probe):
                return False
            if self._motions.size:
                return True
            self._give_up()
        assert self.instead is not None
        return self.instead.singular

    def motions(self, direct: Callable[[scipy.sparse.csr_matrix], Factor]) -> Array:
        """Vectors (n, motions) that the matrix sends to zero."""
        if self.instead is not None:
            return self.instead.motions(direct)
        found: Array = self.root[:, None] * self._motions
        return found

    @cached_property
    def _motions(self) -> Array:
        """Orthonormal vectors that the scaled matrix sends to zero: what of a random vector x does not come back when
        ``A y = A x`` is solved, one after the other until it all does."""
        rng, size = np.random.default_rng(1), len(self.root)
        known = np.zeros((size, 0))
        while known.shape[1] < MOTIONS:
            vector = rng.standard_normal(size)
            vector -= known @ (known.T @ vector)
            found = self._descend(self.scaled @ vector, self._rounding(vector))
            if found is None:
                break
            lost = vector - found
            lost -= known @ (known.T @ lost)
            lost /= _norm(lost)
            if _dot(lost, self.scaled @ lost) > zero_eigenvalue(size):
                break
            known = np.column_stack([known, lost])
        return known

    def _rounding(self, vector: Array) -> Callable[[Array], float]:
        least = 16.0 * _EPS * self.norm * _norm(vector)
        return lambda _: least

    def _give_up(self) -> None:
        self.instead = self._direct(self.matrix)

    def _column(self, load: Array, share: float) -> Array | None:
        size = _norm(load)
        if size == 0.0:
            return np.zeros_like(load)
        found = self._descend(load, lambda x: max(_EPS * (self.norm * _norm(x) + size), share * size))
        if found is None:
            return None
        left = _norm(load - self.scaled @ found)
        return found if left <= max(64.0 * _EPS * (self.norm * _norm(found) + size), 2.0 * share * size) else None

    def _descend(self, load: Array, enough: Callable[[Array], float], steps: Steps | None = None) -> Array | None:
        """Preconditioned conjugate gradients until the residual is `enough`, None where it does not become so.

        What `steps` are taken is added to these, see `least_ritz`.
        """
        with np.errstate(all="ignore"):  # where nothing resists, steps may be of any size
            return self._descended(load, enough, ([], []) if steps is None else steps)

    def _descended(self, load: Array, enough: Callable[[Array], float], steps: Steps) -> Array | None:
        x, residual = np.zeros_like(load), load.copy()
        way = z = self.precondition(residual)
        power = _dot(residual, z)
        lengths, growths = steps
        for _ in range(ITERATIONS):
            ahead = self._acting @ way
            work = _dot(way, ahead)
            if not work > 0.0 or not power > 0.0:
                return None
            lengths.append(power / work)
            x += lengths[-1] * way
            residual -= lengths[-1] * ahead
            self.iterations += 1
            if _norm(residual) <= enough(x):
                return x
            z = self.precondition(residual)
            before, power = power, _dot(residual, z)
            growths.append(power / before)
            way = z + growths[-1] * way
        return None


def _dot(a: Array, b: Array) -> float:
    """Inner product; short of what BLAS would share among threads, which would wait for each other at each step."""
    return float(np.einsum("i,i->", a, b))


def _norm(a: Array) -> float:
    return float(np.sqrt(_dot(a, a)))


def _in_blocks(scaled: scipy.sparse.csr_matrix, places: Places) -> Any:
    """The matrix (n, n) in blocks of six by six, where all nodes have six unknowns: a product takes half the time.

    Of members along the axes most of a block is zero, and entry by entry is the quicker way.
    """
    nodes = len(places.component) // 6
    if not np.array_equal(places.component, np.tile(np.arange(6), nodes)):
        return scaled
    blocks = scaled.tobsr((6, 6))
    return blocks if scaled.nnz > _FILLED * blocks.data.size else scaled


def _preconditioner(scaled: scipy.sparse.csr_matrix, root: Array, places: Places) -> Operator:
    nodes = _node_inverses(scaled, places)
    rigid = _rigid_motions(places)
    rigid = scipy.sparse.csr_matrix(scipy.sparse.diags(1.0 / root) @ rigid)
    moved = scipy.sparse.csr_matrix(rigid.T @ scaled @ rigid)
    stiff = moved.diagonal()
    moved = scipy.sparse.csr_matrix(moved + scipy.sparse.diags(_FLOOR * stiff))
    kept = np.flatnonzero(stiff > _EPS * stiff.max(initial=0.0))
    coarse = LUFactor(moved[kept][:, kept])
    rigid = scipy.sparse.csr_matrix(rigid[:, kept] @ scipy.sparse.diags(coarse.root))
    back = scipy.sparse.csr_matrix(rigid.T)
    if coarse.factor is None:
        return lambda residual: np.asarray(nodes @ residual)
    return lambda residual: np.asarray(nodes @ residual + rigid @ coarse.factor.solve(back @ residual))


def _node_inverses(scaled: scipy.sparse.csr_matrix, places: Places) -> scipy.sparse.csr_matrix:
    """Inverse of each node's own matrix, (n, n)."""
    node, count = _compact(places.node)
    entries = scaled.tocoo()
    own = node[entries.row] == node[entries.col]
    row, column = entries.row[own], entries.col[own]
    blocks = np.zeros((count, 6, 6)) + np.eye(6)
    blocks[node[row], places.component[row], places.component[column]] = entries.data[own]
    inverse = np.linalg.inv(blocks)
    padded = scipy.sparse.csr_matrix(scipy.sparse.bsr_matrix((inverse, np.arange(count), np.arange(count + 1))).tocsr())
    present = 6 * node + places.component
    out = scipy.sparse.csr_matrix(padded[present][:, present])
    out.eliminate_zeros()
    return out


def _rigid_motions(places: Places) -> scipy.sparse.csr_matrix:
    """Displacements (n, 6 pieces) for the six motions of each rigid piece about its centre."""
    at = np.flatnonzero(places.free)
    if not len(at):
        return scipy.sparse.csr_matrix((len(places.node), 0))
    _, first, inverse = np.unique(places.node[at], return_index=True, return_inverse=True)
    points = places.points[at[first]]
    of_node = bisected(points, PIECE)
    centre = np.stack([np.bincount(of_node, x) for x in points.T], axis=1) / np.bincount(of_node)[:, None]
    piece, component = of_node[inverse], places.component[at]
    arm = places.points[at] - centre[piece]
    rows, columns, values = [at], [6 * piece + component], [np.ones(len(at))]
    for k in range(3):
        on = component == k
        for axis, other, sign in (((k + 1) % 3, (k + 2) % 3, 1.0), ((k + 2) % 3, (k + 1) % 3, -1.0)):
            rows.append(at[on])
            columns.append(6 * piece[on] + 3 + axis)
            values.append(sign * arm[on, other])
    shape = (len(places.node), 6 * len(centre))
    return scipy.sparse.coo_matrix(
        (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))), shape
    ).tocsr()


def _compact(numbers: Index) -> tuple[Index, int]:
    """Numbers renamed 0, 1, ... and how many there are."""
    found, renamed = np.unique(numbers, return_inverse=True)
    return renamed.astype(np.int64), len(found)
