"""Bounds of all results hold at random models of all kinds, by all methods; their reference is that of the others."""

from __future__ import annotations

import numpy as np
import pytest
from reference import mixed_method, stiffness_method
from reference.random_structures import random_frame, random_linkage, random_screws

from stress.mixed_kinds import METHODS, tally
from stress.random_models import Tally

# Of those that are neither mechanisms nor refused.
SEEDS = {"broadcast": (1, 4, 5), "banded": (0, 1, 2), "sparse": (0, 2, 6), "iterative": (3, 4, 5)}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
def test_no_number_is_further_off_than_its_bound(method: str) -> None:
    """Displacements, reactions, joint displacements and forces, and end forces, plain and refined."""
    total = Tally()
    for seed in SEEDS[method]:
        total += tally(np.random.default_rng([METHODS.index(method), seed]), 2, method=method)
    assert total.lies == total.silent == 0
    assert total.models == 6
    assert total.numbers > 1000
    assert total.open == 0


@pytest.mark.parametrize("make", [random_frame, random_linkage, random_screws])
def test_the_mixed_method_agrees_with_the_displacement_method(make: object) -> None:
    """To what a penalty of 1e30 for ideal joints leaves of the latter's fifty digits."""
    structure = make(4)  # type: ignore[operator]
    one, other = mixed_method.solve(structure), stiffness_method.solve(structure)
    pairs = {
        "displacement": other.displacement,
        "reaction": other.reaction,
        "joint_displacement": other.extension,
        "joint_force": other.force,
    }
    for kind, truth in pairs.items():
        greatest = max(abs(part) for six in truth.values() for part in six)
        for name, six in truth.items():
            assert max(abs(getattr(one, kind)[name] - six)) < 1e-18 * greatest
