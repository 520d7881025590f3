"""Displacements of the points of a linkage as a function of its uncertain numbers, which other processes can call."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import expected_mechanisms
from ...job.parts import cuts, one_by_one
from ..description.linkage_description import LinkageDescription
from ..files.source import Source
from ..motion import Motion
from ..statics.accuracy import PointAccuracy
from .tolerances import Tolerance, varied


@dataclass(frozen=True, eq=False)
class DrivenPoses:
    """The poses of a study: arguments of `Linkage.move`, with one axis of poses.

    Attributes
    ----------
    values, rates, accelerations
        By joint: () or (poses,), or (f,) or (poses, f) if f coordinates of it are driven.
    branch, tolerance
        As for `Linkage.move`.
    """

    values: Mapping[str, Array]
    rates: Mapping[str, Array]
    accelerations: Mapping[str, Array]
    branch: str = "keep"
    tolerance: float = 0.0

    def move(self, linkage: LinkageDescription, *, column: bool = False) -> Motion:
        """Motion of a linkage over the poses, (poses,); with `column` (poses, 1), to broadcast with samples."""
        numbers = [self.values, self.rates, self.accelerations]
        if column:
            several = {name: len(driven) > 1 for name, driven in linkage.drives.items()}
            numbers = [{k: np.expand_dims(v, -1 - several[k]) for k, v in each.items()} for each in numbers]
        values, rates, gains = numbers
        return Motion.of(linkage, values, rates, gains, self.branch, self.tolerance)


def nominal_positions(motion: Motion, accuracy: Mapping[str, PointAccuracy]) -> Array:
    """Nominal rigid positions of points, (points, poses, 1, 3); NaN where the displacement is not known."""
    shape = (int(np.prod(motion.shape)), 3)
    each = []
    with expected_mechanisms():
        for found in accuracy.values():
            known = np.isfinite(np.broadcast_to(found.total[..., :3], shape))
            each.append(np.where(known, np.broadcast_to(found.rigid, shape), np.nan))
            _ = found.compliance  # computed now, as warnings are expected here
    return np.stack(each)[:, :, None]


@dataclass(frozen=True, eq=False)
class SampledDisplacement:
    """Displacement of points as a function of samples of the uncertain numbers by name, without side effects.

    Attributes
    ----------
    source
        The linkage.
    tolerances
        Tolerances of its numbers, by name.
    poses
        Values of its drives.
    points
        Names of the points.
    nominal
        Their positions with rigid links, no clearance and nominal numbers, (points, poses, 1, 3).
    inertia
        Whether the inertia forces of the rigid motion act as well.
    heat
        By name of a temperature: displacement per degree, (points, poses, 3).
    """

    source: Source
    tolerances: Mapping[str, Tolerance]
    poses: DrivenPoses
    points: tuple[str, ...]
    nominal: Array
    inertia: bool = False
    heat: Mapping[str, Array] = field(default_factory=dict)

    def __call__(self, **draws: Array) -> tuple[Array, NDArray[np.str_]]:
        """Displacement from the nominal rigid position, (points, poses, n, 3), and status, (points, poses, n)."""
        return self.moved(draws)

    def moved(self, draws: Mapping[str, Array], *, clearance: bool = True) -> tuple[Array, NDArray[np.str_]]:
        """Displacement and status for draws by name, (n,) each; without `clearance`, by compliance and dimensions."""
        n = len(next(iter(draws.values())))
        shape = (len(self.points), self.nominal.shape[1], n)
        moved, status = np.empty((*shape, 3)), []
        for cut in one_by_one(cuts(shape[1], n)):
            own = {name: values[cut] for name, values in draws.items()}
            places, reasons = self._places(own, clearance)
            moved[:, :, cut] = places - self.nominal
            for name, slope in self.heat.items():
                if name in draws:
                    moved[:, :, cut] += slope[:, :, None] * draws[name][cut, None]
            status.append(reasons)
        return moved, np.broadcast_to(np.concatenate(status, axis=-1), shape)

    def motion(self, draws: Mapping[str, Array]) -> Motion:
        """Motion (poses, n) with samples of the uncertain numbers, (n,) each."""
        return self.poses.move(varied(self.source, self.tolerances, draws, LinkageDescription), column=True)

    def _places(self, draws: Mapping[str, Array], clearance: bool) -> tuple[Array, NDArray[np.str_]]:
        some = SomePlaces(self, draws)
        return some.places(clearance=clearance), some.status


@dataclass(frozen=True, eq=False)
class SomePlaces:
    """Positions of the points for some samples, computed when they are read.

    Attributes
    ----------
    sampled
        The function of the samples.
    draws
        Samples of the numbers by tolerance, (n,) each; empty for the nominal linkage.
    """

    sampled: SampledDisplacement
    draws: Mapping[str, Array]

    @property
    def shape(self) -> tuple[int, int]:
        """Number of poses and of samples."""
        return self.sampled.nominal.shape[1], len(next(iter(self.draws.values()), [0]))

    @cached_property
    def motion(self) -> Motion:
        """Motion of the samples, (poses, n)."""
        with self.refused():
            return self.sampled.motion(self.draws)

    @cached_property
    def accuracy(self) -> list[PointAccuracy]:
        """Displacements by point."""
        return [self.motion.accuracy(point, inertia=self.sampled.inertia) for point in self.sampled.points]

    @property
    def status(self) -> NDArray[np.str_]:
        """Status of the motion, or of the frame where that of the motion is regular, (poses, n)."""
        with self.refused():
            status = np.where(self.motion.status == "regular", self.accuracy[0].status, self.motion.status)
        return np.broadcast_to(status, self.shape)

    def places(self, *, clearance: bool = True) -> Array:
        """Displaced positions, (points, poses, n, 3)."""
        with self.refused():
            moved = [found.total if clearance else found.compliance for found in self.accuracy]
            each = [found.rigid + own[..., :3] for found, own in zip(self.accuracy, moved, strict=True)]
            return np.stack([np.broadcast_to(place, (*self.shape, 3)) for place in each])

    @contextmanager
    def refused(self) -> Iterator[None]:
        """Let errors of samples name the tolerances that drew them."""
        with expected_mechanisms(), self.sampled.source.at("tolerances"):
            yield
