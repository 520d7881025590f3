"""Dense matrices (..., n, n) of small frames over the batch, for eigenvalues, condition numbers and free motions."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..entries import WHOLE, Entries, Stretch
from ..solvers.rounding import zero_eigenvalue
from ..structure.assembly import point_masses
from ..structure.parts import Row, Value
from ..structure.topology import Group, Index

# Number of element matrices in memory at a time, where only some batch entries are needed.
_MATRICES = 16384


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


def members(group: Group, entries: Entries = WHOLE) -> Array:
    """Stiffness of pieces in the nodes' axes, (n, ..., 12, 12), computed at the given entries alone."""
    if isinstance(entries, Stretch):
        return group.cut(entries.axis, entries.indices).stiffness()
    if entries.index is None:
        return group.stiffness()
    start, end = (entries(turn, 2, leading=1) for turn in group.end_axes)
    if set(group.shape) <= {1}:
        length = entries(group.length, 0, leading=1)
        # Parameters may have several axes of size one, which are inserted between pieces and entries.
        spread = length.reshape(len(length), *(1,) * max(0, len(group.shape) - 1), *length.shape[1:])
        local = group.element.stiffness_matrix(spread).reshape(*length.shape, 12, 12)
    else:
        step = max(1, _MATRICES // int(np.prod(group.stiffness_shape)))
        parts = (group.part(slice(k, k + step)) for k in range(0, len(group.length), step))
        local = np.concatenate([entries(some.element.stiffness_matrix(some.length), 2, leading=1) for some in parts])
    return group.in_node_axes(local, (start, end))


def stiffness(plan: Plan, entries: Entries = WHOLE) -> Array:
    """Stiffness in joint-relative coordinates, (..., n, n), in the order of `plan.unknowns`."""
    return with_springs(plan, reduced(plan, of_members(plan, entries), entries), entries)


def resisting(plan: Plan, entries: Entries = WHOLE, *, pushed: bool = False) -> Array:
    """The stiffness with zeros in rows and columns of unknowns whose diagonal entry is rounding of its terms.

    A node that carries others along displaces them all equally, and the stiffness of their members cancels.

    Parameters
    ----------
    plan
        The compiled frame.
    entries
        The batch entries to compute.
    pushed
        Whether negative diagonal entries, as caused by a preload in compression, are kept.
    """
    members = of_members(plan, entries)
    out = with_springs(plan, reduced(plan, members, entries), entries)
    root = np.sqrt(np.abs(np.diagonal(members, axis1=-2, axis2=-1)))[..., None, :]
    made = (root @ np.abs(_substitution(plan, entries)))[..., 0, :] ** 2
    own = np.diagonal(out, axis1=-2, axis2=-1)
    none = (np.abs(own) if pushed else own) <= zero_eigenvalue(members.shape[-1]) * made
    return np.where(none[..., :, None] | none[..., None, :], 0.0, out)


def of_members(plan: Plan, entries: Entries = WHOLE) -> Array:
    """Stiffness of members over all DOFs, in the nodes' axes, (..., N, N)."""
    return nodal(plan, [(group, members(group, entries)) for group in plan.topology.groups])


def with_springs(plan: Plan, out: Array, entries: Entries = WHOLE) -> Array:
    """A matrix in joint-relative coordinates, (..., n, n), with joint springs added."""
    for spring in plan.tree.springs:
        row = _spread(plan, [spring.row], entries)
        k = entries(np.asarray(spring.stiffness), 0)
        out = out + k[..., None, None] * np.swapaxes(row, -1, -2) * row
    return out


def mass(plan: Plan) -> Array:
    """Mass in joint-relative coordinates, (..., n, n)."""
    out = nodal(plan, [(group, group.mass()) for group in plan.topology.groups])
    for node, matrix in point_masses(plan.topology):
        padded = np.zeros((*np.broadcast_shapes(out.shape[:-2], matrix.shape[:-2]), *out.shape[-2:]))
        padded[..., 6 * node : 6 * node + 6, 6 * node : 6 * node + 6] = matrix
        out = out + padded
    return reduced(plan, out)


def reduced(plan: Plan, matrix: Array, entries: Entries = WHOLE) -> Array:
    """T^T A T for a matrix over all DOFs, with T of ``u = T q + g``."""
    change = _substitution(plan, entries)
    out: Array = np.swapaxes(change, -1, -2) @ matrix @ change
    return out


def global_substitution(plan: Plan, nodes: list[int], entries: Entries = WHOLE) -> Array:
    """Matrix from the unknowns to the displacements of `nodes` in global axes, (..., 6 nodes, n)."""
    return _spread(plan, [row for node in nodes for row in plan.tree.global_rows(node)], entries)


def _substitution(plan: Plan, entries: Entries) -> Array:
    """Matrix from the unknowns to the displacements of all nodes in their axes, (..., N, n)."""
    nodes = range(len(plan.topology.number))
    return _spread(plan, [plan.tree.row(node, k) for node in nodes for k in range(6)], entries)


def _spread(plan: Plan, rows: list[Row], entries: Entries) -> Array:
    column = {k: index for index, k in enumerate(plan.unknowns)}
    values: list[tuple[int, int, Value]] = [
        (r, column[k], entries(np.asarray(v), 0)) for r, row in enumerate(rows) for k, v in row.items() if k >= 0
    ]
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
