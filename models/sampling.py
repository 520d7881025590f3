"""Samples of independent inputs in blocks of fixed size, with a random stream for each input.

The samples depend only on the seed, not on how many are held in memory at once.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from copy import deepcopy
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.batch import as_numbers
from ..framework.checked import whole_number
from ..framework.errors import FrameError
from .distributions import Distribution as Distribution  # taken from here, too
from .distributions import Normal as Normal
from .distributions import Uncertain
from .given_distributions import distributions_of
from .quantiles import quantiles

if TYPE_CHECKING:
    from scipy.stats import qmc

Array = NDArray[np.float64]
Seed = int | np.random.SeedSequence | np.random.Generator | None
# Name of a sampler, or an engine of scipy.stats.qmc, whose type is not named here because its import takes long.
Sampler = Any

SAMPLERS = ("random", "sobol", "lhs", "halton")
# Possible numbers of independent randomisations; each has the same share of a block.
REPLICATES = (1, 4, 8, 16, 32, 64)

# Samples are drawn and summed in blocks of this size, so that results do not depend on how many are held at once.
BLOCK = 1024

# A uniform random number may be 0, whose normal quantile is -inf; this is half the smallest other value.
LEAST = 2.0**-54


def root_seed(rng: Seed) -> np.random.SeedSequence:
    """Seed sequence of `rng`: an int, a seed sequence, a generator (from which it draws), or None for fresh entropy."""
    if isinstance(rng, np.random.SeedSequence):
        return rng
    if isinstance(rng, np.random.Generator):
        return np.random.SeedSequence(rng.integers(0, 2**32, size=4).tolist())
    if rng is None or (isinstance(rng, int | np.integer) and rng >= 0):
        return np.random.SeedSequence(rng)
    raise FrameError(f"rng is {rng!r}: give an integer from 0, a numpy Generator or SeedSequence, or None")


def stream(root: np.random.SeedSequence, name: str) -> np.random.Generator:
    """Random number generator for a name, independent of which other names there are."""
    return np.random.default_rng(named_seed(root, name))


def named_seed(root: np.random.SeedSequence, name: str) -> np.random.SeedSequence:
    """Seed sequence for a name, derived from `root`."""
    return np.random.SeedSequence(root.entropy, spawn_key=(*root.spawn_key, *name.encode()))


def replicate_seeds(root: np.random.SeedSequence, replicates: int) -> list[np.random.SeedSequence]:
    """Seed sequences of independent randomisations, derived from `root`."""
    return [named_seed(root, f"replicate {k}") for k in range(replicates)]


def sample_blocks(
    distributions: Mapping[str, Uncertain], n: int, rng: Seed, sampler: Sampler = "random"
) -> Iterator[dict[str, Array]]:
    """Draw `n` samples of every input, a block at a time.

    Parameters
    ----------
    distributions
        Distributions of the inputs by name, as for `propagate`.
    n
        Number of samples.
    rng
        Seed, as in SciPy. Random and Latin hypercube samples of an input depend only on the seed and its name.
    sampler
        Sampler, as for `points_of`.

    Yields
    ------
    dict
        Samples by input, (`BLOCK`,) each, fewer in the last block.
    """
    known = distributions_of(distributions)
    points = points_of(list(known), n, root_seed(rng), sampler)
    for start in range(0, n, BLOCK):
        columns = zip(known.items(), points.take(start, min(BLOCK, n - start)).T, strict=True)
        yield {name: quantiles(distribution, column) for (name, distribution), column in columns}


def draw(distributions: Mapping[str, Uncertain], n: int, rng: Seed, sampler: Sampler = "random") -> dict[str, Array]:
    """Draw `n` samples of every input at once, (n,) each; see `sample_blocks`."""
    blocks = list(sample_blocks(distributions, n, rng, sampler))
    return {name: np.concatenate([block[name] for block in blocks]) for name in distributions}


def samples_first(result: ArrayLike, size: int, axis: int, *, copy: bool = True) -> Array:
    """Result with its axis of `size` samples moved to the front; without a copy it is valid until the next call."""
    array = as_numbers(result, f"what the function returned for {size} samples", copy=copy)
    if not -array.ndim <= axis < array.ndim or array.shape[axis] != size:
        raise FrameError(
            f"the function returned shape {array.shape} for {size} samples: it must have them along axis {axis},"
            " or give another axis"
        )
    return np.moveaxis(array, axis, 0)


class Points(ABC):
    """Points of the unit cube with a column for each input, which can be taken from any number on.

    A point depends only on its number, not on those taken before. No coordinate is 0.

    Parameters
    ----------
    names
        Names of the inputs.
    n
        Total number of points.
    root
        Seed sequence from which the random streams are derived.
    """

    def __init__(self, names: Sequence[str], n: int, root: np.random.SeedSequence) -> None:
        self.names, self.n, self.root = tuple(names), n, root
        self._next = 0
        self._begin()

    def take(self, start: int, count: int) -> Array:
        """Points with the numbers from `start` to `start + count`, at most a block, (count, k)."""
        if start < self._next:
            self._begin()
            self._next = 0
        if start > self._next:
            self._skip(start - self._next)
        self._next = start + BLOCK
        return np.maximum(self._block()[:count], LEAST)

    @abstractmethod
    def _begin(self) -> None:
        """Go to the first point."""

    @abstractmethod
    def _skip(self, count: int) -> None:
        """Skip `count` points."""

    @abstractmethod
    def _block(self) -> Array:
        """The next `BLOCK` points, or as many as there are."""


class _RandomPoints(Points):
    """Independent random points, with a stream for each input."""

    def _begin(self) -> None:
        self._streams = [stream(self.root, name) for name in self.names]

    def _skip(self, count: int) -> None:
        # Each coordinate uses one random number of 64 bits.
        for each in self._streams:
            each.bit_generator.advance(count)  # type: ignore[attr-defined]

    def _block(self) -> Array:
        return np.stack([each.random(BLOCK) for each in self._streams]).T if self.names else np.empty((BLOCK, 0))


class _Sequence(Points):
    """Scrambled Sobol sequence of SciPy."""

    def _engine(self) -> qmc.QMCEngine:
        from scipy.stats import qmc

        return qmc.Sobol(len(self.names), scramble=True, rng=stream(self.root, "sobol sequence"))

    def _begin(self) -> None:
        self._sequence = self._engine()

    def _skip(self, count: int) -> None:
        self._sequence.fast_forward(count)

    def _block(self) -> Array:
        # A power of two, for which the sequence is balanced.
        return np.asarray(self._sequence.random(min(BLOCK, 1 << (self.n - 1).bit_length())))


class _HaltonPoints(_Sequence):
    def _engine(self) -> qmc.QMCEngine:
        from scipy.stats import qmc

        return qmc.Halton(len(self.names), scramble=True, rng=stream(self.root, "halton sequence"))

    def _skip(self, count: int) -> None:
        # Each point follows from its number; fast_forward of SciPy would compute the points between.
        self._sequence.num_generated += count


class _TogetherPoints(Points):
    """Latin hypercube: its points are balanced only together and so are made all at once."""

    def _begin(self) -> None:
        self._start = 0
        if not hasattr(self, "_all"):
            self._all = self._made()

    def _made(self) -> Array:
        from scipy.stats import qmc

        columns = [qmc.LatinHypercube(1, rng=stream(self.root, name)).random(self.n) for name in self.names]
        return np.concatenate(columns, axis=1) if self.names else np.empty((self.n, 0))

    def _skip(self, count: int) -> None:
        self._start += count

    def _block(self) -> Array:
        found = self._all[self._start : self._start + BLOCK]
        self._start += BLOCK
        return found


class _GivenSequence(_Sequence):
    """Points of the caller's Sobol or Halton engine, from its current position on."""

    def __init__(self, names: Sequence[str], n: int, engine: qmc.QMCEngine) -> None:
        self.engine = engine
        super().__init__(names, n, np.random.SeedSequence(0))

    def _engine(self) -> qmc.QMCEngine:
        return deepcopy(self.engine)


class _GivenTogether(_TogetherPoints):
    """Points of any other engine of the caller."""

    def __init__(self, names: Sequence[str], n: int, engine: qmc.QMCEngine) -> None:
        self.engine = engine
        super().__init__(names, n, np.random.SeedSequence(0))

    def _made(self) -> Array:
        found = np.asarray(deepcopy(self.engine).random(self.n), dtype=np.float64)
        if len(found) < self.n:
            raise FrameError(f"the engine {type(self.engine).__name__} has {len(found)} of {self.n} points")
        return found


class _ReplicatedPoints(Points):
    """Points of several independent randomisations of one sampler, in turn."""

    def __init__(
        self, names: Sequence[str], n: int, root: np.random.SeedSequence, sampler: str, replicates: int
    ) -> None:
        roots = replicate_seeds(root, replicates)
        self.each = [_BY_NAME[sampler](names, n // replicates, own) for own in roots]
        super().__init__(names, n, root)

    def _begin(self) -> None:
        self._number, self._of = 0, -1

    def _skip(self, count: int) -> None:
        self._number += count // BLOCK

    def _block(self) -> Array:
        r, share = len(self.each), BLOCK // len(self.each)
        of, part = divmod(self._number, r)
        if of != self._of:
            # One block of each of r randomisations makes r blocks of the result.
            self._of, first = of, of * BLOCK
            self._together = [each.take(first, min(BLOCK, self.n // r - first)) for each in self.each]
        self._number += 1
        own = [each[part * share : (part + 1) * share] for each in self._together]
        return np.stack(own, axis=1).reshape(-1, len(self.names))


_BY_NAME: dict[str, type[Points]] = {
    "random": _RandomPoints,
    "sobol": _Sequence,
    "lhs": _TogetherPoints,
    "halton": _HaltonPoints,
}


def points_of(
    names: Sequence[str], n: int, root: np.random.SeedSequence, sampler: Sampler = "random", replicates: int = 1
) -> Points:
    """Points of a sampler, after checks of the arguments.

    Parameters
    ----------
    names
        Names of the k inputs.
    n
        Number of samples, 2 or more.
    root
        Seed sequence; not used by an engine, which has its own.
    sampler
        ``"random"``; ``"lhs"``, a Latin hypercube; ``"sobol"``, a scrambled Sobol sequence (A. B. Owen, J. of
        Complexity 14, 1998, doi:10.1006/jcom.1998.0487), best balanced when n is a power of two; ``"halton"``, a
        scrambled Halton sequence (A. B. Owen, arXiv:1706.02808, 2017); or an engine of `scipy.stats.qmc` of dimension
        k, of which a copy is used from its current position on.
    replicates
        Number of independent randomisations of a sampler given by name: 1, or a power of two from 4 to 64 that divides
        n.

    Returns
    -------
    Points
        The points (n, k).

    Raises
    ------
    FrameError
        If there is no such sampler, the number of replicates is not possible, or an engine has another dimension.
    """
    whole_number(n, "number of samples n", 2)
    if isinstance(sampler, str):
        if sampler not in SAMPLERS:
            raise FrameError(
                f"sampler is {sampler!r}: choose one of {', '.join(SAMPLERS)}, or give an engine of scipy.stats.qmc"
            )
        if _checked_replicates(replicates, n) == 1:
            return _BY_NAME[sampler](names, n, root)
        return _ReplicatedPoints(names, n, root, sampler, replicates)
    from scipy.stats import qmc

    if not isinstance(sampler, qmc.QMCEngine):
        raise FrameError(
            f"sampler is {sampler!r}: choose one of {', '.join(SAMPLERS)}, or give an engine of scipy.stats.qmc"
        )
    if replicates != 1:
        raise FrameError(f"replicates is {replicates!r}, and an engine has one randomisation: give a sampler by name")
    if sampler.d != len(names):
        raise FrameError(f"sampler is an engine of dimension {sampler.d}: there are {len(names)} inputs")
    kind = _GivenSequence if goes_on(sampler) else _GivenTogether
    return kind(names, n, sampler)


def _checked_replicates(replicates: object, n: int) -> int:
    """Check the number of replicates for n samples and return it."""
    count = whole_number(replicates, "replicates", 1)
    if count not in REPLICATES:
        raise FrameError(f"replicates is {count}: choose one of {', '.join(map(str, REPLICATES))}")
    samples_of_each(n, count)
    return count


def samples_of_each(n: int, replicates: int) -> int:
    """Number of samples of each replicate, 2 or more, if n samples are divided equally."""
    if n % replicates or n < 2 * replicates:
        raise FrameError(
            f"number of samples n is {n}: give a multiple of the {replicates} replicates, twice that or more"
        )
    return n // replicates


def goes_on(sampler: Sampler) -> bool:
    """Whether a run with a sampler can be extended, because its points do not depend on their total number."""
    if isinstance(sampler, str):
        return sampler != "lhs"
    from scipy.stats import qmc

    return isinstance(sampler, qmc.Sobol | qmc.Halton)
