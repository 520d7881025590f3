"""Any number may be an array: members of a batch are what they are alone, to the last bit, however they are cut."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import FourBar, Linkage
from linkframe.models.linkage.kinematics import blocks
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import bennett, four_bar, rssr
from reference.spatial import stewart


def tolerant(count, spread=1e-2, seed=0):
    """A four-bar whose lengths are random, drawn with one set of them; and the lengths."""
    rng = np.random.default_rng(seed)
    a, b, c, d = (nominal * (1.0 + spread * rng.standard_normal(count)) for nominal in (0.1, 0.25, 0.2, 0.22))
    linkage = Linkage(
        A=(0, 0), B=(0.05, 0.05 * np.sqrt(3.0)), D=(0.2, 0.24), E=np.stack([d, 0.0 * d], axis=-1), P=(0.1, 0.3)
    )
    linkage.link("crank", "A", "B", length=a)
    linkage.link("coupler", "B", "D", length=b)
    linkage.link("rocker", "D", "E", length=c)
    linkage.revolute("A", "ground", "crank", drive=True, reference=np.pi / 3)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage, (a, b, c, d)


def test_random_lengths_are_the_closed_form():
    theta = np.linspace(0.0, 2.0 * np.pi, 37)[:, None]
    linkage, (a, b, c, d) = tolerant(50)
    motion = linkage.move(A=theta, rates={"A": 2.0})
    closed = FourBar(a, b, c, d, branch="open").move(theta, rate=2.0)
    assert motion.shape == (37, 50)
    for point in "BDE":
        assert_allclose(motion.position(point), closed.position(point), atol=1e-15)
        assert_allclose(motion.velocity(point), closed.velocity(point), atol=1e-14)
    assert motion.gap.max() < 1e-13 * 0.25


def test_wide_spread_is_reached_step_by_step():
    theta = np.linspace(0.0, 2.0 * np.pi, 37)[:, None]
    linkage, (a, b, c, d) = tolerant(200, spread=0.08)
    motion = linkage.move(A=theta)
    four_bars = FourBar(a, b, c, d, branch="open")
    reach = four_bars.assembles(theta)
    assert_array_equal(motion.is_assembled[reach], True)
    safe = np.broadcast_to(reach.all(axis=0), reach.shape)
    closed = FourBar(*(x[reach.all(axis=0)] for x in (a, b, c, d)), branch="open").move(theta)
    found = motion.position("D")[safe].reshape(37, -1, 3)
    assert_allclose(found, closed.position("D"), atol=1e-13)


@pytest.mark.parametrize("members", [1, 7, 10**6])
def test_bits_do_not_depend_on_the_blocks(members, monkeypatch):
    theta = np.linspace(0.0, 6.0, 23)[:, None]
    expected = tolerant(40)[0].move(A=theta, rates={"A": 1.0})
    monkeypatch.setattr(blocks.blocks, "__defaults__", (members,))
    motion = tolerant(40)[0].move(A=theta, rates={"A": 1.0})
    for point in "BD":
        assert_array_equal(motion.position(point), expected.position(point))
        assert_array_equal(motion.velocity(point), expected.velocity(point))


def test_blocks_cover_the_batch_once():
    for shape in ((), (5,), (3, 4), (7, 1, 11), (2, 3, 5)):
        for members in (1, 4, 6, 100):
            count = np.zeros(shape, dtype=int)
            for block in blocks.blocks(shape, members):
                assert count[block].size <= members
                count[block] += 1
            assert np.all(count == 1)


@pytest.mark.parametrize(
    "linkage",
    [four_bar(2, 7, 9, 6, 0.5), bennett(0.5, 1.2, 1.0), rssr(0.4, 1.2, 1.0, (0.7, 0.9, 0.3), 0.8, universal=True)],
)
def test_a_pose_alone_is_the_pose_of_the_sweep(linkage):
    (joint,) = linkage.drives
    values = float(linkage.joint(joint).reference[0]) + np.linspace(-0.4, 0.4, 9)
    sweep = linkage.move({joint: values})
    for k, value in enumerate(values):
        alone = linkage.move({joint: value})
        assert alone.shape == ()
        for name, link in linkage.links.items():
            assert_allclose(alone.position(link.points[0], name), sweep.position(link.points[0], name)[k], atol=1e-14)
            assert_allclose(alone.axes(name), sweep.axes(name)[k], atol=1e-14)


def test_grid_of_several_drives_broadcasts():
    linkage = stewart()[0]
    first, second = np.linspace(-0.05, 0.05, 4)[:, None], np.linspace(0.0, 0.1, 3)
    motion = linkage.move(M0=first, M1=second)
    assert motion.shape == (4, 3)
    assert_allclose(motion.coordinate("M0")[..., 0], np.broadcast_to(first, (4, 3)))
    assert_allclose(motion.coordinate("M1")[..., 0], np.broadcast_to(second, (4, 3)))
    assert_allclose(motion.coordinate("M2")[..., 0], 0.0)
    for i in range(4):
        for j in range(3):
            alone = linkage.move(M0=first[i, 0], M1=second[j])
            assert_allclose(motion.position("O")[i, j], alone.position("O"), atol=1e-13)


def test_rates_may_have_axes_of_their_own():
    motion = four_bar(2, 7, 9, 6, 0.5).move(A=np.array([0.5, 0.6])[:, None], rates={"A": [1.0, 2.0, 3.0]})
    assert motion.velocity("D").shape == (2, 3, 3)
    assert motion.position("D").shape == (2, 3, 3)
    assert_allclose(motion.velocity("D")[:, 2], 3.0 * motion.velocity("D")[:, 0])


def test_members_reach_further_than_the_one_that_leads():
    """The end of a rocker's swing for random bars: as far as the triangle of coupler and rocker closes, and no less."""
    rng = np.random.default_rng(0)
    crank, coupler, rocker = (length * (1.0 + 0.01 * rng.standard_normal(200)) for length in (2.0, 1.8, 3.9))
    drawn = four_bar(2.0, 1.8, 3.9, 4.0, np.pi / 2)
    linkage = Linkage(drawn.points)
    for (name, link), length in zip(drawn.links.items(), (crank, coupler, rocker), strict=True):
        linkage.link(name, *link.points, length=length)
    for name, joint in drawn.joints.items():
        linkage.revolute(name, joint.first, joint.second, drive=name in drawn.drives, reference=joint.reference[..., 0])
    theta = np.radians(np.arange(120.0, 154.0, 3.0))[:, None]
    motion = linkage.move(A=theta)
    diagonal = np.abs(4.0 - crank * np.exp(1j * theta))
    there = diagonal < coupler + rocker
    assert_array_equal(motion.is_assembled, there)
    assert 200 < np.count_nonzero(there) < there.size - 200
    assert np.all(motion.closure_status[there] == "regular")
    turned = [np.broadcast_to(x, there.shape)[there] for x in (crank, coupler, rocker, theta)]
    closed = FourBar(*turned[:3], 4.0, branch="open").move(turned[3])
    assert_allclose(motion.position("D")[there], closed.position("D"), atol=1e-11)


@pytest.mark.parametrize("universal", [True, False])
def test_members_of_a_spatial_linkage_reach_as_far_as_their_quadratic(universal):
    """R-S-S-R with random rods: closed where (rod^2 - rocker^2 - |q - b|^2) lies within its amplitude."""
    crank, rocker, pivot, start = 0.5, 0.4, np.array([0.2, 0.9, 0.3]), 0.9
    rods = 0.75 * (1.0 + 0.01 * np.random.default_rng(0).standard_normal(100))
    drawn = rssr(crank, 0.75, rocker, pivot, start, universal)
    linkage = Linkage(drawn.points)
    for name, link in drawn.links.items():
        linkage.link(name, *link.points, length=rods if name == "rod" else None)
    for name, joint in drawn.joints.items():
        second = {"second": joint.axes[:, 0]} if joint.kind.name == "universal" else {}
        make = getattr(linkage, joint.kind.name)
        make(
            name,
            joint.first,
            joint.second,
            axis=joint.axes[:, 2],
            drive=name == "O",
            reference=joint.reference[..., 0] if joint.kind.freedom == 1 else 0.0,
            **second,
        )
    theta = np.linspace(-1.0, 0.9, 39)[:, None]
    motion = linkage.move(O=theta)
    b = crank * np.stack([np.cos(theta), np.sin(theta), 0.0 * theta], axis=-1)
    away = pivot - b
    amplitude = 2.0 * rocker * np.hypot(away[..., 1], away[..., 2])
    there = np.abs(rods**2 - rocker**2 - np.sum(away**2, axis=-1)) < amplitude
    assert_array_equal(motion.is_assembled, there)
    assert 0.1 < there.mean() < 0.9
    if universal:
        assert np.all(motion.closure_status[there] == "regular")
