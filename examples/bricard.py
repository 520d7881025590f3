r"""Bricard's linkage with three-fold symmetry: six hinges, each square to the next, that turn inside out for ever.

All six links have the length a; the axes at the ends of a link are at +90° and −90° by turns. The angles are θ and φ by
turns, with (Y. Chen, Z. You and T. Tarnai, Threefold-symmetric Bricard linkages for deployable structures, Int. J.
Solids and Structures 42 (2005) 2287, with their α at 90°)

        cos θ + cos φ + cos θ cos φ = 0

The loop has six equations for five unknown angles: mobility 0 by the Grübler-Kutzbach count, actual mobility 1, one
redundant constraint.
"""

import numpy as np
from linkframe.models import Linkage
from scipy.spatial.transform import Rotation

LENGTH, START = 1.0, np.radians(90.0)


def other(theta):
    """The angle at the next hinge, between 0 and 180°."""
    return np.arccos(-np.cos(theta) / (1.0 + np.cos(theta)))


angles = (START, other(START)) * 3
place, turn = np.zeros(3), Rotation.identity()
linkage, axes = Linkage(), []
for k, angle in enumerate(angles):  # turn about the hinge, go along the link, lean to the next hinge
    linkage.point(f"H{k}", place)
    axes.append(turn.apply((0.0, 0.0, 1.0)))
    turn = turn * Rotation.from_euler("z", angle)
    place = place + turn.apply((LENGTH, 0.0, 0.0))
    turn = turn * Rotation.from_euler("x", (-1) ** k * np.pi / 2)

names = ("ground", *(f"link {k}" for k in range(5)), "ground")
for k in range(5):
    linkage.link(names[k + 1], f"H{k}", f"H{k + 1}")
for k in range(6):
    linkage.revolute(f"H{k}", names[k], names[k + 1], axis=axes[k], reference=angles[k], drive=k == 0)

theta = np.radians(np.linspace(62.0, 118.0, 57))
motion = linkage.move(H0=theta)
turns = np.stack([motion.coordinate(f"H{k}")[:, 0] for k in range(6)])
mobility = linkage.mobility()

if __name__ == "__main__":
    print(mobility)
    print(f"off the closed form by {np.abs(turns[1::2] - other(theta)).max():.1e} rad")
