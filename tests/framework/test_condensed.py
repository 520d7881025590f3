"""The equations that conjugate gradients solve: those of some nodes of a lattice, the others condensed out."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
import scipy
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.error_bounds import deformations
from linkframe.framework.solvers.condensed import independent
from linkframe.framework.solvers.iterative import Iterative
from linkframe.framework.solvers.sparse import SparseSolver
from numpy.typing import NDArray

Array = NDArray[np.float64]

BEAM = Beam(Section(A=1e-2, Iy=1e-5, Iz=2e-5, J=2e-5), Material(E=2e11, nu=0.3))
CUBE, TOWER, WALL = (4, 4, 4), (3, 3, 40), (3, 1, 12)


def lattice(
    shift: float = 0.1, *, braced: bool = False, jointed: bool = False, shape: tuple[int, int, int] = CUBE
) -> Frame:
    """A block of beams, its nodes off their places, clamped below; with diagonals, or with a hinge in every column."""
    places = np.array(list(np.ndindex(shape)))
    frame = Frame()
    names = [f"{k}" for k in range(len(places))]
    frame.add_nodes(names, places + shift * np.random.default_rng(0).random(places.shape))
    number = np.arange(len(places)).reshape(shape)
    pairs = [
        np.stack([np.moveaxis(number, k, 0)[:-1].ravel(), np.moveaxis(number, k, 0)[1:].ravel()]) for k in range(3)
    ]
    if braced:
        pairs.append(np.stack([number[:-1, :-1].ravel(), number[1:, 1:].ravel()]))
    frame.add_many(BEAM, np.concatenate(pairs, axis=1).T)
    if jointed:
        for k in number[:, :, -1].ravel().tolist():
            frame.node(f"hand {k}", frame.nodes[str(k)].coordinates)
            frame.add(f"grip {k}", Joint(stiffness=(*[np.inf] * 5, 50.0)), str(k), f"hand {k}")
    frame.fix_many([str(k) for k in number[:, :, 0].ravel()])
    frame.load(names[-1], fx=1e3, fy=300.0, mz=20.0)
    return frame


def factor_of(frame: Frame) -> Iterative:
    solver = frame.solve("iterative").solver
    assert isinstance(solver, SparseSolver)
    factor = solver.factor
    assert isinstance(factor, Iterative)
    return factor


KINDS: dict[str, dict[str, Any]] = {
    "plain": {},
    "along axes": {"shift": 0.0},
    "braced": {"braced": True},
    "jointed": {"jointed": True},
}


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_left_is_the_schur_complement(kind: str) -> None:
    """Solved by it, and in its own unknowns, whose blocks are ones where a node is condensed out."""
    factor = factor_of(lattice(**KINDS[kind]))
    condensed, size = factor._condensed, len(factor.root)
    load = np.random.default_rng(1).standard_normal((size, 2))
    own, rest = condensed.condensed(load)
    schur = condensed @ np.eye(len(rest))
    np.testing.assert_allclose(schur, schur.T, atol=1e-14)
    found = condensed.expanded(own, np.linalg.solve(schur, rest))
    exact = np.linalg.solve(factor.scaled.toarray(), load)
    np.testing.assert_allclose(found, exact, atol=1e-10 * np.abs(exact).max())
    energy = np.einsum("nk,nk->k", own, own) + np.einsum("nk,nk->k", rest, np.linalg.solve(schur, rest))
    np.testing.assert_allclose(energy, np.einsum("nk,nk->k", load, exact), rtol=1e-10)


@pytest.mark.parametrize("kind", KINDS)
def test_the_preconditioner_is_symmetric_and_positive(kind: str) -> None:
    factor = factor_of(lattice(**KINDS[kind]))
    inverse = factor.precondition(np.eye(6 * (len(factor._condensed.order) - factor._condensed.out)))
    np.testing.assert_allclose(inverse, inverse.T, atol=1e-9 * np.abs(inverse).max())
    assert np.linalg.eigvalsh(inverse)[0] > 0.5


@pytest.mark.parametrize("kind", KINDS)
def test_every_second_node_of_a_lattice_is_condensed_out(kind: str) -> None:
    """With diagonals they are fewer, and some of the others are coupled."""
    condensed = factor_of(lattice(**KINDS[kind]))._condensed
    share = condensed.out / len(condensed.order)
    assert (0.15 < share < 0.4) if kind == "braced" else share == 0.5
    assert (condensed.others is None) == (kind != "braced")


@pytest.mark.parametrize("seed", range(5))
def test_no_two_of_the_chosen_are_joined_and_no_more_can_be_chosen(seed: int) -> None:
    """Of a random graph in several parts, some vertices alone."""
    graph = scipy.sparse.csr_matrix(scipy.sparse.random(60, 60, 0.03, random_state=seed))
    graph = scipy.sparse.csr_matrix(graph + graph.T)
    graph.setdiag(0.0)
    graph.eliminate_zeros()
    chosen = independent(graph)
    joined = graph.astype(bool).toarray()
    assert not joined[np.ix_(chosen, chosen)].any()
    assert joined[~chosen][:, chosen].any(axis=1).all()


def test_every_second_vertex_of_a_path_is_chosen() -> None:
    """Of a long one, in few rounds, whatever the numbers of its vertices."""
    order = np.random.default_rng(0).permutation(1001)
    ones = np.ones(1000)
    graph = scipy.sparse.coo_matrix((ones, (order[1:], order[:-1])), shape=(1001, 1001))
    chosen = independent(scipy.sparse.csr_matrix(graph + graph.T))[order]
    assert (chosen[1:] != chosen[:-1]).all()


@pytest.mark.parametrize(("kind", "blocks"), [("along axes", False), ("plain", True)])
def test_members_along_the_axes_are_multiplied_entry_by_entry(kind: str, blocks: bool) -> None:
    """Blocks of which most is zero take twice the time; either way a product has the same bits."""
    coupling = factor_of(lattice(**KINDS[kind]))._condensed.coupling
    assert (coupling.format == "bsr") == blocks
    vector = np.random.default_rng(1).standard_normal(coupling.shape[1])
    np.testing.assert_array_equal(coupling @ vector, scipy.sparse.csr_matrix(coupling) @ vector)


def test_a_solution_takes_about_half_the_steps_of_one_for_all_nodes() -> None:
    """With diagonal blocks and rigid pieces for all nodes it took 284 steps, and 110 to show that nothing moves."""
    factor = factor_of(lattice(shape=(6, 6, 6)))
    load = np.zeros((len(factor.root), 1))
    load[-6:, 0] = [1e3, 300.0, 0.0, 0.0, 0.0, 20.0]
    before = factor.iterations
    factor.solve(load)
    assert factor.iterations - before < 200


def error(describe: Callable[[Array], Frame], node: str) -> float:
    """Relative error of the displacement of a node, on average over loads."""
    errors = []
    for load in np.random.default_rng(0).standard_normal((6, 3)):
        frame = describe(load)
        exact = np.asarray(frame.copy().solve("sparse").refined(node, "displacement")[0], np.float64)
        errors.append(np.abs(frame.solve("iterative").displacement(node) - exact).max() / np.abs(exact).max())
    return float(np.sqrt(np.mean(np.square(errors))))


def test_the_rounding_of_the_condensed_matrix_is_not_in_the_solution() -> None:
    """Of a tower; without a second solution, of what the first leaves, errors are five times as large on average."""
    node = str(np.prod(TOWER) - 1)

    def loaded(load: Array) -> Frame:
        frame = lattice(shape=TOWER)
        frame.set_load(node, **dict(zip(("fx", "fy", "fz"), load, strict=True)))
        return frame

    assert error(loaded, node) < 8e-12


def test_what_the_first_solution_leaves_is_summed_in_extended_precision() -> None:
    """In double precision errors of this frame are four times as large."""

    def loaded(load: Array) -> Frame:
        frame = lattice(shape=WALL)
        for name, force in zip(("34", "18", "33"), load, strict=True):
            frame.set_load(name, fx=force, fz=0.5 * force, mx=0.1)
        return frame

    assert error(loaded, "35") < 8e-13


@pytest.mark.parametrize("kind", KINDS)
def test_energies_are_bounded_for_loads_on_either_kind_of_node(kind: str) -> None:
    """Against the inverse, for a unit load on each unknown: never below, and for few loads much above."""
    factor = factor_of(lattice(shape=(3, 3, 4), **KINDS[kind]))
    loads = np.eye(len(factor.root))
    exact = np.sqrt(np.diag(np.linalg.inv(factor.matrix.toarray())))
    found = factor.energies(loads, 4.0)
    assert (found >= exact * (1.0 - 1e-12)).all()
    assert np.median(found / exact) < 3.0


def test_bounds_are_the_same_however_many_members_are_rotated_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    node = str(np.prod(CUBE) - 1)
    wanted = lattice().solve("iterative").error_bound(node)
    monkeypatch.setattr(deformations, "_MEMBERS", 7)
    np.testing.assert_array_equal(lattice().solve("iterative").error_bound(node), wanted)
