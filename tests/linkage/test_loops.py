"""Random closed loops are assembled, checked by products of screws, and assembled back from where they went."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from linkframe.models import Linkage
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
