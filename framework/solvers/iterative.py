"""Conjugate gradients for lattices whose factor would be too costly.

They are done for about half the nodes, see `condensed`, with the preconditioner of `rigid_pieces`.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import cached_property

import numpy as np
import scipy

from ..batch import Array
from ..structure.parts import Extended
from .condensed import Condensed, Places
from .factor import MOTIONS, Factor
from .patterns import filled
from .radau import dot, least_ritz, stored
from .rigid_pieces import preconditioner
from .rounding import SUSPECT, zero_eigenvalue

# Number of iterations after which a factor is used instead.
ITERATIONS = 4000
# Share of the load down to which the first solution goes; that of what is left then adds the further digits, so that
# the rounding of the condensed matrix counts no more.
_FIRST = 1e-5
# What may be left of a load, as a share of the rounding of the product of matrix and solution in double precision.
_LEFT = 0.25
# Number of rows of the matrix that are converted to extended precision at a time.
_ROWS = 2**14
# If the residual of a random load falls to this share, the frame has no free motion.
_PROBE = 1e-5
# Number of vectors, and of steps, of the iteration to the least eigenvalues.
_BLOCK, _SOFT_STEPS = 4, 40
# Share of the load at which the residual is small enough if a few digits suffice.
_ROUGH = 1e-3
_EPS = float(np.finfo(float).eps)

# Number of steps that bound the energy of a load's solution; for a lattice the norm is then two to three times too
# large, if the least eigenvalue is assumed to be a quarter of the estimate.
_STEPS = 5

# Coefficients alpha of the steps of conjugate gradients, and beta of their directions.
Steps = tuple[list[float], list[float]]


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
        self.instead: Factor | None = None
        self.iterations = 0
        sizes = filled(self.scaled, np.abs(self.scaled.data))
        self.norm = float((sizes @ np.ones(len(self.root))).max())
        try:
            self._condensed = Condensed(self.scaled, places)
            self.precondition = preconditioner(self._condensed, self.root, places)
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
        found = []
        for column in scaled.T:
            own, rest = self._condensed.condensed(column)
            found.append(dot(own, own) + stored(rest, self._condensed, self.precondition, least, _STEPS))
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
        inverse = LinearOperator((size, size), matvec=self._nearly, matmat=self._nearly, dtype=float)
        start = np.random.default_rng(0).standard_normal((size, _BLOCK))
        with warnings.catch_warnings():  # that it has not converged to rounding
            warnings.simplefilter("ignore")
            _, vectors = lobpcg(self.scaled, start, M=inverse, largest=False, maxiter=_SOFT_STEPS, tol=_EPS)
        return (np.array(vectors[:, :2]), 2) if np.isfinite(vectors).all() else super().soft()

    def _nearly(self, load: Array) -> Array:
        """Product (n,) or (n, k) of the inverse, as nearly as the preconditioner has it, and loads."""
        own, rest = self._condensed.condensed(load)
        return self._condensed.expanded(own, self.precondition(rest))

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
                self._probed, self._least_ritz = found, least_ritz(lengths, growths) if lengths else 1.0
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
            if dot(lost, self.scaled @ lost) > zero_eigenvalue(size):
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
        found, left = np.zeros_like(load), load
        for aim in (max(share, _FIRST), share, share):
            change = self._descend(left, self._balanced(size, _norm(found), aim))
            if change is None:
                return None
            found = found + change
            most = max(64.0 * _EPS * (self.norm * _norm(found) + size), 2.0 * share * size)
            if _norm(load - self.scaled @ found) <= most:
                return found
            left = self._left(load, found)
        return None

    def _left(self, load: Array, found: Array) -> Array:
        """What a solution leaves unbalanced of a load, summed in extended precision, some rows at a time."""
        wide, left = found.astype(Extended), np.empty_like(load)
        for start in range(0, len(load), _ROWS):
            rows = slice(start, start + _ROWS)
            left[rows] = load[rows] - self.scaled[rows].astype(Extended) @ wide
        return left

    def _balanced(self, size: float, length: float, share: float) -> Callable[[Array], float]:
        """Residual that may be left of a load of some `size`: that of rounding, or a `share`.

        It is that of a change of a solution of some `length`, of a length of its own.
        """
        return lambda change: max(_LEFT * _EPS * (self.norm * max(length, _norm(change)) + size), share * size)

    def _descend(self, load: Array, enough: Callable[[Array], float], steps: Steps | None = None) -> Array | None:
        """Preconditioned conjugate gradients until the residual is at most ``enough(x)``; None without convergence.

        Residual and x are those of the nodes that are not condensed out. The coefficients of the steps are appended to
        `steps`, see `least_ritz`.
        """
        own, rest = self._condensed.condensed(load)
        with np.errstate(all="ignore"):  # of a singular matrix, steps may have any size
            found = self._descended(rest, enough, ([], []) if steps is None else steps)
            return None if found is None else self._condensed.expanded(own, found)

    def _descended(self, load: Array, enough: Callable[[Array], float], steps: Steps) -> Array | None:
        x, residual = np.zeros_like(load), load.copy()
        way, before = np.zeros_like(load), np.inf
        lengths, growths = steps
        while not _norm(residual) <= enough(x):
            z = self.precondition(residual)
            power = dot(residual, z)
            way *= power / before
            way += z
            ahead = self._condensed @ way
            work = dot(way, ahead)
            if not work > 0.0 or not power > 0.0 or len(lengths) >= ITERATIONS:
                return None
            if lengths:
                growths.append(power / before)
            lengths.append(power / work)
            x += np.multiply(way, lengths[-1], out=z)
            residual -= np.multiply(ahead, lengths[-1], out=ahead)
            before = power
            self.iterations += 1
        return x


def _norm(a: Array) -> float:
    return float(np.sqrt(dot(a, a)))
