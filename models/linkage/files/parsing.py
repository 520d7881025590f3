"""Read TOML, with checks of its numbers and its depth, and errors that name the line."""

from __future__ import annotations

import math
import re
import tomllib
from typing import Any

from .toml import Path, bare_lines, line_of

AT_LINE = re.compile(r" \(at line (\d+), column \d+\)| \(at end of document\)")
# A whole number of more digits than Python reads.
MANY_DIGITS = re.compile(r"\d[\d_]{4299,}")
# Largest depth of nested lists and tables.
DEEPEST = 32


class Unreadable(Exception):
    """A text that is not TOML, or has numbers or tables that cannot be read.

    Parameters
    ----------
    line
        Line of the text, from 1.
    why
        What is wrong there.
    """

    def __init__(self, line: int, why: str) -> None:
        super().__init__(why)
        self.line = line


class _OutOfRange(ValueError):
    """A number that a float cannot hold; its text is the argument."""


def parsed(text: str) -> dict[str, Any]:
    """The tables of a text.

    Raises
    ------
    Unreadable
        If it is not TOML, a number is beyond the range of floats, or lists or tables lie too deep in one another.
    """
    try:
        data = tomllib.loads(text, parse_float=_float)
    except tomllib.TOMLDecodeError as error:
        if text.lstrip("\ufeff \t\r\n").startswith("<"):
            why = "this is XML, not TOML: where it is MJCF, linkframe convert FILE.xml FILE.toml makes TOML of it"
            raise Unreadable(1, why) from None
        found = AT_LINE.search(str(error))
        line = int(found[1]) if found and found[1] else text.count("\n", 0, len(text.rstrip())) + 1
        raise Unreadable(line, f"this is not TOML: {AT_LINE.sub('', str(error))}") from error
    except _OutOfRange as error:
        number = str(error)
        line = _line_with(text, re.compile(rf"(?<![\w.+-]){re.escape(number)}(?![\w.])"))
        raise Unreadable(line, f"{number} is beyond the range of floats: give a number from 1e-307 to 1e308") from error
    except ValueError as error:
        why = "a whole number has more than 4300 digits: give at most 300, or a float such as 2e11"
        raise Unreadable(_line_with(text, MANY_DIGITS), why) from error
    except RecursionError:
        raise Unreadable(_deepest_line(text), _TOO_DEEP) from None
    _check_depth(data, text)
    return data


_TOO_DEEP = f"lists or tables lie more than {DEEPEST} deep in one another: write them flatter"


def _float(text: str) -> float:
    """A float of TOML; refused if it would silently become inf or 0."""
    value = float(text)
    if (math.isinf(value) and "inf" not in text) or (value == 0.0 and re.search("[1-9]", re.split("[eE]", text)[0])):
        raise _OutOfRange(text)
    return value


def _check_depth(data: dict[str, Any], text: str) -> None:
    waiting: list[tuple[Path, object]] = [((), data)]
    while waiting:
        path, value = waiting.pop()
        if len(path) > DEEPEST:
            raise Unreadable(line_of(text, path), _TOO_DEEP)
        if isinstance(value, dict):
            waiting += [((*path, key), entry) for key, entry in value.items()]
        elif isinstance(value, list):
            waiting += [((*path, index), entry) for index, entry in enumerate(value) if isinstance(entry, dict | list)]


def _deepest_line(text: str) -> int:
    """Line on which brackets are nested most deeply."""
    depth = deepest = 0
    line = 1
    for number, bare in bare_lines(text):
        for sign in bare:
            depth += (sign in "[{") - (sign in "]}")
            if depth > deepest:
                deepest, line = depth, number
    return line


def _line_with(text: str, pattern: re.Pattern[str]) -> int:
    """First line on which a pattern is found outside strings and comments; 1 if there is none."""
    return next((number for number, bare in bare_lines(text) if pattern.search(bare)), 1)
