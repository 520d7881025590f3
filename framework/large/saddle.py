"""Out of an unstable equilibrium along its free mode, to the stable one beyond.

The mode's amount is prescribed, more and more of it, and the force that this takes is found with the equilibrium. It
pulls back as long as the frame wants to go farther; where it turns round a stable equilibrium lies near.
"""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..elementwise import contracted
from .elimination import LARGE
from .limits import CLOSE
from .newton import Newton, bordered
from .numbers import Where
from .protocols import Balance, FoundEquilibria, Linearisation, Mask, Place
from .sides import amount, softest

# Steps of the amount, in radians or sizes of the frame: the first, the longest, and one at which the way is given up.
_BEGIN, _LONGEST, _LEAST = 0.03, 0.3, 1e-3
# How steps grow where they succeed and shrink where not; the whole amount, steps at most, and iterations for each.
_GROWTH, _SHRINK, _WHOLE, _STEPS, _ITERATIONS = 2.0, 0.2, 3.0, 40, 12
# Interpolations of the amount at which the force is zero.
_SECANTS = 2


class Saddle:
    """Ways out of saddles of one model.

    Parameters
    ----------
    newton
        Iterations on it.
    """

    def __init__(self, newton: Newton) -> None:
        self.newton, self.model = newton, newton.model

    def leave(self, where: Where, state: Place, factor: float) -> FoundEquilibria:
        """Stable equilibria near the unstable ones `state`; not converged where none was found."""
        count = state.displacements.shape[-1]
        balance = self.newton.equations(where, count, factor)
        at = balance.linearised(state)
        mode = self._mode(balance, state, at)
        found = FoundEquilibria.nothing(state)
        found.left[:] = True
        waiting: Mask = np.asarray(np.isfinite(mode).all(axis=0))
        state, done, generalised_force = state.taken(np.arange(count)), np.zeros(count), np.zeros(count)
        more = np.full(count, _BEGIN)
        for _ in range(_STEPS):
            ahead, force, constrained = self._constrained(
                balance, state, mode, np.where(waiting, more, 0.0), generalised_force, found
            )
            on = np.flatnonzero(waiting & constrained)
            before = generalised_force.copy()
            state.put(on, ahead.taken(on))
            done[on], generalised_force[on] = done[on] + more[on], force[on]
            reversing = on[generalised_force[on] > 0.0]
            waiting[reversing] = False
            if len(reversing):
                there = tuple(k[reversing] for k in where)
                near = self._between(there, state.taken(reversing), mode[:, reversing], more[reversing],
                                     (before[reversing], generalised_force[reversing]), factor)  # fmt: skip
                end = self.newton.solve(there, near, factor)
                bad = np.flatnonzero(~end.good)
                if len(bad):
                    again = tuple(k[bad] for k in there)
                    end.take(bad, self.newton.solve(again, state.taken(reversing[bad]), factor))
                found.take(reversing, end, end.good)
            more = np.where(constrained, np.minimum(_GROWTH * more, _LONGEST), _SHRINK * more)
            waiting &= (more > _LEAST) & (done < _WHOLE)
            if not waiting.any():
                break
        return found

    def _between(
        self,
        where: Where,
        state: Place,
        mode: Array,
        step: Array,
        generalised_forces: tuple[Array, Array],
        factor: float,
    ) -> Place:
        """Back to where the force along the mode is nearly zero, between its values `generalised_forces` a `step` ago
        and now.

        Newton's method from farther away may end on the other side.
        """
        balance = self.newton.equations(where, len(step), factor)
        before, now = generalised_forces
        for _ in range(_SECANTS):
            change = now - before
            step = np.where(change != 0.0, -step * now / np.where(change != 0.0, change, 1.0), 0.0)
            ahead, force, constrained = self._constrained(
                balance, state, mode, step, now, FoundEquilibria.nothing(state)
            )
            state.put(np.flatnonzero(constrained), ahead.taken(constrained))
            before, now = np.where(constrained, now, before), np.where(constrained, force, now)
            step = np.where(constrained, step, 0.0)
        return state

    def _mode(self, balance: Balance, state: Place, at: Linearisation) -> Array:
        """The softest mode (free, m), its largest component one, to the side to which the saddle is left.

        NaN where the tangent has none.
        """
        elimination = self.newton.elimination
        if self.model.free <= LARGE:
            root, values, vectors = elimination.spectrum(at.values)
            mode = softest(values, vectors, root)
        else:
            mode = np.random.default_rng(0).standard_normal((self.model.free, at.values.shape[-1]))
            factors = elimination.factor(at.values)
            for _ in range(8):
                mode = factors.solve(elimination.diagonal(at.values) * mode)
                mode = mode / np.abs(mode).max(axis=0)
        return np.asarray(mode / amount(self.newton, balance, state, mode))

    def _constrained(
        self, balance: Balance, state: Place, mode: Array, more: Array, generalised_force: Array, found: FoundEquilibria
    ) -> tuple[Place, Array, Mask]:
        """Equilibria with `more` of the mode, the force `generalised_force` along it, and whether they were found."""
        weight = self.newton.elimination.diagonal(self._start(balance, state)) * mode
        weight = weight / contracted("im,im->m", weight, mode)
        left, stresses = more, None
        constrained = np.zeros(len(generalised_force), dtype=bool)
        for _ in range(_ITERATIONS):
            at = balance.linearised(state, stresses)
            factors = self.newton.factor(at)
            free = factors.solve(generalised_force * weight - at.forces[: self.model.free])
            along = factors.solve(weight)
            step = np.zeros((self.model.size, len(generalised_force)))
            step[: self.model.free], change = bordered(weight, free, along, left)
            step = np.where(constrained | ~np.isfinite(step).all(axis=0), 0.0, step)
            unbalanced = at.forces.copy()
            unbalanced[: self.model.free] -= generalised_force * weight
            work = np.abs(contracted("im,im->m", unbalanced, step))
            generalised_force = np.where(
                constrained | ~np.isfinite(change), generalised_force, generalised_force + change
            )
            left = left - contracted("im,im->m", weight, step[: self.model.free])
            state = balance.advanced(state, step)
            stresses = balance.step_stresses(at, step)
            found.iterations += ~constrained
            constrained |= (work <= CLOSE**0.5 * at.energy) & (np.abs(left) < 1e-6)
            if constrained.all():
                break
        return state, generalised_force, constrained

    @staticmethod
    def _start(balance: Balance, state: Place) -> Array:
        at: Linearisation = balance.linearised(state)
        return at.values
