"""Linkages of many kinds, planar and spatial: a pose is what it is alone, in any order of poses and of description."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.models import Motion
from numpy.testing import assert_allclose, assert_array_equal
from reference.any_linkage import KINDS, Recipe

seeds = st.integers(0, 2**32 - 1)
COUNT = 5


def poses(recipe: Recipe, rng: np.random.Generator) -> dict[str, np.ndarray]:
    """Values of the drives; at one pose all stand as drawn, at another all but the first."""
    values = {name: far * rng.uniform(-1.0, 1.0, COUNT) for name, far in recipe.reach.items()}
    for index, value in enumerate(values.values()):
        value[0] = 0.0
        value[1] *= index == 0
    return values


def assert_same(recipe: Recipe, one: Motion, other: Motion, chosen: np.ndarray) -> None:
    """Statuses, and positions and joint coordinates where they have all digits; `chosen` of the one are the other."""
    assert_array_equal(other.status, one.status[chosen])
    firm = (np.nan_to_num(one.conditioning, nan=1.0) > 1e-2)[chosen]
    for link, points in recipe.links.items():
        at, there = (motion.position(points[0], link) for motion in (one, other))
        assert_allclose(there[firm], at[chosen][firm], rtol=0.0, atol=1e-12)
    for pair in one.mechanism.tree.cuts:
        at, there = (motion.coordinate(pair.name) for motion in (one, other))
        assert_allclose(there[firm], at[chosen][firm], rtol=0.0, atol=1e-10)


def assert_same_compliance(one: Motion, other: Motion, chosen: np.ndarray) -> None:
    """Displacement of P, within what both are sure of."""
    solutions = []
    for motion in (one, other):
        frame = motion.frame()
        frame.load("P", fx=100.0, fy=-50.0, fz=30.0)
        solutions.append(frame.solve())
    assert_array_equal(solutions[1].status, solutions[0].status[chosen])
    firm = (np.nan_to_num(one.conditioning, nan=1.0) > 1e-2)[chosen]
    (at, sure), (there, as_sure) = ((x.displacement("P")[..., :3], x.error_bound("P")[..., :3]) for x in solutions)
    at, sure, there, as_sure = at[chosen][firm], sure[chosen][firm], there[firm], as_sure[firm]
    assert_array_equal(np.isnan(there), np.isnan(at))
    off = np.abs(np.nan_to_num(there - at))
    # beside the solver's own error, that of the pose
    assert np.all(off <= np.nan_to_num(sure + as_sure) + 1e-9 * np.abs(np.nan_to_num(at)).max(initial=0.0))
    assert_array_equal(np.isfinite(as_sure), np.isfinite(sure))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=1)
@given(seed=seeds)
def test_a_pose_is_what_it_is_alone(kind, seed):
    rng = np.random.default_rng(seed)
    recipe = KINDS[kind](rng)
    linkage, values = recipe.made(), poses(recipe, rng)
    motion = linkage.move(values)
    turned = rng.permutation(COUNT)
    other = linkage.move({name: value[turned] for name, value in values.items()})
    assert_same(recipe, motion, other, turned)
    for k in (0, 1, 3):
        alone = linkage.move({name: value[[k]] for name, value in values.items()})
        assert_same(recipe, motion, alone, np.array([k]))
        if k == 3 and alone.is_assembled.all():
            assert_same_compliance(motion, alone, np.array([k]))


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=1)
@given(seed=seeds)
def test_order_of_description(kind, seed):
    rng = np.random.default_rng(seed)
    recipe = KINDS[kind](rng)
    values = poses(recipe, rng)
    one, other = recipe.made().move(values), recipe.made(rng).move(values)
    assert_same(recipe, one, other, np.arange(COUNT))
    assert_same_compliance(one, other, np.arange(COUNT))
