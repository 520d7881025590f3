"""What a mechanism is, and how far it moves, does not depend on the direction in which it stands.

A bar of length l that is free to swing about one end, pulled along itself by F, grows by ``F l / (E A)``. Nothing
resists that it swings, at small displacement.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Joint
from linkframe.framework import Frame, MechanismWarning
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.pulled_bars import DIAMETER, FORCE, GROWN, INF, KINDS, LENGTH, ROD, ROTATIONS, E, pulled
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


@pytest.mark.parametrize("turn", ROTATIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_bar_that_is_pulled_along_itself_grows_in_any_direction(kind: str, turn: Rotation) -> None:
    solution = pulled(kind, turn).solve()
    assert solution.status == "statically consistent mechanism"
    moved = solution.displacement("B")
    along = turn.apply([1.0, 0.0, 0.0])
    assert_allclose(moved[:3], GROWN * along, atol=1e-12 * GROWN)
    assert_allclose(moved[3:], 0.0, atol=1e-12 * GROWN / LENGTH)
    assert solution.end_forces("AB")[6] == pytest.approx(FORCE, rel=1e-9)


@settings(max_examples=15, deadline=None)
@given(x=st.floats(-3.0, 3.0), y=st.floats(-3.0, 3.0), z=st.floats(-3.0, 3.0), kind=st.sampled_from(KINDS))
def test_in_a_direction_of_any_kind(x: float, y: float, z: float, kind: str) -> None:
    test_a_bar_that_is_pulled_along_itself_grows_in_any_direction(kind, Rotation.from_rotvec([x, y, z]))


def bent(turn: Rotation, free: tuple[float, float, float] = (INF, INF, 0.0)) -> Frame:
    """A rod clamped at A, bent by a force at B; there a second one on a hinge, or on a ball, is pulled along itself."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": LENGTH, "C": LENGTH, "D": 2.0 * LENGTH}.items():
        frame.node(name, turn.apply([x, 0.0, 0.0]))
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", ROD, "C", "D")
    frame.add("hinge", Joint((INF,) * 3 + free, axes=turn.as_matrix()), "B", "C")
    frame.fix("A")
    for node, force in {"B": (0.0, -10.0, 0.0), "D": (FORCE, 0.0, 0.0)}.items():
        frame.load(node, **dict(zip(("fx", "fy", "fz"), turn.apply(force), strict=True)))
    return frame


@pytest.mark.parametrize("turn", ROTATIONS)
def test_a_motion_along_which_the_frame_is_bent_is_not_known_in_any_direction(turn: Rotation) -> None:
    """The end of the second rod; of the first one, a cantilever, all is known."""
    solution = bent(turn).solve()
    with pytest.warns(MechanismWarning):
        end = solution.displacement("D")[:3]
    assert solution.status == "statically consistent mechanism"
    across = turn.apply([0.0, 1.0, 0.0])
    assert (np.isnan(end) == (np.abs(across) > 1e-10)).all()
    drop = -10.0 * LENGTH**3 / (3.0 * E * np.pi * DIAMETER**4 / 64.0)
    expected = turn.apply([GROWN, drop, 0.0])
    assert_allclose(solution.displacement("B")[:3], expected, atol=1e-9 * abs(drop))


def test_each_of_several_motions_is_judged_by_itself() -> None:
    """On a ball the second rod is free to tip as well, and to spin: that is across its bending, and zero."""
    turn = Rotation.from_euler("x", 0.7)
    solution = bent(turn, (0.0, 0.0, 0.0)).solve()
    with pytest.warns(MechanismWarning):
        end = solution.displacement("D")
    assert solution.free_motion().count == 3
    assert end[0] == pytest.approx(2.0 * GROWN, rel=1e-9)
    assert (np.isnan(end) == [False, True, True, False, True, True]).all()
    assert end[3] == pytest.approx(0.0, abs=1e-12)


def test_entries_in_several_directions_are_as_they_are_alone() -> None:
    turns = Rotation.from_rotvec([[0.0, 0.0, 0.0], [0.3, 0.2, -0.1], [0.0, 0.0, np.pi / 4.0]])
    along = turns.apply([1.0, 0.0, 0.0])

    def bar(directions: Array) -> Frame:
        frame = Frame()
        frame.node("A", np.zeros(3))
        frame.node("B", LENGTH * directions)
        frame.add("AB", ROD, "A", "B")
        frame.fix("A", "ux", "uy", "uz")
        frame.load("B", **{name: FORCE * directions[..., k] for k, name in enumerate(("fx", "fy", "fz"))})
        return frame

    whole = bar(along).solve().displacement("B")
    for entry, each in enumerate(along):
        assert_allclose(bar(each).solve().displacement("B"), whole[entry], rtol=0.0, atol=1e-20)


@pytest.mark.parametrize("turn", [Rotation.identity(), Rotation.random(rng=5)])
def test_a_hinged_bar_at_the_end_of_a_long_chain_in_any_direction(turn: Rotation) -> None:
    """A cantilever of many pieces and the bar on its end are pulled along themselves, and grow together."""
    pieces, frame = 150, Frame()
    for k in range(pieces + 1):
        frame.node(f"n{k}", turn.apply([k / pieces, 0.0, 0.0]))
        if k:
            frame.add(f"m{k}", ROD, f"n{k - 1}", f"n{k}")
    frame.node("C", turn.apply([1.0, 0.0, 0.0]))
    frame.node("D", turn.apply([1.0 + LENGTH, 0.0, 0.0]))
    frame.add("CD", ROD, "C", "D")
    frame.add("hinge", Joint((INF, INF, INF, INF, INF, 0.0), axes=turn.as_matrix()), f"n{pieces}", "C")
    frame.fix("n0")
    along = turn.apply([1.0, 0.0, 0.0])
    frame.load("D", **dict(zip(("fx", "fy", "fz"), FORCE * along, strict=True)))
    solution = frame.solve()
    assert solution.status == "statically consistent mechanism"
    grown = GROWN * (1.0 + LENGTH) / LENGTH
    assert_allclose(solution.displacement("D")[:3], grown * along, rtol=0.0, atol=1e-9 * grown)
