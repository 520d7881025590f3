"""Whole matrices as stacks (..., n, n): for eigenvalues, condition numbers and the naming of mechanisms."""

from __future__ import annotations

import numpy as np

from .assembly import point_masses
from .batch import Array
from .parts import Row, Value
from .plan import Plan
from .topology import Group, Index


def summed(stacks: list[tuple[Index, Array]], size: int) -> Array:
    """Sum over all DOFs, (..., size, size), of matrices (n, ..., m, m) at DOF numbers (n, m)."""
    shape = np.broadcast_shapes(*(stack.shape[1:-2] for _, stack in stacks)) if stacks else ()
    out = np.zeros((*shape, size, size))
    for numbers, stack in stacks:
        for dofs, matrix in zip(numbers, stack, strict=True):
            out[..., dofs[:, None], dofs[None, :]] += matrix
    return out


def nodal(plan: Plan, stacks: list[tuple[Group, Array]]) -> Array:
    """Sum of member matrices (n, ..., 12, 12), given in the nodes' axes, over all DOFs, (..., N, N)."""
    return summed([(group.dofs, stack) for group, stack in stacks], 6 * len(plan.topology.number))


def stiffness(plan: Plan) -> Array:
    """Stiffness in joint-relative coordinates, (..., n, n), in the order of `plan.unknowns`."""
    stacks = [(group, group.stiffness()) for group in plan.topology.groups]
    out = reduced(plan, nodal(plan, stacks))
    for spring in plan.tree.springs:
        row = _spread(plan, [spring.row])
        k = np.asarray(spring.stiffness)
        out = out + k[..., None, None] * np.swapaxes(row, -1, -2) * row
    return out


def mass(plan: Plan) -> Array:
    """Mass in joint-relative coordinates, (..., n, n)."""
    out = nodal(plan, [(group, group.mass()) for group in plan.topology.groups])
    for node, matrix in point_masses(plan):
        padded = np.zeros((*np.broadcast_shapes(out.shape[:-2], matrix.shape[:-2]), *out.shape[-2:]))
        padded[..., 6 * node : 6 * node + 6, 6 * node : 6 * node + 6] = matrix
        out = out + padded
    return reduced(plan, out)


def reduced(plan: Plan, matrix: Array) -> Array:
    """T^T A T for a matrix over all DOFs."""
    change = substitution(plan)
    out: Array = np.swapaxes(change, -1, -2) @ matrix @ change
    return out


def substitution(plan: Plan) -> Array:
    """T of ``u = T q + g``: nodal displacements, in the nodes' axes, from the unknowns, (..., N, n)."""
    nodes = range(len(plan.topology.number))
    return _spread(plan, [plan.tree.row(node, k)[0] for node in nodes for k in range(6)])


def global_substitution(plan: Plan, nodes: list[int]) -> Array:
    """Displacements of `nodes` in global axes from the unknowns, (..., 6 nodes, n)."""
    return _spread(plan, [row for node in nodes for row in plan.tree.global_rows(node)[0]])


def _spread(plan: Plan, rows: list[Row]) -> Array:
    column = {k: index for index, k in enumerate(plan.unknowns)}
    values: list[tuple[int, int, Value]] = [(r, column[k], v) for r, row in enumerate(rows) for k, v in row.items()]
    shape = np.broadcast_shapes(*(np.shape(value) for _, _, value in values)) if values else ()
    out = np.zeros((*shape, len(rows), len(column)))
    for r, c, value in values:
        out[..., r, c] = value
    return out


def scaled(matrix: Array) -> tuple[Array, Array]:
    """D A D with unit diagonal, and the diagonal of D, (..., n); rows that are zero stay so."""
    diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
    root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
    return matrix * root[..., :, None] * root[..., None, :], root
