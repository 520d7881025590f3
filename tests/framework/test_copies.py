"""Solutions travel: copied, and sent to another process, at any time, with what was read and what was not."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, Solution
from linkframe.framework.cache import SOLVED

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0))
PIN = (1e8, 1e8, 1e8, 1e6, 1e6, 1e3)
WAYS: dict[str, Callable[[Solution], Solution]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda solution: pickle.loads(pickle.dumps(solution)),
}


def bent(clearance: float = 0.0) -> Frame:
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BEAM, "A", "B")
    frame.add("pin", Joint(stiffness=PIN, clearance=clearance), "B", "C")
    frame.add("CD", BEAM, "C", "D")
    frame.fix("A")
    frame.load("D", fx=[100.0, 200.0])
    return frame


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("method", [None, "banded", "sparse", "iterative"])
def test_a_copy_knows_what_its_original_knows_and_outlives_it(way: str, method: str | None) -> None:
    solution = bent().solve(method)
    read = solution.end_forces("AB"), solution.error_bound("D"), solution.status, solution.explain()
    twin, wanted = WAYS[way](solution), bent().solve(method)
    del solution
    np.testing.assert_array_equal(twin.end_forces("AB"), read[0])
    np.testing.assert_array_equal(twin.error_bound("D"), read[1])
    np.testing.assert_array_equal(twin.stress("CD", 0.5), wanted.stress("CD", 0.5))
    np.testing.assert_array_equal(twin.sensitivity("D", "ux").loads["D"], wanted.sensitivity("D", "ux").loads["D"])
    with pytest.raises(ValueError, match="read-only"):
        twin.end_forces("AB")[...] = 0.0


@pytest.mark.parametrize("way", WAYS)
def test_contacts_travel_along(way: str) -> None:
    solution = bent(clearance=1e-4).solve()
    solution.joint_force("pin")
    twin = WAYS[way](solution)
    np.testing.assert_array_equal(twin.contact("pin").normal, solution.contact("pin").normal)
    np.testing.assert_array_equal(twin.reaction("A"), solution.reaction("A"))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("clearance", [0.0, 1e-4])
def test_large_displacement_travels(way: str, clearance: float) -> None:
    solution = bent(clearance).solve(large=True)
    read = solution.error_bound("D"), solution.status
    twin = WAYS[way](solution)  # type: ignore[arg-type]
    np.testing.assert_array_equal(twin.error_bound("D"), read[0])
    np.testing.assert_array_equal(twin.status, read[1])
    np.testing.assert_array_equal(twin.reaction("A"), solution.reaction("A"))


@pytest.mark.parametrize("way", [copy.deepcopy, lambda bounds: pickle.loads(pickle.dumps(bounds))])
def test_bounds_travel_by_themselves(way: Callable[[object], object]) -> None:
    """With the parts of the batch that they have kept."""
    solution = bent().solve()
    solution.error_bound("D")
    bound = solution.bounds.bound("C", "displacement", solution.displacement("C"))
    twin = way(solution.bounds)
    found = twin.bound("C", "displacement", solution.displacement("C"))  # type: ignore[attr-defined]
    np.testing.assert_array_equal(found, bound)


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, Frame.copy])
def test_a_copied_frame_is_loaded_alone(way: Callable[[Frame], Frame]) -> None:
    """What is said of a copy does not reach the original, nor the other way round."""
    frame = bent()
    before = frame.solve().displacement("D").copy()
    twin = way(frame)
    twin.load("D", fy=7.0)
    twin.fix("B", "uz")
    twin.node("E", (2.0, 0.0, 0.0))
    assert "E" not in frame.nodes
    np.testing.assert_array_equal(frame.solve().displacement("D"), before)
    assert np.abs(twin.solve().displacement("D") - before).max() > 1e-6


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, lambda frame: pickle.loads(pickle.dumps(frame))])
@pytest.mark.parametrize("method", [None, "banded", "sparse", "iterative"])
def test_a_solved_frame_travels(way: Callable[[Frame], Frame], method: str | None) -> None:
    """What it keeps of its solution, which may hold a factor that cannot travel, stays behind."""
    frame = bent()
    solution = frame.solve(method)
    wanted = solution.displacement("D")
    twin = way(frame)
    assert SOLVED.get(twin) is None
    np.testing.assert_array_equal(twin.solve(method).displacement("D"), wanted)
    np.testing.assert_array_equal(frame.solve(method).displacement("D"), wanted)


def test_entries_left_out_are_not_the_array_that_was_given() -> None:
    frame, left = bent(), np.array([True, False])
    frame.exclude(left)
    left[...] = False
    assert frame.solve().status.tolist() == ["absent", "regular"]


def test_frames_are_equal_to_themselves_alone() -> None:
    frame = bent()
    assert frame == frame
    assert frame != frame.copy()
    assert len({frame, frame.copy()}) == 2


def test_steps_belong_to_large_displacement() -> None:
    with pytest.raises(FrameError, match=r"steps=5.*large=True"):
        bent().solve(steps=5)  # type: ignore[call-overload]


def test_a_tie_of_a_copy_does_not_bind_the_original() -> None:
    """Though neither has any other part that the other lacks."""
    frame = bent()
    frame.node("E", (2.0, 1.0, 0.0))
    frame.rigid("D", "E")
    twin, before = frame.copy(), frame.solve().displacement("D")
    twin.node("F", (3.0, 1.0, 0.0))
    twin.rigid("D", "F")
    assert [len(each.ties) for each in (frame, twin)] == [1, 2]
    np.testing.assert_array_equal(frame.solve().displacement("D"), before)
