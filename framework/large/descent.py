"""Descent of the energy to an equilibrium, from anywhere: slow, and sure.

Along Newton's direction with all curvatures taken positive (Dauphin et al., NeurIPS 27 (2014)), as far as a line search
allows. Where the tangent is singular, as at a pose in which a linkage can move freely, that is the free motion, in the
sense in which the loads do work on it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from ..batch import Array
from ..elementwise import contracted
from .elimination import LARGE, Spectrum
from .newton import Newton
from .numbers import Where, at_index
from .recorded_newton import CLOSE, NOTHING
from .saddle import NEITHER, amount, softest
from .state import FoundEquilibria, Mask, StateOfEntries
from .tree_equations import Linearisation, TreeEquations

_HALVINGS = 40
# Modes are stiff above this eigenvalue beside a unit diagonal, or above so many times that of those of which a step has
# this share of the most; Newton steps in which they settle.
_STIFF, _STIFFER, _MOVED, _SETTLING = 1e-3, 10.0, 0.1, 3
# Share of a step that is short, and how many longer ones are tried instead, each by this share of the last.
_SHORT, _TRIALS = 0.3, 3
# Stiffness beside a unit diagonal, with which rounding does not move what is free.
_LITTLE = 1e-10
# Amount of a mode, in radians or sizes of the frame, by which a saddle is left.
_PERTURBATION = 1e-2


class Descent:
    """Descents on one model.

    Parameters
    ----------
    newton
        Iterations on it.
    """

    def __init__(self, newton: Newton) -> None:
        self.newton, self.model = newton, newton.model

    def run(self, where: Where, state: StateOfEntries, factor: float, iterations: int) -> FoundEquilibria:
        """Some iterations from `state` on."""
        found = FoundEquilibria.nothing(state)
        active = np.arange(len(found.stable))
        equations = self.newton.equations(where, len(active), factor)
        state = self._prescribed(equations, state.taken(active))
        at_rest = np.abs(equations.linearised(self.newton.start(len(active))).forces[: self.model.free].T)
        for _ in range(iterations):
            at = equations.linearised(state)
            step, stiff, saddle = self._step(at, equations, state, at_rest[active])
            close = self.newton.is_close(equations, at, step) & ~saddle
            found.left[active] |= saddle
            here = at_index(where, active)
            share = np.where(close, 1.0, self._searched(here, equations, state, at, step, factor))
            state = self._farther(here, equations, state, (step, stiff), share, factor)
            found.iterations[active] += 1
            if close.any():
                found.state.put(active[close], state.taken(close))
                found.converged[active[close]] = True
                if self.model.has_clearance:
                    found.stable[active[close]] = self.newton.elimination.definite(at.values)[close]
                active = active[~close]
                if not len(active):
                    break
                state = state.taken(~close)
                equations = self.newton.equations(at_index(where, active), len(active), factor)
        if len(active):
            found.state.put(active, state)
        self.newton.judge(where, found, factor)
        return found

    def _farther(
        self,
        where: Where,
        equations: TreeEquations,
        state: StateOfEntries,
        ahead: tuple[Array, Array],
        share: Array,
        factor: float,
    ) -> StateOfEntries:
        """The state after a share of the step, or farther along the motion that stiff members leave free, if lower.

        A stiff rod that swings keeps its length on a circle, and would lengthen along a straight step. `ahead` are the
        step and the eigenvalue above which a mode is stiff there.
        """
        step, stiff = ahead
        found: StateOfEntries = equations.advanced(state, share * step)
        far = self.newton.limited(equations, step)
        waiting = np.flatnonzero(share < _SHORT * far)
        if self.model.free > LARGE or not len(waiting):
            return found
        lowest = equations.energy(found) - equations.moment_work(state, found)
        for _ in range(_TRIALS):
            some = self.newton.equations(at_index(where, waiting), len(waiting), factor)
            begin = state.taken(waiting)
            tried = self._settled(some, some.advanced(begin, far[waiting] * step[:, waiting]), stiff[waiting])
            better = some.energy(tried) - some.moment_work(begin, tried) < lowest[waiting]
            found.put(waiting[better], tried.taken(better))
            waiting = waiting[~better]
            if not len(waiting):
                break
            far = _SHORT * far
        return found

    def _settled(self, equations: TreeEquations, state: StateOfEntries, stiff: Array) -> StateOfEntries:
        """The state with its stiff modes in balance, of eigenvalues above `stiff` (m,), the soft ones as they are."""
        out = state
        for _ in range(_SETTLING):
            at = equations.linearised(out)
            spectrum = self.newton.elimination.spectrum(at.values)
            values, load = spectrum.values, spectrum.share(-at.forces[: self.model.free])
            share = np.where(np.abs(values) > stiff[:, None], load / np.where(values == 0.0, 1.0, values), 0.0)
            step = self._whole(spectrum, share)
            out = equations.advanced(out, self.newton.limited(equations, step) * step)
        return out

    def _prescribed(self, equations: TreeEquations, state: StateOfEntries) -> StateOfEntries:
        """The state with its prescribed coordinates where they are to be, the others following as the tangent says."""
        prescribed_residual = equations.prescribed_residual(state)
        if not prescribed_residual.any():
            return state
        at = equations.linearised(state)
        step = self.newton.step(at, prescribed_residual, self._resisted(at))
        step[: self.model.free, ~np.isfinite(step).all(axis=0)] = 0.0
        advanced: StateOfEntries = equations.advanced(state, step)
        return advanced

    def _resisted(self, at: Linearisation) -> Callable[[Array], Array]:
        """What solves the equations of the tangent, free motions left out."""
        elimination = self.newton.elimination
        if self.model.free > LARGE:
            # a little stiffness on each coordinate resists a free motion, and changes the others by a little
            return elimination.factor(elimination.raised(at.values, _LITTLE)).solve
        spectrum = elimination.spectrum(at.values)
        return partial(spectrum.solve, free=np.abs(spectrum.values) <= elimination.free)

    def _step(
        self, at: Linearisation, equations: TreeEquations, state: StateOfEntries, at_rest: Array
    ) -> tuple[Array, Array, Mask]:
        """A step down the energy; the eigenvalue above which a mode is stiff there; whether it leaves a saddle.

        `at_rest` are the loads on the coordinates at rest (m, n), by size.
        """
        if self.model.free > LARGE:
            step = self._shifted(at)
            return step, np.full(step.shape[1], _STIFF), np.zeros(step.shape[1], dtype=bool)
        spectrum = self.newton.elimination.spectrum(at.values)
        values, load = spectrum.values, spectrum.share(-at.forces[: self.model.free])
        floor = self.newton.elimination.zero
        # nothing resists a free motion: it goes where the loads drive it, and nowhere by their rounding
        free = np.abs(values) <= self.newton.elimination.free
        pushed = np.maximum(np.abs(load).max(axis=1), (at_rest * spectrum.root).max(axis=1, initial=0.0))
        load = np.where(free & (np.abs(load) <= NEITHER * pushed[:, None]), 0.0, load)
        share = load / np.maximum(np.abs(values), floor)
        # nothing but rounding drives along the mode, but the energy falls there
        still = np.abs(np.einsum("mi,mi->m", load, share)) <= CLOSE * at.energy
        still |= self.newton.largest(equations, self._whole(spectrum, share)) <= NOTHING
        saddle = (values[:, 0] < -floor) & still
        if saddle.any():
            mode = softest(spectrum)
            share[saddle, 0] = (_PERTURBATION / amount(self.newton, equations, state, mode))[saddle]
        whole = self._whole(spectrum, share)
        idle = free & (load == 0.0)
        idle[saddle, 0] = False
        if idle.any():
            weights = np.broadcast_to(equations.scale, whole.shape)[: self.model.free]
            whole[: self.model.free] = spectrum.without(whole[: self.model.free], idle, weights)
        return np.where(np.isfinite(whole).all(axis=0), whole, 0.0), self._stiff(equations, share, spectrum), saddle

    def _stiff(self, equations: TreeEquations, share: Array, spectrum: Spectrum) -> Array:
        """Eigenvalue above which modes are stiff where a step of these shares (m, n) is made, (m,)."""
        scale = np.broadcast_to(equations.scale, (self.model.size, len(share)))[: self.model.free].T
        size = np.abs(share) * (np.abs(spectrum.modes) * scale[:, :, None]).max(axis=1)
        moved = np.where(size >= _MOVED * size.max(axis=1, keepdims=True), np.abs(spectrum.values), 0.0).max(axis=1)
        return np.asarray(np.minimum(_STIFF, _STIFFER * moved))

    def _whole(self, spectrum: Spectrum, share: Array) -> Array:
        """Steps of all coordinates (size, m) for shares of the modes (m, n)."""
        out = np.zeros((self.model.size, len(share)))
        out[: self.model.free] = spectrum.summed(share)
        return out

    def _shifted(self, at: Linearisation) -> Array:
        """The same for a large frame: the diagonal raised until all pivots are positive."""
        elimination = self.newton.elimination
        shift = np.zeros(at.values.shape[-1])
        for _ in range(_HALVINGS):
            factors = elimination.factor(elimination.raised(at.values, shift))
            positive = (factors.pivots > 0.0).all(axis=0)
            if positive.all():
                break
            shift = np.where(positive, shift, np.maximum(10.0 * shift, 1e-10))
        prescribed = np.zeros((self.model.size - self.model.free, len(shift)))
        return self.newton.step(at, prescribed, factors.solve)

    def _searched(
        self,
        where: Where,
        equations: TreeEquations,
        state: StateOfEntries,
        at: Linearisation,
        step: Array,
        factor: float,
    ) -> Array:
        """Share of a step that lowers the energy enough (m,)."""
        share = self.newton.limited(equations, step)
        start = equations.energy(state)
        slope = np.minimum(contracted("im,im->m", at.forces, step), 0.0)
        noise = 64.0 * np.finfo(float).eps * (at.energy + np.abs(start))
        waiting = np.arange(len(share))
        for _ in range(_HALVINGS):
            tried = equations.advanced(state, share[waiting] * step[:, waiting])
            change = equations.energy(tried) - start[waiting] - equations.moment_work(state, tried)
            left = ~(change <= 1e-4 * share[waiting] * slope[waiting] + noise[waiting])
            if not left.any():
                break
            if not left.all():
                waiting, state = waiting[left], state.taken(left)
                equations = self.newton.equations(at_index(where, waiting), len(waiting), factor)
            share[waiting] *= 0.5
        return share
