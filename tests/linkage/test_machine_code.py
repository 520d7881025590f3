"""Long batches of poses as machine code: the same poses, statuses and rates as by arrays, whatever is beside them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from unittest.mock import patch

import numpy as np
import pytest
from benchmarks.kinematics import random_lengths, stewart
from benchmarks.linkage_peers import LINKAGES, described
from linkframe.framework.cache import KERNELS
from linkframe.framework.program import calculation, machine_code
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import four_bar

pytestmark = pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed")
Drives = dict[str, np.ndarray]
Case = Callable[[], tuple[Linkage, Drives]]


@contextmanager
def by(*, machine: bool) -> Iterator[None]:
    """Machine code for all that is not short, or none."""
    with patch.object(machine_code, "available", lambda: machine), patch.object(calculation, "COMPILING", 2e-7):
        yield


def moved(case: Case, *, machine: bool) -> Motion:
    linkage, drives = case()
    with by(machine=machine):
        return linkage.move(drives, rates=dict.fromkeys(drives, 2.0))


def turning(count: int = 6000) -> np.ndarray:
    return np.linspace(-7.0, 9.0, count)


def rocking() -> np.ndarray:
    """A swing, and some angles at which the rocker cannot stand."""
    return np.concatenate([np.linspace(0.23, 2.41, 5000), np.linspace(-2.0, 3.0, 20)])


def drawn_within(width: float) -> tuple[Linkage, Drives]:
    """Bars that vary so much that some members do not go all the way, or not beside the one that leads."""
    rng = np.random.default_rng(1)
    linkage = Linkage(A=(0, 0), B=(2, 0), C=(4, 6.5), D=(6, 0))
    for name, on, length in (("crank", "AB", 2.0), ("coupler", "BC", 6.8), ("rocker", "CD", 6.8)):
        linkage.link(name, *on, length=length * (1.0 + width * rng.standard_normal(60)))
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("C", "coupler", "rocker")
    linkage.revolute("D", "rocker", "ground")
    return linkage, {"A": np.linspace(-2.0, 7.0, 100)[:, None]}


CASES: dict[str, tuple[Case, str]] = {
    "four-bar": (lambda: (described(LINKAGES["four-bar"]), {"A": turning()}), "D"),
    "six-bar": (lambda: (described(LINKAGES["six-bar"]), {"A": turning()}), "F"),
    "parallelogram, change points": (lambda: (four_bar(2, 5, 2, 5, 0.5), {"A": turning()}), "D"),
    "rocker, dead points": (lambda: (four_bar(4, 3, 4, 3.5, 0.9), {"A": rocking()}), "D"),
    "random lengths": (lambda: random_lengths(90, 100), "D"),
    "lengths that do not all go": (lambda: drawn_within(0.2), "C"),
    "Stewart platform": (lambda: stewart(1500), "P"),
}


@pytest.mark.parametrize("name", CASES)
def test_as_by_arrays(name: str) -> None:
    """Closure, gap, places and rates: to 1e-15 where nothing is singular; the states exactly."""
    case, point = CASES[name]
    ours, theirs = moved(case, machine=True), moved(case, machine=False)
    assert_array_equal(ours.is_assembled, theirs.is_assembled)
    assert_array_equal(ours.assembly.reached, theirs.assembly.reached)
    if name != "Stewart platform":
        assert_array_equal(ours.state, theirs.state)
    with by(machine=True):
        place, speed = ours.position(point), ours.velocity(point)
    size = np.nanmax(np.abs(theirs.position(point)))
    singular = "points" in name or "not all" in name
    assert_allclose(place, theirs.position(point), rtol=0.0, atol=(1e-12 if singular else 2e-15) * size)
    steady = np.abs(theirs.velocity(point)).max(axis=-1, initial=0.0) < 30.0 * size
    assert_allclose(speed[steady], theirs.velocity(point)[steady], rtol=0.0, atol=(1e-9 if singular else 1e-13) * size)


@pytest.mark.parametrize("name", ["four-bar", "parallelogram, change points", "random lengths"])
def test_a_pose_is_the_same_in_any_order_and_part(name: str) -> None:
    """The same bits: of a pose in another place of the batch, and of a part of it."""
    case, point = CASES[name]
    linkage, drives = case()
    order = np.random.default_rng(3).permutation(len(drives["A"]))
    with by(machine=True):
        whole = linkage.move(drives).position(point)
        shuffled = linkage.move(A=drives["A"][order]).position(point)
        part = linkage.move(A=drives["A"][: len(order) // 2 + 1]).position(point)
    assert_array_equal(shuffled, whole[order])
    assert_array_equal(part, whole[: len(order) // 2 + 1])


def test_a_linkage_of_the_same_kind_compiles_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[str] = []
    compiled = machine_code.compiled_kernel
    monkeypatch.setattr(machine_code, "compiled_kernel", lambda text: made.append(text) or compiled(text))
    KERNELS.clear()
    for crank in (2.0, 2.1, 1.9):
        count = len(made)
        with by(machine=True):
            motion = four_bar(crank, 7.0, 9.0, 6.0, 0.5).move(A=turning())
            motion.position("D")
        assert "machine code" in motion.explain()
        assert len(made) == (2 if crank == 2.0 else count)


def test_rates_with_an_axis_of_their_own() -> None:
    linkage, angles = four_bar(2.0, 7.0, 9.0, 6.0, 0.5), turning(5000)[:, None]
    found = []
    for machine in (True, False):
        with by(machine=machine):
            motion = linkage.move(A=angles, rates={"A": [1.0, 2.0, 3.0]})
            found.append([motion.position("D"), motion.velocity("D"), motion.acceleration("D"), motion.axes("coupler")])
    for one, other in zip(*found, strict=True):
        assert one.shape[:2] == (5000, 3)
        assert_allclose(one, other, rtol=0.0, atol=1e-13 * np.abs(other).max())


def test_short_batches_are_done_by_arrays() -> None:
    motion = four_bar(2.0, 7.0, 9.0, 6.0, 0.5).move(A=turning(300))
    assert "by NumPy" in motion.explain()


def test_far_turned_drive() -> None:
    """Beyond the turns that are followed, and where neighbouring angles are far apart, arrays take their time."""
    linkage, _ = CASES["four-bar"][0]()
    for turns in (40.0, 1e14):
        angles = np.linspace(0.0, turns, 3000)
        with by(machine=True):
            ours = linkage.move(A=angles).position("B")
        with by(machine=False):
            theirs = linkage.move(A=angles).position("B")
        assert_allclose(ours, theirs, rtol=0.0, atol=1e-14)
