"""First guesses for all poses: from nodes along the way of the drives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .march import Node, Track


@dataclass(frozen=True, eq=False)
class Guide:
    """The nodes of a way as arrays.

    Attributes
    ----------
    s
        Lengths along the way, rising, (nodes,).
    states, rates
        States and their derivatives by s, (nodes, n).
    signs
        Signs of the determinants, (nodes, blocks).
    crossings
        Lengths of the change points.
    low, high
        What was reached.
    sure_from, sure_to
        What was reached without leaving the branch of the drawing.
    """

    s: Array
    states: Array
    rates: Array
    signs: Array
    crossings: Array
    low: float
    high: float
    sure_from: float
    sure_to: float

    @classmethod
    def of(cls, track: Track, back: Track | None = None) -> Guide:
        """Guide along a track; `back` goes the other way from the same start, to negative lengths."""
        nodes = [(node.s, 1.0, node) for node in track.nodes]
        crossings = list(track.crossings)
        low = 0.0
        if back is not None:
            nodes = [(-node.s, -1.0, node) for node in back.nodes[:0:-1]] + nodes
            crossings += [-s for s in back.crossings]
            low = -back.end
        return cls(
            np.array([s for s, _, _ in nodes]),
            np.array([node.pose.state for _, _, node in nodes]),
            np.array([sign * np.array(node.rate) for _, sign, node in nodes]),
            np.array([_signs(node) for _, _, node in nodes]).reshape(len(nodes), -1),
            np.array(sorted(crossings)),
            low,
            track.end,
            -min(back.doubts, default=np.inf) if back is not None else -np.inf,
            min(track.doubts, default=np.inf),
        )

    def reached(self, s: Array) -> NDArray[np.bool_]:
        """Whether the way got as far as s."""
        return (s >= self.low) & (s <= self.high)

    def sure(self, s: Array) -> NDArray[np.bool_]:
        """Whether s lies on the branch of the drawing for certain."""
        return (s >= self.sure_from) & (s <= self.sure_to)

    def at(self, s: Array) -> Array:
        """States (..., n) by the cubic through the neighbouring nodes; outside, that of the last node."""
        if len(self.s) == 1:
            return np.broadcast_to(self.states[0], (*np.shape(s), self.states.shape[1]))
        s = np.clip(s, self.s[0], self.s[-1])
        k, t, h = self._place(s)
        tt, back = t * t, (1.0 - t) ** 2
        out: Array = (1.0 + 2.0 * t) * back * self.states[k] + t * back * h * self.rates[k]
        out += tt * (3.0 - 2.0 * t) * self.states[k + 1] + tt * (t - 1.0) * h * self.rates[k + 1]
        return out

    def _place(self, s: Array) -> tuple[NDArray[np.intp], Array, Array]:
        k = np.clip(np.searchsorted(self.s, s, side="right") - 1, 0, len(self.s) - 2)
        h = (self.s[k + 1] - self.s[k])[..., None]
        return k, (s - self.s[k])[..., None] / h, h

    def signs_at(self, s: Array, near: float) -> Array:
        """Signs of the determinants at s, (..., blocks); 0 where a change point is within `near`."""
        if len(self.s) == 1:
            return np.broadcast_to(self.signs[0], (*np.shape(s), self.signs.shape[1]))
        k, _, _ = self._place(np.clip(s, self.s[0], self.s[-1]))
        out = self.signs[k].copy()
        for where in self.crossings:
            j = int(np.clip(np.searchsorted(self.s, where) - 1, 0, len(self.s) - 2))
            behind = (k == j) & (s > where)
            out[behind] = self.signs[j + 1]
            out[np.abs(s - where) < near] = 0.0
        return out


def _signs(node: Node) -> list[float]:
    return [float(np.sign(value)) for value in node.pose.determinants]
