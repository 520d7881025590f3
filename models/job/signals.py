"""Signals that end a job: it unwinds, so that no incomplete files remain, and exits with the signal's exit code."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any, Self


class Signals:
    """While a job runs, the first signal to end raises `KeyboardInterrupt` in it; later ones are ignored.

    Parameters
    ----------
    last
        Whether the process only has to exit afterwards, so that later signals are ignored then as well.

    Attributes
    ----------
    code
        Exit code: 0, or 128 plus the number of the signal, even if the exception was caught on the way.
    """

    PIPE = 13

    def __init__(self, *, last: bool = False) -> None:
        self.code, self.last = 0, last
        self._before: dict[signal.Signals, Any] = {}

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            names = ("SIGINT", "SIGTERM", "SIGHUP")
            ends = [getattr(signal, name) for name in names if hasattr(signal, name)]
            # signals that were ignored before, as by nohup, stay ignored
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
