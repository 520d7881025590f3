"""Linkages in MJCF: MuJoCo has them where linkframe has them, with the same masses and forces."""

from __future__ import annotations

import warnings
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkage.rigid_bodies import LINKAGES, Engine, along, example
from linkage.test_random_mechanisms import SEEDS, drive, mechanism
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.models import ConversionWarning, Linkage, Motion, read_linkage, write_linkage
from numpy.testing import assert_allclose

mujoco = pytest.importorskip("mujoco")

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3, density=7850.0))
ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7850.0))


def written(linkage: Linkage, folder: Path) -> Any:
    """The model that MuJoCo makes of a linkage."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConversionWarning)
        write_linkage(linkage, folder / "linkage.xml")
    return mujoco.MjModel.from_xml_path(str(folder / "linkage.xml"))


def size_of(linkage: Linkage) -> float:
    return float(np.linalg.norm(np.ptp(np.array(list(linkage.points.values())), axis=0)))


def check_positions(linkage: Linkage, motion: Motion, folder: Path) -> Engine:
    """Every point of every link at every pose, and the loops closed."""
    engine = Engine(written(linkage, folder), motion)
    size = size_of(linkage)
    places = np.stack([motion.position(point, link) for link, point in engine.sites], axis=1)
    assert motion.is_assembled.mean() > 0.95
    for pose in np.flatnonzero(motion.is_assembled).tolist():
        engine.put(pose)
        assert np.abs(engine.positions - places[pose]).max() < 1e-12 * size
        assert engine.gap < 1e-12 * max(size, 1.0)
    return engine


def check_again(linkage: Linkage, motion: Motion, drives: Any, folder: Path) -> Linkage:
    """What is read again has the same parts, and goes the same way."""
    again = read_linkage(folder / "linkage.xml")
    assert again.drives == linkage.drives
    assert set(again.points) == set(linkage.points)
    assert {name: own.points for name, own in again.links.items()} == {n: k.points for n, k in linkage.links.items()}
    assert {name: pair.kind for name, pair in again.joints.items()} == {n: p.kind for n, p in linkage.joints.items()}
    moved = again.move(drives)
    for link, own in linkage.links.items():
        for point in own.points:
            found, expected = moved.position(point, link), motion.position(point, link)
            assert_allclose(found, expected, rtol=0.0, atol=1e-11 * size_of(linkage))
    return again


@pytest.mark.parametrize("name", LINKAGES)
def test_examples(name: str, tmp_path: Path) -> None:
    """At 100 poses on the way of each example, and read again."""
    linkage, shown = example(name)
    drives = along(linkage, shown)
    motion = linkage.move(drives)
    check_positions(linkage, motion, tmp_path)
    check_again(linkage, motion, drives, tmp_path)


def every_kind(*, backwards: bool) -> Linkage:
    """A chain with a joint of each kind, from either of its links to the other."""
    made = Linkage(A=(0, 0, 0), B=(1, 0, 0.2), C=(2, 0.3, 0), D=(2.5, 1, 0.1), E=(3, 1, 1), F=(3.5, 1, 1), G=(4, 0, 1))
    names = "ABCDEFG"
    for one, other in pairwise(names):
        made.link(one + other, one, other, beam=ROD)

    def ends(k: int) -> tuple[str, str]:
        both = "ground" if k == 0 else names[k - 1] + names[k], names[k] + names[k + 1]
        return (both[1], both[0]) if backwards else both

    made.cylindrical("A", *ends(0), axis=(0, 1, 1), drive=True, reference=(0.1, 0.2))
    made.universal("B", *ends(1), axis=(0, 0, 1), second=(1, 1, 0), drive=True)
    made.planar("C", *ends(2), axis=(1, 1, 1), drive=True, reference=(0.3, 0.0, -0.1))
    made.screw("D", *ends(3), axis=(0, 1, 0), pitch=0.2, drive=True, reference=0.4)
    made.spherical("E", *ends(4), axis=(1, 0, 1), drive=True)
    made.fixed("F", *ends(5))
    made.gravity((0.3, -1.0, -9.0))
    return made


@pytest.mark.parametrize("backwards", [False, True])
def test_every_kind(backwards: bool, tmp_path: Path) -> None:
    """Places, energy, drives' forces and what each joint holds, of a tree with joints of every kind."""
    linkage, t = every_kind(backwards=backwards), np.linspace(0.0, 1.5, 7)[:, None]
    drives = {"A": [0.1, 0.2] + t * [1, 2], "B": t * [1, -1], "C": [0.3, 0, -0.1] + t * [1, 1, 2]}
    drives |= {"D": 0.4 + t[:, 0], "E": t * [1.0, 0.5, -0.7]}
    rates = {"A": np.ones(2), "B": np.ones(2), "C": np.ones(3), "D": 2.0, "E": np.array([0.3, -0.2, 0.5])}
    faster = {"A": np.array([1.0, -2.0]), "C": np.array([0.0, 1.0, 0.5]), "E": np.array([0.1, 0.4, -0.5])}
    motion = linkage.move(drives, rates=rates, accelerations=faster)
    engine = check_positions(linkage, motion, tmp_path)
    found = motion.reactions()
    for pose in range(7):
        engine.put(pose)
        assert_allclose(engine.kinetic_energy, motion.kinetic_energy()[pose], rtol=1e-9)
        forces = engine.solve(pose)
        for joint in "ABCD":
            check_drive(linkage, joint, forces, found.drive(joint)[pose])
        for link, joint in zip(linkage.links, "ABCDEF", strict=True):
            check_wrench(engine.on_body(link), moved(motion, joint, link, found.force(joint, link))[pose])


def check_drive(linkage: Linkage, joint: str, forces: dict[str, float], expected: Any) -> None:
    own = linkage.drives[joint]
    given = [forces[joint] if joint in forces else forces[f"{joint} {coordinate}"] for coordinate in own]
    assert_allclose(given, expected, rtol=0.0, atol=1e-6 * max(map(abs, forces.values())))


def check_wrench(given: Any, expected: Any) -> None:
    assert_allclose(given, expected, rtol=0.0, atol=1e-6 * np.abs(expected).max())


def moved(motion: Motion, joint: str, link: str, wrench: Any) -> Any:
    """Force and moment about the point of a joint on one of its links, from those about that on its second link."""
    pair = motion.linkage.joint(joint)
    arm = motion.position(pair.point, pair.second) - motion.position(pair.point, link)
    return np.concatenate([wrench[:, :3], wrench[:, 3:] + np.cross(arm, wrench[:, :3])], axis=1)


def closed_by_cylinder() -> Linkage:
    """RCCC, Duffy's spatial four-bar: a crank, and three joints that turn and slide."""
    made = Linkage(A=(0, 0, 0), B=(0.3, 0.1, 0.2), C=(0.9, 0.4, 0.6), D=(1.0, -0.3, 0.1))
    made.link("crank", "A", "B", beam=ROD)
    made.link("coupler", "B", "C", beam=ROD)
    made.link("rocker", "C", "D", beam=ROD)
    made.revolute("A", "ground", "crank", axis=(0, 0.2, 1), drive=True)
    made.cylindrical("B", "crank", "coupler", axis=(0.1, 1, 0.4))
    made.cylindrical("C", "coupler", "rocker", axis=(1, 0.2, 0.9))
    made.cylindrical("D", "rocker", "ground", axis=(1, 0.1, -0.3), reference=(0.2, 0.1))
    return made


def closed_by_plane() -> Linkage:
    """An arm whose hand slides on a table, tilted as the axes of the arm are."""
    made = Linkage(A=(0, 0, 0), B=(0.2, 0.1, 0.1), C=(0.5, 0.3, 0.0))
    made.link("arm", "A", "B", beam=ROD)
    made.link("hand", "B", "C", mass=2.0, centre=(0.4, 0.2, 0.1), inertia=(0.1, 0.12, 0.15, 0.01, 0.0, 0.02))
    made.revolute("A", "ground", "arm", axis=(0, 0.3, 1), drive=True)
    made.revolute("B", "arm", "hand", axis=(0, 0.3, 1), drive=True)
    made.planar("C", "hand", "ground", axis=(0, 0.3, 1))
    return made


def closed_by_ball() -> Linkage:
    """A crank, a rod with a cross and a ball, and a slide."""
    made = Linkage(A=(0, 0, 0), B=(0.1, 0.02, 0.0), C=(0.5, 0.1, 0.1))
    made.link("crank", "A", "B", beam=BAR)
    made.link("rod", "B", "C", beam=BAR)
    made.link("piston", "C", mass=0.7)
    made.revolute("A", "ground", "crank", axis=(0, 0.1, 1), drive=True)
    made.universal("B", "crank", "rod", axis=(0, 0.1, 1), second=(1, 0, 0))
    made.spherical("C", "rod", "piston")
    made.prismatic("C", "ground", "piston", axis=(1, 0, 0.1), name="slide")
    made.gravity((1.0, -9.0, 3.0))
    return made


def closed_by_hinges() -> Linkage:
    """The four-bar of the README, with a spring, a damper and loads."""
    made = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    made.link("crank", "A", "B", beam=BAR)
    made.link("coupler", "B", "P", "D", beam=BAR)
    made.link("rocker", "D", "E", beam=BAR)
    made.revolute("A", "ground", "crank", drive=True)
    made.revolute("B", "crank", "coupler")
    made.revolute("D", "coupler", "rocker")
    made.revolute("E", "rocker", "ground")
    made.gravity((0.0, -9.81))
    made.spring("P", ("ground", "E"), stiffness=200.0, length=0.1, damping=3.0)
    made.load("P", fy=10.0)
    made.load("P", fx=-3.0, mz=0.2, follower=True)
    return made


MADE = [closed_by_cylinder, closed_by_plane, closed_by_ball, closed_by_hinges]


@pytest.mark.parametrize("make", MADE)
def test_loops(make: Any, tmp_path: Path) -> None:
    """Loops that joints of several kinds close: places, energy, the torque of the drive, and what is read again."""
    linkage = make()
    drives = dict.fromkeys(linkage.drives, np.linspace(-0.3, 0.5, 9))
    rates, faster = dict.fromkeys(drives, 3.0), dict.fromkeys(drives, 2.0)
    motion = linkage.move(drives, rates=rates, accelerations=faster)
    engine = check_positions(linkage, motion, tmp_path)
    torque = {joint: motion.reactions().drive(joint) for joint in drives}
    for pose in range(9):
        engine.put(pose)
        assert_allclose(engine.kinetic_energy, motion.kinetic_energy()[pose], rtol=1e-9)
        for joint, found in engine.solve(pose).items():
            assert_allclose(found, torque[joint][pose, 0], rtol=0.0, atol=1e-6 * np.abs(torque[joint]).max())
    again = check_again(linkage, motion, drives, tmp_path).move(drives, rates=rates, accelerations=faster)
    assert_allclose(again.kinetic_energy(), motion.kinetic_energy(), rtol=1e-9)
    assert (len(again.linkage.springs), len(again.linkage.loads)) == (len(linkage.springs), len(linkage.loads))
    for joint, expected in torque.items():
        assert_allclose(again.reactions().drive(joint), expected, rtol=0.0, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("seed", SEEDS[1:2])
def test_random_mechanisms(seed: int, tmp_path: Path) -> None:
    """Loops through loops, of joints of all kinds: places, energy, forces of the drives, and what is read again."""
    linkage, free = mechanism(seed)
    assert drive(linkage, free) == 0
    t, drives = np.linspace(0.0, 0.05, 3), {}
    for name, own in linkage.drives.items():
        pair = linkage.joint(name)
        start = pair.reference[[pair.kind.coordinates.index(each) for each in own]]
        drives[name] = start + t[:, None] if len(own) > 1 else start + t
    ones = {name: np.ones(len(own)) if len(own) > 1 else 1.0 for name, own in linkage.drives.items()}
    motion = linkage.move(drives, rates=ones, accelerations=ones)
    engine = check_positions(linkage, motion, tmp_path)
    expected = motion.reactions()
    for pose in range(3):
        engine.put(pose)
        assert_allclose(engine.kinetic_energy, motion.kinetic_energy()[pose], rtol=1e-12)
        forces = engine.solve(pose)
        for name in linkage.drives:
            check_drive(linkage, name, forces, expected.drive(name)[pose])
    check_again(linkage, motion, drives, tmp_path)


def test_reactions_in_space(tmp_path: Path) -> None:
    """What each joint of a determinate closed loop holds, force and moment."""
    linkage = closed_by_ball()
    motion = linkage.move(A=np.linspace(0.0, 6.0, 9), rates={"A": 100.0}, accelerations={"A": 50.0})
    found, engine = motion.reactions(), Engine(written(linkage, tmp_path), motion)
    assert set(found.method.tolist()) == {"determinate"}
    for pose in range(9):
        engine.put(pose)
        engine.solve(pose)
        for link, joint in {"crank": "A", "rod": "B", "piston": "slide"}.items():
            check_wrench(engine.on_body(link), moved(motion, joint, link, found.force(joint, link))[pose])
        check_wrench(-engine.at_closure("C"), found.force("C", "piston")[pose, :3])


def test_reactions_in_the_plane(tmp_path: Path) -> None:
    """Forces in the pins of a four-bar under its weight at 2000 rpm; those across the plane have no meaning in it."""
    linkage = closed_by_hinges()
    linkage.loads.clear()
    linkage.springs.clear()
    motion = linkage.move(A=np.linspace(0.0, 6.0, 9), rates={"A": 2000.0 * np.pi / 30.0})
    found, engine = motion.reactions(), Engine(written(linkage, tmp_path), motion)
    for pose in range(9):
        engine.put(pose)
        assert_allclose(engine.solve(pose)["A"], found.drive("A")[pose, 0], rtol=1e-6)
        for link, joint in {"crank": "A", "coupler": "B", "rocker": "E"}.items():
            check_wrench(engine.on_body(link)[:2], found.force(joint, link)[pose, :2])
        both = engine.at_closure("D").reshape(-1, 3) + engine.at_closure("D axis").reshape(-1, 3)
        check_wrench(both[0, :2], found.force("D", "coupler")[pose, :2])


def test_it_runs(tmp_path: Path) -> None:
    """A second of the four-bar, whose drive is sent on by half a turn: the loop stays closed, the drive arrives."""
    linkage = closed_by_hinges()
    model = written(linkage, tmp_path)
    data = mujoco.MjData(model)
    for k in range(1000):
        data.ctrl[0] = min(np.pi, 4.0 * k * model.opt.timestep)
        mujoco.mj_step(model, data)
        assert np.abs(data.efc_pos[: data.ne]).max() < 1e-3 * size_of(linkage)
    assert np.isfinite(data.qpos).all()
    place = linkage.move(A=data.joint("A").qpos[0]).position("P")
    assert_allclose(data.site("P").xpos, place, rtol=0.0, atol=1e-4 * size_of(linkage))
    assert abs(data.joint("A").qpos[0] - np.pi) < 0.05
