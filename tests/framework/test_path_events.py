"""Events on paths: where a sign changes and where a value turns back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.framework.continuation import sign_change, turning_values


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


def test_a_parabola_turns_at_its_summit():
    s = np.arange(6.0)
    np.testing.assert_allclose(turning_values(3.0 - (s - 2.3) ** 2), [3.0], rtol=1e-15)
    np.testing.assert_allclose(
        turning_values(np.concatenate([-((s - 2.3) ** 2), (s - 3.6) ** 2 - 9.0]))[:1], [0.0], atol=1e-15
    )
    assert turning_values(s).size == 0
