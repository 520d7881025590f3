"""Linear equations of equilibrium at many poses: uncoupled blocks, determinate or not, singular or not."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.cache import PATTERNS

Bools = NDArray[np.bool_]
Block = tuple[NDArray[np.int64], NDArray[np.int64]]

# Coefficients below this, which are dimensionless and of the order of one, count as zero, as do loads below this share
# of the largest.
ZERO = 1e-12
# Above this condition number equations count as dependent.
DEPENDENT = 1e11
# Largest residual of equilibrium, as a share of the loads.
MISSED = 1e-8
# Rounding error of a sum, as a share of the largest unknown.
ROUNDING = 1e-13
# Numbers in one stack of matrices, few enough for the processor's cache.
CHUNK = 1 << 18


@dataclass(frozen=True)
class PoseSolutions:
    """Solutions of n poses.

    Attributes
    ----------
    values
        Unknowns, (n, k); NaN where no solution exists.
    unique
        Whether the solution is the only one, (n,).
    lost
        Whether there is no solution, (n,).
    moving
        Whether the idle degrees of freedom accelerate, (n,).
    """

    values: Array
    unique: Bools
    lost: Bools
    moving: Bools


@dataclass(frozen=True)
class IdleMotions:
    """Idle degrees of freedom, such as the spin of a rod between two spherical joints.

    Attributes
    ----------
    count
        Number of idle degrees of freedom.
    inertia
        Mass matrices of the links, in the units of the equations, (n, m, m); None if `count` is zero.
    """

    count: int = 0
    inertia: Array | None = None

    def cut(self, entries: slice | Bools, rows: NDArray[np.int64] | None = None) -> IdleMotions:
        """Idle motions at some of the poses, for some of the equations (all if `rows` is None)."""
        if self.inertia is None:
            return self
        own = self.inertia[entries]
        return IdleMotions(self.count, own if rows is None else own[:, rows[:, None], rows])


def solved(matrices: Callable[[slice], Array], columns: int, side: Array, idle: IdleMotions) -> PoseSolutions:
    """Solve ``matrix x = side`` at every pose; among several solutions, take the one with the least sum of squares.

    Uncoupled blocks of equations are solved separately, and unloaded blocks not at all, so that only the planar
    equations of a planar linkage are solved. Unbalanced loads accelerate the idle degrees of freedom.

    Parameters
    ----------
    matrices
        Function that returns the matrices (..., m, k) of a slice of the n poses, so that they are never all in memory.
    columns
        Number of unknowns, k.
    side
        Right-hand sides, (n, m).
    idle
        The linkage's idle degrees of freedom.
    """
    count, rows = side.shape
    step = max(1, CHUNK // max(rows * columns, 1))
    cuts = [slice(at, at + step) for at in range(0, max(count, 1), step)]
    parts = [_solved(matrices(cut), side[cut], idle.cut(cut)) for cut in cuts]
    return PoseSolutions(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in ("values", "unique", "lost", "moving"))
    )


def without_self_stress(matrices: Callable[[slice], Array], side: Array, elastic: Bools) -> Bools:
    """Poses without self-stress in the rigid parts alone, (n,): there compliance determines how loads are shared.

    The columns of the rigid unknowns must be linearly independent in each loaded block.

    Parameters
    ----------
    matrices, side
        As for `solved`.
    elastic
        Unknowns whose forces strain something, (k,).
    """
    count, rows = side.shape
    step = max(1, CHUNK // max(rows * len(elastic), 1))
    out = np.ones(count, dtype=bool)
    for at in range(0, count, step):
        cut = slice(at, at + step)
        matrix, given = matrices(cut), np.abs(side[cut])
        for poses, used in _patterns(np.asarray(np.abs(matrix) > ZERO)):
            out[cut][poses] = _independent(matrix[poses], given[poses], elastic, used)
    return out


def _independent(matrix: Array, given: Array, elastic: Bools, used: Bools) -> Bools:
    """The same for poses with one pattern of nonzero coefficients, `used` (m, k)."""
    out = np.ones(len(matrix), dtype=bool)
    least = ZERO * given.max(axis=-1, initial=0.0)
    for rows, unknowns in blocks(used):
        rigid = unknowns[~elastic[unknowns]]
        if len(rigid):
            size = np.linalg.svd(matrix[:, rows[:, None], rigid], compute_uv=False)
            independent = (size * DEPENDENT > size[:, :1]).sum(axis=-1) == len(rigid)
            out &= independent | (given[:, rows].max(axis=-1) <= least)
    return out


def _solved(matrix: Array, side: Array, idle: IdleMotions) -> PoseSolutions:
    """Solutions by groups of poses with the same nonzero coefficients, as the uncoupled blocks follow from these."""
    parts = _patterns(np.asarray(np.abs(matrix) > ZERO))
    if len(parts) == 1:
        return _alike(matrix, side, idle, parts[0][1])
    out = PoseSolutions(np.empty((len(matrix), matrix.shape[-1])), *np.empty((3, len(matrix)), dtype=bool))
    for at, used in parts:
        part = _alike(matrix[at], side[at], idle.cut(at), used)
        for name in ("values", "unique", "lost", "moving"):
            getattr(out, name)[at] = getattr(part, name)
    return out


def _patterns(used: Bools) -> list[tuple[Bools, Bools]]:
    """Groups of poses, (n,), with the same pattern in `used` (n, m, k), and that pattern, (m, k)."""
    whole = np.asarray(used.any(axis=0))
    if not (used.sum(axis=(-2, -1)) < whole.sum()).any():
        return [(np.ones(len(used), dtype=bool), whole)]
    patterns = np.packbits(used.reshape(len(used), -1), axis=-1)
    _, first, which = np.unique(patterns, axis=0, return_index=True, return_inverse=True)
    return [(which.reshape(-1) == number, used[pose]) for number, pose in enumerate(first.tolist())]


def _alike(matrix: Array, side: Array, idle: IdleMotions, used: Bools) -> PoseSolutions:
    """Solutions at poses with one pattern of nonzero coefficients, `used` (m, k)."""
    values = np.zeros((len(matrix), matrix.shape[-1]))
    unique = np.ones(len(matrix), dtype=bool)
    lost, moving = np.zeros((2, len(matrix)), dtype=bool)
    loads = np.max(np.abs(side), axis=-1, initial=0.0)
    for rows, columns in blocks(used):
        own = side[:, rows]
        loaded = np.max(np.abs(own), axis=-1, initial=0.0) > ZERO * loads
        if loaded.any():
            block = matrix[loaded][:, rows[:, None], columns]
            part = _least(block, own[loaded], loads[loaded], idle.cut(loaded, rows))
            values[np.ix_(loaded, columns)] = part.values
            unique[loaded] &= part.unique
            moving[loaded] |= part.moving
            lost[loaded] |= part.lost
    if moving.any():
        # with more free motions than elsewhere the pose is singular, and what moves there is not idle
        lost[moving] |= _freedom(matrix[moving]) > idle.count
    values[lost] = np.nan
    return PoseSolutions(values, unique, lost, moving)


def blocks(used: Bools) -> list[Block]:
    """Rows and columns of the uncoupled blocks of matrices with the nonzero coefficients `used`, (m, k)."""
    return PATTERNS.found(("blocks", used.shape, used.tobytes()), lambda: _blocks(used), used.size)  # type: ignore[no-any-return]


def _blocks(used: Bools) -> list[Block]:
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    rows, columns = used.shape
    i, j = np.nonzero(used)
    graph = coo_array((np.ones(len(i)), (i, rows + j)), shape=(rows + columns,) * 2)
    _, label = connected_components(graph, directed=False)
    return [
        (np.flatnonzero(label[:rows] == name), np.flatnonzero(label[rows:] == name)) for name in np.unique(label[:rows])
    ]


def _least(matrix: Array, side: Array, loads: Array, idle: IdleMotions) -> PoseSolutions:
    """Solution of least norm of one block at every pose."""
    _, rows, columns = matrix.shape
    values, unique = np.zeros((len(matrix), columns)), np.ones(len(matrix), dtype=bool)
    if columns:
        values, regular = _full_rank(matrix, side)
        unique = regular & (rows >= columns)
        if not regular.all():
            values[~regular], unique[~regular] = _by_singular_values(matrix[~regular], side[~regular])
    lost, moving = _misses(matrix, values, side, loads), np.zeros(len(matrix), dtype=bool)
    if lost.any() and idle.inertia is not None:
        own = idle.inertia[lost], idle.count
        values[lost], moving[lost] = _moving(matrix[lost], side[lost], loads[lost], *own)
    return PoseSolutions(values, unique, lost & ~moving, moving)


def _misses(matrix: Array, values: Array, side: Array, loads: Array) -> Bools:
    """Poses whose residual is more than rounding, (n,)."""
    missed = np.max(np.abs((matrix @ values[..., None])[..., 0] - side), axis=-1, initial=0.0)
    rounding = ROUNDING * np.max(np.abs(values), axis=-1, initial=0.0)
    return np.asarray(~(missed <= MISSED * loads + rounding))


def _moving(matrix: Array, side: Array, loads: Array, inertia: Array, count: int) -> tuple[Array, Bools]:
    """Solution with the accelerations of the idle degrees of freedom as further unknowns, and whether there is one.

    Idle motions are the left null space of the matrix: those on which no unknown does work.
    """
    rows, columns = matrix.shape[-2:]
    left, size, _ = np.linalg.svd(matrix)
    null = np.ones((len(matrix), rows))
    null[:, : size.shape[-1]] = size * DEPENDENT <= size[:, :1]
    motions = (left * null[:, None, :])[..., rows - min(rows, count) :]
    whole = np.concatenate([matrix, -inertia @ motions], axis=-1)
    values, _ = _by_singular_values(whole, side)
    return values[:, :columns], ~_misses(whole, values, side, loads)


def _freedom(matrix: Array) -> NDArray[np.int64]:
    """Number of motions on which no unknown does work, (n,)."""
    size = np.linalg.svd(matrix, compute_uv=False)
    return np.asarray(matrix.shape[-2] - (size * DEPENDENT > size[:, :1]).sum(axis=-1))


def _full_rank(matrix: Array, side: Array) -> tuple[Array, Bools]:
    """Solution by QR, a least-squares or least-norm one, valid where the rank is full; and whether it is full, (n,)."""
    rows, columns = matrix.shape[-2:]
    if rows == columns:
        return _square(matrix, side)
    tall = rows >= columns
    q, r = np.linalg.qr(matrix if tall else np.swapaxes(matrix, -1, -2))
    diagonal = np.abs(np.diagonal(r, axis1=-2, axis2=-1))
    regular = diagonal.min(axis=-1) * DEPENDENT > diagonal.max(axis=-1)
    r = np.where(regular[:, None, None], r, np.eye(r.shape[-1]))
    given = (np.swapaxes(q, -1, -2) @ side[..., None])[..., 0] if tall else side
    found, well_conditioned = _probed(r if tall else np.swapaxes(r, -1, -2), given)
    return found if tall else (q @ found[..., None])[..., 0], regular & well_conditioned


def _square(matrix: Array, side: Array) -> tuple[Array, Bools]:
    """The same for square matrices, by LU."""
    try:
        return _probed(matrix, side)
    except np.linalg.LinAlgError:
        singular = np.linalg.slogdet(matrix)[0] == 0.0
    found, regular = _probed(np.where(singular[:, None, None], np.eye(matrix.shape[-1]), matrix), side)
    return found, regular & ~singular


def _probed(matrix: Array, side: Array) -> tuple[Array, Bools]:
    """Solution of square equations, and whether they are regular: else the solution of a random right side is huge."""
    probe = np.broadcast_to(np.random.default_rng(0).normal(size=matrix.shape[-1]), side.shape)
    found = np.linalg.solve(matrix, np.stack([side, probe], axis=-1))
    size = np.max(np.abs(matrix), axis=(-2, -1))
    return found[..., 0], np.max(np.abs(found[..., 1]), axis=-1) * size < DEPENDENT


def _by_singular_values(matrix: Array, side: Array) -> tuple[Array, Bools]:
    """Least-norm solution by singular values, and whether it is the only one."""
    left, size, right = np.linalg.svd(matrix, full_matrices=False)
    kept = size * DEPENDENT > size[:, :1]
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=kept)
    parts = inverse * (np.swapaxes(left, -1, -2) @ side[..., None])[..., 0]
    values: Array = (np.swapaxes(right, -1, -2) @ parts[..., None])[..., 0]
    return values, kept.sum(axis=-1) == matrix.shape[-1]
