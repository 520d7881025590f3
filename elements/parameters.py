"""Conversion and checks of the numbers that elements are given; errors name the element and the parameter."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from math import inf, isfinite

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.batch import all_of, numbers
from ..framework.errors import FrameError
from ..framework.protocol import Array

Real = float | Array
# Types of what does not vary over the batch; a tuple, which is quicker than a union.
_SINGLE = (float, type(None))


def require(owner: str, name: str, array: Array, ok: NDArray[np.bool_] | np.bool_, remedy: str) -> None:
    """Raise a `FrameError` unless `ok` holds everywhere, naming the first value at which it does not."""
    if np.count_nonzero(ok) == ok.size:
        return
    shape = np.broadcast_shapes(array.shape, np.shape(ok))
    first = np.broadcast_to(array, shape)[~np.broadcast_to(ok, shape)][0]
    raise FrameError(f"{owner}: {name} = {first:g} must be {remedy}")


def number(owner: str, name: str, value: ArrayLike) -> Real:
    """A finite number, or an array of them; single numbers become Python floats, which are cheap."""
    if type(value) is float and isfinite(value):
        return value
    array = numbers(value, f"{owner}: {name}")
    require(owner, name, array, np.isfinite(array), "finite; give a number")
    return as_real(array)


def _own(value: ArrayLike) -> Array | None:
    """A read-only copy of an array of floats; None of anything else."""
    if type(value) is not np.ndarray or value.dtype != np.float64 or not value.ndim:
        return None
    array = np.array(value)
    array.setflags(write=False)
    return array


def extent(array: Array) -> tuple[float, float]:
    """The least of some numbers, and the greatest that is not negative; NaN if there is one."""
    least = np.minimum.reduce(array, axis=None, initial=inf)
    return float(least), float(np.maximum.reduce(array, axis=None, initial=0.0))


def _above_zero(array: Array) -> bool:
    """Whether all numbers are finite and above zero."""
    return all_of((array > 0.0) & (array < inf))


def positive(owner: str, name: str, value: ArrayLike) -> Real:
    """A finite number above zero, or an array of them."""
    if (array := _own(value)) is not None and _above_zero(array):
        return array
    checked = number(owner, name, value)
    if type(checked) is float and checked > 0.0:
        return checked
    require(owner, name, np.asarray(checked), np.asarray(checked) > 0.0, "above zero; give a positive number")
    return checked


def positive_with_extent(owner: str, name: str, value: ArrayLike) -> tuple[Real, tuple[float, float]]:
    """`positive`, and the least and the greatest of the numbers."""
    if type(value) is float and 0.0 < value < inf:
        return value, (value, value)
    if (array := _own(value)) is not None:
        least, most = extent(array)
        if least > 0.0 and most < inf:
            return array, (least, most)
    checked = positive(owner, name, value)
    return checked, (checked, checked) if isinstance(checked, float) else extent(checked)


def not_negative(owner: str, name: str, value: ArrayLike) -> Real:
    """A finite number not below zero, or an array of them."""
    checked = number(owner, name, value)
    if type(checked) is float and checked >= 0.0:
        return checked
    require(owner, name, np.asarray(checked), np.asarray(checked) >= 0.0, "zero or above; give its magnitude")
    return checked


def derived_numbers(owner: str, given: Mapping[str, Array | float]) -> dict[str, Real]:
    """Positive numbers computed from checked ones, by name; a `FrameError` where one overflows or underflows."""
    return {name: _derived_number(owner, name, value) for name, value in given.items()}


def _derived_number(owner: str, name: str, value: Array | float) -> Real:
    if type(value) is float and 0.0 < value < inf:
        return value
    if type(value) is np.ndarray and value.ndim and _above_zero(value):
        value.setflags(write=False)
        return value
    array = numbers(value, f"{owner}: {name}")
    require(owner, name, array, np.isfinite(array) & (array > 0.0), "within the range of floats; take another unit")
    return as_real(array)


def common_shape(owner: str, shapes: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """Broadcast of named shapes; a `FrameError` with the names where they do not broadcast."""
    try:
        return shape_of(*shapes.values())
    except ValueError:
        text = ", ".join(f"{name} {shape}" for name, shape in shapes.items() if shape)
        raise FrameError(f"{owner}: shapes do not broadcast: {text}; give arrays that broadcast together") from None


def shape_of(*values: Real | tuple[int, ...] | None) -> tuple[int, ...]:
    """Broadcast of the shapes of numbers, and of shapes; fast where all are single numbers, as most are."""
    shapes = {v if isinstance(v, tuple) else np.shape(v) for v in values if not isinstance(v, _SINGLE)}
    shapes.discard(())
    return np.broadcast_shapes(*shapes) if len(shapes) > 1 else next(iter(shapes), ())


def as_real(value: Array | float) -> Real:
    """A Python float if there is one number, which is far cheaper than an array; else an array of floats."""
    return float(value) if np.ndim(value) == 0 else np.asarray(value, dtype=np.float64)


def given_state(described: object) -> dict[str, object]:
    """State of an object for copying and pickling: its attributes without cached properties."""
    kind = type(described)
    return {
        name: value
        for name, value in vars(described).items()
        if not isinstance(getattr(kind, name, None), cached_property)
    }
