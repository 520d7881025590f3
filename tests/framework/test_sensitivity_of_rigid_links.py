"""Sensitivity to the places of nodes on rigid links: against finite differences, whichever end carries the other."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from numpy.testing import assert_allclose

ROD = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3, density=7850.0))
PLACES = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "C": (1.2, 0.3, 0.1), "D": (2.0, 0.5, 0.2), "E": (1.1, -0.2, 0.3)}
INF = np.inf


def body(held: dict[str, tuple[float, ...]], moved: str = "A", by: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Frame:
    """Two rods on a rigid body B C E, at points of which joints hold it to the ground; one point is moved."""
    frame = Frame()
    places = {name: np.array(place) + (name == moved) * np.array(by) for name, place in PLACES.items()}
    for name, place in places.items():
        frame.node(name, place)
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", ROD, "C", "D")
    frame.fix("A")
    frame.rigid("B", "C")
    frame.rigid("C", "E")
    for name, stiffness in held.items():
        frame.node(f"{name} wall", places[name])
        frame.fix(f"{name} wall")
        frame.add(name, Joint(stiffness=stiffness), f"{name} wall", name)
    frame.load("D", fx=100.0, fy=30.0, fz=-20.0, mz=5.0)
    frame.load("E", fy=3.0)
    return frame


@pytest.mark.parametrize(
    "held",
    [
        {"E": (1e6, 0.0, 0.0, 0.0, 0.0, 0.0)},
        {"E": (INF, 0.0, 0.0, 0.0, 0.0, 0.0), "C": (0.0, INF, 0.0, 0.0, 0.0, 0.0)},
    ],
)
def test_places_of_nodes_on_a_rigid_body(held: dict[str, tuple[float, ...]]) -> None:
    """From the joint on, links carry their first nodes; where two joints close a loop, their forces go through them."""
    found = body(held).solve().sensitivity("D", "uy").nodes
    for name, axis in {"B": 1, "C": 2, "E": 0}.items():
        step = 1e-4 * np.eye(3)[axis]
        ahead, behind = (body(held, name, tuple(sign * step)).solve().displacement("D")[1] for sign in (1.0, -1.0))
        own = found[name][axis] + (found[f"{name} wall"][axis] if name in held else 0.0)
        assert_allclose(own, (ahead - behind) / 2e-4, rtol=1e-5)
