"""A four-bar as a linkage: the same motion, forces and compliance, and what only a linkage can be asked."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import FourBar, Link
from linkframe.models.four_bar.frame import coupler_ends
from numpy.testing import assert_allclose

THETA = np.radians([20.0, 75.0, 140.0, 250.0, 335.0])
POINTS = "ABPDE"


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_random_four_bars_move_alike(branch: str) -> None:
    rng = np.random.default_rng(0)
    four_bar = FourBar(
        crank=rng.uniform(0.05, 0.1, 400),
        coupler=rng.uniform(0.2, 0.3, 400),
        rocker=rng.uniform(0.2, 0.3, 400),
        ground=rng.uniform(0.2, 0.3, 400),
        point=(0.1, 0.03),
        branch=branch,
    )
    theta = rng.uniform(0.0, 6.0, 400)
    theta = np.where(four_bar.assembles(theta) & four_bar.assembles(1.0), theta, 1.0)
    good = four_bar.assembles(theta)
    assert good.mean() > 0.9
    four_bar = FourBar(*(length[good] for length in four_bar.lengths), point=four_bar.point, branch=branch)
    theirs = four_bar.linkage(theta[good]).move(A=theta[good], rates={"A": 1.3}, accelerations={"A": -0.7})
    ours = four_bar.move(theta[good], 1.3, -0.7)
    for point in POINTS:
        assert_allclose(theirs.position(point), ours.position(point), atol=1e-15)
        assert_allclose(theirs.velocity(point), ours.velocity(point), rtol=1e-11, atol=1e-13)
        assert_allclose(theirs.acceleration(point), ours.acceleration(point), rtol=1e-9, atol=1e-11)


def test_forces_and_compliance_are_the_same() -> None:
    four_bar = FourBar(crank=0.05, coupler=0.13, rocker=0.12, ground=0.1, point=(0.06, 0.02))
    linkage = four_bar.linkage(0.3)
    linkage.load("P", fy=100.0)
    theirs, ours = linkage.move(A=THETA), four_bar.move(THETA)
    found = ours.reactions(coupler=Link(force=(0.0, 100.0), at=(0.06, 0.02)))
    assert_allclose(theirs.reactions().drive("A")[:, 0], found.drive_torque, rtol=1e-11)
    assert_allclose(theirs.reactions().force("D", "coupler")[:, :3], found.reaction("D"), rtol=1e-10, atol=1e-9)
    frame = ours.frame()
    frame.load("P", fy=100.0)
    assert_allclose(theirs.frame().solve().displacement("P"), frame.solve().displacement("P"), rtol=1e-10, atol=1e-15)


@pytest.mark.parametrize("point", [(0.0, 0.0), (0.2, 0.0), (0.3, 0.0), (0.3, 1e-3), (-0.1, 0.0), (0.1, 0.05)])
def test_the_point_may_lie_anywhere(point: tuple[float, float]) -> None:
    """Also on a pin, or on the line of the two beyond one of them."""
    four_bar = FourBar(ground=0.22, point=point)
    linkage = four_bar.linkage(0.5)
    linkage.load("P", fx=10.0, fy=100.0)
    frame = four_bar.move(0.5).frame()
    frame.load("P", fx=10.0, fy=100.0)
    found = linkage.move(A=0.5).frame().solve().displacement("P")
    assert_allclose(found, frame.solve().displacement("P"), rtol=1e-9, atol=1e-15)


def test_a_point_beyond_a_pin_moves_alike_whether_or_not_it_is_a_little_off_the_line() -> None:
    """A hair's breadth neither doubles the bar between D and P, nor does another entry of the batch."""
    moved = []
    for point in ((0.3, 0.0), (0.3, 1e-7), (np.array([0.3, 0.31]), 0.0)):
        frame = FourBar(ground=0.22, point=point).move(0.5).frame()
        frame.load("P", fx=10.0, fy=100.0)
        moved.append(frame.solve().displacement("P"))
    assert_allclose(moved[1], moved[0], rtol=1e-5, atol=1e-15)
    assert_allclose(moved[2][0], moved[0], rtol=1e-12, atol=1e-15)
    with pytest.raises(FrameError, match=r"order of B, P, D along it changes within the batch.*: split the batch"):
        FourBar(ground=0.22, point=(np.array([0.1, 0.3]), 0.0)).move(0.5).frame()


@pytest.mark.parametrize("beyond", [0.3, -0.1])
def test_a_point_beyond_a_pin_at_some_entries_and_off_the_line_at_others_is_refused(beyond: float) -> None:
    """Alone the one has its bar through the three points in their order, the other one that is bent at P."""
    four_bar = FourBar(ground=0.22, point=(beyond, np.array([0.0, 0.03])))
    for described in (lambda: four_bar.move(0.5).frame(), lambda: four_bar.linkage(0.5)):
        with pytest.raises(FrameError, match=r"runs back .* B, P, D at some entries .* not straight at others: split"):
            described()


def test_a_point_between_the_pins_at_some_entries_and_off_the_line_at_others_is_taken() -> None:
    heights, moved = np.array([0.0, 0.03]), []
    for y in (heights, *heights):
        frame = FourBar(ground=0.22, point=(0.1, y)).move(0.5).frame()
        frame.load("P", fx=10.0, fy=100.0)
        moved.append(frame.solve().displacement("P"))
    assert_allclose(moved[0], moved[1:], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("unit", [1e-150, 1e-80, 1e80, 1e150])
def test_the_bars_of_the_coupler_are_the_same_in_any_unit(unit: float) -> None:
    for point, first in (((0.3, 1e-3), ("B", "D")), ((0.3, 0.2), ("B", "P")), ((-0.1, 0.0), ("P", "B"))):
        lengths = (unit * length for length in (0.05, 0.2, 0.2, 0.22))
        four_bar = FourBar(*lengths, point=(unit * point[0], unit * point[1]))
        assert coupler_ends(four_bar)[0] == first


def test_clearances_go_with_it() -> None:
    four_bar = FourBar(ground=0.22)
    linkage = four_bar.linkage(0.5, {"B": 1e-4})
    assert float(linkage.joints["B"].clearance) == 1e-4
    assert linkage.joints["D"].clearance is None
    with pytest.raises(FrameError, match="clearance"):
        four_bar.linkage(0.5, {"B": -1e-4})
    with pytest.raises(FrameError, match="'C'"):
        four_bar.linkage(0.5, {"C": 1e-4})


def test_a_linkage_knows_more() -> None:
    """The cosine law tells the ends of the drive's range: where coupler and rocker are in line."""
    four_bar = FourBar(crank=3.0, coupler=4.0, rocker=2.0, ground=4.0)
    linkage = four_bar.linkage(1.0)
    limit = np.arccos((3.0**2 + 4.0**2 - 6.0**2) / (2.0 * 3.0 * 4.0))
    assert_allclose(linkage.drive_range("A").upper, limit, rtol=1e-12)
    assert linkage.mobility().actual == 1
    with pytest.raises(FrameError, match="cannot be assembled"):
        four_bar.linkage(limit + 0.01)
