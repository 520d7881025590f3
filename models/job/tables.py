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
# What stands between this run's numbers and others, and a space at which no line ends.
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
    """Columns for a terminal, aligned to the right but for the last.

    Parameters
    ----------
    lines
        A heading and rows, as cells.
    width
        Characters that a line may have: what is wider comes in several tables below each other, each beginning with
        the first column. Components of one vector stay together where they fit. The last column, in words, may go
        beyond where it must. None for one table however wide.
    """
    columns = list(zip(*lines, strict=True))
    widths = [max(map(len, column)) for column in columns]
    heading = [column[0] for column in columns]
    tables = [_joined(columns, widths, numbers) for numbers in _parts(heading, widths, width)]
    return "\n\n".join(tables)


def _joined(columns: Sequence[Sequence[str]], widths: Sequence[int], numbers: Sequence[int]) -> str:
    """Some of the columns side by side; the last of all to the left."""
    last = len(columns) - 1
    cells = [columns[k] if k == last else [text.rjust(widths[k]) for text in columns[k]] for k in numbers]
    return "\n".join("  ".join(row) for row in zip(*cells, strict=True))


def _parts(heading: Sequence[str], widths: Sequence[int], width: int | None) -> list[list[int]]:
    """Numbers of the columns of each table; the last counts with its heading alone where no table can hold it."""
    whole = width is None or widths[0] + 2 + widths[-1] <= width
    counted = [*widths[:-1], widths[-1] if whole else len(heading[-1])]
    bar = heading.index(BAR) if BAR in heading else len(heading)
    parts = [[0]]

    def fits(used: Sequence[int], more: Sequence[int]) -> bool:
        return width is None or sum(counted[n] + 2 for n in (*used, *more)) - 2 <= width

    for family in _families(heading):
        # What stands right of the bar has it before it in each table.
        begun = [0, bar] if bar < family[0] < len(heading) - 1 else [0]
        if not fits(parts[-1], family) and fits(begun, family) and len(parts[-1]) > 1:
            parts.append(list(begun))
        for k in family:
            if not fits(parts[-1], [k]) and len(parts[-1]) > 1:
                parts.append(list(begun))
            parts[-1].append(k)
    return parts


def _families(heading: Sequence[str]) -> list[list[int]]:
    """Numbers of columns that belong together, without the first: components of one vector, and a bar before them."""
    kinds = [re.sub(r"(^|_)[xyz]\b", "", name) for name in heading]
    families: list[list[int]] = []
    for k in range(1, len(heading)):
        if families and (kinds[k] == kinds[families[-1][-1]] or heading[k - 1] == BAR):
            families[-1].append(k)
        else:
            families.append([k])
    return families


def folded(text: str, width: int | None) -> str:
    """Sentences in lines for a terminal of that width; a paragraph that has several lines is a table, and stays."""
    if width is None:
        return text
    parts = (part if "\n" in part else _filled(part, width) for part in text.split("\n\n"))
    return "\n\n".join(parts)


def _filled(text: str, width: int) -> str:
    """One paragraph in lines; a number or name stays whole, as does a unit in brackets."""
    bound = re.sub(r"\[[^\]]*\]", lambda unit: unit[0].replace(" ", HARD), text)
    return fill(bound, width, break_long_words=False, break_on_hyphens=False).replace(HARD, " ")


def markdown(heading: Sequence[str], rows: Iterable[Sequence[str]], left: int = 0) -> str:
    """A Markdown table, its first `left` columns aligned to the left and the others to the right."""
    ruler = [":--" if column < left else "--:" for column in range(len(heading))]
    return "\n".join(f"| {' | '.join(map(_cell, row))} |" for row in (heading, ruler, *rows))


def _cell(text: str) -> str:
    """A name may hold what ends a cell."""
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
        Format of the number, which rules its digits: of kind ``f`` or ``e``.
    """
    text = readable(value, form)
    if value != value or error != error:
        return text
    mantissa, sign, exponent = text.partition("e")
    decimals = len(mantissa.partition(".")[2])
    if sign and error > abs(value):
        # The error is greater than the number, and gives the power of ten.
        exponent = f"{math.floor(math.log10(error)):+03d}"
        mantissa = format(value / 10.0 ** int(exponent), f"z.{decimals}f")
    units = error / 10.0 ** (int(exponent or 0) - decimals)
    return f"{mantissa}({'<1' if 0.0 < units < 0.5 else f'{units:.0f}'}){sign}{exponent}"


def spent(seconds: Mapping[str, float]) -> str:
    """Time that each stage took and all together, in Markdown."""
    stages = [[name, f"{time:.2f}"] for name, time in seconds.items()]
    return markdown(["stage", "seconds"], [*stages, ["**all**", f"**{sum(seconds.values()):.2f}**"]], left=1)


def drawn_by(sampler: str) -> str:
    """How samples are drawn, in words, where they are not random."""
    return {"lhs": " (Latin hypercube)", "sobol": " (Sobol sequence)", "halton": " (Halton sequence)"}.get(sampler, "")
