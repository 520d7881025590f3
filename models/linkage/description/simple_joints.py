"""Joints with one coordinate or none: revolute, prismatic, screw and fixed joints."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from ....framework.renamed import renamed_keywords
from .joined import JoinedSketch, Z


class SimpleJoints(JoinedSketch):
    """A linkage with revolute, prismatic, screw and fixed joints; see `Linkage`."""

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
        """Join links by a pin: the second turns about an axis of the first.

        Parameters
        ----------
        point
            Name of the pin's point.
        first, *others
            Links that it joins. With several others, `first` carries the pin, and each other link has a joint of its
            own with it, of which the first has the name of the joint and the others that name followed by ``.link``.
        axis
            Direction of the axis in the reference configuration, (..., 2 or 3).
        drive
            True if the angle is driven.
        stiffness
            Stiffness of six springs in the joint's axes, (..., 6), 0 to inf; if None, inf in the constrained and driven
            directions. In a free direction it is that of a spring and must be finite; in a driven one it is that of the
            drive, which does not hold the frame if it is 0.
        clearance
            Radial clearance, (...).
        contact
            Direction from the first link's pin centre to the second's, radians, (...): Eq. (11) of the accuracy paper.
            It is measured about the axis from x of the joint in the reference configuration, which is global x for an
            axis along z, and does not rotate with the linkage. The clearance is then an offset in the joint, which
            ``motion.frame(clearance=False)`` leaves out and ``frame.solve(clearance=False)`` does not. If None, the
            contact follows from equilibrium.
        name
            The joint's name; by default its point, or ``point.kind`` if that is taken. A second joint of the same kind
            between the same links at the same point needs a name.
        replace
            Whether it replaces the joint of that name, or without a name that of the same kind between the same links
            at the same point; if there is none, it is added.
        reference
            Angle in the reference configuration, radians, (...).

        Raises
        ------
        FrameError
            If a name is taken or unknown, there is such a joint already, or a number is not valid; the linkage is then
            unchanged.

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
        """Join two links by a slider: the second slides along an axis of the first.

        Parameters
        ----------
        point
            Name of the joint's point in the reference configuration, which both links must have.
        first, second
            Links that it joins.
        axis
            Direction of sliding in the reference configuration, (..., 2 or 3).
        drive
            True if the displacement is driven.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Displacement in the reference configuration, length, (...).

        Raises
        ------
        FrameError
            As for `revolute`.

        Examples
        --------
        A slide that is driven along x.

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
        """Join two links by a screw: the second turns about an axis of the first and advances along it.

        Parameters
        ----------
        point
            Name of the joint's point in the reference configuration.
        first, second
            Links that it joins.
        axis
            Direction of the axis in the reference configuration, (..., 2 or 3).
        pitch
            Advance along the axis per turn, (...), length; negative for a left-hand thread.
        drive
            True if the angle is driven.
        stiffness, clearance, name, replace
            As for `revolute`.
        reference
            Angle in the reference configuration, radians, (...).

        Raises
        ------
        FrameError
            As for `revolute`.

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
        """Join two links rigidly, or by a stiffness in all directions.

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
            As for `revolute`.

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
