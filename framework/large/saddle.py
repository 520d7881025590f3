"""Out of an unstable equilibrium along its free mode, to the stable one beyond.

The mode's amount is prescribed, more and more of it, and the force that this takes is found with the equilibrium. It
pulls back as long as the frame wants to go farther; where it turns round a stable equilibrium lies near.

The mode leads down to both sides. It is followed to the side to which the first little share of the loads moves the
frame: there it goes on when it is loaded bit by bit. Where that is neither, as along the axis of a straight column, the
two ways are mirror images and the choice is arbitrary; it is then told by how the described nodes move, so that it does
not depend on what the frame is made of: of the largest displacements, or rotations times the size of the frame, the
first in the order of nodes is positive.
"""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array
from ..elementwise import contracted
from .elimination import LARGE, Spectrum
from .newton import Newton, bordered
from .numbers import Where, at_index
from .recorded_newton import CLOSE
from .state import FoundEquilibria, Index, Mask, StateOfEntries
from .tree_equations import Linearisation, TreeEquations

# Steps of the amount, in radians or sizes of the frame: the first, the longest, and one at which the way is given up.
_BEGIN, _LONGEST, _LEAST = 0.03, 0.3, 1e-3
# How steps grow where they succeed and shrink where not; the whole amount, steps at most, and iterations for each.
_GROWTH, _SHRINK, _WHOLE, _STEPS, _ITERATIONS = 2.0, 0.2, 3.0, 40, 12
# Interpolations of the amount at which the force is zero.
_SECANTS = 2
# Share of what loads of that size could do that is rounding, and drives no free motion to either side.
NEITHER = 3e-8
# Amount of a mode that shows how nodes move, in radians or sizes of the frame; displacements, as a share of the
# largest, that are as large.
_AMOUNT, _ALIKE = 1e-6, 0.999
# Difference of eigenvalues, beside a unit diagonal, within which any mixture of their modes is a mode.
_EQUAL = 1e-9


class Saddle:
    """Ways out of saddles of one model.

    Parameters
    ----------
    newton
        Iterations on it.
    """

    def __init__(self, newton: Newton) -> None:
        self.newton, self.model = newton, newton.model

    def leave(self, where: Where, state: StateOfEntries, factor: float) -> FoundEquilibria:
        """Stable equilibria near the unstable ones `state`; not converged where none was found."""
        count = state.displacements.shape[-1]
        equations = self.newton.equations(where, count, factor)
        at = equations.linearised(state)
        mode = self._mode(equations, state, at)
        found = FoundEquilibria.nothing(state)
        found.left[:] = True
        waiting: Mask = np.asarray(np.isfinite(mode).all(axis=0))
        state, done, push = state.taken(np.arange(count)), np.zeros(count), np.zeros(count)
        more = np.full(count, _BEGIN)
        for _ in range(_STEPS):
            ahead, force, settled = self._with_more(equations, state, mode, np.where(waiting, more, 0.0), push, found)
            on = np.flatnonzero(waiting & settled)
            before = push.copy()
            state.put(on, ahead.taken(on))
            done[on], push[on] = done[on] + more[on], force[on]
            reversing = on[push[on] > 0.0]
            waiting[reversing] = False
            if len(reversing):
                there = at_index(where, reversing)
                near = self._between(there, state.taken(reversing), mode[:, reversing], more[reversing],
                                     (before[reversing], push[reversing]), factor)  # fmt: skip
                end = self.newton.solve(there, near, factor)
                bad = np.flatnonzero(~end.good)
                if len(bad):
                    end.take(bad, self.newton.solve(at_index(there, bad), state.taken(reversing[bad]), factor))
                found.take(reversing, end, end.good)
            more = np.where(settled, np.minimum(_GROWTH * more, _LONGEST), _SHRINK * more)
            waiting &= (more > _LEAST) & (done < _WHOLE)
            if not waiting.any():
                break
        return found

    def _between(
        self,
        where: Where,
        state: StateOfEntries,
        mode: Array,
        step: Array,
        pushes: tuple[Array, Array],
        factor: float,
    ) -> StateOfEntries:
        """Back to where the push along the mode is nearly zero, between its values `pushes` a `step` ago and now.

        Newton's method from farther away may end on the other side.
        """
        equations = self.newton.equations(where, len(step), factor)
        before, now = pushes
        for _ in range(_SECANTS):
            change = now - before
            step = np.where(change != 0.0, -step * now / np.where(change != 0.0, change, 1.0), 0.0)
            ahead, force, settled = self._with_more(equations, state, mode, step, now, FoundEquilibria.nothing(state))
            state.put(np.flatnonzero(settled), ahead.taken(settled))
            before, now = np.where(settled, now, before), np.where(settled, force, now)
            step = np.where(settled, step, 0.0)
        return state

    def _mode(self, equations: TreeEquations, state: StateOfEntries, at: Linearisation) -> Array:
        """The softest mode (free, m), its largest component one, to the side to which the saddle is left.

        NaN where the tangent has none.
        """
        elimination = self.newton.elimination
        if self.model.free <= LARGE:
            mode = softest(elimination.spectrum(at.values))
        else:
            mode = np.random.default_rng(0).standard_normal((self.model.free, at.values.shape[-1]))
            factors = elimination.factor(at.values)
            for _ in range(8):
                mode = factors.solve(elimination.diagonal(at.values) * mode)
                mode = mode / np.abs(mode).max(axis=0)
        return np.asarray(mode / amount(self.newton, equations, state, mode))

    def _with_more(
        self,
        equations: TreeEquations,
        state: StateOfEntries,
        mode: Array,
        more: Array,
        push: Array,
        found: FoundEquilibria,
    ) -> tuple[StateOfEntries, Array, Mask]:
        """Equilibria with `more` of the mode, the `push` along it that they take, and whether they were found."""
        weight = self.newton.elimination.diagonal(equations.linearised(state).values) * mode
        weight = weight / contracted("im,im->m", weight, mode)
        left, stresses = more, None
        settled = np.zeros(len(push), dtype=bool)
        for _ in range(_ITERATIONS):
            at = equations.linearised(state, stresses)
            factors = self.newton.factor(at)
            free = factors.solve(push * weight - at.forces[: self.model.free])
            along = factors.solve(weight)
            step = np.zeros((self.model.size, len(push)))
            step[: self.model.free], change = bordered(weight, free, along, left)
            step = np.where(settled | ~np.isfinite(step).all(axis=0), 0.0, step)
            unbalanced = at.forces.copy()
            unbalanced[: self.model.free] -= push * weight
            work = np.abs(contracted("im,im->m", unbalanced, step))
            push = np.where(settled | ~np.isfinite(change), push, push + change)
            left = left - contracted("im,im->m", weight, step[: self.model.free])
            state = equations.advanced(state, step)
            stresses = equations.step_stresses(at, step)
            found.iterations += ~settled
            settled |= (work <= CLOSE**0.5 * at.energy) & (np.abs(left) < 1e-6)
            if settled.all():
                break
        return state, push, settled


def amount(newton: Newton, equations: TreeEquations, state: StateOfEntries, mode: Array) -> Array:
    """Component of a mode (n, m) that is seen most, in radians or sizes of the frame, (m,).

    Positive where the mode as it stands leads to the side to which `state` is to be left.
    """
    free = newton.model.free
    scale = equations.scale[:free]
    weighted = mode * scale
    size: Array = np.abs(weighted).max(axis=0)
    size = np.where(size > 0.0, size, 1.0)
    load, compliance = _at_rest(newton, equations, scale * weighted)
    along = contracted("im,im->m", load, compliance)
    load = np.divide(load, scale, out=np.zeros_like(load), where=scale > 0.0)
    most = np.abs(load).max(axis=0, initial=0.0) * np.abs(scale * compliance).max(axis=0, initial=0.0)
    pushed = np.abs(along) > NEITHER * most
    seen = _seen(newton, equations, state, mode / size)
    side: Array = np.where(pushed, np.sign(along), np.where(seen < 0.0, -1.0, 1.0))
    return side * size


def softest(spectrum: Spectrum) -> Array:
    """The softest mode (n, m) of a spectrum; where several are as soft, one that depends on no rounding.

    That is the shadow of a fixed vector on all of them: which of them the spectrum has is arbitrary.
    """
    values, vectors = spectrum.values, spectrum.vectors
    alike = np.where(values <= values[:, :1] + _EQUAL, 1.0, 0.0)
    fixed = 1.0 / np.arange(1.0, vectors.shape[1] + 1.0)
    share = alike * (vectors * fixed[:, None]).sum(axis=1)
    size = np.sqrt((share * share).sum(axis=1, keepdims=True))
    clear = (size > NEITHER) & (alike.sum(axis=1, keepdims=True) > 1.0)
    share = np.where(clear, share / np.where(clear, size, 1.0), np.arange(values.shape[1]) == 0)
    out: Array = ((vectors * share[:, None, :]).sum(axis=2) * spectrum.root).T
    return np.ascontiguousarray(out)


def _at_rest(newton: Newton, equations: TreeEquations, weights: Array) -> tuple[Array, Array]:
    """Loads at rest (free, m), and by how much they change a weighed sum of the displacements; zero where singular."""
    start, free = newton.start(weights.shape[-1]), newton.model.free
    at = equations.linearised(start)
    load = newton.step(at, equations.prescribed_residual(start), lambda load: load)[:free]
    # what a free motion resists with is rounding, of either sign: a little more makes it positive
    stiffer = newton.elimination.raised(at.values, np.full(weights.shape[-1], newton.elimination.free))
    with np.errstate(all="ignore"):
        change = newton.elimination.factor(stiffer, symmetric=newton.model.symmetric).solve(weights)
    return load, np.where(np.isfinite(change).all(axis=0), change, 0.0)


def _seen(newton: Newton, equations: TreeEquations, state: StateOfEntries, mode: Array) -> Array:
    """Of the largest displacements and rotations of the described nodes in a mode, the first (m,)."""
    each = node_motion(newton, equations, state, mode)
    each[3:] *= equations.lengths
    # displacements of all nodes before rotations
    each = each.reshape(2, 3, *each.shape[1:]).swapaxes(1, 2).reshape(-1, mode.shape[-1])
    first: Index = (np.abs(each) >= _ALIKE * np.abs(each).max(axis=0)).argmax(axis=0)
    out: Array = each[first, np.arange(each.shape[-1])]
    return out


def node_motion(newton: Newton, equations: TreeEquations, state: StateOfEntries, mode: Array) -> Array:
    """Displacements and rotations of the described nodes by a little of a mode (n, m), global, (6, nodes, m)."""
    step = np.zeros((newton.model.size, mode.shape[-1]))
    step[: newton.model.free] = _AMOUNT * mode
    before, after = newton.space(state), newton.space(equations.advanced(state, step))
    count = len(newton.model.frame.nodes)
    displacements = (after.displacements - before.displacements)[:, :count]
    back = rotation.conjugate(before.rotations[:, :count])
    rotations = rotation.logarithm(rotation.product(after.rotations[:, :count], back))
    return np.concatenate([displacements, rotations])
