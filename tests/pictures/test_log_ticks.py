"""Numbers along logarithmic axes are plain text, as mathematical text is turned off in figures."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
import pytest
from linkframe import Linkage, propagate
from linkframe.framework.graphics.log_ticks import log_ticks


@pytest.mark.parametrize(
    ("low", "high", "told"),
    [
        (1.2, 60.0, ["2", "5", "10", "20", "50"]),
        (0.05, 3.0, ["0.05", "0.1", "0.2", "0.5", "1", "2"]),
        (2e-9, 3e-6, ["10⁻⁸", "10⁻⁷", "10⁻⁶"]),
        (2e6, 9e7, ["2·10⁶", "5·10⁶", "10⁷", "2·10⁷", "5·10⁷"]),
    ],
)
def test_numbers_along_a_logarithmic_axis(low: float, high: float, told: list[str]) -> None:
    axes = plt.figure().add_subplot()
    axes.set(yscale="log", ylim=(low, high))
    log_ticks(axes.yaxis)
    axes.figure.canvas.draw()
    ticks = sorted((*axes.yaxis.get_major_ticks(), *axes.yaxis.get_minor_ticks()), key=lambda tick: tick.get_loc())
    assert [t.label1.get_text() for t in ticks if low <= t.get_loc() <= high and t.label1.get_text()] == told
    plt.close("all")


def test_no_figure_shows_the_commands_of_mathematical_text() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), P=(1, 0.8))
    linkage.link("upper", "A", "B")
    linkage.link("lower", "B", "P")
    linkage.revolute("A", "ground", "upper", drive=True)
    linkage.revolute("B", "upper", "lower", drive=True)
    row = np.linspace(0.2, 1.7, 8)
    found = propagate(lambda a: 2.0 * a, {"a": (1.0, 2.0)}, n=64, rng=0)
    for axes in (linkage.workspace("P", x=row, y=row).plot("condition"), found.plot("convergence")):
        axes.figure.canvas.draw()
        texts = [
            tick.label1 if each is part.xaxis else tick.label2
            for part in axes.figure.axes
            for each in (part.xaxis, part.yaxis)
            for tick in (*each.get_major_ticks(), *each.get_minor_ticks())
        ]
        assert not [text.get_text() for text in texts if "$" in text.get_text()]
    plt.close("all")
