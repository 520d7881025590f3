"""Load stepping: the equilibria of a whole batch, piece by piece of the batch and share by share of the loads."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .augmented_lagrangian import AugmentedLagrangian
from .equations import EquilibriumEquations
from .model import Model
from .newton import Newton
from .numbers import Where
from .protocols import FoundEquilibria
from .search import Search
from .start import start
from .state import DisplacedState

# Numbers that the stiffness of all members of a piece of the batch may hold, so that it stays in the cache.
_CACHE = 800_000
# How many times as many entries a program takes at a time, which goes through them in parts of its own.
_IN_PARTS = 8


@dataclass
class History:
    """Load steps: factors (steps,), and for each entry strain energy and work of the loads (steps, entries)."""

    factors: Array
    energy: Array
    work: Array


class LoadStepping:
    """All entries of a batch from rest to their whole load.

    Parameters
    ----------
    model
        The compiled frame.
    steps
        Number of equal load steps.
    """

    def __init__(self, model: Model, steps: int) -> None:
        self.model, self.steps = model, steps
        self.newton = Newton(model)
        self.search = Search(self.newton)
        self.with_contact = AugmentedLagrangian(self.search)
        self.count = int(np.prod(model.frame.shape, dtype=np.int64))
        pieces = sum(len(stack.ends) for stack in model.stacks)
        each = 144 if self.newton.planar_model is None else 36  # a member's stiffness in space, in the plane
        self.chunk = max(1, _CACHE // max(1, each * pieces)) * (_IN_PARTS if self.newton.program else 1)

    def run(self) -> tuple[FoundEquilibria, History]:
        """Final equilibria and what happened on the way."""
        factors = np.arange(1, self.steps + 1) / self.steps
        whole = FoundEquilibria.nothing(DisplacedState.start(self.model, self.count), copied=False)
        history = self._history()
        for index in self.pieces():
            self.search.before = int(index[0])
            found = FoundEquilibria.nothing(start(self.newton, self.where(index), len(index), factors[0]), copied=False)
            before = 0.0
            for step, factor in enumerate(factors.tolist()):
                old = found.state
                found = self._step(self.where(index), found, before, factor)
                if self.steps > 1:
                    states = self.newton.space(old), self.newton.space(found.state)
                    self._record(history, index, step, states, (before, factor))
                before = factor
            found.state = self.newton.space(found.state)
            whole.take(index, found)
        return whole, history

    def single(self, state: DisplacedState) -> History:
        """What happened on the way in one load step that has ended at `state`."""
        history = self._history()
        for index in self.pieces():
            begin = self.newton.space(start(self.newton, self.where(index), len(index), 1.0))
            self._record(history, index, 0, (begin, state.taken(index)), (0.0, 1.0))
        return history

    def _history(self) -> History:
        shape = self.steps, self.count
        return History(np.arange(1, self.steps + 1) / self.steps, np.full(shape, np.nan), np.full(shape, np.nan))

    def pieces(self) -> Iterator[NDArray[np.int64]]:
        """Entries that were not left out, a piece of the batch at a time."""
        absent = self.model.frame.absent
        wanted = np.arange(self.count)
        if absent is not None:
            wanted = np.flatnonzero(~np.broadcast_to(absent, self.model.frame.shape).reshape(-1))
        for begin in range(0, len(wanted), self.chunk):
            yield wanted[begin : begin + self.chunk]

    def where(self, index: NDArray[np.int64]) -> Where:
        """Indices of entries along each batch axis."""
        return tuple(np.unravel_index(index, self.model.frame.shape)) if self.model.frame.shape else ()

    def _step(self, where: Where, begin: FoundEquilibria, low: float, high: float) -> FoundEquilibria:
        search = self.with_contact if self.model.contacts else self.search
        found = search.solve(where, begin.state, low, high)
        found.iterations += begin.iterations
        found.left |= begin.left
        return found

    def _record(
        self,
        history: History,
        index: NDArray[np.int64],
        step: int,
        states: tuple[DisplacedState, DisplacedState],
        factors: tuple[float, float],
    ) -> None:
        equations = EquilibriumEquations(self.model, self.where(index), len(index), factors[1])
        history.energy[step, index] = equations.strain_energy(states[1])
        before = history.work[step - 1, index] if step else 0.0
        history.work[step, index] = before + equations.work(states[0], states[1], factors[0] / factors[1])
