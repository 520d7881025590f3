"""Statistics of the chunks, merged in the order of their samples, whatever the order in which they were computed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..moments import Moments
from .blocks import BlockStatistics, PooledMoments
from .chunk import ChunkResult, ChunkTask
from .comoments import Comoments
from .failures import FailureCount
from .histogram import BinnedSamples, Bins, Counts

Array = NDArray[np.float64]
Cut = tuple[Any, ...]


@dataclass(eq=False)
class Gathered:
    """Merged statistics of all samples so far.

    Parameters
    ----------
    task
        The work on each chunk.
    """

    task: ChunkTask
    missing: NDArray[np.int64] | int = 0
    least: Array = field(default_factory=lambda: np.array(np.nan))
    greatest: Array = field(default_factory=lambda: np.array(np.nan))
    comoments: Comoments | None = None
    bins: Bins | None = None
    counts: Counts | int = 0
    kept: list[Array] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._blocks, self._replicated = PooledMoments(), PooledMoments()
        self.failures = FailureCount(self.task.n, self.task.nan_policy, self.task.drawn_at)

    def add(self, found: ChunkResult) -> None:
        """Add the next chunk."""
        own = found.statistics
        self._blocks.add(own.numbers)
        if own.replicated is not None:
            self._replicated.add(own.replicated)
        lower, upper = (np.fmin, np.fmax) if self.task.nan_policy == "omit" else (np.minimum, np.maximum)
        first = found.start == 0
        self.least = own.least if first else lower(self.least, own.least)
        self.greatest = own.greatest if first else upper(self.greatest, own.greatest)
        self.missing = self.missing + found.missing
        for part in found.comoments or ():
            self.comoments = part if self.comoments is None else self.comoments.merge(part)
        if found.counts is not None:
            self.bins = self.bins or found.bins
            self.counts = self.counts + found.counts
        if found.samples is not None:
            self.kept.append(found.samples)
        self.failures.note(found.start, found.count, int(np.size(own.least)), found.failed)

    @property
    def moments(self) -> Moments | None:
        """Moments of all samples so far, (...)."""
        return self._blocks.moments

    @property
    def replicated(self) -> Moments | None:
        """Moments of each replicate, (r, ...); None if there is one."""
        return self._replicated.moments

    def samples(self) -> Array | None:
        """All samples, (n, ...), read-only; None if they were not kept."""
        if not self.task.keep:
            return None
        together = np.concatenate(self.kept)
        together.setflags(write=False)
        return together

    def binned(self) -> BinnedSamples | None:
        """Counts in bins; None if not asked for."""
        if self.bins is None or isinstance(self.counts, int):
            return None
        return BinnedSamples(self.bins, self.counts, np.ravel(self.least), np.ravel(self.greatest))


def joined(waiting: Sequence[tuple[Cut, ChunkResult]]) -> list[tuple[Sequence[Cut], ChunkResult]]:
    """Neighbouring chunks of the same length merged into one, if they hold no samples and no sample failed."""
    groups: list[list[tuple[Cut, ChunkResult]]] = []
    for cut, found in waiting:
        before = groups[-1][-1] if groups else None
        follows = before is not None and before[0][1] == cut[0] and before[1].count == found.count
        if before is not None and follows and _may_be_joined(before[1]) and _may_be_joined(found):
            groups[-1].append((cut, found))
        else:
            groups.append([(cut, found)])
    return [([cut for cut, _ in group], _as_one([found for _, found in group])) for group in groups]


def _may_be_joined(found: ChunkResult) -> bool:
    """Whether a chunk holds nothing about single samples."""
    return found.samples is None and found.failed.whole is None and not len(found.failed.rows)


def _as_one(parts: Sequence[ChunkResult]) -> ChunkResult:
    """One result of successive chunks without failures."""
    if len(parts) == 1:
        return parts[0]
    own = [part.statistics for part in parts]
    replicated = [each.replicated for each in own if each.replicated is not None]
    comoments = [each for part in parts for each in part.comoments or ()]
    counts = [part.counts for part in parts if part.counts is not None]
    return replace(
        parts[0],
        count=sum(part.count for part in parts),
        statistics=BlockStatistics(
            np.concatenate([each.numbers for each in own], axis=1),
            np.concatenate(replicated, axis=1) if replicated else None,
            np.min([each.least for each in own], axis=0),
            np.max([each.greatest for each in own], axis=0),
        ),
        comoments=comoments or None,
        counts=np.sum(counts, axis=0) if counts else None,
    )
