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
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned, rotated
from ..batched.plan import Plan
from ..batched.unloaded import Former
from ..description import Description
from ..errors import MechanismWarning
from ..states import ClearanceState, States
from .by_parts import ContactOfParts, contact_of_parts, is_long, too_much_varies
from .contact import Contact
from .contact_search import ContactSearch
from .contact_state import ClearanceComponents, Tally
from .joints import joints_with_clearance

# A function that returns the search for contact in a frame, given its components with clearance, and whether offsets
# cause forces at its first batch entry; None if that is not known.
Search = Callable[[Description, ClearanceComponents, bool | None], ContactSearch]


def components_with_clearance(frame: Description) -> ClearanceComponents:
    """The components of all joints with clearance."""
    names = joints_with_clearance(frame)
    each = [frame.joints[name].element.clearance_directions for name in names]
    own = np.repeat(np.arange(len(names)), [len(directions) for directions in each])
    return ClearanceComponents(names, own, [k for directions in each for k in directions])


class Clearances:
    """The clearances of a frame in equilibrium under its loads.

    Parameters
    ----------
    frame
        The frame.
    search
        Function that returns the search for contact in this frame, or in some entries of its batch, see `Search`.
    method
        Name of the method of solution that was asked for; None for none.

    Attributes
    ----------
    determinate
        Contact in closed form, where it may apply; else None.
    plan
        Plan of the frame with the position of each journal imposed; None in closed form.
    """

    def __init__(self, frame: Description, search: Search, method: str | None) -> None:
        self.frame, self._components = frame, components_with_clearance(frame)
        self._found, without_clearance = self._found_by(search)
        self.determinate = None if isinstance(self._found, ContactOfParts) else self._found.determinate
        if self.unfit.any():
            self._warn_unfit()
        self.plan = None if self.determinate is not None else self.plan_with_offsets(method, without_clearance)

    def _found_by(self, search: Search) -> tuple[ContactSearch | ContactOfParts, Plan | None]:
        """The contact of the whole batch, in parts if much of it is kept for each entry; and the plan without it."""
        frame, components = self.frame, self._components
        whole = None if is_long(frame) and too_much_varies(frame, components) else search(frame, components, None)
        if whole is None or (is_long(frame) and whole.entry_by_entry):
            found = contact_of_parts(frame, components, lambda part, resists: search(part, components, resists))
            if found is not None:
                return found, None
        whole = whole or search(frame, components, None)
        return whole, whole.finish()

    def _warn_unfit(self) -> None:
        warnings.warn(
            f"{self.unfit.sum()} of {self.unfit.size} batch entries are unresolved and their results are NaN: there "
            f"ideal joints among {', '.join(self.names)} close a loop of rigid links in which no offset fits, as in a "
            "line; give one of them a finite stiffness",
            MechanismWarning,
            stacklevel=5,
        )

    @property
    def names(self) -> list[str]:
        """Names of the joints with clearance."""
        return self._components.names

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Entries that certainly have no results, (...): left out, or kinematically unstable under the loads."""
        return self._found.lost

    @cached_property
    def unfit(self) -> NDArray[np.bool_]:
        """Entries without results because no offset is compatible with a loop of rigid links, (...)."""
        return self._found.unfit

    @property
    def state(self) -> States:
        """State of each joint, a `ClearanceState`, (joints, ...)."""
        return self._found.state

    @property
    def parts(self) -> int:
        """Number of parts of the batch for which contact was found one after the other."""
        return self._found.count if isinstance(self._found, ContactOfParts) else 1

    @property
    def tally(self) -> Tally:
        """How the minima of energy were found."""
        return self._found.tally

    def offsets(self) -> Description:
        """The frame with the position of each journal imposed as an offset of its joint."""
        out = self.frame.copy()
        for (name, k), offset in zip(self._components.pairs, self._found.offset, strict=True):
            imposed = out.offsets.get(name, {})
            # the offset itself is not copied, of which a long batch has many
            out.offsets[name] = {**imposed, k: imposed[k] + offset if k in imposed else np.asarray(offset)}
        return out

    def plan_with_offsets(self, method: str | None, without_clearance: Plan | None) -> Plan:
        """The plan of that frame, by a method, reusing what is known of its members from that without clearance."""
        former = None
        if without_clearance is not None:
            former = Former(without_clearance.unloaded, moved=False, elements=False, linked=False)
        return Plan(self.offsets(), method=method, former=former)

    def contact(self, name: str) -> Contact:
        """Contact in a joint."""
        j, joint = self.names.index(name), self.frame.joints[name].element
        state, radius = np.asarray(self.state[j]), np.broadcast_to(joint.clearance, self.frame.shape)
        closed = np.asarray(state == ClearanceState.CLOSED)
        offset, force = self._vector(j, self._found.offset), self._vector(j, self._found.force)
        along = np.where((radius > 0.0)[..., None], offset, force)
        normal = along / np.where(closed, np.hypot.reduce(along, axis=-1), 1.0)[..., None]
        if joint.axes is not None:
            normal = rotated(aligned(joint.axes, len(self.frame.shape), 2), normal)
        unknown = np.where(state >= ClearanceState.UNRESOLVED, np.nan, 0.0)
        return Contact(
            joint=name,
            state=state,
            normal=np.where(closed[..., None], normal, unknown[..., None]),
            force=np.where(closed, self._found.size[j], unknown),
            gap=np.where(closed, 0.0, radius - np.hypot.reduce(offset, axis=-1) + unknown),
            offset=offset,
        )

    def _vector(self, j: int, values: Array) -> Array:
        """Values by component, (n, ...), as vectors in the axes of joint j, (..., 3)."""
        out = np.zeros((*self.frame.shape, 3))
        for index in np.flatnonzero(self._components.own == j):
            out[..., self._components.component[index] % 3] = values[index]
        return out
