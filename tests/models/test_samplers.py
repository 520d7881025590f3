"""Samplers against the exact moments of a journal off the centre of its bearing."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import propagate
from linkframe.models.sampling import BLOCK, points_of
from numpy.testing import assert_array_equal
from scipy import stats
from scipy.stats import qmc

SIZE, SPREAD, ANGLE, TURN = 1e-3, 5e-5, 0.7, 0.8
GAP = {"eps": stats.norm(SIZE, SPREAD), "gamma": stats.norm(ANGLE, TURN)}
SAMPLERS = ("random", "lhs", "sobol", "halton")


def contact(eps, gamma):
    """x = eps cos(gamma), y = eps sin(gamma) and x², y², x y."""
    x, y = eps * np.cos(gamma), eps * np.sin(gamma)
    return np.stack([x, y, x * x, y * y, x * y], axis=-1)


def exact():
    """Their means, from E exp(i k gamma) = exp(i k g − k² s²/2) and E eps² = mu² + sigma².

    With cos² = (1 + cos 2 gamma)/2, sin² = (1 − cos 2 gamma)/2 and sin cos = sin(2 gamma)/2.
    """
    once, twice = (np.exp(1j * k * ANGLE - (k * TURN) ** 2 / 2) for k in (1, 2))
    half = 0.5 * (SIZE**2 + SPREAD**2)
    products = half * np.array([1 + twice.real, 1 - twice.real, twice.imag])
    return np.concatenate([SIZE * np.array([once.real, once.imag]), products])


@pytest.mark.parametrize("sampler", SAMPLERS)
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_moments_of_the_clearance_are_exact_within_four_standard_errors(sampler, seed):
    found = propagate(contact, GAP, n=8192, rng=seed, sampler=sampler, progress=False)
    assert np.all(np.abs(found.mean - exact()) < 4 * found.standard_error)


@pytest.mark.parametrize(
    ("sampler", "slowest", "fastest"), [("random", -0.35, -0.65), ("sobol", -0.9, -1.5), ("halton", -0.85, -1.5)]
)
def test_rates_of_convergence(sampler, slowest, fastest):
    """The root of the mean square error falls as 1/√n with random samples, about as 1/n with sequences."""
    counts, errors = [64, 512, 4096], []
    for n in counts:
        runs = [propagate(contact, GAP, n=n, rng=seed, sampler=sampler, progress=False).mean for seed in range(12)]
        errors.append(np.sqrt(np.mean(((np.array(runs) - exact()) / exact()) ** 2)))
    rate = np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert fastest < rate < slowest


def test_latin_hypercube_beats_random_samples_where_inputs_act_alone():
    """A clearance that hardly varies leaves one input: every stratum of it is hit once."""
    means = {
        sampler: [propagate(contact, GAP, n=512, rng=seed, sampler=sampler, progress=False).mean for seed in range(8)]
        for sampler in ("random", "lhs")
    }
    random, latin = (np.mean((np.array(each) - exact())[:, :2] ** 2) for each in means.values())
    assert latin < 0.05 * random


@pytest.mark.parametrize("sampler", SAMPLERS)
def test_points_depend_on_their_numbers_alone(sampler):
    """Taken from the middle, backwards or in order: the same bits."""
    names, n, root = ["a", "b", "c"], 6 * BLOCK, np.random.SeedSequence(7)
    ordered = points_of(names, n, root, sampler)
    wanted = [ordered.take(start, BLOCK).copy() for start in range(0, n, BLOCK)]
    jumping = points_of(names, n, root, sampler)
    for block in (4, 1, 2, 0, 5, 3):
        assert_array_equal(jumping.take(block * BLOCK, BLOCK), wanted[block])


@pytest.mark.parametrize("kind", [qmc.Sobol, qmc.Halton, qmc.LatinHypercube])
def test_an_engine_of_scipy(kind):
    """Its points are taken from where it stands, and it is left as it is."""
    engine = kind(2, rng=5)
    points = kind(2, rng=5).random(2 * BLOCK)
    for _ in range(2):
        found = propagate(contact, GAP, n=2 * BLOCK, sampler=engine, progress=False)
        assert_array_equal(found.input_samples["gamma"], GAP["gamma"].ppf(points[:, 1]))
    assert np.all(np.abs(found.mean - exact()) < found.standard_error)


def test_an_engine_has_a_dimension_for_each_input():
    with pytest.raises(FrameError, match="an engine of dimension 3: there are 2 inputs"):
        propagate(contact, GAP, sampler=qmc.Sobol(3))
    with pytest.raises(FrameError, match=r"or give an engine of scipy\.stats\.qmc"):
        propagate(contact, GAP, sampler=np.random.default_rng(0))


def test_low_discrepancy_runs_begin_alike():
    """The first points of a longer run are those of the shorter one, so that it can be extended."""
    for sampler in ("random", "sobol", "halton"):
        short, long = (propagate(contact, GAP, n=n, rng=3, sampler=sampler, progress=False) for n in (2048, 6144))
        assert_array_equal(long.samples[:2048], short.samples)
