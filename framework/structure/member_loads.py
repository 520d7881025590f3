"""Loads on a stretch of a member as point forces at quadrature points, which give the integrals needed exactly."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from ..batch import Array, Shape, aligned, rotated
from ..shape_rules import strain_rows, work_equivalent
from .topology import Group, Index, Topology

PointForces = Iterable[tuple[Array, Array]]

# Size of an array that stays in the processor's cache.
_CACHE = 2**15


def weight_forces(topology: Topology, group: Group, at: Index, upto: Array | None = None) -> PointForces:
    """Point forces that are equivalent to the weight of pieces.

    Parameters
    ----------
    topology
        The numbered frame.
    group
        Group of the pieces.
    at
        Positions of the pieces in the group (n,).
    upto
        Distance from the piece's start (n, ...) at which the stretch ends; the piece's length where None.

    Yields
    ------
    tuple
        Distance from the piece's start (n, ...) and force and moment in local axes (n, ..., 6).
    """
    gravity = topology.frame.weight
    if gravity is None:
        return
    length = group.length[at]
    end = length if upto is None else upto
    push = rotated(group.local_axes[at], aligned(gravity, length.ndim - 1, 1)[None])
    element, share = group.of(at), np.ones((1,) * end.ndim) if upto is None else upto / length
    points, weights = element.rule_between(np.zeros((1,) * end.ndim), share)
    for some in together(len(points), end.size):
        fractions = end * points[some] / length
        masses = element.mass_per_length(fractions)
        masses = np.broadcast_to(masses, np.broadcast_shapes(np.shape(masses), fractions.shape))
        for point, weight, mass in zip(points[some], weights[some], masses, strict=True):
            force = (weight * mass * end)[..., None] * push
            yield end * point, np.concatenate([force, np.zeros_like(force)], axis=-1)


def together(count: int, size: int) -> Iterator[slice]:
    """Slices of `count` quadrature points, each so short that its arrays of this `size` fit the processor's cache."""
    step = max(1, _CACHE // max(1, size))
    yield from (slice(start, start + step) for start in range(0, count, step))


def applied_forces(topology: Topology, group: Group, position: int, upto: Array | None = None) -> PointForces:
    """Point forces that are equivalent to the line and point loads on one piece; see `weight_forces`."""
    piece = topology.pieces[group.pieces[position]]
    length, local_axes = group.length[position], group.local_axes[position]
    start = length * piece.index
    end = start + (length if upto is None else upto)
    element = group.of(np.array([position]))

    def rule(lower: Array, upper: Array) -> tuple[Array, Array]:
        points, weights = element.rule_between(((lower - start) / length)[None], ((upper - start) / length)[None])
        return points[:, 0], weights[:, 0]

    for load in topology.frame.member_loads.get(piece.member, []):
        for x, force in load.in_axes(local_axes).points(start, end, length * piece.count, rule):
            yield (x - start)[None], force[None]


def loads_between(topology: Topology, group: Group) -> Iterator[tuple[Index, Array, Array]]:
    """Point forces that are equivalent to all loads between the ends of the pieces of a group.

    Parameters
    ----------
    topology, group
        The numbered frame, and the group.

    Yields
    ------
    tuple
        Positions of some pieces in the group (n,), distance from their starts (n, ...), and force and moment in local
        axes (n, ..., 6).
    """
    everywhere = np.arange(len(group.pieces))
    for x, force in weight_forces(topology, group, everywhere):
        yield everywhere, x, force
    for at, points in applied_stacks(topology, group):
        for x, force in points:
            yield at, x, force


def loaded(topology: Topology, group: Group) -> list[int]:
    """Positions in a group of the pieces whose members carry line or point loads."""
    by_member = topology.frame.member_loads
    if not by_member:
        return []
    return [k for k, piece in enumerate(group.pieces.tolist()) if topology.pieces[piece].member in by_member]


def applied_stacks(
    topology: Topology, group: Group, positions: Sequence[int] | None = None
) -> Iterator[tuple[Index, list[tuple[Array, Array]]]]:
    """The forces of `applied_forces` on runs of pieces, one after the other, that have equally many of equal shapes.

    Parameters
    ----------
    topology, group
        The numbered frame, and the group.
    positions
        Pieces with line or point loads, by their positions in the group; all of them where None.

    Yields
    ------
    tuple
        Positions of the pieces (n,); and the forces: distances from the start (n, ...) and forces (n, ..., 6).
    """
    run: list[tuple[int, list[tuple[Array, Array]]]] = []
    shapes: list[tuple[Shape, Shape]] = []
    for position in loaded(topology, group) if positions is None else positions:
        points = list(applied_forces(topology, group, position))
        own, size = [(x.shape, force.shape) for x, force in points], sum(force.size for _, force in points)
        if run and (own != shapes or len(run) * size >= _CACHE):
            yield _stack(run)
            run = []
        run.append((position, points))
        shapes = own
    if run:
        yield _stack(run)


def _stack(run: list[tuple[int, list[tuple[Array, Array]]]]) -> tuple[Index, list[tuple[Array, Array]]]:
    each = [
        (np.concatenate([x for x, _ in alike]), np.concatenate([force for _, force in alike]))
        for alike in zip(*(points for _, points in run), strict=True)
    ]
    return np.array([position for position, _ in run]), each


def equivalent(group: Group, at: Index, forces: PointForces) -> Array:
    """End forces in local axes, (n, ..., 12), that are equivalent in work to point forces on pieces."""
    out: Array = np.zeros((*group.length[at].shape, 12))
    for x, force in forces:
        out = out + work_equivalent(group.of(at).shape_functions(group.length[at], x), force)
    return out


def consistent(topology: Topology) -> Iterator[tuple[Group, Index, Array]]:
    """End forces of loads on members by the elements' own methods, scikit-fem forms where they have no closed form.

    Yields a group, positions in it (n,), and forces in local axes (n, ..., 12). They equal those of `equivalent` and
    `strain_forces`, which sum over whole stacks of a batch in a twentieth of the time.
    """
    for group in topology.groups:
        everywhere = np.arange(len(group.pieces))
        if group.strained:
            yield group, everywhere, group.element.strain_loads(group.length)
        weight = list(weight_forces(topology, group, everywhere))
        for at, points in [*([(everywhere, weight)] if weight else []), *applied_stacks(topology, group)]:
            x, force = (np.stack(np.broadcast_arrays(*each)) for each in zip(*points, strict=True))
            yield group, at, group.of(at).consistent_loads(group.length[at], x, force)


def strain_forces(group: Group, at: Index, sizes: bool = False) -> Array:
    """End forces in local axes, (n, ..., 12), that are equivalent to the free strain of pieces, such as by heat.

    Parameters
    ----------
    group
        Group of the pieces.
    at
        Positions of the pieces in the group (n,).
    sizes
        Whether to sum the magnitudes of the terms, for error bounds.
    """
    length = group.length[at]
    out: Array = np.zeros((*length.shape, 12))
    fractions, weights = group.element.integration_points
    lead = (slice(None), *(None,) * (length.ndim + 1 - fractions.ndim))
    forces = group.element.restrained_forces(fractions[lead])
    if forces is not None:
        rows = strain_rows(*group.element.shape_rows(length, fractions[lead]))
        rows, forces = (np.abs(rows), np.abs(forces)) if sizes else (rows, forces)
        out = out + np.sum((weights[lead] * length)[..., None] * np.einsum("...ij,...i->...j", rows, forces), axis=0)
    return out
