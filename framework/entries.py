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
    if set(sizes) <= {1}:
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
        Number of batch axes, and the one along which entries are taken.
    indices
        Their indices along it.
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
        """Slice of each batch axis."""
        return tuple(self.indices if axis == self.axis else slice(None) for axis in range(self.ndim))


@dataclass(frozen=True, kw_only=True)
class Selected(Entries):
    """Batch entries at some indices of each axis, which keep the axes of the batch.

    Attributes
    ----------
    indices
        By batch axis: indices of the entries, in order.
    """

    indices: tuple[Index, ...]

    @classmethod
    def around(cls, mask: NDArray[np.bool_]) -> Selected:
        """The smallest selection that contains all entries of a mask (...)."""
        axes = range(mask.ndim)
        along = (mask.any(axis=tuple(other for other in axes if other != axis)) for axis in axes)
        return cls(indices=tuple(np.flatnonzero(each) for each in along))

    @property
    def shape(self) -> Shape:
        """Batch shape of these entries."""
        return tuple(len(each) for each in self.indices)

    def __call__(self, array: Numbers, trailing: int, leading: int = 0) -> Numbers:
        """An array at the entries, its axes as they are."""
        first = array.ndim - trailing - len(self.indices)
        for axis, indices in enumerate(self.indices, first):
            if axis >= 0 and len(indices) != array.shape[axis] != 1:
                array = array[(slice(None),) * axis + (indices,)]
        return array

    @property
    def where(self) -> tuple[Index, ...]:
        """Index of the entries in an array of the batch."""
        return np.ix_(*self.indices)

    def of_all(self, mask: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """A mask (...) of the whole batch at these entries."""
        return mask[self.where] if self.indices else mask

    def among_all(self, index: tuple[Index, ...]) -> tuple[Index, ...]:
        """Indices (m,) by axis in the whole batch, from those among these entries."""
        return tuple(own[k] for own, k in zip(self.indices, index, strict=True))


WHOLE = Entries()
