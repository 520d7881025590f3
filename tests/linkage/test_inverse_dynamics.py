"""Inverse dynamics of robots: published numbers, and the equations of Lagrange, Newton and Euler written out here."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
G = 9.81


# -- the PUMA 560 -----------------------------------------------------------------------------------------------------

# Denavit and Hartenberg: offset, length, twist; mass, centre and principal inertia of each link in its own axes
# (Armstrong, Khatib and Burdick 1986, as in Corke, Robotics, Vision and Control, 2011, chapter 9).
QUARTER = np.pi / 2
PUMA = [
    ((0.0, 0.0, QUARTER), 0.0, (0, 0, 0), (0, 0.35, 0)),
    ((0.0, 0.4318, 0.0), 17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539)),
    ((0.15005, 0.0203, -QUARTER), 4.8, (-0.0203, -0.0141, 0.070), (0.066, 0.086, 0.0125)),
    ((0.4318, 0.0, QUARTER), 0.82, (0, 0.019, 0), (1.8e-3, 1.3e-3, 1.8e-3)),
    ((0.0, 0.0, -QUARTER), 0.34, (0, 0, 0), (0.3e-3, 0.4e-3, 0.3e-3)),
    ((0.0, 0.0, 0.0), 0.09, (0, 0, 0.032), (0.15e-3, 0.15e-3, 0.04e-3)),
]
NOMINAL = np.array([0.0, np.pi / 4, np.pi, 0.0, np.pi / 4, 0.0])
# Motors: inertia times gear ratio squared, which the published inertia contains.
MOTORS = np.array([200e-6] * 3 + [33e-6] * 3) * np.array([62.6111, 107.815, 53.7063, 76.0364, 71.923, 76.686]) ** 2
# Printed in the book to four decimals, at the nominal pose.
WEIGHT = [0.0, 31.6399, 6.0351, 0.0, 0.0283, 0.0]
CENTRIFUGAL = [0.6280, -0.3607, -0.0003, 0.0, 0.0]  # of joints 2 to 6, at one radian a second of joint 1
INERTIA = np.array(
    [
        [3.6594, -0.4044, 0.1006, -0.0025, 0.0, 0.0],
        [-0.4044, 4.4137, 0.3509, 0.0, 0.0024, 0.0],
        [0.1006, 0.3509, 0.9378, 0.0, 0.0015, 0.0],
        [-0.0025, 0.0, 0.0, 0.1925, 0.0, 0.0],
        [0.0, 0.0024, 0.0015, 0.0, 0.1713, 0.0],
        [0.0, 0.0, 0.0, 0.0, 0.0, 0.1941],
    ]
)


def puma(drawn: Array) -> Linkage:
    """The robot, drawn at some joint angles; its tensors of inertia are turned into the drawing."""
    linkage, turn, place, before, axis = Linkage(J0=(0, 0, 0)), np.eye(3), np.zeros(3), "ground", np.array([0, 0, 1.0])
    for k, ((offset, length, twist), mass, centre, inertia) in enumerate(PUMA):
        turn = turn @ Rotation.from_euler("z", drawn[k]).as_matrix()
        place = place + turn @ (length, 0.0, offset)
        turn = turn @ Rotation.from_euler("x", twist).as_matrix()
        linkage.point(f"J{k + 1}", place)
        own = {"mass": mass, "centre": place + turn @ centre, "inertia": turn @ np.diag(inertia) @ turn.T}
        linkage.link(f"link {k + 1}", f"J{k}", f"J{k + 1}", **own)
        linkage.revolute(f"J{k}", before, f"link {k + 1}", axis=axis, reference=drawn[k], drive=True)
        before, axis = f"link {k + 1}", turn[:, 2]
    return linkage


@pytest.mark.parametrize("drawn", [np.zeros(6), np.array([0.1, 0.2, -0.3, 0.4, 0.5, 0.6])])
def test_puma_560_of_corke(drawn: Array) -> None:
    linkage = puma(drawn)
    pose = {f"J{k}": NOMINAL[k] for k in range(6)}

    def torques(**given: dict[str, Array]) -> Array:
        found = linkage.move(pose, **given).reactions()
        return np.stack([found.drive(f"J{k}")[..., 0] for k in range(6)], axis=-1)

    assert_allclose(torques(rates={"J0": np.ones(())})[1:], CENTRIFUGAL, atol=6e-5)
    unit = {f"J{k}": np.eye(6)[k] for k in range(6)}
    assert_allclose(torques(accelerations=unit) + np.diag(MOTORS), INERTIA, atol=6e-5)
    linkage.gravity((0, 0, -G))
    assert_allclose(torques(), WEIGHT, atol=6e-5)


# -- chains of any joints, by Lagrange --------------------------------------------------------------------------------

FREEDOM = {"revolute": 1, "prismatic": 1, "screw": 1, "cylindrical": 2, "universal": 2, "planar": 3}
PITCH = 0.7


def about(axis: Array, angle: complex) -> NDArray[np.complex128]:
    """Rodrigues' formula, for complex angles too."""
    cross = np.cross(np.eye(3), axis)
    return np.asarray(np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross)


class Chain:
    """An open chain of random links joined by the given kinds of joints, loaded at its end."""

    def __init__(self, kinds: tuple[str, ...], seed: int) -> None:
        rng, n = np.random.default_rng(seed), len(kinds)
        self.kinds, self.sizes = kinds, [FREEDOM[kind] for kind in kinds]
        self.places, self.centres = rng.normal(size=(n + 1, 3)), rng.normal(size=(n, 3))
        self.axes = [np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in kinds]
        self.masses = rng.uniform(0.5, 3.0, n)
        roots = rng.normal(size=(n, 3, 3))
        self.tensors = 0.1 * roots @ np.swapaxes(roots, -1, -2)
        self.gravity, self.load = rng.normal(size=3), rng.normal(size=6)
        self.q, self.rates, self.gains = 0.7 * rng.normal(size=(3, sum(self.sizes)))

    def linkage(self) -> Linkage:
        linkage = Linkage({f"P {k}": place for k, place in enumerate(self.places)})
        before = "ground"
        for k, kind in enumerate(self.kinds):
            name, more = f"arm {k}", {"universal": {"second": self.axes[k][:, 0]}, "screw": {"pitch": PITCH}}
            given = {"mass": self.masses[k], "centre": self.centres[k], "inertia": self.tensors[k]}
            linkage.link(name, f"P {k}", f"P {k + 1}", **given)
            getattr(linkage, kind)(f"P {k}", before, name, axis=self.axes[k][:, 2], drive=True, **more.get(kind, {}))
            before = name
        linkage.gravity(self.gravity)
        linkage.load(f"P {len(self.kinds)}", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), self.load, strict=True)))
        return linkage

    def steps(self, k: int, q: Array) -> list[tuple[Array, complex, complex]]:
        """Axis, advance and turn of the single motions of which a joint's is made."""
        x, _, z = self.axes[k].T
        near = np.eye(3)[int(abs(z[0]) > 0.9)]
        across = (near - near @ z * z) / np.linalg.norm(near - near @ z * z)
        return {
            "revolute": lambda: [(z, 0.0, q[0])],
            "prismatic": lambda: [(z, q[0], 0.0)],
            "screw": lambda: [(z, PITCH * q[0] / (2.0 * np.pi), q[0])],
            "cylindrical": lambda: [(z, q[0], q[1])],
            "universal": lambda: [(z, 0.0, q[0]), (x, 0.0, q[1])],
            "planar": lambda: [(across, q[0], 0.0), (np.cross(z, across), q[1], 0.0), (z, 0.0, q[2])],
        }[self.kinds[k]]()

    def poses(self, q: Array) -> list[tuple[Array, Array]]:
        """Turn and origin of each link."""
        turn, origin, out, at = np.eye(3), np.zeros(3), [], 0
        for k, size in enumerate(self.sizes):
            for axis, advance, angle in self.steps(k, q[at : at + size]):
                origin = origin + turn @ (axis * advance + self.places[k] - about(axis, angle) @ self.places[k])
                turn = turn @ about(axis, angle)
            at += size
            out.append((turn, origin))
        return out

    def jacobians(self, q: Array) -> list[tuple[Array, Array, Array]]:
        """Of each link: turn, and by the coordinates its angular velocity (3, n) and its pose's rate (n, 3, 4)."""
        step = 1e-30
        tilted = [self.poses(q + 1j * step * unit) for unit in np.eye(len(q))]
        out = []
        for k, (turn, _) in enumerate(self.poses(q)):
            rates = np.array([np.column_stack(tilt[k]).imag / step for tilt in tilted])
            spin = rates[:, :, :3] @ turn.T
            out.append((turn, np.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]]), rates))
        return out

    def mass_matrix(self, q: Array) -> Array:
        total = np.zeros((len(q), len(q)))
        for k, (turn, spin, rates) in enumerate(self.jacobians(q)):
            v = rates[:, :, :3] @ self.centres[k] + rates[:, :, 3]
            total += self.masses[k] * v @ v.T + spin.T @ turn @ self.tensors[k] @ turn.T @ spin
        return total

    def applied(self, q: Array) -> Array:
        """Generalized forces of the weights, and of the load at the end."""
        each = self.jacobians(q)
        force = sum(
            m * (rates[:, :, :3] @ c + rates[:, :, 3]) @ self.gravity
            for m, c, (_, _, rates) in zip(self.masses, self.centres, each, strict=True)
        )
        _, spin, rates = each[-1]
        end = rates[:, :, :3] @ self.places[-1] + rates[:, :, 3]
        return np.asarray(force + end @ self.load[:3] + spin.T @ self.load[3:])

    def drive_forces(self) -> Array:
        """d/dt (M q') - 1/2 q' dM/dq q' - applied forces; derivatives of M by central differences."""
        h = 1e-3
        slope = [derivative(lambda t, u=unit: self.mass_matrix(self.q + t * u), h) for unit in np.eye(len(self.q))]
        change = np.einsum("k,kij->ij", self.rates, slope)
        energy = 0.5 * np.einsum("i,kij,j->k", self.rates, slope, self.rates)
        inertia = self.mass_matrix(self.q) @ self.gains + change @ self.rates - energy
        return np.asarray(inertia - self.applied(self.q))

    def split(self, values: Array) -> dict[str, Array]:
        parts = np.split(values, np.cumsum(self.sizes)[:-1])
        return {f"P {k}": part if len(part) > 1 else part[0] for k, part in enumerate(parts)}


def derivative(of: Callable[[float], Array], h: float) -> Array:
    """At zero, to the sixth order."""
    each = [of(k * h) - of(-k * h) for k in (1, 2, 3)]
    return np.asarray((45.0 * each[0] - 9.0 * each[1] + each[2]) / (60.0 * h))


@pytest.mark.parametrize(
    "kinds",
    [
        ("revolute",) * 3,
        ("revolute", "revolute", "prismatic", "revolute", "revolute", "revolute"),
        ("revolute", "revolute", "cylindrical"),
        ("universal", "prismatic", "universal"),
        ("planar", "revolute", "screw"),
        ("cylindrical", "universal", "planar", "prismatic"),
    ],
    ids=["RRR", "Stanford", "SCARA", "UPU", "ERH", "CUEP"],
)
def test_open_chains_by_lagrange(kinds: tuple[str, ...]) -> None:
    chain = Chain(kinds, seed=len(kinds))
    rates, gains = chain.split(chain.rates), chain.split(chain.gains)
    motion = chain.linkage().move(chain.split(chain.q), rates=rates, accelerations=gains)
    found = motion.reactions()
    forces = np.concatenate([found.drive(f"P {k}") for k in range(len(kinds))])
    wanted = chain.drive_forces()
    assert_allclose(forces, wanted, atol=1e-9 * np.abs(wanted).max())
    assert found.method == "determinate"
    for k, (turn, origin) in enumerate(chain.poses(chain.q)):
        assert_allclose(motion.axes(f"arm {k}"), turn, atol=1e-14)
        assert_allclose(motion.origin(f"arm {k}"), origin, atol=1e-13)


# -- parallel robots, by the power of their platform ------------------------------------------------------------------


def test_three_rrr_by_virtual_power() -> None:
    """The platform of a planar robot on a circle; its arms have no mass, the drives follow from its equilibrium."""
    base = np.array([0.0, 1.0, 0.5 + 0.5j * np.sqrt(3.0)])
    corners, arm, mass, inertia = 0.2 * np.exp(1j * np.radians([210, 330, 90])), 0.4, 3.0, 0.05

    def path(t: Array) -> Array:
        return np.stack([0.5 + 0.05 * np.sin(t), 0.3 + 0.04 * np.cos(2 * t), 0.2 * np.sin(t)])

    def drives(x: Array) -> Array:
        reach = x[0] + 1j * x[1] + corners[:, None] * np.exp(1j * x[2]) - base[:, None]
        return np.asarray(np.angle(reach) + np.arccos(0.5 * np.abs(reach) / arm))

    first = path(np.zeros(1))
    elbows = base + arm * np.exp(1j * drives(first)[:, 0])
    tops = complex(*first[:2, 0]) + corners
    linkage = Linkage(G=first[:2, 0])
    linkage_points = {f"{n}{k}": z for n, zs in (("A", base), ("B", elbows), ("C", tops)) for k, z in enumerate(zs)}
    for name, z in linkage_points.items():
        linkage.point(name, (z.real, z.imag))
    linkage.link("platform", "G", "C0", "C1", "C2", mass=mass, inertia=inertia, centre=first[:2, 0])
    for k in range(3):
        linkage.link(f"upper {k}", f"A{k}", f"B{k}")
        linkage.link(f"lower {k}", f"B{k}", f"C{k}")
        linkage.revolute(f"A{k}", "ground", f"upper {k}", drive=True, reference=drives(first)[k, 0])
        linkage.revolute(f"B{k}", f"upper {k}", f"lower {k}")
        linkage.revolute(f"C{k}", f"lower {k}", "platform")
    linkage.gravity((0, -G))
    linkage.torque("platform", mz=0.7)
    t, h = np.linspace(0.0, 6.0, 13), 1e-3
    turn = [drives(path(t + k * h)) for k in range(-3, 4)]
    rates = derivative(lambda s: drives(path(t + s)), h)
    gains = (
        (2 * (turn[0] + turn[6]) - 27 * (turn[1] + turn[5]) + 270 * (turn[2] + turn[4]) - 490 * turn[3]) / 180 / h**2
    )
    given = [{f"A{k}": values[k] for k in range(3)} for values in (turn[3], rates, gains)]
    motion = linkage.move(given[0], rates=given[1], accelerations=given[2])
    assert_allclose(motion.position("G")[:, :2].T, path(t)[:2], atol=1e-13)
    bend = np.stack([-0.05 * np.sin(t), -0.16 * np.cos(2 * t), -0.2 * np.sin(t)])
    needed = np.stack([mass * bend[0], mass * (bend[1] + G), inertia * bend[2] - 0.7])
    back = [derivative(lambda s, u=unit: drives(path(t) + s * u[:, None]), h) for unit in np.eye(3)]
    forces = np.linalg.solve(np.moveaxis(np.array(back), -1, 0), needed.T[..., None])[..., 0]
    reactions = motion.reactions()
    assert_allclose(np.stack([reactions.drive(f"A{k}")[:, 0] for k in range(3)], -1), forces, rtol=1e-7, atol=1e-7)


def test_stewart_platform_with_heavy_legs() -> None:
    """Newton and Euler for platform, cylinders and rods by hand (Dasgupta and Mruthyunjaya 1998); thin legs."""
    low, high = (
        r * np.exp(1j * np.radians(a))
        for r, a in ((1.2, (0, 20, 120, 140, 240, 260)), (0.7, (-40, 60, 80, 180, 200, 300)))
    )
    feet, heads = (np.stack([z.real, z.imag, 0 * z.real], axis=-1) for z in (low, high))
    mass, centre = 5.0, np.array([0.05, -0.02, 0.06])
    inertia = np.array([[0.32, 0.02, 0.0], [0.02, 0.42, 0.03], [0.0, 0.03, 0.6]])
    cylinder, rod, low_centre, top_centre, spin_low, spin_top = 1.5, 0.8, 0.3, 0.25, 0.04, 0.02
    gravity, push = np.array([0.5, 0.0, -G]), np.array([10.0, -20.0, 30.0, 1.0, 2.0, -3.0])

    def turn(t: float) -> Array:
        return Rotation.from_euler("xyz", [0.2 * np.sin(t), 0.15 * np.cos(t), 0.3 * np.sin(1.5 * t)]).as_matrix()

    def place(t: float) -> Array:
        return np.array([0.1 * np.sin(t), 0.12 * np.cos(1.3 * t), 1.1 + 0.1 * np.sin(2.0 * t)])

    def legs(t: float) -> Array:
        return np.asarray(place(t) + heads @ turn(t).T - feet)

    def units(t: float) -> Array:
        return np.asarray(legs(t) / np.linalg.norm(legs(t), axis=1)[:, None])

    def twice(of: Callable[[float], Array], t: float, h: float = 5e-3) -> tuple[Array, Array]:
        v = [of(t + k * h) for k in range(-4, 5)]
        weights = np.array([-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9]) / 5040 / h**2
        first = np.array([3, -32, 168, -672, 0, 672, -168, 32, -3]) / 840 / h
        return np.tensordot(first, v, 1), np.tensordot(weights, v, 1)

    start, t = 0.4, 1.7
    along, tops = units(start), feet + legs(start)
    linkage = Linkage({f"B{k}": feet[k] for k in range(6)} | {f"P{k}": tops[k] for k in range(6)}, tool=place(start))
    own = {
        "mass": mass,
        "centre": place(start) + turn(start) @ centre,
        "inertia": turn(start) @ inertia @ turn(start).T,
    }
    linkage.link("platform", *(f"P{k}" for k in range(6)), "tool", **own)
    for k, axis in enumerate(along):
        thin = np.eye(3) - np.outer(axis, axis)
        linkage.link(
            f"cylinder {k}", f"B{k}", mass=cylinder, centre=feet[k] + low_centre * axis, inertia=spin_low * thin
        )
        linkage.link(
            f"rod {k}", f"P{k}", f"B{k}", mass=rod, centre=tops[k] - top_centre * axis, inertia=spin_top * thin
        )
        linkage.universal(f"B{k}", "ground", f"cylinder {k}", axis=(1, 0, 0), second=np.cross(axis, (1.0, 0.0, 0.0)))
        length = np.linalg.norm(legs(start)[k])
        linkage.prismatic(
            f"B{k}", f"cylinder {k}", f"rod {k}", axis=axis, reference=length, drive=True, name=f"leg {k}"
        )
        linkage.spherical(f"P{k}", f"rod {k}", "platform")
    linkage.gravity(gravity)
    linkage.load("tool", link="platform", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), push, strict=True)))
    lengths = [np.linalg.norm(legs(t), axis=1), *twice(lambda s: np.linalg.norm(legs(s), axis=1), t)]
    values, rates, gains = ({f"leg {k}": x[k] for k in range(6)} for x in lengths)
    motion = linkage.move(values, rates=rates, accelerations=gains)
    # As drawn, each rod's point at its foot stands on the foot, which makes no singular pose.
    drawn_too = linkage.move({name: [linkage.joint(name).reference[0], value] for name, value in values.items()})
    assert_array_equal(drawn_too.status, "regular")
    assert_allclose(motion.position("tool", "platform"), place(t), atol=1e-13)

    slope, bend = twice(turn, t)
    spin, gain = slope @ turn(t).T, bend @ turn(t).T
    omega = np.array([spin[2, 1], spin[0, 2], spin[1, 0]])
    skew = 0.5 * (gain - gain.T)
    alpha = np.array([skew[2, 1], skew[0, 2], skew[1, 0]])
    assert_allclose(motion.angular_acceleration("platform"), alpha, atol=1e-7)
    arm, tensor = turn(t) @ centre, turn(t) @ inertia @ turn(t).T
    lift = mass * (twice(place, t)[1] + np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm)) - gravity)
    twist = tensor @ alpha + np.cross(omega, tensor @ omega) + np.cross(arm, lift)
    needed, columns = np.concatenate([lift, twist]) - push, []
    leg, unit = legs(t), units(t)
    speeds_up = [twice(lambda s: low_centre * units(s), t)[1], twice(lambda s: legs(s) - top_centre * units(s), t)[1]]
    for k in range(6):
        low_force, top_force = cylinder * (speeds_up[0][k] - gravity), rod * (speeds_up[1][k] - gravity)
        swing = np.cross(unit[k], speeds_up[0][k] / low_centre)
        moment = np.cross(low_centre * unit[k], low_force) + np.cross(leg[k] - top_centre * unit[k], top_force)
        across = np.cross(moment + (spin_low + spin_top) * swing, unit[k]) / np.linalg.norm(leg[k])
        head = turn(t) @ heads[k]
        taken = -across - top_force @ unit[k] * unit[k]
        needed = needed - np.concatenate([taken, np.cross(head, taken)])
        columns.append(np.concatenate([unit[k], np.cross(head, unit[k])]))
    found = motion.reactions()
    forces = [found.drive(f"leg {k}")[0] for k in range(6)]
    assert_allclose(forces, np.linalg.solve(np.transpose(columns), needed), rtol=1e-7)
    assert found.method == "determinate"


# -- single effects ---------------------------------------------------------------------------------------------------


def test_spinning_disc_on_a_turning_arm() -> None:
    """Gyroscopic moment J W w about the third axis (Beer and Johnston, Dynamics, chapter 18)."""
    spin, turn, inertia, mass, length = 200.0, 3.0, 0.02, 2.0, 0.5
    linkage = Linkage(O=(0, 0), C=(length, 0, 0))
    linkage.link("arm", "O", "C")
    linkage.link("disc", "C", mass=mass, inertia=(inertia, inertia / 2, inertia / 2, 0, 0, 0))
    linkage.revolute("O", "ground", "arm", drive=True)
    linkage.revolute("C", "arm", "disc", axis=(1, 0, 0), drive=True)
    found = linkage.move(rates={"O": turn, "C": spin}).reactions()
    moment = inertia * spin * turn
    assert_allclose(found.force("C"), [-mass * turn**2 * length, 0, 0, 0, moment, 0], atol=1e-12)
    assert_allclose(found.force("O", "ground")[3:], [0, -moment, 0], atol=1e-12)
    assert_allclose([*found.drive("O"), *found.drive("C")], 0.0, atol=1e-12)


def test_porter_governor_floats_at_its_speed() -> None:
    """Equal arms pivoted on the spindle: w^2 = g (m + M) / (m h); then nothing need hold the sleeve."""
    length, ball, sleeve, angle = 0.25, 2.0, 10.0, 0.6
    height, radius = length * np.cos(angle), length * np.sin(angle)
    speed = np.sqrt(G * (ball + sleeve) / (ball * height))
    linkage = Linkage(O=(0, 0, 0), S=(0, 0, -2 * height))
    linkage.link("spindle", "O", "S")
    linkage.link("sleeve", "S", mass=sleeve)
    for side, x in (("left", -radius), ("right", radius)):
        linkage.point(f"ball {side}", (x, 0, -height))
        linkage.link(f"upper {side}", "O", f"ball {side}", mass=ball, centre=(x, 0, -height))
        linkage.link(f"lower {side}", f"ball {side}", "S")
        linkage.revolute("O", "spindle", f"upper {side}", axis=(0, 1, 0), name=f"top {side}")
        linkage.revolute(f"ball {side}", f"upper {side}", f"lower {side}", axis=(0, 1, 0))
        linkage.revolute("S", f"lower {side}", "sleeve", axis=(0, 1, 0), name=f"bottom {side}")
    linkage.revolute("O", "ground", "spindle", drive=True)
    linkage.prismatic("S", "spindle", "sleeve", axis=(0, 0, 1), drive=True, name="slide")
    linkage.gravity((0, 0, -G))
    for rate in (speed, 1.1 * speed):
        motion = linkage.move(O=[0.0, 0.5], rates={"O": rate})
        lift = sleeve * G - ball * (rate**2 * height - G)
        assert_allclose(motion.reactions().drive("slide")[:, 0], lift, atol=1e-10)


def test_thrust_that_turns_with_its_link() -> None:
    """A rocket across the end of an arm: the same torque at every angle; held in global axes, it is not."""
    theta = np.linspace(0.0, 6.0, 7)
    for follows in (True, False):
        linkage = Linkage(O=(0, 0), T=(2, 0))
        linkage.link("arm", "O", "T")
        linkage.revolute("O", "ground", "arm", drive=True)
        linkage.load("T", fy=3.0, mx=1.0, follower=follows)
        linkage.torque("arm", my=5.0, follower=follows)
        found = linkage.move(O=theta).reactions()
        turn = theta if follows else 0.0 * theta
        assert_allclose(found.drive("O")[:, 0], -6.0 * np.cos(theta - turn), atol=1e-13)
        moment = [-np.cos(turn) + 5.0 * np.sin(turn), -np.sin(turn) - 5.0 * np.cos(turn)]
        assert_allclose(found.force("O")[:, 3:5], np.transpose(moment), atol=1e-13)
