"""Bounds of frames that are solved by iteration: an adjoint has as many digits as its part of the bound asks for."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame, Solution
from linkframe.framework.solvers.iterative import Iterative
from linkframe.framework.solvers.sparse import SparseSolver

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
        assert (bound <= 3.0 * (direct.error_bound(name, of) + np.abs(computed - exact))).all()


def test_a_further_bound_is_cheaper_than_six_solutions() -> None:
    solution = lattice(6, 0).solve("iterative")
    solution.error_bound("(5, 5, 5)")
    solver = solution.solver
    assert isinstance(solver, SparseSolver)
    start = iterations(solution)
    solver.factor.solve(solver.load[solver.excited])
    middle = iterations(solution)
    solution.error_bound("(4, 5, 5)")
    assert iterations(solution) - middle < 4 * (middle - start)


@pytest.mark.parametrize(("shift", "blocks"), [(0.0, False), (0.1, True)])
def test_members_along_the_axes_are_multiplied_entry_by_entry(shift: float, blocks: bool) -> None:
    """Blocks of which most is zero take twice the time; either way a product has the same bits."""
    frame, rng = lattice(4, 0), np.random.default_rng(1)
    places = np.array(list(np.ndindex(4, 4, 4)), dtype=float)
    frame.change([f"{tuple(map(int, place))}" for place in places], places + shift * rng.random(places.shape))
    solver = frame.solve("iterative").solver
    assert isinstance(solver, SparseSolver)
    factor = solver.factor
    assert isinstance(factor, Iterative)
    assert (factor._acting.format == "bsr") == blocks
    vector = rng.standard_normal(len(factor.root))
    np.testing.assert_array_equal(factor._acting @ vector, factor.scaled @ vector)
