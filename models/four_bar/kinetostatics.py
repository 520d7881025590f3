"""Reactions in the joints and the torque of the drive: the rigid linkage in dynamic equilibrium."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...elements.parameters import as_real
from ...framework.batch import finite, join
from ...framework.errors import FrameError
from ..linkage.graphics import reaction_plots
from ..newton_euler import Action, NewtonEuler, Transmitted
from .description import LINKS, known
from .kinematics import FourBarKinematics

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]
Pair = tuple[ArrayLike, ArrayLike]

REACTIONS = ("A", "B", "D", "E")

# Forces in the joints, by which link and on which they act, and the torque of the drive.
FORCE, TORQUE = np.split(np.eye(3), [2])
TRANSMITTED = (
    ("A", "ground", "crank", FORCE),
    ("B", "coupler", "crank", FORCE),
    ("D", "rocker", "coupler", FORCE),
    ("E", "ground", "rocker", FORCE),
    ("A", "ground", "crank", TORQUE),
)


@dataclass(frozen=True, eq=False)
class Link:
    """Mass properties of a rigid link and the loads on it; every number may be an array.

    Parameters
    ----------
    mass
        Mass of the link, (...).
    centre
        Centre of mass (x, y) in the link's axes (crank: A towards B, coupler: B towards D, rocker: E towards D).
    inertia
        Moment of inertia about the centre of mass, (...).
    force
        External force (fx, fy), global components.
    at
        Point (x, y), in the link's axes, on which the force acts; the centre of mass where None.
    torque
        External torque about z, (...).

    Raises
    ------
    FrameError
        If a number is not finite, or mass or inertia is negative.

    Examples
    --------
    The torque that holds a crank of 2 kg level, its centre of mass half way along its 0.1 m, is that of its weight.

    >>> from linkframe.models import FourBar
    >>> crank = Link(mass=2.0, centre=(0.05, 0.0))
    >>> found = FourBar(ground=0.25).move(0.0).reactions(crank=crank, gravity=(0.0, -9.81))
    >>> round(float(found.drive_torque), 9)
    0.981
    """

    mass: ArrayLike = 0.0
    centre: Pair = (0.0, 0.0)
    inertia: ArrayLike = 0.0
    force: Pair = (0.0, 0.0)
    at: Pair | None = None
    torque: ArrayLike = 0.0

    def __post_init__(self) -> None:
        for name in ("mass", "inertia", "torque"):
            value = finite(getattr(self, name), f"{name} of the link")
            if name != "torque" and np.any(value < 0.0):
                raise FrameError(f"{name} of the link is {value[value < 0.0].flat[0]}: give zero or more")
            object.__setattr__(self, name, as_real(value))
        for name in ("centre", "force", "at"):
            if getattr(self, name) is not None or name != "at":
                object.__setattr__(self, name, _pair(getattr(self, name), f"{name} of the link"))


def _pair(given: Pair, what: str) -> Pair:
    """Two numbers, checked."""
    if not isinstance(given, tuple | list) or len(given) != 2:
        raise FrameError(f"{what} is {given!r}: give a pair (x, y)")
    x, y = (as_real(finite(component, what)) for component in given)
    return x, y


@dataclass(frozen=True, eq=False)
class Kinetostatics:
    """Joint reactions and drive torque of a four-bar; made by `FourBarMotion.reactions`.

    Attributes
    ----------
    motion
        The motion that they belong to.
    unknowns
        Ax Ay Bx By Dx Dy Ex Ey Ts, (..., 9); NaN where `status` is not ``"regular"``.
    """

    motion: FourBarKinematics
    unknowns: Array

    def plot(self, what: str = "joints", ax: Axes | None = None, *, units: tuple[str, str] = ("m", "N")) -> Axes:
        """Draw the size of the force in every joint, or the drive torque, over the drive angle.

        Curves that coincide are drawn once, labelled with all their names. Of several batch axes the longest is drawn,
        at the first entry of the others.

        Parameters
        ----------
        what
            ``joints`` or ``drives``.
        ax
            Axes of matplotlib to draw on; new ones where None.
        units
            Units of length and force, for the labels.

        Returns
        -------
        matplotlib.axes.Axes
            The axes; the abscissa is the drive angle in degrees, or the pose number where the drive reverses.

        Raises
        ------
        FrameError
            If there is nothing of that name.
        """
        forces = {joint: self.reaction(joint) for joint in REACTIONS}
        return reaction_plots.plot_four_bar_reactions(self.motion.theta, forces, self.drive_torque, what, ax, units)

    @property
    def status(self) -> NDArray[np.str_]:
        """``"regular"``, or why there is no answer, (...)."""
        return np.broadcast_to(self.motion.status, self.unknowns.shape[:-1])

    @property
    def drive_torque(self) -> Array:
        """Torque of the drive on the crank, positive about z, (...)."""
        return self.unknowns[..., 8]

    def reaction(self, joint: str) -> Array:
        """Force in a joint, by one of its links on the other.

        A: on the crank, by the ground. B: on the crank, by the coupler. D: on the coupler, by the rocker.
        E: on the rocker, by the ground. (F12, F32, F43, F14 in Norton's notation, force of the first index on the
        second.) At B, D and E it is what the frame's `joint_force` shows.

        Parameters
        ----------
        joint
            ``"A"``, ``"B"``, ``"D"`` or ``"E"``.

        Returns
        -------
        ndarray
            Global components, (..., 3); z is zero.

        Raises
        ------
        FrameError
            If there is no such joint.
        """
        column = 2 * REACTIONS.index(known("joint", joint, REACTIONS))
        force = np.zeros((*self.unknowns.shape[:-1], 3))
        force[..., :2] = self.unknowns[..., column : column + 2]
        return force

    def contact_angle(self, joint: str) -> Array:
        """Angle γ at which a joint with clearance makes contact while it transmits its reaction, radians, (...).

        The journal lies against the bearing along the force, so that the later link's pin centre is displaced from
        the earlier one's that way: the γ of Eq. (11) "from the dynamic model", as `accuracy` takes it.

        Parameters
        ----------
        joint
            ``"B"``, ``"D"`` or ``"E"``.

        Returns
        -------
        ndarray
            Angle from global x, radians in (-π, π], (...).
        """
        force = self.reaction(joint)
        return np.arctan2(force[..., 1], force[..., 0])


def kinetostatics(motion: FourBarKinematics, crank: Link, coupler: Link, rocker: Link, gravity: Pair) -> Kinetostatics:
    """Solve the linkage's nine equations of dynamic equilibrium, Eq. (1)-(4) of the accuracy paper.

    They are derived again here, as the signs and lever arms printed in (3) are not consistent.
    """
    links = dict(zip(LINKS, (crank, coupler, rocker), strict=True))
    weight = _pair(gravity, "gravity")
    _check_shapes(motion, links, weight)
    centres = {name: motion.position_on(name, *link.centre)[..., :2] for name, link in links.items()}
    joints = [Transmitted(by, on, motion.position(joint)[..., :2], wrenches) for joint, by, on, wrenches in TRANSMITTED]
    equations = NewtonEuler(centres, joints)
    left = equations.matrix
    actions = (_acting(motion, name, link, weight, centres[name]) for name, link in links.items())
    right = equations.balanced(chain.from_iterable(actions))
    left[np.broadcast_to(motion.singular, left.shape[:-2])] = np.eye(9)
    right[np.broadcast_to(motion.singular, right.shape[:-1])] = np.nan
    return Kinetostatics(motion, np.asarray(np.linalg.solve(left, right[..., None])[..., 0], dtype=np.float64))


def _check_shapes(motion: FourBarKinematics, links: Mapping[str, Link], gravity: Pair) -> None:
    """Refuse what is no link, and numbers that do not broadcast with the motion and each other."""
    shapes = {"the motion": motion.shape} | {f"gravity {k}": np.shape(g) for k, g in zip("xy", gravity, strict=True)}
    for name, link in links.items():
        if not isinstance(link, Link):
            raise FrameError(f"{name} is {link!r}: give a Link")
        for each in fields(Link):
            given = getattr(link, each.name)
            for value in given if isinstance(given, tuple) else (given,):
                join(shapes, f"{each.name} of the {name}", np.shape(value))


def _acting(motion: FourBarKinematics, name: str, link: Link, gravity: Pair, centre: Array) -> Iterator[Action]:
    """Weight, inertia and torque of a link at its centre of mass, and its force where that acts."""
    numbers = (link.mass, link.inertia, link.torque, *link.force, *gravity)
    mass, inertia, torque, fx, fy, gx, gy = (np.asarray(number) for number in numbers)
    acceleration, gain = motion.acceleration_on(name, *link.centre), motion.angular_acceleration(name)
    weight = mass * (gx - acceleration[..., 0]), mass * (gy - acceleration[..., 1])
    yield Action(name, centre, _wrench(*weight, torque - inertia * gain))
    place = centre if link.at is None else motion.position_on(name, *link.at)[..., :2]
    yield Action(name, place, _wrench(fx, fy, np.zeros(())))


def _wrench(*components: Array) -> Array:
    return np.stack(np.broadcast_arrays(*components), axis=-1)
