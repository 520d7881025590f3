"""Batches of a topology and shape that was met before have the results that they have without a program."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, Solution
from linkframe.framework.batched import batch_recording, entry_machine, unloaded
from linkframe.framework.batched.batch_numbers import BatchNumbers
from linkframe.framework.batched.entry_program import Way
from linkframe.framework.cache import PROGRAMS
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
# Solutions of a topology after which its program surely is there.
MET = 18
SEVEN = (7,)


@pytest.fixture(autouse=True)
def _nothing_known() -> Iterator[None]:
    PROGRAMS.clear()
    yield
    PROGRAMS.clear()


@pytest.fixture(params=[Way.STEPS, Way.MACHINE])
def way(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> Way:
    """Both ways to run a program."""
    found: Way = request.param
    if found is Way.MACHINE and not entry_machine.available():
        pytest.skip("no LLVM, or no extended precision of 80 bits")
    monkeypatch.setattr(batch_recording, "_OFTEN", 0 if found is Way.MACHINE else 10**9)
    return found


def steel(rng: np.random.Generator, *shape: int) -> Beam:
    """A bar of a modulus for each entry."""
    return Beam(Rectangle(y=0.0127, z=0.00635), Material(E=rng.uniform(1.9e11, 2.1e11, shape), nu=0.3, density=7850.0))


def linked(
    seed: int, poses: tuple[int, ...] = SEVEN, samples: tuple[int, ...] = SEVEN, bars: tuple[int, ...] | None = None
) -> Frame:
    """Crank, coupler and rocker on bodies: places vary with the pose; beams, joints, offsets, loads with the sample.

    Beams vary over `bars` if given.
    """
    rng = np.random.default_rng(seed)
    frame, angle = Frame(), rng.uniform(0.1, 1.4, poses)
    turned = Rotation.from_rotvec(np.multiply.outer(angle.reshape(-1), [0.0, 0.0, 1.0])).as_matrix()
    frame.body("crank", axes=turned.reshape(*poses, 3, 3))
    frame.node("A", (0.0, 0.0, 0.0), body="crank")
    frame.node("B", (0.1, 0.0, 0.0), body="crank")
    x, y = 0.1 * np.cos(angle), 0.1 * np.sin(angle)
    for name, places in {"B'": (x, y), "P": (x + 0.1, y + 0.01), "D": (x + 0.2, y), "D'": (x + 0.2, y)}.items():
        frame.node(name, np.stack([*places, np.zeros(poses)], axis=-1))
    frame.node("E'", (0.2, 0.0, 0.0))
    frame.node("E", (0.2, 0.0, 0.0))
    for start, end in (("A", "B"), ("B'", "P"), ("P", "D"), ("D'", "E'")):
        frame.add(start + end, steel(rng, *(samples if bars is None else bars)), start, end)
    for name, start, end in (("b", "B", "B'"), ("d", "D", "D'"), ("e", "E'", "E")):
        springs = rng.uniform(1e8, 2e11, (*samples, 6)) * (1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
        frame.add(name, Joint(stiffness=springs), start, end)
        frame.offset(name, ux=rng.normal(size=samples) * 1e-4)
    frame.fix("A")
    frame.fix("E")
    frame.load("P", fx=3.0, fy=rng.normal(size=samples), fz=rng.normal(size=samples))
    return frame


def all_kinds(seed: int) -> Frame:
    """Turned joints, a screw, ideal components, a rigid link, prescribed displacements, loads on members and weight."""
    rng = np.random.default_rng(seed)
    frame = Frame()
    frame.body("arm", rng.normal(size=3), Rotation.random(7, rng=rng).as_matrix())
    frame.node("a", rng.normal(size=3), body="arm")
    frame.node("b", rng.normal(size=3), body="arm")
    frame.node("c", frame.position("b"))
    frame.node("d", rng.normal(size=(7, 3)))
    frame.node("e", frame.position("d"))
    frame.node("f", rng.normal(size=3))
    frame.node("g", rng.normal(size=3))
    frame.add("ab", steel(rng), "a", "b")
    frame.add("cd", steel(rng, 7), "c", "d")
    frame.add("ef", steel(rng, 7), "e", "f")
    axes = Rotation.random(rng=rng).as_matrix()
    frame.add("bc", Joint(stiffness=rng.uniform(1e5, 1e9, (7, 6)), axes=axes, pitch=rng.uniform(0.01, 0.1)), "b", "c")
    frame.add("de", Joint(stiffness=(np.inf, np.inf, 1e9, np.inf, 1e6, rng.uniform(1.0, 100.0))), "d", "e")
    frame.rigid("f", "g")
    frame.fix("a")
    frame.prescribe("a", rz=rng.uniform(0.0, 1e-3, 7))
    frame.offset("bc", ux=rng.uniform(0.0, 1e-3, 7), rz=rng.uniform(0.0, 1e-3))
    frame.load("g", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), rng.normal(size=(6, 7)), strict=True)))
    frame.load("b", fy=rng.normal(), mz=rng.normal(size=7))
    frame.point_load("ef", at=0.1, fx=rng.normal(), fy=rng.normal(size=7), mx=rng.normal())
    frame.gravity(rng.normal(size=3))
    return frame


def fixed_place(seed: int) -> Frame:
    """What varies is not the place: loads and offsets are right-hand-side parameters of their own."""
    return linked(seed, poses=())


def over_two_axes(seed: int) -> Frame:
    """Poses and samples."""
    return linked(seed, poses=(4, 1), samples=(5,))


def medium(seed: int) -> Frame:
    """So many entries that each computes the stiffness of its members for itself, in double precision."""
    return linked(seed, poses=(1100,), samples=(1100,))


def shared(seed: int) -> Frame:
    """So many poses and samples that a member's stiffness is found once for many entries."""
    return linked(seed, poses=(40, 1), samples=(30,), bars=())


def shared_in_turn(seed: int) -> Frame:
    """The same with poses and samples in the other order, and beams that vary with the pose."""
    return linked(seed, poses=(40,), samples=(30, 1), bars=(40,))


def under_many_loads(seed: int) -> Frame:
    """Members, joints and places are the same for all entries."""
    rng = np.random.default_rng(seed)
    frame = linked(seed, poses=(), samples=())
    frame.set_load("P", fx=rng.normal(size=1200), mz=rng.normal(size=1200))
    return frame


def tilted(seed: int) -> Frame:
    """A bar and its joint on a tilted body: displacements are sums over several separate components."""
    rng = np.random.default_rng(seed)
    frame = Frame()
    frame.body("all", axes=Rotation.from_rotvec([0.4, 0.0, 0.0]).as_matrix())
    frame.node("A", (0.0, 0.0, 0.0), body="all")
    frame.node("P", rng.uniform(0.1, 0.2, (40, 1, 1)) * [1.0, 0.0, 0.0], body="all")
    frame.node("E", frame.nodes["P"].coordinates, body="all")
    frame.add("AP", steel(rng), "A", "P")
    frame.add("e", Joint(stiffness=rng.uniform(1e5, 1e7, (30, 6))), "P", "E")
    frame.fix("A")
    frame.fix("E")
    frame.load("P", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), rng.normal(size=(6, 30)), strict=True)))
    return frame


KINDS: dict[str, Callable[[int], Frame]] = {
    "linked": linked,
    "all kinds": all_kinds,
    "fixed place": fixed_place,
    "two axes": over_two_axes,
    "medium": medium,
    "shared": shared,
    "shared in turn": shared_in_turn,
    "under many loads": under_many_loads,
    "tilted": tilted,
}
# Of these NumPy runs the steps in any case.
BY_NUMPY = ("shared", "shared in turn", "under many loads", "tilted")


def everything(solution: Solution) -> dict[str, Array]:
    """Results by name."""
    frame = solution.frame
    found = {f"displacement of {name}": solution.displacement(name) for name in frame.nodes}
    found |= {f"reaction of {name}": solution.reaction(name) for name in frame.supports}
    found |= {f"ends of {name}": solution.end_forces(name) for name in frame.members}
    found |= {f"joint {name}": solution.joint_displacement(name) for name in frame.joints}
    found |= {f"force of {name}": solution.joint_force(name) for name in frame.joints}
    found |= {"all": solution.displacements(), "distance": solution.distance_to_singularity()}
    return found | {"bound": solution.error_bound(list(frame.nodes)[2]), "state": np.asarray(solution.state)}


def without(frame: Frame) -> Solution:
    """The solution without a program."""
    PROGRAMS.clear()
    return frame.copy().solve()


def met(describe: Callable[[], Frame]) -> None:
    """Solve frames of a topology until its program is there."""
    for _ in range(MET):
        frame = describe()
        frame.solve().displacement(next(iter(frame.nodes)))


@pytest.mark.parametrize("kind", KINDS)
def test_later_batches_are_as_the_first(kind: str, way: Way) -> None:
    wanted = everything(without(KINDS[kind](9)))
    met(lambda: KINDS[kind](3))
    solution = KINDS[kind](9).solve()
    found = everything(solution)
    assert solution.plan.entry is not None
    assert solution.plan.entry.way is (Way.STEPS if kind in BY_NUMPY else way)
    assert found.keys() == wanted.keys()
    for name, value in found.items():
        np.testing.assert_array_equal(value, wanted[name], err_msg=name)


def test_a_batch_has_the_bits_of_its_entries(way: Way) -> None:
    rng = np.random.default_rng(1)
    modulus, length, force = rng.uniform(1.0, 2.0, (3, 40)) * [[2e11], [1.0], [10.0]]

    def bent(k: Any) -> Array:
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", np.stack([length[k], 0.5 * length[k], 0.0 * length[k]], axis=-1))
        frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=modulus[k], nu=0.3)), "A", "B")
        frame.fix("A")
        frame.load("B", fx=-0.5 * force[k], fy=force[k])
        return frame.solve("broadcast").displacement("B")

    for _ in range(MET):
        found = bent(slice(None))
    PROGRAMS.clear()
    np.testing.assert_array_equal(found, [bent(k) for k in range(40)])


def test_cantilevers_bend_by_the_closed_form(way: Way) -> None:
    """``F L^3 / 3 E I`` and ``F L^2 / 2 E I`` (Roark's Formulas, 7th ed., table 8.1, 1a)."""
    rng = np.random.default_rng(2)
    for _ in range(MET):
        modulus, length, force = rng.uniform(1.0, 2.0, (3, 50)) * [[2e11], [1.0], [10.0]]
        frame, zero = Frame(), np.zeros(50)
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", np.stack([length, zero, zero], axis=-1))
        frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=modulus, nu=0.3)), "A", "B")
        frame.fix("A")
        frame.load("B", fy=force)
        solution = frame.solve("broadcast")
        found = solution.displacement("B")
    assert solution.plan.entry is not None
    stiff = modulus * 0.01 * 0.02**3 / 12.0
    np.testing.assert_allclose(found[:, 1], force * length**3 / (3.0 * stiff), rtol=1e-13)
    np.testing.assert_allclose(found[:, 5], force * length**2 / (2.0 * stiff), rtol=1e-13)


@pytest.mark.parametrize("kind", KINDS)
def test_another_load_on_the_same_batch(kind: str, way: Way) -> None:
    met(lambda: KINDS[kind](3))
    frame = KINDS[kind](4)
    frame.solve().displacement("b" if kind == "all kinds" else "P")
    node = "g" if kind == "all kinds" else "P"
    frame.set_load(node, fx=2.0, fy=np.linspace(1.0, 2.0, frame.shape[-1]), fz=np.linspace(0.0, 2.0, frame.shape[-1]))
    for _ in range(MET):
        solution = frame.solve()
        found = solution.displacement(node), solution.reaction("a" if kind == "all kinds" else "A")
    assert solution.plan.entry is not None
    other = without(frame)
    np.testing.assert_array_equal(found[0], other.displacement(node))
    np.testing.assert_array_equal(found[1], other.reaction("a" if kind == "all kinds" else "A"))


@pytest.mark.parametrize("poses", [(), SEVEN])
def test_all_numbers_changed_in_place(poses: tuple[int, ...], way: Way) -> None:
    """As by another description, with what is known of the frame before and with its program."""
    frame = by_hand(3, poses)
    for seed in range(4, 4 + MET):
        other = by_hand(seed, poses)
        names = [name for name in frame.nodes if name[0] not in "AE"]
        frame.change(names, np.stack([other.nodes[name].coordinates for name in names], axis=-2))
        frame.change([*frame.members], [member.element for member in other.members.values()])
        frame.change([*frame.joints], [joint.element for joint in other.joints.values()])
        for joint, offsets in other.offsets.items():
            frame.offset(joint, ux=offsets[0])
        frame.set_load("P", fx=3.0, fy=other.loads["P"][1][1], fz=other.loads["P"][2][1])
        solution = frame.solve()
        found = everything(solution)
        assert {name: value.tobytes() for name, value in found.items()} == {
            name: value.tobytes() for name, value in everything(unmet(other)).items()
        }
    assert solution.plan.entry is not None
    assert solution.plan.entry.way is way


def misfit(what: str, seed: int) -> Frame:
    """Two bars on one joint whose two parts do not fit, or with a support that has moved, each by one component."""
    rng = np.random.default_rng(seed)
    frame, scale = Frame(), rng.uniform(1.0, 1.1, (7, 1))
    for name, place in {"A": (0.0, 0.0), "B": (1.0, 0.3), "C": (1.0, 0.3), "D": (1.6, -0.2)}.items():
        frame.node(name, scale * (*place, 0.0))
    frame.add("AB", steel(rng, 7), "A", "B")
    pitch = rng.uniform(0.01, 0.1, 7) if what == "pitch" else 0.0
    frame.add("pin", Joint(stiffness=rng.uniform(1e5, 1e7, (7, 6)), pitch=pitch), "B", "C")
    frame.add("CD", steel(rng, 7), "C", "D")
    frame.fix("A")
    by = rng.uniform(1e-4, 1e-3, 7)
    if what.startswith("support"):
        frame.prescribe("A", **{what.split()[1]: by})
    elif what != "pitch":
        frame.offset("pin", **{what: by})
    frame.load("D", fy=rng.normal(size=7), fz=rng.normal(size=7))
    return frame


@pytest.mark.parametrize("what", ["uy", "rz", "pitch", "support uy", "support rx"])
def test_one_number_of_another_component(what: str, way: Way) -> None:
    """Batches with as many numbers, one of which belongs to something else, have another program."""
    met(lambda: misfit("ux", 3))
    np.testing.assert_array_equal(misfit(what, 4).solve().displacement("D"), unmet(misfit(what, 4)).displacement("D"))
    met(lambda: misfit("support ux", 3))
    np.testing.assert_array_equal(misfit(what, 5).solve().displacement("D"), unmet(misfit(what, 5)).displacement("D"))


def by_hand(seed: int, poses: tuple[int, ...]) -> Frame:
    """That of `linked`, without bodies."""
    linkage, frame = linked(seed, poses), Frame()
    for name in linkage.nodes:
        frame.node(name, linkage.position(name))
    for name, member in linkage.members.items():
        frame.add(name, member.element, member.start, member.end)
    for name, joint in linkage.joints.items():
        frame.add(name, joint.element, joint.first, joint.second)
        frame.offset(name, ux=linkage.offsets[name][0])
    frame.fix("A")
    frame.fix("E")
    frame.load("P", fx=3.0, fy=linkage.loads["P"][1][1], fz=linkage.loads["P"][2][1])
    return frame


def unmet(frame: Frame) -> Solution:
    """The solution of a frame without a program, which others keep."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(unloaded, "FEW", 10**9)
        return frame.copy().solve()


@pytest.mark.parametrize("describe", [linked, shared])
def test_solutions_travel(describe: Callable[[int], Frame], way: Way) -> None:
    met(lambda: describe(1))
    solution = describe(2).solve()
    assert solution.plan.entry is not None
    wanted = solution.displacement("P")
    twin = pickle.loads(pickle.dumps(solution))
    np.testing.assert_array_equal(twin.displacement("P"), wanted)
    np.testing.assert_array_equal(twin.displacement("D"), solution.displacement("D"))
    np.testing.assert_array_equal(twin.reaction("A"), solution.reaction("A"))


@pytest.mark.parametrize(("describe", "told"), [(linked, "1 of 7"), (shared, "40 of 1200")])
def test_a_mechanism_among_the_entries_is_told(describe: Callable[[int], Frame], told: str, way: Way) -> None:
    met(lambda: describe(1))
    frame = describe(2)
    springs = np.full((frame.shape[-1], 6), 2e11) * (1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
    springs[3, :2] = 0.0
    frame.change("b", Joint(stiffness=springs))
    with pytest.warns(MechanismWarning, match=f"{told} batch entries"):
        found = frame.solve().displacement("P")
    assert np.isnan(found[..., 3, :]).any(axis=-1).all()
    assert np.isfinite(np.delete(found, 3, axis=-2)).all()


def test_joints_that_close_a_loop_have_no_program(way: Way) -> None:
    def closed(seed: int) -> Frame:
        frame = linked(seed)
        frame.add("second", Joint(stiffness=np.linspace(1e6, 1e9, 7)[:, None] * np.ones(6)), "B", "B'")
        return frame

    met(lambda: closed(1))
    solution = closed(2).solve()
    np.testing.assert_array_equal(solution.displacement("P"), without(closed(2)).displacement("P"))
    assert solution.plan.entry is None


@pytest.mark.parametrize("samples", [(7,), (1100,)])
def test_what_suits_no_program_is_looked_at_once(samples: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Members alone under loads that vary, which are solved in bands."""
    made = 0
    gathered = BatchNumbers.__init__

    def counted(self: BatchNumbers, *given: Any) -> None:
        nonlocal made
        made += 1
        gathered(self, *given)

    monkeypatch.setattr(BatchNumbers, "__init__", counted)
    for k in range(MET):
        frame, bar = Frame(), steel(np.random.default_rng(k))
        for n in range(4):
            frame.node(f"{n}", (1.0 * n, 0.1 * (n % 3), 0.2 * (n % 2)))
            if n:
                frame.add(f"m{n}", bar, f"{n - 1}", f"{n}")
        frame.fix("0")
        frame.load("3", fy=np.linspace(1.0, 2.0, *samples))
        frame.solve().displacement("3")
    assert made == 1


def test_explain_tells_how_the_program_was_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unloaded, "FEW", 1)
    monkeypatch.setattr(batch_recording, "_FEW", 1)
    monkeypatch.setattr(batch_recording, "_OFTEN", 3)
    told = []
    for k in range(6):
        solution = linked(k).solve()
        solution.displacement("P")
        shape = r"steps on 7 entries, recorded for all batches of this topology and shape, (.+)\."
        told += [*dict.fromkeys(re.findall(shape, solution.explain()) or [""])]
    last = "as machine code" if entry_machine.available() else "by NumPy one by one"
    assert told == ["", "", *["by NumPy one by one"] * 2, last, last]


def test_shared_members_and_no_load() -> None:
    """Displacements are zero, or those of a support that has moved."""
    for moved in (0.0, 1e-3):
        for _ in range(MET):
            rng = np.random.default_rng(1)
            frame = Frame()
            frame.node("A", (0.0, 0.0, 0.0))
            frame.node("B", rng.uniform(1.0, 2.0, (40, 1, 3)))
            frame.add("AB", steel(rng), "A", "B")
            frame.fix("A")
            if moved:
                frame.node("C", frame.position("B"))
                frame.add("pin", Joint(stiffness=rng.uniform(1e5, 1e6, (30, 6))), "B", "C")
                frame.prescribe("A", ux=moved)
            else:
                frame.load("B", fy=np.zeros(30))
            solution = frame.solve("broadcast")
            found = solution.displacement("B")
        np.testing.assert_allclose(found, np.broadcast_to(np.eye(6)[0] * moved, (40, 30, 6)), atol=1e-15)


def test_origins_that_vary_alone_make_another_batch(way: Way) -> None:
    """Chords and axes tell nothing of them, but loads are divided among right-hand-side parameters by them."""

    def placed(seed: int, poses: tuple[int, ...]) -> Frame:
        rng = np.random.default_rng(seed)
        frame = Frame()
        frame.body("arm", rng.normal(size=(*poses, 3)))
        for name, x in {"A": 0.0, "B": 1.0}.items():
            frame.node(name, (x, 0.0, 0.0), body="arm")
        frame.node("C", frame.position("B"))
        frame.add("AB", steel(rng), "A", "B")
        frame.add("pin", Joint(stiffness=rng.uniform(1e5, 1e6, (30, 6))), "B", "C")
        frame.fix("A")
        frame.load("C", fy=rng.normal(size=(40, 1)), fx=rng.normal(size=30))
        return frame

    for first, second in (((40, 1), ()), ((), (40, 1))):
        PROGRAMS.clear()
        wanted = unmet(placed(2, second)).displacement("C")
        met(lambda poses=first: placed(1, poses))  # type: ignore[misc]
        np.testing.assert_array_equal(placed(2, second).solve().displacement("C"), wanted)


def test_what_is_often_singular_is_solved_without_a_program() -> None:
    def singular(seed: int) -> Frame:
        frame = linked(seed)
        springs = np.full((7, 6), 2e11) * (1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
        springs[3, :2] = 0.0
        frame.change("b", Joint(stiffness=springs))
        return frame

    met(lambda: linked(1))
    with pytest.warns(MechanismWarning):
        met(lambda: singular(2))
    solution = singular(3).solve()
    with pytest.warns(MechanismWarning):
        solution.displacement("P")
    assert solution.plan.unloaded.numbers is None


def test_loads_that_vary_over_all_entries_have_no_program() -> None:
    """Loads on members that turn with the pose, of another size for each sample."""

    def loaded(seed: int) -> Frame:
        frame, rng = shared(seed), np.random.default_rng(seed)
        frame.point_load("PD", at=0.05, fy=rng.normal(size=30))
        return frame

    wanted = unmet(loaded(2)).displacement("P")
    met(lambda: loaded(1))
    solution = loaded(2).solve()
    np.testing.assert_array_equal(solution.displacement("P"), wanted)
    assert solution.plan.entry is None


def test_a_mechanism_whatever_the_numbers_is_told() -> None:
    """A pivot that is zero at all entries."""

    def loose(seed: int) -> Frame:
        frame = tilted(seed)
        frame.node("Q", frame.nodes["P"].coordinates, body="all")
        springs = np.random.default_rng(seed).uniform(1e5, 1e7, (30, 6)) * (1.0, 1.0, 1.0, 1.0, 1.0, 0.0)
        frame.add("q", Joint(stiffness=springs), "P", "Q")
        frame.load("Q", mz=1.0)
        return frame

    with pytest.warns(MechanismWarning, match="1200 of 1200"):
        met(lambda: loose(1))
    solution = loose(2).solve()
    with pytest.warns(MechanismWarning, match="1200 of 1200"):
        assert np.isnan(solution.displacement("Q")).any(axis=-1).all()
