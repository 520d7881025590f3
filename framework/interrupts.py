"""Signals (interrupts and termination) deferred during a critical section."""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager


@contextmanager
def put_off(*names: str) -> Iterator[None]:
    """Defer these signals, such as ``"SIGINT"``, until the body is done, if the system can.

    A process that is started meanwhile begins without them.
    """
    numbers = [getattr(signal, name) for name in names if hasattr(signal, name)]
    heard: list[int] = []
    with ExitStack() as after:
        after.callback(_answer, heard)
        if hasattr(signal, "pthread_sigmask"):
            after.callback(
                signal.pthread_sigmask, signal.SIG_SETMASK, signal.pthread_sigmask(signal.SIG_BLOCK, numbers)
            )
        # A signal blocked in this thread is delivered to another, such as one of a linear algebra library.
        if threading.current_thread() is threading.main_thread():
            for number in numbers:
                _note(number, heard, after)
        yield


def _note(number: int, heard: list[int], after: ExitStack) -> None:
    """Only note a signal, until `after` is closed; one that is ignored, or not Python's, is left alone."""
    answer = signal.getsignal(number)
    if answer is None or answer == signal.SIG_IGN:
        return

    def note(signum: int, _frame: object) -> None:
        heard.append(signum)

    def restore() -> None:
        if signal.getsignal(number) is note:  # the body may have said what is to be done from now on
            signal.signal(number, answer)

    after.callback(restore)
    signal.signal(number, note)


def _answer(heard: list[int]) -> None:
    for number in dict.fromkeys(heard):
        signal.raise_signal(number)
