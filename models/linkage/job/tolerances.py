"""Tolerances in a file: numbers of it that are drawn from a distribution."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..files.source import Source

if TYPE_CHECKING:
    from ...sampling import Distribution


@dataclass(frozen=True, eq=False)
class Tolerance:
    """Numbers of the file that share one random draw.

    Attributes
    ----------
    of
        Where they stand in the file.
    law
        Their distribution.
    told
        The law in words.
    """

    of: tuple[tuple[str | int, ...], ...]
    law: Distribution
    told: str


def tolerance(source: Source, name: str) -> Tolerance:
    """Read and check one of the file's tolerances."""
    from scipy import stats

    path = ("tolerances", name)
    found = source.get(path)
    if not isinstance(found, dict) or "of" not in found or "law" not in found:
        source.fail(path, "give a table with of, law and the law's numbers")
    law = source.text_at((*path, "law"))
    kind = getattr(stats, law, None)
    if not isinstance(kind, stats.rv_continuous):
        source.fail(
            (*path, "law"), f"is {law!r}: give a continuous distribution of scipy.stats, such as norm or uniform"
        )
    numbers = {key: float(source.numbers((*path, key))) for key in found if key not in ("of", "law")}
    try:
        frozen: Distribution = kind(**numbers)
        middle = float(frozen.ppf(np.float64(0.5)))  # type: ignore[arg-type]
    except (TypeError, ValueError) as error:
        source.fail(path, f"{law} does not take {', '.join(numbers) or 'nothing'}: {error}")
    if not np.isfinite(middle):
        source.fail(path, f"{law} with {numbers} is no distribution: check its numbers")
    told = f"{law}({', '.join(f'{key}={value:g}' for key, value in numbers.items())})"
    paths = tuple(_place(source, path, index, text) for index, text in enumerate(source.texts((*path, "of"))))
    return Tolerance(paths, frozen, told)


def _place(source: Source, path: tuple[str, str], index: int, text: str) -> tuple[str | int, ...]:
    """Where a tolerance applies, such as ``joints.B.clearance`` or ``loads.0.fy``."""
    try:
        here: Any = tomllib.loads(f"{text} = 0")
    except tomllib.TOMLDecodeError:
        source.fail((*path, "of", index), f"{text!r} is no key: give one such as joints.B.clearance")
    keys: list[str | int] = []
    while isinstance(here, dict):
        key, here = next(iter(here.items()))
        keys.append(int(key) if isinstance(source.get(tuple(keys)), list) and key.isdecimal() else key)
    value = source.get(tuple(keys))
    try:
        put(value, np.zeros(1))
    except FrameError:
        source.fail((*path, "of", index), f"{text!r} is {value!r} in this file: name a number, or a list of numbers")
    if keys[0] in ("run", "tolerances"):
        source.fail((*path, "of", index), f"{text!r} is no part of the linkage")
    return tuple(keys)


def put(value: object, samples: Array) -> object:
    """Samples in place of a number; in a list in place of all its numbers but zeros and infinite ones."""
    if isinstance(value, list):
        return [entry if entry == 0.0 or not np.all(np.isfinite(entry)) else put(entry, samples) for entry in value]
    if isinstance(value, bool) or not isinstance(value, int | float | np.ndarray):
        raise FrameError("not a number")
    return samples
