"""Arguments that are whole numbers or switches, checked."""

from __future__ import annotations

import numpy as np

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
