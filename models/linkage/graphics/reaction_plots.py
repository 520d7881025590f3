"""Joint forces and drive forces over the first drive, with matplotlib."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.graphics.style import new_axes, styled
from ....framework.graphics.units import moment_unit
from ...job.force_figures import Over, draw_forces
from ..description.joints import driven_name
from ..poses.coordinates import coordinate_of
from ..poses.kinematics import Kinematics
from .places import rows_of, series_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KINDS = ("joints", "drives")


def plot_reactions(
    motion: Kinematics,
    forces: Mapping[str, Array],
    drives: Mapping[str, Array],
    what: str,
    axes: Axes | None,
    units: tuple[str, str],
) -> Axes:
    """See `Reactions.plot`."""
    row = np.array(series_of(motion, None)[0])
    along = {name: rows_of(motion, force)[row] for name, force in forces.items()}
    pushes = dict(_pushes(motion, drives, row, units))
    return _plot(over_first_drive(motion, row, units[0]), along, pushes, what, axes, units)


def plot_four_bar_reactions(
    theta: Array, forces: Mapping[str, Array], torque: Array, what: str, axes: Axes | None, units: tuple[str, str]
) -> Axes:
    """See `Kinetostatics.plot`; angles and torque (...), forces (..., 3), drawn along their longest batch axis."""
    shape = torque.shape or (1,)
    at = tuple(slice(None) if k == int(np.argmax(shape)) else 0 for k in range(len(shape)))
    along = {name: np.broadcast_to(force, (*shape, 3))[at] for name, force in forces.items()}
    angle, push = (np.broadcast_to(values, shape)[at] for values in (np.degrees(theta), torque))
    over = Over.drive(angle, "A [°]", True)
    return _plot(over, along, {f"A [{moment_unit(units)}]": push}, what, axes, units)


@styled
def _plot(
    over: Over,
    forces: Mapping[str, Array],
    pushes: Mapping[str, Array],
    what: str,
    axes: Axes | None,
    units: tuple[str, str],
) -> Axes:
    """Plot magnitudes of the forces (k, 3 or more), or the forces and moments of the drives (k,), over the poses."""
    if what not in KINDS:
        raise FrameError(f"plot was given what={what!r}: choose one of {', '.join(KINDS)}")
    curves, label = pushes, "drive force or moment"
    if what == "joints":
        curves = {name: np.linalg.norm(force[:, :3], axis=-1) for name, force in forces.items()}
        label = f"joint force [{units[1]}]"
    found: Any = new_axes(4.8, 3.4) if axes is None else axes
    sizes = all(np.nanmin(curve, initial=0.0) >= 0.0 for curve in curves.values())
    draw_forces(found, over, curves, label, from_zero=sizes)
    found.spines[["top", "right"]].set_visible(False)
    return found  # type: ignore[no-any-return]


def _pushes(motion: Kinematics, drives: Mapping[str, Array], row: Any, units: tuple[str, str]) -> Any:
    """Name with unit, and force or moment (k,), of each driven coordinate."""
    for joint, force in drives.items():
        driven = motion.linkage.drives[joint]
        for component, push in zip(driven, rows_of(motion, force)[row].T, strict=True):
            name = driven_name(joint, component, driven)
            yield f"{name} [{moment_unit(units) if component[0] == 'r' else units[1]}]", push


def over_first_drive(motion: Kinematics, row: Any, length: str) -> Over:
    """Values of the first drive at poses, in degrees for an angle, as abscissa; numbers of poses without drives.

    Parameters
    ----------
    motion
        The motion.
    row
        Flat indices of the poses, (k,).
    length
        Unit of lengths.

    Returns
    -------
    Over
        Values (k,), their label, and whether they are angles.
    """
    for joint, components in motion.linkage.drives.items():
        values = rows_of(motion, coordinate_of(motion, motion.linkage.joint(joint)))[row, 0]
        turns = components[0][0] == "r"
        return Over.drive(np.degrees(values) if turns else values, f"{joint} [{'°' if turns else length}]", turns)
    return Over(np.arange(float(len(row))), "pose", False)
