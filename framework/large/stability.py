"""Stability out of the plane to which a solution was kept."""

from __future__ import annotations

import numpy as np

from .. import rotation
from .equations import EquilibriumEquations
from .found import Mask
from .march import LoadStepping
from .model import Model
from .newton import Newton
from .state import DisplacedState


def definite_in_space(march: LoadStepping, state: DisplacedState, flat: Model) -> Mask:
    """Whether the tangent in space has no negative eigenvalue beyond rounding, (entries,)."""
    newton = Newton(Model(flat.plan, flat=False, clearance=flat.clearance))
    out = np.empty(march.count, dtype=bool)
    for begin in range(0, march.count, march.chunk):
        index = np.arange(begin, min(begin + march.chunk, march.count))
        where = march.where(index)
        inside = EquilibriumEquations(flat, where, len(index))
        there = _state(newton.model, inside, state.taken(index))
        out[index] = newton.definite(EquilibriumEquations(newton.model, where, len(index)).linearised(there).values)
    return out


def _state(model: Model, inside: EquilibriumEquations, state: DisplacedState) -> DisplacedState:
    """The state with the links and loops of `model`, which has some supports more that hold motion out of the plane."""
    flat = inside.model
    place = {joint.edge: number for number, joint in enumerate(flat.edges)}
    forces = inside.linearised(state).own
    own = np.zeros((6, len(model.edges), inside.count))
    for number, joint in enumerate(model.edges):
        known, links = place.get(joint.edge), len(model.joints)
        if number >= links and known is not None:
            held = model.multipliers[:, number - links] >= 0
            own[held, number] = -forces[held, known]
        elif number < links and known is not None:
            own[:, number] = inside.own(state, known)
        elif number < links:
            own[:3, number] = state.moved[:, joint.child]
            own[3:, number] = rotation.logarithm(state.turned[:, joint.child])
    grip = state.grip.those([flat.contacts[place[model.edges[number].edge]] for number in model.contacts])
    return DisplacedState(state.moved, state.turned, own, grip)
