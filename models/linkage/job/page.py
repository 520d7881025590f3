"""The page of the job, and of a file without a job."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ...job import digits
from ..files.read import linkage_of
from ..files.source import Source
from ..linkage import Linkage
from ..motion import Motion
from ..page.about import CERTAIN
from ..page.data import MOST_POSES, traced_point
from ..page.page import PageText, write_page
from .computed import Computed
from .inputs import inputs_of
from .page_limits import worst_case_of

if TYPE_CHECKING:
    from .inputs import RunInputs
    from .result import RunResult


def write_job_page(result: RunResult, path: Path) -> None:
    """Write the page of the first point that a job reports, with its samples and measured positions."""
    inputs, point = result.inputs, result.inputs.points[0]
    motion, every = _few(result)
    spread = result.spread.get(point)
    cloud = None if spread is None else spread.samples[::every]
    write = PageText(
        title=title(inputs.source),
        command=f"linkframe run {inputs.source.file.name}",
        about=[
            *_about(inputs, digits.as_text(result.outcome) if "digits" in inputs.also else ""),
            *([] if result.measured is None else [("Measured", result.measured.as_text())]),
        ],
        samples=f"outermost of {inputs.samples} samples, seed {inputs.rng}",
        status=result.marked_status[::every],
    )
    _write(motion, path, point, inputs, write, cloud)


def write_file_page(source: Source, path: Path, point: str | None) -> str:
    """Write the page of a file: at the poses of its job if it has one, else over the range of its drive.

    Parameters
    ----------
    source
        The file.
    path
        Page to write, ``name.html``.
    point
        The point that the page is about; if None, the first to report, or without a job the only likely one.

    Returns
    -------
    str
        The point.

    Raises
    ------
    FrameError
        If several points could be meant, or nothing moves.
    """
    command = f"linkframe page {source.file.name}"
    if "run" in source.data:
        inputs = inputs_of(source)
        chosen = _known(point, inputs.linkage.points) or inputs.points[0]
        text = PageText(title(source), command, about=list(_about(inputs, "")))
        _write(_few(Computed(inputs))[0], path, chosen, inputs, text, None)
        return chosen
    linkage = linkage_of(source, Linkage)
    motion = linkage.move()
    chosen = _known(point, linkage.points) or traced_point(motion) or ""
    if not chosen:
        raise FrameError(f"several points could be meant: give --point, one of {', '.join(linkage.points)}")
    linkage.page(path, chosen, title=title(source), command=command)
    return chosen


def title(source: Source) -> str:
    """Title of the file, or its name."""
    return str(source.data.get("title", source.file.stem))


def _known(point: str | None, points: Collection[str]) -> str | None:
    """The given point, if any; refused if the file does not have it."""
    if point is not None and point not in points:
        raise FrameError(f"--point {point}: the file has {', '.join(points)}")
    return point


def _write(motion: Motion, path: Path, point: str, inputs: RunInputs, text: PageText, cloud: Array | None) -> None:
    worst, notes = worst_case_of(motion, point, inputs.tolerances)
    joints = {name: joint for joint, _, name in inputs.driven}
    first = joints[next(iter(inputs.drives))]
    write_page(motion, path, point, None, worst, replace(text, notes=notes), drive=first, samples=cloud)


def _few(result: Computed) -> tuple[Motion, int]:
    """The motion, of very many poses only every n-th one; and that n."""
    every = -(-result.poses // MOST_POSES)
    if every == 1:
        return result.motion, 1
    linkage, inputs = result.inputs.linkage, result.inputs
    parts = (lambda drive: drive.values), (lambda drive: drive.rate), (lambda drive: drive.acceleration)
    several = {name: len(driven) > 1 for name, driven in linkage.drives.items()}
    numbers = []
    for part in parts:
        found = inputs.numbers(part)
        numbers.append({k: v[::every] if np.ndim(v) > several[k] and len(v) > 1 else v for k, v in found.items()})
    values, rates, gains = numbers
    moved = linkage.move(values, rates=rates, accelerations=gains, branch=inputs.branch, tolerance=inputs.tolerance)
    return moved, every


def _about(inputs: RunInputs, certain: str) -> Iterator[tuple[str, str]]:
    """Headings and texts on the inputs and the certain digits."""
    drawn = f"# {inputs.samples} samples, seed {inputs.rng}\n" if inputs.tolerances else ""
    yield f"Inputs: {inputs.source.file.name}", f"{drawn}{inputs.source.text}"
    yield "Certainty of digits", "\n\n".join([CERTAIN, *([certain] if certain else [])])
