"""A call that is refused leaves the frame as it was: all of a call is taken up, or nothing."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0))
ONES = np.ones
# Each with names and shapes that its message tells; the frame is loaded at B by fx of shape (3,).
CALLS: dict[str, tuple[Callable[[Frame], object], tuple[str, ...]]] = {
    "load of which one does not fit": (
        lambda f: f.load("D", fx=ONES((4, 1)), fy=ONES(2)),
        ("fy at 'D'", "(2,)", "(3,)", "fx at 'B'", "(36, 1)"),
    ),
    "load of unlike shapes": (
        lambda f: f.load("D", fx=ONES((4, 1)), fy=ONES((5, 1))),
        ("fy at 'D'", "(5, 1)", "(4, 1)", "fx at 'D'", "(36, 1)"),
    ),
    "load of an unknown component": (lambda f: f.load("D", fx=1.0, fw=1.0), ("'fw'", "mz")),
    "support of an unknown component": (lambda f: f.fix("C", "ux", "uw"), ("'uw'", "rz")),
    "prescribed by an unknown component": (lambda f: f.prescribe("C", ux=0.1, uw=0.1), ("'uw'", "rz")),
    "prescribed of unlike shapes": (
        lambda f: f.prescribe("C", ux=ONES((4, 1)), uy=ONES((5, 1))),
        ("uy prescribed at 'C'", "(5, 1)", "(4, 1)", "ux prescribed at 'C'", "(36, 1)"),
    ),
    "offset of unlike shapes": (
        lambda f: f.offset("pin", ux=ONES((4, 1)), uy=ONES((5, 1))),
        ("uy of 'pin'", "(5, 1)", "(4, 1)", "ux of 'pin'", "(36, 1)"),
    ),
    "line load beyond its member": (lambda f: f.line_load("AB", fy=ONES((4, 1)), span=(0.0, 2.0)), ("(0.0, 2.0)", "1")),
    "line load of unlike shapes": (
        lambda f: f.line_load("AB", fx=ONES((4, 1)), fy=ONES((5, 1))),
        ("fy at the start of the line load on 'AB'", "(5, 1)", "(4, 1)", "fx", "(36, 1)"),
    ),
    "line load of unlike ends": (
        lambda f: f.line_load("AB", fx=(ONES((4, 1)), ONES((5, 1)))),
        ("fx at the end of the line load on 'AB'", "(5, 1)", "(4, 1)", "start", "(36, 1)"),
    ),
    "point load beyond its member": (lambda f: f.point_load("AB", at=2.0, fy=ONES((4, 1))), ("'AB'", "2.0", "length")),
    "point load of unlike shapes": (
        lambda f: f.point_load("AB", at=0.5, fx=ONES((4, 1)), mz=ONES((5, 1))),
        ("mz of the point load on 'AB'", "(5, 1)", "(4, 1)", "fx", "(36, 1)"),
    ),
    "gravity that does not fit": (lambda f: f.gravity(ONES((2, 3))), ("gravity", "(2,)", "(3,)", "fx at 'B'")),
    "entries left out that do not fit": (lambda f: f.exclude(ONES(2, dtype=bool)), ("left out", "(2,)", "(3,)")),
    "body of unlike shapes": (
        lambda f: f.body("link", ONES((4, 1, 3)), np.broadcast_to(np.eye(3), (5, 1, 3, 3))),
        ("axes of body 'link'", "(5, 1)", "(4, 1)", "origin of body 'link'", "(36, 1)"),
    ),
    "node that does not fit": (lambda f: f.node("Z", ONES((2, 3))), ("node 'Z'", "(2,)", "(3,)", "fx at 'B'")),
    "joint that does not fit": (
        lambda f: f.add("second", Joint(stiffness=ONES((2, 6))), "C", "B"),
        ("joint 'second'", "(2,)", "(3,)", "fx at 'B'"),
    ),
    "rigid links of which one is unknown": (lambda f: f.rigid("A", "B", "X"), ("'X'", "unknown")),
    "rigid links of which one is its own": (lambda f: f.rigid("A", "B", "A"), ("'A'", "itself")),
}


@pytest.mark.parametrize("case", CALLS)
def test_all_of_a_call_is_taken_up_or_nothing(case: str) -> None:
    call, parts = CALLS[case]
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BEAM, "A", "B")
    frame.add("pin", Joint(stiffness=(2e11,) * 5 + (0.0,)), "B", "C")
    frame.add("CD", BEAM, "C", "D")
    frame.fix("A")
    frame.load("B", fx=ONES(3))
    before = repr(vars(frame))
    with pytest.raises(FrameError) as error:
        call(frame)
    for part in parts:
        assert part in str(error.value), f"{part!r} is not in: {error.value}"
    assert repr(vars(frame)) == before


def test_a_refused_support_is_none() -> None:
    """A node that was to be held, and is not, has no reaction."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BEAM, "A", "B")
    frame.fix("A")
    for refused in (lambda: frame.fix("B", "up"), lambda: frame.prescribe("B")):
        with pytest.raises(FrameError):
            refused()
    with pytest.raises(FrameError, match="'B' has no support"):
        frame.solve().reaction("B")


def test_a_load_that_was_given_keeps_its_place_in_the_batch() -> None:
    """The shape of the first of two loads by one name still binds after a second without it."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.load("A", fx=ONES(3))
    frame.load("A", fx=ONES(1))
    with pytest.raises(FrameError, match=r"fy at 'A'.*\(4,\).*\(3,\) of fx at 'A'"):
        frame.load("A", fy=ONES(4))


def test_batches_clash_with_what_was_given_by_the_same_name_before() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.load("A", fx=[[1.0], [2.0], [3.0]])
    frame.load("A", fx=[1.0, 2.0])
    with pytest.raises(FrameError, match=r"fx at 'A' has batch shape \(2, 1\), which does not broadcast with \(3, 1\)"):
        frame.load("A", fx=[[1.0], [2.0]])
    assert frame.shape == (3, 2)
