"""Relative motion in a joint: rotation and translation of its second link relative to the first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..description.joints import Kind
from .terms import Scalar, Vector, combine, minus, plus, times


@dataclass(frozen=True, eq=False)
class JointMotion:
    """Relative position of the two links of a joint.

    Attributes
    ----------
    shift
        Vector from the first point to the second, in the axes on the first link.
    rotations
        Successive rotations about the joint's own axes: axis 0 1 2, cosine and sine.
    spherical
        Columns of the rotation matrix of a spherical joint; None for other joints.
    """

    shift: Vector
    rotations: list[tuple[int, Scalar, Scalar]]
    spherical: list[Vector] | None = None

    def rotated(self, first: Sequence[Vector]) -> list[Vector]:
        """Axes on the second link from those on the first."""
        if self.spherical is not None:
            return [combine(first, column) for column in self.spherical]
        axes = list(first)
        for axis, cosine, sine in self.rotations:
            axes = _rotated(axes, axis, cosine, sine)
        return axes

    def rotated_back(self, second: Sequence[Vector]) -> list[Vector]:
        """Axes on the first link from those on the second."""
        if self.spherical is not None:
            return [combine(second, row) for row in zip(*self.spherical, strict=True)]
        axes = list(second)
        for axis, cosine, sine in reversed(self.rotations):
            axes = _rotated(axes, axis, cosine, -sine)
        return axes


def _rotated(axes: Sequence[Vector], axis: int, cosine: Scalar, sine: Scalar) -> list[Vector]:
    out = list(axes)
    x, y = (axis + 1) % 3, (axis + 2) % 3
    out[x] = plus(times(cosine, axes[x]), times(sine, axes[y]))
    out[y] = minus(times(cosine, axes[y]), times(sine, axes[x]))
    return out


def motion_at(kind: Kind, state: Sequence[Scalar], pitch: Scalar) -> JointMotion:
    """Relative position in a joint of this kind at `state`; `pitch` is the advance of a screw per radian."""
    shift: list[Scalar] = [0.0, 0.0, 0.0]
    if kind.name == "spherical":
        return JointMotion(shift, [], _euler(*state))
    if kind.tied:
        shift["xyz".index(kind.tied[1])] = pitch * state[0]
    rotations: list[tuple[int, Scalar, Scalar]] = []
    for component, value in zip(kind.coordinates, state, strict=True):
        axis = "xyz".index(component[1])
        if component[0] == "u":
            shift[axis] = value
        else:
            rotations.append((axis, np.cos(value), np.sin(value)))
    return JointMotion(shift, rotations)


def _euler(a: Scalar, b: Scalar, c: Scalar, d: Scalar) -> list[Vector]:
    """Columns of the rotation matrix of unit Euler parameters a b c d."""
    aa, bb, cc, dd = a * a, b * b, c * c, d * d
    return [
        [(aa + bb) - (cc + dd), 2.0 * (b * c + a * d), 2.0 * (b * d - a * c)],
        [2.0 * (b * c - a * d), (aa + cc) - (bb + dd), 2.0 * (c * d + a * b)],
        [2.0 * (b * d + a * c), 2.0 * (c * d - a * b), (aa + dd) - (bb + cc)],
    ]
