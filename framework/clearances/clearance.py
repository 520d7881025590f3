"""Equilibrium of a frame whose joints have clearance: the position of each journal in its bearing.

A joint of stiffness k and clearance ε has the energy ``W(δ) = min over |o| ≤ ε of k/2 |δ − o|²``: it is the joint
without clearance, with an offset o for which the energy of the whole frame is least,

    minimise  ½ o·S o − f·o   subject to |o_j| ≤ ε_j in each joint,

with f the joint forces of the frame without clearance and S their decrease per unit offset in each joint. So the frame
is solved once under its loads and once for the unit offsets, for any stiffness, k = inf included; what remains is a
problem of two or three numbers for each joint, see `ball_qp`. Where joint forces follow from equilibrium alone, S
vanishes and the offsets have the directions of the forces, ``o = ε f/|f|``: the extreme position that the linkage can
reach in the direction of the load (see `determinate`).
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
from ..factor_cache import Factors
from ..results.linear import LinearResults
from ..states import ClearanceState, States, put
from ..structure.parts import collapsed
from .contact import Contact
from .contact_state import ClearanceComponents, ContactState, sizes
from .determinate import (
    DeterminateContact,
    determinate_contact,
    forces_by_work,
    rounding_of_forces,
    told_by_work,
)
from .unit_motions import Solvers
from .unit_offsets import Resistance, against_offsets, resists_at_first_entry

# Largest number of entries of the stiffness against offsets that is kept for the next solution.
_KEPT = 2**16


def joints_with_clearance(frame: Description) -> list[str]:
    """Names of the joints with clearance."""
    given = ((name, joint.element.clearance) for name, joint in frame.joints.items())
    # a single number is compared as a Python float, which takes a quarter of the time
    return [name for name, gap in given if (gap.item() if gap.size == 1 else np.count_nonzero(gap))]


class Clearances:
    """The clearances of a frame in equilibrium under its loads.

    Parameters
    ----------
    frame
        The frame.
    without_clearance
        Its solution without clearances.
    solvers
        Functions that return solutions without clearances of a description.
    factors
        What is kept of the frame for its solution under other loads.

    Attributes
    ----------
    names
        Names of the joints with clearance.
    lost
        Entries that certainly have no results, (...): left out, or kinematically unstable under the loads.
    unfit
        Entries without results because no offset is compatible with a loop of rigid links, (...).
    determinate
        Contact in closed form, where it may apply; else None.
    """

    def __init__(
        self, frame: Description, without_clearance: LinearResults, solvers: Solvers, factors: Factors
    ) -> None:
        self.frame, self.names = frame, joints_with_clearance(frame)
        joints = [frame.joints[name].element for name in self.names]
        own = np.repeat(np.arange(len(joints)), [len(joint.clearance_directions) for joint in joints])
        self._components = ClearanceComponents(
            self.names, own, [k for joint in joints for k in joint.clearance_directions]
        )
        self._without_clearance, self._asked = without_clearance, without_clearance.plan.asked
        self.determinate: DeterminateContact | None = None
        by_chunks = without_clearance.plan.medium or without_clearance.by_chunks
        solvers = solvers if by_chunks else solvers._replace(per_unit=None)
        self._resists = by_chunks and resists_at_first_entry(frame, self._components, solvers)
        if self._resists:
            self._joint_forces  # noqa: B018  # in one pass with the pivots, which tell what is lost
        self.lost = without_clearance.lost
        self._resistance = self._resisting(solvers, factors)
        self.unfit = np.broadcast_to(self._resistance.unfit, frame.shape)
        if self.unfit.any():
            self._warn_unfit()
        if self._resistance.motions is not None and not self._resistance.stiffness.any():
            radius, motions = [joint.clearance for joint in joints], self._resistance.motions
            self.determinate = determinate_contact(self._components, radius, without_clearance, motions)
        if self.determinate is None:
            # results of other solutions that contact needs are computed now, so that these need not be kept
            self.contact_state  # noqa: B018
            self._resistance = replace(self._resistance, motions=None)
            del self._without_clearance

    @cached_property
    def contact_state(self) -> ContactState:
        """Contact state of all journals."""
        state = self._state(self._resistance.stiffness, self._resistance.members)
        if self.unfit.any():
            state = replace(state, radius=np.where(self.unfit, 0.0, state.radius))
        if self.determinate is not None:
            return replace(state, rounding=self.determinate.rounding)
        return self._without_rounding(state)

    def _resisting(self, solvers: Solvers, factors: Factors) -> Resistance:
        """The resistance to offsets, that of the last solution where only loads have changed since."""
        lost = bool(self.lost.any())
        known: Resistance | None = None if lost else factors.resistance
        if known is None:
            loaded = None if self._resists else [*self._without_clearance.plan.forces]
            known = against_offsets(self.frame, self._components, self._bearing, self.lost, solvers, loaded)
            # that of a mechanism, which is without motions, depends on the loads
            small = known.motions is not None and max(known.stiffness.size, known.motions.entries) <= _KEPT
            if small and not lost:
                factors.resistance = known
        return known

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
        """A contact state whose forces, in components without stiffness against offsets, come from virtual work."""
        motions, resisted = self._resistance.motions, state.stiffness.any(axis=0)
        if motions is None or resisted.all() or not told_by_work(state.components, self._without_clearance, motions):
            return state
        if not resisted.any() and motions.strained:
            return state
        told = resisted | self._singular
        found = np.where(told, state.found, forces_by_work(self._without_clearance, motions))
        return replace(state, found=found, rounding=rounding_of_forces(state.components, motions, state.found.ndim - 1))

    @cached_property
    def _force(self) -> Array:
        """Joint forces without clearance in the n components with clearance, (n, ...); NaN at mechanisms."""
        if self.determinate is not None:
            forces = forces_by_work(self._without_clearance, self.determinate.motions)
            forces[:, self.lost] = np.nan
            return forces
        return self._joint_forces

    @cached_property
    def _joint_forces(self) -> Array:
        """These forces as the solution without clearance has them."""
        # no warning: the state of contact is "mechanism" where the frame is one
        return self._without_clearance.silenced().joint_components(self._components.pairs)

    @cached_property
    def _singular(self) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = np.asarray(np.isnan(self._force).any(axis=0))
        return found

    def _bearing(self) -> NDArray[np.bool_]:
        """Whether a component carries a force above rounding, (n, ...)."""
        none = np.zeros(())
        return np.asarray(self._state(none, none).without_clearance != 0.0)

    @cached_property
    def state(self) -> States:
        """State of each joint, a `ContactState`, (joints, ...)."""
        state = self.contact_state.state
        unknown = self._resistance.unknown
        if unknown.any():  # without forces in joints no contact is hidden
            unknown = unknown & (self.contact_state.without_clearance != 0.0).any(axis=0)
        for lost, why in (
            (self.unfit, ClearanceState.UNRESOLVED),
            (unknown, ClearanceState.UNRESOLVED),
            (self._singular, ClearanceState.MECHANISM),
            (self.frame.absent, ClearanceState.ABSENT),
        ):
            if lost is not None and np.any(lost):
                state = put(state, lost, why)
        return state

    def offsets(self) -> Description:
        """The frame with the position of each journal imposed as an offset of its joint."""
        out = self.frame.copy()
        for (name, k), offset in zip(self.contact_state.components.pairs, self.contact_state.offset, strict=True):
            imposed = self.frame.offsets.get(name, {}).get(k, 0.0)
            out.offset(name, **{DISPLACEMENTS[k]: imposed + offset})
        return out

    def plan(self, without_clearance: Plan) -> Plan:
        """The plan of that frame, reusing what is known of its members from the plan without clearance."""
        former = Former(without_clearance.unloaded, moved=False, elements=False, linked=False)
        return Plan(self.offsets(), method=self._asked, former=former)

    def contact(self, name: str) -> Contact:
        """Contact in a joint."""
        j = self.names.index(name)
        state, radius = np.asarray(self.state[j]), self.contact_state.radius[j]
        closed = np.asarray(state == ClearanceState.CLOSED)
        offset, force = self._vector(j, self.contact_state.offset), self._vector(j, self.contact_state.force)
        along = np.where((radius > 0.0)[..., None], offset, force)
        normal = along / np.where(closed, np.hypot.reduce(along, axis=-1), 1.0)[..., None]
        axes = self.frame.joints[name].element.axes
        normal = normal if axes is None else rotated(aligned(axes, len(self.frame.shape), 2), normal)
        unknown = np.where(state >= ClearanceState.UNRESOLVED, np.nan, 0.0)
        return Contact(
            joint=name,
            state=state,
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
    """Largest force component and largest moment component on any node, (2, ...)."""
    out: Array = np.zeros((2, *plan.frame.shape))
    for a, by_source in plan.forces.items():
        value = np.abs(np.asarray(collapsed(by_source, plan.rhs_parameters.values), dtype=np.float64))
        out[a % 6 // 3] = np.maximum(out[a % 6 // 3], value)
    return out
