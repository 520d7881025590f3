"""Bounds of frames that are solved by iteration: of displacements by energy, of forces by adjoints, which have as many
digits as their part of the bound asks for."""

from __future__ import annotations

import copy

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame, Solution
from linkframe.framework.error_bounds.adjoint import unit_forces
from linkframe.framework.error_bounds.energy import EnergyBound, energy_of_error
from linkframe.framework.error_bounds.equilibrium import EquilibriumResidual
from linkframe.framework.error_bounds.requested import requested
from linkframe.framework.solvers.iterative import Iterative
from linkframe.framework.solvers.radau import stored
from linkframe.framework.solvers.sparse import SparseSolver
from numpy.typing import NDArray

BEAM = Beam(Section(A=1e-2, Iy=1e-5, Iz=2e-5, J=2e-5), Material(E=2e11, nu=0.3))


def lattice(size: int, seed: int, *, jointed: bool = False, cases: int = 1) -> Frame:
    """A cube of beams, its nodes off their places by a tenth, clamped below and loaded at a corner of the top."""
    rng = np.random.default_rng(seed)
    frame = Frame()
    for place in np.ndindex(size, size, size):
        frame.node(f"{place}", np.array(place) + 0.1 * rng.random(3))
    for place in np.ndindex(size, size, size):
        for axis in range(3):
            other = tuple(int(k) for k in np.array(place) + np.eye(3, dtype=int)[axis])
            if other[axis] < size:
                frame.add(f"{place}{axis}", BEAM, f"{place}", f"{other}")
        if place[2] == 0:
            frame.fix(f"{place}")
    top = f"{(size - 1,) * 3}"
    if jointed:
        frame.node("hand", frame.nodes[top].coordinates)
        frame.add("grip", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 50.0)), top, "hand")
        top = "hand"
    frame.load(top, fx=1e3 * np.linspace(1.0, 2.0, cases) if cases > 1 else 1e3, fy=300.0, mz=20.0)
    return frame


def iterations(solution: Solution) -> int:
    solver = solution.solver
    assert isinstance(solver, SparseSolver)
    factors = [factor for factor in solver.matrix.factors.values() if isinstance(factor, Iterative)]
    return sum(factor.iterations for factor in factors)


@pytest.mark.parametrize(("seed", "jointed", "cases"), [(0, False, 1), (2, True, 3)])
def test_bounds_hold_and_are_as_sharp_as_by_a_factor(seed: int, jointed: bool, cases: int) -> None:
    """The truth is the direct solution refined, its own bound some digits beyond."""
    size = 4
    by_steps, direct = (lattice(size, seed, jointed=jointed, cases=cases).solve(way) for way in ("iterative", "sparse"))
    top = f"{(size - 1,) * 3}"
    asked = [("displacement", top), ("displacement", "(1, 2, 1)"), ("end_forces", "(1, 1, 0)2")]
    asked += [("joint_force", "grip")] if jointed else [("reaction", "(0, 0, 0)")]
    for of, name in asked:
        computed, bound = getattr(by_steps, of)(name), by_steps.error_bound(name, of)
        exact, left = direct.refined(name, of)
        assert (np.abs(computed - exact) <= bound + left).all()
        # what the iterations leave in the solution itself is in its bound
        own = direct.error_bound(name, of) + np.abs(computed - exact)
        more = 8.0 * greatest_errors(by_steps, direct) if of == "displacement" else 2.0 * own
        assert (bound <= own + more).all()


def greatest_errors(by_steps: Solution, direct: Solution) -> NDArray[np.float64]:
    """The greatest of all nodes, (6,): of translations, and of rotations."""
    error = np.abs(by_steps.displacements() - direct.displacements()).reshape(-1, 2, 3)
    return np.repeat(error.max(axis=(0, 2)), 3)


def test_a_solution_without_such_errors_has_the_bounds_of_adjoints() -> None:
    """Of a beam of its own along an axis, which the iterations solve to the last digit on every processor."""
    frame = Frame()
    frame.add_nodes(["A", "B"], np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    frame.add("AB", BEAM, "A", "B")
    frame.fix("A")
    frame.load("B", fx=1e3, fy=4.0, mz=20.0)
    by_steps, direct = frame.solve("iterative"), frame.solve("sparse")
    assert (by_steps.error_bound("B") <= 3.0 * direct.error_bound("B")).all()


def by_energy(solution: Solution, node: str, off: str, size: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """What the displacements of a node may be off as a bound by energy has it, and what they can be off, (6,).

    They are off by loads that are not balanced, or not known, in proportion to those on whose account a displacement
    is greatest for the energy it takes; or by the stiffness of all members.
    """
    part = next(solution.bounds.parts())
    state, solver = part.state, solution.solver
    assert isinstance(solver, SparseSolver)
    result = requested(state, node, "displacement")
    units = np.asarray(unit_forces(state, result), np.float64).reshape(6, -1)
    moved = solver.factor.solve(units.T).T
    if off == "stiffness":
        found, forces = EnergyBound(state, part.compliance, result, part.energy), solver.load[solver.excited][:, 0]
        return np.asarray(found.error_bound(), np.float64), size * np.abs(moved @ forces)
    error = np.zeros(6)
    bound = np.zeros(6)
    for k in range(6):
        if off == "balance":
            values = state.values - size * moved[k]
            other = EquilibriumResidual(state.statics, state.change, state.unknowns, values)
        else:
            other = EquilibriumResidual(state.statics, state.change, state.unknowns, state.values)
            vars(other)["unbalanced"] = size * np.abs(units[k])
        energy = energy_of_error(other, part.compliance)
        bound[k] = EnergyBound(other, part.compliance, result, energy).error_bound()[k]
        error[k] = size * (moved[k] @ units[k])
    return bound, error


@pytest.mark.parametrize(("off", "size"), [("balance", 1e-3), ("load", 1e-3), ("stiffness", 2.0**-53)])
def test_energy_takes_all_that_a_solution_may_be_off_by(off: str, size: float) -> None:
    """Loads in the shape of the unit load, of which the bound by Cauchy and Schwarz is the error itself."""
    bound, error = by_energy(lattice(3, 1).solve("iterative"), "(2, 2, 2)", off, size)
    assert (error > 0.0).all()
    assert (bound >= error).all()
    if off == "balance":
        assert (bound <= 4.0 * error).all()


@pytest.mark.parametrize("margin", [1.0, 4.0])
def test_energy_of_a_load_is_bounded_from_above(margin: float) -> None:
    """Of unit loads, of one everywhere, and of none; by the solution itself."""
    solver = lattice(4, 1).solve("iterative").solver
    assert isinstance(solver, SparseSolver)
    factor = solver.factor
    assert isinstance(factor, Iterative)
    size = len(factor.root)
    loads = np.concatenate([np.eye(size)[:, :: size // 12], np.ones((size, 1))], axis=1)
    energies = np.sqrt(np.einsum("nk,nk->k", loads, factor.solve(loads)))
    bounds = factor.energies(loads, margin)
    assert (bounds >= (1.0 - 1e-12) * energies).all()
    assert (bounds <= 1.5 * np.sqrt(margin) * energies).all()
    assert factor.energies(np.zeros((size, 1)), margin) == 0.0


def test_gauss_radau_is_exact_at_last_and_refuses_what_is_no_lower_bound() -> None:
    """Of three eigenvalues three steps tell all."""
    matrix, load = np.diag([1.0, 2.0, 5.0]), np.array([1.0, -2.0, 3.0])
    exact = float(load @ np.linalg.solve(matrix, load))
    found = [stored(load, matrix, np.copy, 0.5, steps) for steps in range(4)]
    assert found[0] == pytest.approx(2.0 * float(load @ load))
    assert (np.diff(found) < 0.0).all()
    assert found[3] == pytest.approx(exact, rel=1e-12)
    assert np.isinf(stored(load, matrix, np.copy, 4.0, 3))
    assert np.isinf(stored(load, matrix, np.copy, 0.0, 3))
    assert np.isinf(stored(load, matrix, np.negative, 0.5, 3))


def test_what_is_asked_before_changes_no_bound() -> None:
    one, other = lattice(4, 0).solve("iterative"), lattice(4, 0).solve("iterative")
    other.error_bound("(0, 0, 0)", "reaction")
    other.error_bound("(1, 1, 1)")
    np.testing.assert_array_equal(one.error_bound("(3, 3, 3)"), other.error_bound("(3, 3, 3)"))


@pytest.mark.parametrize("disturbed", [False, True])
def test_another_load_in_between_leaves_the_least_eigenvalue_as_it_is(disturbed: bool) -> None:
    """As threads that share a frame may solve at once: here while the steps that tell it are being made."""
    solver = lattice(3, 1).solve("iterative").solver
    assert isinstance(solver, SparseSolver)
    expected = solver.factor
    assert isinstance(expected, Iterative)
    other = copy.copy(expected)
    vars(other).pop("singular", None)
    own, calls, unit = other.precondition, [0], np.eye(len(other.root))[:, :1]

    def between(residual: NDArray[np.float64]) -> NDArray[np.float64]:
        calls[0] += 1
        if disturbed and calls[0] == 5:
            other.solve(unit)
        return own(residual)

    other.precondition = between
    np.testing.assert_array_equal(other.energies(unit, 2.0), expected.energies(unit, 2.0))


def test_a_further_bound_is_cheaper_than_a_solution() -> None:
    solution = lattice(6, 0).solve("iterative")
    solution.error_bound("(5, 5, 5)")
    solver = solution.solver
    assert isinstance(solver, SparseSolver)
    start = iterations(solution)
    solver.factor.solve(solver.load[solver.excited])
    middle = iterations(solution)
    solution.error_bound("(4, 5, 5)")
    assert 2 * (iterations(solution) - middle) < middle - start
