"""One call of the function: a chunk of samples and its statistics, the same wherever it is computed."""

from __future__ import annotations

import pickle
import threading
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.errors import FrameError
from ...framework.lazily import cached_property
from ..sampling import BLOCK, Points, Sampler, points_of, samples_first
from .blocks import BlockStatistics
from .comoments import Comoments
from .failures import FailedRows
from .histogram import Bins, Counts
from .inputs import JointInputs

Array = NDArray[np.float64]
Function = Callable[..., ArrayLike]
ALSO = ("covariance", "histogram")


@dataclass(frozen=True, eq=False)
class ChunkResult:
    """Statistics of the samples `start` to `start + count`.

    Parameters
    ----------
    start, count
        Which samples.
    statistics
        Moments of the blocks of samples, and extremes.
    missing
        Number of samples that are NaN, (...).
    failed
        Samples that are NaN somewhere.
    comoments
        Of each block, (..., c, c), if asked for.
    bins, counts
        Bins of the histogram, and the number of samples in each, if asked for.
    samples
        Samples of the result, (count, ...), if asked for.
    """

    start: int
    count: int
    statistics: BlockStatistics
    missing: NDArray[np.int64]
    failed: FailedRows
    comoments: list[Comoments] | None
    bins: Bins | None
    counts: Counts | None
    samples: Array | None


@dataclass(frozen=True, eq=False)
class ChunkTask:
    """Work on a chunk; it is sent to each worker once, and then called with ranges of samples.

    Parameters
    ----------
    fn
        The function.
    inputs
        Distributions of its arguments.
    n
        Number of all samples.
    root
        Seed.
    sampler
        See `points_of`.
    axis
        Axis of the samples in what the function returns.
    nan_policy
        Treatment of samples that are NaN: ``raise``, ``omit`` or ``propagate``.
    also
        Of `ALSO`.
    keep
        Whether to keep the samples.
    bins
        Bins of the histogram; None in the first chunk, which lays them out.
    replicates
        Number of randomisations of the sampler, which come in turn.
    """

    fn: Function
    inputs: JointInputs
    n: int
    root: np.random.SeedSequence
    sampler: Sampler
    axis: int
    nan_policy: str
    also: tuple[str, ...]
    keep: bool
    bins: Bins | None = None
    replicates: int = 1

    def __reduce__(self) -> tuple[Callable[[bytes], ChunkTask], tuple[bytes]]:
        return _restored, (self._bytes,)

    @cached_property
    def _bytes(self) -> bytes:
        return _pickled(tuple(getattr(self, each.name) for each in fields(self)))

    @cached_property
    def _own(self) -> threading.local:
        """What each thread has for itself."""
        return threading.local()

    @property
    def _points(self) -> Points:
        """The sequence of points, of which each thread has its own."""
        own = self._own
        if not hasattr(own, "points"):
            own.points = points_of(self.inputs.names, self.n, self.root, self.sampler, self.replicates)
        found: Points = own.points
        return found

    def drawn(self, start: int, stop: int) -> dict[str, Array]:
        """Inputs of the samples `start` to `stop`, (stop − start,) each."""
        blocks = [self._points.take(first, min(BLOCK, stop - first)) for first in range(start, stop, BLOCK)]
        return self.inputs.samples(np.concatenate(blocks))

    def drawn_at(self, numbers: NDArray[np.int64]) -> dict[str, Array]:
        """Inputs of the samples with these increasing numbers, (f,) each."""
        found: list[dict[str, Array]] = []
        for block in np.unique(numbers // BLOCK).tolist():
            inputs = self.drawn(block * BLOCK, min((block + 1) * BLOCK, self.n))
            rows = numbers[numbers // BLOCK == block] - block * BLOCK
            found.append({name: values[rows] for name, values in inputs.items()})
        return {name: np.concatenate([np.empty(0), *(each[name] for each in found)]) for name in self.inputs.names}

    def results(self, start: int, stop: int) -> tuple[Array, NDArray[np.str_] | None]:
        """Results with the sample axis first, (m, ...), and their status, (m, s), if the function returns one."""
        found = self.fn(**self.drawn(start, stop))
        status = None
        if isinstance(found, tuple) and len(found) == 2 and np.asarray(found[1]).dtype.kind in "UT":
            found, status = found
        results = samples_first(found, stop - start, self.axis, copy=self.keep)
        return results, None if status is None else _status(status, results, self.axis)

    def __call__(self, cut: tuple[int, int]) -> ChunkResult:
        """Call the function for a range of samples, and take the statistics asked for."""
        return self.gathered(cut[0], *self.results(*cut))

    def gathered(self, start: int, results: Array, status: NDArray[np.str_] | None) -> ChunkResult:
        """Statistics asked for, from the results of samples from `start` on and their status."""
        statistics = BlockStatistics.of(results, self.nan_policy, self.replicates)
        missing, failed = _lost(results, statistics, status)
        comoments = None
        if "covariance" in self.also:
            parts = (results[first : first + BLOCK] for first in range(0, len(results), BLOCK))
            comoments = [Comoments.of(np.atleast_2d(part.T).T, self.nan_policy) for part in parts]
        bins = counts = None
        if "histogram" in self.also:
            flat = results.reshape(len(results), -1)
            bins = self.bins or Bins.of(flat[:BLOCK])
            counts = bins.count(flat)
        return ChunkResult(
            start,
            len(results),
            statistics,
            missing,
            failed,
            comoments,
            bins,
            counts,
            results if self.keep else None,
        )


def _lost(
    results: Array, found: BlockStatistics, status: NDArray[np.str_] | None
) -> tuple[NDArray[np.int64], FailedRows]:
    """How many samples (m, ...) are NaN, (...), and which; the numbers of their blocks tell whether to look."""
    count, mean = found.numbers[:2]
    if count.sum() != results.size or np.isnan(mean).any():
        lost = np.isnan(results)
        return np.asarray(np.count_nonzero(lost, axis=0)), FailedRows.of(lost.reshape(len(lost), -1), status)
    return np.zeros(results.shape[1:], dtype=np.int64), FailedRows.none(status)


def _status(given: ArrayLike, results: Array, axis: int) -> NDArray[np.str_]:
    """Status with the samples first and the other axes, those of the result but some of the last, as one, (m, s)."""
    text = np.asarray(given, dtype=np.str_)
    if -text.ndim <= axis < text.ndim:
        text = np.moveaxis(text, axis, 0)
    if text.ndim < 1 or text.shape != results.shape[: text.ndim]:
        raise FrameError(
            f"the function returned a status of shape {np.shape(given)} beside results {results.shape}, samples first: "
            "it must have their axes, or the first of them"
        )
    return text.reshape(len(text), -1)


def _pickled(parts: tuple[Any, ...]) -> bytes:
    """Bytes by which another process can do the task.

    Cloudpickle, where it is there, takes functions of any kind; those of a script or notebook go by value, as no
    machine of a cluster knows them by name.
    """
    try:
        found = pickle.dumps(parts)
        if b"__main__" not in found:
            return found
        problem = None
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        found, problem = b"", error
    try:
        import cloudpickle
    except ImportError:
        if problem is None:
            return found
        raise FrameError(
            f"the function cannot be sent to another process ({problem}): define it and what it uses at the top "
            "level of a module, or give workers a concurrent.futures.ThreadPoolExecutor"
        ) from problem
    return bytes(cloudpickle.dumps(parts))


@lru_cache(maxsize=4)
def _restored(pickled: bytes) -> ChunkTask:
    """The task again, once a process, so that it goes on where it left off among the points."""
    return ChunkTask(*pickle.loads(pickled))


def cuts(n: int, chunk: int) -> list[tuple[int, int]]:
    """Ranges of samples for one call each: whole blocks, and none of a single block or less but where n is no more.

    A small batch may be summed in another way than a large one.
    """
    size = BLOCK * max(2, -(-chunk // BLOCK))
    starts = list(range(0, n, size))
    if len(starts) > 1 and n - starts[-1] <= BLOCK:
        starts.pop()
    return list(zip(starts, [*starts[1:], n], strict=True))
