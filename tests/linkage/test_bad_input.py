"""What cannot be meant is refused at once, with the name, the value and the remedy."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import Linkage
from reference.linkages import four_bar


def drawn() -> Linkage:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 1))
    linkage.link("arm", "A", "B")
    linkage.link("hand", "B", "C")
    linkage.revolute("A", "ground", "arm", drive=True)
    return linkage


WRONG = {
    "point 'A' is there already": lambda k: k.point("A", (0, 0)),
    "point 'Q' has shape (4,)": lambda k: k.point("Q", (0, 0, 0, 0)),
    "point 'Q' contains nan": lambda k: k.point("Q", (0, np.nan)),
    "does not broadcast with (3,) of point 'R'": lambda k: (
        k.point("R", np.zeros((3, 2))),
        k.point("Q", np.zeros((4, 2))),
    ),
    "link 'arm' is there already": lambda k: k.link("arm", "A", "B"),
    "link 'ground' is there already": lambda k: k.link("ground", "A", "B"),
    "link 'x' has no points": lambda k: k.link("x"),
    "link 'x': there is no point 'Z': choose one of A, B, C": lambda k: k.link("x", "A", "Z"),
    "link 'x': ['A', 'B'] is not the name of a point": lambda k: k.link("x", ["A", "B"]),
    "name each point once": lambda k: k.link("x", "A", "A"),
    "length of link 'x' is -1": lambda k: k.link("x", "A", "B", length=-1.0),
    "length= needs exactly two": lambda k: k.link("x", "A", "B", "C", length=1.0),
    "mass of link 'x' is -2": lambda k: k.link("x", "A", "B", mass=-2.0),
    "is not a tensor of inertia": lambda k: k.link("x", "A", "B", inertia=np.triu(np.ones((3, 3)))),
    "beam between ('A', 'C')": lambda k: k.link("x", "A", "B", beams=[("A", "C")], beam=1),
    "beam is 1: give a Beam": lambda k: k.link("x", "A", "B", beam=1),
    "joint 'C': link 'arm' has no point 'C': add it": lambda k: k.revolute("C", "arm", "hand"),
    "joint 'B': there is no link 'leg': choose one of arm, hand": lambda k: k.revolute("B", "arm", "leg"),
    "joint 'B' joins only 'arm'": lambda k: k.revolute("B", "arm"),
    "joint 'B' joins arm and arm": lambda k: k.revolute("B", "arm", "arm"),
    "axis of joint 'B' is [0.0, 0.0, 0.0]": lambda k: k.revolute("B", "arm", "hand", axis=(0, 0, 0)),
    "not perpendicular": lambda k: k.universal("B", "arm", "hand", axis=(0, 0, 1), second=(1, 0, 1)),
    "joint 'A' joins 'ground' and 'arm' by a revolute joint at 'A' already": lambda k: k.revolute("A", "arm", "ground"),
    "reference value of joint 'B' has shape (2,)": lambda k: k.spherical("B", "arm", "hand", reference=(1, 2)),
    "give six springs": lambda k: k.revolute("B", "arm", "hand", stiffness=(1, 2, 3)),
    "clearance of joint 'B' is -0.1": lambda k: k.revolute("B", "arm", "hand", clearance=-0.1),
    "joint 'B' has no coordinate 'ux': choose of rz": lambda k: k.revolute("B", "arm", "hand", drive="ux"),
    "the linkage has no joint 'X': choose one of A": lambda k: k.drive("X"),
    "is fixed: drive another": lambda k: (k.fixed("B", "arm", "hand"), k.drive("B")),
    "load: there is no point 'Z'": lambda k: k.load("Z", fx=1.0),
    "load: link 'arm' has no point 'C': it has A, B": lambda k: k.load("C", link="arm", fx=1.0),
    "load: no link has point 'free': add it": lambda k: (k.point("free", (3, 3)), k.load("free", fx=1.0)),
    "spring: both ends are 'B' on 'arm': give two": lambda k: k.spring("B", ("arm", "B"), stiffness=1.0, length=1.0),
    "torque: there is no link 'leg'": lambda k: k.torque("leg", mz=1.0),
    "stiffness of the spring A-B is -1": lambda k: k.spring("A", "B", stiffness=-1.0, length=1.0),
    "link 'hand' is not connected to ground": lambda k: k.move(),
    "joint 'A' is given twice": lambda k: k.move({"A": 1.0}, A=2.0),
    "rates is 1.0: give numbers by joint, such as rates={'A': 1.0}": lambda k: k.move(A=2.0, rates=1.0),
    "drives is 2.0: give numbers by joint": lambda k: k.move(2.0),
    "branch is 'other': choose one of keep, switch": lambda k: k.move(branch="other"),
}


@pytest.mark.parametrize("message", WRONG)
def test_description_is_refused(message):
    with pytest.raises(FrameError) as caught:
        WRONG[message](drawn())
    assert message in str(caught.value)


MOVES = {
    "the linkage has no joint 'Q'": {"Q": 1.0},
    "value of joint 'B' is given, but nothing drives it (driven: A)": {"B": 1.0},
    "value of joint 'A' contains nan": {"A": np.nan},
}


@pytest.mark.parametrize("message", MOVES)
def test_motion_is_refused(message):
    with pytest.raises(FrameError) as caught:
        four_bar(2, 7, 9, 6, 0.5).move(MOVES[message])
    assert message in str(caught.value)


def test_rates_that_do_not_broadcast_are_refused():
    with pytest.raises(FrameError, match=r"rate of joint 'A' has batch shape \(3,\)"):
        four_bar(2, 7, 9, 6, 0.5).move(A=np.zeros(2), rates={"A": np.ones(3)})


def test_singular_drawing_is_refused():
    flat = Linkage(A=(0, 0), B=(1, 0), D=(3, 0), E=(2, 0))
    for name, ends in (("crank", "AB"), ("coupler", "BD"), ("rocker", "DE")):
        flat.link(name, *ends)
    for joint, links in {"A": ("ground", "crank"), "B": ("crank", "coupler"), "D": ("coupler", "rocker")}.items():
        flat.revolute(joint, *links, drive=joint == "A")
    flat.revolute("E", "rocker", "ground")
    with pytest.raises(FrameError, match="the reference configuration is singular"):
        flat.move(A=0.1)


def test_drawing_that_cannot_be_assembled_names_the_gap():
    linkage = Linkage(A=(0, 0), B=(1, 1), D=(3, 1), E=(4, 0))
    linkage.link("crank", "A", "B", length=0.5)
    linkage.link("coupler", "B", "D", length=0.5)
    linkage.link("rocker", "D", "E", length=0.5)
    for joint, links in {"A": ("ground", "crank"), "B": ("crank", "coupler"), "D": ("coupler", "rocker")}.items():
        linkage.revolute(joint, *links, drive=joint == "A")
    linkage.revolute("E", "rocker", "ground")
    for call in (lambda: linkage.move(A=0.1), linkage.mobility, lambda: linkage.drive_range("A")):
        with pytest.raises(FrameError, match=r"cannot be assembled: a gap of 2.66 remains at joint 'D'"):
            call()


def test_unknown_names_of_a_motion_are_refused():
    motion = four_bar(2, 7, 9, 6, 0.5).move(A=0.6)
    for call, message in (
        (lambda: motion.position("X"), "there is no point 'X'"),
        (lambda: motion.position("D", "crank"), "link 'crank' has no point 'D'"),
        (lambda: motion.axes("bar"), "no link 'bar'"),
        (lambda: motion.coordinate("Z"), "no joint 'Z'"),
        (lambda: motion.position_on("crank", (1, 2, 3, 4)), "place on a link has shape"),
    ):
        with pytest.raises(FrameError, match=message):
            call()


def test_a_stiffness_that_does_not_fit_the_poses_is_refused():
    linkage = drawn()
    linkage.revolute("B", "arm", "hand", drive=True, stiffness=np.ones((5, 6)))
    with pytest.raises(FrameError, match=r"do not broadcast: stiffness \(5,\), axes \(3,\)"):
        linkage.move(A=np.zeros(3), B=0.0).frame()
