"""Linear equations of equilibrium at many poses: uncoupled blocks, determinate or not, singular or not."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .coefficients import Coefficients, EquationBlock, blocks, substituted

Bools = NDArray[np.bool_]

# Coefficients below this, which are dimensionless and of the order of one, count as zero, as do loads below this share
# of the largest.
ZERO = 1e-12
# Above this condition number equations count as dependent.
DEPENDENT = 1e11
# Largest residual of equilibrium, as a share of the loads.
MISSED = 1e-8
# Rounding error of a sum, as a share of the largest unknown.
ROUNDING = 1e-13
# Coefficients of as many poses as are solved together, few enough for the processor's cache, and their least number.
CHUNK, FEWEST = 1 << 18, 64


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


def solved(coefficients: Callable[[slice], Coefficients], side: Array, idle: IdleMotions) -> PoseSolutions:
    """Solve the equations at every pose; among several solutions, take the one with the least sum of squares.

    Uncoupled blocks of equations are solved separately, and unloaded blocks not at all, so that only the planar
    equations of a planar linkage are solved. Large blocks are solved part by part, where they come apart: the forces of
    an open chain from its tip to the ground. Unbalanced loads accelerate the idle degrees of freedom.

    Parameters
    ----------
    coefficients
        Function that returns the coefficients of a slice of the n poses, so that they are never all in memory.
    side
        Right-hand sides, (n, m).
    idle
        The linkage's idle degrees of freedom.
    """
    parts = [_solved(own, side[cut], idle.cut(cut)) for cut, own in _chunks(coefficients, len(side))]
    return PoseSolutions(
        *(np.concatenate([getattr(p, name) for p in parts]) for name in ("values", "unique", "lost", "moving"))
    )


def _chunks(coefficients: Callable[[slice], Coefficients], count: int) -> Iterator[tuple[slice, Coefficients]]:
    """Slices of `count` poses with their coefficients."""
    at, step = 0, FEWEST
    while at < max(count, 1):
        own = coefficients(slice(at, at + step))
        yield slice(at, at + step), own
        at, step = at + step, max(FEWEST, CHUNK // max(own.values.shape[-1], 1))


def without_self_stress(coefficients: Callable[[slice], Coefficients], side: Array, elastic: Bools) -> Bools:
    """Poses without self-stress in the rigid parts alone, (n,): there compliance determines how loads are shared.

    The columns of the rigid unknowns must be linearly independent in each loaded block.

    Parameters
    ----------
    coefficients, side
        As for `solved`.
    elastic
        Unknowns whose forces strain something, (k,).
    """
    out = np.ones(len(side), dtype=bool)
    for cut, given in _chunks(coefficients, len(side)):
        loads = np.abs(side[cut])
        for poses, used in _patterns(np.asarray(np.abs(given.values) > ZERO)):
            out[cut][poses] = _independent(given, poses, loads[poses], elastic, used)
    return out


def _independent(coefficients: Coefficients, poses: Bools, given: Array, elastic: Bools, used: Bools) -> Bools:
    """The same for those poses, of one pattern of nonzero coefficients, `used` (e,)."""
    out = np.ones(len(given), dtype=bool)
    least = ZERO * given.max(axis=-1, initial=0.0)
    for block in _blocks_of(coefficients, used):
        rigid = ~elastic[block.columns]
        if rigid.any():
            size = np.linalg.svd(coefficients.of(block, poses).matrix(rigid), compute_uv=False)
            independent = (size * DEPENDENT > size[:, :1]).sum(axis=-1) == rigid.sum()
            out &= independent | (given[:, block.rows].max(axis=-1) <= least)
    return out


def _solved(coefficients: Coefficients, side: Array, idle: IdleMotions) -> PoseSolutions:
    """Solutions by groups of poses with the same nonzero coefficients, as the uncoupled blocks follow from these."""
    parts = _patterns(np.asarray(np.abs(coefficients.values) > ZERO))
    if len(parts) == 1:
        return _alike(coefficients, side, idle, parts[0][1])
    out = PoseSolutions(np.empty((len(side), coefficients.shape[1])), *np.empty((3, len(side)), dtype=bool))
    for at, used in parts:
        part = _alike(coefficients.at(at), side[at], idle.cut(at), used)
        for name in ("values", "unique", "lost", "moving"):
            getattr(out, name)[at] = getattr(part, name)
    return out


def _patterns(used: Bools) -> list[tuple[Bools, Bools]]:
    """Groups of poses, (n,), with the same pattern in `used` (n, e), and that pattern, (e,)."""
    whole = np.asarray(used.any(axis=0))
    if not (used.sum(axis=-1) < whole.sum()).any():
        return [(np.ones(len(used), dtype=bool), whole)]
    patterns = np.packbits(used, axis=-1)
    _, first, which = np.unique(patterns, axis=0, return_index=True, return_inverse=True)
    return [(which.reshape(-1) == number, used[pose]) for number, pose in enumerate(first.tolist())]


def _alike(coefficients: Coefficients, side: Array, idle: IdleMotions, used: Bools) -> PoseSolutions:
    """Solutions at poses with one pattern of nonzero coefficients, `used` (e,)."""
    values = np.zeros((len(side), coefficients.shape[1]))
    unique = np.ones(len(side), dtype=bool)
    lost, moving = np.zeros((2, len(side)), dtype=bool)
    loads = np.max(np.abs(side), axis=-1, initial=0.0)
    for block in _blocks_of(coefficients, used):
        own = side[:, block.rows]
        loaded = np.max(np.abs(own), axis=-1, initial=0.0) > ZERO * loads
        if loaded.any():
            given = coefficients.of(block, loaded)
            part = _least(given, block, own[loaded], loads[loaded], idle.cut(loaded, block.rows))
            values[np.ix_(loaded, block.columns)] = part.values
            unique[loaded] &= part.unique
            moving[loaded] |= part.moving
            lost[loaded] |= part.lost
    if moving.any():
        # with more free motions than elsewhere the pose is singular, and what moves there is not idle
        lost[moving] |= _freedom(coefficients.at(moving).matrix()) > idle.count
    values[lost] = np.nan
    return PoseSolutions(values, unique, lost, moving)


def _blocks_of(coefficients: Coefficients, used: Bools) -> list[EquationBlock]:
    return blocks(coefficients.rows, coefficients.columns, coefficients.shape, used)


def _least(given: Coefficients, block: EquationBlock, side: Array, loads: Array, idle: IdleMotions) -> PoseSolutions:
    """Solution of least norm of one block at every pose."""
    rows, columns = given.shape
    whole = np.zeros((0, 0, 0)) if block.stages else given.matrix()
    values, unique = np.zeros((len(side), columns)), np.ones(len(side), dtype=bool)
    if columns:
        values, regular = _by_stages(given, block, side) if block.stages else _full_rank(whole, side)
        unique = regular & (rows >= columns)
        if not regular.all():
            singular = given.at(~regular).matrix()
            values[~regular], unique[~regular] = _by_singular_values(singular, side[~regular])
    left = given.times(values) if block.stages else (whole @ values[..., None])[..., 0]
    lost, moving = _misses(left, values, side, loads), np.zeros(len(side), dtype=bool)
    if lost.any() and idle.inertia is not None:
        own = idle.inertia[lost], idle.count
        values[lost], moving[lost] = _moving(given.at(lost).matrix(), side[lost], loads[lost], *own)
    return PoseSolutions(values, unique, lost & ~moving, moving)


def _by_stages(given: Coefficients, block: EquationBlock, side: Array) -> tuple[Array, Bools]:
    """Solution of square equations part by part, and whether they are regular."""
    with np.errstate(over="ignore", invalid="ignore"):  # next to singular poses
        found, regular = substituted(given, block.stages, _beside_probe(side))
    return found[..., 0], regular & _is_regular(found[..., 1], np.max(np.abs(given.values), axis=-1))


def _misses(left: Array, values: Array, side: Array, loads: Array) -> Bools:
    """Poses where the residual of the left-hand sides (n, m) is more than rounding, (n,)."""
    missed = np.max(np.abs(left - side), axis=-1, initial=0.0)
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
    return values[:, :columns], ~_misses((whole @ values[..., None])[..., 0], values, side, loads)


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
    """Solution of square equations, and whether they are regular."""
    found = np.asarray(np.linalg.solve(matrix, _beside_probe(side)), dtype=np.float64)
    return found[..., 0], _is_regular(found[..., 1], np.max(np.abs(matrix), axis=(-2, -1)))


def _beside_probe(side: Array) -> Array:
    """Right sides (n, m, 2) with a random one beside each."""
    probe = np.broadcast_to(np.random.default_rng(0).normal(size=side.shape[-1]), side.shape)
    return np.stack([side, probe], axis=-1)


def _is_regular(probed: Array, size: Array) -> Bools:
    """Whether equations with coefficients up to `size` are regular: else the solution of a random side is huge."""
    return np.asarray(np.max(np.abs(probed), axis=-1) * size < DEPENDENT)


def _by_singular_values(matrix: Array, side: Array) -> tuple[Array, Bools]:
    """Least-norm solution by singular values, and whether it is the only one."""
    left, size, right = np.linalg.svd(matrix, full_matrices=False)
    kept = size * DEPENDENT > size[:, :1]
    inverse = np.divide(1.0, size, out=np.zeros_like(size), where=kept)
    parts = inverse * (np.swapaxes(left, -1, -2) @ side[..., None])[..., 0]
    values: Array = (np.swapaxes(right, -1, -2) @ parts[..., None])[..., 0]
    return values, kept.sum(axis=-1) == matrix.shape[-1]
