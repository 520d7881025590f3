"""``report.md`` of the job: inputs and results."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ....framework.batch import Array
from ...job.report import Report
from ...job.tables import drawn_by, markdown, readable
from ..statics.reactions import NONE
from .optional_tables import sections
from .table import as_markdown

if TYPE_CHECKING:
    from ..linkage import Linkage
    from .result import RunResult

TABLE = """\
Position `x`, `y`, `z` of {point} with rigid links and no clearance; `u` its displacement by compliance of links and
joints, and clearance, of the linkage as the file has it; `mean u` and `σ` mean and standard deviation over the samples,
in brackets their standard errors in units of the last digit (all poses share the same draws, so that these go
together); forces or moments of the drives. All points and all parts of the displacement at full precision: `table.csv`;
all joint forces: `reactions.csv`. SI units. *Outside the linear range* marks poses whose displaced shape is out of
balance: there `frame.solve(large=True)` has the numbers."""

PARAVIEW = """\
Open `trajectory.pvd`: one step a pose; time is {time}. {how}"""
BEAMS = """\
Apply *Warp By Vector* with `displacement`, then *Extract Surface* and *Tube*; *Clean to Grid* first merges the twin
nodes of the joints. Poses without a solution have `solved` = 0 and no displacement."""
LINKS = "No link has a beam: the links are drawn as lines between their points, with `velocity` and `acceleration`."


def report(result: RunResult) -> Report:
    """Contents of the job's report."""
    name, source = next(iter(result.inputs.drives)), result.inputs.source
    time = f"the value of drive {name}" if result.increasing else "the number of the pose"
    return Report(
        title=str(source.data.get("title", source.file.stem)),
        summary=list(_summary(result)),
        sections=[
            "## The linkage",
            *_linkage(result),
            "## Table",
            TABLE.format(point=result.inputs.points[0]),
            as_markdown(result),
            *sections(result),
            *(result.measured.section() if result.measured is not None else ()),
        ],
        paraview=PARAVIEW.format(time=time, how=BEAMS if result.has_beams else LINKS),
    )


def _summary(result: RunResult) -> Iterable[str]:
    inputs = result.inputs
    drawn = f" × {inputs.samples} samples{drawn_by(inputs.sampler)}, seed {inputs.rng}" if inputs.tolerances else ""
    yield f"{result.poses} poses{drawn}, from `{inputs.source.file.name}`."
    found = result.marked_status
    statuses = [status for status in dict.fromkeys(found.tolist()) if status != "regular"]
    for status in statuses[:20]:
        at = np.flatnonzero(found == status)
        places = ", ".join(result.where(int(k)) for k in at[:8]) + (" ..." if len(at) > 8 else "")
        yield f"At {places}: {status}."
    if len(statuses) > 20:
        yield f"{len(statuses) - 20} more in `table.csv`."
    methods = sorted(set(np.atleast_1d(result.reactions.method).tolist()) - {NONE})
    yield f"Joint reactions: {', '.join(methods)}." if methods else "No pose has finite joint reactions."
    yield from _contacts(inputs.linkage)
    pose = result.pose
    yield f"Displacement of {inputs.points[0]} at {result.where(pose)}, in mm:"
    parts = {"compliance": result.main.compliance, "clearance": result.main.clearance, "all": result.main.total}
    rows = [[name, *_millimetres(result, values)] for name, values in parts.items()]
    if inputs.points[0] in result.spread:
        spread = result.spread[inputs.points[0]]
        sampled = {
            "mean of samples": (spread.mean, spread.standard_error),
            "σ": (spread.std, spread.std_standard_error),
        }
        for name, both in sampled.items():
            value, error = (_millimetres(result, each) for each in both)
            rows.append([name, *(f"{mean} ± {bound}" for mean, bound in zip(value, error, strict=True))])
    yield markdown(["part", *(f"u_{'xyz'[k]}" for k in result.shown)], rows, left=1)


def _contacts(linkage: Linkage) -> Iterable[str]:
    """Sentences on the contact of journals with clearance: given, or found by equilibrium."""
    with_clearance = [pair for pair in linkage.joints.values() if pair.clearance is not None]
    given = [f"{pair.name} {_degrees(pair.contact)}" for pair in with_clearance if pair.contact is not None]
    free = [pair.name for pair in with_clearance if pair.contact is None]
    if given:
        yield f"Contact angles of the clearances as the file gives them: {', '.join(given)}."
    if free:
        yield f"Contact of the clearances by equilibrium under the load: {', '.join(free)}."


def _degrees(angle: Array) -> str:
    return f"{np.degrees(angle):g}°" if angle.ndim == 0 else "one for each pose"


def _millimetres(result: RunResult, values: Array) -> list[str]:
    at = result.rows(values)[result.pose]
    return [readable(1e3 * float(at[k]), ".4g") for k in result.shown]


def _linkage(result: RunResult) -> Iterable[str]:
    linkage = result.inputs.linkage
    yield str(linkage.mobility(result.inputs.tolerance)).replace("\n", "; ")
    links = [[k.name, ", ".join(k.points), str(len(k.beams) or "rigid")] for k in linkage.links.values()]
    yield markdown(["link", "points", "beams"], links, left=2)
    driven = {name: " ".join(components) for name, components in linkage.drives.items()}
    joints = [
        [pair.name, pair.kind.name, pair.point, f"{pair.first}, {pair.second}", driven.get(pair.name, "")]
        for pair in linkage.joints.values()
    ]
    yield markdown(["joint", "kind", "point", "links", "driven"], joints, left=5)
    if result.inputs.tolerances:
        yield markdown(
            ["tolerance", "distribution", "unit", "of"],
            [
                [name, tolerance.description, tolerance.unit, ", ".join(tolerance.names)]
                for name, tolerance in result.inputs.tolerances.items()
            ],
            left=4,
        )
