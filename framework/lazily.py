"""Lazy loading of the names and modules of a package, and lazy properties that are computed once."""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Collection, Mapping
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

__all__ = ["DeferredModule", "cached_property", "loaded_later"]

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


class DeferredModule(ModuleType):
    """Stands for a module, which is loaded when the first of its names is read.

    Only the module itself is kept, none of its names: what is set in either of the two, as tests do, is seen in both.
    """

    def __getattr__(self, name: str) -> object:
        module = import_module(self.__name__)
        # names are read from now on without a call of this, which would take several times as long
        super().__setattr__("__getattr__", module.__getattribute__)
        return getattr(module, name)

    def __setattr__(self, name: str, value: object) -> None:
        setattr(import_module(self.__name__), name, value)

    def __delattr__(self, name: str) -> None:
        delattr(import_module(self.__name__), name)

    @property
    def __dict__(self) -> dict[str, object]:  # type: ignore[override]
        return vars(import_module(self.__name__))


def loaded_later(
    package: str, places: Mapping[str, str], modules: Collection[str] = ()
) -> tuple[Callable[[str], object], Callable[[], list[str]]]:
    """``__getattr__`` and ``__dir__`` of a package that has more names than it has loaded.

    Parameters
    ----------
    package
        Its ``__name__``.
    places
        By name the module that has it, relative to the package.
    modules
        Modules of the package that ``from package import module`` does not load yet: that is done when one of their
        names is first used, so that a file can name at its top what few of its calls need.

    Returns
    -------
    tuple of callables
        The package's ``__getattr__`` and ``__dir__``.
    """

    def get(name: str) -> object:
        if name in modules:
            return DeferredModule(f"{package}.{name}")
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(places[name], package), name)

    def names() -> list[str]:
        return [*vars(sys.modules[package]), *places]

    return get, names
