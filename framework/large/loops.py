"""Edges that close a loop of joints, links, ties and supports: springs between two nodes, and what holds them together.

The tree has used up the freedom of both nodes, so that the edge's displacement follows from theirs. Its elastic
components are springs on it; ideal ones are constraints with a multiplier each, the force that they transmit.
"""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import less, where, zeros
from ..rotation import inverse, spin, times, transposed
from .links import EdgeGeometry, LinkChange


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


def _angles(q: Array, movable: np.ndarray) -> Array:
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

    def jacobian(self) -> Array:
        """Change of the edge's displacement (6, 12, m)."""
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
