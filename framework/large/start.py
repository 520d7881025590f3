"""Where a load begins: at rest, or with journals where the forces of the frame without clearances press them."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from .equations import EquilibriumEquations
from .joint_law import ContactMultipliers
from .joints import TreeJoint
from .model import Model
from .newton import Newton
from .numbers import Where
from .protocols import Place
from .search import Search
from .state import DisplacedState

# Share of a clearance within which a journal counts as touching its circle: a few roundings.
TOUCHING = 4.0 * float(np.finfo(np.float64).eps)
# Stiffness by which a rigid contact is found, in units of what it meets.
_STIFFER = 10.0
# Clearance, in sizes of the frame or radians, below which it does not soften what a journal meets.
_SMALL = 1e-9


def start(newton: Newton, where: Where, count: int, factor: float) -> Place:
    """The state in which a search at a share `factor` of the loads had better begin."""
    model = newton.model
    with_clearance = [number for number, joint in enumerate(model.edges) if joint.clearance_directions]
    if not with_clearance:
        return newton.start(count)
    without_clearance = Newton(Model(model.plan, clearance=False))
    found = Search(without_clearance).solve(where, without_clearance.start(count), 0.0, factor)
    state = without_clearance.space(found.state)
    equations = EquilibriumEquations(without_clearance.model, where, count, factor)
    own = equations.linearised(state, tangents=False).own
    known = found.converged & np.isfinite(own).all(axis=(0, 1))
    forces = np.where(known, -own, 0.0)
    # what constrained these loops in the components that now have clearance
    state.own[:, len(model.joints) :] *= (model.multipliers >= 0)[..., None]
    state.contact_multipliers = DisplacedState.start(model, count).contact_multipliers
    for number in with_clearance:
        if number < len(model.joints):
            _place(state, number, model.joints[number], forces, model.joints[number].clearance.at(where))
    equations = EquilibriumEquations(model, where, count, factor)
    equations.follow(state)
    if model.contacts:
        state.contact_multipliers = _guess(newton, equations, state, forces)
    return newton.place(state, found.state)


def _place(state: DisplacedState, number: int, joint: TreeJoint, forces: Array, radius: Array) -> None:
    directions = list(joint.clearance_directions)
    push = forces[directions, number]
    size = np.hypot.reduce(push, axis=0)
    if not joint.rigid:
        # in contact, though the springs deflect under a small force by less than rounding
        radius = radius * (1.0 + TOUCHING)
    state.own[directions, number] += radius * (push / np.where(size > 0.0, size, 1.0))


def _guess(newton: Newton, equations: EquilibriumEquations, state: DisplacedState, forces: Array) -> ContactMultipliers:
    """Guesses of the forces in rigid contacts, and the stiffnesses by which they are corrected."""
    model = newton.model
    force, stiffness = (
        np.zeros_like(state.contact_multipliers.force),
        np.empty_like(state.contact_multipliers.stiffness),
    )
    met = _met(model, equations.linearised(state).values)
    for number, place in model.contacts.items():
        joint = model.edges[number]
        directions = list(joint.clearance_directions)
        force[directions, place] = forces[directions, number]
        is_rotation = directions[0] >= 3
        radius = np.maximum(joint.clearance.at(equations.where), _SMALL * (1.0 if is_rotation else equations.lengths))
        nodes = [joint.child] if number < len(model.joints) else slice(None)
        columns = model.columns[3:] if is_rotation else model.columns[:3]
        pressed = np.hypot.reduce(force[:, place], axis=0) / radius
        most = np.maximum(met[columns[:, nodes]].max(axis=(0, 1)), pressed)
        stiffness[place] = _STIFFER * np.where(most > 0.0, most, 1.0)
    return ContactMultipliers(force, stiffness)


def _met(model: Model, values: Array) -> Array:
    """Stiffness against each coordinate alone, and zero for those that are constrained (size + 1, m)."""
    _, rows, columns = model.pattern
    out = np.zeros((model.size + 1, values.shape[-1]))
    own = np.flatnonzero(rows == columns)
    out[rows[own]] = np.abs(values[own])
    return out
