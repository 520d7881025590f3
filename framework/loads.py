"""Loads on members: plain data, and the point forces by which they are integrated exactly."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from .added_forms import FormLoad
from .batch import Array

# Of an array whose last axis is no batch axis.
_VECTORS = {"trailing": 1}


@dataclass(frozen=True)
class LineLoad:
    """Force per length, linear from `start` (..., 3) to `end` (..., 3) over `span` (x1, x2); None: the whole member."""

    start: Array = field(metadata=_VECTORS)
    end: Array = field(metadata=_VECTORS)
    span: tuple[float, float] | None
    local: bool

    @property
    def forces(self) -> tuple[Array, ...]:
        """What may vary over the batch, (..., 3) each."""
        return self.start, self.end

    def clipped(self, lower: Array, upper: Array, length: Array) -> tuple[Array, Array]:
        """Ends of the loaded stretch, measured from the start of the member, within `lower` ... `upper`."""
        x1, x2 = (0.0 * length, length) if self.span is None else (np.asarray(self.span[0]), np.asarray(self.span[1]))
        return np.clip(x1, lower, upper), np.clip(x2, lower, upper)

    def points(self, lower: Array, upper: Array, length: Array, count: int) -> list[tuple[Array, Array]]:
        """Distances from the member's start and `count` forces (..., 6) that stand for the load in between."""
        x1, x2 = (0.0 * length, length) if self.span is None else (np.asarray(self.span[0]), np.asarray(self.span[1]))
        a, b = self.clipped(lower, upper, length)
        half = (b - a) / 2.0
        out = []
        for point, weight in zip(*np.polynomial.legendre.leggauss(count), strict=True):
            x = a + half * (1.0 + point)
            share = ((x - x1) / (x2 - x1))[..., None]
            force = weight * half[..., None] * (self.start * (1.0 - share) + self.end * share)
            out.append((x, np.concatenate([force, np.zeros_like(force)], axis=-1)))
        return out


@dataclass(frozen=True)
class PointLoad:
    """Force and moment `force` (..., 6) at distance `at` from the member's start."""

    at: float
    force: Array = field(metadata=_VECTORS)
    local: bool

    @property
    def forces(self) -> tuple[Array, ...]:
        """What may vary over the batch, (..., 6)."""
        return (self.force,)

    def points(self, lower: Array, upper: Array, length: Array, count: int) -> list[tuple[Array, Array]]:
        """The load itself where `at` lies between `lower` and `upper`, the member's end included; else nothing."""
        inside = (lower <= self.at) & ((self.at < upper) | (upper >= length))
        return [(np.clip(self.at, lower, upper), np.where(np.asarray(inside)[..., None], self.force, 0.0))]


MemberLoad = LineLoad | PointLoad | FormLoad
