"""Arguments that are numbers within limits or switches, checked."""

from __future__ import annotations

from collections.abc import Container, Iterable

import numpy as np
from numpy.typing import ArrayLike

from .batch import Array, finite
from .errors import FrameError


def whole_number(value: object, what: str, least: int) -> int:
    """A whole number not below `least`, checked."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise FrameError(f"{what} is {value!r}: give a whole number of {least} or more")
    return int(value)


def switch(value: object, what: str) -> bool:
    """What is either true or false, checked."""
    if not isinstance(value, bool | np.bool_):
        raise FrameError(f"{what} is {value!r}: give True or False")
    return bool(value)


def check_gradient(derivatives: Container[str], names: Iterable[str], what: str = "input") -> None:
    """Raise an error unless the derivatives of a gradient, by name, include those by all `names` of inputs."""
    for name in names:
        if name not in derivatives:
            raise FrameError(f"the gradient has no derivative by {name!r}: give one for each {what}")


def above_zero(value: ArrayLike, what: str) -> Array:
    """Finite numbers above zero, checked."""
    given = finite(value, what)
    if np.any(given <= 0.0):
        raise FrameError(f"{what} is {given[given <= 0.0].flat[0]:g}: give a number above zero")
    return given


def not_negative(value: ArrayLike, what: str) -> Array:
    """Finite numbers from zero on, checked."""
    given = finite(value, what)
    if np.any(given < 0.0):
        raise FrameError(f"{what} is {given[given < 0.0].flat[0]:g}: give zero or above")
    return given
