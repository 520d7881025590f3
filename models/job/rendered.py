"""The picture in space, if it is asked for and the machine can render it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from ...framework.paraview import entries
from ...framework.pictures import drawing, drawing_process, rendering

if TYPE_CHECKING:
    from ...framework.paraview.entries import Entry
    from ...framework.pictures.drawing_process import Artist
    from ...framework.solution import Solution


class Picture:
    """The picture in space of a job; made by `picture`.

    Parameters
    ----------
    artist
        The process that renders it; None if it is not asked for.
    """

    def __init__(self, artist: Artist | None) -> None:
        self._artist, self._begun = artist, False

    def begin(self, solution: Solution, path: Path, entry: Entry) -> None:
        """Start drawing a solved frame."""
        if self._artist is not None:
            self._begun = True
            at = entries.one(solution.shape, entry, path.name)
            self._artist.draw(drawing.drawing(solution, at, None, "von_mises"), path)

    def wait(self) -> list[str]:
        """Wait until it is drawn; returns a note if that is not possible."""
        if self._artist is None or not self._begun:
            return []
        try:
            self._artist.wait()
        except rendering.RenderingError as error:
            return [f"Without the 3-D picture: {error}."]
        return []


@contextmanager
def picture(wanted: bool) -> Iterator[Picture]:
    """The picture in space; its process starts while the job computes the frame that it shows."""
    if not wanted:
        yield Picture(None)
        return
    with drawing_process.Artist() as artist:
        yield Picture(artist)
