"""Where the points and links of a four-bar are, how fast they move and how they accelerate."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite
from ...framework.states import States, put, states_of
from ..linkage.poses.states import PoseState
from ..planar import Complex, vector
from .closure import Closure
from .description import LINKS, FourBarDescription, known

Array = NDArray[np.float64]

SINGULAR = "singular (direct-kinematic, type II): coupler and rocker in line"


@dataclass(frozen=True, eq=False)
class FourBarKinematics:
    """Positions, velocities and accelerations of a four-bar; see `FourBarMotion`."""

    four_bar: FourBarDescription
    closure: Closure
    drive_rate: Array
    drive_acceleration: Array

    @property
    def theta(self) -> Array:
        """Drive angles, radians, (...)."""
        return self.closure.theta

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        x, y = self.four_bar.point
        drive = self.drive_rate.shape, self.drive_acceleration.shape
        return np.broadcast_shapes(self.closure.gap.shape, *drive, np.shape(x), np.shape(y))

    @property
    def singular(self) -> NDArray[np.bool_]:
        """True where coupler and rocker lie in one line, (...)."""
        return np.broadcast_to(self.closure.singular, self.shape)

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """In words, ``"regular"`` or ``"singular (direct-kinematic, type II): coupler and rocker in line"``, (...)."""
        return np.where(self.singular, SINGULAR, "regular")

    @property
    def state(self) -> States:
        """The status as a number of `PoseState`, (...)."""
        return put(states_of(self.shape, PoseState.REGULAR), self.singular, PoseState.SINGULAR_DIRECT)

    @cached_property
    def transmission_angle(self) -> Array:
        """Angle B D E between coupler and rocker, radians in [0, π], (...): best at π/2, singular at 0 and π.

        From the cosine law, with the sine from the triangle's area so that it stays exact at both ends
        (Norton, Design of Machinery, section 4.10, folds it to the acute angle).
        """
        loop = self.closure
        cosine = 0.5 * (loop.coupler**2 + loop.rocker**2 - np.abs(loop.diagonal) ** 2)
        return np.broadcast_to(np.arctan2(np.abs(loop.area), cosine), self.shape)

    # -- points -----------------------------------------------------------------------------------------------------

    def position(self, point: str) -> Array:
        """Position of a point.

        Parameters
        ----------
        point
            ``"A"``, ``"B"``, ``"P"``, ``"D"`` or ``"E"``.

        Returns
        -------
        ndarray
            Global coordinates x y z, (..., 3), length.

        Raises
        ------
        FrameError
            If there is no such point.

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> motion = FourBar(crank=2.0, coupler=7.0, rocker=9.0, ground=6.0).move(np.radians([0.0, 90.0]))
        >>> motion.position("B").round(9).tolist()
        [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
        """
        return self.position_on(*self._point(point))

    def velocity(self, point: str) -> Array:
        """Velocity of a point.

        Parameters
        ----------
        point
            ``"A"``, ``"B"``, ``"P"``, ``"D"`` or ``"E"``.

        Returns
        -------
        ndarray
            Global components, (..., 3), length per time.

        Raises
        ------
        FrameError
            If there is no such point.

        Examples
        --------
        The crank pin moves across the crank.

        >>> from linkframe.models import FourBar
        >>> FourBar(crank=2.0, coupler=7.0, rocker=9.0, ground=6.0).move(0.0, rate=3.0).velocity("B").round(9).tolist()
        [0.0, 6.0, 0.0]
        """
        return self.velocity_on(*self._point(point))

    def acceleration(self, point: str) -> Array:
        """Acceleration of a point.

        Parameters
        ----------
        point
            ``"A"``, ``"B"``, ``"P"``, ``"D"`` or ``"E"``.

        Returns
        -------
        ndarray
            Global components, (..., 3), length per time squared.

        Raises
        ------
        FrameError
            If there is no such point.
        """
        return self.acceleration_on(*self._point(point))

    def free_velocity(self, point: str) -> Array:
        """Velocity of a point in the motion that a locked crank leaves free where coupler and rocker are in line.

        Parameters
        ----------
        point
            ``"A"``, ``"B"``, ``"P"``, ``"D"`` or ``"E"``.

        Returns
        -------
        ndarray
            D moves across the line at unit speed, the coupler about B and the rocker about E, (..., 3); zero at
            regular poses.

        Raises
        ------
        FrameError
            If there is no such point.

        Examples
        --------
        >>> from linkframe.models import FourBar
        >>> motion = FourBar(point=(0.05, 0.0)).move([0.0, 1.0])
        >>> [motion.free_velocity(point).round(9).tolist() for point in "DP"]
        [[[0.0, 1.0, 0.0], [0.0, 0.0, 0.0]], [[0.0, 0.25, 0.0], [0.0, 0.0, 0.0]]]
        """
        link, x, y = self._point(point)
        arm = finite(x, f"x on the {link}") + 1j * finite(y, f"y on the {link}")
        way = 1j * self.direction("coupler") * arm / self.closure.coupler
        return np.where(self.singular[..., None] & (link == "coupler"), self._vector(way), 0.0)

    def position_on(self, link: str, x: ArrayLike, y: ArrayLike = 0.0) -> Array:
        """Position of the point (x, y) of a link, given in the link's axes, (..., 3).

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.
        x, y
            Coordinates in the link's axes, (...).

        Returns
        -------
        ndarray
            Global coordinates, (..., 3).
        """
        return self._vector(self._place(link, x, y, 0))

    def velocity_on(self, link: str, x: ArrayLike, y: ArrayLike = 0.0) -> Array:
        """Velocity of the point (x, y) of a link, given in the link's axes, (..., 3).

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.
        x, y
            Coordinates in the link's axes, (...).

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._vector(self._place(link, x, y, 1) * self.drive_rate)

    def acceleration_on(self, link: str, x: ArrayLike, y: ArrayLike = 0.0) -> Array:
        """Acceleration of the point (x, y) of a link, given in the link's axes, (..., 3).

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.
        x, y
            Coordinates in the link's axes, (...).

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        first, second = self._place(link, x, y, 1), self._place(link, x, y, 2)
        return self._vector(first * self.drive_acceleration + second * self.drive_rate**2)

    # -- links ------------------------------------------------------------------------------------------------------

    def angle(self, link: str) -> Array:
        """Direction of a link's x axis, radians in (-π, π], (...).

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.

        Returns
        -------
        ndarray
            Angle from global x, (...).

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.models import FourBar
        >>> motion = FourBar(crank=2.0, coupler=7.0, rocker=9.0, ground=6.0).move(np.radians(30.0))
        >>> float(np.degrees(motion.angle("rocker")).round(3))
        117.286
        """
        return np.broadcast_to(np.angle(self.direction(link)), self.shape)

    def angular_velocity(self, link: str) -> Array:
        """Angular velocity of a link, radians per time, (...).

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.

        Returns
        -------
        ndarray
            Rate of `angle`, (...).
        """
        return np.broadcast_to(self._turning(link)[0] * self.drive_rate, self.shape)

    def angular_acceleration(self, link: str) -> Array:
        """Angular acceleration of a link, radians per time squared, (...).

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.

        Returns
        -------
        ndarray
            Rate of `angular_velocity`, (...).
        """
        first, second = self._turning(link)
        return np.broadcast_to(first * self.drive_acceleration + second * self.drive_rate**2, self.shape)

    def direction(self, link: str) -> Complex:
        """Unit vector along a link as a complex number.

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.

        Returns
        -------
        ndarray
            Complex x + i y, (...).
        """
        return self._direction(known("link", link, LINKS), 0)

    def origin(self, link: str) -> Complex:
        """Origin of a link's axes as a complex number: A, B or E.

        Parameters
        ----------
        link
            ``"crank"``, ``"coupler"`` or ``"rocker"``.

        Returns
        -------
        ndarray
            Complex x + i y, (...), length.
        """
        return self._origin(known("link", link, LINKS), 0)

    # -- derivatives of order 0, 1, 2 by the drive angle ------------------------------------------------------------

    def _direction(self, link: str, order: int) -> Complex:
        loop = self.closure
        crank = 1j**order * loop.crank_vector
        if link == "crank":
            return crank / loop.crank
        coupler = loop.coupler_derivatives[order - 1] if order else loop.coupler_vector
        if link == "coupler":
            return coupler / loop.coupler
        diagonal = -crank if order else loop.diagonal
        return (coupler - diagonal) / loop.rocker

    def _origin(self, link: str, order: int) -> Complex:
        if link == "coupler":
            return np.asarray(1j**order * self.closure.crank_vector)
        still = 0.0 if link == "crank" or order else self.closure.ground
        return np.asarray(still, dtype=np.complex128)

    def _place(self, link: str, x: ArrayLike, y: ArrayLike, order: int) -> Complex:
        arm = finite(x, f"x on the {link}") + 1j * finite(y, f"y on the {link}")
        return self._origin(known("link", link, LINKS), order) + arm * self._direction(link, order)

    def _turning(self, link: str) -> tuple[Array, Array]:
        """First and second derivative of a link's angle by the drive angle, (...)."""
        unit, first, second = (self._direction(known("link", link, LINKS), order) for order in range(3))
        return np.imag(first * np.conj(unit)), np.imag(second * np.conj(unit))

    def _point(self, name: str) -> tuple[str, ArrayLike, ArrayLike]:
        loop, (x, y) = self.closure, self.four_bar.point
        points: dict[str, tuple[str, ArrayLike, ArrayLike]] = {
            "A": ("crank", 0.0, 0.0),
            "B": ("crank", loop.crank, 0.0),
            "P": ("coupler", x, y),
            "D": ("coupler", loop.coupler, 0.0),
            "E": ("rocker", 0.0, 0.0),
        }
        return points[known("point", name, points)]

    def _vector(self, point: Complex) -> Array:
        return np.broadcast_to(vector(point), (*np.broadcast_shapes(self.shape, np.shape(point)), 3))
