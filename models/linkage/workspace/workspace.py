"""A grid of places of a point, the poses that reach them, and stiffness, condition and drive effort there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.batch import Array, finite
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import unit_vector
from ..graphics.units import SI, Units
from ..motion import Motion
from ..poses.assembled_poses import OTHER_MODE
from .inverse import InverseKinematics
from .maps import plot_map
from .neighbours import everywhere

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Bools = NDArray[np.bool_]
OUT_OF_REACH = "not assembled: the point cannot be there"


@dataclass(frozen=True, eq=False, repr=False)
class Workspace:
    """Places of a point on a grid, and the linkage's properties there; made by `Linkage.workspace`.

    Attributes
    ----------
    motion
        The poses that reach a place, in the order of the grid, row by row, (poses,).
    point
        Name of the point.
    axes
        The two global axes along which the grid lies: 0, 1, 2 for x, y, z.
    grid
        Coordinates along them, (columns,) and (rows,).
    place
        Position of the grid along the third axis, and the reference position along the others, (3,).
    reached
        Which places are reached, (rows, columns).
    elsewhere
        Which of the others the point can reach in another assembly mode only, (rows, columns): beyond singular poses,
        or where a straight path of the drives from the reference configuration ends elsewhere, as far as was found.
    """

    motion: Motion
    point: str
    axes: tuple[int, int]
    grid: tuple[Array, Array]
    place: Array
    reached: Bools
    elsewhere: Bools
    _solver: InverseKinematics

    def __repr__(self) -> str:
        rows, columns = self.reached.shape
        return f"<Workspace of {self.point}: {np.count_nonzero(self.reached)} of {rows} × {columns} places reached>"

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """Status of the pose at each place, (rows, columns); see `Motion.status`."""
        out = np.where(self.elsewhere, OTHER_MODE, OUT_OF_REACH).astype("<U200")
        out[self.reached] = self.motion.status
        return out

    @cached_property
    def drives(self) -> dict[str, Array]:
        """Drive values by joint, (rows, columns), or (rows, columns, f); NaN where the place is not reached."""
        found = {name: self.motion.coordinate(name) for name in self.motion.linkage.drives}
        return {name: self._on_grid(each[..., 0] if each.shape[-1] == 1 else each) for name, each in found.items()}

    def stiffness(self, direction: ArrayLike | None = None) -> Array:
        """Stiffness of the point against a force, with locked drives and no moment on its link.

        Parameters
        ----------
        direction
            Direction n of the force, (2,) or (3,); if None, that in which the point is softest, within the plane of a
            linkage that moves in a plane.

        Returns
        -------
        ndarray
            Force per length, ``1 / (n . C n)`` with the compliance C, (rows, columns); NaN where the place is not
            reached or the pose is singular, and infinite where the point is rigid (Gosselin, *IEEE Transactions on
            Robotics and Automation* 6, 1990, has such maps).
        """
        compliance = self.motion.compliance_matrix(self.point, self._solver.link)[..., :3, :3]
        if direction is not None:
            n = unit_vector(direction, "direction")
            soft = np.einsum("i,...ij,j->...", n, compliance, n)
        else:
            flat = list(self._solver.plane or range(3))
            within = compliance[..., flat, :][..., flat]
            good: Bools = np.asarray(np.isfinite(within).all(axis=(-2, -1)))
            soft = np.where(good, np.linalg.eigvalsh(np.where(good[..., None, None], within, 0.0))[..., -1], np.nan)
        with np.errstate(divide="ignore"):
            return self._on_grid(1.0 / np.maximum(soft, 0.0))

    def condition(self, length: float | None = None) -> Array:
        """Condition number of the Jacobian of the point by the drives, 1 if it moves equally easily in all directions.

        It is the ratio of the largest to the smallest singular value (Salisbury & Craig, *International Journal of
        Robotics Research* 1, 1982). If the drives control the orientation of the point's link as well, or some drives
        turn and others slide, rotations are multiplied by a characteristic length (Angeles, *Fundamentals of Robotic
        Mechanical Systems*, 2014, section 5.8).

        Parameters
        ----------
        length
            Characteristic length; `characteristic_length` if None. It has no effect if the drives only place the point
            and are all of one kind.

        Returns
        -------
        ndarray
            Condition number, from 1 to infinity, (rows, columns); NaN where the place is not reached.

        Raises
        ------
        FrameError
            If the length is not above zero.
        """
        unit_length = self.characteristic_length if length is None else float(finite(length, "length"))
        if not unit_length > 0.0:
            raise FrameError(f"characteristic length is {length!r}: give a length above zero")
        solver = self._solver
        scale = np.repeat([solver.size / unit_length, 1.0], 3)[: solver.rows, None]
        matrix = scale * solver.jacobian(self.motion)[..., : solver.rows, :]
        matrix = matrix * np.where(solver.slides, unit_length, 1.0) / solver.units
        good: Bools = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
        whole: Array = np.where(good[..., None, None], matrix, 0.0)
        values = np.linalg.svd(whole, compute_uv=False)
        rank = min(matrix.shape[-2:])
        with np.errstate(divide="ignore", invalid="ignore"):
            return self._on_grid(np.where(good, values[..., 0] / values[..., rank - 1], np.nan))

    @cached_property
    def characteristic_length(self) -> float:
        """Root mean square of the distances of the other points of the point's link from it, a length."""
        linkage = self.motion.linkage
        points = linkage.points
        arms = [points[each] - points[self.point] for each in linkage.links[self._solver.link].points]
        far = [float(arm @ arm) for arm in arms if arm @ arm > 0.0]
        return float(np.sqrt(np.mean(far))) if far else self._solver.size

    def effort(self, drive: str | None = None) -> Array:
        """Largest magnitude of the drives' forces or moments under the loads, springs and weights of the linkage.

        Parameters
        ----------
        drive
            One of the drives; all of them if None.

        Returns
        -------
        ndarray
            Moment of drives that turn, force of those that slide, (rows, columns); NaN where the place is not reached.

        Raises
        ------
        FrameError
            If nothing acts on the linkage, there is no such drive, or some turn and others slide and none is named.
        """
        linkage = self.motion.linkage
        if not (linkage.loads or linkage.springs or np.any(linkage.weight)):
            raise FrameError("nothing acts on the linkage, so its drives have no effort: give it a load or gravity")
        chosen = list(linkage.drives) if drive is None else [linkage.joint(drive).name]
        if drive is not None and drive not in linkage.drives:
            raise FrameError(f"joint {drive!r} is not driven: the drives are {', '.join(linkage.drives)}")
        if len({component[0] for name in chosen for component in linkage.drives[name]}) > 1:
            one = f"drive {chosen[0]!r} slides and turns: read motion.reactions().drive({chosen[0]!r}) of the workspace"
            several = f"some drives turn and others slide: name one of {', '.join(chosen)}"
            raise FrameError(one if len(chosen) == 1 else several)
        reactions = self.motion.reactions()
        each = np.concatenate([reactions.drive(name) for name in chosen], axis=-1)
        return self._on_grid(np.abs(each).max(axis=-1))

    def drives_turn(self, drive: str | None = None) -> bool:
        """Whether a drive turns.

        Parameters
        ----------
        drive
            Name of the driven joint; the first drive if None.

        Returns
        -------
        bool
            False for one that slides.
        """
        drives = self.motion.linkage.drives
        return drives[next(iter(drives)) if drive is None else drive][0].startswith("r")

    def flat(self) -> bool:
        """Whether the linkage moves in the plane of the grid.

        Returns
        -------
        bool
            False if the grid is a slice of a workspace in three dimensions.
        """
        return self._solver.plane == tuple(sorted(self.axes))

    def plot(
        self,
        what: str = "stiffness",
        ax: Axes | None = None,
        *,
        direction: ArrayLike | None = None,
        length: float | None = None,
        drive: str | None = None,
        units: Units = SI,
    ) -> Axes:
        """Draw a map over the grid; places that are not reached stay blank, and the title counts them.

        Parameters
        ----------
        what
            ``stiffness``, ``condition`` or ``effort``: the method of that name.
        ax
            Axes of matplotlib to draw on; new ones if None.
        direction
            As for `stiffness`.
        length
            As for `condition`.
        drive
            As for `effort`.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        FrameError
            If there is no such map, or no place has a finite value.
        """
        return plot_map(self, what, ax, direction, length, drive, units)

    def _on_grid(self, values: Array) -> Array:
        """Values (poses, ...) of the poses on the grid, (rows, columns, ...)."""
        out = np.full((*self.reached.shape, *values.shape[1:]), np.nan)
        out[self.reached] = values
        return out


def workspace(
    linkage: LinkageDescription, point: str, link: str | None, given: Mapping[str, ArrayLike | None]
) -> Workspace:
    """See `Linkage.workspace`; `given` is by ``x``, ``y``, ``z``."""
    there = {name: finite(value, f"{name} of the workspace") for name, value in given.items() if value is not None}
    rows = [name for name, value in there.items() if value.ndim]
    if len(rows) != 2 or any(there[name].ndim != 1 or len(there[name]) < 2 for name in rows):
        told = ", ".join(f"{name} of shape {value.shape}" for name, value in there.items()) or "nothing"
        raise FrameError(
            f"a workspace was given {told}: give two of x, y and z as rows of numbers, and the third as one number or "
            "not at all"
        )
    known = {"xyz".index(name): value for name, value in there.items()}
    axes = tuple("xyz".index(name) for name in rows)
    solver = InverseKinematics(linkage, point, link)
    place = np.array(solver.home.position(point, link))
    for k, value in known.items():
        if k not in axes:
            place[k] = value
    grid = known[axes[0]], known[axes[1]]
    shape = len(grid[1]), len(grid[0])
    places = np.broadcast_to(place, (*shape, 3)).copy()
    places[..., axes[0]], places[..., axes[1]] = np.meshgrid(*grid)
    drives, reached, possible = everywhere(solver, places)
    if not reached.any():
        raise FrameError(f"no place of the grid can be reached by {point}: its reference position is {place.tolist()}")
    poses, elsewhere = solver.poses(drives[reached]), possible & ~reached
    return Workspace(poses, point, (axes[0], axes[1]), grid, place, reached, elsewhere, solver)
