"""Batches of frames of some size: a band for each entry, loads that vary by units, and how a way is picked."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Section
from linkframe.framework import Frame
from linkframe.framework.solvers import band_factors, stacked
from linkframe.framework.solvers.stacked import StackedSolver

E, G, A, IY, IZ, J = 2e11, 8e10, 1e-4, 1e-9, 2e-9, 2e-9
SECTION = Section(A=A, Iy=IY, Iz=IZ, J=J)


def chain(count: int, modulus: object = E, force: object = 3.0) -> Frame:
    """A clamped beam along x, 2 m long, of so many members."""
    beam = Beam(SECTION, Material(E=modulus, nu=0.25))
    frame = Frame()
    frame.node("0", (0.0, 0.0, 0.0))
    for k in range(1, count + 1):
        frame.node(f"{k}", (2.0 * k / count, 0.0, 0.0))
        frame.add(f"m{k}", beam, f"{k - 1}", f"{k}")
    frame.fix("0")
    frame.load(f"{count}", fx=5.0, fy=force, mz=0.5)
    return frame


def portal(bays: int, storeys: int, modulus: object = E) -> Frame:
    """Bays by storeys in the plane of x and z, pushed at the top."""
    beam = Beam(Section(A=0.01, Iy=1e-5, Iz=2e-5, J=2e-5), Material(E=modulus, nu=0.3, density=7850.0))
    frame = Frame()
    for s in range(storeys + 1):
        for k in range(bays + 1):
            frame.node(f"{k}.{s}", (4.0 * k, 0.0, 3.0 * s))
            if s == 0:
                frame.fix(f"{k}.0")
                continue
            frame.add(f"column {k}.{s}", beam, f"{k}.{s - 1}", f"{k}.{s}")
            if k:
                frame.add(f"beam {k}.{s}", beam, f"{k - 1}.{s}", f"{k}.{s}")
    frame.load(f"0.{storeys}", fx=1e3, fy=300.0)
    return frame


def mixed(entry: tuple[int, int] | None = None) -> Frame:
    """All that may vary over a batch (4, 6), or one entry of it: places, joints turned anyhow, supports and loads."""
    rng = np.random.default_rng(5)

    def given(*shape: int, low: float = 1.0, high: float = 2.0, trailing: int = 0) -> np.ndarray:
        array = rng.uniform(low, high, shape)
        if entry is None:
            return array
        batch = shape[: len(shape) - trailing]
        return array[tuple(k if n > 1 else 0 for k, n in zip(entry[len(entry) - len(batch) :], batch, strict=True))]

    frame, beam = Frame(), Beam(SECTION, Material(E=E, nu=0.3, density=7850.0))
    frame.node("0", (0.0, 0.0, 0.0))
    shift = given(6, 3, low=-0.05, high=0.05, trailing=1)
    for k in range(8):
        place = np.array([k + 1.0, 0.2 * (k % 2), 0.1 * k]) + shift * (k + 1) / 8
        axes, _ = np.linalg.qr(rng.standard_normal((3, 3)))
        springs = given(4, 1, 6, low=1e5, high=1e7, trailing=1)
        frame.node(f"a{k}", place)
        frame.node(f"b{k}", place)
        frame.add(f"m{k}", beam, "0" if k == 0 else f"b{k - 1}", f"a{k}")
        law = springs if k % 2 else (np.inf,) * 3 + (1e4,) * 3
        frame.add(f"j{k}", Joint(stiffness=law, axes=axes * np.sign(np.linalg.det(axes))), f"a{k}", f"b{k}")
    frame.fix("0")
    frame.node("arm", (9.0, 1.0, 1.0))
    frame.rigid("b7", "arm")
    frame.add("bell", PointMass(given(4, 1)), "arm")
    frame.load("arm", fy=given(4, 6), mx=2.0)
    frame.line_load("m3", fy=given(4, 1))
    frame.gravity((0.0, 0.0, -9.81))
    frame.offset("j2", ux=1e-3 * given(1, 6))
    frame.node("foot", (4.0, 3.0, 0.0))
    frame.add("leg", beam, "b2", "foot")
    frame.prescribe("foot", ux=0.0, uy=1e-3, uz=1e-3 * given(4, 6), rx=0.0, ry=0.0, rz=0.0)
    return frame


def assert_near(found: np.ndarray, expected: np.ndarray, within: float) -> None:
    """Relative to the largest number."""
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=within * np.abs(expected).max())


@pytest.mark.parametrize("count", [40, 400])
def test_cantilevers(count: int) -> None:
    """End deflection ``F L^3 / 3 E I + M L^2 / 2 E I`` at each modulus, scaled condition numbers 1e8 and 1e12."""
    modulus = E * np.array([0.5, 1.0, 1.7, 2.0])
    solution = chain(count, modulus).solve("banded")
    assert isinstance(solution.solver, StackedSolver)
    found = solution.displacement(f"{count}")
    stiffness = modulus * IZ
    np.testing.assert_allclose(found[:, 0], 10.0 / (modulus * A), rtol=1e-13)
    np.testing.assert_allclose(found[:, 1], 8.0 / stiffness + 1.0 / stiffness, rtol=1e-12)
    np.testing.assert_allclose(found[:, 5], 6.0 / stiffness + 1.0 / stiffness, rtol=1e-12)
    assert (solution.status == "regular").all()


def test_all_that_varies() -> None:
    """As by broadcasting, with forces and status; and each entry as the frame of that entry alone."""
    whole, other = mixed().solve("banded"), mixed().solve("broadcast")
    assert isinstance(whole.solver, StackedSolver)
    for name in ("arm", "b3", "a2"):
        assert_near(whole.displacement(name), other.displacement(name), 1e-12)
    assert_near(whole.reaction("foot"), other.reaction("foot"), 1e-10)
    assert_near(whole.joint_force("j3"), other.joint_force("j3"), 1e-10)
    assert_near(whole.all_end_forces(), other.all_end_forces(), 1e-10)
    assert (whole.status == "regular").all()
    for entry in ((0, 0), (3, 4)):
        assert_near(whole.displacement("arm")[entry], mixed(entry).solve().displacement("arm"), 1e-12)


def test_bounds_hold() -> None:
    """And are as narrow as those of the entries alone."""
    whole = portal(2, 4, E * np.array([0.7, 1.0, 1.3])).solve()
    assert isinstance(whole.solver, StackedSolver)
    for k, modulus in enumerate(E * np.array([0.7, 1.0, 1.3])):
        alone = portal(2, 4, modulus).solve("broadcast")
        found, bound = whole.displacement("0.4")[k], whole.error_bound("0.4")[k]
        assert (np.abs(found - alone.displacement("0.4")) <= bound + alone.error_bound("0.4")).all()
        assert (bound <= 1e-11 * np.abs(found).max()).all()


def test_mechanisms_are_told_entry_by_entry() -> None:
    """A joint without any spring against turning in two entries: these are named, the others solved."""
    turning = np.array([1e3, 0.0, 50.0, 0.0])
    frame = portal(3, 5, E * np.linspace(0.9, 1.1, 4))
    springs = np.stack([np.full(4, np.inf)] * 4 + [turning, np.full(4, np.inf)], axis=-1)
    place = frame.nodes["3.5"].coordinates
    frame.node("loose", place)
    frame.node("end", place + np.array([1.0, 0.0, 0.0]))
    frame.add("hinge", Joint(stiffness=springs), "3.5", "loose")
    frame.add("flag", Beam(SECTION, Material(E=E, nu=0.3)), "loose", "end")
    frame.load("end", fz=-1.0)
    solution = frame.solve()
    assert isinstance(solution.solver, StackedSolver)
    with pytest.warns(UserWarning, match=r"2 of 4 batch entries are kinematically unstable"):
        found = solution.displacement("end")
    assert solution.status.tolist() == ["regular", "mechanism", "regular", "mechanism"]
    np.testing.assert_array_equal(np.isnan(found).any(axis=-1), turning == 0.0)
    assert "end" in solution.mechanism(1)
    one = portal(3, 5, E * 0.9)
    one.load("3.5", fz=-1.0, my=1.0)
    np.testing.assert_allclose(found[0, [0, 5]], one.solve().displacement("3.5")[[0, 5]], rtol=1e-11)


def test_units_of_loads_in_a_batch() -> None:
    """Loads that vary over more than the modulus share its factors, and more of them than units cost no more."""
    frame = portal(3, 4, E * np.linspace(0.9, 1.1, 3)[:, None])
    frame.load("1.2", fz=np.linspace(-1e3, 1e3, 7), mx=np.linspace(0.0, 50.0, 7))
    whole = frame.solve()
    assert isinstance(whole.solver, StackedSolver)
    assert (whole.solver.count, whole.solver.columns) == (3, 3)
    found = whole.displacement("2.3")
    for i, k in ((0, 0), (2, 5)):
        one = portal(3, 4, E * np.linspace(0.9, 1.1, 3)[i])
        one.load("1.2", fz=np.linspace(-1e3, 1e3, 7)[k], mx=np.linspace(0.0, 50.0, 7)[k])
        assert_near(found[i, k], one.solve().displacement("2.3"), 1e-13)


def test_other_loads_and_little_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    """The next load takes up the factors; where nothing may be kept, and little done at a time, the same bits come."""
    frame = portal(3, 4, E * np.linspace(0.9, 1.1, 30))
    first = frame.solve()
    first.displacement("0.4")
    factors = first.solver._factors
    frame.load("2.1", fx=5.0)
    second = frame.solve()
    expected = [second.displacement(name) for name in ("0.4", "3.2")]
    assert second.solver._factors is factors
    for limit in ("_ROOM", "_REFINED", "_ROOM_OF_KIND", "_REFINED_OF_KIND", "_KEEP", "_HOLD"):
        monkeypatch.setattr(stacked, limit, 2**10)
    fresh = frame.copy().solve()
    found = [fresh.displacement(name) for name in ("0.4", "3.2")]
    np.testing.assert_array_equal(found, expected)


@pytest.mark.parametrize("available", [True, False])
def test_what_is_kept_lies_together(available: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Factors, scales and springs of all parts of a batch are in one memory, whether or not they are side by side."""
    monkeypatch.setattr(band_factors, "_MANY", 1)
    if not available:
        monkeypatch.setattr(band_factors, "available", lambda: False)
    monkeypatch.setattr(stacked, "_ROOM", 2**17)
    solution = portal(3, 4, E * np.linspace(0.9, 1.1, 42)).solve("banded")
    solution.displacement("0.4")
    list(solution.solver.factors(solution.solver.bands(solution.solver.loaded)))
    factors = list(solution.solver._factors.values())
    kept = [array for each in factors for array in (each.root, each._factors._bands, *each.picked._springs.values())]
    assert len(factors) > 2
    assert len({id(array.base) for array in kept}) == 1
    assert not any(np.shares_memory(one, other) for one, other in combinations(kept, 2))


def test_room_that_is_used_up() -> None:
    """What a room does not hold lies elsewhere; all begin as zeros."""
    room = band_factors.Room(30)
    arrays = [room.zeros(shape) for shape in ((3, 5), (2, 2), (7,), (2,))]
    assert [array.base is arrays[0].base for array in arrays] == [True, True, False, True]
    for k, array in enumerate(arrays):
        np.testing.assert_array_equal(array, 0.0)
        array += k + 1.0


# -- one matrix, many load cases ------------------------------------------------------------------------------------


def settled(varying: Callable[[float, float], object]) -> Frame:
    """A portal with dead loads, a settlement and loads that vary."""
    frame = portal(3, 4)
    frame.gravity((0.0, 0.0, -9.81))
    frame.line_load("beam 1.2", fz=-10.0)
    frame.prescribe("0.0", uz=varying(0.0, -1e-2))
    frame.load("1.2", fz=varying(-1e3, 2e3), mx=20.0)
    frame.load("2.2", fy=varying(3.0, 4.0))
    frame.load("2.2", fy=0.0)
    return frame


@pytest.mark.parametrize("method", ["banded", "sparse", "iterative"])
def test_load_cases_that_are_sums_of_few(method: str) -> None:
    """Units of what varies, and all that is constant together: as each load case alone."""
    share = np.linspace(0.0, 1.0, 20).reshape(4, 5)
    whole = settled(lambda low, high: low + (high - low) * share).solve(method)
    found, forces = whole.displacement("2.3"), whole.end_forces("beam 1.2")
    assert whole.solver.units[0].unknowns.shape[1] == 4
    for entry in ((0, 0), (3, 1)):
        part = share[entry]
        alone = settled(lambda low, high, part=part: low + (high - low) * part).solve(method)
        assert_near(found[entry], alone.displacement("2.3"), 1e-12)
        assert_near(forces[entry], alone.end_forces("beam 1.2"), 1e-10)
        assert (np.abs(found[entry] - alone.displacement("2.3")) <= 2.0 * whole.error_bound("2.3")[entry] + 1e-18).all()
    assert whole.nodal().shape == (4, 5, len(whole.frame.nodes), 6)


@pytest.mark.parametrize("method", ["banded", "sparse"])
def test_one_number_at_many_nodes_is_solved_for_once(method: str) -> None:
    """Of a load that acts in two ways at each of many nodes there are two units, and one with what is constant."""
    share = np.linspace(0.5, 2.0, 12)

    def pushed(share: object) -> Frame:
        frame = portal(3, 4)
        for k in range(4):
            frame.load(f"{k}.4", fx=100.0 * share, fz=-20.0 * share, mx=3.0)
        return frame

    whole = pushed(share).solve(method)
    found = whole.displacement("2.3")
    assert whole.solver.units[0].unknowns.shape[1] == 3
    for entry in (0, 7):
        assert_near(found[entry], pushed(share[entry]).solve(method).displacement("2.3"), 1e-13)


# -- the pick -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("sort", ["line", "point", "weight"])
def test_load_cases_along_members_are_each_their_own(sort: str) -> None:
    """What varies between the nodes, or with gravity, is no sum of few: against every case by itself."""
    size = np.array([-1.0, 0.5, 2.0, 3.5, 0.0, 7.0, 1.0])

    def loaded(value: object) -> Frame:
        frame = portal(3, 5)
        name = next(iter(frame.members))
        if sort == "line":
            frame.line_load(name, fy=value)
        elif sort == "point":
            frame.point_load(name, at=1.0, fz=value)
        else:
            frame.gravity(np.multiply.outer(value, [0.0, -1.0, 0.5]))
        return frame

    found = loaded(size).solve("sparse").displacement("2.3")
    for k in (0, 4, 5):
        assert_near(found[k], loaded(size[k]).solve("sparse").displacement("2.3"), 1e-12)
