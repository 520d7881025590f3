"""What a linkage is: the whole description, which the analyses read and the user changes by its calls, with the joints
that leave several coordinates free."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from numpy.typing import ArrayLike

from ....framework.renamed import renamed_keywords
from .simple_joints import SimpleJoints, Z


class LinkageDescription(SimpleJoints):
    """Points, links, joints, drives, springs and loads; see `Linkage`, which adds what can be asked of them."""

    def __repr__(self) -> str:
        driven = ", ".join(self.drives) or "none"
        parts = ((len(self.points), "points"), (len(self.links), "links"), (len(self.joints), "joints"))
        return f"<Linkage: {', '.join(f'{count} {noun}' for count, noun in parts)}; driven: {driven}>"

    @property
    def version(self) -> tuple[object, ...]:
        """What the compiled mechanism depends on: points, links, joints and drives of now, after their names."""
        points, links, joints, drives = self.points, self.links, self.joints, self.drives
        return (
            *(*points, *points.values()),
            *(*links, *links.values()),
            *(*joints, *joints.values()),
            *(*drives, *drives.values()),
        )

    def alike(self) -> Self:
        """Independent copy.

        Returns
        -------
        same type
            The description as it is now: what is added to either later is not in the other. Arrays are shared.
        """
        other = object.__new__(type(self))
        for name, value in vars(self).items():
            setattr(other, name, value.copy() if isinstance(value, (dict, list)) else value)
        return other

    __copy__ = alike

    # -- joints with several coordinates -------------------------------------------------------------------------------

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
        self._add("cylindrical", point, (first, second), axis, drive, stiffness, clearance, name, replace, reference)

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
        self._add("spherical", point, (first, second), axis, drive, stiffness, clearance, name, replace, reference)

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
        self._add(
            "universal", point, links, axis, drive, stiffness, clearance, name, replace, reference, second_axis=second
        )

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
        self._add("planar", point, (first, second), axis, drive, stiffness, clearance, name, replace, reference)
