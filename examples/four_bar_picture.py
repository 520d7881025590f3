"""The picture in README: the four-bar of four_bar.py bent by its load, and how far P deflects at every pose."""

from pathlib import Path

import four_bar
import numpy as np


def draw(path: Path, pose: int = 30, magnify: float = 150.0) -> None:
    """Draw the linkage at one pose, its displacements magnified, beside the displacement of P at every pose."""
    from matplotlib.collections import LineCollection
    from matplotlib.figure import Figure

    ink, grey, orange = "#222222", "#9a9a9a", "#d55e00"
    figure = Figure(figsize=(8.0, 3.3), dpi=120, layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(1.35, 1.0))

    share = np.linspace(0.0, 1.0, 41)
    lines, stresses = [], []
    for name, member in four_bar.frame.members.items():
        ends = [four_bar.frame.position(node)[pose, :2] for node in (member.start, member.end)]
        line = ends[0] + share[:, None] * (ends[1] - ends[0])
        at = share * np.linalg.norm(ends[1] - ends[0])
        moved = 1e3 * (line + magnify * four_bar.solution.displacement_along(name, at)[pose, :, :2])
        left.plot(*(1e3 * line.T), color=grey, lw=1.0, ls=(0, (5, 3)))
        lines.extend(np.stack([moved[:-1], moved[1:]], axis=1))
        stresses.extend(1e-6 * four_bar.solution.stress(name, at)[pose, :-1, 2])
    bars = LineCollection(lines, array=np.array(stresses), cmap="viridis", lw=6.5, capstyle="round", zorder=2)
    figure.colorbar(left.add_collection(bars), ax=left, label="von Mises stress [MPa]", shrink=0.85)
    nodes = {"A": ("A", (-14, -4)), "B": ("B.crank", (-4, 9)), "P": ("P", (0, -17)), "D": ("D.rocker", (6, 9))}
    for name, (node, shift) in (nodes | {"E": ("E", (14, -4))}).items():
        moved = magnify * four_bar.solution.displacement(node)[pose, :2]
        spot = 1e3 * (four_bar.motion.position(name)[pose, :2] + moved)
        colour = {"A": ink, "P": orange}.get(name, "white")
        left.plot(*spot, "s" if name == "A" else "o", ms=6, mec=ink, mfc=colour, zorder=3)
        left.annotate(name, spot, shift, textcoords="offset points", ha="center")
        if name == "P":
            up, arrow = np.array([0.0, 45.0]), {"arrowstyle": "-|>", "color": orange, "lw": 2.0}
            left.annotate("", spot + up, spot + 0.15 * up, arrowprops=arrow)
            left.annotate("100 N", spot + 0.85 * up, (7, 0), textcoords="offset points", color=orange)
            left.plot(*(spot + 1.1 * up), alpha=0.0)
    left.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]", title=f"displacements × {magnify:g}")
    left.margins(0.1)

    right.plot(np.degrees(four_bar.theta), 1e6 * four_bar.compliance, color=orange, lw=1.6)
    ticks = {angle: f"{angle}°" for angle in range(0, 361, 90)}
    for angle in four_bar.singular:
        right.axvline(angle, color=ink, lw=0.8, ls=":")
        ticks[round(angle)] += "\nsingular"
    right.set(xlim=(-12, 372), ylim=(0, 300), xlabel="drive angle θ", ylabel="µm", title="displacement of P")
    right.set_xticks(list(ticks), list(ticks.values()))
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
        axes.title.set_fontsize(10)
    figure.savefig(path)


if __name__ == "__main__":
    draw(Path(__file__).with_name("four_bar.png"))
