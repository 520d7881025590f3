"""Forces on the ends of members over long batches, by a program: the bits of the arrays that short ones take."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Section
from linkframe.framework import AllResults, Frame, Solution
from linkframe.framework.program import calculation, machine_code, sweep

POSES, SAMPLES = 3, 40
RNG = np.random.default_rng(5)
TURN = np.array([[0.8, -0.6, 0.0], [0.6, 0.8, 0.0], [0.0, 0.0, 1.0]])
THIN, THICK = Section(A=1e-3, Iy=1e-7, Iz=2e-7, J=1e-7), Section(A=2e-3, Iy=3e-7, Iz=5e-7, J=3e-7)


class Own(Beam):
    """A beam of a user: examined, and without formulas of its own number by number."""


def frame(*, plane: bool, singular: bool = False) -> Frame:
    """Three members at all poses, with whatever varies: modulus over the samples, places over the poses."""
    angle = np.linspace(0.2, 1.3, POSES)[:, None]
    modulus = 2e11 * np.exp(0.1 * RNG.normal(size=SAMPLES))
    steel = Material(E=modulus, nu=0.3)
    top = np.stack(np.broadcast_arrays(np.cos(angle), np.sin(angle), 0.0 if plane else 0.3), axis=-1)
    beside = top + np.array([1.0, 0.2, 0.0])
    found = Frame()
    found.body("beside", origin=(0.0, 0.0, 0.0), axes=TURN)
    for name, place in {"A": (0.0, 0.0, 0.0), "B": top, "C2": beside, "D": (2.5, 0.0, 0.0)}.items():
        found.node(name, place)
    found.node("C", beside @ TURN, body="beside")
    found.fix("A")
    found.fix("D", *(("ux", "uy", "uz", "rx", "ry") if plane else ()))
    found.add("AB", Beam(THIN, steel, end=THICK), "A", "B")
    found.add("BC", Beam(THIN, steel, segments=2, release=("start rz",)), "B", "C")
    found.add("CD", Own(THICK, steel), "C2", "D")
    stiffness = np.tile([1e8, 1e7, 1e8, 1e5, 1e5, 0.0], (POSES, 1, 1))
    if singular:
        stiffness[1] = 0.0
    found.add("C", Joint(stiffness), "C", "C2")
    found.load("B", fy=RNG.normal(size=SAMPLES), fx=3.0)
    found.line_load("AB", fy=-2.0)
    if not plane:
        found.load("C", fz=1.0, mx=0.2)
    return found


def together(solution: Solution) -> dict[str, np.ndarray]:
    """All results by name, made together."""
    return dict(zip(AllResults._fields, solution.all_results(), strict=True))


def read(one: Frame) -> dict[str, np.ndarray]:
    solution = one.solve()
    found = together(solution)
    found |= {name: solution.end_forces(name) for name in ("AB", "BC", "CD")}
    found |= {f"reaction {name}": solution.reaction(name) for name in "AD"}
    return found | {"inside": solution.forces("AB", [0.1, 0.5]), "joint": solution.joint_force("C")}


def assert_same(found: dict[str, np.ndarray], wanted: dict[str, np.ndarray]) -> None:
    """The same bits, but of displacements that were turned out of the axes of bodies instead of being found outside."""
    for name, each in wanted.items():
        near = 1e-15 * np.nanmax(np.abs(each)) if name == "displacements" else 0.0
        np.testing.assert_allclose(found[name], each, rtol=0.0, atol=near, err_msg=name)


@pytest.mark.parametrize("plane", [True, False], ids=["in the plane", "in space"])
@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "NumPy"])
def test_long_batches_have_the_bits_of_short_ones(plane: bool, compiled: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if compiled:
        pytest.importorskip("llvmlite")
        monkeypatch.setattr(calculation, "NUMPY", 1.0)  # so slow that compiling pays
    else:
        monkeypatch.setattr(machine_code, "available", lambda: False)
        monkeypatch.setattr(sweep, "CHUNK", 32)
    one = frame(plane=plane)
    found = []
    for long in (1, POSES * SAMPLES):  # all is written down; of what is read by name, ends of members alone
        monkeypatch.setattr(sweep, "LONG", long)
        found.append(read(one))
    monkeypatch.setattr(sweep, "LONG", POSES * SAMPLES + 1)
    wanted = read(one)
    for each in found:
        assert_same(each, wanted)


@pytest.mark.parametrize("compiled", [True, False], ids=["machine code", "NumPy"])
def test_all_results_of_a_long_batch_are_those_by_name_and_in_equilibrium(
    compiled: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    if compiled:
        pytest.importorskip("llvmlite")
        monkeypatch.setattr(calculation, "NUMPY", 1.0)
    else:
        monkeypatch.setattr(machine_code, "available", lambda: False)
    monkeypatch.setattr(sweep, "LONG", 1)
    one = frame(plane=False)
    solution = one.solve()
    found = together(solution)
    for name, result, names in (
        ("displacements", solution.displacement, one.nodes),
        ("reactions", solution.reaction, one.supports),
        ("joint_displacements", solution.joint_displacement, one.joints),
        ("joint_forces", solution.joint_force, one.joints),
        ("end_forces", solution.end_forces, one.members),
    ):
        wanted = np.stack([result(each) for each in names], axis=-2)
        assert found[name].shape == wanted.shape
        np.testing.assert_allclose(found[name], wanted, rtol=0.0, atol=2e-15 * np.abs(wanted).max(), err_msg=name)
    loads = np.stack(np.broadcast_arrays(3.0, dict(one.loads["B"])[1] - 2.0 * one.length("AB"), 1.0), axis=-1)
    np.testing.assert_allclose(found["reactions"].sum(axis=-2)[..., :3], -loads, rtol=0.0, atol=1e-9)


def test_a_state_that_all_entries_share_is_told_of_each() -> None:
    solution = frame(plane=True).solve()
    assert solution.status.shape == (POSES, SAMPLES)
    assert solution.status.strides == (0, 0)
    assert set(solution.status.reshape(-1).tolist()) == {"regular"}


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.MechanismWarning")
def test_what_is_lost_at_some_entries_is_so_in_what_is_read_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """Forces of a piece serve several results: those that are NaN there leave the others as they are."""
    one = frame(plane=True, singular=True)
    monkeypatch.setattr(sweep, "LONG", 1)
    once = read(one)
    solution = one.solve()
    for name in ("AB", "reaction A"):
        again = solution.end_forces("AB") if name == "AB" else solution.reaction("A")
        np.testing.assert_array_equal(again, once[name])
    monkeypatch.setattr(sweep, "LONG", POSES * SAMPLES + 1)
    assert_same(once, read(one))


def post(*, count: int = 2) -> Frame:
    """Bars that stand side by side: masses on their ends, modulus over the poses, loads over the samples alone."""
    found, steel = Frame(), Material(E=2e11 * np.linspace(1.0, 2.0, POSES)[:, None], nu=0.3)
    for k in range(count):
        found.node(f"A{k}", (3.0 * k, 0.0, 0.0))
        found.node(f"B{k}", (3.0 * k, 1.0, 0.0))
        found.fix(f"A{k}")
        found.add(f"AB{k}", Beam(THIN, steel), f"A{k}", f"B{k}")
        found.add(f"mass{k}", PointMass(2.0), f"B{k}")
        found.add(f"foot{k}", PointMass(1.0), f"A{k}")
        found.load(f"B{k}", fx=np.linspace(1.0, 3.0, SAMPLES), mz=0.5)
    found.gravity((0.0, -9.81, 0.0))
    return found


def redundant() -> Frame:
    """Two posts and two ideal joints beside each other between their tops, which are rigid with these."""
    found = post()
    for k in range(2):
        for side in "CD":
            found.node(f"{side}{k}", (1.5, 1.0, 0.0 if side == "C" else 0.4))
        found.rigid(f"B{k}", f"C{k}", f"D{k}")
    for side in "CD":
        found.add(side, Joint((np.inf,) * 6), f"{side}0", f"{side}1")
    return found


def apart() -> Frame:
    """Two posts of which one is no longer supported at a pose."""
    found = post()
    found.node("C", (3.0, 0.0, 0.0))
    found.node("E", (3.0, -1.0, 0.0))
    stiffness = np.tile([1e8, 1e8, 1e8, 1e5, 1e5, 1e5], (POSES, 1, 1))
    stiffness[1] = 0.0
    found.add("EC", Beam(THIN, Material(E=2e11, nu=0.3)), "E", "C")
    found.fix("E", "ux")
    found.add("joint", Joint(stiffness), "C", "A1")
    found.load("C", fx=1.0)
    return found


def left_out() -> Frame:
    found = post(count=1)
    found.exclude(np.arange(SAMPLES) < 3)
    return found


def with_clearance() -> Frame:
    found = post(count=1)
    found.node("C", (0.0, 1.0, 0.0))
    found.fix("C")
    found.add("stop", Joint((1e6, 1e6, 0.0, 0.0, 0.0, 0.0), clearance=1e-6), "B0", "C")
    return found


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.MechanismWarning")
@pytest.mark.parametrize("described", [post, redundant, apart, left_out, with_clearance])
def test_whatever_stands_beside_numbers_of_a_long_batch(
    described: Callable[[], Frame], monkeypatch: pytest.MonkeyPatch
) -> None:
    """What varies over less than the batch, shares of redundant joints, other parts, entries left out, contact."""
    one = described()
    wanted = together(one.solve())
    monkeypatch.setattr(sweep, "LONG", 1)
    monkeypatch.setattr(sweep, "CHUNK", 32)
    found = together(one.solve())
    for name, each in wanted.items():
        np.testing.assert_allclose(found[name], each, rtol=0.0, atol=1e-12 * np.nanmax(np.abs(each), initial=0.0))
    if described is post:
        load = np.linspace(1.0, 3.0, SAMPLES)
        exact = np.stack(np.broadcast_arrays(-load, 3.0 * 9.81, 0.0, 0.0, 0.0, load - 0.5), axis=-1)[:, None]
        np.testing.assert_allclose(found["reactions"] - exact, 0.0, rtol=0.0, atol=1e-9)


@pytest.mark.parametrize(("count", "shape"), [(3, (7, 13)), (5, ()), (2, (1,)), (12, (361, 1001))])
def test_zeros_begin_with_lines_of_the_cache(count: int, shape: tuple[int, ...]) -> None:
    """Each of them, wherever it ends, and many with a large page."""
    found = sweep.zeros(count, shape)
    assert found.shape == (count, *shape)
    assert not found.any()
    place, itemsize = found.__array_interface__["data"][0], found.itemsize
    assert found.strides[0] % (8 * sweep.LINE) == place % (8 * sweep.LINE) == 0
    assert found.size < sweep.NEW or place % (itemsize * sweep.PAGE) == 0
    for each in found:
        assert each.flags.c_contiguous
    found[...] = 1.0
    assert found.sum() == found.size
