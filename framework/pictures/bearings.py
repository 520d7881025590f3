"""Bearings of joints with clearance, as rings in which their journals are seen to rest."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ..batch import Array
from ..paraview.entries import Index
from ..paraview.scene import taken
from .shapes import Surface, joined, tubes, upright

if TYPE_CHECKING:
    from ..solution import Solution

# Points of a quarter of a ring.
ARC_POINTS = 9


@dataclass(frozen=True)
class Bearing:
    """The bearing of one joint at T poses.

    Attributes
    ----------
    joint
        Number of the joint among those drawn.
    clearance
        Radial clearance, (T,).
    normals
        Global unit vectors about which it has rings, (T, n, 3).
    stops
        Global unit vectors along which it has a stop on either side, (T, k, 3).
    """

    joint: int
    clearance: Array
    normals: Array
    stops: Array

    def surface(self, pose: int, centre: Array, journal: float, gap: float, thickness: float) -> Surface:
        """Rings at a pose about the centre (3,), as much wider than the journal as the gap, or stops as far from it."""
        reach = journal + gap + thickness
        arcs = [circle_arcs(centre, axis, reach) for axis in self.normals[pose]]
        for axis in self.stops[pose]:
            arcs += [circle_arcs(centre + side * reach * axis, axis, 0.5 * journal) for side in (-1.0, 1.0)]
        return joined([tubes(arc, np.zeros((4, ARC_POINTS)), thickness) for arc in arcs])


def bearings(solution: Solution, index: Index, across: int | None) -> tuple[Bearing, ...]:
    """Bearings of joints that have clearance along displacements, in a plane structure in its plane.

    Parameters
    ----------
    solution
        The solution; without clearance it has none.
    index
        Index into the batch that leaves one axis.
    across
        Global axis at right angles to a plane structure; None for one in space.
    """
    found = []
    for name in solution.journals:
        joint, number = solution.frame.joints[name].element, list(solution.frame.joints).index(name)
        free = [k for k in joint.clearance_directions if k < 3]
        axes = [solution.joint_global(name, row) for row in np.eye(3)]
        rows = taken(solution, index, [np.stack([np.broadcast_to(row, axes[0].shape) for row in axes], axis=-2)])[:, 0]
        gap = taken(solution, index, [joint.clearance[..., None]])[:, 0, 0]
        chosen = _ring_normals(free, rows, across)
        found.append(Bearing(number, gap, rows[:, chosen], rows[:, free if len(free) == 1 else []]))
    return tuple(found)


def _ring_normals(free: Sequence[int], rows: Array, across: int | None) -> list[int]:
    """Which of the joint's axes (T, 3, 3), as rows, have a ring about them."""
    if len(free) < 2:
        return []
    normals = [k for k in range(3) if len(free) == 3 or k not in free]
    if across is None:
        return normals
    seen = [k for k in normals if np.abs(rows[:, k, across]).min() > 0.9]
    return seen or normals


def circle_arcs(at: Array, axis: Array, radius: float) -> Array:
    """A circle about a unit vector as four arcs, (4, `ARC_POINTS`, 3)."""
    side, up = upright(axis[None])[0].T[:2]
    turn = np.linspace(0.0, 0.5 * np.pi, ARC_POINTS) + 0.5 * np.pi * np.arange(4)[:, None]
    return np.asarray(at + radius * (np.cos(turn)[..., None] * side + np.sin(turn)[..., None] * up))
