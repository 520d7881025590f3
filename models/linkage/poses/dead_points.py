"""Dead points of a drive, and the range in which it can move."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..continuation.interpolation import at_zero
from ..description.linkage_description import LinkageDescription
from .configuration import Configurations, Entry
from .motion_path import AWAY, STEP, MotionPath, PathPoint, TracedPath
from .moving_joints import moving_joints

# Share of the drive in the motion below which the drive counts as at rest.
AT_REST = 1e-6
# Share of its travel that the drive may still move from half of the way on where the linkage runs away to infinity.
SLOW = 0.1


@dataclass(frozen=True)
class DeadPoint:
    """A position in which locking the drive does not lock the linkage.

    Attributes
    ----------
    value
        Coordinate of the drive, radians or length.
    joint
        Joint that moves with the drive locked: the fastest of those that join two moving links.
    change_point
        False where the drive turns back: it can go no further. True where it can go on, on two branches.
    """

    value: float
    joint: str
    change_point: bool

    @property
    def status(self) -> str:
        """Type of the singularity, in words."""
        kind = "change point" if self.change_point else "dead point"
        return f"singular (direct-kinematic, type II; {kind} of {self.joint})"


@dataclass(frozen=True)
class DriveRange:
    """How far a drive can move from the reference configuration, its linkage staying assembled.

    Attributes
    ----------
    lower, upper
        Least and greatest coordinate, radians or length; -inf and inf where nothing stops the drive. Where the linkage
        goes to infinity as the drive approaches a value, that value, to about 1e-9.
    lower_joint, upper_joint
        Joints that stop it, see `DeadPoint.joint`; None where nothing does.
    """

    lower: float
    upper: float
    lower_joint: str | None
    upper_joint: str | None


def dead_points(
    linkage: LinkageDescription, joint: str, coordinate: str | None = None, tolerance: float = 0.0, entry: Entry = None
) -> tuple[DeadPoint, ...]:
    """All dead points of a linkage, moved from the reference configuration by one coordinate as its drive.

    The motion is followed by its arc length, on which dead points are regular, both ways from the reference
    configuration until it closes. Each point where the linkage can move with the drive locked is then found by Newton's
    method to about 1e-12. At a change point the smooth branch is followed.
    """
    curve = _curve(linkage, joint, coordinate, tolerance, entry)
    found: list[DeadPoint] = []
    for place in _singular_places(curve):
        point = _dead_point(curve, place)
        if not any(_same(point, other, curve.unit) for other in found):
            found.append(point)
    return tuple(sorted(found, key=lambda point: point.value))


def drive_range(
    linkage: LinkageDescription, joint: str, coordinate: str | None = None, tolerance: float = 0.0, entry: Entry = None
) -> DriveRange:
    """How far a drive can go from the reference configuration in both directions."""
    curve = _curve(linkage, joint, coordinate, tolerance, entry)
    high, round_again = _end(curve, 1.0)
    low, _ = (None, True) if round_again else _end(curve, -1.0)
    return DriveRange(
        -np.inf if low is None else low.value,
        np.inf if high is None else high.value,
        None if low is None else low.joint,
        None if high is None else high.joint,
    )


def _curve(
    linkage: LinkageDescription, joint: str, coordinate: str | None, tolerance: float, entry: Entry
) -> MotionPath:
    """The path of a linkage with a joint's coordinate as its drive and the other drives locked."""
    pair = linkage.joint(joint)
    free = linkage.drives.get(joint, pair.kind.coordinates)
    if coordinate is None and len(free) == 1:
        (coordinate,) = free
    if coordinate not in pair.kind.coordinates:
        coordinates = ", ".join(pair.kind.coordinates) or "none"
        raise FrameError(f"coordinate {coordinate!r} of joint {joint!r}: choose one that it has ({coordinates})")
    driven = [(name, component) for name, those in linkage.drives.items() for component in those]
    chosen = joint, coordinate
    if chosen not in driven and len(driven) > 1:
        raise FrameError(
            f"joint {joint!r} is not among the drives {', '.join(linkage.drives)}: "
            "choose one of them (the others are locked), or drive the linkage by one joint only"
        )
    if chosen not in driven:
        linkage, driven = _driven_by(linkage, joint, coordinate), [chosen]
    space = Configurations(linkage, tolerance, entry, by_travel=True)
    return MotionPath(space, chosen, [name for name in driven if name != chosen])


def _driven_by(linkage: LinkageDescription, joint: str, coordinate: str) -> LinkageDescription:
    """The same linkage with another drive, which makes that coordinate part of the mechanism's state."""
    other = copy(linkage)
    other.drives = {joint: (coordinate,)}
    return other


def _singular_places(curve: MotionPath) -> list[PathPoint]:
    """All points of the path where something moves with the drive locked."""
    found = map(curve.singular_place, curve.near_singular(curve.traced_both_ways()))
    return [place for place in found if place is not None]


def _end(curve: MotionPath, sign: float) -> tuple[DeadPoint | None, bool]:
    """The dead point where the drive turns back, in one direction from the reference configuration; None if there is
    none.

    And whether the path has returned to the reference configuration without one, so that there is none in the other
    direction either.
    """
    start = curve.start
    traced = curve.trace(start.reversed(sign), until=lambda place: bool(sign * place.tangent[curve.drive] < 0.0))
    forwards = np.array([sign * place.tangent[curve.drive] for place in traced.places])
    if forwards[0] < AT_REST and np.all(forwards[1:2] <= 0.0):
        # the reference configuration is itself a dead point, from which the drive moves in one direction only
        return _dead_point(curve, start), False
    back = np.flatnonzero(forwards[1:] < 0.0)
    if not back.size:
        return _dead_point(curve, traced.places[-1]) if traced.stalled else _asymptote(curve, traced), traced.closes
    before, after = traced.places[back[0]], traced.places[back[0] + 1]
    near = min((before, after), key=lambda place: abs(place.tangent[curve.drive]))
    return _dead_point(curve, curve.singular_place(near) or near), False


def _asymptote(curve: MotionPath, traced: TracedPath) -> DeadPoint | None:
    """The value that the drive approaches as the linkage goes to infinity; None if it does not.

    The coordinate is extrapolated as a polynomial in the inverse of the path length.
    """
    count, last = len(traced.places), traced.places[-1]
    if traced.closes or np.abs(curve.space.places(last.state)).max() < AWAY:
        return None
    knots = [count // k for k in range(1, 9)]
    values = [curve.coordinate(traced.places[knot - 1].state) for knot in knots]
    if abs(values[0] - values[1]) > SLOW * abs(values[1] - curve.coordinate(traced.places[0].state)):
        return None
    joint = _moving_joint(curve, last.state, last.tangent.copy())
    return DeadPoint(float(at_zero(values, [1.0 / knot for knot in knots])), joint, change_point=False)


def _dead_point(curve: MotionPath, place: PathPoint) -> DeadPoint:
    """The dead point at a singular point of the path."""
    # a little beside the point, the free motion is told from idle ones by its small but nonzero singular value
    beside = curve.space.advanced(place.state, 1e-4 * place.tangent)
    motion = np.linalg.svd(curve.locked_equations(beside))[2][curve.rank - 1]
    crossing = bool(abs(place.tangent[curve.drive]) > AT_REST)
    value = curve.coordinate(place.state)
    if crossing and abs(between := curve.crossing_value(place) - value) < STEP * curve.unit:
        value += between
    return DeadPoint(value, _moving_joint(curve, place.state, motion), crossing)


def _moving_joint(curve: MotionPath, state: Array, motion: Array) -> str:
    """The joint that is at its dead point in a motion (n,) with the drive locked."""
    motion[[curve.drive, *curve.locked]] = 0.0
    space = curve.space
    velocities = list((motion / space.units)[:, None, None])
    (joint,) = moving_joints(space.mechanism, state.tolist(), space.parameters, velocities)
    return str(joint)


def _same(one: DeadPoint, other: DeadPoint, unit: float) -> bool:
    alike = (one.joint, one.change_point) == (other.joint, other.change_point)
    return alike and abs(one.value - other.value) < 1e-9 * unit
