"""Curves over a drive, those that coincide as one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from ..batch import Array
from .style import COLOURS, GREY, INK, entry

# Curves that differ by less than this share of their greatest value coincide.
ALIKE = 1e-9
# What tells curves apart where colours do not: in print, in grey.
DASHES: tuple[Any, ...] = ("-", (0, (5, 2)), (0, (1.5, 1.5)), (0, (6, 2, 1.5, 2)))


def together(curves: Mapping[str, Array]) -> list[tuple[list[str], Array]]:
    """Curves (k,) with the names of all that coincide with them, in the order given.

    Parameters
    ----------
    curves
        Values by name, (k,) each; NaN is the same as NaN.
    """
    found: list[tuple[list[str], Array]] = []
    for name, curve in curves.items():
        size = float(np.abs(curve).max(initial=0.0, where=np.isfinite(curve)))
        same = [names for names, other in found if np.allclose(curve, other, ALIKE, ALIKE * size, equal_nan=True)]
        if same:
            same[0].append(name)
        else:
            found.append(([name], curve))
    return found


def draw_curves(axes: Any, x: Array, curves: Mapping[str, Array]) -> None:
    """Draw curves, the greatest in colour with their names, the others grey; equal ones share a line and a name.

    Parameters
    ----------
    axes
        Where.
    x
        Where their values are, (k,).
    curves
        Values by name, (k,) each.
    """
    style: Any = {"marker": "o", "ms": 4} if len(x) == 1 else {}
    groups = together(curves)
    if any(np.any(curve < 0.0) for _, curve in groups) and any(np.any(curve > 0.0) for _, curve in groups):
        axes.axhline(0.0, color=INK, lw=0.5, zorder=0.5)
    size = [float(np.abs(curve).max(initial=0.0, where=np.isfinite(curve))) for _, curve in groups]
    named = sorted(range(len(groups)), key=lambda k: -size[k])[: len(COLOURS)]
    for k in set(range(len(groups))) - set(named):
        axes.plot(x, groups[k][1], color=GREY, lw=0.7, alpha=0.6, **style)
    for number, k in enumerate(sorted(named)):
        names, curve = groups[k]
        dashes = DASHES[number % len(DASHES)]
        axes.plot(x, curve, color=COLOURS[number], lw=1.4, ls=dashes, label=entry(", ".join(names)), **style)


def mark_turns(axes: Any, degrees: Array) -> None:
    """Number an axis of angles in steps that divide a turn.

    Parameters
    ----------
    axes
        Whose x axis is one of angles.
    degrees
        The angles, (k,).
    """
    from matplotlib.ticker import MultipleLocator

    span = float(np.ptp(degrees)) if len(degrees) else 0.0
    step = next((step for step in (1.0, 5.0, 10.0, 15.0, 30.0, 45.0, 90.0) if span / step <= 6.0), 360.0)
    if 5.0 <= span <= 720.0:
        axes.xaxis.set_major_locator(MultipleLocator(step if span <= 540.0 else 180.0))
