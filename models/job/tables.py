"""Tables as comma-separated values, for a terminal, and in Markdown."""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO
from textwrap import fill

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# A number below this share of those that it comes from is their rounding.
ROUNDING = 1e-12
# Separator of this run's numbers from others, and a non-breaking space.
BAR, HARD = "│", "\u00a0"


def separated(heading: Sequence[str], rows: Iterable[Sequence[float | str | None]]) -> str:
    """Comma-separated values at full precision; NaN and None stay empty."""
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heading)
    for row in rows:
        writer.writerow(["" if value is None or value != value else value for value in row])
    return text.getvalue()


def aligned(lines: Sequence[Sequence[str]], width: int | None = None) -> str:
    """Columns for a terminal, aligned to the right except for the last.

    Parameters
    ----------
    lines
        A heading and rows, as cells.
    width
        Largest number of characters in a line: a wider table is split into several, one below the other, which all
        start with the first column. Components of a vector stay together if they fit. The last column, of texts, may
        exceed the width. None for one table of any width.
    """
    columns = list(zip(*lines, strict=True))
    widths = [max(map(len, column)) for column in columns]
    heading = [column[0] for column in columns]
    tables = [_joined(columns, widths, numbers) for numbers in _parts(heading, widths, width)]
    return "\n\n".join(tables)


def _joined(columns: Sequence[Sequence[str]], widths: Sequence[int], numbers: Sequence[int]) -> str:
    """Lines of some of the columns; the last of all columns is aligned to the left."""
    last = len(columns) - 1
    cells = [columns[k] if k == last else [text.rjust(widths[k]) for text in columns[k]] for k in numbers]
    return "\n".join("  ".join(row) for row in zip(*cells, strict=True))


def _parts(heading: Sequence[str], widths: Sequence[int], width: int | None) -> list[list[int]]:
    """Indices of the columns of each table; the last counts with its heading only if it fits in no table."""
    whole = width is None or widths[0] + 2 + widths[-1] <= width
    counted = [*widths[:-1], widths[-1] if whole else len(heading[-1])]
    bar = heading.index(BAR) if BAR in heading else len(heading)
    parts = [[0]]

    def fits(used: Sequence[int], more: Sequence[int]) -> bool:
        return width is None or sum(counted[n] + 2 for n in (*used, *more)) - 2 <= width

    for family in _families(heading):
        # columns to the right of the bar have the bar before them in each table
        begun = [0, bar] if bar < family[0] < len(heading) - 1 else [0]
        if not fits(parts[-1], family) and fits(begun, family) and len(parts[-1]) > 1:
            parts.append(list(begun))
        for k in family:
            if not fits(parts[-1], [k]) and len(parts[-1]) > 1:
                parts.append(list(begun))
            parts[-1].append(k)
    return parts


def _families(heading: Sequence[str]) -> list[list[int]]:
    """Indices of columns that belong together, without the first: components of a vector, and a bar before them."""
    kinds = [re.sub(r"(^|_)[xyz]\b", "", name) for name in heading]
    families: list[list[int]] = []
    for k in range(1, len(heading)):
        if families and (kinds[k] == kinds[families[-1][-1]] or heading[k - 1] == BAR):
            families[-1].append(k)
        else:
            families.append([k])
    return families


def folded(text: str, width: int | None) -> str:
    """Sentences wrapped for a terminal of the given width; a paragraph of several lines is a table and stays."""
    if width is None:
        return text
    parts = (part if "\n" in part else _filled(part, width) for part in text.split("\n\n"))
    return "\n\n".join(parts)


def _filled(text: str, width: int) -> str:
    """One paragraph in lines, without breaks in numbers, names and units in brackets."""
    bound = re.sub(r"\[[^\]]*\]", lambda unit: unit[0].replace(" ", HARD), text)
    return fill(bound, width, break_long_words=False, break_on_hyphens=False).replace(HARD, " ")


def markdown(heading: Sequence[str], rows: Iterable[Sequence[str]], left: int = 0) -> str:
    """A Markdown table, its first `left` columns aligned to the left and the others to the right."""
    ruler = [":--" if column < left else "--:" for column in range(len(heading))]
    return "\n".join(f"| {' | '.join(map(_cell, row))} |" for row in (heading, ruler, *rows))


def _cell(text: str) -> str:
    """Content of a cell, with the characters escaped that would end it."""
    return " ".join(text.replace("|", "\\|").splitlines())


def without_rounding(values: Array, size: Array) -> Array:
    """Numbers as they are shown: zero where they are rounding beside the size of what they come from.

    Parameters
    ----------
    values
        Numbers, (...); NaN stays.
    size
        Greatest of the numbers from which they are computed, in their unit, what broadcasts to (...).
    """
    return np.where(np.abs(values) < ROUNDING * size, 0.0, values)


def readable(value: float | str | None, form: str) -> str:
    """A number as text, a dash for NaN, nothing for None."""
    if value is None:
        return ""
    return "–" if value != value else format(value, form)


def with_error(value: float, error: float, form: str) -> str:
    """A number with its standard error in brackets, in units of its last digit: 0.18654(8), 7.6(2)e-04.

    Parameters
    ----------
    value, error
        The number and its standard error; a dash for NaN.
    form
        Format of the number, of kind ``f`` or ``e``, which determines its digits.
    """
    text = readable(value, form)
    if value != value or error != error:
        return text
    mantissa, sign, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    if sign and error > abs(value):
        # if the error is larger than the number, it determines the power of ten
        exponent = f"{math.floor(math.log10(error)):+03d}"
        mantissa = format(value / 10.0 ** int(exponent), f"z.{decimals}f")
    units = error / 10.0 ** (int(exponent or 0) - decimals)
    return f"{mantissa}({'<1' if 0.0 < units < 0.5 else f'{units:.0f}'}){sign}{exponent}"


def spent(seconds: Mapping[str, float]) -> str:
    """Time of each stage and total time, in Markdown."""
    stages = [[name, f"{time:.2f}"] for name, time in seconds.items()]
    return markdown(["stage", "seconds"], [*stages, ["**all**", f"**{sum(seconds.values()):.2f}**"]], left=1)


def drawn_by(sampler: str) -> str:
    """The sampler in words; empty if it is random."""
    return {"lhs": " (Latin hypercube)", "sobol": " (Sobol sequence)", "halton": " (Halton sequence)"}.get(sampler, "")
