"""Forces on the ends of a piece over a long batch: written down number by number, and done where the numbers lie."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from ..batch import Array, aligned
from ..program.calculation import Calculation
from ..program.recording import Recording, Term
from ..structure.group import Group
from ..structure.parts import Grid, Row, Value, combine

# Entries from which on the steps of a piece take longer than to write them down; those that NumPy does at once.
LONG, CHUNK = 2**14, 2**13


def forces_on_ends(
    grid: Grid, group: Group, position: int, rows: Sequence[Row], nodal: Array, loads: Array
) -> Array | None:
    """Forces on both ends of a piece in its local axes.

    Parameters
    ----------
    grid
        The batch.
    group, position
        Where the piece is.
    rows, nodal
        Displacements of its ends in the axes of the nodes: what they are made of, and they themselves, (..., 12).
    loads
        Forces on the ends that do the work of its loads, (..., 12).

    Returns
    -------
    ndarray or None
        (..., 12), number by number in memory; None where the batch is not long, or the element has no such formula.
    """
    depth = len(grid.shape)
    if math.prod(grid.shape) < LONG:
        return None
    recording = Recording()
    length = aligned(group.length[position], depth)
    moved = [recording.take(nodal[..., k]) if row else 0.0 for k, row in enumerate(rows)]
    turns = [[recording.take(x) for x in grid.components(turn[position], 2)] for turn in group.end_axes]
    local = [
        combine([(turns[block // 2][3 * i + j], moved[3 * block + j]) for j in range(3)])
        for block in range(4)
        for i in range(3)
    ]
    found = group.of(position).end_force_numbers(length, local)
    if found is None:
        return None
    return _done(recording, grid, [force - load for force, load in zip(found, grid.components(loads), strict=True)])


def _done(recording: Recording, grid: Grid, numbers: Sequence[Value | Term]) -> Array:
    """The numbers of a batch, (..., n): of a recording, or the same throughout."""
    whole = np.zeros((len(numbers), *grid.shape))
    terms = {k: number for k, number in enumerate(numbers) if isinstance(number, Term)}
    for k, number in enumerate(numbers):
        if not isinstance(number, Term) and (same := np.asarray(number)).any():
            whole[k] = same
    calculation = Calculation.recorded(recording, list(terms.values()), grid.shape)
    axis, slices = grid.slices(math.prod(grid.shape) if calculation.choice.compiled else CHUNK)
    full = (1 << len(grid.shape)) - 1
    shapes = {k: calculation.of(term.mask) for k, term in terms.items()}
    places = {k: whole[k] if terms[k].mask == full else np.empty(shape) for k, shape in shapes.items()}
    for indices in slices:
        cut = (*(slice(None),) * axis, indices)
        calculation.run(axis, indices, [place[cut] if shapes[k][axis] > 1 else place for k, place in places.items()])
    for k, place in places.items():
        if terms[k].mask != full:
            whole[k] = place
    return np.moveaxis(whole, 0, -1)
