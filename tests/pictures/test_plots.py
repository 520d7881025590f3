"""Figures by one call: what is drawn lies where it is computed, symbols tell what there is, labels are legible."""

from __future__ import annotations

import subprocess
import sys
from itertools import pairwise
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, Solution
from linkframe.models import Linkage, plot_histogram
from linkframe.models.normality import anderson_darling
from matplotlib.backends.backend_agg import FigureCanvasAgg
from numpy.testing import assert_allclose
from scipy import stats

mpl.use("Agg")
BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


def four_bar() -> Linkage:
    """With a ternary coupler, a spring to the ground, a slider on the rocker and a load."""
    linkage = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0), S=(0.23, 0.08))
    linkage.link("crank", "A", "B", beam=BAR)
    linkage.link("coupler", "B", "P", "D", beam=BAR)
    linkage.link("rocker", "D", "E", "S", beam=BAR)
    linkage.link("block", "S", mass=0.1)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    linkage.prismatic("S", "rocker", "block", axis=(0.01, 0.08), drive=True)
    linkage.spring("P", ("ground", "E"), stiffness=10.0, length=0.1)
    linkage.load("P", fy=1.2e4)
    return linkage


def bricard() -> Linkage:
    """A spatial chain: an arm about z that carries another about x."""
    linkage = Linkage(O=(0, 0, 0), A=(0.3, 0, 0), B=(0.3, 0.2, 0.1))
    linkage.link("arm", "O", "A")
    linkage.link("hand", "A", "B")
    linkage.revolute("O", "ground", "arm", drive=True)
    linkage.revolute("A", "arm", "hand", axis=(1, 0, 0), drive=True)
    return linkage


def artists(axes: Any, gid: str) -> list[Any]:
    return [each for each in axes.get_children() if each.get_gid() == gid]


# -- linkages and motions ---------------------------------------------------------------------------------------------


def test_a_linkage_has_a_symbol_for_each_joint_where_it_is() -> None:
    linkage = four_bar()
    axes = linkage.plot()
    for name, pair in linkage.joints.items():
        (patch,) = artists(axes, f"joint {name}")
        corners = patch.get_xy()
        assert_allclose(0.5 * (corners.min(axis=0) + corners.max(axis=0)), linkage.points[pair.point][:2], atol=1e-12)
        assert patch.get_facecolor()[:3] == (mpl.colors.to_rgb("#d55e00") if name in "AS" else (1.0, 1.0, 1.0))
    # Round pins, and a slider that is longer along its axis than across.
    assert len(artists(axes, "joint B")[0].get_xy()) > 40
    assert len(artists(axes, "joint S")[0].get_xy()) == 5
    assert len(artists(axes, "support")) == 2
    # The coil goes to and fro and ends at its points.
    (spring,) = artists(axes, "spring")
    assert_allclose(spring.get_xydata()[[0, -1]], [linkage.points[p][:2] for p in "PE"], atol=1e-15)
    way = np.diff(spring.get_xydata()[[0, -1]], axis=0)[0]
    aside = np.diff(np.sign((spring.get_xydata() - linkage.points["P"][:2]) @ [way[1], -way[0]]))
    assert np.count_nonzero(aside) >= 10
    texts = [text.get_text() for text in axes.texts]
    assert {*linkage.points, "12 kN"} <= set(texts)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "y [m]")
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["crank", "coupler", "rocker"]


def test_a_ternary_link_is_an_area_though_its_beams_leave_it_open() -> None:
    axes = four_bar().plot()
    (area, *_) = artists(axes, "link")
    found = [each for each in artists(axes, "link") if hasattr(each, "get_xy") and len(each.get_xy()) == 4]
    assert found
    assert area is not None
    wanted = {tuple(four_bar().points[p][:2].round(12)) for p in "BPD"}
    assert {tuple(corner) for corner in found[0].get_xy().round(12)} == wanted


def test_a_motion_is_drawn_at_its_pose_with_its_path() -> None:
    motion = four_bar().move(A=np.linspace(0.0, 2.0, 9), S=0.01)
    axes = motion.plot(pose=4, trace=("P", "D"), ghosts=0)
    for line, point in zip(artists(axes, "trace"), "PD", strict=True):
        assert_allclose(line.get_xydata(), motion.position(point)[:, :2], rtol=0.0, atol=1e-12)
    crank = next(line for line in axes.lines if line.get_label() == "crank")
    assert_allclose(crank.get_xydata(), [motion.position(p)[4, :2] for p in "AB"], rtol=0.0, atol=1e-12)
    given = plt.figure().add_subplot()
    assert motion.plot(given, pose=0) is given


def test_limits_hug_what_is_drawn() -> None:
    axes = four_bar().move(A=np.linspace(0.0, 2.0, 9)).plot(loads=False, trace="P")
    low, high = zip(axes.get_xlim(), axes.get_ylim(), strict=True)
    lines = np.concatenate([line.get_xydata() for line in axes.lines])
    assert np.all(np.ptp(lines, axis=0) > 0.85 * np.subtract(high, low))
    assert np.all(lines.min(axis=0) >= low)
    assert np.all(lines.max(axis=0) <= high)


def test_a_motion_in_space_has_axes_in_space() -> None:
    linkage = bricard()
    motion = linkage.move(O=np.linspace(0.0, 1.0, 5), A=np.linspace(0.0, 2.0, 5))
    axes: Any = motion.plot(trace="B", pose=2)
    assert axes.name == "3d"
    (path,) = artists(axes, "trace")
    assert_allclose(np.stack(path.get_data_3d(), axis=-1), motion.position("B"), rtol=0.0, atol=1e-12)
    with pytest.raises(FrameError, match="projection='3d'"):
        linkage.plot(plt.figure().add_subplot())
    flat = plt.figure().add_subplot(projection="3d")
    assert four_bar().plot(flat) is flat


@pytest.mark.parametrize("shape", [(7, 30, 2), (7, 3), (7, 2)])
def test_a_band_holds_all_its_samples(shape: tuple[int, ...]) -> None:
    motion = four_bar().move(A=np.linspace(0.0, 2.0, 7))
    band = 1e-3 * np.random.default_rng(0).random(shape)
    axes = motion.plot(trace="P", band=band, magnify=10.0)
    assert axes.get_title(loc="left") == "displacements of P × 10"
    parts = [patch.get_path() for patch in artists(axes, "band")]
    spread = band if band.ndim == 3 else band[:, None] * np.array([[1.0], [-1.0]])
    for place in (motion.position("P")[:, None, :2] + 10.0 * spread[..., :2]).reshape(-1, 2):
        assert any(part.contains_point(place, radius=1e-9) for part in parts)
    with pytest.raises(FrameError, match=r"band has shape \(3, 2\) and the motion \(7,\)"):
        motion.plot(trace="P", band=np.zeros((3, 2)))
    with pytest.raises(FrameError, match="trace= names 2"):
        motion.plot(trace=("P", "D"), band=band)


def test_an_animation_keeps_its_limits_and_moves_what_is_drawn() -> None:
    motion = four_bar().move(A=np.linspace(0.0, 2.0, 4))
    film: Any = motion.animate(trace="P")
    film._init_draw()
    axes = film._fig.axes[0]
    limits, count = axes.get_xlim(), len(axes.get_children())
    for pose in (3, 1):
        film._func(pose)
        crank = next(line for line in axes.lines if line.get_label() == "crank")
        assert_allclose(crank.get_xydata()[1], motion.position("B")[pose, :2], atol=1e-12)
        assert (axes.get_xlim(), len(axes.get_children())) == (limits, count)


def test_what_cannot_be_drawn_is_told() -> None:
    with pytest.raises(FrameError, match="no points"):
        Linkage().plot()
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(3, 1), D=(3.5, 0))
    for k, link in enumerate(("AB", "BC", "CD")):
        linkage.link(link, *link)
        linkage.revolute("ABCD"[k], ("ground", "AB", "BC")[k], link, drive=k == 0)
    linkage.revolute("D", "CD", "ground")
    with pytest.raises(FrameError, match="no pose of the motion is assembled"):
        linkage.move(A=[np.pi / 2]).plot()
    motion = linkage.move(A=[0.0, np.pi / 2])
    assert motion.plot(trace="C").get_xlabel() == "x [m]"
    for wrong, told in ((1, r"pose 1 cannot be drawn, it is not assembled"), (2, r"give one index")):
        with pytest.raises(FrameError, match=told):
            motion.plot(pose=wrong)
    with pytest.raises(FrameError, match=r"entry=1, but the linkage has a batch of 1"):
        linkage.plot(entry=1)


# -- numbers along axes -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("size", [1.0, 1e-4, 123.456])
@pytest.mark.parametrize("width", [2.6, 6.4])
def test_numbers_along_the_axes_do_not_touch(size: float, width: float) -> None:
    linkage = Linkage(A=(0, 0), B=(size, 0.3 * size))
    linkage.link("arm", "A", "B")
    linkage.revolute("A", "ground", "arm", drive=True)
    figure = plt.figure(figsize=(width, 0.7 * width), layout="constrained")
    linkage.plot(figure.add_subplot())
    legible(figure)


def legible(figure: Any) -> None:
    """Numbers along each axis have room between them, and lie in the figure."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    for axes in figure.axes:
        for axis, way in ((axes.xaxis, "x"), (axes.yaxis, "y")):
            low, high = sorted(axis.get_view_interval())
            shown = [t for t in axis.get_major_ticks() if low <= t.get_loc() <= high and t.label1.get_text()]
            boxes = [getattr(tick.label1.get_window_extent(renderer), f"interval{way}") for tick in shown]
            assert all(one[1] < other[0] for one, other in pairwise(sorted(map(tuple, boxes))))


# -- solutions --------------------------------------------------------------------------------------------------------


def cantilever() -> Solution:
    """A clamped corner under a force along y at its end, and along its second leg."""
    frame = Frame()
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "C": (1.0, 0.5, 0.0)}.items():
        frame.node(name, place)
    frame.add("AB", BAR, "A", "B")
    frame.add("BC", BAR, "B", "C")
    frame.fix("A")
    frame.load("C", fx=10.0)
    return frame.solve()


def test_the_deformed_shape_is_the_displacement() -> None:
    solution = cantilever()
    axes = solution.plot(scale=100.0)
    members = artists(axes, "member")
    assert len(members) == 2
    for line, name in zip(members, ("AB", "BC"), strict=True):
        start, end = (solution.frame.position(node)[:2] for node in name)
        share = np.linspace(0.0, 1.0, len(line.get_xydata()))
        moved = solution.displacement_along(name, share * np.linalg.norm(end - start))[:, :2]
        assert_allclose(line.get_xydata(), start + share[:, None] * (end - start) + 100.0 * moved, atol=1e-12)
    assert len(artists(axes, "support")) == 1
    assert axes.get_title(loc="left") == "displacements × 100"


def test_moments_are_drawn_on_the_side_in_tension() -> None:
    """Force along x at the top of the leg: M = -10 (0.5 - y) in it, and -5 all along the arm, whose top is pulled."""
    axes = cantilever().plot("M")
    arm, leg = (patch.get_xy() for patch in artists(axes, "diagram") if hasattr(patch, "get_xy"))
    assert arm[:, 1].max() == pytest.approx(0.13 * np.hypot(1.0, 0.5))
    assert arm[:, 1].min() == 0.0
    assert leg[:, 0].min() == pytest.approx(1.0 - 0.13 * np.hypot(1.0, 0.5))
    told = [text.get_text() for text in axes.texts if text.get_gid() == "value"]
    assert set(told) == {"5"} or set(told) == {"−5"}
    assert "bending moment M [N m]" in axes.get_title(loc="left")


def test_normal_and_shear_forces_are_told_with_their_units() -> None:
    for what, wanted in (("N", {"10"}), ("V", {"10"})):
        axes = cantilever().plot(what, units=("mm", "N"))
        told = {text.get_text().lstrip("−") for text in axes.texts if text.get_gid() == "value"}
        assert told == wanted
        assert axes.get_title(loc="left").endswith("[N]")
        assert axes.get_xlabel() == "x [mm]"


def test_stress_has_a_bar_of_colours_with_its_unit() -> None:
    solution = cantilever()
    axes = solution.plot("von_mises")
    bar = axes.figure.axes[1]
    assert bar.get_ylabel() == "von Mises stress [MPa]"
    greatest = 1e-6 * np.nanmax(solution.stresses_at(np.linspace(0.0, 1.0, 25))[..., 2])
    assert bar.get_ylim()[1] == pytest.approx(greatest)
    with pytest.raises(FrameError, match="choose one of deformed, von_mises, N"):
        solution.plot("stress")


def test_a_frame_in_space_is_drawn_in_space_with_its_joints() -> None:
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (1, 1, 1)}.items():
        frame.node(name, np.array(place, dtype=float))
    rod = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
    frame.add("AB", rod, "A", "B")
    frame.add("hinge", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 50.0)), "B", "C")
    frame.add("CD", rod, "C", "D")
    frame.fix("A")
    frame.load("D", fz=[1.0, 2.0])
    axes: Any = frame.solve().plot("M", entry=1)
    assert axes.name == "3d"
    assert len(artists(axes, "joint hinge")) == 1
    assert {"A", "B, C", "D"} <= {text.get_text().strip() for text in axes.texts}
    with pytest.raises(FrameError, match="choose an entry"):
        frame.solve().plot()


# -- reactions and histograms -----------------------------------------------------------------------------------------


def test_reactions_that_coincide_share_a_line() -> None:
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
    for link in ("AB", "BC", "CD"):
        linkage.link(link, *link)
    links = ("ground", "AB", "BC", "CD", "ground")
    for k, pin in enumerate("ABCD"):
        linkage.revolute(pin, links[k], links[k + 1], drive=pin == "A")
    linkage.load(("CD", "C"), fx=10.0)
    motion = linkage.move(A=np.radians([0.0, 10.0, 20.0]))
    axes = motion.reactions().plot()
    lines = {line.get_label(): line.get_ydata() for line in axes.lines}
    assert set(lines) == {"A, B, C", "D"}
    assert_allclose(lines["D"], np.linalg.norm(motion.reactions().force("D")[:, :3], axis=-1), rtol=1e-12)
    assert_allclose(axes.lines[0].get_xdata(), [0.0, 10.0, 20.0], atol=1e-12)
    axes = motion.reactions().plot("drives")
    assert [line.get_label() for line in axes.lines] == ["A [N m]"]
    with pytest.raises(FrameError, match="choose one of joints, drives"):
        motion.reactions().plot("torque")


def test_the_statistic_of_anderson_and_darling_is_that_of_scipy() -> None:
    rng = np.random.default_rng(0)
    for samples in (rng.normal(size=50), rng.exponential(size=200), 5.0 + 1e-6 * rng.random(30)):
        with np.errstate(all="ignore"):
            fitted = stats.goodness_of_fit(
                stats.norm, samples, statistic="ad", n_mc_samples=1, rng=0, known_params=None
            ).statistic
        # SciPy fits the deviation with n, not n - 1, in the denominator.
        assert anderson_darling(samples) == pytest.approx(fitted, rel=0.2, abs=0.05)


def test_a_histogram_says_whether_its_fit_holds() -> None:
    rng = np.random.default_rng(2)
    good = plot_histogram(rng.normal(size=500), label="$u_x$", unit="mm")
    assert "normal is not refuted" in good.get_title(loc="left")
    assert good.lines[0].get_label() == "normal fit"
    bad = plot_histogram(rng.exponential(size=500))
    assert "not normal at 1 %" in bad.get_title(loc="left")
    assert bad.lines[0].get_label() == "normal fit, does not hold"
    assert_allclose(sum(bar.get_height() * bar.get_width() for bar in bad.patches), 1.0)
    few = plot_histogram(1e-5 * rng.normal(size=5) + 12.345678)
    assert "normal" not in few.get_title(loc="left")
    for axes in (good, bad, few):
        legible(axes.figure)
    with pytest.raises(FrameError, match="one row of two finite numbers"):
        plot_histogram([1.0, np.nan])


# -- lazy -------------------------------------------------------------------------------------------------------------


def test_nothing_that_draws_is_loaded_before_something_is_drawn() -> None:
    program = (
        "import sys; from linkframe.models import Linkage; from linkframe.framework import Solution\n"
        "print([name for name in ('matplotlib', 'pyvista', 'vtkmodules') if name in sys.modules])"
    )
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert ended.stdout.strip() == "[]"
