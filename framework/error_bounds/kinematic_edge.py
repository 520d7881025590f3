"""An edge of the joint tree in any precision: how it transfers displacements and forces between its nodes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..arm import carried, transferred
from ..batch import rotated
from ..structure.edge import ABOUT, ALONG, GROUND, Edge
from ..structure.parts import Extended

Real = NDArray[Any]


@dataclass(frozen=True)
class KinematicEdge:
    """An edge between two nodes, GROUND for the ground.

    Attributes
    ----------
    edge
        The joint, rigid link, tie or support.
    first, second
        Node numbers.
    sign
        For an edge of the tree, 1 if the first node carries the second and -1 if the second carries the first; 0 if
        the edge closes a loop.
    axes
        Axes of the edge as columns, (..., 3, 3); None for the global ones.
    arm
        Vector from first to second node of a rigid link, (..., 3); None for every other edge.
    lead
        Advance of a screw per radian, (...); None for every other edge.
    """

    edge: Edge
    first: int
    second: int
    sign: float
    axes: Real | None
    arm: Real | None
    lead: Real | None = None

    @property
    def child(self) -> int:
        """The carried node."""
        return self.second if self.sign > 0 else self.first

    @property
    def parent(self) -> int:
        """The node that carries the other."""
        return self.first if self.sign > 0 else self.second

    @property
    def alone(self) -> bool:
        """Whether its coordinates are the global displacements of its child."""
        return self.parent == GROUND and self.sign > 0 and self.axes is None and self.lead is None

    def out(self, vector: Real) -> Real:
        """A vector (..., 6) in the edge's axes, in global axes."""
        return vector if self.axes is None else rotated(self.axes, vector)

    def into(self, vector: Real) -> Real:
        """A vector (..., 6) in global axes, in the edge's axes."""
        return vector if self.axes is None else rotated(np.swapaxes(self.axes, -1, -2), vector)

    def carry(self, motion: Real, sign: float) -> Real:
        """Displacement (..., 6) of the end of the arm from that of its start; the start is the second node if `sign` is
        -1."""
        return motion if self.arm is None else carried(motion, sign * self.arm)

    def transfer(self, force: Real, sign: float) -> Real:
        """Force (..., 6) on the end of the arm, transferred to its start (the second node if `sign` is -1)."""
        return force if self.arm is None else transferred(force, sign * self.arm)

    # A screw's coordinate along its axis is the displacement less the advance.

    def whole(self, own: Real) -> Real:
        """Displacement (..., 6) in the edge's axes from its coordinates."""
        return own if self.lead is None else sheared(own, ALONG, ABOUT, self.lead)

    def rest(self, displacement: Real) -> Real:
        """Coordinates (..., 6) from the displacement in the edge's axes."""
        return displacement if self.lead is None else sheared(displacement, ALONG, ABOUT, -self.lead)

    def worked(self, force: Real) -> Real:
        """Force on the coordinates (..., 6) from force and moment in the edge's axes."""
        return force if self.lead is None else sheared(force, ABOUT, ALONG, self.lead)

    def exerted(self, force: Real) -> Real:
        """Force and moment (..., 6) in the edge's axes from the force on the coordinates."""
        return force if self.lead is None else sheared(force, ABOUT, ALONG, -self.lead)

    def spread(self, sizes: Real) -> Real:
        """Size of the displacement (..., 6) from that of the coordinates, or the other way round."""
        return sizes if self.lead is None else sheared(sizes, ALONG, ABOUT, sizes_of(self.lead))


def extended(array: Any) -> Real:
    """An array in extended precision."""
    return np.asarray(array, dtype=Extended)


def norm(vector: Real) -> Real:
    """Length of vectors along the last axis, in their precision."""
    length: Real = np.sqrt(np.sum(vector * vector, axis=-1))
    return length


def sheared(vector: Real, into: int, by: int, factor: Real) -> Real:
    """Vectors (..., 6) to one component of which `factor` (...) times another is added."""
    shape = (*np.broadcast_shapes(vector.shape[:-1], factor.shape), 6)
    out = np.array(np.broadcast_to(vector, shape), dtype=np.result_type(vector, factor))
    out[..., into] += factor * out[..., by]
    return out


def spread_over(sizes: Real, arm: Real | None) -> Real:
    """Greatest displacement and rotation at the end of an arm, (..., 6)."""
    if arm is None:
        return sizes
    arm_length = np.abs(arm).astype(np.float64).sum(axis=-1, keepdims=True)
    shift = sizes[..., :3] + arm_length * sizes[..., 3:].max(axis=-1, keepdims=True)
    return np.concatenate([shift, np.broadcast_to(sizes[..., 3:], shift.shape)], axis=-1)


def sizes_of(array: Real) -> Real:
    """Magnitudes of an array in double precision."""
    return np.abs(array).astype(np.float64)
