"""Joints that leave one coordinate free or none: pins, sliders, screws, and links joined firmly."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from ....framework.renamed import renamed_keywords
from .joined import JoinedSketch

Z = (0.0, 0.0, 1.0)


class SimpleJoints(JoinedSketch):
    """A sketch that is joined by pins, sliders and screws; see `Linkage`."""

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
            with it, named as the joint is, and from the second on followed by ``.link``.
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
        links = first, *others
        self._add(
            "revolute", point, links, axis, drive, stiffness, clearance, name, replace, reference, contact=contact
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
        self._add("prismatic", point, (first, second), axis, drive, stiffness, clearance, name, replace, reference)

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
        links = first, second
        self._add("screw", point, links, axis, drive, stiffness, clearance, name, replace, reference, pitch=pitch)

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
        self._add("fixed", point, (first, second), axis, False, stiffness, clearance, name, replace)
