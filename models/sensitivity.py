"""Which input the spread of a result comes from: Sobol indices."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.errors import FrameError, SampleWarning
from ..framework.listing import number, text_table
from .sampling import LEAST, Distribution, Seed, check_inputs, root_seed, samples_first, stream, whole

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class SobolIndices:
    """Shares of the variance of a result.

    Attributes
    ----------
    inputs
        Names of the k inputs.
    first
        Share due to each input alone, (..., k).
    total
        Share that vanishes with each input, its interactions included, (..., k).

    Examples
    --------
    A product of two inputs of mean zero depends on both together and on neither alone.

    >>> from scipy import stats
    >>> product = sobol_indices(lambda a, b: a * b, {"a": stats.norm(), "b": stats.norm()}, n=4096, rng=0)
    >>> bool((abs(product.first) < 0.1).all() and (abs(product.total - 1.0) < 0.1).all())
    True
    """

    inputs: tuple[str, ...]
    first: Array
    total: Array

    def __repr__(self) -> str:
        """Greatest shares over all results as a short table."""
        axes = tuple(range(self.first.ndim - 1))
        most = [np.max(part, axis=axes, initial=-np.inf, where=np.isfinite(part)) for part in (self.first, self.total)]
        rows = [[name, *(number(float(part[k])) for part in most)] for k, name in enumerate(self.inputs)]
        of = f", of shape {self.first.shape[:-1]}: the greatest" if axes else ""
        return text_table(f"SobolIndices of {len(self.inputs)} inputs{of}", ["input", "first", "total"], rows)


def sobol_indices(
    fn: Callable[..., ArrayLike],
    distributions: Mapping[str, Distribution],
    *,
    n: int = 1024,
    rng: Seed = None,
    axis: int = 0,
    chunk: int = 16384,
) -> SobolIndices:
    """Sobol indices of a function of independent uncertain inputs, by `scipy.stats.sobol_indices`.

    Parameters
    ----------
    fn
        Function of arrays (m,) that returns their results, as for `propagate`.
    distributions
        Frozen `scipy.stats` distributions by the name of the argument.
    n
        Number of samples, a power of two; `fn` sees n (k + 2) of them for k inputs.
    rng
        Seed, as for `propagate`.
    axis
        Axis of the samples in what `fn` returns.
    chunk
        Number of samples in one call of `fn`.

    Returns
    -------
    SobolIndices
        First-order and total indices (Saltelli et al., Computer Physics Communications 181, 2010,
        doi:10.1016/j.cpc.2009.09.018); NaN where a sample is.

    Raises
    ------
    FrameError
        If `n` is not a power of two, or `fn` returns no axis of samples at `axis`.

    Examples
    --------
    >>> from scipy import stats
    >>> shares = sobol_indices(lambda a, b: a + 2.0 * b, {"a": stats.norm(), "b": stats.norm()}, rng=0)
    >>> bool(abs(shares.first - [0.2, 0.8]).max() < 0.02)
    True
    """
    if whole(n, "number of samples n", 2) & (n - 1):
        raise FrameError(f"number of samples n is {n!r}: Sobol indices need a power of two")
    if not distributions:
        raise FrameError("sobol_indices was given no input: name an argument of the function and its distribution")
    check_inputs(distributions)
    whole(chunk, "chunk", 1)
    from scipy import stats

    names = tuple(distributions)
    shape: list[tuple[int, ...]] = []
    lost: list[int] = []
    holes: list[NDArray[np.bool_]] = []

    def rows(points: Array) -> Array:
        """Results (s, m) at points (k, m)."""
        parts = []
        for start in range(0, points.shape[1], chunk):
            part = points[:, start : start + chunk]
            parts.append(samples_first(fn(**dict(zip(names, part, strict=False))), part.shape[1], axis))
        results = np.concatenate(parts)
        missing = np.isnan(results).reshape(len(results), -1)
        lost.append(int(np.count_nonzero(missing.any(axis=1))))
        holes.append(np.asarray(missing.any(axis=0)))
        shape.append(results.shape[1:])
        return results.reshape(len(results), -1).T

    laws = [_Inside(law) for law in distributions.values()]
    # SciPy takes two inputs or more: an idle one beside a single one.
    laws += [_Inside(stats.uniform())] * (len(laws) == 1)
    generator = stream(root_seed(rng), "sobol indices")
    found = stats.sobol_indices(func=rows, n=n, dists=laws, rng=generator)
    if any(lost):
        warnings.warn(
            f"{sum(lost)} of {n * (len(laws) + 2)} samples are NaN somewhere; the Sobol indices are NaN there, as each "
            "needs all samples",
            SampleWarning,
            stacklevel=2,
        )
    # SciPy returns 0 where a sample is NaN.
    there = np.where(np.any(holes, axis=0), np.nan, 1.0)[:, None]
    first, total = (
        np.reshape(there * order.reshape(len(there), -1), (*shape[0], len(laws)))[..., : len(names)]
        for order in (found.first_order, found.total_order)
    )
    return SobolIndices(names, first, total)


class _Inside:
    """A distribution whose quantiles stay finite at probability zero."""

    def __init__(self, law: Distribution) -> None:
        self.law = law

    def ppf(self, q: Array) -> Any:
        return self.law.ppf(np.maximum(q, LEAST))
