"""One large frame: every way of solving it gives the same, and finds the same mechanisms."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle
from linkframe.framework import Frame, Solution
from linkframe.framework.batched.plan import Plan
from linkframe.framework.errors import FrameError, MechanismWarning
from linkframe.framework.results import dense
from linkframe.framework.results.spectrum import DENSE
from linkframe.framework.results.status import free_motions, is_singular
from linkframe.framework.solvers.dissection import bisected, dissect
from linkframe.framework.solvers.iterative import Iterative
from linkframe.framework.solvers.sparse import SparseSolver

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BEAM = Beam(Rectangle(y=0.1, z=0.2), STEEL)
CHOLMOD = importlib.util.find_spec("cvxopt") is not None
WAYS = ("banded", "sparse", "cholesky", "iterative") if CHOLMOD else ("banded", "sparse", "iterative")


def grid(nx: int, ny: int, nz: int, *, beam: Beam = BEAM, reverse: bool = False) -> Frame:
    """A space frame one metre apart, fixed at its foot and pushed at its top in two load cases."""
    frame = Frame()
    places = [(i, j, k) for k in range(nz) for j in range(ny) for i in range(nx)]
    order = places[::-1] if reverse else places
    known = set(places)
    for place in order:
        frame.node(str(place), np.array(place) + 0.1 * np.sin([place[1], place[2], place[0]]))
    for i, j, k in order:
        for ahead in ((i + 1, j, k), (i, j + 1, k), (i, j, k + 1)):
            if ahead in known:
                frame.add(f"{(i, j, k)} {ahead}", beam, str((i, j, k)), str(ahead))
    for place in order:
        if place[2] == 0:
            frame.fix(str(place))
        if place[2] == nz - 1:
            frame.load(str(place), fx=[1e3, 0.0], fy=[0.0, 2e3], mz=[0.0, 10.0])
    return frame


def tower(**options: bool) -> Frame:
    """Slender, 208 unknowns and more."""
    frame = grid(2, 2, 12, **options)
    frame.gravity((0.0, 0.0, -9.81))
    frame.line_load("(0, 0, 5) (0, 0, 6)", fx=(10.0, 50.0))
    return frame


def lattice(**options: bool) -> Frame:
    """As wide as it is high."""
    return grid(4, 4, 4, **options)


def jointed(*, reverse: bool = False) -> Frame:
    """A lattice hung on joints: ideal, stiff, soft and offset; with a rigid link, a tie, a settlement and a mass."""
    frame = grid(3, 3, 5, reverse=reverse)
    corners = [(0, 0, 4), (2, 0, 4), (0, 2, 4), (2, 2, 4)]
    stiffness = [(np.inf,) * 5 + (0.0,), (2e11,) * 5 + (1e2,), (1e4,) * 6, (np.inf,) * 3 + (1e3,) * 3]
    turned = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    for corner, k in zip(corners, stiffness, strict=True):
        at = frame.nodes[str(corner)].coordinates
        frame.node(f"foot {corner}", at)
        frame.node(f"top {corner}", at + np.array([0.0, 0.0, 1.0]))
        frame.add(f"joint {corner}", Joint(stiffness=k, axes=turned), str(corner), f"foot {corner}")
        frame.add(f"leg {corner}", BEAM, f"foot {corner}", f"top {corner}")
    for here, there in ((0, 1), (1, 3), (3, 2), (2, 0)):
        frame.add(f"edge {here} {there}", BEAM, f"top {corners[here]}", f"top {corners[there]}")
    frame.node("mast", frame.nodes["top (0, 0, 4)"].coordinates + np.array([0.0, 0.5, 2.0]))
    frame.rigid("top (0, 0, 4)", "mast")
    frame.tie("(1, 0, 4)", "(1, 2, 4)", "ux")
    frame.offset("joint (2, 0, 4)", ux=1e-3)
    frame.prescribe("(0, 0, 0)", uz=[-1e-3, 0.0])
    frame.add("bell", PointMass(50.0), "mast")
    frame.gravity((0.0, 0.0, -9.81))
    frame.load("mast", fy=[0.0, 1e3], mx=20.0)
    return frame


CASES: dict[str, Callable[..., Frame]] = {"tower": tower, "lattice": lattice, "jointed": jointed}


def results(frame: Frame, method: str) -> np.ndarray:
    """All displacements, (nodes, load cases, 6)."""
    solution = frame.solve(method)
    return np.stack([solution.displacement(name) for name in sorted(frame.nodes)])


@cache
def moved(case: str, method: str) -> np.ndarray:
    """Those of a case as it is described."""
    return results(CASES[case](), method)


def apart(one: np.ndarray, other: np.ndarray) -> float:
    """Largest difference relative to the largest of its load case."""
    largest = np.abs(one).max(axis=(0, 2))
    return float((np.abs(one - other).max(axis=(0, 2)) / largest).max())


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", WAYS)
def test_all_ways_agree(case: str, method: str) -> None:
    """With the broadcasting elimination, for several load cases."""
    assert apart(moved(case, "broadcast"), moved(case, method)) < 1e-10


@cache
def broadcast_jointed() -> Solution:
    """By the broadcasting elimination."""
    return jointed().solve("broadcast")


@pytest.mark.parametrize("method", WAYS)
def test_forces_agree(method: str) -> None:
    """Joint forces, reactions and end forces, too."""
    one, other = broadcast_jointed(), jointed().solve(method)
    for read in (
        lambda s: s.joint_force("joint (2, 0, 4)"),
        lambda s: s.joint_force("joint (0, 0, 4)"),
        lambda s: s.reaction("(0, 0, 0)"),
        lambda s: s.end_forces("leg (2, 2, 4)"),
    ):
        expected = read(one)
        np.testing.assert_allclose(read(other), expected, rtol=0.0, atol=1e-8 * np.abs(expected).max())


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("method", WAYS)
def test_order_of_description_does_not_matter(case: str, method: str) -> None:
    """Described from the other end, the frame moves the same."""
    assert apart(moved(case, method), results(CASES[case](reverse=True), method)) < 1e-10


@pytest.mark.parametrize("case", CASES)
def test_assembly_is_that_of_the_dense_matrix(case: str) -> None:
    """Stiffness, mass and load by node blocks equal element by element sums; the load that of the equilibrium."""
    plan = Plan(CASES[case]())
    solver = SparseSolver(plan)
    expected = dense.stiffness(plan)
    expected = expected.reshape(expected.shape[-2:])
    np.testing.assert_allclose(solver.stiffness.toarray(), expected, rtol=0.0, atol=1e-15 * np.abs(expected).max())
    mass = dense.mass(plan).reshape(expected.shape)
    np.testing.assert_allclose(solver.mass.toarray(), mass, rtol=0.0, atol=1e-14 * np.abs(mass).max())


@pytest.mark.parametrize("method", WAYS)
def test_mechanism_that_is_pushed(method: str) -> None:
    """A bar on a free hinge, pushed sideways: named, and its results are NaN."""
    frame = lattice()
    frame.node("loose", frame.nodes["(1, 1, 3)"].coordinates)
    frame.node("end", frame.nodes["(1, 1, 3)"].coordinates + np.array([0.0, 0.0, 1.0]))
    frame.add("hinge", Joint(stiffness=(np.inf,) * 3 + (np.inf, 0.0, np.inf)), "(1, 1, 3)", "loose")
    frame.add("bar", BEAM, "loose", "end")
    frame.load("end", fx=1.0)
    solution = frame.solve(method)
    assert set(solution.status.tolist()) == {"mechanism"}
    assert "end (+ux" in solution.mechanism(0) or "end (-ux" in solution.mechanism(0)
    with pytest.warns(MechanismWarning, match="end"):
        assert np.isnan(solution.displacement("end")).all()


@pytest.mark.parametrize("method", WAYS)
def test_mechanism_that_balances(method: str) -> None:
    """Forces in equilibrium on a frame without supports do not hide that it is free."""
    frame = grid(3, 3, 4)
    frame.supports.clear()
    frame.loads.clear()
    frame.load("(0, 0, 0)", fz=1e3)
    frame.load("(0, 0, 3)", fz=-1e3)
    top, foot = (frame.nodes[name].coordinates for name in ("(0, 0, 3)", "(0, 0, 0)"))
    moment = np.cross(top - foot, [0.0, 0.0, 1e3])
    frame.load("(0, 0, 0)", mx=moment[0], my=moment[1])
    solution = frame.solve(method)
    assert solution.status.tolist() == ["statically consistent mechanism", "statically consistent mechanism"]
    with pytest.warns(MechanismWarning, match="statically consistent mechanism"):
        assert np.isnan(solution.displacement("(2, 2, 2)")).all()


@pytest.mark.parametrize("method", WAYS)
def test_idle(method: str) -> None:
    """A free part that no load reaches leaves the results as they are."""
    frame = lattice()
    expected = frame.solve(method).displacement("(3, 3, 3)")
    frame.node("adrift", (50.0, 0.0, 0.0))
    frame.node("away", (51.0, 0.0, 0.0))
    frame.add("drifting", BEAM, "adrift", "away")
    solution = frame.solve(method)
    assert solution.status.tolist() == ["statically consistent mechanism", "statically consistent mechanism"]
    np.testing.assert_allclose(
        solution.displacement("(3, 3, 3)"), expected, rtol=0.0, atol=1e-10 * np.abs(expected).max()
    )


def test_iterations_that_do_not_converge_end_in_a_factor() -> None:
    """A hair of a beam is too ill-conditioned to iterate: same results, and `explain` says so."""
    frame = grid(2, 2, 30, beam=Beam(Rectangle(y=1e-4, z=1e-3), STEEL))
    frame.supports.clear()
    frame.fix("(0, 0, 0)")
    solution = frame.solve("iterative")
    tip = solution.displacement("(0, 0, 29)")
    assert "did not converge" in solution.explain()
    expected = frame.solve("sparse").displacement("(0, 0, 29)")
    np.testing.assert_allclose(tip, expected, rtol=0.0, atol=1e-4 * np.abs(expected).max())


def test_iterations_converge_on_a_lattice() -> None:
    """And no factor is made."""
    solution = lattice().solve("iterative")
    solution.displacement("(3, 3, 3)")
    assert "did not" not in solution.explain()
    assert isinstance(solution.solver, SparseSolver)
    factors = [factor for factor in solution.solver.matrix.factors.values() if isinstance(factor, Iterative)]
    assert factors
    assert all(factor.iterations > 0 and factor.instead is None for factor in factors)


def test_a_block_at_one_node() -> None:
    """A rigid and a flexible frame beside each other do not disturb the coarse frame."""
    frame = lattice()
    frame.node("pole", (20.0, 0.0, 0.0))
    frame.node("tip", (20.0, 0.0, 1.0))
    frame.add("mast", Beam(Rectangle(y=1e-3, z=2e-3), STEEL), "pole", "tip")
    frame.fix("pole")
    frame.load("tip", fx=1.0)
    assert apart(results(frame, "broadcast"), results(frame, "iterative")) < 1e-10


def test_unknown_methods_are_refused() -> None:
    """At once, with the remedy."""
    with pytest.raises(FrameError, match="'fastest' is unknown"):
        lattice().solve("fastest")


def test_a_varying_stiffness_is_refused() -> None:
    """The sparse ways know one matrix."""
    frame = grid(3, 3, 3, beam=Beam(Rectangle(y=np.array([0.1, 0.2]), z=0.1), STEEL))
    with pytest.raises(FrameError, match="varies over the batch"):
        frame.solve("sparse")
    assert frame.solve("broadcast").status.tolist() == ["regular", "regular"]


def test_a_missing_extra_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without cvxopt there is no CHOLMOD, and the plan does without it."""
    monkeypatch.setattr("linkframe.framework.solvers.method.find_spec", lambda name: None)
    with pytest.raises(FrameError, match=r"linkframe\[fast\]"):
        lattice().solve("cholesky")
    assert lattice().solve().plan.method.name in {"banded", "sparse", "iterative"}


def test_the_plan_says_why() -> None:
    """What is chosen follows the size, and `explain` prints it."""
    small, sagging = grid(2, 1, 2), grid(2, 1, 2)
    sagging.gravity((0.0, 0.0, -9.81))
    for frame, name in ((small, "banded"), (sagging, "broadcast")):
        method = frame.solve().plan.method
        assert method.name == name
        assert "as 12 unknowns are no more than 100" in method.reason
    large = lattice().solve()
    assert large.plan.method.name in WAYS
    assert large.plan.method.reason in large.explain()
    assert "as asked for" in lattice().solve("sparse").plan.method.reason


def test_dissection_counts_what_elimination_costs() -> None:
    """Its operations and entries are those of a factor in its order, counted on the pattern."""
    rng = np.random.default_rng(3)
    points = rng.random((60, 3))
    near = np.argsort(np.linalg.norm(points[:, None] - points[None], axis=-1), axis=1)[:, 1:4]
    pairs = np.stack([np.repeat(np.arange(60), 3), near.reshape(-1)], axis=1)
    found = dissect(points, pairs)
    assert sorted(found.order.tolist()) == list(range(60))
    pattern = np.eye(60, dtype=bool)
    pattern[pairs[:, 0], pairs[:, 1]] = pattern[pairs[:, 1], pairs[:, 0]] = True
    pattern = pattern[found.order][:, found.order]
    for k in range(60):
        below = k + 1 + np.flatnonzero(pattern[k + 1 :, k])
        pattern[np.ix_(below, below)] = True
    columns = np.tril(pattern).sum(axis=0)
    # Parts that are not cut, and separators, are counted as full: an upper bound, and not far off.
    entries, operations = 36.0 * columns.sum() - 18.0 * 60, 216.0 * (columns.astype(float) ** 2).sum()
    assert 0.9 * entries <= found.entries <= 2.0 * entries
    assert 0.5 * operations <= found.operations <= 2.0 * operations


def test_bisection_is_compact_and_even() -> None:
    """Parts of nearly equal size, whatever the order of the points."""
    points = np.random.default_rng(4).random((1000, 3))
    part = bisected(points, 50)
    sizes = np.bincount(part)
    assert sizes.max() <= 50
    assert sizes.min() >= 25
    shuffled = np.random.default_rng(5).permutation(1000)
    assert np.array_equal(bisected(points[shuffled], 50), part[shuffled])


def hinged() -> Frame:
    """A lattice with a mast on a free hinge."""
    frame = grid(3, 3, 9)
    top = frame.nodes["(2, 2, 8)"].coordinates
    frame.node("foot", top)
    frame.node("mast", top + np.array([1.0, 0.0, 0.0]))
    frame.add("mast", BEAM, "foot", "mast")
    frame.add("hinge", Joint(stiffness=(1e9,) * 5 + (0.0,)), "(2, 2, 8)", "foot")
    frame.load("mast", fy=1.0)
    return frame


def sliding() -> Frame:
    """A lattice that slides on its feet."""
    frame = grid(3, 3, 9)
    for held in frame.supports.values():
        held.pop(0)
    return frame


@cache
def dense_motion(make: Callable[[], Frame]) -> np.ndarray:
    """What can move by a dense eigenvector, of length one."""
    frame = make()
    plan = Plan(frame)
    matrix, root = dense.scaled(dense.stiffness(plan).reshape(len(plan.unknowns), -1))
    null = root * np.linalg.eigh(matrix)[1][:, 0]
    motion = (dense.global_substitution(plan, [plan.topology.number[name] for name in frame.nodes]) @ null).reshape(
        -1, 6
    )
    return motion / np.linalg.norm(motion)


@pytest.mark.parametrize("make", [hinged, sliding])
@pytest.mark.parametrize("method", WAYS)
def test_motions_are_named_the_sparse_way(method: str, make: Callable[[], Frame]) -> None:
    """The same motions as from dense eigenvectors."""
    solution = make().solve(method)
    assert solution.status[0] == "mechanism"
    assert np.all(solution.status != "regular")
    found = free_motions(solution.plan, (0,))
    assert len(found) == 1
    unit = found[0] / np.linalg.norm(found[0])
    assert abs(np.vdot(unit, dense_motion(make))) == pytest.approx(1.0, abs=1e-6)


def test_suspects_of_long_members_are_judged_entry_by_entry() -> None:
    """Springs in series with a fine arch: where the hinge's spring is absent at some entries, they alone can move."""
    frame = Frame()
    for k in range(81):
        frame.node(f"{k}", (0.05 * k, 0.3 * np.sin(0.05 * k), 0.0))
        if k:
            frame.add(f"{k}", BEAM, f"{k - 1}", f"{k}")
    frame.node("pin", frame.nodes["0"].coordinates)
    spring = np.array([[1e9] * 5 + [0.0], [1e9] * 5 + [1e5], [1e9] * 5 + [0.0]])
    frame.add("pin", Joint(stiffness=spring), "pin", "0")
    frame.fix("pin")
    plan = Plan(frame)
    assert len(plan.unknowns) > DENSE
    assert is_singular(plan, np.ones(3, dtype=bool), set(plan.unknowns)).tolist() == [True, False, True]
    assert is_singular(plan, np.array([False, True, True]), set(plan.unknowns)).tolist() == [False, False, True]
