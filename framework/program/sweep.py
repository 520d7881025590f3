"""Many results of a long batch, recorded together and computed in one pass over the batch."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..batch import Array, Shape
from ..structure.parts import Grid, Row, Value, mask_of_shape
from .calculation import Calculation
from .recording import Recording, Term

# Number of entries above which running the steps of a result takes longer than recording them; size of NumPy's chunks.
LONG, CHUNK = 2**14, 2**13
# Size of chunks for machine code that takes what is computed chunk by chunk.
LONGER = 2**15
# Numbers in a cache line, and in a large memory page.
LINE, PAGE = 8, 2**18
# For arrays above this size the C library requests memory from the system each time, and returns it.
NEW = 2**22


class Sweep:
    """A recording of the unknowns, to which results are added, and their computation over the batch.

    Parameters
    ----------
    grid
        The batch.
    recording
        The recording so far.
    values
        Function that records the values of rows over unknowns and right-hand-side parameters.
    later
        Function that returns the numbers which the recording leaves open, at some indices of a batch axis; None if it
        leaves none open.
    """

    def __init__(
        self,
        grid: Grid,
        recording: Recording,
        values: Callable[[Sequence[Row]], Sequence[Value]],
        later: Callable[[int, slice], list[Value]] | None = None,
    ) -> None:
        self.grid, self.recording, self.values, self._later = grid, recording, values, later

    def run(self, asked: Sequence[Sequence[Value]], watched: Sequence[Value] = ()) -> tuple[list[Array], list[Array]]:
        """Compute some results, each of n numbers that are recorded terms or constants, and single numbers besides.

        Returns
        -------
        results
            Arrays (..., n), each number contiguous over the batch; memory of zeros is never touched.
        watched
            The single numbers, each of the shape over which it varies.
        """
        grid = self.grid
        whole = [zeros(len(numbers), grid.shape) for numbers in asked]
        terms: list[Term] = []
        places: list[Array | None] = []
        for array, numbers in zip(whole, asked, strict=True):
            for place, number in zip(array, numbers, strict=True):
                if isinstance(number, Term):
                    terms.append(number)
                    places.append(place)
                elif np.any(number):
                    place[...] = number
        computed = [number for number in watched if isinstance(number, Term)]
        made = self._filled([*terms, *computed], [*places, *(None for _ in computed)])
        seen = iter(made[len(terms) :])
        alone = [next(seen) if isinstance(number, Term) else np.asarray(number) for number in watched]
        return [np.moveaxis(array, 0, -1) for array in whole], alone

    def _filled(self, terms: Sequence[Term], places: Sequence[Array | None]) -> list[Array]:
        """Arrays of terms, which are written to their places; of the shape over which they vary where that is None."""
        if not terms:
            return []
        shape = self.grid.shape
        calculation = Calculation.recorded(self.recording, terms, shape)
        later = self._later if calculation.needed else None
        full = mask_of_shape(shape)
        made = [
            place if place is not None and term.mask == full else np.empty(calculation.of(term.mask))
            for term, place in zip(terms, places, strict=True)
        ]
        axis, slices = self.grid.slices(self._entries(calculation, whole=later is None))
        for indices in slices:
            part = (*(slice(None),) * axis, indices)
            cut = [out[part] if term.mask >> axis & 1 else out for term, out in zip(terms, made, strict=True)]
            calculation.run(axis, indices, cut, later(axis, indices) if later else ())
        for place, out in zip(places, made, strict=True):
            if place is not None and out is not place and np.any(out):
                place[...] = out
        return made

    def _entries(self, calculation: Calculation, *, whole: bool) -> int:
        """Number of entries at a time: whole batches where nothing is stored on the way, and nothing is left open."""
        if not calculation.choice.compiled:
            return CHUNK
        return LONGER if calculation.stores or not whole else math.prod(self.grid.shape)


def zeros(count: int, shape: Shape) -> Array:
    """An array of zeros, (count, ...), whose memory is allocated by the system as it is written.

    Each of the `count` parts begins at a cache line, so that machine code writes whole lines. A large array, whose
    memory is always new, begins at a large page: small pages take ten times as long to allocate.
    """
    size = math.prod(shape)
    pitch = size + -size % LINE
    step = PAGE if count * pitch > NEW else LINE
    room = np.zeros(count * pitch + 2 * step)
    start = -room.__array_interface__["data"][0] // room.itemsize % step
    return room[start : start + count * pitch].reshape(count, pitch)[:, :size].reshape(count, *shape)
