"""Tables as comma-separated values, for a terminal, and in Markdown."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO


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
        the first column. The last column, in words, may go beyond. None for one table however wide.
    """
    columns = list(zip(*lines, strict=True))
    widths = [max(map(len, column)) for column in columns]
    tables = [_joined(columns, widths, numbers) for numbers in _parts(widths, len(columns[-1][0]), width)]
    return "\n\n".join(tables)


def _joined(columns: Sequence[Sequence[str]], widths: Sequence[int], numbers: Sequence[int]) -> str:
    """Some of the columns side by side; the last of all to the left."""
    last = len(columns) - 1
    cells = [columns[k] if k == last else [text.rjust(widths[k]) for text in columns[k]] for k in numbers]
    return "\n".join("  ".join(row) for row in zip(*cells, strict=True))


def _parts(widths: Sequence[int], last: int, width: int | None) -> list[list[int]]:
    """Numbers of the columns of each table; the last column counts with its heading alone."""
    parts = [[0]]
    for k in range(1, len(widths)):
        own = last if k == len(widths) - 1 else widths[k]
        used = sum(widths[n] + 2 for n in parts[-1])
        if width is not None and used + own > width and len(parts[-1]) > 1:
            parts.append([0])
        parts[-1].append(k)
    return parts


def markdown(heading: Sequence[str], rows: Iterable[Sequence[str]], left: int = 0) -> str:
    """A Markdown table, its first `left` columns aligned to the left and the others to the right."""
    ruler = [":--" if column < left else "--:" for column in range(len(heading))]
    return "\n".join(f"| {' | '.join(map(_cell, row))} |" for row in (heading, ruler, *rows))


def _cell(text: str) -> str:
    """A name may hold what ends a cell."""
    return " ".join(text.replace("|", "\\|").splitlines())


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
