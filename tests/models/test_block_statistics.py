"""Statistics of blocks of samples: the same bits wherever the samples lie, and those of wider numbers."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import propagate
from linkframe.models.moments import SUMS, Moments
from linkframe.models.sampling import BLOCK
from scipy import stats

N = 5 * BLOCK + 300
INPUTS = {"a": stats.lognorm(0.8), "b": stats.norm()}
LAYOUTS = {
    "samples outermost": np.ascontiguousarray,
    "samples innermost": np.asfortranarray,
    "samples between": lambda x: np.moveaxis(np.ascontiguousarray(np.moveaxis(x, 0, 1)), 1, 0),
    "part of more": lambda x: np.concatenate([x, x], axis=-1)[..., : x.shape[-1]],
    "backwards": lambda x: x[:, ::-1].copy()[:, ::-1],
}


def entries(a, b):
    """Several numbers a sample, (m, 3, 2): small ones beside large ones, some missing, and one always."""
    lost = np.where(b > 2.0, np.nan, a)
    found = np.stack([a, b + 1e8, lost, a * b, np.full_like(a, np.nan), 1e-9 * a], axis=-1)
    return found.reshape(-1, 3, 2)


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.SampleWarning")
@pytest.mark.parametrize("policy", ["omit", "propagate"])
def test_bits_do_not_depend_on_where_samples_lie(policy):
    found = [
        propagate(
            lambda a, b, laid=laid: laid(entries(a, b)),
            INPUTS,
            n=N,
            rng=1,
            nan_policy=policy,
            keep_samples=False,
            chunk=chunk,
            progress=False,
        )
        for laid in LAYOUTS.values()
        for chunk in (2 * BLOCK, N)
    ]
    first = found[0]
    for each in found[1:]:
        for key in ("n", *SUMS):
            np.testing.assert_array_equal(getattr(each.moments, key), getattr(first.moments, key))
        np.testing.assert_array_equal(each.envelope[0], first.envelope[0])
        np.testing.assert_array_equal(each.envelope[1], first.envelope[1])


@pytest.mark.parametrize("sets", [1, 2, 7, 40])
def test_pooled_sets_have_the_moments_of_all_samples(sets):
    """Against sums in wider numbers, of sets of different size, some of them empty or far from the others."""
    rng = np.random.default_rng(sets)
    far = np.array([0.0, 1e6])
    parts = [rng.lognormal(1.0, 0.5, size=(int(size), 2)) + far for size in rng.integers(0, 90, sets)]
    parts.append(rng.normal(50.0, 3.0, size=(200, 2)))
    none = Moments(np.zeros(2, np.int64), np.full(2, np.nan), *np.zeros((3, 2)))
    found = Moments.pooled(Moments.stacked([none, *(Moments.of(part) if len(part) else none for part in parts)]))
    wide = np.concatenate(parts).astype(np.longdouble)
    off = wide - wide.mean(axis=0)
    assert found.n == len(wide)
    np.testing.assert_allclose(found.mean, wide.mean(axis=0).astype(float), rtol=1e-14)
    for power, key in enumerate(SUMS[1:], 2):
        scale = np.sum(np.abs(off) ** power, axis=0).astype(float)
        np.testing.assert_array_less(np.abs(getattr(found, key) - np.sum(off**power, axis=0)), 1e-12 * scale)
