"""Contact of long batches, by one pass for loads and offsets, part after part, in memory that does not grow."""

from __future__ import annotations

import gc
import tracemalloc
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle, Spring
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution
from linkframe.framework.clearances import by_parts, contact_search
from linkframe.framework.clearances.unit_motions import UnitMotionsPerEntry
from linkframe.framework.entries import Stretch
from numpy.testing import assert_allclose, assert_array_equal
from reference.rigid_links import rigid_links
from scipy.spatial.transform import Rotation

BAR = Rectangle(y=0.02, z=0.01)
PIN, IDEAL = np.array([2e8, 2e8, 2e8, 2e5, 2e5, 1e4]), np.array([np.inf] * 5 + [1e4])
JOURNALS = ("foot", "top", "seat")
Array = np.ndarray[Any, np.dtype[Any]]


@pytest.fixture(autouse=True)
def one_pass(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 2000 entries on loads and unit offsets are solved for in one pass."""
    monkeypatch.setattr(contact_search, "_LONG", 2000)
    monkeypatch.setattr(contact_search, "_MANY", 0)
    monkeypatch.setattr(contact_search, "_KEPT", 0)


def parts_of(most: int, monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """From now on contact is found for so many entries at a time; the sizes of the parts that are met."""
    met: list[int] = []
    search = by_parts.frame_at

    def noted(frame: Frame, change: Any, shape: tuple[int, ...]) -> Any:
        met.append(int(np.prod(shape)))
        return search(frame, change, shape)

    monkeypatch.setattr(by_parts, "MOST", most)
    monkeypatch.setattr(by_parts, "frame_at", noted)
    return met


def everything(poses: int, samples: int, springs: Array = PIN) -> Frame:
    """An arch on journals with all that a frame can hold; by pose places and axes vary, by sample and both the rest."""
    rng = np.random.default_rng(7)
    pose, sample, both = (poses, 1), (1, samples), (poses, samples)

    def about(value: float, shape: tuple[int, ...]) -> Array:
        found: Array = value * rng.uniform(0.8, 1.2, shape)
        return found

    frame = Frame(axes=("pose", "sample"))
    top = np.stack([about(1.0, both), about(0.5, pose) + np.zeros(both), np.zeros(both)], axis=-1)
    turn = Rotation.from_rotvec(about(0.3, (poses, 1)) * np.array([0.0, 0.0, 1.0])).as_matrix()[:, None]
    frame.body("ground", origin=np.zeros(3), axes=turn)
    for name, place in {"c0": (0, 0, 0), "a0": (0, 0, 0), "b0": top, "b1": top, "d": top, "a1": (2, 0, 0)}.items():
        frame.node(name, place)
    frame.node("c1", (2.0, 0.0, 0.0))
    frame.node("stop", (0.0, 0.0, 0.0), body="ground")
    frame.add("left", Beam(BAR, Material(E=about(2e11, both), nu=0.3)), "a0", "b0")
    frame.add("right", Beam(Rectangle(y=about(0.02, sample), z=0.01), Material(E=2e11, nu=0.3)), "b1", "a1")
    frame.add("spring", Spring(stiffness=about(1e4, sample)), "b0", "a1")
    pin = Joint(springs * about(1.0, (*both, 1)), clearance=about(1e-4, both), clearance_directions=("ux", "uy"))
    frame.add("foot", pin, "c0", "a0")
    frame.add(
        "top", Joint(PIN, axes=turn, clearance=about(1e-4, sample), clearance_directions=("ux", "uy")), "b0", "b1"
    )
    frame.add("seat", Joint(springs, clearance=1e-4, clearance_directions=("ux", "uy")), "a1", "c1")
    frame.add("screw", Joint((1e7, 1e7, 1e7, 1e4, 1e4, 0.0), axes=turn, pitch=about(1e-2, sample)), "b0", "d")
    frame.fix("c0")
    frame.fix("c1", "uz", "rx", "ry", "rz")
    frame.prescribe("c1", ux=about(1e-5, sample), uy=about(-1e-5, both))
    frame.fix("d", "rz")
    frame.offset("screw", ux=about(1e-5, pose))
    frame.add("mass", PointMass(about(2.0, both)), "b0")
    frame.gravity(np.stack([about(1.0, pose), about(-9.81, pose), np.zeros(pose)], axis=-1))
    frame.load("b0", fx=about(20.0, both), fy=about(-100.0, sample))
    frame.load("d", fx=about(15.0, both), mz=about(3.0, sample))
    frame.line_load("left", fy=about(-30.0, both))
    frame.exclude(rng.uniform(size=both) < 0.01)
    return frame


def numbers(solution: Solution) -> list[Array]:
    """What contact and displacements are, NaN included."""
    found = [solution.displacement("b0"), solution.displacement("a1"), solution.joint_force("screw")]
    for name in JOURNALS:
        contact = solution.contact(name)
        found += [contact.offset, contact.normal, contact.force, contact.gap, contact.state.astype(np.float64)]
    return [np.asarray(each) for each in found]


@pytest.mark.parametrize("springs", [PIN, IDEAL], ids=["springs", "ideal"])
@pytest.mark.parametrize(("poses", "samples", "parts"), [(3, 2500, 3), (60, 50, 5), (1, 7000, 3)])
def test_the_same_as_at_once(
    poses: int, samples: int, parts: int, springs: Array, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With all that can be described and vary, and entries that are left out; and as by two passes."""
    frame = everything(poses, samples, springs)
    whole = frame.copy().solve()
    with monkeypatch.context() as patch:
        patch.setattr(UnitMotionsPerEntry, "with_loads", lambda *_, **__: None)
        by_two = frame.copy().solve()
        expected = numbers(by_two)
    met = parts_of(poses * samples // parts + 1, monkeypatch)
    in_parts = frame.solve()
    assert len(met) >= parts
    assert sum(met) == poses * samples
    for found in (whole, in_parts):
        for mine, theirs in zip(numbers(found), expected, strict=True):
            assert_allclose(mine, theirs, rtol=0.0, atol=1e-11 * np.nanmax(np.abs(theirs)))
        assert_array_equal(found.status, by_two.status)
    assert (whole.status == "absent").any()
    told = [each.explain().split("The minimum")[1].split(" entries")[0] for each in (in_parts, whole, by_two)]
    assert told[0] == told[1] == told[2]
    assert f"found before, for {len(met)} parts of the batch one after the other, from" in in_parts.explain()
    assert "found before from" in whole.explain()


@pytest.mark.parametrize("springs", [PIN, IDEAL], ids=["springs", "ideal"])
def test_as_each_entry_alone(springs: Array, monkeypatch: pytest.MonkeyPatch) -> None:
    """By rounding; where constraints are ideal, forces follow from the equilibrium of all loads."""
    parts_of(2500, monkeypatch)
    found, frame = numbers(everything(3, 2500, springs).solve()), everything(3, 2500, springs)
    for pose, sample in ((0, 0), (1, 833), (2, 2499)):
        alone = numbers(by_parts.frame_at(frame, at_one(pose, sample), (1, 1)).solve())
        for mine, theirs in zip(found, alone, strict=True):
            assert_allclose(mine[pose, sample], theirs[0, 0], rtol=0.0, atol=1e-11 * np.nanmax(np.abs(theirs)))


@pytest.mark.parametrize("joined", [False, True], ids=["apart", "joined"])
@pytest.mark.parametrize("count", [1, 3, 20_000])
def test_beside_mechanisms(count: int, joined: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a bar has no spring about its pin and a load turns it, other parts of the frame have their contact.

    But the part to which it is joined has none, and no results.
    """
    loose = np.isin(np.arange(count), [0, 1999, 13_000])

    def hung() -> Frame:
        frame = arch(count, "moduli")
        for name, x in ({"h2": 1.0, "t": 1.5} | ({} if joined else {"h": 1.0})).items():
            frame.node(name, (x, 0.5 * joined, 0.0))
        if not joined:
            frame.fix("h")
        springs = np.full((count, 6), 1e6)
        springs[loose, 5] = 0.0
        frame.add("hinge", Joint(springs), "b0" if joined else "h", "h2")
        frame.add("bar", Beam(BAR, Material(E=2e11, nu=0.3)), "h2", "t")
        frame.load("t", fy=3.0)
        return frame

    expected = arch(count, "moduli").solve()
    for most in (count, max(count // 3, 1)):
        parts_of(most, monkeypatch)
        solution = hung().solve()
        with pytest.warns(MechanismWarning, match="kinematically unstable"):
            moved = solution.displacement("t")
        assert_array_equal(np.isnan(moved).all(axis=-1), loose)
        assert_array_equal(solution.status == "mechanism", loose)
        if joined:
            assert np.isnan(solution.displacement("b0")[loose]).all()
            assert (solution.contact("top").status[loose] == "mechanism").all()
            assert (solution.contact("top").status[~loose] == "closed").all()
            continue
        assert_allclose(solution.displacement("b0"), expected.displacement("b0"), rtol=0.0, atol=1e-15)
        for name in JOURNALS:
            assert_array_equal(solution.contact(name).status, "closed")
            assert_allclose(solution.contact(name).force, expected.contact(name).force, rtol=1e-11)


@pytest.mark.parametrize("load", ["on a member", "at a point", "weight", "on a node", "own offset"])
def test_forces_of_ideal_journals(load: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """They follow from the equilibrium of what they carry, of which a unit offset has no loads."""
    passes: list[UnitMotionsPerEntry | None] = []
    with_loads = UnitMotionsPerEntry.with_loads

    def noted(*given: Any, **named: Any) -> UnitMotionsPerEntry | None:
        passes.append(with_loads(*given, **named))
        return passes[-1]

    monkeypatch.setattr(UnitMotionsPerEntry, "with_loads", noted)

    def loaded(count: int) -> Frame:
        frame = arch(4000, "moduli")
        for name in JOURNALS:
            gap = frame.joints[name].element.clearance
            frame.change(name, Joint(IDEAL, clearance=gap, clearance_directions=("ux", "uy")))
        if load == "on a member":
            frame.line_load("m1", fy=np.linspace(-30.0, -60.0, 4000))
        elif load == "at a point":
            frame.point_load("m1", at=0.4, fy=-40.0)
        elif load == "weight":
            frame.add("mass", PointMass(2.0), "b1")
            frame.gravity((1.0, -9.81, 0.0))
        elif load == "on a node":
            frame.load("a1", mz=5.0)
        else:
            frame.offset("foot", ux=1e-5)
        some = slice(7, 7 + count)
        return by_parts.frame_at(frame, Stretch(ndim=1, axis=0, indices=some), (count,))

    whole, alone = loaded(3993).solve(), loaded(1).solve()
    assert [each is not None for each in passes] == ([] if load == "own offset" else [True])
    for name in JOURNALS:
        assert_allclose(whole.contact(name).offset[0], alone.contact(name).offset[0], rtol=0.0, atol=1e-16)
        assert_allclose(whole.contact(name).force[0], alone.contact(name).force[0], rtol=1e-11)
    assert_allclose(whole.displacement("b0")[0], alone.displacement("b0")[0], rtol=0.0, atol=1e-16)


@pytest.mark.parametrize("beside", ["constant", "springs", "moduli", "everything by pose"])
def test_unconnected_parts_with_journals(beside: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of which one is factorised anew at all entries, and another but once, or in its last unknowns alone."""
    rng, shape = np.random.default_rng(5), (40, 100)

    def about(value: float, *shape: int) -> Array:
        found: Array = value * rng.uniform(0.8, 1.2, shape)
        return found

    def two() -> Frame:
        frame = Frame()
        ends = {"c0": (0, 0), "a0": (0, 0), "b0": (1, 0.5), "b1": (1, 0.5), "a1": (2, 0), "c1": (2, 0)}
        for name, (x, y) in (ends | {"p": (0, 3), "q": (1, 3), "r": (2, 3), "s": (2, 3)}).items():
            frame.node(name, (x, y, 0.0))
        for k in (0, 1):
            frame.add(f"m{k}", Beam(BAR, Material(E=moduli[k], nu=0.3)), f"a{k}", f"b{k}")
        places = {"foot": ("c0", "a0"), "top": ("b0", "b1"), "seat": ("a1", "c1"), "end": ("r", "s")}
        for name, pair in places.items():
            springs = PIN * other["end"][..., None] if name == "end" else PIN
            frame.add(name, Joint(springs, clearance=1e-4, clearance_directions=("ux", "uy")), *pair)
        for name, pair in {"pq": ("p", "q"), "qr": ("q", "r")}.items():
            frame.add(name, Beam(BAR, Material(E=2e11 * other[name], nu=0.3)), *pair)
        for name in ("c0", "c1", "p", "s"):
            frame.fix(name)
        frame.load("b0", fx=3.0, fy=-load)
        frame.load("q", fy=-0.5 * load)
        return frame

    moduli, load, one = about(2e11, 2, *shape), about(100.0, *shape), np.ones(())
    varies = {"constant": {}, "springs": {"end": about(1.0, *shape)}, "moduli": {"pq": about(1.0, *shape)}}
    by_pose = {name: about(1.0, 40, 1) for name in ("end", "pq", "qr")}
    other = {"end": one, "pq": one, "qr": one} | varies.get(beside, by_pose)
    found = two().solve()
    monkeypatch.setattr(UnitMotionsPerEntry, "with_loads", lambda *_, **__: None)
    expected = two().solve()
    for name in ("b0", "q", "r"):
        moved = expected.displacement(name)
        assert_allclose(found.displacement(name), moved, rtol=0.0, atol=1e-12 * np.abs(moved).max())
    for name in (*JOURNALS, "end"):
        force = expected.contact(name).force
        assert_allclose(found.contact(name).force, force, rtol=0.0, atol=1e-11 * np.abs(force).max())
        assert_array_equal(found.contact(name).state, expected.contact(name).state)


@pytest.mark.parametrize("lead", [(), (1,), (1, 1)])
def test_axes_of_size_one_in_front(lead: tuple[int, ...]) -> None:
    """Which only some of the numbers have."""
    frame, plain = arch(4000, "moduli"), arch(4000, "moduli")
    load = np.linspace(1.0, 20.0, 4000)
    frame.set_load("b0", fy=load.reshape(*lead, -1))
    plain.set_load("b0", fy=load)
    expected = plain.solve().contact("top").offset.reshape(*lead, -1, 3)
    assert_allclose(frame.solve().contact("top").offset, expected, rtol=0.0, atol=1e-17)


def at_one(pose: int, sample: int) -> Any:
    """Takes one entry out of arrays with both batch axes."""

    def change(array: Array, trailing: int) -> Array:
        first = array.ndim - trailing - 2
        for axis, index in ((first, pose), (first + 1, sample)):
            if axis >= 0 and array.shape[axis] > 1:
                array = np.take(array, [index], axis=axis)
        return array

    return change


@pytest.mark.parametrize("where", ["here and there", "a whole part"])
def test_entries_at_which_no_offset_fits(where: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """They are told once, also if a part has no others; and if the batch has no others that is an error."""
    height, load = np.linspace(0.1, 0.3, 6000), np.linspace(1.0, 2.0, 6000)
    height[[3, 17, 4000] if where == "here and there" else slice(2000, 4000)] = 0.0
    with pytest.warns(MechanismWarning):
        whole = rigid_links(height, load, 0.0).solve()
    met, count = parts_of(2000, monkeypatch), (height == 0.0).sum()
    with pytest.warns(MechanismWarning, match=f"{count} of 6000 batch entries are unresolved .* pin A, pin B") as told:
        found = rigid_links(height, load, 0.0).solve()
    assert len(met) >= 2
    assert [each.filename for each in told] == [__file__]
    assert_allclose(found.displacement("B"), whole.displacement("B"), rtol=1e-12, atol=1e-18)
    assert_array_equal(found.status, whole.status)
    assert_array_equal(found.contact("pin B").status, whole.contact("pin B").status)
    with pytest.raises(FrameError, match="no offset fits"):
        rigid_links(0.0 * height, 0.0, 0.0).solve()


def arch(count: int, *varies: str, clearance: bool = True) -> Frame:
    """Two beams on three journals; loads and clearances vary, and what is named."""
    rng, frame = np.random.default_rng(3), Frame()
    top = np.zeros((count, 3)) if "places" in varies else np.zeros(3)
    top += (1.0, 0.5, 0.0)
    if "places" in varies:
        top[:, 0] += rng.uniform(-0.1, 0.1, count)
    moduli = 2e11 * (np.exp(0.1 * rng.normal(size=(2, count))) if "moduli" in varies else np.ones(2))
    fixed = dict.fromkeys(("c0", "a0"), (0.0, 0.0, 0.0)) | dict.fromkeys(("a1", "c1"), (2.0, 0.0, 0.0))
    for name, place in (fixed | {"b0": top, "b1": top}).items():
        frame.node(name, place)
    for k, modulus in enumerate(moduli):
        frame.add(f"m{k}", Beam(BAR, Material(E=modulus, nu=0.3)), f"a{k}", f"b{k}")
    for name, ends in zip(JOURNALS, (("c0", "a0"), ("b0", "b1"), ("a1", "c1")), strict=True):
        gap = rng.uniform(0.5e-4, 1.5e-4, count) if clearance else 0.0
        frame.add(name, Joint(PIN, clearance=gap, clearance_directions=("ux", "uy")), *ends)
    frame.fix("c0")
    frame.fix("c1")
    frame.load("b0", fx=rng.uniform(-20.0, 20.0, count), fy=rng.uniform(-150.0, -50.0, count))
    return frame


@pytest.mark.parametrize("varies", [(), ("moduli",), ("places",), ("moduli", "places")], ids=" ".join)
def test_memory_does_not_grow(varies: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """But by what contact returns: by component an offset and a force, by joint a force and a state, and two masks.

    Where loads alone vary all entries are looked at together, which takes as much again.
    """
    parts_of(8192, monkeypatch)

    def most(count: int, *, clearance: bool) -> int:
        frame = arch(count, *varies, clearance=clearance)
        gc.collect()
        tracemalloc.start()
        try:
            frame.solve().displacement("b0")
            return tracemalloc.get_traced_memory()[1]
        finally:
            tracemalloc.stop()

    few, many = 80_000, 160_000
    most(few, clearance=True)
    growth = [(most(many, clearance=gaps) - most(few, clearance=gaps)) / (many - few) for gaps in (True, False)]
    returned = 8 * (6 + 6 + 3) + 3 + 2
    assert growth[0] - growth[1] < (1.2 if varies else 2.0) * returned


def test_contact_in_closed_form_is_that_of_the_whole_batch(monkeypatch: pytest.MonkeyPatch) -> None:
    """Which takes no memory that grows."""
    met = parts_of(1000, monkeypatch)
    frame = arch(5000, "moduli")
    for name in JOURNALS:
        frame.change(name, Joint((*PIN[:5], 0.0), clearance=1e-4, clearance_directions=("ux", "uy")))
    solution = frame.solve()
    assert solution.pressed is not None
    assert not met
