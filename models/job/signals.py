"""Signals that end a job: it unwinds, so that nothing half written stays, and ends with the signal's exit code."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any, Self


class Signals:
    """While a job runs, the first signal to end raises `KeyboardInterrupt` in it, and later ones change nothing.

    Parameters
    ----------
    last
        Whether nothing is left to do behind it but to end the process, so that later signals have nothing to end.

    Attributes
    ----------
    code
        Exit code: 0, or 128 and the signal that came, also where something on the way swallowed the exception.
    """

    PIPE = 13

    def __init__(self, *, last: bool = False) -> None:
        self.code, self.last = 0, last
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            names = ("SIGINT", "SIGTERM", "SIGHUP")
            ends = [getattr(signal, name) for name in names if hasattr(signal, name)]
            # What was ignored before, as by nohup, stays so.
            self._before = {each: signal.getsignal(each) for each in ends if signal.getsignal(each) != signal.SIG_IGN}
            for each in self._before:
                signal.signal(each, self._end)
        return self

    def __exit__(self, *_: object) -> None:
        for each, handler in self._before.items():
            signal.signal(each, signal.SIG_IGN if self.last else handler)

    def _end(self, number: int, _: FrameType | None) -> None:
        if not self.code:
            self.code = 128 + number
            raise KeyboardInterrupt
