"""Stability out of the plane to which a solution was kept."""

from __future__ import annotations

import numpy as np

from .. import rotation
from .equations import EquilibriumEquations
from .load_stepping import LoadStepping
from .model import Model
from .newton import Newton
from .protocols import Mask
from .rounding import ForceRounding
from .state import DisplacedState


def definite_in_space(continuation: LoadStepping, state: DisplacedState, planar_model: Model) -> Mask:
    """Whether the tangent in space has no negative eigenvalue beyond rounding, (entries,); not of those left out."""
    newton = Newton(Model(planar_model.plan, in_plane=False, clearance=planar_model.clearance))
    out = np.zeros(continuation.count, dtype=bool)
    for index in continuation.pieces():
        where = continuation.where(index)
        inside = EquilibriumEquations(planar_model, where, len(index))
        there = in_space(newton.model, inside, state.taken(index))
        at = EquilibriumEquations(newton.model, where, len(index)).linearised(there)
        out[index] = newton.clear(at.values)
        unclear = np.flatnonzero(~out[index])
        if len(unclear):
            some, place = tuple(k[unclear] for k in where), there.taken(unclear)
            equations = EquilibriumEquations(newton.model, some, len(unclear))
            at = equations.linearised(place)
            rounding = ForceRounding(equations, place, at).tangents()
            out[index[unclear]] = newton.definite(at.values, rounding)
    return out


def in_space(model: Model, inside: EquilibriumEquations, state: DisplacedState) -> DisplacedState:
    """A state with the links and loops of `model`, which has some supports more that hold motion out of the plane."""
    planar_model = inside.model
    place = {joint.edge: number for number, joint in enumerate(planar_model.edges)}
    forces = inside.linearised(state, tangents=False).own
    own = np.zeros((6, len(model.edges), inside.count))
    for number, joint in enumerate(model.edges):
        known, links = place.get(joint.edge), len(model.joints)
        if number >= links and known is not None:
            constrained = model.multipliers[:, number - links] >= 0
            own[constrained, number] = -forces[constrained, known]
        elif number < links and known is not None:
            own[:, number] = joint.shortest(inside.own(state, known))
        elif number < links:
            own[:3, number] = state.displacements[:, joint.child]
            own[3:, number] = rotation.logarithm(state.rotations[:, joint.child])
    contact_multipliers = state.contact_multipliers.those(
        [planar_model.contacts[place[model.edges[number].edge]] for number in model.contacts]
    )
    return DisplacedState(state.displacements, state.rotations, own, contact_multipliers)
