"""Numbers of a batch with the batch behind, from which those of some entries are taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
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
        return picked(self.array, where, leading=self.array.ndim - self.ndim)


def batch_first(array: Array, shape: tuple[int, ...], leading: int) -> Array:
    """(components..., m) as (batch..., components...)."""
    moved = np.moveaxis(array.reshape(*array.shape[:leading], *shape), range(leading), range(-leading, 0))
    return np.ascontiguousarray(moved)
