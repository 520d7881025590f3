"""Chunks in the order of their samples, whoever computes them and whichever are already on disk."""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterator, Mapping, Sequence
from contextlib import closing, suppress
from time import monotonic
from typing import TYPE_CHECKING, Any, Generic, Protocol, TypeVar

from ...framework.errors import FrameError

if TYPE_CHECKING:
    from .checkpoint import Checkpoint

# A range of samples, its first and the one after its last, and the name of their kind if there are several.
Cut = tuple[Any, ...]
C = TypeVar("C", bound=Cut)
R = TypeVar("R")
# Types of the chunks and results that a receiver takes.
CT = TypeVar("CT", bound=Cut, contravariant=True)
RT = TypeVar("RT", contravariant=True)
# Seconds of work on short chunks, stored several at a time, that may be lost if a run is killed.
PAUSE = 0.25


def one_by_one(waiting: Sequence[tuple[Cut, R]]) -> list[tuple[Sequence[Cut], R]]:
    """Chunks each of which has its own file."""
    return [([cut], found) for cut, found in waiting]


class StoredChunks(Generic[R]):
    """The chunks of a run on disk.

    Parameters
    ----------
    checkpoint
        Their folder.
    packed, unpacked
        What makes pieces of bytes of the results of a chunk, and results of all these bytes.
    joined
        What makes one result of those of neighbouring chunks that wait, to be stored in one file, where it can: a file
        costs as much as the statistics of a short chunk.
    pause
        Seconds for which chunks that are done may wait for others, where they take less than that on average: to write
        each for itself, behind a short calculation that has emptied the processor's caches, takes three times as long.

    Attributes
    ----------
    written
        How many chunks were written.
    """

    def __init__(
        self,
        checkpoint: Checkpoint,
        packed: Callable[[R], Sequence[bytes | memoryview]],
        unpacked: Callable[[bytes], R],
        joined: Callable[[Sequence[tuple[Cut, R]]], list[tuple[Sequence[Cut], R]]] = one_by_one,
        pause: float = PAUSE,
    ) -> None:
        self.checkpoint, self.packed, self.unpacked, self.joined = checkpoint, packed, unpacked, joined
        self.pause = pause
        self.written = 0
        self._waiting: list[tuple[Cut, R]] = []
        self._begun = self._last = monotonic()
        self._done = 0

    def load(self, cut: Cut) -> R:
        """Results of a chunk that was stored."""
        return self.unpacked(self.checkpoint.load(cut))

    def store(self, cut: Cut, found: R) -> None:
        """Write the results of a chunk completely or not at all, now or together with the next ones."""
        self._waiting.append((cut, found))
        self._done += 1
        now = monotonic()
        # long chunks of several workers arrive together and the next ones much later, so none waits
        if now - self._last >= self.pause or now - self._begun >= self.pause * self._done:
            self.flush()

    def flush(self) -> None:
        """Write the chunks that are waiting."""
        for cuts, found in self.joined(self._waiting):
            self.checkpoint.store((cuts[0][0], *cuts[-1][1:]), self.packed(found))
            del self._waiting[: len(cuts)]
            self.written += len(cuts)
        self._last = monotonic()


def covered(ranges: Sequence[C], stored: Collection[Cut]) -> dict[C, Cut | None]:
    """Which chunks are stored, alone or several in one file.

    Parameters
    ----------
    ranges
        All chunks, in their order.
    stored
        Ranges of the files that are there.

    Returns
    -------
    dict
        By chunk, the file that begins with it; None for the others in a file.
    """
    first = {(cut[0], *cut[2:]): k for k, cut in enumerate(ranges)}
    last = {cut[1:]: k for k, cut in enumerate(ranges)}
    found: dict[C, Cut | None] = {}
    for file in sorted(stored, key=lambda file: (file[0], -file[1])):
        begin, end = first.get((file[0], *file[2:])), last.get(file[1:])
        if begin is None or end is None or end < begin:
            continue
        cuts = [cut for cut in ranges[begin : end + 1] if cut[2:] == file[2:]]
        if found.keys().isdisjoint(cuts):
            found |= dict.fromkeys(cuts)
            found[cuts[0]] = file
    return found


class Receiver(Protocol[CT, RT]):
    """Receiver of chunks in their order."""

    def expect(self, cut: CT, /) -> None:
        """Called before a chunk that is not stored is waited for."""

    def add(self, cut: CT, found: RT, /) -> None:
        """Take the next chunk in order."""

    def progress(self, done: int, of: int, /) -> str:
        """Add to an interrupt how many chunks are done, and how to continue."""


def gather(
    ranges: Sequence[C],
    compute: Callable[[list[C]], Generator[tuple[C, R], None, None]],
    receiver: Receiver[C, R],
    folder: StoredChunks[R] | None,
    stored: Mapping[C, Cut | None],
) -> None:
    """Have chunks computed, store those that are done, and hand them on in their order.

    Parameters
    ----------
    ranges
        All chunks.
    compute
        Computes some of them, in whatever order they are done.
    receiver
        Gets each, and those that are stored as well.
    folder
        Where chunks are stored; None where they are not.
    stored
        Which of them are there, see `covered`.

    Raises
    ------
    FrameError
        If a chunk cannot be computed or written; with the number of chunks that are stored, as an interrupt has it.
    """
    waiting = [cut for cut in ranges if cut not in stored]
    missing = set(waiting)
    computed = 0
    ahead: dict[C, R] = {}
    with closing(compute(waiting)) as parts:
        try:
            for cut in ranges:
                if cut not in missing:
                    file = stored[cut]
                    if file is not None:
                        assert folder is not None
                        receiver.add(cut, folder.load(file))
                    continue
                receiver.expect(cut)
                while cut not in ahead:
                    of, found = next(parts)
                    computed += 1
                    if folder is not None:
                        folder.store(of, found)
                    ahead[of] = found
                receiver.add(cut, ahead.pop(cut))
            _end(parts)
            if folder is not None:
                folder.flush()
        except BaseException as error:
            done = len(ranges) - len(waiting) + computed
            if folder is not None:
                with suppress(FrameError):  # where there is no room, there is none for these either
                    folder.flush()
                done = done + folder.written - computed if folder.checkpoint.is_there else 0
            told = folder is not None and done and isinstance(error, FrameError)
            if told or isinstance(error, KeyboardInterrupt):
                error.add_note(receiver.progress(done, len(ranges)))
            raise


def _end(parts: Iterator[object]) -> None:
    """Let the workers finish what they are doing."""
    next(parts, None)
