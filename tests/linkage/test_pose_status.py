"""Status of poses, conditioning and transmission angle against the triangles of planar linkages."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, PoseState
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.linkages import bennett, four_bar, rssr
from scipy.spatial.transform import Rotation

TILTED = Rotation.from_rotvec([0.4, -1.1, 0.7])


def angle(linkage_sides: tuple[float, float, float]) -> float:
    a, b, opposite = linkage_sides
    return float(np.arccos((a * a + b * b - opposite * opposite) / (2.0 * a * b)))


@pytest.mark.parametrize("turn", [Rotation.identity(), TILTED])
def test_crank_rocker_is_regular_but_at_the_ends_of_its_swing(turn: Rotation) -> None:
    linkage = four_bar(0.1, 0.25, 0.2, 0.22, 0.7, turn=turn)
    outer, inner = angle((0.35, 0.22, 0.2)), angle((0.15, 0.22, 0.2)) + np.pi
    status = linkage.move(A=[0.0, 0.3, outer, 1.5, np.pi, inner]).status
    still = "singular (inverse-kinematic, type I; joint D is stationary)"
    assert status.tolist() == ["regular", "regular", still, "regular", "regular", still]
    assert linkage.move(A=outer).status == still  # told at a single pose as well


@pytest.mark.parametrize("branch", ["keep", "switch"])
def test_parallelogram(branch: str) -> None:
    theta = np.radians([90.0, 170.0, 179.5, 180.0, 180.5, 190.0, 270.0])
    motion = four_bar(0.1, 0.2, 0.1, 0.2, 0.7).move(A=theta, branch=branch)
    loose = "singular (direct-kinematic, type II; dead point of D)"
    near = "near dead point"
    assert motion.status.tolist() == ["regular", "regular", near, loose, near, "regular", "regular"]
    b, d = motion.position("B"), motion.position("D")
    level = np.abs(d[:, 1] - b[:, 1]) < 1e-9
    assert level.tolist() == [True, True, True, True, *[branch == "keep"] * 3]


def test_near_and_beyond_a_dead_point() -> None:
    crank, coupler, rocker, ground = 0.2, 0.22, 0.18, 0.3
    end = angle((crank, ground, coupler + rocker))
    motion = four_bar(crank, coupler, rocker, ground, 0.9).move(A=[1.0, end - 1e-6, end, end + 0.1])
    assert motion.status[:2].tolist() == ["regular", "near dead point"]
    assert motion.status[2] == "singular (direct-kinematic, type II; dead point of D)"
    assert motion.status[3].startswith("not assembled: gap ")
    assert motion.status[3].split(" at joint ")[1] in "ABDE"
    assert np.isnan(motion.position("D")[3]).all()
    assert motion.conditioning[0] > 0.1 > motion.conditioning[1] > motion.conditioning[2]
    assert np.isnan(motion.conditioning[3])


def five_bar() -> Linkage:
    """5R robot drawn symmetric, its elbows out."""
    linkage = Linkage(A=(-0.1, 0), B=(-0.3, 0.3), P=(0, 0.5), D=(0.3, 0.3), E=(0.1, 0))
    for name, ends in {"left": "AB", "left rod": "BP", "right rod": "DP", "right": "ED"}.items():
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "left", drive=True, reference=np.arctan2(0.3, -0.2))
    linkage.revolute("E", "ground", "right", drive=True, reference=np.arctan2(0.3, 0.2))
    linkage.revolute("B", "left", "left rod")
    linkage.revolute("P", "left rod", "right rod")
    linkage.revolute("D", "right", "right rod")
    return linkage


def test_two_drives() -> None:
    """Rods in line: P moves with both drives held. Arm and rod in line: P moves along one direction only."""
    arm, rod = np.hypot(0.2, 0.3), np.hypot(0.3, 0.2)
    spread = np.arccos((rod - 0.1) / arm)
    reach = arm + rod
    # B, and with the left arm stretched P, at this angle of the left arm; then D from the triangle P D E.
    left = 1.3
    p = -0.1 + reach * np.exp(1j * left)
    away = p - 0.1
    right = np.angle(away) - np.arccos((arm**2 + abs(away) ** 2 - rod**2) / (2 * arm * abs(away)))
    linkage = five_bar()
    apart = linkage.move(A=[2.0, np.pi - spread], E=[1.1, spread]).status.tolist()
    assert apart == ["regular", "singular (direct-kinematic, type II; dead point of P)"]
    stretched = linkage.move(A=[2.0, left], E=[1.1, right]).status.tolist()
    assert stretched == ["regular", "singular (inverse-kinematic, type I; joint P loses a degree of freedom)"]


def test_stewart_platform_turned_by_a_right_angle() -> None:
    """Feet and heads on similar hexagons: at 90° about the vertical all legs are held, and the platform moves.

    E. F. Fichter, A Stewart platform-based manipulator, Int. J. Robotics Research 5 (1986) 157.
    """
    ring = np.radians(np.repeat([90.0, 210.0, 330.0], 2) + np.array([[15.0], [45.0]]) * np.tile([-1.0, 1.0], 3))
    feet, heads = (
        radius * np.stack([np.cos(a), np.sin(a), np.zeros(6)], axis=-1)
        for radius, a in zip((1.0, 0.6), ring, strict=True)
    )
    home = np.array([0.0, 0.0, 1.1])
    linkage = Linkage()
    for k, (foot, head) in enumerate(zip(feet, heads, strict=True)):
        linkage.point(f"B{k}", foot)
        linkage.point(f"C{k}", home + head)
    linkage.link("platform", *(f"C{k}" for k in range(6)))
    for k, leg in enumerate(home + heads - feet):
        across = np.cross(leg, (0.0, 0.0, 1.0))
        linkage.link(f"cylinder {k}", f"B{k}", f"C{k}")
        linkage.link(f"piston {k}", f"C{k}")
        linkage.universal(f"B{k}", "ground", f"cylinder {k}", axis=across, second=np.cross(across, leg))
        linkage.prismatic(f"C{k}", f"cylinder {k}", f"piston {k}", axis=leg, drive=True, name=f"leg {k}")
        linkage.spherical(f"C{k}", f"piston {k}", "platform")
    turns = Rotation.from_rotvec(np.radians([[0.0], [30.0], [60.0], [89.0], [90.0]]) * (0.0, 0.0, 1.0)).as_matrix()
    lengths = np.linalg.norm(home + np.einsum("nij,kj->nki", turns, heads) - feet, axis=-1)
    motion = linkage.move({f"leg {k}": lengths[:, k] - lengths[0, k] for k in range(6)})
    assert motion.status[:4].tolist() == ["regular", "regular", "regular", "near dead point"]
    assert motion.status[4].startswith("singular (direct-kinematic, type II; dead point of C")
    assert (np.diff(motion.conditioning) < 0.0).all()
    assert_allclose(motion.axes("platform")[:4], turns[:4], rtol=0.0, atol=1e-12)


def slider_crank(unit: float) -> Linkage:
    """Crank 0.3 and rod 0.5, drawn with the crank upright, in a unit of length."""
    linkage = Linkage(A=(0, 0), B=(0, 0.3 * unit), C=(0.4 * unit, 0))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("piston", "C")
    linkage.revolute("A", "ground", "crank", drive=True, reference=np.pi / 2)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "piston")
    linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0))
    return linkage


def test_idle_rod_is_no_singularity() -> None:
    motion = rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3).move(O=np.linspace(0.3, 0.9, 7))
    assert (motion.status == "regular").all()
    assert motion.conditioning.min() > 0.1


def test_idle_rod_beside_redundant_constraints() -> None:
    """Bennett's linkage, too firmly held, pushes a slider by a rod that can spin."""
    linkage = bennett(np.pi / 6, np.pi / 3, 1.2)
    linkage.point("F", linkage.points["H2"] + np.array([0.3, 0.2, 1.5]))
    linkage.link("rod", "H2", "F")
    linkage.link("slider", "F")
    linkage.spherical("H2", "link 2", "rod", name="ball")
    linkage.spherical("F", "rod", "slider")
    linkage.prismatic("F", "ground", "slider", axis=(0, 0, 1), name="slide")
    motion = linkage.move(H0=np.linspace(1.1, 1.3, 6))
    assert (motion.status == "regular").all()
    assert motion.conditioning.min() > 1e-2


@pytest.mark.parametrize("unit", [1e-3, 39.37, 1e6])
def test_conditioning_has_no_unit(unit: float) -> None:
    theta = np.linspace(0.0, 3.0, 7)
    one, other = (slider_crank(scale).move(A=theta).conditioning for scale in (1.0, unit))
    assert_allclose(one, other, rtol=1e-12)


@pytest.mark.parametrize(("pitch", "lean"), [(0.1, 0.3), (0.02, 0.6)])
def test_what_a_screw_closes_after_many_turns_can_be_assembled(pitch: float, lean: float) -> None:
    """A nut carries a ball along a helix, an arm of two bars follows to all heights of the helix within its reach."""
    upper, fore, radius, foot = 0.8, 0.7, 0.3, np.array([0.6, 0.2, 0.0])
    axis, across = np.array([np.cos(lean), 0.0, np.sin(lean)]), np.array([0.0, 1.0, 0.0])

    def helix(turned: NDArray[np.float64]) -> NDArray[np.float64]:
        round_it = np.cos(turned)[..., None] * across + np.sin(turned)[..., None] * np.cross(axis, across)
        return foot + radius * round_it + (pitch * turned / (2.0 * np.pi))[..., None] * axis

    ball = helix(np.zeros(()))
    reach = float(np.hypot(*ball[:2]))
    heading = np.arctan2(ball[1], ball[0]) + angle((upper, reach, fore))
    elbow = upper * np.cos(heading), upper * np.sin(heading), ball[2]
    linkage = Linkage(A=(0, 0, 0), E=elbow, P=ball, S=foot)
    linkage.link("upper", "A", "E")
    linkage.link("fore", "E", "P")
    linkage.link("nut", "S", "P")
    linkage.revolute("A", "ground", "upper")
    linkage.cylindrical("E", "upper", "fore", drive="uz")
    linkage.spherical("P", "fore", "nut")
    linkage.screw("S", "ground", "nut", axis=axis, pitch=pitch)
    met = helix(np.linspace(-2.4 * np.pi, 2.4 * np.pi, 100) / pitch)
    away = np.hypot(met[:, 0], met[:, 1])
    within = (away < 0.98 * (upper + fore)) & (away > 1.02 * (upper - fore))
    motion = linkage.move(E=met[within, 2] - ball[2])
    assert within.sum() > 50
    assert np.mean(motion.state == PoseState.NOT_ASSEMBLED) < 0.05


@pytest.mark.parametrize("turn", [Rotation.identity(), TILTED])
def test_transmission_angle_of_a_four_bar(turn: Rotation) -> None:
    """Between coupler and rocker, by the cosine law over the diagonal."""
    theta = np.linspace(0.0, 6.2, 40)
    crank, coupler, rocker, ground = 0.1, 0.25, 0.2, 0.22
    motion = four_bar(crank, coupler, rocker, ground, 0.7, turn=turn).move(A=theta)
    square = crank**2 + ground**2 - 2 * crank * ground * np.cos(theta)
    between = np.arccos((coupler**2 + rocker**2 - square) / (2 * coupler * rocker))
    assert_allclose(motion.transmission_angle("D"), np.minimum(between, np.pi - between), rtol=1e-9)


def test_transmission_angle_at_a_dead_point_and_at_a_dwell() -> None:
    assert_allclose(four_bar(0.1, 0.2, 0.1, 0.2, 0.7).move(A=np.pi).transmission_angle("D"), 0.0, atol=1e-9)
    outer = angle((0.35, 0.22, 0.2))
    between = angle((0.25, 0.2, np.sqrt(0.1**2 + 0.22**2 - 2 * 0.1 * 0.22 * np.cos(outer))))
    assert_allclose(four_bar(0.1, 0.25, 0.2, 0.22, 0.7).move(A=outer).transmission_angle("D"), between, rtol=1e-9)


@pytest.mark.parametrize("beside", [0.0, 1e-9, -1e-6, 1e-3])
def test_transmission_angle_keeps_its_digits_where_it_is_best(beside: float) -> None:
    """Near a right angle, where its sine hardly changes."""
    crank, coupler, rocker, ground = 0.1, 0.24, 0.2, 0.22
    square = np.arccos((crank**2 + ground**2 - coupler**2 - rocker**2) / (2.0 * crank * ground))
    motion = four_bar(crank, coupler, rocker, ground, 0.7).move(A=square + beside)
    more = 4.0 * crank * ground * np.sin(square + 0.5 * beside) * np.sin(0.5 * beside)
    off = np.arcsin(more / (2.0 * coupler * rocker))
    assert_allclose(motion.transmission_angle("D"), 0.5 * np.pi - abs(off), rtol=0.0, atol=1e-14)


def test_transmission_angle_of_a_slider_crank() -> None:
    """Between the rod and the line square to the slide."""
    theta = np.linspace(0.1, 6.0, 20)
    found = slider_crank(1.0).move(A=theta).transmission_angle("C")
    assert_allclose(np.cos(found), np.abs(0.3 * np.sin(theta)) / 0.5, rtol=1e-9)


def test_transmission_angle_in_space() -> None:
    """RSSR: the sine is the share of the rod's push that is square to the rocker."""
    motion = rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3).move(O=np.linspace(0.3, 0.9, 7))
    rod = (motion.position("D") - motion.position("B")) / 0.4
    arm = (motion.position("D") - np.array([0.15, 0.1, 0.3])) / 0.25
    across = np.cross((1.0, 0.0, 0.0), arm)
    assert_allclose(np.sin(motion.transmission_angle("D")), np.abs(np.sum(rod * across, axis=-1)), rtol=1e-9)


def test_transmission_to_the_ground_is_refused() -> None:
    linkage = Linkage(A=(0, 0))
    linkage.link("crank", "A")
    linkage.revolute("A", "crank", "ground", drive=True)
    with pytest.raises(FrameError, match="joint 'A': its second link is the ground"):
        linkage.move(A=0.1).transmission_angle("A")
