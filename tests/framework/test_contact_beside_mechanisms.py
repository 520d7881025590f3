"""Contact in batches in which some entries are mechanisms, or nothing acts: each entry is as it is alone."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import meshio
import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution, SolutionState
from linkframe.framework.error_bounds.equilibrium import Statics
from linkframe.framework.results import consistent_mechanisms, constrained_batch
from linkframe.framework.results.constrained import ConstrainedSolution
from linkframe.models import FourBar
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike
from reference import linkages
from reference.rigid_links import rigid_links

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
RNG = np.random.default_rng(1)
MANY, SAMPLES = 40, 3
STIFFNESS = 2e8 * RNG.uniform(0.8, 1.2, MANY)
CLEARANCE = 1e-4 * RNG.uniform(0.5, 1.5, MANY)
# Two of these are dead points to the last digit, and one to double precision.
DEGREES = np.array([0.0, 20.0, 110.0, 180.0, 180.0 + 1e-9, 340.0])

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


def four_bar(degrees: ArrayLike, k: ArrayLike, clearance: ArrayLike, force: ArrayLike) -> Frame:
    free = np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 0.0])
    stiffness = dict.fromkeys("BDE", np.asarray(k)[..., None] * free)
    motion = FourBar(beam=BAR, stiffness=stiffness).move(np.radians(degrees))
    frame = motion.frame(dict.fromkeys("BDE", clearance))
    frame.load("P", fy=force)
    return frame


def results(solution: Solution) -> list[np.ndarray]:
    contact = solution.contact("D")
    forces = solution.joint_force("D"), solution.reaction("E"), solution.end_forces("rocker")
    return [solution.displacement("P"), *forces, contact.normal, contact.offset, contact.force]


def test_entries_are_as_they_are_alone() -> None:
    """Where the load is reversed from sample to sample, by way of none."""
    force = np.linspace(-80.0, 80.0, SAMPLES)
    whole = four_bar(DEGREES[:, None], STIFFNESS[:SAMPLES], CLEARANCE[:SAMPLES], force).solve()
    found, states = results(whole), whole.contact("D").status
    for pose, degrees in enumerate(DEGREES):
        for sample in range(SAMPLES):
            alone = four_bar(degrees, STIFFNESS[sample], CLEARANCE[sample], force[sample]).solve()
            assert alone.status == whole.status[pose, sample]
            assert alone.contact("D").status == states[pose, sample]
            for one, all_of_them in zip(results(alone), found, strict=True):
                size = np.nan_to_num(np.abs(one)).max()
                assert_allclose(all_of_them[pose, sample], one, rtol=0.0, atol=1e-7 * size)
    assert (whole.status[[0, 3]] == "mechanism").sum() == 2 * (force != 0.0).sum()


@pytest.mark.parametrize("imposed", [0.0, 1e-5])
def test_regular_entries_go_the_quick_way_beside_mechanisms(imposed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is looked at more closely that geometry and loads tell, and contact is in closed form."""

    def refused(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(consistent_mechanisms, "small", refused)
    degrees, force = np.delete(DEGREES, 4), np.linspace(80.0, 120.0, MANY)

    def frame_at(degrees: ArrayLike) -> Frame:
        frame = four_bar(np.asarray(degrees)[:, None], STIFFNESS, CLEARANCE, force)
        frame.prescribe("E", ux=imposed)
        frame.offset("D", uy=-imposed)
        return frame

    whole, regular = frame_at(degrees).solve(), frame_at(degrees[[1, 2, 4]]).solve()
    assert whole.pressed is not None
    for some, all_of_them in zip(results(regular), results(whole), strict=True):
        assert_allclose(all_of_them[[1, 2, 4]], some, rtol=1e-9, atol=1e-9 * np.abs(some).max())
    assert np.isnan(whole.displacement("P")[[0, 3]]).all()
    assert np.isnan(whole.joint_force("D")[[0, 3]]).all()
    assert_array_equal(whole.contact("B").status[:, 0], ["mechanism", "closed", "closed", "mechanism", "closed"])
    with pytest.warns(MechanismWarning, match=r"80 of 200 .* free motion 1: "):
        frame_at(degrees).solve().displacement("P")


@pytest.mark.parametrize("degrees", [0.0, 180.0, 180.0 + 1e-9])
@pytest.mark.parametrize("clearance", [None, 1e-4])
def test_without_load_nothing_is_displaced(degrees: float, clearance: float | None) -> None:
    """Even at a dead point, and beside an entry that a load sets in motion."""
    frame = four_bar(degrees, 2e8, 0.0 if clearance is None else clearance, [0.0, 5.0])
    solution = frame.solve()
    rest, state = solution.displacement("P")[0], solution.state[0]
    assert_array_equal(rest, 0.0)
    assert_array_equal(solution.joint_force("D")[0], 0.0)
    assert state == (SolutionState.STATICALLY_CONSISTENT_MECHANISM if clearance is None else SolutionState.FREE)


def test_what_is_left_out_leaves_the_others_the_quick_way() -> None:
    degrees = np.array([20.0, 110.0, 340.0])
    frame = four_bar(degrees[:, None], STIFFNESS, CLEARANCE, 100.0)
    expected = frame.copy().solve().displacement("P")
    frame.exclude(np.array([[False], [True], [False]]))
    solution = frame.solve()
    assert solution.pressed is not None
    assert_allclose(solution.displacement("P")[[0, 2]], expected[[0, 2]], rtol=1e-12)
    assert np.isnan(solution.displacement("P")[1]).all()
    assert (solution.contact("B").status[1] == "absent").all()


def test_a_joint_without_force_at_some_entries_alone() -> None:
    """A stop of the crank at a dead point to double precision, at which offsets drive the linkage by a rounding."""
    along, across = np.array([80.0, 0.0, 60.0]), np.array([0.0, 50.0, 30.0])

    def solved(along: ArrayLike, across: ArrayLike, sample: ArrayLike) -> Solution:
        frame = four_bar(np.array([180.0, 20.0])[:, None], STIFFNESS[sample], CLEARANCE[sample], 0.0)
        frame.node("ground", frame.nodes["B.crank"].coordinates, frame.nodes["B.crank"].body)
        frame.add("stop", Joint((0.0, 1e7, 0.0, 0.0, 0.0, 0.0), clearance=1e-5), "B.crank", "ground")
        frame.fix("ground")
        frame.load("P", fx=along)
        frame.load("B.crank", fy=across)
        return frame.solve()

    whole = solved(along, across, np.arange(3))
    for sample in range(3):
        alone = solved(along[sample, None], across[sample, None], np.array([sample]))
        assert_array_equal(whole.status[:, sample], alone.status[:, 0])
        found, expected = whole.contact("stop"), alone.contact("stop")
        assert_array_equal(found.status[:, sample], expected.status[:, 0])
        assert_allclose(found.offset[:, sample], expected.offset[:, 0], rtol=0.0, atol=1e-12)
        assert_allclose(whole.displacement("P")[:, sample], alone.displacement("P")[:, 0], rtol=0.0, atol=1e-12)
    assert whole.contact("stop").status[0, 1] == "closed"


def test_unit_offsets_at_poses_that_are_singular_by_rounding_go_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """At half a turn the sine of the angle is 1e-16, by which a joint that is opened works on the free motion."""
    looked_at: list[int] = []

    def small(statics: Statics, suspects: np.ndarray, unknowns: list[int]) -> Iterator[ConstrainedSolution]:
        looked_at.append(int(suspects.sum()))
        return constrained_batch.small(statics, suspects, unknowns)

    def in_line(degrees: ArrayLike, sample: ArrayLike) -> Frame:
        """Loaded in line where the links are so: there the load does no work."""
        frame = four_bar(degrees, STIFFNESS[sample], CLEARANCE[sample], 0.0)
        frame.load("P", fx=80.0)
        return frame

    monkeypatch.setattr(consistent_mechanisms, "small", small)
    whole = in_line(np.array([0.0, 180.0])[:, None], np.arange(MANY)).solve()
    found = whole.displacement("P"), whole.joint_force("B"), whole.contact("B").offset
    assert max(looked_at, default=0) == 0
    alone = in_line(180.0, 7).solve()
    expected = alone.displacement("P"), alone.joint_force("B"), alone.contact("B").offset
    for one, all_of_them in zip(expected, found, strict=True):
        assert_allclose(all_of_them[1, 7], one, rtol=0.0, atol=1e-9 * np.nan_to_num(np.abs(one)).max())


HEIGHTS = np.array([0.3, 0.0, 0.1, 0.0, -0.2])


@pytest.mark.parametrize("order", [[0, 1, 2, 3, 4], [1, 3, 4, 2, 0]])
@pytest.mark.parametrize(
    ("fx", "fy", "state"), [(0.0, -1.0, "mechanism"), (1.0, 0.0, "unresolved"), (0, 0, "unresolved")]
)
def test_rigid_links_in_a_line_leave_the_other_entries_their_results(
    fx: float, fy: float, state: str, order: list[int]
) -> None:
    """Where they lie in a line no offset along it fits: nothing is told there, and all else is as it is alone."""
    heights = HEIGHTS[order]
    solution = rigid_links(heights, fx, fy).solve()
    in_line = heights == 0.0
    assert (solution.status[in_line] == state).all()
    assert (solution.contact("pin B").status[in_line] == state).all()
    assert np.isnan(solution.displacement("B")[in_line]).all()
    assert np.isnan(solution.joint_force("pin B")[in_line]).all()
    for entry in np.flatnonzero(~in_line):
        alone = rigid_links(heights[entry], fx, fy).solve()
        assert solution.status[entry] == alone.status
        assert solution.contact("pin B").status[entry] == alone.contact("pin B").status
        assert_allclose(solution.displacement("B")[entry], alone.displacement("B"), rtol=1e-12, atol=1e-18)
        assert_allclose(solution.joint_force("pin B")[entry], alone.joint_force("pin B"), rtol=1e-12, atol=1e-15)


def test_rigid_links_in_a_line_are_told() -> None:
    with pytest.warns(MechanismWarning, match="2 of 5 batch entries are unresolved .* pin A, pin B, pin C") as told:
        rigid_links(HEIGHTS, 1.0, 0.0).solve()
    assert told[0].filename == __file__
    for load in (0.0, [-1.0, 0.0]):
        with pytest.raises(FrameError, match="no offset fits"):
            rigid_links(np.zeros(2), 1.0, load).solve()


def test_rigid_links_in_a_line_are_saved_without_nan(tmp_path: Path) -> None:
    """Entries in which no offset fits have no solution, and ``solved`` says so."""
    with pytest.warns(MechanismWarning, match="no offset fits"):
        rigid_links(HEIGHTS, 1.0, 0.0).solve().save(tmp_path / "x.pvd")
    for entry, height in enumerate(HEIGHTS):
        mesh = meshio.read(tmp_path / "x" / f"joints_{entry:03d}.vtu")
        assert all(np.isfinite(array).all() for array in mesh.point_data.values())
        assert (mesh.cell_data["solved"][0] == (height != 0.0)).all()


def test_two_rigid_links_move_by_their_clearances() -> None:
    """Each of the pins bears the force S of a link, and offsets ε along it do the work of the load: F u = 3 ε S."""
    height, load, gap = HEIGHTS[HEIGHTS != 0.0], 1.0, 1e-4
    solution = rigid_links(HEIGHTS, 0.0, -load).solve()
    force = load * np.sqrt(1.0 + height**2) / (2.0 * np.abs(height))
    assert_allclose(-solution.displacement("B")[HEIGHTS != 0.0, 1], 3.0 * gap * force / load, rtol=1e-12)


def test_entries_left_out_contradict_nothing() -> None:
    """Two supports of one rigid link are moved apart at an entry that is left out."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.rigid("A", "B")
    frame.fix("A")
    frame.fix("B")
    frame.prescribe("A", ux=[0.0, 1e-3])
    frame.load("A", fx=1.0)
    with pytest.raises(FrameError, match=r"contradicts .* at batch entry \(1,\)"):
        frame.solve()
    frame.exclude([False, True])
    assert frame.solve().status.tolist() == ["regular", "absent"]


SPAN, PARTS, GAP, PROP = 17.5, 70, 1e-3, 1e7
SECTION, E = Rectangle(y=12.7e-3, z=6.35e-3), 200e9 * np.array([1.0, 1.1, 0.9])


def with_an_arm(*props: int, **loads: ArrayLike) -> Frame:
    """A cantilever of a size at which free motions are not told apart, on props at some nodes, and a hinged arm."""
    frame, beam = Frame(), Beam(SECTION, Material(E=E, nu=0.3))
    for k, x in enumerate(np.linspace(0.0, SPAN, PARTS + 1)):
        frame.node(f"N{k}", (x, 0.0, 0.0))
        if k:
            frame.add(f"span {k}", beam, f"N{k - 1}", f"N{k}")
    for k in props:
        frame.node(f"ground {k}", frame.nodes[f"N{k}"].coordinates)
        frame.add(f"prop {k}", Joint((0, PROP, 0, 0, 0, 0), clearance=GAP), f"ground {k}", f"N{k}")
        frame.fix(f"ground {k}")
    for name, y in {"S": 0.0, "S'": 0.0, "T": 0.1}.items():
        frame.node(name, (0.0, y, 0.0))
    frame.add("hinge", Joint((1e7, 1e7, 1e7, 1e4, 1e4, 0.0), clearance=1e-4), "S", "S'")
    frame.add("arm", beam, "S'", "T")
    frame.fix("N0")
    frame.fix("S")
    for node, fy in loads.items():
        frame.load(node, fy=fy)
    return frame


def test_a_mechanism_that_offsets_alone_reach_hides_no_contact() -> None:
    """The tip under a load F there goes ε + (F - k ε)/(K + k), k = 3 E I/L³ of the bar, on a prop of stiffness K."""
    force = np.array([-20.0, 0.0, -3.0])
    solution = with_an_arm(PARTS, **{f"N{PARTS}": force}).solve()
    bar = 3.0 * E * SECTION.y**3 * SECTION.z / 12.0 / SPAN**3
    contact, pressed = solution.contact(f"prop {PARTS}"), (np.abs(force) - bar * GAP) / (1.0 + bar / PROP)
    assert contact.status.tolist() == ["closed", "free", "closed"]
    assert (solution.contact("hinge").status == "free").all()
    expected = np.where(force == 0.0, 0.0, GAP + pressed / PROP)
    assert_allclose(-solution.displacement(f"N{PARTS}")[:, 1], expected, rtol=1e-9)
    assert_allclose(contact.force, np.where(force == 0.0, 0.0, pressed), rtol=1e-7)


def test_contact_is_unresolved_where_such_a_mechanism_hides_what_is_coupled() -> None:
    """Of two props one bears nothing under these loads, but an offset of the other would load it."""
    tip, middle = f"N{PARTS}", f"N{PARTS // 2}"
    props = PARTS // 2, PARTS
    shares = [
        with_an_arm(*props, **{node: 1.0}).solve(clearance=False).joint_force(f"prop {PARTS // 2}")[:, 1]
        for node in (tip, middle)
    ]
    solution = with_an_arm(*props, **{tip: -20.0, middle: 20.0 * shares[0] / shares[1]}).solve()
    assert (solution.status == "unresolved").all()
    assert np.isnan(solution.contact(f"prop {PARTS}").force).all()


def test_what_bears_in_one_sample_is_no_matter_in_another() -> None:
    """The prop is loaded in some, the hinge of the arm, whose mechanism offsets reach, in others: as each is alone."""
    tip, arm = np.array([-20.0, 0.0, -20.0]), np.array([0.0, 5.0, 5.0])
    whole = with_an_arm(PARTS, **{f"N{PARTS}": tip[:, None], "T": arm[:, None]}).solve()
    for sample in range(3):
        alone = with_an_arm(PARTS, **{f"N{PARTS}": tip[sample], "T": arm[sample]}).solve()
        for name, loaded in {f"prop {PARTS}": tip, "hinge": arm}.items():
            assert (whole.contact(name).status[sample] == ("closed" if loaded[sample] else "free")).all()
            assert_array_equal(whole.contact(name).offset[sample], alone.contact(name).offset)
        for node in (f"N{PARTS}", "T"):
            assert_array_equal(whole.displacement(node)[sample], alone.displacement(node))


@pytest.mark.parametrize("lead", [0.0, 1e-12, 1e-9, 1e-6])
@pytest.mark.parametrize("samples", [1, 2, 5000])
def test_a_pin_without_load_is_free_at_a_dead_point_too(lead: float, samples: int) -> None:
    """Coupler and rocker in a line but for rounding, which an offset drives by 10⁸ times as much; E alone bears."""
    crank, coupler, rocker, ground = 0.3, 0.2, 0.15, 0.4
    dead = np.arccos((crank**2 + ground**2 - (coupler + rocker) ** 2) / (2.0 * crank * ground))
    linkage = linkages.four_bar(crank, coupler, rocker, ground, dead - 0.3)
    for joint, first, second in (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "ground", "rocker")):
        linkage.revolute(joint, first, second, clearance=1e-4, replace=True)
    frame = linkage.move({"A": [[dead - lead]]}).frame()
    frame.load("E.rocker", fx=np.linspace(5.0, 6.0, samples), fy=3.0)
    solution = frame.solve()
    assert (solution.state == SolutionState.FREE).all()
    for joint, state in {"B": "free", "D": "free", "E": "closed"}.items():
        assert (solution.contact(joint).status == state).all()
