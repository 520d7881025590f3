"""The description of a linkage: one assembled position, links, joints, drives, springs and loads."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...elements import Beam
from ...framework.batch import Array, Shape, finite, joined, vector
from ...framework.errors import FrameError
from .parts import GROUND, Link, Load, Pair, Spring, beams_of, inertia_of, joint_axes, kind_of

if TYPE_CHECKING:
    from .dead_points import DeadPoint, DriveRange
    from .mechanism import Mechanism
    from .mobility import Mobility
    from .motion import Motion

Z = (0.0, 0.0, 1.0)
End = str | tuple[str, str]


class Linkage:
    """Links joined by joints, drawn in one position in which it is assembled.

    Every number may carry a batch; all broadcast.

    Parameters
    ----------
    points
        Points by name, for names that are no Python identifiers; coordinates (..., 2) or (..., 3).
    named
        Points by keyword.

    Attributes
    ----------
    points
        Coordinates (..., 3) as drawn, by name.
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
    kept
        The mechanism that was compiled last, taken up again as long as the description stays the same.

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

    def __init__(self, points: Mapping[str, ArrayLike] | None = None, /, **named: ArrayLike) -> None:
        self.points: dict[str, Array] = {}
        self.links: dict[str, Link] = {}
        self.joints: dict[str, Pair] = {}
        self.drives: dict[str, tuple[str, ...]] = {}
        self.springs: list[Spring] = []
        self.loads: list[Load] = []
        self.weight: Array = np.zeros(3)
        self._shapes: dict[str, Shape] = {}
        self.kept: tuple[tuple[object, ...], Mechanism] | None = None
        for name, place in {**(points or {}), **named}.items():
            self.point(name, place)

    @property
    def shape(self) -> Shape:
        """Batch shape of the drawing."""
        return np.broadcast_shapes(*self._shapes.values())

    @property
    def version(self) -> tuple[object, ...]:
        """What the compiled mechanism depends on; equal as long as points, links, joints and drives are the same."""
        parts = (self.points, self.links, self.joints)
        return *(tuple(map(id, part.values())) for part in parts), tuple(self.drives.items())

    # -- points and links -------------------------------------------------------------------------------------------

    def point(self, name: str, place: ArrayLike) -> None:
        """Add a point.

        Parameters
        ----------
        name
            Its name.
        place
            Coordinates as drawn, (..., 2) in the plane z = 0, or (..., 3).

        Raises
        ------
        FrameError
            If the name is taken, or `place` is not two or three finite numbers.
        """
        if name in self.points:
            raise FrameError(f"point {name!r} is there already: choose another name")
        given = finite(place, f"point {name!r}")
        if given.shape[-1:] == (2,):
            given = np.concatenate([given, np.zeros((*given.shape[:-1], 1))], axis=-1)
        given = vector(given, f"point {name!r}") + 0.0
        self._join(f"point {name!r}", given.shape[:-1])
        self.points[name] = given

    def link(
        self,
        name: str,
        *points: str,
        beam: Beam | Mapping[tuple[str, str], Beam] | None = None,
        beams: Sequence[tuple[str, str]] | None = None,
        mass: ArrayLike | None = None,
        centre: ArrayLike | None = None,
        inertia: ArrayLike | None = None,
        length: ArrayLike | None = None,
    ) -> None:
        """Add a link: a body with points on it.

        Parameters
        ----------
        name
            Its name.
        points
            Names of its points, one or more; beams follow them in this order.
        beam
            Beam of each part, or a mapping from pairs of points to beams; None for a rigid link.
        beams
            Pairs of points between which beams run, where they do not follow the points.
        mass, centre, inertia
            Mass (...), centre of mass as drawn (..., 2 or 3), and inertia about it in drawn axes: a tensor
            (..., 3, 3), six numbers xx yy zz xy yz zx, or one number about z. Where not given, those of the beams.
        length
            True length (...) of a link of two points where the drawing does not have it: the second point then lies
            this far from the first. The drawing is where the assembly starts.

        Raises
        ------
        FrameError
            If the name is taken, a point is unknown or given twice, or a number is not what it should be.
        """
        if name in self.links or name == GROUND:
            raise FrameError(f"link {name!r} is there already: choose another name")
        if not points:
            raise FrameError(f"link {name!r} has no points: name the points that lie on it")
        for point in points:
            self._point(point, f"link {name!r}")
        if len(set(points)) < len(points):
            raise FrameError(f"link {name!r} has points {', '.join(points)}: name each point once")
        true = None if length is None else self._above_zero(length, f"length of link {name!r}")
        if true is not None:
            if len(points) != 2:
                raise FrameError(f"link {name!r} has {len(points)} points: length= needs exactly two; move its points")
            if np.any(np.all(self.points[points[0]] == self.points[points[1]], axis=-1)):
                raise FrameError(f"link {name!r}: {points[0]} and {points[1]} coincide: draw them apart for length=")
            self._join(f"length of link {name!r}", true.shape)
        self.links[name] = Link(
            name,
            points,
            beams_of(name, points, beam, beams),
            None if mass is None else self._not_negative(mass, f"mass of link {name!r}"),
            None if centre is None else _place(centre, f"centre of link {name!r}"),
            inertia_of(name, inertia),
            true,
        )

    # -- joints -----------------------------------------------------------------------------------------------------

    def revolute(
        self,
        point: str,
        first: str,
        *others: str,
        axis: ArrayLike = Z,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join links by a pin: the second turns about the axis, which the first carries.

        Parameters
        ----------
        point
            Where the pin is.
        first, others
            Links that it joins; with several, `first` carries the pin and each other link has a joint of its own
            with it, named by the joint's name, and from the second on with ``.link`` behind it.
        axis
            Direction of the axis as drawn, (..., 3).
        drive
            True where the angle is driven.
        stiffness
            Six springs in the joint's axes, (..., 6), 0 to inf; inf on what the joint holds where None.
        clearance
            Radial clearance, (...).
        name
            The joint's name; its point, or ``point.kind`` where that is taken.
        at
            Angle in the drawing, radians, (...).
        """
        self._add("revolute", point, (first, *others), axis, None, drive, stiffness, clearance, name, at, None)

    def prismatic(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a slider: the second slides along the axis, which the first carries.

        Parameters
        ----------
        point
            Where it is as drawn; the point must be on both links.
        first, second
            Links that it joins.
        axis
            Direction of sliding as drawn, (..., 3).
        drive
            True where the displacement is driven.
        stiffness, clearance, name
            As for `revolute`.
        at
            Displacement in the drawing, (...).
        """
        self._add("prismatic", point, (first, second), axis, None, drive, stiffness, clearance, name, at, None)

    def cylindrical(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join two links so that the second slides along the axis and turns about it; the first carries it.

        Parameters
        ----------
        point
            Where it is as drawn.
        first, second
            Links that it joins.
        axis
            Direction of the axis as drawn, (..., 3).
        drive
            True where both coordinates are driven, ``"uz"`` or ``"rz"`` where one is.
        stiffness, clearance, name
            As for `revolute`.
        at
            Displacement and angle in the drawing, (..., 2).
        """
        self._add("cylindrical", point, (first, second), axis, None, drive, stiffness, clearance, name, at, None)

    def spherical(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a ball.

        Parameters
        ----------
        point
            Where it is.
        first, second
            Links that it joins.
        axis
            z of the joint's axes as drawn, (..., 3).
        drive
            True where the rotation is driven.
        stiffness, clearance, name
            As for `revolute`.
        at
            Rotation vector in the drawing, in the joint's axes, (..., 3).
        """
        self._add("spherical", point, (first, second), axis, None, drive, stiffness, clearance, name, at, None)

    def universal(
        self,
        point: str,
        first: str,
        second_link: str,
        *,
        axis: ArrayLike,
        second: ArrayLike,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a cross (Cardan, Hooke): it turns about an axis of each.

        Parameters
        ----------
        point
            Where the axes meet.
        first, second_link
            Links that it joins.
        axis
            Axis on the first link as drawn, (..., 3): z of the joint.
        second
            Axis on the second link as drawn, (..., 3), perpendicular to `axis`: x of the joint.
        drive
            True where both angles are driven, ``"rz"`` (about the first axis) or ``"rx"`` where one is.
        stiffness, clearance, name
            As for `revolute`.
        at
            The two angles in the drawing, radians, (..., 2).
        """
        self._add("universal", point, (first, second_link), axis, second, drive, stiffness, clearance, name, at, None)

    def planar(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a plane on which the second slides and turns; the first carries it.

        Parameters
        ----------
        point
            A point of the plane that both links have.
        first, second
            Links that it joins.
        axis
            Normal of the plane as drawn, (..., 3).
        drive
            True where all three coordinates are driven; ``"ux"``, ``"uy"`` or ``"rz"`` where one is.
        stiffness, clearance, name
            As for `revolute`.
        at
            Two displacements and the angle in the drawing, (..., 3).
        """
        self._add("planar", point, (first, second), axis, None, drive, stiffness, clearance, name, at, None)

    def screw(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike,
        pitch: ArrayLike,
        drive: bool | str = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        at: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a screw: the second turns about the axis and advances with it; the first carries it.

        Parameters
        ----------
        point
            Where it is as drawn.
        first, second
            Links that it joins.
        axis
            Direction of the axis as drawn, (..., 3).
        pitch
            Advance along the axis per turn, (...); below zero for a left-hand thread.
        drive
            True where the angle is driven.
        stiffness, clearance, name
            As for `revolute`.
        at
            Angle in the drawing, radians, (...).
        """
        self._add("screw", point, (first, second), axis, None, drive, stiffness, clearance, name, at, pitch)

    def fixed(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
    ) -> None:
        """Join two links firmly.

        Parameters
        ----------
        point
            Where they are joined.
        first, second
            Links that it joins.
        axis
            z of the joint's axes as drawn, (..., 3).
        stiffness, clearance, name
            As for `revolute`.
        """
        self._add("fixed", point, (first, second), axis, None, False, stiffness, clearance, name, 0.0, None)

    def drive(self, joint: str, *coordinates: str) -> None:
        """Drive a joint made elsewhere.

        Parameters
        ----------
        joint
            Its name.
        coordinates
            Which of its coordinates, such as ``"rz"``; all where none is named.

        Raises
        ------
        FrameError
            If there is no such joint or coordinate.
        """
        free = self.joint(joint).kind.coordinates
        if not free:
            raise FrameError(f"joint {joint!r} is fixed: drive another, or make it a joint with a coordinate")
        wrong = [name for name in coordinates if name not in free]
        if wrong:
            raise FrameError(f"joint {joint!r} has no coordinate {wrong[0]!r}: choose of {', '.join(free)}")
        self.drives[joint] = tuple(name for name in free if not coordinates or name in coordinates)

    # -- springs and loads ------------------------------------------------------------------------------------------

    def spring(
        self, first: End, second: End, *, stiffness: ArrayLike, length: ArrayLike, damping: ArrayLike = 0.0
    ) -> None:
        """Put a spring, with a damper beside it, between two points.

        Parameters
        ----------
        first, second
            A point, or ``(link, point)`` where several links have it.
        stiffness
            Force per length, (...).
        length
            Length without force, (...).
        damping
            Force per speed, (...).

        Raises
        ------
        FrameError
            If an end is unknown or a number is below zero.
        """
        ends = self.end(first, "spring"), self.end(second, "spring")
        between = f"of the spring {ends[0][1]}-{ends[1][1]}"
        numbers = (("stiffness", stiffness), ("length", length), ("damping", damping))
        self.springs.append(Spring(*ends, *(self._not_negative(v, f"{what} {between}") for what, v in numbers)))

    def load(
        self,
        point: str,
        *,
        link: str | None = None,
        fx: ArrayLike = 0.0,
        fy: ArrayLike = 0.0,
        fz: ArrayLike = 0.0,
        mx: ArrayLike = 0.0,
        my: ArrayLike = 0.0,
        mz: ArrayLike = 0.0,
    ) -> None:
        """Load a point with a force and a moment, global.

        Parameters
        ----------
        point
            The point.
        link
            The link that carries the load; the first that has the point where None.
        fx, fy, fz, mx, my, mz
            Components, (...).
        """
        where = self.end(point if link is None else (link, point), "load")
        self.loads.append(Load(*where, _six(f"load on {point!r}", fx, fy, fz, mx, my, mz)))

    def torque(self, link: str, *, mx: ArrayLike = 0.0, my: ArrayLike = 0.0, mz: ArrayLike = 0.0) -> None:
        """Load a link with a moment, global.

        Parameters
        ----------
        link
            The link.
        mx, my, mz
            Components, (...).
        """
        self._link(link, "torque")
        self.loads.append(Load(link, None, _six(f"torque on {link!r}", 0.0, 0.0, 0.0, mx, my, mz)))

    def gravity(self, acceleration: ArrayLike) -> None:
        """Let gravity act on all links.

        Parameters
        ----------
        acceleration
            Acceleration of gravity, global, (..., 2 or 3).
        """
        self.weight = _place(acceleration, "gravity")

    # -- motion -----------------------------------------------------------------------------------------------------

    def move(
        self,
        drives: Mapping[str, ArrayLike] | None = None,
        /,
        *,
        rates: Mapping[str, ArrayLike] | None = None,
        accelerations: Mapping[str, ArrayLike] | None = None,
        branch: str = "keep",
        **named: ArrayLike,
    ) -> Motion:
        """Move the drives and let everything follow.

        Parameters
        ----------
        drives
            Values of the driven coordinates by joint, (...), or (..., f) where f of a joint are driven, for names
            that are no Python identifiers. A drive without values stays as drawn.
        rates, accelerations
            Their first and second derivatives by time, by joint; 0 where not given. Those of a spherical joint are
            its angular velocity and acceleration, in the joint's axes on the first link.
        branch
            ``"keep"``: through a change point the motion goes on smoothly; ``"switch"``: it takes the other branch.
        named
            Values by keyword.

        Returns
        -------
        Motion
            Where everything is, batch shape the broadcast of drives and drawing.

        Raises
        ------
        FrameError
            If a drive is unknown, shapes do not broadcast, or the linkage hangs in the air.
        """
        from .motion import move

        return move(self, {**(drives or {}), **named}, rates or {}, accelerations or {}, branch)

    def mobility(self) -> Mobility:
        """How many freedoms the linkage has, by counting and in truth; see `mobility.mobility`.

        Returns
        -------
        Mobility
            Freedoms, idle links, redundant constraints.

        Examples
        --------
        Flat, a parallelogram can begin to move in two ways; it has one freedom all the same.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(3, 0), D=(2, 0))
        >>> for link in ("AB", "BC", "CD"):
        ...     linkage.link(link, *link)
        >>> links = ("ground", "AB", "BC", "CD", "ground")
        >>> for k, pin in enumerate("ABCD"):
        ...     linkage.revolute(pin, links[k], links[k + 1])
        >>> print(linkage.mobility())
        mobility 1; 1 by count in the plane, -2 by count in space
        as drawn it is singular: velocities have 2 freedoms
        3 constraints too many: C (uz rx ry)
        """
        from .mobility import mobility

        return mobility(self)

    def dead_points(self, joint: str, coordinate: str | None = None) -> tuple[DeadPoint, ...]:
        """Dead points and change points on the way through the drawing; see `dead_points.dead_points`.

        Parameters
        ----------
        joint
            The joint that drives: one of the drives, the others standing still, or any joint in place of a single
            drive.
        coordinate
            Which of its coordinates, where there are several.

        Returns
        -------
        tuple of DeadPoint
            In the order of the drive's coordinate.

        Examples
        --------
        A piston is powerless where crank and rod, 1 and 3 long, lie in line.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(0, 1), C=(8**0.5, 0))
        >>> linkage.link("crank", "A", "B")
        >>> linkage.link("rod", "B", "C")
        >>> linkage.link("piston", "C")
        >>> linkage.revolute("A", "ground", "crank")
        >>> linkage.revolute("B", "crank", "rod")
        >>> linkage.revolute("C", "rod", "piston")
        >>> linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), at=8**0.5, name="slide", drive=True)
        >>> [(round(point.value, 12), point.joint) for point in linkage.dead_points("slide")]
        [(2.0, 'B'), (4.0, 'B')]
        """
        from .dead_points import dead_points

        return dead_points(self, joint, coordinate)

    def drive_range(self, joint: str, coordinate: str | None = None) -> DriveRange:
        """How far a drive can go from the drawing; see `dead_points.drive_range`.

        Parameters
        ----------
        joint, coordinate
            As for `dead_points`.

        Returns
        -------
        DriveRange
            Least and greatest coordinate, and the joints that stop the drive there.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(0, 1), C=(1, 1), D=(1, 0))
        >>> for link in ("AB", "BC", "CD"):
        ...     linkage.link(link, *link)
        >>> links = ("ground", "AB", "BC", "CD", "ground")
        >>> for k, pin in enumerate("ABCD"):
        ...     linkage.revolute(pin, links[k], links[k + 1])
        >>> linkage.drive_range("A").upper
        inf
        """
        from .dead_points import drive_range

        return drive_range(self, joint, coordinate)

    # -- look-up ----------------------------------------------------------------------------------------------------

    def joint(self, name: str) -> Pair:
        """A joint by its name.

        Parameters
        ----------
        name
            The joint's name.

        Returns
        -------
        Pair
            The joint.

        Raises
        ------
        FrameError
            If there is none.
        """
        if name not in self.joints:
            raise FrameError(f"the linkage has no joint {name!r}: choose one of {', '.join(self.joints) or 'none yet'}")
        return self.joints[name]

    def end(self, where: End, what: str = "the linkage") -> tuple[str, str]:
        """``(link, point)`` of a point, or of a link and a point.

        Parameters
        ----------
        where
            A point, which means the first link that has it, or ``(link, point)``.
        what
            Who asks, for the error.

        Returns
        -------
        tuple of str
            Link, ``"ground"`` where no link has the point, and point.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.
        """
        if isinstance(where, str):
            self._point(where, what)
            return next((name for name, link in self.links.items() if where in link.points), GROUND), where
        link, point = where
        self._point(point, what)
        if link != GROUND and point not in self._link(link, what).points:
            raise FrameError(
                f"{what}: link {link!r} has no point {point!r}: it has {', '.join(self.links[link].points)}"
            )
        return link, point

    def _point(self, name: str, what: str) -> Array:
        if name not in self.points:
            raise FrameError(
                f"{what}: there is no point {name!r}: choose one of {', '.join(self.points) or 'none yet'}"
            )
        return self.points[name]

    def _link(self, name: str, what: str) -> Link:
        if name not in self.links:
            raise FrameError(f"{what}: there is no link {name!r}: choose one of {', '.join(self.links) or 'none yet'}")
        return self.links[name]

    # -- adding -----------------------------------------------------------------------------------------------------

    def _add(
        self,
        kind_name: str,
        point: str,
        links: tuple[str, ...],
        axis: ArrayLike,
        second_axis: ArrayLike | None,
        drive: bool | str,
        stiffness: ArrayLike | None,
        clearance: ArrayLike | None,
        name: str | None,
        at: ArrayLike,
        pitch: ArrayLike | None,
    ) -> None:
        kind = kind_of(kind_name)
        name = self._joint_name(name, point, kind_name)
        what = f"joint {name!r}"
        self._check_links(what, point, links)
        if drive and len(links) > 2:
            raise FrameError(f"{what} joins {len(links)} links: drive one of its joints by name, drive({name!r})")
        axes = joint_axes(name, axis, second_axis)
        angles = self._coordinates(what, kind.freedom, at)
        turn = None if pitch is None else finite(pitch, f"pitch of {what}")
        springs = None if stiffness is None else _springs(what, stiffness)
        play = None if clearance is None else self._not_negative(clearance, f"clearance of {what}")
        shapes = (axes.shape[:-2], angles.shape[:-1], () if turn is None else turn.shape)
        for of, shape in zip(("axis", "at", "pitch"), shapes, strict=True):
            self._join(f"{of} of {what}", shape)
        for index, other in enumerate(links[1:]):
            own = name if index == 0 else f"{name}.{other}"
            if own in self.joints:
                raise FrameError(f"joint {own!r} is there already: give this one another name=")
            self.joints[own] = Pair(own, kind, point, links[0], other, axes, angles, springs, play, turn)
        if drive:
            self.drive(name, *([drive] if isinstance(drive, str) else []))

    def _joint_name(self, name: str | None, point: str, kind: str) -> str:
        choices = [point, f"{point}.{kind}"] if name is None else [name]
        for choice in choices:
            if choice not in self.joints:
                return choice
        raise FrameError(f"joint {choices[-1]!r} is there already: give this one another name=")

    def _check_links(self, what: str, point: str, links: tuple[str, ...]) -> None:
        self._point(point, what)
        if len(links) < 2:
            raise FrameError(f"{what} joins only {links[0]!r}: name the links that it joins, such as 'ground'")
        if len(set(links)) < len(links):
            raise FrameError(f"{what} joins {' and '.join(links)}: name different links")
        for link in links:
            if link != GROUND and point not in self._link(link, what).points:
                raise FrameError(
                    f"{what}: link {link!r} has no point {point!r}: add it to the link, which has "
                    f"{', '.join(self.links[link].points)}"
                )

    def _coordinates(self, what: str, freedom: int, at: ArrayLike) -> Array:
        given = finite(at, f"at of {what}")
        if freedom == 1:
            given = given[..., None]
        if given.ndim == 0:
            given = np.full(freedom, given)
        if given.shape[-1:] != (freedom,):
            raise FrameError(f"at of {what} has shape {given.shape}: its last axis must hold {freedom} coordinates")
        return given

    def _join(self, what: str, shape: Shape) -> None:
        joined(what, shape, self._shapes)
        self._shapes[what] = shape

    @staticmethod
    def _above_zero(value: ArrayLike, what: str) -> Array:
        given = finite(value, what)
        if np.any(given <= 0.0):
            raise FrameError(f"{what} is {given[given <= 0.0].flat[0]:g}: give a number above zero")
        return given

    @staticmethod
    def _not_negative(value: ArrayLike, what: str) -> Array:
        given = finite(value, what)
        if np.any(given < 0.0):
            raise FrameError(f"{what} is {given[given < 0.0].flat[0]:g}: give zero or above")
        return given


def _place(value: ArrayLike, what: str) -> Array:
    given = finite(value, what)
    if given.shape[-1:] == (2,):
        given = np.concatenate([given, np.zeros((*given.shape[:-1], 1))], axis=-1)
    return vector(given, what)


def _six(what: str, *components: ArrayLike) -> Array:
    return np.stack(np.broadcast_arrays(*(finite(value, what) for value in components)), axis=-1)


def _springs(what: str, value: ArrayLike) -> Array:
    springs = np.asarray(value, dtype=np.float64)
    if springs.shape[-1:] != (6,) or np.any(np.isnan(springs)) or np.any(springs < 0.0):
        raise FrameError(f"stiffness of {what} is {springs.tolist()}: give six springs ux uy uz rx ry rz, 0 to inf")
    return springs
