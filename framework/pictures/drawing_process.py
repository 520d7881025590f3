"""A picture drawn by another process, which loads its packages while this one still computes.

Without OpenGL the first rendering kills its process, which no ``try`` catches: here it is not this one.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
from pathlib import Path
from threading import Thread
from typing import Self

from ..view import rendered
from .drawing import Drawing
from .rendering import REMEDY, RenderingError, renders

PROGRAM = f"from {__name__} import serve; serve()"
# What it says when it has rendered something.
READY = b"ready"
# Seconds that a picture may take, some hundred times as long as usual.
PATIENCE = 120.0


class Artist:
    """A process that renders one drawing, and makes itself ready from the beginning.

    As a context manager it ends the process where the picture is not waited for.
    """

    def __init__(self) -> None:
        pipe = subprocess.PIPE
        self._process: subprocess.Popen[bytes] | None
        try:
            self._process = subprocess.Popen(
                [sys.executable, "-P", "-c", PROGRAM], stdin=pipe, stdout=pipe, stderr=pipe
            )
        except OSError:
            self._process = None
        self._name, self._writer, self._said = "", Thread(), (b"", b"")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        if self._process is None or self._process.returncode is not None:
            return
        self._process.kill()
        if self._name:
            self._writer.join()
        else:
            self._process.communicate()

    def draw(self, shown: Drawing, path: Path) -> None:
        """Begin to render.

        Parameters
        ----------
        shown
            The drawing, of which the first pose is rendered.
        path
            Image to write, ``.png`` or ``.jpg``.
        """
        self._name = path.name
        self._writer = Thread(target=self._hand_over, args=(pickle.dumps((shown, path.absolute())),), daemon=True)
        self._writer.start()

    def wait(self) -> None:
        """Wait for the picture.

        Raises
        ------
        RenderingError
            If this machine cannot render; the message says what to install.
        """
        self._writer.join()
        if self._process is not None and self._process.returncode == 0:
            return
        said, complaints = (each.decode(errors="replace").splitlines() for each in self._said)
        why = complaints[-1] if READY.decode() in said and complaints else REMEDY
        raise RenderingError(f"{self._name} was not made: {why}")

    def _hand_over(self, order: bytes) -> None:
        if self._process is None:
            return
        try:
            self._said = self._process.communicate(order, PATIENCE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._said = self._process.communicate()


def serve() -> None:
    """Main function of the other process: render a small test, then the drawing read from its standard input."""
    if not renders():
        raise SystemExit(1)
    print(READY.decode(), flush=True)
    order = sys.stdin.buffer.read()
    if order:
        rendered(*pickle.loads(order))
