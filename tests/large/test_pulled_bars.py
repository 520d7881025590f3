"""Bars that are pulled along themselves at large displacement, in any direction in space.

Their tension resists that they swing; the turn of a bar between balls about its own axis stays free.
"""

from __future__ import annotations

import pytest
from numpy.testing import assert_allclose
from reference.pulled_bars import GROWN, KINDS, ROTATIONS, pulled
from scipy.spatial.transform import Rotation


@pytest.mark.parametrize("turn", ROTATIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_bar_that_is_pulled_along_itself_has_one_status_in_any_direction(kind: str, turn: Rotation) -> None:
    solution = pulled(kind, turn).solve(large=True)
    assert solution.status == ("stable" if kind in ("hinge", "release") else "statically consistent mechanism")
    assert solution.stable
    along = turn.apply([1.0, 0.0, 0.0])
    assert_allclose(solution.displacement("B")[:3], GROWN * along, rtol=0.0, atol=1e-9 * GROWN)
