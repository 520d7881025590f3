"""Events on paths: where a sign changes and zeros side by side."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.continuation import Zeros, sign_change


def test_a_straight_line_takes_one_value():
    asked = []

    def value(place):
        asked.append(place)
        return 2.0 * (place - 0.25)

    assert sign_change(value, (0.0, -0.5), (1.0, 1.5), rounds=4) == 0.25
    assert asked == [0.25]


@settings(max_examples=50, deadline=None)
@given(root=st.floats(0.05, 0.95), bend=st.floats(-0.9, 0.9))
def test_it_closes_in_from_both_sides(root, bend):
    """Of ``(x - r)(1 + b x)``, which bends, plain false position would keep one end for ever."""

    def value(x):
        return (x - root) * (1.0 + bend * x)

    found = sign_change(value, (0.0, value(0.0)), (1.0, value(1.0)), rounds=60)
    assert found == pytest.approx(root, abs=1e-12)


def test_where_nothing_is_known_the_search_ends():
    assert sign_change(lambda _: np.nan, (0.0, -1.0), (1.0, 3.0), rounds=9) == 0.25


def test_parabolas_turn_at_their_summits_however_long_the_steps_to_both_sides():
    """Side by side; the zero of the slope, and with it the height there."""
    summit = np.array([2.3, 2.01, 3.99, 3.0])
    left, right = np.array([2.0, 2.0, 2.0, -40.0]), np.array([4.0, 4.0, 4.0, 3.5])

    def points(s):
        return np.stack([s, 3.0 - (s - summit) ** 2, -2.0 * (s - summit)])

    zeros = Zeros(points(left), points(right))
    zeros.narrow(points(zeros.place()), np.array([True, True, True, False]))
    nearest = np.minimum(np.abs(zeros.left[2]), np.abs(zeros.right[2]))
    np.testing.assert_allclose(nearest[:3], 0.0, atol=1e-14)
    assert (zeros.left[0, 3], zeros.right[0, 3]) == (left[3], right[3])
    nothing = np.full((3, 4), np.nan)
    before = zeros.place()[3]
    zeros.narrow(nothing, np.array([False, False, False, True]))
    assert left[3] < zeros.place()[3] < before
