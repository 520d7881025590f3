"""Parts whose numbers are known to be right: the same frame as by the verbs of a description, without their checks."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.elements.joint import known_joint
from linkframe.framework import Frame
from linkframe.framework.described.known_parts import add_body, add_joint, add_node
from linkframe.framework.errors import FrameError
from numpy.testing import assert_array_equal

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
PIN = np.array([2e8, 2e8, 2e8, 2e5, 2e5, 10.0])
ANGLE = np.array([0.3, 1.0, 2.5])


def axes() -> np.ndarray:
    c, s, o = np.cos(ANGLE), np.sin(ANGLE), np.zeros(3)
    return np.moveaxis(np.array([[c, -s, o], [s, c, o], [o, o, o + 1.0]]), -1, 0)


def described(frame: Frame, body: Callable, node: Callable, joint: Callable) -> Frame:
    """An arm on a turning body, on a pin."""
    node("O", np.zeros(3))
    body("arm", np.array([0.0, 0.0, 0.0]), axes())
    node("A", np.zeros(3), "arm")
    node("B", np.array([1.0, 0.5, 0.0]), "arm")
    joint("pin", "O", "A")
    frame.add("AB", BAR, "A", "B")
    frame.fix("O")
    frame.load("B", fx=3.0, fy=-2.0, fz=1.0)
    return frame


def known(frame: Frame) -> Frame:
    return described(
        frame,
        lambda *given: add_body(frame, *given),
        lambda *given: add_node(frame, *given),
        lambda name, *nodes: add_joint(frame, name, known_joint(PIN.copy(), axes()), *nodes),
    )


def test_they_make_the_same_frame() -> None:
    one, other = known(Frame()), Frame()
    described(other, other.body, other.node, lambda name, *nodes: other.add(name, Joint(PIN, axes()), *nodes))
    assert (one.shape, one.size) == (other.shape, other.size) == ((3,), one.size)
    for node in "OAB":
        assert_array_equal(one.position(node), other.position(node))
        assert_array_equal(one.solve().displacement(node), other.solve().displacement(node))


def test_their_numbers_are_read_only() -> None:
    frame = known(Frame())
    arrays = [frame.bodies["arm"].origin, frame.bodies["arm"].axes, frame.nodes["B"].coordinates]
    for array in arrays:
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


def test_names_are_new_and_shapes_broadcast() -> None:
    frame = known(Frame())
    with pytest.raises(FrameError, match="body 'arm' exists already"):
        add_body(frame, "arm", np.zeros(3), np.eye(3))
    with pytest.raises(FrameError, match="node 'B' exists already"):
        add_node(frame, "B", np.zeros(3))
    with pytest.raises(FrameError, match="element 'AB' exists already"):
        add_joint(frame, "AB", known_joint(PIN), "O", "A")
    with pytest.raises(FrameError, match=r"origin of body 'leg' has batch shape \(2,\)"):
        add_body(frame, "leg", np.zeros((2, 3)), np.eye(3))
    with pytest.raises(FrameError, match=r"joint 'leg' has batch shape \(2,\)"):
        add_joint(frame, "leg", known_joint(np.zeros((2, 6))), "O", "A")
    with pytest.raises(FrameError, match=r"Joint: shapes do not broadcast: stiffness \(2,\), axes \(3,\)"):
        known_joint(np.zeros((2, 6)), axes())
    assert frame.shape == (3,)
