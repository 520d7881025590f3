"""The search for the contact of all journals at equilibrium, at all entries of a batch at once."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..description import Description
from ..factor_cache import Factors
from ..results.linear import LinearResults
from ..states import ClearanceState, States, put
from ..structure.constraints import Contradiction
from ..structure.parts import collapsed
from .contact_state import ClearanceComponents, ContactState, Tally, sizes
from .determinate import (
    DeterminateContact,
    determinate_contact,
    forces_by_work,
    rounding_of_forces,
    told_by_work,
)
from .unit_motions import Solvers, UnitMotionsPerEntry
from .unit_offsets import Resistance, against_offsets, resists_at_first_entry
from .without_loads import shape_of_stiffness, typical_elements

# Largest number of entries of the stiffness against offsets that is kept for the next solution.
_KEPT = 2**16
# From this many entries on one pass for loads and offsets takes less time than two, of which plan and factors of the
# first are kept for the next loads; and from this many motions on if virtual works are needed besides.
_LONG, _MANY = 2**14, 2**18


class FrameSolvers(NamedTuple):
    """Functions that return linear solutions without clearances.

    Attributes
    ----------
    of
        Of a description.
    per_unit
        Of a description without loads, given the plan of the same members: each offset that varies is a right-hand-side
        parameter of its own, per unit of which results are found, by broadcasting elimination.
    loaded
        Of the frame itself, with what is kept of it for its solution under other loads.
    with_offsets
        Of the frame with offsets, which are such parameters if the method is broadcasting elimination.
    """

    of: Callable[[Description], LinearResults]
    per_unit: Callable[[Plan, Description], LinearResults]
    loaded: Callable[[], tuple[LinearResults, Factors]]
    with_offsets: Callable[[Description], LinearResults]


class ContactSearch:
    """The contact of all journals at equilibrium, found from solutions without clearances.

    Parameters
    ----------
    frame
        The frame.
    components
        Its components with clearance.
    solvers
        Functions that return its solutions without clearances.
    resists
        Whether offsets cause forces at the first batch entry; None if that is not known.

    Attributes
    ----------
    known_to_resist
        Whether offsets cause forces at the first batch entry; None if that was not asked.
    """

    def __init__(
        self,
        frame: Description,
        components: ClearanceComponents,
        solvers: FrameSolvers,
        resists: bool | None = None,
    ) -> None:
        self.frame, self.known_to_resist = frame, resists
        self._components, self._solvers = components, solvers

    @cached_property
    def determinate(self) -> DeterminateContact | None:
        """Contact in closed form, where it may apply; else None."""
        if self.entry_by_entry:
            return None
        motions = self._resistance.motions
        if motions is None or self._resistance.stiffness.any():
            return None
        radius = [self.frame.joints[name].element.clearance for name in self._components.names]
        return determinate_contact(self._components, radius, self._without_clearance, motions)

    def finish(self) -> Plan:
        """Compute now what takes the solutions without clearances, unless these are kept for the closed form.

        Returns
        -------
        Plan
            The plan without clearances.
        """
        plan = self._without_clearance.plan
        if self.determinate is None:
            self.contact_state  # noqa: B018  # and with it what is lost and singular
            self._resistance = replace(self._resistance, motions=None)
            del self._loaded, self._together
        del self._solvers
        return plan

    # -- solutions without clearances -------------------------------------------------------------------------------

    @property
    def _resists(self) -> bool:
        """Whether offsets cause forces at the first entry."""
        if self.known_to_resist is None:
            solvers = Solvers(self._solvers.of, None)
            self.known_to_resist = resists_at_first_entry(self.frame, self._components, solvers)
        return self.known_to_resist

    @cached_property
    def _in_one_pass(self) -> bool:
        """Whether forces under the loads and by unit offsets are to be found in one pass over a long batch.

        Not where a common stiffness may suffice for offsets, the resistance is kept for the next loads, or offsets are
        imposed in these components.
        """
        frame, pairs, entries = self.frame, self._components.pairs, math.prod(self.frame.shape)
        if entries < _LONG or len(pairs) ** 2 * entries <= _KEPT:
            return False
        if any(k in frame.offsets.get(name, {}) for name, k in pairs):
            return False
        if shape_of_stiffness(frame) != frame.shape:
            return False
        return self._resists or (len(pairs) * entries > _MANY and typical_elements(frame) is None)

    @cached_property
    def _together(self) -> UnitMotionsPerEntry | None:
        """The motions by unit offsets with the forces under the loads; None where these are not found in one pass."""
        if not self._in_one_pass:
            return None
        frame, solve = self.frame.copy(), self._solvers.with_offsets
        with suppress(Contradiction):  # which is told of each offset alone
            return UnitMotionsPerEntry.with_loads(frame, self._components.pairs, solve, works=not self._resists)
        return None

    @cached_property
    def _loaded(self) -> tuple[LinearResults, Factors]:
        return self._solvers.loaded() if self._together is None else (self._together.solution, Factors())

    @property
    def _without_clearance(self) -> LinearResults:
        """The solution without clearances."""
        return self._loaded[0]

    @cached_property
    def _by_chunks(self) -> bool:
        """Whether each pass over the batch takes as long as a solution."""
        found = self._without_clearance
        return self._together is not None or found.plan.medium or found.by_chunks

    @property
    def _surely_resists(self) -> bool:
        """Whether offsets are known to cause forces, which is asked where these are found entry by entry."""
        return self._by_chunks and self._resists

    @property
    def entry_by_entry(self) -> bool:
        """Whether the stiffness against offsets is found anew for each entry."""
        return self._in_one_pass or self._surely_resists

    # -- what is found ----------------------------------------------------------------------------------------------

    @cached_property
    def lost(self) -> NDArray[np.bool_]:
        """Entries that certainly have no results, (...): left out, or kinematically unstable under the loads."""
        if self._together is None and self._surely_resists:
            self._joint_forces  # noqa: B018  # in one pass with the pivots, which tell what is lost
        return self._without_clearance.lost

    @cached_property
    def _left_out(self) -> NDArray[np.bool_]:
        """Entries that have no results in any of the parts of the frame that contain journals, (...)."""
        absent, solution = self.frame.absent, self._without_clearance
        if solution.solver.parts < 2 or not (self.lost if absent is None else self.lost & ~absent).any():
            return self.lost
        nodes = {self.frame.joints[name].first for name in self._components.names}
        found: NDArray[np.bool_] = np.logical_or.reduce([solution.part(node).lost for node in sorted(nodes)])
        return found

    @property
    def unfit(self) -> NDArray[np.bool_]:
        """Entries without results because no offset is compatible with a loop of rigid links, (...)."""
        found: NDArray[np.bool_] = np.broadcast_to(self._resistance.unfit, self.frame.shape)
        return found

    @property
    def offset(self) -> Array:
        """Displacement within the clearance, (n, ...)."""
        return self.contact_state.offset

    @property
    def force(self) -> Array:
        """Contact force by component, (n, ...)."""
        return self.contact_state.force

    @property
    def size(self) -> Array:
        """Magnitude of the contact force in each joint, (joints, ...); rounding where there is none."""
        return self.contact_state.size

    @property
    def tally(self) -> Tally:
        """How the minima of energy were found."""
        return self.contact_state.tally

    @cached_property
    def state(self) -> States:
        """State of each joint, a `ClearanceState`, (joints, ...)."""
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

    @cached_property
    def contact_state(self) -> ContactState:
        """Contact state of all journals."""
        force = np.nan_to_num(self._force) if self._singular.any() else self._force
        state = self._state(self._resistance.stiffness, self._resistance.members, force)
        if self.unfit.any():
            state = replace(state, radius=np.where(self.unfit, 0.0, state.radius))
        if self.determinate is not None:
            return replace(state, rounding=self.determinate.rounding)
        return self._without_rounding(state)

    @cached_property
    def _resistance(self) -> Resistance:
        """The resistance to offsets, that of the last solution where only loads have changed since."""
        (solution, factors), lost = self._loaded, bool(self._left_out.any())
        per_unit = partial(self._solvers.per_unit, solution.plan) if self._by_chunks else None
        solvers = Solvers(self._solvers.of, per_unit)
        known: Resistance | None = None if lost else factors.resistance
        if known is None:
            loaded = None if self._surely_resists else [*solution.plan.forces]
            known = against_offsets(
                self.frame, self._components, self._bearing, self._left_out, solvers, loaded, self._together
            )
            # that of a mechanism, which is without motions, depends on the loads
            small = known.motions is not None and max(known.stiffness.size, known.motions.entries) <= _KEPT
            if small and not lost:
                factors.resistance = known
        return known

    def _state(self, stiffness: Array, members: Array, force: Array) -> ContactState:
        frame = self.frame
        gaps = (frame.joints[name].element.clearance for name in self._components.names)
        radius = np.stack([np.broadcast_to(gap, frame.shape) for gap in gaps])
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
            forces[:, self._left_out] = np.nan
            return forces
        return self._joint_forces

    @cached_property
    def _joint_forces(self) -> Array:
        """These forces as the solution without clearance has them."""
        if self._together is not None:
            return self._together.under_loads
        # no warning: the state of contact is "mechanism" where the frame is one
        return self._without_clearance.silenced().joint_components(self._components.pairs)

    @cached_property
    def _singular(self) -> NDArray[np.bool_]:
        found: NDArray[np.bool_] = np.asarray(np.isnan(self._force).any(axis=0))
        return found

    def _bearing(self) -> NDArray[np.bool_]:
        """Whether a component carries a force above rounding, (n, ...)."""
        none = np.zeros(())
        state = self._state(none, none, np.nan_to_num(self._joint_forces))
        return np.asarray(state.without_clearance != 0.0)


def _load(plan: Plan) -> Array:
    """Largest force component and largest moment component on any node, (2, ...)."""
    out: Array = np.zeros((2, *plan.frame.shape))
    for a, by_source in plan.forces.items():
        value = np.abs(np.asarray(collapsed(by_source, plan.rhs_parameters.values), dtype=np.float64))
        out[a % 6 // 3] = np.maximum(out[a % 6 // 3], value)
    return out
