"""Dead points and ranges of drives against triangles, polynomials and the linkages' own symmetry."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from linkframe.framework import FrameError
from linkframe.models import Linkage
from linkframe.models.linkage.poses.configuration import Configurations
from linkframe.models.linkage.poses.motion_path import MotionPath
from numpy.testing import assert_allclose
from reference.linkages import bennett, four_bar, loop, n_four_bar, rssr

CLOSE = {"rtol": 0.0, "atol": 1e-10}


def triangle(a: float, b: float, opposite: float) -> float:
    """Angle between two sides of a triangle."""
    return float(np.arccos((a * a + b * b - opposite * opposite) / (2.0 * a * b)))


@given(st.floats(2.0, 4.0), st.floats(0.3, 1.5), st.floats(1.05, 1.6), st.floats(-0.9, 0.9), st.booleans())
@settings(max_examples=5, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_four_bar_that_cannot_turn(longest: float, shortest: float, sum_: float, apart: float, crossed: bool) -> None:
    """It turns back where coupler and rocker lie in line: the diagonal is their sum, or their difference."""
    coupler, rocker = 0.5 * (longest + shortest), 0.5 * (longest - shortest)
    crank, ground = (0.5 * (sum_ * longest + sign * apart * shortest) for sign in (1.0, -1.0))
    low, high = triangle(crank, ground, shortest), triangle(crank, ground, longest)
    linkage = four_bar(crank, coupler, rocker, ground, 0.5 * (low + high), crossed)
    found = linkage.drive_range("A")
    assert_allclose([found.lower, found.upper], [low, high], **CLOSE)
    assert (found.lower_joint, found.upper_joint) == ("D", "D")
    points = linkage.dead_points("A")
    assert_allclose([point.value for point in points], [low, high], **CLOSE)
    assert [point.change_point for point in points] == [False, False]


def test_crank_rocker() -> None:
    linkage = four_bar(0.1, 0.25, 0.2, 0.22, 0.7)
    turning = linkage.drive_range("A")
    assert (turning.lower, turning.upper, turning.upper_joint) == (-np.inf, np.inf, None)
    assert linkage.dead_points("A") == ()
    swing = linkage.drive_range("E")  # from the rocker, crank and coupler lie in line at its ends
    limits = sorted(np.pi - triangle(0.2, 0.22, reach) for reach in (0.35, 0.15))
    assert_allclose([swing.lower, swing.upper], limits, **CLOSE)
    assert (swing.lower_joint, swing.upper_joint) == ("B", "B")


@pytest.mark.parametrize("crossed", [False, True])
def test_parallelogram_passes_its_change_points(crossed: bool) -> None:
    linkage = four_bar(0.1, 0.2, 0.1, 0.2, 0.7, crossed)
    assert linkage.drive_range("A").upper == np.inf
    points = linkage.dead_points("A")
    assert all(point.change_point and point.joint in "D" for point in points)
    assert_allclose(np.sin([point.value for point in points]), 0.0, **CLOSE)
    assert len({round(np.cos(point.value)) for point in points}) == 2


def test_flat_parallelograms_side_by_side() -> None:
    points = n_four_bar(2, np.pi / 3).dead_points("A0")
    assert_allclose(np.sin([point.value for point in points]), 0.0, **CLOSE)
    assert all(point.change_point for point in points)


def slider_crank(crank: float, rod: float, offset: float, theta: float, unit: float) -> Linkage:
    pin = crank * np.array([np.cos(theta), np.sin(theta)])
    place = pin[0] + np.sqrt(rod**2 - (pin[1] - offset) ** 2)
    linkage = Linkage(A=(0, 0), B=unit * pin, C=(unit * place, unit * offset))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("piston", "C")
    linkage.revolute("A", "ground", "crank")
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "piston")
    linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), reference=unit * place, name="slide", drive=True)
    return linkage


@given(st.floats(1.3, 5.0), st.floats(-0.25, 0.25), st.floats(0.3, 2.8), st.sampled_from([1e-3, 1.0, 25.4]))
@settings(max_examples=6, deadline=None)
def test_slider_crank(rod: float, offset: float, theta: float, unit: float) -> None:
    linkage = slider_crank(1.0, rod, offset, theta, unit)
    ends = unit * np.sqrt(np.array([rod - 1.0, rod + 1.0]) ** 2 - offset**2)
    found = linkage.drive_range("slide")
    assert_allclose([found.lower, found.upper], ends, rtol=0.0, atol=1e-10 * unit)
    assert (found.lower_joint, found.upper_joint) == ("B", "B")
    assert_allclose([point.value for point in linkage.dead_points("slide")], ends, rtol=0.0, atol=1e-10 * unit)
    assert linkage.drive_range("A").upper == np.inf  # in place of the drive, and not held by it


@pytest.mark.parametrize("away", [1e-3, 1e-5])
def test_drawn_beside_a_dead_point(away: float) -> None:
    end = triangle(0.2, 0.3, 0.4)
    found = four_bar(0.2, 0.22, 0.18, 0.3, end - away).drive_range("A")
    assert_allclose([found.lower, found.upper], [-end, end], **CLOSE)


def test_drawn_in_a_dead_point() -> None:
    """Crank and rod in line: the piston cannot go out any further."""
    linkage = slider_crank(1.0, 3.0, 0.0, 0.0, 1.0)
    found = linkage.drive_range("slide")
    assert_allclose([found.lower, found.upper], [2.0, 4.0], **CLOSE)
    assert_allclose([point.value for point in linkage.dead_points("slide")], [2.0, 4.0], **CLOSE)


@pytest.mark.parametrize("universal", [False, True])
def test_rssr_limits_are_roots_of_a_polynomial(universal: bool) -> None:
    """The rod just reaches where p² + r² = c² (see `rssr`), a polynomial in e^{iθ} of degree four."""
    crank, rod, rocker, (x, y, z) = 0.3, 0.4, 0.25, (0.15, 0.1, 0.3)
    with mp.workdps(40):
        # As polynomials in e, θ = arg e: cos θ = (e² + 1) / 2e, sin θ = (e² - 1) / 2ie.
        a, s, length, h = (mp.mpf(v) for v in (crank, rocker, rod, z))
        square = mp.mpf(x) ** 2 + mp.mpf(y) ** 2 + h**2 + a**2
        c = [a * (x + 1j * y), length**2 - s**2 - square, a * (x - 1j * y)]
        p = [-1j * s * a, 2 * s * mp.mpf(y), 1j * s * a]
        r = [0, 2 * s * h, 0]
        total = [
            sum(p[i] * p[k - i] + r[i] * r[k - i] - c[i] * c[k - i] for i in range(3) if 0 <= k - i < 3)
            for k in range(5)
        ]
        roots = mp.polyroots(total, maxsteps=200, extraprec=200, asc=True)
        limits = sorted(float(mp.arg(root)) for root in roots if abs(abs(root) - 1) < mp.mpf(10) ** -20)
    assert len(limits) == 2
    middle = 0.5 * sum(limits)
    try:
        linkage = rssr(crank, rod, rocker, (x, y, z), middle, universal)
    except FrameError:
        middle += np.pi
        limits = [limits[1], limits[0] + 2 * np.pi]
        linkage = rssr(crank, rod, rocker, (x, y, z), middle, universal)
    found = linkage.drive_range("O")
    assert_allclose([found.lower, found.upper], limits, **CLOSE)
    assert {found.lower_joint, found.upper_joint} <= {"B", "D"}


def test_bricard_folds_at_120_degrees() -> None:
    """cos φ = -cos θ / (1 + cos θ) reaches 1 at θ = 120°: there the other three hinges are straight."""
    quarter = np.pi / 2
    linkage = loop((1.0,) * 6, (quarter, -quarter) * 3, (quarter,) * 6)
    found = linkage.drive_range("H0")
    assert_allclose([found.lower, found.upper], np.radians([-120.0, 120.0]), **CLOSE)


def test_bennett_turns() -> None:
    assert bennett(np.pi / 6, np.pi / 3, 1.2).drive_range("H0").lower == -np.inf


def test_way_closes_although_a_rod_has_spun() -> None:
    """After a turn of the crank the rod of an RSSR need not have come back about its own line."""
    space = Configurations(rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3))
    curve = MotionPath(space, ("O", "rz"))
    way = curve.trace(curve.start)
    assert way.closes
    assert abs(abs(curve.coordinate(way.places[-1].state) - 0.3) - 2.0 * np.pi) < 0.1


def five_bar(left: float, right: float) -> Linkage:
    b, d = -0.1 + 0.3 * np.exp(1j * left), 0.1 + 0.3 * np.exp(1j * right)
    p = (b + d) / 2 + 1j * np.sqrt(0.35**2 - abs(d - b) ** 2 / 4) * (d - b) / abs(d - b)
    linkage = Linkage(
        {name: (z.real, z.imag) for name, z in {"A": -0.1 + 0j, "B": b, "P": p, "D": d, "E": 0.1 + 0j}.items()}
    )
    for name, ends in {"left": "AB", "left rod": "BP", "right rod": "DP", "right": "ED"}.items():
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "left", drive=True, reference=left)
    linkage.revolute("E", "ground", "right", drive=True, reference=right)
    linkage.revolute("B", "left", "left rod")
    linkage.revolute("D", "right", "right rod")
    linkage.revolute("P", "left rod", "right rod")
    return linkage


def test_other_drives_stand_still() -> None:
    """5R robot, one arm held: the other can go on until the rods lie in line, |B - D| = 0.7."""
    left, right = 2.0, 0.2
    linkage = five_bar(left, right)
    d = 0.1 + 0.3 * np.exp(1j * right)
    away = abs(d + 0.1)
    found = linkage.drive_range("A")
    assert_allclose(found.upper - np.angle(d + 0.1), triangle(0.3, away, 0.7), **CLOSE)
    assert (found.lower_joint, found.upper_joint) == ("P", "P")


def test_range_ends_where_the_linkage_runs_away() -> None:
    """RCCC: the angles are those of a spherical four-bar; at its limits the slides go to infinity, and come near only.

    There the axes a1, a2 and a3 lie in one plane: a1(θ) a3 = cos(α12 ± α23).
    """
    rng = np.random.default_rng(5)
    places, axes = rng.uniform(-1.0, 1.0, (4, 3)), rng.normal(size=(4, 3))
    linkage = Linkage({f"P{k}": place for k, place in enumerate(places)})
    links = ("ground", "input", "coupler", "output", "ground")
    for k in range(3):
        linkage.link(links[k + 1], f"P{k}", f"P{k + 1}")
    linkage.revolute("P0", "ground", "input", axis=axes[0], drive=True)
    for k in (1, 2):
        linkage.cylindrical(f"P{k}", links[k], links[k + 1], axis=axes[k])
    linkage.cylindrical("P3", "ground", "output", axis=axes[3])
    a0, a1, a2, a3 = axes / np.linalg.norm(axes, axis=1, keepdims=True)
    # a1 turned by θ about a0, along a3: constant + cosine cos θ + sine sin θ (O. Rodrigues)
    constant, sine = (a0 @ a1) * (a0 @ a3), np.cross(a0, a1) @ a3
    cosine = a1 @ a3 - constant
    limits = []
    for sign in (1.0, -1.0):
        share = (np.cos(np.arccos(a1 @ a2) + sign * np.arccos(a2 @ a3)) - constant) / np.hypot(cosine, sine)
        if abs(share) < 1.0:
            limits += [np.arctan2(sine, cosine) + turn * np.arccos(share) for turn in (1.0, -1.0)]
    found = linkage.drive_range("P0")
    assert_allclose(found.lower, max(limit for limit in limits if limit < 0.0), **CLOSE)
    assert_allclose(found.upper, min(limit for limit in limits if limit > 0.0), **CLOSE)
    assert {found.lower_joint, found.upper_joint} <= {"P2", "P3"}
    inside, outside = found.upper - 1e-3, found.upper + 1e-3
    assert [str(status)[:7] for status in linkage.move(P0=[inside, outside]).closure_status] == ["regular", "not ass"]


def test_entries_of_a_batch() -> None:
    """Crank and rod in line at both ends of the piston's stroke, rod + crank and rod - crank, for each of the rods."""
    rods = np.array([[2.0, 3.0], [4.0, 5.0]])
    linkage = Linkage(A=(0, 0), B=(0, 1), C=np.stack([np.sqrt(rods**2 - 1.0), 0.0 * rods], axis=-1))
    for name, points in {"crank": "AB", "rod": "BC", "piston": "C"}.items():
        linkage.link(name, *points)
    for joint, links in {"A": ("ground", "crank"), "B": ("crank", "rod"), "C": ("rod", "piston")}.items():
        linkage.revolute(joint, *links)
    linkage.prismatic("C", "ground", "piston", axis=(1, 0), reference=np.sqrt(rods**2 - 1.0), name="slide", drive=True)
    for entry in ((0, 0), (1, 0), (-1, 1)):
        ends = [rods[entry] - 1.0, rods[entry] + 1.0]
        assert_allclose([point.value for point in linkage.dead_points("slide", entry=entry)], ends, rtol=1e-12)
        found = linkage.drive_range("slide", entry=entry)
        assert_allclose([found.lower, found.upper], ends, rtol=1e-12)
        assert linkage.mobility(entry=entry).actual == 1
    assert_allclose(linkage.drive_range("slide").upper, rods[0, 0] + 1.0, rtol=1e-12)
    for wrong in (0, (0, 2), (0, 0, 0)):
        with pytest.raises(FrameError, match="give one index for each of the batch axes"):
            linkage.mobility(entry=wrong)


def test_refusals() -> None:
    linkage = five_bar(2.0, 1.0)
    with pytest.raises(FrameError, match="joint 'B' is not among the drives A, E: choose one of them"):
        linkage.dead_points("B")
    with pytest.raises(FrameError, match=r"coordinate None of joint 'B': choose one that it has \(rx, ry, rz\)"):
        rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3).dead_points("B")
    rigid = loop((1.0, 0.7, 0.9, 1.2), (0.5, 0.9, -0.4, 0.3), (0.3, 0.8, -0.5, 1.1))
    with pytest.raises(FrameError, match="joint 'H0' cannot move"):
        rigid.drive_range("H0")
