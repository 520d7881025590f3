"""A kind of joint that the library does not have: an entry of the catalogue and a method, as README says."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.models import Linkage
from linkframe.models.linkage.description.joints import KINDS, Kind

RADIUS, ANGLES = 0.1, np.array([0.3, 0.8, 2.0])


class SlottedLinkage(Linkage):
    """With a pin in a slot along x."""

    def slot(self, point, first, second, drive=False):
        self._add("slot", point, (first, second), (0, 0, 1), None, drive, None, None, None, 0.0, 0.0, False)


@pytest.fixture(autouse=True)
def catalogue(monkeypatch):
    monkeypatch.setitem(KINDS, "slot", Kind("slot", ("ux", "rz"), ("uy",)))


def scotch_yoke():
    rod = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3, density=7800.0))
    linkage = SlottedLinkage(A=(0, 0), B=(RADIUS, 0), C=(RADIUS, 0.3), D=(RADIUS, 0.5))
    linkage.link("crank", "A", "B", beam=rod)
    linkage.link("yoke", "B", "C", "D", beam=rod)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.slot("B", "yoke", "crank")
    linkage.prismatic("C", "ground", "yoke", axis=(0, 1, 0))
    return linkage


def test_it_closes_a_loop():
    linkage = scotch_yoke()
    assert linkage.mobility().actual == 1
    motion = linkage.move(A=ANGLES)
    np.testing.assert_allclose(motion.position("D")[:, 1], 0.5 + RADIUS * np.sin(ANGLES), atol=1e-15)


def test_what_moves_in_it_is_told():
    motion = scotch_yoke().move(A=ANGLES, rates={"A": 2.0})
    np.testing.assert_allclose(motion.coordinate("B")[:, 0], RADIUS * (np.cos(ANGLES) - 1.0), atol=1e-15)


def test_its_frame_stands_on_the_beam_in_which_the_slot_is():
    """A force across the slot shortens the yoke and bends the crank as a cantilever."""
    motion = scotch_yoke().move(A=0.0)
    frame = motion.frame()
    frame.load("D", fy=1.0)
    sinking = frame.solve().displacement("D")[1]
    area, inertia = np.pi * 0.02**2 / 4.0, np.pi * 0.02**4 / 64.0
    expected = RADIUS**3 / (3.0 * 2e11 * inertia) + 0.5 / (2e11 * area)
    np.testing.assert_allclose(sinking, expected, rtol=1e-12)


def test_it_drives_and_carries():
    linkage = SlottedLinkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B")
    linkage.slot("A", "ground", "arm", drive=True)
    place = linkage.move(A=(0.5, np.pi / 2)).position("B")
    np.testing.assert_allclose(place, [0.5, 1.0, 0.0], atol=1e-15)


def test_it_can_be_written(tmp_path):
    linkage = SlottedLinkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B", mass=1.0, centre=(0.5, 0.0), inertia=0.1)
    linkage.slot("A", "ground", "arm", drive=True)
    linkage.save(tmp_path / "arm.xml")
    text = (tmp_path / "arm.xml").read_text()
    assert 'type="slide"' in text
    assert 'type="hinge"' in text
