"""Programs as functions of a few entries: the bits and shapes of arrays, whatever of the inputs varies."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework.program.source import of_one

# A function of two groups of numbers for floats, and the same for arrays, which is told when it is called.
Groups = tuple[list[Any], list[Any]]


def straight(a: list[Any], b: list[Any]) -> tuple[Any, ...]:
    return a[0] * b[0] + a[1], a[0] / a[1] - b[0], a[1] * 3.0


def called(inputs: Groups) -> tuple[Any, list[str]]:
    by: list[str] = []

    def floats(a: list[Any], b: list[Any]) -> tuple[Any, ...]:
        by.append("floats")
        assert all(type(x) in (float, np.float64, int) for x in (*a, *b))
        return straight(a, b)

    def arrays(a: list[Any], b: list[Any]) -> tuple[Any, ...]:
        by.append("arrays")
        with np.errstate(all="ignore"):
            return straight(a, b)

    return of_one(floats, arrays, few=10)(*inputs), by


VALUES = np.random.default_rng(0).uniform(1.0, 2.0, 12)


@pytest.mark.parametrize(
    ("inputs", "entries"),
    [
        (([1.5, 2.5], [3.5]), 1),
        (([np.array([1.5]), 2.5], [3.5]), 1),
        (([VALUES[:2], 2.5], [3.5]), 2),
        (([VALUES[:6].reshape(2, 3), 2], [np.array([[3.5]])]), 6),
        (([1.5, VALUES[:3]], [VALUES[3:6]]), 3),
        (([1.5, 2.5], [VALUES[:10]]), 10),
    ],
)
def test_few_entries_are_computed_in_floats_to_the_same_bits(inputs: Groups, entries: int) -> None:
    found, by = called(inputs)
    assert by == ["floats"] * entries
    shape = np.broadcast_shapes(*(np.shape(x) for group in inputs for x in group))
    for one, expected in zip(found, straight(*inputs), strict=True):
        assert np.shape(one) == shape
        np.testing.assert_array_equal(one, np.broadcast_to(expected, shape))


@pytest.mark.parametrize(
    "inputs",
    [
        ([VALUES, 2.5], [3.5]),
        ([VALUES[:4].reshape(4, 1), 2.5], [VALUES[:3]]),
        ([VALUES[:0], 2.5], [3.5]),
        ([VALUES[:3], 2.5], [np.array([[3.5]])]),
        ([VALUES[:2].astype(np.longdouble), 2.5], [3.5]),
        ([VALUES[:2], np.longdouble(2.5)], [3.5]),
    ],
)
def test_others_are_computed_in_arrays(inputs: Groups) -> None:
    found, by = called(inputs)
    assert by[-1] == "arrays"
    for one, expected in zip(found, straight(*inputs), strict=True):
        np.testing.assert_array_equal(one, expected)


def test_a_division_by_zero_is_left_to_arrays() -> None:
    found, by = called(([VALUES[:2], np.array([1.0, 0.0])], [3.5]))
    assert by == ["floats", "floats", "arrays"]
    assert found[1][1] == np.inf
