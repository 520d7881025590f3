"""Planar linkages of the textbooks: each against its closed form, and against the laws of motion and equilibrium."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.audit import audit, difference

TURN = np.linspace(0.0, 2.0 * np.pi, 49)


def on_two_circles(p, rp, q, rq, side):
    """Corner of a triangle on p q with sides rp and rq, to the left of p q where `side` is 1; complex."""
    d = q - p
    a = (rp**2 - rq**2 + abs(d) ** 2) / (2 * abs(d))
    return p + (a + 1j * side * np.sqrt(rp**2 - a**2 + 0j).real) * d / abs(d)


def xy(values):
    return values[..., 0] + 1j * values[..., 1]


# -- slider-cranks --------------------------------------------------------------------------------------------------


def slider_crank(r, rod, offset, theta, mass=(0.0, 0.0, 0.0), inertia=(0.0, 0.0), centre=0.5):
    b = r * np.exp(1j * theta)
    c = b.real + np.sqrt(rod**2 - (b.imag - offset) ** 2) + 1j * offset
    linkage = Linkage(A=(0, 0), B=(b.real, b.imag), C=(c.real, c.imag))
    g = b + centre * (c - b)
    linkage.link("crank", "A", "B", mass=mass[0], centre=(0, 0), inertia=inertia[0])
    linkage.link("rod", "B", "C", mass=mass[1], centre=(g.real, g.imag), inertia=inertia[1])
    linkage.link("piston", "C", mass=mass[2])
    linkage.revolute("A", "ground", "crank", drive=True, reference=theta)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "piston")
    linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), reference=c.real)
    return linkage


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("offset", [0.0, 0.03, -0.05])
def test_offset_slider_crank_torque_over_a_cycle(offset, size):
    """x = r cos t + sqrt(l^2 - (r sin t - e)^2); torque by d/dt of the kinetic energy and the gas force's power."""
    r, rod, e, omega = 0.1 * size, 0.3 * size, offset * size, 3.0
    m, j, force = (2.0, 1.5, 0.8), 0.02 * size**2, 40.0
    linkage = slider_crank(r, rod, e, 0.4, m, (0.01 * size**2, j), centre=0.35)
    linkage.load("C", link="piston", fx=-force)
    motion = linkage.move(A=TURN, rates={"A": omega})
    y = r * np.sin(TURN) - e
    root = np.sqrt(rod**2 - y**2)
    assert_allclose(motion.position("C")[:, 0], r * np.cos(TURN) + root, rtol=1e-12)
    yd, ydd = r * np.cos(TURN) * omega, -r * np.sin(TURN) * omega**2
    vx = -r * np.sin(TURN) * omega - y * yd / root
    ax = -r * np.cos(TURN) * omega**2 - (yd**2 + y * ydd) / root - (y * yd) ** 2 / root**3
    assert_allclose(motion.velocity("C")[:, 0], vx, atol=1e-12 * size)
    assert_allclose(motion.acceleration("C")[:, 0], ax, atol=1e-11 * size)
    # rod: sin(phi) = -y / l; centre at B + 0.35 (C - B)
    phid = -yd / root
    phidd = -(ydd / root + y * yd**2 / root**3)
    b_v = 1j * omega * r * np.exp(1j * TURN)
    b_a = -(omega**2) * r * np.exp(1j * TURN)
    g_v, g_a = 0.65 * b_v + 0.35 * vx, 0.65 * b_a + 0.35 * ax
    power = m[1] * (g_v.conj() * g_a).real + j * phid * phidd + m[2] * vx * ax + force * vx
    torque = motion.reactions().drive("A")[:, 0]
    assert_allclose(torque, power / omega, rtol=1e-11, atol=1e-12 * np.abs(power).max())
    # the piston's own balance: what the rod gives it
    given = motion.reactions().force("C", "piston")
    assert_allclose(given[:, 0], m[2] * ax + force, rtol=1e-11, atol=1e-11 * np.abs(ax).max() * m[2] + 1e-10)


def test_inverted_slider_crank_like_a_geneva_drive():
    """Slot angle phi = atan2(r sin t, r cos t - d); rate r (r - d cos t) / (r^2 + d^2 - 2 r d cos t)."""
    r, d, start = 1.0, np.sqrt(2.0), 0.3
    b = (r * np.cos(start), r * np.sin(start))
    linkage = Linkage(A=(0, 0), B=b, D=(d, 0))
    linkage.link("driver", "A", "B", mass=1.0)
    linkage.link("die", "B", mass=0.2, inertia=0.01)
    linkage.link("wheel", "D", "B", mass=3.0, inertia=0.5)
    linkage.revolute("A", "ground", "driver", drive=True, reference=start)
    linkage.revolute("B", "driver", "die")
    slot = (b[0] - d, b[1], 0)
    linkage.prismatic("B", "wheel", "die", axis=slot, reference=np.hypot(*slot[:2]))
    linkage.revolute("D", "ground", "wheel", reference=np.arctan2(b[1], b[0] - d))
    motion = linkage.move(A=TURN, rates={"A": 2.0})
    phi = np.unwrap(np.arctan2(r * np.sin(TURN), r * np.cos(TURN) - d))
    assert_allclose(motion.coordinate("D")[:, 0] - phi, 0.0, atol=1e-13)
    squared = r**2 + d**2 - 2 * r * d * np.cos(TURN)
    assert_allclose(motion.coordinate_rate("D")[:, 0], 2.0 * r * (r - d * np.cos(TURN)) / squared, atol=1e-13)
    assert_allclose(motion.coordinate("B.prismatic")[:, 0], np.sqrt(squared), atol=1e-13)
    alpha = 4.0 * r * d * np.sin(TURN) * (d**2 - r**2) / squared**2
    assert_allclose(motion.angular_acceleration("wheel")[:, 2], alpha, atol=1e-12)
    audit(linkage, lambda t: {"A": start + 1.3 * t + t**2})


def test_whitworth_quick_return():
    """Crank r about A, slotted arm about D below it: the ram's stroke and the time ratio (Norton section 3.6)."""
    r, d, arm, rod, height = 0.1, 0.25, 0.5, 0.3, 0.6
    start = 0.2
    b = 1j * d + r * np.exp(1j * start)
    phi = np.angle(b)
    e = arm * np.exp(1j * phi)
    f = e.real + np.sqrt(rod**2 - (height - e.imag) ** 2) + 1j * height
    pts = {"D": 0j, "A": 1j * d, "B": b, "E": e, "F": f}
    linkage = Linkage({k: (z.real, z.imag) for k, z in pts.items()})
    linkage.link("crank", "A", "B", mass=1.0, inertia=0.01)
    linkage.link("block", "B", mass=0.3)
    linkage.link("arm", "D", "B", "E", mass=2.0, centre=(0.5 * e.real, 0.5 * e.imag), inertia=0.05)
    linkage.link("rod", "E", "F", mass=0.5, inertia=0.003)
    linkage.link("ram", "F", mass=4.0)
    linkage.revolute("A", "ground", "crank", drive=True, reference=start)
    linkage.revolute("B", "crank", "block")
    linkage.prismatic("B", "arm", "block", axis=(b.real, b.imag, 0))
    linkage.revolute("D", "ground", "arm", reference=phi)
    linkage.revolute("E", "arm", "rod")
    linkage.revolute("F", "rod", "ram")
    linkage.prismatic("F", "ground", "ram", axis=(1, 0, 0))
    linkage.gravity((0, -9.81))
    linkage.load("F", link="ram", fx=-100.0)
    motion = linkage.move(A=start - TURN * 2)  # two turns, backwards
    angle = np.angle(1j * d + r * np.exp(1j * (start - 2 * TURN)))
    assert_allclose(motion.coordinate("D")[:, 0], angle, atol=1e-13)
    ends = arm * np.exp(1j * angle)
    ram = ends.real + np.sqrt(rod**2 - (height - ends.imag) ** 2)
    assert_allclose(motion.position("F")[:, 0], ram, atol=1e-13)
    audit(linkage, lambda t: {"A": start + 5 * t})


def test_scotch_yoke_and_elliptic_trammel():
    yoke = Linkage(A=(0, 0), B=(0.06, 0.08), C=(0.4, 0.0))
    yoke.link("crank", "A", "B", mass=1.0, inertia=0.02)
    yoke.link("block", "B", mass=0.1)
    yoke.link("yoke", "B", "C", mass=2.0)
    start = np.arctan2(0.08, 0.06)
    yoke.revolute("A", "ground", "crank", drive=True, reference=start)
    yoke.revolute("B", "crank", "block")
    yoke.prismatic("B", "yoke", "block", axis=(0, 1, 0))
    yoke.prismatic("C", "ground", "yoke", axis=(1, 0, 0))
    motion = yoke.move(A=TURN, rates={"A": 4.0})
    assert_allclose(motion.position("C")[:, 0], 0.34 + 0.1 * np.cos(TURN), atol=1e-14)
    assert_allclose(motion.acceleration("C")[:, 0], -1.6 * np.cos(TURN), atol=1e-13)
    # block and crank turn at constant speed: only the yoke speeds up
    torque = 2.0 * 1.6 * np.cos(TURN) * 0.1 * np.sin(TURN)
    assert_allclose(motion.reactions().drive("A")[:, 0], torque, atol=1e-13)
    audit(yoke, lambda t: {"A": start + 2 * t})

    a, b, start = 0.3, 0.5, 0.6
    trammel = Linkage(
        X=(a * np.cos(start), 0), Y=(0, a * np.sin(start)), P=(-b * np.cos(start), (a + b) * np.sin(start))
    )
    trammel.link("rod", "X", "Y", "P", mass=1.0, inertia=0.1)
    trammel.link("x block", "X", mass=0.5)
    trammel.link("y block", "Y", mass=0.5)
    trammel.prismatic("X", "ground", "x block", axis=(1, 0, 0), name="x")
    trammel.prismatic("Y", "ground", "y block", axis=(0, 1, 0), name="y")
    trammel.revolute("X", "x block", "rod", drive=True, reference=-start)
    trammel.revolute("Y", "y block", "rod")
    motion = trammel.move(X=-TURN)  # drives a coupler, through the ends of both slides
    for k, status in enumerate(motion.status):
        still = {0: "X", 12: "Y"}.get(k % 24)
        assert status == (f"singular (inverse-kinematic, type I; joint {still} is stationary)" if still else "regular")
    assert_allclose(motion.position("X")[:, 0], a * np.cos(TURN), atol=1e-14)
    p = motion.position("P")
    assert_allclose((p[:, 0] / b) ** 2 + (p[:, 1] / (a + b)) ** 2, 1.0, atol=1e-13)
    audit(trammel, lambda t: {"X": -start - 2 * t})


# -- exact straight lines -------------------------------------------------------------------------------------------


def peaucellier(start, a=0.5, long=1.0, short=0.4):
    """Crank a about A with OA = a: Q goes along the line x = (long^2 - short^2) / (2 a)."""
    p = a + a * np.exp(1j * start)
    unit = p / abs(p)
    half = (abs(p) + (long**2 - short**2) / abs(p)) / 2
    r = half * unit + 1j * unit * np.sqrt(long**2 - half**2)
    s = half * unit - 1j * unit * np.sqrt(long**2 - half**2)
    q = (long**2 - short**2) / abs(p) * unit
    pts = {"O": 0j, "A": complex(a), "P": p, "R": r, "S": s, "Q": q}
    linkage = Linkage({k: (z.real, z.imag) for k, z in pts.items()})
    for name, ends in {"crank": "AP", "OR": "OR", "OS": "OS", "PR": "PR", "PS": "PS", "QR": "QR", "QS": "QS"}.items():
        linkage.link(name, *ends, mass=1.0, inertia=0.05)
    linkage.revolute("A", "ground", "crank", drive=True, reference=start)
    linkage.revolute("O", "ground", "OR", "OS")
    linkage.revolute("P", "crank", "PR", "PS")
    linkage.revolute("R", "OR", "PR", "QR")
    linkage.revolute("S", "OS", "PS", "QS")
    linkage.revolute("Q", "QR", "QS")
    linkage.gravity((0, -9.81))
    return linkage


def test_peaucellier_draws_an_exact_line():
    linkage = peaucellier(0.3)
    theta = np.linspace(-1.0, 1.0, 41)
    motion = linkage.move(A=theta, rates={"A": 1.0})
    q = motion.position("Q")
    assert_allclose(q[:, 0], 0.84, atol=1e-14)
    assert_allclose(q[:, 1], 0.84 * np.tan(theta / 2), atol=1e-13)
    # at the ends all lie nearly in line, conditioning 2e-3, whose square takes digits from accelerations
    assert_allclose(motion.acceleration("Q")[:, 0], 0.0, atol=3e-11)
    assert linkage.mobility().actual == 1
    audit(linkage, lambda t: {"A": t})


def test_peaucellier_goes_as_far_as_it_reaches():
    """Arms in line where |OP| = long - short, that is 2 a cos(t / 2) = 0.6."""
    linkage = peaucellier(0.3)
    limits = linkage.drive_range("A")
    end = 2 * np.arccos(0.6)
    assert_allclose((limits.lower, limits.upper), (-end, end), atol=1e-10)


# -- six-bars and legs ----------------------------------------------------------------------------------------------


def dyads(start, recipe, fixed, crank, radius):
    """Points built one after the other from two circles; a drawing and, for any angle, its own solution."""

    def solve(theta):
        z = {k: np.full(np.shape(theta), v, dtype=complex) for k, v in fixed.items()}
        z[crank[1]] = z[crank[0]] + radius * np.exp(1j * np.asarray(theta))
        for name, p, rp, q, rq, side in recipe:
            z[name] = on_two_circles(z[p], rp, z[q], rq, side)
        return z

    return solve, {k: (complex(v).real, complex(v).imag) for k, v in solve(start).items()}


JANSEN = (
    ("J", "C", 50.0, "O", 41.5, 1),
    ("K", "C", 61.9, "O", 39.3, -1),
    ("L", "J", 55.8, "O", 40.1, 1),
    ("M", "L", 39.4, "K", 36.7, 1),
    ("F", "M", 65.7, "K", 49.0, 1),
)


def test_jansen_leg():
    """Theo Jansen's eleven holy numbers: a = 38, l = 7.8, m = 15, b = 41.5, c = 39.3, ..."""
    solve, points = dyads(0.4, JANSEN, {"O": 0j, "A": 38 + 7.8j}, "AC", 15.0)
    linkage = Linkage(points)
    linkage.link("crank", "A", "C", mass=0.1, inertia=2.0)
    linkage.link("j", "C", "J", mass=0.1, inertia=5.0)
    linkage.link("k", "C", "K", mass=0.1, inertia=5.0)
    linkage.link("upper", "O", "J", "L", mass=0.3, inertia=20.0)
    linkage.link("c", "O", "K", mass=0.1, inertia=3.0)
    linkage.link("f", "L", "M", mass=0.1, inertia=4.0)
    linkage.link("foot", "M", "K", "F", mass=0.4, inertia=90.0)
    linkage.revolute("A", "ground", "crank", drive=True, reference=0.4)
    linkage.revolute("C", "crank", "j", "k")
    linkage.revolute("O", "ground", "upper", "c")
    linkage.revolute("J", "j", "upper")
    linkage.revolute("K", "k", "c", "foot")
    linkage.revolute("L", "upper", "f")
    linkage.revolute("M", "f", "foot")
    linkage.gravity((0, -9810.0))
    motion = linkage.move(A=TURN)
    wanted = solve(TURN)
    for name in "JKLMF":
        assert_allclose(xy(motion.position(name)), wanted[name], atol=1e-11, err_msg=name)
    assert np.all(motion.status == "regular")
    audit(linkage, lambda t: {"A": 0.4 + t})


@pytest.mark.parametrize("which", ["Watt I", "Watt II", "Stephenson I"])
def test_six_bars_of_dyads(which):
    fixed = {"A": 0j, "D": 4 + 0j, "H": 7.5 + 0.5j}
    four = ("C", "B", 3.4, "D", 3.0, 1)
    recipes = {
        # E on the coupler, F on the rocker, a dyad between them
        "Watt I": (four, ("E", "B", 2.0, "C", 2.2, 1), ("F", "C", 1.5, "D", 2.2, 1), ("P", "E", 2.5, "F", 2.0, 1)),
        # a second four-bar from the rocker
        "Watt II": (four, ("F", "C", 1.5, "D", 2.2, -1), ("P", "F", 4.5, "H", 4.0, 1)),
        # a dyad between crank's far point and the rocker's point
        "Stephenson I": (
            four,
            ("E", "A", 1.2, "B", 0.9, 1),
            ("F", "C", 1.5, "D", 2.2, 1),
            ("P", "E", 4.5, "F", 2.0, 1),
        ),
    }
    solve, points = dyads(0.7, recipes[which], fixed, "AB", 1.0)
    linkage = Linkage(points)
    names = {
        "Watt I": (["AB", "BCE", "CDF", "EP", "FP"], [("E", "BCE", "EP"), ("F", "CDF", "FP"), ("P", "EP", "FP")]),
        "Watt II": (["AB", "BC", "CDF", "FP", "HP"], [("F", "CDF", "FP"), ("P", "FP", "HP"), ("H", "ground", "HP")]),
        "Stephenson I": (["ABE", "BC", "CDF", "EP", "FP"], [("E", "ABE", "EP"), ("F", "CDF", "FP"), ("P", "EP", "FP")]),
    }[which]
    for name in names[0]:
        linkage.link(name, *name, mass=1.0, inertia=0.3)
    crank, coupler, rocker = names[0][:3]
    linkage.revolute("A", "ground", crank, drive=True, reference=0.7)
    linkage.revolute("B", crank, coupler)
    linkage.revolute("C", coupler, rocker)
    linkage.revolute("D", "ground", rocker)
    for joint, *links in names[1]:
        linkage.revolute(joint, *links)
    linkage.gravity((0, -9.81))
    motion = linkage.move(A=0.7 + TURN)
    wanted = solve(0.7 + TURN)
    for name in points:
        if name in {p for link in names[0] for p in link}:
            assert_allclose(xy(motion.position(name)), wanted[name], atol=1e-11, err_msg=name)
    audit(linkage, lambda t: {"A": 0.7 - t})


def test_pantograph_magnifies_and_takes_two_drives():
    """Parallelogram pantograph: the pen is the image of the tracer, which is driven in x and y by two slides."""
    o, n = 0j, 2.5
    tracer = 1.0 + 0.4j
    b = on_two_circles(o, 1.2, tracer, 1.0, 1)
    pen = n * tracer
    c, e = n * b, tracer + (n - 1) * b  # a parallelogram with b and the tracer
    pts = {"O": o, "B": b, "T": tracer, "C": c, "E": e, "P": pen}
    linkage = Linkage({k: (complex(z).real, complex(z).imag) for k, z in pts.items()})
    linkage.link("long", "O", "B", "C", mass=1.0, inertia=0.3)
    linkage.link("arm", "C", "E", "P", mass=1.0, inertia=0.3)
    linkage.link("short", "B", "T", mass=0.5, inertia=0.1)
    linkage.link("side", "T", "E", mass=0.5, inertia=0.1)
    linkage.link("carriage", "T", mass=0.2)
    linkage.link("block", "T", mass=0.1)
    linkage.revolute("O", "ground", "long")
    linkage.revolute("B", "long", "short")
    linkage.revolute("C", "long", "arm")
    linkage.revolute("E", "arm", "side")
    linkage.prismatic("T", "ground", "carriage", axis=(1, 0, 0), drive=True, name="x", reference=tracer.real)
    linkage.prismatic("T", "carriage", "block", axis=(0, 1, 0), drive=True, name="y", reference=tracer.imag)
    linkage.revolute("T", "block", "short", "side")
    t = np.linspace(0, 2 * np.pi, 31)
    x, y = 1.0 + 0.2 * np.sin(2 * t), 0.4 + 0.3 * np.sin(3 * t)
    motion = linkage.move(x=x, y=y)
    assert_allclose(xy(motion.position("P")), n * (x + 1j * y), atol=1e-13)
    grid = linkage.move(x=np.linspace(0.8, 1.2, 5)[:, None], y=np.linspace(0.1, 0.7, 6))
    assert grid.shape == (5, 6)
    assert_allclose(grid.position("P")[..., 1], n * np.broadcast_to(np.linspace(0.1, 0.7, 6), (5, 6)), atol=1e-13)
    linkage.load("P", fx=3.0, fy=-2.0)
    pull = linkage.move(x=1.1, y=0.2).reactions()
    assert_allclose((pull.drive("x"), pull.drive("y")), [[-3.0 * n], [2.0 * n]], rtol=1e-12)
    audit(linkage, lambda t: {"x": 1.0 + 0.2 * np.sin(t), "y": 0.4 + 0.1 * t})


def test_oldham_coupling_turns_evenly_and_its_cross_runs_round():
    d = 0.05
    linkage = Linkage(A=(0, 0), B=(d, 0), M=(d / 2, d / 2))
    linkage.link("input", "A", "M", mass=1.0, inertia=0.01)
    linkage.link("cross", "M", mass=0.5, inertia=0.005)
    linkage.link("output", "B", "M", mass=1.0, inertia=0.01)
    linkage.revolute("A", "ground", "input", drive=True)
    linkage.prismatic("M", "input", "cross", axis=(1, 1, 0), name="in slot")
    linkage.prismatic("M", "cross", "output", axis=(1, -1, 0), name="out slot")
    linkage.revolute("B", "ground", "output")
    linkage.torque("output", mz=-7.0)
    motion = linkage.move(A=TURN, rates={"A": 10.0})
    assert_allclose(motion.coordinate("B")[:, 0], TURN, atol=1e-13)
    middle = motion.position("M", "cross")[:, :2] - (d / 2, 0)
    assert_allclose(np.hypot(*middle.T), d / 2, rtol=1e-12)
    v = motion.velocity("M", "cross")
    assert_allclose(np.hypot(v[:, 0], v[:, 1]), 10.0 * d, rtol=1e-11)
    torque = motion.reactions().drive("A")[:, 0]
    assert_allclose(torque, 7.0, rtol=1e-9)  # nothing speeds up
    audit(linkage, lambda t: {"A": t})


# -- difference of the drive ----------------------------------------------------------------------------------------


def test_driven_at_the_coupler_and_at_the_rocker():
    """The same motion whichever joint drives."""
    points = {"A": (0.0, 0.0), "B": (1.0, 1.5), "C": (4.5, 3.0), "D": (4.0, 0.0)}

    def drawn(driven):
        linkage = Linkage(points)
        for name in ("AB", "BC", "CD"):
            linkage.link(name, *name, mass=1.0)
        for joint, links in {
            "A": ("ground", "AB"),
            "B": ("AB", "BC"),
            "C": ("BC", "CD"),
            "D": ("CD", "ground"),
        }.items():
            linkage.revolute(joint, *links, drive=joint == driven)
        return linkage

    base = drawn("A").move(A=np.linspace(0, 0.4, 9), rates={"A": 1.0}, accelerations={"A": 0.5})
    for joint in "BCD":
        value, rate = base.coordinate(joint)[:, 0], base.coordinate_rate(joint)[:, 0]
        bend = base.coordinate_acceleration(joint)[:, 0]
        other = drawn(joint).move({joint: value}, rates={joint: rate}, accelerations={joint: bend})
        for point in "BC":
            assert_allclose(other.position(point), base.position(point), atol=1e-13)
            assert_allclose(other.velocity(point), base.velocity(point), atol=1e-12)
            assert_allclose(other.acceleration(point), base.acceleration(point), atol=1e-11)
        power = [m.reactions().drive(j)[:, 0] * m.coordinate_rate(j)[:, 0] for m, j in ((base, "A"), (other, joint))]
        assert_allclose(power[0], power[1], atol=1e-11)
        audit(drawn(joint), lambda t, joint=joint: {joint: 0.2 * t})


def test_differences_of_the_audit_see_an_error():
    t = 0.1 * np.arange(-2, 3)
    assert abs(difference(t**3, 0.1)) < 1e-15
    assert abs(difference(t**3 + t, 0.1) - 1.0) < 1e-14


def test_three_cognates_draw_one_curve_together():
    """Roberts 1875: with (P - A) / (B - A) the same in all couplers; by count the ten bars cannot move."""
    oa, ob, a, b, p = 0j, 5 + 0j, 1.2 + 1.5j, 4.1 + 2.6j, 2.0 + 3.9j
    share = (p - a) / (b - a)
    d, f = oa + p - a, ob + p - b
    places = {"O": oa, "Q": ob, "R": oa + share * (ob - oa), "A": a, "B": b, "P": p, "D": d, "F": f}
    places |= {"E": d + share * (p - d), "G": p + share * (f - p)}
    linkage = Linkage({name: (z.real, z.imag) for name, z in places.items()})
    for points in ("OA", "QB", "ABP", "OD", "RE", "DEP", "QF", "RG", "FGP"):
        linkage.link(points, *points)
    linkage.revolute("O", "ground", "OA", drive=True)
    for point, first, second in (
        ("A", "OA", "ABP"), ("B", "ABP", "QB"), ("Q", "ground", "QB"),
        ("O", "ground", "OD"), ("D", "OD", "DEP"), ("E", "DEP", "RE"), ("R", "ground", "RE"), ("P", "ABP", "DEP"),
        ("Q", "ground", "QF"), ("F", "QF", "FGP"), ("G", "FGP", "RG"), ("R", "ground", "RG"), ("P", "ABP", "FGP"),
    ):  # fmt: skip
        linkage.revolute(point, first, second, name=f"{point} of {second}")
    assert (linkage.mobility().actual, linkage.mobility().kutzbach) == (1, -1)
    motion = linkage.move(O=np.linspace(-0.4, 0.4, 9))
    turned = oa + (a - oa) * np.exp(1j * np.linspace(-0.4, 0.4, 9))
    # B on a circle about A and one about Q, on the side on which it is drawn
    apart, long, short = abs(ob - turned), abs(b - a), abs(b - ob)
    along = (long**2 - short**2 + apart**2) / (2.0 * apart)
    across = np.sign(((b - a) / (ob - a)).imag) * np.sqrt(long**2 - along**2)
    other = turned + (along + 1j * across) * (ob - turned) / apart
    wanted = turned + share * (other - turned)
    for link in ("ABP", "DEP", "FGP"):
        found = motion.position("P", link)
        assert_allclose(found[:, 0] + 1j * found[:, 1], wanted, atol=1e-13)
