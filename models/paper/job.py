"""The job of ``linkframe four-bar``: its files, and its summary in a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ...framework.errors import FrameError
from ..job import figures, large_table
from ..job.measured import CAPTION, FIGURE_FILE, TABLE_FILE
from ..job.report import Report
from ..job.run import Job
from ..job.sharing import ALONE, Sharing
from ..job.stages import Advance
from . import drawing, page, reactions
from .compared_choices import ComparedChoices, compare_choices
from .remarks import beforehand, remarks
from .report import report
from .result import Result, begin, finish
from .study import work
from .table import about_errors, as_csv, as_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from .inputs import Inputs

CAPTIONS = {
    "figure5.png": "Figure 5: the linkage at θ = {pose:g}°, its drive clamped.",
    "figure6.png": "Figure 6: path of P, samples, and their envelope: the boundary of what they sweep from pose to"
    " pose; displacements × {magnify:g}; right, to scale at {pose:g}°.",
    "figure7.png": "Figure 7: displacement of P from its rigid position at θ = {pose:g}°, with normal fits.",
    "reactions.png": "Size of the forces in the joints, and torque of the drive, under the mean load.",
    FIGURE_FILE: CAPTION,
    "figure3d.png": "The loaded linkage at θ = {pose:g}° in space.",
}
UNITS = "Drive angle θ [°]; mean μ and standard deviation σ of the position of P [m]; κ of K, and κ scaled [1]."
PRINTED = "Right of the bar: the values printed in the paper, under the headings that fit them; see report.md."


class FourBarJob(Job):
    """The accuracy of a four-bar, the paper's by default.

    Parameters
    ----------
    inputs
        Inputs of the job.
    shared
        Workers that compute the samples, and the folder where these are kept.
    """

    name = "four-bar"
    optional = (*CAPTIONS, TABLE_FILE, "trajectory/*.vtu")
    has_beams = True
    result: Result

    def __init__(self, inputs: Inputs, shared: Sharing = ALONE) -> None:
        self.inputs, self.shared = inputs, shared
        self.result = begin(inputs)

    def beforehand(self) -> list[str]:
        """Remarks that are known before the samples are computed."""
        return beforehand(self.result)

    @property
    def work(self) -> Mapping[str, int]:
        """Number of poses times samples to compute, by part."""
        return work(self.inputs)

    def compute(self, advance: Advance) -> None:
        """Compute all numbers."""
        finish(self.result, advance, shared=self.shared)

    @property
    def entry(self) -> int:
        return self.result.entry

    def tables(self) -> Mapping[str, str]:
        """Table 1 and the reactions."""
        return {"table1.csv": as_csv(self.result), "reactions.csv": reactions.as_csv(self.result)}

    def samples(self) -> Mapping[str, NDArray[Any]]:
        """Samples of the inputs and of the displacement of P."""
        result = self.result
        return {
            "theta": result.inputs.theta,
            "rigid": result.rigid,
            "displacement": result.samples,
            "displacement_large": result.large.samples,
            "status": result.status,
            "kappa": result.kappa,
            "kappa_scaled": result.kappa_scaled,
            **{f"input_{name}": value for name, value in result.draws.items()},
        }

    def figures(self) -> Iterator[tuple[str, Figure]]:
        """The paper's Figures 5 to 7, and the reactions."""
        result, pose, theta = self.result, self.result.pose, self.inputs.theta
        points = {name: result.motion.position(name)[result.entry] for name in "ABPDE"}
        where = f"θ = {result.degrees[pose]:g}°"
        yield "figure5.png", drawing.draw_linkage(points, (0.0, self.inputs.load), theta[pose])
        traced = figures.TracedPoint(
            "P", "xy", *(each[..., :2] for each in (result.path, result.rigid, result.samples))
        )
        yield "figure6.png", figures.draw_trajectories([traced], result.magnify, pose, where)
        yield "figure7.png", figures.draw_histograms([(result.samples[pose], ("P", "xy"))], where)
        yield "reactions.png", reactions.draw(result)

    def captions(self) -> Mapping[str, str]:
        words = {"pose": self.result.degrees[self.result.pose], "magnify": self.result.magnify}
        return {name: text.format(**words) for name, text in CAPTIONS.items()}

    def page(self, path: Path) -> None:
        """Write the page of P."""
        page.write_job_page(self.result, path)

    def save(self, path: Path) -> None:
        """Write the ParaView files; time is the drive angle in degrees."""
        self.result.solution.save(path, times=self.result.degrees[self.result.assembled])

    def compared(self) -> ComparedChoices | None:
        """Effects of single choices at the pose that is expected to be shown; None if they cannot be computed."""
        try:
            return compare_choices(self.inputs, float(self.result.degrees[self.result.expected_pose]))
        except FrameError:
            return None  # another pose will be shown, or the job itself will raise the same error

    def remarks(self) -> list[str]:
        return remarks(self.result)

    def report(self, compared: ComparedChoices | None = None) -> Report:
        """The report."""
        return report(self.result, compared)

    def summary(self, width: int | None = None) -> str:
        """Table 1, large displacement where it is needed, and the largest reactions."""
        result = self.result
        paragraphs = [UNITS, as_text(result, width), about_errors(result)]
        if self.inputs.is_paper_linkage:
            paragraphs.append(PRINTED)
        paragraphs += large_table.passage(result, width)
        return "\n\n".join([*paragraphs, reactions.summary(result)])
