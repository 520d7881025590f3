"""Derivatives of the position of a point by the inputs from which a function builds the linkage, by the adjoint method.

One equilibrium of the rigid linkage gives the derivatives by all numbers of the description, however many inputs there
are. How these numbers depend on the inputs is found by describing the linkage with each input a little below and above
its value, which closes no loop and solves nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from ....framework.batch import Array
from ..description.parts import LinkageLink, Load, Pair
from .position_sensitivity import PositionSensitivity


class DescribedNumbers(Protocol):
    """The part of a linkage's description that is read here."""

    @property
    def points(self) -> Mapping[str, Array]:
        """Points in the reference configuration, (..., 3)."""

    @property
    def links(self) -> Mapping[str, LinkageLink]:
        """Links by name."""

    @property
    def joints(self) -> Mapping[str, Pair]:
        """Joints by name."""

    @property
    def drives(self) -> Mapping[str, tuple[str, ...]]:
        """Driven components by joint."""

    @property
    def loads(self) -> Sequence[Load]:
        """Forces and moments on links."""

    @property
    def weight(self) -> Array:
        """Acceleration of gravity, (..., 3)."""


Describe = Callable[..., DescribedNumbers]


@dataclass(frozen=True, eq=False)
class DescribedBeside:
    """A linkage described with each input a little below and above its value, for differences of its numbers.

    Attributes
    ----------
    description
        The linkage as one batch, (k 2 m,): for each of k inputs, its lower and upper value at each of m samples.
    names
        Names of the k inputs.
    widths
        Upper minus lower value of each input, (k, m).
    """

    description: DescribedNumbers
    names: tuple[str, ...]
    widths: Array

    @classmethod
    def of(
        cls, describe: Describe, inputs: Mapping[str, Array], ends: Mapping[str, tuple[Array, Array]]
    ) -> DescribedBeside:
        """Describe the linkage with inputs by name, (m,) each, and their lower and upper values; see `along_inputs`."""
        names = tuple(inputs)
        widths = np.stack([ends[name][1] - ends[name][0] for name in names])
        count = widths.shape[1]
        rows = {name: np.tile(values, 2 * len(names)) for name, values in inputs.items()}
        for k, name in enumerate(names):
            for side in (0, 1):
                start = (2 * k + side) * count
                rows[name][start : start + count] = ends[name][side]
        return cls(describe(**rows), names, widths)

    @property
    def rows(self) -> int:
        """Number of linkages in the batch, k 2 m."""
        return 2 * self.widths.size

    def sides(self, value: Array, trailing: int) -> tuple[Array, Array]:
        """Values of a number of the description at the lower and the upper inputs, (k, m, ...) each.

        `trailing` axes of `value` hold its components.
        """
        spread = np.broadcast_to(value, (self.rows, *value.shape[value.ndim - trailing :]))
        count, samples = self.widths.shape
        both = spread.reshape(count, 2, samples, *spread.shape[1:])
        return both[:, 0], both[:, 1]

    def changed(self, value: Array, trailing: int, slope: Array) -> Array:
        """Change of a result between lower and upper inputs, (k, m), through a number `value` of the description.

        `slope` (m, ...) are the derivatives of the result by the number.
        """
        below, above = self.sides(value, trailing)
        # equal values, infinite ones among them, do not change
        change = np.subtract(above, below, out=np.zeros(above.shape), where=above != below)
        return np.asarray(np.sum(change.reshape(*self.widths.shape, -1) * slope.reshape(len(slope), -1), axis=-1))

    def by_name(self, change: Array) -> dict[str, Array]:
        """Derivatives (m,) by each input, from changes (k, m)."""
        return dict(zip(self.names, change / np.where(self.widths > 0.0, self.widths, 1.0), strict=True))


def along_inputs(
    by: PositionSensitivity,
    weight: Array,
    describe: Describe,
    inputs: Mapping[str, Array],
    ends: Mapping[str, tuple[Array, Array]],
) -> dict[str, Array]:
    """Derivatives (m,) of a weighted sum of the components of a position, by each input.

    Parameters
    ----------
    by
        Derivatives of the position of the linkage built of the inputs, (m, 6, n).
    weight
        Weights of the components, (m, 3).
    describe
        Called with inputs by name, (n,) each, as keywords; returns the description of the linkage with them.
    inputs
        The inputs by name, (m,) each.
    ends
        By name the lower and the upper value, (m,) each, between which differences of the description are taken.
    """
    beside = DescribedBeside.of(describe, inputs, ends)
    return beside.by_name(moved_by_numbers(by, weight, beside) + _moved_by_axes(by, weight, beside))


def moved_by_numbers(by: PositionSensitivity, weight: Array, beside: DescribedBeside) -> Array:
    """Changes of the weighted sum of components through points, lengths, pitches and reference values, (k, m)."""
    found = [beside.changed(*each) for each in _numbers(by, beside.description, weight)]
    return np.asarray(np.sum(found, axis=0))


def _moved_by_axes(by: PositionSensitivity, weight: Array, beside: DescribedBeside) -> Array:
    """Changes of the weighted sum of components through the axes of joints, (k, m)."""
    joints = beside.description.joints
    found = [np.sum(_turned(*beside.sides(joints[name].axes, 2)) * _by_axes(by, name, weight), -1) for name in joints]
    return np.asarray(np.sum(found, axis=0))


def _numbers(by: PositionSensitivity, described: DescribedNumbers, weight: Array) -> list[tuple[Array, int, Array]]:
    """Points, lengths, pitches and reference values described, their trailing axes, and the derivatives by them."""
    found = [(value, 1, weighed(by.points[point], weight)) for point, value in described.points.items()]
    for name, link in described.links.items():
        if link.length is not None:
            found.append((link.length, 0, weighed(by.lengths[name][..., None], weight)))
    for name, pair in described.joints.items():
        if pair.pitch is not None:
            found.append((pair.pitch, 0, weighed(by.pitches[name][..., None], weight)))
        if name in described.drives:
            # a drive moves by its value minus its reference value
            own = pair.kind.places_of(described.drives[name])
            found.append((pair.reference[..., own], 1, -weighed(by.drives[name], weight)))
    return found


def weighed(derivative: Array, weight: Array) -> Array:
    """Derivatives (m, n) of the weighted sum from those of all components (m, 6, n)."""
    return np.asarray(np.einsum("mi,min->mn", weight, derivative[..., :3, :]))


def _by_axes(by: PositionSensitivity, joint: str, weight: Array) -> Array:
    """Derivatives (m, 3) by a rotation of the axes of a joint on both of its links."""
    pair = by.linkage.joint(joint)
    return weighed(by.axes[pair.first, joint] + by.axes[pair.second, joint], weight)


def _turned(before: Array, after: Array) -> Array:
    """Small rotation vectors (..., 3) from axes (..., 3, 3) to others."""
    turn = (after - before) @ np.swapaxes(0.5 * (before + after), -1, -2)
    skew = 0.5 * (turn - np.swapaxes(turn, -1, -2))
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
