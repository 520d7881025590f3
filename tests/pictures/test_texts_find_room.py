"""Names, numbers and sizes of forces stand clear of each other and of the numbers of the axes, as they are drawn."""

from __future__ import annotations

from itertools import combinations, pairwise, product
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame
from linkframe.models.paper.drawing import draw_linkage

ROD = Beam(Circle(diameter=0.02), Material(E=210e9, nu=0.3))
COLUMN, PAGE = 85.0 / 25.4, 170.0 / 25.4


def chain(places: list[tuple[float, float, float]], names: str) -> Frame:
    """A chain of rods."""
    frame = Frame()
    for name, place in zip(names, places, strict=True):
        frame.node(name, place)
    for first, second in pairwise(names):
        frame.add(first + second, ROD, first, second)
    return frame


def portal() -> Frame:
    frame = chain([(0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (1, 1, 0)], "ABCDE")
    frame.fix("A")
    frame.fix("E")
    frame.load("C", fz=-100.0)
    frame.load("D", fy=50.0, fz=-20.0)
    return frame


def boxes(texts: list[Any]) -> list[Any]:
    return [text.get_window_extent() for text in texts if text.get_text()]


def overlap(one: Any, other: Any) -> bool:
    return bool(min(one.x1, other.x1) > max(one.x0, other.x0) and min(one.y1, other.y1) > max(one.y0, other.y0))


@pytest.mark.parametrize("width", [COLUMN, PAGE], ids=["column", "page"])
def test_names_in_space_touch_no_number(width: float) -> None:
    figure = plt.figure(figsize=(width, 0.82 * width), layout="constrained")
    axes: Any = portal().solve().plot(ax=figure.add_subplot(projection="3d"))
    figure.canvas.draw()
    numbers = boxes([tick.label1 for axis in (axes.xaxis, axes.yaxis, axes.zaxis) for tick in axis.majorTicks])
    texts = boxes(axes.texts)
    assert len(texts) == 7
    assert not any(overlap(*pair) for pair in (*combinations(texts, 2), *product(texts, numbers)))
    whole = boxes([axes.xaxis.label, axes.yaxis.label, axes.zaxis.label, *axes.texts])
    assert all(box.x0 >= 0.0 and box.x1 <= figure.bbox.x1 and box.y0 >= 0.0 for box in whole)


def test_names_of_one_place_and_a_force_beside_it() -> None:
    """The joints of a node that were displaced apart have a name each; the force there has room beside them."""
    frame = chain([(0, 0, 0), (1, 0, 0), (1.001, 0, 0), (1.002, 0.001, 0)], "ABCD")
    frame.fix("A")
    frame.load("C", fx=100.0)
    axes: Any = frame.solve().plot(ax=plt.figure(figsize=(COLUMN, 2.0), layout="constrained").add_subplot())
    axes.figure.canvas.draw()
    assert not any(overlap(*pair) for pair in combinations(boxes(axes.texts), 2))


def test_few_numbers_along_a_narrow_figure() -> None:
    frame = chain([(0, 0, 0), (0, 1, 0)], "AB")
    frame.fix("A")
    frame.load("B", fy=-10.0)
    axes: Any = frame.solve().plot(ax=plt.figure(figsize=(COLUMN, 2.0), layout="constrained").add_subplot(1, 2, 1))
    axes.figure.canvas.draw()
    inside = [tick.label1 for tick in axes.xaxis.get_major_ticks() if _within(axes.get_xlim(), tick.get_loc())]
    assert inside
    assert not any(overlap(*pair) for pair in combinations(boxes(inside), 2))


def _within(limits: tuple[float, float], place: float) -> bool:
    return limits[0] <= place <= limits[1]


def test_what_has_no_solution_is_drawn_where_it_was() -> None:
    """Nothing holds the rod along its guide, so that the search goes on and on; a plane frame stays plane."""
    sliding = chain([(0, 0, 0), (1, 0, 0)], "AB")
    sliding.fix("A", "uy", "uz", "rx", "ry", "rz")
    sliding.load("B", fx=5.0)
    lost = sliding.solve(large=True)
    axes: Any = lost.plot()
    assert str(lost.status) == "not converged"
    assert axes.get_title(loc="left").startswith("not converged: undeformed shape")
    (dot,) = (
        line for line in axes.lines if np.array_equal(line.get_xydata(), [[1.0, 0.0]]) and line.get_alpha() is None
    )
    assert dot.get_marker() == "o"
    sliding.set_load("B", fx=0.0, fy=5.0)
    assert sliding.solve().status == "statically consistent mechanism"
    assert getattr(sliding.solve().plot(), "name", "") == "rectilinear"


@pytest.mark.parametrize("theta", np.radians([30.0, 150.0, 200.0, 280.0, 330.0]))
def test_the_name_of_a_clamped_drive_stands_off_its_clamp(theta: float) -> None:
    """Figure 5 of the paper: A beside the block that holds the crank, a point of type off its edge at least."""
    way = np.array([np.cos(theta), np.sin(theta), 0.0])
    at = {"A": np.zeros(3), "B": 0.1 * way, "P": 0.1 * way + [0.1, 0, 0], "D": 0.1 * way + [0.2, 0, 0]}
    figure = draw_linkage({**at, "E": np.array([0.2, 0.0, 0.0])}, (0.0, 100.0), theta)
    figure.canvas.draw()
    (axes,) = figure.axes
    (name,) = (text for text in axes.texts if text.get_text() == "A")
    blocks = [patch.get_window_extent() for patch in axes.patches if patch.get_gid() == "support"]
    assert len(blocks) == 2
    box = name.get_window_extent().padded(figure.dpi / 72.0)
    assert not any(overlap(box, block) for block in blocks)
