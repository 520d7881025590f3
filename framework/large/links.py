"""Finite motion in joints, rigid links, ties and supports: where the second node is, seen from the first, and back.

A joint's displacement (t, p) is measured in axes that follow its first node, with rotation R1: ::

    x2 = x1 + R1 (arm + A t),    R2 = R1 A E(p) A^T

so that an ideal component is absent, and a stiff spring stands alone on its own coordinate, however far the joint has
moved. The rotation E(p) = exp(stiff part of p) exp(soft part of p) is that of the rotation vector p where all three
springs are alike; otherwise the softest springs turn first, so that a pin keeps its axis through any number of turns.
Of a screw the coordinate along z is what its advance leaves, ``t_z - lead p_z``.

Along the joint tree the first node and the joint's displacement give the second node (`LinkChange` has the
derivatives). An edge that closes a loop finds both nodes placed, and its displacement follows from theirs
(`LoopChange`): its elastic components are springs on it, ideal ones constraints with a multiplier each, the force that
they transmit.

Vectors are (3, m), matrices (3, 3, m), m batch entries. Variations of rotation are spins in space.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import rotation
from ..batch import Array
from ..elementwise import less, where, zeros
from ..rotation import cross, inverse, spin, times, transposed


@dataclass(frozen=True)
class EdgeGeometry:
    """Geometry of an edge of the tree, seen from parent to child.

    Attributes
    ----------
    axes
        Axes as columns (3, 3, m), None for the global ones.
    arm
        From first to second node at the start (3, m), None for zero.
    movable
        Which components of rotation turn first (3,).
    forward
        Whether the child is the second node.
    follows
        Whether the translation's axes turn with the first node (not for ties).
    lead
        Advance of a screw along z by the turn about z (m,), None for none.
    """

    axes: Array | None
    arm: Array | None
    movable: NDArray[np.bool_]
    forward: bool
    follows: bool
    lead: Array | None = None

    def whole(self, own: Array) -> Array:
        """Displacement (6, m) from the coordinates: a screw's advance added."""
        if self.lead is None:
            return own
        out = own.copy()
        out[2] += self.lead * own[5]
        return out

    def rest(self, displacement: Array) -> Array:
        """Coordinates (6, m) from the displacement: what a screw's advance leaves of it."""
        if self.lead is None:
            return displacement
        out = displacement.copy()
        out[2] -= self.lead * displacement[5]
        return out

    def exerted(self, force: Array) -> Array:
        """Force and moment (6, m) from forces on the coordinates: that along a screw turns, too."""
        if self.lead is None:
            return force
        out = force.copy()
        out[5] -= self.lead * force[2]
        return out

    def relative(self, rotations: Array) -> Array:
        """Quaternion of the relative rotation in the global axes of the start."""
        q = rotation.exponential(np.where(self.movable[:, None], 0.0, rotations))
        q = rotation.product(q, rotation.exponential(np.where(self.movable[:, None], rotations, 0.0)))
        return q if self.axes is None else np.concatenate([q[:1], times(self.axes, q[1:])])

    def child(self, displacement: Array, rotations: Array, own: Array) -> tuple[Array, Array]:
        """Displacement and quaternion of the child from those of the parent and the link's own (6, m)."""
        own = self.whole(own)
        relative = self.relative(own[3:])
        q = rotation.product(rotations, relative if self.forward else rotation.conjugate(relative))
        first = rotations if self.forward else q
        shift = own[:3] if self.axes is None else times(self.axes, own[:3])
        if self.follows:
            shift = shift + rotation.rotated(first, shift)
        if self.arm is not None:
            shift = shift + rotation.rotated(first, self.arm * np.ones_like(shift))
        return displacement + (shift if self.forward else -shift), q


class LinkChange:
    """Variation of the child by those of parent and link, and what the forces on the child do in it.

    Parameters
    ----------
    link
        The link.
    first
        Quaternion of its first node (4, m).
    own
        Its coordinates (6, m).
    """

    def __init__(self, link: EdgeGeometry, first: Array, own: Array) -> None:
        self.link = link
        own = link.whole(own)
        turn = rotation.matrix(first)
        self.axes = turn if link.axes is None else times(turn, link.axes)
        self.slides = self.axes if link.follows else np.broadcast_to(np.eye(3)[..., None], turn.shape)
        self.arm = times(self.axes, own[:3]) if link.follows else np.zeros_like(own[:3])
        if link.arm is not None:
            self.arm = self.arm + times(turn, link.arm * np.ones_like(own[:3]))
        movable = link.movable
        self.constrained, self.free = np.where(movable[:, None], 0.0, own[3:]), np.where(movable[:, None], own[3:], 0.0)
        self.constrained_rotation = rotation.matrix(rotation.exponential(self.constrained))
        self.constrained_tangent = rotation.tangent(self.constrained)
        self.free_tangent = rotation.tangent(self.free)
        self.tangent = np.where(
            movable[:, None], times(self.constrained_rotation, self.free_tangent), self.constrained_tangent
        )
        self.turns = times(self.axes, self.tangent)

    @cached_property
    def jacobian(self) -> Array:
        """Displacement and spin of the child by those of the parent (6) and the link's own (6), (6, 12, m)."""
        out = zeros((6, 12, *self.arm.shape[1:]), self.arm, self.turns)
        out[range(6), range(6)] = 1.0
        if self.link.forward:
            out[:3, 3:6] = -spin(self.arm)
            out[:3, 6:9], out[3:, 9:] = self.slides, self.turns
        else:
            first = self._first_spin()
            out[:3, 3:] = times(spin(self.arm), first)
            out[:3, 6:9] -= self.slides
            out[3:, 3:] = first
        if self.link.lead is not None:
            out[:, 11] += self.link.lead * out[:, 8]
        return out

    def geometric(self, force: Array) -> Array:
        """Derivative of what a constant `force` on the child exerts on spin of the parent and own coordinates.

        Rows and columns: spin (3), translation (3), rotation (3) of the link, (9, 9, m).
        """
        push, moment = force[:3], force[3:]
        out = zeros((9, 9, *push.shape[1:]), push)
        if self.link.forward:
            first = np.zeros((3, *out.shape[1:]))
            first[range(3), range(3)] = 1.0
            sign, joint_moment = 1.0, moment
        else:
            first = self._first_spin()
            sign, joint_moment = -1.0, moment - cross(self.arm, push)
        swing = -times(spin(self.arm), first)
        if self.link.follows:
            swing[:, 3:6] += self.slides
            out[3:6] = sign * times(transposed(self.slides), times(spin(push), first))
        # d(arm x push) = -push x d(arm)
        levered = -sign * times(spin(push), swing)
        out[:3] = levered
        inner = times(spin(joint_moment), first)
        if not self.link.forward:
            inner = inner + levered
        out[6:] = sign * times(transposed(self.turns), inner)
        seen = times(transposed(self.axes), joint_moment)
        out[6:, 6:] += sign * self.own_slope(seen)
        if self.link.lead is not None:
            out[:, 8] += self.link.lead * out[:, 5]
            out[8] += self.link.lead * out[5]
        return out

    def _first_spin(self) -> Array:
        """Spin of the first node by spin of the parent, translation and rotation, backward (3, 9, m)."""
        out = zeros((3, 9, *self.arm.shape[1:]), self.arm, self.turns)
        out[range(3), range(3)] = 1.0
        out[:, 6:] = -self.turns
        return out

    def own_slope(self, moment: Array) -> Array:
        """Derivative of ``tangent^T moment`` by the rotation's coordinates (3, 3, m)."""
        movable = self.link.movable
        constrained = rotation.tangent_slope(self.constrained, moment)
        if not movable.any() or movable.all():
            return rotation.tangent_slope(self.free, moment) if movable.all() else constrained
        seen = times(transposed(self.constrained_rotation), moment)
        free = rotation.tangent_slope(self.free, seen)
        mixed = times(
            transposed(times(self.constrained_rotation, self.free_tangent)),
            times(spin(moment), self.constrained_tangent),
        )
        rows = np.where(movable[:, None, None], np.where(movable[None, :, None], free, mixed), constrained)
        keep = movable[:, None, None] | ~movable[None, :, None]
        out: Array = np.where(keep, rows, 0.0)
        return out


def displacement(link: EdgeGeometry, displacements: tuple[Array, Array], rotations: tuple[Array, Array]) -> Array:
    """Displacement (6, m) of the second node relative to the first, in the edge's axes; less a screw's advance."""
    back = rotation.conjugate(rotations[0])
    shift = displacements[1] - displacements[0]
    if link.follows:
        whole = shift if link.arm is None else shift + link.arm
        shift = shift + rotation.rotated(back, whole)
    relative = rotation.product(back, rotations[1])
    if link.axes is not None:
        axes = transposed(link.axes)
        shift = times(axes, shift)
        relative = np.concatenate([relative[:1], times(axes, relative[1:])])
    return link.rest(np.concatenate([shift, _angles(relative, link.movable)]))


def _angles(q: Array, movable: NDArray[np.bool_]) -> Array:
    """Coordinates of a rotation: the inverse of `EdgeGeometry.relative` in the edge's axes."""
    q = where(less(q[0], 0.0), -q, q)
    if movable.all() or not movable.any():
        return rotation.logarithm(q)
    single = int(np.flatnonzero(movable if movable.sum() == 1 else ~movable)[0])
    twist = np.zeros_like(q)
    twist[0], twist[1 + single] = q[0], q[1 + single]
    twist = rotation.normalised(twist)
    back = rotation.conjugate(twist)
    # the soft part turns first, and stands on the right
    rest = rotation.product(q, back) if movable[single] else rotation.product(back, q)
    return rotation.logarithm(rest) + rotation.logarithm(twist)


class LoopChange:
    """Derivatives of `displacement` by displacements and spins of both nodes.

    Parameters
    ----------
    link
        The edge.
    displacements, rotations
        Displacements (3, m) and quaternions (4, m) of both nodes.
    """

    def __init__(self, link: EdgeGeometry, displacements: tuple[Array, Array], rotations: tuple[Array, Array]) -> None:
        self.link = link
        self.own = displacement(link, displacements, rotations)
        self.change = LinkChange(link, rotations[0], self.own)
        self.arm = displacements[1] - displacements[0]
        if link.arm is not None:
            self.arm = self.arm + link.arm
        self.back = inverse(self.change.turns)

    @cached_property
    def jacobian(self) -> Array:
        """Change of the edge's displacement by displacements and spins of both nodes (6, 12, m)."""
        out = zeros((6, 12, self.own.shape[-1]), self.own, self.back)
        slides = transposed(self.change.slides)
        out[:3, :3], out[:3, 6:9] = -slides, slides
        if self.link.follows:
            out[:3, 3:6] = times(slides, spin(self.arm))
        out[3:, 3:6], out[3:, 9:] = -self.back, self.back
        if self.link.lead is not None:
            out[2] -= self.link.lead * out[5]
        return out

    def geometric(self, force: Array) -> Array:
        """Derivative of ``jacobian^T force`` at a constant force (6, m), by displacements and spins (12, 12, m)."""
        force = self.link.exerted(force)
        push = times(self.change.slides, force[:3])
        joint_moment = times(transposed(inverse(self.change.tangent)), force[3:])
        moment = times(self.change.axes, joint_moment)
        bend = times(transposed(self.back), times(self.change.own_slope(joint_moment), self.back))
        out = zeros((12, 12, self.own.shape[-1]), force, self.own)
        out[9:, 3:6] = bend - spin(moment)
        out[9:, 9:] = -bend
        out[3:6, 3:6] = spin(moment) - bend
        out[3:6, 9:] = bend
        if self.link.follows:
            turn = spin(push)
            out[6:9, 3:6], out[:3, 3:6] = -turn, turn
            out[3:6, 6:9] += turn
            out[3:6, :3] -= turn
            out[3:6, 3:6] += times(spin(self.arm), turn)
        return out
