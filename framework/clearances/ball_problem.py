"""Convex quadratic functions over a product of balls, and their minima, for a whole batch; see `ball_qp`.

Components come first and batch entries last. Every sum is made in an order that does not depend on the number of
entries, and without fused operations, so that arrays and a recorded program give the same bits.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property, reduce
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..elementwise import less, maximum, minimum, where, zeros

# A pivot that is no more than this share of its diagonal entry is raised to it.
ROUNDING = 1e-15
# Largest stiffness for forces of size one: squares and cubes of the resulting displacements must not underflow.
_STIFFEST = 1e100


@dataclass(frozen=True)
class Groups:
    """The components of each ball: `own` (n,) is the ball of each component, in ascending order."""

    own: NDArray[np.int64]

    @cached_property
    def count(self) -> int:
        """Number of balls."""
        return int(self.own[-1]) + 1

    @cached_property
    def bounds(self) -> list[tuple[int, int]]:
        """Index of the first component of each ball, and of the one after its last."""
        ends = np.searchsorted(self.own, np.arange(self.count + 1)).tolist()
        return list(pairwise(ends))

    def dot(self, a: Array, b: Array) -> Array:
        """Inner product of two vectors in each ball, (balls, ...)."""
        product = a * b
        out = np.empty((self.count, *product.shape[1:]), dtype=product.dtype)
        for ball, (start, end) in enumerate(self.bounds):
            out[ball] = product[start]
            for k in range(start + 1, end):
                out[ball] += product[k]
        return out

    def apart(self, x: Array) -> Array:
        """The parts of vectors (n, N) in each ball, zero elsewhere, (n, balls, N)."""
        out = zeros((len(x), self.count, *x.shape[1:]), x)
        for ball, (start, end) in enumerate(self.bounds):
            out[start:end, ball] = x[start:end]
        return out


@dataclass(frozen=True)
class Quadratic:
    """The quadratic functions of N entries, for forces of size one in balls of radius one.

    Attributes
    ----------
    groups
        The components of each ball.
    stiffness
        S, (n, n, N).
    largest
        Largest number in S, (N,).
    force
        f, (n, N).
    members
        Stiffness with which S is compared to see whether it is zero, (n, N).
    """

    groups: Groups
    stiffness: Array
    largest: Array
    force: Array
    members: Array

    def at(self, entries: NDArray[np.bool_]) -> Quadratic:
        """The functions of the entries in a mask (N,)."""
        force, members = self.force[:, entries], self.members[:, entries]
        return Quadratic(self.groups, self.stiffness[:, :, entries], self.largest[entries], force, members)

    def left(self, x: Array) -> Array:
        """``f - S x``."""
        return self.force - times(self.stiffness, x)

    def added(self, multiplier: Array) -> Array:
        """``S + λ``, (n, n, N)."""
        out = self.stiffness.copy()
        for i, ball in enumerate(self.groups.own):
            out[i, i] += multiplier[ball]
        return out

    def widened(self, multiplier: Array) -> Array:
        """``S + λ`` plus its rounding, so that it is regular, (n, n, N)."""
        return self.added(multiplier + 2.0 * ROUNDING * self.largest)


@dataclass(frozen=True)
class BallProblem:
    """The quadratic functions ``½ o·S o − f·o`` of N entries and the balls ``|o_j| ≤ r_j``.

    What does not vary over the entries may have a last axis of size one.

    Attributes
    ----------
    groups
        The components of each ball.
    stiffness
        S, (n, n, N).
    force
        f, (n, N).
    members
        Stiffness with which S is compared to see whether it is zero, (n, N).
    radius
        Radius of each ball, (balls, N).
    """

    groups: Groups
    stiffness: Array
    force: Array
    members: Array
    radius: Array

    def at(self, entries: NDArray[Any] | slice) -> BallProblem:
        """The problem of some entries, by mask, index or slice."""
        parts = (self.stiffness, self.force, self.members, self.radius)
        count = self.force.shape[-1]
        return BallProblem(self.groups, *(a[..., entries] if a.shape[-1] == count else a for a in parts))

    @property
    def largest(self) -> Array:
        """Largest number in S, (N,)."""
        out: Array = np.broadcast_to(_largest(self.stiffness), self.force.shape[-1:])
        return out

    def unbalanced(self, offset: Array, pressing: Array) -> Array:
        """Largest component in each ball of ``f - S o`` less the force on its sphere, 0 in balls of no radius."""
        own, normal = self.groups.own, offset / or_one(self.radius)[self.groups.own]
        rest = np.abs(self.force - times(self.stiffness, offset) - pressing[own] * normal)
        most = np.stack([reduce(maximum, rest[start:end]) for start, end in self.groups.bounds])
        return where(less(0.0, self.radius), most, 0.0)

    def scaled(self) -> tuple[Quadratic, Scaling]:
        """The functions for forces of size one in balls of radius one, and how their minimum is scaled back."""
        own = self.groups.own
        widest, strongest = or_one(reduce(maximum, self.radius)), or_one(reduce(maximum, np.abs(self.force)))
        scale = self.radius / widest
        by, stiffest = scale[own], _STIFFEST / or_one(_largest(self.stiffness))
        force = self.force / strongest * by
        size = or_one(reduce(maximum, np.abs(force)))
        ratio = minimum(widest / strongest, stiffest) / size
        stiffness = mirrored(self.stiffness * (by[:, None] * by * ratio))
        # a load so small that its ratio to the stiffness underflows is scaled up, as it closes no clearance
        share = minimum(strongest * stiffest / widest, 1.0)
        quadratic = Quadratic(
            self.groups, stiffness, _largest(stiffness), force / size, self.members * (by * by * ratio)
        )
        return quadratic, Scaling(self.radius, share, strongest * size / or_one(scale))


@dataclass(frozen=True)
class Minimum:
    """The minima of N entries.

    Attributes
    ----------
    offset
        Minimum o, (n, N).
    pressing
        Magnitude of ``f - S o`` in each ball whose sphere is active, 0 in the others, (balls, N).
    unbalanced
        Largest component in each ball of what is left of ``f - S o``, without its force on the sphere, (balls, N).
    found
        Whether Newton's method found the minimum, and it is unique, (N,).
    steps
        Number of steps, (N,).
    how
        How the steps were done, and why, in words.
    """

    offset: Array
    pressing: Array
    unbalanced: Array
    found: NDArray[np.bool_]
    steps: Array
    how: str = ""

    @property
    def arrays(self) -> tuple[Array, Array, Array, NDArray[np.bool_], Array]:
        """All numbers."""
        return self.offset, self.pressing, self.unbalanced, self.found, self.steps

    @classmethod
    def places(cls, components: int, balls: int, count: int, how: str = "") -> Minimum:
        """Arrays for so many components, balls and entries."""
        offset, pressing, unbalanced = (np.empty((rows, count)) for rows in (components, balls, balls))
        return cls(offset, pressing, unbalanced, np.empty(count, dtype=np.bool_), np.empty(count), how)

    def put(self, entries: NDArray[Any] | slice, other: Minimum) -> None:
        """Fill in the minima of some entries."""
        for whole, new in zip(self.arrays, other.arrays, strict=True):
            whole[..., entries] = new

    def shaped(self, shape: Shape, how: str) -> Minimum:
        """The minima of a batch of a shape, which was counted through."""
        offset, pressing, unbalanced = (each.reshape(len(each), *shape) for each in self.arrays[:3])
        return Minimum(offset, pressing, unbalanced, self.found.reshape(shape), self.steps.reshape(shape), how)


@dataclass(frozen=True)
class Scaling:
    """How a minimum for forces of size one in balls of radius one is scaled back.

    Attributes
    ----------
    radius
        Radius of each ball, (balls, N).
    share
        Factor of offsets in balls whose sphere is not touched, (N,).
    strength
        Factor of the multipliers, (balls, N).
    """

    radius: Array
    share: Array
    strength: Array

    def back(self, x: Array, multiplier: Array, own: NDArray[np.int64]) -> tuple[Array, Array]:
        """Offsets (n, N), and the force with which each journal presses on its sphere, (balls, N)."""
        factor = where(less(0.0, multiplier), self.radius, self.radius * self.share)
        return x * factor[own], multiplier * self.strength


def or_one(values: Array) -> Array:
    """`values`, with one in place of zeros."""
    return where(less(0.0, values), values, 1.0)


def times(matrix: Array, x: Array) -> Array:
    """Product of matrices (n, n, N) and vectors (n, N)."""
    return in_order(matrix[:, j] * x[j] for j in range(len(x)))


def in_order(terms: Iterable[Array]) -> Array:
    """Sum of arrays, one after the other."""
    first, *others = terms
    for each in others:
        first = first + each
    return first


def mirrored(matrix: Array) -> Array:
    """Matrices (n, n, N) with what is above the diagonal also below it, in place."""
    for k in range(len(matrix)):
        matrix[k + 1 :, k] = matrix[k, k + 1 :]
    return matrix


def _largest(stiffness: Array) -> Array:
    """Largest number in positive semidefinite matrices (n, n, N), which is on the diagonal, (N,)."""
    return reduce(maximum, [np.abs(stiffness[k, k]) for k in range(len(stiffness))])
