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

    What lies beyond a hole or beside a corner is tried from the places beside it, as long as that reaches more.

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
    fresh = reached.copy()
    while True:
        target, source = _beside(fresh, reached)
        if not len(target):
            return drives, reached, reached | possible.reshape(shape)
        found, good = solver.refined(drives[source[:, 0], source[:, 1]], places[target[:, 0], target[:, 1]])
        rows, columns = target[good].T
        drives[rows, columns] = found[good]
        fresh = np.zeros(shape, dtype=bool)
        fresh[rows, columns] = True
        reached |= fresh


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
