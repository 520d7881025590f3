"""Steps along equilibrium paths by arc length: the tangent of a path, and points in planes across it.

Unknowns and load factor go together (Riks, J. Appl. Mech. 39 (1972) 1060-1065; Ramm 1981). The length of a step is that
of its coordinates, turns as they are and displacements in sizes of the frame; the load factor has no share in it.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..elementwise import contracted
from .newton import Newton, bordered
from .numbers import Where
from .state import Index, Mask, StateOfEntries
from .tree_equations import Linearisation

# Iterations that a step takes at most.
MOST = 12
_CLOSE = 1e-16
# How far from its tangent the path may bend in a step, as a share of the step.
_ASIDE = 0.5


@dataclass(frozen=True, eq=False)
class ArcPoint:
    """A point of each of m paths, from which these go on.

    Attributes
    ----------
    state, factor
        Where they are, and under which share of the loads (m,).
    along, slope
        Unit tangent, coordinates (size, m), and the change of the load factor by arc length (m,).
    """

    state: StateOfEntries
    factor: Array
    along: Array
    slope: Array


@dataclass(frozen=True, eq=False)
class Corrected:
    """Ends of a step: states, load factors, iterations and whether the energy has a minimum there, (m,) each."""

    state: StateOfEntries
    factor: Array
    iterations: NDArray[np.int64]
    stable: Mask


class ArcLength:
    """Predictor and corrector of the paths of some batch entries of a model.

    Parameters
    ----------
    newton
        Newton's method on the model.
    where
        Indices of the entries along each batch axis.
    count
        Number of entries.
    """

    def __init__(self, newton: Newton, where: Where, count: int) -> None:
        self.newton, self.model, self.count = newton, newton.model, count
        self.whole, self.none = (newton.equations(where, count, factor) for factor in (1.0, 0.0))

    @cached_property
    def weight(self) -> Array:
        """Weights of the squares of the coordinates in those of lengths (size, m or 1)."""
        out: Array = self.whole.scale**2
        return out

    def inner(self, a: Array, b: Array) -> Array:
        """Inner product of steps (size, m), the squares of whose lengths it gives."""
        out: Array = contracted("im,im->m", self.weight * a, b)
        return out

    def tangent(self, state: StateOfEntries, factor: Array) -> tuple[Array, Array]:
        """Unit tangents (size, m) in the direction in which the load factor grows, and by how much it does (m,)."""
        at, load = self.linear(state, None, factor)
        ahead = self.newton.step(at, self.whole.prescribed_values, self.newton.factor(at).solve, load)
        size = np.sqrt(self.inner(ahead, ahead))
        slope = 1.0 / np.where(size > 0.0, size, np.nan)  # without a load there is no path
        return ahead * slope, slope

    def linear(self, state: StateOfEntries, stresses: list[Array] | None, factor: Array) -> tuple[Linearisation, Array]:
        """Forces and tangent at a load factor (m,), and the loads (size, m)."""
        whole, none = (part.linearised(state, stresses) for part in (self.whole, self.none))
        mixed = replace(
            none,
            forces=none.forces + factor * (whole.forces - none.forces),
            values=none.values + factor * (whole.values - none.values),
        )
        return mixed, none.forces - whole.forces

    def corrected(self, begin: ArcPoint, length: Array, paths: Index) -> Corrected:
        """Points of equilibrium in the plane across the tangent, at the ends of steps of some lengths (m,).

        Of other entries than `paths` none are sought. Where none is found, `iterations` are more than `MOST`.
        """
        done = np.ones(self.count, dtype=bool)
        done[paths] = False
        step, share = (np.where(done, 0.0, length * each) for each in (begin.along, begin.slope))
        at, _ = self.linear(begin.state, None, begin.factor)
        state, factor = self.whole.advanced(begin.state, step), begin.factor + share
        stresses = self.whole.step_stresses(at, step)
        prescribed, stable = self.whole.prescribed_values, np.zeros(len(factor), dtype=bool)
        iterations = np.zeros(len(factor), dtype=np.int64)
        aside = np.zeros_like(step)
        while not done.all() and iterations.max() <= MOST:
            at, load = self.linear(state, stresses, factor)
            factors = self.newton.factor(at)
            by_load = self.newton.step(at, prescribed, factors.solve, load)
            there = prescribed - self.whole.prescribed_residual(state)
            free = self.newton.step(at, factor * prescribed - there, factors.solve)
            step, change = bordered(self.weight * begin.along, free, by_load)
            step = np.where(done, 0.0, step)
            usable = np.isfinite(step).all(axis=0) & np.isfinite(change)
            step = np.where(usable, step, 0.0)
            aside += step
            state = self.whole.advanced(state, step)
            factor = np.where(done | ~usable, factor, factor + change)
            stresses = self.whole.step_stresses(at, step)
            iterations += ~done
            # without that of the reactions, on prescribed displacements that are where they should be but for rounding
            forces, push, moved = (part[: self.model.free] for part in (at.forces, load, step))
            work = np.abs(contracted("im,im->m", forces, moved)) + np.abs(change * contracted("im,im->m", push, moved))
            # the plane leaves a single coordinate no step: the load factor alone, in which forces are linear, balances
            close = ~done & usable & (work <= _CLOSE * at.energy)
            stable = np.where(close, (factors.pivots > 0.0).all(axis=0), stable)
            done |= close
        iterations[~done | (self.inner(aside, aside) > (_ASIDE * length) ** 2)] = MOST + 1
        return Corrected(state, factor, iterations, stable)
