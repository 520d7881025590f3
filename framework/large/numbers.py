"""Numbers of a batch with the batch behind, from which those of some entries are taken."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array

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
        lead = self.array.ndim - self.ndim
        sizes = self.array.shape[lead:]
        if all(n == 1 for n in sizes):
            return self.array.reshape(*self.array.shape[:lead], 1)
        picked = tuple(k if n > 1 else np.zeros_like(k) for k, n in zip(where, sizes, strict=True))
        out: Array = self.array[(slice(None),) * lead + picked]
        return out


def batch_first(array: Array, shape: tuple[int, ...], leading: int) -> Array:
    """(components..., m) as (batch..., components...)."""
    moved = np.moveaxis(array.reshape(*array.shape[:leading], *shape), range(leading), range(-leading, 0))
    return np.ascontiguousarray(moved)
