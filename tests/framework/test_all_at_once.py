"""Results of all nodes and members at once are those of each by its name."""

from __future__ import annotations

import meshio
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle, Section, Spring
from linkframe.framework import Frame, FrameError, MechanismWarning
from linkframe.framework.results.base import Results
from linkframe.framework.solvers.sparse import SparseSolver
from numpy.testing import assert_allclose, assert_array_equal

FRACTIONS = np.array([0.0, 0.21, 0.5, 0.77, 1.0])
STEEL = Material(E=2e11, nu=0.3, density=7850.0)


def check(solution: Results) -> None:
    frame, rank = solution.frame, len(solution.shape)
    at = {name: frame.length(name)[..., None] * FRACTIONS for name in frame.members}
    alike(solution.displacements(), [solution.displacement(name) for name in frame.nodes], rank)
    alike(solution.reactions(), [solution.reaction(name) for name in frame.supports], rank)
    alike(solution.all_end_forces(), [solution.end_forces(name) for name in frame.members], rank)
    every = solution.all_results()
    assert_array_equal(every.displacements, solution.displacements())
    assert_array_equal(every.reactions, solution.reactions())
    assert_array_equal(every.end_forces, solution.all_end_forces())
    assert every.joint_forces.shape == (*solution.shape, len(frame.joints), 6)
    for k, name in enumerate(frame.joints):
        assert_array_equal(every.joint_displacements[..., k, :], solution.joint_displacement(name))
        assert_array_equal(every.joint_forces[..., k, :], solution.joint_force(name))
    alike(solution.displacements_at(FRACTIONS), [solution.displacement_along(name, x) for name, x in at.items()], rank)
    alike(solution.forces_at(FRACTIONS), [solution.forces(name, x) for name, x in at.items()], rank)
    check_stresses(solution)


def alike(found: np.ndarray, each: list[np.ndarray], rank: int) -> None:
    expected = np.stack(each, axis=rank)
    assert found.shape == expected.shape
    # components of one kind share a scale: what is zero by one order of summation is rounding by another
    scale = np.nanmax(np.abs(expected), initial=0.0, axis=tuple(range(expected.ndim - 1)))
    assert_array_equal(np.isnan(found), np.isnan(expected))
    assert_allclose(found, expected, rtol=1e-12, atol=1e-12 * np.max(scale, initial=0.0))


def arm(rng: np.random.Generator, batch: tuple[int, ...]) -> Frame:
    """Two bars and a joint on a body that turns with the batch, a tapered and a released bar, and loads on them."""
    frame = Frame()
    angle = rng.uniform(0.0, 6.0, size=(*batch, 1) if batch else ())
    zero, one = np.zeros_like(angle), np.ones_like(angle)
    turn = np.stack([np.cos(angle), -np.sin(angle), zero, np.sin(angle), np.cos(angle), zero, zero, zero, one], axis=-1)
    frame.body("crank", (0.0, 0.0, 0.0), turn.reshape(*turn.shape[:-1], 3, 3))
    places = {"A": (0, 0, 0), "B": (1, 0.2, 0), "C": (1, 0.2, 0), "D": (1.7, 0.1, 0.3), "E": (2.0, -0.3, 0.1)}
    for name, place in places.items():
        frame.node(name, np.array(place) + 0.05 * rng.normal(size=3) * (name not in "BC"), body="crank")
    frame.node("F", (0.3, 0.4, 3.0))
    frame.add("AB", Beam(Rectangle(y=0.03, z=0.02), STEEL, segments=3), "A", "B")
    frame.add("pin", Joint(stiffness=(1e7, 2e7, 3e7, 1e4, 2e4, 5e3), axes=np.eye(3)[[1, 2, 0]]), "B", "C")
    frame.add("CD", Beam(Circle(diameter=0.03), STEEL, shear=True), "C", "D")
    frame.add("DE", Beam(Rectangle(y=0.03, z=0.02), STEEL, release="end rz"), "D", "E")
    frame.add("AF", Beam(Section(A=1e-4, Iy=1e-8, Iz=2e-8, J=2e-8), STEEL), "A", "F")
    frame.add("EF", Spring(stiffness=1e5), "E", "F")
    frame.fix("A")
    frame.fix("F", "ux", "uy", "uz")
    frame.load("E", fx=rng.normal(size=batch), mz=0.3)
    frame.gravity((0.0, -9.81, 1.0))
    frame.line_load("CD", fy=(-30.0, 10.0), span=(0.1, 0.5), local=True)
    frame.line_load("DE", fz=rng.normal(size=batch))
    frame.point_load("AB", at=0.4, fz=5.0)
    return frame


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 2**32 - 1), batch=st.sampled_from([(), (3,), (2, 1)]))
def test_all_at_once_is_each_by_its_name(seed: int, batch: tuple[int, ...]) -> None:
    frame = arm(np.random.default_rng(seed), batch)
    check(frame.solve())


def check_stresses(solution: Results) -> None:
    """Sections known by their properties only have no stress by name, and NaN at once."""
    stresses = solution.stresses_at(FRACTIONS)
    for k, name in enumerate(solution.frame.members):
        at = solution.frame.length(name)[..., None] * FRACTIONS
        try:
            alone = solution.stress(name, at)
        except FrameError:
            assert np.isnan(stresses[..., k, :, :]).all()
        else:
            assert_allclose(stresses[..., k, :, :], alone, rtol=1e-12, atol=1e-12 * np.abs(alone).max())


@pytest.mark.parametrize("method", ["broadcast", "sparse", "banded", "iterative"])
def test_all_at_once_whatever_the_method(method: str) -> None:
    frame = Frame()
    rod = Beam(Circle(diameter=0.02), STEEL)
    for k in range(20):
        frame.node(f"{k}", (float(k % 10), float(k // 10), 0.1 * k))
        if k >= 10:
            frame.add(f"down {k}", rod, f"{k - 10}", f"{k}")
        if k % 10:
            frame.add(f"left {k}", rod, f"{k - 1}", f"{k}")
    for k in range(10):
        frame.fix(f"{k}")
    frame.load("19", fx=[3.0, -1.0], fz=2.0)
    frame.line_load("left 15", fz=-4.0)
    frame.gravity((0.0, 0.0, -9.81))
    check(frame.solve(method))


def test_all_at_once_at_large_displacement() -> None:
    frame = Frame()
    rod = Beam(Circle(diameter=0.02), STEEL, segments=2)
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 1, 0.5)}.items():
        frame.node(name, place)
    frame.add("AB", rod, "A", "B")
    frame.add("BC", rod, "B", "C")
    frame.fix("A")
    frame.load("C", fx=[30.0, -10.0], fz=20.0)
    frame.gravity((0.0, 0.0, -9.81))
    check(frame.solve(large=True))


def test_all_at_once_of_what_is_solved_in_extended_precision() -> None:
    # a mast so slender that its stiffness is singular to double precision: tip P L^3 / 3 E I
    frame, count, rod = Frame(), 6000, Beam(Circle(diameter=0.02), STEEL)
    for k in range(count + 1):
        frame.node(f"{k}", (0.0, 0.0, float(k)))
        if k:
            frame.add(f"rod {k}", rod, f"{k - 1}", f"{k}")
    frame.fix("0")
    frame.load(f"{count}", fx=1e-9)
    solution = frame.solve("sparse")
    assert isinstance(solution.solver, SparseSolver)
    assert solution.solver.factor.precise
    found = solution.displacements()
    for k in (1, 4000, count):
        assert_array_equal(found[k], solution.displacement(f"{k}"))
    tip = 1e-9 * count**3 / (3.0 * 2e11 * np.pi * 0.02**4 / 64.0)
    assert_allclose(found[-1, 0], tip, rtol=1e-13)


def test_parts_that_differ_in_status_keep_their_own_results() -> None:
    rod = Beam(Circle(diameter=0.02), STEEL)
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 3.0, "D": 4.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", rod, "A", "B")
    frame.add("CD", rod, "C", "D")
    frame.fix("A")
    frame.load("B", fy=1.0)
    frame.load("D", fy=1.0)
    with pytest.warns(match="kinematically unstable"):
        found = frame.solve().displacements()
    assert_array_equal(np.isnan(found).all(axis=-1), [False, False, True, True])
    assert_allclose(found[1, 1], 1.0 / (3.0 * 2e11 * np.pi * 0.02**4 / 64.0), rtol=1e-12)


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
def test_few_supports_do_not_ask_for_all_displacements(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stacks begin with the displacements of all nodes: what is read by name in any case makes none."""
    solution = arm(np.random.default_rng(1), (3,)).solve("banded")
    monkeypatch.setattr(type(solution), "nodal", None)
    expected = [solution.reaction(name) for name in solution.frame.supports]
    alike(solution.reactions(), expected, len(solution.shape))


@pytest.mark.parametrize("wrong", [[-0.1], [0.2, 1.1], [[0.5]], [], [np.nan]])
def test_fractions_are_checked(wrong: list[float]) -> None:
    frame = arm(np.random.default_rng(1), ())
    with pytest.raises(FrameError, match="fractions of the members' lengths"):
        frame.solve().forces_at(wrong)


def test_a_spring_that_can_turn_is_a_mechanism_without_other_warnings(tmp_path):
    """Across its axis nothing resists: results are NaN, the file says so, and no warning of NumPy comes through."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (0.1, 0.0, 0.0))
    frame.add("spring", Spring(1e5), "A", "B")
    frame.fix("A")
    frame.load("B", fy=1.0)
    for result in ("all_end_forces", "all_results"):
        with pytest.warns(MechanismWarning, match="kinematically unstable"):
            getattr(frame.solve(), result)()
    with pytest.warns(MechanismWarning, match="kinematically unstable"):
        frame.solve().save(tmp_path / "spring.vtu")
    assert not meshio.read(tmp_path / "spring.vtu").cell_data["solved"][0].any()
