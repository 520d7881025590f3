"""Which way is picked follows what it is expected to take, without a step from size to size or batch to batch."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.cache import TERMS
from linkframe.framework.program import machine_code
from linkframe.framework.solvers import band_factors, estimate
from linkframe.framework.solvers.stacked import StackedSolver

E, MEMBERS = 2e11, (4, 8, 9, 16, 17, 20, 24, 32, 64, 128, 256, 512, 1000, 2000)
BATCHES = {"modulus": (1, 3, 10, 30, 100, 300, 1000, 3000, 10_000, 30_000, 100_000), "load": (1, 10, 1000, 100_000)}
SECTION = Section(A=1e-4, Iy=1e-9, Iz=2e-9, J=2e-9)


def chain(count: int, varying: str, entries: int) -> Frame:
    """A clamped beam along x, 2 m long, of so many members; its modulus or its load varies over a batch."""
    each = np.linspace(1.0, 2.0, entries)
    beam, frame = Beam(SECTION, Material(E=E * each if varying == "modulus" else E, nu=0.25)), Frame()
    names = [f"{k}" for k in range(count + 1)]
    frame.add_nodes(names, np.linspace(0.0, 2.0, count + 1)[:, None] * [1.0, 0.0, 0.0])
    frame.add_many([beam] * count, list(pairwise(names)))
    frame.fix("0")
    frame.load(names[-1], fx=5.0, fy=3.0 * each if varying == "load" else 3.0, mz=0.5)
    return frame


@pytest.mark.parametrize("machine", [True, False])
@pytest.mark.parametrize("varying", ["modulus", "load"])
def test_no_step_in_what_is_expected(varying: str, machine: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """From neighbour to neighbour it neither rises by more than twice what the work does nor falls by half.

    That it is what is measured, to a factor of two, is a target of the benchmark ``middle``.
    """
    if not machine:
        for module in (estimate, band_factors, machine_code):
            monkeypatch.setattr(module, "available", lambda: False)
        TERMS.clear()  # where estimates are kept
    batches = BATCHES[varying]
    seconds = np.empty((len(MEMBERS), len(batches)))
    for i, count in enumerate(MEMBERS):
        for k, entries in enumerate(batches):
            seconds[i, k] = chain(count, varying, entries).solve().plan.method.seconds
    TERMS.clear()
    assert (seconds > 0.0).all()
    for axis, at in ((0, MEMBERS), (1, batches)):
        steps = np.diff(np.log(at))
        rises = np.diff(np.log(seconds), axis=axis)
        assert (rises <= (steps[:, None] if axis == 0 else steps) + np.log(2.0)).all()
        assert (rises >= -np.log(2.0)).all()


@pytest.mark.parametrize("varying", ["modulus", "load"])
def test_short_batches_are_solved_in_bands_at_any_size(varying: str) -> None:
    """So that a frame of a few members takes no longer than one of many."""
    names = {chain(count, varying, 10).solve().plan.method.name for count in (1, 2, 4, 8, 9, 17, 64, 512)}
    assert names == {"banded"}


@pytest.mark.parametrize("entries", [3, 40])
@pytest.mark.parametrize("count", [1, 3, 20])
def test_loads_that_vary_move_the_tip_by_the_closed_form(count: int, entries: int) -> None:
    """Constant along it, varying across it and equal the other way, with a couple that varies otherwise.

    A clamped beam: ``F L / EA``, ``F L^3 / 3EI`` and ``M L^2 / 2EI`` (Roark's Formulas, 7th ed., table 8.1, 1a and 3a).
    """
    frame, force = chain(count, "modulus", 1), np.linspace(-1.0, 2.0, entries)
    couple = np.linspace(0.3, 0.1, entries) ** 2
    frame.set_load(str(count), fx=5.0, fy=force, fz=force.copy(), mz=couple)
    solution = frame.solve()
    assert solution.plan.method.name == "banded"
    A, Iy, Iz, L = SECTION.A, SECTION.Iy, SECTION.Iz, 2.0
    exact = np.zeros((entries, 6))
    exact[:, 0] = 5.0 * L / (E * A)
    exact[:, 1] = force * L**3 / (3.0 * E * Iz) + couple * L**2 / (2.0 * E * Iz)
    exact[:, 2] = force * L**3 / (3.0 * E * Iy)
    exact[:, 4] = -force * L**2 / (2.0 * E * Iy)
    exact[:, 5] = force * L**2 / (2.0 * E * Iz) + couple * L / (E * Iz)
    np.testing.assert_allclose(solution.displacement(str(count)), exact, rtol=1e-12, atol=1e-17)


@pytest.mark.parametrize("entries", [3, 300, 3000])
def test_the_least_is_picked(entries: int) -> None:
    """But that bands, which are refined, may take up to three times as long on a slender frame."""
    for count in (9, 17, 64):
        plan = chain(count, "modulus", entries).solve().plan
        condensed = [piece for _, pieces in plan.chains for piece in pieces]
        shared = estimate.broadcast(plan.rough_coupling, plan.graph, condensed)
        apart = estimate.banded(plan.rough_coupling, plan.graph)
        assert plan.method.seconds in (shared, apart)
        assert plan.method.seconds <= 3.0 * min(shared, apart)


@pytest.mark.parametrize(("count", "entries"), [(4, 60), (4, 300), (8, 30), (16, 20), (20, 10)])
def test_batches_of_a_few_hundred_columns_are_solved_in_one_pass(count: int, entries: int) -> None:
    """As longer ones are, so that they do not take longer; with the closed form's digits, an entry as by itself."""
    pytest.importorskip("llvmlite")
    frame, tip = chain(count, "modulus", entries), str(count)
    solution = frame.solve()
    found = solution.displacement(tip)
    assert isinstance(solution.solver, StackedSolver)
    assert solution.solver._solved._band_pass is not None
    share = np.linspace(1.0, 2.0, entries)
    exact = (3.0 * 2.0**3 / 3.0 + 0.5 * 2.0**2 / 2.0) / (E * SECTION.Iz * share)
    np.testing.assert_allclose(found[:, 1], exact, rtol=1e-14)
    alone = chain(count, "modulus", 1).solve().displacement(tip)
    np.testing.assert_allclose(found * share[:, None], np.broadcast_to(alone, found.shape), rtol=1e-14)


@pytest.mark.parametrize("entries", [4, 7])
def test_fewer_entries_than_lanes_are_not(entries: int) -> None:
    """They would take longer than by LAPACK, up to some size, and the pass has no room for them at any."""
    for count in (4, 64, 512):
        solver = chain(count, "modulus", entries).solve().solver
        assert isinstance(solver, StackedSolver)
        assert solver._solved._band_pass is None


def joined(count: int, entries: int) -> Frame:
    """A chain of members with springs between them that vary over a batch."""
    frame, beam = Frame(), Beam(SECTION, Material(E=E, nu=0.25))
    joint = Joint(stiffness=np.linspace(0.5, 2.0, entries)[:, None] * [2e8, 2e8, 2e8, 2e5, 2e5, 1e4])
    frame.node("b0", (0.0, 0.0, 0.0))
    frame.fix("b0")
    for k in range(1, count + 1):
        for side in "ab":
            frame.node(f"{side}{k}", (float(k), 0.1 * (k % 2), 0.0))
        frame.add(f"m{k}", beam, f"b{k - 1}", f"a{k}")
        frame.add(f"j{k}", joint, f"a{k}", f"b{k}")
    frame.load(f"b{count}", fx=1.0, fy=3.0)
    return frame


def test_joints_that_vary_are_counted() -> None:
    """Measured, bands of such chains take half the time of broadcasting, of which joints are the greater part."""
    for count, entries in ((10, 1000), (10, 3000), (10, 10_000), (20, 300), (20, 3000)):
        assert joined(count, entries).solve().plan.method.name == "banded"
    assert joined(4, 3000).solve().plan.method.name == "broadcast"
