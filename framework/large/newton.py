"""Newton's method for a batch of equilibria, of which only those not yet found are iterated.

Whole steps, their geometric stiffness made of the stresses that the last step predicted linearly (Magisano, Leonetti &
Garcea, Comput. Methods Appl. Mech. Engrg. 313 (2017) 986-1005): slender members do not lock it, and a cantilever is
rolled into a circle in one load step.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np

from ..batch import Array
from ..elementwise import contracted
from ..rotation import dot
from .accuracy import ForceRounding
from .elimination import CLEAR, StackFactor, SymbolicFactorisation
from .equations import EquilibriumEquations
from .model import Model
from .newton_program import NewtonProgram
from .numbers import Where, at_index
from .planar_equations import PlanarEquations
from .planar_model import PlanarModel
from .recorded_newton import CLOSE, ITERATIONS, LONGEST, NOTHING
from .state import DisplacedState, FoundEquilibria, Index, Mask, PlanarState, StateOfEntries
from .tree_equations import Linearisation, TreeEquations


class Newton:
    """Iterations on one model.

    Parameters
    ----------
    model
        The compiled frame.

    Attributes
    ----------
    planar_model
        The same in its plane; None where it is not in one, or has what only equations in space know.
    elimination
        Order and fill of the tangents.
    least
        Pivot up to which the last tangent does not tell whether an equilibrium is stable.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.planar_model = PlanarModel(model) if PlanarModel.suits(model) else None
        _, rows, columns = model.pattern if self.planar_model is None else self.planar_model.pattern
        self.elimination = SymbolicFactorisation.of(
            rows, columns, model.free, half=self.planar_model is not None, constraints=model.constraints
        )
        # a journal that a small force presses may stand a rounding inside its circle, where nothing seems to hold it
        self.least = self.elimination.free if model.has_clearance else CLEAR

    def equations(self, where: Where, count: int, factor: float) -> TreeEquations:
        """The equations of some entries, of the plane where the model is in one."""
        if self.planar_model is not None:
            return PlanarEquations(self.planar_model, where, count, factor)
        return EquilibriumEquations(self.model, where, count, factor)

    def start(self, count: int) -> StateOfEntries:
        """The state at rest."""
        return (DisplacedState if self.planar_model is None else PlanarState).start(self.model, count)

    def space(self, state: StateOfEntries) -> DisplacedState:
        """The state as one in space."""
        if isinstance(state, DisplacedState):
            return state
        assert self.planar_model is not None
        assert isinstance(state, PlanarState)
        return self.planar_model.space(state)

    def place(self, state: DisplacedState, near: StateOfEntries) -> StateOfEntries:
        """A state in space as the equations have it, of which angles are near those of another."""
        if self.planar_model is None:
            return state
        return self.planar_model.in_plane(state, near if isinstance(near, PlanarState) else None)

    @cached_property
    def program(self) -> NewtonProgram | None:
        """The same as a program, where that pays for the frame's batch."""
        return NewtonProgram.of(self.planar_model or self.model, self.elimination)

    def solve(self, where: Where, state: StateOfEntries, factor: float, *, at_rest: bool = False) -> FoundEquilibria:
        """Equilibria at a share `factor` of the loads.

        Given up at once where the tangent at `state` is singular, or where loads have an energy and it falls there.
        Where a frame `at_rest` has its journals put on their circles, that has strained its members, whose stresses
        there tell nothing of those to come: the first tangent is made without them.
        """
        loose = at_rest and self.model.has_clearance
        if self.program is None:
            found = self._iterated(where, state, factor, loose=loose)
        else:
            found = self.program.solve(where, state, factor, loose=loose)
            unclear = self._unclear(found)
            if len(unclear):
                found.iterations[unclear] = 0
                found.take(unclear, self._iterated(at_index(where, unclear), state.taken(unclear), factor, loose=loose))
        self.judge(where, found, factor)
        return found

    def _unclear(self, found: FoundEquilibria) -> Index:
        """Entries of which the program does not tell what arrays do.

        Where joints have clearance stability is told by the last tangent, which it forgets; where constraints have
        multipliers, it leaves out none that are redundant.
        """
        if self.model.constraints:
            return np.flatnonzero(~found.good)
        return np.flatnonzero(self.model.has_clearance & found.converged & ~found.stable)

    def judge(self, where: Where, found: FoundEquilibria, factor: float) -> None:
        """Tell of equilibria that are not known to be stable whether they are, and whether some motion is free there.

        That is asked of the tangent at the place itself: the last step is nothing beside what resists it, but may be
        much for a motion that hardly anything resists, whose stiffness it then changes.
        """
        unclear = np.flatnonzero(found.converged & ~found.stable)
        if not len(unclear):
            return
        here, state = at_index(where, unclear), found.state.taken(unclear)
        values = self.equations(here, len(unclear), factor).linearised(state).values
        equations, place = EquilibriumEquations(self.model, here, len(unclear), factor), self.space(state)
        rounding = ForceRounding(equations, place, equations.linearised(place, tangents=False)).tangents()
        found.stable[unclear] = self.elimination.definite(values, rounding)
        if self.model.symmetric:
            found.neutral[unclear] = found.stable[unclear] & self.elimination.neutral(values)

    def _iterated(self, where: Where, state: StateOfEntries, factor: float, *, loose: bool) -> FoundEquilibria:
        """Equilibria, iterated with arrays; stable where the last tangent was clearly definite."""
        found = FoundEquilibria.nothing(state)
        active = np.arange(len(found.stable))
        balance = self.equations(where, len(active), factor)
        stresses = [np.zeros_like(each) for each in balance.stresses(state)] if loose else None
        for iteration in range(ITERATIONS):
            at = balance.linearised(state, stresses)
            factors = self.factor(at)
            positive: Mask = np.asarray((factors.pivots > self.elimination.free).all(axis=0))
            step = self.step(at, balance.prescribed_residual(state), factors.solve)
            regular = positive if self.model.symmetric else (np.abs(factors.pivots) > self.elimination.free).all(axis=0)
            usable = np.isfinite(step).all(axis=0) & (regular | (iteration > 0))
            step = np.where(usable, step, 0.0)
            share = self.limited(balance, step)
            close = usable & (share == 1.0) & self.is_close(balance, at, step, first=iteration == 0)
            found.iterations[active] += 1
            state = balance.advanced(state, share * step)
            done = close | ~usable
            if done.any():
                found.state.put(active[done], state.taken(done))
                found.converged[active[done]] = close[done]
                sure: Mask = np.asarray((factors.pivots > self.least).all(axis=0))
                if self.model.has_clearance and not sure[done].all():
                    sure |= self.elimination.definite(at.values)
                found.stable[active[done]] = (close & sure)[done]
                active = active[~done]
            if not len(active):
                break
            stresses = balance.step_stresses(at, share * step)
            if done.any():
                state, stresses = state.taken(~done), [stress[..., ~done] for stress in stresses]
                balance = self.equations(at_index(where, active), len(active), factor)
        return found

    def factor(self, at: Linearisation) -> StackFactor:
        """The tangent factorised."""
        return self.elimination.factor(at.values, symmetric=self.model.symmetric)

    def step(
        self, at: Linearisation, residual: Array, solve: Callable[[Array], Array], load: Array | None = None
    ) -> Array:
        """Step of all coordinates, the prescribed ones by their residual (size, m): Newton's, or that by a `load`."""
        push = (-at.forces if load is None else load)[: self.model.free]
        if len(residual):
            push = push - self.elimination.prescribed_forces(at.values, residual)
        return np.concatenate([solve(push), residual])

    def limited(self, balance: TreeEquations, step: Array) -> Array:
        """Share of a step that turns and moves no more than is allowed (m,)."""
        return 1.0 / np.maximum(self.largest(balance, step) / LONGEST, 1.0)

    def largest(self, balance: TreeEquations, step: Array) -> Array:
        """Largest component of a step, in radians or sizes of the frame (m,)."""
        out: Array = (np.abs(step) * balance.scale).max(axis=0, initial=0.0)
        return out

    def is_close(self, balance: TreeEquations, at: Linearisation, step: Array, *, first: bool = False) -> Mask:
        """Whether the work of the unbalanced forces on the step, or the step itself, is nothing.

        Both are so small that what the step leaves open, of second order, lies below rounding. A `first` step, however
        small, is all that there is of a displacement, and holds the rounding of the factors: another one follows it.
        """
        nothing = 0.0 if first else NOTHING
        work = np.abs(contracted("im,im->m", at.forces, step))
        there = np.abs(step[self.model.free :]).max(axis=0, initial=0.0) <= NOTHING * np.minimum(1.0, balance.lengths)
        near: Mask = (there & (work <= CLOSE * at.energy) & (at.energy > 0.0)) | (
            self.largest(balance, step) <= nothing
        )
        return near


def bordered(row: Array, free: Array, along: Array, wanted: Array | float = 0.0) -> tuple[Array, Array]:
    """A step of bordered equations by two solutions with one factor (Keller 1977), (n, m), and its multiplier (m,).

    Parameters
    ----------
    row
        What the border asks of a step (n, m): of an arc, to go across its tangent; of a mode, its amount.
    free, along
        Solutions for what is unbalanced, and for a unit of the multiplier (n, m).
    wanted
        What the row times the step is to be (m,).
    """
    change = (wanted - dot(row, free)) / dot(row, along)
    return free + change * along, change
