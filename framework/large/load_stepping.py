"""Load steps: the equilibria of a whole batch, a piece of the batch and a share of the loads at a time."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..elementwise import contracted
from ..rotation import dot
from . import corotation
from .clearances import AugmentedLagrangian, start
from .equations import EquilibriumEquations, motion_of
from .model import Model
from .newton import Newton
from .numbers import Where
from .search import Search
from .state import DisplacedState, FoundEquilibria, Index

# Numbers in the stiffness of all members of a piece of the batch, at most, so that it stays in the processor's cache.
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
        self.count = len(model.present)
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
            found = FoundEquilibria.nothing(
                start(self.newton, self.model.where(index), len(index), factors[0]), copied=False
            )
            before = 0.0
            for step, factor in enumerate(factors.tolist()):
                old = found.state
                found = self._step(self.model.where(index), found, before, factor)
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
            begin = self.newton.space(start(self.newton, self.model.where(index), len(index), 1.0))
            self._record(history, index, 0, (begin, state.taken(index)), (0.0, 1.0))
        return history

    def _history(self) -> History:
        shape = self.steps, self.count
        return History(np.arange(1, self.steps + 1) / self.steps, np.full(shape, np.nan), np.full(shape, np.nan))

    def pieces(self) -> Iterator[Index]:
        """Entries that were not left out, a piece of the batch at a time."""
        wanted = np.flatnonzero(self.model.present)
        for begin in range(0, len(wanted), self.chunk):
            yield wanted[begin : begin + self.chunk]

    def _step(self, where: Where, begin: FoundEquilibria, low: float, high: float) -> FoundEquilibria:
        search = self.with_contact if self.model.contacts else self.search
        found = search.solve(where, begin.state, low, high)
        found.iterations += begin.iterations
        found.left |= begin.left
        return found

    def _record(
        self,
        history: History,
        index: Index,
        step: int,
        states: tuple[DisplacedState, DisplacedState],
        factors: tuple[float, float],
    ) -> None:
        equations = EquilibriumEquations(self.model, self.model.where(index), len(index), factors[1])
        history.energy[step, index] = equations.strain_energy(states[1])
        before = history.work[step - 1, index] if step else 0.0
        history.work[step, index] = before + _work(equations, states, factors[0] / factors[1])


def _work(equations: EquilibriumEquations, states: tuple[DisplacedState, DisplacedState], share: float) -> Array:
    """Work done on the frame between two equilibria (m,), by the trapezoidal rule.

    Parameters
    ----------
    equations
        Those of the new one.
    states
        The old one and the new one.
    share
        Share of the loads in the old one over that in the new one.
    """
    model, (old, new) = equations.model, states
    work_of_loads = (
        equations.load_work(new, equations.motions(new))
        - equations.load_work(old, equations.motions(old))
        + equations.moment_work(old, new)
    )
    total: Array = 0.5 * (1.0 + share) * work_of_loads
    before = EquilibriumEquations(model, equations.where, equations.count, share * equations.factor)
    both = (before, old), (equations, new)
    forces = [part.linearised(state, tangents=False).forces for part, state in both]
    mean = 0.5 * (forces[0][model.free :] + forces[1][model.free :])
    total += contracted("im,im->m", mean, (1.0 - share) * equations.prescribed_values)
    for stack, pair in zip(model.stacks, zip(before.pieces, equations.pieces, strict=True), strict=True):
        if stack.free is not None:
            steps = zip(pair, states, strict=True)
            at = [corotation.strain_forces(part, motion_of(stack.ends, part, s).deformation) for part, s in steps]
            free = (1.0 - share) * equations.factor * stack.free.at(equations.where)
            total -= 0.5 * dot(at[0] + at[1], free + np.zeros_like(at[0])).sum(axis=0)
    for number, joint in enumerate(model.joints):
        resisted = [part.resistance(state, number, state.own[:, number])[1] for part, state in both]
        offset = (1.0 - share) * equations.factor * joint.offset.at(equations.where)
        total -= 0.5 * dot(resisted[0] + resisted[1], offset + np.zeros_like(resisted[0]))
    return total
