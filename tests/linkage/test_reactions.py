"""Reactions of any linkage: every link in equilibrium, power in balance, closed forms, the limit of stiff frames."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import FourBar, Link, Linkage, Motion
from linkframe.models.linkage.statics import coefficients
from linkframe.models.linkage.statics.coefficients import blocks
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.linkages import four_bar
from reference.spatial import stewart

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), STEEL)


def heavy_four_bar() -> Linkage:
    """A four-bar with everything on it: given masses, loads, a torque, gravity, and a spring with a damper."""
    linkage = Linkage(A=(0, 0), B=(0.1, 0.28), P=(0.5, 0.7), D=(0.9, 0.6), E=(0.7, 0), Q=(0.2, 1.0))
    linkage.link("crank", "A", "B", mass=2.0, centre=(0.03, 0.1), inertia=0.05)
    linkage.link("coupler", "B", "P", "D", mass=5.0, centre=(0.5, 0.4), inertia=0.3)
    linkage.link("rocker", "D", "E", beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    linkage.load("P", fx=3.0, fy=-7.0, mz=0.4)
    linkage.torque("rocker", mz=2.5)
    linkage.gravity((0.3, -9.81))
    linkage.spring("P", "Q", stiffness=200.0, length=0.2, damping=30.0)
    return linkage


def platform() -> Linkage:
    linkage, _, _ = stewart()
    for name, link in list(linkage.links.items()):
        del linkage.links[name]
        linkage.link(name, *link.points, mass=3.0, inertia=(0.1, 0.2, 0.3, 0.01, 0.02, 0.03))
    linkage.gravity((0.5, 0.2, -9.81))
    linkage.load("O", fx=10.0, mx=2.0, my=-1.0)
    return linkage


def vice() -> Linkage:
    """A crank that turns a screw through a cross, a nut that slides along: universal, screw and prismatic joints."""
    bend = np.array([np.cos(0.4), np.sin(0.4), 0.0])
    linkage = Linkage(A=-0.3 * bend, U=(0, 0, 0), S=(0.5, 0, 0), N=(0.5, 0.1, 0))
    linkage.link("shaft", "A", "U", mass=1.0, centre=-0.1 * bend, inertia=(0.02, 0.02, 0.01, 0, 0, 0))
    linkage.link("screw", "U", "S", mass=2.0, inertia=(0.01, 0.03, 0.03, 0, 0, 0))
    linkage.link("nut", "S", "N", mass=4.0, inertia=(0.05, 0.05, 0.05, 0, 0, 0))
    linkage.revolute("A", "ground", "shaft", axis=bend, drive=True)
    linkage.universal("U", "shaft", "screw", axis=(0, 0, 1), second=(0, 1, 0))
    linkage.screw("S", "screw", "nut", axis=(1, 0, 0), pitch=0.05)
    linkage.prismatic("N", "ground", "nut", axis=(1, 0, 0))
    linkage.load("N", fx=-500.0)
    linkage.gravity((0, 0, -9.81))
    return linkage


MOTIONS = {
    "four-bar": lambda: heavy_four_bar().move(A=np.linspace(0.0, 6.0, 25), rates={"A": 4.0}, accelerations={"A": -3.0}),
    "platform": lambda: platform().move(
        {f"M{k}": 0.05 * np.sin(np.linspace(0.0, 3.0, 7) + k) for k in range(6)},
        rates={f"M{k}": 0.3 - 0.1 * k for k in range(6)},
        accelerations={f"M{k}": 1.0 + 0.2 * k for k in range(6)},
    ),
    "vice": lambda: vice().move(A=np.linspace(0.0, 9.0, 19), rates={"A": 7.0}, accelerations={"A": 20.0}),
}


def acting(motion: Motion, link: str) -> list[tuple[Array, Array, Array]]:
    """Place, force and moment of everything but joints on a link, from the description alone."""
    linkage, out = motion.linkage, []
    for load in linkage.loads:
        if load.link == link:
            point = load.point or linkage.links[link].points[0]
            out.append((motion.position(point, link), load.value[..., :3], load.value[..., 3:]))
    for spring in linkage.springs:
        for (own, point), (other, far) in ((spring.first, spring.second), (spring.second, spring.first)):
            if own == link:
                chord = motion.position(far, other) - motion.position(point, own)
                length = np.linalg.norm(chord, axis=-1, keepdims=True)
                speed = motion.velocity(far, other) - motion.velocity(point, own)
                rate = np.sum(speed * chord / length, axis=-1, keepdims=True)
                pull = spring.stiffness * (length - spring.length) + spring.damping * rate
                out.append((motion.position(point, own), pull * chord / length, np.zeros(3)))
    return out


def momentum(motion: Motion, link: str) -> tuple[Array, Array, Array, float]:
    """Centre of mass, rates of momentum and spin about it, mass: of masses as given, and of uniform bars."""
    given = motion.linkage.links[link]
    places = [motion.linkage.points[point] for point in given.points]
    mass, centre, tensor = given.mass, given.centre, given.inertia
    if given.beams:
        (start, end), section = places, BAR.section
        chord = end - start
        length = np.linalg.norm(chord)
        u = chord / length
        mass = np.asarray(7850.0 * section.A * length)
        centre = (start + end) / 2
        y, z = np.cross([0, 0, 1], u), np.array([0.0, 0.0, 1.0])
        i_y, i_z = 7850.0 * length * np.asarray(section.Iy), 7850.0 * length * np.asarray(section.Iz)
        slender = mass * length**2 / 12
        tensor = (i_y + i_z) * np.outer(u, u) + (slender + i_y) * np.outer(y, y) + (slender + i_z) * np.outer(z, z)
    if centre is None:
        centre = np.mean(places, axis=0)
    axes = motion.axes(link)
    turned = axes @ tensor @ np.swapaxes(axes, -1, -2)
    omega, alpha = motion.angular_velocity(link), motion.angular_acceleration(link)
    spin = (turned @ alpha[..., None])[..., 0] + np.cross(omega, (turned @ omega[..., None])[..., 0])
    return motion.position_on(link, centre), mass * motion.acceleration_on(link, centre), spin, mass


@pytest.mark.parametrize("name", MOTIONS)
def test_every_link_is_in_equilibrium(name: str) -> None:
    """Newton and Euler for one link at a time, moments about the global origin."""
    motion = MOTIONS[name]()
    found, linkage = motion.reactions(), motion.linkage
    assert set(np.ravel(found.method)) == {"minimum norm" if name == "vice" else "determinate"}
    for link in linkage.links:
        centre, rate, spin, mass = momentum(motion, link)
        terms = [(centre, mass * linkage.weight, np.zeros(3)), *acting(motion, link)]
        for joint in linkage.joints.values():
            if link in (joint.first, joint.second):
                wrench = found.force(joint.name, link)
                terms.append((motion.position(joint.point, joint.second), wrench[..., :3], wrench[..., 3:]))
        size = max(float(np.abs(force).max()) for _, force, _ in terms)
        assert_allclose(sum(force for _, force, _ in terms), rate, rtol=0.0, atol=1e-12 * size)
        moments = sum(np.cross(place, force) + moment for place, force, moment in terms)
        assert_allclose(moments, spin + np.cross(centre, rate), rtol=0.0, atol=2e-12 * size)


@pytest.mark.parametrize("name", MOTIONS)
def test_joints_transmit_no_more_than_they_hold(name: str) -> None:
    """What a joint lets go takes no force but the drive's; a screw turns force into torque."""
    motion = MOTIONS[name]()
    found = motion.reactions()
    for joint in motion.linkage.joints.values():
        inside = -found.in_joint(joint.name)
        size = np.abs(inside).max()
        for k, component in enumerate(("ux", "uy", "uz", "rx", "ry", "rz")):
            if component not in joint.kind.coordinates:
                continue
            free = inside[..., k]
            if joint.kind.name == "screw":
                free = free + inside[..., 2] * joint.pitch / (2 * np.pi)
            driven = motion.linkage.drives.get(joint.name, ())
            wanted = found.drive(joint.name)[..., driven.index(component)] if component in driven else 0.0
            assert_allclose(free, np.broadcast_to(wanted, free.shape), rtol=0.0, atol=1e-12 * size)


@pytest.mark.parametrize("name", MOTIONS)
def test_power_of_drives_and_loads_is_the_rate_of_kinetic_energy(name: str) -> None:
    motion = MOTIONS[name]()
    found, linkage = motion.reactions(), motion.linkage
    power = np.zeros(motion.shape)
    for joint in linkage.drives:
        power = power + np.sum(found.drive(joint) * motion.coordinate_rate(joint), axis=-1)
    rate = np.zeros(motion.shape)
    for link in linkage.links:
        centre, force, spin, mass = momentum(motion, link)
        omega = motion.angular_velocity(link)
        axes = motion.axes(link)

        def speed(place: Array, link: str = link, axes: Array = axes) -> Array:
            local = (np.swapaxes(axes, -1, -2) @ (place - motion.origin(link))[..., None])[..., 0]
            return motion.velocity_on(link, local)

        rate = rate + np.sum(force * speed(centre) + spin * omega, axis=-1)
        for place, push, moment in [(centre, mass * linkage.weight, np.zeros(3)), *acting(motion, link)]:
            power = power + np.sum(push * speed(place) + moment * omega, axis=-1)
    assert_allclose(power, rate, rtol=0.0, atol=1e-11 * np.abs(rate).max())


@pytest.mark.parametrize("name", MOTIONS)
def test_kinetic_energy_changes_at_that_rate(name: str) -> None:
    """Central differences along the drives, whose rates change with their accelerations."""
    motion = MOTIONS[name]()
    linkage, h = motion.linkage, 1e-4
    values = {joint: motion.coordinate(joint)[..., 0] for joint in linkage.drives}
    rates = {joint: motion.coordinate_rate(joint)[..., 0] for joint in linkage.drives}
    gains = {joint: motion.coordinate_acceleration(joint)[..., 0] for joint in linkage.drives}
    energy = []
    for t in (-h, h):
        moved = {joint: values[joint] + rates[joint] * t + gains[joint] * t**2 / 2 for joint in values}
        faster = {joint: rates[joint] + gains[joint] * t for joint in values}
        energy.append(linkage.move(moved, rates=faster).kinetic_energy())
    rate = sum(
        np.sum(force * motion.velocity_on(link, _centre(motion, link)), axis=-1)
        + np.sum(spin * motion.angular_velocity(link), axis=-1)
        for link in linkage.links
        for _, force, spin, _ in [momentum(motion, link)]
    )
    assert_allclose((energy[1] - energy[0]) / (2 * h), rate, rtol=0.0, atol=2e-5 * np.abs(rate).max())


def _centre(motion: Motion, link: str) -> Array:
    given = motion.linkage.links[link]
    places = [motion.linkage.points[point] for point in given.points]
    return np.mean(places, axis=0) if given.centre is None else given.centre


@settings(max_examples=30, deadline=None)
@given(
    lengths=st.tuples(*[st.floats(0.65, 0.85)] * 2, st.floats(0.6, 0.9)),
    theta=st.floats(0.1, 6.2),
    rate=st.floats(-9.0, 9.0),
    gain=st.floats(-9.0, 9.0),
)
def test_equation_4_of_the_paper(lengths: tuple[float, float, float], theta: float, rate: float, gain: float) -> None:
    """The four-bar's own 9 x 9 system, Eq. (4), derived and tested by itself."""
    crank, (coupler, rocker, ground) = 0.3, lengths
    special = FourBar(crank=crank, coupler=coupler, rocker=rocker, ground=ground, branch="open")
    turned = special.move(theta, rate, gain)
    force = (-11.0, 4.0)
    loads = {
        "crank": Link(mass=2.0, centre=(crank / 2, 0.0), inertia=0.05),
        "coupler": Link(mass=5.0, centre=(coupler / 2, 0.0), inertia=0.3, force=force, at=(coupler, 0.0), torque=-1.5),
        "rocker": Link(mass=3.0, centre=(rocker / 2, 0.0), inertia=0.2),
    }
    wanted = turned.reactions(**loads, gravity=(0.3, -9.81))
    drawn = special.move(1.0)
    linkage = Linkage({point: drawn.position(point) for point in "ABDE"})
    for name, points in (("crank", "AB"), ("coupler", "BD"), ("rocker", "ED")):
        linkage.link(name, *points, mass=loads[name].mass, inertia=loads[name].inertia)
    linkage.revolute("A", "ground", "crank", drive=True, reference=1.0)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    linkage.load("D", link="coupler", fx=force[0], fy=force[1])
    linkage.torque("coupler", mz=-1.5)
    linkage.gravity((0.3, -9.81))
    found = linkage.move(A=theta, rates={"A": rate}, accelerations={"A": gain}).reactions()
    size = np.abs(wanted.unknowns).max()
    assert_allclose(found.drive("A")[0], wanted.drive_torque, rtol=0.0, atol=1e-11 * size)
    for joint, link in (("A", "crank"), ("B", "crank"), ("D", "coupler"), ("E", "rocker")):
        assert_allclose(found.force(joint, link)[:3], wanted.reaction(joint), rtol=0.0, atol=1e-11 * size)


# -- closed forms ------------------------------------------------------------------------------------------------------


def test_screw_jack() -> None:
    """Torque on the screw: force times pitch over two pi."""
    linkage = Linkage(S=(0, 0, 0), N=(0.1, 0, 0))
    linkage.link("spindle", "S")
    linkage.link("nut", "S", "N")
    linkage.revolute("S", "ground", "spindle", axis=(0, 0, 1), drive=True)
    linkage.screw("S", "spindle", "nut", axis=(0, 0, 1), pitch=0.01, name="thread")
    linkage.prismatic("N", "ground", "nut", axis=(0, 0, 1))
    linkage.load("N", fz=-2000.0)
    found = linkage.move(S=np.linspace(0.0, 20.0, 3)).reactions()
    # Turning the spindle forwards lets the nut down.
    assert_allclose(found.drive("S")[:, 0], -2000.0 * 0.01 / (2 * np.pi), rtol=1e-12)


def test_torque_through_a_cardan_joint() -> None:
    """T2 / T1 = w1 / w2 = (1 - sin^2(bend) cos^2(theta)) / cos(bend); the textbook's ratio of speeds, turned round."""
    bend, theta = 0.5, np.linspace(0.0, 6.0, 13)
    out = np.array([np.cos(bend), np.sin(bend), 0.0])
    linkage = Linkage(A=(-1, 0, 0), U=(0, 0, 0), B=out)
    linkage.link("input", "A", "U")
    linkage.link("output", "U", "B")
    linkage.revolute("A", "ground", "input", axis=(1, 0, 0), drive=True)
    linkage.universal("U", "input", "output", axis=(0, 0, 1), second=np.cross((0, 0, 1), out))
    linkage.cylindrical("B", "ground", "output", axis=out)
    linkage.torque("output", **dict(zip(("mx", "my", "mz"), -10.0 * out, strict=True)))
    motion = linkage.move(A=theta, rates={"A": 1.0})
    speed = motion.angular_velocity("output") @ out
    assert_allclose(motion.reactions().drive("A")[:, 0], 10.0 * speed, rtol=1e-11)
    assert_allclose(speed, np.cos(bend) / (1 - np.sin(bend) ** 2 * np.sin(theta) ** 2), rtol=1e-11)


def test_double_pendulum_let_go() -> None:
    """Lagrange's equations of two point masses on rods, ``M a = -h`` (Goldstein, Classical Mechanics, ch. 1)."""
    m1, m2, l1, l2, g = 2.0, 3.0, 0.7, 0.4, 9.81
    linkage = Linkage(O=(0, 0), A=(l1, 0), B=(l1 + l2, 0))
    linkage.link("upper", "O", "A", mass=m1, centre=(l1, 0))
    linkage.link("lower", "A", "B", mass=m2, centre=(l1 + l2, 0))
    linkage.revolute("O", "ground", "upper", drive=True)
    linkage.revolute("A", "upper", "lower", drive=True)
    linkage.gravity((0.0, -g))
    a, b, da, db = 0.3, 0.5, 1.2, -2.0
    found = linkage.move(O=a, A=b, rates={"O": da, "A": db}).free_accelerations({"A": 1.5})
    c, s = np.cos(b), np.sin(b)
    mass = np.array(
        [
            [(m1 + m2) * l1**2 + m2 * l2**2 + 2 * m2 * l1 * l2 * c, m2 * l2**2 + m2 * l1 * l2 * c],
            [m2 * l2**2 + m2 * l1 * l2 * c, m2 * l2**2],
        ]
    )
    rest = np.array(
        [
            -m2 * l1 * l2 * s * (2 * da * db + db**2) + (m1 + m2) * g * l1 * np.cos(a) + m2 * g * l2 * np.cos(a + b),
            m2 * l1 * l2 * s * da**2 + m2 * g * l2 * np.cos(a + b),
        ]
    )
    wanted = np.linalg.solve(mass, np.array([0.0, 1.5]) - rest)
    assert_allclose([found["O"][0], found["A"][0]], wanted, rtol=1e-12)


def test_a_rod_that_spins_between_balls_takes_no_torque() -> None:
    """RSSR: the rod's inertia about itself is balanced by its spin alone, so that the other forces do not feel it."""

    def moving(about_itself: float) -> Motion:
        linkage = Linkage(A=(0, 0, 0), B=(0.2, 0, 0.1), C=(0.9, 0.5, 0.4), D=(0.9, 0.5, 0.0))
        u = np.array([0.7, 0.5, 0.3]) / np.linalg.norm([0.7, 0.5, 0.3])
        linkage.link("crank", "A", "B", mass=1.0)
        tensor = 0.05 * (np.eye(3) - np.outer(u, u)) + about_itself * np.outer(u, u)
        linkage.link("rod", "B", "C", mass=2.0, inertia=0.5 * (tensor + tensor.T))
        linkage.link("rocker", "C", "D", mass=1.0, inertia=(0.1, 0.1, 0.1, 0, 0, 0))
        linkage.revolute("A", "ground", "crank", axis=(0, 0, 1), drive=True)
        linkage.spherical("B", "crank", "rod")
        linkage.spherical("C", "rod", "rocker")
        linkage.revolute("D", "ground", "rocker", axis=(1, 0, 0))
        linkage.gravity((0, 0, -9.81))
        return linkage.move(A=np.linspace(0.0, 1.0, 5), rates={"A": 3.0}, accelerations={"A": 2.0})

    plain, spinning = moving(0.0).reactions(), moving(0.03).reactions()
    assert set(spinning.method) == {"determinate"}
    for joint in "ABCD":
        assert np.isfinite(spinning.force(joint)).all()
    # The rod's spin is the choice of the kinematics; what a symmetric rod does across its axis hardly depends on it.
    assert_allclose(spinning.drive("A"), plain.drive("A"), rtol=0.2)


# -- shared and impossible loads ---------------------------------------------------------------------------------------


def two_pins(beam: Beam | None) -> Motion:
    """A bar held by two pins, pushed along itself at one third; no drive is needed, so one drives nothing."""
    linkage = Linkage(A=(0, 0), P=(1, 0), B=(3, 0), C=(0, 1))
    linkage.link("bar", "A", "P", "B", beam=beam)
    linkage.link("hand", "C")
    linkage.revolute("C", "ground", "hand", drive=True)
    linkage.revolute("A", "ground", "bar")
    linkage.revolute("B", "ground", "bar")
    linkage.load("P", fx=90.0)
    return linkage.move(C=0.0)


def test_a_shared_load_is_shared_by_compliance_or_evenly() -> None:
    stiff, rigid = two_pins(BAR).reactions(), two_pins(None).reactions()
    assert stiff.method == "compliance"
    assert rigid.method == "minimum norm"
    # The bar passes two thirds to the near pin: forces as one over the lengths.
    assert_allclose([stiff.force("A")[0], stiff.force("B")[0]], [-60.0, -30.0], rtol=1e-9)
    assert_allclose([rigid.force("A")[0], rigid.force("B")[0]], [-45.0, -45.0], rtol=1e-9)


def pushed_across(stiffness: float, beam: Beam | None = BAR) -> Motion:
    """A four-bar loaded out of its plane: the joints share moments that equilibrium does not tell."""
    linkage = four_bar(0.3, 0.9, 0.8, 0.7, 1.0)
    for name, link in list(linkage.links.items()):
        del linkage.links[name]
        linkage.link(name, *link.points, beam=beam)
    if np.isfinite(stiffness):
        for name, pair in linkage.joints.items():
            linkage.joints[name] = replace(pair, stiffness=np.array([stiffness] * 5 + [0.0]))
    linkage.load("D", fx=5.0, fz=100.0)
    return linkage.move(A=1.3)


def test_compliant_reactions_tend_to_those_of_ideal_joints() -> None:
    """With joints of stiffness k the shared reactions differ from those of ideal joints by a multiple of 1/k."""
    ideal = pushed_across(np.inf).reactions()
    assert ideal.method == "compliance"
    errors = []
    for k in (1e8, 1e9, 1e10):
        found = pushed_across(k).reactions()
        errors.append(max(np.abs(found.force(j) - ideal.force(j)).max() for j in "ABDE"))
    rates = np.log10(np.array(errors[:-1]) / np.array(errors[1:]))
    assert_allclose(rates, 1.0, atol=0.1)
    assert errors[-1] > 1e-9


def test_rigid_reactions_are_the_limit_of_stiff_links_at_finite_displacement() -> None:
    """In the deformed position the forces differ from the rigid ones by a multiple of the compliance, 1/E."""

    def linkage(young: float) -> Linkage:
        beam = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=young, nu=0.3), segments=2)
        made = four_bar(0.3, 0.9, 0.8, 0.7, 1.0)
        for name, link in list(made.links.items()):
            del made.links[name]
            made.link(name, *link.points, beam=beam)
        made.load("D", fx=300.0, fy=-200.0)
        return made

    rigid = linkage(1.0).move(A=1.3).reactions()
    assert rigid.method == "determinate"
    errors = []
    for young in (2e11, 2e12, 2e13):
        solution = linkage(young).move(A=1.3).frame().solve(large=True)
        errors.append(abs(-solution.joint_force("A")[..., 5] - rigid.drive("A")[0]))
    rates = np.log10(np.ravel(errors)[:-1] / np.ravel(errors)[1:])
    assert_allclose(rates, 1.0, atol=0.1)


def test_singular_poses_have_no_finite_reactions() -> None:
    linkage = four_bar(0.1, 0.2, 0.1, 0.2, 1.0)
    linkage.load("D", fy=1.0)
    found = linkage.move(A=np.array([0.5, np.pi, 4.0])).reactions()
    assert found.method.tolist() == ["determinate", "none", "determinate"]
    assert np.isnan(found.force("B")[1]).all()
    assert np.isfinite(found.force("B")[[0, 2]]).all()
    linkage.loads.clear()
    still = linkage.move(A=np.array([0.5, np.pi])).reactions()
    assert_allclose(still.drive("A"), 0.0, atol=1e-18)


def test_singular_poses_of_a_linkage_with_an_idle_rod() -> None:
    """A flat parallelogram whose coupler spins between balls: its idle spin must not pass for a way out."""
    linkage = Linkage(A=(0, 0), B=(0.05, 0.08), D=(0.25, 0.08), E=(0.2, 0))
    for name, points in (("crank", "AB"), ("coupler", "BD"), ("rocker", "DE")):
        linkage.link(name, *points, mass=1.0, inertia=(0.1, 0.2, 0.3, 0, 0, 0))
    linkage.revolute("A", "ground", "crank", drive=True, reference=np.arctan2(0.08, 0.05))
    linkage.spherical("B", "crank", "coupler")
    linkage.spherical("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    linkage.load("D", fx=2.0, fy=1.0)
    assert linkage.mobility().actual == 2
    found = linkage.move(A=np.array([0.5, np.pi, 4.0]), rates={"A": 1.0}).reactions()
    assert found.method.tolist() == ["determinate", "none", "determinate"]


def test_poses_that_are_not_assembled_have_none_and_spoil_no_others() -> None:
    linkage = four_bar(0.4, 0.5, 0.45, 0.7, 1.0)
    linkage.load("D", fy=1.0)
    motion = linkage.move(A=np.radians([30.0, 180.0]))
    assert motion.is_assembled.tolist() == [True, False]
    found = motion.reactions()
    assert found.method.tolist() == ["determinate", "none"]
    assert_allclose(found.force("B")[0], linkage.move(A=np.radians(30.0)).reactions().force("B"), rtol=1e-12)


def test_batches_of_loads_are_solved_as_one_by_one() -> None:
    forces = np.linspace(-3.0, 5.0, 4)
    linkage = heavy_four_bar()
    linkage.load("D", fx=forces)
    found = linkage.move(A=np.linspace(0.0, 2.0, 3)[:, None]).reactions()
    assert found.shape == (3, 4)
    single = heavy_four_bar()
    single.load("D", fx=forces[2])
    assert_allclose(found.force("E")[1, 2], single.move(A=1.0).reactions().force("E"), rtol=1e-11)


def test_what_does_not_broadcast_with_the_motion_is_named() -> None:
    two = np.array([1.0, 2.0])
    for name, change in (
        ("the load on 'D'", lambda k: k.load("D", fx=two)),
        ("the load on 'crank'", lambda k: k.torque("crank", mz=two)),
        ("the spring A-D", lambda k: k.spring("A", "D", stiffness=1.0, length=two)),
        (
            "mass of link 'bob'",
            lambda k: (k.link("bob", "D", mass=two), k.fixed("D", "rocker", "bob")),
        ),
        ("gravity", lambda k: k.gravity(np.zeros((2, 3)))),
    ):
        linkage = heavy_four_bar()
        change(linkage)
        motion = linkage.move(A=np.linspace(0.0, 1.0, 3))
        with pytest.raises(FrameError, match=rf"^{name} has batch shape \(2,\).*with \(3,\) of the motion"):
            motion.reactions()


def test_what_is_not_there_is_refused() -> None:
    found = heavy_four_bar().move(A=0.3).reactions()
    with pytest.raises(FrameError, match="no joint 'Z'"):
        found.force("Z")
    with pytest.raises(FrameError, match="joint 'B' does not touch link 'rocker': it joins crank and coupler"):
        found.force("B", "rocker")
    with pytest.raises(FrameError, match="joint 'B' is not driven: the drives are A"):
        found.drive("B")
    with pytest.raises(FrameError, match="'B', which is not driven"):
        heavy_four_bar().move(A=0.3).free_accelerations({"B": 1.0})
    with pytest.raises(FrameError, match="nothing that has inertia"):
        four_bar(0.3, 0.9, 0.8, 0.7, 1.0).move(A=0.3).free_accelerations()


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_blocks_of_equations_are_those_that_do_not_meet(seed: int) -> None:
    """Against the powers of the matrix that tells which rows share a column."""
    rng = np.random.default_rng(seed)
    used = rng.random((rng.integers(1, 9), rng.integers(1, 9))) < 0.25
    shared = np.linalg.matrix_power((used @ used.T | np.eye(len(used), dtype=bool)).astype(int), len(used)) > 0
    places = np.indices(used.shape).reshape(2, -1)
    parts = blocks(*places, used.shape, used.reshape(-1))
    found = {tuple(part.rows): set(part.columns.tolist()) for part in parts}
    for row, others in enumerate(shared):
        own = tuple(np.flatnonzero(others).tolist())
        assert found[own] == set(np.flatnonzero(used[list(own)].any(axis=0)).tolist()), row


def test_blocks_are_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Poses of one pattern of coefficients, one by one, and linkages of it: the first alone is looked at."""
    heavy_four_bar().move(A=0.3).reactions()
    monkeypatch.setattr(coefficients, "_blocks", None)
    assert np.isfinite(heavy_four_bar().move(A=0.4).reactions().drive("A")).all()
