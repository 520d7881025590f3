"""Displacement of the coupler point of a loaded four-bar: by compliance, by clearance, and in total."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import aligned, finite, join
from ...framework.errors import FrameError, expected_mechanisms
from ..clearance import offset, pressed
from ..linkage.statics.condition_numbers import ConditionNumbers
from ..linkage.statics.past import past
from ..planar import Complex, cross
from .clearance import clearance_displacement
from .description import JOINTS, LOADS, PerJoint, check_joints, each_joint
from .four_bar import FourBar, FourBarMotion
from .kinematics import SINGULAR

if TYPE_CHECKING:
    from ...framework.frame import Frame
    from ...framework.large.solution import LargeSolution
    from ...framework.solution import Solution

Array = NDArray[np.float64]
OPEN_LOOP = "clearance leaves the loop open"


@dataclass(frozen=True, eq=False)
class Accuracy(ConditionNumbers):
    """Displacement of the coupler point P by its causes; made by `accuracy`, computed when read.

    Attributes
    ----------
    motion
        Motion of the linkage.
    load
        ``fx fy mz`` on P, (...) each.
    clearances
        Radial clearance of the joints B, D, E, (...) each.
    contacts
        Contact angles of the joints B, D, E, (...) each, or None where they follow from the joint forces.
    equilibrium
        Whether those are the joint forces in equilibrium with the clearances, instead of those without clearances.
    """

    motion: FourBarMotion
    load: tuple[Array, Array, Array]
    clearances: Mapping[str, Array]
    contacts: Mapping[str, Array] | None
    equilibrium: bool = False

    @property
    def rigid(self) -> Array:
        """Position of P of the ideal linkage, (..., 3)."""
        return self.motion.position("P")

    @property
    def compliance(self) -> Array:
        """Displacement of P by the load on links and joints, (..., 3), linear; NaN where `status` is not regular."""
        return self._regular(self._cases.displacement("P")[0, ..., :3])

    def _regular(self, moved: Array) -> Array:
        return np.where((self.status == "regular")[..., None], moved, np.nan)

    @property
    def clearance(self) -> Array:
        """Displacement of P by the clearance, (..., 3), to first order; NaN where `status` is not regular.

        The frame's answer to the offsets of its joints; links and joints may deform where the linkage is not
        statically determinate.
        """
        return self._regular(self._cases.displacement("P")[1, ..., :3])

    @cached_property
    def clearance_exact(self) -> Array:
        """Displacement of P by the clearance, (..., 3), the loop closed again; NaN where it cannot close."""
        return np.broadcast_to(clearance_displacement(self.motion, self.offsets), (*self.shape, 3))

    @property
    def total(self) -> Array:
        """Compliance and clearance to first order, (..., 3)."""
        return self.compliance + self.clearance

    @property
    def total_exact(self) -> Array:
        """Compliance and exact clearance, (..., 3)."""
        return self.compliance + self.clearance_exact

    @property
    def large(self) -> Array:
        """Displacement of P by load and clearance together, (..., 3), at large displacement: also at singular poses.

        The stable equilibrium to which load and clearance lead from the rigid position; NaN where none was found.
        """
        return np.broadcast_to(self._large.displacement("P")[..., :3], (*self.shape, 3))

    @property
    def large_passes(self) -> NDArray[np.bool_]:
        """Whether coupler and rocker pass through one line on the way to `large`, towards the other branch, (...).

        False at singular poses, where both lie in line from the start.
        """
        coupler, rocker = (self._large_chord(*ends) for ends in (("B.coupler", "D.coupler"), ("D.rocker", "E.rocker")))
        there = ~self.motion.singular & self._large.converged
        return np.broadcast_to(past([self.motion.closure.area], [-cross(coupler, rocker)], there), self.shape)

    def _large_chord(self, start: str, end: str) -> Complex:
        """Line between two nodes at large displacement, x + i y, (...)."""
        frame, moved = self._large.frame, self._large.displacement
        chord = frame.position(end) + moved(end)[..., :3] - frame.position(start) - moved(start)[..., :3]
        return np.asarray(chord[..., 0] + 1j * chord[..., 1])

    @cached_property
    def _large(self) -> LargeSolution:
        frame = self._finding_contact if self.contacts is None else self.frame()
        return frame.solve(large=True)

    # -- status -----------------------------------------------------------------------------------------------------

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """That of the motion in words, or the frame's ``"mechanism"``, (...)."""
        free = np.broadcast_to(self._cases.movable, (2, *self.shape)).any(axis=0)
        singular = np.broadcast_to(self.motion.singular, self.shape)
        return np.where(singular, SINGULAR, np.where(free, "mechanism", "regular"))

    @cached_property
    def exact_status(self) -> NDArray[np.str_]:
        """As `status`, and ``"clearance leaves the loop open"`` where no assembly has this clearance, (...)."""
        is_open = np.isnan(self.clearance_exact[..., 0]) & (self.status == "regular")
        return np.where(is_open, OPEN_LOOP, self.status)

    @property
    def error_bound(self) -> Array:
        """Bound on the numerical error of `total`, (..., 3); inf where `status` is not regular."""
        in_plane = self._cases.error_bound("P", components=("ux", "uy")).sum(axis=0)
        # Nothing moves P across the plane, so that this is exactly zero wherever it is anything.
        across = np.where(np.isfinite(in_plane[..., :1]), 0.0, np.inf)
        return np.broadcast_to(np.concatenate([in_plane, across], axis=-1), (*self.shape, 3))

    @property
    def nonlinearity(self) -> Array:
        """Estimated relative error of `compliance` by its being linear, (...); inf where `status` is not regular."""
        return np.broadcast_to(self._under_load.nonlinearity(), self.shape)

    @property
    def plane(self) -> tuple[int, int]:
        """The plane of motion: x and y."""
        return 0, 1

    @property
    def _loaded_frame(self) -> Frame:
        return self._bare

    @property
    def _without_clearance(self) -> Solution:
        return self._under_load

    # -- frames -----------------------------------------------------------------------------------------------------

    def frame(self) -> Frame:
        """The linkage as a frame with its load and its clearance, (...).

        Returns
        -------
        Frame
            Of the batch shape, clamped at the drive; its clearances are offsets in the joints, towards the contact.
        """
        frame = self._bare.copy()
        for joint, gap in self.offsets.items():
            frame.offset(joint, ux=gap.real, uy=gap.imag)
        return frame

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""
        given = [value.shape for value in self.clearances.values()]
        given += [value.shape for value in (self.contacts or {}).values()]
        return np.broadcast_shapes(self._bare.shape, self.motion.shape, *given)

    @cached_property
    def offsets(self) -> dict[str, Complex]:
        """Offset δ_x + i δ_y in each joint, of the later link relative to the earlier one, (...)."""
        if self.contacts is not None:
            return {joint: offset(self.clearances[joint], self.contacts[joint]) for joint in JOINTS}
        if self.equilibrium:
            return {joint: self._contact_offsets(joint) for joint in JOINTS}
        with expected_mechanisms():
            # Singular poses have no forces; the warning comes when the displacements are read.
            forces = {joint: self._under_load.joint_force(joint) for joint in JOINTS}
        force = {joint: each[..., 0] + 1j * each[..., 1] for joint, each in forces.items()}
        largest = np.max(np.abs(list(force.values())), axis=0)
        return {joint: pressed(self.clearances[joint], force[joint], largest) for joint in JOINTS}

    def _contact_offsets(self, joint: str) -> Complex:
        if not self.clearances[joint].any():
            return np.zeros(self.shape, dtype=np.complex128)
        place = self._in_equilibrium.contact(joint).offset
        return np.asarray(place[..., 0] + 1j * place[..., 1])

    @cached_property
    def _in_equilibrium(self) -> Solution:
        return self._finding_contact.solve()

    @cached_property
    def _under_load(self) -> Solution:
        return self._bare.solve()

    @cached_property
    def _bare(self) -> Frame:
        """The loaded linkage without clearance; it must not be changed."""
        return self._loaded()

    @cached_property
    def _finding_contact(self) -> Frame:
        """The loaded linkage with clearance, whose journals lie where they are in equilibrium."""
        return self._loaded({joint: gap for joint, gap in self.clearances.items() if gap.any()})

    @cached_property
    def _unloaded(self) -> Frame:
        """The linkage without clearance and load, of which the others are copies."""
        return self.motion.frame()

    def _loaded(self, clearance: Mapping[str, ArrayLike] | None = None) -> Frame:
        frame = self.motion.frame(clearance) if clearance else self._unloaded.copy()
        frame.load("P", **dict(zip(LOADS, self.load, strict=True)))
        return frame

    @cached_property
    def _cases(self) -> Solution:
        """Load alone and clearance alone, (2, ...): the stiffness has no such axis, so that it is factorised once."""
        ndim = len(self.shape)
        first, second = (np.reshape(case, (2, *(1,) * ndim)) for case in ((1.0, 0.0), (0.0, 1.0)))
        frame = self._unloaded.copy()
        frame.load("P", **{name: first * aligned(value, ndim) for name, value in zip(LOADS, self.load, strict=True)})
        for joint, gap in self.offsets.items():
            frame.offset(joint, ux=second * aligned(gap.real, ndim), uy=second * aligned(gap.imag, ndim))
        return frame.solve()


def accuracy(
    four_bar: FourBar,
    theta: ArrayLike,
    *,
    load: tuple[ArrayLike, ArrayLike, ArrayLike] = (0.0, 0.0, 0.0),
    clearance: PerJoint = 0.0,
    contact: PerJoint | str = 0.0,
) -> Accuracy:
    """Displacement of the coupler point P of a four-bar, its drive locked: by compliance, by clearance, and in total.

    The contact in a joint is given by an angle, or comes from the joint's own force in static equilibrium under the
    load: the journal then lies against the bearing along that force. The force is that without clearances
    (``"reaction"``), or, where springs about the pins make the linkage statically indeterminate, the one that the
    clearances leave (``"equilibrium"``, see `Frame.solve`); without such springs the two agree. For a linkage that
    moves, give the angles `Kinetostatics.contact_angle` of its dynamic reactions.

    Parameters
    ----------
    four_bar
        The linkage.
    theta
        Drive angles, radians, (...).
    load
        ``(fx, fy, mz)`` on P, (...) each.
    clearance
        Radial clearance (11) of every joint, (...), or a mapping from some of ``"B"``, ``"D"``, ``"E"``.
    contact
        Contact angle γ (11) of every joint, radians, (...), or a mapping as above; or ``"reaction"``
        or ``"equilibrium"``.
        It is the direction, from global x, in which the later link's pin centre (along crank, coupler, rocker,
        ground) lies from the earlier one's.

    Returns
    -------
    Accuracy
        Displacements, (..., 3), computed when read.

    Raises
    ------
    FrameError
        If the linkage cannot be assembled at a pose, a clearance is negative, a joint is unknown, shapes do not
        broadcast, or ``contact`` is ``"reaction"`` or ``"equilibrium"`` and there is no load to go by.

    Examples
    --------
    >>> import numpy as np
    >>> found = accuracy(FourBar(), np.radians(60.0), clearance=1e-4, contact=np.pi / 2)
    >>> bool(abs(found.clearance - found.clearance_exact).max() < 1e-6)
    True
    """
    motion = four_bar.move(theta)
    shapes = {"drive angle theta": motion.shape}

    def checked(value: ArrayLike, what: str) -> Array:
        array = finite(value, what)
        join(shapes, what, array.shape)
        return array

    def per_joint(given: PerJoint, what: str) -> dict[str, Array]:
        if isinstance(given, Mapping):
            check_joints(given, what)
        return {joint: checked(value, f"{what} of joint {joint!r}") for joint, value in each_joint(given).items()}

    if not isinstance(load, tuple | list) or len(load) != 3:
        raise FrameError(f"load is {load!r}: give (fx, fy, mz)")
    fx, fy, mz = (checked(value, f"load {name}") for value, name in zip(load, LOADS, strict=True))
    gaps = per_joint(clearance, "clearance")
    for joint, gap in gaps.items():
        if np.any(gap < 0.0):
            raise FrameError(f"clearance of joint {joint!r} is {gap[gap < 0.0].flat[0]:g}: give zero or more")
    if not isinstance(contact, str):
        return Accuracy(motion, (fx, fy, mz), gaps, per_joint(contact, "contact angle"))
    if contact not in ("reaction", "equilibrium"):
        raise FrameError(f"contact is {contact!r}: give angles in radians, 'reaction' or 'equilibrium'")
    if not (np.any(fx) or np.any(fy) or np.any(mz)):
        raise FrameError(
            f"contact is {contact!r}, but the load is zero, so that no joint force tells where: give a load"
        )
    return Accuracy(motion, (fx, fy, mz), gaps, None, contact == "equilibrium")
