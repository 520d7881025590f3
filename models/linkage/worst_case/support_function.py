"""The support function of sums of segments, ellipses and ellipsoids, and the contribution of each."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape
from ..description.parts import unit_vector
from .redundant import least_lengths


@dataclass(frozen=True, eq=False, repr=False)
class SupportFunction:
    """Support function of a sum of segments, ellipses and ellipsoids; see `ReachableRegion`.

    Attributes
    ----------
    centre, columns, sizes, names, stress
        See `ReachableRegion`.
    """

    centre: Array
    columns: Array
    sizes: tuple[int, ...]
    names: tuple[str, ...]
    stress: Array | None = None

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.columns.shape[:-2]

    @property
    def contributors(self) -> tuple[str, ...]:
        """Names of the contributors, each once, in their order."""
        return tuple(dict.fromkeys(self.names))

    # -- by direction -----------------------------------------------------------------------------------------------

    def support(self, direction: ArrayLike) -> Array:
        """How far the region reaches in a direction, from the nominal pose.

        Parameters
        ----------
        direction
            Directions, (..., 2 or 3), of any length, that broadcast with the batch.

        Returns
        -------
        ndarray
            Length, or radians of a rotation, (...).
        """
        n = unit_vector(direction, "direction")
        return np.asarray(np.sum(n * self.centre, axis=-1) + np.sum(self._reach(n), axis=-1))

    def extreme(self, direction: ArrayLike) -> Array:
        """The outermost point in a direction; the middle of an edge or face that is outermost.

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            Displacement from the nominal pose, or rotation vector, (..., 3).
        """
        return self._extreme(unit_vector(direction, "direction"))

    def around(self, directions: Array) -> Array:
        """Outermost points in several directions at each pose.

        Parameters
        ----------
        directions
            Unit vectors, (..., m, 3).

        Returns
        -------
        ndarray
            Displacements from the nominal pose, (..., m, 3).
        """
        return self._spread._extreme(directions)

    def deviations(self, direction: ArrayLike) -> Array:
        """The deviations at the outermost point in a direction, as shares of their limits.

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            One for each of the `columns`, (..., n): a unit vector for each contribution, or zeros if it has no effect
            in this direction.
        """
        along, lengths = self._balanced(unit_vector(direction, "direction"))
        length = np.repeat(lengths, self.sizes, axis=-1)
        return np.asarray(np.where(length > 0.0, along / np.where(length > 0.0, length, 1.0), 0.0))

    def contributions(self, direction: ArrayLike) -> Array:
        """How far each contributor lets the region reach in a direction.

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            One for each of `contributors`, (..., k); their sum is the support about the centre.
        """
        return self._by_name(self._reach(unit_vector(direction, "direction")))

    def variances(self, direction: ArrayLike) -> Array:
        """Variance by each contributor in a direction, for a uniform distribution over its interval, disc or ball.

        The variance of a component of a vector distributed uniformly over a ball of radius r in d dimensions is
        ``r^2 / (d + 2)``: 1/3 for an interval, 1/4 for a disc, 1/5 for a ball (Muller, *A note on a method for
        generating points uniformly on n-dimensional spheres*, 1959, has such points).

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            One for each of `contributors`, (..., k), whose deviations are independent.
        """
        return self._by_name(self._reach(unit_vector(direction, "direction")) ** 2 / (np.array(self.sizes) + 2.0))

    @cached_property
    def half_widths(self) -> Array:
        """Half of the extent along x, y and z, (..., 3)."""
        whole = self._spread
        return np.asarray(np.sum(whole._reach(np.eye(3)), axis=-1))

    # -- sums -------------------------------------------------------------------------------------------------------

    def _along(self, n: Array) -> Array:
        """``J_b^T n`` of all contributors one after the other, (..., n)."""
        return np.asarray((n[..., None, :] @ self.columns)[..., 0, :])

    def _lengths(self, along: Array) -> Array:
        """Length of the part of each contribution, (..., contributions), in vectors (..., n)."""
        if not self.sizes:
            return np.zeros((*along.shape[:-1], 0))
        return np.asarray(np.sqrt(np.add.reduceat(along * along, self._starts, axis=-1)))

    def _reach(self, n: Array) -> Array:
        return self._lengths(self._balanced(n)[0])

    def _balanced(self, n: Array) -> tuple[Array, Array]:
        """``J_b^T n``, with multipliers for the redundant constraints, (..., n), and its lengths, (..., contributions).

        With redundant constraints the lengths are smoothed, so that they are never zero.
        """
        along = self._along(n)
        if self.stress is None:
            return along, self._lengths(along)
        good = np.isfinite(along).all(axis=-1, keepdims=True)
        found, lengths = least_lengths(np.where(good, along, 0.0), self.stress, self._starts, self.sizes)
        return np.where(good, found, np.nan), np.where(good, lengths, np.nan)

    def _extreme(self, n: Array, without: slice | None = None) -> Array:
        along, lengths = self._balanced(n)
        if without is not None:
            along, lengths = along.copy(), lengths.copy()
            along[..., without] = 0.0
        length = np.repeat(lengths, self.sizes, axis=-1)
        # a direction perpendicular to an edge, but for rounding, counts as perpendicular
        least = 1e-14 * np.repeat(self._lengths(self._norms), self.sizes, axis=-1)
        here = np.where(length > least, along / np.where(length > least, length, 1.0), 0.0)
        return np.asarray(self.centre + (self.columns @ here[..., None])[..., 0])

    @cached_property
    def _norms(self) -> Array:
        return np.asarray(np.linalg.norm(self.columns, axis=-2))

    def _by_name(self, values: Array) -> Array:
        names = self.contributors
        which = np.array([[name == own for name in names] for own in self.names], dtype=np.float64)
        return np.asarray(values @ which.reshape(len(self.names), len(names)))

    @property
    def _starts(self) -> list[int]:
        """Index of the first column of each contribution."""
        return [0, *accumulate(self.sizes)][:-1]

    @property
    def _spread(self) -> Self:
        """The same region with a further batch axis, for several directions at each pose."""
        stress = None if self.stress is None else self.stress[..., None, :, :]
        return replace(self, centre=self.centre[..., None, :], columns=self.columns[..., None, :, :], stress=stress)
