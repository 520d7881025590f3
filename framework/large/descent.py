"""Down the energy to an equilibrium, from anywhere: slow, and sure.

Along Newton's direction with all curvatures taken positive (Dauphin et al., NeurIPS 27 (2014)), as far as a line search
allows. Where the tangent is singular, as at a pose in which a linkage can move freely, that is the free motion, in the
sense in which the loads do work on it.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..batch import Array
from ..elementwise import contracted
from .elimination import LARGE
from .limits import CLOSE, NEITHER, NOTHING
from .newton import Newton
from .numbers import Where
from .protocols import Balance, FoundEquilibria, Linearisation, Mask, Place
from .sides import amount, softest

_HALVINGS = 40
# Modes are stiff above this eigenvalue beside a unit diagonal, or above so many times that of those of which a step has
# this share of the most; Newton steps in which they settle.
_STIFF, _STIFFER, _MOVED, _SETTLING = 1e-3, 10.0, 0.1, 3
# Share of a step that is short, and how many longer ones are tried instead, each by this share of the last.
_SHORT, _TRIALS = 0.3, 3
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

    def run(self, where: Where, state: Place, factor: float, iterations: int) -> FoundEquilibria:
        """Some iterations from `state` on."""
        found = FoundEquilibria.nothing(state)
        active = np.arange(len(found.stable))
        balance = self.newton.equations(where, len(active), factor)
        state = self._prescribed(balance, state.taken(active))
        at_rest = np.abs(balance.linearised(self.newton.start(len(active))).forces[: self.model.free].T)
        for _ in range(iterations):
            at = balance.linearised(state)
            step, stiff, saddle = self._step(at, balance, state, at_rest[active])
            close = self.newton.is_close(balance, at, step) & ~saddle
            found.left[active] |= saddle
            here = tuple(k[active] for k in where)
            share = np.where(close, 1.0, self._searched(here, balance, state, at, step, factor))
            state = self._farther(here, balance, state, (step, stiff), share, factor)
            found.iterations[active] += 1
            if close.any():
                found.state.put(active[close], state.taken(close))
                found.converged[active[close]] = True
                if self.newton.pressed:
                    found.stable[active[close]] = self.newton.definite(at.values)[close]
                active = active[~close]
                if not len(active):
                    break
                state = state.taken(~close)
                balance = self.newton.equations(tuple(k[active] for k in where), len(active), factor)
        if len(active):
            found.state.put(active, state)
        self.newton.judge(where, found, factor)
        return found

    def _farther(
        self, where: Where, balance: Balance, state: Place, ahead: tuple[Array, Array], share: Array, factor: float
    ) -> Place:
        """The state after a share of the step, or beyond it on the way that stiff members leave free, if that is lower.

        A stiff rod that swings keeps its length on a circle, and would lengthen along a straight step. `ahead` are the
        step and the eigenvalue above which a mode is stiff there.
        """
        step, stiff = ahead
        found: Place = balance.advanced(state, share * step)
        far = self.newton.limited(balance, step)
        waiting = np.flatnonzero(share < _SHORT * far)
        if self.model.free > LARGE or not len(waiting):
            return found
        lowest = balance.energy(found) - balance.moment_work(state, found)
        for _ in range(_TRIALS):
            some = self.newton.equations(tuple(k[waiting] for k in where), len(waiting), factor)
            begin = state.taken(waiting)
            tried = self._settled(some, some.advanced(begin, far[waiting] * step[:, waiting]), stiff[waiting])
            better = some.energy(tried) - some.moment_work(begin, tried) < lowest[waiting]
            found.put(waiting[better], tried.taken(better))
            waiting = waiting[~better]
            if not len(waiting):
                break
            far = _SHORT * far
        return found

    def _settled(self, balance: Balance, state: Place, stiff: Array) -> Place:
        """The state with its stiff modes in balance, of eigenvalues above `stiff` (m,), the soft ones as they are."""
        out = state
        for _ in range(_SETTLING):
            at = balance.linearised(out)
            root, values, vectors = self.newton.elimination.spectrum(at.values)
            load = np.einsum("mji,mj,jm->mi", vectors, root, -at.forces[: self.model.free])
            share = np.where(np.abs(values) > stiff[:, None], load / np.where(values == 0.0, 1.0, values), 0.0)
            step = self._whole(share, vectors, root)
            out = balance.advanced(out, self.newton.limited(balance, step) * step)
        return out

    def _prescribed(self, balance: Balance, state: Place) -> Place:
        """The state with its prescribed coordinates where they are to be, the others following as the tangent says."""
        prescribed_residual = balance.prescribed_residual(state)
        if not prescribed_residual.any():
            return state
        at = balance.linearised(state)
        step = self.newton.step(at, prescribed_residual, self._resisted(at))
        step[: self.model.free, ~np.isfinite(step).all(axis=0)] = 0.0
        advanced: Place = balance.advanced(state, step)
        return advanced

    def _resisted(self, at: Linearisation) -> Callable[[Array], Array]:
        """What solves the equations of the tangent, free motions left out."""
        if self.model.free > LARGE:
            return self.newton.factor(at).solve
        root, values, vectors = self.newton.elimination.spectrum(at.values)
        free = np.abs(values) <= self.newton.free

        def solve(load: Array) -> Array:
            share = np.einsum("mji,mj,jm->mi", vectors, root, load)
            share = np.where(free, 0.0, share / np.where(free, 1.0, values))
            return self._whole(share, vectors, root)[: self.model.free]

        return solve

    def _step(self, at: Linearisation, balance: Balance, state: Place, at_rest: Array) -> tuple[Array, Array, Mask]:
        """A step down the energy; the eigenvalue above which a mode is stiff there; whether it leaves a saddle.

        `at_rest` are the loads on the coordinates at rest (m, n), by size.
        """
        if self.model.free > LARGE:
            step = self._shifted(at)
            return step, np.full(step.shape[1], _STIFF), np.zeros(step.shape[1], dtype=bool)
        root, values, vectors = self.newton.elimination.spectrum(at.values)
        modes = vectors * root[:, :, None]
        load = np.einsum("mji,mj,jm->mi", vectors, root, -at.forces[: self.model.free])
        floor = self.newton.zero
        # nothing resists a free motion: it goes where the loads drive it, and nowhere by their rounding
        free = np.abs(values) <= self.newton.free
        pushed = np.maximum(np.abs(load).max(axis=1), (at_rest * root).max(axis=1, initial=0.0))
        load = np.where(free & (np.abs(load) <= NEITHER * pushed[:, None]), 0.0, load)
        share = load / np.maximum(np.abs(values), floor)
        # nothing but rounding drives along the mode, but the energy falls there
        still = np.abs(np.einsum("mi,mi->m", load, share)) <= CLOSE * at.energy
        still |= self.newton.largest(balance, self._whole(share, vectors, root)) <= NOTHING
        saddle = (values[:, 0] < -floor) & still
        if saddle.any():
            mode = softest(values, vectors, root)
            share[saddle, 0] = (_PERTURBATION / amount(self.newton, balance, state, mode))[saddle]
        whole = self._whole(share, vectors, root)
        return np.where(np.isfinite(whole).all(axis=0), whole, 0.0), self._stiff(balance, share, values, modes), saddle

    def _stiff(self, balance: Balance, share: Array, values: Array, modes: Array) -> Array:
        """Eigenvalue above which modes (m, n, n) are stiff where a step of these shares (m, n) is made, (m,)."""
        scale = np.broadcast_to(balance.scale, (self.model.size, len(share)))[: self.model.free].T
        size = np.abs(share) * (np.abs(modes) * scale[:, :, None]).max(axis=1)
        moved = np.where(size >= _MOVED * size.max(axis=1, keepdims=True), np.abs(values), 0.0).max(axis=1)
        return np.asarray(np.minimum(_STIFF, _STIFFER * moved))

    def _whole(self, share: Array, vectors: Array, root: Array) -> Array:
        """Steps of all coordinates (size, m) for shares of the modes (m, n)."""
        out = np.zeros((self.model.size, len(share)))
        out[: self.model.free] = np.einsum("mij,mj,mi->im", vectors, share, root)
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
        return self.newton.step(at, np.zeros((0, len(shift))), factors.solve)

    def _searched(
        self, where: Where, balance: Balance, state: Place, at: Linearisation, step: Array, factor: float
    ) -> Array:
        """Share of a step that lowers the energy enough (m,)."""
        share = self.newton.limited(balance, step)
        start = balance.energy(state)
        slope = np.minimum(contracted("im,im->m", at.forces, step), 0.0)
        noise = 64.0 * np.finfo(float).eps * (at.energy + np.abs(start))
        waiting = np.arange(len(share))
        for _ in range(_HALVINGS):
            tried = balance.advanced(state, share[waiting] * step[:, waiting])
            change = balance.energy(tried) - start[waiting] - balance.moment_work(state, tried)
            left = ~(change <= 1e-4 * share[waiting] * slope[waiting] + noise[waiting])
            if not left.any():
                break
            if not left.all():
                waiting, state = waiting[left], state.taken(left)
                balance = self.newton.equations(tuple(k[waiting] for k in where), len(waiting), factor)
            share[waiting] *= 0.5
        return share
