r"""Excavator arm: boom, stick and bucket, each turned by a hydraulic cylinder.

           H===\   3         Cylinder 1 (F G) turns the boom about O, cylinder 2 (H I) the stick about S:
    G  .-´`-.   I.==.         a triangle each, so that the cosine law gives the angle. Cylinder 3 (J K) turns
  //.-´      `-. S`-.`==.     the rocker R K; the link K L and the bucket's T L close a four-bar with it.
1//´            `-.  `-. K
O#                    R`o-o L      E is the bucket's edge. Lengths are about those of a digger of 20 tonnes.
  F                     T o
                        bucket E
"""

import numpy as np
from linkframe.models import Linkage

POINTS = {
    **{"O": (0.0, 0.0), "F": (0.55, -0.4), "G": (2.4, 1.7), "H": (2.8, 2.5), "S": (5.2, 1.5)},  # on machine and boom
    **{"I": (5.1, 2.3), "J": (5.65, 1.7), "R": (6.6, -0.7), "T": (6.7, -1.1)},  # on the stick
    **{"K": (7.1, -0.55), "L": (7.15, -1.05), "E": (7.3, -2.5)},  # on rocker and bucket
}
SOIL = 50e3
CYLINDERS = {"boom cylinder": "FG", "stick cylinder": "HI", "bucket cylinder": "JK"}


def length(ends):
    """Distance of two points as drawn."""
    return np.linalg.norm(np.subtract(POINTS[ends[1]], POINTS[ends[0]]))


linkage = Linkage(POINTS)
linkage.link("boom", "O", "G", "H", "S")
linkage.link("stick", "S", "I", "J", "R", "T")
linkage.link("rocker", "R", "K")
linkage.link("link", "K", "L")
linkage.link("bucket", "T", "L", "E")
for name, (foot, head) in CYLINDERS.items():
    barrel = {"F": "ground", "H": "boom", "J": "stick"}[foot]
    moved = {"G": "boom", "I": "stick", "K": "rocker"}[head]
    axis = (*np.subtract(POINTS[head], POINTS[foot]), 0.0)
    linkage.link(f"{name}, barrel", foot, head)
    linkage.link(f"{name}, rod", head)
    linkage.revolute(foot, barrel, f"{name}, barrel")
    linkage.revolute(head, moved, f"{name}, rod")
    linkage.prismatic(
        head, f"{name}, barrel", f"{name}, rod", axis=axis, drive=True, reference=length(foot + head), name=name
    )
linkage.revolute("O", "ground", "boom")
linkage.revolute("S", "boom", "stick")
linkage.revolute("R", "stick", "rocker")
linkage.revolute("K", "rocker", "link", name="rocker end")
linkage.revolute("L", "link", "bucket")
linkage.revolute("T", "stick", "bucket")

linkage.load("E", fx=SOIL, link="bucket")  # the soil resists

# Lower the boom, pull the stick in, curl the bucket, lift.
s = np.linspace(0.0, 1.0, 61)
stroke = {
    "boom cylinder": length("FG") - 0.5 * np.sin(np.pi * s),
    "stick cylinder": length("HI") + 0.6 * s,
    "bucket cylinder": length("JK") + 0.35 * np.clip(2.0 * s - 0.8, 0.0, 1.0),
}
motion = linkage.move(stroke)
edge = motion.position("E")
thrust = {name: motion.reactions().drive(name)[:, 0] for name in CYLINDERS}
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    for name, force in thrust.items():
        print(f"{name} from {1e-3 * force.min():.0f} to {1e-3 * force.max():.0f} kN")
    print(
        f"digs {-edge[:, 1].min():.3f} m deep, from {edge[:, 0].max():.3f} to {edge[:, 0].min():.3f} m from its pivot"
    )
