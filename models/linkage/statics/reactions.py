"""Reactions in the joints and forces of the drives of a moving linkage."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, rotated
from ....framework.errors import FrameError
from ..description.joints import COMPONENTS
from ..graphics.reaction_plots import plot_reactions
from ..poses.states import PoseState
from .actions import centre_of, inertia_force
from .determinacy import IdleMotions, solved, without_self_stress
from .equilibrium import Equilibrium
from .frame import FramedPoses, frame

if TYPE_CHECKING:
    from matplotlib.axes import Axes

DETERMINATE, COMPLIANCE, LEAST, NONE = "determinate", "compliance", "minimum norm", "none"
# At singular poses, ratio of forces to loads above which no finite forces exist: the closure holds to rounding only.
HUGE = 1e6


@dataclass(frozen=True, eq=False, repr=False)
class Reactions:
    """Joint reactions and drive forces; made by `Motion.reactions`.

    They are NaN where no finite forces keep the linkage in equilibrium.

    Attributes
    ----------
    motion
        The motion of the linkage.
    wrenches
        By joint: force and moment on its second link, about the joint's point on that link, global, (..., 6).
    drives
        By driven joint: force or moment on each driven coordinate, (..., f).
    method
        How they were found at each pose, (...): ``"determinate"`` where equilibrium alone determines all reactions that
        differ from zero; ``"compliance"`` where links and joints share a load by their stiffness; ``"minimum norm"``
        where these are rigid, and the reactions are those in equilibrium with the least sum of squares; ``"none"``
        where no finite forces hold the linkage, or it is not assembled.
    """

    motion: FramedPoses
    wrenches: Mapping[str, Array]
    drives: Mapping[str, Array]
    method: NDArray[np.str_]

    def __post_init__(self) -> None:
        for array in (*self.wrenches.values(), *self.drives.values(), self.method):
            array.setflags(write=False)

    def __repr__(self) -> str:
        return f"<Reactions in joints {', '.join(self.wrenches)} of {self.motion!r}>"

    def plot(self, what: str = "joints", ax: Axes | None = None, *, units: tuple[str, str] = ("m", "N")) -> Axes:
        """Plot the magnitude of the force in every joint, or the force or moment of every drive, over the first drive.

        Curves that coincide are drawn as one, labelled with all their names.

        Parameters
        ----------
        what
            ``joints`` or ``drives``.
        ax
            Axes of matplotlib to draw on; new ones if None.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            The axes; over degrees if the drive is an angle, over the number of the pose if the drive moves to and fro.

        Raises
        ------
        FrameError
            If `what` is unknown, or no pose is assembled.
        """
        return plot_reactions(self.motion, self.wrenches, self.drives, what, ax, units)

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        return self.method.shape

    def force(self, joint: str, link: str | None = None) -> Array:
        """Force and moment that a joint exerts on one of its links.

        Parameters
        ----------
        joint
            Name of the joint.
        link
            One of the two links; the second if None.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, global, about the joint's point on the second link, (..., 6).

        Raises
        ------
        FrameError
            If the joint is unknown, or the link not one of its own.
        """
        pair = self.motion.linkage.joint(joint)
        if link not in (None, pair.first, pair.second):
            raise FrameError(f"joint {joint!r} does not touch link {link!r}: it joins {pair.first} and {pair.second}")
        wrench = self.wrenches[joint]
        return -wrench if link == pair.first else wrench

    def in_joint(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first link, in the joint's axes.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz``, (..., 6), as `joint_force` of the frame's solution; but for a rod between two
            spherical joints, whose first joint may have its axes along the rod there.
        """
        axes = self.motion.joint_axes(joint)
        return rotated(np.swapaxes(axes, -1, -2), self.force(joint, self.motion.linkage.joint(joint).first))

    def drive(self, joint: str) -> Array:
        """Force or moment of a drive on each driven coordinate.

        Parameters
        ----------
        joint
            Name of the driven joint.

        Returns
        -------
        ndarray
            A force or moment for each driven coordinate, (..., f); times the rate of the coordinate it is the power.

        Raises
        ------
        FrameError
            If the joint is not driven.
        """
        if joint not in self.drives:
            raise FrameError(f"joint {joint!r} is not driven: the drives are {', '.join(self.drives) or 'none'}")
        return self.drives[joint]

    def inertia_force(self, link: str) -> Array:
        """Inertia force and torque of a link about its centre of mass, Eq. (1) and (2) of the accuracy paper.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        ndarray
            ``-m a`` and ``-(I alpha + omega x I omega)``, global, (..., 6).
        """
        return inertia_force(self.motion, link, centre_of(self.motion, link)).wrench


def reactions(motion: FramedPoses) -> Reactions:
    """Solve the Newton-Euler equations of all links for joint reactions and drive forces; see `Motion.reactions`.

    Idle degrees of freedom, such as the spin of a rod between two spherical joints, accelerate freely.
    """
    equations = Equilibrium(motion)
    side = equations.side
    shape = side.shape[:-1]
    loads, columns = side.reshape(-1, side.shape[-1]), equations.unknowns
    there = np.broadcast_to(motion.is_assembled, shape).reshape(-1) & np.isfinite(loads).all(axis=-1)
    rows_of_values, is_unique = np.full((len(loads), columns), np.nan), np.ones(len(loads), dtype=bool)
    if there.any():
        idle = IdleMotions(equations.idle, _flat(equations.inertia, shape)[there]) if equations.idle else IdleMotions()
        entries = np.flatnonzero(there)
        found = solved(lambda cut: equations.coefficients(shape, entries[cut]), loads[there], idle)
        rows_of_values[there], is_unique[there] = found.values, found.unique
    values, unique = rows_of_values.reshape(*shape, columns), is_unique.reshape(shape)
    values[_boundless(motion, values, side)] = np.nan
    determined = np.isfinite(values).all(axis=-1)
    shared = ~unique & determined
    wrenches, drives = _split(equations, values)
    told: NDArray[np.bool_] = np.asarray(shared & _compliant(motion))
    if shared.any() and not told.any() and (elastic := _elastic(equations)).any():
        entries = np.flatnonzero(shared)
        known = without_self_stress(lambda cut: equations.coefficients(shape, entries[cut]), loads[entries], elastic)
        told = np.isin(np.arange(shared.size), entries[known]).reshape(shape)
    if told.any():
        for own, other in zip((wrenches, drives), _by_compliance(motion), strict=True):
            own.update({joint: np.where(told[..., None], other[joint], force) for joint, force in own.items()})
    method = np.where(determined, np.where(told, COMPLIANCE, np.where(shared, LEAST, DETERMINATE)), NONE)
    return Reactions(motion, wrenches, drives, method)


def _boundless(motion: FramedPoses, values: Array, side: Array) -> NDArray[np.bool_]:
    """Singular poses whose forces are finite only through the rounding errors of the closure, (...)."""
    loads = np.max(np.abs(side), axis=-1, initial=0.0)
    huge = np.asarray(np.max(np.abs(values), axis=-1, initial=0.0) > HUGE * loads)
    if not huge.any():
        return huge
    return np.asarray(huge & (motion.state == PoseState.SINGULAR_DIRECT))


def _flat(matrix: Array, shape: tuple[int, ...]) -> Array:
    """Matrices broadcast to the batch `shape`, with one batch axis, (n, ., .)."""
    return np.broadcast_to(matrix, (*shape, *matrix.shape[-2:])).reshape(-1, *matrix.shape[-2:])


def _compliant(motion: FramedPoses) -> bool:
    """Whether all links, or else all joints, have a finite stiffness by which loads are shared."""
    linkage = motion.linkage
    links = all(link.beams or len(link.points) == 1 for link in linkage.links.values())
    return links or all(np.isfinite(pair.full_stiffness).all() for pair in linkage.joints.values())


def _elastic(equations: Equilibrium) -> NDArray[np.bool_]:
    """Unknowns that strain the stiffness of a joint, (k,); locked drives do not."""
    linkage, out = equations.motion.linkage, np.zeros(equations.unknowns, dtype=bool)
    for joint, columns in zip(equations.names, equations.columns, strict=True):
        springs = np.asarray(np.isfinite(linkage.joints[joint].full_stiffness).reshape(-1, 6).all(axis=0))
        constrained = linkage.joints[joint].kind.constrained
        out[columns] = [name in constrained and springs[COMPONENTS.index(name)] for name in equations.names[joint]]
    return out


def _by_compliance(motion: FramedPoses) -> tuple[dict[str, Array], dict[str, Array]]:
    """Wrenches and drive forces by joint, from the frame under all loads with locked drives."""
    linkage = motion.linkage
    solution = frame(motion, clearance=False, inertia=True, clamped=True).solve()
    wrenches, drives = {}, {}
    for name in linkage.joints:
        force = -solution.joint_force(name)
        wrenches[name] = solution.joint_global(name, force)
        if name in linkage.drives:
            drives[name] = force[..., [COMPONENTS.index(k) for k in linkage.drives[name]]]
    return wrenches, drives


def _split(equations: Equilibrium, values: Array) -> tuple[dict[str, Array], dict[str, Array]]:
    """Wrenches and drive forces by joint from the unknowns (..., n)."""
    wrenches, drives = {}, {}
    for joint, transmitted, columns in zip(equations.names, equations.joints, equations.columns, strict=True):
        own = values[..., columns]
        wrenches[joint] = (own[..., None, :] @ transmitted.wrenches)[..., 0, :]
        if driven := equations.motion.linkage.drives.get(joint):
            drives[joint] = (own * equations.units_of(joint))[..., -len(driven) :]
    return wrenches, drives
