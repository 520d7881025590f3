"""Pictures and ParaView files of the linkages in this folder: links at one pose, the paths of some points."""

import importlib
import sys
from pathlib import Path

from linkframe.models.linkage.job.drawing import draw_mechanism

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


def show(name, folder):
    """Picture and time series of one example."""
    motion = importlib.import_module(name).motion
    pose = motion.shape[0] // 5
    draw_mechanism(motion, pose, TRACED[name], name.replace("_", " ")).savefig(folder / f"{name}.png", dpi=120)
    motion.save(folder / f"{name}.pvd")


if __name__ == "__main__":
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "pictures")
    folder.mkdir(parents=True, exist_ok=True)
    for name in TRACED:
        show(name, folder)
        print(f"{folder / name}.png and .pvd")
