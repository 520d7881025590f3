"""Inverse kinematics: drive values that bring a point of a link to wanted places."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND
from ..graphics.places import ReferencePlaces
from ..kinematics.extent import extent
from ..motion import Motion
from ..poses.coordinates import some_coordinates

Bools = NDArray[np.bool_]
# Largest distance from a place that counts as reached, as a share of the linkage's size.
REACHED = 1e-11
# Largest last step of the drives from there: the distance that it leaves is of the order of its square.
LAST = 1e-7
# Number of Newton steps, largest ratio of the distances after and before each, and largest step of a drive, in radians
# or sizes of the linkage: near a singular pose steps have no bound.
STEPS, NEARER, LONGEST = 8, 0.7, np.pi
# Ratio to the largest singular value below which one counts as zero.
NONE = 1e-9
# Damped steps, where Newton's method does not converge: their number, the sum of squares from which it does, the first,
# least and largest damping, and the factors by which damping decreases and increases.
DAMPED, ARRIVED, DAMPING, LEAST, MOST, FALLS, GROWS = 40, 1e-4, 0.1, 1e-4, 10.0, 0.2, 5.0
# Number of poses distributed over the range of the drives.
ALL_OVER = 1000


@dataclass(frozen=True, eq=False)
class InverseKinematics:
    """Inverse kinematics: drive values that bring a point to given places.

    The point is driven along a path with the linkage's own drives passive, which gives the values of these. If all
    drives are needed to place the point, its link rotates as it must; if there are more, the link keeps its orientation
    in the reference configuration.

    Attributes
    ----------
    linkage
        The description, without a batch.
    point, given
        The point, and the link on which it lies; the first that has it if None.
    """

    linkage: LinkageDescription
    point: str
    given: str | None = None

    def __post_init__(self) -> None:
        if self.linkage.shape:
            raise FrameError(f"the linkage has a batch of shape {self.linkage.shape}: a workspace needs one linkage")
        if not self.linkage.drives:
            raise FrameError("nothing drives the linkage, so nothing can be placed: drive a joint with drive=True")

    @cached_property
    def home(self) -> Motion:
        """The reference configuration."""
        return Motion.of(self.linkage, {}, {}, {}, "keep", 0.0)

    @cached_property
    def link(self) -> str:
        """The link on which the point lies."""
        return self.home.sensitivity(self.point, self.given).link

    @cached_property
    def size(self) -> float:
        """Size of the linkage, a length."""
        return float(extent(self.linkage))

    @cached_property
    def start(self) -> Array:
        """Drive values in the reference configuration, (drives,)."""
        return np.concatenate([some_coordinates(self.home, *drive) for drive in self.linkage.drives.items()])

    @cached_property
    def slides(self) -> Bools:
        """Whether each drive slides, (drives,)."""
        names = [component for components in self.linkage.drives.values() for component in components]
        return np.array([name.startswith("u") for name in names])

    @cached_property
    def units(self) -> Array:
        """Unit of each drive, (drives,): the linkage's size for drives that slide, 1 for those that turn."""
        return np.where(self.slides, self.size, 1.0)

    @cached_property
    def all_over(self) -> tuple[Array, Array]:
        """Drive values (n, drives) and places (n, 3) of assembled poses over the range of the drives.

        That is half a turn, or the linkage's size, on both sides of the reference configuration.
        """
        from scipy.stats import qmc  # takes long to load, and few workspaces need it

        spread = 2.0 * qmc.Halton(len(self.start), scramble=False).random(ALL_OVER) - 1.0
        drives = self.start + spread * np.where(self.slides, self.size, np.pi)
        places = self.poses(drives).position(self.point, self.link)
        there = np.isfinite(places).all(axis=-1)
        return drives[there], places[there]

    @cached_property
    def places(self) -> int:
        """Number of independent directions in which the drives move the point."""
        values = np.linalg.svd(self.jacobian(self.home)[:3], compute_uv=False)
        return int(np.count_nonzero(values > NONE * values[0]))

    @cached_property
    def plane(self) -> tuple[int, int] | None:
        """The plane of two global axes in which the linkage lies and the drives move the point; None in space."""
        flat = ReferencePlaces(self.linkage).flat
        across = self.jacobian(self.home)[3 - sum(flat)] if flat else np.ones(1)
        return None if np.abs(across).max() > NONE else flat

    @property
    def holds_orientation(self) -> bool:
        """Whether there are more drives than placing the point takes, so that its link's orientation is kept too."""
        return self.places < len(self.units)

    @property
    def rows(self) -> int:
        """Number of rows of the Jacobian that are used: position, and orientation if it is kept."""
        return 6 if self.holds_orientation else 3

    def jacobian(self, motion: Motion) -> Array:
        """Displacement and rotation of the point by the drives, (..., 6, drives), lengths in units of the size."""
        by = motion.sensitivity(self.point, self.link).drives
        columns = np.concatenate([by[name] for name in self.linkage.drives], axis=-1)
        return np.asarray(columns / np.repeat([self.size, 1.0], 3)[:, None] * self.units)

    def solved(self, places: Array) -> tuple[Array, Bools, Bools]:
        """Drive values (n, drives) for places (n, 3), whether they reach these, and whether the point can be there.

        The point is moved from its reference position along a straight line. It can be at a place without being reached
        there: the straight path of the drives may end in another assembly mode.
        """
        led = {f"{self.point} to {'xyz'[k]}": places[:, k] for k in self._ways}
        at = Motion.of(self._led(), led, {}, {}, "keep", 0.0)
        columns = [some_coordinates(at, *drive) for drive in self.linkage.drives.items()]
        drives = np.concatenate([np.broadcast_to(each, (len(places), each.shape[-1])) for each in columns], axis=-1)
        drives = np.where(np.isfinite(drives).all(axis=-1, keepdims=True), drives, self.start)
        return drives, self._off(self.poses(drives), places) <= REACHED, at.is_assembled | at.assembly.other

    def refined(self, drives: Array, places: Array) -> tuple[Array, Bools]:
        """Drive values (n, drives) after Newton steps towards places (n, 3), and whether these are reached, (n,).

        Steps continue as long as they reduce the distance; one more, if short, leaves nothing but rounding.
        """
        drives, reached = drives.copy(), np.zeros(len(drives), dtype=bool)
        left, before = np.arange(len(drives)), np.full(len(drives), np.inf)
        for _ in range(STEPS):
            motion = self.poses(drives[left])
            far = self._off(motion, places[left])
            near = far <= REACHED
            reached[left[near]] = True
            step = self._step(motion, places[left])
            size = np.abs(step / self.units).max(axis=-1)
            last = near & (size < LAST)
            drives[left[last]] += step[last]
            on = ~near & (far < NEARER * before) & (size < LONGEST)
            if not on.any():
                break
            left, before = left[on], far[on]
            drives[left] += step[on]
        return drives, reached

    def approached(self, drives: Array, places: Array) -> Array:
        """Drive values (n, drives) nearer to places (n, 3) that are far away or behind a hole, by Levenberg's method.

        Damped steps follow the edge of a hole of the workspace where the straight line leads through it (Wampler, *IEEE
        Transactions on Systems, Man, and Cybernetics* 16, 1986).
        """
        drives, damping = drives.copy(), np.full(len(drives), DAMPING)
        matrix, off, energy = self._equations(self.poses(drives), places)
        for _ in range(DAMPED):
            on = np.flatnonzero((energy > ARRIVED) & (damping < MOST))
            if not len(on):
                break
            square = matrix[on] @ matrix[on].mT + damping[on, None, None] * np.eye(self.rows)
            step = self.units * (matrix[on].mT @ np.linalg.solve(square, off[on, :, None]))[..., 0]
            ahead = self._equations(self.poses(drives[on] + step), places[on])
            good = ahead[2] < energy[on]
            damping[on] = np.maximum(damping[on] * np.where(good, FALLS, GROWS), LEAST)
            damping[on[np.isinf(ahead[2])]] = MOST  # a loop does not close there: this is not the edge of a hole
            drives[on[good]] += step[good]
            for here, there in zip((matrix, off, energy), ahead, strict=True):
                here[on[good]] = there[good]
        return drives

    def poses(self, drives: Array) -> Motion:
        """Motion at drive values (n, drives)."""
        values, first = {}, 0
        for name, components in self.linkage.drives.items():
            own = drives[:, first : first + len(components)]
            values[name] = own[:, 0] if len(components) == 1 else own
            first += len(components)
        return Motion.of(self.linkage, values, {}, {}, "keep", 0.0)

    def _off(self, motion: Motion, places: Array) -> Array:
        """Distance from places (n, 3) in sizes, or if larger, deviation of the kept orientation, (n,)."""
        off = np.linalg.norm(motion.position(self.point, self.link) - places, axis=-1) / self.size
        if self.holds_orientation:
            off = np.maximum(off, np.abs(motion.axes(self.link) - np.eye(3)).max(axis=(-2, -1)))
        return np.asarray(np.nan_to_num(off, nan=np.inf))

    def _step(self, motion: Motion, places: Array) -> Array:
        """Newton step of the drives, of least norm, (n, drives); NaN where the pose has no derivatives."""
        matrix, off, energy = self._equations(motion, places)
        step = (np.linalg.pinv(matrix, rcond=NONE) @ off[..., None])[..., 0]
        return np.where(np.isfinite(energy)[:, None], self.units * step, np.nan)

    def _equations(self, motion: Motion, places: Array) -> tuple[Array, Array, Array]:
        """Jacobian (n, rows, drives), deviation from the places (n, rows), and the sum of squares to minimise (n,).

        Zero, zero and infinite at poses without derivatives.
        """
        off = (places - motion.position(self.point, self.link)) / self.size
        energy = (off**2).sum(axis=-1)
        if self.holds_orientation:
            axes = motion.axes(self.link)
            turned = np.stack([axes[:, k - 2, k - 1] - axes[:, k - 1, k - 2] for k in range(3)], axis=-1)
            off = np.concatenate([off, 0.5 * turned], axis=-1)
            energy = energy + 0.5 * ((axes - np.eye(3)) ** 2).sum(axis=(-2, -1))
        matrix = self.jacobian(motion)[..., : self.rows, :]
        good: Bools = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)) & np.isfinite(off).all(axis=-1))
        return (
            np.where(good[:, None, None], matrix, 0.0),
            np.where(good[:, None], off, 0.0),
            np.where(good, energy, np.inf),
        )

    @property
    def _ways(self) -> tuple[int, ...]:
        """Global axes along which the point is moved."""
        ways = self.plane or (0, 1, 2)
        if self.places < len(ways):
            raise FrameError(
                f"the drives move {self.point} along {self.places} of {len(ways)} axes: a workspace needs them all: "
                "drive more joints"
            )
        return ways

    def _led(self) -> LinkageDescription:
        """The linkage with driven sliders along the axes that move the point, and with its own drives passive."""
        led, before = self.linkage.alike(), GROUND
        led.drives.clear()
        ways = self._ways
        start = self.home.position(self.point, self.link)
        for k in ways:
            name = f"{self.point} to {'xyz'[k]}"
            led.link(name, self.point)
            led.prismatic(self.point, before, name, axis=np.eye(3)[k], drive=True, reference=float(start[k]), name=name)
            before = name
        end = f"{self.point} led"
        if self.holds_orientation:
            led.fixed(self.point, before, self.link, name=end)
        elif len(ways) == 2:
            led.revolute(self.point, before, self.link, axis=np.eye(3)[3 - sum(ways)], name=end)
        else:
            led.spherical(self.point, before, self.link, name=end)
        return led
