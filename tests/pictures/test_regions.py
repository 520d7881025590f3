"""Ellipses, ellipsoids and worst-case regions about points, and clearances, to the scale that stands beside them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, Motion, propagate, taylor_moments
from linkframe.models.linkage.graphics.bodies import Looks, MotionBodies
from linkframe.models.linkage.graphics.regions import drawn_regions
from numpy.testing import assert_allclose
from pictures.test_plots import artists, bricard
from scipy import stats

COVARIANCE = np.array([[4.0, 1.0, 0.0], [1.0, 2.0, 0.5], [0.0, 0.5, 1.0]]) * 1e-8


def arm() -> Motion:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 0.5))
    linkage.link("upper", "A", "B")
    linkage.link("lower", "B", "C")
    linkage.revolute("A", "ground", "upper", drive=True, clearance=2e-4)
    linkage.revolute("B", "upper", "lower", drive=True)
    return linkage.move(A=[0.0, 0.3, 0.6], B=[0.0, 0.2, 0.4])


def space() -> Motion:
    return bricard().move(O=np.linspace(0.0, 1.0, 4), A=np.linspace(0.0, 2.0, 4))


def test_an_ellipse_is_where_the_normal_density_has_its_level() -> None:
    motion, own = arm(), COVARIANCE[:2, :2]
    axes = motion.plot(pose=1, regions={"C": own}, level=0.9, magnify=50.0)
    assert axes.get_title(loc="left") == "90 % ellipse of C × 50"
    (outline,) = (each for each in artists(axes, "zone") if hasattr(each, "get_xydata"))
    off = (outline.get_xydata() - motion.position("C")[1, :2]) / 50.0
    assert_allclose(np.einsum("ki,ij,kj->k", off, np.linalg.inv(own), off), stats.chi2(2).ppf(0.9), rtol=1e-9)
    assert np.linalg.norm(off, axis=-1).max() > 0.99 * np.sqrt(stats.chi2(2).ppf(0.9) * np.linalg.eigvalsh(own)[-1])


def test_a_worst_case_is_drawn_as_its_region_at_the_pose() -> None:
    motion = arm()
    worst = motion.worst_case("C", drives={"A": 1e-4, "B": 2e-4})
    axes = motion.plot(pose=2, regions=worst, magnify=100.0)
    (area,) = (each for each in artists(axes, "zone") if hasattr(each, "get_xy"))
    corners = (area.get_xy() - motion.position("C")[2, :2]) / 100.0
    for angle in np.linspace(0.0, 2.0 * np.pi, 17):
        way = np.array([np.cos(angle), np.sin(angle)])
        assert (corners @ way).max() == pytest.approx(worst.support(way)[2], rel=1e-3)
    picked = motion.plot(pose=2, regions=worst).get_title(loc="left")
    assert picked.startswith("worst case of C × ")


def test_an_ellipsoid_in_space_is_a_body_about_its_point() -> None:
    motion = space()
    bodies = MotionBodies(motion, (1, 3), Looks(regions={"B": COVARIANCE}, level=0.5, magnify=30.0))
    assert bodies.caption == "50 % ellipsoid of B × 30"
    for number, pose in enumerate(bodies.poses):
        surface, _ = bodies.surfaces(number)["region B 0"]
        off = (surface.points - 0.1 * bodies.pin * surface.normals - motion.position("B")[pose]) / 30.0
        inside = np.einsum("ki,ij,kj->k", off, np.linalg.inv(COVARIANCE), off)
        assert_allclose(inside, stats.chi2(3).ppf(0.5), rtol=1e-9)
    axes: Any = motion.plot(pose=1, regions={"B": COVARIANCE})
    assert len(artists(axes, "zone")) == 3


def test_moments_and_samples_give_their_ellipsoids() -> None:
    rows = np.array([[1.0, 2.0], [0.0, 3.0], [1.0, 0.0]])
    laws = {"a": stats.norm(0.0, 1e-4), "b": stats.norm(0.0, 2e-4)}

    def fn(a: Any, b: Any) -> Any:
        return np.stack([a, b], axis=-1) @ rows.T

    exact = rows @ np.diag([1e-8, 4e-8]) @ rows.T
    moments = taylor_moments(fn, laws)
    assert_allclose(moments.result_covariance, exact, atol=1e-15)
    samples = propagate(fn, laws, n=256, rng=0)
    way = np.eye(3)[1:2]
    for given, covariance in ((moments, exact), (samples, samples.covariance)):
        (region,) = drawn_regions(space(), {"B": given}, 0.95)
        reach = np.sqrt(stats.chi2(3).ppf(0.95) * covariance[1, 1])
        assert region.outermost(0, way)[0, 1] == pytest.approx(reach, rel=1e-6)


def test_bearings_are_as_much_wider_than_journals_as_they_say() -> None:
    bodies = MotionBodies(arm(), (0, 1), Looks(clearances=100.0))
    assert bodies.caption == "clearances × 100"
    rings, _ = bodies.surfaces(1)["clearances"]
    away = np.linalg.norm(rings.points[:, :2], axis=-1)
    assert away.max() == pytest.approx(1.25 * bodies.pin + 100.0 * 2e-4 + 0.16 * bodies.pin, rel=1e-3)
    assert MotionBodies(arm(), (0,), Looks()).clearance_scale in {
        step * 10.0**k for step in (1, 2, 5) for k in range(4)
    }
    assert "clearances" not in MotionBodies(arm(), (0,), Looks(clearances=0.0)).surfaces(0)
    assert not MotionBodies(space(), (0,), Looks()).caption


@pytest.mark.parametrize(
    ("given", "told"),
    [
        (COVARIANCE, "regions were given as ndarray"),
        ({"C": np.ones(3)}, r"covariance of C has shape \(3,\)"),
        ({"C": np.ones((7, 3, 3))}, r"batch shape \(7,\), the motion \(3,\)"),
    ],
)
def test_what_is_no_region_is_refused(given: Any, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        arm().plot(regions=given)


def test_a_rigid_link_is_bars_along_its_outline() -> None:
    """They reach from point to point, and no further than their radius beyond."""
    motion = space()
    bodies = MotionBodies(motion, (2,), Looks())
    for name, link in motion.linkage.links.items():
        assert not link.beams
        ((surface, _),) = (found for key, found in bodies.surfaces(0).items() if key == f"link {name}")
        ends = np.array([motion.position(point, name)[2] for point in link.points])
        for corner, outer in (
            (ends.min(axis=0), surface.points.min(axis=0)),
            (ends.max(axis=0), surface.points.max(axis=0)),
        ):
            assert_allclose(outer, corner, atol=bodies.pin)
