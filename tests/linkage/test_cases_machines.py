"""Machines as their handbooks compute them: engine, pump, strut, excavator, screw; also by the laws of motion."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose, assert_array_equal
from reference.audit import audit
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

TURN = np.linspace(0.0, 2.0 * np.pi, 37)
G = 9.81
INERTIA = (0.02, 0.03, 0.04, 0.001, -0.002, 0.003)


@pytest.mark.parametrize("start", [0.0, 1.2])
def test_engine_over_its_cycle(start: float) -> None:
    """Gas force a pose: pin force P / cos b, side thrust P tan b, torque P dx/dt / w (Norton, chapter 13).

    Drawn in its top dead centre too, where the crank, which drives, has no trouble.
    """
    r, rod, mass, speed = 0.05, 0.2, 0.8, 300.0
    theta = np.linspace(0.0, 4.0 * np.pi, 73)
    gas = -1.5e4 * np.exp(-(((theta - np.pi) / 0.4) ** 2)) - 500.0
    linkage = Linkage(
        O=(0, 0),
        A=(r * np.cos(start), r * np.sin(start)),
        B=(r * np.cos(start) + np.sqrt(rod**2 - (r * np.sin(start)) ** 2), 0),
    )
    for name, points in {"crank": "OA", "rod": "AB"}.items():
        linkage.link(name, *points)
    linkage.link("piston", "B", mass=mass)
    linkage.revolute("O", "ground", "crank", drive=True, reference=start)
    linkage.revolute("A", "crank", "rod")
    linkage.revolute("B", "rod", "piston")
    linkage.prismatic("B", "ground", "piston", axis=(1, 0), name="bore")
    linkage.load("B", link="piston", fx=gas)
    motion = linkage.move(O=theta, rates={"O": speed})
    found = motion.reactions()
    sine, cosine, across = np.sin(theta), np.cos(theta), np.sqrt(rod**2 - (r * np.sin(theta)) ** 2)
    v = -speed * r * sine * (1.0 + r * cosine / across)
    a = -(speed**2) * r * (cosine + r * (cosine**2 - sine**2) / across + r**3 * (sine * cosine) ** 2 / across**3)
    push = mass * a - gas
    side = push * r * sine / across
    assert_allclose(motion.acceleration("B")[:, 0], a, rtol=1e-12, atol=1e-9 * speed**2 * r)
    scale = np.abs(push).max()
    assert_allclose(found.force("B")[:, :2] / scale, np.stack([push, -side], -1) / scale, atol=1e-12)
    assert_allclose(found.force("bore")[:, 1] / scale, side / scale, atol=1e-12)
    assert_allclose(found.force("O")[:, :2] / scale, np.stack([push, -side], -1) / scale, atol=1e-12)
    assert_allclose(found.drive("O")[:, 0] / scale, push * v / speed / scale, atol=1e-13)
    assert set(found.method) == {"determinate"}
    ends = [k for k, status in enumerate(motion.status) if status != "regular"]
    assert ends == [0, 18, 36, 54, 72]


def test_swash_plate_pump() -> None:
    """Pistons in a rotor, slippers on a fixed tilted plate: z = R tan(tilt) cos, torque by virtual power."""
    tilt, radius, count, speed, mass, slipper = np.radians(18.0), 0.04, 5, 150.0, 0.1, 0.01
    phase = 2.0 * np.pi * np.arange(count) / count
    stroke = radius * np.tan(tilt)
    places = np.stack([radius * np.cos(phase), radius * np.sin(phase), stroke * np.cos(phase)], axis=-1)
    linkage = Linkage({f"S{k}": place for k, place in enumerate(places)}, O=(0, 0))
    linkage.link("rotor", "O", *(f"S{k}" for k in range(count)))
    linkage.revolute("O", "ground", "rotor", drive=True)
    pressure = -500.0 * (1.0 + 0.3 * np.sin(np.arange(count)))
    for k in range(count):
        linkage.link(f"piston {k}", f"S{k}", mass=mass)
        linkage.link(f"slipper {k}", f"S{k}", mass=slipper, inertia=(1e-6, 1e-6, 1e-6, 0, 0, 0))
        linkage.prismatic(f"S{k}", "rotor", f"piston {k}", axis=(0, 0, 1))
        linkage.spherical(f"S{k}", f"piston {k}", f"slipper {k}")
        linkage.planar(f"S{k}", "ground", f"slipper {k}", axis=(-np.sin(tilt), 0, np.cos(tilt)))
        linkage.load(f"S{k}", link=f"piston {k}", fz=pressure[k])
    found = linkage.mobility()
    assert (found.actual, found.kutzbach, len(found.idle)) == (6, 6, count)
    motion = linkage.move(O=TURN, rates={"O": speed})
    angle = phase + TURN[:, None]
    lift = stroke * np.cos(angle)
    slides = np.stack([motion.coordinate(f"S{k}")[:, 0] for k in range(count)], axis=-1)
    assert_allclose(slides, lift - stroke * np.cos(phase), atol=1e-15)
    needed = -(mass + slipper) * speed**2 * lift - pressure
    torque = np.sum(needed * -stroke * np.sin(angle), axis=-1)
    assert_allclose(motion.reactions().drive("O")[:, 0], torque, atol=1e-10)


def test_wobble_plate_on_its_cross() -> None:
    """A plate on an inclined journal, kept from turning by a cross: its normal goes round a cone, it does not."""
    tilt = np.radians(20.0)
    normal, arm = np.array([np.sin(tilt), 0.0, np.cos(tilt)]), np.array([np.cos(tilt), 0.0, -np.sin(tilt)])
    linkage = Linkage(O=(0, 0), P=0.1 * arm, T=(0.1 * np.cos(tilt), 0, 0.4))
    linkage.link("shaft", "O")
    linkage.link("plate", "O", "P", mass=1.0, inertia=(0.01, 0.01, 0.02, 0, 0, 0))
    linkage.link("rod", "P", "T", mass=0.2, inertia=INERTIA)
    linkage.link("piston", "T", mass=0.3, inertia=INERTIA)
    linkage.revolute("O", "ground", "shaft", drive=True)
    linkage.revolute("O", "shaft", "plate", axis=normal, name="journal")
    linkage.universal("O", "ground", "plate", axis=(0, 1, 0), second=arm, name="hold")
    linkage.spherical("P", "plate", "rod")
    linkage.universal("T", "rod", "piston", axis=(0, 1, 0), second=(1, 0, 0))
    linkage.prismatic("T", "ground", "piston", axis=(0, 0, 1), name="bore")
    found = linkage.mobility()
    assert (found.actual, found.kutzbach, len(found.redundant)) == (1, -2, 3)
    motion = linkage.move(O=TURN)
    cone = np.stack([np.sin(tilt) * np.cos(TURN), np.sin(tilt) * np.sin(TURN), np.cos(tilt) + 0 * TURN], axis=-1)
    assert_allclose(motion.axes("plate") @ normal, cone, atol=1e-14)
    across = np.cross((0.0, 1.0, 0.0), cone)
    across /= np.linalg.norm(across, axis=1)[:, None]
    assert_allclose(motion.position("P"), 0.1 * across, atol=1e-15)
    rise = 0.1 * across[:, 2] + np.sqrt(
        np.sum((linkage.points["T"] - 0.1 * arm) ** 2)
        - np.sum((linkage.points["T"][:2] - 0.1 * across[:, :2]) ** 2, axis=1)
    )
    assert_allclose(motion.position("T")[:, 2], rise, atol=1e-14)
    audit(linkage, lambda t: {"O": 2.0 * t})


def test_mcpherson_strut() -> None:
    """Arm, telescopic strut, steering rod: the upright's six coordinates by its five conditions and the arm's angle.

    The torque that holds the arm is the slope of the potential energy.
    """
    a, ball, top, wheel, steer, rack = (
        np.array(p)
        for p in ((0, 0.4, 0), (0, 0.75, -0.05), (0, 0.6, 0.6), (0, 0.8, 0.05), (0.12, 0.7, 0), (0.14, 0.35, 0.03))
    )
    half = 0.5 * (ball + top)
    along = (top - ball) / np.linalg.norm(top - ball)
    stiffness, free = 25e3, 0.42
    linkage = Linkage(A=a, B=ball, T=top, W=wheel, S=steer, R=rack, Q=half)
    linkage.link("arm", "A", "B", mass=3.0, inertia=INERTIA)
    linkage.link("upright", "B", "W", "S", "Q", mass=20.0, centre=wheel, inertia=(0.5, 0.6, 0.5, 0.01, 0, 0))
    linkage.link("strut", "T", "Q", mass=2.0)
    linkage.link("tie", "S", "R")
    linkage.link("rack", "R", mass=1.0)
    linkage.revolute("A", "ground", "arm", axis=(1, 0, 0), drive=True)
    linkage.spherical("B", "arm", "upright")
    linkage.cylindrical("Q", "strut", "upright", axis=along)
    linkage.universal("T", "ground", "strut", axis=(1, 0, 0), second=np.cross(along, (1, 0, 0)))
    linkage.spherical("S", "upright", "tie")
    linkage.spherical("R", "tie", "rack")
    linkage.prismatic("R", "ground", "rack", axis=(0, 1, 0), drive=True, name="steering")
    linkage.spring("T", ("upright", "Q"), stiffness=stiffness, length=free)
    linkage.gravity((0, 0, -G))
    assert linkage.mobility().idle == ("tie",)
    lift, push = np.linspace(-0.15, 0.15, 7), 0.01 * np.sin(np.arange(7.0))
    motion = linkage.move(A=lift, steering=push)
    assert_array_equal(motion.status, "regular")
    across = np.array([(1.0, 0.0, 0.0), np.cross(along, (1.0, 0.0, 0.0))])
    for k in range(7):
        hub = a + Rotation.from_rotvec((lift[k], 0, 0)).apply(ball - a)
        end = np.add(rack, (0.0, push[k], 0.0))

        def open_by(u, hub=hub, end=end):
            turn = Rotation.from_rotvec(u)
            aside = across @ np.cross(turn.apply(along), top - hub)
            tie = np.linalg.norm(hub + turn.apply(steer - ball) - end) - np.linalg.norm(steer - rack)
            return [*aside, tie]

        turn = Rotation.from_rotvec(fsolve(open_by, np.zeros(3), xtol=1e-13))
        assert_allclose(motion.axes("upright")[k], turn.as_matrix(), atol=1e-11)
        assert_allclose(motion.position("W")[k], hub + turn.apply(wheel - ball), atol=1e-11)

    h = 1e-3 * np.arange(-2, 3)
    near = linkage.move(A=0.05 + h)
    stretch = np.linalg.norm(near.position("Q", "upright") - top, axis=-1) - free
    heights = 3.0 * near.position_on("arm", 0.5 * (a + ball)) + 20.0 * near.position("W")
    heights = heights + 2.0 * near.position_on("strut", 0.5 * (top + half))
    energy = 0.5 * stiffness * stretch**2 + G * heights[:, 2]
    slope = (energy[0] - 8.0 * energy[1] + 8.0 * energy[3] - energy[4]) / 12e-3
    assert_allclose(near.reactions().drive("A")[2, 0], slope, rtol=1e-8)


def test_boom_on_its_cylinder() -> None:
    """A drive that slides between two moving links: the boom's angle by the law of cosines, its force by the lever."""
    foot, eye = np.array([0.5, -0.2]), np.array([1.2, 0.9])
    linkage = Linkage(O=(0, 0), E=(2, 1), H=foot, K=eye)
    linkage.link("boom", "O", "E", "K")
    linkage.link("barrel", "H", mass=30.0, inertia=1.0)
    linkage.link("rod", "K", "H", mass=20.0, inertia=0.5)
    linkage.revolute("O", "ground", "boom")
    linkage.revolute("H", "ground", "barrel")
    drawn = np.linalg.norm(eye - foot)
    linkage.prismatic("H", "barrel", "rod", axis=eye - foot, reference=drawn, drive=True, name="cylinder")
    linkage.revolute("K", "rod", "boom")
    linkage.load("E", fy=-500.0)
    a, b = np.linalg.norm(foot), np.linalg.norm(eye)
    length = np.linspace(1.1, 1.45, 8)
    turn = np.arccos((a * a + b * b - length**2) / (2 * a * b)) - np.arccos((a * a + b * b - drawn**2) / (2 * a * b))
    motion = linkage.move(cylinder=length)
    tip = (2 + 1j) * np.exp(1j * turn)
    assert_allclose(motion.position("E")[:, :2], np.stack([tip.real, tip.imag], axis=-1), atol=1e-14)
    pin = complex(*eye) * np.exp(1j * turn)
    reach = pin - complex(*foot)
    lever = np.abs((np.conj(pin) * reach).imag) / length
    assert_allclose(motion.reactions().drive("cylinder")[:, 0], 500.0 * tip.real / lever, rtol=1e-12)
    assert_array_equal(motion.status, "regular")
    linkage.gravity((0, -G))
    audit(linkage, lambda t: {"cylinder": 1.2 + 0.1 * t})


def test_differential_screw() -> None:
    """Threads of 10 and 8 mm: 2 mm a turn, and a torque of m g times that over a turn."""
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 0.3))
    linkage.link("screw", "A", "B")
    linkage.link("table", "B", mass=10.0)
    linkage.screw("A", "ground", "screw", axis=(0, 0, 1), pitch=0.010, drive=True)
    linkage.screw("B", "screw", "table", axis=(0, 0, 1), pitch=0.008)
    linkage.prismatic("B", "ground", "table", axis=(0, 0, 1), name="guide")
    linkage.gravity((0, 0, -G))
    turns = np.array([0.0, 0.5, 3.0])
    motion = linkage.move(A=2.0 * np.pi * turns)
    assert_allclose(motion.position("B", "table")[:, 2], 0.3 + 0.002 * turns, atol=1e-15)
    assert_allclose(motion.reactions().drive("A")[:, 0], 10.0 * G * 0.002 / (2.0 * np.pi), rtol=1e-10)
