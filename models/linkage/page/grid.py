"""Poses at all combinations of several drives, which a page moves separately."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, Shape, finite
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription


@dataclass(frozen=True, eq=False)
class GridAxis:
    """A drive with its values, radians or lengths, (n,)."""

    name: str
    turns: bool
    values: Array

    def table(self) -> dict[str, Any]:
        """The axis in the data of a page, with angles in degrees."""
        return {
            "name": self.name,
            "turns": self.turns,
            "values": np.degrees(self.values) if self.turns else self.values,
        }


def unfolded(
    linkage: LinkageDescription, drives: Mapping[str, ArrayLike], shape: Shape
) -> tuple[dict[str, Array], tuple[GridAxis, ...]]:
    """Values of the drives at all combinations, with one axis of poses, and the axes of the grid in their order.

    Parameters
    ----------
    linkage
        The linkage, without a batch of its own.
    drives
        Values of the drives by joint, which broadcast; each axis varies one drive, or several together.
    shape
        Shape of the motion.

    Raises
    ------
    FrameError
        If no drive varies along an axis, or a drive varies along several.
    """
    row: dict[str, Array] = {}
    along: dict[int, GridAxis] = {}
    for name, value in drives.items():
        coordinates = linkage.drives[name]
        array = finite(value, f"drive {name!r}")
        tail = array.shape[-1:] if len(coordinates) > 1 else ()
        full = np.broadcast_to(array, (*shape, *tail))
        row[name] = full.reshape(-1, *tail)
        one = full[..., 0] if tail else full
        varies = [k for k, n in enumerate(shape) if n > 1 and np.any(np.diff(one, axis=k))]
        if len(varies) > 1:
            raise FrameError(
                f"drive {name!r} varies along axes {varies} of the poses: give each drive values along one axis, "
                "such as (n, 1) and (m,)"
            )
        for axis in varies:
            values = np.moveaxis(one, axis, 0).reshape(shape[axis], -1)[:, 0]
            along.setdefault(axis, GridAxis(name, coordinates[0][0] == "r", values))
    missing = [k for k, n in enumerate(shape) if n > 1 and k not in along]
    if missing:
        raise FrameError(f"nothing varies along axis {missing[0]} of the poses {shape}: give a drive values along it")
    return row, tuple(along[k] for k in sorted(along))
