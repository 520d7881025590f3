"""The table and the picture of a stress test."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import asdict, fields
from pathlib import Path

import numpy as np

from .axes import AXES, UNITS
from .measure import Measured

ROUNDING = 2.0**-53


def write(rows: Sequence[Measured], out: Path) -> None:
    """``stress.csv`` with everything, ``stress.md`` with the displacements, ``stress.png``.

    Parameters
    ----------
    rows
        What was measured.
    out
        Folder for the files.
    """
    out.mkdir(parents=True, exist_ok=True)
    with (out / "stress.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, [field.name for field in fields(Measured)], lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(row) for row in rows)
    (out / "stress.md").write_text(table(rows), encoding="utf-8")
    picture(rows, out / "stress.png")


def table(rows: Sequence[Measured]) -> str:
    """By axis and place: true error and stated bound of displacements, relative to the greatest of their node."""
    lines = ["| axis | place | error | bound | refined: error | bound | numbers beyond their bound | status |"]
    lines.append("| :-- | --: | --: | --: | --: | --: | --: | :-- |")
    units = list(UNITS)
    for row in rows:
        if row.kind == "displacement":
            place = units[int(row.x)] if row.axis == "units" else f"{row.x:g}"
            numbers = [f"{value:.1e}" for value in (row.error, row.bound, row.refined_error, row.refined_bound)]
            lines.append(f"| {row.axis} | {place} | {' | '.join(numbers)} | {row.lies} | {row.status} |")
    return "\n".join(lines) + "\n"


def picture(rows: Sequence[Measured], path: Path) -> None:
    """True error and stated bound of displacements over each axis."""
    from matplotlib.figure import Figure

    names = list(dict.fromkeys(row.axis for row in rows))
    labels = {axis.name: axis.label for axis in AXES}
    columns = 3
    figure = Figure(figsize=(13, 3.2 * -(-len(names) // columns)), layout="constrained")
    panels = figure.subplots(-(-len(names) // columns), columns, squeeze=False, sharey=True).ravel()
    for name, panel in zip(names, panels, strict=False):
        found = [row for row in rows if row.axis == name and row.kind == "displacement"]
        x = np.array([row.x for row in found])
        if name == "load":  # no figure has so many decades
            x = np.log10(x)
        if np.isinf(x).any():
            x = np.where(np.isinf(x), 100.0 * x[np.isfinite(x)].max(), x)
        error, bound, better, left = (
            np.array([getattr(row, key) for row in found])
            for key in ("error", "bound", "refined_error", "refined_bound")
        )
        panel.loglog(x, np.maximum(error, 1e-18), "o-", color="tab:blue", ms=4, label="true error")
        panel.loglog(x, bound, "_-", color="tab:red", ms=8, label="stated bound")
        panel.loglog(x, np.maximum(better, 1e-18), "o", color="tab:blue", mfc="none", ms=4, label="refined: true error")
        panel.loglog(x, left, "--", color="tab:red", lw=1, label="refined: stated bound")
        none = np.isinf(bound)
        panel.plot(x[none], np.full(none.sum(), 1.0), "x", color="black", ms=7, label="no number given")
        if name in ("units", "closed loop", "load"):
            panel.set_xscale("linear")
        panel.axhline(ROUNDING, color="grey", lw=0.8, ls=":")
        panel.set_title(name, fontsize=10)
        panel.set_xlabel(labels.get(name, "links"), fontsize=9)
        panel.set_ylim(1e-18, 10.0)
        panel.tick_params(labelsize=8)
    for panel in panels[len(names) :]:
        panel.set_axis_off()
    for panel in panels[: len(names) : columns]:
        panel.set_ylabel("relative to the greatest\ndisplacement of a node", fontsize=9)
    handles = {label: handle for p in panels for handle, label in zip(*p.get_legend_handles_labels(), strict=True)}
    figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=5, fontsize=9)
    figure.savefig(path, dpi=110)
