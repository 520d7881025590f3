"""Optional packages, imported when first needed."""

from __future__ import annotations

from importlib import import_module
from typing import Any

from .errors import FrameError


def imported(name: str, what: str) -> Any:
    """A package by its name, or an error that says what needs it.

    Parameters
    ----------
    name
        Name of the package.
    what
        What needs it.
    """
    try:
        return import_module(name)
    except ImportError:
        raise FrameError(f"{what} needs {name}, which is not installed: pip install {name}") from None
