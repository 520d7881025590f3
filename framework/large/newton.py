"""Newton's method for a batch of equilibria, of which only those not yet found are iterated.

Two ways, tried in turn. The fast one takes whole Newton steps, its geometric stiffness made of the stresses that the
last step predicted linearly (Magisano, Leonetti & Garcea, Comput. Methods Appl. Mech. Engrg. 313 (2017) 986-1005), so
that slender members do not lock it. It holds where it ends in a stable equilibrium. Else the sure one goes down the
energy from where the load step began: along Newton's direction with all curvatures taken positive (Dauphin et al.,
NeurIPS 27 (2014)), out of saddles along their free mode, with a line search.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .elimination import Elimination, Factor
from .equations import Equations, SpaceLinear, State
from .model import Model
from .numbers import Where
from .planar import FlatEquations, FlatLinear, FlatModel, FlatState

Mask = NDArray[np.bool_]
Place = State | FlatState
Linear = SpaceLinear | FlatLinear

# Work of the last Newton step, relative to the strain energy: squared again by the step itself.
_CLOSE = 1e-16
_FAST, _FIRST, _SURE = 30, 3, 200
# Largest rotation (radians) in one step, and displacement, in sizes of the frame.
_TURN, _SHIFT = 1.0, 1.0
# Pivots in units of the diagonal that count as zero.
_ZERO = 1e-11


@dataclass
class Found:
    """What was found for m entries: state, whether in equilibrium, stable, iterations, whether a saddle was left."""

    state: Place
    converged: Mask
    stable: Mask
    left: Mask
    iterations: NDArray[np.int64]

    @classmethod
    def nothing(cls, state: Place) -> Found:
        """Before the first iteration."""
        count = state.moved.shape[-1]
        no = np.zeros(count, dtype=bool)
        return cls(state.taken(np.arange(count)), no.copy(), no.copy(), no.copy(), np.zeros(count, dtype=np.int64))

    def take(self, where: NDArray[np.int64], other: Found) -> None:
        """Replace some of the entries by what was found later; iterations add up."""
        self.state.put(where, other.state)
        self.converged[where], self.stable[where] = other.converged, other.stable
        self.left[where] |= other.left
        self.iterations[where] += other.iterations


class Newton:
    """Iterations on one model.

    Parameters
    ----------
    model
        The compiled frame.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.flat = FlatModel(model) if FlatModel.suits(model) else None
        _, rows, columns = model.pattern if self.flat is None else self.flat.pattern
        self.elimination = Elimination(rows, columns, model.free, half=self.flat is not None)
        turning = np.zeros(model.size + 1, dtype=bool)
        turning[model.columns[3:]] = True
        self.turning = turning[:-1]
        self.size = max(model.frame.size, np.finfo(float).tiny)

    def equations(self, where: Where, count: int, factor: float) -> Equations | FlatEquations:
        """The equations of some entries, of the plane where the model is in one."""
        if self.flat is not None:
            return FlatEquations(self.flat, where, count, factor)
        return Equations(self.model, where, count, factor)

    def start(self, count: int) -> Place:
        """The state at rest."""
        return State.start(self.model, count) if self.flat is None else FlatEquations.start(self.model, count)

    def space(self, state: Place) -> State:
        """The state as one in space."""
        if isinstance(state, State):
            return state
        assert self.flat is not None
        return self.flat.space(state)

    def solve(self, where: Where, state: Place, factor: float) -> Found:
        """Equilibrium at a share `factor` of the loads, from the equilibrium `state` at a smaller one."""
        found = self._fast(where, state, factor)
        iterations = _FIRST
        while iterations <= _SURE:
            bad = np.flatnonzero(~(found.converged & found.stable))
            if not len(bad):
                break
            there = tuple(k[bad] for k in where)
            start = state.taken(bad) if iterations == _FIRST else found.state.taken(bad)
            again = self._sure(there, start, factor, iterations)
            self._finish(there, again, factor)
            found.take(bad, again)
            iterations *= 2
        return found

    def _finish(self, where: Where, found: Found, factor: float) -> None:
        """Try the fast way from where the sure one has come to; its end must be stable, and lower."""
        left = np.flatnonzero(~found.converged)
        if not len(left):
            return
        there = tuple(k[left] for k in where)
        equations = self.equations(there, len(left), factor)
        start = found.state.taken(left)
        tried = self._fast(there, start, factor)
        lower = equations.energy(tried.state) - equations.moment_work(start, tried.state) <= equations.energy(start)
        good = tried.converged & tried.stable & lower
        found.iterations[left] += tried.iterations
        found.state.put(left[good], tried.state.taken(good))
        found.converged[left[good]] = found.stable[left[good]] = True

    # -- fast -------------------------------------------------------------------------------------------------------

    def _fast(self, where: Where, state: Place, factor: float) -> Found:
        count = state.moved.shape[-1]
        found = Found.nothing(state)
        active = np.arange(count)
        equations = self.equations(where, count, factor)
        stresses: list[Array] | None = None
        state = state.taken(active)
        for iteration in range(_FAST):
            at = equations.linearised(state, stresses)
            lag = equations.lag(state)
            factors = self.factor(at)
            positive = (factors.pivots > _ZERO).all(axis=0)
            step = self._newton_step(at, lag, factors.solve)
            usable = np.isfinite(step).all(axis=0) & (positive | (iteration > 0))
            step = np.where(usable, step, 0.0)
            share = self._limited(step)
            close = usable & (share == 1.0) & self._is_close(equations, state, at, step)
            found.iterations[active] += 1
            state = equations.advanced(state, share * step)
            stresses = equations.step_stresses(at, share * step)
            done = close | ~usable
            if done.any():
                found.state.put(active[done], state.taken(done))
                found.converged[active[done]] = close[done]
                found.stable[active[done]] = (close & positive)[done]
                active = active[~done]
                if not len(active):
                    return found
                state, stresses = state.taken(~done), [stress[..., ~done] for stress in stresses]
                equations = self.equations(tuple(k[active] for k in where), len(active), factor)
        return found

    def factor(self, at: Linear) -> Factor:
        """The tangent factorised."""
        return self.elimination.factor(at.values, symmetric=self.model.symmetric)

    def _newton_step(self, at: Linear, lag: Array, solve: object) -> Array:
        assert callable(solve)
        load = -at.forces[: self.model.free]
        if len(lag):
            load = load - self.elimination.driven_forces(at.values, lag)
        return np.concatenate([solve(load), lag])

    def _limited(self, step: Array) -> Array:
        """Share of a step that turns and moves no more than is allowed (m,)."""
        turn = np.abs(step[self.turning]).max(axis=0, initial=0.0) / _TURN
        shift = np.abs(step[~self.turning]).max(axis=0, initial=0.0) / (_SHIFT * self.size)
        most: Array = np.maximum(turn, shift)
        return 1.0 / np.maximum(most, 1.0)

    def _is_close(self, equations: Equations, state: Place, at: Linear, step: Array) -> Mask:
        """Whether the work of the unbalanced forces on the step is nothing beside the strain energy."""
        work = np.abs(np.einsum("im,im->m", at.forces, step))
        near: Mask = work <= _CLOSE * at.energy
        return near

    # -- sure -------------------------------------------------------------------------------------------------------

    def _sure(self, where: Where, state: Place, factor: float, iterations: int) -> Found:
        count = state.moved.shape[-1]
        found = Found.nothing(state)
        active = np.arange(count)
        equations = self.equations(where, count, factor)
        state = self._driven(equations, state.taken(active))
        for _ in range(iterations):
            at = equations.linearised(state)
            step, stable, saddle = self._descent(at)
            close = self._is_close(equations, state, at, step) & ~saddle
            found.left[active] |= saddle
            share = np.where(close, 1.0, self._searched(equations, state, at, step))
            state = equations.advanced(state, share * step)
            found.iterations[active] += 1
            if close.any():
                found.state.put(active[close], state.taken(close))
                found.converged[active[close]] = True
                found.stable[active[close]] = stable[close]
                active = active[~close]
                if not len(active):
                    return found
                state = state.taken(~close)
                equations = self.equations(tuple(k[active] for k in where), len(active), factor)
        found.state.put(active, state)
        return found

    def _driven(self, equations: Equations, state: State) -> State:
        """The state with its driven coordinates where they are to be, the others following as the tangent says."""
        lag = equations.lag(state)
        if not lag.any():
            return state
        at = equations.linearised(state)
        step = self._newton_step(at, lag, self.factor(at).solve)
        fallen = ~np.isfinite(step).all(axis=0)
        step[: self.model.free, fallen] = 0.0
        return equations.advanced(state, step)

    def _descent(self, at: Linear) -> tuple[Array, Mask, Mask]:
        """A step down the energy, whether the tangent is positive definite, and whether the step leaves a saddle."""
        matrix = self.elimination.dense(at.values)
        matrix = 0.5 * (matrix + np.swapaxes(matrix, -1, -2))
        diagonal = np.abs(np.diagonal(matrix, axis1=-2, axis2=-1))
        root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        values, vectors = np.linalg.eigh(matrix * root[:, :, None] * root[:, None, :])
        load = np.einsum("mji,mj,jm->mi", vectors, root, -at.forces[: self.model.free])
        floor = _ZERO * len(root.T)
        stable = values[:, 0] > floor
        share = load / np.maximum(np.abs(values), floor)
        # at a saddle: nothing drives along the mode, but the energy falls there
        saddle = (values[:, 0] < -floor) & (np.abs(np.einsum("mi,mi->m", load, share)) <= _CLOSE * at.energy)
        if saddle.any():
            mode = vectors[saddle, :, 0] * root[saddle]
            share[saddle, 0] = self._kick(mode)
        step = np.einsum("mij,mj,mi->im", vectors, share, root)
        whole = np.zeros((self.model.size, step.shape[1]))
        whole[: self.model.free] = step
        return whole, stable, saddle

    def _kick(self, mode: Array) -> Array:
        """Amount of a mode (m, n) that is seen, its largest component positive."""
        turning = self.turning[: self.model.free]
        weighed = np.where(turning, mode, mode / self.size)
        largest = np.take_along_axis(weighed, np.abs(weighed).argmax(axis=1)[:, None], axis=1)[:, 0]
        return 1e-2 / largest

    def _searched(self, equations: Equations, state: Place, at: Linear, step: Array) -> Array:
        """Share of a step that lowers the energy enough (m,)."""
        share = self._limited(step)
        start = equations.energy(state)
        slope = np.einsum("im,im->m", at.forces, step)
        noise = 64.0 * np.finfo(float).eps * (at.energy + np.abs(start))
        waiting = np.ones(len(share), dtype=bool)
        for _ in range(40):
            tried = equations.advanced(state, share * step)
            change = equations.energy(tried) - start - equations.moment_work(state, tried)
            waiting &= ~(change <= 1e-4 * share * np.minimum(slope, 0.0) + noise)
            if not waiting.any():
                break
            share = np.where(waiting, 0.5 * share, share)
        return share
