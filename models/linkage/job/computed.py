"""Numbers of the job: motion, displacements of the points and their samples, reactions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.solution import Solution
from ...job.measured import MeasuredOutcome
from ...job.outcome import magnification
from ...job.parts import Parts
from ...spread import Spread
from ..graphics.plane import ROUNDING, plane
from ..motion import Motion
from ..statics.accuracy import PointAccuracy, marked_status
from ..statics.reactions import Reactions
from ..study.sampled import nominal_positions
from .inputs import RunInputs
from .sampled import sampled_parts

# Size at which displacements are drawn, as a share of the linkage's size.
DRAWN = 0.06


@dataclass(frozen=True, eq=False)
class Computed:
    """Numbers of the job, computed when they are read. Poses without results have NaN.

    Attributes
    ----------
    inputs
        Inputs of the job.
    """

    inputs: RunInputs

    @cached_property
    def motion(self) -> Motion:
        """Motion of the nominal linkage, (poses,)."""
        at = self.inputs.driven_poses
        return self.inputs.linkage.move(
            at.values, rates=at.rates, accelerations=at.accelerations, branch=at.branch, tolerance=at.tolerance
        )

    @property
    def poses(self) -> int:
        """Number of poses."""
        return int(np.prod(self.motion.shape))

    @property
    def drive(self) -> Array:
        """Values of the first drive, in its unit, (poses,)."""
        return np.broadcast_to(self.inputs.first.values, (self.poses,))

    @property
    def increasing(self) -> bool:
        """Whether the first drive only increases, so that it can stand for time."""
        return bool(np.all(np.diff(self.drive) > 0.0))

    @cached_property
    def accuracy(self) -> dict[str, PointAccuracy]:
        """Displacements of the nominal linkage, by point to report."""
        return {point: self.motion.accuracy(point, inertia=self.inputs.moves) for point in self.inputs.points}

    @property
    def main(self) -> PointAccuracy:
        """Displacements of the first point."""
        return self.accuracy[self.inputs.points[0]]

    @property
    def solution(self) -> Solution:
        """Solution of the loaded frame at all poses."""
        return self.main.solution

    @property
    def has_beams(self) -> bool:
        """Whether a link has a beam."""
        return any(link.beams for link in self.motion.linkage.links.values())

    @cached_property
    def reactions(self) -> Reactions:
        """Joint reactions and drive forces."""
        return self.motion.reactions()

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """Status of the motion, or of the frame if that is regular, (poses,); with a mark outside the linear range."""
        return marked_status(self.motion, self.solution)

    @cached_property
    def plane(self) -> tuple[int, int] | None:
        """The two global axes of the plane in which the linkage moves; None if it moves in space."""
        return plane(self.motion)

    @cached_property
    def leaves_plane(self) -> bool:
        """Whether a point to report is displaced out of the plane in which the linkage moves."""
        if self.plane is None:
            return False
        across = 3 - sum(self.plane)
        moved = [found.total[..., :3] for found in self.accuracy.values()]
        moved += [part for spread in self.spread.values() for part in (spread.mean, spread.std)]
        sizes = np.concatenate([np.abs(part).reshape(-1, 3) for part in moved])
        greatest = np.max(sizes, axis=0, where=np.isfinite(sizes), initial=0.0)
        return bool(greatest[across] > ROUNDING * greatest.max())

    @property
    def shown(self) -> tuple[int, ...]:
        """Components in the tables: two in a plane that no point leaves, else three."""
        return (0, 1, 2) if self.flat is None else self.flat

    @property
    def flat(self) -> tuple[int, int] | None:
        """The plane in which displacements can be drawn; None if they are in space."""
        return None if self.leaves_plane else self.plane

    @cached_property
    def parts(self) -> Parts:
        """Displacement of the points with all samples, computed some samples at a time."""
        return sampled_parts(self.inputs, self.nominal)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the results that are needed of the samples."""
        return ("moved", "lost", *(("bound",) if "digits" in self.inputs.also else ()))

    @cached_property
    def displacement(self) -> Array | None:
        """Displacement of all points from their nominal rigid positions, (samples, points, poses, 3).

        None without tolerances. NaN where the nominal linkage has no result, as linear results of its neighbours are
        meaningless there.
        """
        return np.moveaxis(self.parts["moved"], 2, 0) if self.inputs.tolerances else None

    @property
    def lost(self) -> Mapping[str, int]:
        """Number of samples without a result where the nominal linkage has one, by reason, over all poses."""
        return self.parts.count("lost") if self.inputs.tolerances else {}

    @cached_property
    def error_bound(self) -> Array:
        """Bound on the numerical error of the first point's displacement over all samples, (poses, 3)."""
        if not self.inputs.tolerances:
            return np.array(self.rows(self.main.error_bound[..., :3]))
        return self.parts["bound"][0, :, 0] if "digits" in self.inputs.also else np.zeros((self.poses, 3))

    @cached_property
    def nominal(self) -> Array:
        """Nominal rigid positions of the points, (points, poses, 1, 3); NaN where the displacement is not known."""
        return nominal_positions(self.motion, self.accuracy)

    @cached_property
    def spread(self) -> dict[str, Spread]:
        """By point: samples of its displacement, (poses, samples, 3); empty without tolerances."""
        if not self.inputs.tolerances:
            return {}
        samples, policy = self.parts["moved"], self.inputs.nan_policy
        return {point: Spread(samples[index], policy) for index, point in enumerate(self.inputs.points)}

    @cached_property
    def at_measured_poses(self) -> Computed | None:
        """The job for the measured point at its poses; None without measurements."""
        if self.inputs.measured is None:
            return None
        with self.inputs.source.at("measured"):
            return Computed(self.inputs.at_measured_poses())

    @cached_property
    def measured(self) -> MeasuredOutcome | None:
        """Measured positions compared with predicted ones; None without measurements."""
        given, at = self.inputs.measured, self.at_measured_poses
        if given is None or at is None:
            return None
        inputs = at.inputs
        shape = (len(given.table.position), 3)
        found = at.main
        moved, covariance = found.total[..., :3], np.zeros((3, 3))
        if at.spread:
            moved, covariance = at.spread[given.point].mean, at.spread[given.point].covariance
        place = np.broadcast_to(found.rigid + moved, shape)
        with self.inputs.source.at("measured"):
            return MeasuredOutcome.of(given, inputs.drives, place, np.broadcast_to(covariance, (*shape, 3)))

    @cached_property
    def reported_status(self) -> NDArray[np.str_]:
        """`status`, with the number of samples without a result where the nominal linkage has one, (poses,)."""
        missing = np.max([spread.missing.max(axis=-1) for spread in self.spread.values()] or [np.zeros(1, int)], axis=0)
        there = np.isfinite(self.rows(self.main.total)).all(axis=-1)
        words = [
            f"; no result in {count} of {self.inputs.samples} samples" if count else "" for count in missing * there
        ]
        return np.char.add(self.status, words)

    @cached_property
    def pose(self) -> int:
        """Number of the pose in the figures: as given, or else the one with a result nearest to a third of the way."""
        if not self.motion.is_assembled.any():
            raise FrameError("no pose can be assembled: check the drawing, the drives and their unit")
        if self.inputs.pose is not None:
            return int(np.argmin(np.abs(self.drive - self.inputs.pose)))
        good = np.isfinite(self.main.total).all(axis=-1)
        if not good.any():
            good = self.motion.is_assembled
        away = np.abs(np.arange(self.poses) - self.poses / 3.0)
        return int(np.argmin(np.where(good, away, np.inf)))

    @cached_property
    def size(self) -> float:
        """Largest extent along an axis of the linkage over its motion, a length."""
        points = [self.motion.position(point) for point in self.inputs.linkage.points if self._has(point)]
        flat = np.stack(points).reshape(-1, 3)
        return float(np.ptp(flat[np.isfinite(flat).all(axis=-1)], axis=0).max())

    @cached_property
    def magnify(self) -> float:
        """Factor on drawn displacements, by default a round number."""
        if self.inputs.magnify is not None:
            return self.inputs.magnify
        moved = [spread.samples for spread in self.spread.values()]
        moved = moved or [found.total[..., :3] for found in self.accuracy.values()]
        lengths = np.concatenate([np.linalg.norm(each, axis=-1).reshape(-1) for each in moved])
        return magnification(np.where(np.isfinite(lengths), lengths, np.nan), DRAWN * self.size)

    def where(self, pose: int) -> str:
        """A pose in words, such as ``"A = 30°"``."""
        name, drive = next(iter(self.inputs.drives.items()))
        return f"{name} = {self.drive[pose]:g}{'' if drive.unit == 'deg' else ' '}{drive.sign}"

    def rows(self, values: Array) -> Array:
        """Values (..., k) broadcast to all poses, (poses, k)."""
        return np.broadcast_to(values, (self.poses, values.shape[-1]))

    def _has(self, point: str) -> bool:
        return any(point in link.points for link in self.inputs.linkage.links.values())
