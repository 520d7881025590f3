"""Samples without a result: counted by reason, with their numbers and inputs."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]

# Number of failed samples that a message names, and whose numbers are kept.
MOST_NAMED, MOST_KEPT = 10, 10_000
UNTOLD = "no result"


@dataclass(frozen=True, eq=False)
class Reasons:
    """Why samples failed: a few texts, and the number of one of them for each sample.

    Parameters
    ----------
    texts
        The different reasons, (r,).
    which
        Number of the reason, (f,).
    """

    texts: NDArray[np.str_]
    which: NDArray[np.uint16]

    @classmethod
    def of(cls, lost: Flags, status: NDArray[np.str_] | None) -> Reasons:
        """Status of each sample at the first of its entries that is NaN; what follows a colon are numbers.

        Parameters
        ----------
        lost
            Where samples are NaN, (f, e).
        status
            As the function told it, (f, s) with s a divisor of e; None where it told nothing.
        """
        if status is None:
            return cls(np.array([UNTOLD]), np.zeros(len(lost), np.uint16))
        first = lost.argmax(axis=1) // max(1, lost.shape[1] // status.shape[1])
        texts, which = np.unique(status[np.arange(len(status)), first], return_inverse=True)
        short = [text.partition(":")[0] or UNTOLD for text in texts.tolist()]
        return cls(np.array(short, dtype=np.str_), which.astype(np.uint16))

    def count(self, rows: NDArray[np.int64] | slice = slice(None)) -> Counter[str]:
        """Number of failed samples for each reason."""
        times = np.bincount(self.which[rows], minlength=len(self.texts))
        found: Counter[str] = Counter()
        for text, count in zip(self.texts.tolist(), times.tolist(), strict=True):
            if count:
                found[text] += count
        return found


@dataclass(frozen=True, eq=False)
class FailedRows:
    """The samples of one chunk that have NaN somewhere.

    Parameters
    ----------
    rows
        Those with NaN at an entry where another sample of the chunk has a number; rows of the chunk, (f,).
    reasons
        Why, (f,).
    whole
        Entries where all samples of the chunk are NaN, (e,); None where there are none.
    otherwise
        Why the samples are NaN there, (m,), if these entries turn out to count; None where there are none.
    """

    rows: NDArray[np.int64]
    reasons: Reasons
    whole: Flags | None
    otherwise: Reasons | None

    @classmethod
    def none(cls, status: NDArray[np.str_] | None) -> FailedRows:
        """Value for samples of which none is NaN."""
        nowhere = np.zeros((0, 1), dtype=bool)
        return cls(np.zeros(0, np.int64), Reasons.of(nowhere, None if status is None else status[:0]), None, None)

    @classmethod
    def of(cls, lost: Flags, status: NDArray[np.str_] | None) -> FailedRows:
        """From where samples are NaN, (m, e), and the status of the samples there, (m, s) with s a divisor of e."""
        whole = lost.all(axis=0)
        some = lost & ~whole
        rows = np.flatnonzero(some.any(axis=1))
        reasons = Reasons.of(some[rows], None if status is None else status[rows])
        if not whole.any():
            return cls(rows, reasons, None, None)
        return cls(rows, reasons, np.asarray(whole), Reasons.of(lost, status))


@dataclass(frozen=True, eq=False)
class Failures:
    """Samples that have no result where others have one.

    Attributes
    ----------
    n
        Number of all samples.
    count
        Number of those that failed.
    reasons
        How many failed for each reason, as the function told it.
    numbers
        Numbers of the first 10 000 of them, (f,).
    entries, empty
        Number of entries of the result, and of those that no sample has, which make no sample fail.
    empty_reasons
        Where no sample has any entry, how many have none for each reason.
    """

    n: int
    count: int
    reasons: Mapping[str, int]
    numbers: NDArray[np.int64]
    _drawn: Callable[[NDArray[np.int64]], dict[str, Array]] = field(repr=False)
    entries: int = 1
    empty: int = 0
    empty_reasons: Mapping[str, int] = field(default_factory=dict)

    @cached_property
    def inputs(self) -> dict[str, Array]:
        """Inputs of the failed samples by name, (f,) each, drawn again from the seed."""
        return self._drawn(self.numbers)

    def __repr__(self) -> str:
        if self.empty and self.empty == self.entries:
            lines = [f"none of {self.n} samples has a result"]
            return "\n".join([*lines, *_told(self.empty_reasons)])
        lines = [f"{self.count or 'none'} of {self.n} samples failed", *_told(self.reasons)]
        if self.empty:
            lines.append(f"{self.empty} of {self.entries} numbers of the result are NaN in every sample")
        return "\n".join(lines)


def _told(reasons: Mapping[str, int]) -> list[str]:
    """One line for each reason."""
    return [f"  {times:>8} {reason}" for reason, times in reasons.items()]


def in_words(failures: Failures, of: str) -> str:
    """Text of a message about failed samples."""
    first = failures.numbers[:MOST_NAMED]
    inputs = ", ".join(f"{name} = {values[0]:.6g}" for name, values in failures._drawn(first[:1]).items())
    numbers = ", ".join(map(str, first)) + (", ..." if failures.count > len(first) else "")
    why = ", ".join(f"{reason} {times} times" for reason, times in failures.reasons.items())
    because = "" if set(failures.reasons) == {UNTOLD} else f"; {why}"
    return f"{failures.count} of {of} samples are NaN (number {numbers}; the first with {inputs}{because})"


@dataclass(eq=False)
class FailureCount:
    """Counts the failed samples of one chunk after the other.

    An entry that is NaN for every sample of the run does not count as a failure of samples; that is known at the end
    only.

    Parameters
    ----------
    n
        Number of all samples.
    nan_policy
        Raise as soon as a sample has failed, or not.
    drawn
        Draws the inputs of samples by their numbers.
    """

    n: int
    nan_policy: str
    drawn: Callable[[NDArray[np.int64]], dict[str, Array]]
    seen: int = 0
    entries: int = 1
    _always: Flags = field(default_factory=lambda: np.ones((), dtype=bool))
    _chunks: list[tuple[int, int, FailedRows]] = field(default_factory=list)

    def note(self, start: int, count: int, entries: int, failed: FailedRows) -> None:
        """Count the samples `start` to `start + count`."""
        whole = np.zeros(entries, dtype=bool) if failed.whole is None else failed.whole
        self._always, self.entries = self._always & whole, entries
        self.seen = start + count
        if len(failed.rows) or failed.whole is not None:
            self._chunks.append((start, count, failed))
        if self.nan_policy == "raise":
            found = self.found()
            if found.count:
                text = in_words(found, str(self.n) if self.seen == self.n else f"the first {self.seen}")
                raise FrameError(f"{text}: find why, or choose the nan_policy 'omit' or 'propagate'")

    def found(self) -> Failures:
        """Failed samples so far."""
        numbers: list[NDArray[np.int64]] = []
        reasons: Counter[str] = Counter()
        count = held = 0
        for start, size, failed in self._chunks:
            rows = failed.rows
            if failed.whole is not None and (failed.whole & ~self._always).any():
                # an entry that was NaN throughout this chunk is not so throughout the run
                assert failed.otherwise is not None
                rows = np.arange(size)
                others = np.setdiff1d(rows, failed.rows, assume_unique=True)
                reasons += failed.otherwise.count(others)
            reasons += failed.reasons.count()
            count += len(rows)
            if held < MOST_KEPT and len(rows):
                numbers.append(start + rows[: MOST_KEPT - held])
                held += len(numbers[-1])
        together = np.concatenate(numbers) if numbers else np.empty(0, np.int64)
        always, none = np.broadcast_to(self._always, self.entries) & (self.seen > 0), Counter[str]()
        if always.size and always.all():
            for _, _, failed in self._chunks:
                assert failed.otherwise is not None
                none += failed.otherwise.count()
        return Failures(
            self.n,
            count,
            dict(reasons.most_common()),
            together,
            self.drawn,
            self.entries,
            int(np.count_nonzero(always)),
            dict(none.most_common()),
        )
