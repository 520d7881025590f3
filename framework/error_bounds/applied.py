"""Loads on nodes and members in extended precision, with bounds on their rounding errors."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..batch import Array, rotated
from ..batched.plan import Plan
from ..entries import Change
from ..structure.assembly import member_loads, nodal_loads
from ..structure.member_loads import PointForces, applied_stacks, loaded, strain_forces, weight_forces
from ..structure.topology import Group, Index
from .deformations import Springs
from .kinematic_edge import Real, extended

# Numbers of roundings, on the safe side: in the weight of a mass; of distances in a load on a member.
_WEIGHT, _FEW = 16.0, 32.0
_ROUNDING = float(np.finfo(np.float64).eps) / 2.0


@dataclass(frozen=True)
class AppliedLoads:
    """Loads of a frame.

    Of a whole batch only what acts is kept; `forces` and `error_bound` of all nodes are for a part of it.

    Attributes
    ----------
    count
        Number of nodes.
    nodes
        Nodes on which loads act, (l,), and those of them whose loads are rounded, (e,).
    acting
        Forces and moments on the first, global, (..., l, 6), in extended precision.
    rounded
        Bound on the error of the second by rounding in loads on members and masses, (..., e, 6).
    by_piece
        By number of a piece: equivalent forces on its ends in local axes, and their error bound, (..., 12) each.
    """

    count: int
    nodes: tuple[list[int], list[int]]
    acting: Real
    rounded: Array
    by_piece: dict[int, tuple[Real, Array]]

    @cached_property
    def forces(self) -> Real:
        """Forces and moments on all nodes, global, (..., nodes, 6), in extended precision."""
        return self._of_all(self.acting, self.nodes[0])

    @cached_property
    def error_bound(self) -> Array:
        """Bound on their error, (..., nodes, 6)."""
        return self._of_all(self.rounded, self.nodes[1])

    def _of_all(self, some: Array, nodes: list[int]) -> Array:
        out = np.zeros((*some.shape[:-2], self.count, 6), dtype=some.dtype)
        out[..., nodes, :] = some
        return out

    @classmethod
    def of(cls, plan: Plan, springs: list[Springs]) -> AppliedLoads:
        """Loads of a frame, evaluated from its description."""
        count, ndim = len(plan.topology.number) + len(plan.tree.exchanged), len(plan.frame.shape)
        given = list(nodal_loads(plan.topology))
        nodes = sum(len(each) for each in plan.frame.loads.values())
        on_members = list(member_loads(plan.topology))
        shapes = [vector.shape[:-1] for _, vector in given]
        shapes += [local.shape[1:-1] for _, _, local in on_members]
        shapes += [each.local_axes.shape[:-3] for each in springs] if on_members else []
        shape = np.broadcast_shapes((1,) * ndim, *shapes)
        ends = {
            int(node)
            for group, positions, _ in on_members
            for piece in group.pieces[positions].tolist()
            for node in plan.topology.pieces[piece].nodes
        }
        loaded = sorted(ends | {int(node) for node, _ in given})
        uncertain = sorted(ends | {int(node) for node, _ in given[nodes:]})
        place, places = ({node: k for k, node in enumerate(each)} for each in (loaded, uncertain))
        forces, error_bound = extended(np.zeros((*shape, len(loaded), 6))), np.zeros((*shape, len(uncertain), 6))
        if not uncertain:
            error_bound = np.zeros((*(1,) * ndim, 0, 6))
        for index, (node, vector) in enumerate(given):
            forces[..., place[int(node)], :] += vector
            if index >= nodes:  # the weight of a mass
                error_bound[..., places[int(node)], :] += _WEIGHT * _ROUNDING * _greatest(vector)
        by_piece: dict[int, tuple[Real, Array]] = {}
        numbers = {group: k for k, group in enumerate(plan.topology.groups)}
        for group, positions, local in on_members:
            local_axes = springs[numbers[group]].local_axes
            sizes = _sizes(plan, group, positions)
            for position, force, size in zip(positions.tolist(), local, sizes, strict=True):
                axes, piece = local_axes[..., position, :, :], int(group.pieces[position])
                nodal = _out(axes, force)
                spread = _out(np.abs(axes).astype(np.float64), size)
                for side, node in enumerate(plan.topology.pieces[piece].nodes):
                    forces[..., place[int(node)], :] += nodal[..., 6 * side : 6 * side + 6]
                    error_bound[..., places[int(node)], :] += spread[..., 6 * side : 6 * side + 6]
                before = by_piece.get(piece, (extended(0.0), np.zeros(())))
                by_piece[piece] = (before[0] + extended(force), before[1] + size)
        return cls(count, (loaded, uncertain), forces, error_bound, by_piece)

    def mapped(self, change: Change) -> AppliedLoads:
        """A copy with `change`, given the number of trailing axes, applied to every array."""
        by_piece = {k: (change(force, 1), change(size, 1)) for k, (force, size) in self.by_piece.items()}
        return replace(self, acting=change(self.acting, 2), rounded=change(self.rounded, 2), by_piece=by_piece)

    def ends(self, piece: int) -> tuple[Real, Array]:
        """Equivalent forces on the ends of a piece and their error bound, (..., 12), local."""
        return self.by_piece.get(piece, (extended(np.zeros(12)), np.zeros(12)))


def _sizes(plan: Plan, group: Group, positions: Index) -> Array:
    """Bound on the rounding error of the equivalent end forces of members, (n, ..., 12).

    Each is a sum over points of a force times a shape function, itself a sum: the rigid motion plus the effects of the
    two springs of a plane of bending, each a stiffness times a flexibility. None of these terms exceeds the motion of a
    rigid member, though the sum may be far less, as where a member shears far more than it bends. So the sizes are
    those of a rigid member; the roundings are those of a product of two stiffnesses, of the sum over the points, and
    a few of the distances and the products with them.
    """
    roundings = 2.0 * group.element.roundings + group.element.quadrature + _FEW
    sizes = _summed(group, positions, weight_forces(plan.topology, group, positions))
    if group.strained:
        sizes = sizes + strain_forces(group, positions, sizes=True)
    own = set(positions.tolist())
    for at, forces in applied_stacks(plan.topology, group, [k for k in loaded(plan.topology, group) if k in own]):
        size = _summed(group, at, forces)
        shape = np.broadcast_shapes(sizes.shape[1:], size.shape[1:])
        sizes = np.array(np.broadcast_to(sizes, (len(positions), *shape)))
        sizes[np.searchsorted(positions, at)] += size
    return roundings * _ROUNDING * sizes


def _summed(group: Group, at: Index, points: PointForces) -> Array:
    """Size of the equivalent forces of members, (n, ..., 12)."""
    length, element, forces = group.length[at], group.of(at), list(points)
    used = np.zeros((len(at), 6, 12), dtype=bool)
    for x, _ in forces:
        acting = element.shape_functions(length, x) != 0.0
        whole = np.broadcast_to(acting, np.broadcast_shapes(acting.shape, (*x.shape, 6, 12)))
        used |= whole.reshape(len(at), -1, 6, 12).any(axis=1)
    rigid = used.reshape(len(at), *(1,) * (length.ndim - 1), 6, 12) * _rigid(length)
    out: Array = np.zeros((*length.shape, 12))
    for _, force in forces:
        out = out + np.einsum("...ij,...i->...j", rigid, _greatest(force))
    return out


def _rigid(length: Array) -> Array:
    """Greatest displacements and rotations along a rigid member for unit ones of its ends, (..., 6, 12)."""
    turning = np.arange(12) % 6 >= 3
    power = turning.astype(float) - turning[:6, None].astype(float)
    out: Array = length[..., None, None] ** power
    return out


def _greatest(force: Array) -> Array:
    """The greatest force component three times, then the greatest moment component."""
    return np.repeat(np.abs(force).reshape(*force.shape[:-1], 2, 3).max(axis=-1), 3, axis=-1)


def _out(axes: Real, ends: Real) -> Real:
    """Forces on both ends (..., 12) from local into global axes."""
    return rotated(np.swapaxes(axes, -1, -2), ends)
