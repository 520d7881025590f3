"""The formulas of a linkage are written down once for all linkages that differ in the values of dimensions alone."""

from __future__ import annotations

import pickle
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from linkframe.framework.cache import FORMULAS
from linkframe.models import Linkage
from linkframe.models.linkage.kinematics import mechanism

# Points A, B, D and E of four-bars by one name; what is 0 in one is not in another, or equal to another dimension.
FOUR_BARS = {
    "ground level": ((0.0, 0.0), (0.1, 0.9), (2.2, 1.7), (3.0, 0.0)),
    "ground sloping": ((0.0, 0.0), (0.1, 0.9), (2.2, 1.7), (3.0, 0.3)),
    "coupler level": ((0.0, 0.0), (0.1, 0.9), (2.2, 0.9), (3.0, 0.0)),
    "crank along y": ((0.0, 0.0), (0.0, 1.0), (2.2, 1.7), (3.0, 0.0)),
    "equal numbers": ((0.0, 0.0), (0.5, 0.5), (2.5, 2.0), (2.5, 0.0)),
    "other numbers": ((0.2, 0.1), (0.4, 1.2), (2.3, 1.6), (3.1, -0.2)),
}
TURNS = (0.0, 0.3, -0.5)


def four_bar(name: str) -> Linkage:
    linkage = Linkage(**dict(zip("ABDE", FOUR_BARS[name], strict=True)))
    for link, ends in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        linkage.link(link, *ends)
    links = ("ground", "crank", "coupler", "rocker", "ground")
    for k, pin in enumerate("ABDE"):
        linkage.revolute(pin, links[k], links[k + 1], drive=pin == "A")
    return linkage


def by_circles(name: str, turn: float) -> complex:
    """Where D is: the intersection of two circles that lies on the side of the reference configuration."""
    a, b, d, e = (complex(*point) for point in FOUR_BARS[name])
    coupler, rocker, side = abs(d - b), abs(d - e), np.sign(((d - b) * (e - b).conjugate()).imag)
    b = a + (b - a) * np.exp(1j * turn)
    to = e - b
    along = (coupler**2 - rocker**2 + abs(to) ** 2) / (2.0 * abs(to))
    return complex(b + to / abs(to) * (along + 1j * side * np.sqrt(coupler**2 - along**2)))


def places(name: str) -> list[complex]:
    linkage = four_bar(name)
    return [complex(*linkage.move(A=turn).position("D")[:2]) for turn in TURNS]


def test_each_has_its_own_dimensions() -> None:
    FORMULAS.clear()
    with ThreadPoolExecutor(4) as pool:
        once, again = pool.map(places, FOUR_BARS), pool.map(places, FOUR_BARS)
    for name, found, same in zip(FOUR_BARS, once, again, strict=True):
        np.testing.assert_allclose(found, [by_circles(name, turn) for turn in TURNS], rtol=0.0, atol=1e-13)
        FORMULAS.clear()
        assert places(name) == found == same


def hung(*links: str) -> Linkage:
    """Two bars on the ground at A and C, of these names."""
    linkage = Linkage(A=(0.0, 0.0), B=(1.0, 0.2), C=(2.0, 0.0), D=(2.5, 0.7))
    for link in sorted(links):
        linkage.link(link, *("AB" if link == links[0] else "CD"))
    for pin, link in zip("AC", links, strict=True):
        linkage.revolute(pin, "ground", link, drive=True)
    return linkage


def spatial(first: str = "revolute", last: str = "spherical", links: str = "abc", drive: str = "A") -> Linkage:
    """A loop of four bars whose second joint and the one that closes it are of these kinds."""
    linkage = Linkage(A=(0.0, 0.0), B=(0.1, 0.9), P=(2.2, 1.7), D=(3.0, 0.0))
    for link in links:
        linkage.link(link, *{"a": "AB", "b": "BP", "c": "PD"}[link])
    kinds = "revolute", first, last, "revolute"
    for point, kind, one, other in zip("ABPD", kinds, ("ground", *"abc"), (*"abc", "ground"), strict=True):
        getattr(linkage, kind)(point, one, other, drive=point == drive)
    return linkage


def screw(pitch: float) -> Linkage:
    """A nut; the size of the linkage is 2."""
    linkage = Linkage(A=(0.0, 0.0), B=(0.0, 1.0), C=(1.0, 0.0), D=(1.0, 1.0))
    linkage.link("nut", *"ABCD")
    linkage.screw("A", "ground", "nut", axis=(0.0, 0.0, 1.0), pitch=pitch, drive=True)
    return linkage


# Of each two neighbours all dimensions are the same numbers, or known beforehand by the same ones, but for one thing.
NEIGHBOURS = {
    "bars": lambda: hung("x", "y"),
    "bars exchanged": lambda: hung("y", "x"),
    "loop": spatial,
    "loop, cylindrical joint on the tree": lambda: spatial("cylindrical"),
    "loop, hinge closes it": lambda: spatial(last="revolute"),
    "loop, cylindrical joint closes it": lambda: spatial(last="cylindrical"),
    "loop, links in another order": lambda: spatial(links="cba"),
    "loop, driven from the other side": lambda: spatial(drive="D"),
    "screw": lambda: screw(0.3),
    "screw that advances by the size of the linkage per radian": lambda: screw(4.0 * np.pi),
    "screw that advances so the other way": lambda: screw(-4.0 * np.pi),
}


def answers(linkage: Linkage) -> list[np.ndarray]:
    drives = dict.fromkeys(linkage.drives, 0.2)
    motion = linkage.move(drives, rates=dict.fromkeys(drives, 3.0))
    asked = [(end, link) for link, bar in sorted(linkage.links.items()) for end in sorted(bar.points)]
    questions = motion.position, motion.velocity, motion.acceleration
    mechanism = motion.mechanism
    places = mechanism.poses[0]([0.0] * mechanism.entries, mechanism.parameters)
    return [*(ask(*each) for ask in questions for each in asked), np.array(places)]


def test_no_linkage_takes_the_formulas_of_its_neighbour() -> None:
    alone = {}
    for name, made in NEIGHBOURS.items():
        FORMULAS.clear()
        alone[name] = answers(made())
    FORMULAS.clear()
    for name, made in NEIGHBOURS.items():
        for found, expected in zip(answers(made()), alone[name], strict=True):
            np.testing.assert_array_equal(found, expected, err_msg=name)


@pytest.mark.parametrize(("pitch", "count"), [(0.3, 2), (0.3, 100_000), (4.0 * np.pi, 2), (-4.0 * np.pi, 2)])
def test_points_of_a_nut(pitch: float, count: int) -> None:
    """Whichever components lead to a point, and whether or not the pitch is the linkage's size per radian."""
    turn = np.linspace(0.2, 0.5, count)
    motion = screw(pitch).move(A=turn)
    for point, place in {"A": 0.0, "B": 1.0j, "C": 1.0, "D": 1.0 + 1.0j}.items():
        x, y, z = motion.position(point, "nut").T
        np.testing.assert_allclose(x + 1j * y, place * np.exp(1j * turn), rtol=0.0, atol=4e-15)
        np.testing.assert_allclose(z, pitch * turn / (2.0 * np.pi), rtol=4e-15)


def test_other_values_need_no_other_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    places("ground level")
    written: list[object] = []
    formulas = mechanism.Formulas
    monkeypatch.setattr(mechanism, "Formulas", lambda of: written.append(of) or formulas(of))
    monkeypatch.setitem(FOUR_BARS, "ground level", ((0.0, 0.0), (0.1, 1.1), (2.4, 1.6), (2.9, 0.0)))
    places("ground level")
    assert not written
    FORMULAS.clear()
    places("ground level")
    assert len(written) == 1


def test_a_motion_travels_without_them() -> None:
    motion = four_bar("other numbers").move(A=0.3, rates={"A": 2.0})
    place, speed = motion.position("D"), motion.velocity("D")
    there = pickle.loads(pickle.dumps(motion))
    np.testing.assert_array_equal(there.position("D"), place)
    np.testing.assert_array_equal(there.velocity("D"), speed)
    assert "formulas" not in vars(there.mechanism)
