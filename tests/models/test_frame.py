"""The four-bar as a frame: its joint forces against kinetostatics, its compliance against the unit-load method."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.errors import FrameError
from linkframe.models import FourBar, Link
from numpy.testing import assert_allclose, assert_array_equal

THETA = np.radians([10.0, 30.0, 60.0, 90.0, 150.0, 230.0, 300.0, 350.0])
ROCKING = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open")


def forces(motion, load):
    """Rigid joint reactions under a force on P."""
    return motion.reactions(coupler=Link(force=load, at=motion.four_bar.point))


def compliance(motion, load):
    """Displacement of P by the unit-load method, for a parallelogram with P on the line of its coupler.

    The clamped linkage is statically determinate: rigid reactions give N and M in each bar, and
    u · f = Σ ∫ (N n/EA + M m/EI) dx + Σ R · r/k, with n, m, r due to a unit load f.
    """
    four_bar = motion.four_bar
    crank, coupler, rocker, _ = four_bar.lengths
    x = float(four_bar.point[0])
    beam = four_bar.link_beam("crank")
    stretch, bend = beam.material.E * 12.7e-3 * 6.35e-3, beam.material.E * 6.35e-3 * 12.7e-3**3 / 12
    real = forces(motion, load)
    found = []
    for unit in ((1.0, 0.0), (0.0, 1.0)):
        virtual = forces(motion, unit)
        total = 0.0
        for link, length in (("crank", crank), ("rocker", rocker)):
            # The crank carries the force on its tip as a cantilever, the rocker the force in D as a strut.
            along = np.stack([np.cos(motion.angle(link)), np.sin(motion.angle(link)), 0 * motion.theta], axis=-1)
            tip, unit_tip = (each.reaction("B" if link == "crank" else "D") for each in (real, virtual))
            across = np.cross([0.0, 0.0, 1.0], along)
            axial = np.sum(tip * along, -1) * np.sum(unit_tip * along, -1)
            shear = np.sum(tip * across, -1) * np.sum(unit_tip * across, -1)
            total = total + axial * length / stretch + shear * length**3 / (3 * bend)
        # The coupler is parallel to global x, loaded at x between its pins; N differs on the two sides of P.
        for end, part in (("B", x), ("D", coupler - x)):
            normal = real.reaction(end)[:, 0] * virtual.reaction(end)[:, 0]
            lift = real.reaction(end)[:, 1] * virtual.reaction(end)[:, 1]
            total = total + normal * part / stretch + lift * part**3 / (3 * bend)
        for joint in "BDE":
            k = four_bar.joint_stiffness(joint)[0]
            total = total + np.sum(real.reaction(joint) * virtual.reaction(joint), -1) / k
        found.append(total)
    return np.stack(found, axis=-1)


@pytest.mark.parametrize(("four_bar", "load"), list(product([FourBar(), ROCKING], [(0.0, 100.0), (-30.0, 20.0)])))
def test_joint_forces_are_the_reactions_of_kinetostatics(four_bar, load):
    motion = four_bar.move(THETA)
    frame = motion.frame()
    frame.load("P", fx=load[0], fy=load[1])
    solution, rigid = frame.solve(), forces(motion, load)
    for joint in "BDE":
        assert_allclose(solution.joint_force(joint)[:, :3], rigid.reaction(joint), atol=1e-10)
    assert_allclose(solution.reaction("A")[:, :3], rigid.reaction("A"), atol=1e-10)
    assert_allclose(solution.reaction("A")[:, 5], rigid.drive_torque, atol=1e-10)
    assert_allclose(solution.reaction("E")[:, :3], rigid.reaction("E"), atol=1e-10)


@pytest.mark.parametrize("load", [(0.0, 100.0), (50.0, 0.0), (-30.0, 20.0)])
def test_compliance_is_that_of_the_unit_load_method(load):
    motion = FourBar(stiffness=(1e8, 1e8, 1e8, 1e8, 1e8, 0.0), point=(0.06, 0.0)).move(THETA)
    frame = motion.frame()
    frame.load("P", fx=load[0], fy=load[1])
    assert_allclose(frame.solve().displacement("P")[:, :2], compliance(motion, load), rtol=1e-12, atol=1e-18)


def test_a_clearance_offset_parts_the_pins_by_just_that():
    frame = FourBar().move(THETA).frame()
    frame.offset("D", ux=1e-3, uy=-2e-3)
    solution = frame.solve()
    assert_allclose(solution.joint_displacement("D")[:, :2], np.tile([1e-3, -2e-3], (8, 1)), rtol=1e-12)
    apart = solution.displacement("D.rocker") - solution.displacement("D.coupler")
    assert_allclose(apart[:, :2], np.tile([1e-3, -2e-3], (8, 1)), rtol=1e-9)


def test_nodes_lie_where_the_motion_has_its_points():
    motion = ROCKING.move(THETA)
    frame = motion.frame()
    for node in frame.nodes:
        placed = np.broadcast_to(frame.position(node), (8, 3))
        assert_allclose(placed, motion.position(node[0]), atol=1e-15)
    assert list(frame.joints) == ["B", "D", "E"]
    assert list(frame.bodies) == ["crank", "coupler", "rocker"]


@pytest.mark.parametrize(
    ("point", "members"),
    [
        ((0.1, 0.0), ["B.coupler-P", "P-D.coupler"]),
        ((0.1, 0.05), ["B.coupler-P", "P-D.coupler"]),
        ((0.3, 0.0), ["B.coupler-D.coupler", "D.coupler-P"]),
        ((-0.1, 0.0), ["P-B.coupler", "B.coupler-D.coupler"]),
        ((0.0, 0.0), ["B.coupler-D.coupler"]),
        ((0.2, 0.0), ["B.coupler-D.coupler"]),
    ],
)
def test_the_coupler_runs_through_its_points_in_their_order(point, members):
    motion = FourBar(point=point).move(THETA)
    frame = motion.frame()
    assert [f"{m.start}-{m.end}" for name, m in frame.members.items() if name.startswith("coupler")] == members
    frame.load("P", fy=100.0)
    rigid = forces(motion, (0.0, 100.0))
    assert_allclose(frame.solve().joint_force("D")[:, :3], rigid.reaction("D"), atol=1e-10)


def test_links_may_differ():
    thick = Beam(Rectangle(y=0.1, z=0.1), Material(E=2e11, nu=0.3))
    thin = FourBar().link_beam("crank")
    stiff = FourBar(beam={"crank": thick, "coupler": thin, "rocker": thin}).move(THETA).frame()
    limp = FourBar().move(THETA).frame()
    for frame in (stiff, limp):
        frame.load("P", fy=100.0)
    tip = [np.abs(frame.solve().displacement("B.crank")[:, 1]) for frame in (stiff, limp)]
    assert np.all(tip[0] < 1e-2 * tip[1])


def test_batch_of_poses_and_stiffnesses():
    soft = np.array([1e6, 1e7, 1e8])
    springs = np.stack([soft] * 5 + [0 * soft], axis=-1)
    frame = FourBar(stiffness=springs).move(THETA[:, None]).frame()
    frame.load("P", fy=100.0)
    assert frame.shape == (8, 3)
    one = FourBar(stiffness=springs[1]).move(THETA[2]).frame()
    one.load("P", fy=100.0)
    assert_allclose(frame.solve().displacement("P")[2, 1], one.solve().displacement("P"), rtol=1e-13, atol=1e-18)


def described(motion, clearance):
    """The frame as its docstring tells it, by the verbs of a frame."""
    four_bar, frame = motion.four_bar, Frame()
    (x, y), (a, b, c, d), zero = four_bar.point, four_bar.lengths, (0.0, 0.0, 0.0)
    for link in ("crank", "coupler", "rocker"):
        start, along = motion.origin(link), motion.direction(link)
        origin, cos, sin = np.stack([start.real, start.imag, 0.0 * start.real], axis=-1), along.real, along.imag
        axes = np.zeros((*np.shape(cos), 3, 3))
        axes[..., 0, 0], axes[..., 0, 1], axes[..., 1, 0], axes[..., 1, 1], axes[..., 2, 2] = cos, -sin, sin, cos, 1.0
        frame.body(link, origin, axes)
    for node, on, place in (
        ("A", "crank", zero), ("B.crank", "crank", (a, 0.0, 0.0)),
        ("B.coupler", "coupler", zero), ("P", "coupler", (x, y, 0.0)), ("D.coupler", "coupler", (b, 0.0, 0.0)),
        ("D.rocker", "rocker", (c, 0.0, 0.0)), ("E.rocker", "rocker", zero), ("E", None, (d, 0.0, 0.0)),
    ):  # fmt: skip
        frame.node(node, np.stack(np.broadcast_arrays(*place), axis=-1), on)
    frame.add("crank", four_bar.link_beam("crank"), "A", "B.crank")
    frame.add("coupler.1", four_bar.link_beam("coupler"), "B.coupler", "P")
    frame.add("coupler.2", four_bar.link_beam("coupler"), "P", "D.coupler")
    frame.add("rocker", four_bar.link_beam("rocker"), "D.rocker", "E.rocker")
    for joint, ends in {"B": ("B.crank", "B.coupler"), "D": ("D.coupler", "D.rocker"), "E": ("E.rocker", "E")}.items():
        across = ("ux", "uy") if joint in clearance else None
        pin = four_bar.joint_stiffness(joint)
        frame.add(joint, Joint(pin, clearance=clearance.get(joint, 0.0), clearance_directions=across), *ends)
    frame.fix("A")
    frame.fix("E")
    return frame


@pytest.mark.parametrize("clearance", [{}, {"B": 1e-4, "E": 2e-4}])
def test_the_frame_is_bit_by_bit_the_one_described_by_hand(clearance):
    """Of random four-bars, with joints that are not alike along global x and y, alone and in a batch."""
    rng = np.random.default_rng(5)
    lengths = rng.uniform((0.05, 0.2, 0.2, 0.2), (0.1, 0.3, 0.3, 0.3), (200, 4)).T
    theta, point = rng.uniform(-6.0, 6.0, 200), (rng.uniform(0.05, 0.15, 200), rng.uniform(0.01, 0.1, 200))
    good = FourBar(*lengths).assembles(theta)
    pins = [rng.uniform(1e6, 1e8, 6) for _ in "BDE"]
    for pin in pins if clearance else ():
        pin[1] = pin[0]
    stiffness = dict(zip("BDE", pins, strict=True))
    batches = [good, *np.flatnonzero(good)[:10]]
    for at in batches:
        motion = FourBar(*lengths[:, at], point=(point[0][at], point[1][at]), stiffness=stiffness).move(theta[at])
        frames = motion.frame(clearance), described(motion, clearance)
        for frame in frames:
            frame.load("P", fx=20.0, fy=-50.0, fz=3.0, mz=1.0)
        one, other = (frame.solve() for frame in frames)
        for parts in ("bodies", "nodes", "members", "joints", "supports"):
            assert list(getattr(frames[0], parts)) == list(getattr(frames[1], parts))
        assert frames[0].size == frames[1].size
        for node in frames[0].nodes:
            assert_array_equal(frames[0].position(node), frames[1].position(node))
            assert_array_equal(one.displacement(node), other.displacement(node))
        for joint in "BDE":
            assert_array_equal(one.joint_force(joint), other.joint_force(joint))


def test_it_refuses_a_clearance_where_the_joint_is_not_equally_stiff():
    motion = FourBar(stiffness=(1e6, 2e6, 1e6, 1e6, 1e6, 0.0)).move(1.0)
    with pytest.raises(FrameError, match=r"joint 'B' has clearance in ux uy, where its stiffness is 1e\+06, 2e\+06"):
        motion.frame({"B": 1e-4})
    with pytest.raises(FrameError, match=r"clearance of joint 'B' is -0\.0001: give zero or above"):
        motion.frame({"B": -1e-4})
    with pytest.raises(FrameError, match="passive joints are B, D, E"):
        motion.frame({"A": 1e-4})
