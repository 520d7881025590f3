"""Spindles: links whose joints, a screw among them, all lie on one axis.

A spindle may turn any number of times while the rest of the linkage goes a short way: what it does for the others is
told by the travel of its screw, not by its angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from ..description.parts import Pair

KINDS = ("screw", "revolute", "cylindrical")
# Distance, in extents of the linkage, and sine of the angle below which two axes are one.
COAXIAL = 1e-9


@dataclass(frozen=True)
class Spindle:
    """A link that turns about one axis.

    Attributes
    ----------
    joints
        Names of its joints.
    lead
        Largest advance of its screws per radian, length.
    """

    joints: frozenset[str]
    lead: float


def spindles(linkage: LinkageDescription, entry: tuple[int, ...], size: float) -> dict[str, Spindle]:
    """Spindles of a linkage by the names of their links.

    Parameters
    ----------
    linkage
        The description.
    entry
        Entry of its batch.
    size
        Extent of the linkage, length.
    """
    pairs = linkage.joints.values()
    if not any(pair.kind.name == "screw" for pair in pairs):
        return {}

    def own(numbers: Array, trailing: int) -> Array:
        return np.asarray(np.broadcast_to(numbers, (*linkage.shape, *numbers.shape[numbers.ndim - trailing :]))[entry])

    def line(pair: Pair) -> tuple[Array, Array]:
        return own(linkage.points[pair.point], 1), own(pair.axes, 2)[:, 2]

    def lead(pair: Pair) -> float:
        return 0.0 if pair.pitch is None else abs(float(own(pair.pitch, 0))) / (2.0 * np.pi)

    out = {}
    for link in linkage.links:
        those = [pair for pair in pairs if link in (pair.first, pair.second)]
        advance = max(map(lead, those), default=0.0)
        if advance and all(pair.kind.name in KINDS for pair in those) and _coaxial([*map(line, those)], size):
            out[link] = Spindle(frozenset(pair.name for pair in those), advance)
    return out


def _coaxial(lines: list[tuple[Array, Array]], size: float) -> bool:
    """Whether lines, each given by a point and a unit vector, are one."""
    (origin, axis), *others = lines
    apart = [np.cross(along, axis) for _, along in others] + [np.cross(at - origin, axis) / size for at, _ in others]
    return bool(np.abs(apart).max(initial=0.0) < COAXIAL)
