"""Singular poses as answers: the free motion, what works on it, how far away it is, and where linear results end."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning
from linkframe.models import FourBar
from numpy.testing import assert_allclose
from reference.as_frame import as_frame
from reference.four_bar import LENGTH, coordinates, four_bar

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=2e11, nu=0.3))
PIN = Joint(stiffness=(np.inf,) * 5 + (0.0,))


def folded(**load: float) -> Frame:
    """The paper's linkage at 0, 30 and 180 degrees, loaded at P."""
    frame = FourBar().move(np.radians([0.0, 30.0, 180.0])).frame()
    frame.load("P", **load)
    return frame


def test_the_folded_four_bar_moves_across_its_line() -> None:
    """At 0 degrees D moves by one, P by half of it; rocker and coupler turn about B, D and E as the lengths say."""
    motion = folded(fy=-100.0).solve().free_motion(0)
    assert motion.count == 1
    d, p = motion.displacement("D.coupler")[0], motion.displacement("P")[0]
    assert_allclose(d[:2], [0.0, -1.0], atol=1e-12)
    assert_allclose(p[:2], [0.0, -0.5], atol=1e-12)
    coupler, rocker = -1.0 / (2 * LENGTH), -1.0 / LENGTH
    assert_allclose(motion.joints["B"][0, 5], coupler, rtol=1e-10)
    assert_allclose(motion.joints["D"][0, 5], rocker - coupler, rtol=1e-10)
    assert_allclose(motion.joints["E"][0, 5], -rocker, rtol=1e-10)
    assert_allclose(motion.joints["D"][0, :5], 0.0, atol=1e-12)
    assert_allclose(motion.work["P"], [50.0], rtol=1e-10)
    assert_allclose(motion.drive, [50.0], rtol=1e-10)
    assert not motion.solvable


def test_a_load_along_the_line_is_in_equilibrium() -> None:
    """It does no work on the free motion."""
    motion = folded(fx=100.0).solve().free_motion(2)
    assert motion.count == 1
    assert motion.solvable
    assert_allclose(motion.drive, 0.0, atol=1e-9)


def test_a_regular_pose_has_no_free_motion() -> None:
    motion = folded(fy=100.0).solve().free_motion(1)
    assert motion.count == 0
    assert motion.solvable
    assert motion.displacement("P").shape == (0, 6)


def test_all_work_is_done_on_the_first_of_several_motions() -> None:
    """A floating bar has six; a force and a couple drive one combination of them."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.load("B", fy=2.0, mx=0.3)
    frame.load("A", fz=-1.0)
    motion = frame.solve().free_motion()
    assert motion.count == 6
    assert motion.drive[0] > 0.1
    assert_allclose(motion.drive[1:], 0.0, atol=1e-10)
    assert_allclose(motion.work["A"] + motion.work["B"], motion.drive, atol=1e-12)
    moved = np.concatenate([motion.displacement(node) for node in "AB"], axis=-1)
    assert np.linalg.matrix_rank(moved) == 6
    # each is a rigid motion: the bar keeps its length
    assert_allclose(moved[:, 6] - moved[:, 0], 0.0, atol=1e-12)


def test_an_offset_drives_what_no_load_does() -> None:
    """A misfit across two clamps on a slider: the spring between them is all that resists."""
    frame = Frame()
    frame.node("ground", (0.0, 0.0, 0.0))
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("slide", Joint(stiffness=(0.0,) + (np.inf,) * 5), "ground", "A")
    frame.add("AB", BAR, "A", "B")
    frame.fix("ground")
    frame.load("B", fy=1.0)
    frame.offset("slide", uy=1e-3)
    motion = frame.solve().free_motion()
    assert motion.count == 1
    assert motion.solvable
    assert_allclose(np.abs(motion.displacement("B")), [[1.0, 0.0, 0.0, 0.0, 0.0, 0.0]], atol=1e-12)
    with pytest.raises(FrameError, match="Q"):
        motion.displacement("Q")


def test_distance_falls_with_the_angle() -> None:
    """In proportion to it near the singular pose, to rounding at it."""
    angles = np.array([0.0, 1e-6, 1e-4, 1e-2])
    frame = FourBar().move(np.radians(angles)).frame()
    frame.load("P", fy=1.0)
    distance = frame.solve().distance_to_singularity()
    assert distance[0] < 1e-15
    assert_allclose(distance[1:] / angles[1:], distance[3] / angles[3], rtol=1e-4)


def test_a_large_frame_has_a_distance_too() -> None:
    """By the factor of the sparse way as by singular values."""
    frame = Frame()
    for k in range(25):
        frame.node(f"n{k}", (float(k), 0.3 * (k % 2), 0.0))
        if k:
            frame.add(f"m{k}", BAR, f"n{k - 1}", f"n{k}")
    frame.fix("n0")
    frame.load("n24", fz=1.0)
    assert_allclose(
        frame.solve("sparse").distance_to_singularity(), frame.solve("broadcast").distance_to_singularity(), rtol=1e-3
    )


@pytest.mark.parametrize("angle", [1e-5, 3e-6, 1e-6])
def test_regular_poses_that_double_precision_calls_singular(angle: float) -> None:
    """They are solved all the same, and agree with 50 digits within their bound."""
    from reference.stiffness_method import mp, solve

    structure = four_bar(coordinates(angle), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))
    solution = as_frame(structure).solve()
    assert solution.status == "regular"
    exact = solve(structure).displacement["P"]
    refined, left = solution.refined("P")
    for found, bound in ((solution.displacement("P"), solution.error_bound("P")), (refined, left)):
        assert all(abs(mp.mpf(float(a)) - b) <= mp.mpf(float(c)) for a, b, c in zip(found, exact, bound, strict=True))
    assert left[1] < 1e-2 * abs(refined[1])
    assert not solution.linear


def test_a_column_by_its_buckling_load() -> None:
    """The sway that P adds to that of a small side force, to first order, is P L^2 / 3 E I of it."""
    length, thrust = 1.0, np.array([0.0, 10.0, 100.0])
    rod = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3))
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (length, 0.0, 0.0))
    frame.add("AB", rod, "A", "B")
    frame.fix("A")
    frame.load("B", fx=-thrust, fy=1e-3)
    stiffness = 2e11 * np.pi * 0.02**4 / 64
    solution = frame.solve()
    off = solution.nonlinearity()
    # the work of the thrust on the bar's own shortening counts in the energy of the solution
    shortening = thrust**2 * length / (2e11 * np.pi * 0.02**2 / 4)
    bending = 1e-6 * length**3 / (3 * stiffness)
    expected = thrust * length**2 / (3 * stiffness) * np.sqrt(bending / (bending + shortening))
    assert_allclose(off[1:], expected[1:], rtol=1e-4)
    assert solution.linear.all()


def test_a_cantilever_by_its_slope() -> None:
    """Half the slope of its chord, while nothing else is out of balance; beyond a tenth it is not linear."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    stiffness = 2e11 * 0.01 * 0.02**3 / 12
    slope = np.array([0.0, 1e-3, 0.09, 0.11])
    frame.load("B", fy=3 * stiffness * slope)
    solution = frame.solve()
    assert_allclose(solution.nonlinearity(), slope / 2, rtol=1e-3)
    assert list(solution.linear) == [True, True, True, False]


def test_a_mechanism_is_not_linear() -> None:
    solution = folded(fy=100.0).solve()
    assert list(solution.linear) == [False, True, False]
    assert np.isinf(solution.nonlinearity()[[0, 2]]).all()
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.displacement("P")[0]).all()


@pytest.mark.parametrize("shape", [(1,), (1, 1), (1, 1, 1)])
@pytest.mark.parametrize("segments", [1, 3])
def test_batches_of_several_axes(shape: tuple[int, ...], segments: int) -> None:
    """Members whose numbers have axes of size one, in a batch of three axes of which some entries are mechanisms."""
    beam = Beam(Rectangle(y=0.02, z=0.01), Material(E=np.full(shape, 2e11), nu=0.3), segments=segments)
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    turning = np.array([0.0, 1e5, 0.0, 2e5]).reshape(2, 1, 2)
    stiffness = np.stack([np.full_like(turning, np.inf)] * 5 + [turning], axis=-1)
    frame.add("AB", beam, "A", "B")
    frame.add("CD", beam, "C", "D")
    frame.add("hinge", Joint(stiffness=stiffness), "B", "C")
    frame.fix("A")
    frame.load("D", fy=np.ones((2, 3, 2)))
    expected = np.where(turning == 0.0, "mechanism", "regular")
    np.testing.assert_array_equal(frame.solve().status, np.broadcast_to(expected, (2, 3, 2)))
