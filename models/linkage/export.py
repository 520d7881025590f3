"""A rigid motion for ParaView: links as lines between their points, a .pvd of all poses."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import Array
from ...framework.errors import FrameError
from ...framework.paraview.blocks import write_series
from ...framework.paraview.export import increasing
from ...framework.paraview.files import whole_or_nothing
from ...framework.paraview.scene import Part
from ...framework.paraview.vtu import write_names
from .poses.kinematics import Kinematics


def save(motion: Kinematics, path: str | Path, times: ArrayLike | None) -> None:
    """See `Motion.save`."""
    path = Path(path)
    if path.suffix != ".pvd":
        raise FrameError(f"{path.name} does not end in .pvd, a series of poses for ParaView, or .dxf, a drawing")
    if len(motion.shape) > 1:
        raise FrameError(f"{path.name} holds one row of poses, but the batch shape is {motion.shape}: save one row")
    there = np.flatnonzero(motion.is_assembled)
    if not len(there):
        raise FrameError(f"{path.name}: no pose is assembled, so there is nothing to save")
    given = increasing(times, int(np.prod(motion.shape)), path)
    with whole_or_nothing(path.parent) as stage:
        names = {"link": list(motion.linkage.links)}
        write_series(stage / path.name, [_links(motion, there)], [given[k] for k in there], names)
        write_names(stage / path.name, names)


def _links(motion: Kinematics, poses: NDArray[np.int64]) -> Part:
    """Links as lines: their beams, or else from point to point, closed if a link has more than two points."""
    points: list[Array] = []
    cells: list[tuple[int, int]] = []
    owner: list[int] = []
    data: dict[str, list[Array]] = {"velocity": [], "acceleration": []}
    for number, (name, link) in enumerate(motion.linkage.links.items()):
        first = len(points)
        numbers = {point: first + index for index, point in enumerate(link.points)}
        points += [motion.position(point, name) for point in link.points]
        data["velocity"] += [motion.velocity(point, name) for point in link.points]
        data["acceleration"] += [motion.acceleration(point, name) for point in link.points]
        ring = list(zip(link.points, (*link.points[1:], link.points[0]), strict=True))
        lines = list(link.beams) or ring[: max(1, len(ring) - (len(ring) < 3))]
        cells += [(numbers[a], numbers[b]) for a, b in lines]
        owner += [number] * len(lines)

    def taken(vectors: list[Array]) -> Array:
        return np.stack([np.broadcast_to(v, (*motion.shape, 3)).reshape(-1, 3)[poses] for v in vectors], axis=1)

    links = np.broadcast_to(np.array(owner, dtype=np.int32), (len(poses), len(owner)))
    arrays = {name: taken(vectors) for name, vectors in data.items()}
    return Part("links", "line", taken(points), np.array(cells), arrays, {"link": links})
