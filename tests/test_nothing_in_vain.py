"""What is known already is not done again."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.structure.topology import Topology

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


def bracket(tip: object = (1.0, 0.5, 0.2), load: object = 3.0, body: bool = False) -> Frame:
    """Two bars at a joint, and a third between places of their own; in a batch where `load` or `tip` is one."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    if body:
        frame.body("arm", origin=(1.0, 0.0, 0.0), axes=np.eye(3)[[1, 2, 0]])
        frame.node("C", (0.0, 0.0, 0.0), body="arm")
    else:
        frame.node("C", (1.0, 0.0, 0.0))
    frame.node("D", tip)
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 50.0)), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.add("AD", BAR, "A", "D")
    frame.fix("A")
    frame.load("D", fy=load)
    return frame


PLACES = [(1.1, 0.5, 0.2), (1.0, 0.7, 0.0), (0.9, 0.4, -0.3)]


@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("load", [3.0, [1.0, 2.0]])
def test_nodes_that_move_give_the_bits_of_a_new_frame(body: bool, load: object) -> None:
    frame = bracket(load=load, body=body)
    frame.solve().displacement("D")
    for place in [*PLACES, np.array([(1.0, 0.5, 0.2), (1.2, 0.5, 0.1)])]:
        if np.ndim(place) == 2 and np.ndim(load) == 0:
            continue  # the batch widens, and with it what is gathered
        frame.change("D", place)
        anew = bracket(place, load, body)
        for name in ("displacement", "reaction"):
            asked = "D" if name == "displacement" else "A"
            np.testing.assert_array_equal(getattr(frame.solve(), name)(asked), getattr(anew.solve(), name)(asked))
        np.testing.assert_array_equal(frame.solve().end_forces("AD"), anew.solve().end_forces("AD"))


def test_nodes_that_move_leave_members_gathered_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = bracket()
    frame.solve().displacement("D")

    def anew(*_: object, **__: object) -> Topology:
        raise AssertionError("members were numbered again")

    monkeypatch.setattr(Topology, "of", anew)
    for place in PLACES:
        frame.change("D", place)
        assert np.isfinite(frame.solve().displacement("D")).all()
    frame.change("AD", Beam(Rectangle(y=0.03, z=0.01), Material(E=200e9, nu=0.3)))
    assert np.isfinite(frame.solve().displacement("D")).all()
    frame.node("one more", (0.0, 0.0, 1.0))
    with pytest.raises(AssertionError, match="numbered again"):
        frame.solve()
