"""Some entries of a batch, taken out of its arrays.

Arrays are (leading..., batch..., trailing...). Their batch axes broadcast with those of the batch: of size one, or left
out in front, where nothing varies.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .batch import Shape

Numbers = NDArray[Any]
Index = NDArray[np.int64]
# Takes entries out of an array, given the number of its trailing axes.
Change = Callable[[Numbers, int], Numbers]


def picked(array: Numbers, index: tuple[Index, ...], trailing: int = 0, leading: int = 0) -> Numbers:
    """An array at entries of a batch, (leading..., m, trailing...), with 1 in place of m where all are alike.

    Parameters
    ----------
    array
        The array.
    index
        By batch axis the indices (m,) of the entries.
    trailing, leading
        Number of its axes that are no batch axes.
    """
    missing = len(index) + leading + trailing - array.ndim
    if missing:
        array = array.reshape(*array.shape[:leading], *(1,) * missing, *array.shape[leading:])
    behind = leading + len(index)
    sizes = array.shape[leading:behind]
    if max(sizes, default=1) == 1:
        return array.reshape(*array.shape[:leading], 1, *array.shape[behind:])
    where = tuple(k if n != 1 else 0 for k, n in zip(index, sizes, strict=True))
    return array[(slice(None),) * leading + where]


def flattened(array: Numbers, shape: Shape, trailing: int) -> Numbers:
    """An array (batch..., trailing...) at all entries of a batch of that shape, (entries, trailing...)."""
    tail = array.shape[array.ndim - trailing :]
    return np.broadcast_to(array, (*shape, *tail)).reshape(-1, *tail)


@dataclass(frozen=True)
class Entries:
    """Some batch entries as one axis, or (None) the whole batch as it is.

    Attributes
    ----------
    index
        By batch axis the indices (m,) of the entries.
    """

    index: tuple[Index, ...] | None = None

    def __call__(self, array: Numbers, trailing: int, leading: int = 0) -> Numbers:
        """An array at the entries, (leading..., m or 1, trailing...)."""
        return array if self.index is None else picked(array, self.index, trailing, leading)


@dataclass(frozen=True, kw_only=True)
class Stretch(Entries):
    """Batch entries in a row along one of `ndim` axes, which keep the shape of the batch.

    Attributes
    ----------
    ndim, axis
        Number of batch axes, and along which of them.
    indices
        Which.
    """

    ndim: int
    axis: int
    indices: slice

    def __call__(self, array: Numbers, trailing: int, leading: int = 0) -> Numbers:
        """An array at the entries, its axes as they are."""
        behind = array.ndim - trailing
        place = behind - self.ndim + self.axis
        alike = not 0 <= place < behind or array.shape[place] == 1
        return array if alike else array[(slice(None),) * place + (self.indices,)]

    @property
    def where(self) -> tuple[slice, ...]:
        """What is taken of each axis of the batch."""
        return tuple(self.indices if axis == self.axis else slice(None) for axis in range(self.ndim))


WHOLE = Entries()
