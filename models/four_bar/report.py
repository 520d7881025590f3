"""report.md: what went in, what came out, and where the paper differs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import fields
from typing import TYPE_CHECKING

import numpy as np

from ..job.tables import markdown, spent
from . import against_paper, digits, large
from .table import as_markdown

if TYPE_CHECKING:
    from .result import Result

UNITS = {
    **dict.fromkeys(("crank", "coupler", "rocker", "ground", "length_sd", "point", "section"), "m"),
    **dict.fromkeys(("clearance", "clearance_sd"), "m"),
    **dict.fromkeys(("young", "young_sd"), "Pa"),
    **dict.fromkeys(("stiffness", "stiffness_sd"), "N/m, N m/rad"),
    **dict.fromkeys(("contact", "contact_sd", "poses", "histogram_pose"), "deg"),
    **dict.fromkeys(("load", "load_sd"), "N"),
}


TABLE = """\
Position of P: `x`, `y` with rigid links and no clearance; mean `μ` and standard deviation `σ` over the samples, in
metres. `κ` is the condition number (2-norm) of the stiffness matrix as the paper assembles it, `κ scaled` that of the
matrix that is solved, with its diagonal scaled to ones. *Beyond linear* marks poses whose displaced shape is out of
balance, or whose samples spread otherwise at large displacement by a tenth or more, so that the numbers of linear
mechanics do not hold there. Printed values stand under the headings that fit them (see below). Full
precision: `table1.csv`."""

PARAVIEW = """\
Open `trajectory.pvd`: beams and joints, one step a pose, time is the drive angle in degrees. Apply *Warp By Vector*
with `displacement`, then *Extract Surface* and *Tube*; *Clean to Grid* first merges the twin nodes of the joints. It
shows the mean inputs without clearance; singular poses have `solved` = 0 and no displacement."""


def report(result: Result, pictures: Mapping[str, str], notes: Sequence[str], seconds: Mapping[str, float]) -> str:
    """The report in Markdown.

    Parameters
    ----------
    result
        The run.
    pictures
        Caption of each figure by the name of its file.
    notes
        What the reader should know of this run, such as what could not be drawn.
    seconds
        Time that each stage took.

    Returns
    -------
    str
        The text.
    """
    paragraphs = [
        "# Accuracy of a four-bar linkage",
        *_summary(result),
        *notes,
        "## Inputs",
        "SI units, angles in degrees; `sd` is the standard deviation of a normal distribution.",
        _inputs(result),
        "## Table 1",
        TABLE,
        as_markdown(result),
        "### Certain digits",
        digits.EXPLAINED,
        digits.as_markdown(result),
        "### Large displacement",
        large.EXPLAINED,
        large.as_markdown(result),
        "## Figures",
        *(f"![{caption}]({file})\n\n{caption}" for file, caption in pictures.items()),
        "## In ParaView",
        PARAVIEW,
        "## Against the paper",
        *against_paper.points(result),
        "## Time",
        spent(seconds),
    ]
    return "\n\n".join(paragraphs) + "\n"


def _summary(result: Result) -> Iterable[str]:
    yield f"{len(result.degrees)} poses × {result.inputs.samples} samples, seed {result.inputs.rng}."
    for status in sorted(set(result.status[~result.regular])):
        angles = ", ".join(f"{angle:g}°" for angle in result.degrees[result.status == status])
        yield f"At {angles}: {status}."
    study, pose = result.study, result.pose
    yield f"Displacement of P from its rigid position at θ = {result.degrees[pose]:g}°, in mm:"
    parts = {
        "compliance": study.compliance,
        "clearance": study.clearance,
        "geometry": study.geometry,
        "all": study.total,
    }
    yield markdown(
        ["part", "mean of u_x", "mean of u_y", "σ of u_x", "σ of u_y"],
        [
            [name, *(f"{1e3 * value:.4f}" for value in (*part.mean[pose, :2], *part.std[pose, :2]))]
            for name, part in parts.items()
            if name != "geometry" or result.inputs.length_sd
        ],
        left=1,
    )
    off = 1e3 * np.abs(study.clearance_exact.samples - study.clearance.samples)[pose].max()
    yield f"The clearance is taken to first order; the loop closed anew gives P within {off:.4f} mm of it at this pose."


def _inputs(result: Result) -> str:
    given = {field.name: getattr(result.inputs, field.name) for field in fields(result.inputs)}
    return markdown(
        ["input", "value", "unit"],
        [
            [name.replace("_", " ").replace("nan ", "NaN "), _text(value), UNITS.get(name, "")]
            for name, value in given.items()
            if value is not None
        ],
        left=3,
    )


def _text(value: object) -> str:
    if isinstance(value, tuple):
        return " ".join(map(_text, value))
    return f"{value:g}" if isinstance(value, float) else str(value)
