"""A four-bar has the figures of every motion, at its singular poses as well."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import FourBar, Link, Motion
from linkframe.models.linkage.graphics.drawn_motion import DrawnMotion
from numpy.testing import assert_allclose
from pictures.test_plots import artists

THETA = np.radians(np.arange(0.0, 360.0, 20.0))


def test_a_four_bar_is_drawn_at_all_poses_where_its_closed_form_has_it() -> None:
    motion = FourBar().move(THETA)
    assert motion.singular[0]
    axes = motion.plot(trace="P", pose=0)
    (path,) = artists(axes, "trace")
    assert_allclose(path.get_xydata(), motion.position("P")[:, :2], atol=1e-15)
    crank = next(line for line in axes.lines if line.get_label() == "crank")
    assert_allclose(crank.get_xydata(), [motion.position(point)[0, :2] for point in "AB"], atol=1e-15)
    half = np.full((len(THETA), 2), 1e-4)
    assert "displacements of P" in motion.plot(trace="P", band=half).get_title(loc="left")
    film = motion.animate()
    film._init_draw()
    film._func(5)
    assert film._fig.axes[0].get_xlabel() == "x [m]"
    with pytest.raises(FrameError, match="no point 'Q'"):
        motion.plot(trace="Q")


def test_a_four_bar_at_a_dead_point_is_drawn_as_it_can_move() -> None:
    """Links of 0.1, 0.2, 0.1 and 0.2 m in line: D goes across, P half way along the coupler half as fast."""
    motion = FourBar().move([0.0, 1.0])
    axes = motion.plot(pose=0)
    ways = {each.xyann[0]: np.subtract(each.xy, each.xyann) for each in artists(axes, "free motion")}
    at = {point: motion.position(point)[0, 0] for point in "DP"}
    assert sorted(ways) == pytest.approx(sorted(at.values()))
    long, short = (next(way for x, way in ways.items() if x == pytest.approx(at[point])) for point in "DP")
    assert_allclose(short, 0.5 * long, atol=1e-15)
    assert_allclose(long[0], 0.0, atol=1e-15)
    assert axes.get_title(loc="left") == "arrows: free motion, drives locked"
    assert not artists(motion.plot(pose=1), "free motion")


def test_all_motions_have_the_same_verbs() -> None:
    verbs = {name for name in vars(DrawnMotion) if not name.startswith("_")}
    assert verbs == {"plot", "animate", "picture", "movie", "show"}
    assert issubclass(Motion, DrawnMotion)


@pytest.mark.parametrize("longest", [0, 1])
def test_reactions_of_a_four_bar_over_its_drive(longest: int) -> None:
    """Under a force on the coupler alone crank and ground carry one force, so that A and B share a curve."""
    theta = np.stack([THETA, THETA + 0.01], axis=1 - longest)
    motion = FourBar(crank=2.0, coupler=7.0, rocker=9.0, ground=6.0).move(theta)
    found = motion.reactions(coupler=Link(force=(0.0, 100.0), at=(3.0, 0.0)))
    axes = found.plot()
    assert [line.get_label() for line in axes.lines] == ["A, B", "D, E"]
    assert_allclose(axes.lines[0].get_xdata(), np.degrees(THETA))
    assert_allclose(axes.lines[0].get_ydata(), np.linalg.norm(found.reaction("B").take(0, 1 - longest), axis=-1))
    assert axes.get_ylim()[0] == 0.0
    drive = found.plot("drives", units=("mm", "N"))
    assert drive.lines[-1].get_label() == "A [N mm]"
    torque = found.drive_torque.take(0, 1 - longest)
    assert_allclose(drive.lines[-1].get_ydata(), torque)
    assert drive.get_ylim()[0] < torque.min() < 0.0
    with pytest.raises(FrameError, match="choose one of joints, drives"):
        found.plot("forces")
