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
