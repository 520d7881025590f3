"""Geometric stiffness of a whole frame under the forces of its linear solution, as element matrices between nodes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..batch import Array, aligned, block_diagonal
from ..batched.plan import Plan
from ..description import Description
from ..entries import Stretch, picked
from ..error_bounds.deformations import Springs
from ..error_bounds.equilibrium import EquilibriumResidual
from ..error_bounds.link_forces import link_forces, link_roundings
from ..error_bounds.tree_members import MEMBER
from ..protocol import LineElement
from ..structure.assembly import offset_weights
from ..structure.edge import GROUND, Edge
from ..structure.member_loads import loads_between
from ..structure.topology import Group, Index, Topology
from . import dense
from .geometric import of_arm, of_end_moments, of_link, of_load_between, of_released_ends

# A force below this many roundings of its terms is zero.
_ROUNDINGS = 16.0
_EPS = float(np.finfo(float).eps)
Stack = tuple[Index, Array]


def geometric_stacks(state: EquilibriumResidual, frame: Description | None = None) -> list[Stack]:
    """Node numbers (n, k) and geometric stiffness (n, ..., 6 k, 6 k) in the nodes' axes.

    Forces that are zero but for rounding count as zero.

    Parameters
    ----------
    state
        The solution, for the whole batch or a part of it, in its equilibrium equations.
    frame
        The frame that buckles, whose springs decide which rotations of a joint carry the others; that of the solution
        where None.
    """
    topology = _part(state)
    out, roundings = [], []
    for group, springs, number in zip(topology.groups, state.double_springs, range(len(state.springs)), strict=True):
        ends, error_bound = _ends(state, springs, number)
        roundings.append(_greatest(error_bound))
        ends = np.where(np.abs(ends) < error_bound, 0.0, ends)
        matrices = _members(topology, group, np.moveaxis(ends, -2, 0))
        out.append((group.nodes, group.in_node_axes(matrices)))
    return [*out, *_links(state, frame, roundings), *_weights(state)]


def at_entry(entry: tuple[int, ...], matrices: Array) -> Array:
    """Matrices (n, m, m) at one batch entry.

    Parameters
    ----------
    entry
        Indices of the batch entry.
    matrices
        Matrices (n, ..., m, m), which need not vary along every batch axis.
    """
    return picked(matrices, tuple(np.array([k]) for k in entry), trailing=2, leading=1)[:, 0]


def _part(state: EquilibriumResidual) -> Topology:
    """Members and their loads in the part of the batch to which the state belongs."""
    cut, topology = state.change, state.plan.topology
    return topology.cut(cut.axis, cut.indices) if isinstance(cut, Stretch) and cut.ndim else topology


def geometric_stiffness(plan: Plan, state: EquilibriumResidual) -> Array:
    """Geometric stiffness over the unknowns, (..., n, n), in the order of ``plan.unknowns``.

    Parameters
    ----------
    plan
        The plan whose unknowns are meant: that of the solution, or of a frame with other supports.
    state
        The solution for the whole batch in its equilibrium equations.
    """
    return dense.reduced(plan, over_dofs(plan, geometric_stacks(state, None if plan is state.plan else plan.frame)))


def over_dofs(plan: Plan, stacks: list[Stack]) -> Array:
    """Sum of matrices between nodes over all DOFs, (..., N, N).

    Parameters
    ----------
    plan
        The plan of the frame.
    stacks
        Node numbers (n, k) and matrices (n, ..., 6 k, 6 k) of each stack.
    """
    by_dof = [((6 * nodes[:, :, None] + np.arange(6)).reshape(len(nodes), -1), each) for nodes, each in stacks]
    return dense.summed(by_dof, 6 * len(plan.topology.number))


def _ends(state: EquilibriumResidual, springs: Springs, number: int) -> tuple[Array, Array]:
    """Forces on both ends of members in local axes, and bounds on their rounding errors, (..., n, 12) each."""
    rows = np.asarray(springs.local_rows, dtype=np.float64)
    generalised_forces = np.asarray(state.member_forces[number], dtype=np.float64)
    sizes = np.asarray(springs.stiffness * state.deformation_sizes[number], dtype=np.float64)
    ends = np.einsum("...nij,...ni->...nj", rows, generalised_forces)
    error_bound = _ROUNDINGS * _EPS * np.einsum("...nij,...ni->...nj", np.abs(rows), sizes)
    if state.loads.by_piece:
        given = [state.loads.ends(piece) for piece in springs.pieces.tolist()]
        ends = ends - _stacked([np.asarray(force, dtype=np.float64) for force, _ in given])
        error_bound = error_bound + _stacked([about for _, about in given])
    return ends, error_bound


def _stacked(each: list[Array]) -> Array:
    """Stack of n arrays (..., 12), (..., n, 12)."""
    shape = np.broadcast_shapes(*(array.shape for array in each))
    return np.stack([np.broadcast_to(array, shape) for array in each], axis=-2)


def _greatest(error_bound: Array) -> Array:
    """The greatest force and moment component on both ends, (..., n, 2, 2)."""
    out: Array = error_bound.reshape(*error_bound.shape[:-1], 2, 2, 3).max(axis=-1)
    return out


def _members(topology: Topology, group: Group, ends: Array) -> Array:
    """Geometric stiffness of a group in local axes, (n, ..., 12, 12), for the forces on the ends (n, ..., 12)."""
    length = np.broadcast_to(group.length, np.broadcast_shapes(group.length.shape, ends.shape[:-1]))
    axial = group.element.tension + 0.5 * (ends[..., 6] - ends[..., 0])
    loads = list(loads_between(topology, group))
    applied = None
    if any(np.any(force[..., 3:]) for _, _, force in loads):
        applied = np.zeros((*length.shape, 3))
        for position, _, force in loads:
            applied[position] += force[..., 3:]
    bent = of_end_moments(length, ends[..., 3:6], ends[..., 9:], applied)
    out: Array = _whole(group.element).geometric_matrix(length, axial) + bent
    for position, x, force in loads:
        own = np.broadcast_to(length[position], np.broadcast_shapes(length[position].shape, x.shape, force.shape[:-1]))
        shapes = _whole(group.of(position)).shape_functions(own, x)
        out[position] += of_load_between(own, shapes, np.broadcast_to(x, own.shape), force)
    if _whole(group.element) is not group.element:
        moved = _moved_ends(group)
        out = np.swapaxes(moved, -1, -2) @ out @ moved + of_released_ends(moved, ends)
    return out


def _whole(element: LineElement) -> LineElement:
    """The element without its releases, if there is such an element."""
    return element.unreleased() or element


def _moved_ends(group: Group) -> Array:
    """Displacement of both ends of members with releases per unit displacement of the nodes, (n, ..., 12, 12)."""
    element, length = group.element, group.length
    ends = [element.shape_functions(length, 0.0 * length), element.shape_functions(length, length)]
    out = np.zeros((*np.broadcast_shapes(*(end.shape[:-2] for end in ends)), 12, 12)) + np.eye(12)
    for end, component in element.releases:
        out[..., 6 * end + component, :] = ends[end][..., component, :]
    return out


def _links(state: EquilibriumResidual, frame: Description | None, roundings: list[Array]) -> list[Stack]:
    """Node numbers and geometric stiffness of joints, rigid links and ties that transmit forces."""
    nodes, matrices = [], []
    forces, error_bounds = link_forces(state), link_roundings(state, roundings)
    links = zip(state.kinematics.links, state.stiffness, forces, error_bounds, strict=True)
    for link, stiffness, force, error_bound in links:
        if GROUND in (link.first, link.second) or link.edge.kind == MEMBER:
            continue
        force = np.where(np.abs(force) < np.repeat(error_bound, 3, axis=-1), 0.0, force)
        matrix = of_link(link, _springs(state, frame, link.edge, stiffness), force)
        if np.any(matrix):
            nodes.append((link.first, link.second))
            matrices.append(_in_axes(state, (link.first, link.second), matrix))
    if not nodes:
        return []
    shape = np.broadcast_shapes(*(matrix.shape for matrix in matrices))
    return [(np.array(nodes), np.stack([np.broadcast_to(matrix, shape) for matrix in matrices]))]


def _springs(state: EquilibriumResidual, frame: Description | None, edge: Edge, stiffness: Array) -> Array:
    """Spring stiffnesses of an edge (..., 6), inf where it is ideal, in the frame that buckles."""
    if frame is None or edge.kind != "joint" or edge.name is None:
        return np.where(np.isin(range(6), edge.ideal), np.inf, stiffness)
    return state.change(aligned(frame.joints[edge.name].element.stiffness, len(frame.shape), 1), 1)


def _weights(state: EquilibriumResidual) -> Iterator[Stack]:
    """Geometric stiffness of weights with an offset from their node, whose arms rotate with it."""
    topology = state.plan.topology
    ndim = len(topology.frame.shape)
    for node, force, arm in offset_weights(topology):
        if np.any(arm):
            swing = of_arm(*(state.change(aligned(part, ndim, 1), 1) for part in (arm, force)))
            matrix = np.zeros((*swing.shape[:-2], 6, 6))
            matrix[..., 3:, 3:] = -swing
            yield np.array([[node]]), _in_axes(state, (node,), matrix)[None]


def _in_axes(state: EquilibriumResidual, nodes: tuple[int, ...], matrix: Array) -> Array:
    """A matrix (..., 6 k, 6 k) in global axes, transformed to the axes of its nodes."""
    each = (state.plan.topology.axes(node) for node in nodes)
    axes = [None if own is None else state.change(own, 2) for own in each]
    if all(own is None for own in axes):
        return matrix
    plain = np.eye(3)
    turn = block_diagonal([plain if own is None else own for own in axes for _ in range(2)])
    return np.swapaxes(turn, -1, -2) @ matrix @ turn
