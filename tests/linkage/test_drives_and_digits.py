"""Too few drives, too many, and too few digits in the drawing: told, with the remedy."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.continuation.many_paths import Derivatives
from linkframe.models.linkage.zone import driven_values
from numpy.testing import assert_allclose
from reference.linkages import PLANAR, bennett, loop, rssr
from scipy.spatial.transform import Rotation

POINTS = {"A": (0.0, 0.0), "B": (-0.5, 1.0), "C": (1.0, 2.0), "D": (2.5, 1.0), "E": (2.0, 0.0)}


def five_bar(*drives: str) -> Linkage:
    linkage = Linkage(POINTS)
    links = ("AB", "BC", "CD", "DE")
    for link in links:
        linkage.link(link, *link)
    for joint, first, second in zip("ABCDE", ("ground", *links), (*links, "ground"), strict=True):
        linkage.revolute(joint, first, second, drive=joint in drives)
    return linkage


# -- drives ----------------------------------------------------------------------------------------------------------


def test_missing_drive_is_named():
    with pytest.raises(
        FrameError,
        match=r"^underdetermined: 1 degree of freedom has no drive \(driven: A\).*also drive B or C or D or E$",
    ):
        five_bar("A").move(A=[0.1, 0.2])
    assert np.all(five_bar("A", "E").move(A=[0.1, 0.2], E=0.1).status == "regular")
    assert five_bar().move().status == "regular"  # without drives it stands still


def test_chain_without_its_second_drive():
    arm = Linkage(A=(0, 0), B=(1, 0), C=(2, 0), D=(3, 0))
    for link in ("AB", "BC", "CD"):
        arm.link(link, *link)
    arm.revolute("A", "ground", "AB", drive=True)
    arm.revolute("B", "AB", "BC")
    arm.cylindrical("C", "BC", "CD", drive="uz")
    with pytest.raises(FrameError, match=r"^underdetermined: 2 degrees of freedom have no drive"):
        arm.move(A=0.1)
    arm.drive("B")
    with pytest.raises(
        FrameError, match=r"^underdetermined: 1 degree of freedom has no drive.*: also drive C \(rz too\)$"
    ):
        arm.move(A=0.1)
    arm.drive("C")
    assert_allclose(arm.move(B=np.pi / 2).position("D"), (1.0, 2.0, 0.0), atol=1e-15)


def square() -> Linkage:
    """A parallelogram that both cranks drive."""
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(1, 1), D=(1, 0))
    for link in ("AB", "BC", "CD"):
        linkage.link(link, *link)
    linkage.revolute("A", "ground", "AB", drive=True)
    linkage.revolute("B", "AB", "BC")
    linkage.revolute("C", "BC", "CD")
    linkage.revolute("D", "CD", "ground", drive=True)
    return linkage


def test_rates_of_more_drives_than_freedoms_that_agree():
    """The coupler moves on a circle: its velocity and acceleration in closed form; D counts from the rocker."""
    angle, rate, gain = np.array([0.1, -0.3]), 2.0, 5.0
    motion = square().move(A=angle, D=-angle, rates={"A": rate, "D": -rate}, accelerations={"A": gain, "D": -gain})
    out, along = np.array([-np.sin(angle), np.cos(angle)]), np.array([-np.cos(angle), -np.sin(angle)])
    for link in ("BC", "CD"):
        assert_allclose(motion.velocity("C", link)[:, :2], (rate * along).T, atol=1e-14)
        assert_allclose(motion.acceleration("C", link)[:, :2], (gain * along - rate**2 * out).T, atol=1e-13)


def test_steady_rates_of_a_parallelogram_agree_whatever_its_lengths_round_to():
    """The coupler does not turn: what its rates add to the accelerations cancels, but for rounding."""
    b, rate = np.array([0.05, 0.0866]), 3.0
    linkage = Linkage(A=(0, 0), B=b, D=(0.25, b[1]), E=(0.2, 0))
    for link, ends in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        linkage.link(link, *ends)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground", drive=True)
    angle = np.linspace(0.0, 1.0, 20)
    motion = linkage.move(A=angle, E=-angle, rates={"A": rate, "E": -rate})
    moved = [np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]]) @ b for t in angle]
    assert_allclose(motion.acceleration("D")[:, :2], -(rate**2) * np.array(moved), rtol=1e-12)
    with pytest.raises(FrameError, match="their accelerations do not agree"):
        linkage.move(A=angle, E=-angle, rates={"A": rate, "E": -rate}, accelerations={"A": 0.01 * rate**2})


@pytest.mark.parametrize(
    ("rates", "accelerations", "told"),
    [
        ({"A": 1.0, "D": [-1.0, -1.0, -2.0]}, {}, "their rates do not agree at pose 2: give rates"),
        ({"A": 1.0, "D": 1.0}, {}, "their rates do not agree at pose 0: give rates"),
        ({"A": 1.0, "D": -1.01}, {}, "their rates do not agree at pose 0: give rates"),
        ({"A": 1.0, "D": -1.0}, {"A": 1.0}, "their accelerations do not agree at pose 0"),
    ],
)
def test_rates_of_more_drives_than_freedoms_that_do_not_agree_are_refused(rates, accelerations, told):
    angle = np.array([0.1, 0.2, 0.3])
    with pytest.raises(FrameError, match=f"^2 drives for 1 degree of freedom: {told}"):
        square().move(A=angle, D=-angle, rates=rates, accelerations=accelerations)
    one = {name: np.ravel(value)[-1] for name, value in rates.items()}
    with pytest.raises(FrameError, match=f"^2 drives for 1 degree of freedom: {told.split(' at ')[0]}: give"):
        square().move(A=0.1, D=-0.1, rates=one, accelerations=accelerations)


def test_spin_that_moves_no_point_needs_no_drive():
    assert rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3).move(O=0.5).status == "regular"


def test_drives_that_do_not_agree_are_counted():
    linkage = five_bar("A", "E", "C")
    status = linkage.move(A=[0.0, 0.1]).status
    assert status[0] == "regular"
    assert status[1].endswith("; 3 drives for 2 degrees of freedom: their values do not agree")
    turned = five_bar("A", "E").move(A=0.1).coordinate("C")[..., 0]
    assert linkage.move(A=0.1, C=turned).status == "regular"  # one too many, in agreement with the others


# -- digits ----------------------------------------------------------------------------------------------------------


def rounded(exact: Linkage, digits: int, unit: float, turn: Rotation = PLANAR) -> Linkage:
    """The hinges of a linkage as a drawing with few digits has them."""
    linkage = Linkage({name: unit * np.round(turn.apply(place.copy()), digits) for name, place in exact.points.items()})
    for name, link in exact.links.items():
        linkage.link(name, *link.points)
    for name, joint in exact.joints.items():
        axis = np.round(turn.apply(joint.axes[..., 2]), digits)
        linkage.revolute(
            name, joint.first, joint.second, axis=axis, drive=name in exact.drives, reference=joint.reference[..., 0]
        )
    return linkage


@pytest.mark.parametrize("digits", [10, 8, 6, 3])
@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_bennett_drawn_with_few_digits_moves_within_a_tolerance(digits: int, unit: float):
    exact = bennett(np.pi / 6, np.pi / 3, 1.2)
    linkage, tolerance, theta = rounded(exact, digits, unit), 8.0 * unit * 10.0**-digits, np.linspace(1.2, 6.0, 25)
    motion = linkage.move(H0=theta, tolerance=tolerance)
    assert np.all(motion.status == "regular")
    assert np.all((motion.gap <= tolerance) & (motion.gap[0] < 1e-12 * unit))
    assert motion.gap.max() > 1e-2 * tolerance
    away = motion.position("H2") - unit * exact.move(H0=theta).position("H2")
    assert np.abs(away).max() < tolerance
    found = linkage.mobility(tolerance)
    assert (found.actual, found.instantaneous, len(found.redundant)) == (1, 1, 3)


@pytest.mark.parametrize("digits", [8, 6, 4])
def test_range_within_a_tolerance(digits: int):
    """Bricard's linkage folds at 120°, see `test_dead_points`; here askew, as a drawing with few digits has it."""
    quarter, tolerance = np.pi / 2, 8.0 * 10.0**-digits
    exact = loop((1.0,) * 6, (quarter, -quarter) * 3, (quarter,) * 6)
    found = rounded(exact, digits, 1.0, Rotation.from_rotvec([0.4, -1.1, 0.7])).drive_range("H0", tolerance=tolerance)
    assert_allclose([found.lower, found.upper], np.radians([-120.0, 120.0]), rtol=0.0, atol=20.0 * tolerance)
    turning = rounded(bennett(np.pi / 6, np.pi / 3, 1.2), digits, 1.0)
    assert turning.drive_range("H0", tolerance=tolerance).upper == np.inf
    assert turning.dead_points("H0", tolerance=tolerance) == ()


def test_few_digits_are_told():
    linkage = rounded(bennett(np.pi / 6, np.pi / 3, 1.2), 6, 1.0)
    motion = linkage.move(H0=[1.2, 2.0])
    assert motion.status[0] == "regular"
    assert "at joint H2; overconstrained: give the points with more digits, or accept" in motion.status[1]
    assert np.isnan(motion.position("H2")[1]).all()
    assert "its points have too few digits" in str(linkage.mobility())
    assert linkage.mobility().nearly == 1
    # Nothing would make this one move.
    rigid = loop((1.0, 0.7, 0.9, 1.2), (0.5, 0.9, -0.4, 0.3), (0.3, 0.8, -0.5, 1.1))
    assert rigid.move(H0=0.5).status[()].endswith("1 drive for 0 degrees of freedom: their values do not agree")
    assert "digits" not in str(rigid.mobility())


@pytest.mark.parametrize("digits", [12, 11, 9, 8, 6, 3])
def test_few_digits_are_told_of_ranges_and_dead_points(digits: int):
    linkage = rounded(bennett(np.pi / 6, np.pi / 3, 1.2), digits, 1.0)
    for ask in (linkage.drive_range, linkage.dead_points):
        with pytest.raises(FrameError, match=r"'H0' cannot move.*too few digits: give more, or give tolerance="):
            ask("H0")


def test_gap_of_a_drawing_can_be_let_be():
    """Two bars in line between fixed pins, together 1e-4 too short."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
    linkage.link("a", "A", "B", length=1.0 - 1e-4)
    linkage.link("b", "B", "C")
    linkage.revolute("A", "ground", "a")
    linkage.revolute("B", "a", "b")
    linkage.revolute("C", "b", "ground")
    with pytest.raises(FrameError, match=r"a gap of 0.0001 remains at joint 'B'.*tolerance="):
        linkage.move()
    assert_allclose(linkage.move(tolerance=2e-4).gap, 1e-4, rtol=1e-6)
    with pytest.raises(FrameError, match="tolerance is -1: give a length, 0 or above"):
        linkage.move(tolerance=-1.0)


# -- drawing ---------------------------------------------------------------------------------------------------------


def test_nothing_has_no_freedom():
    found = Linkage().mobility()
    assert (found.actual, found.kutzbach, found.redundant) == (0, 0, ())


def test_axes_in_the_plane_have_two_components():
    sliders = [Linkage(A=(0, 0)) for _ in range(2)]
    for slider, axis in zip(sliders, ((1, 1), (1, 1, 0)), strict=True):
        slider.link("block", "A")
        slider.prismatic("A", "ground", "block", axis=axis, drive=True)
    assert_allclose(*(slider.move(A=2**0.5).position("A") for slider in sliders), rtol=0.0, atol=0.0)


def test_one_of_two_coordinates_is_driven_from_its_own_reference() -> None:
    """A sleeve drawn at 0.1 m and 0.5 rad, which stands on a table: only its angle is driven, by what lies between."""
    linkage = Linkage(A=(0, 0), B=(2, 0))
    linkage.link("sleeve", "A", "B")
    linkage.cylindrical("A", "ground", "sleeve", drive="rz", reference=(0.1, 0.5))
    linkage.planar("B", "ground", "sleeve")
    motion = linkage.move(A=[0.5, 0.9])
    angle = np.array([0.0, 0.4])
    assert_allclose(motion.position("B")[:, :2], 2.0 * np.stack([np.cos(angle), np.sin(angle)], -1))
    assert_allclose(driven_values(motion, "A"), [0.5, 0.9])


def test_rates_of_poses_that_are_not_assembled_are_no_matter():
    status = square().move(A=[0.1, 0.2], D=[-0.1, -0.6], rates={"A": 1.0, "D": -1.0}).status
    assert status[0] == "regular"
    assert status[1].startswith("not assembled")


def test_of_many_poses_the_one_whose_rates_do_not_agree_is_named():
    angle = np.linspace(0.0, 0.5, 5000)
    rate = np.where(np.arange(5000) == 4500, 2.0, 1.0)
    with pytest.raises(FrameError, match="their rates do not agree at pose 4500: give rates"):
        square().move(A=angle, D=-angle, rates={"A": rate, "D": -1.0})


def test_a_pose_that_two_drives_move_together_is_predicted_to_the_second_order():
    """Half the step leaves an eighth of the error; so with each of the drives alone."""
    linkage = five_bar("A", "E")
    nominal, loops, start = linkage.move().mechanism.begun
    derivatives = Derivatives.of(loops, nominal, start)
    for way in ((1.0, -0.7), (1.0, 0.0), (0.0, 1.0)):
        errors = []
        for step in (0.02, 0.01):
            first, second = derivatives.along(step * np.array(way)[:, None])
            there = linkage.move(A=step * way[0], E=step * way[1]).assembly.state
            errors.append(np.linalg.norm(np.array(start.state) + (first + 0.5 * second)[:, 0] - there))
        assert 7.0 < errors[0] / errors[1] < 9.0
