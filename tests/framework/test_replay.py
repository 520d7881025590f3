"""The elimination of one entry from a list that another frame of the topology wrote: the same bits."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, MechanismWarning
from linkframe.framework.batched import entry_recording, replay
from linkframe.framework.cache import PROGRAMS
from reference.as_frame import as_frame
from reference.random_structures import random_constrained, random_frame, random_linkage

STEEL = Material(E=200e9, nu=0.3)


@pytest.fixture(autouse=True)
def _no_program_of_all(monkeypatch: pytest.MonkeyPatch) -> None:
    """The elimination is looked at alone."""
    monkeypatch.setattr(entry_recording, "_FEW", 10**9)


def answers(frame: Frame) -> list[bytes]:
    solution = frame.solve()
    arrays = [solution.displacement(node) for node in frame.nodes]
    arrays += [solution.reaction(node) for node in frame.supports]
    arrays += [solution.joint_force(joint) for joint in frame.joints]
    arrays += [solution.solver.factor(name).pivot_ratio() for name in sorted(solution.plan.excited)]  # type: ignore[union-attr]
    # a zero of either sign is one and the same
    return [(array + 0.0).tobytes() for array in arrays]


@pytest.mark.parametrize("seed", range(6))
def test_the_same_bits_as_without(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of random frames, linkages and constrained structures; then of others of their topology, and other loads."""
    monkeypatch.setattr(replay, "_FEW", 0)
    PROGRAMS.clear()
    frame = as_frame((random_frame, random_constrained, random_linkage)[seed % 3](seed))
    rng = np.random.default_rng(seed)
    for _ in range(3):
        monkeypatch.setattr(replay, "MOST", 20_000)
        found = answers(frame.copy())
        assert len(PROGRAMS) > 0
        monkeypatch.setattr(replay, "MOST", 0)
        assert answers(frame.copy()) == found
        name = next(iter(frame.members))
        frame.change(name, Beam(Circle(diameter=float(rng.uniform(0.01, 0.1))), STEEL))
        frame.load(list(frame.nodes)[-1], fx=float(rng.normal()), mz=float(rng.normal()))


def test_what_can_move_is_found_from_the_list_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """A joint without stiffness where the frame that wrote the list had some, and the other way round."""
    monkeypatch.setattr(replay, "_FEW", 0)

    def arm(turning: float) -> Frame:
        frame = Frame()
        for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
            frame.node(name, (x, 0.0, 0.0))
        frame.add("AB", Beam(Circle(diameter=0.02), STEEL), "A", "B")
        frame.add("CD", Beam(Circle(diameter=0.02), STEEL), "C", "D")
        frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, turning)), "B", "C")
        frame.fix("A")
        frame.load("D", fy=1.0)
        return frame

    for _ in range(2):
        assert arm(10.0).solve().displacement("D")[1] > 0.09
        with pytest.warns(MechanismWarning):
            assert np.isnan(arm(0.0).solve().displacement("D")).all()


def test_lists_are_written_for_what_is_met_often_and_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[object] = []
    record = replay._Recorded._record
    monkeypatch.setattr(
        replay._Recorded, "_record", lambda self, *given: (written.append(self), record(self, *given))[1]
    )
    PROGRAMS.clear()
    for k in range(8):
        frame = Frame()
        frame.add_nodes(2, [(0.0, 0.0, 0.0), (1.0 + 0.1 * k, 0.0, 0.0)])
        frame.add("beam", Beam(Circle(diameter=0.02), STEEL), "0", "1")
        frame.fix("0")
        frame.load("1", fy=1.0)
        frame.solve().displacement("1")
        assert len(written) == (k >= 3)
    assert len(PROGRAMS) == 2  # of the elimination, and of the whole
