"""Geometric stiffness of the forces of a linear solution, as members, joints and rigid links rotate.

It is the second derivative of the potential energy in the undeformed shape: the second derivative of the deformations
by the displacements, times the forces that work on them. With rotation vectors as coordinates of the nodes it is
symmetric, and a moment with a fixed axis counts as semitangential (Argyris, Dunne & Scharpf, *Comput. Methods Appl.
Mech. Engrg.* 14 (1978) 401-451). The tangent stiffness of `linkframe.framework.large` follows the same convention and
tends to this one where displacements before buckling are small.

*Members.* In axes that rotate with the chord by t (mean twist about x, and the rotation of the line between the ends)
the rotation of an end is, to second order, ``w - t - t x w / 2 - s``, where s is the second-order part of t ::

    s = (-[t x (w1 + w2)]_x / 4,  t_x t_z / 2 - e t_y,  -t_x t_y / 2 - e t_z),    e = (u2 - u1) / L

The end moments do work on it; the axial force contributes the element's own geometric matrix. Where an end is
released, u and w are those of the member's end, and what is released moves in axes that rotate with it by w: the node
is displaced by ``d + w x d`` and rotated by ``r + w x r / 2`` from there.

*Links.* Relative to the first node, in axes that rotate with it by w1, the second node is displaced by
``u2 - u1 + arm x w1 - w1 x (u2 - u1) + w1 x (w1 x arm) / 2`` and rotated by ``w2 - w1 - w1 x w2 / 2``; less
``h x l / 2`` if a joint rotates by l about its softer springs in axes carried by the rotation h of the stiffer ones.
"""

from __future__ import annotations

import numpy as np

from ..arm import cross_matrix
from ..batch import Array
from ..error_bounds.kinematic_edge import KinematicEdge

_X = np.array([1.0, 0.0, 0.0])
# Rotations of the two ends per unit of the twelve end displacements.
_FIRST, _SECOND = np.zeros((3, 12)), np.zeros((3, 12))
_FIRST[:, 3:6] = _SECOND[:, 9:12] = np.eye(3)


def chord_rotation(length: Array) -> Array:
    """Rotation of the chord's axes per unit end displacement in local axes, (..., 3, 12)."""
    out = np.zeros((*length.shape, 3, 12))
    out[..., 0, 3] = out[..., 0, 9] = 0.5
    out[..., 1, 2] = out[..., 2, 7] = 1.0 / length
    out[..., 1, 8] = out[..., 2, 1] = -1.0 / length
    return out


def of_end_moments(length: Array, first: Array, second: Array, between: Array | None = None) -> Array:
    """Geometric stiffness of the end moments of members, in local axes, (..., 12, 12).

    Parameters
    ----------
    length
        Length, (...).
    first, second
        Moments on the start and on the end, (..., 3).
    between
        Sum of moments applied between the ends, (..., 3); None for none.
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


def of_released_ends(moved: Array, ends: Array) -> Array:
    """Geometric stiffness of what is released at the ends of members, in local axes, (..., 12, 12).

    Parameters
    ----------
    moved
        Displacement of both ends of the member per unit displacement of the nodes, (..., 12, 12).
    ends
        Forces on both ends of the member, (..., 12).
    """
    half = np.zeros(np.broadcast_shapes(moved.shape, (*ends.shape, 12)))
    nodes = np.eye(12)
    for k in (0, 6):
        force, moment = cross_matrix(ends[..., k : k + 3]), cross_matrix(ends[..., k + 3 : k + 6])
        turned = moved[..., k + 3 : k + 6, :]
        half += np.swapaxes(turned, -1, -2) @ force @ (nodes[k : k + 3] - moved[..., k : k + 3, :])
        half -= 0.5 * nodes[:, k + 3 : k + 6] @ moment @ turned
    return half + np.swapaxes(half, -1, -2)


def of_load_between(length: Array, shapes: Array, x: Array, force: Array) -> Array:
    """Geometric stiffness of a dead force and moment on members between their ends, in local axes, (..., 12, 12).

    In addition to its equivalent end forces, the force does work on the deformation of the member in axes that rotate
    with the chord.

    Parameters
    ----------
    length, x
        Length, and distance from the start, (...).
    shapes
        Displacement and rotation there per unit end displacement, (..., 6, 12).
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
    """Geometric stiffness of a link by the displacements of both nodes, in global axes, (..., 12, 12).

    Parameters
    ----------
    link
        The joint, rigid link or tie.
    stiffness
        Stiffness of its springs, (..., 6), inf where it is ideal.
    force
        Force and moment on its first node, in the link's axes, (..., 6).
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
    """Derivative (..., 3, 3), by the rotation w of an arm (..., 3), of the moment of a force (..., 3) at its end.

    Twice the symmetric matrix of ``force . w x (w x arm) / 2``.
    """
    swing: Array = cross_matrix(arm) @ cross_matrix(force)
    return 0.5 * (swing + np.swapaxes(swing, -1, -2))


def _stretch(length: Array) -> Array:
    """Strain of the chord per unit end displacement in local axes, (..., 1, 12)."""
    out = np.zeros((*length.shape, 1, 12))
    out[..., 0, 0], out[..., 0, 6] = -1.0 / length, 1.0 / length
    return out


def _order(turns: Array, moment: Array) -> Array:
    """Twice the matrix (..., 3, 3) of ``moment . h x l / 2``, for rotations h of stiffer and l of softer springs."""
    soft = turns == turns.min(axis=-1, keepdims=True)
    mixed = np.where(soft[..., :, None] & ~soft[..., None, :], 0.5 * cross_matrix(moment), 0.0)
    return mixed + np.swapaxes(mixed, -1, -2)
