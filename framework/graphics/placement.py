"""Where names and numbers stand in a figure: beside their places, clear of each other, of lines and of numbers of axes.

How wide a text is, and where it falls in a view in space, is known when the figure is drawn, and found anew each time.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array

# Directions and distances, points, that are tried, and room about a text, points.
DIRECTIONS, REACHES, ROOM = 16, (0.0, 6.0, 14.0, 24.0), 1.0
# What a place costs that covers another text, a number of the axes or the edge; that is nearer to another place than to
# its own; that covers a line, a joint; that is turned away from where it was wanted by half a turn; and that is a point
# of type further off.
COVERS, MISLEADS, CUTS, HIDES, TURNED, FURTHER = 12.0, 5.0, 4.0, 3.0, 2.0, 0.08
# From line to line of a text, in heights of one.
LINE = 1.6
# Up to so many texts are they moved out of each other's way.
MANY = 150


@dataclass(frozen=True, eq=False)
class PlacedText:
    """A text beside a place.

    Attributes
    ----------
    text
        Its words.
    at
        The place, (2,) or (3,) as the axes have it.
    way
        Direction in the figure in which it is to stand if there is room, (2,).
    clear
        Radius about the place that is taken, lengths of the axes.
    gap
        Room between that and the text, points.
    look
        How it looks.
    """

    text: str
    at: Array
    way: Array
    clear: float
    gap: float
    look: dict[str, Any]


@dataclass(eq=False)
class TextPlacement:
    """The texts of a scene on its axes.

    Attributes
    ----------
    axes
        Where they stand, in a plane or in space.
    lines
        Lines (k, 2) or (k, 3) of which they are to be clear.
    """

    axes: Any
    lines: list[Array]
    _texts: list[PlacedText] = field(default_factory=list)
    _centres: Array = field(default_factory=lambda: np.zeros((0, 2)))

    def write(self, texts: list[PlacedText]) -> list[Any]:
        """Add the texts to the axes, and give them as artists."""
        self._texts = texts
        return [
            self.axes.annotate(
                each.text, (0.0, 0.0), (0.0, 0.0), xycoords=_Centre(self, k), textcoords=_Centre(self, k), ha="center",
                va="center", parse_math=False, **each.look,
            )
            for k, each in enumerate(texts)
        ]  # fmt: skip

    def centre(self, number: int, renderer: Any) -> Array:
        """Middle of a text, pixels, (2,); all are placed when the first is asked for."""
        if number == 0 or not len(self._centres):
            self._centres = self._placed(renderer)
        return np.asarray(self._centres[number])

    def _placed(self, renderer: Any) -> Array:
        point = float(renderer.points_to_pixels(1.0))
        at = _seen(self.axes, np.array([each.at for each in self._texts]))
        sizes = np.array([self._size(each, renderer) for each in self._texts]) + 2.0 * ROOM * point
        taken = np.array([each.clear * self._pixels() + each.gap * point for each in self._texts])
        ways = np.array([np.arctan2(each.way[1], each.way[0]) for each in self._texts])
        turns = 2.0 * np.pi * np.arange(DIRECTIONS) / DIRECTIONS
        turns = np.concatenate([[0.0], *([turn, -turn] for turn in turns[1 : DIRECTIONS // 2]), [np.pi]])
        reaches = point * np.array(REACHES)
        if len(at) > MANY:
            return at + _shifts(ways, taken, sizes)
        own = TURNED * (np.abs(turns) / np.pi) + FURTHER * np.array(REACHES)[:, None]
        lines, edge = self._segments(), self.axes.figure.bbox.extents
        boxes = self._numbers(renderer)
        centres = np.empty_like(at)
        for k, place in enumerate(at):
            tried = place + _shifts(ways[k] + turns, (taken[k] + reaches)[:, None], sizes[k])
            low, high = tried - 0.5 * sizes[k], tried + 0.5 * sizes[k]
            cost = own + COVERS * _covers(low, high, boxes)
            cost += COVERS * ((low < edge[:2]) | (high > edge[2:])).any(axis=-1)
            cost += CUTS * np.minimum(_crossed(low, high, lines), 2)
            others = np.delete(at, k, axis=0)
            cost += HIDES * np.minimum(_covers(low, high, np.concatenate([others, others], axis=-1)), 2)
            away = np.linalg.norm(tried[..., None, :] - others, axis=-1).min(axis=-1, initial=np.inf)
            cost += MISLEADS * (away < np.linalg.norm(tried - place, axis=-1))
            best = np.unravel_index(int(cost.argmin()), cost.shape)
            centres[k] = tried[best]
            boxes = np.concatenate([boxes, [[*low[best], *high[best]]]])
        return centres

    def _size(self, text: PlacedText, renderer: Any) -> tuple[float, float]:
        from matplotlib.font_manager import FontProperties

        font, lines = FontProperties(size=text.look["fontsize"]), text.text.splitlines() or [""]
        sizes = [renderer.get_text_width_height_descent(line, font, False)[:2] for line in lines]
        width, height = np.max(sizes, axis=0)
        return float(width), float(height) * (1.0 + LINE * (len(lines) - 1))

    def _pixels(self) -> float:
        """Pixels to a length of the axes; nothing in space, where places are marked by their size on paper."""
        if getattr(self.axes, "name", "") == "3d":
            return 0.0
        return float(abs(self.axes.transData.get_matrix()[0, 0])) if self.axes.transData.is_affine else 0.0

    def _segments(self) -> Array:
        """Pieces of the lines, pixels, (n, 2, 2)."""
        seen = [_seen(self.axes, line) for line in self.lines]
        pieces = [np.stack([line[:-1], line[1:]], axis=1) for line in seen]
        found = np.concatenate([np.zeros((0, 2, 2)), *pieces])
        return np.asarray(found[np.isfinite(found).all(axis=(1, 2))])

    def _numbers(self, renderer: Any) -> Array:
        """Boxes of the numbers, labels and titles of the axes, (n, 4)."""
        from matplotlib.text import Text

        titles = [each for each in self.axes.get_children() if isinstance(each, Text) and each not in self.axes.texts]
        axis_names = ("xaxis", "yaxis", "zaxis") if hasattr(self.axes, "zaxis") else ("xaxis", "yaxis")
        written = [
            text
            for axis in (getattr(self.axes, name) for name in axis_names)
            for text in (*(tick.label1 for tick in axis.majorTicks), axis.label)
        ]
        told = [text for text in (*titles, *written) if text.get_visible() and text.get_text()]
        return np.array([text.get_window_extent(renderer).extents for text in told]).reshape(-1, 4)


@dataclass(frozen=True, eq=False)
class _Centre:
    """The coordinates of matplotlib whose origin is the middle of a text."""

    placement: TextPlacement
    number: int

    def __call__(self, renderer: Any) -> Any:
        from matplotlib.transforms import Affine2D

        return Affine2D().translate(*self.placement.centre(self.number, renderer))


def _seen(axes: Any, places: Array) -> Array:
    """Places (n, 2) or (n, 3) in pixels, (n, 2)."""
    flat = places
    if places.shape[-1] == 3:
        whole = np.concatenate([places, np.ones((len(places), 1))], axis=-1) @ axes.get_proj().T
        flat = whole[:, :2] / whole[:, 3:]
    return np.asarray(axes.transData.transform(flat), dtype=float)


def _shifts(angles: Array, taken: Array, size: Array) -> Array:
    """From a place to the middle of a box of that size (..., 2) that just stands off a circle about it, (..., 2)."""
    ways = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    with np.errstate(divide="ignore"):
        far = ((taken[..., None] + 0.5 * size) / np.abs(ways)).min(axis=-1)
    return np.asarray(far[..., None] * ways)


def _covers(low: Array, high: Array, boxes: Array) -> NDArray[np.int64]:
    """How many boxes (n, 4) each of the boxes between corners (..., 2) covers, (...)."""
    apart = (boxes[:, :2] >= high[..., None, :]) | (boxes[:, 2:] <= low[..., None, :])
    return np.asarray((~apart.any(axis=-1)).sum(axis=-1))


def _crossed(low: Array, high: Array, lines: Array) -> NDArray[np.int64]:
    """How many pieces of lines (n, 2, 2) run through each of the boxes between corners (..., 2), (...).

    A piece is cut to the box one way after the other (Liang and Barsky, ACM Trans. Graph. 3 (1984) 1-22).
    """
    first, last = low.reshape(-1, 2).min(axis=0), high.reshape(-1, 2).max(axis=0)
    near = ((lines.min(axis=1) <= last) & (lines.max(axis=1) >= first)).all(axis=-1)
    start, step = lines[near, 0], lines[near, 1] - lines[near, 0]
    along = np.where(step == 0.0, 1e-9, step)
    ends = np.sort([(low[..., None, :] - start) / along, (high[..., None, :] - start) / along], axis=0)
    enter = np.maximum(ends[0].max(axis=-1), 0.0)
    leave = np.minimum(ends[1].min(axis=-1), 1.0)
    return np.asarray((enter < leave).sum(axis=-1))
