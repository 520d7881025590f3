"""Polynomial chaos of inputs with long tails: by their normal scores, where that explains more."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import polynomial_chaos
from linkframe.models.quantiles import normal_scores
from scipy import stats

SHAPE = 0.3
INPUTS = {"stiffness": stats.lognorm(SHAPE, scale=2.0), "force": stats.norm(100.0, 10.0), "length": (0.9, 1.1)}


def deflection(stiffness, force, length):
    return np.stack([force * length / stiffness, force / stiffness], axis=-1)


def test_moments_of_a_compliance_in_closed_form():
    """A lognormal stiffness has a lognormal compliance, with moments exp(s²/2) and exp(2 s²) of the median."""
    found = polynomial_chaos(deflection, INPUTS, degree=6, rng=0)
    mean = 100.0 * np.exp(SHAPE**2 / 2.0) / 2.0
    square = (100.0**2 + 10.0**2) * np.exp(2.0 * SHAPE**2) / 4.0 * np.array([1.0 + 0.01 / 3.0, 1.0])
    np.testing.assert_allclose(found.mean, mean, rtol=1e-6)
    np.testing.assert_allclose(found.std, np.sqrt(square - mean**2), rtol=1e-5)
    x = {"stiffness": np.array([1.1, 3.0]), "force": np.array([90.0, 110.0]), "length": np.array([0.95, 1.05])}
    np.testing.assert_allclose(found(**x), deflection(**x), rtol=1e-3)


def test_what_is_a_polynomial_of_the_inputs_stays_one():
    found = polynomial_chaos(lambda stiffness, force, length: stiffness**2 * force + length, INPUTS, degree=3, rng=0)
    moment = 4.0 * np.exp(2.0 * SHAPE**2)
    assert float(found.mean) == pytest.approx(moment * 100.0 + 1.0, rel=1e-12)
    assert float(found.unexplained) < 1e-20


@pytest.mark.parametrize("distribution", [stats.lognorm(0.5), stats.gamma(3.0), stats.norm(1.0, 2.0)])
def test_scores_are_exact_in_both_tails(distribution):
    scores = np.array([-9.0, -1.0, 0.0, 2.0, 9.0])
    values = np.where(scores > 0.0, distribution.isf(stats.norm.sf(scores)), distribution.ppf(stats.norm.cdf(scores)))
    np.testing.assert_allclose(normal_scores("x", distribution, values), scores, atol=1e-9)
