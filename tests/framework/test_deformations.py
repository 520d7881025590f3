"""Frames of middle size by deformations that do not vary: what is factorised, and what is nearly singular."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.error_bounds.equilibrium import EquilibriumResidual
from linkframe.framework.solvers import band_factors
from linkframe.framework.solvers.sparse import SparseSolver

AREA, IY, IZ, E = 0.02, 6.7e-5, 1.7e-5, 2e11
BEAM = Beam(Section(A=AREA, Iy=IY, Iz=IZ, J=4.6e-5), Material(E=E, G=8e10))


def crooked(count: int = 24) -> Frame:
    """A crooked line of members with a hinge that a spring turns, and a brace; half of it is loaded across."""
    frame = Frame()
    rng = np.random.default_rng(3)
    for k in range(count + 1):
        frame.node(f"{k}", (float(k), *(0.3 * rng.standard_normal(2) if k > 0 else (0.0, 0.0))))
    for a, b in pairwise(range(count + 1)):
        released = Beam(BEAM.section, BEAM.material, release=("end rz",)) if b == 7 else BEAM
        frame.add(f"{a}-{b}", released, f"{a}", f"{b}")
    frame.node("H", frame.nodes[f"{count}"].coordinates)
    frame.add("hinge", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 0.0, 50.0)), f"{count}", "H")
    frame.node("far", (float(count), 5.0, 0.0))
    frame.add("brace", BEAM, "H", "far")
    frame.fix("0")
    frame.fix("far")
    frame.load("12", fy=1.0, fz=2.0)
    return frame


def chain(count: int, share: np.ndarray) -> Frame:
    """A cantilever of members one metre long under a force along it and two across."""
    frame = Frame()
    names = [f"{k}" for k in range(count + 1)]
    frame.add_nodes(names, np.arange(count + 1.0)[:, None] * [1.0, 0.0, 0.0])
    frame.add_many([BEAM] * count, list(pairwise(names)))
    frame.fix("0")
    frame.load(names[-1], fx=1e3 * share, fy=5e2, fz=2e2)
    return frame


def test_what_is_factorised_is_the_stiffness() -> None:
    """The sum over springs is that over members in the axes of the nodes, and symmetric to the last bit."""
    solver = crooked().solve("banded").solver
    assert isinstance(solver, SparseSolver)
    found, expected = solver.matrix.assembled.toarray(), solver.stiffness.toarray()
    assert found is not expected
    np.testing.assert_array_equal(found, found.T)
    scale = np.sqrt(np.outer(expected.diagonal(), expected.diagonal()))
    assert np.abs((found - expected) / scale).max() < 1e-14


def test_some_of_the_deformations() -> None:
    """Those by some of the unknowns are columns of those by all, without the springs that these do not deform."""
    solver = crooked().solve("banded").solver
    assert isinstance(solver, SparseSolver)
    whole = solver.matrix.deformations
    assert whole is not None
    where = np.arange(len(solver.unknown)) % 3 == 1
    some = whole.restricted(where)
    kept = np.isin(whole.acting, some.acting)
    columns = whole.by_unknowns.toarray()[:, where]
    np.testing.assert_array_equal(some.by_unknowns.toarray(), columns[kept])
    np.testing.assert_array_equal(some.back.toarray(), columns[kept].T.astype(float))
    np.testing.assert_array_equal(some.springs, whole.springs[kept])
    assert not columns[~kept].any()


def test_a_nearly_singular_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    """A chain whose matrix is singular to double precision, against u = F L / E A and F L^3 / (3 E I).

    It takes neither the equations of equilibrium, which take a hundred times as long, nor a solution for each load.
    """

    def refuse(*_: object) -> None:
        raise AssertionError("the springs tell it")

    monkeypatch.setattr(EquilibriumResidual, "corrected", refuse)
    count, share = 2400, np.linspace(0.5, 2.0, 12)
    solution = chain(count, share).solve()
    tip = solution.displacement(f"{count}")
    assert isinstance(solution.solver, SparseSolver)
    assert solution.solver.factor.precise
    assert (solution.status == "regular").all()
    np.testing.assert_allclose(tip[:, 0], 1e3 * share * count / (E * AREA), rtol=4e-15)
    np.testing.assert_allclose(tip[:, 1], 5e2 * count**3 / (3.0 * E * IZ), rtol=4e-15)
    np.testing.assert_allclose(tip[:, 2], 2e2 * count**3 / (3.0 * E * IY), rtol=4e-15)


def test_a_long_chain_that_turns_freely_is_a_mechanism() -> None:
    """Of what is near to singular the same steps tell what is so."""
    frame = chain(900, np.ones(1))
    frame.supports.clear()
    frame.fix("0", "ux", "uy", "uz", "rx", "ry")
    with pytest.warns(Warning, match="unstable"):
        assert np.isnan(frame.solve().displacement("900")).all()


def test_lanes_are_filled_or_left_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Few entries leave most lanes idle: LAPACK then takes one after the other."""
    monkeypatch.setattr(band_factors, "available", lambda: True)
    width = band_factors.WIDTH
    assert not band_factors.side_by_side(1, 10**6, 12)
    assert not band_factors.side_by_side(3, 10**6, 12)
    assert band_factors.side_by_side(width, 10**6, 12)
    assert band_factors.side_by_side(30, 10**6, 12)
    assert band_factors.in_lanes(width + 1) == 2 * width
