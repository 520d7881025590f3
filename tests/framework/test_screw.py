"""Screw joints: turning advances, torque is force times pitch over two pi, in trees and loops, stiff or ideal."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
PITCH = 0.05
LEAD = PITCH / (2.0 * np.pi)
BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3))
TURNED = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def spindle(stiffness: Array, axes: Array, *, closed: bool, pitch: object = PITCH) -> Frame:
    """A clamped bar, a screw, and a bar beyond it along the screw; `closed` holds the far end but for its turning."""
    frame = Frame()
    places = {"A": np.zeros(3), "B": 0.3 * axes[:, 0], "C": 0.3 * axes[:, 0], "D": 0.3 * axes[:, 0] + 0.4 * axes[:, 2]}
    for name, place in places.items():
        frame.node(name, place)
    frame.add("arm", BEAM, "A", "B")
    frame.add("screw", Joint(stiffness, axes=axes, pitch=pitch), "B", "C")  # type: ignore[arg-type]
    frame.add("rod", BEAM, "C", "D")
    frame.fix("A")
    if closed:
        frame.node("E", places["D"])
        frame.fix("E")
        frame.add("end", Joint((np.inf,) * 5 + (0.0,), axes=axes), "D", "E")
    return frame


@pytest.mark.parametrize("axes", [np.eye(3), TURNED], ids=["global", "turned"])
@pytest.mark.parametrize("held", [np.inf, 1e7], ids=["ideal", "stiff"])
def test_torque_on_the_nut_that_an_axial_force_needs(held: float, axes: Array) -> None:
    """A torsion spring k about the screw: a force F turns it by F p / 2 pi k, and advances it by p / 2 pi of that."""
    torsion, force = 40.0, 100.0
    frame = spindle(np.array([held] * 5 + [torsion]), axes, closed=False)
    frame.load("D", **dict(zip(("fx", "fy", "fz"), force * axes[:, 2], strict=True)))
    solution = frame.solve()
    moved, acting = solution.joint_displacement("screw"), solution.joint_force("screw")
    slack = 0.0 if np.isinf(held) else force / held
    assert moved[5] == pytest.approx(LEAD * force / torsion, rel=1e-12)
    assert moved[2] == pytest.approx(LEAD * moved[5] + slack, rel=1e-12)
    assert acting[2] == pytest.approx(force, rel=1e-12)
    assert acting[5] == pytest.approx(0.0, abs=1e-12 * force)


@pytest.mark.parametrize("held", [np.inf, 1e9], ids=["ideal", "stiff"])
def test_turning_the_rod_pushes(held: float) -> None:
    """A torque on a free rod is balanced by a force F = 2 pi T / p between the ends that hold it."""
    frame = spindle(np.array([held] * 5 + [0.0]), TURNED, closed=True)
    torque = 3.0
    frame.load("D", **dict(zip(("mx", "my", "mz"), torque * TURNED[:, 2], strict=True)))
    solution = frame.solve()
    acting = solution.joint_force("screw")
    # The screw holds the rod back: torque -T on it, which is the second link, and with it the force T / lead.
    assert acting[5] == pytest.approx(torque, rel=1e-9)
    assert acting[2] == pytest.approx(-torque / LEAD, rel=1e-9)
    total = solution.reaction("A") + solution.reaction("E")
    np.testing.assert_allclose(total[:3], 0.0, atol=1e-9 * torque / LEAD)
    assert solution.joint_displacement("screw")[2] - LEAD * solution.joint_displacement("screw")[5] == pytest.approx(
        0.0 if np.isinf(held) else acting[2] / held, abs=1e-15
    )


@pytest.mark.parametrize("turning", [20.0, np.inf], ids=["slide closes the loop", "screw closes the loop"])
def test_rigid_loop_through_a_screw(turning: float) -> None:
    """The loop's ideal components are eliminated with the pitch in them: the rod that both joints carry is at rest."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (0, 0, 0)}.items():
        frame.node(name, place)
    frame.fix("A")
    frame.rigid("A", "B")
    frame.add("screw", Joint((np.inf,) * 5 + (0.0,), pitch=PITCH), "B", "C")
    frame.add("slide", Joint((np.inf, np.inf, 1e4, np.inf, np.inf, turning)), "A", "D")
    frame.rigid("D", "C")
    frame.load("C", fy=3.0, fz=10.0)
    solution = frame.solve()
    # The rod would have to turn about z through A and through C at once.
    np.testing.assert_allclose(solution.joint_displacement("screw"), 0.0, atol=1e-18)
    screw, slide = solution.joint_force("screw"), solution.joint_force("slide")
    assert screw[2] == pytest.approx(10.0)
    assert screw[5] == pytest.approx(-LEAD * 10.0)
    # Equilibrium of the rod, moments about A: joints pull it back with what they exert on their first nodes.
    load = np.array([0.0, 3.0, 10.0])
    np.testing.assert_allclose(screw[:3] + slide[:3], load, atol=1e-12)
    moments = screw[3:] + slide[3:] + np.cross([1.0, 0.0, 0.0], screw[:3])
    np.testing.assert_allclose(moments, np.cross([1.0, 0.0, 0.0], load), atol=1e-12)


@pytest.mark.parametrize("turning", [np.inf, 25.0], ids=["driven", "driven through a spring"])
@pytest.mark.parametrize(
    ("held", "second"), [(np.inf, False), (1e7, False), (1e7, True)], ids=["ideal", "stiff", "stiff, closing a loop"]
)
def test_an_imposed_turn_drives(held: float, turning: float, second: bool) -> None:
    """A turn of the nut by θ lifts the rod by θ p / 2 pi, and a force F turns it back by F p / 2 pi k."""
    angle, force = 0.02, 100.0
    frame = spindle(np.array([held] * 5 + [turning]), TURNED, closed=False)
    frame.offset("screw", rz=angle)
    frame.load("D", **dict(zip(("fx", "fy", "fz"), force * TURNED[:, 2], strict=True)))
    if second:  # the same screw once more, doing half of the work
        frame.add("twin", Joint(np.array([held] * 5 + [turning]), axes=TURNED, pitch=PITCH), "B", "C")
        frame.offset("twin", rz=angle)
    moved = frame.solve().joint_displacement("screw")
    share = 0.5 if second else 1.0
    back = LEAD * force * share / turning
    assert moved[5] == pytest.approx(angle + back, rel=1e-11)
    assert moved[2] == pytest.approx(LEAD * moved[5] + (0.0 if np.isinf(held) else force * share / held), rel=1e-11)


def test_stiffness_matrix_is_the_hessian_of_the_energy() -> None:
    springs = np.array([3.0, 5.0, 7.0, 11.0, 13.0, 17.0])
    joint = Joint(springs, axes=TURNED, pitch=PITCH)
    rng = np.random.default_rng(0)
    u = rng.normal(size=12)
    moved = np.concatenate([TURNED.T @ (u[6:9] - u[0:3]), TURNED.T @ (u[9:12] - u[3:6])])
    moved[2] -= LEAD * moved[5]
    assert u @ joint.matrix() @ u == pytest.approx(springs @ moved**2, rel=1e-13)
    np.testing.assert_array_equal(joint.matrix(), joint.matrix().T)


def test_pitch_may_vary_over_the_batch_and_zero_is_a_cylinder_that_holds() -> None:
    pitches = np.array([0.0, 0.01, PITCH])
    stiffness = np.array([np.inf] * 5 + [25.0])
    frame = spindle(stiffness, np.eye(3), closed=False, pitch=pitches)
    frame.load("D", fz=1e3)
    found = frame.solve().joint_displacement("screw")
    np.testing.assert_allclose(found[:, 5], 1e3 * pitches / (2 * np.pi) / 25.0, rtol=1e-12, atol=1e-18)


def test_a_free_motion_turns_and_advances() -> None:
    frame = spindle(np.array([np.inf] * 5 + [0.0]), TURNED, closed=False)
    frame.load("D", **dict(zip(("mx", "my", "mz"), TURNED[:, 2], strict=True)))
    motion = frame.solve().free_motion()
    moved = motion.joints["screw"][0]
    assert moved[5] != 0.0
    np.testing.assert_allclose(moved[:3], LEAD * moved[5] * np.eye(3)[2], rtol=1e-14, atol=1e-16)
    # the motion has unit size, so that rounding leaves some 1e-16 in what is zero
    np.testing.assert_allclose(motion.displacement("D")[0, :3], LEAD * moved[5] * TURNED[:, 2], rtol=1e-12, atol=2e-15)


def test_condition_number_counts_the_pitch() -> None:
    def number(pitch: float) -> float:
        frame = spindle(np.array([1e7] * 5 + [25.0]), np.eye(3), closed=False, pitch=pitch)
        return float(frame.solve().condition_number())

    assert number(0.5) != number(0.0)


def refused(build: Callable[[], object], told: str) -> None:
    with pytest.raises(FrameError, match=told):
        build()


def test_a_pitch_that_is_no_number_is_refused() -> None:
    refused(lambda: Joint((1.0,) * 6, pitch=np.nan), "pitch = nan must be finite")
    refused(lambda: Joint((1.0,) * 6, axes=np.stack([np.eye(3)] * 2), pitch=np.ones(3)), r"pitch \(3,\)")


def test_bounds_and_sensitivities_of_a_batch_of_screws() -> None:
    """Turn and advance under a force, F p / 2 pi k and its lead, with their bounds and derivatives by stiffness."""
    pitches, force = np.array([[0.0], [0.01], [PITCH]]), np.array([1.0, 300.0])
    held = 1e7
    frame = spindle(np.array([held] * 5 + [25.0]), TURNED, closed=False, pitch=pitches)
    frame.load("D", **dict(zip(("fx", "fy", "fz"), force[:, None].T * TURNED[:, 2:], strict=True)))
    frame.offset("screw", rz=0.01)
    solution = frame.solve()
    lead = pitches / (2.0 * np.pi)
    turn = lead * force / 25.0 + 0.01
    exact = {5: turn, 2: lead * turn + force / held}
    moved, bound = solution.joint_displacement("screw"), solution.error_bound("screw", "joint_displacement")
    for k, expected in exact.items():
        assert np.all(np.abs(moved[..., k] - expected) <= bound[..., k] + 1e-15 * np.abs(expected))
        assert np.all(bound[..., k] <= 1e-12 * np.abs(expected) + 1e-24)
    found = solution.sensitivity("screw", "uz", "joint_displacement")
    np.testing.assert_allclose(found.joints["screw"][..., 5], -(lead**2) * force / 25.0**2, rtol=1e-9, atol=1e-18)
    np.testing.assert_allclose(found.joints["screw"][..., 2], -force / held**2 + 0.0 * lead, rtol=1e-9)
    np.testing.assert_allclose(found.offsets["screw"][..., 5], lead + 0.0 * force, rtol=1e-9, atol=1e-15)
    torque = solution.sensitivity("screw", "mz", "joint_force")
    along = torque.loads["D"][..., :3] @ TURNED[:, 2]
    np.testing.assert_allclose(along, 0.0, atol=1e-12)


def test_sensitivity_to_the_axes_of_a_screw() -> None:
    """Against differences of frames whose screws point elsewhere, in a batch of pitches, zero among them."""
    stiffness, pitches, step = np.array([1e6, 2e6, 3e6, 4e3, 5e3, 25.0]), np.array([0.0, 0.01, PITCH]), 1e-5

    def moved(turn: Array) -> Frame:
        frame = spindle(stiffness, TURNED, closed=False, pitch=pitches)
        frame.change("screw", Joint(stiffness, axes=turn @ TURNED, pitch=pitches))
        frame.set_load("C", fx=3.0, fy=200.0, fz=100.0, mx=2.0, mz=5.0)
        return frame

    found = moved(np.eye(3)).solve().sensitivity("C", "ux").joint_axes["screw"]
    for axis in range(3):
        ahead, behind = (Rotation.from_rotvec(sign * step * np.eye(3)[axis]).as_matrix() for sign in (1.0, -1.0))
        change = moved(ahead).solve().displacement("C") - moved(behind).solve().displacement("C")
        np.testing.assert_allclose(found[:, axis], change[:, 0] / (2.0 * step), rtol=1e-5, atol=1e-9)
