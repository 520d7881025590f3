"""What a joint does between its two links: how it turns and shifts the second relative to the first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .terms import Scalar, Vector, combine, minus, plus, times


@dataclass(frozen=True, eq=False)
class TurnStep:
    """Relative position of a joint's links.

    Attributes
    ----------
    shift
        Second point less first, in the axes on the first link.
    turns
        Turns about own axes one after the other: axis 0 1 2, cosine and sine.
    ball
        Columns of the rotation of a ball; None for other joints.
    """

    shift: Vector
    turns: list[tuple[int, Scalar, Scalar]]
    ball: list[Vector] | None = None

    def turned(self, first: Sequence[Vector]) -> list[Vector]:
        """Axes on the second link from those on the first."""
        if self.ball is not None:
            return [combine(first, column) for column in self.ball]
        axes = list(first)
        for axis, cosine, sine in self.turns:
            axes = _turned(axes, axis, cosine, sine)
        return axes

    def turned_back(self, second: Sequence[Vector]) -> list[Vector]:
        """Axes on the first link from those on the second."""
        if self.ball is not None:
            return [combine(second, row) for row in zip(*self.ball, strict=True)]
        axes = list(second)
        for axis, cosine, sine in reversed(self.turns):
            axes = _turned(axes, axis, cosine, -sine)
        return axes


def _turned(axes: Sequence[Vector], axis: int, cosine: Scalar, sine: Scalar) -> list[Vector]:
    out = list(axes)
    x, y = (axis + 1) % 3, (axis + 2) % 3
    out[x] = plus(times(cosine, axes[x]), times(sine, axes[y]))
    out[y] = minus(times(cosine, axes[y]), times(sine, axes[x]))
    return out


def moved(kind: str, state: Sequence[Scalar], pitch: Scalar) -> TurnStep:
    """What a joint of this kind does at `state`; `pitch` is the advance of a screw per radian."""

    def turn(axis: int, angle: Scalar) -> tuple[int, Scalar, Scalar]:
        return axis, np.cos(angle), np.sin(angle)

    still: Vector = [0.0, 0.0, 0.0]
    if kind == "revolute":
        return TurnStep(still, [turn(2, state[0])])
    if kind == "prismatic":
        return TurnStep([0.0, 0.0, state[0]], [])
    if kind == "cylindrical":
        return TurnStep([0.0, 0.0, state[0]], [turn(2, state[1])])
    if kind == "universal":
        return TurnStep(still, [turn(2, state[0]), turn(0, state[1])])
    if kind == "planar":
        return TurnStep([state[0], state[1], 0.0], [turn(2, state[2])])
    if kind == "screw":
        return TurnStep([0.0, 0.0, pitch * state[0]], [turn(2, state[0])])
    if kind == "spherical":
        return TurnStep(still, [], _euler(*state))
    return TurnStep(still, [])


def _euler(a: Scalar, b: Scalar, c: Scalar, d: Scalar) -> list[Vector]:
    """Columns of the rotation with unit Euler parameters a b c d."""
    aa, bb, cc, dd = a * a, b * b, c * c, d * d
    return [
        [(aa + bb) - (cc + dd), 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)],
        [2.0 * (b * c - a * d), (aa + cc) - (bb + dd), 2.0 * (c * d + a * b)],
        [2.0 * (b * d + a * c), 2.0 * (c * d - a * b), (aa + dd) - (bb + cc)],
    ]
