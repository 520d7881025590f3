"""Work that a copy of this process does beside it, on another processor."""

from __future__ import annotations

import ctypes
import os
import pickle
import signal
import sys
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from typing import Generic, NoReturn, Self, TypeVar

from ...framework.interrupts import put_off
from ..propagation.workers import processors

T = TypeVar("T")
# Signals that ask a process to end, and what Linux calls the request for one when the parent ends.
ENDING, PR_SET_PDEATHSIG = ("SIGINT", "SIGTERM", "SIGHUP"), 1


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
            with suppress(ProcessLookupError):
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
        self.copy = None
        os.close(pipe)
        try:
            _, code = os.waitpid(process, 0)
        except ChildProcessError:  # where signals of ended processes are ignored, nobody knows how this one ended
            return b""
        return b"" if code else told


def copies() -> bool:
    """Whether this process can be copied, and another processor is there to run the copy."""
    alone = threading.active_count() == 1  # what other threads hold, the copy would wait for
    return sys.platform == "linux" and alone and processors() > 1


def _begun(work: Callable[[], object]) -> tuple[int, int] | None:
    """A copy of this process at work: its number, and the end of a pipe that gives what it tells."""
    here = os.getpid()
    try:
        reading, writing = os.pipe()
    except OSError:  # no room for a pipe
        return None
    process = 0
    try:
        # A signal that came between would raise in the copy, too, which then went on as if it were this process.
        with put_off(*ENDING):
            process = _copied()
            if not process:
                _end_by_signals()
    except BaseException as error:
        os.close(reading)
        os.close(writing)
        if process:  # the signal that was put off: nobody would know of the copy, which writes on
            _end(process)
        if isinstance(error, OSError):  # no room for another process
            return None
        raise
    if not process:
        os.close(reading)
        _work_and_end(work, writing, here)
    os.close(writing)
    return process, reading


def _end(process: int) -> None:
    """End a copy, and wait until it has."""
    os.kill(process, signal.SIGKILL)
    with suppress(ChildProcessError):
        os.waitpid(process, 0)


def _copied() -> int:
    """Copy this process; the number of the copy, and 0 in the copy itself."""
    with warnings.catch_warnings():
        # The threads that Python may warn of are those of OpenBLAS, which ends them before a copy is made.
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _end_by_signals() -> None:
    """Have signals end this copy at once: what is to be tidied up is left to the process that it is a copy of."""
    for each in (getattr(signal, name) for name in ENDING):
        if signal.getsignal(each) != signal.SIG_IGN:
            signal.signal(each, signal.SIG_DFL)


def _work_and_end(work: Callable[[], object], writing: int, parent: int) -> NoReturn:
    """Do the work and tell its outcome; whatever happens, do nothing of what a process does when it ends."""
    code = 1
    try:
        # It ends with its parent, even if that is killed: nobody would read what it tells, nor remove what it writes.
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() == parent:
            with open(writing, "wb", closefd=False) as end:
                pickle.dump(work(), end)
            code = 0
    finally:
        os._exit(code)
