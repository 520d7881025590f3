"""Local axes: the stated rule, exact zeros in a plane, rotations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose

BAR, STEEL = Rectangle(y=0.1, z=0.05), Material(E=200e9, nu=0.3)
BEAM = Beam(BAR, STEEL)
coordinate = st.floats(-10.0, 10.0).filter(lambda value: abs(value) > 1e-3)
chords = st.tuples(coordinate, coordinate, coordinate).map(np.array)


@pytest.mark.parametrize(
    ("chord", "axes"),
    [
        ((2.0, 0.0, 0.0), [[1, 0, 0], [0, 1, 0], [0, 0, 1]]),
        ((-2.0, 0.0, 0.0), [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]),
        ((0.0, 3.0, 0.0), [[0, 1, 0], [-1, 0, 0], [0, 0, 1]]),
        ((0.0, 0.0, 2.0), [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
        ((0.0, 0.0, -2.0), [[0, 0, -1], [0, 1, 0], [1, 0, 0]]),
        ((3.0, 0.0, 4.0), [[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]]),
    ],
)
def test_stated_rule(chord: tuple[float, float, float], axes: list[list[float]]) -> None:
    assert_allclose(BEAM.axes(np.array(chord)), axes, atol=1e-16)


@given(chord=chords, up=st.none() | chords)
def test_right_handed_along_the_chord_and_nearest_to_up(chord: np.ndarray, up: np.ndarray | None) -> None:
    direction = np.array([0.0, 0.0, 1.0]) if up is None else up
    if np.linalg.norm(np.cross(direction, chord)) < 1e-3 * np.linalg.norm(direction) * np.linalg.norm(chord):
        return
    R = Beam(BAR, STEEL, up=up).axes(chord)
    assert_allclose(R @ R.T, np.eye(3), atol=1e-14)
    assert_allclose(np.cross(R[0], R[1]), R[2], atol=1e-14)
    assert_allclose(R[0], chord / np.linalg.norm(chord), atol=1e-15)
    # nothing of `up` lies along y, and what lies along z points the same way
    assert abs(R[1] @ direction) < 1e-14 * np.linalg.norm(direction)
    assert R[2] @ direction > 0.0


@given(x=coordinate, y=coordinate)
def test_a_member_in_the_xy_plane_stays_there_exactly(x: float, y: float) -> None:
    R = BEAM.axes(np.array([x, y, 0.0]))
    assert np.array_equal(R[2], [0.0, 0.0, 1.0])
    assert not np.any(R[:2, 2])
    turned = Beam(BAR, STEEL, up=(0.3, 1.0, 0.0)).axes(np.array([1.0, 0.0, 0.0]))
    assert not np.any(turned[[0, 2], 2])


def test_nearly_vertical_members_lose_no_digits() -> None:
    R = BEAM.axes(np.array([1e-9, 2e-9, 1.0]))
    assert_allclose(R @ R.T, np.eye(3), atol=1e-15)
    assert_allclose(R[1], np.array([-2.0, 1.0, 0.0]) / np.sqrt(5), rtol=1e-15, atol=0.0)


def test_a_chord_may_be_given_as_a_list() -> None:
    """Of whole numbers, too."""
    assert_allclose(BEAM.axes([0, 2, 0]), [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]], atol=0.0)


def test_a_batch_is_its_members() -> None:
    chords = np.array([[[1.0, 2.0, 3.0], [0.0, 0.0, 1.0]], [[0.0, 0.0, -2.0], [1.0, 0.0, 0.0]]])
    batch = BEAM.axes(chords)
    for index in np.ndindex(2, 2):
        assert np.array_equal(batch[index], BEAM.axes(chords[index]))
    ups = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]])
    several = Beam(BAR, STEEL, up=ups)
    assert several.shape == (3,)
    assert several.stiffness_matrix(1.0).shape == (12, 12)
    for index, up in enumerate(ups):
        assert_allclose(
            several.axes(np.array([1.0, 0.2, 0.3]))[index], Beam(BAR, STEEL, up=up).axes(np.array([1.0, 0.2, 0.3]))
        )


def test_up_along_the_member_is_refused() -> None:
    beam = Beam(BAR, STEEL, up=(0.0, 0.0, 2.0))
    with pytest.raises(
        FrameError, match=r"up = \(0.0, 0.0, 2.0\) is parallel to the member; give a direction across it"
    ):
        beam.check(np.array([0.0, 0.0, -1.0]))
    beam.check(np.array([1.0, 0.0, -1.0]))
