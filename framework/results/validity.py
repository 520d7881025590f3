"""Whether linear theory holds: an estimate of its error from the forces out of balance in the displaced shape.

In the displaced shape the internal forces of each member rotate with its chord, and those of joints and rigid links
with their first node. The residual at the nodes is ``g = sum over members of psi x f``, with the rotation psi of the
chord, plus that of links by `linkframe.framework.results.geometric`. It would move the frame by ``K^-1 g``, the first
step of an iteration to large displacement with f as dead loads. Its energy norm over that of the solution,
``sqrt(g . K^-1 g / u . K u)``, is the relative error of the linear result to first order. In addition, a chord that
rotates by psi shortens its projection by half of psi times the displacement of its end (Crisfield, *Non-linear Finite
Element Analysis of Solids and Structures* 1, 1991, ch. 7, for forces that rotate with the chord). The displaced shape
includes displacements within clearances, which rotate links under any load. Where all displacements are rounding
compared with the size of the frame, as in a rigid link loaded along its axis, the estimate is zero.

Above a buckling load the equilibrium is unstable, and the estimate is inf, see
`linkframe.framework.results.stability`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..batch import Array, aligned, merged, rotated
from ..entries import flattened
from ..error_bounds.bounds import BatchPart, BoundedResults
from ..error_bounds.deformations import Springs, on_nodes
from ..error_bounds.equilibrium import EquilibriumResidual
from ..error_bounds.kinematic_edge import Real
from ..error_bounds.link_forces import link_forces
from ..error_bounds.tree_members import MEMBER
from ..member_law import deformation_rows
from ..states import SolutionState
from ..structure.edge import GROUND
from ..structure.member_loads import strain_forces
from ..structure.topology import Group
from .geometric import of_link
from .stability import Stability

# Linear theory counts as valid if the estimated relative error is below this.
LINEAR = 0.05
# Displacements below this share of the frame's size are rounding, and their estimated relative error has no meaning.
_STILL = 1e-13


def beyond_linear(error: float) -> str:
    """What is said of a result that linear mechanics does not give.

    Parameters
    ----------
    error
        Its estimated relative error; inf where the equilibrium is unstable.
    """
    if np.isinf(error):
        return "outside the linear range: unstable under its load"
    return f"outside the linear range: estimated error {100.0 * error:.2g} %"


def nonlinearity(solution: BoundedResults) -> Array:
    """Estimated relative error of linear theory in a solution, (...); inf for mechanisms and above a buckling load."""
    out = np.zeros(solution.shape)
    stability = Stability(solution)
    with np.errstate(all="ignore"):  # of mechanisms
        for part in solution.bounds.parts():
            out[part.where] = _of(part)
            stability.see(part)
    out[(solution.own_state == SolutionState.MECHANISM) | stability.unstable()] = np.inf
    return out


def _of(part: BatchPart) -> Real:
    state, compliance = part.state, part.compliance
    count = state.kinematics.count
    acting: list[tuple[Springs, Real]] = []
    largest: Any = 0.0
    energy: Any = 0.0
    ndim, groups = len(state.plan.frame.shape), state.plan.topology.groups
    stacks = zip(groups, state.springs, state.member_forces, state.deformations, strict=True)
    for group, springs, generalised_force, found in stacks:
        turn = _rotation(springs, state.displacements)
        forces = np.einsum("...nij,...ni->...nj", springs.rows, generalised_force)
        tension = state.change(aligned(group.element.tension, ndim), 0)[..., None, None]
        along = tension * springs.local_axes[..., 0, :]
        forces[..., :3], forces[..., 6:9] = forces[..., :3] - along, forces[..., 6:9] + along
        if group.strained:
            forces = forces - _strain_forces(state, group, springs)
        split = forces.reshape(*forces.shape[:-1], 4, 3)
        by_rotation = np.cross(turn[..., None, :], split).reshape(forces.shape)
        if group.element.has_law:
            by_rotation = by_rotation + _beyond_stiffness(state, group, springs)
        acting.append((springs, -by_rotation))
        largest = np.maximum(largest, np.sum(turn * turn, axis=-1).max(axis=-1))
        energy = energy + np.sum(generalised_force * found, axis=(-1, -2))
    for k, generalised_force in zip(state.stiffness, state.generalised_forces, strict=True):
        energy = energy + np.sum(
            np.where(k > 0.0, generalised_force * generalised_force / np.where(k > 0.0, k, 1.0), 0.0), axis=-1
        )
    by_rotation, turns = _links(state)
    unbalanced, largest = on_nodes(np.zeros((count, 6)), acting) + by_rotation, np.maximum(largest, turns)
    more = [_beyond_springs(state, number) for number in range(len(state.kinematics.links))]
    load = state.kinematics.reduced(state.unknowns, state.kinematics.generalised(unbalanced, more))
    work = np.sum(load * compliance.solve(load.astype(compliance.root.dtype)), axis=-1)
    # The work is negative where the stiffness is not definite, for which the estimate must not be small either.
    ratio = np.sqrt(np.abs(work) / np.where(energy > 0.0, energy, 1.0))
    size = state.plan.frame.size
    scale = np.abs(state.displacements).astype(np.float64).reshape(*state.displacements.shape[:-1], 2, 3)
    moves = (scale.max(axis=(-3, -1), initial=0.0) * np.array([1.0, size])).max(axis=-1) > _STILL * size
    out: Real = np.maximum(np.where(moves & (energy > 0.0), ratio, 0.0), 0.5 * np.sqrt(largest))
    return out


def _strain_forces(state: EquilibriumResidual, group: Group, springs: Springs) -> Real:
    """End forces equivalent to the free strain of the members of a group, in global axes, (..., n, 12)."""
    local = strain_forces(group, np.arange(len(group.pieces)))
    return rotated(np.swapaxes(springs.local_axes, -1, -2), state.change(np.moveaxis(local, 0, -2), 2))


def _beyond_stiffness(state: EquilibriumResidual, group: Group, springs: Springs) -> Real:
    """End forces by the nonlinear law of members less those by their stiffness, in global axes, (..., n, 12)."""
    length = np.asarray(springs.length, dtype=np.float64)
    local_axes = np.asarray(springs.local_axes, dtype=np.float64)
    moved = np.asarray(state.displacements[..., springs.nodes, :], dtype=np.float64)
    local = rotated(local_axes, merged(moved, -2, -1))
    rows = deformation_rows(length)
    deformation = np.einsum("...ij,...j->...i", rows, local)
    shape, ndim = deformation.shape[:-1], len(state.plan.frame.shape)

    def pick(array: Array, trailing: int) -> Array:
        part = state.change(aligned(array, ndim, trailing), trailing)
        return flattened(np.expand_dims(part, part.ndim - trailing), shape, trailing)

    along = np.broadcast_to(length, shape).reshape(-1)
    _, force, _ = group.element.resistance(along, deformation.reshape(-1, 7), pick)
    nonlinear = np.einsum("...ij,...i->...j", rows, force.reshape(*shape, 7))
    linear = np.einsum("...nij,...ni->...nj", springs.local_rows, springs.stiffness * _deformed(springs, local))
    return rotated(np.swapaxes(local_axes, -1, -2), nonlinear - linear)


def _deformed(springs: Springs, local: Array) -> Real:
    """Deformations (..., n, springs) of local displacements (..., n, 12)."""
    out: Real = np.einsum("...nij,...nj->...ni", springs.local_rows, local)
    return out


def _beyond_springs(state: EquilibriumResidual, number: int) -> Real | None:
    """Spring forces of a joint less those by its nonlinear law, (..., 6); None where it has no such law."""
    edge = state.kinematics.links[number].edge
    if edge.kind != "joint" or edge.name is None:
        return None
    element = state.plan.frame.joints[edge.name].element
    if not element.has_law:
        return None
    offset, whole = state.imposed[number], len(state.plan.frame.shape)
    stretch = np.asarray(
        state.relative_displacements[number] if offset is None else state.relative_displacements[number] - offset,
        np.float64,
    )
    own = state.change(aligned(np.empty(element.shape), whole), 0).shape
    shape = np.broadcast_shapes(stretch.shape[:-1], own)

    def pick(array: Array, trailing: int) -> Array:
        return flattened(state.change(aligned(array, whole, trailing), trailing), shape, trailing)

    _, force, _ = element.resistance(np.broadcast_to(stretch, (*shape, 6)).reshape(-1, 6), pick)
    constrained = np.isin(np.arange(6), edge.ideal)
    out: Real = np.where(constrained, 0.0, state.generalised_forces[number] - force.reshape(*shape, 6))
    return out


def _links(state: EquilibriumResidual) -> tuple[Array, Array]:
    """Residual at the nodes by rotating links, (..., nodes, 6), and the largest squared rotation of an arm, (...)."""
    moved = np.asarray(state.displacements, dtype=np.float64)
    out, largest = np.zeros(moved.shape), np.zeros(moved.shape[:-2])
    for link, k, force in zip(state.kinematics.links, state.stiffness, link_forces(state), strict=True):
        if GROUND in (link.first, link.second) or link.edge.kind == MEMBER:
            continue
        ends = np.concatenate([moved[..., link.first, :], moved[..., link.second, :]], axis=-1)
        springs = np.where(np.isin(range(6), link.edge.ideal), np.inf, k)
        by_rotation = np.einsum("...ij,...j->...i", of_link(link, springs, force), ends)
        out[..., link.first, :] -= by_rotation[..., :6]
        out[..., link.second, :] -= by_rotation[..., 6:]
        if link.arm is not None:
            largest = np.maximum(largest, np.sum(ends[..., 3:6] ** 2, axis=-1) * np.any(link.arm != 0.0, axis=-1))
    return out, largest


def _rotation(springs: Springs, displacements: Real) -> Real:
    """Rotation vectors of the chords of members, with their mean twist, (..., n, 3)."""
    ends = displacements[..., springs.nodes, :]
    along = springs.local_axes[..., 0, :]
    difference = ends[..., 1, :3] - ends[..., 0, :3]
    twist = np.sum(along * (ends[..., 0, 3:] + ends[..., 1, 3:]), axis=-1, keepdims=True) / 2.0
    out: Real = np.cross(along, difference) / springs.length[..., None] + twist * along
    return out
