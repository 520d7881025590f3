"""Spatial linkages of the textbooks: each against its closed form, and against the laws of motion and equilibrium."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.audit import audit
from scipy.optimize import fsolve, least_squares
from scipy.spatial.transform import Rotation

TURN = np.linspace(0.0, 2.0 * np.pi, 49)
INERTIA = (0.02, 0.03, 0.04, 0.001, -0.002, 0.003)


def test_rccc_of_duffy():
    """Angles and slides by least squares on the open chain, product of rotations (Duffy 1980)."""
    rng = np.random.default_rng(4)
    places = rng.uniform(-1, 1, (4, 3))
    axes = rng.normal(size=(4, 3))
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    names = ["ground", "input", "coupler", "output", "ground"]
    linkage = Linkage({f"P{k}": p for k, p in enumerate(places)})
    for k in range(3):
        linkage.link(names[k + 1], f"P{k}", f"P{k + 1}", mass=1.0, inertia=INERTIA)
    linkage.revolute("P0", "ground", "input", axis=axes[0], drive=True)
    for k in (1, 2):
        linkage.cylindrical(f"P{k}", names[k], names[k + 1], axis=axes[k])
    linkage.cylindrical("P3", "ground", "output", axis=axes[3])
    linkage.gravity((1.0, 2.0, -9.81))
    linkage.torque("output", mx=0.3, mz=-1.0)
    angle = np.linspace(0, 0.5, 6)
    motion = linkage.move(P0=angle)

    def closure(u, t):
        r = [Rotation.from_rotvec(a * q) for a, q in zip(axes[:3], (t, u[0], u[1]), strict=True)]
        back = Rotation.from_rotvec(axes[3] * u[2])
        p1 = places[0] + r[0].apply(places[1] - places[0])
        p1 = p1 + u[3] * r[0].apply(axes[1])
        p2 = p1 + (r[0] * r[1]).apply(places[2] - places[1]) + u[4] * (r[0] * r[1]).apply(axes[2])
        p3 = p2 + (r[0] * r[1] * r[2]).apply(places[3] - places[2])
        turn = (r[0] * r[1] * r[2] * back.inv()).as_rotvec()
        return np.concatenate([turn, p3 - places[3] - u[5] * axes[3]])

    guess = np.zeros(6)
    for k, t in enumerate(angle):
        guess = least_squares(closure, guess, args=(t,), xtol=1e-15, ftol=1e-15, gtol=1e-15).x
        assert_allclose(closure(guess, t), 0.0, atol=1e-11)
        found = [motion.coordinate(f"P{j}")[k] for j in (1, 2, 3)]
        assert_allclose(found, [[guess[3], guess[0]], [guess[4], guess[1]], [guess[5], guess[2]]], atol=1e-10)
    assert linkage.mobility().actual == 1
    audit(linkage, lambda t: {"P0": t + t**2})


def test_rssr_with_a_slide_by_its_quadratic():
    """R-S-S-P: a crank about a skew axis moves a slide by a rod of two balls; x from a quadratic."""
    crank_axis, r, rod = np.array([0.0, 0.6, 0.8]), 0.3, 1.5
    e1 = np.array([1.0, 0.0, 0.0])
    e2 = np.cross(crank_axis, e1)

    def pin(t):
        return r * (np.cos(t)[..., None] * e1 + np.sin(t)[..., None] * e2)

    origin, along = np.array([0.4, 0.2, 0.1]), np.array([0.48, 0.6, 0.64])

    def slide(t):
        w = pin(t) - origin
        half = w @ along
        return half + np.sqrt(half**2 - np.sum(w**2, axis=-1) + rod**2)

    start = np.asarray(0.5)
    b, c = pin(start), origin + slide(start) * along
    linkage = Linkage(A=(0, 0, 0), B=b, C=c)
    linkage.link("crank", "A", "B", mass=1.0, inertia=INERTIA)
    linkage.link("rod", "B", "C", mass=0.7)
    linkage.link("slide", "C", mass=2.0)
    linkage.revolute("A", "ground", "crank", axis=crank_axis, drive=True, reference=start)
    linkage.spherical("B", "crank", "rod")
    linkage.spherical("C", "rod", "slide")
    linkage.prismatic("C", "ground", "slide", axis=along, reference=slide(start))
    motion = linkage.move(A=start + TURN)
    assert_allclose(motion.coordinate("C.prismatic")[:, 0], slide(start + TURN), atol=1e-13)
    assert linkage.mobility().idle == ("rod",)
    assert linkage.mobility().actual == 2
    audit(linkage, lambda t: {"A": start - 2 * t}, without=("rod",))


def test_sarrus_goes_straight():
    """Two pairs of hinged plates at a right angle: the top only rises; overconstrained by one."""
    a, lift = 1.0, 0.6
    reach = np.sqrt(a**2 - lift**2)
    linkage = Linkage(
        A=(0, 0, 0),
        B=(reach, 0, lift),
        C=(0, 0, 2 * lift),
        D=(0, 0.1, 0),
        E=(0, 0.1 + reach, lift),
        F=(0, 0.1, 2 * lift),
    )
    for name, ends in {"ab": "AB", "bc": "BC", "de": "DE", "ef": "EF"}.items():
        linkage.link(name, *ends, mass=1.0, inertia=INERTIA)
    linkage.link("top", "C", "F", mass=2.0)
    start = np.arcsin(lift)
    linkage.revolute("A", "ground", "ab", axis=(0, -1, 0), drive=True, reference=start)
    linkage.revolute("B", "ab", "bc", axis=(0, 1, 0))
    linkage.revolute("C", "bc", "top", axis=(0, 1, 0))
    linkage.revolute("D", "ground", "de", axis=(1, 0, 0))
    linkage.revolute("E", "de", "ef", axis=(1, 0, 0))
    linkage.revolute("F", "ef", "top", axis=(1, 0, 0))
    linkage.gravity((0, 0, -10.0))
    t = np.linspace(0.1, 1.5, 21)
    motion = linkage.move(A=t)
    assert_allclose(motion.position("C"), np.stack([0 * t, 0 * t, 2 * np.sin(t)], -1), atol=1e-13)
    assert_allclose(motion.axes("top"), np.broadcast_to(np.eye(3), (21, 3, 3)), atol=1e-13)
    m = linkage.mobility()
    assert (m.actual, m.kutzbach, len(m.redundant)) == (1, 0, 1)
    static = motion.reactions()
    # d(potential) / dt: plates' middles rise by 1/2 and 3/2 cos t, the top by 2 cos t
    assert_allclose(static.drive("A")[:, 0], 10.0 * np.cos(t) * (2 * (0.5 + 1.5) + 4.0), rtol=1e-11)
    assert set(static.method) == {"minimum norm"}
    audit(linkage, lambda t: {"A": start + t})


def dh_closure(angles, lengths, twists, offsets):
    """Turn and shift by which a chain of hinges misses its start, by Denavit and Hartenberg; (..., 6)."""
    turn, place = Rotation.identity(), np.zeros(3)
    for q, a, twist, d in zip(angles, lengths, twists, offsets, strict=True):
        place = place + turn.apply((0, 0, d))
        turn = turn * Rotation.from_euler("z", q)
        place = place + turn.apply((a, 0, 0))
        turn = turn * Rotation.from_euler("x", twist)
    return np.concatenate([turn.as_rotvec(), place])


def dh_linkage(lengths, twists, offsets, angles):
    """A loop of hinges, each hinge's point where the link before it ends; all links have mass."""
    n = len(angles)
    turn, place, linkage, axes = Rotation.identity(), np.zeros(3), Linkage(), []
    for k, (a, twist, d) in enumerate(zip(lengths, twists, offsets, strict=True)):
        linkage.point(f"H{k}", place)
        axes.append(turn.apply((0, 0, 1)))
        place = place + d * axes[-1]
        turn = turn * Rotation.from_euler("z", angles[k])
        place = place + turn.apply((a, 0, 0))
        turn = turn * Rotation.from_euler("x", twist)
    names = ["ground", *(f"link {k}" for k in range(1, n)), "ground"]
    for k in range(1, n):
        linkage.link(names[k], f"H{k - 1}", f"H{k}", mass=1.0, inertia=INERTIA)
    for k in range(n):
        linkage.revolute(f"H{k}", names[k], names[k + 1], axis=axes[k], reference=angles[k], drive=k == 0)
    linkage.gravity((1.0, 2.0, -9.81))
    return linkage


SIDE = np.sin([0.6, 1.1, 0.9])  # of Bennett's links: proportional to the sines of their twists
RIGHT = np.pi / 2
OVERCONSTRAINED = {
    # two Bennett linkages with a link in common, which is left out (Goldberg 1943)
    "Goldberg": (
        (SIDE[1] + SIDE[2], SIDE[0], SIDE[2], SIDE[1], SIDE[0]),
        (2.0, 0.6, 0.9, 1.1, 0.6),
        (0.0,) * 5,
        (0.9, 2.0, 0.5, -1.0, 1.0),
    ),
    # P. Schatz 1929, the mixer Turbula
    "Schatz": (
        (0.0, 1.0, 1.0, 1.0, 0.0, np.sqrt(3.0)),
        (RIGHT, RIGHT, RIGHT, RIGHT, RIGHT, 0.0),
        (0.4, 0.0, 0.0, 0.0, 0.0, -0.4),
        (0.5, 1.0, -1.0, 1.0, -1.0, 0.5),
    ),
    # symmetric about a plane (Myard 1931; Baker 1979)
    "Myard": (
        (1.0, 1.0 / np.sin(0.8), 0.0, 1.0 / np.sin(0.8), 1.0),
        (0.8, RIGHT, np.pi - 1.6, RIGHT, np.pi - 0.8),
        (0.0,) * 5,
        (1.0, 2.0, 1.0, 2.0, 1.0),
    ),
    # the squares of every other length have the same sum (Bricard 1927)
    "Bricard, trihedral": (
        (1.0, 1.2, 1.1, 0.9, 1.0, np.sqrt(1.0 + 1.1**2 + 1.0 - 1.2**2 - 0.9**2)),
        (RIGHT, -RIGHT) * 3,
        (0.0,) * 6,
        (0.38, 2.21, 0.44, 2.15, 0.37, 1.86),
    ),
    # opposite links are alike (Bricard 1927)
    "Bricard, line-symmetric": (
        (1.0, 0.8, 0.6) * 2,
        (0.7, 1.1, 0.9) * 2,
        (0.1, 0.2, 0.3) * 2,
        (-1.2, 0.88, -2.49) * 2,
    ),
}


@pytest.mark.parametrize("name", OVERCONSTRAINED)
def test_overconstrained_loops_of_hinges(name):
    """They move though by count they do not; every pose closes the chain of Denavit and Hartenberg."""
    lengths, twists, offsets, guess = OVERCONSTRAINED[name]
    rng = np.random.default_rng(2)
    for _ in range(200):
        start = least_squares(dh_closure, guess, args=(lengths, twists, offsets), xtol=1e-15, ftol=1e-15, gtol=1e-15)
        spread = np.abs(np.sin(start.x)).min()
        if start.cost < 1e-28 and spread > 0.05:
            break
        guess = rng.uniform(-3, 3, len(lengths))
    assert start.cost < 1e-28
    linkage = dh_linkage(lengths, twists, offsets, start.x)
    n = len(lengths)
    m = linkage.mobility()
    assert (m.actual, m.kutzbach, len(m.redundant)) == (1, n - 6, 7 - n)
    theta = start.x[0] + np.linspace(0.0, 0.6, 13)
    motion = linkage.move(H0=theta)
    assert np.all(motion.is_assembled)
    angles = np.concatenate([motion.coordinate(f"H{k}") for k in range(n)], axis=-1)
    assert_allclose(angles[0], start.x, atol=1e-12)
    for row in angles:
        assert_allclose(dh_closure(row, lengths, twists, offsets), 0.0, atol=1e-12)
    assert np.all(np.ptp(angles, axis=0) > 0.01)
    audit(linkage, lambda t: {"H0": start.x[0] + t}, t=0.1)


@pytest.mark.parametrize("phase", [0.0, np.pi / 2])
def test_double_cardan_and_the_phase_of_its_forks(phase):
    """Equal bends in one plane: with its forks in phase the shaft turns the output evenly, else it is cos^2 as far."""
    bend = np.radians(25.0)
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    linkage = Linkage(A=(0, 0, 0), U=(0.3, 0, 0), V=(0.3, 0, 0) + 0.5 * along, E=(0.6, 0, 0) + 0.5 * along)
    linkage.link("in", "A", "U", mass=1.0, inertia=INERTIA)
    linkage.link("shaft", "U", "V", mass=1.0, inertia=INERTIA)
    linkage.link("out", "V", "E", mass=1.0, inertia=INERTIA)
    up, across, side = np.array([0, 0, 1.0]), np.cross((0, 0, 1.0), along), np.array([0, 1.0, 0])
    linkage.revolute("A", "ground", "in", axis=(1, 0, 0), drive=True)
    linkage.universal("U", "in", "shaft", axis=up, second=across)
    if phase:
        linkage.universal("V", "shaft", "out", axis=up, second=side)
    else:
        linkage.universal("V", "shaft", "out", axis=across, second=up)
    linkage.cylindrical("E", "ground", "out", axis=(1, 0, 0))
    motion = linkage.move(A=TURN)
    factor = np.cos(bend) ** 2 if phase else 1.0
    wanted = np.unwrap(np.arctan2(factor * np.sin(TURN), np.cos(TURN)))
    assert_allclose(motion.coordinate("E")[:, 1], wanted, atol=1e-12)
    audit(linkage, lambda t: {"A": t})


def test_single_cardan_joint_and_its_torque():
    """tan(out) = cos(bend) tan(in) from where the driving fork is square to the bend; power in equals power out."""
    bend = 0.5
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    across = np.cross((0, 0, 1.0), along)
    linkage = Linkage(A=(-1, 0, 0), U=(0, 0, 0), E=along)
    linkage.link("in", "A", "U", mass=1.0)
    linkage.link("out", "U", "E", mass=1.0)
    linkage.revolute("A", "ground", "in", axis=(1, 0, 0), drive=True)
    linkage.universal("U", "in", "out", axis=(0, 0, 1), second=across)
    linkage.revolute("E", "ground", "out", axis=along)
    linkage.torque("out", mx=-5.0 * along[0], my=-5.0 * along[1])
    motion = linkage.move(A=TURN, rates={"A": 1.0})
    out = motion.coordinate("E")[:, 0]
    # the driving fork is along z, square to the plane of the bend, at 0
    assert_allclose(np.tan(out[:10]), np.tan(TURN[:10]) * np.cos(bend), atol=1e-12)
    ratio = np.cos(bend) / (1 - np.sin(bend) ** 2 * np.sin(TURN) ** 2)
    assert_allclose(motion.coordinate_rate("E")[:, 0], ratio, rtol=1e-11)
    assert_allclose(motion.reactions().drive("A")[:, 0], 5.0 * ratio, rtol=1e-10)


def test_three_upu_moves_straight():
    """3-UPU with outer axes tangent and inner axes parallel to them: three translations, leg lengths by Pythagoras."""
    heading = np.radians([0.0, 120.0, 240.0])
    out = np.stack([np.cos(heading), np.sin(heading), 0 * heading], -1)
    tangent = np.stack([-np.sin(heading), np.cos(heading), 0 * heading], -1)
    base, top, home = 1.0, 0.5, np.array([0.05, 0.02, 1.2])
    linkage = Linkage(P=home)
    start = np.linalg.norm(home + (top - base) * out, axis=1)
    for k in range(3):
        linkage.point(f"B{k}", base * out[k])
        linkage.point(f"T{k}", home + top * out[k])
        linkage.point(f"M{k}", (base * out[k] + home + top * out[k]) / 2)
    linkage.link("platform", "P", "T0", "T1", "T2", mass=3.0, inertia=INERTIA)
    for k in range(3):
        leg = (home + (top - base) * out[k]) / start[k]
        inner = np.cross(leg, tangent[k])
        inner /= np.linalg.norm(inner)
        linkage.link(f"lower {k}", f"B{k}", f"M{k}", mass=0.5)
        linkage.link(f"upper {k}", f"M{k}", f"T{k}", mass=0.5)
        linkage.universal(f"B{k}", "ground", f"lower {k}", axis=tangent[k], second=inner)
        linkage.prismatic(f"M{k}", f"lower {k}", f"upper {k}", axis=leg, drive=True, reference=start[k])
        linkage.universal(f"T{k}", f"upper {k}", "platform", axis=inner, second=tangent[k])
    linkage.gravity((0, 0, -9.81))
    s = np.linspace(0, 1, 15)
    wanted = home + np.stack([0.2 * np.sin(3 * s), 0.1 * s, -0.2 * s], -1)
    legs = np.linalg.norm(wanted[:, None] + (top - base) * out, axis=-1)
    motion = linkage.move({f"M{k}": legs[:, k] for k in range(3)})
    assert_allclose(motion.position("P"), wanted, atol=1e-12)
    assert linkage.mobility().actual == 3

    def path(t):
        place = home + np.stack([0.2 * np.sin(t), 0.1 * t, -0.1 * t], -1)
        length = np.linalg.norm(place[..., None, :] + (top - base) * out, axis=-1)
        return {f"M{k}": length[..., k] for k in range(3)}

    audit(linkage, path)


def test_three_rpr_by_leg_lengths():
    """Planar 3-RPR: leg lengths of a wanted pose of the platform give that pose."""
    base = np.array([[0.0, 0.0], [4.0, 0.0], [2.0, 3.5]])
    own = np.array([[-0.5, -0.3], [0.5, -0.3], [0.0, 0.6]])

    def corners(place, turn):
        c, s = np.cos(turn)[..., None], np.sin(turn)[..., None]
        x, y = own.T
        return np.stack([place[..., :1] + c * x - s * y, place[..., 1:] + s * x + c * y], -1)

    home, turn = np.array([2.0, 1.2]), np.asarray(0.2)
    at = corners(home, turn)
    linkage = Linkage(P=home)
    for k in range(3):
        linkage.point(f"B{k}", base[k])
        linkage.point(f"C{k}", at[k])
    linkage.link("platform", "P", "C0", "C1", "C2", mass=2.0, inertia=0.3)
    for k in range(3):
        chord = at[k] - base[k]
        linkage.link(f"barrel {k}", f"B{k}", f"C{k}", mass=0.5)
        linkage.link(f"piston {k}", f"C{k}", mass=0.2)
        linkage.revolute(f"B{k}", "ground", f"barrel {k}")
        linkage.prismatic(
            f"C{k}",
            f"barrel {k}",
            f"piston {k}",
            axis=(*chord, 0),
            reference=np.hypot(*chord),
            drive=True,
            name=f"leg {k}",
        )
        linkage.revolute(f"C{k}", f"piston {k}", "platform")
    linkage.gravity((0, -9.81))

    def path(t):
        place = home + np.stack([0.3 * np.sin(t), 0.2 * t], -1)
        legs = np.linalg.norm(corners(place, turn + 0.4 * t) - base, axis=-1)
        return {f"leg {k}": legs[..., k] for k in range(3)}

    t = np.linspace(0, 1.5, 16)
    motion = linkage.move(path(t))
    assert_allclose(motion.position("P")[:, :2], home + np.stack([0.3 * np.sin(t), 0.2 * t], -1), atol=1e-12)
    platform = motion.axes("platform")
    assert_allclose(np.arctan2(platform[:, 1, 0], platform[:, 0, 0]), 0.4 * t, atol=1e-12)
    audit(linkage, path)


def test_robot_arm_as_an_open_chain():
    """Six hinges of a wrist-partitioned robot: pose by the product of rotations; torques by the energy."""
    axes = [(0, 0, 1), (0, 1, 0), (0, 1, 0), (1, 0, 0), (0, 1, 0), (1, 0, 0)]
    places = [(0, 0, 0), (0, 0, 0.4), (0, 0, 0.9), (0.1, 0, 0.95), (0.5, 0, 0.95), (0.5, 0, 0.95), (0.6, 0, 0.95)]
    linkage = Linkage({f"J{k}": p for k, p in enumerate(places[:6])}, T=places[6])
    chain = ["ground"]
    for k in range(6):
        ends = [f"J{k}"] + ([f"J{k + 1}"] if k < 5 else ["T"])
        linkage.link(f"body {k}", *ends, mass=2.0 - 0.2 * k, inertia=INERTIA)
        chain.append(f"body {k}")
    for k in range(6):
        linkage.revolute(f"J{k}", chain[k], chain[k + 1], axis=axes[k], drive=True)
    linkage.gravity((0, 0, -9.81))
    linkage.load("T", fx=10.0, mz=2.0)

    def path(t):
        return {f"J{k}": (0.3 + 0.1 * k) * np.sin(t + k) for k in range(6)}

    motion = linkage.move(path(TURN))
    turn, tip = Rotation.identity(), np.array(places[6])
    for k in reversed(range(6)):
        r = Rotation.from_rotvec(np.outer(path(TURN)[f"J{k}"], axes[k]))
        tip = places[k] + r.apply(tip - places[k])
        turn = r * turn
    assert_allclose(motion.position("T"), tip, atol=1e-13)
    assert_allclose(motion.axes("body 5"), turn.as_matrix(), atol=1e-13)
    audit(linkage, path)


def test_gantry_and_tree():
    """Three slides carry a hinge with two arms on it: an open tree in which every place is written down."""
    linkage = Linkage(O=(0, 0, 0), A=(0.3, 0, 0), B=(0, 0.4, 0.1))
    for name in ("bridge", "trolley"):
        linkage.link(name, "O", mass=3.0)
    linkage.link("hoist", "O", mass=1.0)
    linkage.link("left", "O", "A", mass=1.0, inertia=INERTIA)
    linkage.link("right", "O", "B", mass=1.0, inertia=INERTIA)
    linkage.prismatic("O", "ground", "bridge", axis=(1, 0, 0), drive=True, name="x")
    linkage.prismatic("O", "bridge", "trolley", axis=(0, 1, 0), drive=True, name="y")
    linkage.prismatic("O", "trolley", "hoist", axis=(0, 0, 1), drive=True, name="z")
    linkage.revolute("O", "hoist", "left", "right", name="hinge")
    linkage.drive("hinge")
    linkage.drive("hinge.right")
    linkage.gravity((0, 0, -10.0))
    s = np.linspace(0, 1, 4)
    motion = linkage.move(
        {"x": s[:, None, None], "y": s[:3, None], "z": -s[:2], "hinge": np.pi / 2, "hinge.right": -np.pi}
    )
    assert motion.shape == (4, 3, 2)
    wanted = np.stack(np.broadcast_arrays(s[:, None, None], s[:3, None] + 0.3, -s[:2]), -1)
    assert_allclose(motion.position("A"), wanted, atol=1e-14)
    assert_allclose(
        motion.position("B") - motion.position("O", "hoist"), np.broadcast_to((0, -0.4, 0.1), (4, 3, 2, 3)), atol=1e-14
    )
    assert_allclose(motion.reactions().drive("z")[..., 0], 30.0, rtol=1e-12)
    audit(linkage, lambda t: {"x": t, "y": t**2, "z": -t, "hinge": 2 * t, "hinge.right": -t})


def test_screw_jack_force():
    """Torque = force x pitch / 2 pi, with a left-hand thread too."""
    for pitch in (0.006, -0.006):
        linkage = Linkage(A=(0, 0, 0), B=(0, 0, 0.5), C=(0.1, 0, 0.5))
        linkage.link("spindle", "A", "B", mass=1.0, inertia=0.01)
        linkage.link("nut", "B", "C", mass=2.0)
        linkage.revolute("A", "ground", "spindle", axis=(0, 0, 1), drive=True)
        linkage.screw("B", "spindle", "nut", axis=(0, 0, 1), pitch=pitch)
        linkage.prismatic("C", "ground", "nut", axis=(0, 0, 1))
        linkage.load("C", fz=-1000.0)
        turn = np.linspace(0, -20 * np.pi, 21)
        motion = linkage.move(A=turn)
        assert_allclose(motion.position("C")[:, 2] - 0.5, -pitch * turn / (2 * np.pi), atol=1e-14)
        assert_allclose(motion.reactions().drive("A")[:, 0], -pitch * 1000.0 / (2 * np.pi), rtol=1e-10)
        audit(linkage, lambda t: {"A": 3 * t})


def double_wishbone():
    """Upper and lower arm on skew hinges, upright with balls, track rod to a rack; driven by the wheel's height."""
    linkage = Linkage(
        L1=(0.3, 0.15, 0.2),
        L2=(0.32, -0.15, 0.21),
        L3=(0.7, 0.0, 0.18),
        U1=(0.4, 0.12, 0.45),
        U2=(0.41, -0.14, 0.44),
        U3=(0.68, -0.02, 0.48),
        R=(0.3, 0.14, 0.27),
        S=(0.69, 0.13, 0.25),
        W=(0.78, 0.0, 0.3),
    )
    points = linkage.points
    linkage.link("lower", "L1", "L2", "L3", mass=3.0, inertia=INERTIA)
    linkage.link("upper", "U1", "U2", "U3", mass=2.0, inertia=INERTIA)
    linkage.link("upright", "L3", "U3", "S", "W", mass=20.0, inertia=INERTIA)
    linkage.link("track rod", "R", "S", mass=1.0, inertia=INERTIA)
    linkage.link("rack", "R", mass=1.0)
    linkage.revolute("L1", "ground", "lower", axis=points["L2"] - points["L1"], drive=True)
    linkage.revolute("U1", "ground", "upper", axis=points["U2"] - points["U1"])
    linkage.spherical("L3", "lower", "upright")
    linkage.spherical("U3", "upper", "upright")
    linkage.spherical("S", "upright", "track rod")
    rod = points["S"] - points["R"]
    linkage.universal(
        "R", "rack", "track rod", axis=np.cross(rod, (0, 1, 0)), second=np.cross(rod, np.cross(rod, (0, 1, 0)))
    )
    linkage.prismatic("R", "ground", "rack", axis=(0, 1, 0), drive=True, name="steering")
    linkage.gravity((0, 0, -9.81))
    return linkage


def test_double_wishbone_suspension():
    """Five rods and two drives: the upright's pose by fsolve on distances between points only."""
    linkage = double_wishbone()
    p = linkage.points
    bump, steer = np.linspace(-0.2, 0.2, 5)[:, None], np.linspace(-0.04, 0.04, 3)
    motion = linkage.move(L1=bump, steering=steer)
    assert motion.shape == (5, 3)
    assert np.all(motion.status == "regular")
    axis = (p["L2"] - p["L1"]) / np.linalg.norm(p["L2"] - p["L1"])

    def rods(u, l3, r):
        u3, s, w = u.reshape(3, 3)
        new = {"L1": p["L1"], "U1": p["U1"], "U2": p["U2"], "L3": l3, "R": r, "U3": u3, "S": s, "W": w}
        pairs = [
            ("U1", "U3"),
            ("U2", "U3"),
            ("L3", "U3"),
            ("L3", "S"),
            ("U3", "S"),
            ("R", "S"),
            ("L3", "W"),
            ("U3", "W"),
            ("S", "W"),
        ]
        return [np.sum((new[a] - new[b]) ** 2) - np.sum((p[a] - p[b]) ** 2) for a, b in pairs]

    for i in range(5):
        for j in range(3):
            l3 = p["L1"] + Rotation.from_rotvec(axis * bump[i, 0]).apply(p["L3"] - p["L1"])
            guess = np.concatenate([p[k] + l3 - p["L3"] for k in ("U3", "S", "W")])
            found = fsolve(rods, guess, args=(l3, p["R"] + (0, steer[j], 0)), xtol=1e-12).reshape(3, 3)
            for k, name in enumerate(("U3", "S", "W")):
                assert_allclose(motion.position(name, "upright")[i, j], found[k], atol=1e-9)
    linkage.load("W", link="upright", fz=3000.0, fy=500.0)
    linkage.spring("L3", ("ground", "U1"), stiffness=3e4, length=0.5, damping=2e3)
    audit(linkage, lambda t: {"L1": 0.2 * t, "steering": 0.02 * np.sin(t)}, tolerance=1e-7)


@pytest.mark.parametrize("turn", [Rotation.from_euler("x", 90, degrees=True), Rotation.from_rotvec((0.4, -1.1, 0.7))])
def test_spherical_four_bar_in_any_plane(turn):
    """cos of the coupler's arc stays: A cos(psi) + B sin(psi) = C (Chiang, Kinematics of Spherical Mechanisms)."""
    arcs = np.radians([30.0, 70.0, 60.0, 80.0])  # crank, coupler, rocker, ground
    start = np.asarray(0.9)

    def ends(theta):
        b = np.stack(
            [np.cos(arcs[0]) + 0 * theta, np.sin(arcs[0]) * np.cos(theta), np.sin(arcs[0]) * np.sin(theta)], -1
        )
        # D at arcs[3] from A in the x-y plane; C about D
        d = np.array([np.cos(arcs[3]), np.sin(arcs[3]), 0.0])
        u, w = np.array([-np.sin(arcs[3]), np.cos(arcs[3]), 0.0]), np.array([0.0, 0.0, 1.0])
        a1, a2 = np.sin(arcs[2]) * (b @ u), np.sin(arcs[2]) * (b @ w)
        a3 = np.cos(arcs[1]) - np.cos(arcs[2]) * (b @ d)
        psi = np.arctan2(a2, a1) + np.arccos(a3 / np.hypot(a1, a2))
        return (
            b,
            d,
            psi,
            np.cos(arcs[2]) * d + np.sin(arcs[2]) * (np.cos(psi)[..., None] * u + np.sin(psi)[..., None] * w),
        )

    b, d, psi, c = ends(start)
    linkage = Linkage({k: turn.apply(v) for k, v in {"A": (1.0, 0, 0), "B": b, "C": c, "D": d}.items()})
    for name in ("AB", "BC", "CD"):
        linkage.link(name, *name, mass=1.0, inertia=INERTIA)
    hinge = {k: linkage.points[k] for k in "ABCD"}
    linkage.revolute("A", "ground", "AB", axis=hinge["A"], drive=True, reference=start)
    linkage.revolute("B", "AB", "BC", axis=hinge["B"])
    linkage.revolute("C", "BC", "CD", axis=hinge["C"])
    linkage.revolute("D", "ground", "CD", axis=hinge["D"], reference=psi)
    motion = linkage.move(A=start + TURN)
    _, _, wanted, place = ends(start + TURN)
    assert_allclose(motion.coordinate("D")[:, 0], np.unwrap(wanted), atol=1e-12)
    assert_allclose(motion.position("C"), turn.apply(place), atol=1e-12)
    m = linkage.mobility()
    assert (m.actual, m.kutzbach, len(m.redundant)) == (1, -2, 3)
    audit(linkage, lambda t: {"A": start + t})
