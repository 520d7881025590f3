"""Samples of where the points of a linkage go: a function of its uncertain numbers that another process can call."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import MechanismWarning
from ...job.parts import cuts, one_by_one
from ..description.linkage_description import LinkageDescription
from ..files.source import Source
from ..motion import Motion
from ..statics.accuracy import PointAccuracy
from .tolerances import Tolerance, varied


@dataclass(frozen=True, eq=False)
class DrivenPoses:
    """The poses of a study: what `Linkage.move` takes, with one axis of poses.

    Attributes
    ----------
    values, rates, accelerations
        By joint, () or (poses,), or () or (poses, f) with a last axis where f coordinates of it are driven.
    branch, tolerance
        As `Linkage.move` takes them.
    """

    values: Mapping[str, Array]
    rates: Mapping[str, Array]
    accelerations: Mapping[str, Array]
    branch: str = "keep"
    tolerance: float = 0.0

    def move(self, linkage: LinkageDescription, *, column: bool = False) -> Motion:
        """Motion of a linkage over the poses; as a column, (poses, 1), beside samples."""
        numbers = [self.values, self.rates, self.accelerations]
        if column:
            several = {name: len(driven) > 1 for name, driven in linkage.drives.items()}
            numbers = [{k: np.expand_dims(v, -1 - several[k]) for k, v in each.items()} for each in numbers]
        values, rates, gains = numbers
        return Motion.of(linkage, values, rates, gains, self.branch, self.tolerance)


def nominal_positions(motion: Motion, accuracy: Mapping[str, PointAccuracy]) -> Array:
    """Nominal rigid positions of points, (points, poses, 1, 3); NaN where there is no displacement."""
    shape = (int(np.prod(motion.shape)), 3)
    each = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)  # the status says so
        for found in accuracy.values():
            known = np.isfinite(np.broadcast_to(found.total[..., :3], shape))
            each.append(np.where(known, np.broadcast_to(found.rigid, shape), np.nan))
            _ = found.compliance  # computed here, where nobody need be warned
    return np.stack(each)[:, :, None]


@dataclass(frozen=True, eq=False)
class SampledDisplacement:
    """Displacement of points with samples of uncertain numbers; called by their names, and free of side effects.

    Attributes
    ----------
    source
        The linkage.
    tolerances
        Which of its numbers vary, by name.
    poses
        Where its drives go.
    points
        Which points are asked for.
    nominal
        Where they are with rigid links, no clearance and nominal numbers, (points, poses, 1, 3).
    inertia
        Whether the inertia forces of the rigid motion act as well.
    heat
        By name of a temperature, displacement by a rise of 1, (points, poses, 3).
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
        """The same of draws by name, (n,) each; without `clearance`, by compliance and dimensions alone."""
        n = len(next(iter(draws.values())))
        shape = (len(self.points), self.nominal.shape[1], n)
        moved, status = np.empty((*shape, 3)), []
        for cut in one_by_one(cuts(shape[1], n)):
            own = {name: values[cut] for name, values in draws.items()}
            places, reasons = self._places(own, cut.stop - cut.start, clearance)
            moved[:, :, cut] = places - self.nominal
            for name, slope in self.heat.items():
                if name in draws:
                    moved[:, :, cut] += slope[:, :, None] * draws[name][cut, None]
            status.append(reasons)
        return moved, np.broadcast_to(np.concatenate(status, axis=-1), shape)

    def motion(self, draws: Mapping[str, Array]) -> Motion:
        """Motion with samples of the uncertain numbers, (n,) each: (poses, n)."""
        return self.poses.move(varied(self.source, self.tolerances, draws, LinkageDescription), column=True)

    def _places(self, draws: Mapping[str, Array], n: int, clearance: bool) -> tuple[Array, NDArray[np.str_]]:
        shape = (self.nominal.shape[1], n)
        with warnings.catch_warnings(), self.source.at("tolerances"):
            warnings.simplefilter("ignore", MechanismWarning)
            motion = self.motion(draws)
            each = [motion.accuracy(point, inertia=self.inertia) for point in self.points]
            displaced = [found.total if clearance else found.compliance for found in each]
            places = [
                np.broadcast_to(found.rigid + own[..., :3], (*shape, 3))
                for found, own in zip(each, displaced, strict=True)
            ]
            status = np.where(motion.status == "regular", each[0].status, motion.status)
        return np.stack(places), np.broadcast_to(status, shape)
