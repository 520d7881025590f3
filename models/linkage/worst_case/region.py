"""The region that sums of segments, discs and balls fill: boundary, area, volume, farthest point."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ....framework.batch import Array, Shape
from ....framework.errors import FrameError
from .mixed_area import area_of_sum, area_within, volume_of_sum, volume_within
from .redundant import LEAST, kept_closed
from .starts import circle, sphere
from .support_function import SupportFunction

# What is thinner than this share of the largest extent is flat.
FLAT = 1e-9
# Entries of the batch whose farthest points are sought together.
TOGETHER = 256
# Directions in which the farthest point is sought, the best of them that are followed, and for how many steps.
BEST, STEPS = 4, 200
# The search ends where a step takes it farther by less than this share.
GROWTH = 1e-14
# Directions whose outermost points tell a volume, and an area, that is no sum.
IN_HULL, IN_POLYGON = 400, 360


@dataclass(frozen=True, eq=False, repr=False)
class ReachableRegion(SupportFunction):
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

    def __repr__(self) -> str:
        return f"<ReachableRegion of {', '.join(self.contributors)}, shape {self.shape}>"

    # -- the farthest point -----------------------------------------------------------------------------------------

    @property
    def greatest(self) -> Array:
        """Distance of the farthest point from the nominal pose, (...); to some 2e-4 where constraints are redundant."""
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
        if self.stress is not None:
            # How far it reaches in a direction is known better than the point that lies there.
            n = found / np.where(length > 0.0, length, 1.0)[..., None]
            length = np.maximum(length, np.sum(n * self.centre, axis=-1) + np.sum(self._reach(n), axis=-1))
            found = length[..., None] * n
        chosen = np.argmax(length, axis=-1)
        return np.asarray(np.take_along_axis(found, chosen[:, None, None], axis=1)[:, 0])

    def with_segments(self, along: Array) -> ReachableRegion:
        """The region with a segment added at each pose, as long as the region is wide.

        Parameters
        ----------
        along
            Unit vectors of the segments, (..., 3).

        Returns
        -------
        ReachableRegion
            What lies in a plane with the region and the segments has a `normal`.
        """
        column = self._extents[0] * np.broadcast_to(along, (*self.shape, 3))[..., None]
        columns = np.concatenate([self.columns, column], axis=-1)
        none = None if self.stress is None else np.zeros((*self.stress.shape[:-1], 1))
        stress = None if none is None or self.stress is None else np.concatenate([self.stress, none], axis=-1)
        return ReachableRegion(self.centre, columns, (*self.sizes, 1), (*self.names, "segment"), stress)

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
        """Area of the region in its plane, (...); to some four digits where constraints are redundant.

        The area of a sum is the sum of the mixed areas of all pairs; that of two ellipses ``A`` and ``B``, images of
        the unit disc, is half the perimeter of the ellipse ``adj(A) B``, an elliptic integral (Schneider 2014, 5.1).

        Raises
        ------
        FrameError
            If the region lies in no plane.
        """
        if self.dimension > 2:
            raise FrameError("the region extends in all three directions: it has a volume, and no area")
        if self.stress is not None:
            around = circle(IN_POLYGON) @ self._basis[:2]
            return self._one_by_one(lambda part: area_within(part._extreme(around) @ self._basis[:2].T), (), TOGETHER)
        return area_of_sum(self._basis[:2] @ self.columns, self.sizes)

    @cached_property
    def volume(self) -> Array:
        """Volume, (...), 0 where the region lies in a plane.

        To within a per cent, mostly to some four digits; to some two where constraints are redundant.
        """
        if self.dimension < 3:
            return np.where(np.isfinite(self.columns).all(axis=(-1, -2)), 0.0, np.nan)
        if self.stress is not None:
            return self._one_by_one(lambda part: volume_within(part._extreme(sphere(IN_HULL))), ())
        return self._one_by_one(lambda part: volume_of_sum(part.columns[:, 0], self.sizes), (), TOGETHER // 16)

    def boundary(self, count: int = 180) -> Array:
        """Outermost points all around, in their order where the region lies in a plane.

        In the plane the ends of straight edges, which intervals and joints of rank 1 make, are among them, unless
        redundant constraints bind them. In space what lies between the points falls short of the support by up to
        7 % where the region is smooth, at 180 directions, and by up to some 10 % where it has straight edges, however
        thin it is.

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
            # where the region is thin, as closely as if it were stretched to be as wide as it is long
            n = (sphere(count) / self._extents) @ self._basis
            return whole._extreme(n / np.linalg.norm(n, axis=-1, keepdims=True))
        n = circle(count) @ self._basis[:2]
        return in_order(
            np.concatenate([whole._extreme(n), *self._edge_ends(whole)], axis=-2), self._basis[:2], self.centre
        )

    def _edge_ends(self, whole: ReachableRegion) -> Iterator[Array]:
        """Ends of the edges (..., 2, 3) of each contributor of rank one, on either side."""
        if self.stress is not None:
            return
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

    @cached_property
    def _flat_basis(self) -> tuple[Array, Array]:
        whole = self.columns if self.stress is None else kept_closed(self.columns, self.stress)
        columns = np.moveaxis(whole, -2, 0).reshape(3, -1)
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
