"""The search for stable equilibria: methods in turn, from the fastest to the surest."""

from __future__ import annotations

import numpy as np

from ..clock import tell
from .descent import Descent
from .newton import Newton
from .numbers import Where, at_index
from .saddle import Saddle
from .state import FoundEquilibria, Mask, StateOfEntries

# Into how many steps a load step is cut where one is too long, and how often it is halved where that is still so.
_CUTS, _HALVINGS = (4, 16), 6
# Iterations of the descent before Newton's method is tried again: at first, and at most, doubled each time.
_FIRST, _LAST = 3, 200


class Search:
    """Searches on one model.

    Parameters
    ----------
    newton
        Iterations on it.

    Attributes
    ----------
    before
        How many entries of the batch were solved before those in hand.
    """

    def __init__(self, newton: Newton) -> None:
        self.newton, self.descent, self.saddle = newton, Descent(newton), Saddle(newton)
        self.before = 0

    def solve(self, where: Where, begin: StateOfEntries, low: float, high: float) -> FoundEquilibria:
        """Equilibria at a share `high` of the loads, from the equilibria `begin` at `low`.

        Newton's method in one step; where that fails but the tangent was regular, in smaller steps; from an unstable
        equilibrium along its mode; all of these by way of half the load, and half of that; in the end descent of the
        energy.
        """
        found = self.newton.solve(where, begin, high, at_rest=low == 0.0)
        self._tell(found)
        regular = found.iterations > 1
        for cuts in _CUTS:
            bad = np.flatnonzero(~found.good & regular)
            if len(bad):
                again = self._stepped(at_index(where, bad), begin.taken(bad), low, high, cuts)
                found.improve(bad, again)
        self._leave(where, found, high)
        bad = np.flatnonzero(self._worth(found) & regular)
        if len(bad):
            again = self._halved(at_index(where, bad), begin.taken(bad), low, high, _HALVINGS)
            found.improve(bad, again)
        if not self.newton.model.constraints:  # the energy is no guide where constraints have multipliers
            self._descend(where, begin, high, found)
        return found

    def _stepped(self, where: Where, begin: StateOfEntries, low: float, high: float, cuts: int) -> FoundEquilibria:
        found = FoundEquilibria.nothing(begin)
        found.converged[:] = found.stable[:] = True
        rest = low == 0.0
        for factor in np.linspace(low, high, cuts + 1)[1:].tolist():
            going = np.flatnonzero(found.converged)
            if len(going):
                at = found.state.taken(going)
                found.take(going, self.newton.solve(at_index(where, going), at, factor, at_rest=rest))
            rest = False
        return found

    def _leave(self, where: Where, found: FoundEquilibria, factor: float) -> None:
        """Leave unstable equilibria."""
        bad = np.flatnonzero(found.converged & ~found.stable)
        if len(bad) and not self.newton.model.constraints:
            again = self.saddle.leave(at_index(where, bad), found.state.taken(bad), factor)
            found.take(bad, again, again.good)

    def _worth(self, found: FoundEquilibria) -> Mask:
        """Entries worth more search: only where loads have an energy is there always a stable equilibrium to find."""
        return ~found.good if self.newton.model.symmetric else ~found.converged

    def _halved(self, where: Where, begin: StateOfEntries, low: float, high: float, depth: int) -> FoundEquilibria:
        """Equilibria by way of half the load, and of half of that where it must be."""
        half = 0.5 * (low + high)
        found = self._through(where, begin, low, half, depth)
        going = np.flatnonzero(~self._worth(found))
        found.converged[self._worth(found)] = False
        if len(going):
            found.take(going, self._through(at_index(where, going), found.state.taken(going), half, high, depth))
        return found

    def _through(self, where: Where, begin: StateOfEntries, low: float, high: float, depth: int) -> FoundEquilibria:
        found = self.newton.solve(where, begin, high, at_rest=low == 0.0)
        regular = found.iterations > 1
        self._leave(where, found, high)
        bad = np.flatnonzero(self._worth(found) & regular)
        if depth and len(bad):
            again = self._halved(at_index(where, bad), begin.taken(bad), low, high, depth - 1)
            found.improve(bad, again)
        return found

    def _descend(self, where: Where, begin: StateOfEntries, factor: float, found: FoundEquilibria) -> None:
        """Down the energy, from the beginning; an equilibrium that is unstable stays where no other is found."""
        index = np.flatnonzero(self._worth(found))
        known, had = found.state.taken(index), found.converged[index]
        self._fall(where, begin, factor, found)
        lost = had & ~found.converged[index]
        found.state.put(index[lost], known.taken(lost))
        found.converged[index[lost]] = True

    def _fall(self, where: Where, begin: StateOfEntries, factor: float, found: FoundEquilibria) -> None:
        iterations = _FIRST
        while iterations <= _LAST:
            bad = np.flatnonzero(self._worth(found))
            if not len(bad):
                break
            start = begin.taken(bad) if iterations == _FIRST else found.state.taken(bad)
            again = self.descent.run(at_index(where, bad), start, factor, iterations)
            self._finish(at_index(where, bad), again, factor)
            found.take(bad, again)
            self._tell(found)
            iterations *= 2

    def _tell(self, found: FoundEquilibria) -> None:
        tell(self.before + int(found.converged.sum()))

    def _finish(self, where: Where, found: FoundEquilibria, factor: float) -> None:
        """Try Newton's method from where the descent has come to; its end must be stable, and lower."""
        left = np.flatnonzero(~found.converged)
        if not len(left):
            return
        start = found.state.taken(left)
        equations = self.newton.equations(at_index(where, left), len(left), factor)
        tried = self.newton.solve(at_index(where, left), start, factor)
        gained = equations.energy(tried.state) - equations.moment_work(start, tried.state)
        found.take(left, tried, tried.good & (gained <= equations.energy(start)))
