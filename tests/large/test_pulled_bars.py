"""Bars that are pulled or pushed along themselves at large displacement, in any direction in space.

Tension resists that they swing; compression swings them round until it is tension. The turn of a bar between balls
about its own axis stays free.
"""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_allclose
from reference.pulled_bars import FORCE, GROWN, KINDS, LENGTH, ROTATIONS, pulled
from scipy.spatial.transform import Rotation


@pytest.mark.parametrize("turn", ROTATIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_bar_that_is_pulled_along_itself_has_one_status_in_any_direction(kind: str, turn: Rotation) -> None:
    solution = pulled(kind, turn).solve(large=True)
    assert solution.status == ("stable" if kind in ("hinge", "release") else "statically consistent mechanism")
    assert solution.stable
    along = turn.apply([1.0, 0.0, 0.0])
    assert_allclose(solution.displacement("B")[:3], GROWN * along, rtol=0.0, atol=1e-9 * GROWN)


@pytest.mark.parametrize("turn", ROTATIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_a_bar_that_is_pushed_along_itself_swings_round_in_any_direction(kind: str, turn: Rotation) -> None:
    """Straight and compressed it is in equilibrium, which is a saddle; beyond, it is pulled on the other side."""
    solution = pulled(kind, turn, -FORCE).solve(large=True)
    bar, hinge = turn.as_matrix()[:, [0, 2]].T
    if kind == "hinge" and hinge[2] != 1.0 and bar[1] == hinge[1] == 0.0:
        # a frame in a coordinate plane is kept to it, and told to be unstable where it would leave it
        assert solution.status == "unstable"
        return
    assert solution.status == "stable beyond a saddle"
    along = turn.apply([1.0, 0.0, 0.0])
    assert_allclose(solution.displacement("B")[:3], -(2.0 * LENGTH + GROWN) * along, rtol=0.0, atol=1e-12 * LENGTH)


@pytest.mark.parametrize("turn", ROTATIONS)
@pytest.mark.parametrize("force", [1e-13, 1e-12, -1e-12])
def test_a_force_that_hardly_strains_is_told_from_none_alike_in_any_direction(force: float, turn: Rotation) -> None:
    """Of its spring's stiffness times the length, resistance across it is 1e-13: below what is told from rounding."""
    frame = pulled("spring", turn, force * FORCE / GROWN * LENGTH)
    frame.fix("B", "rx", "ry", "rz")
    solution = frame.solve(large=True)
    found = (
        "statically consistent mechanism" if force == 1e-13 else "stable" if force > 0.0 else "stable beyond a saddle"
    )
    assert solution.status == found
    moved = solution.displacement("B")[:3]
    along = turn.apply([1.0 if force > 0.0 else -1.0, 0.0, 0.0])
    assert_allclose(turn.apply([LENGTH, 0.0, 0.0]) + moved, LENGTH * along, rtol=0.0, atol=1e-9 * LENGTH)
    assert np.isfinite(solution.error_bound("B")).all() == (force != 1e-13)


@pytest.mark.parametrize("turn", ROTATIONS)
# hinges at both ends that are bent by half a turn are singular: a bar swings round on them, and has no bound there
@pytest.mark.parametrize(("kind", "force"), [(k, f) for k in KINDS for f in (FORCE, -FORCE) if k != "bar" or f > 0.0])
def test_bounds_are_finite_but_for_the_turn_about_the_bar(kind: str, turn: Rotation, force: float) -> None:
    """What is free to spin has a part of each rotation about an axis that is not at right angles to the bar.

    The end of a spring, or of a bar on hinges, turns freely about what is at right angles to it as well.
    """
    bound = pulled(kind, turn, force).solve(large=True).error_bound("B")
    assert (bound[:3] < 1e-7 * LENGTH).all()
    spins = np.abs(turn.apply([1.0, 0.0, 0.0])) > 1e-5
    free = spins if kind in ("support", "ball") or (kind == "release" and force < 0.0) else np.zeros(3, dtype=bool)
    if kind in ("bar", "spring"):
        free = np.abs(turn.apply([1.0, 0.0, 0.0])) < (2.0 if kind == "spring" else 1.0 - 1e-9)
    assert (np.isinf(bound[3:]) == free).all()
