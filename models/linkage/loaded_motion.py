"""What acts on a moving linkage, and how far it deflects."""

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
    """What is asked of a motion does not contain the loads that one of its frames was given."""


@dataclass(frozen=True, eq=False, repr=False)
class LoadedMotion(FramedPoses):
    """Forces, compliance and clearance of a motion; see `Motion`."""

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
            Force and moment in every joint, (..., 6), and of every drive, (..., f); NaN where no finite forces keep
            the linkage in equilibrium.

        Raises
        ------
        FrameError
            If masses, loads, springs or gravity do not broadcast with the motion.

        Warns
        -----
        LoadsWarning
            Where a frame of the motion was given loads.

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
            Energy, (...); zero where no link has a mass.

        Raises
        ------
        FrameError
            If masses do not broadcast with the motion.

        Examples
        --------
        A mass of 3 kg that goes round at 2 m with 5 rad/s.

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

        With the rates as they are, the drive forces of `reactions` are linear in the accelerations,
        ``M a + h``; this solves ``M a = f - h`` (Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 6).

        Parameters
        ----------
        forces
            Force or moment by driven joint, (...), or (..., f) where f coordinates are driven; zero where not given.

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
        A pendulum let go from the level, its mass at its end: ``g / l`` (Featherstone 2008).

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
        """The linkage at every pose as a frame of beams, joints and springs, held at its drives.

        Each link is a body, in whose own axes its nodes do not move, so that its stiffness is computed once for all
        poses. A point that only one link has gives the node of its name; where joints part it each link has its own,
        ``point.link``, and the bare name means that of the first link. Members are called as their link, or
        ``link.1``, ``link.2``, ...; joints by their names; springs ``spring.1``, ... A universal joint is two: the
        cross turns about the axis on the first link in ``joint.rz``, all else is in ``joint``.

        A slider loads the link that carries it where it is at each pose: on any of the beams along which its slot
        runs, at a point of the link, or, where it is beyond them all, on a rigid prolongation of the nearest end. A
        beam counts where it leans from the slot by less than 0.01 radians and is off it by less than a hundredth of
        its length. Where the slot runs along no beam, as that of a yoke, the slider stands on a rigid arm from the
        joint's point. Where it changes from seat to seat with the pose, each seat is a joint ``joint.link.on.seat``
        between the link and the slider's node, rigid at the poses at which the slider stands there and free else.

        A mass that was given alone is spread along the link's beams as their own is. One that was given its place sits,
        rigid, on the link's point nearest to its centre, the first of those that are equally near, and the beams weigh
        nothing.

        A rod between two balls spins about itself: nothing resists that, and it has no part in any other result. As
        long as no load works on the spin, it rotates about itself as its neighbour does at that of both balls whose
        name comes first in the alphabet; a load that does, a moment about the rod, moves it without bound
        (``mechanism``, NaN). Under `inertia` the spin accelerates as the loads make it.

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
        """Where a point of the loaded linkage really goes: by compliance, clearance and expansion, and in total.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.
        inertia
            Let the inertia forces of the rigid motion act as well.
        temperature
            Rise of temperature of all links, (...), or by link, the ``"ground"`` among them, K. Links grow evenly and
            move each other, to first order; the ground grows about its first pivot, the thread of a screw with the
            link that carries its axis, and what a drive holds stays as it is.
        expansion
            Coefficient of thermal expansion of these links, 1/K, or by link.
        **load
            Forces and moments on the point beside the linkage's own loads, ``fx fy fz mx my mz``, global, (...).

        Returns
        -------
        PointAccuracy
            Displacements ``ux uy uz rx ry rz`` by ``compliance``, by ``clearance``, ``thermal`` and in ``total``,
            (..., 6) each, length and radians, computed when read. What tolerances do to them, `Linkage.study` tells.

        Raises
        ------
        FrameError
            If there is no such point or link, the link has it not, or a component of the load is unknown.

        Examples
        --------
        An arm of 1 m on a pin with 0.1 mm of clearance, loaded across: its compliance ``F L^3 / (3 E I)`` (Timoshenko,
        *Strength of Materials* I), and what the pin gives.

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
        """Displacement and rotation of a point by unit forces and moments on it, drives locked, clearances closed.

        About the pose under the linkage's springs, loads and weights: these make links stiffer or softer as they turn
        (geometric stiffness), rigid ones as well. On a linkage of one degree of freedom whose drive has a stiffness k
        it is ``1 / (k + V'')`` with the potential V of springs, loads and weights (Thompson & Hunt, *A General Theory
        of Elastic Stability*, 1973). Loads keep the direction that they have at the pose, those that turn with a link,
        too.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` by ``fx fy fz mx my mz``, global, (..., 6, 6); symmetric. Length per force, and
            radians per moment. NaN in the rotations of a rod that spins between two balls, and by moments on it, as a
            moment about it turns it without bound.

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
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            ``fx fy fz mx my mz`` by ``ux uy uz rx ry rz``, global, (..., 6, 6); NaN where nothing holds the point in
            some direction. Force per length, and moment per radian.

        Raises
        ------
        FrameError
            If links and joints are rigid on the way to the point, so that it cannot deflect in some direction.

        Examples
        --------
        The tip of an arm of 1 m while it does not rotate, ``12 E I / L^3`` (Przemieniecki 1968, Eq. 5.116).

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
        """The lowest natural frequencies at every pose, under springs, loads and weights; drives locked, no clearances.

        Parameters
        ----------
        count
            Number of frequencies, from 1 to the number of unknowns of the frame.

        Returns
        -------
        ndarray
            Hz, (..., count); NaN where the pose is unstable. The zeros of rods that spin between two balls are left
            out.

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
        """Stress along the members of a link under the linkage's loads and its inertia, clearances closed.

        Loads that were given to a frame of the motion alone are not among them.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        Stress
            At stations along the members of the link, (..., members, stations, 3), its extremes by pose, and the
            envelope over all poses, force per area.

        Raises
        ------
        FrameError
            If there is no such link, or it is rigid.

        Examples
        --------
        An arm of 1 m under 10 N across, ``s = M / W`` with ``W = b h^2 / 6`` (Timoshenko, *Strength of Materials* I).

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
