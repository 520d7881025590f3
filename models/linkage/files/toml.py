"""Write TOML from plain values, and find the lines of its keys."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Mapping
from itertools import takewhile
from typing import Any

import numpy as np

Path = tuple[str | int, ...]

BARE = re.compile(r"[A-Za-z0-9_-]+")
NAME = r"""(?:[A-Za-z0-9_-]+|"(?:[^"\\]|\\.)*"|'[^']*')"""
KEY = re.compile(rf"\s*({NAME}(?:\s*\.\s*{NAME})*)\s*=")
STRING = re.compile(r'"(?:[^"\\]|\\.)*"|\'[^\']*\'')
LONG_STRING = re.compile(r'"""(?:[^\\]|\\.)*?"""|\'\'\'.*?\'\'\'', re.DOTALL)


def written(data: Mapping[str, Any]) -> str:
    """Tables as TOML: numbers, strings and lists first, then tables, then lists of tables.

    Floats are written so that they read back to the same bits, inf and nan included.

    Parameters
    ----------
    data
        Tables of numbers, strings, booleans, arrays, lists and further tables.

    Returns
    -------
    str
        The text.
    """
    return "\n".join(_lines(data, ())).strip() + "\n"


def _lines(data: Mapping[str, Any], above: tuple[str, ...]) -> Iterator[str]:
    plain = {key: value for key, value in data.items() if not _is_table(value)}
    if above and (plain or not data):
        yield f"[{'.'.join(map(_key, above))}]"
    yield from (f"{_key(key)} = {_value(value)}" for key, value in plain.items())
    if plain or (above and not data):
        yield ""
    for key, value in data.items():
        if isinstance(value, Mapping):
            yield from _lines(value, (*above, key))
        elif _is_table(value):
            for table in value:
                yield f"[[{'.'.join(map(_key, (*above, key)))}]]"
                yield from (f"{_key(name)} = {_value(entry)}" for name, entry in table.items())
                yield ""


def _is_table(value: object) -> bool:
    return isinstance(value, Mapping) or (isinstance(value, list) and any(isinstance(v, Mapping) for v in value))


def _key(name: str) -> str:
    return name if BARE.fullmatch(name) else json.dumps(name, ensure_ascii=False)


def _value(value: object) -> str:
    if isinstance(value, np.ndarray | np.generic):
        return _value(value.tolist())
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)


def line_of(text: str, path: Path) -> int:
    """Line of a key, counted from 1; if there is no such key, that of the table around it.

    Parameters
    ----------
    text
        Text of the file.
    path
        Keys from the outermost table on, numbers for entries of lists of tables.

    Returns
    -------
    int
        The line; 1 if not even a table around it is found.
    """
    best, line = 0, 1
    for known, at in _places(text):
        shared = sum(1 for _ in takewhile(lambda pair: pair[0] == pair[1], zip(known, path, strict=False)))
        if shared > best:
            best, line = shared, at
    return line


def _places(text: str) -> Iterator[tuple[Path, int]]:
    """Keys and tables with their lines."""
    table: Path = ()
    counts: dict[Path, int] = {}
    depth = 0
    for number, line in _lines_of(text):
        bare = STRING.sub('""', line).split("#")[0]
        inside, depth = depth > 0, depth + sum(bare.count(c) for c in "[{") - sum(bare.count(c) for c in "]}")
        if inside:
            continue
        head = line.strip()
        key = KEY.match(line)
        if key:
            yield (*table, *_path(f"{key[1]} = 0")), number
        elif head.startswith("["):
            table = _path(head)
            if head.startswith("[["):
                counts[table] = counts.get(table, -1) + 1
                table = (*table, counts[table])
            yield table, number


def _path(line: str) -> Path:
    """The path of keys in a line that has one key."""
    path: list[str | int] = []
    try:
        here: Any = tomllib.loads(line)
    except tomllib.TOMLDecodeError:
        return ()
    while isinstance(here, dict) and here:
        name, here = next(iter(here.items()))
        path.append(name)
        here = here[0] if isinstance(here, list) else here
    return tuple(path)


def bare_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines, counted from 1, without comments and the content of strings."""
    for number, line in _lines_of(text):
        yield number, STRING.sub('""', line).split("#")[0]


def _lines_of(text: str) -> Iterator[tuple[int, str]]:
    """Lines, counted from 1; strings over several lines are emptied."""
    flat = LONG_STRING.sub(lambda found: '""' + "\n" * found[0].count("\n"), text)
    return enumerate(flat.split("\n"), start=1)
