"""The symmetric four-bar of the accuracy paper: how far a force on its coupler bends it, at every pose.

             P ↑ F
      B o----+----o D        the drive is clamped at A; at 0° and 180° coupler and
       /         /           rocker lie in line and the linkage can move all the same:
    A #- - - - -o E          there the answer is a status, and no number

`python four_bar.py` draws it, its displacements magnified, into four_bar.png.
"""

import warnings
from pathlib import Path

import numpy as np
from linkframe.framework import MechanismWarning
from linkframe.models import FourBar

theta = np.radians(np.arange(0.0, 361.0, 2.0))
motion = FourBar(crank=0.1, coupler=0.2, rocker=0.1, ground=0.2, point=(0.1, 0.0)).move(theta)
frame = motion.frame()
frame.load("P", fy=100.0)
solution = frame.solve()

with warnings.catch_warnings():
    warnings.simplefilter("ignore", MechanismWarning)  # the two change points are meant
    compliance = np.linalg.norm(solution.displacement("P")[:, :3], axis=-1)
singular = np.degrees(theta[motion.singular])


def draw(path: Path, magnify: float = 400.0) -> None:
    """Draw the linkage at 60°, the path of P, and the path under load with its displacement magnified."""
    from matplotlib.figure import Figure

    ink, sky, orange = "#222222", "#9cc3e6", "#d55e00"
    figure = Figure(figsize=(7.2, 3.6), dpi=110, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.4, 1.0))
    pose = 30
    moved = motion.position("P") + magnify * solution.displacement("P")[:, :3]
    left.plot(*(1e3 * motion.position("P")[:, :2].T), color=ink, lw=1.0, label="path of P")
    left.plot(*(1e3 * moved[:, :2].T), color=orange, lw=1.4, label=f"under 100 N, × {magnify:g}")
    for level, link in enumerate(("AB", "ED", "BPD"), start=3):
        line = 1e3 * np.array([motion.position(name)[pose, :2] for name in link])
        left.plot(*line.T, color=ink, lw=8, solid_capstyle="round", zorder=level)
        left.plot(*line.T, color=sky, lw=6, solid_capstyle="round", zorder=level)
    for name in "ABPDE":
        spot = 1e3 * motion.position(name)[pose, :2]
        left.plot(
            *spot, "s" if name == "A" else "o", ms=6, mec=ink, mfc={"A": ink, "P": orange}.get(name, "white"), zorder=9
        )
        left.annotate(name, spot, (0, 9), textcoords="offset points", ha="center", fontsize=10)
    left.set_aspect("equal")
    left.set(xlabel="x [mm]", ylabel="y [mm]")
    left.legend(loc="lower right", fontsize=8, frameon=False)
    right.semilogy(np.degrees(theta), 1e6 * compliance, color=orange)
    for angle in singular:
        right.axvline(angle, color=ink, lw=0.8, ls=":")
    right.annotate(
        "singular",
        (180, 0.97),
        (3, 0),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
        fontsize=8,
        va="top",
    )
    right.set(xlabel="drive angle θ [°]", ylabel="displacement of P [µm]", xticks=range(0, 361, 90))
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    figure.savefig(path)


if __name__ == "__main__":
    draw(Path(__file__).with_suffix(".png"))
    print(f"singular at {', '.join(f'{angle:g}°' for angle in singular)}")
    print(f"compliance from {1e6 * np.nanmin(compliance):.2f} to {1e6 * np.nanmax(compliance):.0f} µm")
