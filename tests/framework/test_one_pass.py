"""Batches of banded matrices that machine code solves in one pass: the same bits as step by step, and the truth."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section, Spring
from linkframe.framework import Frame, Solution
from linkframe.framework.solvers import stacked, stacked_pass
from linkframe.framework.solvers.stacked import StackedSolver

pytest.importorskip("llvmlite")
SECTION, E = Section(A=1e-4, Iy=1e-9, Iz=2e-9, J=2e-9), 2e11


def chain(count: int, modulus: Callable[[int], np.ndarray], *, bent: bool = False, joint: bool = False) -> Frame:
    """A clamped chain; bent in space, so that all displacements are coupled, or with a joint that does not vary."""
    frame = Frame()
    for k in range(count + 1):
        place = (0.1 * k, 0.3 * np.sin(0.7 * k) if bent else 0.0, 0.1 * np.cos(k) if bent else 0.0)
        frame.node(f"{k}", place)
        if joint and k == 3:
            frame.node("joined", place)
            frame.add("joint", Joint(stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 1e3)), "3", "joined")
    names = [f"{k}" for k in range(count + 1)]
    for k, (start, end) in enumerate(pairwise(names)):
        beam = Beam(SECTION, Material(E=modulus(k), nu=0.25))
        frame.add(f"m{k}", beam, "joined" if joint and k == 3 else start, end)
    frame.fix("0")
    frame.load(names[-1], fx=5.0, fy=3.0, fz=1.0, mx=0.2, mz=0.5)
    return frame


def step_by_step(frame: Frame, monkeypatch: pytest.MonkeyPatch) -> Solution:
    """The solution without the pass."""
    with monkeypatch.context() as patch:
        patch.setattr(stacked_pass, "of", lambda *_: None)
        solution = frame.copy().solve("banded")
        assert solution.solver._solved._band_pass is None
    return solution


def in_one_pass(frame: Frame) -> Solution:
    """The solution by the pass."""
    solution = frame.copy().solve("banded")
    assert isinstance(solution.solver, StackedSolver)
    assert solution.solver._solved._band_pass is not None
    return solution


@pytest.mark.parametrize("entries", [300, 301, 1007])
@pytest.mark.parametrize("kind", ["straight", "bent", "joint"])
def test_the_same_bits_as_step_by_step(kind: str, entries: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Displacements of all nodes, whatever the number of entries, and where few are held at a time.

    What does not vary, as a joint, is summed in another order, which leaves a rounding.
    """
    each = np.linspace(0.8, 1.25, entries)
    frame = chain(12, lambda k: E * each ** (1.0 + 0.1 * k), bent=kind == "bent", joint=kind == "joint")
    expected = step_by_step(frame, monkeypatch)
    tips = [expected.displacement(f"{k}") for k in range(13)]
    for room in (2**21, 2**17):
        monkeypatch.setattr(stacked_pass, "_ROOM", room)
        found = in_one_pass(frame)
        for k, tip in enumerate(tips):
            least = 4.0 * np.finfo(float).eps * np.abs(tip).max(axis=1, keepdims=True) * (kind == "joint")
            assert (np.abs(found.displacement(f"{k}") - tip) <= least).all()
    assert (found.status == "regular").all()


def test_wide_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same bits where loops over the band are not written out."""
    frame = Frame()
    beam = Beam(SECTION, Material(E=E * np.linspace(0.8, 1.25, 100), nu=0.25))
    for i in range(5):
        for k in range(4):
            frame.node(f"{i}.{k}", (0.3 * i, 0.4 * k, 0.1 * np.sin(i + 2.0 * k)))
            if k:
                frame.add(f"up {i}.{k}", beam, f"{i}.{k - 1}", f"{i}.{k}")
            if k and i:
                frame.add(f"across {i}.{k}", beam, f"{i - 1}.{k}", f"{i}.{k}")
        frame.fix(f"{i}.0")
    frame.load("4.3", fx=5.0, fy=3.0, fz=1.0)
    found, expected = in_one_pass(frame), step_by_step(frame, monkeypatch)
    assert found.solver._solved.bands.width > 12
    for name in ("4.3", "2.2"):
        np.testing.assert_array_equal(found.displacement(name), expected.displacement(name))


def test_matrices_that_leave_a_doubt(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are solved step by step: the same bits and status, beside others that stay as they are."""
    each = np.linspace(0.8, 1.25, 200)
    soft = np.where(np.arange(200) % 67 == 3, 1e-17, 1.0)
    frame = chain(12, lambda k: E * each * (soft if k == 5 else 1.0))
    found, expected = in_one_pass(frame), step_by_step(frame, monkeypatch)
    np.testing.assert_array_equal(found.displacement("12"), expected.displacement("12"))
    np.testing.assert_array_equal(found.status, expected.status)
    plain = in_one_pass(chain(12, lambda k: E * each)).displacement("12")
    np.testing.assert_array_equal(found.displacement("12")[soft == 1.0], plain[soft == 1.0])


@pytest.mark.parametrize("hold", [2**26, 0])
@pytest.mark.parametrize("count", [4, 24, 100])
def test_a_cantilever(count: int, hold: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """``F L / EA``, ``F L^3 / 3EI + M L^2 / 2EI`` and so on (Roark's Formulas, 7th ed., table 8.1, 1a and 3a).

    Of an exact solution on nodes whose places are rounded, a few roundings are left.
    """
    monkeypatch.setattr(stacked, "_HOLD", hold)
    modulus = E * np.linspace(0.8, 1.25, 700)
    solution = in_one_pass(chain(count, lambda _: modulus))
    A, Iy, Iz, J, L = SECTION.A, SECTION.Iy, SECTION.Iz, SECTION.J, 0.1 * count
    exact = [
        5.0 * L / A,
        3.0 * L**3 / (3.0 * Iz) + 0.5 * L**2 / (2.0 * Iz),
        L**3 / (3.0 * Iy),
        0.2 * L * 2.5 / J,
        -(L**2) / (2.0 * Iy),
        3.0 * L**2 / (2.0 * Iz) + 0.5 * L / Iz,
    ]
    np.testing.assert_allclose(solution.displacement(f"{count}"), exact / modulus[:, None], rtol=3e-15)


def test_singular_before_any_value() -> None:
    """Whether matrices are singular is known where no displacement was asked for."""
    each = np.linspace(0.8, 1.25, 300)
    solution = chain(12, lambda _: E * each).solve("banded")
    assert not solution.solver.singular(excited=True).any()


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
def test_entries_without_stiffness() -> None:
    """Where a spring of a row is zero what lies behind it is a mechanism, beside ``F Σ 1/k`` at the other entries."""
    count, entries, loose = 40, 600, np.arange(600) % 97 == 5
    stiffness = np.linspace(1.0, 3.0, count)[:, None] * np.linspace(1.0, 2.0, entries)
    given = np.where((np.arange(count) == 20)[:, None] & loose, 0.0, stiffness)
    frame = Frame()
    for k in range(count + 1):
        frame.node(f"{k}", (float(k), 0.0, 0.0))
        frame.fix(f"{k}", *(("ux",) if not k else ()), "uy", "uz", "rx", "ry", "rz")
        if k:
            frame.add(f"m{k}", Spring(given[k - 1]), f"{k - 1}", f"{k}")
    frame.load(f"{count}", fx=2.0)
    solution = in_one_pass(frame)
    end = solution.displacement(f"{count}")[:, 0]
    assert np.isnan(end[loose]).all()
    assert (solution.status[loose] == "mechanism").all()
    np.testing.assert_allclose(end[~loose], (2.0 / stiffness).sum(axis=0)[~loose], rtol=1e-14)
