"""Work that a copy of this process does in parallel, on another processor."""

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
# Signals that ask a process to end, and Linux's option of prctl for a signal when the parent ends.
ENDING, PR_SET_PDEATHSIG = ("SIGINT", "SIGTERM", "SIGHUP"), 1


class Beside(Generic[T]):
    """Work that a copy of this process starts at once, and whose outcome this process asks for later.

    The copy has the state of this process when it is made, with its loaded packages, and computes the same bits. If no
    copy can be made, or it fails, this process does the work when it is asked for the outcome.

    As a context manager it ends the copy if the outcome was not asked for.

    Parameters
    ----------
    work
        Function that does the work. It may write files; its result must be picklable.
    worth
        Whether this process has something to do meanwhile.

    Attributes
    ----------
    copy
        Process number of the copy, and the pipe with its outcome; None if there is no copy.
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
        """Wait for the outcome of the work.

        Returns
        -------
        object
            Result of `work`; its exceptions are raised.
        """
        told = self._told()
        return pickle.loads(told) if told else self._work()

    def _told(self) -> bytes:
        """Pickled outcome of the copy, after it has ended; empty if it failed or there is no copy."""
        if self.copy is None:
            return b""
        process, pipe = self.copy
        with open(pipe, "rb", closefd=False) as end:
            told = end.read()
        self.copy = None
        os.close(pipe)
        try:
            _, code = os.waitpid(process, 0)
        except ChildProcessError:  # signals of ended processes are ignored, so that its exit code is lost
            return b""
        return b"" if code else told


def copies() -> bool:
    """Whether this process can be copied, and there is another processor to run the copy."""
    alone = threading.active_count() == 1  # the copy would wait for locks of other threads
    return sys.platform == "linux" and alone and processors() > 1


def _begun(work: Callable[[], object]) -> tuple[int, int] | None:
    """Start a copy of this process with the work: its process number, and the pipe with its outcome."""
    here = os.getpid()
    try:
        reading, writing = os.pipe()
    except OSError:  # no room for a pipe
        return None
    process = 0
    try:
        # a signal in between would raise in the copy as well, which would then continue as if it were this process
        with put_off(*ENDING):
            process = _copied()
            if not process:
                _end_by_signals()
    except BaseException as error:
        os.close(reading)
        os.close(writing)
        if process:  # a deferred signal: the copy must not continue unknown to anybody
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
    """Copy this process; returns the process number of the copy, and 0 in the copy itself."""
    with warnings.catch_warnings():
        # the threads that Python may warn of are those of OpenBLAS, which ends them before a copy is made
        warnings.simplefilter("ignore", DeprecationWarning)
        return os.fork()


def _end_by_signals() -> None:
    """Let signals end this copy at once: tidying up is left to the original process."""
    for each in (getattr(signal, name) for name in ENDING):
        if signal.getsignal(each) != signal.SIG_IGN:
            signal.signal(each, signal.SIG_DFL)


def _work_and_end(work: Callable[[], object], writing: int, parent: int) -> NoReturn:
    """Do the work, send its outcome and exit, in any case without the exit handlers of a process."""
    code = 1
    try:
        # end with the parent, even if that is killed: nobody would read the outcome or remove the files
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() == parent:
            with open(writing, "wb", closefd=False) as end:
                pickle.dump(work(), end)
            code = 0
    finally:
        os._exit(code)
