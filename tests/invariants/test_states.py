"""States are numbers that can be counted, and say the same as the words; inside, the numbers are compared."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, SolutionState
from linkframe.models import Linkage, PoseState

BAR = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3))


def pendulum(fx: object, clearance: float = 0.0) -> Frame:
    """A bar hung on a pin."""
    frame = Frame()
    for name, place in {"G": (0, 0, 0), "A": (0, 0, 0), "B": (0, -1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(1e8,) * 5 + (0.0,), clearance=clearance), "G", "A")
    frame.fix("G")
    frame.load("B", fx=fx, fy=-1.0)
    return frame


def test_solutions() -> None:
    """Pushed aside, it is a mechanism; pulled along, idle; left out, absent."""
    frame = pendulum([1.0, 0.0, 0.0])
    frame.exclude(np.array([False, False, True]))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        solution = frame.solve()
        assert solution.state.tolist() == [
            SolutionState.MECHANISM,
            SolutionState.STATICALLY_CONSISTENT_MECHANISM,
            SolutionState.ABSENT,
        ]
    assert solution.status.tolist() == [SolutionState(k).text for k in solution.state]
    assert solution.is_singular.tolist() == [True, True, False]
    assert not solution.is_regular.any()
    frame.fix("B", "rz")
    assert frame.solve().is_regular.tolist() == [True, True, False]
    assert frame.solve(large=True).state.tolist() == [SolutionState.STABLE, SolutionState.STABLE, SolutionState.ABSENT]


@pytest.mark.parametrize("large", [False, True])
def test_shape_and_words(large: bool) -> None:
    """Both are of the batch shape, or of none."""
    for fx in (0.0, np.zeros((2, 3)), np.zeros((0,))):
        frame = pendulum(fx)
        frame.fix("B", "rz")
        if large and np.size(fx) == 0:
            continue
        solution = frame.solve(large=large)
        assert solution.state.shape == solution.status.shape == solution.is_regular.shape == np.shape(fx)
        assert solution.is_regular.all()


def four_bar(rocker: float = 0.2) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0, 0.1), D=(0.3, rocker), E=(0.3, 0))
    for name, on in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        linkage.link(name, *on)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage


WORDS = {
    PoseState.REGULAR: "regular",
    PoseState.NEAR_DEAD_POINT: "near dead point",
    PoseState.SINGULAR_DIRECT: "singular (direct-kinematic, type II; ",
    PoseState.SINGULAR_INVERSE: "singular (inverse-kinematic, type I; ",
    PoseState.NOT_ASSEMBLED: "not assembled: gap ",
}


def test_poses() -> None:
    """A rocker driven from dead point to dead point, beyond, and at the ends of the swing of what it drives."""
    linkage = four_bar()
    limit = linkage.drive_range("A")
    crank = linkage.move(A=np.linspace(0.0, 2.0 * np.pi, 721))
    linkage.drives = {"E": ("rz",)}
    ends = [point.value for point in linkage.dead_points("E")]
    rocker = linkage.move(E=[0.0, *ends, ends[0] + 1e-5, max(ends) + 0.1])
    assert limit.upper == np.inf
    assert rocker.state[1:].tolist() == [PoseState.SINGULAR_DIRECT] * len(ends) + [
        PoseState.NEAR_DEAD_POINT,
        PoseState.NOT_ASSEMBLED,
    ]
    assert rocker.is_singular.tolist() == [False] + [True] * len(ends) + [False] * 2
    for motion in (crank, rocker):
        assert motion.state.shape == motion.status.shape == motion.shape
        np.testing.assert_array_equal(motion.is_regular, motion.status == "regular")
        for state, words in zip(motion.state, motion.status, strict=True):
            assert words.startswith(WORDS[PoseState(state)])


def test_numbers_of_gaps_do_not_part_what_is_counted() -> None:
    """Each pose that cannot be assembled has words of its own, with its gap; their state is one."""
    linkage = four_bar(rocker=0.12)
    motion = linkage.move(A=np.linspace(0.0, 2.0 * np.pi, 25))
    lost = motion.state == PoseState.NOT_ASSEMBLED
    np.testing.assert_array_equal(lost, ~motion.is_assembled)
    if lost.sum() > 1:
        assert len(set(motion.status[lost].tolist())) > 1


def test_where_journals_rest_anywhere_a_warning_says_so() -> None:
    """Without a force on it, a journal's place in its bearing is one of many."""
    frame = pendulum([0.0, 1.0], clearance=1e-3)
    frame.loads.clear()
    frame.load("B", mz=[0.0, 1.0])
    frame.fix("B", "rz")
    solution = frame.solve()
    assert solution.state.tolist() == [SolutionState.FREE] * 2
    with pytest.warns(MechanismWarning, match="2 of 2 batch entries are free: .* statistics of them mean nothing"):
        solution.displacement("B")
    assert frame.solve(clearance=False).is_regular.all()
