"""Member stiffness and loads in the nodes' axes: as stacks, and entry by entry for the broadcasting elimination."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, aligned, block_diagonal, rotated
from ..batched.condensation import Condensation
from ..batched.stage import Forces
from .member_loads import applied_stacks, equivalent, strain_forces, weight_forces
from .parts import Grid, Matrix, RightHandSideParameters, Row, Value, add, enter_all, is_zero, mask_of, scaled
from .topology import Group, Index, Topology
from .varying import Varying

# Loads on members are computed for this many batch entries at a time.
_SLICE = 2**13


def stiffness_entries(
    groups: Iterable[Group],
    grid: Grid,
    condensed: Condensation,
    varying: Varying,
    known: Mapping[Group, NDArray[Any]] = MappingProxyType({}),
) -> Matrix:
    """Parts of the stiffness of members by pair of DOF numbers, chains being condensed to their ends.

    Entries of `varying` members are left empty. The stiffness of some groups may be `known`, (n, ..., 12, 12).
    """
    matrix: Matrix = {}
    for entry in varying.entries:
        i, j = entry.at
        matrix.setdefault(i, {})[j] = matrix.setdefault(j, {})[i] = {}
    for numbers, stacks in _stacks(groups, condensed, known):
        used = np.triu((stacks != 0.0).any(axis=tuple(range(1, stacks.ndim - 2))))
        piece, a, b = np.nonzero(used)
        entries = np.moveaxis(stacks, (0, -2, -1), (0, 1, 2))[piece, a, b]
        shared = entries.size == len(entries)
        values = list(entries.reshape(-1)) if shared else [grid.value(entry) for entry in entries]
        first, second = (numbers[piece, end].tolist() for end in (a, b))
        enter_all(matrix, first, second, values)
    return matrix


def _stacks(
    groups: Iterable[Group], condensed: Condensation, known: Mapping[Group, NDArray[Any]]
) -> Iterator[tuple[Index, NDArray[Any]]]:
    """DOF numbers (n, 12) and stiffness (n, ..., 12, 12) of members and chains."""
    if not condensed.chains:
        for group in groups:
            yield group.dofs, known[group] if group in known else group.extended_stiffness()
        return
    for group in groups:
        left = np.flatnonzero(~np.isin(group.pieces, condensed.pieces))
        if len(left):
            part = group.part(left) if len(left) < len(group.pieces) else group
            yield part.dofs, part.extended_stiffness()
    yield condensed.dofs, condensed.stiffness


def force_entries(topology: Topology, rhs_parameters: RightHandSideParameters) -> Forces:
    """By DOF and right-hand-side parameter: parts of the load per unit of the parameter.

    Loads on members are included as equivalent nodal loads.
    """
    forces: Forces = {}
    grid = rhs_parameters.grid

    def put(dof: int, source: int, value: Value) -> None:
        add(forces.setdefault(dof, {}).setdefault(source, {}), mask_of(value), value)

    for node, k, value in component_loads(topology):
        axes, number = topology.axes_of[topology.bodies[node]], grid.value(value)
        if axes is None and type(number) is float:  # as most often
            if number != 0.0:
                add(forces.setdefault(6 * node + k, {}).setdefault(0, {}), 0, number)
            continue
        shares: Row = {6 * node + k: 1.0}
        if axes is not None:
            block, row = 6 * node + 3 * (k // 3), aligned(axes, len(grid.shape), 2)[..., k % 3, :]
            shares = {block + c: share for c, share in enumerate(grid.components(row))}
        for key, factor in rhs_parameters.row(number).items():
            for dof, push in scaled(shares, factor).items():
                put(dof, -1 - key, push)
    for dof, share in member_and_mass_loads(topology, grid):
        if not is_zero(share):
            put(dof, 0, share)
    return forces


def member_and_mass_loads(topology: Topology, grid: Grid) -> Iterator[tuple[int, Value]]:
    """DOF and value of the weights of masses and of equivalent nodal loads, in the nodes' axes; values may be zero."""
    frame = topology.frame
    if frame.weight is None and not frame.member_loads and not topology.strained:
        return
    for node, vector in mass_loads(topology):
        for c, share in enumerate(grid.components(_in_node(topology, node, vector))):
            yield 6 * node + c, share
    yield from _member_shares(topology, grid)


def _member_shares(topology: Topology, grid: Grid) -> Iterator[tuple[int, Value]]:
    """Equivalent nodal loads by DOF, computed slice by slice of the batch, to keep intermediate arrays small."""
    if math.prod(topology.loaded_shape) <= _SLICE:
        yield from _shares(topology, grid)
        return
    axis, slices = grid.slices(_SLICE)
    found: dict[tuple[int, Shape], Array] = {}
    for indices in slices:
        part = topology.cut(axis, indices)
        for dof, share in _shares(part, grid):
            if np.ndim(share) and np.shape(share)[axis] > 1:
                assert isinstance(share, np.ndarray)
                key = dof, (*share.shape[:axis], grid.shape[axis], *share.shape[axis + 1 :])
                if key not in found:
                    found[key] = np.zeros(key[1])
                found[key][(slice(None),) * axis + (indices,)] += share
            elif indices.start == 0:
                # the same in all slices
                yield dof, share
    for (dof, _), whole in found.items():
        yield dof, whole


def _shares(topology: Topology, grid: Grid) -> Iterator[tuple[int, Value]]:
    for group, positions, local in member_loads(topology):
        for dofs, stack in zip(group.dofs[positions].tolist(), group.nodal(positions, local), strict=True):
            for dof, share in zip(dofs, grid.components(stack), strict=True):
                if not is_zero(share):
                    yield dof, share


def _in_node(topology: Topology, node: int, vector: Array) -> Array:
    """A global force and moment (..., 6) in the axes of a node."""
    axes = topology.axes(node)
    aligned_vector = aligned(vector, len(topology.frame.shape), 1)
    return aligned_vector if axes is None else rotated(np.swapaxes(axes, -1, -2), aligned_vector)


def nodal_loads(topology: Topology) -> Iterator[tuple[int, Array]]:
    """Loads at nodes and weight of masses: node number, and vector (..., 6) in global axes."""
    for node, k, value in component_loads(topology):
        yield node, aligned(value[..., None] * np.eye(6)[k], len(topology.frame.shape), 1)
    yield from mass_loads(topology)


def component_loads(topology: Topology) -> list[tuple[int, int, Array]]:
    """Loads at nodes as given: node number, component, value (...)."""
    number = topology.number
    return [(number[name], k, value) for name, loads in topology.frame.loads.items() for k, value in loads]


def mass_loads(topology: Topology) -> Iterator[tuple[int, Array]]:
    """Weight of masses: node number, and vector (..., 6) in global axes."""
    frame = topology.frame
    if frame.weight is not None:
        push = np.concatenate([frame.weight, np.zeros_like(frame.weight)], axis=-1)
        for mass in frame.masses.values():
            force = (mass.element.mass_matrix() @ push[..., None])[..., 0]
            yield topology.number[mass.node], aligned(force, len(frame.shape), 1)


def offset_weights(topology: Topology) -> Iterator[tuple[int, Array, Array]]:
    """Weights of masses: node number, force (..., 3), and arm (..., 3) from the node to where it acts."""
    frame = topology.frame
    if frame.weight is None:
        return
    for point in frame.masses.values():
        matrix = point.element.mass_matrix()
        mass = matrix[..., 0, 0, None]
        moment = np.stack([matrix[..., 5, 1], matrix[..., 3, 2], matrix[..., 4, 0]], axis=-1)
        arm = np.divide(moment, mass, out=np.zeros(np.broadcast_shapes(moment.shape, mass.shape)), where=mass > 0.0)
        yield topology.number[point.node], mass * frame.weight, arm


def member_loads(topology: Topology) -> Iterator[tuple[Group, Index, Array]]:
    """Equivalent end forces of loads on members: group, positions in it (n,), and forces in local axes (n, ..., 12)."""
    frame = topology.frame
    for group in topology.groups:
        everywhere = np.arange(len(group.pieces))
        if group.strained:
            yield group, everywhere, strain_forces(group, everywhere)
        if frame.weight is not None:
            yield group, everywhere, equivalent(group, everywhere, weight_forces(topology, group, everywhere))
        for at, forces in applied_stacks(topology, group):
            yield group, at, equivalent(group, at, forces)


def point_masses(topology: Topology) -> Iterator[tuple[int, Array]]:
    """Masses at nodes: node number, and matrix (..., 6, 6) in the node's axes."""
    for point in topology.frame.masses.values():
        node = topology.number[point.node]
        matrix = aligned(point.element.mass_matrix(), len(topology.frame.shape), 2)
        axes = topology.axes(node)
        if axes is not None:
            turn = block_diagonal((axes, axes))
            matrix = np.swapaxes(turn, -1, -2) @ matrix @ turn
        yield node, matrix
