"""The closed poses of a linkage: where each link is and at what rates it moves, or why a pose is not assembled."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.batch import Array, Shape
from ....framework.errors import FrameError
from ....framework.lazily import cached_property
from ....framework.program.calculation import worth_compiling
from ....framework.program.sines import FARTHEST
from ....framework.program.source import Functions
from ..continuation.assemble import Assembly, assembled
from ..continuation.driven import check_rates, remedy, too_many_drives
from ..continuation.drives import Drives, given_drives
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND
from ..kinematics.blocks import blocks, common, cut_all
from ..kinematics.mechanism import Mechanism, compiled
from ..kinematics.terms import Value

BRANCHES = ("keep", "switch")
OTHER_MODE = "other assembly mode; not reachable from the reference configuration"


@dataclass(frozen=True, eq=False, repr=False)
class AssembledPoses:
    """A linkage over a batch of poses, with the pose and the rates of each of its links; see `Motion`."""

    linkage: LinkageDescription
    mechanism: Mechanism
    drives: Drives
    assembly: Assembly

    @classmethod
    def of(
        cls,
        linkage: LinkageDescription,
        values: Mapping[str, ArrayLike],
        rates: Mapping[str, ArrayLike],
        accelerations: Mapping[str, ArrayLike],
        branch: str = "keep",
        tolerance: float = 0.0,
        other_modes: bool = False,
    ) -> Self:
        """Those of a linkage whose drives are given; see `Linkage.move`.

        Parameters
        ----------
        linkage
            The description.
        values, rates, accelerations
            By driven joint, (...) or (..., f).
        branch
            ``keep`` or ``switch`` at change points.
        tolerance
            Greatest gap, a length, with which poses count as assembled.
        other_modes
            Whether poses in another assembly mode have positions.

        Returns
        -------
        same type
            All poses, closed or with the status that says why not.

        Raises
        ------
        FrameError
            If branch, tolerance or a drive are not what they should be, the linkage cannot be assembled in the
            reference configuration, or there are more drives than degrees of freedom and their rates do not agree.
        """
        if branch not in BRANCHES:
            raise FrameError(f"branch is {branch!r}: choose one of {', '.join(BRANCHES)}")
        if not 0.0 <= tolerance < np.inf:
            raise FrameError(f"tolerance is {tolerance:g}: give a length, 0 or above")
        mechanism = compiled(linkage, common=tolerance > 0.0)
        mechanism.check_free()
        drives = given_drives(linkage, mechanism, values, rates, accelerations)
        share = tolerance / mechanism.size if isinstance(mechanism.size, float) else 0.0
        found = assembled(mechanism, drives, branch == "switch", share, other_modes)
        poses = cls(linkage, mechanism, drives, found)
        if rates or accelerations:
            poses.check_rates()
        return poses

    def check_rates(self) -> None:
        """Check that the rates of more drives than there are degrees of freedom agree.

        Raises
        ------
        FrameError
            If the loops would open with them.
        """
        found, closed = self.assembly, np.asarray(self.is_assembled)
        if too_many_drives(found.loops):
            check_rates(found.loops, found.state, self.mechanism.parameters, *self.velocities, closed)

    @cached_property
    def shape(self) -> Shape:
        """Batch shape: the broadcast of drives, rates, accelerations and points."""
        driven, closed = self.drives.full_shape, self.assembly.shape
        return driven if driven == closed else np.broadcast_shapes(driven, closed)

    @property
    def tolerance(self) -> float:
        """Greatest gap, a length, with which poses count as assembled; 0 for rounding."""
        size = self.mechanism.size
        return self.assembly.loops.tolerance * size if isinstance(size, float) else 0.0

    # -- closure ----------------------------------------------------------------------------------------------------

    @cached_property
    def is_assembled(self) -> NDArray[np.bool_]:
        """Whether each pose can be assembled, (...)."""
        return np.broadcast_to(self.assembly.closed, self.shape)

    @cached_property
    def gap(self) -> Array:
        """Closure error of each pose, (...), a length; angles count times the linkage's size."""
        return np.broadcast_to(self.assembly.gap, self.shape)

    @cached_property
    def closure_status(self) -> NDArray[np.str_]:
        """``"regular"``, ``"other assembly mode..."`` or ``"not assembled: gap ... at joint ..."``, (...)."""
        found = self.assembly
        status = np.full(found.shape, "regular", dtype="<U200")
        if not found.reached.all():
            status[found.other] = OTHER_MODE
            sizes = np.broadcast_to(self.mechanism.size, found.shape)
            for index in map(tuple, np.argwhere(~found.reached & ~found.other)):
                joint = self.mechanism.rows[int(found.open_row[index])][0]
                gap = float(found.gap[index])
                status[index] = (
                    f"not assembled: gap {gap:.3g} at joint {joint}{remedy(found.loops, gap, float(sizes[index]))}"
                )
        return np.broadcast_to(status, self.shape)

    def counted(self, joint: str) -> Assembly:
        """The same poses of a mechanism that has the coordinates of a joint, which here closes a loop, in its state.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        Assembly
            Closed states, in which the joint's angles contain the turns made on the way to each pose.
        """
        if joint not in self._counted:
            mechanism, found = self.mechanism.counting(joint), self.assembly
            self._counted[joint] = assembled(mechanism, self.drives, found.switch, found.loops.tolerance)
        return self._counted[joint]

    @cached_property
    def _counted(self) -> dict[str, Assembly]:
        return {}

    # -- states and rates -------------------------------------------------------------------------------------------

    @cached_property
    def velocities(self) -> tuple[list[Value], list[Value]]:
        """Velocity coordinates and their time derivatives, entries (...) of the batch shape."""
        return _rates(self)

    def evaluate_links(self, *, rates: bool = False) -> None:
        """Find the poses of all links, and with `rates` their motions, together, before they are asked for one by one.

        Links of a chain stand on those before them: one by one takes a time that grows with the square of their number.

        Parameters
        ----------
        rates
            Whether velocities and accelerations are wanted.
        """
        links = self.linkage.links
        if len(self._poses) < len(links):
            self._poses.update(self._vectors(links, self.mechanism.poses))
        if rates and len(self._moves) < len(links):
            self._moves.update(self._vectors(links, self.mechanism.rates, *self.velocities))

    def _pose(self, link: str) -> tuple[list[Value], list[list[Value]]]:
        """Reference point and axes, in the ground's axes."""
        if link not in self._poses:
            self._poses.update(self._vectors([self._known(link)], self.mechanism.pose_of(link)))
        origin, *axes = self._poses[link]
        return origin, axes

    @cached_property
    def _poses(self) -> dict[str, list[list[Value]]]:
        return {}

    def _rates(self, link: str) -> list[list[Value]]:
        """Angular velocity, velocity of the reference point, and both accelerations, in the ground's axes."""
        if link == GROUND:
            return [[0.0, 0.0, 0.0]] * 4
        if link not in self._moves:
            program = self.mechanism.rates_of(self._known(link))
            self._moves.update(self._vectors([link], program, *self.velocities))
        return self._moves[link]

    @cached_property
    def _moves(self) -> dict[str, list[list[Value]]]:
        return {}

    def _vectors(
        self, links: Iterable[str], program: Functions, *inputs: Sequence[Value]
    ) -> dict[str, list[list[Value]]]:
        """By link the four vectors that a program has of it."""
        numbers = self._run(program, self.assembly.state, *inputs)
        return {link: [numbers[k : k + 3] for k in range(12 * n, 12 * n + 12, 3)] for n, link in enumerate(links)}

    def _run(self, program: Functions, *inputs: Sequence[Value]) -> list[Value]:
        """Results of a program, entry by entry, NaN where the pose is not assembled."""
        state, *others = inputs
        given = state, self.mechanism.parameters, *others
        long = bool(self.shape) and worth_compiling(math.prod(self.shape))
        work = program.calculation(given, self.shape) if long else None
        found: Sequence[Value] = work.results() if work is not None and not self._far else program[1](*given)
        if self.assembly.all_closed:
            return list(found)
        return [np.where(self.assembly.closed, x, np.nan) for x in found]

    @cached_property
    def _far(self) -> bool:
        """Whether a drive goes so far that its sine takes more care."""
        return any(float(np.abs(x).max(initial=0.0)) > 0.5 * FARTHEST for x in self.drives.states)

    def _global(self, components: Sequence[Value], scale: float | Array = 1.0) -> Array:
        """Vector (..., 3) in global axes from entries in the ground's axes."""
        arrays = [x.shape for x in components if isinstance(x, np.ndarray)]
        if arrays or self.shape:
            out = np.empty((*common({self.shape, *arrays}), 3))
            for k, x in enumerate(components):
                out[..., k] = x * scale
        else:
            out = np.array([x * scale for x in components])
        if self.mechanism.upright:
            return out
        return np.asarray(np.einsum("...ij,...j->...i", self.mechanism.bodies[GROUND].reference_axes, out))

    def _global_columns(self, columns: Sequence[Sequence[Value]]) -> Array:
        """Matrix (..., 3, k) of vectors in global axes from their entries in the ground's axes."""
        each = [self._global(components) for components in columns]
        out = np.empty((*each[0].shape, len(each)))
        for k, column in enumerate(each):
            out[..., k] = column
        return out

    # -- look-up ----------------------------------------------------------------------------------------------------

    def _known(self, link: str) -> str:
        if link not in self.linkage.links:
            raise FrameError(f"the linkage has no link {link!r}: choose one of {', '.join(self.linkage.links)}")
        return link


def _rates(motion: AssembledPoses) -> tuple[list[Value], list[Value]]:
    found, drives, mechanism = motion.assembly, motion.drives, motion.mechanism
    loops, shape = found.loops, motion.shape
    given = found.state, mechanism.parameters, drives.rates, drives.accelerations
    first, second = (None if motion._far else loops.rates_at_once(*given, shape)) or _rates_in_blocks(motion)
    for patch in found.patches:
        members = np.broadcast_to(patch.members, shape)
        spread = np.broadcast_to(np.cumsum(patch.members).reshape(patch.members.shape) - 1, shape)[members]
        for k, follow, bend in zip(mechanism.unknown, patch.follow, patch.bend, strict=True):
            rate = np.broadcast_to(drives.rates[patch.drive], shape)[members]
            speeds_up = np.broadcast_to(drives.accelerations[patch.drive], shape)[members]
            np.asarray(first[k])[members] = follow[spread] * rate
            np.asarray(second[k])[members] = follow[spread] * speeds_up + bend[spread] * rate**2
    return first, second


def _rates_in_blocks(motion: AssembledPoses) -> tuple[list[Value], list[Value]]:
    found, drives, mechanism = motion.assembly, motion.drives, motion.mechanism
    loops, shape, count = found.loops, motion.shape, len(mechanism.columns)
    first, second = ([np.empty(shape) for _ in range(count)] for _ in range(2))
    for block in blocks(shape):
        state, parameters = cut_all(found.state, block), cut_all(mechanism.parameters, block)
        v = loops.velocities(state, parameters, cut_all(drives.rates, block))
        w = loops.accelerations(state, parameters, v, cut_all(drives.accelerations, block))
        for k in range(count):
            first[k][block], second[k][block] = v[k], w[k]
    return list(first), list(second)
