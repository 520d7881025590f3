"""The paper's four-bar at one pose, as a structure."""

from __future__ import annotations

from math import cos, radians, sin

from .structure import Member, Spring, Structure, Vector

LENGTH = 0.1
IN_PLANE, OUT_OF_PLANE = 0.0127, 0.00635
E, NU = 2e11, 0.3
G = E / (2 * (1 + NU))
A = IN_PLANE * OUT_OF_PLANE
IZ = OUT_OF_PLANE * IN_PLANE**3 / 12
IY = IN_PLANE * OUT_OF_PLANE**3 / 12
# Any torsion constant does, as long as both sides have the same float.
J = 0.229 * IN_PLANE * OUT_OF_PLANE**3
STIFFNESS = (2e11, 2e11, 2e11, 2e11, 2e11, 0.0)
CLAMPED = dict.fromkeys(("ux", "uy", "uz", "rx", "ry", "rz"), 0.0)
ENDS = {
    "crank": ("A", "B.crank"),
    "coupler.1": ("B.coupler", "P"),
    "coupler.2": ("P", "D.coupler"),
    "rocker": ("D.rocker", "E.rocker"),
}
JOINTS = {"B": ("B.crank", "B.coupler"), "D": ("D.coupler", "D.rocker"), "E": ("E.rocker", "E")}


def coordinates(theta: float) -> dict[str, Vector]:
    """Float coordinates of the nodes at crank angle `theta` in degrees."""
    x, y = LENGTH * cos(radians(theta)), LENGTH * sin(radians(theta))
    b, d, e = (x, y, 0.0), (2 * LENGTH + x, y, 0.0), (2 * LENGTH, 0.0, 0.0)
    p = (LENGTH + x, y, 0.0)
    return {
        "A": (0.0, 0.0, 0.0),
        "B.crank": b,
        "B.coupler": b,
        "P": p,
        "D.coupler": d,
        "D.rocker": d,
        "E.rocker": e,
        "E": e,
    }


def four_bar(nodes: dict[str, Vector], load: tuple[float, ...]) -> Structure:
    """The linkage with nodes at `nodes` and `load` (fx, fy, fz, mx, my, mz) at P."""
    return Structure(
        nodes=nodes,
        members={name: Member(*ends, E=E, G=G, A=A, Iy=IY, Iz=IZ, J=J) for name, ends in ENDS.items()},
        joints={name: Spring(*ends, STIFFNESS) for name, ends in JOINTS.items()},
        supports={"A": CLAMPED, "E": CLAMPED},
        loads={"P": load},
    )
