"""The pattern of the terms in the equations of a batch, see `coupling`, shared by frames of one topology."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from ..cache import TERMS
from ..lazily import cached_property
from ..structure.topology import Index
from .patterns import connected, labelled, pattern_by_rows

Mask = NDArray[np.bool_]
Found = TypeVar("Found")
# Weight in the cache of a term of a member, with the results derived from it; and the largest weight that is cached.
_EACH, MOST = 16, 2**21
# Number of results that are kept with the terms.
_KINDS = 12
_TWELVE = np.triu_indices(12)


@dataclass(frozen=True)
class Tables:
    """The pattern of a `Transformation`, without its factors.

    Attributes
    ----------
    start, column, varying
        As of the transformation.
    size
        Number of unknowns.
    """

    start: Index
    column: Index
    varying: Index
    size: int


@dataclass(frozen=True, eq=False)
class TermPattern:
    """All terms of the equations, without their values; shared between frames, so it must not be changed.

    A term is the product of a number of an `EvaluatedBlock`, two deformations, two factors of T (or G) and a constant.

    Attributes
    ----------
    source
        Index of the number among those of all blocks, (terms,).
    first, second
        Indices of the varying factors in `Coupling.factors`, (terms,); -1 for none.
    low, high
        Places of the two unknowns that the term couples, (terms,). For a load, `high` is the number of unknowns plus
        that of the right-hand-side parameter.
    own
        Indices of the two deformations, (2, terms), those of all groups being numbered from 1; 0 for the factor one.
    shares
        Indices of the two factors in `Transformation.share`, (2, terms).
    times
        Constant factors, (terms,).
    blocks
        Index at which the numbers of each block begin, and at last where they end.
    size
        Number of unknowns.
    """

    source: Index
    first: Index
    second: Index
    low: Index
    high: Index
    own: Index
    shares: Index
    times: NDArray[np.float64]
    blocks: tuple[int, ...]
    size: int
    _known: dict[tuple[object, ...], Any] = field(default_factory=dict, init=False, repr=False)

    def factors(self, deformations: Sequence[NDArray[np.float64]], share: NDArray[np.float64]) -> NDArray[np.float64]:
        """Constant factor of each term, (terms,), from constant deformations of members and the factors of T."""
        numbers = np.concatenate([np.ones(1), *(each.reshape(-1) for each in deformations)])
        found: NDArray[np.float64] = numbers[self.own[0]] * numbers[self.own[1]]
        found *= share[self.shares[0]]
        found *= share[self.shares[1]]
        found *= self.times
        return found

    def at(self, chosen: Mask) -> TermPattern:
        """The terms in a mask."""
        names = ("source", "first", "second", "low", "high", "own", "shares", "times")
        return replace(self, **{name: getattr(self, name)[..., chosen] for name in names})

    def known(self, key: tuple[object, ...], make: Callable[[], Found]) -> Found:
        """A result that depends on the terms and a key alone, kept here or computed by `make`."""
        found: Found | None = self._known.get(key)
        if found is None:  # two threads may both compute it, which does no harm
            found = make()
            if len(self._known) >= _KINDS:  # as with many sets of loaded unknowns
                self._known.clear()
            self._known[key] = found
        return found

    @cached_property
    def stiff(self) -> Mask:
        """Mask of the terms of the stiffness, (terms,); the others are loads."""
        return self.high < self.size

    @cached_property
    def label(self) -> Index:
        """Connected component of each unknown, (n,)."""
        return connected(self.low[self.stiff], self.high[self.stiff], self.size)

    @cached_property
    def loaded(self) -> Mask:
        """Whether a load, an offset or a prescribed displacement acts on the component of each unknown, (n,)."""
        return labelled(self.label, self.label[self.low[~self.stiff]])

    @cached_property
    def loaded_sizes(self) -> Index:
        """Number of unknowns of each loaded component, by its label; 0 for the others."""
        return np.bincount(self.label[self.loaded])

    def sources(self, loaded: Mask) -> Index:
        """Numbers of the right-hand-side parameters that act on the unknowns in the mask `loaded` (n,)."""

        def found() -> Index:
            acting = ~self.stiff & loaded[self.low]
            return np.unique(self.high[acting]) - self.size

        return self.known(("sources", loaded.tobytes()), found)


class Ordered(NamedTuple):
    """Indices of some terms, the same in the order of a matrix's entries, and a matrix of that pattern."""

    places: Index
    order: Index
    matrix: scipy.sparse.csr_matrix


class SumPattern:
    """Which terms add up to which targets, such as the entries of a band.

    Parameters
    ----------
    pattern
        All terms.
    chosen
        Indices of the terms to sum.
    target
        Number of the target of each of these terms.
    count
        Number of targets.

    Attributes
    ----------
    parts
        For each block with terms: its number; the terms without varying factors, with a matrix (targets, numbers of the
        block) of their pattern; and the others, with a matrix (targets, terms).
    """

    def __init__(self, pattern: TermPattern, chosen: Index, target: Index, count: int) -> None:
        self.count = count
        source, plain = pattern.source[chosen], (pattern.first[chosen] < 0) & (pattern.second[chosen] < 0)
        self.parts: list[tuple[int, Ordered | None, Ordered | None]] = []
        for number, (begin, end) in enumerate(zip(pattern.blocks[:-1], pattern.blocks[1:], strict=True)):
            mine = (source >= begin) & (source < end)
            whole, each = np.flatnonzero(mine & plain), np.flatnonzero(mine & ~plain)
            parts = (
                _ordered(chosen, whole, target, source[whole] - begin, (count, end - begin)),
                _ordered(chosen, each, target, np.arange(len(each)), (count, len(each))),
            )
            if any(part is not None for part in parts):
                self.parts.append((number, *parts))


def _ordered(chosen: Index, some: Index, target: Index, column: Index, shape: tuple[int, int]) -> Ordered | None:
    if not len(some):
        return None
    order, matrix = pattern_by_rows(target[some], column, shape)
    return Ordered(chosen[some], chosen[some][order], matrix)


# -- finding the terms ------------------------------------------------------------------------------------------------


def term_pattern(
    tables: Tables, acting: Sequence[Mask], dofs: Sequence[Index], edges: tuple[int, int], loads: Index
) -> TermPattern:
    """The terms of a frame, from the cache or computed.

    Parameters
    ----------
    tables
        Pattern of the displacements over the unknowns.
    acting
        For each group of n members a mask of the displacements that deform each spring, (n, s, 12); or, where
        deformations vary over the batch, of the entries of the stiffness that are not zero, (n, 12, 12, 1).
    dofs
        DOF numbers of the members of each group, (n, 12).
    edges
        Number of the first row of a joint spring, and how many joint springs there are.
    loads
        Displacement on which each load acts, and its right-hand-side parameter, (loads, 2).
    """

    def make() -> TermPattern:
        return _found(tables, acting, dofs, edges, loads)

    weight = sum(map(term_weight, acting))
    if weight > MOST:
        return make()
    shapes = tuple(each.shape for each in (*acting, tables.start, loads))
    numbers: list[NDArray[Any]] = [*map(np.packbits, acting), *dofs]
    numbers += [tables.start, tables.column, tables.varying, loads]
    key = (tables.size, edges, shapes, *(each.tobytes() for each in numbers))
    found: TermPattern = TERMS.found(key, make, weight)
    return found


def term_weight(acting: Mask) -> int:
    """Weight in the cache of the terms of a group of members."""
    return _EACH * _pairs_of(acting)


def _pairs_of(acting: Mask) -> int:
    """Approximate number of terms of a group: as if all springs were deformed by equally many displacements."""
    count = int(np.count_nonzero(acting))
    if acting.ndim == 4:
        return count
    springs = max(1, acting.size // 12)
    return count * (count + springs) // (2 * springs)


def _found(
    tables: Tables, acting: Sequence[Mask], dofs: Sequence[Index], edges: tuple[int, int], loads: Index
) -> TermPattern:
    blocks, parts, numbers = [0], [], 1
    for mine, at in zip(acting, dofs, strict=True):
        count = len(mine)
        if mine.ndim == 4:
            a, b = _TWELVE
            piece, pair = np.nonzero(mine[:, a, b, 0])
            a, b = a[pair], b[pair]
            source, number = (12 * a + b) * count + piece, 144 * count
            own = np.zeros((2, len(source)), dtype=np.int64)
        else:
            piece, spring, a, b = _pairs(mine)
            source, number = spring * count + piece, mine.shape[1] * count
            own = numbers + (piece * mine.shape[1] + spring) * 12 + np.stack([a, b])
            numbers += mine.size
        parts.append(_expanded(tables, blocks[-1] + source, at[piece, a], at[piece, b], own, -1.0))
        blocks.append(blocks[-1] + number)
    first, springs = edges
    rows = first + np.arange(springs)
    none = np.zeros((2, springs), dtype=np.int64)
    parts.append(_expanded(tables, blocks[-1] + np.arange(springs), rows, rows, none, -1.0))
    blocks.append(blocks[-1] + springs)
    none = np.zeros((2, len(loads)), dtype=np.int64)
    known = first + springs + loads[:, 1]
    parts.append(_expanded(tables, blocks[-1] + np.arange(len(loads)), loads[:, 0], known, none, 1.0))
    blocks.append(blocks[-1] + len(loads))
    source, one, two, low, high, own, shares, times = (
        np.concatenate(each, axis=-1) for each in zip(*parts, strict=True)
    )
    return TermPattern(source, one, two, low, high, own, shares, times, tuple(blocks), tables.size)


def _expanded(
    tables: Tables, source: Index, one: Index, other: Index, own: Index, sign: float
) -> tuple[NDArray[Any], ...]:
    """Fields of a `TermPattern` for n numbers that couple two rows of T, (i, j) representing (j, i) as well.

    `own` are the indices (2, n) of the deformations that multiply each number.
    """
    start, column = tables.start, tables.column
    each = start[other + 1] - start[other]
    times = (start[one + 1] - start[one]) * each
    item = np.repeat(np.arange(len(one)), times)
    place = np.arange(len(item)) - np.repeat(np.cumsum(times) - times, times)
    first = start[one[item]] + place // each[item]
    second = start[other[item]] + place % each[item]
    i, j, same = column[first], column[second], one[item] == other[item]
    low, high = np.minimum(i, j), np.maximum(i, j)
    kept = (low < tables.size) & (~same | (i >= j))
    factor = np.where(same | (i != j), 1.0, 2.0)
    factor = np.where(high >= tables.size, sign * factor, factor)[kept]
    item, first, second = item[kept], first[kept], second[kept]
    varying = tables.varying[first], tables.varying[second]
    return source[item], *varying, low[kept], high[kept], own[:, item], np.stack([first, second]), factor


def _pairs(acting: Mask) -> tuple[Index, Index, Index, Index]:
    """For each spring, all pairs of displacements that deform it: piece, spring, and the two, the lower first."""
    piece, spring, one = np.nonzero(acting)
    place = np.arange(len(one))
    starts = np.diff(acting.shape[1] * piece + spring, prepend=-1) > 0
    ends = np.append(np.flatnonzero(starts)[1:], len(one))[np.cumsum(starts) - 1]
    times = ends - place
    item = np.repeat(place, times)
    other = item + np.arange(len(item)) - np.repeat(np.cumsum(times) - times, times)
    return piece[item], spring[item], one[item], one[other]
