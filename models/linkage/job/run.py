"""The job of ``linkframe run``: check, compute, and then write everything or nothing."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.errors import MechanismWarning
from ...job.output import results, written
from ...job.rendered import rendered
from ...job.stages import Stages
from .figures import captions, draw
from .inputs import RunInputs
from .remarks import remarks
from .report import report
from .result import compute, work
from .table import as_csv, as_text, reactions_csv

if TYPE_CHECKING:
    from .result import RunResult

# What an earlier run may have left: of more poses, with tolerances, or where rendering works.
EARLIER = ("figure3d.png", "histogram.png", "samples.npz", "trajectory.pvd", "trajectory/*.vtu")


def run(inputs: RunInputs, out: Path) -> None:
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
        If no pose can be assembled, something cannot be solved, the samples do not fit the memory, or `out` cannot be
        written or holds the results of another job; then nothing is written.
    """
    stages = Stages(7 if inputs.tolerances else 6)
    with results(out, "run", EARLIER) as stage, warnings.catch_warnings():
        # Singular poses are part of the answer: their status says so.
        warnings.simplefilter("ignore", MechanismWarning)
        with stages("solution", work(inputs)) as advance:
            result = compute(inputs, advance)
        if inputs.tolerances:
            with stages("samples"):
                _save_samples(result, stage / "samples.npz")
        with stages("tables"):
            (stage / "table.csv").write_text(as_csv(result), encoding="utf-8")
            (stage / "reactions.csv").write_text(reactions_csv(result), encoding="utf-8")
        with stages("figures"):
            for name, figure in draw(result).items():
                figure.savefig(stage / name)
        with stages("ParaView files"):
            _save(result, stage / "trajectory.pvd")
        with stages("3-D picture"):
            notes = rendered(result.solution, stage / "figure3d.png", result.pose) if result.has_beams else []
        with stages("report"):
            pictures = {name: text for name, text in captions(result).items() if (stage / name).exists()}
            text = report(result, pictures, notes, stages.seconds)
            (stage / "report.md").write_text(text, encoding="utf-8")
        stages.close()
        files = written(stage)
    _tell(result, out, files, notes, stages)


def _save_samples(result: RunResult, path: Path) -> None:
    found = result.propagation
    assert found is not None
    arrays: dict[str, Any] = {"drive": result.drive, "displacement": found.samples}
    np.savez_compressed(path, **arrays)


def _save(result: RunResult, path: Path) -> None:
    times = result.drive if result.increasing else None
    if result.has_beams:
        result.solution.save(path, times=times, axis=0)
    else:
        result.motion.save(path, times=times)


def _tell(result: RunResult, out: Path, files: list[str], notes: list[str], stages: Stages) -> None:
    print(as_text(result))
    if result.inputs.tolerances:
        print(
            "\nIn brackets: one standard error of sampling, in units of the last digit; all poses share the same draws."
        )
    for note in [*remarks(result), *notes]:
        print(f"\n{note}")
    print(f"\nWritten to {out}: {', '.join(files)}\n{stages.spent}")
