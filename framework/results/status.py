"""Mechanisms: the entries at which the stiffness is singular, and their free motions in words."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..dofs import DISPLACEMENTS
from ..entries import Entries
from ..solvers.evaluation import Picked
from ..solvers.rounding import zero_eigenvalue
from ..solvers.sparse import SparseSolver
from ..solvers.stacked_bands import Bands
from ..structure.topology import Index
from . import dense
from .spectrum import DENSE

# Displacements below this share of the largest are not named, and at most _MOST nodes are.
_NAMED = 0.05
_MOST = 6
# Above this many unknowns, if dense matrices of the frame would have more than _DENSE numbers, banded factors are used.
_FEW, _DENSE = 60, 2**23
# Size of the bands that are in memory at a time.
_ROOM = 2**22


def is_singular(plan: Plan, suspects: NDArray[np.bool_], unknowns: set[int]) -> NDArray[np.bool_]:
    """Mask of the `suspects` whose stiffness over `unknowns` has a zero eigenvalue, (...) of the batch shape."""
    out = np.zeros(suspects.shape, dtype=bool)
    index = np.nonzero(np.atleast_1d(suspects)) if suspects.ndim else ()
    kept = [k for k, unknown in enumerate(plan.unknowns) if unknown in unknowns]
    if not suspects.any():
        return out
    if len(kept) > DENSE or (len(kept) > _FEW and suspects.sum() * len(plan.unknowns) ** 2 > _DENSE):
        out[suspects] = _by_bands(plan, index, kept)
        return out
    entries = Entries(index or None)
    matrix = dense.resisting(plan, entries)[..., kept, :][..., :, kept]
    values = np.linalg.eigvalsh(dense.scaled(matrix)[0])
    out[suspects] = _zero(plan, values).any(axis=-1)
    return out


def _zero(plan: Plan, values: NDArray[Any]) -> NDArray[np.bool_]:
    """Mask of the eigenvalues of the scaled stiffness that are zero to rounding, (..., n).

    A negative one is rounding, except if springs have a negative stiffness by a preload: then the frame is unstable.
    """
    pushed = any((group.element.springs(group.length)[0] < 0.0).any() for group in plan.topology.groups)
    return np.asarray((np.abs(values) if pushed else values) <= zero_eigenvalue(values.shape[-1]))


def _by_bands(plan: Plan, index: tuple[Index, ...], kept: list[int]) -> NDArray[np.bool_]:
    """Mask (m,) of the entries that are singular over the unknowns `kept`, by inverse iteration with bands."""
    where = np.zeros(len(plan.unknowns), dtype=bool)
    where[kept] = True
    bands = Bands(plan.coupling, where, plan.graph.order(plan.graph.band, where))
    step = max(1, _ROOM // (bands.size * bands.width))
    count, found = len(index[0]) if index else 1, []
    with np.errstate(all="ignore"):
        for start in range(0, count, step):
            factor = bands.factorised(Picked(plan.frame.shape, tuple(each[start : start + step] for each in index)))
            growth = factor.probed(np.arange(factor.count))
            found.append(~(1.0 / growth > zero_eigenvalue(bands.size)))
    return np.concatenate(found)


def free_motions(plan: Plan, entry: tuple[int, ...]) -> Array:
    """Displacements of the described nodes in the free motions at a batch entry, global, (motions, nodes, 6)."""
    entries = Entries(tuple(np.array([k]) for k in entry) or None)
    nodes = [plan.topology.number[name] for name in plan.frame.nodes]
    if plan.large and len(plan.unknowns) > DENSE:
        solver = SparseSolver(plan)
        shapes = solver.motions()
        change: Array | scipy.sparse.csr_matrix = solver.matrices.global_substitution(nodes)
    else:
        matrix, root = dense.scaled(_only(dense.resisting(plan, entries)))
        values, vectors = np.linalg.eigh(matrix)
        shapes = root[:, None] * vectors[:, _zero(plan, values)]
        change = _only(dense.global_substitution(plan, nodes, entries))
    motions: Array = np.asarray(change @ shapes).T.reshape(shapes.shape[1], len(nodes), 6)
    return motions


def describe(plan: Plan, entry: tuple[int, ...]) -> str:
    """The free motions of a batch entry in words: for each a list of nodes and directions."""
    names = list(plan.frame.nodes)
    size = length_scale(plan, entry)
    sentences = []
    for motion in free_motions(plan, entry):
        weighted = motion * np.array([1.0, 1.0, 1.0, size, size, size])
        largest = np.abs(weighted).max(axis=-1)
        leading = [k for k in np.argsort(-largest, kind="stable") if largest[k] > _NAMED * largest.max()]
        text = [f"{names[k]} ({_direction(weighted[k], float(largest.max()))})" for k in leading[:_MOST]]
        more = f" and {len(leading) - _MOST} more" if len(leading) > _MOST else ""
        sentences.append(", ".join(text) + more)
    return "; ".join(f"free motion {i + 1}: {text}" for i, text in enumerate(sentences))


def _direction(weighted: Array, largest: float) -> str:
    return " ".join(
        f"{'+' if value > 0 else '-'}{name}"
        for name, value in zip(DISPLACEMENTS, weighted, strict=True)
        if abs(value) > _NAMED * largest
    )


def length_scale(plan: Plan, entry: tuple[int, ...]) -> float:
    """Length of the longest member at a batch entry."""
    frame = plan.frame
    lengths = [float(np.broadcast_to(frame.length(member), frame.shape)[entry]) for member in frame.members]
    return max(lengths, default=1.0)


def _only(stack: Array) -> Array:
    """The matrix of a stack with a single entry."""
    matrix: Array = stack.reshape(stack.shape[-2:])
    return matrix
