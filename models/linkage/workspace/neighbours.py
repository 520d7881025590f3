"""Places of a grid that no straight line reaches, tried from those beside them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .inverse import Bools, InverseKinematics

Numbers = NDArray[np.int64]

BESIDE = ((0, 1), (0, -1), (1, 0), (-1, 0))
# Pieces of the way to a place that is too far from the one beside it for Newton's method.
PIECES = 8


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
        given, start, wanted = drives[*source.T], places[*source.T], places[*target.T]
        found, good = solver.refined(given, wanted)
        far = ~good & possible.reshape(shape)[*target.T]
        found[far], good[far] = _by_pieces(solver, given[far], start[far], wanted[far])
        rows, columns = target[good].T
        drives[rows, columns] = found[good]
        fresh = np.zeros(shape, dtype=bool)
        fresh[rows, columns] = True
        reached |= fresh


def _by_pieces(solver: InverseKinematics, drives: Array, start: Array, end: Array) -> tuple[Array, Bools]:
    """Drive values (k, drives) that bring the point from places `start` to places `end`, (k, 3), and which do, (k,)."""
    good = np.ones(len(drives), dtype=bool)
    for share in np.arange(1, PIECES + 1) / PIECES:
        on = np.flatnonzero(good)
        if len(on):
            drives[on], good[on] = solver.refined(drives[on], start[on] + share * (end - start)[on])
    return drives, good


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
