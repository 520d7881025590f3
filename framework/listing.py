"""Short tables and counts by which objects are shown in a terminal and in a notebook."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

import numpy as np

from .states import State, States

# Rows that a table shows before it says how many more there are.
MOST = 12


class Explanation(str):
    """A text of several lines, which a notebook shows as such."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return f"<pre>{escape(self)}</pre>"


def counted(states: States, kind: type[State]) -> str:
    """How often each state occurs, such as ``35 regular, 2 mechanism``.

    Parameters
    ----------
    states
        Numbers of the states, (...).
    kind
        Class of the states.
    """
    numbers, times = np.unique(np.asarray(states), return_counts=True)
    return ", ".join(f"{count} {kind(number).text}" for number, count in zip(numbers, times, strict=True)) or "none"


def number(value: float) -> str:
    """A number to four digits; a dash where there is none."""
    return "–" if value != value else f"{value:.4g}"


def cut(rows: Sequence[Sequence[str]], most: int = MOST) -> list[list[str]]:
    """The first rows, and one that says how many more there are."""
    shown = [list(row) for row in rows[:most]]
    if len(rows) > most:
        shown.append([f"... {len(rows) - most} more", *[""] * (len(rows[0]) - 1)])
    return shown


def text_table(title: str, heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A title and a table with names to the left and numbers to the right.

    Parameters
    ----------
    title
        The first line.
    heading
        Of each column.
    rows
        Cells; those beyond `MOST` rows are counted only.
    """
    lines = [list(heading), *cut(rows)]
    widths = [max(len(line[k]) for line in lines) for k in range(len(heading))]
    aligned = [
        "  ".join([line[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(line[1:], widths[1:], strict=True))]).rstrip()
        for line in lines
    ]
    return "\n".join([title, *(f"  {line}" for line in aligned)])


def html_table(title: str, heading: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """The same for a notebook.

    Parameters
    ----------
    title, heading, rows
        As for `text_table`.
    """
    head = "".join(f"<th>{escape(cell)}</th>" for cell in heading)
    body = "".join(
        "<tr>"
        + "".join(
            f"<td style='text-align:{'right' if k else 'left'}'>{escape(cell)}</td>" for k, cell in enumerate(row)
        )
        + "</tr>"
        for row in cut(rows)
    )
    return f"<p>{escape(title)}</p><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"
