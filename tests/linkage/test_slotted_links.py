"""Sliders on elastic links load them where they are at every pose: closed forms, orders of points, pose by pose."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.motion import Motion
from numpy.testing import assert_allclose

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7850.0))
EI = 200e9 * np.pi * 0.02**4 / 64
START = 0.4
CRANK, BELOW = 0.1, 0.3
# A turn that begins and ends as drawn, with the slider on the drawn point.
TURN = START + np.linspace(0.0, 2.0 * np.pi, 25)


def shaper(order: str = "EBQ", reach: float = 0.7, turn: np.ndarray | None = None, **lever: object) -> Linkage:
    """A crank's block slides along a lever from E past B, where it is drawn, to Q; `turn` sets it up in space."""
    turn = np.eye(3) if turn is None else turn
    b = CRANK * np.array([np.cos(START), np.sin(START), 0.0])
    e = np.array([0.0, -BELOW, 0.0])
    u = (b - e) / np.linalg.norm(b - e)
    places = {"O": np.zeros(3), "B": b, "E": e, "Q": e + reach * u}
    linkage = Linkage({name: turn @ place for name, place in places.items()})
    linkage.link("crank", "O", "B")
    linkage.link("block", "B")
    linkage.link("lever", *order, **({"beam": ROD} | lever))  # type: ignore[arg-type]
    z = turn[:, 2]
    linkage.revolute("O", "ground", "crank", axis=z, drive=True, reference=START)
    linkage.revolute("B", "crank", "block", axis=z)
    linkage.prismatic("B", "lever", "block", axis=turn @ u, name="slide")
    linkage.revolute("E", "ground", "lever", axis=z)
    return linkage


def across(motion: Motion, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Unit vector across the lever, its length, and the slider's distance from its pivot."""
    arm = motion.position("Q", "lever") - motion.position("E", "lever")
    length = np.linalg.norm(arm, axis=-1)
    slider = np.linalg.norm(motion.position("B", "block") - motion.position("E", "lever"), axis=-1)
    return np.cross(normal, arm) / length[..., None], length, slider


@pytest.mark.parametrize("order", ["".join(order) for order in itertools.permutations("EBQ")])
def test_a_lever_that_overhangs_its_slider_in_any_order_of_its_points(order: str) -> None:
    """Load F at the end of an overhang a beyond a span s: F a^2 (a + s) / 3EI; moment F a at the slider."""
    linkage, force = shaper(order), 50.0

    def found(angles: object) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        motion = linkage.move(O=angles)
        n, length, s = across(motion, np.array([0.0, 0.0, 1.0]))
        a = length - s
        load = {"fx": force * n[..., 0], "fy": force * n[..., 1]}
        moved = np.sum(motion.accuracy("Q", **load).total[..., :3] * n, axis=-1)
        assert_allclose(moved, force * a**2 * (a + s) / (3 * EI), rtol=1e-12)
        linkage.load("Q", link="lever", **load)
        stress = linkage.move(O=angles).stress("lever")
        linkage.loads.clear()
        assert_allclose(stress.greatest, force * a * 0.01 / (EI / 200e9), rtol=1e-11)
        return moved, stress.least, stress.greatest, stress.von_mises

    one_by_one = [np.stack(each) for each in zip(*map(found, TURN[::6]), strict=True)]
    for sweep, single in zip(found(TURN), one_by_one, strict=True):
        assert_allclose(sweep[::6], single, rtol=1e-12)


def test_a_lever_set_up_in_space() -> None:
    turn = np.linalg.qr(np.array([[0.3, -0.7, 0.2], [0.5, 0.4, -0.9], [-0.6, 0.1, 0.8]]))[0]
    turn = turn * np.linalg.det(turn)
    motion = shaper(turn=turn).move(O=TURN)
    n, length, s = across(motion, turn[:, 2])
    found = motion.accuracy("Q", **{f"f{x}": 50.0 * n[:, k] for k, x in enumerate("xyz")}).total
    a = length - s
    assert_allclose(np.sum(found[:, :3] * n, axis=-1), 50.0 * a**2 * (a + s) / (3 * EI), rtol=1e-11)


def test_points_on_a_lever_change_nothing() -> None:
    """Weight and end loads: with the point at which the slider is drawn on the beam, and without."""
    results = []
    for given_lever in ({}, {"beam": {("E", "Q"): ROD}}):
        linkage = shaper("EBQ", **given_lever)
        linkage.gravity((1.0, -9.81, 2.0))
        linkage.load("Q", fx=20.0, fz=7.0, my=3.0)
        solution = linkage.move(O=TURN).frame().solve()
        results.append([solution.displacement("Q"), solution.joint_force("slide"), solution.joint_force("E")])
    for one, other in zip(*results, strict=True):
        assert_allclose(one, other, rtol=0.0, atol=1e-9 * np.abs(other).max())


@pytest.mark.parametrize("neighbour", [None, "beam", "rigid"])
def test_beyond_its_end_a_lever_goes_on_rigidly(neighbour: str | None) -> None:
    """Against frames by hand, pose by pose, with the end B rigid with the slider's node; and with links at Q."""
    linkage = shaper("EBQ", reach=0.33)
    linkage.load("Q", link="lever", fx=100.0, fy=30.0, fz=7.0)
    if neighbour is not None:
        q = linkage.points["Q"]
        linkage.point("R", q + np.array([0.4, 0.1, 0.0]))
        linkage.link("rod", "Q", "R", beam=None if neighbour == "rigid" else ROD)
        linkage.link("ram", "R")
        linkage.revolute("Q", "lever", "rod")
        linkage.revolute("R", "rod", "ram")
        linkage.prismatic("R", "ground", "ram", axis=(1, 0, 0), name="way")
        linkage.load("R", link="ram", fx=-100.0)
    motion = linkage.move(O=TURN)
    _, length, s = across(motion, np.array([0.0, 0.0, 1.0]))
    beyond = s > np.linalg.norm(linkage.points["B"] - linkage.points["E"]) + 1e-3
    assert beyond.any()
    assert (s < length).any()
    solution = motion.frame().solve()
    found = solution.displacement("Q")
    assert set(solution.status) == {"regular"}
    single = np.stack([linkage.move(O=angle).frame().solve().displacement("Q") for angle in TURN[::4]])
    assert_allclose(found[::4], single, rtol=0.0, atol=1e-12 * np.abs(single).max())
    if neighbour is None:
        for index in range(0, len(TURN), 2):
            assert_allclose(found[index], by_hand(motion, index), rtol=1e-9, atol=1e-15)


def by_hand(motion: Motion, index: int) -> np.ndarray:
    """Displacement of Q where the lever E-Q-B is pinned at E and held across, and against all turns, by the slider."""
    spots = {"E": ("E", "lever"), "Q": ("Q", "lever"), "B": ("B", "lever"), "under": ("B", "block")}
    places = {name: motion.position(*at)[index] for name, at in spots.items()}
    away = {name: float(np.linalg.norm(place - places["E"])) for name, place in places.items()}
    frame = Frame()
    for name, place in places.items():
        frame.node(name, place)
    frame.node("held", places["under"])
    within = away["under"] < away["B"] * (1.0 - 1e-12)
    chain = sorted(name for name in places if within or name != "under")
    for here, there in itertools.pairwise(sorted(chain, key=lambda name: away[name])):
        frame.add(here + there, ROD, here, there)
    if not within:
        frame.rigid("B", "under")
    x = (places["Q"] - places["E"]) / away["Q"]
    y = np.cross([0.0, 0.0, 1.0], x)
    # It slides along x, and turns with the block about the pin.
    frame.add("slide", Joint((0.0, *(np.inf,) * 4, 0.0), np.stack([x, y, [0.0, 0.0, 1.0]], axis=-1)), "under", "held")
    frame.fix("held")
    frame.fix("E", "ux", "uy", "uz", "rx", "ry")
    frame.load("Q", fx=100.0, fy=30.0, fz=7.0)
    return frame.solve().displacement("Q")


def at(low: float, high: float) -> st.SearchStrategy[float]:
    """Places on a grid, so that sliders come to stand on points; some a hair beside it."""
    return st.builds(
        lambda k, beside: k / 20 + beside, st.integers(round(20 * low), round(20 * high)), st.sampled_from((0.0, 3e-8))
    )


@settings(max_examples=15)
@given(
    places=st.lists(at(0.1, 0.9), min_size=1, max_size=3, unique_by=lambda x: round(x, 2)),
    reach=st.lists(st.tuples(at(0.0, 1.4), at(0.0, 1.4)), min_size=2, max_size=5),
    order=st.permutations(range(5)),
)
@example(places=[0.5], reach=[(0.0, 0.0), (0.0, 0.5)], order=[0, 1, 2, 3, 4])
# a piece of a beam 3e-8 long, of which the stiffness in double precision tells nothing
@example(places=[0.1, 0.15], reach=[(3e-8, 3e-8), (0.10000003, 0.10000003)], order=[0, 1, 2, 3, 4])
def test_two_sliders_pass_points_and_the_end(
    places: list[float], reach: list[tuple[float, float]], order: list[int]
) -> None:
    """A cantilever with two loads that move: F a^2 (3L - a) / 6EI each; beyond the end with the moment F (a - L)."""
    points = {"E": 0.0, "Q": 1.0} | {f"P{k}": x for k, x in enumerate(places)}
    names = [name for _, name in sorted(zip(order, points, strict=False))]
    linkage = Linkage({name: (x, 0.0) for name, x in points.items()})
    linkage.link("bar", *names, beam=ROD)
    linkage.fixed("E", "ground", "bar")
    # Both are drawn at points of the bar, on which they then stand; they pass all others and the end.
    drives = {}
    lower, upper = (np.array([f(pair) for pair in reach]) for f in (min, max))
    for tool, force, drawn, ways in (("one", 10.0, "P0", lower), ("two", -25.0, "Q", np.maximum(upper, lower + 1e-3))):
        linkage.link(tool, drawn)
        linkage.prismatic(drawn, "bar", tool, axis=(1, 0), drive=True, reference=points[drawn], name=f"{tool} slides")
        linkage.load(drawn, link=tool, fy=force)
        drives[f"{tool} slides"] = np.array([points[drawn], *ways])
    stood = [{name for name, x in points.items() if any(abs(np.minimum(a, 1.0) - x) < 1e-7)} for a in drives.values()]
    if len(stood[0] & stood[1]) > 1:
        with pytest.raises(FrameError, match="comes to stand on"):
            linkage.move(drives).frame()
        return
    found = linkage.move(drives).frame().solve().displacement("Q.bar")[:, 1]
    wanted = 0.0
    for force, a in zip((10.0, -25.0), drives.values(), strict=True):
        inside, arm = np.minimum(a, 1.0), np.maximum(a - 1.0, 0.0)
        wanted = wanted + force * (inside**2 * (3.0 - inside) / 6.0 + arm / 2.0) / EI
    assert_allclose(found, wanted, rtol=0.0, atol=1e-9 * 25.0 / EI)


def test_sliders_that_come_to_stand_on_the_same_points_are_refused() -> None:
    """On one point they may; on two, what holds them there would form a loop."""
    linkage = Linkage(E=(0, 0), S=(0.3, 0), T=(0.6, 0), Q=(1, 0))
    linkage.link("bar", "E", "S", "T", "Q", beam=dict.fromkeys(itertools.pairwise("ESTQ"), ROD))
    linkage.fixed("E", "ground", "bar")
    for tool in "ST":
        linkage.link(f"tool {tool}", tool)
        linkage.prismatic(tool, "bar", f"tool {tool}", axis=(1, 0), drive=True)
    assert linkage.move(S=[0.0, -0.2], T=[0.0, -0.3]).frame().shape == (2,)
    with pytest.raises(FrameError, match=r"slider 'T' comes to stand on 'S' and 'T', as 'S' at other poses: give each"):
        linkage.move(S=[0.0, -0.2, 0.3], T=[0.0, -0.3, 0.2]).frame()


def test_sliders_that_pass_each_other_are_refused() -> None:
    linkage = Linkage(E=(0, 0), S=(0.3, 0), T=(0.6, 0), Q=(1, 0))
    linkage.link("bar", "E", "S", "T", "Q", beam={("E", "Q"): ROD})
    linkage.fixed("E", "ground", "bar")
    for tool in "ST":
        linkage.link(f"tool {tool}", tool)
        linkage.prismatic(tool, "bar", f"tool {tool}", axis=(1, 0), drive=True)
    assert linkage.move(S=[0.0, 0.1], T=[0.0, 0.1]).frame().shape == (2,)
    with pytest.raises(FrameError, match=r"sliders '[ST]' and '[ST]' pass each other on one beam"):
        linkage.move(S=[0.0, 0.4], T=[0.0, -0.1]).frame()


def test_a_slot_along_one_stretch_of_a_bent_link() -> None:
    """The slider loads the straight stretch on which it runs, off its corners, whatever comes before and behind it."""
    linkage = Linkage(A=(0, 0), B=(0, 0.3), C=(0.5, 0.3), D=(0.5, 0.7), S=(0.2, 0.3))
    linkage.link("bent", "A", "B", "C", "D", "S", beam=dict.fromkeys((("A", "B"), ("B", "C"), ("C", "D")), ROD))
    linkage.link("tool", "S")
    linkage.fixed("A", "ground", "bent")
    linkage.prismatic("S", "bent", "tool", axis=(1, 0), drive=True, name="slot", reference=0.2)
    linkage.load("S", link="tool", fy=-40.0)
    a = np.array([0.0, 0.1, 0.2, 0.5, 0.6, -0.1])
    found = linkage.move(slot=a).frame().solve().displacement("D")
    # The post turns by M h / EI and its head goes by M h^2 / 2EI; then the cantilever B-C, rigid beyond its ends.
    inside, arm, moment = np.clip(a, 0.0, 0.5), np.maximum(a - 0.5, 0.0), -40.0 * a
    turned = moment * 0.3 / EI
    stretched = -40.0 * 0.3 / (200e9 * np.pi * 1e-4)
    bent_turn = -40.0 * (inside**2 / 2.0 + arm * 0.5) / EI
    bent_down = -40.0 * (inside**2 * (1.5 - inside) / 6.0 + arm * 0.5**2 / 2.0) / EI
    assert_allclose(found[:, 5], turned + bent_turn, rtol=1e-9, atol=1e-15)
    assert_allclose(found[:, 1], stretched + 0.5 * turned + bent_down, rtol=1e-9, atol=1e-15)
    assert_allclose(found[:, 0], -moment * 0.3**2 / 2.0 / EI - 0.4 * (turned + bent_turn), rtol=1e-9, atol=1e-15)


def test_a_tapered_line_must_not_run_back() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(0.5, 0))
    tapered = Beam(Circle(diameter=0.02), ROD.material, end=Circle(diameter=0.01))
    with pytest.raises(FrameError, match=r"runs back over itself along A, B, C.*in their order"):
        linkage.link("bar", "A", "B", "C", beam=tapered)
    batch = Linkage(A=(0, 0), B=(1, 0), C=np.array([[0.5, 0.0], [1.5, 0.0]]))
    with pytest.raises(FrameError, match="changes within the batch"):
        batch.link("bar", "A", "B", "C", beam=ROD)
    assert not linkage.links
    assert not batch.links


def on_a_plate() -> Linkage:
    """A cantilever, and a plate that is driven in a plane above it, by a planar joint drawn at its end."""
    linkage = Linkage(E=(0, 0, 0), Q=(1, 0, 0))
    linkage.link("cantilever", "E", "Q", beam=ROD)
    linkage.link("plate", "Q")
    linkage.fixed("E", "ground", "cantilever")
    linkage.planar("Q", "cantilever", "plate", axis=(0, 0, 1), drive=("ux", "uy", "rz"), name="plane")
    linkage.load("Q", link="plate", fz=10.0)
    return linkage


def test_a_plate_stands_on_the_beam_only_where_it_lies_on_its_line() -> None:
    """Load F on the beam at s: F s^3 / 3EI. Off its line the drawn end of the beam, at L, carries the plate by an arm
    a = L - s along and b across: F (L^3/3 - a L^2 + a^2 L) / EI + F b^2 L / GJ. A pose knows nothing of others."""
    torsion = 2.0 * EI / (2.0 * 1.3)
    moves = np.array([[-0.3, -0.1, 0.0], [-0.3, 0.0, 0.0], [-0.3, 0.1, 0.0], [-0.6, 0.0, 0.0], [0.2, 0.0, 0.0]])
    a, b = -moves[:, 0], moves[:, 1]
    on_beam = (1.0 - a) ** 3 / 3.0 / EI
    at_end = (1.0 / 3.0 - a + a * a) / EI + b * b / torsion
    expected = 10.0 * np.where((b == 0.0) & (a > 0.0), on_beam, at_end)

    def found(moved: np.ndarray) -> np.ndarray:
        return np.asarray(on_a_plate().move(plane=moved).frame().solve().displacement("Q.plate")[:, 2])

    assert_allclose(found(moves), expected, rtol=1e-11)
    assert_allclose(np.concatenate([found(each[None]) for each in moves]), expected, rtol=1e-11)
