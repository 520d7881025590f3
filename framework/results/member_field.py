"""Forces and displacement inside one piece of a member, exact for any load that the piece carries."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..errors import FrameError
from ..structure.member_loads import PointForces, applied_forces, equivalent, weight_forces
from ..structure.topology import Group, Topology

# Share of the length by which a station is at an end.
_AT = 1e-9


def cut_forces(topology: Topology, group: Group, position: int, x: Array, start: Array) -> Array:
    """Internal forces ``N Vy Vz T My Mz`` at distance `x` (...) from the start of a piece, (..., 6).

    Equilibrium of the stretch before the cut under `start` (..., 6), the force on its first end.
    """
    total = -_about(start, -x)
    for s, force in _loads(topology, group, position, x):
        total = total - _about(force[0], s[0] - x)
    return total


def at_ends(topology: Topology, group: Group, position: int, x: Array, ends: Array) -> Array:
    """Internal forces at the ends of a piece (..., 6) from the forces on these (..., 12).

    Raises
    ------
    FrameError
        Where a station lies between them: what holds such a piece there, its ends do not tell.
    """
    length = group.length[position]
    last = x >= length * (1.0 - _AT)
    if not np.all(last | (x <= length * _AT)):
        raise FrameError(
            f"{_named(topology, group, position)} resists rigid motion, as what is held between its ends does: its "
            "forces are known at the ends of its segments alone: give it more of them, and stations there"
        )
    return np.where(last[..., None], ends[..., 6:], -ends[..., :6])


def _named(topology: Topology, group: Group, position: int) -> str:
    piece = topology.pieces[group.pieces[position]]
    kind = type(topology.frame.members[piece.member].element).__name__
    return f"member {piece.member!r} ({kind})"


def deflection(topology: Topology, group: Group, position: int, x: Array, ends: Array) -> Array:
    """Displacement at distance `x` from the start of a piece for its end displacements (..., 12), local, (..., 6)."""
    length = group.length[position]
    moved: Array = np.einsum("...ij,...j->...i", group.element.shape_functions(length, x), ends)
    at = np.array([position])
    held = equivalent(group, at, _loads(topology, group, position, None))[0]
    if not held.any() and not _carries(topology, group, position):
        return moved
    if group.stands:
        return _held_between(topology, group, position, x, moved)
    fixed = _integrated(topology, group, position, x, -held[..., :6])
    slip = _slips(group, length, _integrated(topology, group, position, length, -held[..., :6]))
    return moved + fixed + _rigid(slip, x)


def _held_between(topology: Topology, group: Group, position: int, x: Array, moved: Array) -> Array:
    """Displacement of a loaded piece that is held between its ends: as its shape functions have it, if not exact."""
    length = group.length[position]
    between = (x > length * _AT) & (x < length * (1.0 - _AT))
    if group.element.exact and np.any(between):
        raise FrameError(
            f"{_named(topology, group, position)} resists rigid motion, as what is held between its ends does, and is "
            "loaded there: its displacement is known at its ends alone: divide it into members, and read their nodes"
        )
    return moved


def _carries(topology: Topology, group: Group, position: int) -> bool:
    member = topology.pieces[group.pieces[position]].member
    return topology.frame.weight is not None or member in topology.frame.member_loads


def _loads(topology: Topology, group: Group, position: int, upto: Array | None) -> PointForces:
    stretch = None if upto is None else upto[None]
    yield from weight_forces(topology, group, np.array([position]), stretch)
    yield from applied_forces(topology, group, position, upto)


def _about(force: Array, arm: Array) -> Array:
    """A force at distance `arm` ahead, with its moment about the origin."""
    shape = np.broadcast_shapes(force.shape[:-1], np.shape(arm))
    out = np.array(np.broadcast_to(force, (*shape, 6)))
    out[..., 4] -= arm * force[..., 2]
    out[..., 5] += arm * force[..., 1]
    return out


def _integrated(topology: Topology, group: Group, position: int, x: Array, start: Array) -> Array:
    """Displacement at `x` relative to the start, from the strains between them, (..., 6)."""
    length = group.length[position]
    out: Array = np.zeros((*np.broadcast_shapes(start.shape[:-1], np.shape(x)), 6))
    lower = np.zeros_like(length)
    points, weights = np.polynomial.legendre.leggauss(group.element.quadrature)
    for upper in _breaks(topology, group, position):
        a, b = np.minimum(lower, x), np.minimum(upper, x)
        for point, weight in zip((1.0 + points) / 2.0, weights / 2.0, strict=True):
            s = a + (b - a) * point
            strain = group.element.section_flexibility(s / length) * cut_forces(topology, group, position, s, start)
            out = out + (weight * (b - a))[..., None] * _carried(strain, x - s)
        lower = upper
    return out


def _breaks(topology: Topology, group: Group, position: int) -> list[Array]:
    """Distances from the start at which a load begins or ends, in order, and the end of the piece."""
    piece = topology.pieces[group.pieces[position]]
    length = group.length[position]
    start = length * piece.index
    marks = []
    for load in topology.frame.member_loads.get(piece.member, []):
        span = getattr(load, "span", (getattr(load, "at", 0.0),))
        marks += list(span) if span is not None else []
    return [np.clip(mark - start, 0.0, length) for mark in sorted(set(marks))] + [length]


def _carried(strain: Array, ahead: Array) -> Array:
    """Displacement at a distance `ahead` of a unit stretch with this strain."""
    out = strain.copy()
    out[..., 1] += ahead * strain[..., 5]
    out[..., 2] -= ahead * strain[..., 4]
    return out


def _rigid(motion: Array, x: Array) -> Array:
    """Displacement at `x` that goes with `motion` (..., 6) of the start."""
    shape = np.broadcast_shapes(motion.shape[:-1], np.shape(x))
    return _carried(np.broadcast_to(motion, (*shape, 6)), np.asarray(x))


def _slips(group: Group, length: Array, end: Array) -> Array:
    """Motion of the start in its released components that brings the other components of the end back to zero."""
    free = [component for side, component in group.element.releases if side == 0]
    kept = [k for k in range(6) if (1, k) not in group.element.releases]
    out = np.zeros_like(end)
    if free:
        columns = np.stack([_rigid(np.eye(6)[k], length) for k in free], axis=-1)[..., kept, :]
        out[..., free] = -(np.linalg.pinv(columns) @ end[..., kept, None])[..., 0]
    return out
