"""The four-bar linkage and its motion: what can be asked of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import finite, join
from ...framework.errors import FrameError
from ...framework.frame import Frame
from ..linkage.graphics.drawn_motion import DrawnMotion
from . import as_linkage
from .closure import Closure
from .description import FourBarDescription
from .frame import frame
from .kinematics import FourBarKinematics
from .kinetostatics import Kinetostatics, Link, kinetostatics

if TYPE_CHECKING:
    from ..linkage.graphics.places import DrawnPoses
    from ..linkage.linkage import Linkage


@dataclass(frozen=True, eq=False)
class FourBarMotion(DrawnMotion, FourBarKinematics):
    """Motion of a four-bar; made by `FourBar.move`.

    Points are A, B (crank pin), D (rocker pin), E (rocker's pivot) and P (on the coupler). Each link has axes of its
    own: the crank from A towards B, the coupler from B towards D, the rocker from E towards D; z is global z.

    Where coupler and rocker lie in line (`status`), positions are exact; velocities and accelerations are those of
    the smooth motion if the branch has one (a parallelogram on the branch ``"parallel"`` passes through), NaN if not.

    Attributes
    ----------
    four_bar
        The linkage.
    closure
        The closed loop at the drive angles.
    drive_rate, drive_acceleration
        First and second time derivative of the drive angle, (...).
    """

    four_bar: FourBar

    def _drawn(self) -> DrawnPoses:
        return as_linkage.drawn(self)

    def frame(self, clearance: Mapping[str, ArrayLike] | None = None) -> Frame:
        """Make a frame of beams and joints of the linkage at every pose, clamped at A.

        Parameters
        ----------
        clearance
            Radial clearance in the plane, (...), of some of the joints ``"B"``, ``"D"``, ``"E"``, whose stiffness is
            the same along x and y.

        Returns
        -------
        Frame
            Without loads; nodes A (fixed), B.crank, B.coupler, P, D.coupler, D.rocker, E.rocker and E (fixed), joints
            B, D, E; batch shape the broadcast of poses, linkage and clearances.

        Raises
        ------
        FrameError
            If a joint is unknown or a clearance is negative.

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> frame = FourBar().move(np.radians([30.0, 60.0])).frame()
        >>> frame.load("P", fy=100.0)
        >>> frame.solve().displacement("P").shape
        (2, 6)
        """
        return frame(self, clearance or {})

    def reactions(
        self,
        crank: Link | None = None,
        coupler: Link | None = None,
        rocker: Link | None = None,
        gravity: tuple[ArrayLike, ArrayLike] = (0.0, 0.0),
    ) -> Kinetostatics:
        """Joint reactions and drive torque of the rigid linkage, by the Newton-Euler equations of its three links.

        Nine equations, Eq. (1)-(4) of the accuracy paper (Norton, *Design of Machinery*, section 11.4).

        Parameters
        ----------
        crank, coupler, rocker
            Mass, centre, inertia and external load of each link; nothing where None.
        gravity
            Acceleration of gravity (gx, gy).

        Returns
        -------
        Kinetostatics
            Eight reaction components and the drive torque, (...); NaN where coupler and rocker lie in line, as no
            finite reactions hold the linkage there.

        Examples
        --------
        A crank of 2 kg, its centre of mass at 0.05 m, held level.

        >>> from linkframe.models import FourBar, Link
        >>> found = FourBar(ground=0.25).move(0.0).reactions(Link(mass=2.0, centre=(0.05, 0.0)), gravity=(0.0, -9.81))
        >>> float(found.drive_torque.round(9)), found.reaction("A").round(9).tolist()
        (0.981, [0.0, 19.62, 0.0])
        """
        return kinetostatics(self, crank or Link(), coupler or Link(), rocker or Link(), gravity)


@dataclass(frozen=True, eq=False)
class FourBar(FourBarDescription):
    """Planar four-bar linkage A B D E with a point P on its coupler.

    The drive is at A = (0, 0), the rocker's pivot at E = (ground, 0); crank A-B, coupler B-D, rocker E-D. Without
    arguments it is the symmetric linkage of the accuracy paper. Every number may be an array; all broadcast.

    Parameters
    ----------
    crank, coupler, rocker, ground
        Lengths a, b, c, d > 0, (...).
    point
        Position (x, y) of P in the coupler's axes, length each, (...): origin B, x towards D.
    branch
        Where D lies: ``"open"``, to the left of the diagonal from B to E; ``"crossed"``, to its right;
        ``"parallel"``, to the left while the crank pin is above the ground line and to the right while it is below,
        so that a parallelogram stays one through its change points; ``"antiparallel"``, the reverse.
        Where None: parallel if opposite links are equal, open otherwise.
    beam
        Beam of every link, or a mapping from ``"crank"``, ``"coupler"``, ``"rocker"`` to beams.
    stiffness
        Stiffness ``ktx kty ktz krx kry krz`` (..., 6) of every passive joint, in global axes, or a mapping from
        ``"B"``, ``"D"``, ``"E"``; ``inf`` is ideal, 0 is free.

    Raises
    ------
    FrameError
        If a length is not positive and finite, shapes do not broadcast, or a branch, link or joint is unknown.

    Examples
    --------
    >>> import numpy as np
    >>> four_bar = FourBar(crank=2.0, coupler=7.0, rocker=9.0, ground=6.0, point=(3.5, 0.0))
    >>> motion = four_bar.move(np.radians(30.0))
    >>> bool(abs(np.degrees(motion.angle("rocker")) - 117.286) < 1e-3)
    True
    """

    def move(self, theta: ArrayLike, rate: ArrayLike = 0.0, acceleration: ArrayLike = 0.0) -> FourBarMotion:
        """Motion of the linkage at drive angles, in closed form.

        Parameters
        ----------
        theta
            Drive angles, radians, (...).
        rate
            Drive rates, radians per time, (...).
        acceleration
            Drive accelerations, radians per time squared, (...).

        Returns
        -------
        FourBarMotion
            Positions, velocities, accelerations of its points and links.

        Raises
        ------
        FrameError
            If it cannot be assembled at a pose: naming the pose and the gap.

        Examples
        --------
        Crank 2, coupler 7, rocker 9, ground 6 at 30° (Norton, *Design of Machinery*, Table P4-1, row a: 88.8° and
        117.3°).

        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> motion = FourBar(crank=2.0, coupler=7.0, rocker=9.0, ground=6.0).move(np.radians(30.0))
        >>> [float(np.degrees(motion.angle(link)).round(1)) for link in ("coupler", "rocker")]
        [88.8, 117.3]
        """
        closure = self._closure(theta)
        rates = finite(rate, "drive rate"), finite(acceleration, "drive acceleration")
        _refuse_gap(closure)
        shapes = {"drive angle theta": np.shape(closure.gap)}
        for name, value in zip(("drive rate", "drive acceleration"), rates, strict=True):
            join(shapes, name, value.shape)
        return FourBarMotion(self, closure, *rates)

    def linkage(self, theta: ArrayLike, clearance: Mapping[str, ArrayLike] | None = None) -> Linkage:
        """The four-bar as a linkage, drawn at a drive angle, with all that can be asked of one.

        Points A, B, P, D, E; links ``crank``, ``coupler``, ``rocker``, ``ground``; joints A, which drives and whose
        coordinate is the drive angle, B, D and E. It has mobility, dead points, the range of its drive, vibration,
        stress, inertia of its beams and more, none of which need a four-bar. It is slower, as it closes any loop:
        what a four-bar knows in closed form is asked of `move`.

        Parameters
        ----------
        theta
            Drive angle at which it is drawn, radians, (...). From there it moves on smoothly, see `Linkage.move`.
        clearance
            Radial clearance, (...), of some of the joints ``"B"``, ``"D"``, ``"E"``.

        Returns
        -------
        Linkage
            The linkage, without loads.

        Raises
        ------
        FrameError
            If it cannot be assembled at `theta`, or a clearance is negative.

        Examples
        --------
        >>> import numpy as np
        >>> four_bar = FourBar(crank=3.0, coupler=4.0, rocker=2.0, ground=4.0)
        >>> reach = four_bar.linkage(1.0).drive_range("A")
        >>> round(float(np.degrees(reach.upper)), 4)  # where coupler and rocker are in line
        117.2796
        """
        return as_linkage.linkage(self.move(theta), clearance or {})


def _refuse_gap(closure: Closure) -> None:
    gap = closure.gap
    if not np.any(gap > 0.0):
        return
    worst = np.unravel_index(np.argmax(gap), gap.shape)
    theta = np.degrees(np.broadcast_to(closure.theta, gap.shape)[worst])
    where = f"pose {', '.join(str(int(i)) for i in worst)} (theta = {theta:.6g} deg)" if worst else f"{theta:.6g} deg"
    raise FrameError(
        f"the four-bar cannot be assembled at {where}: coupler and rocker leave a gap of {gap[worst]:.6g}"
        f" ({np.count_nonzero(gap)} of {gap.size} poses are out of reach);"
        " change a length, or keep to the poses where assembles(theta) is true"
    )
