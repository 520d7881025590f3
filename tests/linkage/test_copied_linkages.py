"""Copies of a linkage, each of which is changed by itself."""

from __future__ import annotations

import copy
import pickle
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.models import Linkage


def through_bytes(linkage: Linkage) -> Linkage:
    found: Linkage = pickle.loads(pickle.dumps(linkage))
    return found


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, through_bytes, Linkage.alike])
def test_what_is_added_to_one_is_not_in_the_other(way: Callable[[Linkage], Linkage]) -> None:
    linkage = Linkage(A=(0, 0), P=(0.2, 0), Q=(0, 0.3))
    linkage.link("arm", "A", "P")
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.load("P", fy=3.0)
    torque = linkage.move(A=0.1).reactions().drive("A")
    other = way(linkage)
    other.point("R", (1.0, 1.0))
    other.link("further", "P", "R")
    other.revolute("P", "arm", "further", drive=True)
    other.load("P", fy=5.0, link="arm")
    other.spring("P", "Q", stiffness=10.0, length=0.1)
    other.gravity((0, -9.81))
    assert [len(vars(linkage)[name]) for name in ("points", "links", "joints", "drives", "springs", "loads")] == [
        3, 1, 1, 1, 0, 1,
    ]  # fmt: skip
    assert not linkage.weight.any()
    assert np.array_equal(linkage.move(A=0.1).reactions().drive("A"), torque)
    assert len(other.loads) == 2


def test_springs_of_a_rigid_joint_are_not_written_to() -> None:
    """They are kept with the joint, which must stay as it was described."""
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", drive=True)
    with pytest.raises(ValueError, match="read-only"):
        linkage.joints["A"].full_stiffness[:] = 7.0
