"""Starting values for all poses, interpolated between the nodes of the path of the drives."""

from __future__ import annotations

from bisect import bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.lazily import cached_property
from ..kinematics.blocks import MEMBERS, blocks
from .interpolation import shares
from .predictor_corrector import RayPath


@dataclass(frozen=True, eq=False)
class PathNodes:
    """The nodes of a `Guide` as lists of floats."""

    s: list[float]
    states: list[list[float]]
    rates: list[list[float]]
    signs: list[list[float]]
    crossings: list[float]


@dataclass(frozen=True, eq=False)
class Guide:
    """The nodes of a path as arrays.

    Attributes
    ----------
    s
        Lengths along the path, rising, (nodes,).
    states, rates
        States and their derivatives by s, (nodes, n).
    determinants
        Of the blocks of equations, (nodes, blocks).
    crossings
        Lengths of the change points.
    low, high
        Ends of the path.
    """

    s: Array
    states: Array
    rates: Array
    determinants: Array
    crossings: Array
    low: float
    high: float

    @classmethod
    def of(cls, path: RayPath, back: RayPath | None = None) -> Guide:
        """Guide along a path; `back` goes the other way from the same start, to negative lengths."""
        nodes = [(node.s, 1.0, node) for node in path.nodes]
        crossings = list(path.crossings)
        low = 0.0
        if back is not None:
            nodes = [(-node.s, -1.0, node) for node in back.nodes[:0:-1]] + nodes
            crossings += [-s for s in back.crossings]
            low = -back.end
        return cls(
            np.array([s for s, _, _ in nodes]),
            np.array([node.pose.state for _, _, node in nodes]),
            np.array([sign * np.array(node.rate) for _, sign, node in nodes]),
            np.array([node.pose.determinants for _, _, node in nodes]).reshape(len(nodes), -1),
            np.array(sorted(crossings)),
            low,
            path.end,
        )

    def reached(self, s: Array) -> NDArray[np.bool_]:
        """Whether s lies within the ends of the path, (...)."""
        return (s >= self.low) & (s <= self.high)

    def at(self, s: Array) -> Array:
        """States (..., n) by the cubic between neighbouring nodes; beyond the ends, the state of the last node."""
        return np.stack(self.entries(s), axis=-1)

    def entries(self, s: Array) -> list[Array]:
        """As `at`, a list of the entries of the state, (...) each."""
        if len(self.s) == 1:
            return [np.broadcast_to(x, s.shape) for x in self.states[0]]
        states, rates = self._columns
        out = np.empty((len(states), *s.shape))
        for block in blocks(s.shape, max(MEMBERS // len(states), 1)):
            at = self._inside(s[block])
            k = self.before(at)
            after = k + 1
            begin = self.s[k]
            h = self.s[after] - begin
            p, q, u, v = shares((at - begin) / h, h)
            first, then = p * states.take(k, 1) + q * rates.take(k, 1), u * states.take(after, 1)
            out[:, *block] = first + (then + v * rates.take(after, 1))
        return list(out)

    @cached_property
    def _columns(self) -> tuple[Array, Array]:
        """States and rates, (n, nodes)."""
        return np.ascontiguousarray(self.states.T), np.ascontiguousarray(self.rates.T)

    def one(self, s: float) -> tuple[list[float], list[float]]:
        """State and signs of the determinants at one s, as by `at` and `signs_at`.

        The path must have that length, and no change point there.
        """
        nodes = self._floats
        k = min(max(bisect_right(nodes.s, s) - 1, 0), len(nodes.s) - 2)
        h = nodes.s[k + 1] - nodes.s[k]
        t = (s - nodes.s[k]) / h
        p, q, u, v = shares(t, h)
        ends = zip(nodes.states[k], nodes.rates[k], nodes.states[k + 1], nodes.rates[k + 1], strict=True)
        crossed = any(nodes.s[k] < where < s for where in nodes.crossings)
        return [(p * a + q * b) + (u * c + v * d) for a, b, c, d in ends], nodes.signs[k + 1 if crossed else k]

    @cached_property
    def _floats(self) -> PathNodes:
        signs: list[list[float]] = self._signs.tolist()
        return PathNodes(self.s.tolist(), self.states.tolist(), self.rates.tolist(), signs, self.crossings.tolist())

    @cached_property
    def _signs(self) -> Array:
        """Signs of the determinants, (nodes, blocks)."""
        signs: Array = np.sign(self.determinants)
        return signs

    def before(self, s: Array) -> NDArray[np.intp]:
        """Index of the node before each s, (...)."""
        k = self.s.searchsorted(s, side="right") - 1
        return np.maximum(np.minimum(k, len(self.s) - 2), 0)

    def _inside(self, s: Array) -> Array:
        """Each s, or the first or last node where it lies beyond."""
        inside: Array = np.minimum(np.maximum(s, self.s[0]), self.s[-1])
        return inside

    def signs_at(self, s: Array, near: float) -> list[Array]:
        """Signs of the determinants at s, (...) by block; 0 where a change point is within `near`."""
        signs = self._signs
        if not self.crossings.size and (signs == signs[0]).all():
            return [np.full(s.shape, sign) for sign in signs[0]]
        k = self.before(self._inside(s))
        out = [np.array(each[k]) for each in signs.T]
        for where in self.crossings:
            j = int(np.clip(np.searchsorted(self.s, where) - 1, 0, len(self.s) - 2))
            behind, beside = (k == j) & (s > where), np.abs(s - where) < near
            for each, sign in zip(out, signs[j + 1], strict=True):
                each[behind] = sign
                each[beside] = 0.0
        return out
