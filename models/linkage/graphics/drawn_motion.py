"""Drawing methods of all motions: those of linkages and of four-bars."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from . import bodies, pictures, plots
from .units import GHOSTS, SI, Units

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

    from .places import DrawnPoses


class DrawnMotion(ABC):
    """A motion that can be drawn, in the plane and in space."""

    @abstractmethod
    def _drawn(self) -> DrawnPoses:
        """The motion of a linkage that is to be drawn."""

    def plot(
        self,
        ax: Axes | None = None,
        *,
        pose: int | tuple[int, ...] | None = None,
        trace: str | Sequence[str] = (),
        band: ArrayLike | None = None,
        regions: object = None,
        level: float = 0.95,
        magnify: float | None = None,
        ghosts: int = GHOSTS,
        names: bool = True,
        loads: bool = True,
        units: Units = SI,
    ) -> Axes:
        """Draw one pose, others faintly behind it, and the paths of points; at a dead point its free motion as arrows.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on, in space for a motion in space; new ones if None.
        pose
            Index of the pose; the first that can be assembled if None.
        trace
            Point, or points, whose paths over the longest batch axis are drawn.
        band
            Displacements of the one point traced, lengths, whose envelope is drawn about its path: samples, (poses,
            samples, 2 or more), or a `Spread` of them; or half widths by pose, (poses, 2 or more).
        regions
            Regions to draw about points: a `WorstCase`, or by point a `WorstCase`, a `ReachableRegion`, a covariance of
            its position, (..., 2, 2) or (..., 3, 3), or a `Propagation` or `TaylorMoments` with a covariance.
        level
            Probability with which a normal deviation lies within the ellipse or ellipsoid of a covariance.
        magnify
            Factor on these displacements and regions; a suitable round one if None. The title states it.
        ghosts
            Approximate number of other poses that are drawn; 0 for none.
        names, loads
            Whether points are named, and forces drawn.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, in the linkage's unit of length.

        Raises
        ------
        FrameError
            If no pose is assembled, there is no such pose or point, or the band does not fit the poses.

        Examples
        --------
        >>> import matplotlib; matplotlib.use("Agg")
        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> half = np.full((20, 2), 0.01)
        >>> linkage.move(A=np.linspace(0.0, 1.0, 20)).plot(trace="B", band=half).get_title(loc="left")
        'displacements of B × 5'
        """
        traced = (trace,) if isinstance(trace, str) else tuple(trace)
        return plots.plot_motion(
            self._drawn(), ax, pose, traced, band, regions, level, magnify, ghosts, names, loads, units
        )

    def animate(
        self,
        ax: Axes | None = None,
        *,
        trace: str | Sequence[str] = (),
        interval: float = 50.0,
        names: bool = True,
        units: Units = SI,
    ) -> FuncAnimation:
        """Animate the poses along the longest batch axis.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on, in space for a motion in space; new ones if None.
        trace
            Point, or points, whose paths are drawn.
        interval
            Milliseconds from pose to pose.
        names
            Whether points are named.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.animation.FuncAnimation
            The animation, to be kept in a variable while it is shown: ``.save("motion.gif")``, or ``.to_jshtml()`` in a
            notebook.

        Raises
        ------
        FrameError
            If no pose is assembled, or there is no such point.
        """
        return plots.animate_motion(
            self._drawn(), ax, (trace,) if isinstance(trace, str) else tuple(trace), interval, names, units
        )

    def picture(
        self,
        path: str | Path,
        *,
        pose: int | tuple[int, ...] | None = None,
        regions: object = None,
        level: float = 0.95,
        magnify: float | None = None,
        clearances: float | None = None,
        names: bool = True,
        size: tuple[int, int] = (1600, 1000),
        units: Units = SI,
    ) -> None:
        """Render one pose in space: links with their sections, joints by kind, drives in orange, ground, forces.

        At a dead point violet arrows show the free motion with locked drives.

        ``linkframe.framework.picture`` of ``motion.frame().solve()`` shows the deformed linkage coloured by its stress.

        Parameters
        ----------
        path
            Image to write, ``.png`` or ``.jpg``.
        pose
            Index of the pose; the first that can be assembled if None.
        regions
            Regions to draw about points: a `WorstCase`, or by point a `WorstCase`, a `ReachableRegion`, a covariance of
            its position, (..., 2, 2) or (..., 3, 3), or a `Propagation` or `TaylorMoments` with a covariance.
        level
            Probability with which a normal deviation lies within the ellipse or ellipsoid of a covariance.
        magnify
            Factor on the regions; a suitable round one if None. The caption states it.
        clearances
            Factor on the clearances of the joints, whose bearings are drawn as rings about their journals; a suitable
            round one if None, and 0 for none. The caption states it.
        names
            Whether points are named.
        size
            Width and height in pixels.
        units
            Units of length and force, for the labels.

        Raises
        ------
        RenderingError
            If this machine cannot render; the message says what to install.
        FrameError
            If the name has another ending, there is no such pose, or the folder cannot be written.
        """
        looks = bodies.Looks(regions, level, magnify, clearances, names, units)
        pictures.picture(self._drawn(), path, pose, looks, size)

    def movie(
        self,
        path: str | Path,
        *,
        regions: object = None,
        level: float = 0.95,
        magnify: float | None = None,
        clearances: float | None = None,
        names: bool = False,
        size: tuple[int, int] = (960, 608),
        rate: int = 12,
        units: Units = SI,
    ) -> None:
        """Render the poses along the longest batch axis as a movie, each as by `picture`.

        Parameters
        ----------
        path
            Movie to write, ``.gif`` or ``.mp4``; needs the extra ``movie``.
        regions, level, magnify, clearances
            As for `picture`.
        names
            Whether points are named.
        size
            Width and height in pixels.
        rate
            Poses a second.
        units
            Units of length and force, for the labels.

        Raises
        ------
        RenderingError
            If this machine cannot render or the extra is not installed; the message says what to install.
        FrameError
            If the name has another ending, no pose is assembled, or the folder cannot be written.
        """
        looks = bodies.Looks(regions, level, magnify, clearances, names, units)
        pictures.movie(self._drawn(), path, looks, size, rate)

    def show(
        self,
        *,
        pose: int | tuple[int, ...] | None = None,
        regions: object = None,
        level: float = 0.95,
        magnify: float | None = None,
        clearances: float | None = None,
        names: bool = True,
        units: Units = SI,
    ) -> object:
        """Open a window that shows the motion in space, to rotate and zoom, with a slider for the pose.

        Parameters
        ----------
        pose
            Index of the pose shown first; the first that can be assembled if None.
        regions, level, magnify, clearances
            As for `picture`.
        names
            Whether points are named.
        units
            Units of length and force, for the labels.

        Returns
        -------
        object
            The result of PyVista: in a notebook the view, in a terminal None once the window is closed.

        Raises
        ------
        FrameError
            If no pose is assembled, or there is no such pose.
        """
        return pictures.show(self._drawn(), pose, bodies.Looks(regions, level, magnify, clearances, names, units))
