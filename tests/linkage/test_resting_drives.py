"""Drives that rest at their reference value may have axes that those that move have not."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose

ANGLES = np.array([0.3, 0.4, 0.5])


@pytest.mark.parametrize("lengths", [0.5, np.array([0.5, 0.6, 0.7])], ids=["one", "batch"])
@pytest.mark.parametrize(
    ("upper", "lower"),
    [
        (np.zeros(3), 0.3),
        (np.zeros((2, 1)), ANGLES),
        (np.zeros((2, 1)), 0.3),
        (0.3, np.zeros((2, 1))),
        (np.zeros((4, 1, 1)), ANGLES[:2, None]),
    ],
    ids=["one place", "two axes", "a column", "the other", "three axes"],
)
def test_places_are_those_of_two_turned_bars(upper: Any, lower: Any, lengths: Any) -> None:
    tip = np.stack(np.broadcast_arrays(1.0, lengths), axis=-1)
    linkage = Linkage(A=(0, 0), B=(1, 0), C=tip)
    linkage.link("upper", "A", "B")
    linkage.link("lower", "B", "C")
    linkage.revolute("A", "ground", "upper", drive=True)
    linkage.revolute("B", "upper", "lower", drive=True)
    motion = linkage.move(A=upper, B=lower)
    a, b, length = np.broadcast_arrays(upper, lower, lengths)
    expected = np.exp(1j * a) * (1.0 + np.exp(1j * b) * 1j * length)
    assert motion.shape == expected.shape
    assert_allclose(motion.position("C")[..., 0] + 1j * motion.position("C")[..., 1], expected, atol=1e-14)


def test_no_poses_of_one_drive_and_one_of_the_other() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 0.5))
    linkage.link("upper", "A", "B")
    linkage.link("lower", "B", "C")
    linkage.revolute("A", "ground", "upper", drive=True)
    linkage.revolute("B", "upper", "lower", drive=True)
    assert linkage.move(A=[], B=[0.3]).position("C").shape == (0, 3)
