"""Compute all numbers that the job's tables, figures and report show."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.errors import expected_mechanisms
from ...job.measured import MEASURED_WAY
from ...job.memory import check
from ...job.outcome import LARGE_WAY, LINEAR_WAY, taken
from ...job.sharing import ALONE, SampleKind, Sharing
from ...job.stages import Advance
from ...sampling import sample_blocks
from .computed import Computed
from .inputs import RunInputs
from .point import PointOutcome

# Memory that a sample takes for each of its inputs, and for each point at a pose, bytes.
BYTES_ALONE, BYTES = 8 * 30, 8 * 30


@dataclass(frozen=True, eq=False)
class RunResult(Computed):
    """Outcome of the job."""

    def kinds(self) -> dict[str, SampleKind]:
        """Results that depend on samples, by kind: linear, large displacement, at measured poses."""
        found = {}
        if self.inputs.tolerances:
            found["linear"] = SampleKind(LINEAR_WAY, self.parts, self.names)
        if "large" in self.inputs.also:
            found["large"] = SampleKind(LARGE_WAY, self.outcome.large_parts, ("large", "rigid", "large_passes"))
        measured = self.at_measured_poses
        if measured is not None and measured.inputs.tolerances:
            found["measured"] = SampleKind(MEASURED_WAY, measured.parts, measured.names)
        return found

    @cached_property
    def outcome(self) -> PointOutcome:
        """Outcome of the first point, for the tables that all jobs share."""
        return PointOutcome(self)

    @cached_property
    def marked_status(self) -> NDArray[np.str_]:
        """`reported_status`, marked by the first point's large displacement if that is asked for, (poses,)."""
        found = self.reported_status
        return np.where(found == "regular", self.outcome.marked_status, found) if "large" in self.inputs.also else found


def compute(inputs: RunInputs, advance: Advance | None = None, shared: Sharing = ALONE) -> RunResult:
    """Compute all numbers of the job, so that nothing can fail when they are written.

    Parameters
    ----------
    inputs
        Inputs of the job.
    advance
        Called with the name of a part of `work(inputs)`, and the number of poses times samples that were done.
    shared
        Workers that compute the samples, and the folder where these are kept.

    Raises
    ------
    FrameError
        If no pose can be assembled, something cannot be solved, or the samples do not fit the memory.
    """
    return finish(RunResult(inputs), advance, shared)


def finish(result: RunResult, advance: Advance | None = None, shared: Sharing = ALONE) -> RunResult:
    """Compute all numbers of a result; see `compute`."""
    inputs = result.inputs
    if inputs.tolerances:
        _check_memory(inputs)
        for draws in sample_blocks(inputs.distributions, inputs.samples, inputs.rng, inputs.sampler):
            # refuse samples that describe no linkage before anything is computed
            inputs.varied(draws)
    for _ in inputs.chosen(0, 2):
        pass  # refuse impossible choices before anything is computed
    with expected_mechanisms():
        _ = result.pose, result.status, result.reactions
        shared.compute(result.kinds(), advance or (lambda *_: None))
        _ = result.spread, result.measured
        for found in result.accuracy.values():
            _ = found.compliance, found.total
        if "large" in inputs.also:
            _ = result.outcome.large
    return result


def work(inputs: RunInputs) -> dict[str, int]:
    """Number of poses times samples to compute, by part: linear, at large displacement, at measured poses."""
    found = {LINEAR_WAY: _poses(inputs) * inputs.samples} if inputs.tolerances else {}
    if "large" in inputs.also:
        found[LARGE_WAY] = _poses(inputs) * (taken(inputs.samples) if inputs.tolerances else 1)
    if inputs.tolerances and inputs.measured is not None:
        found[MEASURED_WAY] = len(inputs.measured.table.position) * inputs.samples
    return found


def _poses(inputs: RunInputs) -> int:
    return max(len(drive.values) for drive in inputs.drives.values())


def _check_memory(inputs: RunInputs) -> None:
    displaced = _poses(inputs) * len(inputs.points)
    displaced += 0 if inputs.measured is None else len(inputs.measured.table.position)
    each = BYTES_ALONE * len(inputs.tolerances) + BYTES * displaced
    with inputs.source.at("run", "samples"):
        check(each, inputs.samples, "samples")
