"""The description of a linkage: one assembled position, links, joints, drives, springs and loads."""

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
    """Links joined by joints, drawn in one position in which it is assembled.

    Every number may carry a batch; all broadcast.

    Parameters
    ----------
    points
        Coordinates by the name of the point, (..., 2) or (..., 3), length, for names that are no Python identifiers.
    **named
        The same by keyword, (..., 2) or (..., 3).

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
        """Move the drives and let everything follow.

        A pose depends on its own drives and dimensions and on the reference configuration alone, the linkage as it
        was drawn: not on the other poses of the batch, nor on any order. It is what the linkage comes to as its drives
        go there from their reference values on a straight line, all at once. A drive that turns goes the whole way, to
        370° through 360°; where it moves alone and cannot turn fully, it goes round the other way to what lies beyond
        an end of its range. Of a batch of dimensions each member starts from its own reference configuration.

        Where that path ends before, or crosses a singular pose beyond which it could go on in several ways, positions
        are NaN and the status says whether the pose lies in another assembly mode or cannot be assembled at all; a
        path with a bend may reach it. A change point through which the linkage goes on in one smooth way, as a
        parallelogram does, is passed: lengths that are equal to eight digits count as equal there.

        What the drives leave free, such as a rod's spin between two balls, moves as little as it can. A single drive
        may go round any number of times; beyond 1000 radians the angles of other joints come without the whole turns.

        Parameters
        ----------
        drives
            Values of the driven coordinates by joint, (...), or (..., f) where f of a joint are driven, for names
            that are no Python identifiers. A drive without values keeps its reference value.
        rates, accelerations
            First and second time derivatives of these values by joint, (...) or (..., f); 0 where not given. Those of a
            spherical joint are its angular velocity and acceleration, in the joint's axes on the first link.
        branch
            ``"keep"``: through a change point the motion goes on smoothly; ``"switch"``: it takes the other branch.
        tolerance
            Greatest gap, a length, with which a pose counts as assembled; `Motion.gap` tells it. An overconstrained
            linkage drawn with few digits moves only so: where its loops cannot close, each pose has the least gap that
            it can (least squares, angles times the linkage's size). At 0, a pose is closed to rounding.
        other_modes
            Give positions also where the linkage can be assembled in another assembly mode only, to which no path
            leads: of those found that which is most like the reference configuration, open or crossed.
        **named
            Values of the driven coordinates by keyword, (...) or (..., f).

        Returns
        -------
        Motion
            Where everything is, batch shape the broadcast of drives and points.

        Raises
        ------
        FrameError
            If a drive is unknown or given twice, shapes do not broadcast, the linkage is not connected to ground, its
            reference configuration cannot be assembled, its drives leave points free to move, or a stiffness is inf
            where a joint is free.

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
        """Where points go under load with tolerances on the numbers of the linkage, at every pose, in one call.

        Parameters
        ----------
        tolerances
            By the name of a number, as a file of the linkage has it (see `read_linkage`, `write_linkage`), such as
            ``"joints.B.clearance"``, ``"joints.B.stiffness"``, ``"points.C.x"``, ``"loads.0.fy"`` or
            ``"materials.material1.E"``: what `propagate` takes for an input, a deviation such as ``"± 5 %"``,
            ``"± 0.1"`` or ``"+0.2/-0.1"``, or half the width of an interval about the nominal value. By any other name
            a table as in the file, ``{"of": [...], "distribution": "norm", "scale": "5 %"}``, whose numbers share one
            draw.
        points
            Name of the point, or of several.
        drives, rates, accelerations
            As `move` takes them, (poses,), or (poses, f) where f coordinates of a joint are driven.
        branch, tolerance
            As `move` takes them.
        inertia
            Let the inertia forces of the rigid motion act as well.
        n, rng, sampler, progress, nan_policy, workers, checkpoint, replicates
            As `propagate` takes them.
        correlation
            As `propagate` takes it: by pair, a matrix (k, k) of the k tolerances, or a `GaussianCopula`.
        temperatures
            Rise of temperature by link, or of the ``"ground"``, K: what `propagate` takes for an input, called
            ``temperature.NAME`` in the results. The link grows evenly, to first order, and moves the others.
        expansion
            Coefficient of thermal expansion of these links, 1/K, or by link.

        Returns
        -------
        AccuracyStudy
            Mean, standard deviation, worst case and contributors at every pose, the probability of leaving a zone, and
            all of it as a table; in `parts` what geometry, clearance, compliance, load and heat do by themselves.

        Raises
        ------
        FrameError
            If there is no such number, point or drive, a tolerance cannot be meant, the linkage carries a batch, or it
            has parts for which a file has no words.

        Examples
        --------
        The end of an arm of 2 m whose length is good to 0.1 mm, on a pin with 0.2 mm of clearance.

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

        Drives are orange, with an arrow the way in which they go; what stands on the ground is hatched.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on, in space for a linkage in space; new ones where None.
        entry
            Number of the linkage drawn, where the description carries a batch.
        names
            Whether points are named.
        loads
            Whether forces on the linkage are drawn.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            What was drawn on, in the linkage's own lengths.

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
        """Write the linkage to a file that its ending tells: a drawing, or what describes it.

        As ``.toml``, ``.xml`` (MJCF), ``.urdf`` or ``.sdf`` it is what `write_linkage` writes. As ``.dxf`` (extra
        ``dxf``) it is a drawing of the reference configuration for CAD, on layers by the names of the links. Links are
        lines, with the outlines of their sections where they have beams; joints are circles on a layer of
        their kind, with a second circle about drives and a line along slides; points have their names.

        Parameters
        ----------
        path
            The file; it is replaced, and its folder made where it is missing.
        entry
            Number of the linkage drawn, where the description carries a batch.
        unit
            Unit of the coordinates, for the header of a drawing: m, cm, mm, in or ft.

        Raises
        ------
        FrameError
            If the name ends otherwise, there are no points, the unit is unknown, ezdxf is not installed or the folder
            cannot be written; of the other formats as by `write_linkage`.

        Warns
        -----
        ConversionWarning
            If a format has no words for something, which is left out.
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
        """Write a page that opens in a browser, of the linkage at the poses of its drive; see `Motion.page`.

        Parameters
        ----------
        path
            ``name.html``.
        point, link
            The point that is looked at, and the link on which it is taken.
        drives
            Values of the drives by joint, (poses,), or along an axis for each, such as (n, 1) and (m,), so that each
            can be moved by itself. Of a single drive its whole range, a turn in steps of 2°, where None.
        title, command
            Heading, and what made it.
        units
            Units of length and force, for its table.
        **deviations
            Clearances and tolerances beside those of the description, as for `Motion.worst_case`.

        Raises
        ------
        FrameError
            If there are several drives and no values, or as `Motion.page`.

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
        """In a notebook: the drawing."""
        return html_of(self)
