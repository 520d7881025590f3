"""Limits of deviations: clearances of joints, and tolerances of lengths, positions of points and drives."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, finite
from ....framework.checked import not_negative
from ....framework.errors import FrameError
from ..derivatives.position_sensitivity import PositionSensitivity
from ..description.joints import COMPONENTS
from ..description.parts import Pair

# Kinds of joint with a bearing, whose length limits how far clearance lets the joint tilt.
TILTING = ("revolute", "prismatic", "cylindrical", "screw", "universal")
# Kinds of joint that are constrained along the axis of a pin or thread, where they can have end play.
WITH_END_PLAY = ("revolute", "universal", "screw")


@dataclass(frozen=True, eq=False)
class Limit:
    """Deviation allowed by a tolerance or by the clearance of a joint: a vector in an interval, a disc or a ball.

    Attributes
    ----------
    name
        Name of the contributor.
    by
        Derivatives ``ux uy uz rx ry rz`` of the point by each component of the deviation, (..., 6, m).
    radius
        Largest length of the deviation, (...).
    middle
        Middle of an interval, (...); 0 for discs and balls.
    joint
        The joint, if this is its clearance without a bearing length; empty for other deviations.
    """

    name: str
    by: Array
    radius: Array
    middle: Array
    joint: str = ""


@dataclass(frozen=True, eq=False)
class Given:
    """Limits as the user gave them: see `Motion.worst_case`."""

    clearances: Mapping[str, ArrayLike]
    journals: Mapping[str, ArrayLike]
    end_play: Mapping[str, ArrayLike]
    lengths: Mapping[str | tuple[str, str, str], ArrayLike]
    places: Mapping[tuple[str, str], ArrayLike]
    drives: Mapping[str, ArrayLike]


def given_of(deviations: Mapping[str, Any]) -> Given:
    """Limits given by keyword; those that are not given are empty.

    Raises
    ------
    FrameError
        If a keyword is unknown.
    """
    names = [each.name for each in fields(Given)]
    unknown = [name for name in deviations if name not in names]
    if unknown:
        raise FrameError(f"deviations {unknown[0]!r} are none of a worst case: give {', '.join(names)}")
    return Given(**{name: deviations.get(name) or {} for name in names})


def limits(by: PositionSensitivity, given: Given) -> Iterator[Limit]:
    """All limits, clearances first.

    Raises
    ------
    FrameError
        If a name is unknown, a joint has no such limit, or a limit is negative.
    """
    yield from _clearances(by, given)
    for joint, value in given.end_play.items():
        pair = _of_kind(by, joint, WITH_END_PLAY, "end play")
        for axis, own in _each_pin(pair, value, "end play"):
            play = not_negative(own, f"end play of joint {joint!r}")
            yield Limit(f"joint {pair.name}", _components(by, pair, ("u" + "xyz"[axis],)), play, np.zeros(()))
    for where, value in given.lengths.items():
        name, column = _length(by, where)
        yield _interval(f"length {name}", column[..., None], value)
    for place, value in given.places.items():
        if place not in by.places:
            known = ", ".join(map(str, by.places))
            raise FrameError(f"place {place!r} is no point of a link: give (link, point), one of {known}")
        radius = not_negative(value, f"place {place!r}")
        yield Limit(f"place {'.'.join(place)}", by.places[place], radius, np.zeros(()))
    for joint, value in given.drives.items():
        pair = by.linkage.joint(joint)
        if joint not in by.drives:
            raise FrameError(f"joint {joint!r} is not driven: the drives are {', '.join(by.drives) or 'none'}")
        found = by.drives[joint]
        if found.shape[-1] > 1:
            raise FrameError(
                f"joint {joint!r} has {found.shape[-1]} drives: a tolerance can be given only where there is one"
            )
        yield _interval(f"drive {pair.name}", found, value)


def _clearances(by: PositionSensitivity, given: Given) -> Iterator[Limit]:
    own: dict[str, ArrayLike] = {
        name: pair.clearance for name, pair in by.linkage.joints.items() if pair.clearance is not None
    }
    for joint in given.journals:
        _of_kind(by, joint, TILTING, "length of the bearing")
        if joint not in own | dict(given.clearances):
            raise FrameError(f"joint {joint!r} has the length of a bearing and no clearance: give its clearance, too")
    for joint, value in (own | dict(given.clearances)).items():
        pair = by.linkage.joint(joint)
        radius = not_negative(value, f"clearance of joint {joint!r}")
        if joint not in given.journals:
            across = _components(by, pair, pair.kind.clearance)
            yield Limit(f"joint {joint}", across, radius, np.zeros(()), joint)
            continue
        for axis, bearing in _each_pin(pair, given.journals[joint], "length of the bearing"):
            length = not_negative(bearing, f"length of the bearing of joint {joint!r}")
            if np.any(length == 0.0):
                raise FrameError(
                    f"length of the bearing of joint {joint!r} is 0: leave it out where the joint cannot tilt"
                )
            for end in _ends(by, pair, length, axis):
                yield Limit(f"joint {joint}", end, radius, np.zeros(()))


def _each_pin(pair: Pair, value: ArrayLike, what: str) -> Iterator[tuple[int, ArrayLike]]:
    """Axis of each pin of a joint and the limit given for it: 2, for z, and for a universal joint also 0, for x."""
    both = isinstance(value, tuple)
    if pair.kind.name != "universal":
        if both:
            raise FrameError(
                f"{what} of joint {pair.name!r} is {value!r}: a {pair.kind.name} joint has one, not a pair"
            )
        yield 2, value
        return
    if isinstance(value, tuple) and len(value) != 2:
        raise FrameError(f"{what} of joint {pair.name!r} is {value!r}: give one for both of its pins, or a pair")
    yield from zip((2, 0), value if isinstance(value, tuple) else (value, value), strict=True)


def _ends(by: PositionSensitivity, pair: Pair, length: Array, axis: int) -> Iterator[Array]:
    """Derivatives by the lateral displacement of each end of a bearing, (..., 6, 2).

    Displacements d1 and d2 of the ends at ``z = L/2`` and ``-L/2`` displace the middle by their mean and tilt the joint
    by ``e_z x (d1 - d2) / L``, at most by 2 eps / L for a clearance eps; likewise along x.
    """
    names = "xyz"[(axis + 1) % 3], "xyz"[(axis + 2) % 3]
    across, tilt = (_components(by, pair, tuple(kind + name for name in names)) for kind in "ur")
    rotated = np.stack([tilt[..., 1], -tilt[..., 0]], axis=-1) / length[..., None, None]
    yield 0.5 * across + rotated
    yield 0.5 * across - rotated


def _components(by: PositionSensitivity, pair: Pair, names: tuple[str, ...]) -> Array:
    return by.joints[pair.name][..., [COMPONENTS.index(name) for name in names]]


def _of_kind(by: PositionSensitivity, joint: str, kinds: tuple[str, ...], what: str) -> Pair:
    pair = by.linkage.joint(joint)
    if pair.kind.name not in kinds:
        raise FrameError(
            f"{what} of joint {joint!r}, which is {pair.kind.name}: only {', '.join(kinds)} joints have it"
        )
    return pair


def _length(by: PositionSensitivity, where: str | tuple[str, str, str]) -> tuple[str, Array]:
    """Name of, and derivative (..., 6) by, the length of a link of two points or the distance of two of its points."""
    if isinstance(where, tuple) and len(where) == 3:
        return f"{where[0]} {where[1]}-{where[2]}", by.length(*where)
    if where not in by.lengths:
        known = ", ".join(by.lengths) or "none"
        raise FrameError(f"length {where!r} is none: name a link of two points ({known}), or give (link, point, point)")
    return str(where), by.lengths[str(where)]


def _interval(name: str, column: Array, value: ArrayLike) -> Limit:
    """Limit of a scalar, given by its half width, or by a pair of a lower and an upper deviation."""
    if isinstance(value, tuple) and len(value) == 2:
        lower, upper = (finite(end, f"tolerance of {name}") for end in value)
        if np.any(upper < lower):
            raise FrameError(f"tolerance of {name} is {value!r}: give the lower deviation before the upper one")
        return Limit(name, column, 0.5 * (upper - lower), 0.5 * (upper + lower))
    return Limit(name, column, not_negative(value, f"tolerance of {name}"), np.zeros(()))
