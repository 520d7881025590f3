"""A bar that is free to swing about one end and is pulled along itself, in many directions in space."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Beam, Circle, Joint, Material, Spring
from linkframe.framework import Frame
from scipy.spatial.transform import Rotation

INF = np.inf
LENGTH, FORCE, E, DIAMETER = 0.4, 100.0, 210e9, 0.02
ROD = Beam(Circle(diameter=DIAMETER), Material(E=E, nu=0.3))
GROWN = FORCE * LENGTH / (E * np.pi * DIAMETER**2 / 4.0)
KINDS = ["support", "ball", "hinge", "release", "bar", "spring"]
# Turns about the axes, to their diagonals, hardly at all, and as they come.
TILTS = [1e-16, 1e-9]
ROTATIONS = [
    *Rotation.from_euler("xyz", [(0, 0, 0), (0, 90, 0), (0, 0, 90), (45, 0, 0), (0, 45, 0), (0, 0, 45)], degrees=True),
    *Rotation.from_euler("xyz", [(0, 0, 180), (30, 45, 60), (90, 45, 0), (0, 35.26, 45)], degrees=True),
    *Rotation.from_rotvec([[0.0, 0.0, tilt] for tilt in TILTS] + [[tilt, 0.7 * tilt, -tilt] for tilt in TILTS]),
    *Rotation.random(3, rng=5),
]


def pulled(kind: str, turn: Rotation, force: float = FORCE) -> Frame:
    """The bar, its free end turned with the whole from the x axis; a force along it."""
    along = turn.apply([1.0, 0.0, 0.0])
    frame = Frame()
    frame.node("A", np.zeros(3))
    frame.node("B", LENGTH * along)
    if kind in ("ball", "hinge"):
        frame.node("O", np.zeros(3))
        free = (0.0, 0.0, 0.0) if kind == "ball" else (INF, INF, 0.0)
        frame.add("pin", Joint((INF,) * 3 + free, axes=turn.as_matrix()), "O", "A")
        frame.fix("O")
    elif kind == "support":
        frame.fix("A", "ux", "uy", "uz")
    else:
        frame.fix("A")
    ends = {"release": ("start",), "bar": ("start", "end")}.get(kind, ())
    loose = [f"{end} {turned}" for end in ends for turned in ("ry", "rz")]
    member = Spring(FORCE / GROWN) if kind == "spring" else Beam(ROD.section, ROD.material, release=tuple(loose))
    frame.add("AB", member, "A", "B")
    frame.load("B", **dict(zip(("fx", "fy", "fz"), force * along, strict=True)))
    return frame
