"""Results that write themselves to files."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from numpy.typing import ArrayLike

from ..paraview.export import save
from .base import Results


class SavedResults(Results):
    """Results by name, which files for ParaView are made of."""

    def save(
        self,
        path: str | Path,
        *,
        entry: int | Sequence[int] | None = None,
        axis: int | None = None,
        times: ArrayLike | None = None,
        stations: int = 8,
    ) -> None:
        """Write files for ParaView, whole or not at all; `linkframe.framework.paraview.export` says what they hold.

        Parameters
        ----------
        path
            ``name.vtu`` for one batch entry; ``name.pvd`` for those along a batch axis as a time series, with its
            files in the folder ``name`` beside it. Folders that are missing are made.
        entry
            Indices of the batch entry; for a .pvd those of the other axes. Not needed where these have size 1.
        axis
            For a .pvd, the batch axis that becomes time; not needed where only one is longer than 1.
        times
            For a .pvd, increasing times (or angles) of the entries, (n,); their numbers 0, 1, ... by default.
        stations
            Cells of a member, so that its curved shape shows.

        Raises
        ------
        FrameError
            If the name ends otherwise, the batch does not fit, or the folder cannot be written.
        """
        save(self, path, entry=entry, axis=axis, times=times, stations=stations)
