"""Regions that are sums of segments, ellipses and ellipsoids: boundary, area, volume and farthest point."""

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

# Ratio to the largest extent below which a region is flat.
FLAT = 1e-9
# Number of entries of the batch that are treated together.
TOGETHER = 256
# Number of directions from which the search for the farthest point continues, and of its steps.
BEST, STEPS = 4, 200
# Relative growth in a step at which the search ends.
GROWTH = 1e-14
# Number of directions whose outermost points give the volume and the area with redundant constraints.
IN_HULL, IN_POLYGON = 400, 360


@dataclass(frozen=True, eq=False, repr=False)
class ReachableRegion(SupportFunction):
    """All possible displacements of a point, or rotations of its link, from the nominal pose.

    The region is the Minkowski sum of the contributions: segments, ellipses and ellipsoids, the images of intervals,
    discs and balls under the derivatives ``J_b``. It is symmetric about its centre. Its support function, the distance
    of its outermost point in a direction n, is a sum too, ``h(n) = c . n + sum |J_b^T n|`` (Schneider, *Convex Bodies:
    The Brunn-Minkowski Theory*, 2014, sections 1.7 and 3.5).

    Attributes
    ----------
    centre
        Centre c, (..., 3); zero if all limits are symmetric.
    columns
        All ``J_b``, each times its radius or half width, one after the other, (..., 3, n).
    sizes
        Number of columns of each contribution: 1 for an interval, 2 for a disc, 3 for a ball.
    names
        Name of the contributor of each; several contributions of one name count as one contributor.
    stress
        Gaps in the redundant constraints of overconstrained loops by the deviations, (..., s, n):
        ``stress @ deviations`` has to be zero; None if there are no such constraints.

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
        """Distance of the farthest point from the nominal pose, (...); to some 2e-4 with redundant constraints."""
        return np.asarray(np.linalg.norm(self.farthest, axis=-1))

    @property
    def direction(self) -> Array:
        """Unit vector to the farthest point, (..., 3); if the centre is zero the opposite point is equally far."""
        length = self.greatest[..., None]
        found = np.where(length > 0.0, self.farthest / np.where(length > 0.0, length, 1.0), self._basis[0])
        return np.where(np.isnan(length), np.nan, found)

    @cached_property
    def farthest(self) -> Array:
        """The farthest point from the nominal pose, (..., 3).

        The search starts in directions all around. The vector to the outermost point in a direction is the next
        direction, by which the distance never decreases: the power method for a convex function on the sphere (Journee,
        Nesterov, Richtarik & Sepulchre, Journal of Machine Learning Research 11, 2010).
        """
        return self._one_by_one(lambda part: part._farthest(self._around), (3,))

    def _one_by_one(self, ask: Callable[[ReachableRegion], Array], trailing: Shape, most: int = TOGETHER) -> Array:
        """Result of `ask` for all entries of the batch, called with regions of shape (m, 1), m being `most` or less."""
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
        """Farthest points (m, 3) of regions of shape (m, 1), searched from directions (d, 3)."""
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
            # the support in a direction is known more accurately than the outermost point
            n = found / np.where(length > 0.0, length, 1.0)[..., None]
            length = np.maximum(length, np.sum(n * self.centre, axis=-1) + np.sum(self._reach(n), axis=-1))
            found = length[..., None] * n
        chosen = np.argmax(length, axis=-1)
        return np.asarray(np.take_along_axis(found, chosen[:, None, None], axis=1)[:, 0])

    def with_segments(self, along: Array) -> ReachableRegion:
        """The region plus a segment at each pose, of the size of the largest contribution to the region.

        Parameters
        ----------
        along
            Unit vectors of the segments, (..., 3).

        Returns
        -------
        ReachableRegion
            It has a `normal` if the region and all segments lie in one plane.
        """
        column = self._extents[0] * np.broadcast_to(along, (*self.shape, 3))[..., None]
        columns = np.concatenate([self.columns, column], axis=-1)
        none = None if self.stress is None else np.zeros((*self.stress.shape[:-1], 1))
        stress = None if none is None or self.stress is None else np.concatenate([self.stress, none], axis=-1)
        return ReachableRegion(self.centre, columns, (*self.sizes, 1), (*self.names, "segment"), stress)

    # -- its size ---------------------------------------------------------------------------------------------------

    @cached_property
    def dimension(self) -> int:
        """Dimension of the region over all poses: 2 if it lies in a plane, 3 if it extends in space."""
        return int(np.count_nonzero(self._extents > FLAT * self._extents[0]))

    @property
    def normal(self) -> Array:
        """Normal of the plane in which the region lies at all poses, (3,).

        Raises
        ------
        FrameError
            If the region does not lie in a plane.
        """
        if self.dimension > 2:
            raise FrameError("the region extends in all three directions: it lies in no plane")
        return np.asarray(self._basis[2])

    @cached_property
    def area(self) -> Array:
        """Area of the region in its plane, (...); to some four digits with redundant constraints.

        The area of a sum is the sum of the mixed areas of all pairs. The mixed area of two ellipses ``A`` and ``B``,
        images of the unit disc, is half the perimeter of the ellipse ``adj(A) B``, an elliptic integral (Schneider
        2014, 5.1).

        Raises
        ------
        FrameError
            If the region does not lie in a plane.
        """
        if self.dimension > 2:
            raise FrameError("the region extends in all three directions: it has a volume, and no area")
        if self.stress is not None:
            around = circle(IN_POLYGON) @ self._basis[:2]
            return self._one_by_one(lambda part: area_within(part._extreme(around) @ self._basis[:2].T), (), TOGETHER)
        return area_of_sum(self._basis[:2] @ self.columns, self.sizes)

    @cached_property
    def volume(self) -> Array:
        """Volume, (...); 0 if the region lies in a plane.

        It is accurate to one per cent, mostly to some four digits; with redundant constraints to some two digits.
        """
        if self.dimension < 3:
            return np.where(np.isfinite(self.columns).all(axis=(-1, -2)), 0.0, np.nan)
        if self.stress is not None:
            return self._one_by_one(lambda part: volume_within(part._extreme(sphere(IN_HULL))), ())
        return self._one_by_one(lambda part: volume_of_sum(part.columns[:, 0], self.sizes), (), TOGETHER // 16)

    def boundary(self, count: int = 180) -> Array:
        """Outermost points in directions all around, in their order along the boundary if the region lies in a plane.

        In the plane they include the ends of straight edges, which come from contributions that are segments, unless
        there are redundant constraints. In space, the convex hull of the points for 180 directions falls short of the
        support by up to 7 % if the region is smooth, and by up to some 10 % if it has straight edges, however thin it
        is.

        Parameters
        ----------
        count
            Number of directions, at least 4.

        Returns
        -------
        ndarray
            Displacements from the nominal pose, (..., m, 3); m is `count` in space, and in the plane `count` plus 4 for
            each contribution that is a segment.
        """
        whole = self._spread
        if self.dimension > 2:
            # directions for the region scaled to equal extents, so that thin regions are resolved as well
            n = (sphere(count) / self._extents) @ self._basis
            return whole._extreme(n / np.linalg.norm(n, axis=-1, keepdims=True))
        n = circle(count) @ self._basis[:2]
        return in_order(
            np.concatenate([whole._extreme(n), *self._edge_ends(whole)], axis=-2), self._basis[:2], self.centre
        )

    def _edge_ends(self, whole: ReachableRegion) -> Iterator[Array]:
        """Ends of both straight edges of each contribution that is a segment, (..., 2, 3) each."""
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
        # extents from the columns, as the eigenvalues are their squares, with half the digits
        extents = np.abs(basis @ finite).max(axis=1, initial=0.0)
        return extents, _upright(basis, extents)

    @property
    def _extents(self) -> Array:
        return self._flat_basis[0]

    @property
    def _basis(self) -> Array:
        """Principal axes, one a row, (3, 3); the last is the normal of a region that lies in a plane."""
        return self._flat_basis[1]

    @cached_property
    def _around(self) -> Array:
        if self.dimension > 2:
            return np.concatenate([sphere(256 if self.stress is None else 48), np.eye(3), -np.eye(3)])
        # a region symmetric about the nominal pose is equally far on both sides
        return circle(128)[: 128 if self.centre.any() else 64] @ self._basis[:2]


def in_order(points: Array, axes: Array, centre: Array) -> Array:
    """Points (..., m, 3) in the plane of `axes` (2, 3), sorted by their angle around a centre (..., 3)."""
    flat = (points - centre[..., None, :]) @ axes.T
    order = np.argsort(np.arctan2(flat[..., 1], flat[..., 0]), axis=-1, kind="stable")
    return np.take_along_axis(points, order[..., None], axis=-2)


def _upright(basis: Array, extents: Array) -> Array:
    """Right-handed axes for a region; those of the global frame if the region lies in the plane of x and y."""
    if np.count_nonzero(extents > FLAT * extents[0]) == 2 and abs(basis[2, 2]) > 1.0 - FLAT:
        return np.eye(3)
    return np.asarray(np.stack([basis[0], basis[1], np.cross(basis[0], basis[1])]))
