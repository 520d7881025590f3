"""Evaluation of the equations of a batch, see `coupling`, for some of its entries at a time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, Shape, aligned
from ..entries import picked
from ..lazily import cached_property
from ..protocol import LineElement
from ..structure.group import Group
from ..structure.topology import Index
from .coupling import Coupling, EvaluatedBlock, Together
from .patterns import filled, times
from .terms import Ordered, SumPattern

# An empty array of indices.
_NONE: Index = np.zeros(0, dtype=np.int64)
# Index of the first entry, read-only as it is shared.
_FIRST: Index = np.zeros(1, dtype=np.int64)
_FIRST.flags.writeable = False


@dataclass(eq=False)
class Picked:
    """A selection of m entries of a batch, along one axis.

    Attributes
    ----------
    shape
        Shape of the batch.
    index
        For each batch axis the indices of the entries, (m,).
    """

    shape: Shape
    index: tuple[Index, ...]
    # Spring stiffnesses that were evaluated, by the index of the first number of their block.
    _springs: dict[int, Array] = field(default_factory=dict, init=False, repr=False, compare=False)

    def springs(self, block: EvaluatedBlock) -> Array:
        """Spring stiffnesses of a block of members whose deformations do not vary, (count, m or 1)."""
        if block.first not in self._springs:
            assert block.group is not None
            if block.group.spring_stiffness is None:
                group = self.of_group(block.group)
                stiffness = group.element.spring_stiffness(group.length)
            else:
                stiffness = self.of_array(block.group.spring_stiffness, 1, leading=1)
            found = stiffness.transpose(-1, *range(stiffness.ndim - 1))
            self._springs[block.first] = found.reshape(block.count, -1)
        return self._springs[block.first]

    def moved(self, zeros: Callable[[tuple[int, ...]], Array]) -> None:
        """Move evaluated stiffnesses into arrays that `zeros` allocates."""
        for first, numbers in self._springs.items():
            place = zeros(numbers.shape)
            place[...] = numbers
            self._springs[first] = place

    @classmethod
    def of(cls, shape: Shape, mask: int, numbers: Index) -> Picked:
        """Entries given by flat numbers over the axes of a mask, at the first index along the other axes."""
        if len(shape) == 1:  # as most often
            return cls(shape, (numbers if mask else np.zeros_like(numbers),))
        sizes = [n if mask >> axis & 1 else 1 for axis, n in enumerate(shape)]
        return cls(shape, tuple(np.array(k, dtype=np.int64) for k in np.unravel_index(numbers, sizes or (1,))))

    @classmethod
    def first(cls, shape: Shape) -> Picked:
        """The first entry of a batch."""
        return cls(shape, (_FIRST,) * max(1, len(shape)))

    def of_array(self, array: Array, trailing: int, leading: int = 0) -> Array:
        """An array (leading..., batch..., trailing...) at the entries, (leading..., m or 1, trailing...)."""
        return picked(array, self.index, trailing, leading)

    def of_values(self, values: Together) -> Array:
        """Numbers at the entries, (numbers, m)."""
        count = len(self.index[0]) if self.index else 1
        if values.plain is not None:
            return np.repeat(values.plain[:, None], count, axis=1)
        out = np.empty((values.count, count))
        for places, part in values.parts:
            out[places] = self.of_array(part, 0, leading=1)
        return out

    def of_element(self, group: Group) -> LineElement:
        """The element of a group at the entries."""
        if not group.stacked and set(group.shape) <= {1}:
            return group.element
        ndim = len(self.shape)

        def parameter(array: Array, trailing: int) -> Array:
            if array.ndim == trailing:
                return array
            if array.ndim - trailing > ndim:  # one for each piece
                return self.of_array(array, trailing, leading=1)
            return self.of_array(aligned(array, ndim, trailing), trailing)

        return group.element.cut(parameter)

    def of_group(self, group: Group) -> Group:
        """A group of members at the entries."""
        start, end, body = (None if axes is None else self.of_array(axes, 2) for axes in (*group.axes, group.body))
        chord, counts = self.of_array(group.chord, 1, leading=1), group.counts.reshape(-1, 1)
        return replace(group, element=self.of_element(group), chord=chord, counts=counts, axes=(start, end), body=body)


@dataclass(eq=False)
class _FilledRows:
    """A matrix (targets, terms) of which many rows may be empty: so each of many kinds of member costs its own alone.

    Attributes
    ----------
    targets
        Its rows that have entries; all of them, as a slice, where most have.
    matrix
        These rows.
    count
        Number of all rows.
    """

    targets: Index | slice
    matrix: scipy.sparse.csr_matrix
    count: int

    @classmethod
    def of(cls, matrix: scipy.sparse.csr_matrix) -> _FilledRows:
        """The rows of a matrix that have entries."""
        count, start = matrix.shape[0], matrix.indptr
        used = np.flatnonzero(start[1:] > start[:-1])
        if 2 * len(used) > count:
            return cls(slice(None), matrix, count)
        start = np.append(start[used], start[-1:])
        shape = len(used), matrix.shape[1]
        return cls(used, scipy.sparse.csr_matrix((matrix.data, matrix.indices, start), shape=shape), count)

    @property
    def all_rows(self) -> scipy.sparse.csr_matrix:
        """The matrix with its empty rows."""
        if isinstance(self.targets, slice):
            return self.matrix
        start = np.zeros(self.count + 1, dtype=self.matrix.indptr.dtype)
        start[self.targets + 1] = np.diff(self.matrix.indptr)
        shape = self.count, self.matrix.shape[1]
        return scipy.sparse.csr_matrix((self.matrix.data, self.matrix.indices, np.cumsum(start)), shape=shape)

    def add_to(self, sums: Array | None, values: Array) -> Array:
        """Sums (targets, ...) to which the products with values (terms, ...) are added in place; None for no sums."""
        found = times(self.matrix, values)
        if sums is None:
            if isinstance(self.targets, slice):
                return found
            sums = np.zeros((self.count, *found.shape[1:]))
        sums[self.targets] += found
        return sums


@dataclass(eq=False)
class _Sum:
    """The contribution of one block to the sums: as a matrix where no factor varies, or term by term.

    Attributes
    ----------
    whole
        Terms without varying factors, of the numbers of the block.
    each
        Terms with varying factors.
    source, factors
        For each term with varying factors, the index of its number in the block and of its two factors; -1 for none.
    """

    block: EvaluatedBlock
    whole: _FilledRows | None
    each: _FilledRows | None
    source: Index
    factors: tuple[Index, Index]

    @classmethod
    def of(cls, coupling: Coupling, number: int, whole: Ordered | None, each: Ordered | None) -> _Sum:
        """The contribution of block `number`, by the patterns of `SumPattern`."""
        block, terms = coupling.blocks[number], coupling.pattern
        one, other = (
            None if p is None else _FilledRows.of(filled(p.matrix, coupling.factor[p.order])) for p in (whole, each)
        )
        if each is None:
            return cls(block, one, other, _NONE, (_NONE, _NONE))
        places = each.places
        return cls(block, one, other, terms.source[places] - block.first, (terms.first[places], terms.second[places]))


class Sums:
    """Entries of the matrix or of the loads, each a sum of terms.

    Parameters
    ----------
    coupling
        The terms of the equations.
    pattern
        Which terms add up to which target.
    """

    def __init__(self, coupling: Coupling, pattern: SumPattern) -> None:
        self.coupling, self.count = coupling, pattern.count
        parts = [_Sum.of(coupling, *part) for part in pattern.parts]
        self._fixed = [part for part in parts if part.whole is not None and not part.block.mask]
        self._varying = [part for part in parts if part.each is not None or part.block.mask]

    @property
    def parts(self) -> list[tuple[EvaluatedBlock, scipy.sparse.csr_matrix | None]]:
        """Blocks, each with the matrix of its terms (targets, numbers of the block); None where factors vary."""
        return [
            (part.block, None if part.each is not None or part.whole is None else part.whole.all_rows)
            for part in self._fixed + self._varying
        ]

    @property
    def varies(self) -> bool:
        """Whether any of the sums varies over the batch."""
        return bool(self._varying)

    @cached_property
    def constant(self) -> Array:
        """The sums of the terms that do not vary over the batch, (targets,)."""
        out, picked = None, Picked.first(self.coupling.grid.shape)
        for part in self._fixed if self.coupling.grid.sizes[-1] else ():  # of a batch without entries none is the first
            assert part.whole is not None
            out = part.whole.add_to(out, np.ascontiguousarray(numbers_of(part.block, picked)[:, 0]))
        return np.zeros(self.count) if out is None else out

    @cached_property
    def _factors(self) -> Together | None:
        """The varying factors of terms; None where there are none."""
        return Together(self.coupling.factors) if any(part.each is not None for part in self._varying) else None

    def at(self, picked: Picked) -> Array:
        """The sums at some entries, (targets, m)."""
        count = len(picked.index[0]) if picked.index else 1
        out = np.repeat(self.constant[:, None], count, axis=1) if self._fixed else None
        factors = None if self._factors is None else picked.of_values(self._factors)
        for part in self._varying:
            numbers = numbers_of(part.block, picked)
            if part.whole is not None and part.block.mask:
                every = numbers if numbers.shape[1] == count else np.broadcast_to(numbers, (len(numbers), count))
                out = part.whole.add_to(out, every)
            if part.each is not None:
                assert factors is not None
                out = part.each.add_to(out, _weighted(part, numbers, factors))
        return np.zeros((self.count, count)) if out is None else out


def _weighted(part: _Sum, numbers: Array, factors: Array) -> NDArray[np.float64]:
    """Terms times their varying factors, (terms, m)."""
    taken: Array = numbers[part.source]
    for each in part.factors:
        taken = taken * np.where((each >= 0)[:, None], factors[each], 1.0)
    return np.broadcast_to(taken, (len(taken), factors.shape[1]))


def numbers_of(block: EvaluatedBlock, picked: Picked) -> Array:
    """Numbers of a block at some entries, (count, m or 1)."""
    if block.group is None:
        return picked.of_values(block.together)
    if block.rows is not None:
        return picked.springs(block)
    stiffness = np.moveaxis(picked.of_group(block.group).stiffness(), (-2, -1), (0, 1))
    return stiffness.reshape(block.count, -1)
