"""The table of the job, with a row for each pose: drives, rigid position, displacement, spread, forces, status."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from ....framework.batch import Array
from ....framework.dofs import FORCES
from ...job.tables import aligned, markdown, separated, with_error, without_rounding
from .optional_tables import columns as further

if TYPE_CHECKING:
    from .result import RunResult

AXES = "xyz"


def as_csv(result: RunResult) -> str:
    """All points and all components at full precision."""
    names, columns = _columns(result)
    for name, values in further(result).items():
        names.append(name)
        columns.append(values)
    numbers = np.column_stack(columns).tolist()
    rows = ([*row, status] for row, status in zip(numbers, result.marked_status.tolist(), strict=True))
    return separated([*names, "status"], rows)


def reactions_csv(result: RunResult) -> str:
    """Force and moment of every joint on its second link, and the force of every drive."""
    found, linkage = result.reactions, result.inputs.linkage
    names, columns = _drives(result)
    for joint in linkage.joints:
        names += [f"{joint}_{component}" for component in FORCES]
        columns += list(np.moveaxis(result.rows(found.force(joint)), -1, 0))
    for joint, driven in linkage.drives.items():
        names += [f"{joint}_drive_{component}" for component in driven]
        columns += list(np.moveaxis(result.rows(found.drive(joint)), -1, 0))
    method = np.broadcast_to(found.method, (result.poses,)).tolist()
    rows = ([*row, how] for row, how in zip(np.column_stack(columns).tolist(), method, strict=True))
    return separated([*names, "method"], rows)


def as_text(result: RunResult, width: int | None = None) -> str:
    """Table of the first point for a terminal of the given width."""
    return aligned(list(_cells(result)), width)


def legend(result: RunResult) -> str:
    """Meaning of the columns of the table, and their units."""
    ways = " ".join(AXES[k] for k in result.shown)
    drives = [f"{name} [{drive.sign}]" for name, drive in result.inputs.drives.items()]
    units = {"r": "N m", "u": "N"}
    pushes = [f"drive {name} [{units[component[0]]}]" for _, component, name in result.inputs.driven]
    spread = "; mean and σ of its samples" if result.spread else ""
    point = result.inputs.points[0]
    others = ", ".join(result.inputs.points[1:])
    text = f" Of {others}: table.csv." if others else ""
    return (
        f"Drives {', '.join(drives)}; position {ways} of {point} [m]; displacement u of {point} by compliance and"
        f" clearance [m]{spread}; {', '.join(pushes)}.{text}"
    )


def as_markdown(result: RunResult) -> str:
    """Table of the first point for the report."""
    heading, *body = _cells(result)
    return markdown(heading, body)


def _drives(result: RunResult) -> tuple[list[str], list[Array]]:
    drives = result.inputs.drives
    names = [f"{name}_{drive.unit}" if drive.unit else name for name, drive in drives.items()]
    return names, [np.broadcast_to(drive.values, (result.poses,)) for drive in drives.values()]


def _greatest_displacement(result: RunResult) -> Array:
    """Greatest displacement of any node of the loaded frame along any axis, (poses,)."""
    moved = np.abs(result.solution.displacements())[..., :3]
    greatest = np.max(moved, axis=(-2, -1), where=np.isfinite(moved), initial=0.0)
    return np.broadcast_to(greatest, (result.poses,))


def _drive_forces(result: RunResult) -> Iterator[Array]:
    """Forces and moments of the drives, (poses,) each, without what is rounding beside those of the joints."""
    found, linkage = result.reactions, result.inputs.linkage
    sizes = np.abs(np.stack([result.rows(found.force(joint)) for joint in linkage.joints])).max(axis=0)
    force, moment = sizes[:, :3].max(axis=-1), sizes[:, 3:].max(axis=-1)
    for joint, driven in linkage.drives.items():
        for component, push in zip(driven, result.rows(found.drive(joint)).T, strict=True):
            turns = component.startswith("r")
            yield without_rounding(push, moment + force * result.size if turns else force + moment / result.size)


def _columns(result: RunResult) -> tuple[list[str], list[Array]]:
    names, columns = _drives(result)
    for point, found in result.accuracy.items():
        parts = {"": found.rigid, "compliance_": found.compliance, "clearance_": found.clearance, "total_": found.total}
        if point in result.spread:
            spread = result.spread[point]
            parts |= {"mu_": found.rigid + spread.mean, "sigma_": spread.std}
        for kind, values in parts.items():
            names += [f"{point}_{kind}{axis}" for axis in AXES]
            columns += list(np.moveaxis(result.rows(values[..., :3]), -1, 0))
    return names, columns


def _cells(result: RunResult) -> Iterator[list[str]]:
    """The heading, then a row for each pose."""
    shown, point = result.shown, result.inputs.points[0]
    heads = list(result.inputs.drives) + [AXES[k] for k in shown] + [f"u_{AXES[k]}" for k in shown]
    columns = _drives(result)[1]
    columns += [result.rows(result.main.rigid)[:, k] for k in shown]
    whole = _greatest_displacement(result)
    columns += [without_rounding(result.rows(result.main.total)[:, k], whole) for k in shown]
    forms = ["g"] * len(result.inputs.drives) + ["z.6f"] * len(shown) + [".3e"] * len(shown)
    errors = [np.full(result.poses, np.nan)] * len(columns)
    if point in result.spread:
        spread = result.spread[point]
        heads += [f"{name}{AXES[k]}" for name in ("mean u_", "σ_") for k in shown]
        columns += [without_rounding(each[:, k], whole) for each in (spread.mean, spread.std) for k in shown]
        errors += [each[:, k] for each in (spread.standard_error, spread.std_standard_error) for k in shown]
        forms += [".2e"] * (2 * len(shown))
    heads += [f"drive {name}" for _, _, name in result.inputs.driven]
    forces = list(_drive_forces(result))
    columns += forces
    forms += [".4g"] * len(forces)
    errors += [np.full(result.poses, np.nan)] * len(forces)
    yield [*heads, "status"]
    numbers = (np.column_stack(each).tolist() for each in (columns, errors))
    for row, uncertainties, status in zip(*numbers, result.marked_status.tolist(), strict=True):
        yield [*(with_error(*each) for each in zip(row, uncertainties, forms, strict=True)), status]
