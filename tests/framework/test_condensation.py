"""Members in line condensed to their ends: the results are those of the elimination one by one, and of 50 digits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, Solution
from linkframe.framework.batched import condensation
from linkframe.framework.cache import SOLVED
from reference.as_frame import as_frame
from reference.compare import allowed, apart, stacked
from reference.random_structures import CLAMPED, member
from reference.stiffness_method import solve
from reference.structure import Structure, Vector

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
THETA = np.linspace(0.2, 1.2, 5)[:, None]
SPRINGS = np.linspace(1e6, 2e6, 7)
COUNT = 21


def bent(k: int) -> tuple[float, float, float]:
    """Points of a link that is bent in space."""
    x = k / COUNT
    return x, 0.2 * np.sin(2.0 * x), 0.1 * x * x


def arm(pivot: object = SPRINGS, branch: int | None = None) -> Frame:
    """A turning link of many members, some described from end to start, on a spring hinge; its tip is loaded."""
    c, s, o = np.cos(THETA), np.sin(THETA), np.zeros_like(THETA)
    axes = np.stack([np.stack([c, -s, o], -1), np.stack([s, c, o], -1), np.stack([o, o, o + 1.0], -1)], -2)
    frame = Frame()
    frame.node("ground", (0.0, 0.0, 0.0))
    frame.body("link", axes=axes)
    for k in range(COUNT + 1):
        frame.node(f"n{k}", bent(k), "link")
    for k in range(COUNT):
        ends = (f"n{k}", f"n{k + 1}")
        frame.add(f"m{k}", BAR, *(ends if k % 3 else ends[::-1]))
    if branch is not None:
        frame.node("twig", np.add(bent(branch), (0.0, 0.3, 0.0)), "link")
        frame.add("twig", BAR, f"n{branch}", "twig")
    stiffness = np.stack([np.asarray(pivot, dtype=float)] * 6, axis=-1)
    frame.add("pivot", Joint(stiffness=stiffness), "ground", "n0")
    frame.fix("ground")
    frame.load(f"n{COUNT}", fx=1.0, fy=SPRINGS / 1e6, fz=2.0, mz=0.1)
    return frame


def one_by_one(frame: Frame, monkeypatch: pytest.MonkeyPatch) -> Solution:
    """The same without condensation."""
    monkeypatch.setattr(condensation, "FEW", 10**9)
    SOLVED.drop(frame)
    return frame.solve()


def loaded_inside() -> Frame:
    frame = arm()
    frame.load("n9", fz=3.0)
    frame.line_load("m14", fy=2.0)
    return frame


def offset() -> Frame:
    frame = arm()
    frame.offset("pivot", ux=1e-3, rz=SPRINGS / 1e9)
    return frame


CASES: dict[str, Callable[[], Frame]] = {
    "arm": arm,
    "branch": lambda: arm(branch=10),
    "loaded inside": loaded_inside,
    "offset": offset,
}


@pytest.mark.parametrize("case", CASES)
def test_as_one_by_one(case: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Displacements of all nodes, forces in all members and in the joint, at every entry."""
    solution = CASES[case]().solve()
    assert solution.plan.condensed.nodes
    other = one_by_one(CASES[case](), monkeypatch)
    assert not other.plan.condensed.nodes
    for read, names, least in (
        (Solution.displacement, solution.frame.nodes, 1e-12),
        (Solution.joint_force, ["pivot"], 1e-12),
        # A stiffness times a difference of displacements some 10^6 times as large.
        (Solution.end_forces, solution.frame.members, 1e-8),
    ):
        ours, theirs = (np.stack([np.asarray(read(each, name)) for name in names]) for each in (solution, other))
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=least * np.abs(theirs).max())
    np.testing.assert_array_equal(solution.status, other.status)


def test_fifty_digits() -> None:
    """A bent bar of 21 members of different sections, clamped at one end, to rounding."""
    rng = np.random.default_rng(1)
    nodes: dict[str, Vector] = {f"n{k}": tuple(map(float, bent(k))) for k in range(COUNT + 1)}  # type: ignore[misc]
    chord = np.array([0.3, 0.05, 0.02])
    members = {f"m{k}": member(rng, f"n{k}", f"n{k + 1}", chord) for k in range(COUNT)}
    structure = Structure(
        nodes, members, supports={"n0": CLAMPED}, loads={f"n{COUNT}": (30.0, -70.0, 50.0, 3.0, -2.0, 1.0)}
    )
    solution = as_frame(structure).solve(method="broadcast")
    assert len(solution.plan.condensed.nodes) == COUNT - 1
    truth = solve(structure)
    found = apart(stacked({name: solution.displacement(name) for name in nodes}), stacked(truth.displacement))
    assert found < 1e-13
    assert found < allowed(solution.scaled_condition_number())
    reaction = apart(stacked({"n0": solution.reaction("n0")}), stacked(truth.reaction))
    assert reaction < 1e-10


def test_both_ends_held() -> None:
    """A chain that one support moves and another holds: nothing is left but what is known, and its inside is told."""
    frame = Frame()
    for k in range(COUNT + 1):
        frame.node(f"n{k}", (0.1 * k, 0.0, 0.0))
    for k in range(COUNT):
        frame.add(f"m{k}", BAR, f"n{k}", f"n{k + 1}")
    frame.fix("n0")
    frame.prescribe(f"n{COUNT}", ux=0.0, uy=[1e-3, 2e-3], uz=0.0, rx=0.0, ry=0.0, rz=0.0)
    solution = frame.solve(method="broadcast")
    assert len(solution.plan.condensed.nodes) == COUNT - 1
    x = np.arange(COUNT + 1) / COUNT
    moved = np.stack([solution.displacement(f"n{k}")[:, 1] for k in range(COUNT + 1)], axis=-1)
    np.testing.assert_allclose(moved, np.array([[1e-3], [2e-3]]) * (3 * x**2 - 2 * x**3), rtol=1e-12, atol=1e-18)
    assert (solution.status == "regular").all()
    assert "20 nodes that only members in line are on" in solution.explain()


def straight(hinged: dict[int, str]) -> Frame:
    """A straight cantilever of many members, some with hinges."""
    frame = Frame()
    for k in range(COUNT + 1):
        frame.node(f"n{k}", (0.1 * k, 0.0, 0.0))
    for k in range(COUNT):
        beam = Beam(BAR.section, BAR.material, release=hinged[k]) if k in hinged else BAR
        frame.add(f"m{k}", beam, f"n{k}", f"n{k + 1}")
    frame.fix("n0")
    frame.load(f"n{COUNT}", fy=1.0)
    return frame


@pytest.mark.parametrize(
    ("hinged", "condensed"),
    [({7: "end rz"}, True), ({7: "end rz", 8: "start rz"}, False), ({3: "end rz", 9: "end rz", 15: "end rz"}, False)],
    ids=["one", "a node turns freely", "three in line"],
)
def test_hinges(hinged: dict[int, str], condensed: bool) -> None:
    """A chain that moves between fixed ends is left to the elimination one by one; either way a mechanism is told."""
    solution = straight(hinged).solve(method="broadcast")
    assert solution.plan.chains
    assert bool(solution.plan.condensed.nodes) == condensed
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.displacement(f"n{COUNT}")).all()
    assert solution.status == "mechanism"


def test_other_loads() -> None:
    """A plan taken up for other loads has the chains of these: the same bits as of a frame never solved."""
    frame = arm()
    first = frame.solve()
    first.displacement("n5")
    fresh = arm()
    for each in (frame, fresh):
        each.load(f"n{COUNT}", fy=1.0)
    again = frame.solve()
    assert again.plan.condensed is first.plan.condensed
    np.testing.assert_array_equal(again.displacement("n5"), fresh.solve().displacement("n5"))
    for each in (frame, fresh):
        each.load("n5", fy=1.0)
    again = frame.solve()
    assert again.plan.topology.number["n5"] not in again.plan.condensed.nodes
    np.testing.assert_array_equal(again.displacement("n5"), fresh.solve().displacement("n5"))


def test_few_are_left_alone() -> None:
    """Where there are hardly any nodes in line nothing is done."""
    frame = Frame()
    for k in range(4):
        frame.node(f"n{k}", (0.1 * k, 0.0, 0.0))
    for k in range(3):
        frame.add(f"m{k}", BAR, f"n{k}", f"n{k + 1}")
    frame.fix("n0")
    frame.load("n3", fy=1.0)
    plan = frame.solve().plan
    assert plan.chains == []
    assert "in line" not in frame.explain()


def test_rings() -> None:
    """A ring that hangs on one node is no chain between two ends: its members are eliminated one by one."""
    frame = Frame()
    angle = 2.0 * np.pi * np.arange(24) / 24
    for k, at in enumerate(angle):
        frame.node(f"n{k}", (np.cos(at), np.sin(at), 0.0))
    for k in range(24):
        frame.add(f"m{k}", BAR, f"n{k}", f"n{(k + 1) % 24}")
    frame.fix("n0")
    frame.load("n12", fy=1.0)
    solution = frame.solve(method="broadcast")
    assert len(solution.plan.condensed.nodes) == 22
    top = solution.displacement("n12")
    held = frame.solve(method="sparse").displacement("n12")
    np.testing.assert_allclose(top, held, rtol=1e-10, atol=1e-16)
    other = Frame()
    other.nodes, other.members, other.size = frame.nodes, frame.members, frame.size
    other.fix("n0")
    other.load("n0", fy=1.0)
    assert not other.solve(method="broadcast").plan.condensed.nodes
