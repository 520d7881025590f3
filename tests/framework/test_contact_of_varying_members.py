"""Contact in long batches whose members or places vary: as each entry alone, and the truth by 64 digits.

All unit offsets are solved for in one pass over such a batch, and, where geometry alone decides whether offsets meet
any stiffness, with the members of the first entry.
"""

from __future__ import annotations

import gc
from dataclasses import dataclass
from typing import Any
from weakref import WeakSet

import numpy as np
import pytest
import skfem
from linkframe import Beam, Frame, Joint, Material, Rectangle
from linkframe.elements import Spring
from linkframe.framework import LineElement, Solution, straight_shapes
from linkframe.framework.clearances import contact_search, unit_offsets
from linkframe.framework.clearances.member_stiffness import member_stiffness
from linkframe.framework.clearances.unit_motions import UnitMotions, UnitMotionsPerEntry
from linkframe.framework.composed import Composed
from linkframe.framework.program import machine_code
from numpy.testing import assert_allclose, assert_array_equal
from reference.mixed_method import solve
from reference.structure import Member, Structure
from reference.structure import Spring as Springs

BAR = Rectangle(y=0.02, z=0.01)
SOFT, STIFF = (2e8, 2e8, 2e8, 2e5, 2e5, 0.0), (2e8, 2e8, 2e8, 2e5, 2e5, 1e5)
# Springs about the pins that are rounding beside the members.
LOOSE = (2e8, 2e8, 2e8, 2e5, 2e5, 1e-7)
COUNT = 20_000
AT = [0, 7, 4711, COUNT - 1]
Array = np.ndarray[Any, np.dtype[Any]]
Numbers = dict[str, Any]


def drawn(*varies: str) -> Numbers:
    """Numbers of a three-hinged arch, of which loads and clearances vary, and what is named."""
    rng = np.random.default_rng(3)
    whole = {
        "fx": rng.uniform(-20.0, 20.0, COUNT),
        "fy": rng.uniform(-150.0, -50.0, COUNT),
        "gap": rng.uniform(0.5e-4, 1.5e-4, (3, COUNT)),
        "E": 2e11 * np.exp(0.1 * rng.normal(size=(2, COUNT))),
        "x": 1.0 + 0.1 * rng.uniform(-1.0, 1.0, COUNT),
        "y": np.full(COUNT, 0.5),
        "stiffness": np.exp(0.1 * rng.normal(size=(COUNT, 1))),
    }
    fixed = {"E": np.full(2, 2e11), "x": np.ones(()), "y": np.array(0.5), "stiffness": np.ones(1)}
    return whole | {name: value for name, value in fixed.items() if name not in varies}


def arch(given: Numbers, springs: tuple[float, ...] = SOFT) -> Frame:
    """Two beams on pins with clearance at 0, 1 and 2 m; with springs that resist rotation it is indeterminate."""
    top = np.stack(np.broadcast_arrays(given["x"], given["y"], 0.0), axis=-1)
    places = {"c0": np.zeros(3), "a0": np.zeros(3), "b0": top, "b1": top, "a1": np.array([2.0, 0.0, 0.0])}
    frame = Frame()
    for name, place in (places | {"c1": places["a1"]}).items():
        frame.node(name, place)
    for k, modulus in enumerate(given["E"]):
        frame.add(f"m{k}", Beam(BAR, Material(E=modulus, nu=0.3)), f"a{k}", f"b{k}")
    for k, ends in enumerate((("c0", "a0"), ("b0", "b1"), ("a1", "c1"))):
        stiffness = given["stiffness"] * np.array(springs)
        joint = Joint(stiffness, clearance=given["gap"][k], clearance_directions=("ux", "uy"))
        frame.add(f"j{k}", joint, *ends)
    for name in ("c0", "c1"):
        frame.fix(name)
    frame.load("b0", fx=given["fx"], fy=given["fy"])
    return frame


def one(given: Numbers, entry: int) -> Numbers:
    """The numbers of one entry."""
    return {name: few(name, value, entry) for name, value in given.items()}


def few(name: str, value: Any, entries: int | slice) -> Any:
    """A number at some entries; itself where it does not vary."""
    lead = {"gap": 1, "E": 1}.get(name, 0)
    return value[(slice(None),) * lead + (entries,)] if value.ndim > lead and value.shape[lead] == COUNT else value


def truth(given: Numbers, entry: int, springs: tuple[float, ...], offset: np.ndarray) -> Any:
    """The arch by 64 digits with imposed offsets (3, 3) in its joints."""
    mine, frame = one(given, entry), arch(one(given, entry), springs)
    nodes = {name: tuple(map(float, frame.position(name))) for name in frame.nodes}
    members = {
        f"m{k}": Member(f"a{k}", f"b{k}", E=float(E), G=float(E) / 2.6, A=BAR.A, Iy=BAR.Iy, Iz=BAR.Iz, J=BAR.J)
        for k, E in enumerate(mine["E"])
    }
    stiffness = tuple(map(float, (mine["stiffness"] * np.array(springs)).reshape(6)))
    ends = {name: (joint.first, joint.second) for name, joint in frame.joints.items()}
    return solve(
        Structure(
            nodes=nodes,
            members=members,
            joints={name: Springs(*pair, stiffness) for name, pair in ends.items()},
            supports={name: dict.fromkeys(("ux", "uy", "uz", "rx", "ry", "rz"), 0.0) for name in ("c0", "c1")},
            loads={"b0": (float(mine["fx"]), float(mine["fy"]), 0.0, 0.0, 0.0, 0.0)},
            offsets={f"j{k}": (*map(float, each), 0.0, 0.0, 0.0) for k, each in enumerate(offset)},
        )
    )


VARIES = [("E",), ("x",), ("stiffness",), ("E", "x"), ("E", "stiffness"), ("E", "x", "stiffness")]


@pytest.mark.parametrize("springs", [SOFT, STIFF], ids=["determinate", "indeterminate"])
@pytest.mark.parametrize("varies", VARIES, ids=" ".join)
def test_as_each_entry_alone_and_by_64_digits(varies: tuple[str, ...], springs: tuple[float, ...]) -> None:
    """Journals are displaced along their forces, by the clearance; displacements to rounding."""
    given = drawn(*varies)
    solution = arch(given, springs).solve()
    moved = solution.displacement("b0")
    assert (solution.status == "regular").all()
    # geometry alone tells whether the contact is determinate
    assert solution.clearances is not None
    assert (solution.clearances.determinate is not None) == (springs is SOFT and "x" not in varies)
    contacts = [solution.contact(f"j{k}") for k in range(3)]
    for entry in AT:
        alone = arch(one(given, entry), springs).solve()
        assert_allclose(moved[entry], alone.displacement("b0"), rtol=0.0, atol=1e-13 * np.abs(moved[entry]).max())
        offset = np.stack([each.offset[entry] for each in contacts])
        exact = truth(given, entry, springs, offset)
        for k, each in enumerate(contacts):
            force = exact.joint_force[f"j{k}"][:3].astype(np.float64)
            radius = given["gap"][k, entry]
            assert_allclose(offset[k], radius * force / np.linalg.norm(force), rtol=0.0, atol=2e-13 * radius)
            assert each.status[entry] == "closed"
        displaced = exact.displacement["b0"].astype(np.float64)
        assert_allclose(moved[entry], displaced, rtol=0.0, atol=1e-13 * np.abs(displaced).max())


@pytest.mark.parametrize("count", [1001, 2048, 3000, 17_000])
@pytest.mark.parametrize("varies", VARIES, ids=" ".join)
def test_shorter_batches(varies: tuple[str, ...], count: int) -> None:
    """Above a thousand entries the members of the first are tried, above 2048 all offsets are found in one pass."""
    whole = drawn(*varies)
    given = {name: few(name, value, slice(count)) for name, value in whole.items()}
    solution = arch(given, STIFF).solve()
    moved = solution.displacement("b0")
    for entry in (0, 7, count - 1):
        alone = arch(one(whole, entry), STIFF).solve()
        assert_allclose(moved[entry], alone.displacement("b0"), rtol=0.0, atol=1e-13 * np.abs(moved[entry]).max())


@pytest.mark.parametrize("with_loads", [False, True], ids=["alone", "with loads"])
@pytest.mark.parametrize("springs", [SOFT, STIFF, LOOSE], ids=["determinate", "indeterminate", "soft springs"])
def test_one_pass_for_all_offsets(
    springs: tuple[float, ...], with_loads: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same as of unit offsets that are entries of a batch: forces, motions, and whether springs deform."""
    given = drawn("E", "x", "stiffness")
    with monkeypatch.context() as patch:
        if with_loads:
            patch.setattr(contact_search, "_MANY", 0)
        else:
            patch.setattr(UnitMotionsPerEntry, "with_loads", lambda *_, **__: None)
        found = asked(given, springs, patch)
    assert isinstance(found, UnitMotionsPerEntry)
    for name in ("of", "with_loads"):
        monkeypatch.setattr(UnitMotionsPerEntry, name, lambda *_, **__: None)
    other = asked(given, springs, monkeypatch)
    assert not isinstance(other, UnitMotionsPerEntry)
    assert found.entries == other.entries == len(found.stiffness) * COUNT
    assert found.strained == other.strained == (springs is not SOFT)
    if with_loads:
        forces = arch(given, springs).solve(clearance=False).joint_force
        expected = np.stack([forces(f"j{k}")[:, i] for k in range(3) for i in range(2)])
        assert_allclose(found.under_loads, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
    number = other.plan.topology.number
    rows = [other.plan.tree.row(number["b1"], k) for k in range(6)]
    loaded = [6 * number["b0"], 6 * number["b0"] + 1]
    pairs = [
        (found.stiffness, other.stiffness),
        (found.rows(rows), other.rows(rows)),
        (found.moved(loaded), other.moved(loaded)),
        (found.moved(loaded[:1]), other.moved(loaded[:1])),
        (np.stack(found.largest() or ()), np.stack(other.largest() or ())),
    ]
    scale = 2e8 if springs is STIFF else 1.0
    for (mine, theirs), size in zip(pairs, (scale, 1.0, 1.0, 1.0, 1.0), strict=True):
        assert_allclose(mine, theirs, rtol=0.0, atol=1e-9 * size)


@pytest.mark.parametrize("springs", [SOFT, STIFF], ids=["determinate", "indeterminate"])
def test_another_method_that_is_asked_for(springs: tuple[float, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Long batches of large frames are solved by bands, in which offsets take no pass of their own."""
    given = {name: few(name, value, slice(17_000)) for name, value in drawn("E", "x", "stiffness").items()}
    expected = arch(given, springs).solve()
    monkeypatch.setattr(UnitMotionsPerEntry, "_found", property(lambda self: pytest.fail("a pass over the batch")))
    solution = arch(given, springs).solve(method="banded")
    assert solution.plan.method.name == "banded"
    moved = solution.displacement("b0")
    assert_allclose(moved, expected.displacement("b0"), rtol=0.0, atol=1e-9 * np.abs(moved).max())


def asked(given: Numbers, springs: tuple[float, ...], patch: pytest.MonkeyPatch) -> UnitMotions:
    """The unit motions from which a solution takes the stiffness against offsets last."""
    seen: list[UnitMotions] = []
    members = unit_offsets._members

    def noted(motions: UnitMotions, *others: Any) -> Array:
        seen.append(motions)
        return members(motions, *others)

    with patch.context() as inside:
        inside.setattr(unit_offsets, "_members", noted)
        arch(given, springs).solve().displacement("b0")
    return seen[-1]


def test_entries_close_to_singular_without_clearances() -> None:
    """They keep the digits that they have alone, by extended precision, beside others that need none."""
    given = drawn("E", "x", "y", "stiffness") | {"gap": np.zeros(3)}
    low = np.arange(COUNT) % 2000 == 7
    given["y"] = np.where(low, 1e-7, given["y"])
    first = arch(given).solve().end_forces("m0")  # in one pass with the pivots that tell which entries are close
    solution = arch(given).solve()
    forces, found = [solution.joint_force(f"j{k}") for k in range(3)], solution.all_results()
    assert_array_equal(np.stack(forces, axis=-2), found.joint_forces)
    for entry in (7, 4007, 1):
        exact = truth(given, entry, SOFT, np.zeros((3, 3)))
        displaced = exact.displacement["b0"].astype(np.float64)
        size = np.abs(displaced).max()
        assert_allclose(solution.displacement("b0")[entry], displaced, rtol=0.0, atol=1e-14 * size)
        assert_allclose(found.displacements[entry, 2], displaced, rtol=0.0, atol=1e-14 * size)
        ends = exact.end_forces["m0"].astype(np.float64)
        assert_allclose(first[entry], ends, rtol=0.0, atol=1e-11 * np.abs(ends).max())
        force = exact.joint_force["j1"].astype(np.float64)
        assert_allclose(forces[1][entry], force, rtol=0.0, atol=1e-14 * np.abs(force).max())


def test_entries_that_are_mechanisms_or_left_out() -> None:
    """They have no results, beside others that have those which they have alone."""
    given = drawn("E", "x", "y", "stiffness")
    flat, absent = np.arange(COUNT) % 1000 == 7, np.arange(COUNT) % 1000 == 11
    given["y"] = np.where(flat, 0.0, given["y"])
    frame = arch(given)
    frame.exclude(absent)
    solution = frame.solve()
    with pytest.warns(UserWarning, match="kinematically unstable"):
        moved = solution.displacement("b0")
    assert (solution.status[flat] == "mechanism").all()
    assert (solution.status[absent] == "absent").all()
    assert np.isnan(moved[flat | absent]).any(axis=-1).all()
    for entry in (0, 1, 4711):
        alone = arch(one(given, entry)).solve().displacement("b0")
        assert_allclose(moved[entry], alone, rtol=0.0, atol=1e-13 * np.abs(alone).max())


def test_mechanisms_that_the_first_pass_finds(monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever is read first; and offsets of entries close to one are found with the digits that they need."""
    given = drawn("E", "x", "y", "stiffness")
    flat = np.arange(COUNT) % 1000 == 7
    given["y"] = np.where(flat, 0.0, given["y"])
    solution = arch(given | {"gap": np.zeros(3)}).solve()
    with pytest.warns(UserWarning, match="kinematically unstable"):
        ends = solution.end_forces("m0")
    assert_array_equal(np.isnan(ends).any(axis=-1), flat)
    given["y"] = np.where(flat, 1e-7, given["y"])
    assert not isinstance(asked(given, SOFT, monkeypatch), UnitMotionsPerEntry)


SIZES = {"by chunks": (COUNT, COUNT, COUNT), "trailing unknowns": (1, 1, COUNT), "at once": (40, 40, 40)}


@pytest.mark.parametrize("sizes", SIZES.values(), ids=SIZES)
def test_results_per_unit_of_an_offset(sizes: tuple[int, int, int]) -> None:
    """Of springs' forces and displacements: half of those of a batch in which each offset is two units."""
    whole = drawn("E", "x", "stiffness")
    moduli, places, stiffness = sizes
    given = whole | {"gap": np.zeros(3), "fx": 0.0, "fy": 0.0}
    given |= {"E": whole["E"][:, :moduli], "x": whole["x"][:places], "stiffness": whole["stiffness"][:stiffness]}
    names, count = ["j0", "j1", "j2"], max(sizes)
    apart, batch = arch(given, STIFF), arch(given, STIFF)
    for k, name in enumerate(names):
        apart.offset(name, ux=np.full(count, k + 1.0))
        batch.offset(name, ux=2.0 * (np.arange(3) == k).reshape(3, 1))
    expected = batch.solve()
    solution = Solution._per_unit(expected.plan, apart)
    values = solution.plan.rhs_parameters.values
    places_of = {float(value.flat[0]): k for k, value in enumerate(values) if isinstance(value, np.ndarray)}
    number = solution.plan.topology.number["b1"]
    rows = [solution.plan.tree.row(number, k) for k in range(6)]
    pairs = [(name, 0) for name in names]
    found = solution.against_offsets(pairs, [lambda values: values(rows)], [places_of[k + 1.0] for k in range(3)])
    assert found is not None
    forces = np.stack([expected.joint_force(name)[..., 0] for name in names]) / 2.0
    moved, scale = expected.displacement("b1") / 2.0, np.abs(forces).max()
    assert_allclose(found[0], -0.5 * (forces + np.swapaxes(forces, 0, 1)), rtol=0.0, atol=1e-13 * scale)
    assert_allclose(forces, np.swapaxes(forces, 0, 1), rtol=0.0, atol=1e-9 * scale)
    assert_allclose(found[1], moved, rtol=0.0, atol=1e-13 * np.abs(moved).max())


class Tie(Spring):
    """A spring that says that it deforms as any other."""

    deforms_as = "tie"


def test_a_member_without_stiffness_at_the_first_entry() -> None:
    """A tie that is slack there makes the arch determinate there, and only there."""
    given = drawn()
    tie = np.where(np.arange(COUNT) == 0, 0.0, 1e6)

    def tied(numbers: Numbers, stiffness: Any) -> Frame:
        frame = arch(numbers)
        frame.add("tie", Tie(stiffness), "a0", "b1")
        return frame

    whole = tied(given, tie).solve()
    moved = whole.displacement("b0")
    for entry in AT:
        alone = tied(one(given, entry), tie[entry]).solve()
        assert_allclose(moved[entry], alone.displacement("b0"), rtol=0.0, atol=1e-12 * np.abs(moved[entry]).max())
        for k in range(3):
            own, other = whole.contact(f"j{k}"), alone.contact(f"j{k}")
            assert_allclose(own.offset[entry], other.offset, rtol=0.0, atol=1e-12 * given["gap"][k, entry])


@dataclass(frozen=True, eq=False)
class PlainBeam(Composed):
    """A beam whose end forces have no formula for programs."""

    kind = property(lambda self: self)


@pytest.mark.parametrize("joint", [(np.inf,) * 5 + (1e5,), (np.inf,) * 5 + (0.0,), STIFF], ids=str)
@pytest.mark.parametrize("way", ["heat", "own element"])
def test_ideal_joints_of_elements_without_a_formula(way: str, joint: tuple[float, ...]) -> None:
    """Forces of ideal joints follow from those on the ends of members, which are those of each offset."""
    given = drawn("E", "x")

    def framed(numbers: Numbers) -> Frame:
        frame = arch(numbers, joint)
        if way == "heat":
            frame.add_form(skfem.LinearForm(lambda v, w: w.force * v.grad[0]), on="m0", force=100.0)
        else:
            frame.change("m0", PlainBeam(frame.members["m0"].element))
        return frame

    whole = framed(given).solve()
    moved = whole.displacement("b0")
    for entry in AT:
        alone = framed(one(given, entry)).solve()
        assert_allclose(moved[entry], alone.displacement("b0"), rtol=0.0, atol=1e-12 * np.abs(moved[entry]).max())
        for k in range(3):
            offset, gap = whole.contact(f"j{k}").offset[entry], given["gap"][k, entry]
            assert_allclose(offset, alone.contact(f"j{k}").offset, rtol=0.0, atol=1e-11 * gap)


@dataclass(frozen=True, eq=False)
class Guide(LineElement):
    """Five stiff springs: the end slides across the member at an angle to its local z."""

    angle: Array

    @property
    def shape(self) -> tuple[int, ...]:
        return self.angle.shape

    def springs(self, length: Array) -> tuple[Array, Array]:
        shape = np.broadcast_shapes(np.shape(length), self.angle.shape)
        rows = np.zeros((*shape, 5, 12), np.result_type(length, np.float64))
        for spring, dof in enumerate((0, 3, 4, 5)):
            rows[..., spring, dof], rows[..., spring, dof + 6] = -1.0, 1.0
        y, z = np.cos(self.angle), np.sin(self.angle)
        rows[..., 4, 7], rows[..., 4, 1], rows[..., 4, 5] = y, -y, -y * length
        rows[..., 4, 8], rows[..., 4, 2], rows[..., 4, 4] = z, -z, z * length
        return np.full((*shape, 5), 1e8), rows

    def shape_functions(self, length: Array, x: Array) -> Array:
        return straight_shapes(length, x)


def test_an_element_whose_deformations_depend_on_its_numbers() -> None:
    """What it resists is a matter of its own numbers as well, so that no entry stands for the others."""
    angle = np.linspace(0.2, 1.4, 2000)

    def guided(turn: Any) -> Frame:
        frame = Frame()
        for name, x in {"c": 0.0, "a": 0.0, "b": 1.0}.items():
            frame.node(name, (x, 0.0, 0.0))
        frame.add("guide", Guide(np.asarray(turn)), "a", "b")
        frame.add("j", Joint((2e8,) * 3 + (2e5,) * 3, clearance=1e-4, clearance_directions=("uy", "uz")), "c", "a")
        frame.fix("c")
        frame.fix("b", "uz")
        frame.load("b", fx=3.0, fy=10.0)
        return frame

    whole = guided(angle).solve()
    moved = whole.displacement("b")
    for entry in (0, 1000, 1999):
        alone = guided(angle[entry]).solve()
        assert_allclose(moved[entry], alone.displacement("b"), rtol=0.0, atol=1e-12 * np.abs(moved[entry]).max())
        assert_allclose(whole.contact("j").offset[entry], alone.contact("j").offset, rtol=0.0, atol=1e-14)


@pytest.mark.skipif(not machine_code.available(), reason="needs llvmlite")
def test_bits_do_not_depend_on_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    """All operations are those of NumPy, and no sum is a matrix product."""
    given = drawn("E", "x", "stiffness")
    found = arch(given, STIFF).solve().displacement("b0")
    monkeypatch.setattr(machine_code, "available", lambda: False)
    assert_array_equal(found, arch(given, STIFF).solve().displacement("b0"))


def test_redundant_ideal_joints() -> None:
    """Ideal joints in a redundant loop share forces by least squares, offset by offset."""
    given = drawn("E")
    ideal = (np.inf, np.inf, np.inf, np.inf, np.inf, 0.0)
    given["stiffness"] = np.ones(1)
    solution = arch(given, ideal).solve()
    moved = solution.displacement("b0")
    for entry in AT:
        alone = arch(one(given, entry), ideal).solve()
        assert_allclose(moved[entry], alone.displacement("b0"), rtol=0.0, atol=1e-12 * np.abs(moved[entry]).max())


def two_beams(places: Array, gap: Array, fy: Array) -> Frame:
    """Two beams clamped to each other at B, on journals at A and C, of which that at C leaves x free: determinate."""
    frame = Frame()
    for name, place in zip(("A", "B", "C", "a", "c"), (*places, places[0], places[2]), strict=True):
        frame.node(name, place)
    beam = Beam(Rectangle(y=0.02, z=0.01), Material(E=2e11, nu=0.3))
    frame.add("AB", beam, "A", "B")
    frame.add("BC", beam, "B", "C")
    frame.add("ja", Joint((2e8, 2e8, 2e8, 2e5, 2e5, 0.0), clearance=gap[0]), "a", "A")
    frame.add("jc", Joint((0.0, 2e8, 2e8, 2e5, 2e5, 0.0), clearance=gap[1]), "c", "C")
    frame.fix("a")
    frame.fix("c")
    frame.load("B", fx=30.0, fy=fy)
    return frame


def test_rounding_is_told_from_stiffness_where_all_places_vary() -> None:
    """No offset meets a stiffness: it is compared with that of members whose stiffness no array holds."""
    rng = np.random.default_rng(1)
    places = np.array([[0.0, 0.0, 0.0], [0.5, 0.2, 0.0], [1.0, 0.0, 0.0]])[:, None] * np.ones((3, COUNT, 3))
    places[..., :2] += rng.uniform(-0.1, 0.1, (3, COUNT, 2))
    gap, fy = 1e-4 * rng.uniform(0.5, 1.5, (2, COUNT)), rng.uniform(-150.0, 150.0, COUNT)
    solution = two_beams(places, gap, fy).solve()
    assert "no offset meets any stiffness" in solution.explain()
    for k in range(3):
        alone = two_beams(places[:, k], gap[:, k], fy[k]).solve()
        assert "no offset meets any stiffness" in alone.explain()
        mine, theirs = solution.displacement("B")[k], alone.displacement("B")
        assert_allclose(mine, theirs, rtol=0.0, atol=1e-12 * np.abs(theirs).max())


@pytest.mark.parametrize("varies", ["E", "x", "E x", ""])
def test_stiffness_of_members(varies: str) -> None:
    """The largest of E A / L; and of 3 E I / L, the shear 12 E I / L³ at half the length."""
    given = drawn(*varies.split())
    frame = arch(given, STIFF)
    plan = frame.solve(clearance=False).plan
    translation, rotation = (np.broadcast_to(each, frame.shape) for each in member_stiffness(plan))
    lengths = np.stack([np.broadcast_to(frame.length(name), frame.shape) for name in frame.members])
    moduli = np.stack([np.broadcast_to(each.element.material.E, frame.shape) for each in frame.members.values()])
    section = next(iter(frame.members.values())).element.section
    assert_allclose(translation, (moduli * section.A / lengths).max(axis=0), rtol=1e-14)
    assert_allclose(rotation, (3.0 * moduli * max(section.Iy, section.Iz) / lengths).max(axis=0), rtol=1e-14)


@pytest.mark.parametrize("count", [3, 3000])
def test_what_another_entry_resists_is_no_matter(count: int) -> None:
    """At one entry nothing resists one joint; the stiffness against the others is that of the entry alone."""

    def described(modulus: Array, stop: Array) -> Frame:
        """A flat arch on a journal, with hardly any stiffness in its hinges, and a lever that a stop may hold."""
        frame = Frame()
        for name, place in {
            "c0": (0, 0),
            "a0": (0, 0),
            "b0": (1, 1e-3),
            "b1": (1, 1e-3),
            "a1": (2, 0),
            "c1": (2, 0),
        }.items():
            frame.node(name, (*place, 0.0))
        for name, x in {"p": 0.0, "q": 0.0, "r": 1.0, "w": 1.0}.items():
            frame.node(name, (x, 2.0, 0.0))
        for name, ends in {"m0": ("a0", "b0"), "m1": ("b1", "a1"), "lever": ("q", "r")}.items():
            frame.add(name, Beam(BAR, Material(E=modulus, nu=0.3)), *ends)
        hinge = (2e8, 2e8, 2e8, 2e5, 2e5, 2.4e-6)
        frame.add("j0", Joint(hinge, clearance=1e-4, clearance_directions=("ux", "uy")), "c0", "a0")
        frame.add("j1", Joint(hinge), "b0", "b1")
        frame.add("j2", Joint(hinge), "a1", "c1")
        frame.add("jq", Joint(STIFF, clearance=1e-4, clearance_directions=("ux", "uy")), "p", "q")
        held = np.zeros((*stop.shape, 6))
        held[..., 1] = stop
        frame.add("stop", Joint(held), "r", "w")
        for name in ("c0", "c1", "p", "w"):
            frame.fix(name)
        frame.load("b0", fy=-1e-6)
        frame.load("r", fx=3.0, fy=1.0)
        return frame

    modulus = 2e11 * np.exp(0.01 * np.random.default_rng(0).normal(size=count))
    stop = np.full(count, 1e5)
    stop[1] = 0.0
    whole, alone = described(modulus, stop).solve(), described(modulus[1], stop[1]).solve()
    assert_allclose(whole.contact("j0").offset[1], alone.contact("j0").offset, rtol=1e-6)
    few = described(modulus[1:2], stop[1:2]).solve()
    assert_allclose(few.contact("j0").offset[0], alone.contact("j0").offset, rtol=1e-6)


@pytest.mark.parametrize("springs", [SOFT, STIFF], ids=["determinate", "indeterminate"])
def test_motions_of_a_long_batch_are_not_kept(springs: tuple[float, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither by the solution nor for the next one: they take many times the memory of the results."""
    given, seen = drawn("x"), WeakSet[UnitMotions]()
    made = UnitMotionsPerEntry.__init__

    def noted(self: UnitMotionsPerEntry, *args: Any, **named: Any) -> None:
        made(self, *args, **named)
        seen.add(self)

    monkeypatch.setattr(UnitMotionsPerEntry, "__init__", noted)
    frame = arch(given, springs)
    solution = frame.solve()
    moved = solution.displacement("b0")
    gc.collect()
    assert not seen
    frame.set_load("b0", fx=given["fx"], fy=given["fy"])
    assert_array_equal(frame.solve().displacement("b0"), moved)


@pytest.mark.parametrize("springs", [SOFT, STIFF, LOOSE], ids=["determinate", "indeterminate", "soft springs"])
@pytest.mark.parametrize("rise", [3e-8, 1e-7, 0.01])
@pytest.mark.parametrize("count", [1, 3, 3000])
def test_arches_that_are_almost_flat(count: int, rise: float, springs: tuple[float, ...]) -> None:
    """Where pivots have lost their digits, displacements with journals in contact are found in extended precision."""
    whole = drawn("E", "x")
    whole |= {"y": np.array(rise), "fx": np.full(COUNT, 3.0), "fy": np.full(COUNT, -5.0)}
    given = {name: few(name, value, slice(count)) for name, value in whole.items()} if count > 1 else one(whole, 0)
    solution = arch(given, springs).solve()
    moved = np.atleast_2d(solution.displacement("b0"))[0]
    offset = np.stack([np.atleast_2d(solution.contact(f"j{k}").offset)[0] for k in range(3)])
    exact = truth(whole, 0, springs, offset).displacement["b0"].astype(np.float64)
    # with soft springs the flattest but one still has pivots above rounding, and the digits that go with them
    allowed = 1e-6 if springs is LOOSE and rise == 1e-7 else 1e-12
    assert_allclose(moved, exact, rtol=0.0, atol=allowed * np.abs(exact).max())
