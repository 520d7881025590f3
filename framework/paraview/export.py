"""Save a solution for ParaView: one pose as a .vtu, a batch axis as a .pvd of many."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ..batch import finite
from ..errors import FrameError
from ..results.base import Results
from .blocks import write_series
from .entries import Entry, Index, one, series
from .files import whole_or_nothing
from .scene import Part, beams, joints
from .vtu import write_grid, write_names


def save(
    solution: Results,
    path: str | Path,
    *,
    entry: Entry | None = None,
    axis: int | None = None,
    times: ArrayLike | None = None,
    stations: int = 8,
) -> None:
    """Write a solution for ParaView, whole or not at all, see `SavedResults.save`.

    A .vtu has beams as line cells and joints as vertex cells of one grid, told apart by the cell array ``part``. A .pvd
    has for each pose the named blocks ``beams`` and ``joints``, in files of their own in the folder of its name, where
    README.txt tells what each array is, and open_in_paraview.py opens the series in ParaView.

    The arrays are those of `scene.beams` and `scene.joints`: on points ``displacement``, ``rotation``; for
    beams ``N V T M`` (global) and ``stress_min stress_max von_mises`` on points, ``V_local M_local`` and
    ``member link solved`` on cells; for joints ``gap gap_rotation force moment`` (global) and, where there is
    clearance, ``clearance_offset contact`` on points, ``joint solved`` on cells. Where there
    is no solution, as of a mechanism, ``solved`` is 0 and so are the results. Numbers of members, links and joints
    follow the order of the description; `read_names` gives their names, which each pose of a series also holds as the
    strings ``member_names``, ``link_names`` and ``joint_names`` of its field data.

    In ParaView: Warp By Vector (displacement), Extract Surface, Tube.
    """
    path = Path(path)
    if stations not in range(1, 1001):
        raise FrameError(f"{path.name} was given {stations!r} stations a member: give a whole number from 1 to 1000")
    if 0 in solution.shape:
        raise FrameError(f"{path.name}: the batch shape is {solution.shape}, without entries: save one that has some")
    if path.suffix == ".vtu":
        if axis is not None or times is not None:
            raise FrameError(f"{path.name} holds one pose, without axis or times: save as .pvd for a series of poses")
        _save_pose(solution, path, one(solution.shape, entry, path.name), stations)
    elif path.suffix == ".pvd":
        index = series(solution.shape, axis, entry, path.name)
        count = len(np.broadcast_to(0.0, solution.shape)[index])
        _save_series(solution, path, index, increasing(times, count, path), stations)
    else:
        raise FrameError(f"{path.name} is neither .vtu (one pose) nor .pvd (a series of poses): choose one of them")


def _save_pose(solution: Results, path: Path, index: Index, stations: int) -> None:
    with whole_or_nothing(path.parent) as stage:
        write_grid(stage / path.name, _parts(solution, index, stations), 0)
        write_names(stage / path.name, _names(solution))


def _save_series(solution: Results, path: Path, index: Index, times: Sequence[float], stations: int) -> None:
    with whole_or_nothing(path.parent) as stage:
        write_series(stage / path.name, _parts(solution, index, stations), times, _names(solution))
        write_names(stage / path.name, _names(solution))


def _parts(solution: Results, index: Index, stations: int) -> list[Part]:
    frame = solution.frame
    parts = [beams(solution, index, stations)] if frame.members else []
    parts += [joints(solution, index)] if frame.joints else []
    if not parts:
        raise FrameError("the frame has no member and no joint to save: add one")
    return parts


def _names(solution: Results) -> dict[str, list[str]]:
    frame = solution.frame
    return {"member": list(frame.members), "link": list(frame.bodies), "joint": list(frame.joints)}


def increasing(times: ArrayLike | None, count: int, path: Path) -> list[float]:
    """Times of `count` poses: as given, checked, or their numbers."""
    if times is None:
        return [float(pose) for pose in range(count)]
    given = finite(times, f"times of {path.name}")
    if given.shape != (count,):
        raise FrameError(f"times of {path.name} have shape {given.shape}: give {count} increasing numbers, one a pose")
    if (back := np.flatnonzero(np.diff(given) <= 0.0)).size:
        before, after = given[back[0]], given[back[0] + 1]
        raise FrameError(
            f"times of {path.name} go from {before:g} to {after:g}: give {count} increasing numbers, one a pose"
        )
    return [float(time) for time in given]
