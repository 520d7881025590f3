"""Importance sampling asks for as many samples at a time as it seems to want, and no more of its limit on them."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import reliability
from scipy import stats
from scipy.special import ndtr

INPUTS = {"a": stats.norm(), "b": stats.norm()}


def planes(x, pose):
    return 3.0 + 0.5 * pose - (x["a"] + x["b"]) / np.sqrt(2.0)


def test_few_calls_to_a_small_error():
    found = reliability(planes, INPUTS, poses=6, accuracy=0.01, rng=0)
    exact = ndtr(-3.0 - 0.5 * np.arange(6.0))
    assert found.batches < 40
    assert found.coefficient_of_variation.max() <= 0.01
    np.testing.assert_allclose(found.probability, exact, rtol=0.04)


@pytest.mark.parametrize("most", [100, 700, 1600])
def test_no_more_samples_than_allowed(most):
    sizes = []

    def limit(x):
        sizes.append(len(x["a"]))
        return 4.0 - (x["a"] + x["b"]) / np.sqrt(2.0)

    reliability(limit, INPUTS, accuracy=0.001, samples=most, rng=0)
    searched = reliability(limit, INPUTS, method="form", starts=9, rng=0).evaluations
    assert sum(sizes) - 2 * searched <= 500 + most
