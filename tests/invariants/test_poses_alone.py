"""A pose depends on itself and the reference configuration alone: not on its neighbours, nor on any order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Material
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import rssr

seeds = st.integers(0, 2**32 - 1)
ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
PIN = (2e8, 2e8, 2e8, 2e5, 2e5, 0.0)


def four_bar(rng, count=0, order=None) -> tuple[Linkage, dict[str, float]]:
    """A crank, a coupler and a rocker; with `count`, as many of them, of lengths of their own."""
    places = {"A": (0.0, 0.0), "B": (0.0, 0.1), "D": (0.25, 0.2), "E": (0.25, 0.0), "P": (0.1, 0.25)}
    places = {name: np.array(place) + rng.uniform(-0.02, 0.02, 2) for name, place in places.items()}
    spread = 1.0 + 0.03 * rng.standard_normal((2, count)) if count else (None, None)
    links = {"crank": "AB", "coupler": "BPD", "rocker": "DE"}
    pins = {"A": ("ground", "crank"), "B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}
    lengths = {}
    for name, share in zip(("crank", "rocker"), spread, strict=True):
        if share is not None:
            first, last = (places[point] for point in (links[name][0], links[name][-1]))
            lengths[name] = np.linalg.norm(last - first) * share
    return built(places, links, pins, ("A",), lengths, order), {"A": 3.5}


def five_bar(rng, count=0, order=None) -> tuple[Linkage, dict[str, float]]:
    """Two driven arms and two rods."""
    places = {"A": (-0.1, 0), "B": (-0.3, 0.3), "P": (0, 0.5), "D": (0.3, 0.3), "E": (0.1, 0)}
    places = {name: np.array(place) + rng.uniform(-0.02, 0.02, 2) for name, place in places.items()}
    links = {"left": "AB", "left rod": "BP", "right rod": "DP", "right": "ED"}
    pins = {
        "A": ("ground", "left"),
        "E": ("ground", "right"),
        "B": ("left", "left rod"),
        "P": ("left rod", "right rod"),
        "D": ("right", "right rod"),
    }
    lengths = {}
    if count:
        lengths["left"] = np.linalg.norm(places["B"] - places["A"]) * (1.0 + 0.03 * rng.standard_normal(count))
    return built(places, links, pins, ("A", "E"), lengths, order), {"A": 1.0, "E": 1.0}


def built(places, links, pins, drives, lengths, order) -> Linkage:
    """The linkage described in its own order, or shuffled by a generator."""

    def shuffled(names):
        return list(names) if order is None else [list(names)[k] for k in order.permutation(len(names))]

    linkage = Linkage({name: places[name] for name in shuffled(places)})
    for name in shuffled(links):
        linkage.link(name, *links[name], beam=ROD, length=lengths.get(name))
    for name in shuffled(pins):
        linkage.revolute(name, *pins[name], drive=name in drives, stiffness=None if name in drives else PIN)
    return linkage


def poses(rng, reach, count):
    return {name: far * rng.uniform(-1.0, 1.0, count) for name, far in reach.items()}


def told(motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    return motion.position("P"), motion.status


def firmly(motion: Motion) -> np.ndarray:
    """Where positions have all digits."""
    return np.nan_to_num(motion.conditioning, nan=1.0) > 1e-2


@pytest.mark.parametrize("kind", [four_bar, five_bar])
@settings(max_examples=4)
@given(seed=seeds)
def test_a_batch_of_poses_is_its_entries_in_any_order(kind, seed):
    rng = np.random.default_rng(seed)
    linkage, reach = kind(rng)
    values = poses(rng, reach, 12)
    values["A"][0] = 0.0
    motion = linkage.move(values)
    place, status = told(motion)
    firm = firmly(motion)
    turned = rng.permutation(12)
    other = linkage.move({name: value[turned] for name, value in values.items()})
    assert_array_equal(other.status, status[turned])
    assert_allclose(other.position("P")[firm[turned]], place[turned][firm[turned]], rtol=0.0, atol=1e-12)
    solution = motion.frame()
    solution.load("P", fx=100.0, fy=-50.0)
    solution = solution.solve()
    for k in range(0, 12, 3):
        alone = linkage.move({name: value[k] for name, value in values.items()})
        assert alone.status == status[k]
        if firm[k]:
            assert_allclose(alone.position("P"), place[k], rtol=0.0, atol=1e-12)
        if alone.is_assembled and firm[k]:
            frame = alone.frame()
            frame.load("P", fx=100.0, fy=-50.0)
            single = frame.solve()
            assert single.status == solution.status[k]
            there = solution.displacement("P")[k]
            assert_allclose(single.displacement("P"), there, rtol=0.0, atol=1e-9 * np.abs(there).max())
            assert_allclose(single.error_bound("P"), solution.error_bound("P")[k], rtol=0.5, atol=1e-25)


@pytest.mark.parametrize("kind", [four_bar, five_bar])
@settings(max_examples=4)
@given(seed=seeds)
def test_members_of_a_batch_of_lengths_are_what_they_are_alone(kind, seed):
    """Three percent of scatter; each is drawn with the same points, which its own lengths do not fit."""
    linkage, reach = kind(np.random.default_rng(seed), count=6)
    rng = np.random.default_rng(seed + 1)
    values = {name: value[:, None] for name, value in poses(rng, reach, 5).items()}
    motion = linkage.move(values)
    firm = firmly(motion)
    for member in (0, 3, 5):
        alone, _ = kind(np.random.default_rng(seed), count=6)
        single = Linkage(alone.points)
        for name, link in alone.links.items():
            length = link.length
            single.link(name, *link.points, beam=ROD, length=None if length is None else float(length[member]))
        for name, pair in alone.joints.items():
            single.revolute(
                name,
                pair.first,
                pair.second,
                drive=name in alone.drives,
                stiffness=None if pair.name in alone.drives else PIN,
            )
        own = single.move({name: value[:, 0] for name, value in values.items()})
        assert_array_equal(own.status, motion.status[:, member])
        chosen = firm[:, member]
        assert_allclose(own.position("P")[chosen], motion.position("P")[chosen, member], rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("kind", [four_bar, five_bar])
@settings(max_examples=4)
@given(seed=seeds)
def test_the_order_of_the_description_does_not_matter(kind, seed):
    linkage, reach = kind(np.random.default_rng(seed))
    shuffled, _ = kind(np.random.default_rng(seed), order=np.random.default_rng(seed + 1))
    values = poses(np.random.default_rng(seed + 2), reach, 8)
    one, other = linkage.move(values), shuffled.move(values)
    assert_array_equal(one.status, other.status)
    firm = firmly(one)
    for point, link in (("P", None), ("B", None), ("D", None)):
        at, there = (motion.position(point, link)[firm] for motion in (one, other))
        assert_allclose(there, at, rtol=0.0, atol=1e-12)


def test_a_free_rod_spins_alike_alone_and_in_a_batch():
    """A rod between two balls turns about itself as little as it can, on a path that is the same in any company."""
    rods = 0.75 * (1.0 + 0.01 * np.random.default_rng(0).standard_normal(5))

    def batch(rod) -> Linkage:
        drawn = rssr(0.5, 0.75, 0.4, np.array([0.2, 0.9, 0.3]), 0.9)
        linkage = Linkage(drawn.points)
        for name, link in drawn.links.items():
            linkage.link(name, *link.points, length=rod if name == "rod" else None)
        for name, pair in drawn.joints.items():
            hinge = (
                {} if pair.kind.name == "spherical" else {"axis": pair.axes[:, 2], "reference": pair.reference[..., 0]}
            )
            getattr(linkage, pair.kind.name)(name, pair.first, pair.second, drive=name in drawn.drives, **hinge)
        return linkage

    (drive,) = batch(rods).drives
    values = 0.9 + np.linspace(-0.6, 0.6, 12)
    motion = batch(rods).move({drive: values[:, None]})
    assert motion.is_assembled.all()
    for k, rod in enumerate(rods):
        sweep = batch(float(rod)).move({drive: values})
        assert_allclose(sweep.axes("rod"), motion.axes("rod")[:, k], rtol=0.0, atol=1e-12)
        single = batch(float(rod)).move({drive: values[7]})
        assert_allclose(single.axes("rod"), motion.axes("rod")[7, k], rtol=0.0, atol=1e-12)
