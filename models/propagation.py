"""What uncertain inputs make of a result: propagation by sampling, for any function of arrays."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.errors import FrameError, SampleWarning
from .moments import Moments, Statistics, checked_policy
from .sampling import BLOCK, Distribution, Seed, root_seed, sample_blocks, samples_first, whole
from .sensitivity import SobolIndices, sobol_indices
from .spread import quantiles

Array = NDArray[np.float64]
Function = Callable[..., ArrayLike]
# Samples that are NaN and told by their numbers.
MOST_NAMED = 10


@dataclass(frozen=True, eq=False)
class Propagation(Statistics):
    """Statistics of a result under uncertain inputs; made by `propagate`.

    Standard errors are those of independent random samples; Sobol and Latin samples do better than they say. Samples
    that are NaN do not count, or make the statistics NaN, as `nan_policy` has it; `missing` tells how many there are.

    Attributes
    ----------
    inputs
        Names of the inputs.
    n
        Number of samples, those that are NaN included.
    failed
        Numbers of the first samples that are NaN where others are not.
    nan_policy
        What was done with them.
    kept
        Samples of the result, (n, ...), or None where they were not kept.
    """

    inputs: tuple[str, ...]
    n: int
    failed: tuple[int, ...]
    nan_policy: str
    _missing: NDArray[np.int64] = field(repr=False)
    _moments: Moments = field(repr=False)
    kept: Array | None
    _indices: Callable[..., SobolIndices] = field(repr=False)

    @property
    def moments(self) -> Moments:
        """Count, mean and sums of powers of the deviations, (...)."""
        return self._moments

    @property
    def missing(self) -> NDArray[np.int64]:
        """Number of samples that are NaN, (...)."""
        return self._missing

    @property
    def samples(self) -> Array:
        """Samples of the result, sample axis first, (n, ...)."""
        if self.kept is None:
            raise FrameError("the samples were not kept: call propagate with keep_samples=True")
        return self.kept

    def quantile(self, p: ArrayLike) -> Array:
        """Quantile of the result at one or more probabilities.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        ndarray
            Quantiles, (k..., ...), interpolated linearly between samples.

        Raises
        ------
        FrameError
            If the samples were not kept, or a probability is not in [0, 1].
        """
        return quantiles(self.samples, p, axis=0, nan_policy=self.nan_policy)

    @cached_property
    def sobol(self) -> SobolIndices:
        """First-order and total Sobol indices, from n (k + 2) further calls for k inputs; see `sobol_indices`.

        They are NaN where one of those calls is, whatever the `nan_policy`.
        """
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
    nan_policy: str = "omit",
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
    nan_policy
        What to do with samples whose result is NaN where that of others is not, as in SciPy: ``"omit"`` them, so that
        the statistics are those of the others; ``"propagate"``: the statistics are NaN; ``"raise"``. The first two
        warn with their number and the inputs of the first one.

    Returns
    -------
    Propagation
        Statistics, with the sample axis gone.

    Raises
    ------
    FrameError
        If a distribution, `n`, `rng`, `sampler` or `nan_policy` cannot be meant, `fn` returns no axis of samples at
        `axis`, or a sample is NaN and the policy is to raise.

    Warns
    -----
    SampleWarning
        If some samples are NaN.

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
    checked_policy(nan_policy)
    root = root_seed(rng)
    size = BLOCK * max(2, -(-whole(chunk, "chunk", 1) // BLOCK))
    blocks = sample_blocks(distributions, n, root, sampler)
    moments: Moments | None = None
    lost = _Lost(n, nan_policy)
    kept: list[Array] = []
    for inputs, results in _results(fn, blocks, size // BLOCK, axis, _bar(n, progress)):
        lost.note(inputs, results)
        for start in range(0, len(results), BLOCK):
            part = Moments.of(results[start : start + BLOCK], nan_policy)
            moments = part if moments is None else moments.merge(part)
        if keep_samples:
            kept.append(results)
    assert moments is not None  # n is 2 or more
    lost.warn()
    samples = np.concatenate(kept) if keep_samples else None
    if samples is not None:
        samples.setflags(write=False)
    indices = partial(sobol_indices, fn, dict(distributions), rng=root, axis=axis, chunk=size)
    missing = np.asarray(lost.missing)
    return Propagation(tuple(distributions), n, tuple(lost.failed), nan_policy, missing, moments, samples, indices)


class _Lost:
    """The samples that are NaN where others are not, counted as they come.

    Parameters
    ----------
    n
        Number of all samples.
    nan_policy
        What to do with them.
    """

    def __init__(self, n: int, nan_policy: str) -> None:
        self.n, self.nan_policy = n, nan_policy
        self.missing: NDArray[np.int64] | int = 0
        self.failed: list[int] = []
        self.first: dict[str, float] = {}
        self.count = self.seen = 0

    def note(self, inputs: Mapping[str, Array], results: Array) -> None:
        """Count those of one call, (m, ...)."""
        lost = np.isnan(results)
        here = np.count_nonzero(lost, axis=0)
        self.missing = self.missing + here
        # Where the result is NaN for every sample, that is not for the sample's sake.
        some = (here > 0) & (here < len(results))
        if some.any():
            rows = np.flatnonzero(lost[:, some].any(axis=1))
            if not self.failed:
                self.first = {name: float(values[rows[0]]) for name, values in inputs.items()}
            self.count += len(rows)
            self.failed += [self.seen + int(row) for row in rows[: MOST_NAMED - len(self.failed)]]
            if self.nan_policy == "raise":
                raise FrameError(f"{self._told()}: find why, or choose the nan_policy 'omit' or 'propagate'")
        self.seen += len(results)

    def warn(self) -> None:
        """Tell of them all."""
        if self.failed:
            omitted = "the statistics are those of the others"
            end = omitted if self.nan_policy == "omit" else "the statistics are NaN, too"
            warnings.warn(f"{self._told()}; {end}", SampleWarning, stacklevel=3)

    def _told(self) -> str:
        inputs = ", ".join(f"{name} = {value:.6g}" for name, value in self.first.items())
        numbers = ", ".join(map(str, self.failed)) + (", ..." if self.count > len(self.failed) else "")
        found = f"of the first {self.seen}" if self.nan_policy == "raise" and self.seen else f"of {self.n}"
        return f"{self.count} {found} samples are NaN (number {numbers}; the first with {inputs})"


def _results(
    fn: Function, blocks: Iterator[dict[str, Array]], count: int, axis: int, bar: Callable[[int], object]
) -> Iterator[tuple[dict[str, Array], Array]]:
    """Inputs, and results of `count` blocks at a time, sample axis first."""
    for chunk in _chunks(blocks, count):
        inputs = {name: np.concatenate([block[name] for block in chunk]) for name in chunk[0]}
        size = len(next(iter(inputs.values())))
        yield inputs, samples_first(fn(**inputs), size, axis)
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
