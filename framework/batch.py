"""Broadcasting is the batch interface: checks of what comes in, alignment of what goes through."""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .errors import FrameError

Array = NDArray[np.float64]
Shape = tuple[int, ...]

# Objects up to which each is held against all others, and numbers up to which Python looks at each.
_FEW = 16
# Of up to so many numbers each is added, also where all of one component are zero.
_MANY = 2**12
# Axes examined at a time.
_IN_CACHE = 2**13
# Product of the numbers of matrices and vectors above which these are multiplied three components after three.
_LONG = 150_000
# What arrays of floats are most often of: one object, though others may be equal to it.
_FLOATS = np.dtype(np.float64)
# For each column of three the next one.
_NEXT = [1, 2, 0]
# The number zero as an array: one object, which is known by itself and nobody may change.
ZERO: Array = np.zeros(())
ZERO.setflags(write=False)


def numbers(value: ArrayLike, what: str) -> Array:
    """`value` as a read-only float array of its own: what becomes of the given one later changes nothing."""
    plain = type(value) is np.ndarray and value.dtype is _FLOATS  # as most often; there is no more to look at
    array: Array = np.array(value) if plain else as_numbers(value, what, copy=True)
    array.setflags(write=False)
    return array


def as_numbers(value: ArrayLike, what: str, *, copy: bool = False) -> Array:
    """`value` as a float array; without a copy the one that was given, where it is one, to be read and forgotten."""
    if hasattr(value, "_mask") and np.ma.is_masked(value):
        raise FrameError(f"{what} has masked entries: give a number for each, or leave them out")
    try:
        given = np.array(value, copy=copy or None)
        if given.dtype.kind not in "biufO":
            raise TypeError
        array: Array = given.astype(np.float64, copy=False)
    except (TypeError, ValueError, OverflowError):
        raise FrameError(f"{what} is {_short(value)}: give a number or an array of numbers") from None
    return array


def _short(value: object) -> str:
    """The repr of `value`, cut off for a long array."""
    text = " ".join(repr(value).split())
    return text if len(text) <= 80 else f"{text[:76]} ..."


def finite(value: ArrayLike, what: str) -> Array:
    """`numbers`, with an error if one is not finite."""
    kind = type(value)
    # as most often; there is no more to look at
    if (kind is float or kind is np.float64) and math.isfinite(value):  # type: ignore[arg-type]
        array = np.array(value)
        array.setflags(write=False)
        return array
    if kind is np.ndarray and value.dtype is _FLOATS:  # type: ignore[union-attr]
        array = np.array(value)
        array.setflags(write=False)
    else:
        array = numbers(value, what)
    # of a few numbers Python knows in a third of the time
    if not (all(map(math.isfinite, array.ravel().tolist())) if array.size <= _FEW else all_of(np.isfinite(array))):
        bad = array[~np.isfinite(array)].flat[0]
        raise FrameError(f"{what} contains {bad}: give finite numbers")
    return array


def unvaried(value: ArrayLike, shape: Shape = ()) -> Array | None:
    """`value` as finite numbers of exactly this shape, without batch axes; None if it is anything else."""
    try:
        array = finite(value, "")
    except FrameError:
        return None
    return array if array.shape == shape else None


def vector(value: ArrayLike, what: str, *, flat: bool = False) -> Array:
    """`value` as a finite array (..., 3); a `flat` one may be (..., 2), in the plane z = 0."""
    array = finite(value, what)
    if flat and array.shape[-1:] == (2,):
        array = np.concatenate([array, np.zeros((*array.shape[:-1], 1))], axis=-1)
        array.setflags(write=False)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise FrameError(f"{what} has shape {array.shape}: its last axis must hold 3 components")
    return array


def rotation(value: ArrayLike, what: str) -> Array:
    """`value` as right-handed orthonormal axes (..., 3, 3), the axes being its columns."""
    array = finite(value, what)
    if array.ndim < 2 or array.shape[-2:] != (3, 3):
        raise FrameError(f"{what} have shape {array.shape}: give (..., 3, 3), the axes as columns")
    if array.ndim == 2 and _is_rotation(array):
        return array
    if array.size <= _MANY:
        off, left = _oriented_one_by_one(array)
    else:
        whole = merged(array, 0, -3)
        each = [_oriented(whole[start : start + _IN_CACHE]) for start in range(0, len(whole), _IN_CACHE)]
        off, left = max(off for off, _ in each), any(left for _, left in each)
    if off > 1e-9:
        raise FrameError(f"{what} are not orthonormal (off by {off:.2g}): give three unit vectors at right angles")
    if left:
        raise FrameError(f"{what} are left-handed: turn one of the columns round")
    return array


def _is_rotation(axes: Array) -> bool:
    """Whether the third column of a matrix (3, 3) is the product of the first two, and these are unit vectors at right
    angles: by a tenth of what `rotation` allows, told of one matrix in a tenth of the time.
    """
    (x1, y1, z1), (x2, y2, z2), (x3, y3, z3) = axes.tolist()
    product = x2 * y3 - x3 * y2 - z1, x3 * y1 - x1 * y3 - z2, x1 * y2 - x2 * y1 - z3
    unit = x1 * x1 + x2 * x2 + x3 * x3 - 1.0, y1 * y1 + y2 * y2 + y3 * y3 - 1.0
    return bool(max(map(abs, (*product, *unit, x1 * y1 + x2 * y2 + x3 * y3))) < 1e-10)


def _oriented_one_by_one(axes: Array) -> tuple[float, bool]:
    """How far the columns of matrices (..., 3, 3) are from orthonormal, and whether some are left-handed."""
    rows = np.moveaxis(axes.reshape(-1, 3, 3), 0, -1).copy()
    units, products = rows * rows, rows * rows[:, _NEXT]
    off = [
        np.abs(each[0] + each[1] + each[2] - wanted).max(initial=0.0) for each, wanted in ((units, 1), (products, 0))
    ]
    (a, b, c), (d, e, f), (g, h, i) = rows
    # where these are units at right angles, the determinant is 1 or -1
    left = any_of(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) < 0.0)
    return float(max(off)), left


def _oriented(axes: Array) -> tuple[float, bool]:
    """The same of many matrices, component by component, in a tenth of the time."""
    x, y, z = (_components(axes[..., column]) for column in range(3))
    pairs = ((x, x, 1.0), (y, y, 1.0), (z, z, 1.0), (x, y, 0.0), (y, z, 0.0), (z, x, 0.0))
    off = max(float(np.abs(_dot(one, other) - wanted).max(initial=0.0)) for one, other, wanted in pairs)
    minus = [-part for part in z]
    across = [_dot((y[k - 2], y[k - 1]), (z[k - 1], minus[k - 2])) for k in range(3)]
    return off, bool(np.any(_dot(x, across) < 0.0))


def norms(vectors: Array) -> Array:
    """Lengths (...) of vectors (..., 3): equals `numpy.linalg.norm`, in a third of the time where there are many."""
    parts = _components(vectors)
    return np.broadcast_to(np.sqrt(_dot(parts, parts)), vectors.shape[:-1])


def placed(origin: Array, axes: Array, local: Array) -> Array:
    """Positions (..., 3) of points given by their components `local` (..., 3) along the columns of `axes` (..., 3, 3).

    Of many points those components that are zero throughout, as in the plane, are left out.
    """
    parts = _components(local) if local.size > _MANY else ()
    if not any(type(part) is float for part in parts):
        return origin + rotated(axes, local)
    shape = (*np.broadcast_shapes(origin.shape[:-1], axes.shape[:-2], local.shape[:-1]), 3)
    if all(type(part) is float for part in parts):
        return np.broadcast_to(origin, shape)
    out = np.empty(shape)
    for k in range(3):
        out[..., k] = origin[..., k] + _dot([axes[..., k, j] for j in range(3)], parts)
    return out


def _components(vectors: Array) -> Sequence[Array | float]:
    """The components of vectors (..., 3), each (...) and together in memory; 0.0 for one that is zero throughout."""
    parts = [vectors[..., k] for k in range(3)]
    return [part.copy() if np.count_nonzero(part) else 0.0 for part in parts]


def _dot(one: Sequence[Array | float], other: Sequence[Array | float]) -> Array | float:
    """Scalar products of vectors given by their components."""
    pairs = zip(one, other, strict=True)
    terms = [a * b for a, b in pairs if not (type(a) is float or type(b) is float)]
    return functools.reduce(operator.add, terms) if terms else 0.0


def joined(name: str, shape: Shape, known: Mapping[str, Shape]) -> Shape:
    """Broadcast of `shape` with all `known` shapes; a clash names both sides."""
    if all(not theirs or theirs == shape for theirs in known.values()):  # as most often
        return shape
    try:
        return np.broadcast_shapes(shape, *known.values())
    except ValueError:
        for other, theirs in known.items():
            if not _broadcastable(shape, theirs):
                raise FrameError(
                    f"{name} has batch shape {shape}, which does not broadcast with {theirs} of {other}: "
                    "give each independent variation an axis of its own, such as (36, 1) and (100,)"
                ) from None
        raise


def join(known: dict[str, Shape], name: str, shape: Shape) -> None:
    """Add `shape` to the `known` shapes, with all of which it must broadcast; a clash names both sides."""
    joined(name, shape, known)
    known[name] = shape


def one_entry(shape: Shape, entry: int | Sequence[int], what: str) -> tuple[int, ...]:
    """Indices of one entry of a batch, checked."""
    chosen = np.atleast_1d(entry).tolist()
    if len(chosen) != len(shape) or any(i not in range(-n, n) for i, n in zip(chosen, shape, strict=True)):
        raise FrameError(f"{what} was given entry={entry}: give one index for each of the batch axes {shape}")
    return tuple(map(int, chosen))


def _broadcastable(one: Shape, other: Shape) -> bool:
    return all(a == b or 1 in (a, b) for a, b in zip(one[::-1], other[::-1], strict=False))


def merged(array: NDArray[Any], first: int, last: int) -> NDArray[Any]:
    """An array with its axes from `first` to `last`, counted from either end, merged; the batch may be empty."""
    shape, start, stop = array.shape, *(k % array.ndim for k in (first, last))
    return array.reshape(*shape[:start], math.prod(shape[start : stop + 1]), *shape[stop + 1 :])


def aligned(array: Array, ndim: int, trailing: int = 0) -> Array:
    """`array` with leading axes of size one, so that it has `ndim` batch axes before `trailing` ones."""
    missing = ndim + trailing - array.ndim
    return array.reshape((1,) * missing + array.shape) if missing > 0 else array


def rotated(axes: Array, vectors: Array) -> Array:
    """Each three components of `vectors` (..., 3 n) multiplied by the matrices `axes` (..., 3, 3)."""
    fine = axes.dtype != np.float64 or vectors.dtype != np.float64
    if not fine and axes.ndim == 2 and vectors.shape == (3,):  # the same sum, with less to look at
        return np.asarray(np.einsum("ij,j->i", axes, vectors))
    if axes.size > 9 and not fine and axes.size * vectors.size > _LONG:
        return _rotated_one_by_one(axes, vectors)
    split = vectors.reshape(*vectors.shape[:-1], vectors.shape[-1] // 3, 3)
    # of numbers in extended precision matmul is the quicker one
    out: Array = split @ np.swapaxes(axes, -1, -2) if fine else np.einsum("...ij,...kj->...ki", axes, split)
    return out.reshape(*out.shape[:-2], 3 * out.shape[-2])


def _rotated_one_by_one(axes: Array, vectors: Array) -> Array:
    """`rotated` for long batches: the same sums, three components after three.

    NumPy goes through operands whose axes merge into one several times as fast, so that what it would have to repeat
    along an axis is repeated first, unless that is the last one of the vectors.
    """
    shape = axes.shape[:-2]
    if shape != vectors.shape[:-1]:
        shape = np.broadcast_shapes(shape, vectors.shape[:-1])
        if vectors.ndim > 1 and vectors.shape[-2] > 1 and vectors.strides[-1] == vectors.itemsize:
            transposed = axes.strides[-2] < axes.strides[-1]  # and must stay so, as the order of the sums goes by it
            rows = np.ascontiguousarray(np.broadcast_to(axes.mT if transposed else axes, (*shape, 3, 3)))
            axes = rows.mT if transposed else rows
            vectors = np.ascontiguousarray(np.broadcast_to(vectors, (*shape, vectors.shape[-1])))
    if vectors.shape[-1] == 3:
        return np.asarray(np.einsum("...ij,...j->...i", axes, vectors))
    out = np.empty((*shape, vectors.shape[-1]))
    for k in range(0, vectors.shape[-1], 3):
        out[..., k : k + 3] = np.einsum("...ij,...j->...i", axes, vectors[..., k : k + 3])
    return out


def block_diagonal(parts: Sequence[Array]) -> Array:
    """Block-diagonal matrices (..., 3 m, 3 m) of m matrices (..., 3, 3)."""
    shapes = {part.shape[:-2] for part in parts}
    shape = shapes.pop() if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    out = np.zeros((*shape, 3 * len(parts), 3 * len(parts)))
    for k, part in enumerate(parts):
        out[..., 3 * k : 3 * k + 3, 3 * k : 3 * k + 3] = part
    return out


def any_of(numbers: NDArray[Any]) -> bool:
    """Whether one of some numbers is not zero: `numbers.any()`, in a tenth of the time where they are few."""
    return bool(np.count_nonzero(numbers) > 0)


def all_of(numbers: NDArray[Any]) -> bool:
    """Whether none of some numbers is zero, see `any_of`."""
    return bool(np.count_nonzero(numbers) == numbers.size)


def distinct(objects: Sequence[object]) -> tuple[list[int], NDArray[np.int64]]:
    """Indices at which each distinct object comes first, and for each object the number of its distinct one, (n,)."""
    alone = len(set(map(id, objects)))
    if alone in (1, len(objects)):  # as most often
        return list(range(alone)), np.zeros(len(objects), np.int64) if alone == 1 else np.arange(alone)
    if len(objects) <= _FEW:
        firsts: list[int] = []
        found = []
        for k, each in enumerate(objects):
            found.append(next((n for n, first in enumerate(firsts) if objects[first] is each), len(firsts)))
            if found[-1] == len(firsts):
                firsts.append(k)
        return firsts, np.array(found, dtype=np.int64)
    identity = np.fromiter(map(id, objects), dtype=np.uint64, count=len(objects))
    _, first, which = np.unique(identity, return_index=True, return_inverse=True)
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return first[order].tolist(), rank[which]


class Same:
    """A dictionary key that compares the identity of the object it holds."""

    __slots__ = ("it",)

    def __init__(self, it: object) -> None:
        self.it = it

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.it is other.it

    def __hash__(self) -> int:
        return object.__hash__(self.it)
