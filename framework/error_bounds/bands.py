"""Inverses of the stiffness of middle-sized frames in batches: a banded factor for each entry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..solvers.evaluation import Picked
from ..solvers.stacked_bands import Bands, StackedFactor
from ..structure.topology import Index
from .compliance import Compliance, estimated_least, rounding_of
from .deformations import Springs
from .equilibrium import EquilibriumResidual
from .kinematic_edge import Real, extended
from .kinematics import FrameKinematics
from .resistance import resisted

# Inverse iterations, from random vectors, that find the least eigenvalue.
_TO_THE_LEAST, _RANDOM = 8, 2


@dataclass(frozen=True)
class _Double:
    """A frame in double precision, for `resisted`."""

    kinematics: FrameKinematics
    springs: list[Springs]
    stiffness: list[Real]


class BandedCompliance(Compliance):
    """Matrices of one pattern, each with its factor; the least eigenvalues by inverse iteration, with a margin.

    Parameters
    ----------
    bands
        The pattern of the unknowns of the state.
    place
        Place of each of these in its order, (n,).
    numbers
        Number of the matrix at each entry of the state, of one along batch axes over which it does not vary.
    picked
        Entries with these matrices, in the order of `numbers`.
    state
        A solution, to the frame of which the motions that inverse iteration finds are put.
    """

    def __init__(self, bands: Bands, place: Index, numbers: Index, picked: Picked, state: EquilibriumResidual) -> None:
        self._place, self._numbers, self._state = place, numbers, state
        self._factor: StackedFactor = bands.factorised(picked)
        self.root = self._factor.root[place].T.reshape(*numbers.shape, len(place))
        coupled = state.plan.graph.coupled
        self.greatest = float(coupled)
        self.backward_error = np.asarray(rounding_of(coupled))
        motion, self._growth = self._softest()
        moved = extended(self.root * motion)
        resistance = np.sum(resisted(state, state.unknowns, moved) * moved, axis=-1).astype(np.float64)
        self.least = estimated_least(np.minimum(1.0 / self._growth, resistance), self.backward_error)

    def _softest(self) -> tuple[Array, Array]:
        """Motions of length one that the scaled matrices resist least, (..., n), and one over what by, (...)."""
        size = len(self._place)
        start = np.random.default_rng(0).standard_normal((_RANDOM, size))
        count = (1,) * self._numbers.ndim
        vector = np.broadcast_to(start.reshape(_RANDOM, *count, size), (_RANDOM, *self._numbers.shape, size))
        growth = np.ones(self._numbers.shape)
        for _ in range(_TO_THE_LEAST):
            found = self._solved(vector / np.sqrt(np.sum(vector**2, axis=-1, keepdims=True)))
            sizes = np.sqrt(np.sum(found**2, axis=-1)).max(axis=0)
            growth = np.where(np.isfinite(sizes), sizes, np.inf)
            vector = np.where(np.isfinite(sizes)[..., None], found, vector)
        motion: Array = vector[0] / np.sqrt(np.sum(vector[0] ** 2, axis=-1, keepdims=True))
        return motion, growth

    def _solved(self, load: Array) -> Array:
        """Solutions of the scaled matrices for loads (..., n)."""
        numbers, size = self._numbers, load.shape[-1]
        ahead = load.ndim - 1 - numbers.ndim
        shape = np.broadcast_shapes(load.shape[:-1], numbers.shape)
        # the axes over which matrices vary come first, all others are loads of each
        axes = [ahead + axis for axis, count in enumerate(numbers.shape) if count > 1]
        first = range(len(axes))
        moved = np.moveaxis(np.broadcast_to(load, (*shape, size)), axes, first)
        ordered = np.empty((size, numbers.size, moved.size // max(1, numbers.size * size)))
        ordered[self._place] = moved.reshape(-1, size).T.reshape(ordered.shape)
        self._factor.solve(np.arange(numbers.size), ordered)
        solved = ordered[self._place].reshape(size, -1).T.reshape(moved.shape)
        found: Array = np.moveaxis(solved, first, axes)
        return found

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        out: Array = self.root * self._solved((self.root * load).astype(np.float64))
        return out

    def distance(self) -> Array:
        """Least singular value of the deformations by the unknowns, scaled to columns of length one, estimated,
        (...)."""
        out: Array = 1.0 / np.sqrt(self._growth)
        return out

    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""
        state = self._state
        double = _Double(state.double, state.double_springs, state.stiffness)
        return resisted(double, state.unknowns, displacement).astype(np.float64)
