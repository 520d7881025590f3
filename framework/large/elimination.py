"""Tangents of one sparse pattern: order and fill of their elimination, factors, eigenvalues and free motions.

Up to `LARGE` unknowns a whole batch is eliminated side by side; larger tangents are factorised one by one.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..batched.order import Pattern, link, order
from ..cache import KERNELS
from ..ldl import Columns, PivotStep, eliminated, sparse_steps, substitute
from ..solvers.lu import symmetric_lu
from ..structure.parts import Grid
from .model import Model

Index = NDArray[np.int64]

# Unknowns above which matrices are factorised one by one in SuperLU.
LARGE = 240
# Pivot, in units of the diagonal, above which all are clear of what the last step still changes.
CLEAR = 1e-8
# Roundings, by unknown, in an eigenvalue of a tangent whose rows and columns are scaled so that no entry is above one;
# so many of these within which a motion is free.
_ROUNDINGS, _FREE = 4.0 * float(np.finfo(np.float64).eps), 64.0
# Eigenvalue of scaled equations with multipliers up to which a constraint is redundant.
_REDUNDANT = 1e-12
# Stiffness of a coordinate, beside the largest in the same units, that is rounding; squares of motions that are alike.
_UNJOINED, _ALIKE = 1e-13, 1e-12


class SymbolicFactorisation:
    """Order and fill of a symmetric pattern, found once.

    Parameters
    ----------
    rows, columns
        Entries of the pattern; both (i, j) and (j, i) are there, or only those with i >= j where `half`.
    size
        Number of unknowns; entries beyond are left out.
    half
        Whether only the lower half is given.
    constraints
        How many of the last unknowns are multipliers, which stand for constraints on those before them and follow them
        in the order; any two that a constraint couples are coupled.
    units
        By unknown the number of what it is measured in together with others, (size,): the displacements of a node are,
        and its rotations, as they mix with the axes. All by themselves where not given.

    Attributes
    ----------
    zero
        Eigenvalue of a scaled tangent that is rounding.
    free
        Pivot or eigenvalue, some roundings more, at which a motion is free.
    """

    def __init__(
        self,
        rows: Index,
        columns: Index,
        size: int,
        *,
        half: bool = False,
        constraints: int = 0,
        units: Index | None = None,
    ) -> None:
        self.units = np.arange(size) if units is None else units
        self.size, self.half, self.constraints, self.first_constraint = size, half, constraints, size - constraints
        self.zero = _ROUNDINGS * size
        self.free = _FREE * self.zero
        inside = np.flatnonzero((rows < size) & (columns < size))
        self.rows, self.columns, self.inside = rows[inside], columns[inside], inside
        prescribed = np.flatnonzero((columns < size) & (rows >= size))
        self.prescribed = prescribed, columns[prescribed], rows[prescribed] - size
        if size <= LARGE:
            self._order()

    @staticmethod
    def of(
        rows: Index, columns: Index, size: int, *, half: bool = False, constraints: int = 0, units: Index
    ) -> SymbolicFactorisation:
        """That of a pattern, which all frames of the same structure have in common."""
        make = partial(SymbolicFactorisation, rows, columns, size, half=half, constraints=constraints, units=units)
        if size > LARGE:
            return make()
        key = "elimination", rows.tobytes(), columns.tobytes(), size, half, constraints, units.tobytes()
        found: SymbolicFactorisation = KERNELS.found(key, make, len(rows))
        return found

    @staticmethod
    def of_model(model: Model) -> SymbolicFactorisation:
        """That of the tangents of a model in space."""
        _, rows, columns = model.pattern
        return SymbolicFactorisation.of(rows, columns, model.free, constraints=model.constraints, units=model.units)

    def _order(self) -> None:
        """Minimum degree, as nothing here varies less than the rest."""
        pattern: Pattern = {}
        for k in range(self.size):
            link(pattern, k, k, 0)
        self.source: Index = np.flatnonzero(self.rows >= self.columns)
        lower = list(zip(self.rows[self.source].tolist(), self.columns[self.source].tolist(), strict=True))
        for i, j in lower:
            link(pattern, i, j, 0)
        free = range(self.first_constraint)
        constraints = range(self.first_constraint, self.size)
        self.constrained = {k: [i for i in sorted(pattern[k]) if i in free] for k in constraints}
        for coupled in self.constrained.values():
            for i in coupled:
                for j in coupled:
                    link(pattern, i, j, 0)
        orders = [order(pattern, some, Grid(())) for some in (free, constraints) if some]
        place = {(k, k): k for k in range(self.size)}
        self.steps: tuple[PivotStep, ...] = sparse_steps(
            ((k, each.below[k]) for each in orders for k in each.pivots), place
        )
        self.entries, self.place = len(place), place
        self.goal = np.array([place[pair] for pair in lower], dtype=np.int64)
        if not self.half:
            mirror = {pair: n for n, pair in enumerate(zip(self.columns.tolist(), self.rows.tolist(), strict=True))}
            self.other = np.array([mirror[pair] for pair in lower], dtype=np.int64)

    def prescribed_forces(self, values: Array, prescribed_residual: Array) -> Array:
        """Forces on the unknowns from displacements `prescribed_residual` (prescribed, m) of the prescribed
        coordinates."""
        which, row, column = self.prescribed
        out = np.zeros((self.size, values.shape[-1]))
        np.add.at(out, row, values[which] * prescribed_residual[column])
        return out

    def dense(self, values: Array) -> Array:
        """Whole matrices (m, n, n)."""
        out = np.zeros((self.size, self.size, values.shape[-1]))
        out[self.rows, self.columns] = values[self.inside]
        if self.half:
            out[self.columns, self.rows] = values[self.inside]
        return np.ascontiguousarray(np.moveaxis(out, -1, 0))

    def diagonal(self, values: Array) -> Array:
        """Sizes of the coordinates' stiffnesses (n, m), by whose roots rows and columns are divided to leave no entry
        above one: magnitudes on the diagonal, more where a coupling is too large for it, one where nothing is.

        Those of a node's displacements are summed up, which is the same in all axes: what is stiff along one of them
        has only rounding across it, which would count as much as the stiffness. So it is with its rotations.
        """
        own = np.flatnonzero(self.rows == self.columns)
        size = np.zeros((self.size, values.shape[-1]))
        size[self.rows[own]] = np.abs(values[self.inside[own]])
        size = self._together(size, np.add)
        inverse = np.divide(1.0, size, out=np.zeros_like(size), where=size > np.finfo(float).tiny)
        entries = values[self.inside]
        out = size.copy()
        for i, j in ((self.rows, self.columns), (self.columns, self.rows)):
            np.maximum.at(out, i, entries * (entries * inverse[j]))
        out = self._together(out, np.maximum)
        return np.where(out > 0.0, out, 1.0)

    def _together(self, size: Array, combined: np.ufunc) -> Array:
        """The sum, or the largest, of what is measured together, for all of it (n, m)."""
        out = np.zeros_like(size)
        combined.at(out, self.units, size)
        return np.asarray(out[self.units])

    def raised(self, values: Array, shift: Array | float, more: Array | float = 0.0) -> Array:
        """`values` with the diagonal raised by a share `shift` (m,) of its size, and by `more` (n, m)."""
        own = np.flatnonzero(self.rows == self.columns)
        out = values.copy()
        out[self.inside[own]] += (shift * self.diagonal(values) + more)[self.rows[own]]
        return out

    def spectrum(self, values: Array) -> Spectrum:
        """Eigenvalues and eigenvectors of symmetric parts, scaled to leave no entry above one; NaN if not finite."""
        matrix = self.dense(values)
        root = 1.0 / np.sqrt(self.diagonal(values).T)
        matrix = 0.5 * (matrix + np.swapaxes(matrix, -1, -2)) * root[:, :, None] * root[:, None, :]
        lost = ~np.isfinite(matrix).all(axis=(1, 2))
        matrix[lost] = 0.0
        eigenvalues, vectors = np.linalg.eigh(matrix)
        eigenvalues[lost] = np.nan
        return Spectrum(root, eigenvalues, vectors)

    def clearly_definite(self, values: Array) -> NDArray[np.bool_]:
        """Whether tangents are positive definite beyond all rounding (m,); with multipliers that is not known."""
        if self.constraints:
            return np.zeros(values.shape[-1], dtype=bool)
        return np.asarray((self.factor(values).pivots > CLEAR).all(axis=0))

    def definite(self, values: Array, rounding: Array | float = 0.0) -> NDArray[np.bool_]:
        """Whether tangents have no negative eigenvalue beyond rounding (m,): all pivots are positive once it is added.

        The number of negative eigenvalues of the symmetric part, the second order of the work on any motion, is the
        same in all units and axes (Sylvester).

        Parameters
        ----------
        values
            The tangents.
        rounding
            Of their diagonal, beside that in its own size (free, m).
        """
        raised = values if self.constraints else self.raised(values, self.zero, rounding)
        return np.asarray((self.factor(raised).pivots > 0.0).all(axis=0))

    def neutral(self, values: Array) -> NDArray[np.bool_]:
        """Whether tangents have an eigenvalue that is rounding or negative (m,); with multipliers that is not known."""
        if self.constraints:
            return np.zeros(values.shape[-1], dtype=bool)
        return np.asarray(~(self.factor(self.raised(values, -self.free)).pivots > 0.0).all(axis=0))

    def factor(self, values: Array, *, symmetric: bool = True) -> StackFactor:
        """Factors of tangents, `values` on the pattern (entries, m); of symmetric ones both halves are averaged."""
        if self.constraints:
            return ConstrainedFactor(self.dense(values), self.constraints)
        if not symmetric:
            return GeneralFactor(self.dense(values), self.factor(values).pivots)
        return SmallFactor(self, values) if self.size <= LARGE else LargeFactor(self, values)


@dataclass(frozen=True)
class Spectrum:
    """Modes of a stack of tangents.

    Attributes
    ----------
    root
        Scale of rows and columns (m, n).
    values, vectors
        Eigenvalues (m, n), rising, and eigenvectors as columns (m, n, n), of the scaled tangents.
    """

    root: Array
    values: Array
    vectors: Array

    @property
    def modes(self) -> Array:
        """The modes as columns, in the coordinates (m, n, n)."""
        return self.vectors * self.root[:, :, None]

    def share(self, load: Array) -> Array:
        """Work of loads (n, m) on the modes (m, n)."""
        return np.asarray(np.einsum("mji,mj,jm->mi", self.vectors, self.root, load))

    def summed(self, share: Array) -> Array:
        """Displacements (n, m) by shares of the modes (m, n)."""
        return np.asarray(np.einsum("mij,mj,mi->im", self.vectors, share, self.root))

    def solve(self, load: Array, free: NDArray[np.bool_]) -> Array:
        """Solution for loads (n, m), `free` modes (m, n) left out."""
        return self.summed(np.where(free, 0.0, self.share(load) / np.where(free, 1.0, self.values)))

    def without(self, steps: Array, free: NDArray[np.bool_], weights: Array) -> Array:
        """Steps (n, m) with so much of the `free` modes (m, n) that they are least.

        Coordinates count by `weights` (n, m) that are the same in all directions: the modes are at right angles in
        units of the tangent's diagonal, which depend on how the frame stands.
        """
        stiffness = (self.root * weights.T) ** -2.0
        # what nothing is joined to moves by itself, with the rounding of a stiffness
        joined = stiffness > _UNJOINED * stiffness.max(axis=1, keepdims=True)
        chosen = np.where(free[:, None, :] & joined[:, :, None], self.modes, 0.0)
        weighted = chosen * weights.T[:, :, None]
        across = np.swapaxes(weighted, 1, 2)
        share = np.linalg.pinv(across @ weighted, rcond=_ALIKE, hermitian=True) @ (
            across @ (weights * steps).T[:, :, None]
        )
        return np.asarray(steps - (chosen @ share)[:, :, 0].T)


class StackFactor:
    """A factorised stack.

    Attributes
    ----------
    pivots
        (n, m), in units of the diagonal: all are positive where the matrix is positive definite.
    """

    pivots: Array

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m)."""
        raise RuntimeError(f"{type(self).__name__} does not solve")


class SmallFactor(StackFactor):
    """Elimination of the whole stack, step by step."""

    def __init__(self, order: SymbolicFactorisation, values: Array) -> None:
        self.order = order
        inside = values[order.inside]
        work = np.zeros((order.entries, values.shape[-1]))
        work[order.goal] = inside if order.half else 0.5 * (inside[order.source] + inside[order.other])
        diagonal = np.abs(work[: order.size])
        scale = np.where(diagonal > 0.0, diagonal, 1.0)
        with np.errstate(all="ignore"):
            self.columns: Columns = eliminated(work, order.steps)
            self.pivots = work[: order.size] / scale

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m)."""
        out = load.copy()
        with np.errstate(all="ignore"):
            substitute(self.order.steps, self.columns, out)
        return out


class GeneralFactor(StackFactor):
    """Matrices (m, n, n) that are not symmetric, as under moments in space; pivots are those of symmetric parts."""

    def __init__(self, matrix: Array, pivots: Array) -> None:
        self.matrix, self.pivots = matrix, pivots

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m)."""
        try:
            return np.asarray(np.linalg.solve(self.matrix, load.T[..., None])[..., 0].T, dtype=np.float64)
        except np.linalg.LinAlgError:
            return np.stack([_least(a, b) for a, b in zip(self.matrix, load.T, strict=True)], axis=-1)


def _least(matrix: Array, load: Array) -> Array:
    """Solution of one system, of least size where it is singular, whatever the others of the batch are."""
    if not np.isfinite(matrix).all():
        return np.full(len(load), np.nan)
    try:
        return np.asarray(np.linalg.solve(matrix, load[:, None])[:, 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.asarray(np.linalg.lstsq(matrix, load)[0], dtype=np.float64)


class ConstrainedFactor(StackFactor):
    """Symmetric matrices (m, n, n) whose last rows are constraints, by eigenvalues; redundant constraints drop out.

    Its one pivot is positive where the matrix is positive definite on what the constraints leave free: it then has as
    many negative eigenvalues as constraints that are independent.
    """

    def __init__(self, matrix: Array, constraints: int) -> None:
        matrix = 0.5 * (matrix + np.swapaxes(matrix, -1, -2))
        size = matrix.shape[-1] - constraints
        diagonal = np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)[:, :size])
        root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        rows = np.sqrt(((matrix[:, size:, :size] * root[:, None]) ** 2).sum(axis=-1))
        root = np.concatenate([root, 1.0 / np.where(rows > 0.0, rows, 1.0)], axis=1)
        values, vectors = np.linalg.eigh(matrix * root[:, :, None] * root[:, None, :])
        self.spectrum, self.zero = Spectrum(root, values, vectors), np.abs(values) <= _REDUNDANT
        spare = self.zero.sum(axis=1)
        independent = ((values < 0.0) & ~self.zero).sum(axis=1)
        self.pivots = np.where(independent == constraints - spare, 1.0, -1.0)[None]

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m)."""
        inverse = np.where(self.zero, 0.0, 1.0 / np.where(self.zero, 1.0, self.spectrum.values))
        return self.spectrum.summed(self.spectrum.share(load) * inverse)


class LargeFactor(StackFactor):
    """SuperLU in symmetric mode, matrix by matrix."""

    def __init__(self, order: SymbolicFactorisation, values: Array) -> None:
        self.order = order
        self.factors = []
        self.pivots = np.empty((order.size, values.shape[-1]))
        shape = (order.size, order.size)
        for entry, column in enumerate(values[order.inside].T):
            matrix = scipy.sparse.csc_matrix((column, (order.rows, order.columns)), shape=shape)
            twice = matrix + matrix.T
            matrix = scipy.sparse.csc_matrix(
                twice - scipy.sparse.diags(matrix.diagonal()) if order.half else 0.5 * twice
            )
            diagonal = np.abs(matrix.diagonal())
            scale = np.where(diagonal > 0.0, diagonal, 1.0)
            factor = symmetric_lu(matrix)
            self.pivots[:, entry] = 0.0 if factor is None else factor.U.diagonal() / scale[np.argsort(factor.perm_c)]
            self.factors.append(factor)

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m)."""
        nothing = np.full(len(load), np.nan)
        found = [
            nothing if factor is None else factor.solve(column)
            for factor, column in zip(self.factors, load.T, strict=True)
        ]
        return np.stack(found, axis=-1)
