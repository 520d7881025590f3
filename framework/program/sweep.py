"""Results of a long batch that are written down together, and then made in one pass over the batch."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..batch import Array, Shape
from ..structure.parts import Grid, Row, Value, mask_of_shape
from .calculation import Calculation
from .recording import Recording, Term

# Entries from which on the steps of a result take longer than to write them down; those that NumPy does at once.
LONG, CHUNK = 2**14, 2**13
# Numbers in a line of the cache, and in a large page of memory.
LINE, PAGE = 8, 2**18
# From so many numbers on the C library asks the system for memory each time, and gives it back.
NEW = 2**22


class Sweep:
    """A recording that values of combinations begin with, and what becomes of it.

    Parameters
    ----------
    grid
        The batch.
    recording
        What is written down already.
    values
        Writes down the values of combinations of unknowns and right-hand-side parameters.
    """

    def __init__(self, grid: Grid, recording: Recording, values: Callable[[Sequence[Row]], Sequence[Value]]) -> None:
        self.grid, self.recording, self.values = grid, recording, values

    def run(self, asked: Sequence[Sequence[Value]]) -> list[Array]:
        """Some results, each of numbers that were written down or are the same throughout.

        Returns
        -------
        list of ndarray
            Each (..., n), number by number in memory, where what is zero is never touched.
        """
        grid = self.grid
        whole = [zeros(len(numbers), grid.shape) for numbers in asked]
        terms: list[Term] = []
        places: list[Array] = []
        for array, numbers in zip(whole, asked, strict=True):
            for place, number in zip(array, numbers, strict=True):
                if isinstance(number, Term):
                    terms.append(number)
                    places.append(place)
                elif np.any(number):
                    place[...] = number
        if terms:
            self._fill(terms, places)
        return [np.moveaxis(array, 0, -1) for array in whole]

    def _fill(self, terms: Sequence[Term], places: Sequence[Array]) -> None:
        """Put numbers in their places, by way of less memory where they vary over less than the batch."""
        shape = self.grid.shape
        calculation = Calculation.recorded(self.recording, terms, shape)
        axis, slices = self.grid.slices(math.prod(shape) if calculation.choice.compiled else CHUNK)
        full = mask_of_shape(shape)
        made = [
            place if term.mask == full else np.empty(calculation.of(term.mask))
            for term, place in zip(terms, places, strict=True)
        ]
        for indices in slices:
            part = (*(slice(None),) * axis, indices)
            cut = [out[part] if term.mask >> axis & 1 else out for term, out in zip(terms, made, strict=True)]
            calculation.run(axis, indices, cut)
        for place, out in zip(places, made, strict=True):
            if out is not place and np.any(out):
                place[...] = out


def zeros(count: int, shape: Shape) -> Array:
    """So many arrays of zeros, (count, ...), none of which is in memory before it is written to.

    All begin with a line of the cache, so that machine code writes whole lines. So many that their memory is always new
    begin with a large page: small ones take ten times as long to be made.
    """
    size = math.prod(shape)
    pitch = size + -size % LINE
    step = PAGE if count * pitch > NEW else LINE
    room = np.zeros(count * pitch + 2 * step)
    start = -room.__array_interface__["data"][0] // room.itemsize % step
    return room[start : start + count * pitch].reshape(count, pitch)[:, :size].reshape(count, *shape)
