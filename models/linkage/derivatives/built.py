"""How the place of a point depends on the inputs that a linkage is built of: an adjoint for all of them.

The derivatives by the numbers of the description come from one equilibrium of the rigid linkage, whose number does not
grow with that of the inputs. How these numbers depend on the inputs is told by describing the linkage anew of inputs
beside, which closes no loop and solves nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Protocol

import numpy as np

from ....framework.batch import Array
from ..description.parts import LinkageLink, Pair
from .position_sensitivity import PositionSensitivity


class DescribedNumbers(Protocol):
    """What is read of a linkage's description."""

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


Describe = Callable[..., DescribedNumbers]


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
    names, count = list(inputs), len(weight)
    rows = {name: np.tile(values, 2 * len(names)) for name, values in inputs.items()}
    for k, name in enumerate(names):
        for side in (0, 1):
            start = (2 * k + side) * count
            rows[name][start : start + count] = ends[name][side]
    described = describe(**rows)
    shape = (len(names), 2, count)
    total = np.zeros((len(names), count))
    for at, trailing, slope in _numbers(by, described, weight):
        spread = np.broadcast_to(at, (2 * len(names) * count, *at.shape[at.ndim - trailing :]))
        change = np.diff(spread.reshape(*shape, *spread.shape[1:]), axis=1)[:, 0]
        total += np.sum(change.reshape(*total.shape, -1) * slope.reshape(count, -1), axis=-1)
    for joint, pair in described.joints.items():
        axes = np.broadcast_to(pair.axes, (2 * len(names) * count, 3, 3)).reshape(*shape, 3, 3)
        total += np.sum(_turned(axes[:, 0], axes[:, 1]) * _by_axes(by, joint, weight), axis=-1)
    width = np.stack([ends[name][1] - ends[name][0] for name in names])
    return dict(zip(names, total / np.where(width > 0.0, width, 1.0), strict=True))


def _numbers(by: PositionSensitivity, described: DescribedNumbers, weight: Array) -> list[tuple[Array, int, Array]]:
    """What the description says of points, lengths, pitches and references, its trailing axes, and the slopes by it."""
    found = [(value, 1, _weighed(by.points[point], weight)) for point, value in described.points.items()]
    for name, link in described.links.items():
        if link.length is not None:
            found.append((link.length, 0, _weighed(by.lengths[name][..., None], weight)))
    for name, pair in described.joints.items():
        if pair.pitch is not None:
            found.append((pair.pitch, 0, _weighed(by.pitches[name][..., None], weight)))
        if name in described.drives:
            # A drive has gone from its reference to its value.
            own = [pair.kind.coordinates.index(component) for component in described.drives[name]]
            found.append((pair.reference[..., own], 1, -_weighed(by.drives[name], weight)))
    return found


def _weighed(derivative: Array, weight: Array) -> Array:
    """Derivatives (m, n) of the weighted sum, from those of all components, (m, 6, n)."""
    return np.asarray(np.einsum("mi,min->mn", weight, derivative[..., :3, :]))


def _by_axes(by: PositionSensitivity, joint: str, weight: Array) -> Array:
    """Derivatives (m, 3) by a rotation of the axes of a joint on both of its links."""
    pair = by.linkage.joint(joint)
    return _weighed(by.axes[pair.first, joint] + by.axes[pair.second, joint], weight)


def _turned(before: Array, after: Array) -> Array:
    """Small rotation vectors (..., 3) from axes (..., 3, 3) to others."""
    turn = (after - before) @ np.swapaxes(0.5 * (before + after), -1, -2)
    skew = 0.5 * (turn - np.swapaxes(turn, -1, -2))
    return np.stack([skew[..., 2, 1], skew[..., 0, 2], skew[..., 1, 0]], axis=-1)
