"""The job of ``linkframe run``: its files, and its summary in a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...job import large_table
from ...job.measured import TABLE_FILE
from ...job.report import Report
from ...job.run import Job
from ...job.sharing import ALONE, Sharing
from ...job.stages import Advance
from .figures import CAPTIONS, captions, draw
from .inputs import RunInputs
from .page import write_job_page
from .remarks import remarks
from .report import report
from .result import RunResult, finish, work
from .sampled import drawn
from .table import as_csv, as_text, legend, reactions_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

DRAWN = "In brackets: one standard error of sampling, in units of the last digit; all poses share the same draws."


class LinkageJob(Job):
    """The accuracy of the linkage in a file.

    Parameters
    ----------
    inputs
        Inputs of the job.
    shared
        Workers that compute the samples, and the folder where these are kept.
    """

    name = "run"
    optional = (*CAPTIONS, TABLE_FILE, "samples.npz", "trajectory.pvd", "trajectory/*.vtu")
    result: RunResult

    def __init__(self, inputs: RunInputs, shared: Sharing = ALONE) -> None:
        self.inputs, self.shared = inputs, shared
        self.result = RunResult(inputs)

    @property
    def has_beams(self) -> bool:
        return any(link.beams for link in self.inputs.linkage.links.values())

    @property
    def work(self) -> Mapping[str, int]:
        """Number of poses times samples to compute, by part."""
        return work(self.inputs)

    def compute(self, advance: Advance) -> None:
        """Compute all numbers."""
        finish(self.result, advance, self.shared)

    @property
    def entry(self) -> int:
        return self.result.pose

    def tables(self) -> Mapping[str, str]:
        """The table and the reactions."""
        return {"table.csv": as_csv(self.result), "reactions.csv": reactions_csv(self.result)}

    def samples(self) -> Mapping[str, NDArray[Any]]:
        """Samples of the inputs and of the displacement of all points; nothing without tolerances."""
        result, also = self.result, self.inputs.also
        if result.displacement is None:
            return {}
        found: dict[str, NDArray[Any]] = {"drive": result.drive, "displacement": result.displacement}
        found["rigid"] = np.stack([result.rows(each.rigid) for each in result.accuracy.values()])
        if "large" in also:
            found["displacement_large"] = np.moveaxis(result.outcome.large.samples, 1, 0)
            found["large_passes"] = result.outcome.large.passed.T
        if "condition" in also:
            outcome = result.outcome
            found |= {"kappa": outcome.kappa, "kappa_plane": outcome.planar_kappa, "kappa_scaled": outcome.kappa_scaled}
        draws = {f"input_{name}": values for name, values in drawn(self.inputs).items()}
        return {**found, "status": result.marked_status, **draws}

    def figures(self) -> Iterator[tuple[str, Figure]]:
        """The linkage, the paths of its points, histograms of what varies, and the reactions."""
        yield from draw(self.result).items()

    def captions(self) -> Mapping[str, str]:
        return captions(self.result)

    def page(self, path: Path) -> None:
        """Write the page of the first point."""
        write_job_page(self.result, path)

    def save(self, path: Path) -> None:
        """Write the ParaView files; those of the motion alone if no link has a beam."""
        result = self.result
        times = result.drive if result.increasing else None
        if self.has_beams:
            self.result.solution.save(path, times=times, axis=0)
        else:
            result.motion.save(path, times=times)

    def remarks(self) -> list[str]:
        return remarks(self.result)

    def report(self, compared: None = None) -> Report:
        """The report; this job compares nothing."""
        return report(self.result)

    def summary(self, width: int | None = None) -> str:
        """Legend of the table, the table, the meaning of its brackets, and further tables."""
        table = as_text(self.result, width)
        outcome = self.result.outcome
        large = large_table.passage(outcome, width) if "large" in self.inputs.also else []
        paragraphs = [legend(self.result), table, *([DRAWN] if self.inputs.tolerances else []), *large]
        return "\n\n".join(paragraphs)
