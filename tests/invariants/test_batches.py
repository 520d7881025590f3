"""A batch is its members: any broadcast of poses, samples and load cases equals the frames solved one by one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, Solution
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.compare import FORCES, allowed, apart
from reference.random_structures import few

Array = NDArray[np.float64]
Parameters = dict[str, Array]

NODES = ("A", "B1", "B2", "P", "D1", "D2", "E1", "E2")
MEMBERS = {"crank": ("A", "B1"), "arm1": ("B2", "P"), "arm2": ("P", "D1"), "rocker": ("D2", "E1")}


def linkage(p: Parameters) -> Frame:
    """A compliant four-bar every number of which may be an array."""
    theta, lift = p["theta"], p["lift"]
    zero = np.zeros(np.broadcast_shapes(theta.shape, lift.shape))
    x, y = 0.1 * np.cos(theta) + zero, 0.1 * np.sin(theta) + zero
    b, d = np.stack([x, y, zero], axis=-1), np.stack([x + 0.2, y, zero], axis=-1)
    frame = Frame()
    places = {"A": np.zeros(3), "P": (b + d) / 2 + np.stack([zero, zero, lift + zero], axis=-1)}
    places |= {"B1": b, "B2": b, "D1": d, "D2": d}
    places |= dict.fromkeys(("E1", "E2"), np.array([0.2, 0.0, 0.0]))
    for name in NODES:
        frame.node(name, places[name])
    beam = Beam(Rectangle(y=p["depth"], z=6.35e-3), Material(E=p["E"], nu=0.3, density=7850.0))
    for name, ends in MEMBERS.items():
        frame.add(name, beam, *ends)
    k = p["stiffness"]
    springs = np.stack([k, k, k, k, k, np.zeros_like(k)], axis=-1)
    for name in "BDE":
        frame.add(name, Joint(stiffness=springs), f"{name}1", f"{name}2")
    frame.fix("A")
    frame.prescribe("E2", ux=p["settlement"], uy=0.0, uz=0.0, rx=0.0, ry=0.0, rz=0.0)
    frame.load("P", fy=p["load"], fz=10.0)
    frame.line_load("crank", fy=p["line"])
    frame.point_load("rocker", at=0.05, fx=p["point"])
    frame.gravity((0.0, 0.0, -9.81))
    frame.offset("D", uy=p["clearance"])
    return frame


DEFAULTS = {
    "theta": 1.0,
    "lift": 0.02,
    "depth": 12.7e-3,
    "E": 2e11,
    "stiffness": 2e8,
    "settlement": 1e-4,
    "load": 100.0,
    "line": -30.0,
    "point": 20.0,
    "clearance": 1e-4,
}

READINGS: dict[str, Callable[[Solution], Array]] = {
    "displacement": lambda s: np.stack(np.broadcast_arrays(*(s.displacement(name) for name in NODES)), axis=-2),
    "reaction": lambda s: np.stack(np.broadcast_arrays(*(s.reaction(name) for name in ("A", "E2"))), axis=-2),
    "joint displacement": lambda s: np.stack(np.broadcast_arrays(*(s.joint_displacement(n) for n in "BDE")), axis=-2),
    "joint force": lambda s: np.stack(np.broadcast_arrays(*(s.joint_force(name) for name in "BDE")), axis=-2),
    "end forces": lambda s: s.end_forces("crank").reshape(*s.shape, 2, 6),
    "forces": lambda s: s.forces("rocker", np.array([0.0, 0.03, 0.07])),
    "along": lambda s: s.displacement_along("crank", np.array([0.01, 0.05])),
}


def given_arrays(**arrays: Any) -> Parameters:
    """Defaults, with some given as arrays."""
    return {name: np.asarray(arrays.get(name, value), dtype=np.float64) for name, value in DEFAULTS.items()}


def assert_is_its_members(arrays: Parameters, entries: int | None = None) -> None:
    """Every (or some) entries of the batch against single frames of plain floats."""
    whole = linkage(arrays)
    shape = np.broadcast_shapes(*(value.shape for value in arrays.values()))
    assert whole.shape == shape
    solution = whole.solve()
    every = {name: np.broadcast_to(value, shape) for name, value in arrays.items()}
    indices = list(np.ndindex(shape))
    if entries is not None:
        indices = [indices[i] for i in np.linspace(0, len(indices) - 1, entries).astype(int)]
    read = {name: reading(solution) for name, reading in READINGS.items()}
    kappa = np.broadcast_to(solution.scaled_condition_number(), shape)
    for name, values in read.items():
        assert values.shape[: len(shape)] == shape, name
    for index in indices:
        single = linkage({name: value[index] for name, value in every.items()}).solve()
        assert single.shape == ()
        assert_allclose(kappa[index], single.scaled_condition_number(), rtol=1e-6)
        for name, values in read.items():
            factor = 2.0 if name in ("displacement", "along") else 2.0 * FORCES
            assert apart(values[index], READINGS[name](single)) <= factor * allowed(kappa[index]), (name, index)


@pytest.mark.parametrize(
    "arrays",
    [
        pytest.param({"theta": [[0.3], [1.2], [2.5]], "stiffness": [1e7, 1e9, 2e11, 1e8]}, id="poses x joints"),
        pytest.param({"load": [[1.0], [-50.0]], "theta": [0.4, 0.8, 2.0]}, id="loads x poses"),
        pytest.param({"E": [1e11, 2e11], "depth": [[0.01], [0.02]], "lift": [[[0.0]], [[0.05]]]}, id="links"),
        pytest.param({"clearance": [-1e-4, 0.0, 1e-4], "settlement": [[0.0], [1e-3]]}, id="imposed displacements"),
        pytest.param({"line": [1.0, 2.0], "point": [[3.0], [4.0]], "theta": [[[0.5]], [[1.0]]]}, id="member loads"),
        pytest.param({"theta": [1.0]}, id="an axis of one"),
    ],
)
def test_a_batch_equals_its_members(arrays: dict[str, Any]) -> None:
    """Axes in any place, for every kind of parameter."""
    assert_is_its_members(given_arrays(**arrays))


def test_poses_by_samples() -> None:
    """(36, 1) poses by (100,) samples of stiffness, load and clearance: 20 of the 3600 entries one by one."""
    rng = np.random.default_rng(1)
    arrays = given_arrays(
        theta=np.radians(np.arange(5, 365, 10))[:, None],
        stiffness=2e9 * np.exp(rng.normal(size=100)),
        load=100.0 + 5.0 * rng.normal(size=100),
        clearance=1e-4 * rng.normal(size=100),
    )
    assert_is_its_members(arrays, entries=20)


@few
@given(st.integers(0, 2**32 - 1))
def test_any_axes(seed: int) -> None:
    """Each parameter with random axes of a common (2, 3) shape."""
    rng = np.random.default_rng(seed)
    shapes = [(), (3,), (1, 3), (2, 1), (2, 3)]
    arrays = {}
    for name, value in DEFAULTS.items():
        if rng.random() < 0.4:
            arrays[name] = value * rng.uniform(0.7, 1.3, size=shapes[int(rng.integers(len(shapes)))])
    assert_is_its_members(given_arrays(**arrays), entries=3)


def test_the_same_frame_gives_the_same_bits() -> None:
    """Solving twice, and reading in another order, gives equal bits."""
    arrays = given_arrays(theta=[[0.3], [1.2]], stiffness=[1e7, 1e9, 2e11])
    one, two = linkage(arrays).solve(), linkage(arrays).solve()
    first = {name: reading(one) for name, reading in READINGS.items()}
    second = {name: READINGS[name](two) for name in reversed(READINGS)}
    for name, values in first.items():
        assert np.array_equal(values, second[name])


def test_entries_do_not_depend_on_their_neighbours() -> None:
    """The same entry in a longer batch: equal bits whatever the chunks; in one of a few, done otherwise: to 1e-14."""
    rng = np.random.default_rng(2)
    k = 2e9 * np.exp(rng.normal(size=5000))
    long, middle, short = (
        linkage(given_arrays(stiffness=k[part])).solve().displacement("P")
        for part in (slice(None), slice(0, 2000), slice(1234, 1240))
    )
    assert np.array_equal(long[:2000], middle)
    assert_allclose(long[1234:1240], short, rtol=0, atol=1e-14 * np.abs(short).max())
