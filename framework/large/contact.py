"""Contact in a joint with clearance, in an equilibrium at large displacement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..batch import Array, aligned, turned
from ..clearances.contact import ABSENT, CLOSED, OPEN, STATES, UNRESOLVED, Contact
from . import rotation

if TYPE_CHECKING:
    from .solution import LargeSolution


def contact(solution: LargeSolution, name: str) -> Contact:
    """Where a joint with clearance is in contact, and how hard it is pressed; its axes turned with its first node."""
    frame, joint = solution.frame, solution.frame.joints[name]
    play = list(joint.element.play)
    imposed = frame.offsets.get(name, {})
    gap = solution.joint_displacement(name)[..., play] - np.stack(
        np.broadcast_arrays(*(imposed.get(k, np.zeros(())) for k in play)), axis=-1
    )
    radius, length = np.broadcast_to(joint.element.clearance, frame.shape), np.linalg.norm(gap, axis=-1)
    closed = np.asarray(length > radius)
    state = np.where(closed, CLOSED, OPEN)
    state = np.where(solution.converged, state, UNRESOLVED)
    state = state if frame.absent is None else np.where(frame.absent, ABSENT, state)
    unknown = np.where(state >= UNRESOLVED, np.nan, 0.0)
    press = np.linalg.norm(solution.joint_force(name)[..., play], axis=-1)
    offset = np.zeros((*frame.shape, 3))
    offset[..., [k % 3 for k in play]] = gap * np.where(closed, radius / np.where(closed, length, 1.0), 1.0)[..., None]
    along = np.zeros((*frame.shape, 3))
    along[..., [k % 3 for k in play]] = gap / np.where(closed, length, 1.0)[..., None]
    return Contact(
        joint=name,
        state=STATES[state],
        normal=np.where(closed[..., None], _turned(solution, name, along), 0.0) + unknown[..., None],
        force=np.where(closed, press, 0.0) + unknown,
        gap=np.where(closed, 0.0, radius - length) + unknown,
        offset=offset + unknown[..., None],
    )


def _turned(solution: LargeSolution, name: str, along: Array) -> Array:
    """Vectors in a joint's axes as global ones, (..., 3)."""
    frame, joint = solution.frame, solution.frame.joints[name]
    axes = joint.element.axes
    start = along if axes is None else turned(aligned(axes, len(frame.shape), 2), along)
    turn = rotation.matrix(solution.state.turned[:, solution.model.topology.number[joint.first]])
    return turned(np.moveaxis(turn, -1, 0).reshape(*frame.shape, 3, 3), start)
