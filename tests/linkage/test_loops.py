"""Random closed loops are assembled, checked by products of screws, and assembled back from where they went."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from linkframe.models import Linkage
from linkframe.models.linkage.kinematics.loops import Loops
from linkframe.models.linkage.kinematics.mechanism import compiled
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

seeds = st.integers(0, 2**32 - 1)
STEP = 0.1


def ring(points, axes, kinds, at=None):
    """A closed chain: joint k, of kinds[k], at points[k] between link k - 1 and link k; the ground is link -1."""
    count = len(points)
    linkage = Linkage({f"P{k}": point for k, point in enumerate(points)})
    names = ["ground", *(f"link {k}" for k in range(count - 1)), "ground"]
    for k in range(count - 1):
        linkage.link(names[k + 1], f"P{k}", f"P{k + 1}")
    for k, kind in enumerate(kinds):
        start = {} if at is None else {"reference": at[k]}
        getattr(linkage, kind)(f"P{k}", names[k], names[k + 1], axis=axes[k], drive=k == 0, **start)
    return linkage


def placed(point, axis, kind, coordinates):
    """4 x 4 motion of a joint drawn at `point` with `axis`: slide along it and turn about it."""
    slide = coordinates[0] if kind in ("prismatic", "cylindrical") else 0.0
    angle = coordinates[-1] if kind in ("revolute", "cylindrical") else 0.0
    unit = axis / np.linalg.norm(axis)
    out = np.eye(4)
    out[:3, :3] = Rotation.from_rotvec(angle * unit).as_matrix()
    out[:3, 3] = point - out[:3, :3] @ point + slide * unit
    return out


def random_ring(seed, kinds, planar):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1.0, 1.0, (len(kinds), 3))
    axes = rng.normal(size=(len(kinds), 3))
    if planar:
        turn = Rotation.from_rotvec(rng.uniform(-2.0, 2.0, 3)).as_matrix()
        points[:, 2], axes[:] = rng.uniform(-1.0, 1.0), (0.0, 0.0, 1.0)
        return points @ turn.T, axes @ turn.T
    return points, axes


RINGS = {
    "planar": (["revolute"] * 4, True),
    "seven hinges": (["revolute"] * 7, False),
    "RCCC": (["revolute", "cylindrical", "cylindrical", "cylindrical"], False),
    "sliders": (["prismatic", "revolute", "cylindrical", "revolute", "cylindrical"], False),
}


@pytest.mark.parametrize("name", RINGS)
@settings(max_examples=8)
@given(seed=seeds)
def test_loop_closes_as_a_product_of_screws_and_comes_back(name, seed):
    kinds, planar = RINGS[name]
    points, axes = random_ring(seed, kinds, planar)
    motion = ring(points, axes, kinds).move(P0=[0.0, STEP])
    assume(motion.closure_status[1] == "regular")
    total, moved_points, moved_axes, at = np.eye(4), [], [], []
    for k, kind in enumerate(kinds):
        coordinates = motion.coordinate(f"P{k}")[1]
        moved_axes.append(total[:3, :3] @ axes[k])
        here = total @ placed(points[k], axes[k], kind, coordinates)
        # the point of the drawing on the link that the joint carries
        moved_points.append(here[:3, :3] @ points[k] + here[:3, 3])
        at.append(coordinates[0] if len(coordinates) == 1 else coordinates)
        total = here
    assert_allclose(total, np.eye(4), atol=1e-11)
    closed = ring(points, axes, kinds).move(P0=STEP)
    for k in range(len(kinds) - 1):
        assert_allclose(closed.position(f"P{k}", f"link {k}"), moved_points[k], atol=1e-11)
    if any(kind != "revolute" for kind in kinds):
        return
    back = ring(moved_points, moved_axes, kinds, at).move(P0=0.0)
    assume(back.closure_status == "regular")
    for k in range(len(kinds)):
        assert_allclose(back.position(f"P{k}"), points[k], atol=1e-9)


@settings(max_examples=8)
@given(seed=seeds, planar=st.booleans(), scale=st.sampled_from([1e-3, 1.0, 300.0]), mirrored=st.booleans())
def test_turned_mirrored_and_scaled_linkages_move_alike(seed, planar, scale, mirrored):
    kinds = ["revolute"] * (4 if planar else 7)
    points, axes = random_ring(seed, kinds, planar)
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.uniform(-3.0, 3.0, 3)).as_matrix()
    mirror = np.diag([-1.0, 1.0, 1.0]) if mirrored else np.eye(3)
    shift = rng.uniform(-2.0, 2.0, 3) * scale
    there = scale * turn @ mirror
    drive = np.array([0.02, -0.03, 0.05])
    motion = ring(points, axes, kinds).move(P0=drive)
    # a mirror turns the sense of rotation about a mirrored axis
    alike = ring(points @ there.T + shift, axes @ (turn @ mirror).T, kinds).move(P0=-drive if mirrored else drive)
    assume(np.all(motion.closure_status == "regular"))
    assert np.all(alike.closure_status == "regular")
    for k in range(len(kinds)):
        expected = motion.position(f"P{k}") @ there.T + shift
        assert_allclose(alike.position(f"P{k}"), expected, atol=1e-9 * scale)


def chains_of_four_bars():
    """Two chains that do not meet, each of a four-bar whose rocker is the crank of another; and a driven pendulum."""
    linkage = Linkage()
    for k in range(2):
        x = 9.0 * k
        places = {"A": (x, 0), "B": (x, 1), "D": (x + 2.4, 1.6), "E": (x + 2.2, 0), "F": (x + 2.8, 1.2)}
        places |= {"G": (x + 5.0, 1.5), "H": (x + 4.6, 0)}
        for name, place in places.items():
            linkage.point(f"{name}{k}", place)
        for name, points in {"crank": "AB", "coupler": "BD", "rocker": "DEF", "rod": "FG", "end": "GH"}.items():
            linkage.link(f"{name}{k}", *(f"{point}{k}" for point in points))
        for point, first, second in (
            ("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("F", "rocker", "rod"), ("G", "rod", "end"),
        ):  # fmt: skip
            linkage.revolute(f"{point}{k}", f"{first}{k}", f"{second}{k}")
        for point, link in {"A": "crank", "E": "rocker", "H": "end"}.items():
            linkage.revolute(f"{point}{k}", "ground", f"{link}{k}", drive=point == "A")
    linkage.point("P", (-3, 0))
    linkage.link("pendulum", "P")
    linkage.revolute("P", "ground", "pendulum", drive=True)
    return linkage


def test_unknowns_follow_only_the_drives_that_reach_them():
    """By differences of closed poses: what is taken not to follow a drive stands still, what follows is as given."""
    mechanism = compiled(chains_of_four_bars())
    loops, h = Loops(mechanism), 1e-6
    start = loops.close(loops.reference_state, mechanism.parameters)
    moved = np.zeros((len(mechanism.driven), loops.columns))
    for drive, place in enumerate(loops.driven_states):
        ends = []
        for sign in (1.0, -1.0):
            state = list(start.state)
            state[place] += sign * h
            ends.append(np.array(loops.close(state, mechanism.parameters).state)[loops.unknown_states])
        moved[drive] = (ends[0] - ends[1]) / (2.0 * h)
    taken = np.zeros_like(moved)
    for place, value in zip(loops.equations.followers, start.follow, strict=True):
        taken[place] = value
    assert_allclose(taken, moved, atol=1e-8)
    # each chain has two loops of two unknowns in the equations, which all move with its own crank
    assert np.count_nonzero(taken) == len(loops.equations.followers) == 8
    assert loops.equations.driven_together == [(0, 0), (1, 1), (2, 2)]


def test_many_chains_move_as_each_does_alone():
    """Each drive's chain at 40 poses off the way of the others, by differences from a single chain."""
    both, angles = chains_of_four_bars(), np.random.default_rng(3).uniform(-0.5, 0.5, (2, 40))
    motion = both.move(A0=angles[0], A1=angles[1], P=angles[0] * 3.0)
    for k in range(2):
        alone = both.move(A0=angles[k], A1=0.0 * angles[k], P=0.0)
        found = motion.position(f"G{k}") - (9.0 * k, 0.0, 0.0)
        assert_allclose(found, alone.position("G0"), atol=1e-14)
    assert motion.is_regular.all()


def test_two_drives_of_one_loop_are_followed_together():
    linkage = ring([(0, 0), (-0.5, 1), (0.8, 2), (2.4, 1.0), (2, 0)], [(0, 0, 1)] * 5, ["revolute"] * 5)
    linkage.revolute("P4", "link 3", "ground", drive=True, replace=True)
    assert Loops(compiled(linkage)).equations.driven_together == [(0, 0), (1, 0), (1, 1)]
