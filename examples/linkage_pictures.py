"""Pictures and ParaView files of the linkages in this folder: links at one pose, the paths of some points.

And ten of them side by side, the picture in README.
"""

import importlib
import sys
from pathlib import Path

import matplotlib.pyplot as plt
from matplotlib.figure import Figure

# Points that leave a trace.
TRACED = {
    "slider_crank": ("B", "C"),
    "six_bar": ("B", "P", "F"),
    "andrews_squeezer": ("E", "G", "H"),
    "five_bar": ("P",),
    "three_rrr": ("P",),
    "scissor_lift": ("L5", "R3"),
    "rssr": ("B", "D"),
    "bennett": ("H1", "H2"),
    "bricard": ("H1", "H2", "H3", "H4"),
    "cardan_shaft": ("I", "T"),
    "delta_robot": ("P",),
    "stewart_platform": ("P",),
    "excavator": ("E",),
}

# Examples that the picture in README shows, and what it calls them.
SHOWN = {
    "slider_crank": "slider-crank",
    "six_bar": "Stephenson III six-bar",
    "andrews_squeezer": "Andrews' squeezer",
    "excavator": "excavator arm",
    "scissor_lift": "scissor lift",
    "three_rrr": "3-RRR robot",
    "bennett": "Bennett's linkage",
    "bricard": "Bricard's linkage",
    "delta_robot": "delta robot",
    "stewart_platform": "Stewart platform",
}
SPATIAL = ("bennett", "bricard", "delta_robot", "stewart_platform")


def show(name, folder):
    """Picture and time series of one example."""
    motion = importlib.import_module(name).motion
    pose = motion.shape[0] // 5
    axes = motion.plot(pose=pose, trace=TRACED[name])
    axes.set_title(name.replace("_", " "), loc="left")
    axes.figure.savefig(folder / f"{name}.png", dpi=120)
    plt.close(axes.figure)
    motion.save(folder / f"{name}.pvd")


def gallery(path):
    """The examples in SHOWN side by side."""
    figure = Figure(figsize=(11.5, 4.8), dpi=100)
    for number, (name, title) in enumerate(SHOWN.items()):
        motion = importlib.import_module(name).motion
        flat = name not in SPATIAL
        left, bottom = number % 5 / 5, 0.5 - number // 5 / 2
        place = (left + 0.01, bottom + 0.01, 0.18, 0.42)
        axes = figure.add_axes(place if flat else (left, bottom - 0.02, 0.2, 0.48), projection=None if flat else "3d")
        motion.plot(axes, pose=motion.shape[0] // 5, trace=TRACED[name], names=False, loads=False)
        if axes.get_legend():
            axes.get_legend().remove()
        if flat:
            axes.set_aspect("equal", adjustable="datalim")
        else:
            limits = axes.get_xlim(), axes.get_ylim(), axes.get_zlim()
            axes.set_box_aspect([high - low for low, high in limits], zoom=1.1)
        axes.set_axis_off()
        figure.text(left + 0.1, bottom + 0.455, title, ha="center", fontsize=10)
    figure.savefig(path, pil_kwargs={"optimize": True})


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "pictures")
    folder.mkdir(parents=True, exist_ok=True)
    for name in TRACED:
        show(name, folder)
        print(f"{folder / name}.png and .pvd")
    gallery(folder / "linkages.png")
