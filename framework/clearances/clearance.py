"""Equilibrium of a frame whose joints have clearance: where each journal rests in its bearing.

A joint of stiffness k and clearance ε holds the energy ``W(δ) = min over |o| ≤ ε of k/2 |δ − o|²``: it is the joint
without clearance, its springs about an offset o that lies where the energy of the whole frame is least,

    minimise  ½ o·S o − f·o   subject to |o_j| ≤ ε_j in each joint,

with f the forces in the joints of the frame without clearance and S their fall for a unit offset in each. So the frame
is solved once under its loads and once for the unit offsets, whatever it holds, k = inf included; what is left is a
problem of two or three numbers a joint, see `balls`. Where joint forces follow from equilibrium alone, S vanishes and
the journals lie along them, ``o = ε f/|f|``: the extreme point of what the linkage can reach in the load's direction
(see `determinate`).
"""

from __future__ import annotations

import warnings
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned, rotated
from ..batched.plan import Plan
from ..batched.unloaded import Former
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..errors import MechanismWarning
from ..results.linear import LinearResults
from ..structure.parts import collapsed
from .contact import ABSENT, CLOSED, MECHANISM, STATES, UNRESOLVED, Contact
from .contact_state import ClearanceComponents, ContactState, sizes
from .determinate import (
    DeterminateContact,
    determinate_contact,
    forces_by_work,
    rounding_of_forces,
    strained,
    told_by_work,
)
from .unit_offsets import Solve, against_offsets


def joints_with_clearance(frame: Description) -> list[str]:
    """Names of the joints with clearance."""
    # that of one entry is asked as a number, which takes a quarter of the time
    return [
        name
        for name, joint in frame.joints.items()
        if (gap.item() if (gap := joint.element.clearance).size == 1 else np.count_nonzero(gap))
    ]


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
    lost
        Entries without results of which that is plain: left out, or set in motion by the loads, (...).
    unfit
        Entries at which no offset fits a loop of rigid links, and which have no results, (...).
    determinate
        Contact in closed form where that may do; None elsewhere.
    """

    def __init__(self, frame: Description, without_clearance: LinearResults, solve: Solve) -> None:
        self.frame, self.names = frame, joints_with_clearance(frame)
        joints = [frame.joints[name].element for name in self.names]
        own = np.repeat(np.arange(len(joints)), [len(joint.clearance_directions) for joint in joints])
        self._components = ClearanceComponents(
            self.names, own, [k for joint in joints for k in joint.clearance_directions]
        )
        self._without_clearance, self._asked = without_clearance, without_clearance.plan.asked
        self.determinate: DeterminateContact | None = None
        self.lost = without_clearance.lost
        self._resistance = against_offsets(frame, self._components, self._bearing, self.lost, solve)
        self.unfit = np.broadcast_to(self._resistance.unfit, frame.shape)
        if self.unfit.any():
            self._warn_unfit()
        if self._resistance.motions is not None and not self._resistance.stiffness.any():
            radius, motions = [joint.clearance for joint in joints], self._resistance.motions
            self.determinate = determinate_contact(self._components, radius, without_clearance, motions)
        if self.determinate is None:
            # what contact takes of other solutions is taken now, so that they need not be held
            self.contact_state  # noqa: B018
            self._resistance = replace(self._resistance, motions=None)
            del self._without_clearance

    @cached_property
    def contact_state(self) -> ContactState:
        """Where the journals are in contact."""
        state = self._state(self._resistance.stiffness, self._resistance.members)
        if self.unfit.any():
            state = replace(state, radius=np.where(self.unfit, 0.0, state.radius))
        if self.determinate is not None:
            return replace(state, rounding=self.determinate.rounding)
        return self._without_rounding(state)

    def _warn_unfit(self) -> None:
        warnings.warn(
            f"{self.unfit.sum()} of {self.unfit.size} batch entries are unresolved and their results are NaN: there "
            f"ideal joints among {', '.join(self.names)} close a loop of rigid links in which no offset fits, as in a "
            "line; give one of them a finite stiffness",
            MechanismWarning,
            stacklevel=5,
        )

    def _state(self, stiffness: Array, members: Array) -> ContactState:
        frame = self.frame
        radius = np.stack([np.broadcast_to(frame.joints[name].element.clearance, frame.shape) for name in self.names])
        force = np.nan_to_num(self._force) if self._singular.any() else self._force
        load = _load(self._without_clearance.plan)
        return ContactState(self._components, stiffness, members, force, radius, load, sizes(frame))

    def _without_rounding(self, state: ContactState) -> ContactState:
        """The same, with forces by the work of the loads in components that no stiffness resists."""
        motions, resisted = self._resistance.motions, state.stiffness.any(axis=0)
        if motions is None or resisted.all() or not told_by_work(state.components, self._without_clearance, motions):
            return state
        if not resisted.any() and strained(motions):
            return state
        told = resisted | self._singular
        found = np.where(told, state.found, forces_by_work(self._without_clearance, motions))
        return replace(state, found=found, rounding=rounding_of_forces(state.components, motions, state.found.ndim - 1))

    @cached_property
    def _force(self) -> Array:
        """Forces without clearance by component, (n, ...); NaN at mechanisms."""
        if self.determinate is not None:
            forces = forces_by_work(self._without_clearance, self.determinate.motions)
            forces[:, self.lost] = np.nan
            return forces
        # entries that are mechanisms have no contact, which their state tells
        quiet = self._without_clearance.silenced()
        return np.stack([quiet.joint_force(name)[..., k] for name, k in self._components.pairs])

    @cached_property
    def _singular(self) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = np.asarray(np.isnan(self._force).any(axis=0))
        return found

    def _bearing(self) -> NDArray[np.bool_]:
        """Which components bear a force that is more than rounding, (n, ...)."""
        none = np.zeros(())
        return np.asarray(self._state(none, none).without_clearance != 0.0)

    @cached_property
    def state(self) -> NDArray[np.uint8]:
        """Number of the state of each joint, see `Contact`, (joints, ...)."""
        state = self.contact_state.state
        for lost, why in (
            # without any force in a joint none of its contacts is hidden
            (self.unfit, UNRESOLVED),
            (self._resistance.unknown & (self.contact_state.without_clearance != 0.0).any(axis=0), UNRESOLVED),
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

    def plan(self, without_clearance: Plan) -> Plan:
        """That frame compiled, with what is known of its members without clearance."""
        former = Former(without_clearance.unloaded, moved=False, elements=False, linked=False)
        return Plan(self.offsets(), method=self._asked, former=former)

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
