"""Natural frequencies and mode shapes."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.idle import released_masses
from ..batched.plan import Plan
from ..described.released_ends import with_hinges
from ..description import Description
from ..errors import FrameError, MechanismWarning
from ..joint_examination import require_springs
from ..solvers.sparse import SparseSolver
from . import dense
from .shapes import Shapes, check_count_of
from .sparse_spectrum import SparsePencil
from .spectrum import (
    DENSE,
    OF_FRAME,
    AskedModes,
    above_rounding,
    found_anew,
    inverse_pencil,
    shifted,
    stiffness_halves,
    surely_stiff,
)

# Scaled eigenvalues below this belong to rigid-body motions and mechanisms, unless the deformations show otherwise.
_REGULAR = 1e-12
# A singular stiffness is shifted, K + shift M. The shift is lowered to the first elastic mode in this many steps.
_NARROWINGS = 4
# Number of restarts of the iteration in these steps, where the frame is large: a rough eigenvalue is enough.
_CRUDE = 2
# Squared frequencies below this fraction of the shift are zero.
_NOISE = 1e-6
# Eigenvalues of a large frame below this many roundings of the greatest are nothing but rounding.
_LOST = 16


@dataclass(frozen=True, eq=False)
class Modes(Shapes):
    """Natural modes of a frame, the lowest frequency first; rigid-body modes and mechanisms have frequency zero.

    Their `shapes` have unit modal mass.

    Attributes
    ----------
    frequencies
        Natural frequencies in Hz, (..., count).

    Examples
    --------
    A clamped rod of 1 m: bending in both planes alike, at ``3.516 / (2 pi) sqrt(E I / m L^4)`` (Timoshenko, *Vibration
    Problems in Engineering*).

    >>> from linkframe.elements import Beam, Circle, Material
    >>> from linkframe.framework import Frame
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 1.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7850.0), segments=8), "A", "B")
    >>> frame.fix("A")
    >>> modes = frame.modes(2)
    >>> modes.frequencies.round(2).tolist()
    [14.12, 14.12]
    >>> modes.shapes("B").shape
    (2, 6)
    """

    frequencies: Array


def modes(frame: Description, count: int, asked: AskedModes = OF_FRAME) -> Modes:
    """The `count` lowest modes of ``K x = omega^2 M x`` for every batch entry.

    Parameters
    ----------
    frame
        The frame.
    count
        How many.
    asked
        By what they were asked for, as messages say it.

    Raises
    ------
    FrameError
        Where the frame has no mass at a batch entry, or fewer modes than asked for.
    """
    require_springs({name: joint.element for name, joint in frame.joints.items()})
    plan = Plan(with_hinges(released_masses(frame)).copy(), cut=True)
    check_count_of(asked.verb, count, plan)
    way = _sparse if plan.large and len(plan.unknowns) > DENSE else _dense
    squared, vectors = way(plan, count, asked)
    frequencies = np.sqrt(squared) / (2.0 * np.pi)
    shape = np.broadcast_shapes(frame.shape, frequencies.shape[:-1])
    out = np.array(np.broadcast_to(frequencies, (*shape, count)))
    if frame.absent is not None:
        out[np.broadcast_to(frame.absent, shape)] = np.nan
    return Modes(out, _plan=plan, _vectors=vectors)


def _dense(plan: Plan, count: int, asked: AskedModes) -> tuple[Array, Array]:
    stiffness, mass = dense.resisting(plan, pushed=True), dense.mass(plan)
    asked.require_mass(np.any(mass, axis=(-2, -1)), plan.frame.absent)
    if plan.frame.absent is not None:  # entries that are left out may have no mass, or too few modes
        left_out = plan.frame.absent[..., None, None]
        stiffness, mass = (np.where(left_out, np.eye(matrix.shape[-1]), matrix) for matrix in (stiffness, mass))
    least = np.linalg.eigvalsh(dense.scaled(stiffness)[0])[..., 0]
    unstable = least < -_REGULAR
    eye = np.eye(stiffness.shape[-1])
    if unstable.any():
        concerned = unstable if plan.frame.absent is None else unstable & ~plan.frame.absent
        if concerned.any():
            warnings.warn(_unstable(concerned), MechanismWarning, stacklevel=4)
        stiffness = np.where(unstable[..., None, None], eye, stiffness)
    singular = (least <= _REGULAR) & ~unstable
    shift = _shift(stiffness, mass, singular)
    half, root = _halves(plan, stiffness, mass, shift)
    half = np.where(unstable[..., None, None], eye, half)
    if plan.frame.absent is not None:
        half, root = np.where(left_out, eye, half), np.where(left_out[..., 0], 1.0, root)
    values, vectors = inverse_pencil(half, root, mass, count)
    values = above_rounding(values)
    squared = _elastic(1.0 / values - shift[..., None], shift[..., None])
    vectors = vectors / np.sqrt(values)[..., None, :]
    if singular.any():
        own = (np.diagonal(stiffness, axis1=-2, axis2=-1) > 0.0).all(axis=-1)
        soft = (squared == 0.0) & (singular & own & surely_stiff(plan))[..., None]
        squared, vectors = _soft(plan, mass, soft, squared, vectors)
    squared, vectors = found_anew(
        stiffness, mass, np.maximum(shift, squared[..., 0]), squared, vectors, asked.number(count)
    )
    squared[np.broadcast_to(unstable, squared.shape[:-1])] = np.nan
    return squared, vectors


def _soft(plan: Plan, mass: Array, soft: NDArray[np.bool_], squared: Array, vectors: Array) -> tuple[Array, Array]:
    """Compute anew the modes `soft`, whose stiffness is lost in the rounding of K, from the springs and deformations,
    in which it is not lost.
    """
    if not soft.any():
        return squared, vectors
    alone = np.asarray(soft.any(axis=-1))[..., None, None]
    half, root = stiffness_halves(plan)
    half = np.where(alone, half, np.eye(half.shape[-1]))
    values, shapes = inverse_pencil(half, root, mass, soft.shape[-1])
    values = np.where(soft, values, 1.0)
    shapes = shapes / np.sqrt(values)[..., None, :]
    return np.where(soft, 1.0 / values, squared), np.where(soft[..., None, :], shapes, vectors)


def _unstable(where: NDArray[np.bool_]) -> str:
    first = f", the first {np.argwhere(where)[0].tolist()}," if where.ndim else ""
    return (
        f"{where.sum()} of {where.size} batch entries{first} are unstable by the preload of their springs, "
        "and their frequencies are NaN"
    )


def _sparse(plan: Plan, count: int, asked: AskedModes) -> tuple[Array, Array]:
    solver = SparseSolver(plan)
    asked.require_mass(np.asarray(solver.mass.nnz > 0), None)
    shift = 0.0
    if solver.singular(excited=True).any() or solver.singular(excited=False).any():
        shift = float(solver.stiffness.diagonal().sum() / solver.mass.diagonal().sum())
        for _ in range(_NARROWINGS):
            squared = 1.0 / SparsePencil(solver, shift).greatest(solver.mass, count + 6, _CRUDE)[0] - shift
            shift = min([shift, *squared[squared > _NOISE * shift]])
    values, vectors = SparsePencil(solver, shift).greatest(solver.mass, count)
    if np.any(values <= _LOST * np.finfo(float).eps * values[0]):
        raise FrameError(
            f"{asked.number(count)} has fewer modes with mass, or modes so far apart that rounding hides the "
            "highest: ask for fewer"
        )
    return _elastic(1.0 / values - shift, np.asarray(shift)), vectors / np.sqrt(values)


def _elastic(squared: Array, shift: Array) -> Array:
    """Squared frequencies that were found with a shift, with zero in place of the rounding left at free motions."""
    return np.where(squared > _NOISE * shift, np.maximum(squared, 0.0), 0.0)


def _halves(plan: Plan, stiffness: Array, mass: Array, shift: Array) -> tuple[Array, Array]:
    """L of ``D (K + shift M) D = L L^T``, (..., n, n), and the diagonal of D, (..., n).

    Entries with zero shift are factorised from the springs, which is most precise, whatever the shifts of others.
    """
    if not shift.any():
        return stiffness_halves(plan)
    moved, moved_root = shifted(stiffness, mass, shift)
    if shift.all():
        return moved, moved_root
    half, root = stiffness_halves(plan)
    at = shift[..., None] > 0.0
    return np.where(at[..., None], moved, half), np.where(at, moved_root, root)


def _shift(stiffness: Array, mass: Array, singular: NDArray[np.bool_]) -> Array:
    """Shift for each entry, (...): zero where K is regular, else about the least squared frequency above zero."""
    shape = np.broadcast_shapes(stiffness.shape[:-2], mass.shape[:-2])
    singular = np.broadcast_to(singular, shape)
    if not singular.any():
        return np.zeros(shape)
    stiff, heavy = (np.trace(matrix, axis1=-2, axis2=-1) for matrix in (stiffness, mass))
    # Without any stiffness, or any mass, any shift will do.
    some = (stiff > 0.0) & (heavy > 0.0)
    shift = np.where(some, stiff / np.where(some, heavy, 1.0), 1.0)
    shift = np.array(np.broadcast_to(shift, shape))
    for _ in range(_NARROWINGS):
        size = stiffness.shape[-1]
        values, _ = inverse_pencil(*shifted(stiffness, mass, shift), mass, size)
        with np.errstate(divide="ignore"):
            squared = np.where(values > 0.0, 1.0 / np.where(values > 0.0, values, 1.0), np.inf) - shift[..., None]
        elastic = np.where(squared > _NOISE * shift[..., None], squared, np.inf).min(axis=-1)
        shift = np.minimum(shift, elastic)
    return np.where(singular, shift, 0.0)
