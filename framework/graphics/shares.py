"""Shares of many in one thing as ranked bars."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ..batch import Array
from .style import COLOURS, INK

# What tells the bars of one name apart in grey.
HATCHES = ("", "////", "....")


def draw_shares(
    axes: Any,
    names: Sequence[str],
    shares: Mapping[str, Array],
    most: int,
    errors: Mapping[str, Array] | None = None,
) -> None:
    """Draw ranked bars, the greatest above; those beyond `most` are one bar.

    Parameters
    ----------
    axes
        Of matplotlib.
    names
        Names of the k contributors.
    shares
        Shares in per cent, (k,), by what they are shares of; the first ranks them.
    most
        Number of bars.
    errors
        Standard errors of some of them, (k,), per cent.
    """
    first = np.nan_to_num(next(iter(shares.values())))
    order = sorted(range(len(names)), key=lambda k: (-first[k], names[k]))
    shown, left = order[:most], order[most:]
    text = [names[k] for k in shown] + ([f"{len(left)} others"] if left else [])
    place, high = np.arange(float(len(text))), 0.8 / len(shares)
    end = 0.0
    for number, (kind, values) in enumerate(shares.items()):
        long = np.append(values[shown], [np.sum(values[left])] if left else [])
        at = place + high * (number - 0.5 * (len(shares) - 1))
        error = None if errors is None or left else errors[kind][shown]
        axes.barh(
            at, long, high, color=COLOURS[number], ec="white", lw=0.6, hatch=HATCHES[number % len(HATCHES)], label=kind,
            xerr=error, error_kw={"lw": 0.8, "capsize": 2.0, "ecolor": INK},
        )  # fmt: skip
        beyond = long if error is None else long + error
        for x, y, value in zip(beyond, at, long, strict=True):
            told = f" {value:.3g} %".replace("-", "−")
            axes.text(max(x, 0.0), y, told, va="center", fontsize=7.0, color=INK, gid="share", clip_on=False)
        end = max(end, float(np.nanmax(beyond, initial=0.0)))
    axes.set_yticks(place, text, parse_math=False)
    axes.tick_params(axis="y", length=0.0)
    axes.invert_yaxis()
    # Room for the number beside the longest bar.
    axes.set_xlim(right=1.22 * end if end > 0.0 else 1.0)
    axes.set_xlabel("share [%]")
    axes.spines[["top", "right"]].set_visible(False)
    if len(shares) > 1:
        axes.legend(fontsize=7.5, frameon=False, loc="best")


def height_of_shares(count: int, most: int) -> float:
    """Height of a figure of ranked pairs of bars with its titles and labels, inches."""
    return 1.0 + 0.34 * min(count, most + 1)
