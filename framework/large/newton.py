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
        Pivot up to which the last tangent does not decide whether an equilibrium is stable.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.planar_model = PlanarModel(model) if PlanarModel.suits(model) else None
        _, rows, columns = model.pattern if self.planar_model is None else self.planar_model.pattern
        self.elimination = SymbolicFactorisation.of(
            rows,
            columns,
            model.free,
            half=self.planar_model is not None,
            constraints=model.constraints,
            units=model.units,
        )
        # a journal pressed by a small force may lie a rounding inside its circle, where nothing seems to resist it
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
        """The iterations as a program, None where that does not pay for the frame's batch."""
        return NewtonProgram.of(self.planar_model or self.model, self.elimination)

    def solve(self, where: Where, state: StateOfEntries, factor: float, *, at_rest: bool = False) -> FoundEquilibria:
        """Equilibria at a share `factor` of the loads.

        An entry is given up at once where the tangent at `state` is singular, or where the loads have a potential and
        the tangent is not positive definite. Putting journals on their circles has strained the members of a frame
        that is `at_rest`; these stresses say nothing about those to come, so that the first tangent leaves them out.
        """
        unstressed = at_rest and self.model.has_clearance
        if self.program is None:
            found = self._iterated(where, state, factor, unstressed=unstressed)
        else:
            found = self.program.solve(where, state, factor, unstressed=unstressed)
            unclear = self._unclear(found)
            if len(unclear):
                found.iterations[unclear] = 0
                found.take(
                    unclear,
                    self._iterated(at_index(where, unclear), state.taken(unclear), factor, unstressed=unstressed),
                )
        self.judge(where, found, factor)
        return found

    def _unclear(self, found: FoundEquilibria) -> Index:
        """Entries that are to be iterated with arrays after the program.

        Where joints have clearance, stability follows from the last tangent, which the program does not return; where
        constraints have multipliers, it does not leave out redundant ones.
        """
        if self.model.constraints:
            return np.flatnonzero(~found.good)
        return np.flatnonzero(self.model.has_clearance & found.converged & ~found.stable)

    def judge(self, where: Where, found: FoundEquilibria, factor: float) -> None:
        """Decide whether equilibria that are not known to be stable are, and whether some motion is free there.

        The tangent at the equilibrium itself decides: the last step is negligible beside what resists it, but may be
        large for a motion that hardly anything resists, and then changes the stiffness of that.
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

    def _iterated(self, where: Where, state: StateOfEntries, factor: float, *, unstressed: bool) -> FoundEquilibria:
        """Equilibria, iterated with arrays; stable where the last tangent was clearly definite."""
        found = FoundEquilibria.nothing(state)
        active = np.arange(len(found.stable))
        equations = self.equations(where, len(active), factor)
        stresses = [np.zeros_like(each) for each in equations.stresses(state)] if unstressed else None
        for iteration in range(ITERATIONS):
            at = equations.linearised(state, stresses)
            factors = self.factor(at)
            positive: Mask = np.asarray((factors.pivots > self.elimination.free).all(axis=0))
            step = self.step(at, equations.prescribed_residual(state), factors.solve)
            regular = positive if self.model.symmetric else (np.abs(factors.pivots) > self.elimination.free).all(axis=0)
            usable = np.isfinite(step).all(axis=0) & (regular | (iteration > 0))
            step = np.where(usable, step, 0.0)
            share = self.limited(equations, step)
            close = usable & (share == 1.0) & self.is_close(equations, at, step, first=iteration == 0)
            found.iterations[active] += 1
            state = equations.advanced(state, share * step)
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
            stresses = equations.step_stresses(at, share * step)
            if done.any():
                state, stresses = state.taken(~done), [stress[..., ~done] for stress in stresses]
                equations = self.equations(at_index(where, active), len(active), factor)
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

    def limited(self, equations: TreeEquations, step: Array) -> Array:
        """Share of a step that turns and moves no more than is allowed (m,)."""
        return 1.0 / np.maximum(self.largest(equations, step) / LONGEST, 1.0)

    def largest(self, equations: TreeEquations, step: Array) -> Array:
        """Largest component of a step, in radians or sizes of the frame (m,)."""
        out: Array = (np.abs(step) * equations.scale).max(axis=0, initial=0.0)
        return out

    def is_close(self, equations: TreeEquations, at: Linearisation, step: Array, *, first: bool = False) -> Mask:
        """Whether the work of the unbalanced forces on the step, or the step itself, is nothing.

        Both are so small that what the step leaves open, of second order, lies below rounding. A `first` step, however
        small, is all that there is of a displacement, and holds the rounding of the factors: another one follows it.
        """
        nothing = 0.0 if first else NOTHING
        work = np.abs(contracted("im,im->m", at.forces, step))
        there = np.abs(step[self.model.free :]).max(axis=0, initial=0.0) <= NOTHING * np.minimum(1.0, equations.lengths)
        near: Mask = (there & (work <= CLOSE * at.energy) & (at.energy > 0.0)) | (
            self.largest(equations, step) <= nothing
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
