"""The region that sums of segments, discs and balls fill: support function, boundary, area, volume, farthest point."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape, vector
from ....framework.errors import FrameError
from .mixed_area import area_of_sum, volume_of_sum, volume_within
from .redundant import LEAST, least_lengths
from .starts import circle, sphere

# What is thinner than this share of the largest extent is flat.
FLAT = 1e-9
# Entries of the batch whose farthest points are sought together.
TOGETHER = 256
# Directions in which the farthest point is sought, the best of them that are followed, and for how many steps.
BEST, STEPS = 4, 200
# The search ends where a step takes it farther by less than this share.
GROWTH = 1e-14
# Directions whose outermost points tell a volume that is no sum.
IN_HULL = 400


@dataclass(frozen=True, eq=False, repr=False)
class ReachableRegion:
    """Where a point can be, or how its link can be turned, relative to the nominal pose; symmetric about its centre.

    It is the sum of what each contributor lets happen by itself: a segment, an ellipse or an ellipsoid, the image of an
    interval, a disc or a ball under the derivatives ``J_b``. Its support function, the distance of its outermost
    point in a direction n, is a sum as well, ``h(n) = c . n + sum |J_b^T n|`` (Schneider, *Convex Bodies: The
    Brunn-Minkowski Theory*, 2014, sections 1.7 and 3.5).

    Attributes
    ----------
    centre
        Its centre, (..., 3); zero where all limits are symmetric.
    columns
        All ``J_b``, each times its radius or half width, one after the other, (..., 3, n).
    sizes
        Number of columns of each contributor: 1 for an interval, 2 for a disc, 3 for a ball.
    names
        Names of the contributors; those of one name count as one.
    stress
        What the deviations must not do, (..., s, n): they open redundant constraints of overconstrained loops by
        ``stress @ deviations``, which has to be zero; None where there are none.

    Examples
    --------
    A disc of radius 1 and an interval of half width 2 along x, which fill a stadium.

    >>> import numpy as np
    >>> from linkframe.models import ReachableRegion
    >>> stadium = ReachableRegion(np.zeros(3), np.array([[1.0, 0, 2], [0, 1, 0], [0, 0, 0]]), (2, 1), ("disc", "slot"))
    >>> float(stadium.greatest), bool(np.isclose(stadium.area, np.pi + 8.0, rtol=1e-14))
    (3.0, True)
    """

    centre: Array
    columns: Array
    sizes: tuple[int, ...]
    names: tuple[str, ...]
    stress: Array | None = None

    def __repr__(self) -> str:
        return f"<ReachableRegion of {', '.join(self.contributors)}, shape {self.shape}>"

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.columns.shape[:-2]

    @property
    def contributors(self) -> tuple[str, ...]:
        """Different names, in their order."""
        return tuple(dict.fromkeys(self.names))

    # -- by direction -----------------------------------------------------------------------------------------------

    def support(self, direction: ArrayLike) -> Array:
        """How far the region reaches in a direction, from the nominal pose.

        Parameters
        ----------
        direction
            Directions, (..., 2 or 3), that broadcast with the batch; their length does not count.

        Returns
        -------
        ndarray
            Length, or radians of a rotation, (...).
        """
        n = unit(direction)
        return np.asarray(np.sum(n * self.centre, axis=-1) + np.sum(self._reach(n), axis=-1))

    def extreme(self, direction: ArrayLike) -> Array:
        """The outermost point in a direction; where an edge or a face is outermost, its middle.

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            Displacement from the nominal pose, or rotation vector, (..., 3).
        """
        return self._extreme(unit(direction))

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
        """What each contributor does where the region is outermost, in shares of its limit.

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            One for each of the `columns`, (..., n): a vector of length one for each contributor, zero where it does not
            count.
        """
        along, lengths = self._balanced(unit(direction))
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
        return self._by_name(self._reach(unit(direction)))

    def variances(self, direction: ArrayLike) -> Array:
        """Variance that each contributor brings about in a direction, spread evenly over its interval, disc or ball.

        The variance of a component of a vector that is spread evenly over a ball of radius r in d dimensions is
        ``r^2 / (d + 2)``: 1/3 for an interval, 1/4 for a disc, 1/5 for a ball (Muller, *A note on a method for
        generating points uniformly on n-dimensional spheres*, 1959, has such points).

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        ndarray
            One for each of `contributors`, (..., k); all are independent.
        """
        return self._by_name(self._reach(unit(direction)) ** 2 / (np.array(self.sizes) + 2.0))

    @cached_property
    def half_widths(self) -> Array:
        """Half of the extent along x, y and z, (..., 3)."""
        whole = self._spread
        return np.asarray(np.sum(whole._reach(np.eye(3)), axis=-1))

    # -- the farthest point -----------------------------------------------------------------------------------------

    @property
    def greatest(self) -> Array:
        """Distance of the farthest point from the nominal pose, (...)."""
        return np.asarray(np.linalg.norm(self.farthest, axis=-1))

    @property
    def direction(self) -> Array:
        """Unit vector to the farthest point, (..., 3); where the centre is nominal its opposite is as far."""
        length = self.greatest[..., None]
        found = np.where(length > 0.0, self.farthest / np.where(length > 0.0, length, 1.0), self._basis[0])
        return np.where(np.isnan(length), np.nan, found)

    @cached_property
    def farthest(self) -> Array:
        """The farthest point from the nominal pose, (..., 3).

        From directions all around, the way to the outermost point in each direction is taken as the next direction;
        the distance only grows. (On the sphere this is the power method for a convex function: Journee, Nesterov,
        Richtarik & Sepulchre, Journal of Machine Learning Research 11, 2010.)
        """
        return self._one_by_one(lambda part: part._farthest(self._around), (3,))

    def _one_by_one(self, ask: Callable[[ReachableRegion], Array], trailing: Shape, most: int = TOGETHER) -> Array:
        """What is asked of regions of shape (m, 1), of all entries of the batch, some thousand at a time."""
        columns = self.columns.reshape(-1, 1, *self.columns.shape[-2:])
        centre = np.broadcast_to(self.centre, (*self.shape, 3)).reshape(-1, 1, 3)
        stress = None if self.stress is None else self.stress.reshape(-1, 1, *self.stress.shape[-2:])
        out = np.full((len(columns), *trailing), np.nan)
        good = np.flatnonzero(np.isfinite(columns).all(axis=(1, 2, 3)))
        for first in range(0, len(good), most):
            own = good[first : first + most]
            out[own] = ask(
                replace(
                    self,
                    centre=centre[own],
                    columns=columns[own],
                    stress=None if stress is None else stress[own],
                )
            )
        return out.reshape((*self.shape, *trailing))

    def _farthest(self, around: Array) -> Array:
        """That of regions of shape (m, 1), from some directions (d, 3)."""
        found = self._extreme(around)
        best = np.argsort(-np.sum(found**2, axis=-1), axis=-1, kind="stable")[:, :BEST]
        found = np.take_along_axis(found, best[..., None], axis=1)
        length = np.linalg.norm(found, axis=-1)
        slowest = GROWTH if self.stress is None else LEAST
        for _ in range(STEPS):
            before, found = length, self._extreme(found / np.where(length > 0.0, length, 1.0)[..., None])
            length = np.linalg.norm(found, axis=-1)
            if np.all(length <= before * (1.0 + slowest)):
                break
        chosen = np.argmax(length, axis=-1)
        return np.asarray(np.take_along_axis(found, chosen[:, None, None], axis=1)[:, 0])

    # -- its size ---------------------------------------------------------------------------------------------------

    @cached_property
    def dimension(self) -> int:
        """Of the directions in which it extends at any pose: 2 for a region in a plane, 3 for one in space."""
        return int(np.count_nonzero(self._extents > FLAT * self._extents[0]))

    @property
    def normal(self) -> Array:
        """Normal of the plane in which it lies at all poses, (3,).

        Raises
        ------
        FrameError
            If it lies in none.
        """
        if self.dimension > 2:
            raise FrameError("the region extends in all three directions: it lies in no plane")
        return np.asarray(self._basis[2])

    @cached_property
    def area(self) -> Array:
        """Area of the region in its plane, (...).

        The area of a sum is the sum of the mixed areas of all pairs; that of two ellipses ``A`` and ``B``, images of
        the unit disc, is half the perimeter of the ellipse ``adj(A) B``, an elliptic integral (Schneider 2014, 5.1).

        Raises
        ------
        FrameError
            If the region lies in no plane.
        """
        if self.dimension > 2 or self.stress is not None:
            raise FrameError("the region extends in all three directions: it has a volume, and no area")
        return area_of_sum(self._basis[:2] @ self.columns, self.sizes)

    @cached_property
    def volume(self) -> Array:
        """Volume, (...), 0 where the region lies in a plane.

        To some four digits, or two where constraints are redundant.
        """
        if self.dimension < 3:
            return np.where(np.isfinite(self.columns).all(axis=(-1, -2)), 0.0, np.nan)
        if self.stress is not None:
            return self._one_by_one(lambda part: volume_within(part._extreme(sphere(IN_HULL))), ())
        return self._one_by_one(lambda part: volume_of_sum(part.columns[:, 0], self.sizes), (), TOGETHER // 16)

    def boundary(self, count: int = 180) -> Array:
        """Outermost points all around, in their order where the region lies in a plane.

        In the plane the ends of straight edges, which intervals and joints of rank 1 make, are among them.

        Parameters
        ----------
        count
            Number of directions, at least 4.

        Returns
        -------
        ndarray
            Displacements from the nominal pose, (..., m, 3), with m = count in space, and count and two for each edge
            in the plane.
        """
        whole = self._spread
        if self.dimension > 2:
            return whole._extreme(sphere(count))
        n = circle(count) @ self._basis[:2]
        return in_order(
            np.concatenate([whole._extreme(n), *self._edge_ends(whole)], axis=-2), self._basis[:2], self.centre
        )

    @property
    def _spread(self) -> ReachableRegion:
        """The same with a further axis, for directions at each pose."""
        stress = None if self.stress is None else self.stress[..., None, :, :]
        return replace(self, centre=self.centre[..., None, :], columns=self.columns[..., None, :, :], stress=stress)

    def _edge_ends(self, whole: ReachableRegion) -> Iterator[Array]:
        """Ends of the edges (..., 2, 3) of each contributor of rank one, on either side."""
        across = np.cross(self._basis[2], np.swapaxes(self.columns, -1, -2))
        ends = np.cumsum(self.sizes)
        for start, end in zip(self._starts, ends, strict=True):
            own = self.columns[..., start:end]
            u, s, _ = np.linalg.svd(np.where(np.isfinite(own), own, 0.0), full_matrices=False)
            straight = (s[..., 1:] <= FLAT * s[..., :1]).all(axis=-1)
            if not straight.any() or not np.any(across):
                continue
            edge = u[..., 0] * s[..., :1]
            normal = np.cross(self._basis[2], u[..., 0])
            for side in (1.0, -1.0):
                middle = whole._extreme(side * normal[..., None, :], without=slice(start, end))
                yield middle + np.array([[1.0], [-1.0]]) * edge[..., None, :]

    @property
    def _starts(self) -> list[int]:
        """Where the columns of each contributor begin."""
        return [0, *accumulate(self.sizes)][:-1]

    # -- sums -------------------------------------------------------------------------------------------------------

    def _along(self, n: Array) -> Array:
        """``J_b^T n`` of all contributors one after the other, (..., n)."""
        return np.asarray((n[..., None, :] @ self.columns)[..., 0, :])

    def _lengths(self, along: Array) -> Array:
        """Length of the part of each contributor, (..., contributors)."""
        if not self.sizes:
            return np.zeros((*along.shape[:-1], 0))
        return np.asarray(np.sqrt(np.add.reduceat(along * along, self._starts, axis=-1)))

    def _reach(self, n: Array) -> Array:
        return self._lengths(self._balanced(n)[0])

    def _balanced(self, n: Array) -> tuple[Array, Array]:
        """What each deviation works on, (..., n), with the forces in redundant constraints, and its lengths.

        These are rounded off where constraints are redundant, so that they are never zero.
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
        # A direction square to an edge, to rounding, is taken as square to it.
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

    @cached_property
    def _flat_basis(self) -> tuple[Array, Array]:
        columns = np.moveaxis(self.columns, -2, 0).reshape(3, -1)
        finite = columns[:, np.isfinite(columns).all(axis=0)]
        basis = np.linalg.eigh(finite @ finite.T)[1].T[::-1] if finite.size else np.eye(3)
        # The eigenvalues are squares: how thin it is tell the columns themselves.
        extents = np.abs(basis @ finite).max(axis=1, initial=0.0)
        return extents, _upright(basis, extents)

    @property
    def _extents(self) -> Array:
        return self._flat_basis[0]

    @property
    def _basis(self) -> Array:
        """Axes (3, 3), row by row, of which the last is the normal of a region that lies in a plane."""
        return self._flat_basis[1]

    @cached_property
    def _around(self) -> Array:
        if self.dimension > 2:
            return np.concatenate([sphere(256 if self.stress is None else 48), np.eye(3), -np.eye(3)])
        # What is symmetric about the nominal pose is as far on either side.
        return circle(128)[: 128 if self.centre.any() else 64] @ self._basis[:2]


def unit(direction: ArrayLike) -> Array:
    """Unit vectors (..., 3) of directions (..., 2 or 3)."""
    given = np.asarray(direction, dtype=np.float64)
    if given.shape[-1:] == (2,):
        given = np.concatenate([given, np.zeros((*given.shape[:-1], 1))], axis=-1)
    given = vector(given, "direction")
    length = np.linalg.norm(given, axis=-1, keepdims=True)
    if np.any(length == 0.0):
        raise FrameError("direction has length 0: give the direction in which to look")
    return np.asarray(given / length)


def in_order(points: Array, axes: Array, centre: Array) -> Array:
    """Points (..., m, 3) in a plane with these axes (2, 3), in their order around a centre (..., 3)."""
    flat = (points - centre[..., None, :]) @ axes.T
    order = np.argsort(np.arctan2(flat[..., 1], flat[..., 0]), axis=-1, kind="stable")
    return np.take_along_axis(points, order[..., None], axis=-2)


def _upright(basis: Array, extents: Array) -> Array:
    """Axes in whose plane a region lies, those of the global frame where that plane is one of its own."""
    if np.count_nonzero(extents > FLAT * extents[0]) == 2 and abs(basis[2, 2]) > 1.0 - FLAT:
        return np.eye(3)
    return np.asarray(np.stack([basis[0], basis[1], np.cross(basis[0], basis[1])]))
