"""Work that a copy of this process does beside it, on another processor."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from typing import Generic, Self, TypeVar

from ..propagation.workers import processors

T = TypeVar("T")


class Beside(Generic[T]):
    """Work that a copy of this process begins at once, and whose outcome this one asks for later.

    The copy has what there is when it is made, loaded packages among it, and comes to the same bits. Where none can be
    made, or the copy could not do the work, this process does it when it is asked for the outcome.

    As a context manager it ends the copy where nobody has asked.

    Parameters
    ----------
    work
        What to do. It may write files; what it gives back can be pickled.
    worth
        Whether this process has something to do meanwhile.

    Attributes
    ----------
    copy
        Number of the process that is at work, and where it tells the outcome; None where there is none.
    """

    def __init__(self, work: Callable[[], T], *, worth: bool = True) -> None:
        self._work = work
        self.copy = _begun(work) if worth and copies() else None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self.copy is not None:
            os.kill(self.copy[0], signal.SIGKILL)
            self._told()

    def outcome(self) -> T:
        """Wait for what the work gives back.

        Returns
        -------
        object
            What `work` gives back, or raises.
        """
        told = self._told()
        return pickle.loads(told) if told else self._work()

    def _told(self) -> bytes:
        """What the copy has told when it has ended; nothing where it was not done, or there is none."""
        if self.copy is None:
            return b""
        process, pipe = self.copy
        with open(pipe, "rb", closefd=False) as end:
            told = end.read()
        _, code = os.waitpid(process, 0)
        self.copy = None
        os.close(pipe)
        return b"" if code else told


def copies() -> bool:
    """Whether this process can be copied, and another processor is there to run the copy."""
    alone = threading.active_count() == 1  # what other threads hold, the copy would wait for
    return sys.platform == "linux" and alone and processors() > 1


def _begun(work: Callable[[], object]) -> tuple[int, int] | None:
    """A copy of this process at work: its number, and the end of a pipe that gives what it tells."""
    reading, writing = os.pipe()
    here, code, process = os.getpid(), 1, None
    try:
        with warnings.catch_warnings():
            # The threads that Python may warn of are those of OpenBLAS, which ends them before a copy is made.
            warnings.simplefilter("ignore", DeprecationWarning)
            process = os.fork()
        if not process:
            os.close(reading)
            with open(writing, "wb", closefd=False) as end:
                pickle.dump(work(), end)
            code = 0
    except OSError:  # no room for another process
        process = None
    finally:
        if os.getpid() != here:
            # Whatever happened to it, a copy ends here, without what this process does when it ends.
            os._exit(code)
        os.close(writing)
    if process is None:
        os.close(reading)
        return None
    return process, reading
