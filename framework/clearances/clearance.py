"""Equilibrium of a frame whose joints have clearance: where each journal rests in its bearing.

A joint of stiffness k and clearance ε holds the energy ``W(δ) = min over |o| ≤ ε of k/2 |δ − o|²``: it is the joint
without clearance, its springs about an offset o that lies where the energy of the whole frame is least,

    minimise  ½ o·S o − f·o   subject to |o_j| ≤ ε_j in each joint,

with f the forces in the joints of the frame without clearance and S their fall for a unit offset in each. So the frame
is solved once under its loads and once for the unit offsets, whatever it holds, k = inf included; what is left is a
problem of two or three numbers a joint, see `balls`. Where joint forces follow from equilibrium alone, S vanishes and
the journals lie along them, ``o = ε f/|f|``: the extreme point of what the linkage can reach in the load's direction.
"""

from __future__ import annotations

import warnings
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned, rotated
from ..batched.plan import Plan
from ..batched.stage import collapsed
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..errors import MechanismWarning
from ..results.linear import LinearResults
from .contact import ABSENT, CLOSED, MECHANISM, STATES, UNRESOLVED, Contact
from .contact_state import ClearanceComponents, ContactState
from .unit_offsets import Solve, against_offsets


def joints_with_clearance(frame: Description) -> list[str]:
    """Names of the joints with clearance."""
    return [name for name, joint in frame.joints.items() if np.count_nonzero(joint.element.clearance)]


class Clearances:
    """The clearances of a frame in equilibrium under its loads.

    Parameters
    ----------
    frame
        The frame.
    without_clearance
        Its solution without clearances.
    solve
        Makes such a solution of a description.

    Attributes
    ----------
    names
        The joints with clearance.
    contact_state
        Where their journals are in contact.
    """

    def __init__(self, frame: Description, without_clearance: LinearResults, solve: Solve) -> None:
        self.frame, self.names = frame, joints_with_clearance(frame)
        joints = [frame.joints[name].element for name in self.names]
        own = np.repeat(np.arange(len(joints)), [len(joint.clearance_directions) for joint in joints])
        components = ClearanceComponents(self.names, own, [k for joint in joints for k in joint.clearance_directions])
        with warnings.catch_warnings():
            # Entries that are mechanisms have no contact, which their state tells.
            warnings.simplefilter("ignore", MechanismWarning)
            force = np.stack([without_clearance.joint_force(name)[..., k] for name, k in components.pairs])
        self._singular = np.asarray(np.isnan(force).any(axis=0))
        loaded = np.any(force.reshape(len(force), -1) != 0.0, axis=1)
        self._resistance = against_offsets(frame, components, loaded, solve)
        radius = np.stack([np.broadcast_to(joint.clearance, frame.shape) for joint in joints])
        force = np.nan_to_num(force) if self._singular.any() else force
        resistance, load = self._resistance, _load(without_clearance.plan)
        self.contact_state = ContactState(
            components, resistance.stiffness, resistance.members, force, radius, load, frame.size
        )

    @cached_property
    def state(self) -> NDArray[np.uint8]:
        """Number of the state of each joint, see `Contact`, (joints, ...)."""
        state = self.contact_state.state
        for lost, why in (
            (self._resistance.unknown, UNRESOLVED),
            (self._singular, MECHANISM),
            (self.frame.absent, ABSENT),
        ):
            if lost is not None and np.any(lost):
                state = np.where(lost, np.uint8(why), state)
        return state

    def offsets(self) -> Description:
        """The frame with each journal where it rests, as offsets of its joints."""
        out = self.frame.copy()
        for (name, k), offset in zip(self.contact_state.components.pairs, self.contact_state.offset, strict=True):
            imposed = self.frame.offsets.get(name, {}).get(k, 0.0)
            out.offset(name, **{DISPLACEMENTS[k]: imposed + offset})
        return out

    def contact(self, name: str) -> Contact:
        """Contact in a joint."""
        j = self.names.index(name)
        state, radius = np.asarray(self.state[j]), self.contact_state.radius[j]
        closed = np.asarray(state == CLOSED)
        offset, force = self._vector(j, self.contact_state.offset), self._vector(j, self.contact_state.force)
        along = np.where((radius > 0.0)[..., None], offset, force)
        normal = along / np.where(closed, np.hypot.reduce(along, axis=-1), 1.0)[..., None]
        axes = self.frame.joints[name].element.axes
        normal = normal if axes is None else rotated(aligned(axes, len(self.frame.shape), 2), normal)
        unknown = np.where(state >= UNRESOLVED, np.nan, 0.0)
        return Contact(
            joint=name,
            state=STATES[state],
            normal=np.where(closed[..., None], normal, unknown[..., None]),
            force=np.where(closed, self.contact_state.size[j], unknown),
            gap=np.where(closed, 0.0, radius - np.hypot.reduce(offset, axis=-1) + unknown),
            offset=offset,
        )

    def _vector(self, j: int, values: Array) -> Array:
        """Values by component, (n, ...), as vectors in the axes of joint j, (..., 3)."""
        out = np.zeros((*self.frame.shape, 3))
        for index in np.flatnonzero(self.contact_state.components.own == j):
            out[..., self.contact_state.components.component[index] % 3] = values[index]
        return out


def _load(plan: Plan) -> Array:
    """Largest force and largest moment on a node, (2, ...)."""
    out: Array = np.zeros((2, *plan.frame.shape))
    for a, by_source in plan.forces.items():
        value = np.abs(np.asarray(collapsed(by_source, plan.rhs_parameters.values), dtype=np.float64))
        out[a % 6 // 3] = np.maximum(out[a % 6 // 3], value)
    return out
