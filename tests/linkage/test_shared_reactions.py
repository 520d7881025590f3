"""Reactions that links and joints share by their stiffness: rods between two balls, and springs beside links."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.models import Linkage
from numpy.testing import assert_allclose

from ..reference.audit import in_equilibrium

RODS = range(7)
ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
LOAD = {"fx": 10.0, "fy": -3.0, "fz": 5.0, "mx": 1.0}


def platform(springs: tuple[float, ...] | None) -> Linkage:
    """On one rod more than hold it, their lower balls on springs along axes of their own."""
    rng = np.random.default_rng(1)
    linkage = Linkage(O=(0, 0, 1))
    for k in RODS:
        linkage.point(f"A{k}", rng.uniform(-1.0, 1.0, 3) * (1.0, 1.0, 0.1))
        linkage.point(f"B{k}", rng.uniform(-0.5, 0.5, 3) * (1.0, 1.0, 0.2) + (0.0, 0.0, 1.0))
    linkage.link("platform", "O", *(f"B{k}" for k in RODS), beam={("O", f"B{k}"): ROD for k in RODS})
    for k in RODS:
        linkage.link(f"rod {k}", f"A{k}", f"B{k}", beam=ROD)
        linkage.spherical(f"A{k}", "ground", f"rod {k}", axis=rng.normal(size=3), stiffness=springs)
        linkage.spherical(f"B{k}", f"rod {k}", "platform", axis=rng.normal(size=3))
    linkage.load("O", **LOAD)
    return linkage


def as_springs(linkage: Linkage, springs: tuple[float, ...] | None) -> Frame:
    """Each rod with its ball as one spring along its line."""
    frame = Frame()
    frame.node("O", linkage.points["O"])
    for k in RODS:
        low, high = linkage.points[f"A{k}"], linkage.points[f"B{k}"]
        length = float(np.linalg.norm(high - low))
        along = (high - low) / length
        soft = length / (200e9 * np.pi * 0.01**2)
        if springs is not None:
            soft += float(np.sum((along @ linkage.joint(f"A{k}").axes) ** 2 / springs[:3]))
        across = np.cross(along, (1.0, 0.0, 0.0)) / np.linalg.norm(np.cross(along, (1.0, 0.0, 0.0)))
        axes = np.column_stack([along, across, np.cross(along, across)])
        frame.node(f"B{k}", high)
        frame.node(f"G{k}", high)
        frame.fix(f"G{k}")
        frame.add(f"arm {k}", ROD, "O", f"B{k}")
        frame.add(f"rod {k}", Joint((1.0 / soft, 0, 0, 0, 0, 0), axes), f"G{k}", f"B{k}")
    frame.load("O", **LOAD)
    return frame


@pytest.mark.parametrize("springs", [None, (1e6,) * 3 + (0.0,) * 3, (1e5, 2e6, 3e7, 0.0, 0.0, 0.0)])
def test_a_platform_on_seven_rods(springs: tuple[float, ...] | None) -> None:
    linkage = platform(springs)
    motion, alone = linkage.move(), as_springs(linkage, springs).solve()
    assert_allclose(motion.accuracy("O").compliance, alone.displacement("O"), rtol=1e-9)
    found = motion.reactions()
    assert found.method == "compliance"
    for k in RODS:
        along = linkage.points[f"B{k}"] - linkage.points[f"A{k}"]
        pushed = -alone.joint_force(f"rod {k}")[0] * along / np.linalg.norm(along)
        for ball in "AB":
            assert_allclose(found.force(f"{ball}{k}")[:3], pushed, atol=1e-8)


def test_a_spring_pulls_as_in_the_rigid_motion() -> None:
    """Across its plane a four-bar shares loads by stiffness; every link is in equilibrium, whatever deflects."""
    linkage = Linkage(A=(0, 0), B=(0.1, 0.3), C=(0.6, 0.5), D=(0.7, 0), Q=(0.4, 0.8, 0.1), F=(1.3, 0.1))
    for name, points in {"crank": "AB", "coupler": "BCQ", "rocker": "CD"}.items():
        inertia = (0.2, 0.3, 0.25, 0.01, 0.02, -0.01)
        linkage.link(name, *points, beam=ROD, mass=1.5, centre=(0.2, 0.1, 0.1), inertia=inertia)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=(1e7, 1e7, 1e6, 1e4, 1e4, 0.0))
    linkage.revolute("C", "coupler", "rocker")
    linkage.revolute("D", "rocker", "ground")
    linkage.spring(("coupler", "Q"), ("ground", "F"), stiffness=500.0, length=0.3, damping=1.0)
    linkage.load("Q", **LOAD)
    linkage.gravity((1.0, -9.81, 2.0))
    motion = linkage.move(A=[0.0, 0.2], rates={"A": 2.0}, accelerations={"A": 3.0})
    assert (motion.reactions().method == "compliance").all()
    in_equilibrium(linkage, motion)


def on_three_cranks(springs: tuple[float, ...], at: float, load: float, twin: bool = False) -> Linkage:
    """A rigid bar, its pins springs, on upright cranks that turn on ideal pins, or are perhaps clamped beside them."""
    linkage = Linkage({f"A{k}": (k, 0) for k in range(3)}, P=(at, 1))
    for k in range(3):
        linkage.point(f"B{k}", (k, 1))
        linkage.link(f"crank {k}", f"A{k}", f"B{k}")
        linkage.revolute(f"A{k}", "ground", f"crank {k}", drive=k == 0)
    linkage.link("bar", "B0", "B1", "B2", "P")
    for k, spring in enumerate(springs):
        linkage.revolute(f"B{k}", f"crank {k}", "bar", stiffness=(spring,) * 5 + (0.0,))
    if twin:
        linkage.fixed("A1", "ground", "crank 1")
        linkage.fixed("A2", "ground", "crank 2")
    linkage.load("P", link="bar", fy=load)
    return linkage


def test_ideal_pins_beside_springs_leave_the_sharing_to_these() -> None:
    """A rigid bar on three springs: ``f = k (v + x a)`` with the load and its moment about the first."""
    springs, place, at, load = np.array([1e6, 3e6, 5e5]), np.arange(3.0), 0.4, 700.0
    matrix = np.array([[springs.sum(), springs @ place], [springs @ place, springs @ place**2]])
    sunk, turned = np.linalg.solve(matrix, [load, at * load])
    found = on_three_cranks(tuple(springs), at, load).move(A0=[0.0, 0.0]).reactions()
    assert found.method.tolist() == ["compliance"] * 2
    for k in range(3):
        wanted = -springs[k] * (sunk + place[k] * turned)
        for pin in (f"A{k}", f"B{k}"):
            assert_allclose(found.force(pin)[:, :2], [[0.0, wanted]] * 2, rtol=1e-9, atol=1e-9 * load)


def test_two_ideal_joints_that_hold_the_same_share_by_no_compliance() -> None:
    """Pins and clamps side by side on the ground hold the same components twice."""
    found = on_three_cranks((1e6, 3e6, 5e5), 0.4, 700.0, twin=True).move().reactions()
    assert found.method == "minimum norm"
    total = sum(found.force(joint)[1] for joint in (*(f"A{k}" for k in range(3)), "A1.fixed", "A2.fixed"))
    assert_allclose(total, -700.0, rtol=1e-9)


def test_how_a_pose_is_shared_does_not_depend_on_others_of_its_batch() -> None:
    """Held twice across its plane, where nothing loads it: a crank that leaves the plane at another entry is no matter.

    There one crank is askew, so that what is held twice is coupled with what is loaded.
    """

    def on_cranks(aside: float | list[float]) -> Linkage:
        linkage = Linkage({f"A{k}": (k, 0) for k in range(3)}, P=(0.4, 1))
        for k, out in enumerate([0.0, aside, 0.0]):
            linkage.point(f"B{k}", np.stack(np.broadcast_arrays(float(k), 1.0, out), axis=-1))
            linkage.link(f"crank {k}", f"A{k}", f"B{k}")
            linkage.revolute(f"A{k}", "ground", f"crank {k}", drive=k == 0)
        linkage.link("bar", "B0", "B1", "B2", "P")
        for k, spring in enumerate((1e6, 3e6, 5e5)):
            linkage.revolute(f"B{k}", f"crank {k}", "bar", stiffness=(spring,) * 5 + (0.0,))
        linkage.planar("A1", "ground", "crank 1")
        linkage.load("P", link="bar", fy=700.0)
        return linkage

    both = on_cranks([0.0, 0.1]).move(A0=0.0).reactions()
    assert both.method.tolist() == ["compliance", "minimum norm"]
    for entry, aside in enumerate((0.0, 0.1)):
        alone = on_cranks(aside).move(A0=0.0).reactions()
        assert alone.method == both.method[entry]
        for k in range(3):
            assert_allclose(both.force(f"A{k}")[entry], alone.force(f"A{k}"), rtol=1e-9, atol=1e-9)


def test_two_drives_for_one_freedom_share_by_no_stiffness_of_theirs() -> None:
    """Reactions are those with locked drives: a moment of 10 N m, which their stiffness does not divide."""
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(1, 1), D=(1, 0))
    for link in ("AB", "BC", "CD"):
        linkage.link(link, *link)
    linkage.revolute("A", "ground", "AB", drive=True, stiffness=(np.inf,) * 5 + (1e4,))
    linkage.revolute("B", "AB", "BC")
    linkage.revolute("C", "BC", "CD")
    linkage.revolute("D", "CD", "ground", drive=True, stiffness=(np.inf,) * 5 + (3e4,))
    linkage.load("B", link="AB", fx=10.0)
    found = linkage.move(A=0.0, D=0.0).reactions()
    assert found.method == "minimum norm"
    assert_allclose(found.drive("A") - found.drive("D"), 10.0, rtol=1e-12)  # D counts the other way round
