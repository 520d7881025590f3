"""The short form of the stress test: no number is further off than its bound, and no NaN goes unannounced."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework import MechanismWarning
from reference.as_frame import as_frame
from reference.compare import apart, stacked
from reference.four_bar import coordinates, four_bar
from reference.stiffness_method import mp, solve

from stress import stacked as double_double
from stress.axes import AXES, UNITS, Axis, in_units
from stress.chain import chain, tip
from stress.measure import KINDS, Measured, measured, of_tip
from stress.random_models import KINDS as TOPOLOGIES
from stress.random_models import one_of, random_models, tally
from stress.report import table, write

NOMINAL = four_bar(coordinates(30.0), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))


@pytest.mark.parametrize("axis", AXES, ids=lambda axis: axis.name)
def test_bounds_hold_along_each_axis(axis: Axis) -> None:
    """Against 50 digits: displacements, reactions, joint displacements and forces, plain and refined."""
    for x in axis.short:
        rows = measured(axis.name, x, axis.build(x))
        assert sum(row.lies for row in rows) == 0
        assert {row.kind for row in rows} <= set(KINDS)


def test_bounds_are_tight_where_the_pose_is_regular() -> None:
    """At 30 degrees a bound is within two decades of the error, or of rounding where that is less."""
    for row in measured("angle", 30.0, NOMINAL):
        if row.kind == "displacement":
            assert row.bound < 100 * max(row.error, 2.0**-53)


def test_refinement_buys_digits_near_a_singular_pose() -> None:
    """At 1e-4 degrees the plain result has eight digits, the refined one all, and its bound says so to ten."""
    (row,) = (
        row
        for row in measured("angle", 1e-4, four_bar(coordinates(1e-4), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0)))
        if row.kind == "displacement"
    )
    assert row.refined_error < 1e-15
    assert row.refined_bound < 1e-10
    assert row.error <= row.bound < 10 * row.error + 1e-14


@pytest.mark.parametrize("links", [2, 7, 40])
def test_bounds_hold_at_the_tip_of_a_chain(links: int) -> None:
    structure = chain(links)
    assert of_tip("chain", links, structure, tip(structure)).lies == 0


def test_the_bound_of_a_long_chain_leaves_digits() -> None:
    """Scaled condition 1e12: the bound is that of the refined tip, whose residual is in extended precision."""
    structure = chain(500)
    found = of_tip("chain", 500, structure, tip(structure))
    assert found.lies == 0
    assert found.bound < 1e-9


def test_the_tip_of_a_chain_is_that_of_the_reference() -> None:
    """Link by link as by the matrix."""
    structure = chain(4)
    np.testing.assert_allclose(
        tip(structure).astype(float), solve(structure).displacement["e3"].astype(float), rtol=1e-15, atol=0.0
    )


@pytest.mark.parametrize("kind", TOPOLOGIES)
def test_random_models_are_the_same_in_every_process(kind: str) -> None:
    """Their nodes have an order, not that of a set, which each process chooses by itself."""
    models = random_models(np.random.default_rng(0), 1, kind)
    assert list(models.nodes) == sorted(models.nodes)
    assert list(models.loads) == sorted(models.loads)


@pytest.mark.parametrize("kind", TOPOLOGIES)
@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
def test_random_models_never_lie(kind: str) -> None:
    """Sizes, slenderness, moduli, joints and loads over many decades each: 250 models, beside double-double numbers."""
    found = tally(np.random.default_rng(1), 250, kind)
    assert found.lies == found.silent == 0
    assert found.numbers > 5000
    assert found.least > 1.0
    assert found.open + found.mechanisms < found.models / 4


@pytest.mark.parametrize("kind", TOPOLOGIES)
def test_double_double_numbers_are_those_of_fifty_digits(kind: str) -> None:
    """To 1e-17, at random models one by one; where a bound looks broken, 50 digits have the word."""
    models = random_models(np.random.default_rng(5), 3, kind)
    structure = models.structure()
    found = double_double.solve(structure)
    for index in range(3):
        exact = solve(one_of(structure, index))
        for node in models.loads:
            for value, truth in zip(found[node], exact.displacement[node], strict=True):
                assert abs((mp.mpf(value.high[index]) + mp.mpf(value.low[index]) - truth) / truth) < 1e-17


def test_units_leave_the_digits_alone() -> None:
    """Powers of two change no bit; other units agree to the rounding of the numbers that go in."""
    plain = as_frame(NOMINAL).solve()
    scaled = as_frame(in_units(NOMINAL, 2.0**10, 2.0**-7)).solve()
    lengths = np.array([2.0**10] * 3 + [1.0] * 3)
    for node in NOMINAL.nodes:
        np.testing.assert_array_equal(scaled.displacement(node), lengths * plain.displacement(node))
    nodes = list(NOMINAL.nodes)
    for a, b in UNITS.values():
        other = as_frame(in_units(NOMINAL, a, b)).solve()
        factors = np.array([a] * 3 + [1.0] * 3)
        found = stacked({node: other.displacement(node) / factors for node in nodes})
        assert apart(found, stacked({node: plain.displacement(node) for node in nodes})) < 1e-13


def test_a_singular_pose_is_announced() -> None:
    """Where no digit is certain the status says so, and the bound is infinite."""
    solution = as_frame(four_bar(coordinates(0.0), (0.0, 100.0, 0.0, 0.0, 0.0, 0.0))).solve()
    assert solution.status == "mechanism"
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.displacement("P")).all()
    assert np.isinf(solution.error_bound("P")).all()


def test_the_table_and_the_files_show_what_was_measured(tmp_path: Path) -> None:
    rows = [
        Measured("load", 1.0, "displacement", 1e-16, 2e-15, 1e-17, 1e-15, 0, "regular"),
        Measured("load", 1e300, "displacement", math.nan, math.inf, math.nan, math.inf, 0, "mechanism"),
        Measured("units", 4.0, "displacement", 1e-16, 2e-15, 1e-17, 1e-15, 1, "regular"),
    ]
    write(rows, tmp_path)
    with (tmp_path / "stress.csv").open(encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert [float(row["bound"]) for row in read] == [2e-15, math.inf, 2e-15]
    assert (tmp_path / "stress.png").stat().st_size > 10_000
    assert "| load | 1e+300 | nan | inf |" in table(rows)
    assert "| units | mm, kN | 1.0e-16 | 2.0e-15 | 1.0e-17 | 1.0e-15 | 1 | regular |" in table(rows)


@pytest.mark.parametrize(("axis", "x"), [("short stiff member", 1e-9), ("coincident nodes", 1e-12)])
def test_short_members_are_no_mechanisms(axis: str, x: float) -> None:
    """Where 10^18 separates stiffnesses, results are right to the last digits, and their bounds know it."""
    build = next(each.build for each in AXES if each.name == axis)
    for row in measured(axis, x, build(x)):
        assert row.status == "regular"
        if row.kind == "displacement":
            assert row.error < 2e-15
            assert row.bound < 1e-13
