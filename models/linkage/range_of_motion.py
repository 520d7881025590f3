"""Range of motion of a linkage: degrees of freedom, dead points, the range of its drives, and its workspace."""

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
    """A linkage with methods for its range of motion; see `Linkage`."""

    def mobility(self, tolerance: float = 0.0, entry: int | tuple[int, ...] | None = None) -> Mobility:
        """Count the degrees of freedom, by Grübler and Kutzbach, and actual; see `mobility.mobility`.

        Parameters
        ----------
        tolerance
            As for `move`.
        entry
            Entry of the batch if the points have one: one index an axis; the first if None.

        Returns
        -------
        Mobility
            Degrees of freedom, idle links, redundant constraints.

        Raises
        ------
        FrameError
            If the reference configuration cannot be assembled.

        Examples
        --------
        A parallelogram with all links in line has two independent velocities, but one degree of freedom.

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
        """Find dead points and change points on the path through the reference configuration.

        See `dead_points.dead_points`.

        Parameters
        ----------
        joint
            The driving joint: one of the drives, with the others locked, or any joint instead of a single drive.
        coordinate
            The coordinate, such as ``"rz"``, if the joint has several.
        tolerance
            As for `move`.
        entry
            As for `mobility`.

        Returns
        -------
        tuple of DeadPoint
            The points in the order of the drive's coordinate.

        Raises
        ------
        FrameError
            If there is no such joint or coordinate, it cannot move, more than one degree of freedom is not locked, or
            the linkage is overconstrained and described with too few digits to follow its path.

        Examples
        --------
        A piston cannot drive its crank where crank and rod, of lengths 1 and 3, are in line.

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
        """Find the range of a drive from the reference configuration; see `dead_points.drive_range`.

        Parameters
        ----------
        joint, coordinate, tolerance, entry
            As for `dead_points`.

        Returns
        -------
        DriveRange
            Smallest and largest coordinate, and the joints that stop the drive there.

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
        """Place a point on a grid: the drive values it takes, and the stiffness and condition of the linkage there.

        The point is moved to each place on a straight line from its reference position or, beyond obstacles, from
        neighbouring places; remaining places are tried from poses all over the range of the drives, so that legs may
        fold the other way. `move` reaches the place with the drive values found, on a straight path of the drives.
        Places beyond singular poses, which that path would cross, or to which only a path with a bend leads, stay
        blank, as other assembly modes do in `move`; ``elsewhere`` has them. If there are more drives than placing the
        point takes, its link keeps the orientation of the reference configuration: the constant-orientation workspace
        of a parallel robot.

        Parameters
        ----------
        point
            Name of the point.
        x, y, z
            Two of them as rows of coordinates, (columns,) and (rows,), and the third as one number, by default that of
            the reference position.
        link
            The link on which the point lies; the first that has it if None.

        Returns
        -------
        Workspace
            Maps of stiffness, condition number and effort of the drives, as arrays and figures.

        Raises
        ------
        FrameError
            If there is no such point, the grid is not valid, no place of it is reached, or the linkage has a batch.

        Examples
        --------
        Two bars of ``sqrt(2)`` and 1 m, driven at the base and at the elbow: the condition number is 1 where they are
        at 135° (Salisbury & Craig 1982).

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
    """Values of the only drive of a linkage over its range, by joint, (poses,)."""
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
    # the ends are dead points, without derivatives
    inside = 1e-3 * (found.upper - found.lower)
    return {name: np.linspace(found.lower + inside, found.upper - inside, 181)}
