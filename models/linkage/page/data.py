"""What the page of a motion shows: numbers that are linear in everything that its sliders move."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import GROUND
from ..poses.coordinates import coordinate_of
from ..statics.accuracy import accuracy
from ..statics.frame import FramedPoses
from ..statics.reactions import reactions
from ..worst_case.worst_case import WorstCase

# Digits that are written of a number: an error of 1e-12 of it.
DIGITS = 12
# Motion across the plane that is rounding, as a share of the linkage's size.
ROUNDING = 1e-9


def page_data(motion: FramedPoses, point: str, link: str | None, worst: WorstCase | None, drive: str) -> dict[str, Any]:
    """Numbers of a page, as JSON has them; null where a pose has none.

    Parameters
    ----------
    motion
        Where the linkage is, (poses,).
    point, link
        The point that is looked at, and the link on which it is taken.
    worst
        What clearances and tolerances let it reach; None where nothing deviates.
    drive
        The drive whose values name the poses.
    """
    axes = [0, 1] if is_flat(motion) else [0, 1, 2]
    angular, values = motion.linkage.drives[drive][0][0] == "r", driven(motion, drive)
    here = {name: motion.position(name)[..., axes] for name in _drawn(motion)}
    return {
        "drive": {
            "name": drive,
            "unit": "°" if angular else "",
            "values": listed(np.degrees(values) if angular else values),
        },
        "status": np.broadcast_to(motion.status, motion.shape).tolist(),
        "dimensions": len(axes),
        "points": {name: listed(place) for name, place in here.items()},
        "links": [{"name": name, "points": list(each.points)} for name, each in motion.linkage.links.items()],
        "joints": [
            {
                "name": name,
                "kind": each.kind.name,
                "point": each.point,
                "ground": GROUND in (each.first, each.second),
                "axis": listed(motion.axes(each.first)[..., axes, :] @ each.axes[:, _shown_axis(each.kind.name)]),
            }
            for name, each in motion.linkage.joints.items()
        ],
        "point": {"name": point, "place": listed(motion.position(point, link)[..., axes])},
        "loaded": _loaded(motion, point, link, axes),
        "limits": [] if worst is None else _limits(worst, motion.shape, axes),
        "reactions": _reactions(motion, axes),
    }


def driven(motion: FramedPoses, drive: str) -> Array:
    """Values of a drive's first coordinate, (poses,), radians or a length."""
    pair = motion.linkage.joint(drive)
    number = pair.kind.coordinates.index(motion.linkage.drives[drive][0])
    return np.asarray(coordinate_of(motion, pair)[..., number])


def is_flat(motion: FramedPoses) -> bool:
    """Whether all links move in planes z = const and turn about z alone."""
    there, size = motion.is_assembled, motion.mechanism.size
    for link in motion.linkage.links:
        tilted = np.abs(motion.axes(link)[..., 2] - np.array([0.0, 0.0, 1.0])).max(axis=-1)
        lifted = np.abs(motion.origin(link)[..., 2])
        if np.any(tilted[there] > ROUNDING) or np.any(lifted[there] > ROUNDING * size):
            return False
    return True


def listed(values: Array) -> list[Any]:
    """Numbers as JSON has them, to `DIGITS` digits; None where there is none."""
    if values.ndim > 1:
        return [listed(each) for each in values]
    return [float(f"{each:.{DIGITS}g}") + 0.0 if np.isfinite(each) else None for each in values.tolist()]


def _drawn(motion: FramedPoses) -> list[str]:
    """Points of links and joints."""
    linkage = motion.linkage
    used = {name for link in linkage.links.values() for name in link.points}
    used |= {pair.point for pair in linkage.joints.values()}
    return [name for name in linkage.points if name in used]


def _shown_axis(kind: str) -> int:
    """Number of the joint's axis that tells how it lies: that along which it slides, else that about which it turns."""
    return 0 if kind == "prismatic" else 2


def _loaded(motion: FramedPoses, point: str, link: str | None, axes: list[int]) -> dict[str, Any] | None:
    """Displacement by compliance under the linkage's own loads, with its error bound; None where nothing gives way."""
    elastic = any(each.beams for each in motion.linkage.links.values()) or any(
        pair.stiffness is not None for pair in motion.linkage.joints.values()
    )
    if not elastic or not motion.linkage.loads:
        return None
    found = accuracy(motion, point, link, {}, inertia=False)
    bound = np.broadcast_to(found.closed.error_bound(found.point), (*motion.shape, 6))
    moved = np.broadcast_to(found.compliance, (*motion.shape, 6))
    return {"displacement": listed(moved[..., axes]), "bound": listed(bound[..., axes])}


def _limits(worst: WorstCase, shape: tuple[int, ...], axes: list[int]) -> list[dict[str, Any]]:
    """Derivatives by each deviation in its first order, (poses, axes, m), with its radius and middle, (poses,)."""
    return [
        {
            "name": each.name,
            "by": listed(np.broadcast_to(each.by, (*shape, *each.by.shape[-2:]))[..., axes, :]),
            "radius": listed(np.broadcast_to(each.radius, shape)),
            "middle": listed(np.broadcast_to(each.middle, shape)),
        }
        for each in worst.limits
    ]


def _reactions(motion: FramedPoses, axes: list[int]) -> dict[str, list[Any]]:
    """Forces of the joints on their second links, under the linkage's own loads, (poses, axes) each."""
    if not motion.linkage.loads:
        return {}
    found = reactions(motion)
    forces: Mapping[str, NDArray[np.float64]] = {name: found.force(name) for name in motion.linkage.joints}
    return {name: listed(np.broadcast_to(each, (*motion.shape, 6))[..., axes]) for name, each in forces.items()}


def checked(motion: FramedPoses, drive: str | None) -> str:
    """The drive that names the poses."""
    if len(motion.shape) != 1 or not motion.is_assembled.any():
        raise FrameError(f"a page of a motion of shape {motion.shape}: give one axis of poses, some of them assembled")
    if motion.linkage.springs:
        raise FrameError("a page of a linkage with springs: their forces do not follow its loads, leave them out")
    there = list(motion.linkage.drives)
    if not there:
        raise FrameError("a page of a linkage without a drive: nothing moves")
    if drive is None:
        moved = [name for name in there if np.nanmax(driven(motion, name)) > np.nanmin(driven(motion, name))]
        return (moved or there)[0]
    if drive not in there:
        raise FrameError(f"joint {drive!r} is no drive: choose one of {', '.join(there)}")
    return drive
