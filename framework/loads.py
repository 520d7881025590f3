"""Loads on members: plain data, and the point forces by which they are integrated exactly."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from .added_forms import FormLoad
from .batch import Array, aligned, rotated

# Field metadata of arrays whose last axis is no batch axis.
_VECTORS = {"trailing": 1}

# Returns fractions and weights (points, ...) of the quadrature between two distances (...) from the member's start.
Rule = Callable[[Array, Array], tuple[Array, Array]]


@dataclass(frozen=True)
class LineLoad:
    """Force per length, linear from `start` (..., 3) to `end` (..., 3) over `span` (x1, x2); None: the whole member.

    With `start_bow` and `end_bow` (..., 3) it is cubic: at the fraction s of the span, ``s (1 - s)`` times the linear
    interpolation between these two is added.
    """

    start: Array = field(metadata=_VECTORS)
    end: Array = field(metadata=_VECTORS)
    span: tuple[float, float] | None
    local: bool
    start_bow: Array | None = field(default=None, metadata=_VECTORS)
    end_bow: Array | None = field(default=None, metadata=_VECTORS)

    @classmethod
    def through(cls, values: Sequence[Array]) -> LineLoad:
        """The cubic over the whole member through four forces per length (..., 3), global, at 0, 1/3, 2/3 and 1."""
        start, first, second, end = values
        near, far = 4.5 * first - 3.0 * start - 1.5 * end, 4.5 * second - 1.5 * start - 3.0 * end
        return cls(start, end, None, local=False, start_bow=2.0 * near - far, end_bow=2.0 * far - near)

    @property
    def parts(self) -> dict[str, Array]:
        """Its vectors by name, (..., 3) each."""
        named = {"start": self.start, "end": self.end, "start_bow": self.start_bow, "end_bow": self.end_bow}
        return {name: vectors for name, vectors in named.items() if vectors is not None}

    @property
    def forces(self) -> tuple[Array, ...]:
        """What may vary over the batch, (..., 3) each."""
        return tuple(self.parts.values())

    @property
    def places(self) -> tuple[float, ...]:
        """Distances from the member's start at which it begins and ends; none where it acts on the whole member."""
        return () if self.span is None else self.span

    def in_axes(self, local_axes: Array) -> LineLoad:
        """Its components in the local axes (..., 3, 3), given as rows."""
        if self.local:
            return self
        ndim = local_axes.ndim - 2
        own = {name: rotated(local_axes, aligned(vectors, ndim, 1)) for name, vectors in self.parts.items()}
        return LineLoad(span=self.span, local=True, **own)

    def clipped(self, lower: Array, upper: Array, length: Array) -> tuple[Array, Array]:
        """Ends of the loaded stretch within `lower` ... `upper`, as distances from the member's start, (...)."""
        x1, x2 = (0.0 * length, length) if self.span is None else (np.asarray(self.span[0]), np.asarray(self.span[1]))
        return np.clip(x1, lower, upper), np.clip(x2, lower, upper)

    def points(self, lower: Array, upper: Array, length: Array, rule: Rule) -> list[tuple[Array, Array]]:
        """Quadrature of the load between `lower` and `upper`: distances from the member's start and forces (..., 6)."""
        x1, x2 = (0.0 * length, length) if self.span is None else (np.asarray(self.span[0]), np.asarray(self.span[1]))
        a, b = self.clipped(lower, upper, length)
        stretch = b - a
        out = []
        for point, weight in zip(*rule(a, b), strict=True):
            x = a + stretch * point
            share = ((x - x1) / (x2 - x1))[..., None]
            per_length = self.start * (1.0 - share) + self.end * share
            if self.start_bow is not None and self.end_bow is not None:
                bow = self.start_bow * (1.0 - share) + self.end_bow * share
                per_length = per_length + share * (1.0 - share) * bow
            force = (weight * stretch)[..., None] * per_length
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

    @property
    def places(self) -> tuple[float, ...]:
        """Distance from the member's start at which it acts."""
        return (self.at,)

    def in_axes(self, local_axes: Array) -> PointLoad:
        """Its components in the local axes (..., 3, 3), given as rows."""
        if self.local:
            return self
        return replace(self, force=rotated(local_axes, aligned(self.force, local_axes.ndim - 2, 1)), local=True)

    def points(self, lower: Array, upper: Array, length: Array, rule: Rule) -> list[tuple[Array, Array]]:
        """The load itself where `at` lies between `lower` and `upper`, the member's end included; else nothing."""
        inside = (lower <= self.at) & ((self.at < upper) | (upper >= length))
        return [(np.clip(self.at, lower, upper), np.where(np.asarray(inside)[..., None], self.force, 0.0))]


MemberLoad = LineLoad | PointLoad | FormLoad
