"""The ways that are gone most are short: few calls lead from one file into another."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from types import FrameType

import linkframe.framework
import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, lazily
from linkframe.framework.batched import entry_machine
from linkframe.framework.cache import ORDERS, PROGRAMS
from linkframe.models import Linkage

# Where the packages lie.
ROOT = str(Path(linkframe.framework.__file__).parent.parent)
# Stands for `functools.cached_property`: who reads such a property calls what computes it.
SEEN_THROUGH = lazily.__file__


def between_files(work: Callable[[], object]) -> int:
    """Calls of functions, on the way, from a file of the packages into another one of them."""
    count = 0

    def note(frame: FrameType, event: str, _: object) -> None:
        nonlocal count
        here = frame.f_code.co_filename
        if event != "call" or not here.startswith(ROOT) or here == SEEN_THROUGH:
            return
        above = frame.f_back
        while above is not None and (
            above.f_code.co_filename == SEEN_THROUGH or not above.f_code.co_filename.startswith((ROOT, __file__))
        ):
            above = above.f_back
        count += above is not None and above.f_code.co_filename not in (here, __file__)

    sys.setprofile(note)
    try:
        work()
    finally:
        sys.setprofile(None)
    return count


def described(x: float) -> Frame:
    """Two beams and a joint, not yet loaded."""
    beam, frame = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3)), Frame()
    for name, place in {"A": (0.0, 0.0), "B": (x, 0.0), "C": (x, 0.0), "D": (0.2, 0.1)}.items():
        frame.node(name, (*place, 0.0))
    frame.add("AB", beam, "A", "B")
    frame.add("pin", Joint(stiffness=(2e11,) * 5 + (0.0,)), "B", "C")
    frame.add("CD", beam, "C", "D")
    frame.fix("A")
    frame.fix("D", "ux", "uy", "uz")
    return frame


def test_few_calls_lead_from_a_load_to_a_displacement() -> None:
    """Of a topology that was met once, of one that is written down, and where nothing but the load has changed."""

    def solved(frame: Frame, force: float) -> None:
        frame.set_load("C", fy=force)
        frame.solve().displacement("C")

    solved(described(0.1), 100.0)  # loads what solves
    for known in (ORDERS, PROGRAMS):
        known.clear()
    frames = [described(0.1 + 0.001 * k) for k in range(6)]
    counts = [between_files(partial(solved, frame, 100.0)) for frame in frames]
    assert counts[1] < 180
    assert counts[5] < 69
    assert between_files(partial(solved, frames[5], 50.0)) < 44


@pytest.mark.skipif(not entry_machine.available(), reason="needs llvmlite and 80-bit numbers")
def test_few_calls_lead_from_a_place_to_a_displacement() -> None:
    """Of one node of a frame that was solved often: calls of Python's and NumPy's functions, those within files too."""

    def solved(height: float) -> None:
        frame.change("D", (0.2, height, 0.01))
        frame.solve().displacement("C")

    frame, count = described(0.1), 0
    frame.load("C", fy=1.0)
    for k in range(1200):  # until the program of the topology is machine code
        solved(0.1 + 1e-4 * k)

    def note(_: FrameType, event: str, __: object) -> None:
        nonlocal count
        count += event in ("call", "c_call")

    sys.setprofile(note)
    try:
        solved(0.3)
    finally:
        sys.setprofile(None)
    assert count <= 425


@pytest.mark.parametrize(("entries", "varying", "most"), [(3, "modulus", 193), (30, "load", 231)])
def test_few_calls_lead_to_a_displacement_of_a_short_batch(entries: int, varying: str, most: int) -> None:
    """Of a chain that was described, whose topology was met before: nothing is asked or evaluated a second time."""
    share = np.linspace(0.8, 1.25, entries)
    modulus, force = (200e9 * share, 1.0) if varying == "modulus" else (200e9, share)
    beam, frame = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=modulus, nu=0.3)), Frame()
    for k in range(21):
        frame.node(f"{k}", (0.0, 0.0, float(k)))
        if k:
            frame.add(f"AB{k}", beam, f"{k - 1}", f"{k}")
    frame.fix("0")
    frame.load("20", fx=force, fy=0.1 * force, fz=0.2 * force)

    def solved() -> None:
        frame.copy().solve().displacement("20")

    solved()
    assert between_files(solved) <= most


def four_bar(k: int, stiffness: np.ndarray | float) -> Linkage:
    """A four-bar with compliant pins; each k has a coupler point of its own."""
    beam = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
    linkage = Linkage(A=(0, 0), B=(0.05, 0.0866), P=(0.15 + 1e-4 * k, 0.0866), D=(0.25, 0.0866), E=(0.2, 0))
    for link, points in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        linkage.link(link, *points, beam=beam)
    springs = np.multiply.outer(stiffness, (1.0, 1.0, 1.0, 1.0, 1.0, 0.0))
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=springs)
    linkage.revolute("D", "coupler", "rocker", stiffness=springs)
    linkage.revolute("E", "rocker", "ground")
    return linkage


def test_few_calls_lead_from_a_drive_to_a_position() -> None:
    """Of a linkage that was never moved, and of one that was."""
    four_bar(0, 2e11).move(A=0.1).position("P")
    linkage = four_bar(1, 2e11)
    assert between_files(lambda: linkage.move(A=0.1).position("P")) < 112
    assert between_files(lambda: linkage.move(A=0.2).position("P")) < 35


def test_few_calls_lead_from_samples_of_stiffness_to_displacements() -> None:
    """Of a linkage described anew, moved, made a frame, solved and read, for a hundred stiffnesses."""

    def displacement(k: int) -> None:
        motion = four_bar(k, 2e11 * np.linspace(0.8, 1.2, 100)).move(A=np.radians([[10.0 + k]]))
        frame = motion.frame()
        frame.load("P", fy=100.0)
        frame.solve().displacement("P")

    displacement(0)
    assert between_files(partial(displacement, 1)) < 635
