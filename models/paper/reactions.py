"""Reactions in the joints and torque of the drive at every pose, by the paper's Eq. (4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..four_bar.kinetostatics import REACTIONS
from ..job import force_figures
from ..job.tables import markdown, readable, separated, without_rounding

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .result import Result

Array = NDArray[np.float64]

COMPONENTS = tuple(f"{joint}_f{axis}_N" for joint in REACTIONS for axis in "xy")
# Relative difference below which forces count as equal.
ALIKE = 1e-9
# Largest number of poses that are named individually.
MOST_NAMED = 6
COLUMNS = ("theta_deg", *COMPONENTS, "drive_torque_Nm", "status")
EXPLAINED = """\
Forces in the joints, in newtons, and the torque of the drive, in newton metres, by Eq. (4): the rigid linkage without
clearance in equilibrium at rest under the mean load (the drive is clamped, so that there are no inertia forces). A and
B: on the crank, by ground and coupler. D: on the coupler, by the rocker. E: on the rocker, by the ground. The torque is
the drive's on the crank, positive about z. Full precision: `reactions.csv`."""


def as_csv(result: Result) -> str:
    """Table of all reaction components at full precision; empty where no finite forces hold the linkage."""
    numbers = np.column_stack([result.degrees, result.forces]).tolist()
    rows = ([*row, status] for row, status in zip(numbers, result.status.tolist(), strict=True))
    return separated(COLUMNS, list(rows))


def as_markdown(result: Result) -> str:
    """The reactions as a table for the report."""
    heading = ["θ", *(f"{joint}{axis}" for joint in REACTIONS for axis in "xy"), "drive torque", "status"]
    shown = _rounded(result.forces)
    return markdown(
        heading,
        [
            [f"{angle:g}", *(readable(value, "z.2f") for value in row[:-1]), readable(row[-1], "z.4f"), str(status)]
            for angle, row, status in zip(result.degrees, shown.tolist(), result.status, strict=True)
        ],
    )


def summary(result: Result) -> str:
    """Sentence with the largest joint force and drive torque."""
    sizes, torque = _sizes(result.forces), np.abs(result.forces[:, 8])
    if not np.isfinite(torque).any():
        return "No pose has finite reactions."
    force, push = float(np.nanmax(sizes)), float(np.nanmax(torque))
    poses, joints = np.nonzero(sizes >= (1.0 - ALIKE) * force)
    return (
        f"Reactions of the rigid linkage under the mean load: the greatest joint force is {force:.4g} N, in"
        f" {', '.join(REACTIONS[joint] for joint in np.unique(joints))} at {_angles(result, np.unique(poses))}, the"
        f" greatest drive torque {push:.4g} N m, at {_angles(result, np.flatnonzero(torque >= (1.0 - ALIKE) * push))};"
        " all of them are in reactions.csv."
    )


def _angles(result: Result, poses: NDArray[np.intp]) -> str:
    named = ", ".join(f"{angle:g}°" for angle in result.degrees[poses[:MOST_NAMED]])
    return named + (" ..." if len(poses) > MOST_NAMED else "")


def draw(result: Result) -> Figure:
    """Plot the magnitude of every joint's force, and the torque of the drive, over the drive angle."""
    sizes = dict(zip(REACTIONS, _sizes(result.forces).T, strict=True))
    over = force_figures.Over(result.degrees, "θ [°]", True)
    return force_figures.draw_reactions(over, sizes, {"A": ("N m", result.forces[:, 8])})


def _sizes(forces: Array) -> Array:
    """Magnitude of the force in each joint, (poses, joints)."""
    return np.asarray(np.hypot(forces[:, 0:8:2], forces[:, 1:8:2]))


def _rounded(forces: Array) -> Array:
    """Forces and torque, set to zero where they are rounding compared with the largest joint force at the pose."""
    return without_rounding(forces, _sizes(forces).max(axis=1, keepdims=True))
