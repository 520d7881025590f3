"""Fuzzy inputs: cuts of results against closed forms, dense grids, and the worst case of each level."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework import FrameError
from linkframe.models import FuzzyNumber, Linkage, propagate_fuzzy
from numpy.testing import assert_allclose, assert_array_equal

Array = np.ndarray
CRANK, COUPLER, ROCKER, GROUND = 0.1, 0.25, 0.2, 0.22
ANGLES = np.radians([30.0, 100.0, 200.0, 320.0])


def rocker_angle(crank: Array, coupler: Array, rocker: Array, angle: Array) -> Array:
    """Angle of the rocker of a four-bar with the ground GROUND: the law of cosines in both triangles."""
    x, y = crank * np.cos(angle) - GROUND, crank * np.sin(angle)
    reach = np.hypot(x, y)
    inner = np.arccos((rocker**2 + reach**2 - coupler**2) / (2.0 * rocker * reach))
    return np.unwrap(np.stack(np.broadcast_arrays(np.arctan2(y, x) % (2.0 * np.pi) - inner, 0.0))[:1])[0]


def four_bar(crank: Array = CRANK, coupler: Array = COUPLER, rocker: Array = ROCKER) -> Linkage:
    """The same as a linkage, at the drive's angle 30°."""
    angle = ANGLES[0]
    out = rocker_angle(crank, coupler, rocker, angle)
    b = np.stack(np.broadcast_arrays(crank * np.cos(angle), crank * np.sin(angle), 0.0 * out), axis=-1)
    d = np.stack(np.broadcast_arrays(GROUND + rocker * np.cos(out), rocker * np.sin(out), 0.0 * out), axis=-1)
    linkage = Linkage(A=(0, 0), B=b, D=d, E=(GROUND, 0))
    for name, ends in (("crank", "AB"), ("coupler", "BD"), ("rocker", "DE")):
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "crank", drive=True, reference=angle)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(-10.0, 10.0), min_size=4, max_size=4).map(sorted), st.floats(0.0, 1.0))
def test_numbers_are_their_cuts(corners: list[float], level: float) -> None:
    """Ends of a cut have its level or more, and what is further out less."""
    low, first, last, high = corners
    number = FuzzyNumber.trapezoidal(low, first, last, high)
    lower, upper = number.cut(level)
    assert_allclose([lower, upper], [low + level * (first - low), high + level * (last - high)], rtol=0.0, atol=1e-14)
    assert (
        min(number.membership(lower), number.membership(upper)) >= level - 1e-9 or min(first - low, high - last) < 1e-6
    )
    assert number.membership([first, last, 0.5 * (first + last)]).tolist() == [1.0, 1.0, 1.0]
    assert number.membership([low - 1e-3, high + 1e-3, np.nan])[:2].tolist() == [0.0, 0.0]


def test_steps_in_a_number() -> None:
    """An end that stands still over some levels has the highest of them."""
    number = FuzzyNumber.from_cuts([0.0, 0.5, 1.0], [1.0, 1.0, 2.0], [5.0, 4.0, 4.0])
    assert number.membership([1.0, 1.5, 2.0, 4.0, 4.5, 5.0]).tolist() == [0.5, 0.75, 1.0, 1.0, 0.25, 0.0]
    assert repr(number) == "<FuzzyNumber: 2 to 4, from 1 to 5>"


@pytest.mark.parametrize("method", ["corners", "search"])
def test_monotone(method: str) -> None:
    """A quotient of positive numbers is largest where its parts are so, at every level, to the bit."""
    inputs = {"a": (1.0, 2.0, 3.0), "b": (2.0, 3.0), "c": (1.0, 1.5, 2.0, 4.0)}
    found = propagate_fuzzy(lambda a, b, c: a * b / c, inputs, levels=5, method=method)
    level = np.linspace(0.0, 1.0, 5)
    assert_array_equal(found.lower, (1.0 + level) * 2.0 / (4.0 - 2.0 * level))
    assert_array_equal(found.upper, (3.0 - level) * 3.0 / (1.0 + 0.5 * level))
    assert_array_equal(found.at_upper["c"], 1.0 + 0.5 * level)
    assert found.membership(found.upper).tolist() == level.tolist()
    assert found.number().cut(0.25) == (found.lower[1], found.upper[1])


def test_not_monotone() -> None:
    """Ishigami's function, -(1 + b π⁴) to a + 1 + b π⁴ where all inputs are within ± π; and x² on [-1, 2]."""
    a, b = 7.0, 0.1
    found = propagate_fuzzy(
        lambda x, y, z: np.sin(x) + a * np.sin(y) ** 2 + b * z**4 * np.sin(x),
        dict.fromkeys("xyz", (-np.pi, 0.0, np.pi)),
    )
    part = 1.0 - found.levels
    most = np.sin(np.pi * np.minimum(part, 0.5)) * (1.0 + b * (np.pi * part) ** 4)
    assert_allclose(found.upper, most + a * np.sin(np.pi * np.minimum(part, 0.5)) ** 2, rtol=1e-12, atol=1e-12)
    assert_allclose(found.lower, -most, rtol=1e-12, atol=1e-12)
    square = propagate_fuzzy(lambda x: x**2, {"x": (-1.0, 2.0)}, levels=2)
    assert (square.lower.tolist(), square.upper.tolist()) == ([0.0, 0.0], [4.0, 4.0])


def of_quadratic(h: Array, g: Array) -> tuple[float, float]:
    """Smallest and largest value of ``x h x / 2 + g x`` in [-1, 1]^k: each face has its stationary point, if within."""
    values = []
    for face in itertools.product((-1.0, 0.0, 1.0), repeat=len(g)):
        x = np.array(face)
        free = x == 0.0
        x[free] = np.linalg.solve(h[np.ix_(free, free)], -(g[free] + h[np.ix_(free, ~free)] @ x[~free]))
        if np.abs(x).max() <= 1.0:
            values.append(float(0.5 * x @ h @ x + g @ x))
    return min(values), max(values)


def quadratic(rng: np.random.Generator) -> tuple[int, Callable[[Array], Array], tuple[float, float]]:
    """A quadratic that bends up in some directions and down in others, and its extremes."""
    k = int(rng.integers(2, 7))
    h = rng.normal(size=(k, k))
    h, g = h + h.T, rng.normal(size=k) * rng.uniform(0.0, 2.0)
    return k, lambda x: 0.5 * np.einsum("ni,ij,nj->n", x, h, x) + x @ g, of_quadratic(h, g)


def waves(rng: np.random.Generator) -> tuple[int, Callable[[Array], Array], tuple[float, float]]:
    """A sum of functions of one input each, with several hills, and its extremes: from 200 001 values of each."""
    k = int(rng.integers(1, 6))
    size, pitch, phase, slope = (
        rng.normal(size=k), rng.uniform(0.5, 4.0, size=k), rng.uniform(0.0, 6.28, size=k), rng.normal(size=k)
    )  # fmt: skip

    def each(x: Array) -> Array:
        return size * np.sin(pitch * x + phase) + slope * x

    grid = each(np.linspace(-1.0, 1.0, 200_001)[:, None])
    return k, lambda x: each(x).sum(axis=1), (grid.min(axis=0).sum(), grid.max(axis=0).sum())


@pytest.mark.parametrize(("case", "seed"), [(quadratic, 1), (quadratic, 2), (waves, 2), (waves, 3)])
def test_the_highest_of_several_hills(case: Callable[[np.random.Generator], Any], seed: int) -> None:
    """From one corner and one point within, three in a hundred of these end on a lower one."""
    rng = np.random.default_rng(seed)
    for _ in range(60):
        k, function, (least, greatest) = case(rng)
        found = propagate_fuzzy(
            lambda call=function, **x: call(np.stack(list(x.values()), axis=-1)),
            {f"x{i}": (-1.0, 1.0) for i in range(k)},
            levels=2,
        )
        near = 1e-8 * (greatest - least)
        assert_allclose([found.lower[0], found.upper[0]], [least, greatest], rtol=0.0, atol=near)


def test_many_inputs() -> None:
    """A sum of parabolas in twelve inputs, some with their lowest point within: more corners than are tried."""
    weight, middle = np.linspace(-1.0, 2.0, 12), np.linspace(-1.5, 1.5, 12)
    names = [f"x{k}" for k in range(12)]
    found = propagate_fuzzy(
        lambda **x: sum(w * (x[name] - m) ** 2 for w, m, name in zip(weight, middle, names, strict=True)),
        dict.fromkeys(names, (-1.0, 0.0, 1.0)),
        levels=3,
    )
    half = (1.0 - found.levels)[:, None]
    near, far = np.maximum(np.abs(middle) - half, 0.0) ** 2, (np.abs(middle) + half) ** 2
    assert_allclose(found.lower, np.sum(np.where(weight > 0.0, weight * near, weight * far), axis=1), rtol=1e-12)
    assert_allclose(found.upper, np.sum(np.where(weight > 0.0, weight * far, weight * near), axis=1), rtol=1e-12)


def test_four_bar_beside_a_dense_grid() -> None:
    """Never within what a grid of the closed form finds, and not outside by more than the grid's steps allow."""
    inputs = {"crank": (0.09, CRANK, 0.115), "coupler": (0.24, COUPLER, 0.26), "rocker": (0.18, ROCKER, 0.21)}
    found = propagate_fuzzy(
        lambda **x: rocker_angle(*(each[:, None] for each in x.values()), ANGLES), inputs, levels=[0.0, 0.4, 1.0]
    )
    for k, level in enumerate(found.levels):
        ends = [FuzzyNumber.triangular(*each).cut(level) for each in inputs.values()]
        grid = np.meshgrid(*(np.linspace(low, high, 41) for low, high in ends))
        there = rocker_angle(*(each.reshape(-1, 1) for each in grid), ANGLES)
        for mine, theirs in ((found.lower[k], there.min(axis=0)), (-found.upper[k], -there.max(axis=0))):
            assert np.all(mine <= theirs + 1e-14)
            assert np.all(mine >= theirs - 2e-4)


def test_first_order_and_the_worst_case_of_each_level() -> None:
    """Of small tolerances of the lengths: by derivatives, by search over linkages closed anew, by `Motion.fuzzy`."""
    size = 1e-6
    motion = four_bar().move(A=ANGLES)
    tolerances = {"crank": (-size, 0.0, 2.0 * size), "coupler": (-size, 0.0, size), "rocker": (0.0, 0.0, size)}
    lengths = {"crank": CRANK, "coupler": COUPLER, "rocker": ROCKER}
    by = motion.sensitivity("D", "coupler").lengths
    first = motion.fuzzy("D", "coupler", levels=3, lengths=tolerances)

    def height(**x: Array) -> Array:
        moved = four_bar(**{name: each[:, None] for name, each in x.items()}).move(A=ANGLES)
        return moved.position("D", "coupler")[..., 1]

    inputs = {name: tuple(lengths[name] + each for each in tolerances[name]) for name in lengths}
    along = first.along((0, 1))
    slopes = propagate_fuzzy(
        height, inputs, levels=3, method="first order", gradient=lambda **_: {k: by[k][:, 1] for k in by}
    )
    differences = propagate_fuzzy(height, inputs, levels=3, method="first order")
    searched = propagate_fuzzy(height, inputs, levels=3, samples=8)
    nominal = motion.position("D", "coupler")[:, 1]
    for other, near in ((slopes, 1e-14), (differences, 1e-12), (searched, 200.0 * size**2)):
        assert_allclose(other.lower - nominal, along.lower, rtol=0.0, atol=near)
        assert_allclose(other.upper - nominal, along.upper, rtol=0.0, atol=near)
    assert np.abs(along.upper).max() > size
    for k, level in enumerate(first.levels):
        cut = {name: FuzzyNumber.triangular(*each).cut(level) for name, each in tolerances.items()}
        assert_allclose(first.worst.greatest[k], motion.worst_case("D", "coupler", lengths=cut).greatest, rtol=1e-12)
    assert_allclose(along.membership(0.5 * along.upper[0]), 0.5, rtol=1e-12)


def test_fuzzy_clearances() -> None:
    """What a clearance of fuzzy size allows is what its largest does; crisp ones are there at every level."""
    motion = four_bar().move(A=ANGLES)
    found = motion.fuzzy("D", levels=3, clearances={"B": (1e-5, 2e-5, 4e-5), "D": 1e-5}, drives={"A": (-1e-4, 2e-4)})
    assert found.worst.shape == (3, 4)
    worst = motion.worst_case("D", clearances={"B": 3e-5, "D": 1e-5}, drives={"A": (-1e-4, 2e-4)})
    assert_allclose(found.worst.greatest[1], worst.greatest, rtol=1e-12)
    assert "11 levels" in repr(motion.fuzzy("D", drives={"A": 1e-4}))


def test_points_without_a_result_are_told() -> None:
    found = propagate_fuzzy(lambda x: np.sqrt(np.where(x < 0.0, np.nan, x)), {"x": (-1.0, 1.0, 2.0)}, levels=3)
    assert found.failed > 0
    assert "without a result" in repr(found)
    assert_allclose(found.upper, np.sqrt([2.0, 1.5, 1.0]), rtol=1e-14)


@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda: FuzzyNumber.triangular(2.0, 1.0, 3.0), "those of higher levels must lie"),
        (lambda: FuzzyNumber.from_cuts([0.1, 1.0], [0, 1], [3, 2]), "let them rise from 0 to 1"),
        (lambda: propagate_fuzzy(np.sin, {}), "given no input"),
        (lambda: propagate_fuzzy(lambda x: x, {"x": 3.0}), "fuzzy input 'x' is 3.0: give a FuzzyNumber"),
        (lambda: propagate_fuzzy(lambda x: x, {"x": (0, 1)}, method="grid"), "choose one of search, corners"),
        (lambda: propagate_fuzzy(lambda x: x, {"x": (0, 1)}, levels=1), "give 2 or more"),
        (lambda: propagate_fuzzy(lambda x: x[:3], {"x": (0, 1)}), "the function returned shape"),
        (lambda: four_bar().move().fuzzy("D", lenghts={}), "'lenghts' are none of a worst case"),
        (lambda: four_bar().move().fuzzy("D", clearances={"B": (-1e-5, 0.0, 1e-5)}), "give zero or more"),
    ],
)
def test_what_is_refused(call: object, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        call()  # type: ignore[operator]
