"""Places of a grid that no straight line reaches, tried from their neighbours and from poses all over the drives."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .inverse import Bools, InverseKinematics

Numbers = NDArray[np.int64]

BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))
# Number of the nearest poses, out of those all over the range of the drives, from which a place is tried.
TRIED = 6


def everywhere(solver: InverseKinematics, places: Array) -> tuple[Array, Bools, Bools]:
    """Drive values (rows, columns, drives) for a grid of places, and which are reached and could be reached.

    Places beyond a hole or behind a corner are tried from their neighbours, the remaining ones from the nearest place
    that is reached, as long as more are reached. What still remains may need a leg that folds the other way (beyond an
    inverse-kinematic singularity, which stops the point and not the drives), and is tried from poses all over the range
    of the drives.

    Parameters
    ----------
    solver
        The inverse kinematics.
    places
        Wanted positions, (rows, columns, 3).
    """
    shape = places.shape[:2]
    flat, there, possible = solver.solved(places.reshape(-1, 3))
    drives, reached = flat.reshape(*shape, -1), there.reshape(shape)
    could = reached | possible.reshape(shape)
    _spread(solver, places, drives, reached, could)
    if (could & ~reached).any() and _from_anywhere(solver, places, drives, reached, could):
        _spread(solver, places, drives, reached, could)
    return drives, reached, reached | could


def _spread(solver: InverseKinematics, places: Array, drives: Array, reached: Bools, could: Bools) -> None:
    """Continue from reached places to others as long as more are reached; changes `drives` and `reached`."""
    fresh = reached.copy()
    while True:
        target, source = _beside(fresh, reached)
        damped = not len(target)
        if damped:
            target, source = _nearest(could & ~reached, reached)
        if not len(target):
            return
        given, wanted = drives[*source.T], places[*target.T]
        found, good = solver.refined(solver.approached(given, wanted) if damped else given, wanted)
        if damped and not good.any():
            return
        fresh = _write(target[good], found[good], drives, reached)


def _from_anywhere(solver: InverseKinematics, places: Array, drives: Array, reached: Bools, could: Bools) -> bool:
    """Try the remaining places from poses all over the range of the drives; whether more are reached."""
    from scipy.spatial import KDTree  # as in `_nearest`

    start, at = solver.all_over
    if not len(start):
        return False
    target = np.argwhere(could & ~reached)
    nearest = KDTree(at).query(places[*target.T], [*range(1, min(TRIED, len(start)) + 1)])[1]
    wanted = np.repeat(places[*target.T], nearest.shape[1], axis=0)
    found, good = solver.refined(start[nearest.ravel()], wanted)
    good, found = good.reshape(nearest.shape), found.reshape(*nearest.shape, -1)
    there = good.any(axis=-1)
    _write(target[there], found[there, good[there].argmax(axis=-1)], drives, reached)
    return bool(there.any())


def _write(target: Numbers, found: Array, drives: Array, reached: Bools) -> Bools:
    """Store drive values (k, drives) of k newly reached places; returns where these are, (rows, columns)."""
    fresh = np.zeros(reached.shape, dtype=bool)
    fresh[*target.T] = True
    drives[*target.T] = found
    reached |= fresh
    return fresh


def _nearest(left: Bools, reached: Bools) -> tuple[Numbers, Numbers]:
    """Row and column, (k, 2), of remaining places and of the nearest reached place to each; none if none is reached."""
    from scipy.ndimage import distance_transform_edt  # takes long to load, and few workspaces need it

    target = np.argwhere(left & reached.any())
    nearest = distance_transform_edt(~reached, return_distances=False, return_indices=True)
    return target, nearest[:, *target.T].T.astype(np.int64)


def _beside(fresh: Bools, reached: Bools) -> tuple[Numbers, Numbers]:
    """Row and column, (k, 2), of places beside those reached last, and of the reached neighbour of each."""
    by_target: dict[tuple[int, int], tuple[int, int]] = {}
    rows, columns = fresh.shape
    for row, column in np.argwhere(fresh).tolist():
        for down, right in BESIDE:
            to = row + down, column + right
            if 0 <= to[0] < rows and 0 <= to[1] < columns and not reached[to]:
                by_target.setdefault(to, (row, column))
    target, source = (list(each) for each in (by_target, by_target.values()))
    return np.array(target, np.int64).reshape(-1, 2), np.array(source, np.int64).reshape(-1, 2)
