"""Chunks in their order, whoever computes them and however many are on disk already."""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from ...framework.errors import FrameError
from .checkpoint import Checkpoint

# A range of samples, and where there are samples of several kinds whose they are: the first and behind the last of
# them, and a name.
Cut = tuple[Any, ...]
C = TypeVar("C", bound=Cut)
R = TypeVar("R")
# Those of who takes chunks and gives none.
CT = TypeVar("CT", bound=Cut, contravariant=True)
RT = TypeVar("RT", contravariant=True)


@dataclass(frozen=True, eq=False)
class StoredChunks(Generic[R]):
    """The chunks of a run on disk.

    Parameters
    ----------
    checkpoint
        Their folder.
    packed, unpacked
        What makes bytes of the results of a chunk, and results of these bytes.
    """

    checkpoint: Checkpoint
    packed: Callable[[R], bytes]
    unpacked: Callable[[bytes], R]

    def load(self, cut: Cut) -> R:
        """Results of a chunk that was stored."""
        return self.unpacked(self.checkpoint.load(cut))

    def store(self, cut: Cut, found: R) -> None:
        """Write the results of a chunk, all of it or nothing."""
        self.checkpoint.store(cut, self.packed(found))


class Receiver(Protocol[CT, RT]):
    """Who puts chunks together."""

    def expect(self, cut: CT, /) -> None:
        """Be told that the next chunk is waited for, which is not stored."""

    def add(self, cut: CT, found: RT, /) -> None:
        """Take the next chunk in their order."""

    def progress(self, done: int, of: int, /) -> str:
        """Tell who interrupts the run how many chunks are done, and how to go on."""


def gather(
    ranges: Sequence[C],
    compute: Callable[[list[C]], Generator[tuple[C, R], None, None]],
    receiver: Receiver[C, R],
    folder: StoredChunks[R] | None,
    stored: set[Cut],
) -> None:
    """Have chunks computed, store each as soon as it is done, and hand them on in their order.

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
        Which of them are there.

    Raises
    ------
    FrameError
        If a chunk cannot be computed or written; with the number of chunks that are stored, as an interrupt has it.
    """
    waiting = [cut for cut in ranges if cut not in stored]
    done = len(ranges) - len(waiting)
    missing = set(waiting)
    ahead: dict[C, R] = {}
    with closing(compute(waiting)) as parts:
        try:
            for cut in ranges:
                if cut not in missing:
                    assert folder is not None
                    receiver.add(cut, folder.load(cut))
                    continue
                receiver.expect(cut)
                while cut not in ahead:
                    of, found = next(parts)
                    if folder is not None:
                        folder.store(of, found)
                    done += 1
                    ahead[of] = found
                receiver.add(cut, ahead.pop(cut))
            _end(parts)
        except KeyboardInterrupt as interrupt:
            interrupt.add_note(receiver.progress(done, len(ranges)))
            raise
        except FrameError as error:
            if folder is not None and done:
                error.add_note(receiver.progress(done, len(ranges)))
            raise


def _end(parts: Iterator[object]) -> None:
    """Let the workers end in peace."""
    next(parts, None)
