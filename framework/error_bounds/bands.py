"""Inverses of the stiffness of a batch of medium-sized frames: a banded factor for each entry."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..solvers.evaluation import Picked
from ..solvers.stacked_bands import Bands, StackedFactor
from ..structure.topology import Index
from .compliance import rounding_of
from .equilibrium import EquilibriumResidual
from .kinematic_edge import extended
from .pushing import in_double
from .resistance import resisted
from .sparse_compliance import EstimatedCompliance

# Steps of inverse iteration for the least eigenvalue, and number of random start vectors.
_TO_THE_LEAST, _RANDOM = 8, 2


class BandedCompliance(EstimatedCompliance):
    """Matrices of one pattern, each with its factor; least eigenvalues estimated by inverse iteration, with a margin.

    Parameters
    ----------
    bands
        The pattern of the unknowns of the state.
    place
        Place of each unknown in the order of the bands, (n,).
    numbers
        Number of the matrix at each entry of the state, of length one along batch axes over which it does not vary.
    picked
        Entries with these matrices, in the order of `numbers`.
    state
        A solution; the energy of the motions found by inverse iteration is evaluated with its frame.
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
        self._estimated(np.minimum(1.0 / self._growth, np.abs(resistance)), state)

    def _softest(self) -> tuple[Array, Array]:
        """Eigenvectors of the least eigenvalues of the scaled matrices, (..., n), and the inverses of these, (...)."""
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
        # the axes over which the matrices vary come first; all others are right-hand sides of each matrix
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
        return resisted(in_double(state), state.unknowns, displacement).astype(np.float64)
