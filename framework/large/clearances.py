"""Clearances: where journals begin, the force that presses them in rigid contact, and where they lie in the end.

A search begins with journals where the forces of the frame without clearances press them. Each equilibrium is one of a
smooth energy (see `joints`), so that all ways of `search` are open to it. In rigid contact the force found in one is
the guess for the next, which moves the journal by less and less, down to rounding.
"""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..clearances.joints import UNLOADED
from .equations import EquilibriumEquations
from .joints import TreeJoint
from .model import Model
from .newton import Newton
from .numbers import Where, at_index
from .search import Search
from .state import DisplacedState, FoundEquilibria, Index, Mask, StateOfEntries

_EPS = float(np.finfo(np.float64).eps)
# Share of a clearance within which a journal counts as touching its circle: a few roundings.
TOUCHING = 4.0 * _EPS
# Stiffness by which a rigid contact is found, in units of what it meets.
_STIFFER = 10.0
# Clearance, in sizes of the frame or radians, below which it does not soften what a journal meets.
_SMALL = 1e-9
# By how much the stiffness of a contact is raised where a guess leaves more than this share of the last one's error.
_RAISED, _FALL = 30.0, 0.2
# Guesses at most; roundings by which a journal may lie off its circle, and above which that is no equilibrium.
_GUESSES, _ROUNDINGS, _FAR = 30, 4.0, 1e5


def start(newton: Newton, where: Where, count: int, factor: float) -> StateOfEntries:
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
    contacts = len(model.contacts), count
    state.contact_force, state.contact_stiffness = np.zeros((6, *contacts)), np.ones(contacts)
    for number in with_clearance:
        if number < len(model.joints):
            _place(state, number, model.joints[number], forces, model.joints[number].clearance.at(where))
    equations = EquilibriumEquations(model, where, count, factor)
    equations.follow(state)
    if model.contacts:
        state.contact_force, state.contact_stiffness = _guess(newton, equations, state, forces)
    return newton.place(state, found.state)


def _place(state: DisplacedState, number: int, joint: TreeJoint, forces: Array, radius: Array) -> None:
    directions = list(joint.clearance_directions)
    push = forces[directions, number]
    size = np.hypot.reduce(push, axis=0)
    if not joint.rigid:
        # in contact, though the springs deflect under a small force by less than rounding
        radius = radius * (1.0 + TOUCHING)
    state.own[directions, number] += radius * (push / np.where(size > 0.0, size, 1.0))


def _guess(
    newton: Newton, equations: EquilibriumEquations, state: DisplacedState, forces: Array
) -> tuple[Array, Array]:
    """Guesses of the forces in rigid contacts, and the stiffnesses by which they are corrected."""
    model = newton.model
    force, stiffness = np.zeros_like(state.contact_force), np.empty_like(state.contact_stiffness)
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
    return force, stiffness


def _met(model: Model, values: Array) -> Array:
    """Stiffness against each coordinate alone, and zero for those that are constrained (size + 1, m)."""
    _, rows, columns = model.pattern
    out = np.zeros((model.size + 1, values.shape[-1]))
    own = np.flatnonzero(rows == columns)
    out[rows[own]] = np.abs(values[own])
    return out


class AugmentedLagrangian:
    """Searches on a model with rigid contacts.

    Parameters
    ----------
    search
        The search for an equilibrium with given guesses.
    """

    def __init__(self, search: Search) -> None:
        self.search, self.newton = search, search.newton
        self.model = search.newton.model

    def solve(self, where: Where, begin: StateOfEntries, low: float, high: float) -> FoundEquilibria:
        """Equilibria at a share `high` of the loads, from the equilibria `begin` at `low`."""
        found = self.search.solve(where, begin, low, high)
        waiting = np.flatnonzero(found.converged)
        before = np.full((len(self.model.contacts), len(found.converged)), np.inf)
        for _ in range(_GUESSES):
            here = at_index(where, waiting)
            state = found.state.taken(waiting)
            force, off = self._better(here, self.newton.space(state), high)
            stalled = off > _FALL * before[:, waiting]
            left: Mask = np.asarray(((off > _ROUNDINGS) & ~(stalled & (off <= _FAR))).any(axis=0))
            before[:, waiting] = off
            waiting = waiting[left]
            if not len(waiting):
                break
            state.contact_force = force
            state.contact_stiffness[stalled & (off > _FAR)] *= _RAISED
            self._again(at_index(here, left), state.taken(left), high, found, waiting)
        found.converged &= ~(before > _FAR).any(axis=0)
        return found

    def _again(self, where: Where, state: StateOfEntries, factor: float, found: FoundEquilibria, index: Index) -> None:
        """Equilibria with new guesses, from those found with the old ones."""
        again = self.newton.solve(where, state, factor)
        bad = np.flatnonzero(~again.good)
        if len(bad):
            again.take(bad, self.search.solve(at_index(where, bad), state.taken(bad), factor, factor))
        found.take(index, again)

    def _better(self, where: Where, state: DisplacedState, factor: float) -> tuple[Array, Array]:
        """The forces at a state as guesses, and how far journals are off where these put them, in roundings."""
        equations = EquilibriumEquations(self.model, where, state.displacements.shape[-1], factor)
        force, off = np.zeros_like(state.contact_force), np.zeros_like(state.contact_stiffness)
        for number, place in self.model.contacts.items():
            joint = self.model.edges[number]
            directions = list(joint.clearance_directions)
            own = equations.own(state, number)
            force[directions, place] = equations.resistance(state, number, own)[1][directions]
            change = np.hypot.reduce(force[directions, place] - state.contact_force[directions, place])
            distance = np.hypot.reduce(own[directions]) + joint.clearance.at(where)
            size = np.hypot.reduce(force[directions, place])
            rounding = _EPS * (distance * state.contact_stiffness[place] + size)
            off[place] = change / np.where(rounding > 0.0, rounding, 1.0)
        return force, off


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
