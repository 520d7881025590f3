"""Names of a package that are loaded where they are first used."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


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
        What gives a name, and what lists them all.
    """

    def get(name: str) -> object:
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        return getattr(import_module(places[name], package), name)

    def names() -> list[str]:
        return [*vars(sys.modules[package]), *places]

    return get, names
