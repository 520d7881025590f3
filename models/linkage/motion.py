"""Where everything of a linkage is, how fast it moves and how it accelerates."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import Array, Shape, vector
from ...framework.errors import FrameError
from ...framework.states import States, among
from .description.parts import GROUND
from .kinematics.blocks import blocks, cut_all
from .kinematics.coordinates import coordinate_of, rates_of_coordinate
from .kinematics.mechanism import Mechanism
from .kinematics.tape import Program, Value
from .linkage import Linkage
from .poses.states import PoseState
from .way.assemble import Assembly, assembled
from .way.driven import remedy
from .way.drives import Drives, given_drives

if TYPE_CHECKING:
    from ...framework.frame import Frame
    from .statics.accuracy import PointAccuracy, Stress
    from .statics.frame import Builder
    from .statics.reactions import Reactions

BRANCHES = ("keep", "switch")
OTHER_MODE = "other assembly mode; not reachable from the reference configuration"


class LoadsWarning(UserWarning):
    """What is asked of a motion does not contain the loads that one of its frames was given."""


def move(
    linkage: Linkage,
    values: Mapping[str, ArrayLike],
    rates: Mapping[str, ArrayLike],
    accelerations: Mapping[str, ArrayLike],
    branch: str,
    tolerance: float = 0.0,
    other_modes: bool = False,
) -> Motion:
    """Motion of a linkage; see `Linkage.move`."""
    if branch not in BRANCHES:
        raise FrameError(f"branch is {branch!r}: choose one of {', '.join(BRANCHES)}")
    if not 0.0 <= tolerance < np.inf:
        raise FrameError(f"tolerance is {tolerance:g}: give a length, 0 or above")
    linkage.check_free()
    mechanism = compiled(linkage)
    drives = given_drives(linkage, mechanism, values, rates, accelerations)
    found = assembled(mechanism, drives, branch == "switch", tolerance / mechanism.size, other_modes)
    return Motion(linkage, mechanism, drives, found)


def compiled(linkage: Linkage) -> Mechanism:
    """The linkage's mechanism, compiled once for as long as its description stays the same."""
    if linkage.kept is None or linkage.kept[0] != linkage.version:
        linkage.kept = linkage.version, Mechanism(linkage)
    return linkage.kept[1]


@dataclass(frozen=True, eq=False, repr=False)
class Motion:
    """Motion of a linkage over a batch of poses; made by `Linkage.move`.

    Poses that cannot be assembled have the status ``"not assembled: ..."`` and NaN throughout, as have those in another
    assembly mode than the reference configuration unless these were asked for.

    Attributes
    ----------
    linkage
        The description.
    mechanism
        Its compiled form.
    drives
        Values, rates and accelerations of the drives.
    assembly
        The closed states.
    """

    linkage: Linkage
    mechanism: Mechanism
    drives: Drives
    assembly: Assembly

    def __repr__(self) -> str:
        return f"<Motion of shape {self.shape} of {self.linkage!r}>"

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; frames that are in use in this one are not known there."""
        return {name: value for name, value in vars(self).items() if name != "frames"}

    @property
    def shape(self) -> Shape:
        """Batch shape: the broadcast of drives, rates, accelerations and drawing."""
        return np.broadcast_shapes(self.drives.full_shape, self.assembly.shape)

    @property
    def tolerance(self) -> float:
        """Greatest gap, a length, with which poses count as assembled; 0 for rounding."""
        return self.assembly.loops.tolerance * self.mechanism.size

    # -- how it went ------------------------------------------------------------------------------------------------

    @cached_property
    def is_assembled(self) -> NDArray[np.bool_]:
        """Whether each pose can be assembled, (...)."""
        return np.broadcast_to(self.assembly.closed, self.shape)

    @cached_property
    def gap(self) -> Array:
        """Closure error of each pose, (...), a length; angles count times the linkage's size."""
        return np.broadcast_to(self.assembly.gap, self.shape)

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """What is special about each pose, (...).

        * ``"regular"``
        * ``"near dead point"``: see `conditioning`
        * ``"singular: output, joint ... moves with the drives held"``: in a dead point or a change point. Of the joints
          that move, one is named that has no hold on either side.
        * ``"singular: input, joint ... stands still"``, with several drives ``"... has lost a direction"``: in which
          they move its point, or the link that slides in it, at other poses, as the pin of a rocker at the end of its
          swing. Positions and velocities are good as ever.
        * ``"other assembly mode; not reachable from the reference configuration"``: the linkage can be assembled, but
          not on the straight path of the drives from the reference configuration; results are NaN, but with
          ``other_modes=True`` those of the position that was found.
        * ``"not assembled: gap ... at joint ..."``: results are NaN.
        """
        return np.broadcast_to(self._told[1], self.shape)

    @cached_property
    def state(self) -> States:
        """The same as numbers, (...): see `linkframe.models.PoseState`."""
        return np.broadcast_to(self._told[0], self.shape)

    @property
    def is_regular(self) -> NDArray[np.bool_]:
        """Where nothing is special about the pose, (...)."""
        return np.asarray(self.state == PoseState.REGULAR)

    @property
    def is_singular(self) -> NDArray[np.bool_]:
        """Where the pose is singular, of either type, (...)."""
        return among(self.state, PoseState.SINGULAR_DIRECT, PoseState.SINGULAR_INVERSE)

    @cached_property
    def _told(self) -> tuple[States, NDArray[np.str_]]:
        from .poses.singular import pose_states

        return pose_states(self)

    @property
    def conditioning(self) -> Array:
        """How firmly the drives hold each pose, (...): from 0, where something moves with the drives held, towards 1.

        Least over greatest singular value of the loop closure by the coordinates that are not driven, with lengths in
        units of the linkage's extent; what moves by itself at every pose does not count.
        """
        return np.broadcast_to(self.held[0], self.shape)

    @cached_property
    def held(self) -> tuple[Array, Array]:
        """The conditioning, and at singular poses the motions of the unknown velocity coordinates that are not held."""
        from .poses.singular import conditioning

        return conditioning(self)

    def transmission_angle(self, joint: str) -> Array:
        """Angle of transmission at a joint, radians in [0, π/2], (...): best at π/2, none at 0.

        The angle between the force that the joint passes on to its second link and the direction square to the motion
        of that link's half of the joint; 90° less the pressure angle. For a four-bar at the joint between coupler and
        rocker it is the angle between the two, acute (Norton, Design of Machinery, section 4.10); between a connecting
        rod and its piston it is the angle between the rod and the line square to the slide. In general, with drives
        held, the joint can pass on those forces that the links before it take without moving, and its second link can
        move as it can without the joint: the angle of transmission has the sine of the best of them.

        Parameters
        ----------
        joint
            The joint; its second link is the one that is driven.

        Returns
        -------
        ndarray
            Radians, (...).

        Raises
        ------
        FrameError
            If there is no such joint, or its second link is the ground.
        """
        from .poses.transmission import transmission_angle

        return transmission_angle(self, joint)

    @cached_property
    def closure_status(self) -> NDArray[np.str_]:
        """``"regular"``, ``"other assembly mode..."`` or ``"not assembled: gap ... at joint ..."``, (...)."""
        found = self.assembly
        status = np.full(found.shape, "regular", dtype="<U200")
        if not found.reached.all():
            status[found.other] = OTHER_MODE
            for index in map(tuple, np.argwhere(~found.reached & ~found.other)):
                joint = self.mechanism.rows[int(found.open_row[index])][0]
                gap = float(found.gap[index])
                status[index] = f"not assembled: gap {gap:.3g} at joint {joint}{remedy(found.loops, gap)}"
        return np.broadcast_to(status, self.shape)

    # -- points -----------------------------------------------------------------------------------------------------

    def position(self, point: str, link: str | None = None) -> Array:
        """Position of a point, (..., 3).

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Global coordinates, (..., 3).
        """
        return self._position(*self._on(point, link))

    def velocity(self, point: str, link: str | None = None) -> Array:
        """Velocity of a point, (..., 3).

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._velocity_at(*self._on(point, link))

    def acceleration(self, point: str, link: str | None = None) -> Array:
        """Acceleration of a point, (..., 3).

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._acceleration_at(*self._on(point, link))

    def position_on(self, link: str, place: ArrayLike) -> Array:
        """Position of a place of a link, (..., 3).

        Parameters
        ----------
        link
            The link.
        place
            The place in the drawing, (..., 2 or 3).

        Returns
        -------
        ndarray
            Global coordinates, (..., 3).
        """
        return self._position(link, _drawn(place))

    def velocity_on(self, link: str, place: ArrayLike) -> Array:
        """Velocity of a place of a link, (..., 3).

        Parameters
        ----------
        link
            The link.
        place
            The place in the drawing, (..., 2 or 3).

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._velocity_at(link, _drawn(place))

    def acceleration_on(self, link: str, place: ArrayLike) -> Array:
        """Acceleration of a place of a link, (..., 3).

        Parameters
        ----------
        link
            The link.
        place
            The place in the drawing, (..., 2 or 3).

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._acceleration_at(link, _drawn(place))

    # -- links ------------------------------------------------------------------------------------------------------

    def origin(self, link: str) -> Array:
        """Where the drawing's origin, fixed on the link, is: position = origin + axes @ drawn place, (..., 3).

        Parameters
        ----------
        link
            The link.

        Returns
        -------
        ndarray
            Global coordinates, (..., 3).
        """
        return self._position(link, np.zeros(3))

    def axes(self, link: str) -> Array:
        """Axes of a link as columns, (..., 3, 3): the identity as drawn.

        Parameters
        ----------
        link
            The link.

        Returns
        -------
        ndarray
            Rotation from the drawing, (..., 3, 3).
        """
        if link == GROUND:
            return np.broadcast_to(np.eye(3), (*self.shape, 3, 3))
        body = self.mechanism.bodies[self._known(link)]
        now = np.stack([self._global(v) for v in self._pose(link)[1]], axis=-1)
        return np.asarray(np.einsum("...ij,...kj->...ik", now, body.drawn_axes))

    def angular_velocity(self, link: str) -> Array:
        """Angular velocity of a link, (..., 3).

        Parameters
        ----------
        link
            The link.

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._global(self._rates(link)[0])

    def angular_acceleration(self, link: str) -> Array:
        """Angular acceleration of a link, (..., 3).

        Parameters
        ----------
        link
            The link.

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._global(self._rates(link)[2])

    # -- joints -----------------------------------------------------------------------------------------------------

    def coordinate(self, joint: str) -> Array:
        """Coordinates of a joint, (..., f): of the second link relative to the first.

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        ndarray
            In the order of the kind's coordinates; ``at`` as drawn. Angles go on beyond a turn: they count the turns
            that the joint makes while the drives go to the pose from their reference values. Of a ball: the rotation
            vector, of length at most π.
        """
        return coordinate_of(self, self.linkage.joint(joint))

    def counted(self, joint: str) -> Assembly:
        """The same poses of a mechanism that has the coordinates of a joint, which here closes a loop, in its state.

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        Assembly
            Closed states, in which the joint's angles contain the turns made on the way to each pose.
        """
        if joint not in self._counted:
            mechanism, found = self.mechanism.counting(joint), self.assembly
            self._counted[joint] = assembled(mechanism, self.drives, found.switch, found.loops.tolerance)
        return self._counted[joint]

    @cached_property
    def _counted(self) -> dict[str, Assembly]:
        return {}

    def coordinate_rate(self, joint: str) -> Array:
        """Rates of a joint's coordinates, (..., f).

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        ndarray
            Time derivatives; of a ball the angular velocity, in the joint's axes on its first link.
        """
        return rates_of_coordinate(self, self.linkage.joint(joint), 0)

    def coordinate_acceleration(self, joint: str) -> Array:
        """Accelerations of a joint's coordinates, (..., f).

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        ndarray
            Second time derivatives; of a ball the rate of the components that `coordinate_rate` gives.
        """
        return rates_of_coordinate(self, self.linkage.joint(joint), 1)

    def joint_axes(self, joint: str) -> Array:
        """Axes of a joint as columns x y z, (..., 3, 3).

        They move with the joint's first link; those of a universal joint have z on the first and x on the second.

        Parameters
        ----------
        joint
            The joint.

        Returns
        -------
        ndarray
            Global components, (..., 3, 3).
        """
        pair = self.linkage.joint(joint)
        first = self.axes(pair.first) @ pair.axes
        if pair.kind.name != "universal":
            return np.asarray(first)
        z, x = first[..., 2], (self.axes(pair.second) @ pair.axes)[..., 0]
        return np.stack([x, np.cross(z, x), z], axis=-1)

    # -- forces, compliance and clearance -----------------------------------------------------------------------------

    def reactions(self) -> Reactions:
        """Joint reactions and drive forces of the rigid linkage, by the Newton-Euler equations of all links.

        Inertia forces (Eq. 1 and 2 of the accuracy paper), gravity, loads, springs and dampers are in equilibrium with
        what the joints hold and the drives push. Where equilibrium alone does not tell all reactions, those follow
        from the compliance of links and joints; if these are rigid, the reactions with the least sum of squares are
        given (moments divided by half of what the drawing spans). ``.method`` says which.

        Loads that were given to a frame of the motion alone are not among them.

        Returns
        -------
        Reactions
            Reactions and drive forces; NaN where no finite forces hold the linkage.

        Warns
        -----
        LoadsWarning
            Where a frame of the motion was given loads.

        Raises
        ------
        FrameError
            If masses, loads, springs or gravity do not broadcast with the motion.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> arm = Linkage(A=(0, 0), B=(2, 0))
        >>> arm.link("arm", "A", "B", mass=3.0)
        >>> arm.revolute("A", "ground", "arm", drive=True)
        >>> arm.gravity((0, -10))
        >>> round(float(arm.move(A=0.0).reactions().drive("A")[0]), 9)
        30.0
        """
        from .statics.reactions import reactions

        self._check_frames("reactions()")
        return reactions(self)

    def kinetic_energy(self) -> Array:
        """Kinetic energy of all links, (...)."""
        from .statics.actions import kinetic_energy

        return kinetic_energy(self)

    def free_accelerations(self, forces: Mapping[str, ArrayLike] | None = None) -> dict[str, Array]:
        """Accelerations of the drives under given drive forces, at the motion's poses and rates.

        With the rates as they are, the drive forces of `reactions` are linear in the accelerations,
        ``M a + h``; this solves ``M a = f - h`` (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 6).

        Parameters
        ----------
        forces
            Force or moment by driven joint, (...), or (..., f) where f coordinates are driven; zero where not given.

        Returns
        -------
        dict of ndarray
            By driven joint, (..., f).

        Raises
        ------
        FrameError
            If a joint is not driven, or the linkage has no inertia against one of its drives.
        """
        from .statics.free import free_accelerations

        return free_accelerations(self, forces or {})

    @cached_property
    def bare(self) -> Builder:
        """The frame of the motion without loads, whose plan serves all load cases."""
        from .statics.frame import Builder

        return Builder(self, clearance=True)

    def frame(self, *, clearance: bool = True, loads: bool = True, inertia: bool = False) -> Frame:
        """The linkage at every pose as a frame of beams, joints and springs, held at its drives.

        Each link is a body, in whose own axes its nodes do not move, so that its stiffness is computed once for all
        poses. A point that only one link has gives the node of its name; where joints part it each link has its own,
        ``point.link``, and the bare name means that of the first link. Members are called as their link, or
        ``link.1``, ``link.2``, ...; joints by their names; springs ``spring.1``, ...

        A slider loads the link that carries it where it is at each pose: on any of the beams along which its slot
        runs, at a point of the link, or, where it is beyond them all, on a rigid prolongation of the nearest end. A
        beam counts where it leans from the slot by less than 0.01 radians and is off it by less than a hundredth of
        its length. Where the slot runs along no beam, as that of a yoke, the slider stands on a rigid arm from the
        joint's point. Where it changes from seat to seat with the pose, each seat is a joint ``joint.link.on.seat``
        between the link and the slider's node, rigid at the poses at which the slider stands there and free else.

        A mass that was given sits, rigid, on the link's point nearest to its centre, and its beams weigh nothing.
        Springs carry their force at rest and turn with it; that the forces in links turn, too, is left to
        `flexibility`, `stiffness` and `frequencies`, and to ``frame.buckling``.

        Parameters
        ----------
        clearance
            Give the joints their clearance.
        loads
            Apply what the linkage was loaded with: loads, torques, gravity, and the forces of springs and dampers.
            What the frame is loaded with later acts in it alone, and neither in `reactions` nor in `stress`.
        inertia
            Apply the inertia forces of the rigid motion.

        Returns
        -------
        Frame
            The frame, batch shape (...) and that of beams, stiffnesses and loads. Poses that are not assembled are
            left out: their status is ``absent``.
        """
        from .statics.frame import frame

        built = frame(self, clearance=clearance, loads=loads, inertia=inertia)
        self.frames[built] = loads_of(built)
        return built

    @cached_property
    def frames(self) -> WeakKeyDictionary[Frame, tuple[int, ...]]:
        """Frames that were made of the motion and are still in use, and how many loads they then had."""
        return WeakKeyDictionary()

    def _check_frames(self, what: str) -> None:
        """Warn where a frame of the motion was given loads, which what is asked of the motion does not contain."""
        if any(loads_of(frame) != before for frame, before in self.frames.items()):
            warnings.warn(
                f"motion.{what} does not contain the loads that were given to a frame of this motion: loads given by "
                "linkage.load(...) act in both",
                LoadsWarning,
                stacklevel=3,
            )

    def save(self, path: str | Path, times: ArrayLike | None = None) -> None:
        """Write the motion for ParaView: links as lines, with the velocity and acceleration of their points.

        With beams, ``motion.frame().solve().save(path)`` shows them with their displacements and forces.

        Parameters
        ----------
        path
            File ``.pvd``; the poses are files in a folder beside it. Poses that are not assembled are left out.
        times
            Increasing times (or angles) of the poses, (poses,); their numbers where None.

        Raises
        ------
        FrameError
            If the name ends otherwise, the motion is not one row of poses, or the folder cannot be written.
        """
        from .export import save

        save(self, path, times)

    def accuracy(
        self, point: str, link: str | None = None, *, inertia: bool = False, **load: ArrayLike
    ) -> PointAccuracy:
        """Where a point of the loaded linkage really goes: by compliance, by clearance, and in total.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.
        inertia
            Let the inertia forces of the rigid motion act as well.
        **load
            Forces and moments on the point beside the linkage's own loads, ``fx fy fz mx my mz``, global, (...).

        Returns
        -------
        PointAccuracy
            Displacements (..., 6), computed when read.
        """
        from .statics.accuracy import accuracy

        return accuracy(self, point, link, load, inertia=inertia)

    def flexibility(self, point: str, link: str | None = None) -> Array:
        """Displacement and rotation of a point by unit forces and moments on it, drives held, clearances closed.

        About the pose under the linkage's springs, loads and weights: these make links stiffer or softer as they turn
        (geometric stiffness), rigid ones as well. On a linkage of one degree of freedom whose drive has a stiffness k
        it is ``1 / (k + V'')`` with the potential V of springs, loads and weights.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` by ``fx fy fz mx my mz``, global, (..., 6, 6); symmetric.
        """
        from .statics.accuracy import flexibility

        return flexibility(self, point, link)

    def stiffness(self, point: str, link: str | None = None) -> Array:
        """Force and moment at a point by unit displacements and rotations of it: the inverse of `flexibility`.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            End-point stiffness, global, (..., 6, 6); NaN where nothing holds the point in some direction.

        Raises
        ------
        FrameError
            If links and joints are rigid on the way to the point, so that it cannot give way in some direction.
        """
        from .statics.accuracy import stiffness

        return stiffness(self, point, link)

    def frequencies(self, count: int) -> Array:
        """The lowest natural frequencies at every pose, under springs, loads and weights; drives held, no clearances.

        Parameters
        ----------
        count
            Number of frequencies.

        Returns
        -------
        ndarray
            Hz, (..., count); NaN where the pose is unstable.
        """
        from .statics.accuracy import frequencies

        return frequencies(self, count)

    def stress(self, link: str) -> Stress:
        """Stress along the members of a link under the linkage's loads and its inertia, clearances closed.

        Loads that were given to a frame of the motion alone are not among them.

        Parameters
        ----------
        link
            The link.

        Returns
        -------
        Stress
            By pose, and the envelope over all poses.

        Raises
        ------
        FrameError
            If the link is rigid.
        """
        from .statics.accuracy import stress

        self._check_frames("stress()")
        return stress(self, link)

    # -- states and rates -------------------------------------------------------------------------------------------

    @cached_property
    def velocities(self) -> tuple[list[Value], list[Value]]:
        """Velocity coordinates and their time derivatives, entries (...) of the batch shape."""
        return _rates(self)

    def _pose(self, link: str) -> tuple[list[Value], list[list[Value]]]:
        if link not in self._poses:
            twelve = self._run(self.mechanism.pose_of(self._known(link)), self.assembly.state)
            self._poses[link] = twelve[:3], [twelve[3:6], twelve[6:9], twelve[9:12]]
        return self._poses[link]

    @cached_property
    def _poses(self) -> dict[str, tuple[list[Value], list[list[Value]]]]:
        return {}

    def _rates(self, link: str) -> list[list[Value]]:
        """Angular velocity, velocity of the reference point, and both accelerations, in the ground's axes."""
        if link == GROUND:
            return [[0.0, 0.0, 0.0]] * 4
        if link not in self._moves:
            twelve = self._run(self.mechanism.rates_of(self._known(link)), self.assembly.state, *self.velocities)
            self._moves[link] = [twelve[k : k + 3] for k in range(0, 12, 3)]
        return self._moves[link]

    @cached_property
    def _moves(self) -> dict[str, list[list[Value]]]:
        return {}

    def _run(self, program: tuple[Program, Program], *inputs: Sequence[Value]) -> list[Value]:
        """Results of a program, entry by entry, NaN where the pose is not assembled."""
        state, *others = inputs
        found: Sequence[Value] = program[1](state, self.mechanism.parameters, *others)
        if self.assembly.all_closed:
            return list(found)
        return [np.where(self.assembly.closed, x, np.nan) for x in found]

    # -- in global axes ---------------------------------------------------------------------------------------------

    def _position(self, link: str, place: Array) -> Array:
        ground = self.mechanism.bodies[GROUND]
        if link == GROUND:
            return np.broadcast_to(place, (*np.broadcast_shapes(self.shape, place.shape[:-1]), 3))
        origin, axes = self._pose(link)
        there = [x + y for x, y in zip(origin, self._arm(link, axes, place), strict=True)]
        return np.asarray(self._global(there, self.mechanism.size) + ground.place)

    def _arm(self, link: str, axes: list[list[Value]], place: Array) -> list[Value]:
        """Vector from the link's reference point to a place, in the ground's axes."""
        return _combined(axes, self.mechanism.arm(link, place))

    def _velocity_at(self, link: str, place: Array) -> Array:
        omega, v, _, _ = self._rates(link)
        if link == GROUND:
            return np.zeros((*self.shape, 3))
        arm = self._arm(link, self._pose(link)[1], place)
        return self._global([x + y for x, y in zip(v, _cross(omega, arm), strict=True)], self.mechanism.size)

    def _acceleration_at(self, link: str, place: Array) -> Array:
        omega, _, alpha, a = self._rates(link)
        if link == GROUND:
            return np.zeros((*self.shape, 3))
        arm = self._arm(link, self._pose(link)[1], place)
        turning, inward = _cross(alpha, arm), _cross(omega, _cross(omega, arm))
        return self._global([x + y + z for x, y, z in zip(a, turning, inward, strict=True)], self.mechanism.size)

    def _global(self, components: Sequence[Value], scale: float = 1.0) -> Array:
        """Vector (..., 3) in global axes from entries in the ground's axes."""
        shape = np.broadcast_shapes(self.shape, *(np.shape(x) for x in components))
        out = np.empty((*shape, 3))
        for k, x in enumerate(components):
            out[..., k] = x * scale
        if self.mechanism.upright:
            return out
        return np.asarray(np.einsum("...ij,...j->...i", self.mechanism.bodies[GROUND].drawn_axes, out))

    # -- look-up ----------------------------------------------------------------------------------------------------

    def _known(self, link: str) -> str:
        if link not in self.linkage.links:
            raise FrameError(f"the linkage has no link {link!r}: choose one of {', '.join(self.linkage.links)}")
        return link

    def _on(self, point: str, link: str | None) -> tuple[str, Array]:
        name, _ = self.linkage.end(point if link is None else (link, point), "the motion")
        return name, self.mechanism.place(name, point)


def loads_of(frame: Frame) -> tuple[int, ...]:
    """How many loads a frame has at nodes and on members, and which weight."""
    given = (frame.loads, frame.member_loads)
    return *(sum(map(len, loads.values())) for loads in given), 0 if frame.weight is None else id(frame.weight)


def _drawn(place: ArrayLike) -> Array:
    given = np.asarray(place, dtype=np.float64)
    if given.shape[-1:] == (2,):
        given = np.concatenate([given, np.zeros((*given.shape[:-1], 1))], axis=-1)
    return vector(given, "place on a link")


def _combined(axes: Sequence[Sequence[Value]], components: Sequence[Value]) -> list[Value]:
    return [_sum((axis[k], x) for axis, x in zip(axes, components, strict=True)) for k in range(3)]


def _sum(pairs: object) -> Value:
    total: Value = 0.0
    for a, b in pairs:  # type: ignore[attr-defined]
        if not (_is_zero(a) or _is_zero(b)):
            total = total + a * b
    return total


def _is_zero(x: Value) -> bool:
    return isinstance(x, float) and x == 0.0


def _cross(a: Sequence[Value], b: Sequence[Value]) -> list[Value]:
    return [
        _sum([(a[1], b[2]), (_minus(a[2]), b[1])]),
        _sum([(a[2], b[0]), (_minus(a[0]), b[2])]),
        _sum([(a[0], b[1]), (_minus(a[1]), b[0])]),
    ]


def _minus(x: Value) -> Value:
    return x if _is_zero(x) else -x


def _rates(motion: Motion) -> tuple[list[Value], list[Value]]:
    found, drives, mechanism = motion.assembly, motion.drives, motion.mechanism
    loops, shape = found.loops, motion.shape
    count = len(mechanism.columns)
    first, second = ([np.empty(shape) for _ in range(count)] for _ in range(2))
    for block in blocks(shape):
        state, parameters = cut_all(found.state, block), cut_all(mechanism.parameters, block)
        v = loops.velocities(state, parameters, cut_all(drives.rates, block))
        w = loops.accelerations(state, parameters, v, cut_all(drives.accelerations, block))
        for k in range(count):
            first[k][block], second[k][block] = v[k], w[k]
    for patch in found.patches:
        members = np.broadcast_to(patch.members, shape)
        spread = np.broadcast_to(np.cumsum(patch.members).reshape(patch.members.shape) - 1, shape)[members]
        for k, follow, bend in zip(mechanism.unknown, patch.follow, patch.bend, strict=True):
            rate = np.broadcast_to(drives.rates[patch.drive], shape)[members]
            speeds_up = np.broadcast_to(drives.accelerations[patch.drive], shape)[members]
            first[k][members] = follow[spread] * rate
            second[k][members] = follow[spread] * speeds_up + bend[spread] * rate**2
    return list(first), list(second)
