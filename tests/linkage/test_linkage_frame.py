"""The frame of a linkage: equal to the four-bar's own, right about sliders, screws, springs and masses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.models import FourBar, Linkage
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.linkages import four_bar, loop
from reference.spatial import stewart

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), STEEL)
ROD = Beam(Circle(diameter=0.02), STEEL)
PIN = (2e11,) * 5 + (0.0,)
THETA = np.radians(np.arange(7.0, 360.0, 15.0))


def drawn(special: FourBar, **pin: object) -> Linkage:
    motion = special.move(1.0)
    linkage = Linkage({point: motion.position(point) for point in "ABPDE"})
    linkage.link("crank", "A", "B", beam=special.link_beam("crank"))
    linkage.link("coupler", "B", "P", "D", beam=special.link_beam("coupler"))
    linkage.link("rocker", "D", "E", beam=special.link_beam("rocker"))
    linkage.revolute("A", "ground", "crank", drive=True, reference=1.0)
    linkage.revolute("B", "crank", "coupler", stiffness=PIN, **pin)  # type: ignore[arg-type]
    linkage.revolute("D", "coupler", "rocker", stiffness=PIN, **pin)  # type: ignore[arg-type]
    linkage.revolute("E", "rocker", "ground", stiffness=PIN, **pin)  # type: ignore[arg-type]
    return linkage


def test_the_four_bar() -> None:
    """Built from its closed form in `models/four_bar/frame.py`, checked there against fifty digits."""
    special = FourBar(crank=0.1, coupler=0.25, rocker=0.2, ground=0.22, point=(0.12, 0.05), beam=BAR)
    theirs, ours = special.move(THETA).frame(), drawn(special).move(A=THETA).frame()
    for frame in (theirs, ours):
        frame.load("P", fx=30.0, fy=100.0, fz=5.0, mz=2.0)
    one, other = theirs.solve(), ours.solve()
    for point in "P":
        size = np.abs(one.displacement(point)).max()
        assert_allclose(other.displacement(point), one.displacement(point), rtol=0.0, atol=1e-13 * size)
    for joint in "BDE":
        # The axes differ: here they turn with the first link.
        for part in (slice(0, 2), slice(2, 3), slice(3, 5)):
            both = (np.linalg.norm(s.joint_force(joint)[..., part], axis=-1) for s in (one, other))
            assert_allclose(*both, rtol=1e-9)
    assert_allclose(ours.modes(3).frequencies, theirs.modes(3).frequencies, rtol=1e-9)


def test_names() -> None:
    frame = drawn(FourBar(point=(0.1, 0.02))).move(A=1.0).frame()
    assert sorted(frame.nodes) == sorted(
        ["A.ground", "A.crank", "B.crank", "B.coupler", "P", "D.coupler", "D.rocker", "E.rocker", "E.ground"]
    )
    assert frame.aliases == {"A": "A.crank", "B": "B.crank", "D": "D.coupler", "E": "E.rocker"}
    assert list(frame.members) == ["crank", "coupler.1", "coupler.2", "rocker"]
    assert list(frame.joints) == ["A", "B", "D", "E"]
    assert list(frame.supports) == ["A.ground", "E.ground"]


def test_several_links_on_one_pin() -> None:
    """Three bars from the ground to one pin: a truss, whose bars share the load as their stiffnesses along it."""
    places = {"A": (-0.6, 0), "B": (0.0, 0), "C": (0.6, 0), "P": (0, -0.8), "X": (2, 0)}
    linkage = Linkage(places)
    for name, foot in (("left", "A"), ("middle", "B"), ("right", "C")):
        linkage.link(name, foot, "P", beam=ROD)
        linkage.revolute(foot, "ground", name)
    linkage.revolute("P", "left", "middle", "right")
    linkage.link("hand", "X")
    linkage.revolute("X", "ground", "hand", drive=True)
    linkage.load("P", fy=-1e4)
    motion = linkage.move(X=0.0)
    solution = motion.frame().solve()
    area = np.pi * 0.01**2
    # The middle bar, 0.8 long, and two of length 1 that lean by cos = 0.8; a slender bar's bending counts for nothing.
    stiffness = 200e9 * area * (1 / 0.8 + 2 * 0.8**2)
    assert_allclose(solution.displacement("P")[1], -1e4 / stiffness, rtol=1e-3)
    assert sorted(solution.frame.joints) == ["A", "B", "C", "P", "P.right", "X"]
    assert motion.reactions().method == "compliance"


def whitworth(beam: Beam) -> Linkage:
    """An inverted slider-crank: a block on the crank slides along a swinging arm."""
    linkage = Linkage(O=(0, 0), A=(0.1, 0), S=(0, -0.3), T=(0.25, 0.45))
    along = np.array([0.1, 0.3, 0.0])
    linkage.link("crank", "O", "A")
    linkage.link("block", "A")
    linkage.link("arm", "S", "T", "A", beam={("S", "T"): beam})
    linkage.revolute("O", "ground", "crank", drive=True)
    linkage.revolute("A", "crank", "block")
    linkage.prismatic("A", "arm", "block", axis=along, name="slide")
    linkage.revolute("S", "ground", "arm")
    return linkage


@pytest.mark.parametrize("release", [(), ("start rz",)], ids=["plain", "hinged where it is pinned"])
def test_a_slider_stands_on_the_beam_that_carries_it(release: tuple[str, ...]) -> None:
    """The arm is a beam on two supports, S and the block, that overhangs: deflection of its tip by the textbook.

    A load F across at the end of an overhang c beyond a span a: F c^2 (a + c) / 3EI.
    """
    linkage = whitworth(replace(ROD, release=release))
    motion = linkage.move(O=np.linspace(0.0, 6.0, 9))
    frame = motion.frame()
    assert list(frame.members) == ["arm.1", "arm.2"]
    arm = motion.position("T") - motion.position("S")
    length = np.linalg.norm(arm, axis=-1)
    u = arm / length[:, None]
    across = np.stack([-u[:, 1], u[:, 0], 0 * length], axis=-1)
    force = 50.0
    frame.load("T", fx=force * across[:, 0], fy=force * across[:, 1])
    moved = np.sum(frame.solve().displacement("T")[:, :3] * across, axis=-1)
    a = np.linalg.norm(motion.position("A", "block") - motion.position("S"), axis=-1)
    assert np.ptp(a) > 0.15
    c, EI = length - a, 200e9 * np.pi * 0.02**4 / 64
    assert_allclose(moved, force * c**2 * (a + c) / (3 * EI), rtol=1e-9)


def test_a_slider_off_every_beam_stands_on_a_rigid_arm() -> None:
    linkage = Linkage(A=(0, 0), B=(0.5, 0), S=(0.5, 0.1))
    linkage.link("post", "A", "B", "S", beam={("A", "B"): ROD})
    linkage.link("tool", "S")
    linkage.revolute("A", "ground", "post", drive=True)
    linkage.prismatic("S", "post", "tool", axis=(0, 1, 0), drive=True)
    reach = np.array([0.0, 0.2])
    frame = linkage.move(A=0.0, S=reach).frame()
    frame.load("S.tool", fx=10.0)
    # Tension, and the moment of the arm 0.1 + reach at the end of the cantilever, whose end turns by M L / EI.
    arm, EA, EI = 0.1 + reach, 200e9 * np.pi * 1e-4, 200e9 * np.pi * 0.02**4 / 64
    moved = frame.solve().displacement("S.tool")[:, 0]
    assert_allclose(moved, 10.0 * 0.5 / EA + 10.0 * arm**2 * 0.5 / EI, rtol=1e-10)


def test_a_screw_in_a_linkage() -> None:
    """A rod turned by a spring about its screw: the axial force comes back as torque."""
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 0.4))
    linkage.link("rod", "A", "B", beam=ROD)
    stiffness = (np.inf,) * 5 + (30.0,)
    linkage.screw("A", "ground", "rod", axis=(0, 0, 1), pitch=0.05, stiffness=stiffness)
    linkage.drive("A")
    frame = linkage.move(A=np.array([0.0, 2.0])).frame()
    frame.load("B", fz=100.0)
    lead = 0.05 / (2 * np.pi)
    solution = frame.solve()
    # A drive that has a stiffness of its own is not clamped.
    assert_allclose(solution.joint_displacement("A")[:, 5], 100.0 * lead / 30.0, rtol=1e-12)
    stretch = 100.0 * 0.4 / (200e9 * np.pi * 1e-4)
    assert_allclose(solution.displacement("B")[:, 2], 100.0 * lead**2 / 30.0 + stretch, rtol=1e-12)


def test_a_loaded_jack_turns_its_spindle_back() -> None:
    """A loop through a thread: the nut sinks by what shortens the spindle, and by the turns of spindle and drive.

    Both go as far as the nut stands along the spindle; the torque is F p / 2 π, right-handed or left-handed.
    """
    pitch, force, drive, thread = np.array([0.01, -0.01, 0.03]), 1000.0, 40.0, 1e9
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 0.5))
    linkage.link("spindle", "A", "B", beam=ROD)
    linkage.link("nut", "B")
    linkage.revolute("A", "ground", "spindle", axis=(0, 0, 1), drive=True, stiffness=(np.inf,) * 5 + (drive,))
    linkage.screw("B", "spindle", "nut", axis=(0, 0, 1), pitch=pitch, stiffness=(thread,) * 5 + (0.0,))
    linkage.prismatic("B", "ground", "nut", axis=(0, 0, 1), name="slide")
    turn = 6.0 * np.pi * np.array([[0.0], [1.0]])
    motion = linkage.move(A=turn * np.sign(pitch))
    frame = motion.frame()
    frame.load("B.nut", fz=-force)
    length, lead, area = motion.position("B", "nut")[..., 2], pitch / (2.0 * np.pi), np.pi * 0.02**2 / 4.0
    assert_allclose(length, 0.5 - np.abs(lead) * turn, rtol=1e-12)
    torsion = 200e9 / 2.6 * np.pi * 0.02**4 / 32.0
    sinking = force * (length / (200e9 * area) + 1.0 / thread + lead**2 * (1.0 / drive + length / torsion))
    solution = frame.solve()
    assert_allclose(-solution.displacement("B.nut")[..., 2], sinking, rtol=1e-9)
    assert_allclose(np.abs(solution.joint_force("A")[..., 5]), np.broadcast_to(force * np.abs(lead), (2, 3)), rtol=1e-9)
    assert (solution.error_bound("B.nut")[..., 2] < 1e-9 * sinking).all()
    small = 1e-3
    frame.set_load("B.nut", fz=-small * force)
    assert_allclose(-frame.solve(large=True).displacement("B.nut")[..., 2], small * sinking, rtol=1e-6)


def test_springs_pull_with_their_force_and_resist_with_their_stiffness() -> None:
    """A stiff arm held up by a spring: static force at the pose, and stiffness k against further displacement."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 2))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", stiffness=(np.inf,) * 5 + (50.0,), drive=True)
    linkage.spring("B", "C", stiffness=300.0, length=1.9)
    motion = linkage.move(A=0.0)
    solution = motion.frame().solve()
    pull, turn = 300.0 * 0.1, 50.0 + 300.0 * 1.0**2
    assert_allclose(solution.displacement("B")[1], pull / turn, rtol=1e-9)
    assert_allclose(motion.reactions().drive("A")[0], -pull, rtol=1e-12)
    assert motion.frame(loads=False).solve().displacement("B")[1] == 0.0


def test_platform_on_legs() -> None:
    """A rigid platform on six elastic legs: stiffness by Gosselin's ``J^T k J`` of the legs' stiffness along them."""
    linkage, base, top = stewart()
    for name, link in list(linkage.links.items()):
        if name != "platform":
            del linkage.links[name]
            linkage.link(name, *link.points, beam=ROD)
    motion = linkage.move({f"M{k}": np.array([0.0, 0.02]) for k in range(6)})
    stiffness = motion.stiffness("O")[0]
    legs = top - base
    length = np.linalg.norm(legs, axis=-1)
    u = legs / length[:, None]
    # Each leg is two rods in line, joined by the driven slider's rigid arm.
    k = 200e9 * np.pi * 1e-4 / length
    jacobian = np.concatenate([u, np.cross(top - np.array([0, 0, 1.1]), u)], axis=-1)
    wanted = jacobian.T @ (k[:, None] * jacobian)
    assert_allclose(stiffness, wanted, rtol=0.0, atol=1e-6 * np.abs(wanted).max())


def test_given_masses_sit_where_they_were_put() -> None:
    """Weight of beams and of given masses, offset from their points, against the reactions of the rigid linkage."""
    linkage = four_bar(0.3, 0.9, 0.8, 0.7, 1.0)
    for name, link in list(linkage.links.items()):
        del linkage.links[name]
        given = {"mass": 5.0, "centre": (0.5, 0.8), "inertia": 0.2} if name == "coupler" else {}
        linkage.link(name, *link.points, beam=ROD, **given)  # type: ignore[arg-type]
    linkage.gravity((0.0, -9.81))
    motion = linkage.move(A=THETA, rates={"A": 5.0}, accelerations={"A": 3.0})
    found = motion.reactions()
    solution = motion.frame(inertia=True).solve()
    for joint in "ABDE":
        size = np.abs(found.force(joint)).max()
        assert_allclose(solution.joint_force(joint)[..., 5], found.in_joint(joint)[..., 5], rtol=0.0, atol=1e-10 * size)
        assert_allclose(
            solution.joint_force(joint)[..., :2], found.in_joint(joint)[..., :2], rtol=0.0, atol=1e-10 * size
        )


def test_taper_and_inertia() -> None:
    """A tapered arm that turns: what its inertia needs at the pin is that of the rigid body, exactly."""
    thin = Rectangle(y=0.01, z=0.01)
    linkage = Linkage(A=(0, 0), B=(0.8, 0.3))
    linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.03, z=0.02), STEEL, end=thin))
    linkage.revolute("A", "ground", "arm", drive=True)
    motion = linkage.move(A=0.4, rates={"A": 8.0}, accelerations={"A": -5.0})
    solution, found = motion.frame(inertia=True).solve(), motion.reactions()
    assert_allclose(
        -solution.joint_force("A"), np.concatenate([*_local(motion, found.force("A"))]), rtol=1e-10, atol=1e-10
    )


def _local(motion: object, wrench: Array) -> tuple[Array, Array]:
    axes = motion.joint_axes("A")  # type: ignore[attr-defined]
    return axes.T @ wrench[:3], axes.T @ wrench[3:]


def test_poses_that_are_not_assembled_are_absent() -> None:
    linkage = four_bar(0.4, 0.5, 0.45, 0.7, 1.0)
    for name, link in list(linkage.links.items()):
        del linkage.links[name]
        linkage.link(name, *link.points, beam=ROD)
    linkage.gravity((0.0, -9.81))
    motion = linkage.move(A=np.radians([30.0, 180.0, 40.0]), rates={"A": 1.0})
    frame = motion.frame(inertia=True)
    frame.load("D", fy=10.0)
    solution = frame.solve()
    assert solution.status.tolist() == ["regular", "absent", "regular"]
    assert np.isnan(solution.displacement("D")[1]).all()
    assert np.isfinite(solution.displacement("D")[[0, 2]]).all()


@pytest.mark.parametrize("beam", [None, ROD], ids=["rigid", "beams"])
def test_overconstrained_loops_with_ideal_joints(beam: Beam | None) -> None:
    """Rigid links and ideal joints leave nothing to move: redundant constraints are found, not fought."""
    linkage = four_bar(0.3, 0.9, 0.8, 0.7, 1.0)
    for name, link in list(linkage.links.items()):
        del linkage.links[name]
        linkage.link(name, *link.points, beam=beam)
    linkage.load("D", fx=10.0, fz=10.0)
    solution = linkage.move(A=THETA).frame().solve()
    assert set(solution.status) == {"regular"}
    moved = solution.displacement("D")
    assert np.isfinite(moved).all()
    assert (beam is None) == (np.abs(moved).max() == 0.0)


def test_bennett_s_loop_with_rigid_links_and_ideal_hinges() -> None:
    """Four hinges in space, three constraints too many at every pose: nothing gives, each link is in equilibrium."""
    alpha, beta, start = np.radians([30.0, 60.0, 70.0])
    ratio = np.sin((beta + alpha) / 2) / np.sin((beta - alpha) / 2)
    other = 2.0 * np.arctan(ratio / np.tan(start / 2.0))
    long = 0.2 * np.sin(beta) / np.sin(alpha)
    linkage = loop((0.2, long) * 2, (alpha, beta) * 2, (start, other, -start, -other))
    linkage.load("H2", link="link 1", fx=3.0, fy=-2.0, fz=10.0)
    motion = linkage.move(H0=np.radians(np.linspace(10.0, 350.0, 25)))
    assert motion.is_assembled.all()
    solution = motion.frame().solve()
    assert set(solution.status) == {"regular"}
    assert np.abs(solution.displacement("H2")).max() == 0.0
    axes = {joint: motion.joint_axes(joint) for joint in linkage.joints}
    forces = {joint: (axes[joint] @ solution.joint_force(joint)[:, :3, None])[..., 0] for joint in axes}
    # Joints pull on their first link, and on their second the other way.
    load = np.array([3.0, -2.0, 10.0])
    assert_allclose(forces["H1"] - forces["H0"], np.zeros((25, 3)), atol=1e-9)
    assert_allclose(forces["H2"] - forces["H1"] + load, np.zeros((25, 3)), atol=1e-9)
    assert_allclose(forces["H3"] - forces["H2"], np.zeros((25, 3)), atol=1e-9)


def test_frames_of_many_poses_are_built_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """No step of the way counts poses: as many nodes are placed for a thousand poses as for one."""
    calls = {1: 0, 1000: 0}
    for poses in calls:
        original = Frame._put

        def counted(self: Frame, *args: object, n: int = poses, node: object = original) -> None:
            calls[n] += 1
            node(self, *args)  # type: ignore[operator]

        with monkeypatch.context() as patch:
            patch.setattr(Frame, "_put", lambda self, *a, f=counted, **k: f(self, *a, *k.values()))
            drawn(FourBar()).move(A=np.linspace(0.5, 2.0, poses)).frame()
    assert calls[1] == calls[1000] == 9


@pytest.mark.parametrize(("springs", "told"), [((1e6, 2e6), r"1e\+06, 2e\+06"), ((0.0, 0.0), "0, 0")])
def test_unequal_or_no_springs_cannot_have_a_clearance(springs: tuple[float, float], told: str) -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B", beam=ROD)
    linkage.revolute("A", "ground", "arm", drive=True, stiffness=(*springs, 1e6, 1e6, 1e6, 0.0), clearance=1e-4)
    told = rf"joint 'A' has clearance in ux uy, where its stiffness is {told}: give one stiffness above 0"
    with pytest.raises(FrameError, match=told):
        linkage.move(A=0.0).frame()
    assert linkage.move(A=0.0).frame(clearance=False).shape == ()
