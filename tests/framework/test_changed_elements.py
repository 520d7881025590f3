"""Another element in place: what depends on connections alone is taken up, and results are those of a new frame."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle, Section, Tube
from linkframe.framework import Frame
from linkframe.framework.structure.group import Group

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
ROD = Beam(Circle(diameter=0.02), STEEL)
SECTION = Section(A=3e-4, Iy=8e-9, Iz=6e-9, J=1.2e-8)
PLACES = {"A": (0.0, 0.0, 0.0), "B": (0.5, 0.1, 0.2), "C": (0.5, 0.1, 0.2), "D": (0.9, -0.2, 0.4), "E": (1.0, 0.5, 0.0)}
ELEMENTS: dict[str, Any] = {
    "same form": Beam(Circle(diameter=0.03), STEEL),
    "other form": Beam(Tube(outer=0.03, thickness=0.002), STEEL),
    "properties": Beam(SECTION, STEEL),
    "segments": Beam(Circle(diameter=0.03), STEEL, segments=3),
    "released": Beam(Circle(diameter=0.03), STEEL, release="end rz"),
    "taper": Beam(Circle(diameter=0.03), STEEL, end=Circle(diameter=0.02)),
    "turned": Beam(Rectangle(y=0.03, z=0.01), STEEL, up=(0.0, 1.0, 0.3)),
    "batch": Beam(Circle(diameter=np.array([0.02, 0.03])), STEEL),
}


def described(element: Beam) -> Frame:
    frame = Frame()
    for name, place in PLACES.items():
        frame.node(name, place)
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", element, "C", "D")
    frame.add("DE", ROD, "D", "E")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 10.0)), "B", "C")
    frame.fix("A")
    frame.fix("E")
    frame.load("D", fy=10.0, mz=1.0)
    frame.gravity((0.0, 0.0, -9.81))
    return frame


@pytest.mark.parametrize("kind", ELEMENTS)
def test_results_are_those_of_a_frame_described_anew(kind: str) -> None:
    """To the bit, also back again, with a node moved at once, and under another load."""
    element, frame = ELEMENTS[kind], described(ROD)
    first = frame.solve().displacement("D")
    for _ in range(3):
        frame.change("CD", element)
        found, anew = frame.solve(), described(element).solve()
        np.testing.assert_array_equal(found.displacement("D"), anew.displacement("D"))
        np.testing.assert_array_equal(found.end_forces("CD"), anew.end_forces("CD"))
        np.testing.assert_array_equal(found.reaction("A"), anew.reaction("A"))
        frame.change("CD", ROD)
        np.testing.assert_array_equal(frame.solve().displacement("D"), first)
    frame.change("CD", element)
    frame.change("D", (0.9, -0.1, 0.4))
    frame.set_load("D", fx=5.0)
    other = described(element)
    other.change("D", (0.9, -0.1, 0.4))
    other.set_load("D", fx=5.0)
    np.testing.assert_array_equal(frame.solve().displacement("D"), other.solve().displacement("D"))


@dataclass(frozen=True, eq=False)
class LinedBeam(Beam):
    """A beam with a lining as heavy as itself."""

    def mass_per_length(self, fraction: Any = 0.0) -> Any:
        return 2.0 * super().mass_per_length(fraction)

    def mass_matrix(self, length: Any) -> Any:
        return 2.0 * super().mass_matrix(length)


@pytest.mark.parametrize("name", ["AB", "DE"])
def test_an_element_of_a_class_of_ones_own_gives_way_to_a_plain_one(name: str) -> None:
    """Whose family it has inherited; what is left of its like stays what it is."""

    pipe = LinedBeam(Circle(diameter=0.02), STEEL)

    def lined(plain: str) -> Frame:
        frame = described(pipe)
        for member in ("AB", "DE"):
            frame.change(member, ROD if member == plain else pipe)
        return frame

    frame = lined("")
    heavy = frame.solve().reactions()
    frame.change(name, ROD)
    found = frame.solve().reactions()
    np.testing.assert_array_equal(found, lined(name).solve().reactions())
    assert not np.allclose(found, heavy, rtol=1e-3)


class WarmBeam(Beam):
    """A beam that grows by one part in ten thousand."""

    def free_strain(self, fraction: Any) -> Any:
        return np.array([1e-4, 0.0, 0.0, 0.0, 0.0, 0.0])


def test_what_grows_by_heat_takes_the_place_of_what_does_not() -> None:
    """It was known of the first that nothing loads it; its end goes by strain times length."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", ROD, "A", "B")
    frame.fix("A")
    for element, growth in ((ROD, 0.0), (WarmBeam(Circle(diameter=0.02), STEEL), 2e-4), (ROD, 0.0)):
        frame.change("AB", element)
        np.testing.assert_allclose(frame.solve().displacement("B"), [growth, 0, 0, 0, 0, 0], rtol=0.0, atol=1e-18)


@pytest.mark.parametrize("kind", ["same form", "taper"])
def test_numbering_and_joints_are_taken_up(kind: str) -> None:
    frame = described(ROD)
    before = frame.solve()
    before.displacement("D")
    frame.change("CD", ELEMENTS[kind])
    after = frame.solve()
    after.displacement("D")
    assert after.plan.topology.number is before.plan.topology.number
    links = [each.plan.unloaded.known_links for each in (before, after)]
    assert links[0] is links[1]
    assert links[0] is not None
    stacks = [each.plan.unloaded.known_stacks for each in (before, after)]
    assert stacks[0] is not stacks[1]


def test_solutions_of_a_known_topology_travel() -> None:
    """Their unknowns too, which are found where they are asked for."""
    for number in range(6):
        solution = described(Beam(Circle(diameter=0.02 + 0.001 * number), STEEL)).solve()
        moved = solution.displacement("D")
        copy = pickle.loads(pickle.dumps(solution))
        np.testing.assert_array_equal(copy.displacement("D"), moved)
        np.testing.assert_array_equal(copy.reaction("A"), solution.reaction("A"))


def rung(*elements: Beam) -> Frame:
    """A ladder of six members between places of no pattern, of these elements in turn."""
    frame, places = Frame(), np.random.default_rng(5).normal(size=(6, 3))
    for number, place in enumerate(places):
        frame.node(f"N{number}", place)
    for number in range(12):
        frame.add(
            f"m{number}", elements[number % len(elements)], f"N{number % 6}", f"N{(number + 1 + number // 6) % 6}"
        )
    frame.fix("N0")
    frame.load("N3", fx=1.0, fz=2.0, my=0.5)
    return frame


def test_members_that_stay_are_not_evaluated_again() -> None:
    """Stiffness is taken up by stacks, and within a stack by members; results are those of a new frame, to the bit."""
    flat, taper = Beam(Rectangle(y=0.02, z=0.01), STEEL), Beam(Circle(diameter=0.02), STEEL, end=Circle(diameter=0.01))
    frame = rung(ROD, flat, taper)
    for step in range(6):
        name, place = f"m{3 * (step % 2)}", (0.1 * step, 0.2, -0.3)
        if step < 4:
            frame.change(name, Beam(Circle(diameter=0.021 + 0.001 * step), STEEL))
            frame.change("m2", Beam(Circle(diameter=0.02), STEEL, end=Circle(diameter=0.011 + 0.001 * step)))
        else:
            frame.change("N3", place)
        found, anew = frame.solve(), pickle.loads(pickle.dumps(frame)).solve()
        np.testing.assert_array_equal(found.displacement("N3"), anew.displacement("N3"))
        np.testing.assert_array_equal(found.end_forces("m7"), anew.end_forces("m7"))
    before = frame.solve()
    before.displacement("N3")
    frame.change("m0", Beam(Circle(diameter=0.05), STEEL))
    after = frame.solve()
    after.displacement("N3")
    rods, *others = zip(*(each.plan.unloaded.known_stacks or () for each in (before, after)), strict=True)
    assert all(one is other for one, other in others)
    assert (rods[0] != rods[1]).any(axis=(1, 2)).tolist() == [True, False, False, False]


def test_where_a_node_moved_its_members_alone_are_evaluated(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a stack of other sections too, and to the bit."""
    frame = described(ROD)
    for name, diameter in {"AB": 0.03, "DE": 0.025}.items():
        frame.change(name, Beam(Circle(diameter=diameter), STEEL))
        frame.solve().displacement("D")
    evaluated, step = list[list[int]](), np.array([0.01, 0.02, 0.0])
    stiffness = Group.extended_stiffness

    def noted(group: Group) -> np.ndarray[Any, Any]:
        evaluated.append(group.pieces.tolist())
        return stiffness(group)

    for moved, members in (("E", [2]), ("D", [1, 2]), ("BC", [0, 1]), ("BCD", [0, 2]), ("BCE", [0, 1, 2])):
        places = [frame.nodes[node].coordinates + step for node in moved]
        frame.change(tuple(moved), places if len(moved) > 1 else places[0])
        with monkeypatch.context() as patched:
            patched.setattr(Group, "extended_stiffness", noted)
            found = frame.solve().displacement("D")
        assert evaluated == [members]
        evaluated.clear()
        np.testing.assert_array_equal(found, pickle.loads(pickle.dumps(frame)).solve().displacement("D"))


def test_copies_share_supports_until_they_change() -> None:
    frame = described(ROD)
    frame.offset("pin", ux=1e-3)
    copy = frame.copy()
    assert copy.supports["A"] is frame.supports["A"]
    copy.prescribe("A", ux=1e-3)
    copy.fix_many(["E"], "ux")
    copy.offset("pin", uy=1e-3)
    assert frame.supports["A"][0] == 0.0
    assert copy.supports["A"][0] == 1e-3
    assert (sorted(frame.offsets["pin"]), sorted(copy.offsets["pin"])) == ([0], [0, 1])
