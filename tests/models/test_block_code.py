"""Statistics of blocks by machine code, and quantiles without SciPy's examination: the bits of NumPy and of SciPy."""

from __future__ import annotations

import threading
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from linkframe.models import propagate
from linkframe.models.moments import SUMS, Moments
from linkframe.models.propagation import block_code, blocks
from linkframe.models.propagation.blocks import BlockStatistics
from linkframe.models.quantiles import at_scores, quantiles
from linkframe.models.sampling import BLOCK
from scipy import stats
from scipy.special import ndtr

NUMBERS = ("least", "greatest", "n", *SUMS)
DISTRIBUTIONS = [
    stats.norm(3.0, 0.2),
    stats.norm(loc=1e-3, scale=7.0),
    stats.lognorm(0.05, scale=1e8),
    stats.lognorm(s=0.3, loc=2.0),
    stats.uniform(2.0, 3.0),
    stats.uniform(),
    stats.expon(scale=2.0),
    stats.truncnorm(-1.0, 2.0),
    stats.norm(2.0, -1.0),
    stats.lognorm(-0.1),
    stats.norm([1.0], [2.0]),
]


def by_numpy(rows):
    moments = Moments.of_rows(rows)
    n = np.full(rows.shape[:-1], float(moments.n))
    return np.array([rows.min(-1), rows.max(-1), n, *(getattr(moments, key) for key in SUMS)])


@pytest.fixture
def compiled():
    pytest.importorskip("llvmlite")


@pytest.mark.parametrize("kind", ["small", "large mean", "wide", "constant", "infinite", "overflowing"])
def test_machine_code_has_the_bits_of_numpy(compiled, kind):
    rng = np.random.default_rng(3)
    rows = rng.normal(size=(5, 7, BLOCK))
    rows = {
        "small": 1e-12 * rows,
        "large mean": rows + 1e9,
        "wide": np.exp(8.0 * rows),
        "constant": np.full_like(rows, 0.1),
        "infinite": np.where(rows > 3.2, np.inf, rows),
        "overflowing": 1e200 * rows,
    }[kind]
    found = block_code.numbers_of_blocks(rows)
    for name, a, b in zip(NUMBERS, found, by_numpy(rows), strict=True):
        np.testing.assert_array_equal(a, b, err_msg=name)


def test_machine_code_takes_samples_wherever_their_rows_lie(compiled):
    rows = np.random.default_rng(4).normal(size=(6, 9 * BLOCK))[::-2, BLOCK : 4 * BLOCK].reshape(3, 3, BLOCK)
    np.testing.assert_array_equal(block_code.numbers_of_blocks(rows), by_numpy(np.ascontiguousarray(rows)))


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.SampleWarning")
@pytest.mark.parametrize("policy", ["omit", "propagate"])
def test_propagation_has_the_same_bits_with_and_without_machine_code(compiled, policy, monkeypatch):
    def several(a, b):
        return np.stack([a, np.where(b > 2.0, np.nan, b), a * b, np.where(a > 9.0, np.inf, a)], axis=-1)

    found = []
    for served in (True, False):
        monkeypatch.setattr(block_code, "serves", lambda numbers, served=served: served)
        given = {"a": stats.lognorm(0.8), "b": stats.norm()}
        run = propagate(several, given, n=5 * BLOCK + 300, rng=1, nan_policy=policy, keep_samples=False, progress=False)
        found.append(run)
    one, other = found
    for key in ("n", *SUMS):
        np.testing.assert_array_equal(getattr(one.moments, key), getattr(other.moments, key))
    np.testing.assert_array_equal(one.envelope, other.envelope)


@pytest.mark.parametrize("distribution", DISTRIBUTIONS, ids=lambda d: f"{d.dist.name} {d.args} {d.kwds}")
def test_quantiles_have_the_bits_of_scipy(distribution):
    at = np.concatenate([[2.0**-60, 0.5, 1.0 - 2.0**-53], np.random.default_rng(5).random(1000)])
    np.testing.assert_array_equal(quantiles(distribution, at), distribution.ppf(at))


@pytest.mark.parametrize("distribution", DISTRIBUTIONS, ids=lambda d: f"{d.dist.name} {d.args} {d.kwds}")
def test_values_at_normal_scores_are_scipys_quantiles_in_both_tails(distribution):
    scores = np.linspace(-9.0, 9.0, 37)
    below, above = distribution.ppf(ndtr(-np.abs(scores))), distribution.isf(ndtr(-np.abs(scores)))
    np.testing.assert_allclose(at_scores(distribution, scores), np.where(scores > 0.0, above, below), rtol=1e-12)
    far = at_scores(distribution, np.array([-50.0, -37.5, 37.5, 50.0]))
    np.testing.assert_array_equal(far[[0, 3]], far[[1, 2]])


def test_threads_do_not_write_into_each_others_memory():
    """Statistics of a chunk are found in memory that is kept for the next one."""
    rng = np.random.default_rng(6)
    chunks = [rng.normal(k, 1.0, (3, 80 * BLOCK)).T[:, ::-1] + 0.0 for k in range(4)]
    meet = threading.Barrier(len(chunks))

    def found(chunk):
        meet.wait()
        return BlockStatistics.of(chunk, "omit").moments, [id(each) for each in blocks._own_memory()]

    with ThreadPoolExecutor(len(chunks)) as pool:
        together = list(pool.map(found, chunks))
    for chunk, (moments, _) in zip(chunks, together, strict=True):
        alone = BlockStatistics.of(chunk, "omit").moments
        for key in SUMS:
            np.testing.assert_array_equal(getattr(moments, key), getattr(alone, key))
    assert len({number for _, numbers in together for number in numbers}) == 3 * len(chunks)
