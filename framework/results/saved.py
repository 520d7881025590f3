"""Results with the methods that save, tabulate and plot them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ..graphics import plots
from ..paraview.export import save
from .base import Results
from .tabulated import to_dataframe, to_xarray

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class SavedResults(Results):
    """Results by name that can be saved for ParaView, tabulated and plotted."""

    def save(
        self,
        path: str | Path,
        *,
        entry: int | Sequence[int] | None = None,
        axis: int | None = None,
        times: ArrayLike | None = None,
        stations: int = 8,
    ) -> None:
        """Write files for ParaView, completely or not at all; `linkframe.framework.paraview.export` lists them.

        Parameters
        ----------
        path
            ``name.vtu`` for one batch entry; ``name.pvd`` for those along a batch axis as a time series, with its
            files in the folder ``name`` beside it. Missing folders are created.
        entry
            Indices of the batch entry; for a .pvd those of the other axes. Not needed where these have size 1.
        axis
            For a .pvd, the batch axis that becomes time; not needed where only one is longer than 1.
        times
            For a .pvd, increasing times (or angles) of the entries, (n,); their indices 0, 1, ... by default.
        stations
            Number of cells into which each member is divided, to show its curved shape.

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
        """Put displacements into a table, with one row for each batch entry and node.

        Returns
        -------
        pandas.DataFrame
            A column of indices for each batch axis, by the names of ``Frame(axes=...)``; columns ``node``,
            ``ux uy uz rx ry rz``, length and radians, and ``status``.

        Raises
        ------
        FrameError
            If pandas is not installed.
        """
        return to_dataframe(self)

    def to_xarray(self) -> Any:
        """Put results into a data set with named dimensions: the batch axes by ``Frame(axes=("pose", "sample"))``.

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
        """Draw one entry: the deformed frame, its stress, or the diagram of an internal force along its members.

        A frame that lies, and is displaced, in a coordinate plane is drawn in that plane. Diagrams are drawn
        perpendicular to members, bending moments on the side in tension. In a plane numbers have signs (moments
        positive about the plane's normal, shear towards the left of the member); in space they are magnitudes.

        Parameters
        ----------
        what
            ``deformed``, ``von_mises``, or ``N``, ``V``, ``T``, ``M``.
        ax
            Axes of matplotlib to draw on, three-dimensional for a frame in space; new ones where None.
        entry
            Indices of the batch entry; not needed if the batch has a single one.
        scale
            Factor on the displacements; a suitable round one where None. It is given above the figure.
        names
            Whether to label nodes with their names.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            The axes drawn on, in the frame's unit of length.

        Raises
        ------
        FrameError
            If `what` is unknown, or the frame has no member or no such entry.

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
        return plots.plot_solution(self, ax, what, entry, scale, names, units)
