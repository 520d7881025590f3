"""Worst case of clearances and tolerances at every pose: reachable regions, largest displacement, contributors."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape
from ....framework.errors import FrameError
from ..derivatives.position_sensitivity import PositionSensitivity, position_sensitivity, with_redundant_rows
from ..description.parts import unit_vector
from ..poses.classified import ClassifiedPoses
from .contributors import Contributors
from .finite import FiniteWorstCase, finite
from .limits import Given, Limit, limits
from .region import ReachableRegion

# Gap in a redundant constraint, as a share of the largest displacement by a deviation, above which it counts as open.
OPENED = 1e-10


@dataclass(frozen=True, eq=False, repr=False)
class WorstCase:
    """Largest displacements of a point and rotations of its link; made by `Motion.worst_case`.

    Results are exact to first order in clearances and tolerances. At dead points, which have no derivatives, they are
    NaN.

    Attributes
    ----------
    sensitivity
        Derivatives of the point's position, with its name, link and motion.
    limits
        Limits of the deviations.
    """

    sensitivity: PositionSensitivity
    limits: tuple[Limit, ...]

    def __repr__(self) -> str:
        of = f"{self.sensitivity.point} on {self.sensitivity.link}"
        greatest = self.greatest
        if not np.isfinite(greatest).any():
            return f"<WorstCase of {of}, shape {self.shape}: no pose is regular>"
        where = ", ".join(str(int(k)) for k in np.unravel_index(np.nanargmax(greatest), greatest.shape))
        at = f" at pose {where}" if greatest.ndim else ""
        head = f"<WorstCase of {of}, shape {self.shape}: {np.nanmax(greatest):.4g}{at}>"
        return f"{head}\n{self.contributors()}"

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.position.shape

    @cached_property
    def position(self) -> ReachableRegion:
        """Region of possible displacements of the point from its nominal position, lengths."""
        return self._region(slice(0, 3))

    @cached_property
    def rotation(self) -> ReachableRegion:
        """Region of possible rotation vectors of its link, radians; those of a planar linkage are along its normal.

        It is NaN if the link can spin with locked drives, as a rod between two spherical joints can.
        """
        return self._region(slice(3, 6))

    def _region(self, rows: slice) -> ReachableRegion:
        shape = self.sensitivity.motion.shape
        chosen = [*range(6)[rows], *range(6, self.limits[0].by.shape[-2])]
        parts = [each.by[..., chosen, :] * each.radius[..., None, None] for each in self.limits]
        middles = [each.by[..., rows, 0] * each.middle[..., None] for each in self.limits if each.middle.any()]
        shape = np.broadcast_shapes(shape, *(part.shape[:-2] for part in parts), *(m.shape[:-1] for m in middles))
        columns = np.concatenate([np.broadcast_to(part, (*shape, *part.shape[-2:])) for part in parts], axis=-1)
        centre = np.broadcast_to(np.sum(np.broadcast_arrays(np.zeros((*shape, 3)), *middles), axis=0), (*shape, 3))
        sizes = tuple(part.shape[-1] for part in parts)
        stress = columns[..., 3:, :]
        # redundant constraints that no deviation opens, as those out of the plane of a planar linkage, do not matter
        moved = np.abs(columns).max(axis=(-2, -1), initial=0.0)
        opened = np.abs(stress) > OPENED * moved[..., None, None]
        kept = np.where(opened, stress, 0.0) if opened.any() else None
        if kept is not None:
            self._check_middles(moved)
        return ReachableRegion(centre, columns[..., :3, :], sizes, tuple(each.name for each in self.limits), kept)

    def _check_middles(self, moved: Array) -> None:
        """Refuse intervals whose middles together open a redundant constraint: the region has no centre there.

        Parameters
        ----------
        moved
            Largest effect of a deviation at each pose, (...).
        """
        aside = [each for each in self.limits if each.middle.any()]
        open_by = [each.by[..., 6:, 0] * each.middle[..., None] for each in aside]
        if np.any(np.abs(np.sum(np.broadcast_arrays(0.0, *open_by), axis=0)) > OPENED * moved[..., None]):
            raise FrameError(
                f"the tolerances of {', '.join(each.name for each in aside)} are not symmetric, and with all of them "
                "at their middles the overconstrained loops do not close: give tolerances whose middles fit each other"
            )

    @property
    def greatest(self) -> Array:
        """Largest displacement, length, (...)."""
        return self.position.greatest

    @property
    def direction(self) -> Array:
        """Unit vector of the largest displacement, (..., 3)."""
        return self.position.direction

    @property
    def angle(self) -> Array:
        """Largest rotation of the link, radians, (...)."""
        return self.rotation.greatest

    @property
    def area(self) -> Array:
        """Area of the region that a point of a planar linkage can reach, (...); see `ReachableRegion.area`."""
        return self.position.area

    @property
    def volume(self) -> Array:
        """Volume of the region that a point in space can reach, (...); see `ReachableRegion.volume`."""
        return self.position.volume

    def support(self, direction: ArrayLike) -> Array:
        """How far the point can be displaced in a direction; see `ReachableRegion.support`.

        Parameters
        ----------
        direction
            Directions, (..., 2 or 3), that broadcast with the batch.

        Returns
        -------
        ndarray
            Length, (...).
        """
        return self.position.support(direction)

    def boundary(self, count: int = 180) -> Array:
        """Outermost positions all around the reachable region; see `ReachableRegion.boundary`.

        Parameters
        ----------
        count
            Number of directions.

        Returns
        -------
        ndarray
            Global coordinates, (..., m, 3).
        """
        motion, point, link = self.sensitivity.motion, self.sensitivity.point, self.sensitivity.link
        return np.asarray(motion.position(point, link)[..., None, :] + self.position.boundary(count))

    def deviations(self, direction: ArrayLike) -> tuple[Array, ...]:
        """The deviations at which the point is outermost in a direction.

        Parameters
        ----------
        direction
            As for `support`.

        Returns
        -------
        tuple of ndarray
            For each of `limits` the deviation, (..., m); that of a clearance is along the joint's clearance directions,
            such as ``ux uy``.
        """
        shares = self.position.deviations(direction)
        ends = np.cumsum(self.position.sizes)
        return tuple(
            shares[..., end - size : end] * each.radius[..., None] + each.middle[..., None]
            for each, size, end in zip(self.limits, self.position.sizes, ends, strict=True)
        )

    def contributors(self, direction: ArrayLike | None = None) -> Contributors:
        """Rank the contributors by their shares in the worst case and in the variance, at every pose.

        Parameters
        ----------
        direction
            Direction of the displacement, (..., 2 or 3); that of the largest at each pose if None.

        Returns
        -------
        Contributors
            The contributors, shown as a table that is ranked by the worst case.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
        >>> linkage.move().worst_case("B", drives={"A": 2e-4}).contributors((0, 1))  # doctest: +NORMALIZE_WHITESPACE
        contributor   worst case            %   variance %
        drive A           0.0004         80.0         95.5
        joint A           0.0001         20.0          4.5
        """
        n = np.nan_to_num(self.direction, nan=1.0) if direction is None else unit_vector(direction, "direction")
        where = np.isfinite(self.greatest)[..., None]
        region = self.position
        reach = region.contributions(n)
        for limit in self.limits:
            if limit.middle.any():  # the middle of an asymmetric interval adds to the reach
                along = np.sum(limit.by[..., :3, 0] * n, axis=-1) * limit.middle
                own = [name == limit.name for name in region.contributors]
                reach = reach + along[..., None] * np.array(own, dtype=np.float64)
        each = np.where(where, reach, np.nan)
        return Contributors(region.contributors, each, np.where(where, region.variances(n), np.nan))

    def finite(self, direction: ArrayLike | None = None) -> FiniteWorstCase:
        """How far the point goes with finite rotations under a force, with clearances as the only deviations.

        A force in the direction pulls the point of the rigid linkage until every joint is in contact. That is the
        largest displacement in the direction of the force near the nominal pose.

        Parameters
        ----------
        direction
            Directions, (..., 2 or 3), that broadcast with the batch; that of the largest displacement if None.

        Returns
        -------
        FiniteWorstCase
            Displacement, and its difference from the worst case to first order.

        Raises
        ------
        FrameError
            If there are limits other than clearances without a bearing length.

        Examples
        --------
        A driven arm does not rotate, so that its end is displaced by the clearance of its pin.

        >>> from linkframe.models import Linkage
        >>> arm = Linkage(A=(0, 0), B=(1, 0))
        >>> arm.link("arm", "A", "B")
        >>> arm.revolute("A", "ground", "arm", drive=True, clearance=0.1)
        >>> round(float(arm.move().worst_case("B").finite((0.6, 0.8)).reach), 9)
        0.1
        """
        others = [each.name for each in self.limits if not each.joint]
        if others:
            raise FrameError(
                f"finite() is for clearances alone, and {others[0]} is none that contact can take up: leave it out"
            )
        n = np.broadcast_to(
            self.direction if direction is None else unit_vector(direction, "direction"), (*self.shape, 3)
        )
        clearances = {each.joint: each.radius for each in self.limits}
        return finite(self.sensitivity, clearances, n, self.position.extreme(np.nan_to_num(n, nan=1.0)))

    def envelope(self, count: int = 2) -> Array:
        """Outermost positions perpendicular to the path of the point: the band, or in space the tube, it stays in.

        To first order the envelope of all regions touches each at its outermost point perpendicular to the path.

        Parameters
        ----------
        count
            Number of directions around the path; two are in the plane of a planar linkage.

        Returns
        -------
        ndarray
            Global coordinates, (..., count, 3); NaN where the point is at rest.

        Raises
        ------
        FrameError
            If several drives could move the point and none has a rate: give ``move(..., rates=)``.
        """
        tangent = unit_or_nan(self._path())
        region = self.position
        plane = region if region.dimension == 2 else region.with_segments(tangent)
        if plane.dimension > 2:
            seed = np.eye(3)[np.argmin(np.abs(np.nan_to_num(tangent)), axis=-1)]
            first = unit_or_nan(np.cross(tangent, seed))
        else:
            first = unit_or_nan(np.cross(plane.normal, tangent))
        angles = 2.0 * np.pi * np.arange(count)[:, None] / count
        n = np.cos(angles) * first[..., None, :] + np.sin(angles) * np.cross(tangent, first)[..., None, :]
        motion, point, link = self.sensitivity.motion, self.sensitivity.point, self.sensitivity.link
        return np.asarray(motion.position(point, link)[..., None, :] + region.around(n))

    def _path(self) -> Array:
        """A vector tangent to the path of the point, (..., 3)."""
        motion, drives = self.sensitivity.motion, self.sensitivity.drives
        if any(np.any(rate) for rate in motion.drives.rates):
            return motion.velocity(self.sensitivity.point, self.sensitivity.link)
        columns = [column for each in drives.values() for column in np.moveaxis(each[..., :3, :], -1, 0)]
        if len(columns) != 1:
            raise FrameError(f"the linkage has {len(columns)} drives and none has a rate: give move(..., rates=)")
        return np.asarray(columns[0])


def unit_or_nan(vectors: Array) -> Array:
    """Unit vectors (..., 3); NaN for those of length zero."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.asarray(vectors / np.where(length > 0.0, length, np.nan))


def worst_case(motion: ClassifiedPoses, point: str, link: str | None, given: Given) -> WorstCase:
    """Worst case of a point under clearances and tolerances; see `Motion.worst_case`."""
    by = position_sensitivity(motion, point, link)
    return worst_case_by(by, with_redundant_rows(by), given)


def worst_case_by(by: PositionSensitivity, rows: PositionSensitivity, given: Given) -> WorstCase:
    """Worst case of a point from its derivatives, without (`by`) and with (`rows`) those of redundant constraints."""
    found = tuple(limits(rows, given))
    if not found:
        raise FrameError(
            "worst_case was given nothing that deviates: give the joints a clearance, or limits by "
            "clearances=, lengths=, places= or drives="
        )
    return WorstCase(by, found)
