"""Rigid contact in clearances: the force that presses, by going back to the equilibrium with a better guess of it.

Each equilibrium is one of a smooth energy (see `law`), so that all ways of `search` are open to it. The force found in
one is the guess for the next, which moves the journal by less and less, down to rounding.
"""

from __future__ import annotations

import numpy as np

from ..batch import Array
from .equations import EquilibriumEquations
from .joint_law import ContactMultipliers
from .numbers import Where
from .protocols import FoundEquilibria, Index, Mask, Place
from .search import Search
from .state import DisplacedState

# By how much the stiffness of a contact is raised where a guess leaves more than this share of the last one's error.
_RAISED, _FALL = 30.0, 0.2
# Guesses at most; roundings by which a journal may lie off its circle, and above which that is no equilibrium.
_GUESSES, _ROUNDINGS, _FAR = 30, 4.0, 1e5
_EPS = float(np.finfo(np.float64).eps)


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

    def solve(self, where: Where, begin: Place, low: float, high: float) -> FoundEquilibria:
        """Equilibria at a share `high` of the loads, from the equilibria `begin` at `low`."""
        found = self.search.solve(where, begin, low, high)
        waiting = np.flatnonzero(found.converged)
        before = np.full((len(self.model.contacts), len(found.converged)), np.inf)
        for _ in range(_GUESSES):
            here = tuple(k[waiting] for k in where)
            state = found.state.taken(waiting)
            contact_multipliers, off = self._better(here, self.newton.space(state), high)
            stalled = off > _FALL * before[:, waiting]
            left: Mask = np.asarray(((off > _ROUNDINGS) & ~(stalled & (off <= _FAR))).any(axis=0))
            before[:, waiting] = off
            waiting = waiting[left]
            if not len(waiting):
                break
            contact_multipliers.stiffness[stalled & (off > _FAR)] *= _RAISED
            state.contact_multipliers = contact_multipliers
            self._again(tuple(k[left] for k in here), state.taken(left), high, found, waiting)
        found.converged &= ~(before > _FAR).any(axis=0)
        return found

    def _again(self, where: Where, state: Place, factor: float, found: FoundEquilibria, index: Index) -> None:
        """Equilibria with new guesses, from those found with the old ones."""
        again = self.newton.solve(where, state, factor)
        bad = np.flatnonzero(~again.good)
        if len(bad):
            again.take(bad, self.search.solve(tuple(k[bad] for k in where), state.taken(bad), factor, factor))
        found.take(index, again)

    def _better(self, where: Where, state: DisplacedState, factor: float) -> tuple[ContactMultipliers, Array]:
        """The forces at a state as guesses, and how far journals are off where these put them, in roundings."""
        equations = EquilibriumEquations(self.model, where, state.displacements.shape[-1], factor)
        force, off = np.zeros_like(state.contact_multipliers.force), np.zeros_like(state.contact_multipliers.stiffness)
        for number, place in self.model.contacts.items():
            joint = self.model.edges[number]
            directions = list(joint.clearance_directions)
            own = equations.own(state, number)
            force[directions, place] = equations.resistance(state, number, own)[1][directions]
            change = _length(force[directions, place] - state.contact_multipliers.force[directions, place])
            distance = _length(own[directions]) + joint.clearance.at(where)
            rounding = _EPS * (
                distance * state.contact_multipliers.stiffness[place] + _length(force[directions, place])
            )
            off[place] = change / np.where(rounding > 0.0, rounding, 1.0)
        return ContactMultipliers(force, state.contact_multipliers.stiffness.copy()), off


def _length(vector: Array) -> Array:
    """Length of vectors (n, m)."""
    out: Array = np.hypot.reduce(vector, axis=0)
    return out
