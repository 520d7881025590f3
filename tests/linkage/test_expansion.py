"""Links that become warmer: similar linkages, linkages with longer links, and studies of temperatures."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.linkages import parallel_cranks
from scipy import stats

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
ANGLES = np.array([0.1, 0.6, 1.2])
STEEL = 1.2e-5


def four_bar(crank: float | None = None, clearance: float | None = None) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(0.1, 0.05), C=(0.4, 0.2), D=(0.35, 0), P=(0.3, 0.3))
    linkage.link("crank", "A", "B", beam=BAR, length=crank)
    linkage.link("coupler", "B", "C", "P", beam=BAR)
    linkage.link("rocker", "C", "D", beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", stiffness=(2e9,) * 5 + (0.0,))
    linkage.revolute("C", "coupler", "rocker", clearance=clearance)
    linkage.revolute("D", "rocker", "ground")
    linkage.load("P", fy=-50.0)
    return linkage


def test_all_alike_is_a_similar_linkage() -> None:
    """Links and ground that grow alike leave all angles: P moves away from the first pivot by the strain."""
    motion = four_bar().move(A=ANGLES)
    rises = dict.fromkeys(("crank", "coupler", "rocker", "ground"), 30.0)
    found = motion.accuracy("P", temperature=rises, expansion=STEEL)
    assert_allclose(found.thermal[:, :3], STEEL * 30.0 * motion.position("P"), rtol=1e-12, atol=1e-18)
    assert_allclose(found.thermal[:, 3:], 0.0, atol=1e-16)
    cold = motion.accuracy("P")
    assert_allclose(found.total, cold.total + found.thermal, rtol=1e-12, atol=1e-18)
    assert_allclose(found.compliance, cold.compliance, rtol=0.0, atol=0.0)
    assert np.all(cold.thermal == 0.0)


def test_one_warm_link_is_a_longer_link() -> None:
    """By differences of linkages whose crank is given a length; each pose with a temperature of its own."""
    length, step = float(np.hypot(0.1, 0.05)), 1e-6
    longer, shorter = (four_bar(length * (1.0 + sign * step)).move(A=ANGLES).position("P") for sign in (1.0, -1.0))
    rise = np.array([10.0, 20.0, -5.0])
    found = four_bar().move(A=ANGLES).accuracy("P", temperature={"crank": rise}, expansion={"crank": STEEL})
    assert_allclose(found.thermal[:, :3], (STEEL * rise)[:, None] * (longer - shorter) / (2.0 * step), atol=1e-12)


def test_a_thread_grows_with_the_link_that_carries_it() -> None:
    """A spindle that turns a nut up: all alike is a similar linkage; the spindle alone, by the height of the nut."""
    linkage = Linkage(A=(0, 0, 0), N=(0, 0, 0.1), P=(0.2, 0, 0.1))
    linkage.link("spindle", "A", "N")
    linkage.link("nut", "N", "P")
    linkage.revolute("A", "ground", "spindle", drive=True)
    linkage.screw("N", "spindle", "nut", axis=(0, 0, 1), pitch=0.004)
    linkage.prismatic("P", "ground", "nut", axis=(0, 0, 1))
    turns = np.array([-5.0, 0.0, 10.0])
    motion = linkage.move(A=2.0 * np.pi * turns)
    assert_allclose(motion.position("P")[:, 2], 0.1 - 0.004 * turns, rtol=1e-14)
    alike = motion.accuracy("P", temperature=dict.fromkeys(("spindle", "nut", "ground"), 30.0), expansion=STEEL)
    assert_allclose(alike.thermal[:, :3], STEEL * 30.0 * motion.position("P"), rtol=1e-11, atol=1e-18)
    warm = motion.accuracy("N", "nut", temperature={"spindle": 30.0}, expansion=STEEL)
    assert_allclose(warm.thermal[:, 2], STEEL * 30.0 * (0.1 - 0.004 * turns), rtol=1e-11)


def test_what_does_not_fit_is_refused() -> None:
    """Of three parallel cranks all may grow, and not one alone."""
    motion = parallel_cranks().move(A=1.0)
    together = motion.accuracy("D", temperature=dict.fromkeys(("one", "two", "three"), 10.0), expansion=STEEL)
    assert_allclose(
        together.thermal[:3], 10.0 * STEEL * (motion.position("B") - motion.position("A")), rtol=1e-9, atol=1e-15
    )
    with pytest.raises(FrameError, match="do not fit in the overconstrained loops"):
        motion.accuracy("D", temperature={"two": 10.0}, expansion=STEEL)
    with pytest.raises(FrameError, match="temperature of 'four', which is no link: name one of one, two"):
        motion.accuracy("D", temperature={"four": 10.0}, expansion=STEEL)
    with pytest.raises(FrameError, match="a temperature needs an expansion"):
        motion.accuracy("D", temperature=10.0)
    with pytest.raises(FrameError, match="expansion= has no effect without temperature="):
        motion.accuracy("D", expansion=STEEL)


TOLERANCES: dict[str, Any] = {
    "points.D.x": 2e-5,
    "joints.B.stiffness": "± 20 %",
    "loads.0.fy": "± 10 %",
    "joints.C.clearance": (0.0, 2e-5),
}


@pytest.fixture(scope="module")
def found() -> Any:
    """A study with tolerances of all kinds."""
    return four_bar(clearance=1e-5).study(
        TOLERANCES,
        "P",
        {"A": ANGLES},
        n=64,
        rng=0,
        sampler="sobol",
        progress=False,
        temperatures={"crank": stats.norm(0.0, 10.0), "coupler": (-20.0, 20.0)},
        expansion=STEEL,
    )


def test_parts_apart_and_together(found: Any) -> None:
    """The deviation by heat is that of the expansion; variances of parts add up; so do worst cases, nearly."""
    parts = found.parts
    assert tuple(parts) == ("geometry", "clearance", "compliance", "load", "thermal", "together")
    assert parts["together"] is found
    motion = four_bar().move(A=ANGLES)
    slopes = [
        motion.accuracy("P", temperature={name: 1.0}, expansion=STEEL).thermal[:, :3] for name in ("crank", "coupler")
    ]
    assert_allclose(
        parts["thermal"].std[0], np.hypot(10.0 * slopes[0], 20.0 / np.sqrt(3.0) * slopes[1]), rtol=0.01, atol=1e-12
    )
    apart = sum(part.std[0] ** 2 for kind, part in parts.items() if kind != "together")
    assert_allclose(found.std[0], np.sqrt(apart), rtol=0.03, atol=1e-9)
    assert set(parts["geometry"].contributors["P"].names) == {"points.D.x"}
    assert set(parts["thermal"].worst_case["P"].position.contributors) == {"temperature.crank", "temperature.coupler"}
    along = found.worst_case["P"].direction
    supports = [part.worst_case["P"].support(along) for kind, part in parts.items() if kind != "together"]
    assert_allclose(np.sum(supports, axis=0), found.worst_case["P"].support(along), rtol=1e-5)
    assert all(each.shape == (1, 3) for each in parts.probability(1e-4).values())
    text = repr(parts)
    assert all(kind in text for kind in parts)


def test_one_ranked_table(found: Any) -> None:
    """Shares to first order beside Sobol' indices: of what is linear they are the same; intervals hold them."""
    ranked = found.ranked()
    assert set(ranked.names) == {*TOLERANCES, "temperature.crank", "temperature.coupler"}
    assert_allclose(ranked.worst.sum(axis=1), 100.0)
    assert_allclose(ranked.of_variance.sum(axis=1), 100.0)
    for name in ("temperature.crank", "temperature.coupler", "points.D.x"):
        k = ranked.names.index(name)
        low, high = (each[:, k] for each in ranked.total_interval)
        assert np.all((low <= ranked.total[:, k]) & (ranked.total[:, k] <= high))
        assert_allclose(ranked.first[:, k], ranked.total[:, k], atol=0.1)
    order = ranked.order(0)
    assert ranked.worst[0, order[0]] == ranked.worst[0].max()
    lines = ranked.table(0).splitlines()
    assert len([line for line in lines if any(name in line for name in ranked.names)]) == len(ranked.names)
    assert "total" in repr(ranked)
    with pytest.raises(FrameError, match="point 'Q' is not in the study: choose of P"):
        found.ranked("Q")


def test_temperatures_alone_in_closed_form() -> None:
    """An arm of 2 m: only its own length grows; worst case, deviation and share of samples outside."""
    arm = Linkage(A=(0, 0), B=(2, 0))
    arm.link("arm", "A", "B")
    arm.revolute("A", "ground", "arm", drive=True)
    found = arm.study(
        {}, "B", {"A": [0.0, 1.0]}, n=4096, rng=0, sampler="sobol", replicates=16, progress=False,
        temperatures={"arm": (-20.0, 20.0)}, expansion=STEEL,
    )  # fmt: skip
    assert_allclose(found.greatest[0], 2.0 * STEEL * 20.0, rtol=1e-9)
    assert_allclose(found.probability(STEEL * 20.0)[0], 0.5, atol=2e-3)
    assert_allclose(found.std[0, 0, 0], 2.0 * STEEL * 20.0 / np.sqrt(3.0), rtol=1e-3)
    assert found.propagation.replicates == 16
    assert_allclose(found.ranked().total, 1.0, atol=1e-3)
