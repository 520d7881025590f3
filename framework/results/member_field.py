"""Internal forces and displacement inside pieces of members, exact for any load on them.

Pieces of one group are evaluated together: arrays have the stations first, then the pieces, then the batch,
(k, n, ...).
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..arm import transferred_along_x
from ..batch import Array
from ..errors import FrameError
from ..structure.member_loads import applied_forces, applied_stacks, equivalent, strain_forces, together, weight_forces
from ..structure.topology import Group, Index, Topology

# A station within this share of the length from an end counts as being there.
_AT = 1e-9
# For each of ux uy uz rx ry rz the strain that mainly causes it, and the strains of bending.
_STRAIN_OF, _BENDING = [0, 5, 4, 3, 4, 5], [4, 5]


def internal_forces(topology: Topology, group: Group, at: Index, x: Array, ends: Array) -> Array:
    """Internal forces ``N Vy Vz T My Mz`` in some pieces, (k, n, ..., 6).

    Parameters
    ----------
    topology, group
        The numbered frame, and the group of the pieces.
    at
        Positions of the pieces in the group, (n,).
    x
        Distances from the starts of the pieces, (k, n, ...).
    ends
        Forces on the ends of the pieces in local axes, (n, ..., 12).

    Raises
    ------
    FrameError
        If a station lies between the ends of a piece on an elastic foundation, whose forces are known at its ends only.
    """
    if group.has_foundation:
        return _at_ends(topology, group, at, x, ends)
    forces = cut_forces(topology, group, at, x, ends[..., :6])
    if group.resists:  # a preload, whose line rotates with the member
        length = group.length[at]
        last = cut_forces(topology, group, at, length[None], ends[..., :6])
        forces = forces + (x / length)[..., None] * (ends[..., 6:] - last)
    return forces


def cut_forces(topology: Topology, group: Group, at: Index, x: Array, start: Array) -> Array:
    """Internal forces as by `internal_forces`, for pieces that are not supported between their ends.

    They follow from the equilibrium of the part before the cut, under the force `start` (n, ..., 6) on its first end
    and its loads.
    """
    total = -transferred_along_x(start, -x)
    for s, force in weight_forces(topology, group, at, x):
        total -= transferred_along_x(force, s - x)
    for i in _loaded(topology, group, at):
        for s, force in applied_forces(topology, group, int(at[i]), x[:, i]):
            total[:, i] -= transferred_along_x(force[0], s[0] - x[:, i])
    return total


def _at_ends(topology: Topology, group: Group, at: Index, x: Array, ends: Array) -> Array:
    """Internal forces at stations that are ends of pieces, from the forces on these ends."""
    length = group.length[at]
    last = x >= length * (1.0 - _AT)
    if not np.all(last | (x <= length * _AT)):
        raise FrameError(
            f"{_named(topology, group, at)} resists rigid motion, as what is supported between its ends does: its "
            "forces are known at the ends of its segments alone: give it more of them, and stations there"
        )
    return np.where(last[..., None], ends[..., 6:], -ends[..., :6])


def _named(topology: Topology, group: Group, at: Index) -> str:
    piece = topology.pieces[group.pieces[at[0]]]
    kind = topology.frame.members[piece.member].element.title
    return f"member {piece.member!r} ({kind})"


def end_loads(topology: Topology, group: Group, at: Index) -> Array:
    """End forces in local axes, (n, ..., 12), that are equivalent in work to the loads on some pieces."""
    out = equivalent(group, at, weight_forces(topology, group, at))
    if group.strained:
        out = out + strain_forces(group, at)
    index = _loaded(topology, group, at)
    for some, forces in applied_stacks(topology, group, at[index].tolist()):
        load, here, index = equivalent(group, some, forces), index[: len(some)], index[len(some) :]
        out = np.array(np.broadcast_to(out, (len(at), *np.broadcast_shapes(out.shape[1:], load.shape[1:]))))
        out[here] += load
    return out


def deflection(topology: Topology, group: Group, at: Index, x: Array, ends: Array) -> Array:
    """Displacement inside some pieces, in local axes, (k, n, ..., 6), given the displacements of their ends.

    Parameters
    ----------
    topology, group, at, x
        As for `cut_forces`.
    ends
        Displacements of the ends of the pieces in local axes, (n, ..., 12).
    """
    shapes = group.of(at).shape_functions(group.length[at], x)
    moved: Array = np.einsum("...ij,...j->...i", shapes, ends)
    for some in _alike(topology, group, at):
        if group.has_foundation:
            _check_supported_between(topology, group, at[some], x[:, some])
            continue
        between = _between_fixed_ends(topology, group, at[some], x[:, some])
        whole = np.broadcast_shapes(moved.shape, (1, len(at), *between.shape[2:]))
        moved = np.array(np.broadcast_to(moved, whole)) if whole != moved.shape else moved
        moved[:, some] += between
    return moved


def _check_supported_between(topology: Topology, group: Group, at: Index, x: Array) -> None:
    """Refuse stations between the ends of loaded pieces on a foundation whose shape functions are otherwise exact."""
    length = group.length[at]
    if group.element.exact and np.any((x > length * _AT) & (x < length * (1.0 - _AT))):
        raise FrameError(
            f"{_named(topology, group, at)} resists rigid motion, as what is supported between its ends does, and is "
            "loaded there: its displacement is known at its ends alone: divide it into members, and read their nodes"
        )


def _alike(topology: Topology, group: Group, at: Index) -> Iterator[Index]:
    """Indices of the pieces with loads: those with their weight alone together, the others one by one."""
    loaded = _loaded(topology, group, at)
    if topology.frame.weight is not None or group.strained:
        plain = np.setdiff1d(np.arange(len(at)), np.array(loaded, dtype=np.int64))
        if len(plain):
            yield plain
    for i in loaded:
        yield np.array([i])


def _between_fixed_ends(topology: Topology, group: Group, at: Index, x: Array) -> Array:
    """Displacement by the loads on some pieces whose ends are fixed, in local axes, (k, n, ..., 6).

    It is integrated in each plane from the stiffer end, so that rounding in the strain of a thin end is not amplified.
    """
    length = group.length[at]
    ends = np.stack([np.zeros_like(length), np.ones_like(length)])
    flexibility = group.of(at).section_flexibility(ends)[..., _STRAIN_OF]
    first, last = np.broadcast_to(flexibility, np.broadcast_shapes(flexibility.shape, (*ends.shape, 6)))
    last_is_stiffer = last < first
    constrained = -end_loads(topology, group, at)[..., :6]

    def fixed_at(side: int) -> Array:
        origin = side * length
        slip = _slips(
            group, length, _integrated(topology, group, at, length - origin[None], constrained, side)[0], side
        )
        return _integrated(topology, group, at, x, constrained, side) + _rigid(slip, x - origin)

    if not last_is_stiffer.any():
        return fixed_at(0)
    return fixed_at(1) if last_is_stiffer[..., _BENDING].all() else np.where(last_is_stiffer, fixed_at(1), fixed_at(0))


def _loaded(topology: Topology, group: Group, at: Index) -> list[int]:
    """Indices of those pieces that belong to members with line or point loads."""
    loads = topology.frame.member_loads
    if not loads:
        return []
    pieces = topology.pieces
    return [i for i, piece in enumerate(group.pieces[at].tolist()) if pieces[piece].member in loads]


def _integrated(topology: Topology, group: Group, at: Index, x: Array, start: Array, side: int) -> Array:
    """Displacement at `x` relative to the start (0) or end (1), from the strains between them, (k, n, ..., 6)."""
    length = group.length[at]
    out: Array = np.zeros((*np.broadcast_shapes(start.shape[:-1], np.shape(x)), 6))
    lower = np.zeros_like(length)
    element = group.of(at)
    for upper in _breaks(topology, group, at):
        a, b = (np.maximum(lower, x), np.maximum(upper, x)) if side else (np.minimum(lower, x), np.minimum(upper, x))
        points, weights = element.rule_between(a / length, b / length)
        for some in together(len(points), out.size):
            places = a + (b - a) * points[some]
            # stations and quadrature points are merged into one axis, as elements take stations only
            s = places.reshape(-1, *places.shape[2:])
            strain = element.section_flexibility(s / length) * cut_forces(topology, group, at, s, start)
            free = element.free_strain(s / length)
            strain = strain if free is None else strain + free
            strains = strain.reshape(len(places), -1, *strain.shape[1:])
            for weight, place, here in zip(weights[some], places, strains, strict=True):
                out = out + (weight * (a - b if side else b - a))[..., None] * _carried(here, x - place)
        lower = upper
    return out


def _breaks(topology: Topology, group: Group, at: Index) -> list[Array]:
    """Distances from the start at which loads begin or end, in order, and the length of the piece.

    For pieces with line or point loads `at` has a single piece.
    """
    piece, length = topology.pieces[group.pieces[at[0]]], group.length[at]
    start = length * piece.index
    marks: list[float] = []
    for load in topology.frame.member_loads.get(piece.member, []):
        marks += load.places
    return [np.clip(mark - start, 0.0, length) for mark in sorted(set(marks))] + [length]


def _carried(strain: Array, ahead: Array) -> Array:
    """Displacement at a distance `ahead` caused by a strain over a unit length."""
    out = strain.copy()
    out[..., 1] += ahead * strain[..., 5]
    out[..., 2] -= ahead * strain[..., 4]
    return out


def _rigid(motion: Array, x: Array) -> Array:
    """Displacement at a distance `x` ahead in a rigid `motion` (..., 6) of the origin."""
    shape = np.broadcast_shapes(motion.shape[:-1], np.shape(x))
    return _carried(np.broadcast_to(motion, (*shape, 6)), np.asarray(x))


def _slips(group: Group, length: Array, other: Array, side: int) -> Array:
    """Displacement of the start (0) or end (1) in its released components that makes the other end's zero."""
    free = [component for own, component in group.element.releases if own == side]
    kept = [k for k in range(6) if (1 - side, k) not in group.element.releases]
    out = np.zeros_like(other)
    if free:
        ahead = -length if side else length
        columns = np.stack([_rigid(np.eye(6)[k], ahead) for k in free], axis=-1)[..., kept, :]
        out[..., free] = -(np.linalg.pinv(columns) @ other[..., kept, None])[..., 0]
    return out
