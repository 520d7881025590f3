"""A TOML file being read: its values, and errors that name its lines."""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path as File
from typing import Any, NoReturn, Self

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from .old_keys import renew
from .parsing import Unreadable, parsed
from .toml import Path, line_of

# Lists of samples in messages, which are shortened.
LONG_LIST = re.compile(r"\[[^'\"]{200,}\]")


class Source:
    """A TOML file.

    Parameters
    ----------
    file
        Path of the file.

    Raises
    ------
    FrameError
        If it cannot be read, or is not TOML.
    """

    def __init__(self, file: str | File) -> None:
        self.file = File(file)
        try:
            self.text = self.file.read_text(encoding="utf-8-sig")  # Windows editors begin with a mark
        except (OSError, ValueError) as error:
            why = getattr(error, "strerror", None) or "it is not UTF-8 text"
            raise FrameError(f"{self.file} cannot be read: {why}; give a TOML file that describes a linkage") from error
        try:
            self.data = parsed(self.text)
        except Unreadable as error:
            raise FrameError(f"{self.file}, line {error.line}: {error}") from error
        self.written = renew(self.data)
        self.samples: Mapping[Path, Array] = {}
        self.by: Mapping[Path, Path] = {}
        # what has set keys that are not from the text of the file, such as an option
        self.set_by: Mapping[Path, str] = {}

    def with_samples(self, samples: Mapping[Path, Array], by: Mapping[Path, Path]) -> Self:
        """The file with samples in place of some of its numbers; errors in them name the tolerance that drew them.

        Parameters
        ----------
        samples
            By path of the number: its samples, (n,).
        by
            By path of the number: path of the tolerance that drew them.
        """
        clone = self.changed(samples)
        clone.samples, clone.by = samples, by
        return clone

    def changed(self, values: Mapping[Path, float | Array]) -> Self:
        """The file with other values in place of some of its numbers.

        Parameters
        ----------
        values
            By path of the number: its value, or samples (n,).
        """
        clone = copy.copy(self)
        clone.data = copy.deepcopy(self.data)
        for place, value in values.items():
            *above, last = place
            here: Any = clone.data
            for key in above:
                here = here[key]
            here[last] = value
        return clone

    def fail(self, path: Path, message: str) -> NoReturn:
        """Refuse the file because of the value at `path`."""
        for place, values in self.samples.items():
            shared = min(len(place), len(path))
            if place[:shared] == path[:shared]:
                least, most = (f"{each:g}" for each in (values.min(), values.max()))
                reach = f"are {least}" if least == most else f"reach from {least} to {most}"
                drawn = f"samples of {'.'.join(map(str, place))} {reach}"
                path, message = self.by[place], f"{drawn}: {LONG_LIST.sub('[...]', message)}"
                break
        path = (*self.written.get(path[:3], path[:3]), *path[3:])
        raise FrameError(f"{self.place(path)}: {message}")

    def place(self, path: Path) -> str:
        """File, line and name of a key, in words."""
        for place, by in self.set_by.items():
            if path[: len(place)] == place:
                return f"{self.file} with {by}"
        return f"{self.file}, line {line_of(self.text, path)}, {'.'.join(map(str, path))}"

    @contextmanager
    def at(self, *path: str | int) -> Iterator[None]:
        """Let errors in the body name the file and line of the key, in the table at `path`, that they are about."""
        try:
            yield
        except FrameError as error:
            if str(error).startswith(f"{self.file}"):
                raise
            self.fail((*path, *self._named(path, str(error))), str(error))

    def _named(self, path: Path, message: str) -> Path:
        """Key of the table at `path` that a message mentions first, also in the singular."""
        table, words = self.get(path), re.findall(r"\w+", message)
        places = [
            (words.index(word), key)
            for key in (table if isinstance(table, Mapping) else {})
            for word in (key, key.removesuffix("s"))
            if word in words
        ]
        return (min(places)[1],) if places else ()

    def get(self, path: Path) -> Any:
        """The value at a path; None if there is none."""
        here: Any = self.data
        for key in path:
            try:
                here = here[key]
            except (KeyError, IndexError, TypeError):
                return None
        return here

    def table(self, path: Path, required: tuple[str, ...], optional: tuple[str, ...] = ()) -> dict[str, Any]:
        """A table, refused if it has unknown keys or lacks required ones."""
        found = self.get(path)
        if not isinstance(found, dict):
            self.fail(path, f"is {shown_value(found)}: give a table")
        known = (*required, *optional)
        for key in found:
            if key not in known:
                self.fail((*path, key), f"there is no such key here: use one of {', '.join(known)}")
        for key in required:
            if key not in found:
                self.fail(path, f"has no {key}: give {', '.join(required)}")
        return found

    def numbers(self, path: Path) -> Array:
        """A number, or numbers in lists of equal lengths, as an array."""
        value = self.get(path)
        try:
            array = as_array(value)
        except (TypeError, ValueError):
            array = None
        except OverflowError:
            self.fail(path, "has a number beyond the range of floats: give at most 1e308")
        if array is None:
            self.fail(path, f"is {shown_value(value)}: give a number, or a list of numbers")
        return array

    def number(self, path: Path) -> float:
        """One number."""
        array = self.numbers(path)
        if array.ndim:
            self.fail(path, f"is {shown_value(self.get(path))}: give one number")
        return float(array)

    def text_at(self, path: Path, among: Mapping[str, object] | tuple[str, ...] | None = None) -> str:
        """A string, one of `among`."""
        value = self.get(path)
        if value is None:
            known = f", one of {', '.join(among)}" if among else ""
            self.fail(path[:-1], f"has no {path[-1]}: give its name in quotes{known}")
        if not isinstance(value, str):
            self.fail(path, f"is {shown_value(value)}: give a name in quotes")
        if among is not None and value not in among:
            known = ", ".join(among)
            self.fail(path, f"is {shown_value(value)}: {f'choose one of {known}' if known else 'none is defined yet'}")
        return value

    def texts(self, path: Path) -> list[str]:
        """A list of strings."""
        value = self.get(path)
        if not isinstance(value, list) or not value or not all(isinstance(entry, str) for entry in value):
            self.fail(path, f"is {shown_value(value)}: give a list of names in quotes")
        return value

    def names(self, path: Path) -> list[str]:
        """Keys of a table; none if it is not there."""
        found = self.get(path)
        if found is None:
            return []
        if not isinstance(found, dict):
            self.fail(
                path, f"is {shown_value(found)}: give a table of tables, such as [{'.'.join(map(str, path))}.name]"
            )
        return list(found)

    def count(self, path: Path) -> int:
        """Length of a list of tables; 0 if it is not there."""
        found = self.get(path)
        if found is None:
            return 0
        if not isinstance(found, list) or not all(isinstance(entry, dict) for entry in found):
            self.fail(path, f"is {shown_value(found)}: give a list of tables, [[{path[0]}]]")
        return len(found)


def shown_value(value: object) -> str:
    """A value as shown in a message, shortened if it is long."""
    try:
        text = " ".join(repr(value).split())
    except ValueError:  # Python does not print whole numbers of thousands of digits
        text = "a number of thousands of digits"
    return text if len(text) <= 80 else f"{text[:76]} ..."


def as_array(value: object) -> Array:
    """Numbers in nested lists as an array; the axes of entries that are arrays, a batch, come first."""
    if isinstance(value, np.ndarray):
        return value
    if isinstance(value, list):
        parts = [as_array(entry) for entry in value]
        if any(isinstance(entry, np.ndarray) for entry in _leaves(value)):
            return np.stack(np.broadcast_arrays(*parts), axis=-1 - _depth(value[0]))
        return np.array([part.tolist() for part in parts], dtype=np.float64)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise TypeError(value)
    return np.array(value, dtype=np.float64)


def _depth(value: object) -> int:
    return 1 + _depth(value[0]) if isinstance(value, list) else 0


def _leaves(value: object) -> Iterator[object]:
    if isinstance(value, list):
        for entry in value:
            yield from _leaves(entry)
    else:
        yield value
