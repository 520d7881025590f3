"""Samples of independent inputs: each from a stream of its own, in blocks, the same bits however they are taken."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.batch import numbers
from ..framework.errors import FrameError

Array = NDArray[np.float64]
Seed = int | np.random.SeedSequence | np.random.Generator | None

SAMPLERS = ("random", "sobol", "lhs")

# Samples are drawn and summed in blocks of this size, whatever is held at once: so results do not depend on it.
BLOCK = 1024

# A uniform number may be 0, whose normal quantile is -inf; this is half the least other value that it takes.
LEAST = 2.0**-54


class Distribution(Protocol):
    """What a frozen distribution of `scipy.stats` offers and sampling needs."""

    def ppf(self, q: Array, /) -> Any:
        """Quantile at probability `q`."""


@dataclass(frozen=True)
class Normal:
    """Normal distribution, with the bits of `scipy.stats.norm`, which takes long to load.

    Parameters
    ----------
    mean, deviation
        Mean and standard deviation, in the unit of what is drawn.
    """

    mean: float
    deviation: float

    def ppf(self, q: Array, /) -> Array:
        """Quantile at probability `q`.

        Parameters
        ----------
        q
            Probabilities in (0, 1), (...).

        Returns
        -------
        ndarray
            Quantiles, (...).
        """
        from scipy.special import ndtri

        return np.asarray(ndtri(q) * self.deviation + self.mean)

    def pdf(self, x: Array, /) -> Array:
        """Probability density.

        Parameters
        ----------
        x
            Values, (...).

        Returns
        -------
        ndarray
            Density, (...), in the inverse unit.
        """
        off = (x - self.mean) / self.deviation
        return np.asarray(np.exp(-0.5 * off**2) / (np.sqrt(2.0 * np.pi) * self.deviation))


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
    """Generator that belongs to `name`: it does not change when other names come or go."""
    key = (*root.spawn_key, *name.encode())
    return np.random.default_rng(np.random.SeedSequence(root.entropy, spawn_key=key))


def sample_blocks(
    distributions: Mapping[str, Distribution], n: int, rng: Seed, sampler: str = "random"
) -> Iterator[dict[str, Array]]:
    """Draw `n` samples of every input, a block at a time.

    Parameters
    ----------
    distributions
        Frozen `scipy.stats` distributions by input.
    n
        Number of samples, 2 or more.
    rng
        Seed, as in SciPy. Random and Latin samples of one input depend on the seed and its name alone.
    sampler
        ``"random"``; ``"lhs"``, a Latin hypercube; or ``"sobol"``, a scrambled Sobol sequence (A. B. Owen, J. of
        Complexity 14, 1998, doi:10.1006/jcom.1998.0487), best balanced when n is a power of two.

    Yields
    ------
    dict
        Samples by input, each of `BLOCK` or, in the last block, fewer.
    """
    root = root_seed(rng)
    check_inputs(distributions)
    whole(n, "number of samples n", 2)
    if sampler not in SAMPLERS:
        raise FrameError(f"sampler is {sampler!r}: choose one of {', '.join(SAMPLERS)}")
    uniform = {"random": _random, "sobol": _sobol, "lhs": _latin}[sampler](list(distributions), n, root)
    for start, points in zip(range(0, n, BLOCK), uniform, strict=False):
        count = min(BLOCK, n - start)
        inside = np.maximum(points[:count], LEAST)
        columns = zip(distributions.items(), inside.T, strict=True)
        yield {name: np.asarray(law.ppf(column), dtype=np.float64) for (name, law), column in columns}


def draw(distributions: Mapping[str, Distribution], n: int, rng: Seed, sampler: str = "random") -> dict[str, Array]:
    """Draw `n` samples of every input at once, (n,) each; see `sample_blocks`."""
    blocks = list(sample_blocks(distributions, n, rng, sampler))
    return {name: np.concatenate([block[name] for block in blocks]) for name in distributions}


def whole(value: object, what: str, least: int) -> int:
    """A whole number not below `least`, checked."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise FrameError(f"{what} is {value!r}: give a whole number of {least} or more")
    return int(value)


def check_inputs(distributions: Mapping[str, Distribution]) -> None:
    """Refuse what is no mapping of names to frozen distributions."""
    if not isinstance(distributions, Mapping):
        raise FrameError(f"distributions are {distributions!r}: give a mapping of names to frozen ones of scipy.stats")
    for name, law in distributions.items():
        if not hasattr(law, "ppf"):
            raise FrameError(
                f"distribution of {name!r} is {law!r}: give a frozen one, such as scipy.stats.norm(1.0, 0.1)"
            )
        median = law.ppf(np.array(0.5))
        if np.shape(median) != () or not np.isfinite(median):
            raise FrameError(f"distribution of {name!r} has the median {median}: give finite scalar parameters")


def samples_first(result: ArrayLike, size: int, axis: int) -> Array:
    """`result` with its axis of `size` samples first."""
    array = numbers(result, f"what the function returned for {size} samples")
    if not -array.ndim <= axis < array.ndim or array.shape[axis] != size:
        raise FrameError(
            f"the function returned shape {array.shape} for {size} samples: it must have them along axis {axis},"
            " or tell another axis"
        )
    return np.moveaxis(array, axis, 0)


def _random(names: list[str], n: int, root: np.random.SeedSequence) -> Iterator[Array]:
    streams = [stream(root, name) for name in names]
    while True:
        yield np.stack([each.random(BLOCK) for each in streams], axis=-1) if names else np.empty((BLOCK, 0))


def _sobol(names: list[str], n: int, root: np.random.SeedSequence) -> Iterator[Array]:
    from scipy.stats import qmc

    sequence = qmc.Sobol(len(names), scramble=True, rng=stream(root, "sobol sequence"))
    while True:
        yield sequence.random(BLOCK)


def _latin(names: list[str], n: int, root: np.random.SeedSequence) -> Iterator[Array]:
    from scipy.stats import qmc

    columns = [qmc.LatinHypercube(1, rng=stream(root, name)).random(n) for name in names]
    points = np.concatenate(columns, axis=1) if names else np.empty((n, 0))
    for start in range(0, n, BLOCK):
        yield points[start : start + BLOCK]
