"""Frames that lie and are loaded in a coordinate plane: what leaves the plane stays zero and is not solved for."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..batch import Array

if TYPE_CHECKING:
    from .model import Model

# Displacement components in the planes across z, y and x: two translations and the rotation about the normal.
_PLANES = ((0, 1, 5), (0, 2, 4), (1, 2, 3))
WHOLE = (0, 1, 2, 3, 4, 5)


def plane(model: Model) -> tuple[int, ...]:
    """Components in which nodes move: three where frame, loads and given motions keep to a plane, else all six."""
    for kept in _PLANES:
        normal = kept[2] - 3
        left = [k for k in WHOLE if k not in kept]
        if all(_keeps(rows, normal) for rows in _axes(model)) and not any(v[left].any() for v in _vectors(model)):
            return kept
    return WHOLE


def _keeps(rows: Array, normal: int) -> bool:
    """Whether each of the axes (3, 3, ...), the rows, lies either along the normal or across it."""
    across = np.delete(rows, normal, axis=1)
    return not np.any((rows[:, normal] != 0.0) & (across != 0.0).any(axis=1))


def _axes(model: Model) -> list[Array]:
    """Axes of members and joints as rows."""
    out = [stack.level.array for stack in model.stacks]
    return out + [np.swapaxes(joint.axes.array, 0, 1) for joint in model.joints if joint.axes is not None]


def _vectors(model: Model) -> list[Array]:
    """Loads, given displacements and arms, as components (6, ...) in global axes."""
    out = [model.reach]
    out += [_at(k, target.array) for (node, k), target in model.targets.items() if model.plain[node]]
    for joint in model.joints:
        axes = np.eye(3) if joint.axes is None else joint.axes.array
        given = joint.offset.array
        turned = [np.einsum("ij...,j...->i...", _like(axes, part), part) for part in (given[:3], given[3:])]
        out.append(np.concatenate(turned))
        if joint.arm is not None:
            out.append(np.concatenate([joint.arm.array, np.zeros_like(joint.arm.array)]))
    for _, _, arm in model.hung:
        out.append(np.moveaxis(np.concatenate([arm, np.zeros_like(arm)], axis=-1), -1, 0))
    return out


def _at(k: int, value: Array) -> Array:
    out = np.zeros((6, *value.shape))
    out[k] = value
    return out


def _like(axes: Array, vector: Array) -> Array:
    """Axes (3, 3) or (3, 3, ...) with batch axes for a vector (3, ...)."""
    return axes.reshape(3, 3, *(1,) * (vector.ndim - 1)) if axes.ndim == 2 else axes
