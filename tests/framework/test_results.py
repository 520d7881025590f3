"""What linear and large-displacement solutions have in common: how they are asked, saved and shown."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, LargeSolution, Solution, SolutionState
from numpy.testing import assert_allclose

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0))


def bent(force: object = 1.0) -> Frame:
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", BEAM, "A", "B")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 1e3)), "B", "C")
    frame.add("CD", BEAM, "C", "D")
    frame.fix("A")
    frame.load("D", fx=force)  # type: ignore[arg-type]
    frame.alias("tip", "D")
    return frame


def solved(large: bool, force: object = 1.0) -> Solution | LargeSolution:
    return bent(force).solve(large=True) if large else bent(force).solve()


QUESTIONS: dict[str, tuple[Callable[[Solution | LargeSolution], object], str]] = {
    "displacement": (lambda s: s.displacement("X"), "node 'X' is unknown: known are 'A', 'B', 'C', 'D'"),
    "displacement along": (lambda s: s.displacement_along("pin", 0.5), "member 'pin' is unknown: known are 'AB', 'CD'"),
    "forces": (lambda s: s.forces("X", 0.5), "member 'X' is unknown: known are 'AB', 'CD'"),
    "stress": (lambda s: s.stress("X", 0.5), "member 'X' is unknown: known are 'AB', 'CD'"),
    "end forces": (lambda s: s.end_forces("X"), "member 'X' is unknown: known are 'AB', 'CD'"),
    "joint displacement": (lambda s: s.joint_displacement("AB"), "joint 'AB' is unknown: known are 'pin'"),
    "joint force": (lambda s: s.joint_force("AB"), "joint 'AB' is unknown: known are 'pin'"),
    "reaction": (lambda s: s.reaction("tip"), "node 'D' has no support: reactions are at A"),
    "contact of no joint": (lambda s: s.contact("AB"), "joint 'AB' is unknown: known are 'pin'"),
    "contact": (lambda s: s.contact("pin"), "no clearance: those with one are none, or they were left out"),
    "bound": (lambda s: s.error_bound("X"), "node 'X' is unknown: known are 'A', 'B', 'C', 'D'"),
}


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize("question", QUESTIONS)
def test_both_refuse_what_is_unknown_in_the_same_words(question: str, large: bool) -> None:
    ask, told = QUESTIONS[question]
    with pytest.raises(FrameError) as error:
        ask(solved(large))
    assert told in str(error.value)


@pytest.mark.parametrize("large", [False, True])
@pytest.mark.parametrize("reader", ["displacement", "end_forces", "joint_force", "joint_displacement", "reaction"])
def test_names_are_strings_of_any_kind(reader: str, large: bool) -> None:
    """NumPy's strings are told as what they say; what is no string is refused as such."""
    read = getattr(solved(large), reader)
    known = {"end_forces": "AB", "joint_force": "pin", "joint_displacement": "pin"}.get(reader, "A")
    assert_allclose(read(np.array([known])[0]), read(known), rtol=0.0)
    with pytest.raises(FrameError, match="unknown: known are") as error:
        read(np.str_("X"))
    assert "str_" not in str(error.value)
    for wrong in (["A"], 0, None):
        with pytest.raises(FrameError, match="give a non-empty string"):
            read(wrong)


@pytest.mark.parametrize("large", [False, True])
def test_both_know_nodes_by_their_other_names(large: bool) -> None:
    solution = solved(large)
    assert_allclose(solution.displacement("tip"), solution.displacement("D"), rtol=0.0)
    assert_allclose(solution.error_bound("tip"), solution.error_bound("D"), rtol=0.0)


def test_small_loads_are_answered_alike() -> None:
    linear, large = solved(False, 1e-3), solved(True, 1e-3)
    for ask in (
        lambda s: s.forces("CD", [0.25, 0.75])[:, 5],
        lambda s: s.stress("CD", [0.25, 0.75]),
        lambda s: s.displacement_along("AB", [0.5])[:, 5],
    ):
        assert_allclose(ask(large), ask(linear), rtol=1e-5)


def test_both_are_saved_by_the_same_options(tmp_path: Path) -> None:
    assert inspect.signature(LargeSolution.save) == inspect.signature(Solution.save)
    for large in (False, True):
        solution = solved(large, [0.0, 1.0, 2.0])
        solution.save(tmp_path / "pose.vtu", entry=1, stations=2)
        solution.save(tmp_path / "series.pvd", axis=0, times=[0.0, 0.5, 2.0])
        assert {"pose.vtu", "series.pvd"} <= {path.name for path in tmp_path.iterdir()}
        with pytest.raises(FrameError, match="increasing"):
            solution.save(tmp_path / "series.pvd", axis=0, times=[0.0, 2.0, 0.5])


def test_what_is_printed_is_a_line() -> None:
    frame = "<Frame of shape (1000, 3): 4 nodes, 2 members, 1 joint>"
    assert repr(bent(np.ones((1000, 3)))) == frame
    assert repr(solved(False, np.ones((1000, 3)))) == f"<Solution of {frame}>"
    assert repr(solved(True, np.ones((1000, 3)))) == f"<LargeSolution of {frame}>"


def test_numbers_of_states_belong_to_whoever_asks() -> None:
    solution = bent(np.ones(3)).solve()
    solution.state[1] = SolutionState.ABSENT
    assert (solution.status == "regular").all()
