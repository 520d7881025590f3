"""The whole description of a linkage, which all analyses read, and joints with several coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

from numpy.typing import ArrayLike

from ....framework.renamed import renamed_keywords
from .joined import Z
from .simple_joints import SimpleJoints


class LinkageDescription(SimpleJoints):
    """Points, links, joints, drives, springs and loads; see `Linkage`, which adds the analyses."""

    def __repr__(self) -> str:
        driven = ", ".join(self.drives) or "none"
        parts = ((len(self.points), "points"), (len(self.links), "links"), (len(self.joints), "joints"))
        return f"<Linkage: {', '.join(f'{count} {noun}' for count, noun in parts)}; driven: {driven}>"

    @property
    def version(self) -> tuple[object, ...]:
        """All that the compiled mechanism depends on: names and values of points, links, joints and drives."""
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
            The copy. Later changes of one description do not change the other; arrays are shared.
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
        """Join two links so that the second slides along an axis of the first and turns about it.

        Parameters
        ----------
        point
            Name of the joint's point in the reference configuration.
        first, second
            Links that it joins.
        axis
            Direction of the axis in the reference configuration, (..., 2 or 3).
        drive
            True if both coordinates are driven, ``"uz"`` or ``"rz"`` if one is.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Displacement (length) and angle (radians) in the reference configuration, (..., 2).

        Raises
        ------
        FrameError
            As for `revolute`.

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
        """Join two links by a spherical joint.

        Parameters
        ----------
        point
            Name of the centre of the joint.
        first, second
            Links that it joins.
        axis
            Third axis z of the joint in the reference configuration, (..., 2 or 3).
        drive
            True if the rotation is driven.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Rotation vector in the reference configuration, in the joint's axes, radians, (..., 3).

        Raises
        ------
        FrameError
            As for `revolute`.

        Examples
        --------
        A rod on a spherical joint is turned by 90° about y.

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
        """Join two links by a universal joint (Cardan, Hooke): its cross turns about an axis of each link.

        Parameters
        ----------
        point
            Name of the point where the axes meet.
        first, second_link
            Links that it joins.
        axis
            Axis on the first link in the reference configuration, (..., 2 or 3): z of the joint.
        second
            Axis on the second link in the reference configuration, (..., 2 or 3), perpendicular to `axis`: x of the
            joint.
        drive
            True if both angles are driven, ``"rz"`` (about the first axis) or ``"rx"`` if one is.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            The two angles in the reference configuration, radians, (..., 2).

        Raises
        ------
        FrameError
            As for `revolute`, or if the axes are not perpendicular.

        Examples
        --------
        Two shafts at 30° to each other, the second in a bearing: ``tan(out) = tan(in) / cos(30°)`` or its inverse,
        depending on the initial position of the cross (Shigley & Uicker, *Theory of Machines and Mechanisms*, on
        Hooke's joint).

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
        """Join two links so that the second slides and turns on a plane of the first.

        Parameters
        ----------
        point
            Name of a point of the plane that both links have.
        first, second
            Links that it joins.
        axis
            Normal of the plane in the reference configuration, (..., 2 or 3).
        drive
            True if all three coordinates are driven; ``"ux"``, ``"uy"`` or ``"rz"``, or several of them, if these are.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Two displacements (length) and the angle (radians) in the reference configuration, (..., 3).

        Raises
        ------
        FrameError
            As for `revolute`.

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
