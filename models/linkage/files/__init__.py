"""Linkages in files: written, read, and pointed at by line and key where they are wrong."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .linkage_file import read_linkage
    from .write import write_linkage

__all__ = ["read_linkage", "write_linkage"]

# Imported where they are first asked for: a linkage reads parts of files, and files make linkages.
_LATER = {
    "read_linkage": ".linkage_file",
    "write_linkage": ".write",
}


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_LATER[name], __name__), name)


def __dir__() -> list[str]:
    return [*globals(), *_LATER]
