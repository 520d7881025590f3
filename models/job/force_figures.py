"""Joint forces and drive forces over a drive, of any linkage."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...framework.batch import Array
from ...framework.graphics.canvas import few_ticks
from ...framework.graphics.curves import draw_curves, mark_turns
from ...framework.graphics.style import figure, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class Over(NamedTuple):
    """Abscissa of force curves: values (k,), their name with unit, and whether they are angles in degrees."""

    values: Array
    name: str
    turns: bool

    @classmethod
    def drive(cls, values: Array, name: str, turns: bool) -> Over:
        """Values of a drive, or the numbers of its poses if its values do not increase."""
        if np.all(np.diff(values) > 0.0):
            return cls(values, name, turns)
        return cls(np.arange(float(len(values))), "pose", False)


_PUSHES = {"N": "drive force [N]", "N m": "drive torque [N m]"}


@styled
def draw_reactions(over: Over, forces: Mapping[str, Array], pushes: Mapping[str, tuple[str, Array]]) -> Figure:
    """Draw the magnitudes of joint forces on the left, and forces or moments of drives on the right.

    Parameters
    ----------
    over
        Abscissa of the curves.
    forces
        Magnitudes by joint, newtons, (k,) each. The largest are named, the others are grey; equal ones share a curve.
    pushes
        By drive: "N" or "N m", and its forces or torques, (k,).

    Returns
    -------
    Figure
        The figure with both panels.
    """
    drawn_on, (left, right) = figure(7.6, 3.4, ratios=(1.0, 1.0))
    draw_forces(left, over, forces, "joint force [N]", from_zero=True)
    units = {unit for unit, _ in pushes.values()}
    alike = len(units) == 1
    curves = {drive if alike else f"{drive} [{unit}]": values for drive, (unit, values) in pushes.items()}
    draw_forces(right, over, curves, _PUSHES[units.pop()] if alike else "drive force or torque", from_zero=False)
    return drawn_on


def draw_forces(axes: Any, over: Over, curves: Mapping[str, Array], label: str, *, from_zero: bool) -> None:
    """Draw curves of forces on axes of matplotlib, or say that no pose has any.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    over
        Abscissa of the curves.
    curves
        Values by name, (k,) each.
    label
        Label of the ordinate, with its unit.
    from_zero
        Whether the axis of forces starts at zero.
    """
    if not any(np.isfinite(values).any() for values in curves.values()):
        axes.set_title(f"no pose has a finite {label.partition(' [')[0]}", loc="left")
        axes.set_axis_off()
        return
    draw_curves(axes, over.values, curves)
    axes.set(xlabel=over.name, ylabel=label)
    axes.legend(loc="best", fontsize=7.0, frameon=False)
    few_ticks(axes)
    if over.turns:
        mark_turns(axes, over.values)
    if from_zero:
        axes.set_ylim(bottom=0.0)
