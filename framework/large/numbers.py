"""Numbers of a batch with the batch behind, from which those of some entries are taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..elementwise import is_recorded, zeros
from ..entries import picked

Where = tuple[NDArray[np.int64], ...]


@dataclass(frozen=True)
class Numbers:
    """An array (components..., batch...), the batch axes as they were given: of size one where nothing varies."""

    array: Array
    ndim: int

    @classmethod
    def of(cls, given: Array, ndim: int, trailing: int, leading: int = 0) -> Numbers:
        """From an array (leading..., batch..., trailing...), its batch axes perhaps not all there.

        The components of the result are the trailing axes, then the leading ones.
        """
        missing = ndim + trailing + leading - given.ndim
        shape = given.shape[:leading] + (1,) * missing + given.shape[leading:]
        whole = given.reshape(shape)
        order = (*range(leading + ndim, whole.ndim), *range(leading + ndim))
        return cls(whole.transpose(order).copy(order="C"), ndim)

    def at(self, where: Where) -> Array:
        """Numbers of some entries, (components..., m), or (components..., 1) where they are all alike."""
        return np.ascontiguousarray(picked(self.array, where, leading=self.array.ndim - self.ndim))


def batch_first(array: Array, shape: tuple[int, ...], leading: int) -> Array:
    """(components..., m) as (batch..., components...)."""
    moved = np.moveaxis(array.reshape(*array.shape[:leading], *shape), range(leading), range(-leading, 0))
    return np.ascontiguousarray(moved)


def summed(matrix: scipy.sparse.csr_matrix, terms: Array) -> Array:
    """Sums of rows (n, m), numbers or terms of a recording, with the factors of a sparse matrix."""
    if not is_recorded(terms):
        out: Array = matrix @ terms
        return out
    out = zeros((matrix.shape[0], terms.shape[1]), terms)
    for row, (a, b) in enumerate(zip(matrix.indptr[:-1].tolist(), matrix.indptr[1:].tolist(), strict=True)):
        for column, factor in zip(matrix.indices[a:b].tolist(), matrix.data[a:b].tolist(), strict=True):
            out[row] = out[row] + factor * terms[column]
    return out
