"""What uncertain inputs make of a result: propagation by sampling, for any function of arrays."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.errors import FrameError
from .moments import Moments, Statistics
from .sampling import BLOCK, Distribution, Seed, root_seed, sample_blocks, samples_first, whole
from .sensitivity import SobolIndices, sobol_indices
from .spread import quantiles

Array = NDArray[np.float64]
Function = Callable[..., ArrayLike]


@dataclass(frozen=True, eq=False)
class Propagation(Statistics):
    """Statistics of a result under uncertain inputs; made by `propagate`.

    Standard errors are those of independent random samples; Sobol and Latin samples do better than they say. Where a
    sample is NaN, so are the statistics.

    Attributes
    ----------
    inputs
        Names of the inputs.
    kept
        Samples of the result, (n, ...), or None where they were not kept.
    """

    inputs: tuple[str, ...]
    _moments: Moments = field(repr=False)
    kept: Array | None
    _indices: Callable[..., SobolIndices] = field(repr=False)

    @property
    def moments(self) -> Moments:
        """Count, mean and sums of powers of the deviations, (...)."""
        return self._moments

    @property
    def n(self) -> int:
        """Number of samples."""
        return self.moments.n

    @property
    def samples(self) -> Array:
        """Samples of the result, sample axis first, (n, ...)."""
        if self.kept is None:
            raise FrameError("the samples were not kept: call propagate with keep_samples=True")
        return self.kept

    def quantile(self, p: ArrayLike) -> Array:
        """Quantiles of the result.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        ndarray
            Quantiles, (k..., ...), interpolated linearly between samples.
        """
        return quantiles(self.samples, p, axis=0)

    @cached_property
    def sobol(self) -> SobolIndices:
        """First-order and total Sobol indices, from n (k + 2) further calls for k inputs; see `sobol_indices`."""
        return self._indices(n=2 ** int(np.log2(self.n)))


def propagate(
    fn: Function,
    distributions: Mapping[str, Distribution],
    *,
    n: int = 10_000,
    rng: Seed = None,
    sampler: str = "random",
    axis: int = 0,
    chunk: int = 16 * BLOCK,
    keep_samples: bool = True,
    progress: bool = True,
) -> Propagation:
    """Propagate independent uncertain inputs through a function, by sampling.

    The same seed gives the same bits, whatever the chunk.

    Parameters
    ----------
    fn
        Function of arrays: called by keyword with the samples of each input, (m,), it returns the results of all of
        them with the samples along `axis`.
    distributions
        Frozen `scipy.stats` distributions by the name of the argument.
    n
        Number of samples.
    rng
        Seed, as in SciPy: an integer, a numpy Generator or SeedSequence, or None.
    sampler
        ``"random"``, ``"sobol"`` or ``"lhs"``; see `sampling.sample_blocks`.
    axis
        Axis of the samples in what `fn` returns.
    chunk
        Number of samples in one call of `fn`, rounded up to a multiple of 1024, at least 2048; it bounds the memory.
    keep_samples
        False keeps moments only, so that memory does not grow with n; quantiles and samples are then not to be had.
    progress
        Show a progress bar when it takes longer than a second.

    Returns
    -------
    Propagation
        Statistics, with the sample axis gone.

    Raises
    ------
    FrameError
        If a distribution, `n`, `rng` or `sampler` cannot be meant, or `fn` returns no axis of samples at `axis`.

    Examples
    --------
    >>> from scipy import stats
    >>> result = propagate(lambda force, stiffness: force / stiffness,
    ...                    {"force": stats.norm(100.0, 5.0), "stiffness": stats.norm(1e6, 1e4)}, rng=0, sampler="sobol")
    >>> bool(abs(result.mean - 1.0001e-4) < 1e-8)
    True
    """
    if not distributions:
        raise FrameError("propagate was given no input: name an argument of the function and its distribution")
    root = root_seed(rng)
    size = BLOCK * max(2, -(-whole(chunk, "chunk", 1) // BLOCK))
    blocks = sample_blocks(distributions, n, root, sampler)
    moments: Moments | None = None
    kept: list[Array] = []
    for results in _results(fn, blocks, size // BLOCK, axis, _bar(n, progress)):
        for start in range(0, len(results), BLOCK):
            part = Moments.of(results[start : start + BLOCK])
            moments = part if moments is None else moments.merge(part)
        if keep_samples:
            kept.append(results)
    assert moments is not None  # n is 2 or more
    samples = np.concatenate(kept) if keep_samples else None
    if samples is not None:
        samples.setflags(write=False)
    indices = partial(sobol_indices, fn, dict(distributions), rng=root, axis=axis, chunk=size)
    return Propagation(tuple(distributions), moments, samples, indices)


def _results(
    fn: Function, blocks: Iterator[dict[str, Array]], count: int, axis: int, bar: Callable[[int], object]
) -> Iterator[Array]:
    """Results of `count` blocks at a time, sample axis first."""
    for chunk in _chunks(blocks, count):
        inputs = {name: np.concatenate([block[name] for block in chunk]) for name in chunk[0]}
        size = len(next(iter(inputs.values())))
        yield samples_first(fn(**inputs), size, axis)
        bar(size)


def _chunks(blocks: Iterator[dict[str, Array]], count: int) -> Iterator[list[dict[str, Array]]]:
    """Blocks `count` at a time, one that is left over with those before: a small batch may be summed in another way."""
    waiting: list[dict[str, Array]] = []
    for block in blocks:
        waiting.append(block)
        if len(waiting) == count + 2:
            yield waiting[:count]
            del waiting[:count]
    yield waiting


def _bar(n: int, progress: bool) -> Callable[[int], object]:
    from tqdm import tqdm

    bar = tqdm(total=n, desc="samples", delay=1.0, disable=not progress, leave=False)
    update: Callable[[int], object] = bar.update
    return update
