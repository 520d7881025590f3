"""Workspaces: drives by closed forms, stiffness and condition numbers against formulas, and what stays blank."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.workspace.inverse import InverseKinematics
from numpy.testing import assert_allclose

LINE = np.linspace(-2.0, 2.0, 17)
BAR = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))


def arm(beam: Beam | None = None) -> Linkage:
    """Two bars of 1 m and 0.6 m with drives at the base and at the elbow."""
    linkage = Linkage(A=(0, 0), B=(1, 0), P=(1, 0.6))
    linkage.link("upper", "A", "B", beam=beam)
    linkage.link("lower", "B", "P", beam=beam)
    linkage.revolute("A", "ground", "upper", drive=True)
    linkage.revolute("B", "upper", "lower", drive=True, reference=np.pi / 2)
    return linkage


def test_drives_of_an_arm_and_its_condition_number() -> None:
    """Elbow by the cosine law; det J = a b sin(elbow) and trace J^T J give the singular values."""
    space = arm().workspace("P", x=LINE, y=LINE)
    x, y = np.meshgrid(LINE, LINE)
    cosine = (x**2 + y**2 - 1.0 - 0.36) / 1.2
    inside = np.abs(cosine) < 1.0
    # All of them, those in the shadow of the hole of radius 0.4 as well.
    assert (space.reached == inside).all()
    elbow = space.drives["B"][space.reached]
    assert_allclose(np.cos(elbow), cosine[space.reached], atol=1e-12)
    place = space.motion.position("P")
    assert_allclose(place[:, :2], np.stack([x, y], axis=-1)[space.reached], atol=1e-12)
    square = (x**2 + y**2)[inside] + 0.36
    root = np.sqrt(square**2 - 4.0 * 0.36 * (1.0 - cosine[inside] ** 2))
    assert_allclose(space.condition()[inside], np.sqrt((square + root) / (square - root)), rtol=1e-9)
    assert np.isnan(space.condition()[~space.reached]).all()


def arm_with_wrist() -> Linkage:
    """Bars of 2 and 1 with a driven wrist: its pin goes wherever the bars reach, from 1 to 3 away, stretched at 3."""
    linkage = Linkage(A=(0, 0), B=(2, 0), W=(2, 1), P=(2.5, 1))
    for link, on in (("upper", "AB"), ("lower", "BW"), ("tool", "WP")):
        linkage.link(link, *on)
    for pin, first, second in (("A", "ground", "upper"), ("B", "upper", "lower"), ("W", "lower", "tool")):
        linkage.revolute(pin, first, second, drive=True)
    return linkage


@pytest.mark.parametrize(("ends", "count"), [(3.0, 5), (2.9, 4), (2.7, 3)])
def test_a_held_orientation_beyond_a_hole_and_beside_singular_places(ends: float, count: int) -> None:
    """Of coarse grids some places lie beyond the hole of all places beside them, or beside none that is reached."""
    line = np.linspace(-ends, ends, count)
    space = arm_with_wrist().workspace("P", x=line + 0.5, y=line)
    away = np.hypot(*np.meshgrid(line, line))
    assert space.reached[(away > 1.01) & (away < 2.99)].all()
    assert not space.reached[(away < 0.99) | (away > 3.01)].any()
    assert_allclose(space.motion.axes("tool"), np.broadcast_to(np.eye(3), (*space.motion.shape, 3, 3)), atol=1e-10)


def test_a_held_orientation_at_places_far_apart() -> None:
    """Beside each other by more than the shorter bar is long, beyond what Newton's method takes in one go."""
    space = arm_with_wrist().workspace("P", x=[-2.1, -0.8], y=[0.0, 1.3])
    assert space.reached.all()
    assert_allclose(space.motion.axes("tool"), np.broadcast_to(np.eye(3), (*space.motion.shape, 3, 3)), atol=1e-10)


def test_damped_steps_arrive_from_anywhere() -> None:
    """Wherever the drives begin: at places between the hole and the outer edge, in the orientation that is held."""
    rng, solver = np.random.default_rng(0), InverseKinematics(arm_with_wrist(), "P")
    away, around = rng.uniform(1.02, 2.98, 300), rng.uniform(-np.pi, np.pi, 300)
    places = np.stack([0.5 + away * np.cos(around), away * np.sin(around), 0.0 * away], axis=-1)
    found = solver.approached(rng.uniform(-np.pi, np.pi, (300, 3)), places)
    first, second, third = found.T + np.array([[0.0], [np.pi / 2], [-np.pi / 2]])
    at = 2.0 * np.exp(1j * first) + np.exp(1j * (first + second)) + 0.5 * np.exp(1j * (first + second + third))
    assert_allclose(at.real, places[:, 0], atol=0.03)
    assert_allclose(at.imag, places[:, 1], atol=0.03)
    assert_allclose(np.exp(1j * (first + second + third)), 1.0, atol=0.015)
    assert solver.refined(found, places)[1].all()


def test_a_slide_may_go_as_far_as_the_linkage_is_long() -> None:
    """A polar robot with a wrist, in millimetres: behind its pivot it is tried from the place beside."""
    linkage = Linkage(A=(0, 0), W=(1000, 0), P=(1500, 0))
    linkage.link("turret", "A", "W")
    linkage.link("rod", "W")
    linkage.link("tool", "W", "P")
    linkage.revolute("A", "ground", "turret", drive=True)
    linkage.prismatic("W", "turret", "rod", axis=(1, 0, 0), drive=True, name="slide")
    linkage.revolute("W", "rod", "tool", drive=True, name="wrist")
    assert linkage.workspace("P", x=[-1500.0, 500.0], y=[0.0, 1000.0]).reached.all()


@pytest.mark.parametrize("unit", [1.0, 1000.0])
def test_a_drive_that_turns_beside_one_that_slides(unit: float) -> None:
    """A polar robot: J^T J = diag(r^2, 1), the same in metres and in millimetres."""
    robot = Linkage(A=(0, 0), B=(0.1 * unit, 0), P=(0.5 * unit, 0))
    robot.link("arm", "A", "B")
    robot.link("rod", "B", "P")
    robot.revolute("A", "ground", "arm", drive=True)
    robot.prismatic("B", "arm", "rod", axis=(1, 0), drive=True)
    r = np.array([0.3, 0.4, 0.5])
    space = robot.workspace("P", x=r * unit, y=[0.0, 0.01 * unit])
    assert_allclose(space.condition(0.1 * unit)[0], r / 0.1, rtol=1e-9)
    assert_allclose(space.condition()[0], np.maximum(r / 0.4, 0.4 / r), rtol=1e-9)


def test_one_joint_that_slides_and_turns_has_no_one_effort() -> None:
    reel = Linkage(A=(0, 0), P=(0.5, 0))
    reel.link("rod", "A", "P")
    reel.planar("A", "ground", "rod", drive=("ux", "uy", "rz"))
    reel.load("P", fy=1.0)
    with pytest.raises(FrameError, match="drive 'A' slides and turns: read"):
        reel.workspace("P", x=[0.4, 0.5], y=[0.0, 0.1]).effort()


def test_places_behind_a_singular_pose_are_told_from_those_out_of_reach() -> None:
    """A four-bar whose coupler point leads: beyond the dead point there are places in the other assembly mode only."""
    linkage = Linkage(A=(-1.0, 0.0), B=(-0.6, 0.8), P=(0.0, 0.1), C=(0.6, 0.8), D=(1.0, 0.0))
    for link in ("AB", "BP", "PC", "CD"):
        linkage.link(link, *link)
    joints = {"A": ("ground", "AB"), "B": ("AB", "BP"), "P": ("BP", "PC"), "C": ("PC", "CD"), "D": ("CD", "ground")}
    for name, links in joints.items():
        linkage.revolute(name, *links, drive=name in "AD")
    x, y = np.linspace(-1.5, 1.5, 9), np.linspace(-0.5, 1.5, 9)
    space = linkage.workspace("P", x=x, y=y)
    places = np.stack(np.meshgrid(x, y), axis=-1)
    rod = np.hypot(0.6, 0.7)
    away = np.linalg.norm(places[..., None, :] - np.array([[-1.0, 0.0], [1.0, 0.0]]), axis=-1)
    bar = np.hypot(0.4, 0.8)
    can_be = ((away < bar + rod) & (away > abs(bar - rod))).all(axis=-1)
    assert (can_be == (space.reached | space.elsewhere)).all()
    assert space.elsewhere.any()
    assert not (space.reached & space.elsewhere).any()
    told = space.plot("condition").get_title(loc="left").replace("\n", " ")
    assert f"{np.count_nonzero(space.elsewhere)} of them in another assembly mode" in told
    out = space.status[~can_be]
    assert set(out) == {"not assembled: the point cannot be there"}
    assert all(each.startswith("other assembly mode") for each in space.status[space.elsewhere])


def test_places_that_a_five_bar_reaches_with_an_elbow_folded_the_other_way() -> None:
    """The elbows of each place by the cosine law: where the drives go there straight, loops closed, it is reached."""
    bar, rod, tip, bases = 1.0, 1.2, 1.2j, np.array([-1.0, 1.0])

    def cranks(place: complex) -> list[np.ndarray]:
        leg = place - bases
        with np.errstate(invalid="ignore"):
            fold = np.arccos((bar**2 - rod**2 + np.abs(leg) ** 2) / (2 * bar * np.abs(leg)))
        return [np.angle(leg) + fold * sides for sides in ((1, -1), (-1, 1), (1, 1), (-1, -1))]

    start = cranks(tip)[0]
    elbows = bases + bar * np.exp(1j * start)
    points = dict(zip("ABPDE", (bases[0], elbows[0], tip, elbows[1], bases[1]), strict=True))
    linkage = Linkage({name: (np.real(at), np.imag(at)) for name, at in points.items()})
    for link in ("AB", "BP", "PD", "DE"):
        linkage.link(link, *link)
    joints = {"A": ("ground", "AB"), "B": ("AB", "BP"), "P": ("BP", "PD"), "D": ("PD", "DE"), "E": ("ground", "DE")}
    for name, links in joints.items():
        linkage.revolute(name, *links, drive=name in "AE")
    x, y = np.linspace(-2.2, 2.2, 11), np.linspace(-2.0, 2.4, 11)
    space = linkage.workspace("P", x=x, y=y)

    def closed_on_the_way(place: complex, end: np.ndarray) -> bool:
        turn = np.remainder(end - start + np.pi, 2 * np.pi) - np.pi
        first, second = (bases + bar * np.exp(1j * (start + np.linspace(0.0, 1.0, 500)[:, None] * turn))).T
        apart = np.abs(first - second)
        above = ((place - first[-1]).conjugate() * (place - second[-1])).imag > 0.0
        return bool(above and (apart > 0.02).all() and (apart < 2 * rod - 0.02).all())

    expected = [[any(closed_on_the_way(a + 1j * b, end) for end in cranks(a + 1j * b)) for a in x] for b in y]
    assert np.count_nonzero(expected) > 16
    assert space.reached[np.array(expected)].all()
    placed = space.motion.position("P")[:, :2]
    assert_allclose(placed, np.stack(np.meshgrid(x, y), axis=-1)[space.reached], atol=1e-10)


def test_maps_say_what_is_blank_and_have_units() -> None:
    linkage = arm(BAR)
    linkage.load("P", fy=-100.0)
    space = linkage.workspace("P", x=LINE, y=LINE)
    blank = np.count_nonzero(~space.reached)
    axes: Any = space.plot("effort", units=("m", "N"))
    assert axes.get_title(loc="left") == f"blank: {blank} of 289 places not reachable"
    (cells,) = (each for each in axes.collections if each.get_gid() == "map")
    assert np.ma.getmaskarray(cells.get_array()).reshape(17, 17).tolist() == (~space.reached).tolist()
    assert axes.figure.axes[1].get_ylabel() == "greatest drive torque [N m]"
    moment = np.abs(np.stack([100.0 * np.meshgrid(LINE, LINE)[0], 100.0 * 0.6 * np.cos(sum(space.drives.values()))]))
    reached = space.reached
    # The lower bar leans by both angles; its drive holds the load at its own arm.
    lower = np.abs(100.0 * (space.motion.position("P") - space.motion.position("B"))[:, 0])
    assert_allclose(space.effort("B")[reached], lower, atol=1e-9)
    assert_allclose(space.effort()[reached], np.maximum(moment[0][reached], lower), atol=1e-9)
    softest = space.plot("stiffness").figure.axes[1].get_ylabel()
    assert softest == "least stiffness of P [kN/m]"
    along = space.stiffness((0.0, 1.0))
    assert_allclose(along[reached], 1.0 / space.motion.compliance_matrix("P")[:, 1, 1], rtol=1e-12)
    assert (space.stiffness()[reached] <= along[reached] * (1.0 + 1e-12)).all()
    assert space.plot("stiffness", direction=(0, 1)).figure.axes[1].get_ylabel().startswith("stiffness along (0, 1)")


def test_a_slice_through_a_space_says_where() -> None:
    """A gantry: three slides, each of which is its own coordinate; its Jacobian is the identity."""
    linkage = Linkage(O=(0, 0, 0))
    links = ["ground", "bridge", "carriage", "tool"]
    for k, (before, link) in enumerate(pairwise(links)):
        linkage.link(link, "O")
        linkage.prismatic("O", before, link, axis=np.eye(3)[k], drive=True, name="xyz"[k])
    space = linkage.workspace("O", x=[0.0, 0.5, 1.0], z=[0.0, 2.0], y=-0.25, link="tool")
    assert_allclose(space.drives["x"], [[0.0, 0.5, 1.0]] * 2, atol=1e-12)
    assert_allclose(space.drives["y"], -0.25)
    assert_allclose(space.condition(), 1.0)
    axes = space.plot("condition")
    assert axes.get_title(loc="left") == "y = −0.25 m\nall 6 places reachable"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "z [m]")


def test_a_platform_keeps_its_orientation_and_counts_turns_by_a_length() -> None:
    """Three slides on a platform in the plane: x at P, y at the ends of a bar of half length 0.5."""
    linkage = Linkage(P=(0, 0), L=(-0.5, 0), R=(0.5, 0))
    linkage.link("platform", "L", "P", "R")
    for name, link, point, axis in (("a", "one", "P", (1, 0)), ("b", "two", "L", (0, 1)), ("c", "three", "R", (0, 1))):
        linkage.link(link, point)
        linkage.link(f"{link} cross", point)
        linkage.prismatic(point, "ground", link, axis=axis, drive=True, name=name)
        linkage.prismatic(point, link, f"{link} cross", axis=axis[::-1], name=f"{name} cross")
        linkage.revolute(point, f"{link} cross", "platform", name=f"{name} pin")
    space = linkage.workspace("P", x=[-0.1, 0.0, 0.1], y=[-0.1, 0.1])
    assert_allclose(space.drives["b"], space.drives["c"], atol=1e-12)
    assert_allclose(space.drives["b"], [[-0.1] * 3, [0.1] * 3], atol=1e-12)
    assert space.characteristic_length == pytest.approx(0.5)
    # y and 0.5 times the turn are half the sum and half the difference of b and c: singular values 1, 1/√2, 1/√2.
    assert_allclose(space.condition(), np.sqrt(2.0), rtol=1e-9)
    assert (space.condition(0.05) > 2.0).all()


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"x": LINE}, "x of shape"),
        ({"x": LINE, "y": 0.0}, "give two of x, y and z as rows"),
        ({}, "given nothing"),
        ({"x": [7.0, 8.0], "y": [7.0, 8.0]}, "no place of the grid can be reached"),
    ],
)
def test_grids_that_cannot_be_meant_are_refused(given: dict[str, Any], told: str) -> None:
    with pytest.raises(FrameError, match=told):
        arm().workspace("P", **given)


def test_linkages_without_a_workspace_are_refused() -> None:
    crank = Linkage(A=(0, 0), B=(1, 0))
    crank.link("crank", "A", "B")
    crank.revolute("A", "ground", "crank")
    with pytest.raises(FrameError, match="nothing drives the linkage"):
        crank.workspace("B", x=LINE, y=LINE)
    crank.drive("A")
    with pytest.raises(FrameError, match="along 1 of 2 axes: a workspace needs them all"):
        crank.workspace("B", x=LINE, y=LINE)
    space = arm().workspace("P", x=[0.9, 1.0], y=[0.5, 0.6])
    with pytest.raises(FrameError, match="nothing acts on the linkage"):
        space.effort()
    with pytest.raises(FrameError, match="choose one of stiffness, condition, effort"):
        space.plot("torque")
    with pytest.raises(FrameError, match="give a length above zero"):
        space.condition(0.0)


def test_places_are_sought_from_the_drive_values_of_the_reference_configuration() -> None:
    """Of each drive its own, in the order of the drives."""
    linkage = Linkage(A=(0, 0), B=(1, 0), P=(1.5, 0.5))
    linkage.link("upper", "A", "B")
    linkage.link("lower", "B", "P")
    linkage.revolute("A", "ground", "upper", drive=True, reference=0.3)
    linkage.revolute("B", "upper", "lower", drive=True, reference=-0.8)
    assert_allclose(InverseKinematics(linkage, "P").start, [0.3, -0.8], atol=1e-15)
