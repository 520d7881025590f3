"""How far a linkage goes: its degrees of freedom, dead points, the range of its drives, and its workspace."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ...framework.errors import FrameError
from .description.linkage_description import LinkageDescription
from .poses.dead_points import DeadPoint, DriveRange, dead_points, drive_range
from .poses.mobility import Mobility, mobility
from .workspace.workspace import Workspace, workspace


class RangeOfMotion(LinkageDescription):
    """A linkage that tells how far it goes; see `Linkage`."""

    def mobility(self, tolerance: float = 0.0, entry: int | tuple[int, ...] | None = None) -> Mobility:
        """Count the degrees of freedom, by Grübler and Kutzbach, and actual; see `mobility.mobility`.

        Parameters
        ----------
        tolerance
            As for `move`.
        entry
            Which entry is meant where the points carry a batch: one index an axis; the first where None.

        Returns
        -------
        Mobility
            Freedoms, idle links, redundant constraints.

        Raises
        ------
        FrameError
            If the reference configuration cannot be assembled.

        Examples
        --------
        Flat, a parallelogram can begin to move in two ways; it has one degree of freedom all the same.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(1, 0), C=(3, 0), D=(2, 0))
        >>> for link in ("AB", "BC", "CD"):
        ...     linkage.link(link, *link)
        >>> links = ("ground", "AB", "BC", "CD", "ground")
        >>> for k, pin in enumerate("ABCD"):
        ...     linkage.revolute(pin, links[k], links[k + 1])
        >>> print(linkage.mobility())
        mobility 1 (Grübler-Kutzbach: 1 planar, -2 spatial)
        singular in the reference configuration: 2 degrees of freedom of velocity
        3 redundant constraints: C (uz rx ry)
        """
        return mobility(self, tolerance, entry)

    def dead_points(
        self,
        joint: str,
        coordinate: str | None = None,
        tolerance: float = 0.0,
        entry: int | tuple[int, ...] | None = None,
    ) -> tuple[DeadPoint, ...]:
        """Dead points and change points on the way through the reference configuration; see `dead_points.dead_points`.

        Parameters
        ----------
        joint
            The joint that drives: one of the drives, the others standing still, or any joint in place of a single
            drive.
        coordinate
            Which of its coordinates, such as ``"rz"``, where there are several.
        tolerance
            As for `move`.
        entry
            As for `mobility`.

        Returns
        -------
        tuple of DeadPoint
            In the order of the drive's coordinate.

        Raises
        ------
        FrameError
            If there is no such joint or coordinate, it cannot move, other drives than one are not locked, or the
            linkage is overconstrained and described with too few digits to go on.

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
        >>> linkage.prismatic("C", "ground", "piston", axis=(1, 0, 0), reference=8**0.5, name="slide", drive=True)
        >>> [(round(point.value, 12), point.joint) for point in linkage.dead_points("slide")]
        [(2.0, 'B'), (4.0, 'B')]
        """
        return dead_points(self, joint, coordinate, tolerance, entry)

    def drive_range(
        self,
        joint: str,
        coordinate: str | None = None,
        tolerance: float = 0.0,
        entry: int | tuple[int, ...] | None = None,
    ) -> DriveRange:
        """How far a drive can go from the reference configuration; see `dead_points.drive_range`.

        Parameters
        ----------
        joint, coordinate, tolerance, entry
            As for `dead_points`.

        Returns
        -------
        DriveRange
            Least and greatest coordinate, and the joints that stop the drive there.

        Raises
        ------
        FrameError
            As for `dead_points`.

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
        return drive_range(self, joint, coordinate, tolerance, entry)

    def workspace(
        self,
        point: str,
        *,
        x: ArrayLike | None = None,
        y: ArrayLike | None = None,
        z: ArrayLike | None = None,
        link: str | None = None,
    ) -> Workspace:
        """Place a point on a grid: what drives it takes, and how stiff and well conditioned the linkage is there.

        The point is led to each place on a straight line from its reference position or, beyond what it cannot cross,
        from the places beside; what is left is sought from poses all over the range of the drives, so that legs may
        fold the other way there. The drives that it takes bring it there by `move`, on a straight path of theirs.
        Places beyond singular poses, which that path would cross, or to which only a path with a bend leads, stay
        blank, as other assembly modes do in `move`; ``elsewhere`` tells which they are. Where the drives do more than
        place the point, its link keeps the orientation of the reference configuration: the constant-orientation
        workspace of a parallel robot.

        Parameters
        ----------
        point
            Name of the point.
        x, y, z
            Two of them as rows of coordinates, (columns,) and (rows,), and the third as one number; where it is left
            out, the grid lies at the reference position.
        link
            The link on which the point is taken; the first that has it where None.

        Returns
        -------
        Workspace
            Maps of stiffness, condition number and effort of the drives, as arrays and figures.

        Raises
        ------
        FrameError
            If there is no such point, the grid cannot be meant, nothing of it is reached, or the linkage has a batch.

        Examples
        --------
        Two bars of 1 m, driven at the base and at the elbow: ``k(J) = 1`` nowhere, least where they are at 135°
        (Salisbury & Craig 1982, with bars of ratio 1/sqrt(2)).

        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2**0.5, 0), P=(2**0.5, 1))
        >>> linkage.link("upper", "A", "B"); linkage.link("lower", "B", "P")
        >>> linkage.revolute("A", "ground", "upper", drive=True); linkage.revolute("B", "upper", "lower", drive=True)
        >>> space = linkage.workspace("P", x=np.linspace(0.2, 3.0, 57), y=[0.0, 0.01])
        >>> best = np.nanargmin(space.condition()[0])
        >>> float(space.grid[0][best].round(6)), round(float(space.condition()[0, best]), 6)
        (1.0, 1.0)
        """
        return workspace(self, point, link, {"x": x, "y": y, "z": z})


def whole_range(linkage: RangeOfMotion) -> dict[str, Array]:
    """Values of the only drive of a linkage from end to end."""
    if linkage.shape:
        raise FrameError(
            f"the linkage has a batch of shape {linkage.shape}: give a drive value for each in drives, on one axis"
        )
    driven = [(name, each) for name, coordinates in linkage.drives.items() for each in coordinates]
    if len(driven) != 1:
        raise FrameError(f"a page of a linkage with {len(driven)} drives: give their values in drives")
    name, coordinate = driven[0]
    joint, found = linkage.joint(name), linkage.drive_range(name, coordinate)
    if np.isinf(found.lower) or np.isinf(found.upper):
        if coordinate[0] == "u":
            raise FrameError(f"nothing stops the drive {name!r}: give its values in drives")
        start = joint.reference[joint.kind.coordinates.index(coordinate)]
        return {name: start + np.radians(np.arange(0.0, 361.0, 2.0))}
    # The ends are dead points, at which nothing is known to first order.
    inside = 1e-3 * (found.upper - found.lower)
    return {name: np.linspace(found.lower + inside, found.upper - inside, 181)}
