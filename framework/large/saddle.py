"""Out of an unstable equilibrium along its free mode, to the stable one beyond.

The mode's amount is prescribed, more and more of it, and the force that this takes is found with the equilibrium. It
pulls back as long as the frame wants to go farther; where it turns round a stable equilibrium lies near.
"""

from __future__ import annotations

import numpy as np

from ..batch import Array
from .descent import Descent
from .elimination import LARGE
from .found import Balance, Found, Linear, Place
from .newton import CLOSE, Newton
from .numbers import Where

# Amounts, in radians or sizes of the frame, and iterations for each.
_AMOUNTS = (0.03, 0.1, 0.2, 0.3, 0.45, 0.6, 0.8, 1.0, 1.25, 1.5, 1.8, 2.1, 2.5, 3.0)
_ITERATIONS = 12


class Saddle:
    """Ways out of saddles of one model.

    Parameters
    ----------
    newton
        Iterations on it.
    """

    def __init__(self, newton: Newton) -> None:
        self.newton, self.model = newton, newton.model

    def leave(self, where: Where, state: Place, factor: float) -> Found:
        """Stable equilibria near the unstable ones `state`; not converged where none was found."""
        count = state.moved.shape[-1]
        balance = self.newton.equations(where, count, factor)
        at = balance.linearised(state)
        mode = self._mode(at)
        found = Found.nothing(state)
        found.left[:] = True
        waiting = np.isfinite(mode).all(axis=0)
        state, done, pull = state.taken(np.arange(count)), np.zeros(count), np.zeros(count)
        for amount in _AMOUNTS:
            state, done, pull, held = self._held(balance, state, mode, amount - done, pull, found)
            turned = np.flatnonzero(waiting & held & (pull > 0.0))
            waiting &= held & (pull <= 0.0)
            if len(turned):
                there = tuple(k[turned] for k in where)
                end = self.newton.solve(there, state.taken(turned), factor)
                found.take(turned, end, end.good)
            if not waiting.any():
                break
            done = np.full(count, amount)
        return found

    def _mode(self, at: Linear) -> Array:
        """The softest mode (free, m), its largest component one and positive; NaN where the tangent has none."""
        elimination = self.newton.elimination
        if self.model.free <= LARGE:
            root, _, vectors = elimination.spectrum(at.values)
            mode = (vectors[:, :, 0] * root).T
        else:
            mode = np.random.default_rng(0).standard_normal((self.model.free, at.values.shape[-1]))
            factors = elimination.factor(at.values)
            for _ in range(8):
                mode = factors.solve(elimination.diagonal(at.values) * mode)
                mode = mode / np.abs(mode).max(axis=0)
        return np.asarray(mode / Descent(self.newton).largest(mode))

    def _held(
        self, balance: Balance, state: Place, mode: Array, more: Array, pull: Array, found: Found
    ) -> tuple[Place, Array, Array, np.ndarray]:
        """Equilibria with `more` of the mode, the force `pull` along it, and whether they were found."""
        weight = self.newton.elimination.diagonal(self._start(balance, state)) * mode
        weight = weight / np.einsum("im,im->m", weight, mode)
        left, stresses = more, None
        held = np.zeros(len(pull), dtype=bool)
        for _ in range(_ITERATIONS):
            at = balance.linearised(state, stresses)
            factors = self.newton.factor(at)
            free = factors.solve(pull * weight - at.forces[: self.model.free])
            along = factors.solve(weight)
            change = (left - np.einsum("im,im->m", weight, free)) / np.einsum("im,im->m", weight, along)
            step = np.zeros((self.model.size, len(pull)))
            step[: self.model.free] = free + change * along
            step = np.where(held | ~np.isfinite(step).all(axis=0), 0.0, step)
            unbalanced = at.forces.copy()
            unbalanced[: self.model.free] -= pull * weight
            work = np.abs(np.einsum("im,im->m", unbalanced, step))
            pull = np.where(held | ~np.isfinite(change), pull, pull + change)
            left = left - np.einsum("im,im->m", weight, step[: self.model.free])
            state = balance.advanced(state, step)
            stresses = balance.step_stresses(at, step)
            found.iterations += ~held
            held |= (work <= CLOSE**0.5 * at.energy) & (np.abs(left) < 1e-6)
            if held.all():
                break
        return state, left, pull, held

    @staticmethod
    def _start(balance: Balance, state: Place) -> Array:
        at: Linear = balance.linearised(state)
        return at.values
