"""Spindles: links whose joints, a screw among them, all lie on one axis.

A spindle may turn any number of times while the rest of the linkage goes a short way: what it does for the others is
told by the travel of its screw, not by its angle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from ..description.parts import Pair

KINDS = ("screw", "revolute", "cylindrical")
# Distance, in extents of the linkage, and sine of the angle below which two axes are one.
COAXIAL = 1e-9


@dataclass(frozen=True, eq=False)
class Spindle:
    """A link that turns about one axis.

    Attributes
    ----------
    joints
        Names of its joints.
    lead
        Largest advance of its screws per radian, length, of the linkage's batch shape; 0 where it has several axes.
    """

    joints: frozenset[str]
    lead: Array


def spindles(linkage: LinkageDescription, size: Array) -> dict[str, Spindle]:
    """Spindles of a linkage by the names of their links.

    Parameters
    ----------
    linkage
        The description.
    size
        Extent of the linkage, length, of its batch shape.
    """
    pairs = linkage.joints.values()
    if not any(pair.kind.name == "screw" for pair in pairs):
        return {}
    out = {}
    for link in linkage.links:
        those = [pair for pair in pairs if link in (pair.first, pair.second)]
        pitches = [pair.pitch for pair in those if pair.pitch is not None]
        if pitches and all(pair.kind.name in KINDS for pair in those):
            advance = np.max(np.broadcast_arrays(*map(np.abs, pitches)), axis=0) / (2.0 * np.pi)
            lead = np.where(_coaxial(linkage, those, size), advance, 0.0)
            if lead.any():
                out[link] = Spindle(frozenset(pair.name for pair in those), np.broadcast_to(lead, linkage.shape))
    return out


def turning_units(linkage: LinkageDescription, columns: Sequence[tuple[str, str]], size: Array) -> dict[int, Array]:
    """Units of the angles of spindles, by the place of the coordinate among `columns`.

    Each is the travel of the screw per radian in extents of the linkage, 1 at most, of the linkage's batch shape.
    """
    out: dict[int, Array] = {}
    for spindle in spindles(linkage, size).values():
        unit = np.where(spindle.lead > 0.0, np.minimum(spindle.lead / size, 1.0), 1.0)
        for place, (name, component) in enumerate(columns):
            if name in spindle.joints and component == "rz":
                out[place] = np.minimum(unit, out.get(place, 1.0))
    return out


def _coaxial(linkage: LinkageDescription, pairs: list[Pair], size: Array) -> Array:
    """Whether the axes of joints are one, (...)."""
    lines = [(linkage.points[pair.point], pair.axes[..., 2]) for pair in pairs]
    (origin, axis), *others = lines
    apart = [np.cross(along, axis) for _, along in others]
    apart += [np.cross(at - origin, axis) / size[..., None] for at, _ in others]
    return np.asarray(
        np.all([np.abs(each).max(axis=-1) < COAXIAL for each in np.broadcast_arrays(0.0, *apart)], axis=0)
    )
