"""Solutions of a batch of banded matrices in one pass over its entries, by the machine code of `band_pass_code`.

What the factors of `stacked_bands` and the refinement of `stacked_refinement` do in turn for all entries is done here
from the stiffness of springs on, without storing matrices. Entries whose pivots or refinement leave a doubt are left to
these.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..program.band_pass_code import BandPass, Cells, Refinement
from ..program.machine_text import WIDTH
from ..structure.topology import Index
from .deformation_table import Deformations
from .evaluation import Picked
from .rounding import surely_positive
from .stacked_bands import Bands, stiffness_of
from .stacked_refinement import FINE, LOST, SAFE, STEPS

# Bytes of the numbers of springs and results that are handled at a time, which should stay in the cache.
_ROOM = 2**21
_EPS = float(np.finfo(np.float64).eps)


def of(bands: Bands, deformations: Deformations | None) -> SpringBands | None:
    """The pass, if neither deformations nor factors vary over the batch; else None."""
    cells = None if deformations is None else _cells(bands, deformations.acting)
    return None if deformations is None or cells is None else SpringBands(bands, deformations, cells)


def _cells(bands: Bands, springs: Index) -> Cells | None:
    """Entries of the matrices as sums of springs; None where factors vary."""
    positions, numbers, factors = [], [], []
    for block, matrix in bands.sums.parts:
        if matrix is None:
            return None
        positions.append(np.repeat(bands.position, np.diff(matrix.indptr)))
        numbers.append(block.first + matrix.indices.astype(np.int64))
        factors.append(matrix.data)
    position, number = np.concatenate(positions), np.concatenate(numbers)
    spring = np.searchsorted(springs, number)
    if (springs[np.minimum(spring, len(springs) - 1)] != number).any():
        return None
    order = np.argsort(position, kind="stable")
    start = np.searchsorted(position[order], np.arange(bands.size * bands.width + 1)).astype(np.int64)
    return Cells(start, spring[order], np.concatenate(factors)[order])


class SpringBands:
    """The pass for banded matrices with constant deformations.

    Parameters
    ----------
    bands
        The pattern of the matrices.
    deformations
        Deformations of springs per unknown.
    cells
        Entries of the matrices as sums of springs.
    """

    def __init__(self, bands: Bands, deformations: Deformations, cells: Cells) -> None:
        self._bands, self._springs = bands, deformations.acting
        rough = _EPS * math.sqrt(bands.size)
        self._pass = BandPass(
            cells, deformations.split, bands.size, bands.width, Refinement(rough, SAFE, FINE, LOST, STEPS)
        )

    def slices(self, entries: int, wanted: int) -> Iterator[slice]:
        """Slices of so many entries, of at least a vector each, with so many unknowns that are asked for.

        The last one overlaps that before it where too few entries are left.
        """
        numbers = len(self._springs) + wanted
        step = max(WIDTH, _ROOM // (8 * numbers) // WIDTH * WIDTH)
        for start in range(0, entries, step):
            stop = min(start + step, entries)
            yield slice(min(start, stop - WIDTH), stop)

    def run(self, picked: Picked, forces: Array, wanted: Index, out: Array) -> NDArray[np.bool_]:
        """Solve at some entries.

        Parameters
        ----------
        picked
            The m entries of the batch.
        forces
            Forces on the unknowns, (size, m) or (size, 1).
        wanted
            Places of the unknowns that are asked for, (n,).
        out
            Their values (n, m), which are written.

        Returns
        -------
        ndarray
            Whether the solution is to be trusted, (m,): others are to be found otherwise.
        """
        stiffness = stiffness_of(self._bands.sums.coupling, self._springs, picked)
        least, error = self._pass.run(stiffness, forces, wanted, out)
        found: NDArray[np.bool_] = surely_positive(least**2, self._bands.size) & (error <= LOST)
        return found
