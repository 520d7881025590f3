"""The search for stable equilibria: ways in turn, from the fastest to the surest."""

from __future__ import annotations

import numpy as np

from .descent import Descent
from .found import Found, Index, Place
from .newton import Newton
from .numbers import Where
from .saddle import Saddle

# Into how many steps a load step is cut where one is too long.
_CUTS = (4, 16)
# Iterations of the descent before the fast way is tried again; doubled each time, up to.
_FIRST, _LAST = 3, 200


class Search:
    """Searches on one model.

    Parameters
    ----------
    newton
        Iterations on it.
    """

    def __init__(self, newton: Newton) -> None:
        self.newton, self.descent, self.saddle = newton, Descent(newton), Saddle(newton)

    def solve(self, where: Where, begin: Place, low: float, high: float) -> Found:
        """Equilibria at a share `high` of the loads, from the equilibria `begin` at `low`.

        Newton's method at once; where that fails but the tangent was regular, in smaller steps; out of an unstable
        equilibrium along its mode; and else down the energy.
        """
        found = self.newton.solve(where, begin, high)
        for cuts in _CUTS:
            bad = np.flatnonzero(~found.good & (found.iterations > 1))
            if len(bad):
                again = self._stepped(_part(where, bad), begin.taken(bad), low, high, cuts)
                found.take(bad, again, again.good | (again.converged & ~found.converged[bad]))
        if self.newton.held:  # the energy is no guide where constraints have multipliers
            return found
        bad = np.flatnonzero(found.converged & ~found.stable)
        if len(bad):
            again = self.saddle.leave(_part(where, bad), found.state.taken(bad), high)
            found.take(bad, again, again.good)
        self._descend(where, begin, high, found)
        return found

    def _stepped(self, where: Where, begin: Place, low: float, high: float, cuts: int) -> Found:
        found = Found.nothing(begin)
        found.converged[:] = found.stable[:] = True
        for factor in np.linspace(low, high, cuts + 1)[1:].tolist():
            going = np.flatnonzero(found.converged)
            if len(going):
                found.take(going, self.newton.solve(_part(where, going), found.state.taken(going), factor))
        return found

    def _descend(self, where: Where, begin: Place, factor: float, found: Found) -> None:
        iterations = _FIRST
        while iterations <= _LAST:
            bad = np.flatnonzero(~found.good)
            if not len(bad):
                break
            start = begin.taken(bad) if iterations == _FIRST else found.state.taken(bad)
            again = self.descent.run(_part(where, bad), start, factor, iterations)
            self._finish(_part(where, bad), again, factor)
            found.take(bad, again)
            iterations *= 2

    def _finish(self, where: Where, found: Found, factor: float) -> None:
        """Try Newton's method from where the descent has come to; its end must be stable, and lower."""
        left = np.flatnonzero(~found.converged)
        if not len(left):
            return
        start = found.state.taken(left)
        balance = self.newton.equations(_part(where, left), len(left), factor)
        tried = self.newton.solve(_part(where, left), start, factor)
        gained = balance.energy(tried.state) - balance.moment_work(start, tried.state)
        found.take(left, tried, tried.good & (gained <= balance.energy(start)))


def _part(where: Where, index: Index) -> Where:
    return tuple(k[index] for k in where)
