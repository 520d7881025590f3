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
        self._add("slot", point, (first, second), (0, 0, 1), drive, None, None, None, False)


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


def test_the_pin_bears_on_a_turning_lever_where_it_stands():
    """A lever on a pivot and on the pin at d, its end a beyond, sinks there by F a² (a + d) / (3 E I)."""
    pivot, length, modulus, angle = 0.2, 0.45, 2e11, np.linspace(0.0, 2.0 * np.pi, 9)
    lever = Beam(Circle(diameter=0.02), Material(E=modulus, nu=0.3), shear=False)
    linkage = SlottedLinkage(O=(0, 0), A=(0, RADIUS), C=(-pivot, RADIUS), T=(length - pivot, RADIUS))
    linkage.link("crank", "O", "A", beam=Beam(Circle(diameter=2.0), Material(E=1e3 * modulus, nu=0.3)))
    linkage.link("lever", "C", "A", "T", beam=lever)
    linkage.revolute("O", "ground", "crank", drive=True)
    linkage.revolute("C", "ground", "lever")
    linkage.slot("A", "lever", "crank")
    motion = linkage.move(O=angle)
    inside = np.linalg.norm(motion.position("A", "crank") - motion.position("C"), axis=-1)
    across = np.cross([0.0, 0.0, 1.0], motion.position("T") - motion.position("C")) / length
    frame = motion.frame()
    frame.load("T", fx=across[:, 0], fy=across[:, 1])
    sinking = np.sum(frame.solve().displacement("T")[:, :3] * across, axis=-1)
    expected = (length - inside) ** 2 * length / (3.0 * modulus * np.pi * 0.02**4 / 64.0)
    assert np.ptp(inside) > 0.1
    np.testing.assert_allclose(sinking, expected, rtol=1e-5)


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
