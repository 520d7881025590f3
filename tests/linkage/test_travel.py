"""What is made of a linkage travels to another process, and nothing that is handed out reaches back inside."""

from __future__ import annotations

import copy
import os
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework.cache import COMPILED
from linkframe.models import Linkage
from numpy.testing import assert_array_equal

BEAM = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3, density=7850.0))
ANGLES = np.radians([0.0, 10.0, 20.0, 40.0])
WAYS: dict[str, Callable[[Any], Any]] = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    "pickle": lambda made: pickle.loads(pickle.dumps(made)),
}
READ = "import pickle, sys; print(pickle.load(open(sys.argv[1], 'rb')).reactions().drive('A').tobytes().hex())"


def four_bar(stiffness: object = None) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    linkage.link("crank", "A", "B", beam=BEAM)
    linkage.link("coupler", "B", "P", "D", beam=BEAM)
    linkage.link("rocker", "D", "E", beam=BEAM)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=stiffness)  # type: ignore[arg-type]
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    linkage.gravity((0.0, -9.81))
    linkage.load("P", fy=100.0)
    return linkage


def spatial() -> Linkage:
    """A rocker driven over a rod between two balls: its equations are no square blocks."""
    linkage = Linkage(A=(0, 0, 0), B=(0, 0.05, 0.1), C=(0.3, 0.2, 0.1), D=(0.3, 0, 0))
    linkage.link("crank", "A", "B", beam=BEAM)
    linkage.link("rod", "B", "C", beam=BEAM)
    linkage.link("rocker", "C", "D", beam=BEAM)
    linkage.revolute("A", "ground", "crank", axis=(1, 0, 0), drive=True)
    linkage.spherical("B", "crank", "rod")
    linkage.spherical("C", "rod", "rocker")
    linkage.revolute("D", "rocker", "ground", axis=(0, 0, 1))
    linkage.gravity((0.0, -9.81, 0.0))
    return linkage


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("drawn", [four_bar, spatial])
def test_a_moved_linkage_its_motion_and_reactions_travel(drawn: Callable[[], Linkage], way: str) -> None:
    linkage = drawn()
    motion = linkage.move(A=ANGLES, rates={"A": 3.0})
    reactions = motion.reactions()
    linkage.mobility()
    point = list(linkage.points)[-2]
    for before in (True, False):
        moved, held, drawing = WAYS[way](motion), WAYS[way](reactions), WAYS[way](linkage)
        for there in (moved, held.motion, drawing.move(A=ANGLES, rates={"A": 3.0})):
            assert_array_equal(there.position(point), motion.position(point))
            assert_array_equal(there.acceleration(point), motion.acceleration(point))
            assert_array_equal(there.status, motion.status)
            assert_array_equal(there.reactions().drive("A"), reactions.drive("A"))
        assert_array_equal(held.force("A"), reactions.force("A"))
        if before:
            motion.frame()


def test_a_motion_is_read_in_another_process(tmp_path: Path) -> None:
    motion = four_bar().move(A=ANGLES)
    file = tmp_path / "motion.pickle"
    file.write_bytes(pickle.dumps(motion))
    run = [sys.executable, "-c", READ, str(file)]
    told = subprocess.run(run, capture_output=True, check=True, text=True, timeout=60, env=dict(os.environ)).stdout
    assert told.strip() == motion.reactions().drive("A").tobytes().hex()


def test_a_copied_linkage_is_compiled_from_its_own_description() -> None:
    """What is kept of the original does not travel."""
    linkage = four_bar()
    linkage.move(A=ANGLES)
    assert COMPILED.get(linkage) is not None
    for way in WAYS.values():
        assert COMPILED.get(way(linkage)) is None


def test_stiffness_of_a_joint_is_not_the_array_that_was_given() -> None:
    stiffness = np.array([1e8, 1e8, 1e8, 1e5, 1e5, 0.0])
    linkage = four_bar(stiffness)
    before = linkage.move(A=ANGLES).frame().solve().displacement("P").copy()
    stiffness *= 1e-3
    assert_array_equal(linkage.move(A=ANGLES).frame().solve().displacement("P"), before)


def test_what_is_handed_out_cannot_be_written_to() -> None:
    linkage = four_bar()
    reactions = linkage.move(A=ANGLES).reactions()
    for array in (
        reactions.force("B"),
        reactions.drive("A"),
        reactions.method,
        linkage.points["P"],
        linkage.points["A"],
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[...] = 1.0


def test_what_is_printed_of_a_motion_and_its_reactions_is_a_line() -> None:
    reactions = four_bar().move(A=np.zeros((1000, 1))).reactions()
    of = "<Motion of shape (1000, 1) of <Linkage: 5 points, 3 links, 4 joints; driven: A>: 1000 regular>"
    assert repr(reactions) == f"<Reactions in joints A, B, D, E of {of}>"
    assert repr(reactions.motion) == of
