"""Newton-Euler equations of rigid bodies: the forces in their joints balance the loads and the inertia.

In space positions are (..., 3), and a wrench is a force and a moment, (..., 6). In a plane positions are (..., 2), and
a wrench is ``fx fy mz``, (..., 3). All axes before the last broadcast.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.arm import transferred
from ..framework.batch import Array, Shape


class Action(NamedTuple):
    """A load on a body: its name, a point (..., d), and the wrench (..., c) about that point, in global axes."""

    body: str
    place: Array
    wrench: Array


class Transmitted(NamedTuple):
    """Unit wrenches (..., n, c) about a point (..., d) that a joint exerts on its second body, reversed on its first.

    Bodies without equations, such as the ground, are not in the matrix.
    """

    first: str
    second: str
    place: Array
    wrenches: Array


class NewtonEuler:
    """Equations of equilibrium of rigid bodies, Eq. (3) and (4) of the accuracy paper.

    For each body the wrenches of its joints, its loads, its weight and its inertia about its centre of mass add up to
    zero.

    Parameters
    ----------
    centres
        Centres of mass of the bodies in global axes, (..., d), by name.
    joints
        Unit wrenches of joints and drives, which are the columns of the matrix.
    size
        Length by which moments are divided, (...), so that all coefficients are of order one.

    Attributes
    ----------
    units
        Divisor of each component of a wrench, (..., c): 1 for forces, `size` for moments.
    rows, columns
        Rows of the matrix for each body, by name, and its columns for each joint, in order.
    """

    def __init__(self, centres: Mapping[str, Array], joints: Sequence[Transmitted], size: ArrayLike = 1.0) -> None:
        self.centres, self.joints = centres, joints
        d = next(iter(centres.values())).shape[-1]
        count = 3 * (d - 1)
        self.units = np.where(np.arange(count) < d, 1.0, np.asarray(size)[..., None])
        self.rows = {body: slice(count * k, count * (k + 1)) for k, body in enumerate(centres)}
        ends = accumulate((joint.wrenches.shape[-2] for joint in joints), initial=0)
        self.columns = [slice(*pair) for pair in pairwise(ends)]

    @property
    def unknowns(self) -> int:
        """Number of unit wrenches in all joints."""
        return self.columns[-1].stop if self.columns else 0

    @cached_property
    def parts(self) -> list[tuple[slice, slice, Array]]:
        """Rows, columns and coefficients (..., c, n) of each joint in the equations of each of its bodies."""
        parts = []
        for joint, columns in zip(self.joints, self.columns, strict=True):
            for body, sign in ((joint.second, 1.0), (joint.first, -1.0)):
                if body in self.centres:
                    arm = (joint.place - self.centres[body])[..., None, :]
                    each = transferred(joint.wrenches, arm) / (sign * self.units[..., None, :])
                    parts.append((self.rows[body], columns, np.swapaxes(each, -1, -2)))
        return parts

    @property
    def matrix(self) -> Array:
        """Coefficients of the unknowns, (..., c bodies, unknowns)."""
        matrix = self._zeros(np.broadcast_shapes(*(part.shape[:-2] for _, _, part in self.parts)))
        for rows, columns, part in self.parts:
            matrix[..., rows, columns] = part
        return matrix

    @cached_property
    def places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Rows and columns of all coefficients that a joint can have in the equations of its bodies, (e,) each."""
        every = np.arange(max(self.units.shape[-1] * len(self.centres), self.unknowns))
        spans = [(every[rows], every[columns]) for rows, columns, _ in self.parts]
        none = every[:0]
        return (
            np.concatenate([none, *(np.repeat(rows, len(columns)) for rows, columns in spans)]),
            np.concatenate([none, *(np.concatenate([columns] * len(rows)) for rows, columns in spans)]),
        )

    def numbers(self, shape: Shape, entries: NDArray[np.int64]) -> Array:
        """Coefficients at those places, at k entries of the flattened batch of shape `shape`, (k, e)."""
        whole = shape or (1,)
        where = np.unravel_index(entries, whole)
        out, at = np.empty((len(entries), len(self.places[0]))), 0
        for _, _, part in self.parts:
            size = part.shape[-2] * part.shape[-1]
            chosen = part if part.ndim == 2 else np.broadcast_to(part, (*whole, *part.shape[-2:]))[where]
            out[:, at : at + size] = chosen.reshape(-1, size)
            at += size
        return out

    def balanced(self, actions: Iterable[Action]) -> Array:
        """Right-hand side of the equations, (..., c bodies): the negative sum of the loads on each body."""
        loads: dict[str, Array] = {}
        for body, place, wrench in actions:
            about = transferred(wrench, place - self.centres[body]) / self.units
            loads[body] = loads.get(body, np.zeros(())) - about
        shape = np.broadcast_shapes(*(load.shape for load in loads.values()))
        return np.concatenate([np.broadcast_to(loads[body], shape) for body in self.centres], axis=-1)

    def _zeros(self, shape: Shape) -> Array:
        return np.zeros((*shape, self.units.shape[-1] * len(self.centres), self.unknowns))
