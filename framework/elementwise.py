"""Elementwise functions of arrays of numbers, or of terms of a recording.

A formula written with these is computed on arrays of numbers; on arrays of objects that hold terms of a recording (or
plain numbers, if known beforehand), its operations are recorded instead.
"""

from __future__ import annotations

import operator
from functools import cache
from typing import Any

import numpy as np

from .batch import Array

# Of the arc tangent (S. L. Moshier, Methods and Programs for Mathematical Functions, 1989): a rational function up to
# this argument, above which 45 degrees are taken off first, and what the constants for these lack.
_ANGLE = 0.66
_ABOVE = (
    -8.750608600031904122785e-1,
    -1.615753718733365076637e1,
    -7.500855792314704667340e1,
    -1.228866684490136173410e2,
    -6.485021904942025371773e1,
)
_BELOW = (
    1.0,
    2.485846490142306297962e1,
    1.650270098316988542046e2,
    4.328810604912902668951e2,
    4.853903996359136964868e2,
    1.945506571482613964425e2,
)
_LACK = 6.123233995736765886130e-17
# Added and taken off again, it leaves the nearest whole number.
_WHOLE = 1.5 * 2.0**52
# Strides of an axis that comes last in memory, or along which numbers are alike.
_LAST = (8, 0)


def is_recorded(*arrays: Array) -> bool:
    """Whether one of the arrays holds terms of a recording."""
    return any(array.dtype == object for array in arrays)


def zeros(shape: tuple[int, ...], *like: Array) -> Array:
    """Zeros, for numbers or for terms as these arrays hold."""
    out: Array = np.zeros(shape)
    return out.astype(object) if is_recorded(*like) else out


def contracted(pattern: str, *arrays: Array) -> Array:
    """Sum of products as `np.einsum` has it, of arrays whose batch axes come last.

    Terms are added in the order of their indices, however long the batch is: NumPy adds along the axis that comes last
    in memory in another order, so that an entry alone would differ by rounding from itself in a batch.
    """
    lone, ordered = True, True
    for array, leading in zip(arrays, _leading(pattern), strict=True):
        strides, batch = array.strides[leading:], array.shape[leading:]
        if batch and batch[-1] != 1:
            lone, ordered = False, ordered and strides[-1] in _LAST
        elif len(batch) == 2 and batch[0] != 1:
            lone, ordered = False, ordered and strides[0] in _LAST
        elif len(batch) != 1 and batch != (1, 1):
            lone = False
    if not lone:
        return np.asarray(np.einsum(pattern, *(arrays if ordered else map(np.ascontiguousarray, arrays))))
    if is_recorded(*arrays):
        return np.asarray(np.einsum(pattern, *arrays))
    twice: Array = np.einsum(pattern, *[np.concatenate((array, array), axis=-1) for array in arrays])
    return twice[..., :1].copy()


@cache
def _leading(pattern: str) -> tuple[int, ...]:
    """How many axes of each array are no batch axes."""
    return tuple(len(each.replace("...", "m")) - 1 for each in pattern.split("->")[0].split(","))


def added(terms: Array) -> Array:
    """Sum over the first axis of terms (n, m), in the order of their indices, however long the batch is."""
    lone = terms.shape[-1] == 1 and len(terms) > 0 and not is_recorded(terms)
    out: Array = np.cumsum(terms, axis=0)[-1] if lone else np.ascontiguousarray(terms).sum(axis=0)
    return out


def square_root(x: Array) -> Array:
    """Square root."""
    out: Array = _root(x) if is_recorded(x) else np.sqrt(x)
    return out


def sine(x: Array) -> Array:
    """Sine."""
    out: Array = _sine(x) if is_recorded(x) else np.sin(x)
    return out


def cosine(x: Array) -> Array:
    """Cosine."""
    out: Array = _cosine(x) if is_recorded(x) else np.cos(x)
    return out


def sinc(x: Array) -> Array:
    """Sine over angle."""
    if not is_recorded(x):
        return np.asarray(np.sinc(x / np.pi))
    safe = where(less(-np.abs(x), 0.0), x, 1.0)
    return where(less(-np.abs(x), 0.0), sine(x) / safe, 1.0)


def minimum(a: Array, b: Any) -> Array:
    """The lesser of two."""
    out: Array = _minimum(a, b) if is_recorded(a) else np.minimum(a, b)
    return out


def maximum(a: Array, b: Any) -> Array:
    """The greater of two."""
    out: Array = _maximum(a, b) if is_recorded(a) else np.maximum(a, b)
    return out


def less(a: Any, b: Any) -> Any:
    """Whether a is less than b."""
    return _less(a, b) if is_recorded(*(x for x in (a, b) if isinstance(x, np.ndarray))) else a < b


def where(condition: Any, a: Any, b: Any) -> Array:
    """a where a condition holds, b elsewhere."""
    arrays = [x for x in (condition, a, b) if isinstance(x, np.ndarray)]
    out: Array = _where(condition, a, b) if is_recorded(*arrays) else np.where(condition, a, b)
    return out


def rounded(x: Array) -> Array:
    """The nearest whole number, of two the even one; of terms, up to 2^51."""
    return (x + _WHOLE) - _WHOLE if is_recorded(x) else np.round(x)


def angle(y: Array, x: Array) -> Array:
    """Angle between x axis and the direction (x, y), from -pi to pi; recorded, to two roundings of the result."""
    out: Array = _angle(y, x) if is_recorded(y, x) else np.arctan2(y, x)
    return out


def _choose(condition: Any, a: Any, b: Any) -> Any:
    if isinstance(condition, (bool, np.bool_)):
        return a if condition else b
    return condition.chosen(a, b)


def _angle_of(y: Any, x: Any) -> Any:
    height, width = np.abs(y), np.abs(x)
    low, high = np.minimum(height, width), np.maximum(height, width)
    steep = np.greater(low, _ANGLE * high)
    below = _choose(steep, low + high, high)
    t = _choose(steep, low - high, low) / _choose(np.greater(below, 0.0), below, 1.0)
    square = t * t
    above, under = _ABOVE[0], square + _BELOW[1]
    for each in _ABOVE[1:]:
        above = above * square + each
    for each in _BELOW[2:]:
        under = under * square + each
    out = t * (square * above / under) + t
    out = _choose(steep, 0.25 * np.pi + (out + 0.5 * _LACK), out)
    out = _choose(np.less(width, height), 0.5 * np.pi - (out - _LACK), out)
    out = _choose(np.less(x, 0.0), np.pi - (out - 2.0 * _LACK), out)
    return _choose(np.less(y, 0.0), -out, out)


_root: Any = np.frompyfunc(np.sqrt, 1, 1)
_sine: Any = np.frompyfunc(np.sin, 1, 1)
_cosine: Any = np.frompyfunc(np.cos, 1, 1)
_minimum: Any = np.frompyfunc(np.minimum, 2, 1)
_maximum: Any = np.frompyfunc(np.maximum, 2, 1)
_less: Any = np.frompyfunc(operator.lt, 2, 1)
_where: Any = np.frompyfunc(_choose, 3, 1)
_angle: Any = np.frompyfunc(_angle_of, 2, 1)
