"""Parts of a frame that supports alone have in common: each is solved where it is read, whatever way that is done."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, MechanismWarning
from linkframe.framework.results import primary, status
from linkframe.framework.solvers.sparse import SparseSolver
from linkframe.framework.solvers.stacked import StackedSolver

E = 210e9
WAYS = ("banded", "sparse", "iterative", "broadcast")


def arms(lengths: dict[str, int], modulus: object = E, hinge: object = 50.0) -> Frame:
    """Clamped arms of 0.1 m members, bent at each node, loaded at their ends; a hinge in the middle of that named B."""
    rod = Beam(Circle(diameter=0.02), Material(E=modulus, nu=0.3))
    frame = Frame()
    for at, (name, count) in enumerate(lengths.items()):
        for k in range(count + 1):
            frame.node(f"{name}{k}", (0.1 * k, float(at), 0.03 * (k % 2)))
            if name == "B" and 2 * k == count:
                frame.node("twin", (0.1 * k, float(at), 0.03 * (k % 2)))
                law = np.asarray(hinge)[..., None] * np.array([0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
                law = law + np.array([1e8, 1e8, 1e8, 1e6, 1e6, 0.0])
                frame.add("hinge", Joint(stiffness=law), f"{name}{k}", "twin")
            if k:
                start = "twin" if name == "B" and 2 * (k - 1) == count else f"{name}{k - 1}"
                frame.add(f"{name}m{k}", rod, start, f"{name}{k}")
        frame.fix(f"{name}0")
        frame.load(f"{name}{count}", fx=1.0, fy=np.array(3.0), mz=0.2)
    return frame


@pytest.mark.parametrize("way", WAYS)
def test_what_moves_in_one_part_leaves_the_others(way: str) -> None:
    """Warnings are errors: nothing of the mechanism is even looked at."""
    alone = arms({"A": 20}).solve(method=way)
    solution = arms({"A": 20, "B": 20}, hinge=0.0).solve(method=way)
    for of, name in (("displacement", "A20"), ("reaction", "A0"), ("end_forces", "Am3")):
        found, there = getattr(solution, of)(name), getattr(alone, of)(name)
        np.testing.assert_allclose(found, there, rtol=1e-9, atol=1e-9 * np.abs(there).max())
        assert (np.abs(found - there) <= solution.error_bound(name, of) + alone.error_bound(name, of)).all()
    members = solution.sensitivity("A20", "uy").members
    assert float(members["Am1"].sum()) < 0.0
    assert not members["Bm1"].any()
    with pytest.warns(MechanismWarning, match="B20"):
        assert np.isnan(solution.displacement("B20")).all()
    assert solution.status == "mechanism"
    assert np.isfinite(solution.displacements()[: len(alone.frame.nodes)]).all()


def test_what_moves_in_one_part_of_a_batch_leaves_the_others() -> None:
    modulus, hinge = E * np.linspace(1.0, 2.0, 4), np.array([50.0, 0.0, 50.0, 0.0])
    solution = arms({"A": 20, "B": 20}, modulus, hinge).solve(method="banded")
    assert isinstance(solution.solver, StackedSolver)
    found = solution.displacement("A20")
    np.testing.assert_allclose(found * modulus[:, None], np.broadcast_to(found[0] * E, (4, 6)), rtol=1e-10)
    with pytest.warns(MechanismWarning, match="2 of 4"):
        moved = solution.displacement("B20")
    assert np.isnan(moved).any(axis=1).tolist() == [False, True, False, True]
    assert solution.status.tolist() == ["regular", "mechanism"] * 2


@pytest.mark.parametrize("varying", [False, True])
def test_parts_that_nobody_reads_are_not_factorised(varying: bool) -> None:
    solution = arms({"A": 20, "C": 60, "D": 80}, E * np.linspace(1.0, 2.0, 3) if varying else E).solve(method="banded")
    solution.displacement("A20")
    solution.error_bound("A20")
    factors = solution.primary.factors
    if varying:
        assert {factor.bands.size for factor in factors.stacked.values()} == {6 * 20}
        return
    assert isinstance(solution.solver, SparseSolver)
    assert {len(factor.root) for factor in solution.solver.matrix.factors.values()} == {6 * 20}


def test_many_parts_are_solved_together() -> None:
    """And one by one only where something moves."""
    lengths = {chr(ord("A") + k): 4 for k in range(primary.PARTS + 1)}
    regular = arms(lengths).solve(method="banded")
    regular.displacement("A4")
    assert isinstance(regular.solver, SparseSolver)
    assert {len(factor.root) for factor in regular.solver.matrix.factors.values()} == {len(regular.plan.unknowns)}
    moving = arms(lengths, hinge=0.0).solve(method="banded")
    np.testing.assert_allclose(moving.displacement("A4"), regular.displacement("A4"), rtol=1e-12)


def test_bands_tell_mechanisms_as_eigenvalues_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of parts that no load reaches, which are looked at for the status alone."""
    modulus, hinge = E * np.linspace(1.0, 2.0, 6), np.array([50.0, 0.0, 1e-3, 0.0, 1e-9, 1e6])
    told = []
    for dense in (np.inf, 0.0):
        monkeypatch.setattr(status, "_DENSE", dense)
        frame = arms({"A": 1, "B": 20}, modulus, hinge)
        del frame.loads["B20"]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", MechanismWarning)
            told.append(frame.solve(method="broadcast").status.tolist())
    assert told[0] == told[1]
    assert told[0][:2] == ["regular", "statically consistent mechanism"]


def test_long_chains_are_no_mechanisms() -> None:
    """Where one step of refinement is enough it takes away more than a later one may."""
    modulus = E * np.linspace(1.0, 2.0, 20)
    for count in (70, 90, 100, 110, 130):
        solution = arms({"A": count}, modulus).solve(method="banded")
        assert solution.is_regular.all()
        found = solution.displacement(f"A{count}")[:, 1] * modulus
        np.testing.assert_allclose(found, found[0], rtol=1e-13)


def test_batches_of_slender_frames_keep_their_digits() -> None:
    """Where both ways take about the same time the one is taken that refines."""
    modulus = E * np.linspace(1.0, 2.0, 300)
    frame = arms({"A": 200}, modulus)
    found = frame.solve().displacement("A200")[:, 1] * modulus
    np.testing.assert_allclose(found, found[0], rtol=1e-12)
