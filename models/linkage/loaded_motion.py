"""Forces in a moving linkage, and its deflection under load."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.frame import Frame
from .derivatives.thermal import Expansion, Temperature
from .statics.accuracy import PointAccuracy, Stress, accuracy, compliance_matrix, frequencies, stiffness, stress
from .statics.actions import kinetic_energy
from .statics.frame import FramedPoses, frame
from .statics.free import free_accelerations
from .statics.loading import loads_of
from .statics.reactions import Reactions, reactions


class LoadsWarning(UserWarning):
    """A result of a motion does not contain the loads that were added to one of its frames."""


@dataclass(frozen=True, eq=False, repr=False)
class LoadedMotion(FramedPoses):
    """Forces, compliance and clearance of a motion; see `Motion`."""

    def reactions(self) -> Reactions:
        """Joint reactions and drive forces of the rigid linkage, by the Newton-Euler equations of all links.

        Inertia forces (Eq. 1 and 2 of the accuracy paper), gravity, loads, springs and dampers are in equilibrium with
        the joint reactions and drive forces. If equilibrium alone does not determine all reactions, they follow from
        the compliance of links and joints; if these are rigid, the reactions with the least sum of squares are given
        (moments divided by half the linkage's largest extent). ``.method`` says which.

        Loads that were added to a frame of the motion are not included.

        Returns
        -------
        Reactions
            Force and moment in every joint, (..., 6), and of every drive, (..., f); NaN where no finite forces keep
            the linkage in equilibrium.

        Raises
        ------
        FrameError
            If masses, loads, springs or gravity do not broadcast with the motion.

        Warns
        -----
        LoadsWarning
            If loads were added to a frame of the motion.

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
        """Kinetic energy of all links at the motion's rates.

        The sum of ``m v^2 / 2 + w I w / 2`` over the links, v of the centre of mass and w the angular velocity
        (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 2).

        Returns
        -------
        ndarray
            Energy, (...); zero if no link has a mass.

        Raises
        ------
        FrameError
            If masses do not broadcast with the motion.

        Examples
        --------
        A mass of 3 kg that rotates at a radius of 2 m with 5 rad/s.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B", mass=3.0, centre=(2, 0), inertia=0.0)
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> float(linkage.move(A=0.0, rates={"A": 5.0}).kinetic_energy().round(9))
        150.0
        """
        return kinetic_energy(self)

    def free_accelerations(self, forces: Mapping[str, ArrayLike] | None = None) -> dict[str, Array]:
        """Acceleration of each drive under given drive forces, at the motion's poses and rates.

        At given rates, the drive forces of `reactions` are linear in the accelerations, ``M a + h``; this solves
        ``M a = f - h`` (Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 6).

        Parameters
        ----------
        forces
            Force or moment by driven joint, (...), or (..., f) if f coordinates are driven; zero by default.

        Returns
        -------
        dict of ndarray
            By driven joint, (..., f), length or radians per time squared.

        Raises
        ------
        FrameError
            If a joint is not driven, or the linkage has no inertia against one of its drives.

        Examples
        --------
        A pendulum with its mass at the end, released from a horizontal position: ``g / l`` (Featherstone 2008).

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B", mass=3.0, centre=(2, 0), inertia=0.0)
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.gravity((0, -10))
        >>> linkage.move(A=0.0).free_accelerations()["A"].round(9).tolist()
        [-5.0]
        """
        return free_accelerations(self, forces or {})

    def frame(self, *, clearance: bool = True, loads: bool = True, inertia: bool = False) -> Frame:
        """Make the frame of beams, joints and springs of the linkage at every pose, with its drives locked.

        Each link is a body, in whose axes its nodes do not move, so that its stiffness is computed once for all poses.
        A point of one link gives a node of the same name. A point of several links gives each its own node,
        ``point.link``, and the plain name stands for that of the first link. Members have the name of their link, or
        ``link.1``, ``link.2``, ...; joints have their names; springs are ``spring.1``, ... A universal joint becomes
        two: in ``joint.rz`` the cross turns about the axis on the first link, and ``joint`` is between the cross and
        the second link.

        A slider loads its guiding link at its place at each pose: on one of the beams along which its slot runs, at a
        point of the link, or, beyond them all, on a rigid extension of the nearest end. The slot runs along a beam if
        the angle between them is less than 0.01 radians and their distance less than a hundredth of the beam's length.
        If the slot does not run along a beam, as that of a yoke, the slider stands on a rigid arm from the joint's
        point. If it stands on different nodes at different poses, each of them is connected to the slider's node by a
        joint ``joint.link.on.node``, rigid at the poses at which the slider stands there and free at others.

        A mass that is given alone is distributed along the link's beams as their own mass is. A mass that is given with
        its centre or inertia is attached rigidly to the link's point nearest to its centre, the first of several that
        are equally near, and the beams are then massless.

        A rod between two spherical joints can spin about itself: nothing resists the spin, and it does not affect any
        other result. While no load works on the spin, the rod rotates about itself with its neighbour at the joint
        whose name comes first in the alphabet; under a moment about the rod its displacement has no bound
        (``mechanism``, NaN). With `inertia` the spin is accelerated by the loads.

        The frame is linear about the linkage without loads: links, joints and springs have their elastic stiffness, and
        the force of springs at rest is one of the loads. The effect of forces that rotate with their links, joints and
        springs (geometric stiffness) is included in `compliance_matrix`, `stiffness` and `frequencies` of the motion,
        and in ``buckling`` and ``solve(large=True)`` of the frame, where springs act along their line.

        Parameters
        ----------
        clearance
            Whether joints have their clearance.
        loads
            Whether the linkage's loads, torques, gravity, and forces of springs and dampers act. Loads that are added
            to the frame later act in the frame only, not in `reactions` or `stress`.
        inertia
            Whether the inertia forces of the rigid motion act.

        Returns
        -------
        Frame
            The frame; its batch shape is the broadcast of (...) with beams, stiffnesses and loads. Poses that are not
            assembled are excluded: their status is ``absent``.

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> frame = linkage.move(A=np.radians([0.0, 90.0])).frame()
        >>> frame.load("B", fy=10.0)
        >>> frame.solve().displacement("B")[:, 1].round(9).tolist()
        [0.0025, 2.5e-07]
        """
        built = frame(self, clearance=clearance, loads=loads, inertia=inertia)
        self.frames[built] = loads_of(built)
        return built

    @cached_property
    def frames(self) -> WeakKeyDictionary[Frame, tuple[object, ...]]:
        """Frames made from the motion that are still in use, with their loads when they were made."""
        return WeakKeyDictionary()

    def _check_frames(self, what: str) -> None:
        """Warn if loads were added to a frame of the motion, which results of the motion do not contain."""
        if any(loads_of(frame) != before for frame, before in self.frames.items()):
            warnings.warn(
                f"motion.{what} does not contain the loads that were given to a frame of this motion: loads given by "
                "linkage.load(...) act in both",
                LoadsWarning,
                stacklevel=3,
            )

    def accuracy(
        self,
        point: str,
        link: str | None = None,
        *,
        inertia: bool = False,
        temperature: Temperature | None = None,
        expansion: Expansion | None = None,
        **load: ArrayLike,
    ) -> PointAccuracy:
        """Displacement of a point of the loaded linkage: by compliance, clearance and expansion, and in total.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it lies; the first that has it if None.
        inertia
            Whether the inertia forces of the rigid motion act as well.
        temperature
            Rise of temperature of all links, (...), or by link, which may include the ``"ground"``, K. Links expand
            uniformly and move each other, to first order; the ground expands about its first pivot, the thread of a
            screw with the first link of its joint, and driven coordinates keep their values.
        expansion
            Coefficient of thermal expansion of these links, 1/K, or by link.
        **load
            Forces and moments on the point in addition to the linkage's own loads, ``fx fy fz mx my mz``, global,
            (...).

        Returns
        -------
        PointAccuracy
            Displacements ``ux uy uz rx ry rz`` by ``compliance``, by ``clearance``, ``thermal`` and in ``total``,
            (..., 6) each, length and radians, computed when they are read. For tolerances see `Linkage.study`.

        Raises
        ------
        FrameError
            If there is no such point or link, the link does not have the point, or a load component is unknown.

        Examples
        --------
        An arm of 1 m on a pin with 0.1 mm of clearance under a transverse load: its deflection ``F L^3 / (3 E I)``
        (Timoshenko, *Strength of Materials* I), and the clearance.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
        >>> found = linkage.move(A=0.0).accuracy("B", fy=10.0)
        >>> float(found.compliance[1].round(9)), float(found.clearance[1].round(9))
        (0.0025, 0.0001)
        """
        return accuracy(self, point, link, load, inertia=inertia, temperature=temperature, expansion=expansion)

    def compliance_matrix(self, point: str, link: str | None = None) -> Array:
        """Displacement and rotation of a point by unit forces and moments on it, drives locked, without clearance.

        It is taken at the pose under the linkage's springs, loads and weights, whose geometric stiffness makes elastic
        and rigid links stiffer or softer. For a linkage of one degree of freedom whose drive has a stiffness k it is
        ``1 / (k + V'')`` with the potential V of springs, loads and weights (Thompson & Hunt, *A General Theory of
        Elastic Stability*, 1973). All loads keep the direction that they have at the pose, even follower loads.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it lies; the first that has it if None.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` by ``fx fy fz mx my mz``, global, (..., 6, 6), symmetric; length per force, and
            radians per moment. NaN for rotations of, and moments on, a rod that can spin between two spherical joints,
            as its rotation under a moment about itself has no bound.

        Examples
        --------
        The tip of an arm of 1 m, ``L^3 / (3 E I)``.

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> float(linkage.move(A=0.0).compliance_matrix("B")[1, 1].round(12))
        0.00025
        """
        return compliance_matrix(self, point, link)

    def stiffness(self, point: str, link: str | None = None) -> Array:
        """Force and moment at a point by unit displacements and rotations of it: the inverse of `compliance_matrix`.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it lies; the first that has it if None.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` by ``ux uy uz rx ry rz``, global, (..., 6, 6), force per length and moment per radian;
            NaN where the point is kinematically unstable in some direction.

        Raises
        ------
        FrameError
            If links and joints between the ground and the point are rigid, so that it cannot deflect in some direction.

        Examples
        --------
        The tip of an arm of 1 m without rotation, ``12 E I / L^3`` (Przemieniecki 1968, Eq. 5.116).

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> float(linkage.move(A=0.0).stiffness("B")[1, 1].round(6))
        16000.0
        """
        return stiffness(self, point, link)

    def frequencies(self, count: int) -> Array:
        """The lowest natural frequencies at every pose under springs, loads and weights, drives locked, no clearance.

        Parameters
        ----------
        count
            Number of frequencies, from 1 to the number of unknowns of the frame.

        Returns
        -------
        ndarray
            Frequencies in Hz, (..., count); NaN where the pose is unstable. The zero frequencies of rods that can spin
            between two spherical joints are left out.

        Examples
        --------
        A clamped arm of 1 m, ``3.516 / (2 pi) sqrt(E I / m L^4)`` (Timoshenko, *Vibration Problems in Engineering*).

        >>> from linkframe.elements import Beam, Circle, Material
        >>> from linkframe.models import Linkage
        >>> steel = Material(E=200e9, nu=0.3, density=7850.0)
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Circle(diameter=0.02), steel, segments=8))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.move(A=0.0).frequencies(1).round(2).tolist()
        [14.12]
        """
        return frequencies(self, count)

    def stress(self, link: str) -> Stress:
        """Stress along the members of a link under the linkage's loads and inertia forces, without clearance.

        Loads that were added to a frame of the motion are not included.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        Stress
            Stress at stations along the members of the link, (..., members, stations, 3), its extremes by pose, and the
            envelope over all poses, force per area.

        Raises
        ------
        FrameError
            If there is no such link, or it is rigid.

        Examples
        --------
        An arm of 1 m under a transverse load of 10 N, ``s = M / W`` with ``W = b h^2 / 6`` (Timoshenko, *Strength of
        Materials* I).

        >>> from linkframe.elements import Beam, Material, Rectangle
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("arm", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.015), Material(E=200e9, nu=0.3)))
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.load("B", fy=10.0)
        >>> float((linkage.move(A=0.0).stress("arm").greatest / 1e6).round(6))
        10.0
        """
        self._check_frames("stress()")
        return stress(self, link)
