"""The motion of a linkage: where it is, and what can be asked of it there."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from weakref import WeakKeyDictionary

from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.frame import Frame
from ...framework.renamed import RenamedAttribute
from .poses.coordinates import coordinate_of, rates_of_coordinate
from .statics.accuracy import PointAccuracy, Stress, accuracy, compliance_matrix, frequencies, stiffness, stress
from .statics.actions import kinetic_energy
from .statics.frame import FramedPoses, frame
from .statics.free import free_accelerations
from .statics.reactions import Reactions, reactions
from .statics.transmission import transmission_angle


class LoadsWarning(UserWarning):
    """What is asked of a motion does not contain the loads that one of its frames was given."""


@dataclass(frozen=True, eq=False, repr=False)
class Motion(FramedPoses):
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

    def __repr__(self) -> str:
        return f"<Motion of shape {self.shape} of {self.linkage!r}>"

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; frames that are in use in this one are not known there."""
        return {name: value for name, value in vars(self).items() if name != "frames"}

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
        return transmission_angle(self, joint)

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
            In the order of the kind's coordinates; ``reference`` in the reference configuration. Angles go on beyond a
            turn: they count the turns that the joint makes while the drives go to the pose from their reference values.
            Of a ball: the rotation vector, of length at most π.
        """
        return coordinate_of(self, self.linkage.joint(joint))

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

    # -- forces, compliance and clearance -----------------------------------------------------------------------------

    def reactions(self) -> Reactions:
        """Joint reactions and drive forces of the rigid linkage, by the Newton-Euler equations of all links.

        Inertia forces (Eq. 1 and 2 of the accuracy paper), gravity, loads, springs and dampers are in equilibrium with
        what the joints hold and the drives push. Where equilibrium alone does not tell all reactions, those follow
        from the compliance of links and joints; if these are rigid, the reactions with the least sum of squares are
        given (moments divided by half of what the linkage spans). ``.method`` says which.

        Loads that were given to a frame of the motion alone are not among them.

        Returns
        -------
        Reactions
            Reactions and drive forces; NaN where no finite forces keep the linkage in equilibrium.

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
        self._check_frames("reactions()")
        return reactions(self)

    def kinetic_energy(self) -> Array:
        """Kinetic energy of all links, (...)."""
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
        return free_accelerations(self, forces or {})

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

        The frame is linear about the linkage without loads: its links, joints and springs resist with their stiffness
        alone, and what springs exert at rest is one of the loads. That forces turn with the links, joints and springs
        that carry them (geometric stiffness) is in `compliance_matrix`, `stiffness` and `frequencies` of the motion,
        and of the frame in ``buckling`` and ``solve(large=True)``, where springs pull along their line wherever they
        are.

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
        from .export import save  # what it writes with takes long to load

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
        return accuracy(self, point, link, load, inertia=inertia)

    def compliance_matrix(self, point: str, link: str | None = None) -> Array:
        """Displacement and rotation of a point by unit forces and moments on it, drives locked, clearances closed.

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
        return compliance_matrix(self, point, link)

    flexibility = RenamedAttribute("compliance_matrix")

    def stiffness(self, point: str, link: str | None = None) -> Array:
        """Force and moment at a point by unit displacements and rotations of it: the inverse of `compliance_matrix`.

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
            If links and joints are rigid on the way to the point, so that it cannot deflect in some direction.
        """
        return stiffness(self, point, link)

    def frequencies(self, count: int) -> Array:
        """The lowest natural frequencies at every pose, under springs, loads and weights; drives locked, no clearances.

        Parameters
        ----------
        count
            Number of frequencies.

        Returns
        -------
        ndarray
            Hz, (..., count); NaN where the pose is unstable.
        """
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
        self._check_frames("stress()")
        return stress(self, link)


def loads_of(frame: Frame) -> tuple[int, ...]:
    """How many loads a frame has at nodes and on members, and which weight."""
    given = (frame.loads, frame.member_loads)
    return *(sum(map(len, loads.values())) for loads in given), 0 if frame.weight is None else id(frame.weight)
