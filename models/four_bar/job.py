"""The job of ``linkframe four-bar``: check, compute, and then write everything or nothing."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np

from ...framework.errors import FrameError, MechanismWarning
from ...framework.files import whole_or_nothing
from .figures import draw_histograms, draw_linkage, draw_trajectory
from .report import report
from .result import compute
from .table import as_csv, as_text

if TYPE_CHECKING:
    from .inputs import Inputs
    from .result import Result

CAPTIONS = {
    "figure5.png": "Figure 5: the linkage at θ = {pose:g}°, its drive clamped.",
    "figure6.png": "Figure 6: path of P, samples, envelope, displacements × {magnify:g}; right, to scale at {pose:g}°.",
    "figure7.png": "Figure 7: displacement of P from its rigid position at θ = {pose:g}°, with normal fits.",
    "figure3d.png": "The loaded linkage at θ = {pose:g}° in space.",
}


class Stages:
    """The stages of a job: a progress bar on a terminal, and how long each took.

    Parameters
    ----------
    count
        Number of stages to come.
    """

    def __init__(self, count: int) -> None:
        from tqdm import tqdm

        self.bar = tqdm(total=count, disable=None, leave=False, bar_format="{desc:<20}{bar}| {elapsed}")
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the body as the stage `name`."""
        self.bar.set_description_str(name)
        start = perf_counter()
        yield
        self.seconds[name] = perf_counter() - start
        self.bar.update()


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
        If the linkage cannot be assembled at a pose, no pose is regular, or `out` cannot be written; then nothing is.
    """
    stages = Stages(6)
    with _made(out), whole_or_nothing(out) as stage, warnings.catch_warnings():
        # Singular poses are part of the answer: their status says so.
        warnings.simplefilter("ignore", MechanismWarning)
        with stages("solution"):
            result = compute(inputs)
        with stages("table and samples"):
            (stage / "table1.csv").write_text(as_csv(result), encoding="utf-8")
            _save_samples(result, stage / "samples.npz")
        with stages("figures"):
            _draw(result, stage)
        with stages("ParaView files"):
            result.solution.save(stage / "trajectory.pvd", times=result.degrees)
        with stages("3-D picture"):
            notes = _render(result, stage / "figure3d.png")
        with stages("report"):
            pictures = {name: _caption(name, result) for name in CAPTIONS if (stage / name).exists()}
            text = report(result, pictures, notes, stages.seconds)
            (stage / "report.md").write_text(text, encoding="utf-8")
        stages.bar.close()
        new = {path.relative_to(stage) for path in stage.rglob("*")}
    _forget(out, new)
    _tell(result, out, notes, stages)


@contextmanager
def _made(out: Path) -> Iterator[None]:
    """Make `out` and its parents, and unmake what was made if the body fails."""
    missing = [path for path in (out, *out.parents) if not path.exists()]
    try:
        try:
            out.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            why = error.strerror or error
            raise FrameError(f"--out {out} cannot be made: {why}; choose a directory that can be written") from error
        yield
    except BaseException:
        for path in missing:
            with suppress(OSError):
                path.rmdir()
        raise


def _forget(out: Path, new: set[Path]) -> None:
    """Remove what an earlier run left and this one did not write: more poses, a picture in space."""
    for path in (out / "figure3d.png", *out.glob("trajectory/*.vtu")):
        if path.relative_to(out) not in new:
            path.unlink(missing_ok=True)


def _save_samples(result: Result, path: Path) -> None:
    arrays: dict[str, Any] = {
        "theta": result.inputs.theta,
        "rigid": result.rigid,
        "displacement": result.samples,
        "status": result.status,
        "kappa": result.kappa,
        "kappa_scaled": result.kappa_scaled,
    }
    arrays |= {f"input_{name}": value for name, value in result.draws.items()}
    np.savez_compressed(path, **arrays)


def _draw(result: Result, stage: Path) -> None:
    pose, theta = result.pose, result.inputs.theta
    points = {name: result.motion.position(name)[pose] for name in "ABPDE"}
    draw_linkage(points, (0.0, result.inputs.load), theta[pose]).savefig(stage / "figure5.png")
    draw_trajectory(result.path, result.rigid, result.samples, result.magnify, pose, theta).savefig(
        stage / "figure6.png"
    )
    draw_histograms(result.samples[pose], theta[pose]).savefig(stage / "figure7.png")


def _render(result: Result, path: Path) -> list[str]:
    from ...framework.rendering import RenderingError
    from ...framework.view import picture

    try:
        picture(result.solution, path, entry=result.pose)
    except RenderingError as error:
        return [f"Without the 3-D picture: {error}."]
    return []


def _caption(name: str, result: Result) -> str:
    return CAPTIONS[name].format(pose=result.degrees[result.pose], magnify=result.magnify)


def _tell(result: Result, out: Path, notes: list[str], stages: Stages) -> None:
    print(as_text(result))
    if result.inputs.is_paper_linkage:
        print("\nRight of the bar: the values printed in the paper, under the headings that fit them; see report.md.")
    for note in notes:
        print(f"\n{note}")
    split = ", ".join(f"{name} {seconds:.2f}" for name, seconds in stages.seconds.items())
    print(f"\nWritten to {out}: {', '.join(sorted(path.name for path in out.iterdir()))}")
    print(f"{sum(stages.seconds.values()):.2f} s: {split}")
