"""Find the numbers of a file that a tolerance names."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator
from typing import Any

from ..description.joints import COMPONENTS, KINDS
from ..files.source import Source, shown_value
from ..files.toml import Path

AXES = ("x", "y", "z")
TENSOR = ("xx", "yy", "zz", "xy", "yz", "zx")
# Tables of a file that are no part of the linkage.
OF_THE_RUN = ("run", "tolerances", "choices", "measured", "title")
DIRECTIONS = ("axis", "second", "up", "axes")


def numbers_at(source: Source, path: Path, text: str, *, relative: bool) -> tuple[Path, dict[Path, float]]:
    """Path of an entry, and by path the numbers in it that vary.

    Parameters
    ----------
    source
        The file.
    path
        Path at which the tolerance names the entry, for errors.
    text
        Its name, such as ``joints.B.clearance``, ``joints.B.stiffness.ux``, ``points.C.x`` or ``loads.0.fy``.
    relative
        Whether the numbers are scaled.

    Raises
    ------
    FrameError
        If there is no such entry, or no number in it that can vary.
    """
    place = _place(source, path, text)
    value = source.get(place)
    if place[0] in OF_THE_RUN:
        source.fail(path, f"{text!r} is no part of the linkage")
    if value is None:
        source.fail(path, _missing(source, place, text))
    numbers = dict(_numbers(value, place))
    if not numbers or any(isinstance(entry, bool) or not isinstance(entry, int | float) for entry in numbers.values()):
        source.fail(path, f"{text!r} is {shown_value(value)} in this file: name a number, or a list of numbers")
    if isinstance(value, list) and place[-1] in DIRECTIONS:
        source.fail(path, f"{text!r} is a direction, which has no size: name one number of it, such as {text}.x")
    if isinstance(value, list):
        # 0 and inf, for free and ideal directions of a stiffness, do not vary, nor does a coordinate of 0
        varied = {where: float(number) for where, number in numbers.items() if number and math.isfinite(number)}
    else:
        varied = {place: float(value)}
    if not varied or not all(map(math.isfinite, varied.values())):
        source.fail(
            path, f"{text!r} is {shown_value(value)}: 0 and inf stay as they are in a list, and inf alone cannot vary"
        )
    if relative and 0.0 in varied.values():
        source.fail(path, f"{text!r} is 0, of which a percentage is 0: give loc and scale as numbers")
    return place, varied


def entry_name(source: Source, place: Path) -> str:
    """A place in the file by the names that `numbers_at` takes: ``points.B.y``, ``joints.B.stiffness.ux``."""
    names = _components(source, place[:-1]) if isinstance(place[-1], int) else ()
    last = names[place[-1]] if isinstance(place[-1], int) and place[-1] < len(names) else place[-1]
    return ".".join(map(str, (*place[:-1], last)))


def _missing(source: Source, place: Path, text: str) -> str:
    """Message for an entry that is not in the file, which lists the entries beside it."""
    depth = next(k for k in reversed(range(len(place))) if k == 0 or source.get(place[:k]) is not None)
    beside = source.data if depth == 0 else source.get(place[:depth])
    where = "the file" if depth == 0 else ".".join(map(str, place[:depth]))
    if not isinstance(beside, dict):
        return f"there is no {text!r} in this file: {where} is {shown_value(beside)}"
    names = [str(name) for name in beside if depth or name not in OF_THE_RUN]
    return f"there is no {text!r} in this file: {where} has {', '.join(names) or 'nothing'}"


def _place(source: Source, path: Path, text: str) -> Path:
    """Path of an entry, in which components of lists may be named or numbered."""
    try:
        here: Any = tomllib.loads(f"{text} = 0")
    except (tomllib.TOMLDecodeError, RecursionError):
        here = None
    if not isinstance(here, dict) or len(here) != 1:
        source.fail(path, f"{text!r} is no key: give one such as joints.B.clearance")
    keys: list[str | int] = []
    while isinstance(here, dict):
        key, here = next(iter(here.items()))
        keys.append(_index(source, path, text, tuple(keys), key))
    return tuple(keys)


def _index(source: Source, path: Path, text: str, above: Path, key: str) -> str | int:
    """The key of a table, or the index in a list."""
    entries = source.get(above) if above else source.data
    if not isinstance(entries, list):
        return key
    names = _components(source, above) if not any(isinstance(entry, list | dict) for entry in entries) else ()
    index = int(key) if key.isdecimal() and len(key) < 10 else names.index(key) if key in names else len(entries)
    if index >= len(entries):
        known = ", ".join(names[: len(entries)])
        source.fail(
            path,
            f"{text!r}: {'.'.join(map(str, above))} has no {key!r}: give "
            f"{f'one of {known}, or ' if known else ''}a number from 0 to {len(entries) - 1}",
        )
    return index


def _components(source: Source, place: Path) -> tuple[str, ...]:
    """Names of the numbers in a list."""
    match place:
        case ("joints", _, "stiffness"):
            return COMPONENTS
        case ("joints", name, "reference"):
            kind = source.get(("joints", name, "kind"))
            return KINDS[kind].coordinates if kind in KINDS else ()
        case ("points", _) | ("gravity",) | (_, _, "axis" | "second" | "up" | "centre"):
            return AXES
        case ("links", _, "inertia"):
            return TENSOR
    return ()


def _numbers(value: object, place: Path) -> Iterator[tuple[Path, Any]]:
    """Entries of nested lists, each with its path."""
    if isinstance(value, list):
        for index, entry in enumerate(value):
            yield from _numbers(entry, (*place, index))
    else:
        yield place, value
