"""What the job computes: motion, displacements of the points with their samples, reactions."""

from __future__ import annotations

import warnings
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError, MechanismWarning, SampleWarning
from ....framework.results.validity import LINEAR
from ....framework.solution import Solution
from ...job.outcome import magnification
from ...job.parts import cuts, one_by_one
from ...job.remarks import beyond_linear
from ...job.stages import Advance
from ...propagation import Propagation, propagate
from ...spread import Spread
from ..graphics.plane import ROUNDING, plane
from ..linkage import Linkage
from ..motion import Motion
from ..statics.accuracy import PointAccuracy
from ..statics.reactions import Reactions
from .inputs import RunInputs
from .measured import MeasuredOutcome

# How large the drawn displacements are, as a share of the linkage.
DRAWN = 0.06
# Samples that are held before they are put behind the others.
CHUNK = 1024
# What is counted.
WAY = "samples at a pose"


@dataclass(frozen=True, eq=False)
class Computed:
    """What the job computes. Poses without results hold NaN.

    Attributes
    ----------
    inputs
        What was asked for.
    advance
        Told how many more poses times samples are done.
    """

    inputs: RunInputs
    advance: Advance = lambda *_: None

    @cached_property
    def motion(self) -> Motion:
        """Motion of the nominal linkage, (poses,)."""
        return self.move(self.inputs.linkage)

    def move(self, linkage: Linkage, *, column: bool = False) -> Motion:
        """Motion of a linkage over the poses; as a column, (poses, 1), beside samples."""
        parts = (lambda drive: drive.values), (lambda drive: drive.rate), (lambda drive: drive.acceleration)
        numbers = [self.inputs.numbers(part) for part in parts]
        if column:
            several = {name: len(driven) > 1 for name, driven in linkage.drives.items()}
            numbers = [{k: np.expand_dims(v, -1 - several[k]) for k, v in each.items()} for each in numbers]
        values, rates, gains = numbers
        return linkage.move(
            values, rates=rates, accelerations=gains, branch=self.inputs.branch, tolerance=self.inputs.tolerance
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
        """Whether the first drive only goes forward, so that it can stand for time."""
        return bool(np.all(np.diff(self.drive) > 0.0))

    @cached_property
    def accuracy(self) -> dict[str, PointAccuracy]:
        """By point to report."""
        return {point: self.motion.accuracy(point, inertia=self.inputs.moves) for point in self.inputs.points}

    @property
    def main(self) -> PointAccuracy:
        """Of the first point."""
        return self.accuracy[self.inputs.points[0]]

    @property
    def solution(self) -> Solution:
        """The loaded frame at all poses."""
        return self.main.solution

    @property
    def has_beams(self) -> bool:
        """Whether there is a beam to show."""
        return any(link.beams for link in self.motion.linkage.links.values())

    @cached_property
    def reactions(self) -> Reactions:
        """Joint reactions and drive forces."""
        return self.motion.reactions()

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """That of the motion, or where it is regular that of the frame, marked where linear results do not hold."""
        frame = np.broadcast_to(self.main.status, self.motion.shape)
        moved = np.where(self.motion.is_regular, frame, self.motion.status)
        off = np.broadcast_to(self.solution.nonlinearity(), self.motion.shape)
        text = np.array([beyond_linear(each) for each in off.flat]).reshape(off.shape)
        marked = np.where(moved == "regular", text, np.char.add(np.char.add(moved, "; "), text))
        solved = (frame == "regular") | (frame == self.motion.status)
        return np.where(solved & ~(off < LINEAR), marked, moved)

    @cached_property
    def plane(self) -> tuple[int, int] | None:
        """The two global axes of the plane in which the linkage moves; None where it moves in space."""
        return plane(self.motion)

    @cached_property
    def leaves_plane(self) -> bool:
        """Whether a point to report is displaced across the plane in which the linkage moves."""
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
        """Components that the tables show: two in a plane that no point leaves, else three."""
        return (0, 1, 2) if self.flat is None else self.flat

    @property
    def flat(self) -> tuple[int, int] | None:
        """The plane in which displacements can be drawn; None where they need space."""
        return None if self.leaves_plane else self.plane

    @property
    def propagation(self) -> Propagation | None:
        """Displacement of all points from their nominal rigid positions, (samples, points, poses, 3).

        NaN where the nominal linkage has no answer: that of its neighbours by linear mechanics has no meaning there.
        """
        return self._sampled[0]

    @property
    def lost(self) -> Mapping[str, int]:
        """How many samples have no result where the nominal linkage has one, by reason, over all poses."""
        return self._sampled[1]

    @cached_property
    def _sampled(self) -> tuple[Propagation | None, Counter[str], Array]:
        inputs, lost, bound = self.inputs, Counter[str](), np.zeros((self.poses, 3))
        if not inputs.tolerances:
            return None, lost, bound
        nominal = self._nominal()

        def displaced(**draws: Array) -> Array:
            n = len(next(iter(draws.values())))
            moved = np.empty((*nominal.shape[:2], n, 3))
            for cut in one_by_one(cuts(self.poses, n)):
                self.advance(WAY, 0)
                places, reasons, errors = self._places({name: values[cut] for name, values in draws.items()})
                np.maximum(bound, errors, out=bound)
                moved[:, :, cut] = places - nominal
                missing = (np.isnan(moved[:, :, cut]) & ~np.isnan(nominal)).any(axis=(0, -1))
                for reason, times in zip(*np.unique(reasons[missing], return_counts=True), strict=True):
                    # What follows a colon are numbers, which differ from sample to sample.
                    lost[str(reason).partition(":")[0]] += int(times)
                self.advance(WAY, self.poses * (cut.stop - cut.start))
            return moved

        with warnings.catch_warnings(), inputs.source.at("run", "nan_policy"):
            warnings.simplefilter("ignore", SampleWarning)  # the tables count them
            found = propagate(
                displaced,
                inputs.distributions,
                n=inputs.samples,
                rng=inputs.rng,
                sampler=inputs.sampler,
                axis=2,
                chunk=CHUNK,
                progress=False,
                nan_policy=inputs.nan_policy,
            )
        return found, lost, bound

    @cached_property
    def error_bound(self) -> Array:
        """Bound on the numerical error of the first point's displacement in every sample, (poses, 3)."""
        if self.inputs.tolerances:
            return self._sampled[2]
        return np.array(np.broadcast_to(self.main.error_bound[..., :3], (self.poses, 3)))

    def _nominal(self) -> Array:
        """Nominal rigid positions of the points, (points, poses, 1, 3); NaN where there is no displacement."""
        shape = (self.poses, 3)
        each = [
            np.where(
                np.isfinite(np.broadcast_to(found.total[..., :3], shape)), np.broadcast_to(found.rigid, shape), np.nan
            )
            for found in self.accuracy.values()
        ]
        return np.stack(each)[:, :, None]

    def _places(self, draws: Mapping[str, Array]) -> tuple[Array, NDArray[np.str_], Array]:
        """Positions of the points with samples, (points, poses, n, 3), the status of each, (poses, n), and a bound.

        That is on the numerical error of the first point, (poses, 3); 0 where it is not asked for.
        """
        inputs = self.inputs
        shape = (self.poses, len(next(iter(draws.values()))))
        varied = inputs.varied(draws)
        with warnings.catch_warnings(), inputs.source.at("tolerances"):
            warnings.simplefilter("ignore", MechanismWarning)
            motion = self.move(varied, column=True)
            each = [motion.accuracy(point, inertia=inputs.moves) for point in inputs.points]
            places = [np.broadcast_to(found.rigid + found.total[..., :3], (*shape, 3)) for found in each]
            status = np.where(motion.status == "regular", each[0].status, motion.status)
            bound = np.zeros(3)
            if "digits" in inputs.also:
                bound = np.broadcast_to(each[0].error_bound[..., :3], (*shape, 3)).max(axis=1)
        return np.stack(places), np.broadcast_to(status, shape), bound

    @cached_property
    def spread(self) -> dict[str, Spread]:
        """Samples of the displacement of each point, (poses, samples, 3); none without tolerances."""
        if self.propagation is None:
            return {}
        samples = np.moveaxis(self.propagation.samples, 0, 2)
        policy = self.inputs.nan_policy
        return {point: Spread(samples[index], policy) for index, point in enumerate(self.inputs.points)}

    @cached_property
    def measured(self) -> MeasuredOutcome | None:
        """Measured positions beside those that are predicted at their poses; None where nothing was measured."""
        given = self.inputs.measured
        if given is None:
            return None
        with self.inputs.source.at("measured"):
            inputs = self.inputs.at_measured_poses()
        at = Computed(inputs)
        shape = (len(given.table.position), 3)
        found = at.main
        moved, deviation = found.total[..., :3], np.zeros(shape)
        if at.spread:
            moved, deviation = at.spread[given.point].mean, at.spread[given.point].std
        place = np.broadcast_to(found.rigid + moved, shape)
        drives = {name: np.array(np.broadcast_to(drive.values, shape[:1])) for name, drive in inputs.drives.items()}
        with self.inputs.source.at("measured"):
            return MeasuredOutcome.of(given, drives, place, np.broadcast_to(deviation, shape))

    @cached_property
    def reported_status(self) -> NDArray[np.str_]:
        """`status`, and of how many samples there is no result where the nominal linkage has one, (poses,)."""
        missing = np.max([spread.missing.max(axis=-1) for spread in self.spread.values()] or [np.zeros(1, int)], axis=0)
        there = np.isfinite(np.broadcast_to(self.main.total, (self.poses, 6))).all(axis=-1)
        words = [
            f"; no result in {count} of {self.inputs.samples} samples" if count else "" for count in missing * there
        ]
        return np.char.add(self.status, words)

    @cached_property
    def pose(self) -> int:
        """Number of the pose that the figures show: as asked, or the regular one nearest to a third of the way."""
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
        """Largest extent of the linkage over its motion."""
        points = [self.motion.position(point) for point in self.inputs.linkage.points if self._has(point)]
        flat = np.stack(points).reshape(-1, 3)
        return float(np.ptp(flat[np.isfinite(flat).all(axis=-1)], axis=0).max())

    @cached_property
    def magnify(self) -> float:
        """Factor on drawn displacements, a round number."""
        if self.inputs.magnify is not None:
            return self.inputs.magnify
        moved = [spread.samples for spread in self.spread.values()]
        moved = moved or [found.total[..., :3] for found in self.accuracy.values()]
        lengths = np.concatenate([np.linalg.norm(each, axis=-1).reshape(-1) for each in moved])
        return magnification(np.where(np.isfinite(lengths), lengths, np.nan), DRAWN * self.size)

    def where(self, pose: int) -> str:
        """A pose in words, such as ``"A = 30°"``."""
        name, drive = next(iter(self.inputs.drives.items()))
        unit = {"deg": "°", "rad": " rad"}.get(drive.unit, " m")
        return f"{name} = {self.drive[pose]:g}{unit}"

    def _has(self, point: str) -> bool:
        return any(point in link.points for link in self.inputs.linkage.links.values())
