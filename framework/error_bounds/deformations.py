"""Members as springs on deformations, in extended precision, with the uncertainty of their rounded stiffnesses.

``K = sum_i k_i b_i b_i^T``. The rows b follow from the geometry, which is taken as exact, and are evaluated in extended
precision; the stiffnesses k are known to a few roundings of double precision. These are positive, except for springs
preloaded in compression, of which error bounds take the magnitude.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ..batch import Array, aligned, rotated
from ..batched.plan import Plan
from ..batched.unloaded import Unloaded
from ..entries import Change
from ..protocol import LineElement
from ..structure.group import resists_rigid
from ..structure.parts import Extended
from ..structure.topology import Group, Index
from .kinematic_edge import Real, extended, norm
from .kinematics import position

# Roundings of extended precision in a deformation, relative to its size.
_FINE = 24.0 * float(np.finfo(np.longdouble).eps)
# Members whose rows are rotated at a time.
_MEMBERS = 2**10


@dataclass(frozen=True)
class Springs:
    """The members of one kind.

    Attributes
    ----------
    nodes
        Node numbers of their ends (n, 2).
    pieces
        Their numbers (n,).
    rows
        Deformations by the displacements of both ends in global axes, (..., n, springs, 12).
    local_rows
        The same in local axes, where most are exactly zero, which rotating back from global axes would lose.
    local_axes
        Local axes as rows, (..., n, 3, 3).
    length
        Lengths (..., n).
    stiffness
        Stiffnesses (..., n, springs), in double precision.
    roundings
        Number of roundings by which the stiffness may be off.
    mixed
        Pairs of springs (i, j) such that a rounded stiffness may add some of b_j to b_i, as a rounded elastic centre
        adds bending to shear: b_i acts on all displacements on which b_j does, and on others.
    balanced
        Whether a rigid motion needs no force; it does if the member is held from outside the frame or has a preload.
    determinate
        1 if the start carries the end, -1 if the end carries the start, 0 if neither (n,). The coordinates of the
        carried end are its displacement relative to the rigid motion of the other; they alone deform the member.
    """

    nodes: Index
    pieces: Index
    rows: Real
    local_rows: Real
    local_axes: Real
    length: Real
    stiffness: Array
    roundings: float
    mixed: tuple[tuple[int, int], ...]
    balanced: bool
    determinate: Index

    def mapped(self, change: Change) -> Springs:
        """A copy with `change`, given the number of trailing axes, applied to every array of the batch."""
        return replace(
            self,
            rows=change(self.rows, 3),
            local_rows=change(self.local_rows, 3),
            local_axes=change(self.local_axes, 3),
            length=change(self.length, 1),
            stiffness=change(self.stiffness, 2),
        )

    def of(self, displacements: Real, coordinates: Real) -> Real:
        """Deformations (..., n, springs) from displacements and coordinates of the nodes (..., nodes, 6)."""
        return _applied(self.rows, self._ends(displacements, coordinates))

    def sizes(self, displacements: Real, coordinates: Real) -> Real:
        """Sizes of the deformations, (..., n, springs), in double precision."""
        ends = np.abs(self._ends(displacements, coordinates).astype(np.float64))
        return _applied(self._absolute, ends)

    @cached_property
    def sizes_of_stiffness(self) -> Array:
        """Magnitudes of the stiffnesses, (..., n, springs)."""
        found: Array = np.abs(self.stiffness)
        return found

    @cached_property
    def _absolute(self) -> Array:
        """Magnitudes of the rows in double precision."""
        # rounded first, as double precision is several times faster
        found: Array = self.rows.astype(np.float64)
        return np.abs(found, out=found)

    def uncertain(self, deformations: Real, rounding: float) -> Real:
        """Bound on the change of spring forces by rounding of stiffness and elastic centre, (..., n, springs).

        If the elastic centre is off by a fraction d of the length, ``b_shear`` becomes ``b_shear + d s b_bend``, which
        mixes moment and shear; s is the ratio given by `share`. The place of a hinge is exact.
        """
        off, found = self.roundings * rounding, np.abs(deformations)
        out = off * self.sizes_of_stiffness * found
        shares = [self.share(shear, bend) for shear, bend in self.mixed]
        # the axes of a rolled beam may vary over the batch while its stiffness and deformations do not
        out = np.array(
            np.broadcast_to(out, (*np.broadcast_shapes(out.shape[:-1], *map(np.shape, shares)), out.shape[-1]))
        )
        for (shear, bend), share in zip(self.mixed, shares, strict=True):
            lean = 2.0 * off * self.sizes_of_stiffness[..., shear] * share
            lean = lean * (self.stiffness[..., bend] != 0.0)
            out[..., shear] += lean * found[..., bend]
            out[..., bend] += lean * found[..., shear]
        return out

    def work(self, generalised_forces: Real) -> Real:
        """Square of the greatest work of spring forces (..., n, springs) on a motion of unit energy norm, (...)."""
        sizes = self.sizes_of_stiffness
        stiff = sizes > 0.0
        shares = np.where(stiff, generalised_forces * generalised_forces / np.where(stiff, sizes, 1.0), 0.0)
        out: Real = np.sum(shares, axis=(-1, -2))
        return out

    def spread_forces(self, generalised_forces: Real) -> Array:
        """Sizes of the forces (..., n, 12) that spring forces exert on both ends, in double precision."""
        found: Array = np.einsum("...nij,...ni->...nj", self._absolute, generalised_forces.astype(np.float64))
        return found

    def forces(self, generalised_forces: Real) -> Real:
        """Forces (..., n, 12) on both ends, global, for spring forces (..., n, springs)."""
        found: Real = np.einsum("...nij,...ni->...nj", self.rows, generalised_forces)
        return found

    def add_to(self, nodal: Real, acting: Real) -> None:
        """Add quantities at both ends of the members (..., n, 2 k), global, to those of their nodes (..., nodes, k)."""
        ends = self.nodes.reshape(-1)
        acting = acting.reshape(*acting.shape[:-2], len(ends), nodal.shape[-1])
        order = np.argsort(ends, kind="stable")
        starts = np.flatnonzero(np.diff(ends[order], prepend=-1))
        if len(starts) < len(ends):
            acting, ends = np.add.reduceat(acting[..., order, :], starts, axis=-2), ends[order][starts]
        nodal[..., ends, :] += acting

    def share(self, i: int, j: int) -> Array:
        """Greatest ratio of b_i to b_j of a pair in `mixed` where both act, (..., n)."""
        pair = self.rows[..., (i, j), :].astype(np.float64)
        size = np.sqrt(np.sum(pair.reshape(*pair.shape[:-1], 4, 3) ** 2, axis=-1))
        first, second = size[..., 0, :], size[..., 1, :]
        ratio: Array = np.where(second > 0.0, first / np.where(second > 0.0, second, 1.0), 0.0).max(axis=-1)
        return ratio

    def _ends(self, displacements: Real, coordinates: Real) -> Real:
        taken = displacements[..., self.nodes, :]
        if self.determinate.any():
            which = np.flatnonzero(self.determinate)
            side = (self.determinate[which] > 0).astype(np.int64)
            taken[..., which, 1 - side, :] = 0.0
            taken[..., which, side, :] = coordinates[..., self.nodes[which, side], :]
        ends: Real = taken.reshape(*taken.shape[:-2], 12)
        return ends


def springs(plan: Plan) -> list[Springs]:
    """All members of a frame in extended precision."""
    return [_of(plan, group) for group in plan.topology.groups]


def on_nodes(nodal: Real, kinds: Iterable[tuple[Springs, Real]]) -> Real:
    """Quantities of nodes (..., nodes, k) and those at the ends of members (..., n, 2 k), added by kind of member.

    Each kind is added where its nodes are, so that many kinds with few members each cost no more than a single one.
    """
    each = list(kinds)
    shape = np.broadcast_shapes(nodal.shape[:-2], *(acting.shape[:-2] for _, acting in each))
    precision = np.result_type(nodal, *(acting.dtype for _, acting in each))
    out: Real = np.array(np.broadcast_to(nodal, (*shape, *nodal.shape[-2:])), dtype=precision)
    for springs_of_kind, acting in each:
        springs_of_kind.add_to(out, acting)
    return out


def constant_springs(plan: Plan | Unloaded, group: Group, element: LineElement) -> tuple[Real, Array, Real]:
    """Lengths (n, 1), stiffness (n, springs), and deformations (n, springs, 12) by the displacements of both ends in
    global axes, where they do not vary.

    Parameters
    ----------
    plan
        The compiled frame.
    group
        The members.
    element
        Their element, at one entry of the batch.
    """
    chord, local_axes = (each.reshape(len(each), *each.shape[-k:]) for k, each in enumerate(_geometry(plan, group), 1))
    length = (norm(chord) / extended(group.counts.reshape(-1)))[:, None]
    stiffness, rows = element.springs(length)
    in_global = _rotated(rows.reshape(-1, *rows.shape[-2:]), local_axes)
    return length, np.broadcast_to(stiffness.reshape(-1, stiffness.shape[-1]), in_global.shape[:2]), in_global


def _rotated(rows: Real, local_axes: Real) -> Real:
    """Rows (..., springs, 12) by displacements in local axes, turned into rows by displacements in global axes."""
    split, turn = rows.reshape(*rows.shape[:-1], 4, 3), local_axes[..., None, :, :]
    shape = *np.broadcast_shapes(split.shape[:-2], turn.shape[:-2]), 4, 3
    out: Real = np.empty(shape, np.result_type(split, turn))
    step = _MEMBERS if split.shape[-4] == turn.shape[-4] else shape[-4]
    for start in range(0, shape[-4], max(step, 1)):
        some = ..., slice(start, start + step), slice(None), slice(None), slice(None)
        # contiguous, as the product then takes half the time
        np.matmul(np.ascontiguousarray(split[some]), turn[some], out=out[some])
    return out.reshape(*shape[:-2], 12)


def _of(plan: Plan, group: Group) -> Springs:
    topology = plan.topology
    chord, local_axes = _geometry(plan, group)
    length = norm(chord) / extended(group.counts)
    stiffness, rows = group.element.springs(length)
    mixed, balanced = _mixed(rows), group.element.balanced
    if balanced is None:
        balanced = not resists_rigid(stiffness, rows, length, _FINE)
    rows, local_axes = np.moveaxis(rows, 0, -3), np.moveaxis(local_axes, 0, -3)
    return Springs(
        topology.ends[group.pieces],
        group.pieces,
        _rotated(rows, local_axes),
        rows,
        local_axes,
        np.moveaxis(length, 0, -1),
        np.moveaxis(stiffness, 0, -2),
        group.element.roundings,
        mixed,
        balanced,
        np.zeros(len(group.pieces), dtype=np.int64),
    )


def _mixed(rows: Real) -> tuple[tuple[int, int], ...]:
    """Pairs of springs (i, j) such that i acts on all displacements on which j does, and on others."""
    acts = (rows != 0.0).reshape(-1, *rows.shape[-2:]).any(axis=0)
    within = (acts[None, :] <= acts[:, None]).all(axis=-1)
    pairs = np.argwhere(within & ~within.T & acts.any(axis=-1)).tolist()
    return tuple((i, j) for i, j in pairs)


def _geometry(plan: Plan | Unloaded, group: Group) -> tuple[Real, Real]:
    """Chords (n, ..., 3) of the members and their axes as rows (n, ..., 3, 3), global."""
    topology, frame = plan.topology, plan.frame
    ndim = len(frame.shape)
    if (plain := topology.plain_chords(Extended)) is not None:
        chord = plain[group.pieces].reshape(-1, *(1,) * ndim, 3)
        return chord, group.element.axes(chord)
    pieces = [topology.pieces[k] for k in group.pieces]
    members = [frame.members[piece.member] for piece in pieces]
    first, second = (topology.bodies[node] for node in pieces[0].nodes)
    if first is None or first != second:
        chord = np.stack([aligned(position(plan, m.end) - position(plan, m.start), ndim, 1) for m in members])
        return chord, group.element.axes(chord)
    ends = [(extended(frame.nodes[m.end].coordinates), extended(frame.nodes[m.start].coordinates)) for m in members]
    local = np.stack([aligned(end - start, ndim, 1) for end, start in ends])
    axes = aligned(extended(frame.bodies[first].axes), ndim, 2)
    local_axes = group.element.axes(local) @ np.swapaxes(axes, -1, -2)
    return rotated(axes, local), _orthonormal(local_axes)


def _orthonormal(rows: Real) -> Real:
    """Axes orthonormal to double precision, made orthonormal in extended precision; x stays as it is."""
    x, y = rows[..., 0, :] / norm(rows[..., 0, :])[..., None], rows[..., 1, :]
    y = y - np.sum(x * y, axis=-1, keepdims=True) * x
    y = y / norm(y)[..., None]
    return np.stack([x, y, np.cross(x, y)], axis=-2)


def _applied(rows: Real, ends: Real) -> Real:
    out: Real = np.einsum("...nij,...nj->...ni", rows, ends)
    return out
