"""``report.md`` of the job: inputs, results, and differences from the paper."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..job import digits, large_table
from ..job.report import Report
from ..job.tables import drawn_by, markdown
from . import against_paper, reactions
from .readings import run_std
from .table import about_errors, as_markdown

if TYPE_CHECKING:
    from ..spread import Spread
    from .compared_choices import ComparedChoices
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
matrix that is solved, scaled node by node. *Outside the linear range* marks poses whose displaced shape
is out of balance, or whose samples spread otherwise at large displacement by a tenth or more, so that the numbers of
linear mechanics do not hold there. Printed values stand under the headings that fit them (see below), `μ_x` measured
from A like all x. Full precision: `table1.csv`."""

PARAVIEW = """\
Open `trajectory.pvd`: beams and joints, one step a pose, time is the drive angle in degrees. Apply *Warp By Vector*
with `displacement`, then *Extract Surface* and *Tube*; *Clean to Grid* first merges the twin nodes of the joints. It
shows the mean inputs without clearance; singular poses have `solved` = 0 and no displacement."""


def report(result: Result, compared: ComparedChoices | None = None) -> Report:
    """Contents of the job's report; effects of the choices are computed if they are not known already."""
    return Report(
        title="Accuracy of a four-bar linkage",
        summary=list(_summary(result)),
        sections=[
            "## Inputs",
            "SI units, angles in degrees; `sd` is the standard deviation of a normal distribution.",
            _inputs(result),
            "## Table 1",
            TABLE,
            about_errors(result),
            as_markdown(result),
            *digits.section(result),
            *large_table.section(result, "table1.csv"),
            *(result.measured.section() if result.measured is not None else ()),
            "## Reactions and drive torque",
            reactions.EXPLAINED,
            reactions.as_markdown(result),
        ],
        paraview=PARAVIEW,
        more=["## Against the paper", *against_paper.points(result, compared)],
    )


def _summary(result: Result) -> Iterable[str]:
    drawn = f"{result.inputs.samples} samples{drawn_by(result.inputs.sampler)}"
    yield f"{len(result.degrees)} poses × {drawn}, seed {result.inputs.rng}."
    yield from _irregular(result)
    study, pose, entry = result.study, result.pose, result.entry
    yield f"Displacement of P from its rigid position at θ = {result.degrees[pose]:g}°, in mm, with standard errors:"
    parts = {
        "compliance": study.compliance,
        "clearance": study.clearance,
        "geometry": study.geometry,
        "all": study.total,
    }
    rows = [
        [name, *(f"{1e3 * value:.4f} ± {1e3 * error:.4f}" for value, error in _statistics(part, entry))]
        for name, part in parts.items()
        if name != "geometry" or result.inputs.varies_geometry
    ]
    population = run_std(result.inputs, result.motion)
    if population is not None:
        rows.insert(2, ["clearance, whole population", "", "", *(f"{1e3 * std:.4f}" for std in population[entry])])
    yield markdown(["part", "mean of u_x", "mean of u_y", "σ of u_x", "σ of u_y"], rows, left=1)
    off = 1e3 * np.linalg.norm(study.clearance_exact.samples[entry] - study.clearance.samples[entry], axis=-1).max()
    yield f"The clearance is taken to first order; the loop closed anew gives P within {off:.4f} mm of it at this pose."
    yield reactions.summary(result)


def _irregular(result: Result) -> Iterable[str]:
    """Sentences on poses without statistics, with the reason."""
    text = np.where(result.assembled, result.status, "not assembled: coupler and rocker do not reach each other")
    for status in sorted(set(text[~result.regular])):
        angles = ", ".join(f"{angle:g}°" for angle in result.degrees[text == status])
        yield f"At {angles}: {status}."


def _statistics(part: Spread, entry: int) -> Iterable[tuple[float, float]]:
    """Mean and standard deviation of u_x and u_y at a pose, each with its standard error."""
    for value, error in ((part.mean, part.standard_error), (part.std, part.std_standard_error)):
        yield from zip(value[entry, :2].tolist(), error[entry, :2].tolist(), strict=True)


def _inputs(result: Result) -> str:
    given = result.inputs.in_words("g")
    rows = [[name.replace("_", " ").replace("nan ", "NaN "), text, UNITS.get(name, "")] for name, text in given.items()]
    return markdown(["input", "value", "unit"], rows, left=3)
