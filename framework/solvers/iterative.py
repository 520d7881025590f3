"""Conjugate gradients for lattices whose factor would be too costly.

The preconditioner is the sum of block Jacobi, by node, and of a coarse-grid correction in which the frame is divided
into rigid pieces (Nicolaides, SIAM J. Numer. Anal. 24, 1987, 355-365, with the six rigid motions of each piece).
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

# Number of nodes of a rigid piece.
PIECE = 100
# Number of iterations after which a factor is used instead.
ITERATIONS = 4000
# If the residual of a random load falls to this share, the frame has no free motion.
_PROBE = 1e-5
# Number of vectors, and of steps, of the iteration to the least eigenvalues.
_BLOCK, _SOFT_STEPS = 4, 40
# Share of the load at which the residual is small enough if a few digits suffice.
_ROUGH = 1e-3
# Share of its diagonal that is added to the coarse stiffness, so that it is regular even if the frame is singular.
_FLOOR = 1e-12
# If more than this share of the entries in blocks is not zero, a product by blocks is faster.
_FILLED = 0.65
_EPS = float(np.finfo(float).eps)

# Number of steps that bound the energy of a load's solution; for a lattice the norm is then two to three times too
# large, if the least eigenvalue is assumed to be a quarter of the estimate.
_STEPS = 8

Operator = Callable[[Array], Array]
# Coefficients alpha of the steps of conjugate gradients, and beta of their directions.
Steps = tuple[list[float], list[float]]


@dataclass(frozen=True)
class Places:
    """The nodes of n unknowns.

    Attributes
    ----------
    node, component
        Number of the node and index of the displacement component, (n,).
    points
        Positions of the nodes, (n, 3).
    free
        Whether the unknown is a displacement of the node in global axes, rather than one of a joint, (n,).
    """

    node: Index
    component: Index
    points: Array
    free: NDArray[np.bool_]

    def of(self, where: NDArray[np.bool_]) -> Places:
        """The unknowns in a mask (n,)."""
        return Places(self.node[where], self.component[where], self.points[where], self.free[where])


class Iterative(Factor):
    """Solver by conjugate gradients to rounding; by a factor where they do not converge.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    places
        The nodes of its unknowns.
    direct
        Function that factorises the matrix if need be.
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
        """Whether all pivots of a factor are positive."""
        return self._direct(self.matrix).definite

    def solve_scaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        return self._found(load, np.zeros(load.shape[1]))

    def solve_to(self, load: Array, share: Array) -> Array:
        """As `solve`, until a `share` (k,) of each scaled load (n, k) is left unbalanced."""
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
            if self.instead is None:  # the matrix is regular, but the iteration does not converge
                self._give_up()
        assert self.instead is not None
        return self.instead.solve_scaled(load)

    def energies(self, load: Array, margin: float) -> Array:
        """Upper bounds (k,) on the energy norm of the solutions for loads (n, k).

        Parameters
        ----------
        load
            The loads, (n, k).
        margin
            Factor by which the least eigenvalue may be below its estimate from the iterations.
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
        """Start vectors for inverse iteration, see `Factor.soft`: those of the least eigenvalues by LOBPCG.

        (Knyazev, SIAM J. Sci. Comput. 23, 2001, 517-541.) If `nearly` suffices, the solution for the random load of
        `singular` is returned.
        """
        from scipy.sparse.linalg import LinearOperator, lobpcg

        size = len(self.root)
        if nearly and not self.singular and self.instead is None:
            return self._probed[:, None], 1
        if self.instead is not None or size <= _BLOCK * _BLOCK:
            return super().soft()
        inverse = LinearOperator((size, size), matvec=self.precondition, matmat=self.precondition, dtype=float)
        start = np.random.default_rng(0).standard_normal((size, _BLOCK))
        with warnings.catch_warnings():  # that it has not converged to rounding
            warnings.simplefilter("ignore")
            _, vectors = lobpcg(self.scaled, start, M=inverse, largest=False, maxiter=_SOFT_STEPS, tol=_EPS)
        return (np.array(vectors[:, :2]), 2) if np.isfinite(vectors).all() else super().soft()

    def roughly(self, load: Array) -> Array | None:
        """As `solve_scaled`, but to a few digits."""
        found = [self._rough(column) for column in load.T] if self.instead is None else [None]
        columns = [column for column in found if column is not None]
        return np.stack(columns, axis=1) if len(columns) == len(found) else self.solve_scaled(load)

    def _rough(self, load: Array) -> Array | None:
        least = _ROUGH * _norm(load)
        return self._descend(load, lambda _: least)

    @cached_property
    def singular(self) -> bool:
        """Whether there is a free motion, as shown by a random load; if that does not converge, by a factor."""
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
        """Null vectors of the matrix, (n, motions)."""
        if self.instead is not None:
            return self.instead.motions(direct)
        found: Array = self.root[:, None] * self._motions
        return found

    @cached_property
    def _motions(self) -> Array:
        """Orthonormal null vectors of the scaled matrix A, (n, motions).

        They are the parts of random vectors x that are lost when ``A y = A x`` is solved, one after the other until
        nothing is lost.
        """
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
        """Preconditioned conjugate gradients until the residual is at most ``enough(x)``; None without convergence.

        The coefficients of the steps are appended to `steps`, see `least_ritz`.
        """
        with np.errstate(all="ignore"):  # of a singular matrix, steps may have any size
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
    """Inner product without BLAS, whose threads would wait for each other at every step."""
    return float(np.einsum("i,i->", a, b))


def _norm(a: Array) -> float:
    return float(np.sqrt(_dot(a, a)))


def _in_blocks(scaled: scipy.sparse.csr_matrix, places: Places) -> Any:
    """The matrix (n, n) in blocks of six by six if all nodes have six unknowns: a product then takes half the time.

    Where members lie along the axes, most of a block is zero, and the matrix is returned as it is.
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
    """Block-diagonal matrix of the inverses of the nodes' diagonal blocks, (n, n)."""
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
    """Displacements (n, 6 pieces) per unit of the six motions of each rigid piece about its centre."""
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
    """Numbers renamed 0, 1, ..., and how many different ones there are."""
    found, renamed = np.unique(numbers, return_inverse=True)
    return renamed.astype(np.int64), len(found)
