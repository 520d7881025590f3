"""Geometric stiffness: what the forces of a linear solution do where its members, joints and rigid links turn.

The second derivative of the potential energy at rest, under the forces of the solution: that of the deformations by the
displacements, times the forces that work on them. With rotation vectors as coordinates of the nodes it is symmetric,
and a moment that keeps its axis counts as a semitangential one (Argyris, Dunne & Scharpf, *Comput. Methods Appl. Mech.
Engrg.* 14 (1978) 401-451); so does the tangent of `linkframe.framework.large`, which tends to this one where what is
displaced before buckling is small.

*Members.* In axes that turn with the chord by t (mean twist about x, and the turn of the line between the ends) the
rotation of an end is, to second order, ``w - t - t x w / 2 - s`` with what the turn itself has of second order ::

    s = (-[t x (w1 + w2)]_x / 4,  t_x t_z / 2 - e t_y,  -t_x t_y / 2 - e t_z),    e = (u2 - u1) / L

The moments on the ends work on it; for the axial force there is the element's own matrix.

*Links.* The second node moves against the first, in axes that turn with the first by w1, by
``u2 - u1 + arm x w1 - w1 x (u2 - u1) + w1 x (w1 x arm) / 2`` and turns by ``w2 - w1 - w1 x w2 / 2``; where some
springs of a joint turn first, by ``- h x l / 2`` less, of what the stiffer (h) and the softer (l) ones turn.
"""

from __future__ import annotations

import numpy as np

from ..arm import cross_matrix
from ..batch import Array
from ..error_bounds.kinematic_edge import KinematicEdge

_X = np.array([1.0, 0.0, 0.0])
# Spins of the ends by the twelve end displacements.
_FIRST, _SECOND = np.zeros((3, 12)), np.zeros((3, 12))
_FIRST[:, 3:6] = _SECOND[:, 9:12] = np.eye(3)


def chord_rotation(length: Array) -> Array:
    """Turn of the chord's axes by the end displacements in local axes, (..., 3, 12)."""
    out = np.zeros((*length.shape, 3, 12))
    out[..., 0, 3] = out[..., 0, 9] = 0.5
    out[..., 1, 2] = out[..., 2, 7] = 1.0 / length
    out[..., 1, 8] = out[..., 2, 1] = -1.0 / length
    return out


def of_end_moments(length: Array, first: Array, second: Array, between: Array | None = None) -> Array:
    """Geometric stiffness of the moments on members, in local axes, (..., 12, 12).

    Parameters
    ----------
    length
        Length, (...).
    first, second
        Moments on start and end, (..., 3).
    between
        Sum of those applied between the ends, (..., 3); None for none.
    """
    turn = chord_rotation(length)
    stretch = _stretch(length)
    both = first + second if between is None else first + second + between
    twisting = 0.5 * both[..., :1] * _X
    half = -0.5 * (
        _FIRST.T @ cross_matrix(first - twisting) @ turn + _SECOND.T @ cross_matrix(second - twisting) @ turn
    )
    x, y, z = (turn[..., k : k + 1, :] for k in range(3))
    for moment, own, other, sign in ((both[..., 1], y, z, -0.5), (both[..., 2], z, y, 0.5)):
        row = np.swapaxes(stretch, -1, -2) @ own + sign * np.swapaxes(x, -1, -2) @ other
        half = half + moment[..., None, None] * row
    return half + np.swapaxes(half, -1, -2)


def of_load_between(length: Array, shapes: Array, x: Array, force: Array) -> Array:
    """Geometric stiffness of a dead force and moment on members between their ends, in local axes, (..., 12, 12).

    Beside its share at the ends, a force moves with what the member is deformed, in axes that turn with the chord.

    Parameters
    ----------
    length, x
        Length, and distance from the start, (...).
    shapes
        Displacement and rotation there by the end displacements, (..., 6, 12).
    force
        Force and moment, (..., 6).
    """
    turn, stretch = chord_rotation(length), _stretch(length)
    deformed = np.zeros((*length.shape, 12, 12))
    deformed[..., 3:6, :], deformed[..., 9:, :] = _FIRST - turn, _SECOND - turn
    deformed[..., 6:7, :] = length[..., None, None] * stretch
    moved = shapes @ deformed
    moved[..., :1, :] -= x[..., None, None] * stretch
    half = -np.swapaxes(moved[..., :3, :], -1, -2) @ cross_matrix(force[..., :3]) @ turn
    half = half - 0.5 * np.swapaxes(moved[..., 3:, :], -1, -2) @ cross_matrix(force[..., 3:]) @ turn
    out: Array = half + np.swapaxes(half, -1, -2)
    return out


def of_link(link: KinematicEdge, stiffness: Array, force: Array) -> Array:
    """Geometric stiffness of a link by the displacements of both nodes, global, (..., 12, 12).

    Parameters
    ----------
    link
        The joint, rigid link or tie.
    stiffness
        Its springs, (..., 6), inf where it is ideal.
    force
        Force and moment on its first node, in its axes, (..., 6).
    """
    if link.axes is not None:
        axes = np.asarray(link.axes, dtype=np.float64)
        push, moment = (np.einsum("...ij,...j->...i", axes, part) for part in (force[..., :3], force[..., 3:]))
    else:
        axes, push, moment = None, force[..., :3], force[..., 3:]
    order = _order(stiffness[..., 3:], force[..., 3:])
    order = order if axes is None else axes @ order @ np.swapaxes(axes, -1, -2)
    shapes = [push.shape[:-1], order.shape[:-2], *(part.shape[:-1] for part in (link.arm,) if part is not None)]
    out = np.zeros((*np.broadcast_shapes(*shapes), 12, 12))
    if link.edge.kind != "tie":
        across = cross_matrix(push)
        out[..., 3:6, :3], out[..., 3:6, 6:9] = -across, across
        out[..., :3, 3:6], out[..., 6:9, 3:6] = across, -across
        if link.arm is not None:
            out[..., 3:6, 3:6] = of_arm(np.asarray(link.arm, dtype=np.float64), push)
    out[..., 3:6, 3:6] -= order
    out[..., 9:, 9:] -= order
    out[..., 3:6, 9:] = order + 0.5 * cross_matrix(moment)
    out[..., 9:, 3:6] = order - 0.5 * cross_matrix(moment)
    return out


def of_arm(arm: Array, force: Array) -> Array:
    """Derivative (..., 3, 3), by the spin of an arm (..., 3), of the moment of a force (..., 3) that acts at its root.

    Twice the symmetric matrix of ``force . w x (w x arm) / 2``.
    """
    swing: Array = cross_matrix(arm) @ cross_matrix(force)
    return 0.5 * (swing + np.swapaxes(swing, -1, -2))


def _stretch(length: Array) -> Array:
    """Strain of the chord by the end displacements in local axes, (..., 1, 12)."""
    out = np.zeros((*length.shape, 1, 12))
    out[..., 0, 0], out[..., 0, 6] = -1.0 / length, 1.0 / length
    return out


def _order(turns: Array, moment: Array) -> Array:
    """Twice the symmetric matrix (..., 3, 3) of ``moment . h x l / 2`` for stiffer turns h and softer ones l."""
    soft = turns == turns.min(axis=-1, keepdims=True)
    mixed = np.where(soft[..., :, None] & ~soft[..., None, :], 0.5 * cross_matrix(moment), 0.0)
    return mixed + np.swapaxes(mixed, -1, -2)
