"""Old spellings of public names: they still work for one release, with a warning that names the new one."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

P = ParamSpec("P")
R = TypeVar("R")


def renamed_keywords(**new: str) -> Callable[[Callable[P, R]], Callable[P, R]]:
    """Decorator of a function that takes some keywords by their old names as well.

    Parameters
    ----------
    new
        New name of each keyword by its old one.

    Raises
    ------
    TypeError
        When the function is called with both names of a keyword.
    """

    def decorated(function: Callable[P, R]) -> Callable[P, R]:
        @wraps(function)
        def called(*args: P.args, **kwargs: P.kwargs) -> R:
            for old in new:
                if old not in kwargs:
                    continue
                if new[old] in kwargs:
                    raise TypeError(f"{function.__name__} was given {old}= and {new[old]}=: give {new[old]}= alone")
                _warn(f"{old}= is now {new[old]}=")
                kwargs[new[old]] = kwargs.pop(old)
            return function(*args, **kwargs)

        return called

    return decorated


class RenamedAttribute:
    """The old name, in a class, of an attribute or a method.

    Parameters
    ----------
    new
        Its new name.
    """

    def __init__(self, new: str) -> None:
        self.new = new

    def __get__(self, owner: Any, kind: type) -> Any:
        if owner is None:
            return self
        _warn(f"this attribute of {kind.__name__} is now called {self.new}")
        return getattr(owner, self.new)


def _warn(text: str) -> None:
    warnings.warn(f"{text}: the old name goes with the next release", DeprecationWarning, stacklevel=3)
