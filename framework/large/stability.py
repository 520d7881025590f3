"""Stability out of the plane to which a solution was kept."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..batch import Array
from . import rotation
from .elimination import LARGE, Elimination
from .equations import Equations
from .model import Model
from .state import State

if TYPE_CHECKING:
    from .march import March


def least_pivot(march: March, state: State, flat: Model) -> Array:
    """Least eigenvalue (of a large frame: pivot) of the tangent in space, scaled to a unit diagonal, (entries,).

    inf, nothing found against it, where supports out of the plane close loops.
    """
    model = Model(flat.plan, flat=False, clearance=flat.clearance)
    if model.loops:
        return np.full(march.count, np.inf)
    _, rows, columns = model.pattern
    elimination = Elimination(rows, columns, model.free)
    out = np.empty(march.count)
    for begin in range(0, march.count, march.chunk):
        index = np.arange(begin, min(begin + march.chunk, march.count))
        equations = Equations(model, march.where(index), len(index))
        values = equations.linearised(_state(model, flat, state.taken(index))).values
        if elimination.size > LARGE:
            out[index] = elimination.factor(values).pivots.min(axis=0)
            continue
        out[index] = elimination.spectrum(values)[1][:, 0]
    return out


def _state(model: Model, flat: Model, state: State) -> State:
    """The state with the links of `model`, which has some supports more that hold motion out of the plane."""
    place = {joint.child: number for number, joint in enumerate(flat.joints)}
    own = [
        state.own[:, place[joint.child]]
        if joint.child in place
        else np.concatenate([state.moved[:, joint.child], rotation.logarithm(state.turned[:, joint.child])])
        for joint in model.joints
    ]
    joints = [place[model.joints[number].child] for number in model.contacts]
    grip = state.grip.those([flat.contacts[number] for number in joints])
    return State(state.moved, state.turned, np.stack(own, axis=1) if own else state.own, grip)
