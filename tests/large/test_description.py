"""What a frame holds beside members and loads: other names, entries left out, contacts in clearances."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError
from linkframe.framework.large.numbers import Numbers
from linkframe.models import FourBar
from numpy.testing import assert_allclose, assert_array_equal

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3), segments=4)


def cantilever(force: np.ndarray) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.alias("base", "A")
    frame.alias("tip", "B")
    frame.add("AB", ROD, "A", "B")
    frame.fix("base")
    frame.load("tip", fy=force)
    return frame


def test_nodes_answer_to_their_other_names() -> None:
    frame = cantilever(np.array([1e3, 2e3]))
    solution = frame.solve(large=True)
    assert_array_equal(solution.displacement("tip"), solution.displacement("B"))
    assert_array_equal(solution.reaction("base"), solution.reaction("A"))
    path = frame.path("tip", "uy", 0.1, first=0.2)
    assert_array_equal(path.displacement("tip"), path.displacement("B"))


def test_entries_left_out_are_absent() -> None:
    """The others are as they are without them."""
    frame = cantilever(np.array([1e3, 2e3, 3e3]))
    frame.exclude(np.array([False, True, False]))
    solution, whole = frame.solve(large=True, steps=2), cantilever(np.array([1e3, 3e3])).solve(large=True, steps=2)
    assert solution.status.tolist() == ["stable", "absent", "stable"]
    assert solution.iterations[1] == 0
    for found, kept in (
        (solution.displacement("B"), whole.displacement("B")),
        (solution.reaction("A"), whole.reaction("A")),
        (solution.end_forces("AB"), whole.end_forces("AB")),
        (solution.forces("AB", 0.3), whole.forces("AB", 0.3)),
        (solution.stress("AB", 0.3), whole.stress("AB", 0.3)),
        (solution.displacement_along("AB", 0.3), whole.displacement_along("AB", 0.3)),
    ):
        assert np.isnan(found[1]).all()
        assert_array_equal(found[[0, 2]], kept)
    path = frame.path("B", "uy", 0.05, first=0.2)
    assert np.isnan(path.factor[:, 1]).all()
    assert path.displacement("B")[-1, 0, 1] > 0.05


def test_contact_tends_to_that_of_the_linear_solution() -> None:
    motion = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open", stiffness=(1e8,) * 5 + (0.0,)).move(
        np.radians([30.0, 60.0, 200.0])
    )
    frame = motion.frame(dict.fromkeys("BDE", 1e-7))
    frame.load("P", fy=1e-2)
    large, linear = frame.solve(large=True), frame.solve()
    for joint in "BDE":
        found, expected = large.contact(joint), linear.contact(joint)
        assert_array_equal(found.state, expected.state)
        assert_allclose(found.normal, expected.normal, atol=1e-5)
        assert_allclose(found.force, expected.force, rtol=1e-5)
        assert_allclose(np.cos(found.angle - expected.angle), 1.0, atol=1e-9)


@pytest.mark.parametrize("degrees", [20.0, 100.0])
def test_contact_turns_with_the_part_that_holds_the_bearing(degrees: float) -> None:
    """A bar hung in a bearing whose support turns: the force on it is vertical whatever the support does."""
    frame = Frame()
    for name, x in {"A": 0.0, "A1": 0.0, "B": 0.5}.items():
        frame.node(name, (x, 0.0, 0.0))
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    frame.add("pin", Joint((1e8,) * 5 + (0.0,), turn, clearance=1e-3), "A", "A1")
    frame.add("bar", ROD, "A1", "B")
    frame.fix("A")
    frame.prescribe("A", rz=np.radians(degrees))
    frame.load("B", fx=100.0)
    solution = frame.solve(large=True, steps=4)
    assert solution.converged
    contact = solution.contact("pin")
    assert contact.closed
    assert_allclose(contact.normal, [1.0, 0.0, 0.0], atol=1e-9)
    assert contact.force == pytest.approx(100.0, rel=1e-9)
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    assert_allclose(contact.offset, 1e-3 * np.array([-s, -c, 0.0]), atol=1e-9)


def test_contact_is_refused_where_there_is_none() -> None:
    with pytest.raises(FrameError, match="'pin' is unknown"):
        cantilever(np.array(1.0)).solve(large=True).contact("pin")
    frame = FourBar().move(1.0).frame({"B": 1e-4})
    frame.load("P", fy=1.0)
    with pytest.raises(FrameError, match="those with one are B"):
        frame.solve(large=True).contact("D")
    with pytest.raises(FrameError, match="left out"):
        frame.solve(large=True, clearance=False).contact("B")


def test_explanation_tells_of_plane_steps_and_entries() -> None:
    frame = cantilever(np.array([1e3, 2e3, 3e3]))
    frame.exclude(np.array([False, True, False]))
    text = frame.solve(large=True, steps=2).explain()
    assert "3 entries, of which 1 are left out" in text
    assert "4 corotational pieces; the frame is kept to the xy plane" in text
    assert "12 unknown, 0 given" in text
    assert "Load steps: 2" in text
    frame.load("B", fz=1.0)
    assert "moves in space" in frame.solve(large=True).explain()


def test_numbers_keep_their_axes() -> None:
    assert Numbers.of(np.array(3.0), ndim=0, trailing=0).array.shape == ()
    assert Numbers.of(np.array(3.0), ndim=2, trailing=0).array.shape == (1, 1)
    assert Numbers.of(np.zeros((4, 6)), ndim=1, trailing=1).array.shape == (6, 4)
