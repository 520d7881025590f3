"""Results that write themselves to files, and draw themselves."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ..paraview.export import save
from .base import Results
from .tabulated import to_dataframe, to_xarray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class SavedResults(Results):
    """Results by name, which files for ParaView and figures are made of."""

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

    def to_dataframe(self) -> Any:
        """Put displacements into a table, one row a batch entry and node.

        Returns
        -------
        pandas.DataFrame
            A column with the numbers of the entries for each batch axis, by the names of ``Frame(axes=...)``; ``node``,
            ``ux uy uz rx ry rz``, length and radians, and ``status``.

        Raises
        ------
        FrameError
            If pandas is not installed.
        """
        return to_dataframe(self)

    def to_xarray(self) -> Any:
        """Name the dimensions of the results: the batch axes as ``Frame(axes=("pose", "sample"))`` has them.

        Returns
        -------
        xarray.Dataset
            ``displacement`` by node and component, ``reaction`` by support and force, ``joint_displacement`` and
            ``joint_force`` by joint, and ``status``.

        Raises
        ------
        FrameError
            If xarray is not installed.
        """
        return to_xarray(self)

    def plot(
        self,
        what: str = "deformed",
        ax: Axes | None = None,
        *,
        entry: int | tuple[int, ...] | None = None,
        scale: float | None = None,
        names: bool = True,
        units: tuple[str, str] = ("m", "N"),
    ) -> Axes:
        """Draw one entry: the deformed frame, its stress, or the diagram of a section force along its members.

        What lies, and is displaced, in a coordinate plane is drawn in it. Diagrams stand across their members, bending
        moments on the side in tension; in a plane numbers have their signs (moments positive about the plane's normal,
        shear towards the left of the member), in space they are sizes.

        Parameters
        ----------
        what
            ``deformed``, ``von_mises``, or ``N``, ``V``, ``T``, ``M``.
        ax
            Axes of matplotlib to draw on, in space for a frame in space; new ones where None.
        entry
            Indices of the batch entry; not needed where the batch holds one.
        scale
            Factor on the displacements; a round one that shows them where None. It stands above the figure.
        names
            Whether nodes are named.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            What was drawn on, in the frame's own lengths.

        Raises
        ------
        FrameError
            If there is nothing of that name, no member, or no such entry.

        Examples
        --------
        >>> import matplotlib; matplotlib.use("Agg")
        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.framework import Frame
        >>> frame = Frame()
        >>> for name, x in {"A": 0.0, "B": 1.0}.items():
        ...     frame.node(name, (x, 0.0, 0.0))
        >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
        >>> frame.fix("A"); frame.load("B", fy=-10.0)
        >>> frame.solve().plot("M").get_title(loc="left")
        'bending moment M [N m], on the side in tension'
        """
        from ..graphics.plots import plot_solution  # with all that draws, which most solutions never need

        return plot_solution(self, ax, what, entry, scale, names, units)
