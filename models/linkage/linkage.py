"""The linkage: its description in one assembled position, and its methods."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ...framework.errors import FrameError
from ..distributions import Uncertain
from ..propagation.correlation import GaussianCopula, Pairs
from ..propagation.workers import Workers
from ..sampling import Sampler, Seed
from .continuation.drives import by_joint
from .derivatives.thermal import Expansion
from .files.write_linkage import ROBOTS, write
from .graphics.dxf import save_linkage
from .graphics.plots import html_of, plot_linkage
from .graphics.units import SI, Units
from .motion import Motion, limits_of
from .page.grid import GridAxis, unfolded
from .page.page import PageText, write_page
from .range_of_motion import RangeOfMotion, whole_range
from .study.study import AccuracyStudy, driven, study

if TYPE_CHECKING:
    from matplotlib.axes import Axes


class Linkage(RangeOfMotion):
    """Links connected by joints, described in one assembled position, the reference configuration.

    Every number may be an array, a batch; all broadcast.

    Parameters
    ----------
    points
        Coordinates by name of the point, (..., 2) or (..., 3), length, for names that are not Python identifiers.
    **named
        Coordinates of points by keyword, (..., 2) or (..., 3), length.

    Attributes
    ----------
    points
        Coordinates (..., 3) in the reference configuration, by name.
    links
        Links by name; the ground, ``"ground"``, is not among them and has every point.
    joints
        Joints by name.
    drives
        Driven coordinates, such as ``("rz",)``, by joint.
    springs, loads
        Springs, forces and torques in the order given.
    weight
        Acceleration of gravity (..., 3).

    Raises
    ------
    FrameError
        If a point is not two or three finite numbers, or shapes do not broadcast.

    Examples
    --------
    >>> import numpy as np
    >>> linkage = Linkage(A=(0, 0), B=(0, 2), C=(7, 4), D=(6, 0), P=(4, 5))
    >>> linkage.link("crank", "A", "B")
    >>> linkage.link("coupler", "B", "P", "C")
    >>> linkage.link("rocker", "C", "D")
    >>> linkage.revolute("A", "ground", "crank", drive=True)
    >>> linkage.revolute("B", "crank", "coupler")
    >>> linkage.revolute("C", "coupler", "rocker")
    >>> linkage.revolute("D", "rocker", "ground")
    >>> motion = linkage.move(A=np.radians([0.0, 10.0, 20.0]))
    >>> motion.position("P").shape
    (3, 3)
    """

    def move(
        self,
        drives: Mapping[str, ArrayLike] | None = None,
        /,
        *,
        rates: Mapping[str, ArrayLike] | None = None,
        accelerations: Mapping[str, ArrayLike] | None = None,
        branch: str = "keep",
        tolerance: float = 0.0,
        other_modes: bool = False,
        **named: ArrayLike,
    ) -> Motion:
        """Compute the motion of the linkage at given values of its drives.

        A pose depends only on its own drives and dimensions and on the reference configuration, not on other poses of
        the batch or on their order. It is the pose that the linkage reaches when its drives move from their reference
        values there along a straight line, all at once. A drive that turns goes all the way, to 370° through 360°; a
        single drive that cannot make full turns goes the other way round to values beyond an end of its range. In a
        batch of dimensions each linkage starts from its own reference configuration.

        If that path ends before, or crosses a singular pose beyond which several motions are possible, positions are
        NaN, and the status says whether the pose lies in another assembly mode or cannot be assembled at all; a path
        with a bend may reach it. A change point with one smooth continuation, as in a parallelogram, is passed: lengths
        that are equal to eight digits count as equal there.

        Idle motions that the drives leave free, such as the spin of a rod between two spherical joints, are as small as
        possible. A single drive may make any number of turns; beyond 1000 radians the angles of other joints do not
        include whole turns.

        Parameters
        ----------
        drives
            Values of the driven coordinates by joint, (...), or (..., f) if f coordinates of a joint are driven, for
            names that are not Python identifiers. A drive without values keeps its reference value.
        rates, accelerations
            First and second time derivatives of these values by joint, (...) or (..., f); 0 by default. Those of a
            spherical joint are its angular velocity and acceleration, in the joint's axes on the first link.
        branch
            ``"keep"``: the motion continues smoothly through a change point; ``"switch"``: it takes the other branch.
        tolerance
            Largest gap of an assembled pose, a length; `Motion.gap` returns the gaps. An overconstrained linkage given
            with few digits needs such a tolerance: if its loops cannot close, each pose has the least possible gap
            (least squares, angles times the linkage's size). At 0, loops are closed to rounding.
        other_modes
            Whether to give positions also at poses that can be assembled in another assembly mode only, to which no
            path leads: out of those found, the one most similar to the reference configuration, open or crossed.
        **named
            Values of the driven coordinates by keyword, (...) or (..., f).

        Returns
        -------
        Motion
            The motion; its batch shape is the broadcast of drives and points.

        Raises
        ------
        FrameError
            If a drive is unknown or given twice, shapes do not broadcast, the linkage is not connected to ground, its
            reference configuration cannot be assembled, its drives leave points free to move, the stiffness of a free
            coordinate is inf, or the rates of more drives than there are degrees of freedom differ by a thousandth.

        Examples
        --------
        The piston of a slider-crank, ``x = r cos(t) + sqrt(l^2 - r^2 sin(t)^2)`` (Norton, *Design of Machinery*,
        section 13.2).

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(4, 0))
        >>> linkage.link("crank", "A", "B"); linkage.link("rod", "B", "C"); linkage.link("piston", "C")
        >>> linkage.revolute("A", "ground", "crank", drive=True)
        >>> linkage.revolute("B", "crank", "rod"); linkage.revolute("C", "rod", "piston")
        >>> linkage.prismatic("C", "ground", "piston", axis=(1, 0), name="slide")
        >>> t = np.radians([0.0, 60.0, 120.0])
        >>> motion = linkage.move(A=t)
        >>> bool(abs(motion.position("C")[:, 0] - np.cos(t) - np.sqrt(9.0 - np.sin(t)**2)).max() < 1e-14)
        True
        """
        given, first, second = by_joint(drives=drives, rates=rates, accelerations=accelerations)
        for name in named.keys() & given.keys():
            raise FrameError(f"joint {name!r} is given twice, by keyword and in the mapping: give it once")
        return Motion.of(self, {**given, **named}, first, second, branch, tolerance, other_modes)

    def study(
        self,
        tolerances: Mapping[str, Any],
        points: str | Sequence[str],
        drives: Mapping[str, ArrayLike] | None = None,
        *,
        rates: Mapping[str, ArrayLike] | None = None,
        accelerations: Mapping[str, ArrayLike] | None = None,
        branch: str = "keep",
        tolerance: float = 0.0,
        inertia: bool = False,
        n: int = 1000,
        rng: Seed = None,
        sampler: Sampler = "random",
        progress: bool = True,
        nan_policy: str = "omit",
        workers: Workers = 1,
        checkpoint: str | os.PathLike[str] | None = None,
        replicates: int = 1,
        correlation: GaussianCopula | Pairs | ArrayLike | None = None,
        temperatures: Mapping[str, Uncertain] | None = None,
        expansion: Expansion | None = None,
    ) -> AccuracyStudy:
        """Study the displacements of points under load with tolerances on the linkage's numbers, at every pose.

        Parameters
        ----------
        tolerances
            By name of a number, as in a file of the linkage (see `read_linkage`, `write_linkage`), such as
            ``"joints.B.clearance"``, ``"joints.B.stiffness"``, ``"points.C.x"``, ``"loads.0.fy"`` or
            ``"materials.material1.E"``: an input as for `propagate`, a deviation such as ``"± 5 %"``, ``"± 0.1"`` or
            ``"+0.2/-0.1"``, or the half width of an interval about the nominal value. By any other name: a table as in
            the file, ``{"of": [...], "distribution": "norm", "scale": "5 %"}``, whose numbers share one draw.
        points
            Name of the point, or of several.
        drives, rates, accelerations
            As for `move`, (poses,), or (poses, f) if f coordinates of a joint are driven.
        branch, tolerance
            As for `move`.
        inertia
            Whether the inertia forces of the rigid motion act as well.
        n, rng, sampler, progress, nan_policy, workers, checkpoint, replicates
            As for `propagate`.
        correlation
            As for `propagate`: by pair, a matrix (k, k) of the k tolerances, or a `GaussianCopula`.
        temperatures
            Rise of temperature by link, or of the ``"ground"``, K: inputs as for `propagate`, called
            ``temperature.NAME`` in the results. The link expands uniformly, to first order, and moves the others.
        expansion
            Coefficient of thermal expansion of these links, 1/K, or by link.

        Returns
        -------
        AccuracyStudy
            Mean, standard deviation, worst case and contributors at every pose, the probability of leaving a zone, and
            all of it as a table; its `parts` have the effects of geometry, clearance, compliance, load and temperature.

        Raises
        ------
        FrameError
            If there is no such number, point or drive, a tolerance cannot be meant, the linkage has a batch, or a file
            cannot describe it.

        Examples
        --------
        The end of an arm of 2 m with a length tolerance of 0.1 mm, on a pin with 0.2 mm of clearance.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=2e-4, contact=0.0)
        >>> found = linkage.study({"points.B.x": "± 0.0001"}, "B", {"A": [0.0, 1.0]}, n=64, rng=0, sampler="sobol")
        >>> found.greatest.round(9).tolist(), found.probability(3e-4).round(9).tolist()
        ([[0.0003, 0.0003]], [[0.0, 0.0]])
        """
        poses = driven(drives, rates, accelerations, branch, tolerance)
        return study(
            self, tolerances, points, poses, inertia=inertia, n=n, rng=rng, sampler=sampler, progress=progress,
            nan_policy=nan_policy, correlation=correlation, workers=workers, checkpoint=checkpoint,
            temperatures=temperatures, expansion=expansion, replicates=replicates,
        )  # fmt: skip

    # -- to look at -------------------------------------------------------------------------------------------------

    def plot(
        self, ax: Axes | None = None, *, entry: int = 0, names: bool = True, loads: bool = True, units: Units = SI
    ) -> Axes:
        """Draw the reference configuration: links, joints by their kind, ground, drives, springs, forces and names.

        Drives are orange, with an arrow in their positive direction; the ground is hatched.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on, in space for a linkage in space; new ones if None.
        entry
            Number of the linkage drawn, if the description has a batch.
        names
            Whether points are named.
        loads
            Whether forces on the linkage are drawn.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            The axes, in the linkage's unit of length.

        Raises
        ------
        FrameError
            If there are no points, or a linkage in space is to be drawn on flat axes.

        Examples
        --------
        >>> import matplotlib; matplotlib.use("Agg")
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.plot().get_xlabel()
        'x [m]'
        """
        return plot_linkage(self, ax, entry, names, loads, units)

    def save(self, path: str | Path, *, entry: int = 0, unit: str = "m") -> None:
        """Write the linkage to a file, a description or a drawing by the file's ending.

        For ``.toml``, ``.xml`` (MJCF), ``.urdf`` and ``.sdf`` see `write_linkage`. A ``.dxf`` file (extra ``dxf``) is a
        drawing of the reference configuration for CAD, with a layer for each link. Links are lines, with the outlines
        of the sections of their beams; joints are circles on a layer of their kind, with a second circle about drives
        and a line along slides; points have their names.

        Parameters
        ----------
        path
            The file; it is replaced, and its folder made if it is missing.
        entry
            Number of the linkage drawn, if the description has a batch.
        unit
            Unit of the coordinates, for the header of a drawing: m, cm, mm, in or ft.

        Raises
        ------
        FrameError
            If the name has another ending, there are no points, the unit is unknown, ezdxf is not installed or the
            folder cannot be written; for the other formats as for `write_linkage`.

        Warns
        -----
        ConversionWarning
            If a format cannot describe something, which is left out.
        """
        path = Path(path)
        if path.suffix.lower() == ".dxf":
            save_linkage(self, path, entry, unit)
        elif path.suffix.lower() in (".toml", *ROBOTS):
            write(self, path, 2)
        else:
            raise FrameError(
                f"{path.name} does not tell by its ending how to save a linkage: choose .toml, .xml (MJCF), .urdf or "
                ".sdf, or .dxf for a drawing"
            )

    def page(
        self,
        path: str | Path,
        point: str,
        link: str | None = None,
        *,
        drives: Mapping[str, ArrayLike] | None = None,
        title: str = "",
        command: str = "",
        units: Units = SI,
        **deviations: Any,
    ) -> None:
        """Write a page for a browser, of the linkage at the poses of its drives; see `Motion.page`.

        Parameters
        ----------
        path
            Page to write, ``name.html``.
        point, link
            The point that the page is about, and the link on which it lies.
        drives
            Values of the drives by joint, (poses,), or along an axis for each, such as (n, 1) and (m,), so that each
            can be moved separately. If None, the whole range of a single drive, in steps of 2° for a full turn.
        title, command
            Heading, and the command that made the page.
        units
            Units of length and force, for its table.
        **deviations
            Clearances and tolerances in addition to those of the description, as for `Motion.worst_case`.

        Raises
        ------
        FrameError
            If there are several drives and no values, or as for `Motion.page`.

        Examples
        --------
        >>> from tempfile import TemporaryDirectory
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
        >>> with TemporaryDirectory() as folder:
        ...     linkage.page(f"{folder}/arm.html", "B")
        """
        values = whole_range(self) if drives is None else drives
        motion = self.move(values)
        grid: tuple[GridAxis, ...] = ()
        if len(motion.shape) > 1 and not self.shape:
            values, grid = unfolded(self, values, motion.shape)
            motion = self.move(values)
        worst = limits_of(motion, point, link, deviations)
        write_page(motion, path, point, link, worst, PageText(title, command, units), grid=grid)

    def _repr_html_(self) -> str:
        """Drawing for a notebook."""
        return html_of(self)
