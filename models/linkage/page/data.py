"""Numbers of the page of a motion, which are linear in all that its sliders change."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import GROUND
from ..graphics.plane import ROUNDING, plane
from ..graphics.scene import points_in_use
from ..poses.coordinates import some_coordinates
from ..statics.frame import FramedPoses
from ..worst_case.starts import circle, sphere
from ..worst_case.worst_case import WorstCase
from .forces import Parts, displacement, drawn_loads, drawn_springs, forces_of_joints_and_drives, status

# Significant digits of the numbers.
DIGITS = 12
# Significant digits of numbers that are only drawn.
DRAWN = 5
# Largest size in bytes of the numbers on a page in the plane and in space, and largest number of poses.
ROOM, MOST_POSES = {2: 250_000, 3: 900_000}, 721
# Number of directions in which the outermost samples are drawn, in the plane and in space.
DIRECTIONS = {2: 16, 3: 40}
REDUNDANT = (
    "Worst cases are not on this page: the linkage has redundant constraints that clearances and tolerances would "
    "open, so that these cannot come about independently. Motion.worst_case has the numbers."
)


def page_data(
    motion: FramedPoses,
    point: str,
    link: str | None,
    worst: WorstCase | None,
    drive: str,
    samples: Array | None = None,
    told: NDArray[np.str_] | None = None,
) -> dict[str, Any]:
    """Numbers of a page; the first axis of each array is that of the poses.

    Parameters
    ----------
    motion
        The motion of the linkage, (poses,).
    point, link
        The point that the page is about, and the link on which it lies.
    worst
        Its worst case under clearances and tolerances; None if nothing deviates.
    drive
        The drive whose values label the poses.
    samples
        Displacements of the point from its rigid position, (poses, samples, 3), to be drawn.
    told
        Status of the poses, (poses,), where it is known otherwise.
    """
    loaded, (forces, pushes) = displacement(motion, point, link), forces_of_joints_and_drives(motion)
    bent = [loaded["displacement"]] if loaded else []
    flat = plane(motion) == (0, 1) and not _across(worst, bent, list(forces.values()))
    axes = [0, 1] if flat else [0, 1, 2]
    angular, values = motion.linkage.drives[drive][0][0] == "r", driven(motion, drive)
    redundant = worst is not None and worst.position.stress is not None
    return {
        "drive": {"name": drive, "turns": angular, "values": np.degrees(values) if angular else values},
        "status": status(motion, point, link) if told is None else told,
        "dimensions": len(axes),
        "points": {name: motion.position(name)[..., axes] for name in points_in_use(motion.linkage)},
        "links": [{"name": name, "points": list(each.points)} for name, each in motion.linkage.links.items()],
        "joints": _joints(motion, axes),
        "springs": drawn_springs(motion, axes),
        "loads": drawn_loads(motion, axes),
        "scalable": bool(motion.linkage.loads),
        "point": {"name": point, "place": motion.position(point, link)[..., axes]},
        "loaded": loaded and {name: _along(part, axes) for name, part in loaded.items()},
        "limits": [] if worst is None or redundant else _limits(worst, motion.shape, axes),
        "reactions": {name: _along(part, axes) for name, part in forces.items()},
        "drives": pushes,
        "cloud": None if samples is None else _outermost(samples[..., axes]),
        "notes": [REDUNDANT] if redundant else [],
    }


def as_json(data: dict[str, Any]) -> str:
    """The data of a page as JSON; if the poses do not fit, only every second, third ... one.

    The poses of a grid are never left out: a grid that is too large is refused.
    """
    poses, grid, room = len(data["status"]), data["grid"], ROOM[data["dimensions"]]
    every = 1 if grid else max(1, -(-poses // MOST_POSES))
    while True:
        # the values of the grid's axes are not thinned with the poses
        thinned = {**data, "every": every, "grid": [{**axis, "values": listed(axis["values"])} for axis in grid]}
        text = json.dumps(_listed(thinned, every), ensure_ascii=False, allow_nan=False, separators=(",", ":"))
        size = len(text.encode())
        if grid and (size > room or poses > MOST_POSES):
            given = " x ".join(str(len(axis["values"])) for axis in grid)
            most = min(MOST_POSES, poses * room // size)
            raise FrameError(f"a page of {given} poses is too large: give the drives fewer values, for {most} poses")
        if size <= room or every >= poses:
            return text
        every = max(every + 1, round(every * len(text) / room))


def _listed(value: Any, every: int) -> Any:
    """The data with lists in place of arrays, of which every `every`-th pose is kept."""
    if isinstance(value, dict):
        return {name: _listed(each, every) for name, each in value.items()}
    if isinstance(value, list):
        return [_listed(each, every) for each in value]
    if not isinstance(value, np.ndarray):
        return value
    kept = value[::every]
    if kept.dtype.kind in "US":
        return kept.tolist()
    return listed(kept, DRAWN if kept.dtype == np.float32 else DIGITS)


def driven(motion: FramedPoses, drive: str) -> Array:
    """Values of a drive's first coordinate, (poses,), radians or a length."""
    return some_coordinates(motion, drive, motion.linkage.drives[drive])[..., 0]


def _along(part: Parts, axes: list[int]) -> Parts:
    return {name: value[..., axes] for name, value in part.items()}


def _across(worst: WorstCase | None, *quantities: list[Parts]) -> bool:
    """Whether deviations or forces have components out of the plane of x and y."""
    found = [[value[..., :3] for part in parts for value in part.values()] for parts in quantities]
    if worst is not None:
        moved = [each.by[..., :6, :] * each.radius[..., None, None] for each in worst.limits]
        found.append([np.moveaxis(each, -2, -1)[..., :3] for each in moved])
        # a rotation about an axis in the plane leaves the plane as well
        found += [[np.moveaxis(each, -2, -1)[..., [5, 5, axis]] for each in moved] for axis in (3, 4)]
    for values in found:
        sizes = [np.abs(np.nan_to_num(each)).reshape(-1, 3).max(axis=0) for each in values if each.size]
        greatest = np.max(sizes, axis=0) if sizes else np.zeros(3)
        if greatest[-1] > ROUNDING * greatest.max():
            return True
    return False


def listed(values: Array, digits: int = DIGITS) -> list[Any]:
    """Numbers as nested lists for JSON, rounded to so many significant digits; None for NaN and infinity."""
    if values.ndim > 1:
        return [listed(each, digits) for each in values]
    # a whole number is shorter without its decimal point
    rounded = (float(f"{each:.{digits}g}") if np.isfinite(each) else None for each in values.tolist())
    return [int(each) if each is not None and each.is_integer() and abs(each) < 1e15 else each for each in rounded]


def _joints(motion: FramedPoses, axes: list[int]) -> list[dict[str, Any]]:
    """Joints with their kind and point; those of sliders, and in space all of them, also with their axis."""
    found = []
    for name, each in motion.linkage.joints.items():
        joint: dict[str, Any] = {
            "name": name,
            "kind": each.kind.name,
            "point": each.point,
            "ground": GROUND in (each.first, each.second),
            "driven": name in motion.linkage.drives,
        }
        if each.kind.name == "prismatic" or len(axes) > 2:
            lies = motion.axes(each.first)[..., axes, :] @ each.axes[:, 2]
            joint["axis"] = np.broadcast_to(lies, (*motion.shape, len(axes))).astype(np.float32)
        found.append(joint)
    return found


def _limits(worst: WorstCase, shape: tuple[int, ...], axes: list[int]) -> list[dict[str, Any]]:
    """Derivatives of position and rotation by each deviation, (poses, axes, m), with its radius and middle.

    In the plane there is only the rotation about its normal.
    """
    turns = [5] if len(axes) == 2 else [3, 4, 5]
    found = []
    for each in worst.limits:
        by = np.broadcast_to(each.by, (*shape, *each.by.shape[-2:]))
        limit: dict[str, Any] = {"name": each.name, "by": by[..., axes, :], "turn": by[..., turns, :]}
        limit["angle"] = each.name.startswith("drive ") and _turns(worst, each.name.removeprefix("drive "))
        for name, value in (("radius", each.radius), ("middle", each.middle)):
            # a value common to all poses is written once
            limit[name] = float(value) if value.ndim == 0 else np.broadcast_to(value, shape)
        found.append(limit)
    return found


def _turns(worst: WorstCase, joint: str) -> bool:
    return worst.sensitivity.linkage.drives[joint][0][0] == "r"


def _outermost(samples: Array) -> Array:
    """The outermost samples in several directions at each pose, (poses, directions, axes); NaN if there are none."""
    dimensions = samples.shape[-1]
    n = (circle if dimensions == 2 else sphere)(DIRECTIONS[dimensions])
    known = np.isfinite(samples).all(axis=-1, keepdims=True)
    along = np.where(known, np.nan_to_num(samples) @ n.T, -np.inf)
    farthest = np.take_along_axis(samples, along.argmax(axis=1)[..., None], axis=1)
    some = np.asarray(np.any(known, axis=1))
    return np.asarray(np.where(some[:, None], farthest, np.nan), dtype=np.float32)


def traced_point(motion: FramedPoses) -> str | None:
    """The point that a page is about by default: the only one with a load, or else the only one without a joint.

    None if there are several or none.
    """
    linkage = motion.linkage
    joined = {pair.point for pair in linkage.joints.values()}
    loaded = {load.point for load in linkage.loads if load.point is not None and load.link != GROUND}
    free = {point for link in linkage.links.values() for point in link.points if point not in joined}
    chosen: Sequence[str] = sorted(loaded) if loaded else sorted(free)
    return chosen[0] if len(chosen) == 1 else None


def checked(motion: FramedPoses, drive: str | None) -> str:
    """The drive whose values label the poses, checked; by default the first that moves."""
    if len(motion.shape) != 1 or not motion.is_assembled.any():
        raise FrameError(
            f"a page of a motion of shape {motion.shape}: give one axis of poses, some of them assembled; or, to "
            "Linkage.page, drives with an axis each"
        )
    there = list(motion.linkage.drives)
    if not there:
        raise FrameError("a page of a linkage without a drive: nothing moves")
    if drive is None:
        moved = [name for name in there if np.nanmax(driven(motion, name)) > np.nanmin(driven(motion, name))]
        return (moved or there)[0]
    if drive not in there:
        raise FrameError(f"joint {drive!r} is no drive: choose one of {', '.join(there)}")
    return drive
