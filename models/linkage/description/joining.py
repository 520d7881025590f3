"""The joints of a linkage, and which of them are driven."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, finite, numbers
from ....framework.errors import FrameError
from ....framework.renamed import renamed_keywords
from .joints import COMPONENTS, Kind
from .parts import GROUND, Pair, joint_axes, kind_of
from .sketch import Sketch

Z = (0.0, 0.0, 1.0)


class Joining(Sketch):
    """A sketch whose links are joined; see `Linkage`."""

    @renamed_keywords(at="reference")
    def revolute(
        self,
        point: str,
        first: str,
        *others: str,
        axis: ArrayLike = Z,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        contact: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join links by a pin: the second turns about the axis, which the first carries.

        Parameters
        ----------
        point
            Where the pin is.
        first, *others
            Links that it joins; with several, `first` carries the pin and each other link has a joint of its own
            with it, named by the joint's name, and from the second on with ``.link`` behind it.
        axis
            Direction of the axis in the reference configuration, (..., 2 or 3).
        drive
            True where the angle is driven.
        stiffness
            Six springs in the joint's axes, (..., 6), 0 to inf; inf on what the joint constrains and on what is driven
            where None. On a coordinate that the joint leaves free it is that of a spring, which cannot be inf; on a
            driven one it is that of the drive, and with 0 nothing holds the frame there.
        clearance
            Radial clearance, (...).
        contact
            Direction in which the second link's pin centre lies from the first's, radians, (...): Eq. (11) of the
            accuracy paper. It is measured about the axis from x of the joint in the reference configuration, which is
            global x for an axis along z, and stays where the linkage turns. The clearance then is an offset in the
            joint, which ``motion.frame(clearance=False)`` leaves out and ``frame.solve(clearance=False)`` does not.
            Where None, the contact state follows from equilibrium.
        name
            The joint's name; its point, or ``point.kind`` where that is taken. A second joint of one kind between the
            same links at one point needs one.
        replace
            Whether it takes the place of the joint of that name, or where no name is given of that of its kind
            between the same links at the same point; it is new where there is none.
        reference
            Angle in the reference configuration, radians, (...).

        Raises
        ------
        FrameError
            If a name is taken or unknown, if there is such a joint already, or if a number is not what it should be;
            the linkage is then as it was.

        Examples
        --------
        A pin of 2e8 N/m with 0.1 mm of radial clearance about which both bars turn freely.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
        >>> linkage.link("left", "A", "B"); linkage.link("right", "B", "C")
        >>> linkage.revolute("B", "left", "right", stiffness=(2e8, 2e8, 2e8, 2e5, 2e5, 0.0), clearance=1e-4)
        >>> linkage.joint("B").kind.name
        'revolute'
        """
        self._add(
            "revolute",
            point,
            (first, *others),
            axis,
            None,
            drive,
            stiffness,
            clearance,
            name,
            reference,
            0.0,
            replace,
            contact,
        )

    @renamed_keywords(at="reference")
    def prismatic(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a slider: the second slides along the axis, which the first carries.

        Parameters
        ----------
        point
            Where it is in the reference configuration; the point must be on both links.
        first, second
            Links that it joins.
        axis
            Direction of sliding in the reference configuration, (..., 2 or 3).
        drive
            True where the displacement is driven.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Displacement in the reference configuration, length, (...).

        Raises
        ------
        FrameError
            As by `revolute`.

        Examples
        --------
        A slide that is driven along x from where it is.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0))
        >>> linkage.link("carriage", "A")
        >>> linkage.prismatic("A", "ground", "carriage", axis=(1, 0), drive=True)
        >>> linkage.move(A=[0.0, 0.25]).position("A", "carriage").tolist()
        [[0.0, 0.0, 0.0], [0.25, 0.0, 0.0]]
        """
        self._add(
            "prismatic", point, (first, second), axis, None, drive, stiffness, clearance, name, reference, 0.0, replace
        )

    @renamed_keywords(at="reference")
    def cylindrical(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join two links so that the second slides along the axis and turns about it; the first carries it.

        Parameters
        ----------
        point
            Where it is in the reference configuration.
        first, second
            Links that it joins.
        axis
            Direction of the axis in the reference configuration, (..., 2 or 3).
        drive
            True where both coordinates are driven, ``"uz"`` or ``"rz"`` where one is.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Displacement (length) and angle (radians) in the reference configuration, (..., 2).

        Raises
        ------
        FrameError
            As by `revolute`.

        Examples
        --------
        A sleeve on a shaft along z is pushed by 0.1 m and turned by 90°.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("sleeve", "A", "B")
        >>> linkage.cylindrical("A", "ground", "sleeve", drive=True)
        >>> linkage.move(A=(0.1, np.pi / 2)).position("B").round(12).tolist()
        [0.0, 1.0, 0.1]
        """
        links = first, second
        self._add("cylindrical", point, links, axis, None, drive, stiffness, clearance, name, reference, 0.0, replace)

    @renamed_keywords(at="reference")
    def spherical(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a ball.

        Parameters
        ----------
        point
            Name of the centre of the ball.
        first, second
            Links that it joins.
        axis
            Third axis z of the joint in the reference configuration, (..., 2 or 3).
        drive
            True where the rotation is driven.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Rotation vector in the reference configuration, in the joint's axes, radians, (..., 3).

        Raises
        ------
        FrameError
            As by `revolute`.

        Examples
        --------
        A rod on a ball is turned by 90° about y.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("rod", "A", "B")
        >>> linkage.spherical("A", "ground", "rod", drive=True)
        >>> linkage.move(A=(0.0, np.pi / 2, 0.0)).position("B").round(12).tolist()
        [0.0, 0.0, -1.0]
        """
        self._add(
            "spherical", point, (first, second), axis, None, drive, stiffness, clearance, name, reference, 0.0, replace
        )

    @renamed_keywords(at="reference")
    def universal(
        self,
        point: str,
        first: str,
        second_link: str,
        *,
        axis: ArrayLike,
        second: ArrayLike,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a cross (Cardan, Hooke): it turns about an axis of each.

        Parameters
        ----------
        point
            Where the axes meet.
        first, second_link
            Links that it joins.
        axis
            Axis on the first link in the reference configuration, (..., 2 or 3): z of the joint.
        second
            Axis on the second link in the reference configuration, (..., 2 or 3), perpendicular to `axis`: x of the
            joint.
        drive
            True where both angles are driven, ``"rz"`` (about the first axis) or ``"rx"`` where one is.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            The two angles in the reference configuration, radians, (..., 2).

        Raises
        ------
        FrameError
            As by `revolute`, or if the axes are not perpendicular.

        Examples
        --------
        Two shafts at 30° to each other, the second in a bearing: ``tan(out) = tan(in) / cos(30°)`` or its inverse, by
        where the cross starts (Shigley & Uicker, *Theory of Machines and Mechanisms*, on Hooke's joint).

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> tilt = np.radians(30.0)
        >>> out = np.array([np.cos(tilt), np.sin(tilt), 0.0])
        >>> linkage = Linkage(A=(-1, 0), C=(0, 0), D=out)
        >>> linkage.link("in", "A", "C"); linkage.link("out", "C", "D")
        >>> linkage.revolute("A", "ground", "in", axis=(1, 0), drive=True)
        >>> linkage.universal("C", "in", "out", axis=(0, 0, 1), second=(-out[1], out[0]))
        >>> linkage.cylindrical("D", "ground", "out", axis=out)
        >>> turned = linkage.move(A=np.radians(45.0)).coordinate("D")[1]
        >>> float((np.tan(turned) / np.cos(tilt)).round(12))
        1.0
        """
        links = first, second_link
        self._add("universal", point, links, axis, second, drive, stiffness, clearance, name, reference, 0.0, replace)

    @renamed_keywords(at="reference")
    def planar(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike = Z,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a plane on which the second slides and turns; the first carries it.

        Parameters
        ----------
        point
            A point of the plane that both links have.
        first, second
            Links that it joins.
        axis
            Normal of the plane in the reference configuration, (..., 2 or 3).
        drive
            True where all three coordinates are driven; ``"ux"``, ``"uy"`` or ``"rz"``, or several, where these are.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Two displacements (length) and the angle (radians) in the reference configuration, (..., 3).

        Raises
        ------
        FrameError
            As by `revolute`.

        Examples
        --------
        A plate on the table z = 0 is moved by (1, 2) and turned by 90°.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0))
        >>> linkage.link("plate", "A", "B")
        >>> linkage.planar("A", "ground", "plate", drive=True)
        >>> linkage.move(A=(1.0, 2.0, np.pi / 2)).position("B").round(12).tolist()
        [1.0, 3.0, 0.0]
        """
        self._add(
            "planar", point, (first, second), axis, None, drive, stiffness, clearance, name, reference, 0.0, replace
        )

    @renamed_keywords(at="reference")
    def screw(
        self,
        point: str,
        first: str,
        second: str,
        *,
        axis: ArrayLike,
        pitch: ArrayLike,
        drive: bool | Sequence[str] = False,
        stiffness: ArrayLike | None = None,
        clearance: ArrayLike | None = None,
        name: str | None = None,
        replace: bool = False,
        reference: ArrayLike = 0.0,
    ) -> None:
        """Join two links by a screw: the second turns about the axis and advances with it; the first carries it.

        Parameters
        ----------
        point
            Where it is in the reference configuration.
        first, second
            Links that it joins.
        axis
            Direction of the axis in the reference configuration, (..., 2 or 3).
        pitch
            Advance along the axis per turn, (...), length; below zero for a left-hand thread.
        drive
            True where the angle is driven.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Angle in the reference configuration, radians, (...).

        Raises
        ------
        FrameError
            As by `revolute`.

        Examples
        --------
        Half a turn of a thread with a pitch of 2 mm.

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0))
        >>> linkage.link("nut", "A")
        >>> linkage.screw("A", "ground", "nut", axis=(0, 0, 1), pitch=2e-3, drive=True)
        >>> linkage.move(A=np.pi).position("A", "nut").round(12).tolist()
        [0.0, 0.0, 0.001]
        """
        self._add(
            "screw", point, (first, second), axis, None, drive, stiffness, clearance, name, reference, pitch, replace
        )

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
        replace: bool = False,
    ) -> None:
        """Join two links firmly.

        Parameters
        ----------
        point
            Name of the point where they are joined.
        first, second
            Links that it joins.
        axis
            Third axis z of the joint in the reference configuration, (..., 2 or 3).
        stiffness, clearance, name, replace
            As for `revolute`.

        Raises
        ------
        FrameError
            As by `revolute`.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 1))
        >>> linkage.link("arm", "A", "B"); linkage.link("tool", "B", "C")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.fixed("B", "arm", "tool", stiffness=(1e8, 1e8, 1e8, 1e4, 1e4, 1e4))
        >>> linkage.mobility().actual
        1
        """
        self._add("fixed", point, (first, second), axis, None, False, stiffness, clearance, name, 0.0, 0.0, replace)

    def drive(self, joint: str, *coordinates: str) -> None:
        """Drive a joint made elsewhere.

        Parameters
        ----------
        joint
            Name of the joint.
        *coordinates
            Which of its coordinates, such as ``"rz"``; all where none is named.

        Raises
        ------
        FrameError
            If there is no such joint or coordinate.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm")
        >>> linkage.drive("A")
        >>> linkage.drives
        {'A': ('rz',)}
        """
        self.drives[joint] = driven_coordinates(joint, self.joint(joint).kind, coordinates or True)

    def check_free(self) -> None:
        """See that no stiffness holds a coordinate that its joint leaves free.

        Raises
        ------
        FrameError
            If a stiffness is inf on a coordinate that is free and not driven.
        """
        for name, pair in self.joints.items():
            for coordinate in set(pair.kind.coordinates) - set(self.drives.get(name, ())):
                if np.any(np.isinf(pair.full_stiffness[..., COMPONENTS.index(coordinate)])):
                    raise FrameError(
                        f"stiffness of joint {name!r} is inf on {coordinate}, which a {pair.kind.name} joint leaves "
                        "free: give 0 there, or the stiffness of a spring, or drive it, or take a joint that "
                        "constrains it"
                    )

    # -- adding -----------------------------------------------------------------------------------------------------

    def _add(
        self,
        kind_name: str,
        point: str,
        links: tuple[str, ...],
        axis: ArrayLike,
        second_axis: ArrayLike | None,
        drive: bool | Sequence[str],
        stiffness: ArrayLike | None,
        clearance: ArrayLike | None,
        name: str | None,
        reference: ArrayLike,
        pitch: ArrayLike,
        replace: bool,
        contact: ArrayLike | None = None,
    ) -> None:
        kind = kind_of(kind_name)
        name = self._joint_name(name, point, kind, links, replace=replace)
        what = f"joint {name!r}"
        self._check_links(what, point, links)
        driven = driven_coordinates(name, kind, drive)
        if driven and len(links) > 2:
            raise FrameError(f"{what} joins {len(links)} links: drive one of its joints by name, drive({name!r})")
        axes = joint_axes(name, axis, second_axis)
        angles = self._coordinates(what, kind.freedom, reference)
        turn = finite(pitch, f"pitch of {what}") if kind_name == "screw" else None
        springs = None if stiffness is None else _springs(what, stiffness)
        gap = None if clearance is None else self._not_negative(clearance, f"clearance of {what}")
        touch = None if contact is None else finite(contact, f"contact of {what}")
        if touch is not None and gap is None:
            raise FrameError(f"{what} has a contact angle and no clearance: give its clearance, too")
        shapes = {"axis": axes.shape[:-2], "reference": angles.shape[:-1], "pitch": () if turn is None else turn.shape}
        names = [name if index == 0 else f"{name}.{other}" for index, other in enumerate(links[1:])]
        taken = [own for own in names if own in self.joints]
        if taken and not replace:
            raise FrameError(f"joint {taken[0]!r} is there already: give this one another name=")
        self._join({f"{of} of {what}": shape for of, shape in shapes.items()}, instead=replace)
        for own, other in zip(names, links[1:], strict=True):
            self.joints[own] = Pair(own, kind, point, links[0], other, axes, angles, springs, gap, turn, touch)
            self.drives.pop(own, None)
        if driven:
            self.drives[name] = driven

    def _joint_name(self, name: str | None, point: str, kind: Kind, links: tuple[str, ...], *, replace: bool) -> str:
        choices = [point, f"{point}.{kind.name}"] if name is None else [name]
        if replace and name is not None:
            return name
        if name is None and (existing := self._between(kind, point, links)) is not None:
            if replace:
                return existing.name
            raise FrameError(
                f"joint {existing.name!r} joins {existing.first!r} and {existing.second!r} by a {kind.name} joint at "
                f"{point!r} "
                "already: give replace=True to put this one in its place, or name= to have both"
            )
        for choice in choices:
            if choice not in self.joints:
                return choice
        raise FrameError(
            f"joint {choices[-1]!r} is there already: give this one another name=, or replace=True to put it there"
        )

    def _between(self, kind: Kind, point: str, links: tuple[str, ...]) -> Pair | None:
        """A joint of a kind at a point between the first and any other of the links."""
        ends = [pair for other in links[1:] for pair in ((links[0], other), (other, links[0]))]
        there = (own for own in self.joints.values() if own.kind == kind and own.point == point)
        return next((own for own in there if (own.first, own.second) in ends), None)

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

    def _coordinates(self, what: str, freedom: int, reference: ArrayLike) -> Array:
        given = finite(reference, f"reference value of {what}")
        if freedom == 1:
            given = given[..., None]
        if given.ndim == 0:
            given = np.full(freedom, given)
        if given.shape[-1:] != (freedom,):
            raise FrameError(
                f"reference value of {what} has shape {given.shape}: its last axis must hold {freedom} coordinates"
            )
        return given


def driven_coordinates(joint: str, kind: Kind, names: bool | Sequence[str]) -> tuple[str, ...]:
    """Coordinates of a joint that are driven: those that are named, or all or none.

    Raises
    ------
    FrameError
        If the joint has no such coordinate.
    """
    free = kind.coordinates
    if isinstance(names, (bool, np.bool_)):
        named = free if names else ()
    elif isinstance(names, (str, list, tuple)):
        named = (names,) if isinstance(names, str) else tuple(names)
    else:
        raise FrameError(f"drive of joint {joint!r} is {names!r}: give True, or coordinates of {', '.join(free)}")
    if not free and (named or names):
        raise FrameError(f"joint {joint!r} is fixed: drive another, or make it a joint with a coordinate")
    wrong = [name for name in named if name not in free]
    if wrong:
        raise FrameError(f"joint {joint!r} has no coordinate {wrong[0]!r}: choose of {', '.join(free)}")
    return tuple(name for name in free if name in named)


def _springs(what: str, value: ArrayLike) -> Array:
    springs = numbers(value, f"stiffness of {what}")
    if springs.shape[-1:] != (6,) or np.any(np.isnan(springs)) or np.any(springs < 0.0):
        raise FrameError(f"stiffness of {what} is {springs.tolist()}: give six springs ux uy uz rx ry rz, 0 to inf")
    return springs
