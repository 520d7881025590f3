"""Fits by ISO 286, and the cheapest ones that hold an accuracy."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import allocate, fit, limits_of_size, tolerance_grade
from linkframe.models.fits.iso286 import GRADES, SIZES
from numpy.testing import assert_allclose

# Mean sizes of the ranges by the standard's rule: geometric means of their limits, sqrt(1 * 3) for the first.
MEANS = [np.sqrt(low * high) for low, high in zip((1, *SIZES), SIZES, strict=False)]
# Multiples of the tolerance factor i = 0.45 D^(1/3) + 0.001 D, µm, of ISO 286-1, annex B.
FACTORS = {5: 7, 6: 10, 7: 16, 8: 25, 9: 40, 10: 64, 11: 100, 12: 160}


@pytest.mark.parametrize("grade", FACTORS)
def test_grades_are_the_formula_rounded(grade: int) -> None:
    """Within what the standard's rounding moves; the smallest sizes are rounded up further."""
    exact = np.array([FACTORS[grade] * (0.45 * np.cbrt(size) + 0.001 * size) for size in MEANS])
    printed = np.array(GRADES[grade], dtype=float)
    assert np.all(np.abs(printed - exact)[1:] <= 0.7 + 0.04 * exact[1:])
    assert exact[0] - 1.0 < printed[0] <= 1.25 * exact[0]
    assert np.all(np.diff(printed) > 0.0)


def test_fine_grades_lie_between() -> None:
    """IT2 to IT4 are about a geometric series from IT1 to IT5."""
    for k in range(13):
        first, last = GRADES[1][k], GRADES[5][k]
        for grade in (2, 3, 4):
            between = first * (last / first) ** ((grade - 1) / 4)
            assert abs(GRADES[grade][k] - between) <= 0.25 * between


@pytest.mark.parametrize(
    ("size", "name", "least", "greatest"),
    [
        # ISO 286-1 and -2 as machinery handbooks print their fits, µm on the diameter
        (25.0, "H7/g6", 7.0, 41.0),
        (10.0, "H8/f7", 13.0, 50.0),
        (50.0, "H7/h6", 0.0, 41.0),
        (30.0, "H9/d9", 65.0, 169.0),
        (80.0, "H8/e8", 60.0, 152.0),
        (40.0, "H7/k6", -18.0, 23.0),
        (18.0, "H7/n6", -23.0, 6.0),
        (60.0, "H7/p6", -51.0, -2.0),
        (3.0, "H7/js6", -3.0, 13.0),
        (120.0, "F8/h7", 36.0, 125.0),
    ],
)
def test_fits(size: float, name: str, least: float, greatest: float) -> None:
    found = fit(1e-3 * size, name)
    assert (found.least_clearance, found.greatest_clearance) == (float(f"{least}e-6"), float(f"{greatest}e-6"))
    assert found.offset == 0.5 * max(found.greatest_clearance, 0.0)


def test_ranges_hold_their_upper_limit() -> None:
    assert tolerance_grade(0.030, 7) == 21e-6
    assert tolerance_grade(0.030001, 7) == 25e-6
    assert limits_of_size(0.01, "k8").lower == 0.0
    assert limits_of_size(0.01, "k7").lower == 1e-6


@pytest.mark.parametrize(
    ("size", "name", "told"),
    [
        (0.6, "H7/g6", "sizes above 0 up to 0.5 m"),
        (0.01, "g6/H7", "write the hole's class before the shaft's"),
        (0.01, "H7/z6", "of shafts there are d, e, f, g, h, js, k, m, n, p"),
        (0.01, "H17/g6", "give a grade from 1 to 12"),
        (0.01, "Hx/g6", "write it as 'H7'"),
    ],
)
def test_fits_that_are_refused(size: float, name: str, told: str) -> None:
    with pytest.raises(FrameError, match=told):
        fit(size, name)


@pytest.mark.parametrize("combine", ["worst case", "statistical"])
def test_the_cheapest_of_all(combine: str) -> None:
    """Beside every one of the 12⁴ choices, on random effects of four joints at twenty poses and directions."""
    rng, power = np.random.default_rng(1), 1 if combine == "worst case" else 2
    held = 0
    for _ in range(10):
        effects = {joint: rng.normal(size=20) for joint in "ABCD"}
        sizes = np.sort(rng.uniform(1.0, 50.0, size=(4, 12)))
        costs = 10.0 / sizes + rng.uniform(0.0, 0.05, size=(4, 12))
        limit = float(rng.uniform(10.0, 60.0))
        choices = {
            joint: {str(k): (float(size[k]), float(cost[k])) for k in range(12)}
            for joint, size, cost in zip("ABCD", sizes, costs, strict=True)
        }
        table = np.abs(np.stack(list(effects.values())))
        index = np.array(list(product(range(12), repeat=4)))
        picked = np.take_along_axis(sizes, index.T, axis=1)
        reached = np.max(np.einsum("jr,ji->ri", table**power, picked**power), axis=0) ** (1.0 / power)
        price = np.take_along_axis(costs, index.T, axis=1).sum(axis=0)
        holds = reached <= limit
        if not holds.any():
            with pytest.raises(FrameError, match="no choice holds"):
                allocate(effects, choices, limit, combine=combine)
            continue
        held += 1
        best = int(np.argmin(np.where(holds, price, np.inf)))
        found = allocate(effects, choices, limit, combine=combine)
        assert_allclose(found.cost, price[best], rtol=1e-12)
        assert [int(found.chosen[joint]) for joint in "ABCD"] == index[best].tolist()
        assert_allclose(found.reached, reached[best], rtol=1e-12)
        assert found.binding.size
    assert held > 5


def test_allocations_that_are_refused() -> None:
    some = {"H7/g6": (1.0, 1.0)}
    with pytest.raises(FrameError, match="effects of A and choices of B"):
        allocate({"A": [1.0]}, {"B": some}, 1.0)
    with pytest.raises(FrameError, match="choices of 'A': give by name a tolerance and a cost"):
        allocate({"A": [1.0]}, {"A": {"H7/g6": (-1.0, 1.0)}}, 1.0)
    with pytest.raises(FrameError, match="the tightest of all parts come to 1"):
        allocate({"A": [1.0]}, {"A": some}, 0.5)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("unit", [1e-8, 1.0, 1e8])
def test_costs_in_any_unit(unit: float, seed: int) -> None:
    """The cheapest by trying all, whatever the costs are counted in; one part is dear in all its choices."""
    rng = np.random.default_rng(seed)
    effects = {name: rng.normal(size=5) for name in "ABCD"}
    choices = {
        name: {f"{k}": (float(rng.uniform(5e-6, 50e-6)), unit * float(10.0 ** rng.uniform(0.0, 2.0))) for k in range(3)}
        for name in effects
    }
    choices["A"] = {name: (size, cost + 1000.0 * unit) for name, (size, cost) in choices["A"].items()}
    least = np.max(
        sum(np.abs(effects[name]) * min(size for size, _ in some.values()) for name, some in choices.items())
    )
    limit, best = 2.0 * float(least), np.inf
    for chosen in product(*(some.values() for some in choices.values())):
        off = sum(np.abs(effect) * size for effect, (size, _) in zip(effects.values(), chosen, strict=True))
        if np.max(off) <= limit:
            best = min(best, sum(cost for _, cost in chosen))
    assert allocate(effects, choices, limit).cost == pytest.approx(best, rel=1e-12)


@pytest.mark.parametrize(
    ("size", "name", "lower", "upper"),
    [
        (25, "K7", -15, 6), (25, "M7", -21, 0), (25, "N7", -28, -7), (25, "P7", -35, -14), (25, "K6", -11, 2),
        (25, "N6", -24, -11), (25, "P6", -31, -18), (25, "K8", -23, 10), (25, "M8", -29, 4), (25, "N8", -36, -3),
        (25, "N9", -52, 0), (25, "P9", -74, -22), (3, "K7", -10, 0), (3, "M7", -12, -2), (3, "N7", -14, -4),
        (3, "P7", -16, -6), (3, "N9", -29, -4), (3, "P9", -31, -6), (300, "M6", -41, -9), (300, "M7", -52, 0),
        (50, "K7", -18, 7), (50, "N7", -33, -8), (50, "P7", -42, -17), (80, "K7", -21, 9), (100, "P7", -59, -24),
    ],
)  # fmt: skip
def test_holes_of_interference_fits_as_the_standard_prints_them(size: int, name: str, lower: int, upper: int) -> None:
    found = limits_of_size(1e-3 * size, name)
    assert (found.lower, found.upper) == (pytest.approx(1e-6 * lower), pytest.approx(1e-6 * upper))


def test_grades_that_holes_do_not_have() -> None:
    for name in ("K2", "P1", "K9"):
        with pytest.raises(FrameError, match=f"tolerance class '{name}': holes K to P have grades from 3 on"):
            limits_of_size(0.025, name)
    assert fit(0.025, "P7/h6").greatest_clearance == pytest.approx(-1e-6)
