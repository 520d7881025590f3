"""Propagation of uncertain inputs by sampling, for any function of arrays."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.checked import whole_number
from ...framework.errors import FrameError, SampleWarning
from ..distributions import Uncertain
from ..moments import checked_policy
from ..sampling import BLOCK, Sampler, Seed, goes_on, points_of, root_seed
from ..sensitivity import SobolIndices, sobol_indices
from .checkpoint import FUNCTION, Checkpoint, first_results, same_results
from .chunk import ALSO, ChunkResult, ChunkTask, Function, cuts
from .correlation import GaussianCopula, Pairs
from .failures import in_words
from .gathered import Gathered, joined
from .inputs import JointInputs, check_sum
from .ordered import StoredChunks, covered, gather
from .packed import packed, unpacked
from .progress import SampleBar, sample_bar
from .result import Propagation
from .workers import Workers, computed

Array = NDArray[np.float64]
Cut = tuple[int, int]


def propagate(
    fn: Function,
    distributions: Mapping[str, Uncertain],
    *,
    n: int = 10_000,
    rng: Seed = None,
    sampler: Sampler = "random",
    replicates: int = 1,
    axis: int = 0,
    chunk: int = 16 * BLOCK,
    keep_samples: bool = True,
    progress: bool = True,
    nan_policy: str = "omit",
    correlation: GaussianCopula | Pairs | ArrayLike | None = None,
    also: Sequence[str] = (),
    workers: Workers = 1,
    checkpoint: str | os.PathLike[str] | None = None,
) -> Propagation:
    """Propagate uncertain inputs through a function, by sampling.

    The same seed gives the same bits, whatever the chunk, the number of workers, and how often the run was interrupted.

    Parameters
    ----------
    fn
        Function of arrays: called by keyword with the samples of each input, (m,), it returns the results of all of
        them with the samples along `axis`; or a pair of these and of texts with the same axes, or the first of them,
        such as the status of each pose and sample, by which samples without a result are named.
    distributions
        By the name of the argument: a frozen `scipy.stats` distribution or random variable, any object with ``ppf`` or
        ``icdf``, an interval ``(low, high)``, or in words a tolerance such as ``"0.1 ± 5 %"`` or a distribution such as
        ``"norm(0.1, 0.002)"``.
    n
        Number of samples.
    rng
        Seed, as in SciPy: an integer, a numpy Generator or SeedSequence, or None.
    sampler
        ``"random"``, ``"lhs"`` (Latin hypercube), ``"sobol"``, ``"halton"``, or an engine of `scipy.stats.qmc`, of
        which a copy is taken from where it stands.
    replicates
        Number of independent randomisations of the sampler among which the n samples are shared: 1, or 4 to 64, a power
        of two. With several, standard errors and confidence intervals are those between them (P. L'Ecuyer & C. Lemieux,
        in *Modeling Uncertainty*, 2002), and so as narrow as a sequence or Latin hypercube deserves; with one they are
        those of independent samples, which are wider.
    axis
        Axis of the samples in what `fn` returns.
    chunk
        Number of samples in one call of `fn`, rounded up to a multiple of 1024, at least 2048; it bounds the memory.
    keep_samples
        False keeps statistics only, so that memory does not grow with n.
    progress
        Show a progress bar when it takes longer than a second.
    nan_policy
        What to do with samples whose result is NaN where that of others is not, as in SciPy: ``"omit"`` them, so that
        the statistics are those of the others; ``"propagate"``: the statistics are NaN; ``"raise"``. The first two
        warn with their number and the inputs of the first one.
    correlation
        Correlations of inputs by pair, such as ``{("a", "b"): 0.3}``, as a matrix (k, k), or a `GaussianCopula`. Left
        out, the inputs are independent.
    also
        What to gather where samples are not kept: ``"covariance"`` of the components along the last axis of the result,
        ``"histogram"``, which gives quantiles as well.
    workers
        Who calls `fn`, as in SciPy: this process (1), so many processes, as many as there are processors (−1), a
        callable like ``map``, a `concurrent.futures.Executor`, or a dask ``Client``.
    checkpoint
        Folder in which each chunk is stored when it is done, short ones a quarter of a second of work at a time. The
        same call goes on from there if the run was ended, by whatever means, and gives the same bits; with a larger `n`
        it extends the run (whole chunks of it, so that `n` best is a multiple of `chunk`). Chunks that were damaged are
        done again.

    Returns
    -------
    Propagation
        Statistics, with the sample axis gone.

    Raises
    ------
    FrameError
        If an input, `n`, `rng`, `sampler` or another option cannot be meant, `fn` returns no axis of samples at
        `axis`, a sample is NaN and the policy is to raise, a worker came to an end, or the checkpoint belongs to
        another run or cannot be written.

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
    inputs = JointInputs.of(distributions, correlation)
    whole_number(n, "number of samples n", 2)
    _check_also(also)
    root = root_seed(rng)
    size = whole_number(chunk, "chunk", 1)
    task = ChunkTask(fn, inputs, n, root, sampler, axis, nan_policy, tuple(also), keep_samples, replicates=replicates)
    points_of(inputs.names, n, root, sampler, replicates)
    ranges = cuts(n, size)
    folder: Checkpoint | None = None
    begun: dict[Cut, ChunkResult] = {}
    if checkpoint is not None:
        task, folder, begun = _taken_up(task, checkpoint, ranges[0], fresh=rng is None, alone=workers == 1)
    gathered = _gather(task, ranges, workers, folder, begun, progress)
    indices = partial(
        sobol_indices, fn, inputs.distributions, rng=task.root, axis=axis, chunk=size, replicates=replicates
    )
    return _result(task, gathered, indices)


def _check_also(also: Sequence[str]) -> None:
    for each in [also] if isinstance(also, str) else also:
        if each not in ALSO or isinstance(also, str):
            raise FrameError(f"also is {also!r}: give some of {', '.join(ALSO)}, such as also=('histogram',)")


def _result(task: ChunkTask, gathered: Gathered, indices: partial[SobolIndices]) -> Propagation:
    """The result, with a warning if samples failed."""
    failures = gathered.failures.found()
    if failures.count:
        omitted = "the statistics are those of the others"
        end = omitted if task.nan_policy == "omit" else "the statistics are NaN, too"
        warnings.warn(f"{in_words(failures, str(task.n))}; {end}", SampleWarning, stacklevel=3)
    moments = gathered.moments
    assert moments is not None  # n is 2 or more
    return Propagation(
        task.inputs.names,
        task.n,
        task.nan_policy,
        failures,
        gathered.samples(),
        np.asarray(gathered.missing),
        moments,
        (gathered.least, gathered.greatest),
        gathered.comoments,
        gathered.binned(),
        task,
        indices,
        gathered.replicated,
    )


# -- chunks in their order --------------------------------------------------------------------------------------------


@dataclass(eq=False)
class _Gathering:
    """Merges the chunks of a run, and shows its progress."""

    gathered: Gathered
    bar: SampleBar
    folder: Checkpoint | None

    def expect(self, _: Cut) -> None:
        """Nothing to do before a chunk."""

    def add(self, _: Cut, found: ChunkResult) -> None:
        self.gathered.add(found)
        self.bar.advance(found.count, self.gathered)

    def progress(self, done: int, of: int) -> str:
        if self.folder is None:
            return f"{done} of {of} chunks were done; with checkpoint='a folder' an interrupted run can be resumed"
        where = self.folder.folder
        return f"{done} of {of} chunks are stored in {where}: the same call with this checkpoint goes on from there"


def _gather(
    task: ChunkTask,
    ranges: Sequence[Cut],
    workers: Workers,
    folder: Checkpoint | None,
    begun: dict[Cut, ChunkResult],
    progress: bool,
) -> Gathered:
    stored = {} if folder is None else covered(ranges, folder.stored())
    chunks = None if folder is None else StoredChunks(folder, packed, unpacked, joined)
    first = stored.get(ranges[0])
    laid_out = None if chunks is None or first is None else partial(chunks.load, first)
    gathered = Gathered(task)
    compute = partial(_in_any_order, task, ranges, workers, laid_out, begun)
    with sample_bar(task.n, progress) as bar:
        gather(ranges, compute, _Gathering(gathered, bar, folder), chunks, stored)
    return gathered


def _in_any_order(
    task: ChunkTask,
    ranges: Sequence[Cut],
    workers: Workers,
    laid_out: Callable[[], ChunkResult] | None,
    begun: dict[Cut, ChunkResult],
    left: list[Cut],
) -> Generator[tuple[Cut, ChunkResult], None, None]:
    """Chunks that are not stored, as they are done; the very first comes first if it lays out the bins."""
    first = begun.pop(left[0], None) if left else None
    if "histogram" in task.also and left:
        if left[0] == ranges[0]:
            first = first or task(left[0])
        else:
            assert laid_out is not None
            first = laid_out()
        task = replace(task, bins=first.bins)
    if first is not None and left[0] == ranges[0]:
        yield left[0], first
        left = left[1:]
    if left:
        yield from computed(task, left, workers)


# -- what a run depends on --------------------------------------------------------------------------------------------


def _taken_up(
    task: ChunkTask, checkpoint: str | os.PathLike[str], first: Cut, *, fresh: bool, alone: bool
) -> tuple[ChunkTask, Checkpoint, dict[Cut, ChunkResult]]:
    """The task, with the seed of the run in a folder where none was given; the folder; and the chunk begun with.

    The function is known by its results of the first samples. Who works `alone` has them from the first chunk; where
    others are to begin meanwhile, or chunks are there already, it is called for two samples.
    """
    before = Checkpoint.known(checkpoint)
    if before is None and alone:
        Checkpoint.made(checkpoint)
        results, status = task.results(*first)
        now = about(task, results[:2])
        return task, Checkpoint.open(checkpoint, now), {first: task.gathered(first[0], results, status)}
    if fresh and before is not None:
        task = replace(task, root=_seed_of(before["the seed"]))
    now = about(task, task.results(0, 2)[0])
    if before is not None and before[FUNCTION] != now[FUNCTION]:
        # Rounding may differ on another machine, and in a longer batch: the same results to so many digits are those of
        # the same function.
        same = same_results(before[FUNCTION], now[FUNCTION])
        if same or before[FUNCTION] == first_results(task.results(*first)[0][:2]):
            now[FUNCTION] = before[FUNCTION]
    return task, Checkpoint.open(checkpoint, now), {}


def about(task: ChunkTask, results: Array) -> dict[str, Any]:
    """By what the results of a run depend on, and its first results, what tells it from another run."""
    text: dict[str, Any] = {"the order of the inputs": list(task.inputs.names)} | task.inputs.told()
    entropy = task.root.entropy
    text["the seed"] = {
        "entropy": entropy if entropy is None or isinstance(entropy, int) else [int(each) for each in entropy],
        "spawn_key": [int(each) for each in task.root.spawn_key],
    }
    if isinstance(task.sampler, str):
        text["the sampler"] = task.sampler
    else:
        first = points_of(task.inputs.names, task.n, task.root, task.sampler).take(0, 16)
        text["the sampler"] = check_sum(first)
    if not goes_on(task.sampler):
        # these points are balanced for their total number
        text["the number of samples"] = task.n
    if task.replicates > 1:
        text["the number of replicates"] = task.replicates
    text |= {"axis": task.axis, "nan_policy": task.nan_policy, "also": sorted(task.also), "keep_samples": task.keep}
    text[FUNCTION] = first_results(results)
    return text


def _seed_of(text: Mapping[str, Any]) -> np.random.SeedSequence:
    return np.random.SeedSequence(text["entropy"], spawn_key=text["spawn_key"])
