"""Stiffness and frequencies about a loaded pose: the second derivative of the potential through the closed loop."""

from __future__ import annotations

import runpy
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, PointMass, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
INF = np.inf
CRANK, ROD, DRAWN = 0.1, 0.25, 0.9
ANCHOR = (0.5, 0.1)
DRIVE = 30.0
HINGE = (INF,) * 5 + (DRIVE,)


def slider_crank(beam: Beam | None = None, force: float = 0.0) -> Linkage:
    """A spring from the slider to the ground, perhaps a force on the crank's pin and a weight on the slider's point."""
    pin = CRANK * np.cos(DRAWN), CRANK * np.sin(DRAWN)
    linkage = Linkage(A=(0, 0), B=pin, C=(pin[0] + np.sqrt(ROD**2 - pin[1] ** 2), 0.0), Q=ANCHOR)
    linkage.link("crank", "A", "B", beam=beam)
    linkage.link("rod", "B", "C", beam=beam)
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank", stiffness=HINGE, drive=True)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0), name="S")
    linkage.spring("C", ("ground", "Q"), stiffness=1000.0, length=0.2)
    if force:
        linkage.load("B", fx=force, fy=-2.0 * force)
    return linkage


def potential(angle: object, force: float) -> object:
    """Of spring and force, by the crank's angle."""
    x, y = CRANK * mpmath.cos(angle), CRANK * mpmath.sin(angle)
    slider = x + mpmath.sqrt(ROD**2 - y**2)
    length = mpmath.sqrt((ANCHOR[0] - slider) ** 2 + mpmath.mpf(ANCHOR[1]) ** 2)
    return 500 * (length - mpmath.mpf("0.2")) ** 2 - force * x + 2 * force * y


@pytest.mark.parametrize("force", [0.0, 40.0])
def test_the_tangent_stiffness_of_a_slider_crank(force: float) -> None:
    """Of spring, crank and rod together; it is negative where the potential has a top."""
    turned = np.array([0.0, 0.5, 1.0, 2.0, 3.0])
    found = 1.0 / slider_crank(force=force).move(A=turned).compliance_matrix("B", "crank")[:, 5, 5] - DRIVE
    with mpmath.workdps(30):
        wanted = [float(mpmath.diff(lambda a: potential(a, force), DRAWN + t, 2)) for t in turned]
    assert min(wanted) < -1.0
    assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)


def test_rigid_links_are_the_limit_of_stiff_beams() -> None:
    turned = np.array([0.0, 1.0, 2.0])
    rigid = slider_crank(force=40.0).move(A=turned).compliance_matrix("B", "crank")[:, 5, 5]
    off = []
    for modulus in (1e13, 1e15):
        beam = Beam(Rectangle(y=0.02, z=0.02), Material(E=modulus, nu=0.3))
        elastic = slider_crank(beam, 40.0).move(A=turned).compliance_matrix("B", "crank")[:, 5, 5]
        off.append(np.abs(elastic / rigid - 1.0).max())
    assert off[0] < 1e-4
    assert off[1] < 0.05 * off[0]


def pendulum(drive: float) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0, -0.5))
    linkage.link("arm", "A", "B", mass=2.0, centre=(0, -0.5), inertia=0.0)
    linkage.revolute("A", "ground", "arm", stiffness=(INF,) * 5 + (drive,), drive=True)
    linkage.gravity((0, -9.81))
    return linkage


@pytest.mark.parametrize("drive", [1.0, 20.0])
def test_a_pendulum_swings_by_its_weight(drive: float) -> None:
    """``m l^2 w^2 = k + m g l cos(angle)``; upside down on a weak spring it has no frequency."""
    angle = np.radians([0.0, 40.0, 120.0, 180.0])
    motion = pendulum(drive).move(A=angle)
    stiffness = drive + 2.0 * 9.81 * 0.5 * np.cos(angle)
    assert_allclose(1.0 / motion.compliance_matrix("B")[:, 5, 5], stiffness, rtol=1e-12)
    wanted = np.where(stiffness > 0.0, np.sqrt(np.abs(stiffness) / 0.5) / (2.0 * np.pi), np.nan)
    assert_allclose(motion.frequencies(1)[:, 0], wanted, rtol=1e-9)


def test_a_balanced_arm_moves_freely_at_every_angle() -> None:
    """A spring of no free length from above the pivot balances a weight: the stiffness is the drive's alone."""
    linkage = Linkage(A=(0, 0), B=(0.3, 0), T=(0, 0.2), M=(0.6, 0))
    linkage.link("arm", "A", "B", "M")
    linkage.revolute("A", "ground", "arm", stiffness=(INF,) * 5 + (1e-3,), drive=True)
    stiffness = 500.0
    linkage.load("M", fy=-stiffness * 0.3 * 0.2 / 0.6)
    linkage.spring("B", ("ground", "T"), stiffness=stiffness, length=0.0)
    motion = linkage.move(A=np.radians([-60.0, 0.0, 35.0, 80.0]))
    assert_allclose(motion.reactions().drive("A"), 0.0, atol=1e-12)
    assert_allclose(1.0 / motion.compliance_matrix("B")[:, 5, 5], 1e-3, rtol=1e-8)


def test_an_elastic_arm_under_load_keeps_its_shape_of_results() -> None:
    """A column pushed at half its buckling load gives way about twice as far; batches of loads come with the poses."""
    steel = Material(E=200e9, nu=0.3, density=7850.0)
    bar = Beam(Rectangle(y=0.01, z=0.02), steel, segments=4)
    linkage = Linkage(A=(0, 0), B=(1.0, 0))
    linkage.link("arm", "A", "B", beam=bar)
    linkage.revolute("A", "ground", "arm", drive=True)
    euler = np.pi**2 / 4.0 * 200e9 * 0.02 * 0.01**3 / 12.0
    linkage.load("B", fx=-euler * np.array([1e-9, 0.5]))
    motion = linkage.move(A=np.zeros((3, 1)))
    across = motion.compliance_matrix("B")[..., 1, 1]
    assert across.shape == (3, 2)
    assert_allclose(across[:, 1] / across[:, 0], 2.0, rtol=0.02)
    frequencies = motion.frequencies(2)
    assert frequencies.shape == (3, 2, 2)
    assert_allclose(frequencies[:, 1, 0] / frequencies[:, 0, 0], np.sqrt(0.5), rtol=0.02)


THRUST = np.array([20.0, -35.0, 15.0])


def on_a_cross(looped: bool) -> tuple[Linkage, Array]:
    """A rod on a cross with springs, or a shaft on a cross within a loop whose crank has one; and these springs."""
    linkage = Linkage(A=(0, 0, 0), B=(0.2, 0.1, 0.8), C=(0.9, 0.3, 0.5))
    for name, points in {"rod": "AB", "shaft": "BC"}.items():
        linkage.link(name, *points)
    for point, force in (("B", THRUST), ("C", THRUST[::-1])):
        linkage.load(point, link="shaft", **dict(zip(("fx", "fy", "fz"), force, strict=True)))
    if looped:
        linkage.revolute("A", "ground", "rod", axis=(0.3, 0.2, 1), drive=True, stiffness=(INF,) * 5 + (60.0,))
        linkage.universal("B", "rod", "shaft", axis=(0, 1, 0.4), second=(1, 0, 0))
        linkage.link("slide", "C")
        linkage.spherical("C", "shaft", "slide")
        linkage.prismatic("C", "ground", "slide", axis=(0.2, 1, 0.1), name="S")
        return linkage, np.array([60.0])
    springs = (INF, INF, INF, 60.0, INF, 90.0)
    linkage.universal("A", "ground", "rod", axis=(0, 1, 0), second=(1, 0, 0.1), drive=True, stiffness=springs)
    linkage.fixed("B", "rod", "shaft")
    return linkage, np.array([90.0, 60.0])


@pytest.mark.parametrize("looped", [False, True])
def test_a_cross_turns_about_an_axis_of_each_link(looped: bool) -> None:
    """C = J^T (k + V'')^-1 J with the potential of the forces, by its differences over poses."""
    linkage, springs = on_a_cross(looped)
    at, step, units = np.array([0.3, 0.5])[: len(springs)], 1e-3, np.eye(len(springs))
    signs = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    ways = np.einsum("sa,ijak->ijsk", signs, np.stack(np.broadcast_arrays(units[:, None], units), axis=2))
    around = linkage.move(A=np.squeeze(at + step * ways, axis=-1) if looped else at + step * ways)
    energy = -around.position("B", "shaft") @ THRUST - around.position("C", "shaft") @ THRUST[::-1]
    bent = energy @ (1.0, -1.0, -1.0, 1.0) / (4.0 * step**2)
    here = linkage.move(A=np.squeeze(at) if looped else at)
    moved = here.sensitivity("C", "shaft").drives["A"]
    wanted = moved @ np.linalg.inv(np.diag(springs) + bent) @ moved.T
    assert np.abs(bent).max() > 2.0
    assert_allclose(here.compliance_matrix("C", "shaft"), wanted, rtol=0.0, atol=3e-5 * np.abs(wanted).max())


@pytest.mark.parametrize("springs", [(60.0, 90.0), (90.0, 60.0)])
def test_a_cross_at_large_displacement(springs: tuple[float, float]) -> None:
    """Where the energy of a rod's springs and load is least: about z of the ground first, then about x of the rod."""
    tip, force = np.array([0.2, 0.1, 0.8]), np.array([40.0, -35.0, 15.0])
    linkage = Linkage(A=(0, 0, 0), B=tip)
    linkage.link("rod", "A", "B")
    hold = (INF, INF, INF, springs[1], INF, springs[0])
    linkage.universal("A", "ground", "rod", axis=(0, 1, 0), second=(1, 0, 0.1), drive=True, stiffness=hold)
    linkage.load("B", **dict(zip(("fx", "fy", "fz"), force, strict=True)))
    axes = linkage.joint("A").axes

    def moved(turn: Array) -> Array:
        about_z, about_x = (Rotation.from_rotvec(axes[:, k] * angle) for k, angle in zip((2, 0), turn, strict=True))
        return np.asarray((about_z * about_x).apply(tip)) - tip

    least = minimize(lambda turn: 0.5 * np.dot(springs, turn**2) - force @ moved(turn), np.zeros(2), tol=1e-12).x
    found = linkage.move().frame().solve(large=True).displacement("B")[:3]
    assert_allclose(found, moved(least), atol=1e-6)


def test_a_delta_robot_under_load_on_rigid_rods_that_spin() -> None:
    """``C^-1 = k q'^T q' + t . q''`` by the closed form q of its arms, whose drives hold a force on the platform."""
    delta = runpy.run_path(str(Path(__file__).parents[2] / "examples" / "delta_robot.py"))
    linkage, arms, spring = delta["linkage"], delta["arm_angles"], 200.0
    for k in range(3):
        given = {"axis": delta["tangent"][k], "reference": delta["start"][k], "stiffness": (INF,) * 5 + (spring,)}
        linkage.revolute(f"A{k}", "ground", f"arm {k}", replace=True, drive=True, **given)
    force = np.array([3.0, -2.0, 10.0])
    linkage.load("P", link="platform", **dict(zip(("fx", "fy", "fz"), force, strict=True)))
    places = delta["home"] + [[0.05, 0.03, 0.01], [-0.08, 0.02, -0.03]]
    found = linkage.move({f"A{k}": arms(places)[:, k] for k in range(3)}).compliance_matrix("P")
    step, units, signs = 1e-3, np.eye(3), np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])
    for place, matrix in zip(places, found, strict=True):
        around = arms(place + step * np.array([-2, -1, 1, 2])[:, None, None] * units)
        slope = ((1, -8, 8, -1) @ around.reshape(4, -1)).reshape(3, 3).T / (12.0 * step)
        held = np.linalg.solve(slope.T, force)
        ways = np.einsum("sa,ijak->ijsk", signs, np.stack(np.broadcast_arrays(units[:, None], units), axis=2))
        near, far = (((arms(place + h * ways) @ held) @ (1, -1, -1, 1)) / (4 * h**2) for h in (step, 2 * step))
        wanted = np.linalg.inv(spring * slope.T @ slope + (4.0 * near - far) / 3.0)
        assert_allclose(matrix[:3, :3], wanted, rtol=1e-7, atol=1e-7 * np.abs(wanted).max())
        assert_allclose(matrix[3:], 0.0, atol=1e-12)


@pytest.mark.parametrize("load", [0.0, -1.0])
@pytest.mark.parametrize(("density", "where"), [(0.0, ""), ([7850.0, 0.0], r" at batch entry \[1\]")])
def test_a_linkage_without_mass_is_refused_alike_with_and_without_load(density: Any, where: str, load: float) -> None:
    """Naming the batch entry that has none, where the frequency would be infinite."""
    beam = Beam(Circle(diameter=0.01), Material(E=2e11, nu=0.3, density=np.array(density)))
    linkage = Linkage(A=(0, 0), B=(0.3, 0))
    linkage.link("arm", "A", "B", beam=beam)
    linkage.revolute("A", "ground", "arm", drive=True)
    if load:
        linkage.load("B", fy=load)
    with pytest.raises(FrameError, match=f"^frequencies: the linkage has no mass{where}: give its materials a density"):
        linkage.move(A=0.0).frequencies(1)


def test_a_frame_without_mass_at_an_entry_is_refused() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    steel = Material(E=2e11, nu=0.3, density=np.array([7850.0, 0.0, 7850.0]))
    frame.add("AB", Beam(Circle(diameter=0.01), steel), "A", "B")
    frame.fix("A")
    with pytest.raises(FrameError, match=r"^modes: the frame has no mass at batch entry \[1\]: give its materials"):
        frame.modes(1)


@pytest.mark.parametrize("count", [1, 4])
def test_an_entry_that_is_left_out_needs_no_mass(count: int) -> None:
    """Nor as many modes as are asked for."""

    def frequencies(density: Any, tip: Any, left: Any = None) -> np.ndarray:
        frame = Frame()
        for name, x in {"A": 0.0, "B": 0.5, "C": 1.0}.items():
            frame.node(name, (x, 0.0, 0.0))
        beam = Beam(Circle(diameter=0.01), Material(E=2e11, nu=0.3, density=density))
        frame.add("AB", beam, "A", "B")
        frame.add("BC", beam, "B", "C")
        frame.add("tip", PointMass(tip), "C")
        frame.fix("A")
        if left is not None:
            frame.exclude(left)
        return frame.modes(count).frequencies

    found = frequencies(np.array([7850.0, 0.0, 0.0]), np.array([2.0, 0.0, 1.0]), [False, True, True])
    assert_allclose(found[0], frequencies(7850.0, 2.0), rtol=1e-12)
    assert np.isnan(found[1:]).all()


def test_a_released_end_of_a_pressed_rod_is_a_joint_that_is_free_in_the_same_component() -> None:
    """A slider-crank whose rod lies along x, so that the axes of rod and joint are the same."""
    steel, found = Material(E=200e9, nu=0.3, density=7850.0), []
    for release, resistance in ((("start ry",), np.inf), ((), 0.0)):
        linkage = Linkage(A=(0.0, 0.0), B=(0.0, 0.3), C=(1.0, 0.3))
        linkage.link("crank", "A", "B", beam=Beam(Rectangle(y=0.03, z=0.03), steel))
        linkage.link("rod", "B", "C", beam=Beam(Rectangle(y=0.02, z=0.01), steel, segments=2, release=release))
        linkage.link("piston", "C")
        linkage.revolute("A", "ground", "crank", drive=True)
        linkage.revolute("B", "crank", "rod", stiffness=(np.inf,) * 4 + (resistance, 0.0))
        linkage.revolute("C", "rod", "piston")
        linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), name="slide")
        linkage.load("C", fx=-3000.0)
        motion = linkage.move(A=0.0)
        found.append((motion.frequencies(3), motion.compliance_matrix("B")))
    for given, joined in zip(*found, strict=True):
        assert_allclose(given, joined, rtol=1e-9, atol=1e-18)
