"""Numbers of a batch, each kept at the smallest batch shape over which it varies, and sums and products of them.

An entry of a matrix is a sum of parts, keyed by the batch axes over which each part varies (a bit mask). A constant
part is a float, one that varies with the pose an array ``(36, 1)``, one that varies with the sample ``(1, 100)``.
Parts are added only when the sum is needed, so that most arithmetic is done on the small ones.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, aligned
from ..lazily import cached_property

# A constant number is a scalar. What is computed once for the whole batch is computed in extended precision where the
# machine has it (80 bits on x86), which costs next to nothing and adds no error to what depends on it.
Extended = np.longdouble
Value = float | np.floating[Any] | NDArray[np.floating[Any]]
Parts = dict[int, Value]
# Parts of the entries of a symmetric matrix: (i, j) and (j, i) are one object.
Matrix = dict[int, dict[int, Parts]]
# A linear combination: factors by number of the unknown (0, 1, ...) and of the right-hand-side parameter (-1, -2, ...).
Row = dict[int, Value]
# A linear combination as a list of number, factor and mask of the factor.
Factors = list[tuple[int, Value, int]]
# Parts of the loads by unknown and right-hand-side parameter.
Loads = dict[int, dict[int, Parts]]
# The right-hand-side parameter one.
ONE = -1


@dataclass(frozen=True)
class Grid:
    """The batch: its shape, and the number of entries over which a number with a given mask varies."""

    shape: Shape

    @cached_property
    def sizes(self) -> tuple[int, ...]:
        """Number of batch entries by mask."""
        if len(self.shape) < 2:  # as most often
            return 1, *self.shape
        return tuple(
            math.prod(n for axis, n in enumerate(self.shape) if mask >> axis & 1)
            for mask in range(1 << len(self.shape))
        )

    def slices(self, entries: int) -> tuple[int, list[slice]]:
        """The longest axis, and slices of it with about this many batch entries each, none of a single index."""
        axis = int(np.argmax(self.shape))
        length = self.shape[axis]
        count = max(1, min(self.sizes[-1] // entries, length // 2))
        bounds = [k * length // count for k in range(count + 1)]
        return axis, [slice(a, b) for a, b in pairwise(bounds)]

    def value(self, array: NDArray[Any]) -> Value:
        """`array` (...) as a scalar if it holds a single number, else as a contiguous array with all batch axes."""
        if array.size == 1:
            number: Value = array.reshape(-1)[0]
            return float(number) if array.dtype == np.float64 else number
        return np.ascontiguousarray(aligned(array, len(self.shape)))

    def components(self, array: Array, trailing: int = 1) -> list[Value]:
        """The components of `array` (..., n) or (..., n, m), each as by `value`; 0.0 if zero everywhere."""
        batch = array.ndim - trailing
        flat = array.reshape(*array.shape[:batch], math.prod(array.shape[batch:]))
        if flat.size > flat.shape[-1]:
            flat = aligned(flat, len(self.shape), 1)
            columns = [flat[..., k] for k in range(flat.shape[-1])]
            # most are not zero at the first entry, and need no second look
            used = [bool(each[(0,) * each.ndim] != 0.0 or np.count_nonzero(each)) for each in columns]
            return [np.ascontiguousarray(each) if some else 0.0 for each, some in zip(columns, used, strict=True)]
        return [self.value(flat[..., k]) if (flat[..., k] != 0.0).any() else 0.0 for k in range(flat.shape[-1])]


def mask_of(value: object) -> int:
    """Mask of the batch axes over which a number varies; an array must have all batch axes."""
    if isinstance(value, np.ndarray):
        return mask_of_shape(value.shape)
    # a term of a recording may tell
    return 0 if type(value) is float else getattr(value, "batch_mask", 0)


def mask_of_shape(shape: Shape) -> int:
    """Mask of the axes of a shape that are longer than one."""
    mask, bit = 0, 1
    for n in shape:
        if n > 1:
            mask |= bit
        bit <<= 1
    return mask


def masks_of(rows: Iterable[Row]) -> list[dict[int, int]]:
    """The mask of each factor in sparse rows."""
    return [{key: mask_of(value) for key, value in row.items()} for row in rows]


def is_zero(value: Value) -> bool:
    """Whether `value` is the exact constant zero."""
    return not isinstance(value, np.ndarray) and value == 0.0


def add(parts: Parts, mask: int, value: Value) -> None:
    """Add `value`, which varies over `mask`, to a sum of parts."""
    parts[mask] = parts[mask] + value if mask in parts else value


def entry(matrix: Matrix, i: int, j: int) -> Parts:
    """Parts of the entries (i, j) and (j, i), created if missing."""
    row = matrix.get(i)
    if row is None:
        row = matrix[i] = {}
    found = row.get(j)
    if found is None:
        found = row[j] = matrix.setdefault(j, {})[i] = {}
    return found


def enter(matrix: Matrix, i: int, j: int, mask: int, value: Value) -> None:
    """Add a term, which varies over `mask`, to the entries (i, j) and (j, i)."""
    add(entry(matrix, i, j), mask, value)


def enter_all(matrix: Matrix, rows: Iterable[int], columns: Iterable[int], values: Iterable[Value]) -> None:
    """Add terms, each to the entries (i, j) and (j, i) of its row and column."""
    for i, j, value in zip(rows, columns, values, strict=True):
        parts, mask = entry(matrix, i, j), mask_of(value)
        parts[mask] = parts[mask] + value if mask in parts else value


def total(parts: Parts) -> tuple[int, Value]:
    """Mask and value of a sum of parts, smallest parts first."""
    if len(parts) == 1:
        return next(iter(parts.items()))
    varying, result = 0, 0.0  # type: int, Value
    for mask in sorted(parts):
        varying |= mask
        result = parts[mask] if is_zero(result) else result + parts[mask]
    return varying, result


def totals(row: dict[int, Parts], keys: Iterable[int]) -> list[tuple[int, int, Value]]:
    """Key, mask and value of the sums of a row that have any part."""
    return [(key, *total(row[key])) for key in keys if row.get(key)]


def pivot_column(
    row: dict[int, Parts], k: int, keys: Iterable[int], scale: Parts
) -> tuple[tuple[int, Value], tuple[int, Value], list[tuple[int, int, Value]]]:
    """Mask and value of the entry `k` of a row, those of its `scale`, and the `totals` of the entries `keys`."""
    return total(row.get(k, {})), total(scale), totals(row, keys)


def product(a: Value, b: Value) -> Value:
    """a times b; 0.0 if one of them is the constant zero, and b itself if a is the constant one."""
    plain = not isinstance(a, np.ndarray)
    if (plain and a == 0.0) or (not isinstance(b, np.ndarray) and b == 0.0):
        return 0.0
    return b if plain and a == 1.0 else a * b


def combine(terms: Iterable[tuple[Value, Value]]) -> Value:
    """Sum of products of pairs, without the terms that are exactly zero."""
    result: Value = 0.0
    owned = False
    for a, b in terms:
        plain = not isinstance(a, np.ndarray)
        if (plain and a == 0.0) or is_zero(b):
            continue
        unit = plain and a == 1.0
        product = b if unit else a * b
        if is_zero(result):
            result, owned = product, not unit
        elif owned and isinstance(result, np.ndarray) and isinstance(product, np.ndarray) and _alike(result, product):
            np.add(result, product, out=result)
        else:
            result, owned = result + product, True
    return result


def _alike(one: NDArray[Any], other: NDArray[Any]) -> bool:
    """Whether two arrays have the same shape and precision."""
    return one.shape == other.shape and one.dtype == other.dtype


def collapsed(by_source: dict[int, Parts], sources: Sequence[Value]) -> Value:
    """A load: the loads per unit of each source (right-hand-side parameter), times the values of the sources."""
    if not by_source:
        return 0.0
    return combine([(sources[source], value) for source, _, value in totals(by_source, by_source)])


def collapsed_each(each: Iterable[dict[int, Parts]], sources: Sequence[Value]) -> list[Value]:
    """Several loads, each as by `collapsed`."""
    return [collapsed(by_source, sources) for by_source in each]


def sums(each: Iterable[Iterable[tuple[Value, Value]]]) -> list[Value]:
    """Several sums of products, each as by `combine`."""
    return [combine(terms) for terms in each]


def combine_each(rows: Iterable[Row], known: Mapping[int, Value]) -> list[Value]:
    """Values of sparse rows over known numbers."""
    return [combine([(factor, known[k]) for k, factor in row.items()]) for row in rows]


def scaled(row: Row, factor: Value) -> Row:
    """`factor` times a sparse row, without factors that are exactly zero."""
    return nonzero({key: product(value, factor) for key, value in row.items()})


def scaled_each(rows: Iterable[Row], factor: float) -> list[Row]:
    """`factor` times several sparse rows, without factors that are exactly zero."""
    return [nonzero(row) if factor == 1.0 else scaled(row, factor) for row in rows]


def nonzero(row: Row) -> Row:
    """A sparse row without factors that are exactly zero."""
    return {key: value for key, value in row.items() if not is_zero(value)}


def combined(terms: Iterable[tuple[Value, Row]]) -> Row:
    """Sum of products of numbers with sparse rows."""
    out: Row = {}
    for factor, row in terms:
        if not is_zero(factor):
            add_row(out, row, factor)
    return out


def combined_each(each: Iterable[Iterable[tuple[Value, Row]]]) -> list[Row]:
    """Several sums of products of numbers with sparse rows."""
    return [combined(terms) for terms in each]


def add_row(row: Row, other: Row, factor: Value = 1.0) -> None:
    """Add `factor` times the sparse row `other` to `row`."""
    if not isinstance(factor, np.ndarray) and factor == 1.0:
        terms = other.items()
    else:
        terms = {key: product(factor, value) for key, value in other.items()}.items()
    for key, term in terms:
        if not is_zero(term):
            row[key] = row[key] + term if key in row else term


def unknowns(row: Row) -> list[int]:
    """The numbers of the unknowns in a row."""
    return [key for key in row if key >= 0]


def add_congruence(
    into: Matrix, known: Loads, matrix: Matrix, rows: dict[int, Factors], wanted: Sequence[bool]
) -> bool:
    """Add ``T^T A T`` of a symmetric matrix A, given the rows of T, as far as the masks of its terms are `wanted`.

    Parameters
    ----------
    into
        Matrix over the unknowns, to which the terms between unknowns are added.
    known
        Loads, from which the terms between an unknown and a right-hand-side parameter are subtracted.
    matrix, rows
        The matrix A, and by number of its rows the rows of T.
    wanted
        For each mask, whether terms that vary over it are wanted.

    Returns
    -------
    bool
        Whether all terms were wanted.
    """
    complete, rows = True, _as_precise(rows, (part for row in matrix.values() for part in row.values()), wanted)
    for a, left in rows.items():
        for b, parts in matrix.get(a, {}).items():
            if b >= a and b in rows:
                for part in parts.items():
                    complete &= add_dyad(into, known, part, left, rows[b], wanted, twice=a != b)
    return complete


def add_dyad(
    into: Matrix,
    known: Loads,
    part: tuple[int, Value],
    left: Factors,
    right: Factors,
    wanted: Sequence[bool],
    *,
    twice: bool = False,
    given: bool | None = None,
    scale: dict[int, Parts] | None = None,
) -> bool:
    """Add ``a k b^T`` to a symmetric matrix, as `add_congruence` does; with `twice` ``b k a^T`` as well.

    `given`, unless None, decides in place of `wanted` about terms whose only varying factor is k. Terms on the diagonal
    are added to `scale` as well, if there is one.
    """
    (mask, value), complete = part, True
    for i, factor, over in left:
        half: Value | None = None
        row = into.get(i, {})
        for j, other, along in right:
            if not twice and (i < 0 or 0 <= j < i):
                continue
            axes = mask | over | along
            if not (wanted[axes] if given is None or over | along else given):
                complete = False
                continue
            if half is None:
                half = product(factor, value)
            term = product(other, half)
            if i >= 0 and j >= 0:
                parts = row.get(j)
                if parts is None:
                    parts = entry(into, i, j)
                    row = into[i]
                whole = 2.0 * term if twice and i == j else term
                parts[axes] = parts[axes] + whole if axes in parts else whole
                if scale is not None and i == j:
                    add(scale.setdefault(i, {}), axes, term)
            elif i >= 0 or j >= 0:
                parts = known.setdefault(max(i, j), {}).setdefault(-1 - min(i, j), {})
                parts[axes] = parts[axes] - term if axes in parts else -term
    return complete


def add_squares(
    into: dict[int, Parts], scale: dict[int, Parts], rows: dict[int, Factors], wanted: Sequence[bool]
) -> bool:
    """Add the squares of factors times the `scale` of their rows, as far as `wanted`; whether all terms were."""
    complete, rows = True, _as_precise(rows, scale.values(), wanted)
    for a, row in rows.items():
        for mask, value in scale.get(a, {}).items():
            for i, factor, over in row:
                if i >= 0 and wanted[mask | over]:
                    add(into.setdefault(i, {}), mask | over, product(product(value, factor), factor))
                elif i >= 0:
                    complete = False
    return complete


def add_loads(into: Loads, loads: Loads, rows: dict[int, Factors], wanted: Sequence[bool]) -> bool:
    """Add ``T^T f``, given the rows of T, as far as the masks of terms are `wanted`; whether all terms were."""
    complete = True
    for a, row in rows.items():
        for i, factor, over in row:
            if i < 0:
                continue
            for source, parts in loads.get(a, {}).items():
                for mask, value in parts.items():
                    if wanted[mask | over]:
                        sums = into.setdefault(i, {}).setdefault(source, {})
                        add(sums, mask | over, product(factor, value))
                    else:
                        complete = False
    return complete


def _as_precise(rows: dict[int, Factors], numbers: Iterable[Parts], wanted: Sequence[bool]) -> dict[int, Factors]:
    """Rows with their arrays in extended precision if the numbers are, as the first of them tells.

    A product of arrays of two precisions takes twice as long; so each array is converted once, not in every product.
    Factors that vary more than is wanted are in no product.
    """
    first = next((value for parts in numbers for value in parts.values()), None)
    if getattr(first, "dtype", None) != Extended:
        return rows
    return {
        a: [(k, f.astype(Extended, copy=False) if isinstance(f, np.ndarray) and wanted[m] else f, m) for k, f, m in row]
        for a, row in rows.items()
    }


@dataclass
class RightHandSideParameters:
    """The right-hand-side parameters of a frame: one, and loads, offsets and prescribed displacements.

    Results are linear in them and are computed per unit of each. A number becomes a parameter of its own if it varies
    over axes over which the geometry does not; otherwise it is a factor of the parameter one.

    Attributes
    ----------
    grid
        The batch.
    geometry
        Mask of the axes over which the geometry varies.
    values
        Values of the parameters, the first being one; the key -1 - k of a row stands for ``values[k]``.
    """

    grid: Grid
    geometry: int
    values: list[Value] = field(default_factory=lambda: [1.0])

    def copy(self) -> RightHandSideParameters:
        """An independent copy."""
        return RightHandSideParameters(self.grid, self.geometry, list(self.values))

    def row(self, value: Value) -> Row:
        """`value` as a row over the right-hand-side parameters, to which it is added if need be."""
        if not (value.any() if isinstance(value, np.ndarray) else value):
            return {}
        if not mask_of(value) & ~self.geometry:
            return {ONE: value}
        self.values.append(value)
        return {-len(self.values): 1.0}

    def six(self, given: Mapping[int, NDArray[Any]]) -> tuple[Row, ...]:
        """Six components, given by index, as rows over the right-hand-side parameters; empty where none is given."""
        return tuple([self.row(self.grid.value(given[k])) if k in given else {} for k in range(6)])
