"""Contact in a joint with clearance, in an equilibrium at large displacement."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..clearances.contact import ABSENT, CLOSED, OPEN, STATES, UNRESOLVED, Contact
from ..clearances.contact_state import UNLOADED
from .equations import EquilibriumEquations
from .numbers import batch_first
from .results import LargeResults
from .start import TOUCHING
from .state import DisplacedState

# Largest unbalanced force over the largest force of an equilibrium that counts as certain.
_BALANCED = 1e-6


def contact(solution: LargeResults, name: str, number: int) -> Contact:
    """Where a joint (of this number) is in contact, and how hard it is pressed; its axes turned with its first node."""
    frame, joint = solution.frame, solution.frame.joints[name]
    directions = list(joint.element.clearance_directions)
    gap = _vector(solution, directions, _beyond(solution, number)[directions])
    force = _vector(solution, directions, -solution.linear.own[directions, number])
    radius = np.broadcast_to(joint.element.clearance, frame.shape)
    length, contact_force = (np.hypot.reduce(vector, axis=-1) for vector in (gap, force))
    largest = np.abs(solution.linear.nodal[:3]).max(axis=(0, 1)).reshape(contact_force.shape)
    closed = _closed(solution, number, (length >= radius * (1.0 - TOUCHING)) & (contact_force > UNLOADED * largest))
    state = np.where(closed, CLOSED, OPEN)
    state = np.where(solution.converged, state, UNRESOLVED)
    state = state if frame.absent is None else np.where(frame.absent, ABSENT, state)
    unknown = np.where(state >= UNRESOLVED, np.nan, 0.0)
    along = force / np.where(contact_force > 0.0, contact_force, 1.0)[..., None]
    inside = gap * np.where(closed, radius / np.where(length > 0.0, length, 1.0), 1.0)[..., None]
    return Contact(
        joint=name,
        state=STATES[state],
        normal=np.where(closed[..., None], solution.joint_global(name, along), 0.0) + unknown[..., None],
        force=np.where(closed, contact_force, 0.0) + unknown,
        gap=np.where(closed, 0.0, np.maximum(radius - length, 0.0)) + unknown,
        offset=inside + unknown[..., None],
    )


def touched(equations: EquilibriumEquations, state: DisplacedState) -> DisplacedState:
    """The state, and journals whose springs deflect under a small force by less than rounding on their circles."""
    model, forces = equations.model, None
    for number, joint in enumerate(model.joints):
        if not joint.clearance_directions or joint.rigid:
            continue
        directions, radius = list(joint.clearance_directions), joint.clearance.at(equations.where)
        beyond = state.own[directions, number] - equations.factor * joint.offset.at(equations.where)[directions]
        length = np.hypot.reduce(beyond, axis=0)
        near = (length <= radius) & (length >= radius * (1.0 - TOUCHING)) & (radius > 0.0)
        if near.any():
            forces = equations.linearised(state, tangents=False) if forces is None else forces
            pressed = np.hypot.reduce(forces.own[directions, number], axis=0)
            near &= pressed > UNLOADED * np.abs(forces.nodal[:3]).max(axis=(0, 1))
            state.own[directions, number] += np.where(near, 2.0 * TOUCHING * beyond, 0.0)
    if forces is not None:
        equations.follow(state)
    return state


def unbalanced(solution: LargeResults) -> NDArray[np.bool_]:
    """Where forces are left that are not small, and more than rounding or with a journal not pressed, (entries,).

    Nothing resists such a journal, and forces below the rounding of others may still drive it.
    """
    unconverged = np.asarray(solution.residual > _BALANCED).reshape(-1)
    if not unconverged.any():
        return unconverged
    model, trust, at = solution.model, solution.trust, solution.linear
    own = np.setdiff1d(np.arange(model.free), model.multipliers)
    # what is wrong is what is unbalanced, and the rounding in it
    more: NDArray[np.bool_] = (2.0 * np.abs(trust.at.forces) > trust.wrong)[own].any(axis=0)
    for number, joint in enumerate(model.edges):
        if joint.clearance_directions:
            directions = list(joint.clearance_directions)
            length, contact_force = (
                np.hypot.reduce(v[directions], axis=0) for v in (_beyond(solution, number), at.own[:, number])
            )
            more |= length < joint.clearance.at(solution.equations.where) * (1.0 - TOUCHING)
            more |= contact_force <= UNLOADED * np.abs(at.nodal[:3]).max(axis=(0, 1))
    return unconverged & more


def _beyond(solution: LargeResults, number: int) -> Array:
    """Displacement of a joint beyond its imposed offset (6, m)."""
    equations = solution.equations
    return equations.own(solution.displaced, number) - solution.model.edges[number].offset.at(equations.where)


def _closed(solution: LargeResults, number: int, beyond: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether a joint is pressed: a rigid one by its force, one with a stiffness where it is `beyond` its clearance."""
    if number not in solution.model.contacts:
        return beyond
    force = solution.displaced.contact_multipliers.force[:, solution.model.contacts[number]]
    largest = np.abs(solution.linear.nodal[:3]).max(axis=(0, 1))
    pressed: NDArray[np.bool_] = np.hypot.reduce(force, axis=0) > UNLOADED * largest
    return pressed.reshape(beyond.shape)


def _vector(solution: LargeResults, directions: list[int], values: Array) -> Array:
    """Values by clearance direction, (n, m), as vectors in the joint's axes, (..., 3)."""
    out = np.zeros((3, values.shape[-1]))
    out[[k % 3 for k in directions]] = values
    return batch_first(out, solution.shape, 1)
