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

        Examples
        --------
        >>> from pathlib import Path
        >>> from tempfile import TemporaryDirectory
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=[1.0, 2.0])
        >>> with TemporaryDirectory() as folder:
        ...     frame.solve().save(Path(folder) / "rod.pvd")
        ...     sorted(path.name for path in Path(folder).iterdir())
        ['rod', 'rod.pvd']
        """
        save(self, path, entry=entry, axis=axis, times=times, stations=stations)
