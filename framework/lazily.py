"""Lazy loading of the names of a package, and lazy properties that are computed once."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Mapping
from importlib import import_module
from typing import TYPE_CHECKING

__all__ = ["cached_property", "loaded_later"]

if TYPE_CHECKING:
    from functools import cached_property
else:

    class cached_property(functools.cached_property):
        """That of `functools`, without a lock, and one object for all threads.

        Before Python 3.12 all objects of a class share a lock, so that what one thread solves waits for all that others
        do; from then on each of several threads may have an object of its own.
        """

        def __get__(self, instance, owner=None):
            """The value, which is then an attribute of the object."""
            if instance is None:
                return self
            # two threads may both compute it; one of the two is kept
            return vars(instance).setdefault(self.attrname, self.func(instance))


def loaded_later(package: str, places: Mapping[str, str]) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package that has more names than it has loaded.

    Parameters
    ----------
    package
        Its ``__name__``.
    places
        By name the module that has it, relative to the package.

    Returns
    -------
    tuple of callables
        The package's ``__getattr__`` and ``__dir__``.
    """

    def get(name: str) -> object:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(places[name], package), name)

    def names() -> list[str]:
        return [*vars(sys.modules[package]), *places]

    return get, names
