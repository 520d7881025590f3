"""Names of displacement and load components."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from numpy.typing import ArrayLike

from .batch import Array, finite
from .errors import FrameError

DISPLACEMENTS = ("ux", "uy", "uz", "rx", "ry", "rz")
FORCES = ("fx", "fy", "fz", "mx", "my", "mz")


def component(name: str, names: tuple[str, ...] = DISPLACEMENTS) -> int:
    """Index 0 to 5 of a component name."""
    if name not in names:
        raise FrameError(f"component {name!r} is unknown: use one of {', '.join(names)}")
    return names.index(name)


def components(names: Iterable[str]) -> tuple[int, ...]:
    """Indices of displacement components; all six where none is named."""
    return tuple(component(name) for name in names) or tuple(range(6))


def values(what: str, given: Mapping[str, ArrayLike], names: tuple[str, ...]) -> dict[int, Array]:
    """Checked component values by index, such as ``{1: array(100.0)}`` for ``fy=100.0``."""
    if not given:
        raise FrameError(f"{what} names no component: give at least one of {', '.join(names)}")
    out = {}
    for name, value in given.items():
        if name not in names:
            component(name, names)
        out[names.index(name)] = finite(value, f"{what}, {name},")
    return out
