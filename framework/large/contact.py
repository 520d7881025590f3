"""Contact in a joint with clearance, in an equilibrium at large displacement."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned, turned
from ..clearances.contact import ABSENT, CLOSED, OPEN, STATES, UNRESOLVED, Contact
from ..clearances.resting import UNLOADED
from . import rotation
from .numbers import batch_first

if TYPE_CHECKING:
    from .solution import LargeSolution


def contact(solution: LargeSolution, name: str, number: int) -> Contact:
    """Where a joint (of this number) is in contact, and how hard it is pressed; its axes turned with its first node."""
    frame, joint = solution.frame, solution.frame.joints[name]
    play = list(joint.element.play)
    gap = _vector(solution, play, _beyond(solution, number)[play])
    force = _vector(solution, play, -solution.linear.own[play, number])
    radius = np.broadcast_to(joint.element.clearance, frame.shape)
    length, press = (np.linalg.norm(vector, axis=-1) for vector in (gap, force))
    closed = _closed(solution, number, length > radius)
    state = np.where(closed, CLOSED, OPEN)
    state = np.where(solution.converged, state, UNRESOLVED)
    state = state if frame.absent is None else np.where(frame.absent, ABSENT, state)
    unknown = np.where(state >= UNRESOLVED, np.nan, 0.0)
    along = force / np.where(press > 0.0, press, 1.0)[..., None]
    inside = gap * np.where(closed, radius / np.where(length > 0.0, length, 1.0), 1.0)[..., None]
    return Contact(
        joint=name,
        state=STATES[state],
        normal=np.where(closed[..., None], _turned(solution, name, along), 0.0) + unknown[..., None],
        force=np.where(closed, press, 0.0) + unknown,
        gap=np.where(closed, 0.0, np.maximum(radius - length, 0.0)) + unknown,
        offset=inside + unknown[..., None],
    )


def _beyond(solution: LargeSolution, number: int) -> Array:
    """Displacement of a joint beyond its imposed offset (6, m)."""
    equations = solution.equations
    return equations.own(solution.state, number) - solution.model.edges[number].offset.at(equations.where)


def _closed(solution: LargeSolution, number: int, beyond: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a joint is pressed: a rigid one by its force, one with a stiffness where it is `beyond` its play."""
    if number not in solution.model.contacts:
        return beyond
    force = solution.state.grip.force[:, solution.model.contacts[number]]
    largest = np.abs(solution.linear.nodal[:3]).max(axis=(0, 1))
    pressed: NDArray[np.bool_] = np.sqrt((force**2).sum(axis=0)) > UNLOADED * largest
    return pressed.reshape(beyond.shape)


def _vector(solution: LargeSolution, play: list[int], values: Array) -> Array:
    """Values by component with play, (n, m), as vectors in the joint's axes, (..., 3)."""
    out = np.zeros((3, values.shape[-1]))
    out[[k % 3 for k in play]] = values
    return batch_first(out, solution.shape, 1)


def _turned(solution: LargeSolution, name: str, along: Array) -> Array:
    """Vectors in a joint's axes as global ones, (..., 3)."""
    frame, joint = solution.frame, solution.frame.joints[name]
    axes = joint.element.axes
    start = along if axes is None else turned(aligned(axes, len(frame.shape), 2), along)
    turn = rotation.matrix(solution.state.turned[:, solution.model.topology.number[joint.first]])
    return turned(np.moveaxis(turn, -1, 0).reshape(*frame.shape, 3, 3), start)
