"""The job of ``linkframe four-bar``: check, compute, and then write everything or nothing."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ...framework.errors import MechanismWarning
from ..job.figures import draw_histograms, draw_trajectory
from ..job.output import results, written
from ..job.rendered import rendered
from ..job.stages import Stages
from . import large_table, reactions
from .figures import draw_linkage
from .remarks import remarks
from .report import report
from .result import compute, work
from .table import about_errors, as_csv, as_text

if TYPE_CHECKING:
    from .inputs import Inputs
    from .result import Result

# What a run with other poses, or where rendering works, may have left.
EARLIER = ("figure3d.png", "trajectory/*.vtu")
CAPTIONS = {
    "figure5.png": "Figure 5: the linkage at θ = {pose:g}°, its drive clamped.",
    "figure6.png": "Figure 6: path of P, samples, and their envelope: the boundary of what they sweep from pose to"
    " pose; displacements × {magnify:g}; right, to scale at {pose:g}°.",
    "figure7.png": "Figure 7: displacement of P from its rigid position at θ = {pose:g}°, with normal fits.",
    "reactions.png": "Size of the forces in the joints, and torque of the drive, under the mean load.",
    "figure3d.png": "The loaded linkage at θ = {pose:g}° in space.",
}


def run(inputs: Inputs, out: Path) -> None:
    """Run the job and print its table.

    Parameters
    ----------
    inputs
        What to compute.
    out
        Directory for the results; made if it does not exist. Files of an earlier run are replaced, others stay.

    Raises
    ------
    FrameError
        If the linkage can be assembled at no pose, no pose is regular, or `out` cannot be written or holds
        the results of another job; then nothing is written.
    """
    stages = Stages(6)
    with results(out, "four-bar", EARLIER) as stage, warnings.catch_warnings():
        # Singular poses are part of the answer: their status says so.
        warnings.simplefilter("ignore", MechanismWarning)
        with stages("solution", work(inputs)) as advance:
            result = compute(inputs, advance)
        with stages("table and samples"):
            (stage / "table1.csv").write_text(as_csv(result), encoding="utf-8")
            (stage / "reactions.csv").write_text(reactions.as_csv(result), encoding="utf-8")
            _save_samples(result, stage / "samples.npz")
        with stages("figures"):
            _draw(result, stage)
        with stages("ParaView files"):
            result.solution.save(stage / "trajectory.pvd", times=result.degrees[result.assembled])
        with stages("3-D picture"):
            notes = rendered(result.solution, stage / "figure3d.png", result.entry)
        with stages("report"):
            notes = [*remarks(result), *notes]
            pictures = {name: _caption(name, result) for name in CAPTIONS if (stage / name).exists()}
            text = report(result, pictures, notes, stages.seconds)
            (stage / "report.md").write_text(text, encoding="utf-8")
        stages.close()
        files = written(stage)
    _tell(result, out, files, notes, stages)


def _save_samples(result: Result, path: Path) -> None:
    arrays: dict[str, Any] = {
        "theta": result.inputs.theta,
        "rigid": result.rigid,
        "displacement": result.samples,
        "displacement_large": result.large.samples,
        "status": result.status,
        "kappa": result.kappa,
        "kappa_scaled": result.kappa_scaled,
    }
    arrays |= {f"input_{name}": value for name, value in result.draws.items()}
    np.savez_compressed(path, **arrays)


def _draw(result: Result, stage: Path) -> None:
    pose, theta = result.pose, result.inputs.theta
    points = {name: result.motion.position(name)[result.entry] for name in "ABPDE"}
    draw_linkage(points, (0.0, result.inputs.load), theta[pose]).savefig(stage / "figure5.png")
    where = f"θ = {result.degrees[pose]:g}°"
    draw_trajectory(result.path, result.rigid, result.samples, result.magnify, pose, where).savefig(
        stage / "figure6.png"
    )
    draw_histograms(result.samples[pose], where).savefig(stage / "figure7.png")
    reactions.draw_reactions(result.degrees, result.forces).savefig(stage / "reactions.png")


def _caption(name: str, result: Result) -> str:
    return CAPTIONS[name].format(pose=result.degrees[result.pose], magnify=result.magnify)


def _tell(result: Result, out: Path, files: list[str], notes: list[str], stages: Stages) -> None:
    print(f"{as_text(result)}\n\n{about_errors(result)}")
    if result.inputs.is_paper_linkage:
        print("\nRight of the bar: the values printed in the paper, under the headings that fit them; see report.md.")
    if table := large_table.as_text(result):
        print(f"\nWhere linear mechanics does not hold, beside the samples at large displacement:\n{table}")
    for note in (*large_table.passages(result), reactions.summary(result), *notes):
        print(f"\n{note}")
    print(f"\nWritten to {out}: {', '.join(files)}\n{stages.spent}")
