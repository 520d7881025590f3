"""Condition numbers of the stiffness, in the usual assembly and in the joint-relative coordinates that are solved."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from ..batch import Array, Shape, aligned, block_diagonal
from ..batched.plan import Plan
from ..errors import FrameError
from ..solvers.node_blocks import summed
from ..solvers.sparse import SparseSolver
from ..structure.own_unknowns import own_unknowns
from ..structure.parts import Value
from ..structure.topology import Index
from ..structure.tree import JointTree
from . import dense
from .spectrum import DENSE, extremes

Stack = tuple[Index, Array]


def usual(plan: Plan) -> Array:
    """2-norm condition number of K as structural programs assemble it, (...).

    Every node has its six global displacements, joints are 12 x 12 springs between duplicate nodes, and supported
    components are deleted. The nodes of a joint that is ideal in all components, such as a locked drive, are merged.

    Raises
    ------
    FrameError
        If a joint is ideal in some components only, or there are rigid links or ties, which would need a penalty.
    """
    frame, number = plan.frame, plan.topology.number
    if frame.ties:
        raise FrameError("condition_number: rigid links and ties have no usual assembly: use scaled_condition_number()")
    rigid = [joint for joint in frame.joints.values() if np.isinf(joint.element.stiffness).all()]
    same = _same(len(number), [(number[joint.first], number[joint.second]) for joint in rigid])
    apart = [name for name, joint in frame.joints.items() if joint not in rigid]
    each = [*_members(plan), *(_joint(plan, name) for name in apart)]
    stacks = [(6 * same[dofs // 6] + dofs % 6, stack) for dofs, stack in each]
    constrained = {6 * same[number[node]] + k for node, parts in frame.supports.items() for k in parts}
    free = [6 * node + k for node in np.unique(same) for k in range(6) if 6 * node + k not in constrained]
    if _sparse(plan):
        parts = [(dofs[:, ::6] // 6, stack.__getitem__) for dofs, stack in stacks]
        return _spread(plan, extremes(summed(parts, np.ones(len(number), dtype=bool))[free][:, free]))
    return _ratio(plan, dense.summed(stacks, 6 * len(number))[..., free, :][..., :, free])


def scaled(plan: Plan) -> Array:
    """2-norm condition number of K in joint-relative coordinates, scaled by `_units`, (...)."""
    if _sparse(plan):
        solver = SparseSolver(plan)
        units = scipy.sparse.diags(_units(plan, solver.unknown, solver.stiffness.diagonal()))
        return _spread(plan, extremes(scipy.sparse.csr_matrix(units @ solver.stiffness @ units)))
    stiffness, (own, unknowns) = dense.resisting(plan, pushed=True), own_unknowns(plan.tree.elimination, plan.unknowns)
    if own is not None:
        stiffness = np.swapaxes(own, -1, -2) @ stiffness @ own
    root = _units(plan, unknowns, np.diagonal(stiffness, axis1=-2, axis2=-1))
    return _ratio(plan, stiffness * root[..., :, None] * root[..., None, :])


def _units(plan: Plan, unknowns: Index, diagonal: Array) -> Array:
    """Scale of the unknowns, (..., n): the inverse square root of the mean diagonal stiffness of similar ones.

    The three displacements of a node are similar, and so are its three rotations, as a mean of the diagonal is the same
    in any axes. In a joint, components with springs of the same stiffness are similar. `unknowns` are the numbers of
    the unknowns, (..., n) or (n,), -1 for those that represent no displacement.
    """
    springs, count = _joint_springs(plan.tree), 6 * len(plan.topology.number) + 3
    varying = (value.shape for value in springs.values() if isinstance(value, np.ndarray))
    spring = np.zeros((*np.broadcast_shapes(*varying), count))
    for number, stiffness in springs.items():
        spring[..., number] = stiffness
    at: tuple[Any, ...] = (..., unknowns)
    each_has: Shape = ()
    if unknowns.ndim > 1:
        each_has = np.broadcast_shapes(unknowns.shape[:-1], diagonal.shape[:-1], spring.shape[:-1])
        own = np.broadcast_to(unknowns, (*each_has, unknowns.shape[-1]))
        at = *np.indices(own.shape, sparse=True)[:-1], own
    there, size = np.zeros((*each_has, count)), np.zeros((*(each_has or diagonal.shape[:-1]), count))
    there[at], size[at] = 1.0, diagonal
    spring, there, size = (each.reshape(*each.shape[:-1], count // 3, 3) for each in (spring, there, size))
    alike = there[..., None, :] * (spring[..., :, None] == spring[..., None, :])
    mean = np.vecdot(alike, size[..., None, :]) / np.maximum(alike.sum(axis=-1), 1.0)
    found = mean.reshape(*mean.shape[:-2], count)[at]
    return np.asarray(1.0 / np.sqrt(np.where(found > 0.0, found, 1.0)))


def _joint_springs(tree: JointTree) -> dict[int, Value]:
    """Stiffness of the spring on each joint-relative unknown, by its number."""
    found = {6 * each.child + k: spring for each in tree.branches for k, spring in enumerate(each.edge.stiffness)}
    for edge, exchanged in tree.exchanged.items():  # at some entries another joint has these coordinates
        for row, spring in zip(exchanged.rows, edge.stiffness, strict=True):
            for number, share in row.items():
                taken = np.asarray(exchanged.where) * (np.abs(np.asarray(share)) == 1.0)
                found[number] = np.where(taken > 0.0, spring, found.get(number, 0.0))
    return found


def _same(count: int, pairs: list[tuple[int, int]]) -> Index:
    """For each node the least number of the nodes merged with it, given pairs of merged nodes, (nodes,)."""
    if not pairs:
        return np.arange(count)
    there = np.ones(len(pairs), dtype=bool)
    graph = scipy.sparse.csr_matrix((there, tuple(np.array(pairs, dtype=np.int64).reshape(-1, 2).T)), (count, count))
    labels = scipy.sparse.csgraph.connected_components(graph, directed=False)[1]
    return np.asarray(np.unique(labels, return_index=True)[1][labels])


def _sparse(plan: Plan) -> bool:
    return plan.large and len(plan.unknowns) > DENSE


def _members(plan: Plan) -> list[Stack]:
    """DOF numbers (n, 12) and stiffness (n, ..., 12, 12) in global axes of the members of each group."""
    stacks = []
    for group in plan.topology.groups:
        turn = block_diagonal([group.local_axes] * 4)
        local = group.element.stiffness_matrix(group.length)
        stacks.append((group.dofs, np.swapaxes(turn, -1, -2) @ local @ turn))
    return stacks


def _joint(plan: Plan, name: str) -> Stack:
    """DOF numbers (1, 12) and stiffness (1, ..., 12, 12) of a joint in global axes."""
    link, number = plan.frame.joints[name], plan.topology.number
    if np.isinf(link.element.stiffness).any():
        raise FrameError(f"condition_number: joint {name!r} is ideal (inf): use scaled_condition_number()")
    dofs = np.concatenate([6 * number[node] + np.arange(6) for node in (link.first, link.second)])
    return dofs[None], aligned(link.element.matrix(), len(plan.frame.shape), 2)[None]


def _ratio(plan: Plan, matrix: Array) -> Array:
    if matrix.shape[-1] == 0:
        return np.ones(plan.frame.shape)
    values = np.abs(np.linalg.eigvalsh(matrix))
    return _spread(plan, (values.min(axis=-1), values.max(axis=-1)))


def _spread(plan: Plan, limits: tuple[Array, Array]) -> Array:
    """Largest over smallest eigenvalue, broadcast to the whole batch."""
    with np.errstate(divide="ignore"):
        return np.array(np.broadcast_to(np.divide(limits[1], limits[0]), plan.frame.shape))
