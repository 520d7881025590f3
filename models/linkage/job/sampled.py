"""Samples of the job by their number, which any process can compute."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...job.parts import Check, Parts
from ...propagation.failures import FailedRows, FailureCount
from ...sampling import draw
from ..statics.accuracy import PointAccuracy
from ..study.sampled import SampledDisplacement, SomePlaces
from .inputs import RunInputs


class SomeSamples(SomePlaces):
    """Results of some samples, (points, poses, n, ...), computed when they are read."""

    def __call__(self, cut: slice) -> SomeSamples:
        """A part of the samples."""
        return SomeSamples(self.sampled, {name: values[cut] for name, values in self.draws.items()})

    @cached_property
    def moved(self) -> Array:
        """Displacement from the nominal rigid position, (points, poses, n, 3)."""
        return np.asarray(self.places() - self.sampled.nominal)

    def lost(self) -> dict[str, int]:
        """Number of samples without a result where the nominal linkage has one, by reason, over all poses."""
        missing = (np.isnan(self.moved) & ~np.isnan(self.sampled.nominal)).any(axis=(0, -1))
        found: dict[str, int] = {}
        for reason, times in zip(*np.unique(self.status[missing], return_counts=True), strict=True):
            # after a colon come numbers, which differ from sample to sample
            short = str(reason).partition(":")[0]
            found[short] = found.get(short, 0) + int(times)
        return found

    def bound(self) -> Array:
        """Bound on the numerical error of the first point's displacement, (1, poses, n, 3)."""
        return np.broadcast_to(self.accuracy[0].error_bound[..., :3], (1, *self.shape, 3))

    def large(self) -> Array:
        """Displacement of the first point from its own rigid position at large displacement, (1, poses, n, 3)."""
        with self.refused():
            return np.broadcast_to(self.accuracy[0].large[..., :3], (1, *self.shape, 3))

    def large_passes(self) -> NDArray[np.bool_]:
        """Whether the linkage passes a singular configuration on the way there, (1, poses, n)."""
        with self.refused():
            return np.broadcast_to(self.accuracy[0].large_passes, (1, *self.shape))

    def condition_numbers(self) -> tuple[Array, Array]:
        """Condition number of the stiffness matrix, and of its rows and columns in the plane, (poses, n) each."""
        with self.refused():
            return conditions(self.accuracy[0], self.shape)

    def rigid(self) -> Array:
        """Rigid position of the first point in each sample, (1, poses, n, 3)."""
        return np.broadcast_to(self.accuracy[0].rigid, (1, *self.shape, 3))


def conditions(accuracy: PointAccuracy, shape: tuple[int, ...]) -> tuple[Array, Array]:
    """Condition numbers of the matrix as usually assembled, and of its planar part, broadcast to `shape`.

    NaN if a joint is ideal in some directions only, or nodes are tied; the planar one also for motion in space.
    """
    found = []
    for read in (accuracy.condition_number, accuracy.planar_condition_number):
        try:
            found.append(np.broadcast_to(read(), shape))
        except FrameError:
            found.append(np.full(shape, np.nan))
    whole, plane = found
    return whole, plane


def drawn(inputs: RunInputs) -> dict[str, Array]:
    """Samples of the uncertain numbers by tolerance, (n,) each."""
    return draw(inputs.distributions, inputs.samples, inputs.rng, inputs.sampler) if inputs.tolerances else {}


def sampled_parts(inputs: RunInputs, nominal: Array) -> Parts:
    """Displacement of the points of a run with all of its samples, (points, poses, n, 3).

    Parameters
    ----------
    inputs
        The run.
    nominal
        Rigid positions of its points, (points, poses, 1, 3); NaN where they have no displacement.
    """
    draws = drawn(inputs)
    check = _refusing(inputs, draws) if inputs.nan_policy == "raise" else None
    make = SomeSamples(_displacement(inputs, nominal), draws)
    shape = *nominal.shape[:2], inputs.samples
    return Parts(make, shape, greatest=("bound",), counted=("lost",), check=check)


def few_samples(inputs: RunInputs, nominal: Array, count: int) -> SomeSamples:
    """The first `count` samples of a run; without tolerances the linkage itself."""
    return SomeSamples(_displacement(inputs, nominal), drawn(inputs))(slice(count))


def large_parts(inputs: RunInputs, nominal: Array, count: int) -> Parts:
    """The first point of a run at large displacement, (1, poses, count, 3), for the first `count` samples."""
    draws = {name: values[:count] for name, values in drawn(inputs).items()}
    make = SomeSamples(_displacement(inputs, nominal), draws)
    return Parts(make, (1, nominal.shape[1], count), soon=True)


def _displacement(inputs: RunInputs, nominal: Array) -> SampledDisplacement:
    return SampledDisplacement(
        inputs.source, inputs.tolerances, inputs.driven_poses, inputs.points, nominal, inputs.moves
    )


def _refusing(inputs: RunInputs, draws: Mapping[str, Array]) -> Check:
    """Check that refuses the first part in which a sample has no result."""
    count = FailureCount(inputs.samples, inputs.nan_policy, lambda rows: {k: v[rows] for k, v in draws.items()})

    def check(cut: slice, found: Mapping[str, Array]) -> None:
        moved = np.moveaxis(found["moved"], 2, 0)
        lost = np.isnan(moved).reshape(len(moved), -1)
        with inputs.source.at("run", "nan_policy"):
            count.note(cut.start, cut.stop - cut.start, lost.shape[1], FailedRows.of(lost, None))

    return check
