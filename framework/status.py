"""Mechanisms in words: which nodes move in which direction where nothing resists."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix, diags, eye

from . import dense
from .batch import Array
from .dofs import DISPLACEMENTS
from .plan import Plan
from .sparse import SparseSolver
from .spectrum import DENSE, sparse_pencil

# Eigenvalues of the scaled stiffness below this are zero; motions below this share of the largest are not named.
_ZERO = 1e-12
_NAMED = 0.05
_MOST = 6
# Where zero eigenvalues of a large frame are looked for.
_NEAR = 1e-9


def free_motions(plan: Plan, entry: tuple[int, ...]) -> Array:
    """Displacements of the described nodes, (motions, nodes, 6), global, that cost no energy at a batch entry."""
    if plan.large and len(plan.unknowns) > DENSE:
        stiffness = SparseSolver(plan).stiffness
        root = 1.0 / np.sqrt(np.maximum(stiffness.diagonal(), np.finfo(float).tiny))
        scaled = csr_matrix(diags(root) @ stiffness @ diags(root))
        values, vectors = sparse_pencil(scaled, eye(len(root), format="csr"), _MOST, _NEAR)
    else:
        matrix, root = dense.scaled(_at(dense.stiffness(plan), entry))
        values, vectors = np.linalg.eigh(matrix)
    shapes = (root[:, None] * vectors[:, values < _ZERO * max(1.0, float(values[-1]))]).T
    nodes = [plan.topology.number[name] for name in plan.frame.nodes]
    moved = shapes @ _at(dense.global_substitution(plan, nodes), entry).T
    motions: Array = moved.reshape(len(shapes), len(nodes), 6)
    return motions


def describe(plan: Plan, entry: tuple[int, ...]) -> str:
    """Each free motion of a batch entry as a list of nodes and directions."""
    motions = free_motions(plan, entry)
    names = list(plan.frame.nodes)
    size = _size(plan)
    sentences = []
    for motion in motions:
        weighed = motion * np.array([1.0, 1.0, 1.0, size, size, size])
        largest = np.abs(weighed).max(axis=-1)
        leading = [k for k in np.argsort(-largest, kind="stable") if largest[k] > _NAMED * largest.max()]
        told = [f"{names[k]} ({_direction(weighed[k], float(largest.max()))})" for k in leading[:_MOST]]
        more = f" and {len(leading) - _MOST} more" if len(leading) > _MOST else ""
        sentences.append(", ".join(told) + more)
    return "; ".join(f"free motion {i + 1}: {text}" for i, text in enumerate(sentences))


def _direction(weighed: Array, largest: float) -> str:
    return " ".join(
        f"{'+' if value > 0 else '-'}{name}"
        for name, value in zip(DISPLACEMENTS, weighed, strict=True)
        if abs(value) > _NAMED * largest
    )


def _size(plan: Plan) -> float:
    lengths = [float(np.max(plan.frame.length(member))) for member in plan.frame.members]
    return max(lengths, default=1.0)


def _at(stack: Array, entry: tuple[int, ...]) -> Array:
    """The matrix of one batch entry from a stack whose axes may have size one."""
    axes = stack.shape[:-2]
    index = tuple(k if n > 1 else 0 for k, n in zip(entry, axes, strict=True)) if axes else ()
    matrix: Array = stack[index]
    return matrix
