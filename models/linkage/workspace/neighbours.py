"""Places of a grid that no straight line reaches, tried from those beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .inverse import Bools, InverseKinematics

Numbers = NDArray[np.int64]

BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))


def everywhere(solver: InverseKinematics, places: Array) -> tuple[Array, Bools, Bools]:
    """Drive values (rows, columns, drives) for a grid of places (rows, columns, 3), and which are and could be reached.

    What lies beyond a hole or beside a corner is tried from the places beside it, what is then left from the nearest
    that is reached, as long as that reaches more.

    Parameters
    ----------
    solver
        The inverse kinematics.
    places
        Wanted positions.
    """
    shape = places.shape[:2]
    flat, there, possible = solver.solved(places.reshape(-1, 3))
    drives, reached = flat.reshape(*shape, -1), there.reshape(shape)
    could = reached | possible.reshape(shape)
    fresh = reached.copy()
    while True:
        target, source = _beside(fresh, reached)
        damped = not len(target)
        if damped:
            target, source = _nearest(could & ~reached, reached)
        if not len(target):
            return drives, reached, reached | could
        given, wanted = drives[*source.T], places[*target.T]
        found, good = solver.refined(solver.approached(given, wanted) if damped else given, wanted)
        rows, columns = target[good].T
        if damped and not len(rows):
            return drives, reached, reached | could
        drives[rows, columns] = found[good]
        fresh = np.zeros(shape, dtype=bool)
        fresh[rows, columns] = True
        reached |= fresh


def _nearest(left: Bools, reached: Bools) -> tuple[Numbers, Numbers]:
    """Places that are left, and the nearest to each that is reached, (k, 2) each; none where none is reached."""
    from scipy.ndimage import distance_transform_edt  # takes long to load, and few workspaces need it

    target = np.argwhere(left & reached.any())
    nearest = distance_transform_edt(~reached, return_distances=False, return_indices=True)
    return target, nearest[:, *target.T].T.astype(np.int64)


def _beside(fresh: Bools, reached: Bools) -> tuple[Numbers, Numbers]:
    """Places not reached beside those that were reached last, each once, and the one beside it, (k, 2) each."""
    by_target: dict[tuple[int, int], tuple[int, int]] = {}
    rows, columns = fresh.shape
    for row, column in np.argwhere(fresh).tolist():
        for down, right in BESIDE:
            to = row + down, column + right
            if 0 <= to[0] < rows and 0 <= to[1] < columns and not reached[to]:
                by_target.setdefault(to, (row, column))
    target, source = (list(each) for each in (by_target, by_target.values()))
    return np.array(target, np.int64).reshape(-1, 2), np.array(source, np.int64).reshape(-1, 2)
