"""Where the journals of a frame rest, from the forces of the frame without clearances and its stiffness."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from ..description import Description
from .ball_qp import minimise_in_balls
from .contact import CLOSED, FREE, OPEN, UNRESOLVED
from .middle import free_motions

# A force below this share of the largest load or joint force is the rounding of none.
UNLOADED = 1e-12
# A joint's share of a free motion below which it does not take part.
_STILL = 1e-6
# Squares between these hold all digits of what was squared.
_LEAST, _LARGEST = 1e-280, 1e280
# Largest stiffness for loads of size one: squares and cubes of what these move against it have numbers.
_STIFFEST = 1e100
# Entries whose matrices are in memory at a time.
_MOST = 2**16
# Imbalance in the joints, relative to the largest load or joint force, beyond which a contact is not to be trusted.
_BALANCED = 1e-6


@dataclass(frozen=True)
class ClearanceComponents:
    """Components with clearance, all joints in a row: names of the joints, joint and joint component of each."""

    names: list[str]
    own: NDArray[np.int64]
    component: list[int]

    @property
    def starts(self) -> NDArray[np.int64]:
        """First component of each joint, (joints,)."""
        return np.searchsorted(self.own, np.arange(len(self.names)))

    @property
    def is_rotation(self) -> NDArray[np.bool_]:
        """Which components are rotations, whose forces are moments, (n,)."""
        return np.asarray(self.component) >= 3

    @property
    def pairs(self) -> list[tuple[str, int]]:
        """Name of the joint and joint component of each."""
        return [(self.names[j], k) for j, k in zip(self.own, self.component, strict=True)]

    def length(self, vectors: Array) -> Array:
        """Length of the vectors (n, ...) by joint, (joints, ...)."""
        with np.errstate(over="ignore", under="ignore"):
            square, ends = vectors * vectors, [*self.starts[1:], len(vectors)]
            square = np.stack([square[a:b].sum(axis=0) for a, b in zip(self.starts, ends, strict=True)])
        length: Array = np.sqrt(square)
        unsafe = np.asarray(~((square > _LEAST) & (square < _LARGEST)).all(axis=0))
        if unsafe.any():
            length[:, unsafe] = np.hypot.reduceat(np.abs(vectors[:, unsafe]), self.starts, axis=0)
        return length


@dataclass(frozen=True, eq=False)
class ContactState:
    """Where all journals are in contact.

    Attributes
    ----------
    components
        The components with clearance.
    stiffness
        S, fall of the forces for unit offsets, (n, n, ...); it may lack axes over which it does not vary.
    members
        Stiffness of the members, (n, ...), by which the softness of S is judged.
    found
        Forces without clearance, (n, ...).
    radius
        Clearance, (joints, ...).
    load
        Largest force and largest moment on a node, (2, ...).
    length_scale
        Length by which moments compare with forces, see `sizes`.
    rounding
        Share of the largest force below which one without clearance is rounding, that of joints, (joints, ...), or one.
    """

    components: ClearanceComponents
    stiffness: Array
    members: Array
    found: Array
    radius: Array
    load: Array
    length_scale: Array
    rounding: Array | float = UNLOADED

    @cached_property
    def scale(self) -> Array:
        """Largest load or joint force, a moment where they are rotations, (joints, ...)."""
        is_rotation, found = self.components.is_rotation, np.abs(self.found)
        force, moment = (
            np.maximum(load, found[which].max(axis=0, initial=0.0))
            for load, which in zip(self.load, (~is_rotation, is_rotation), strict=True)
        )
        # without a size there are no arms, by which one would make the other
        arm = self.length_scale
        both = (
            np.maximum(force, np.where(arm > 0.0, moment, 0.0) / _or_one(arm)),
            np.maximum(moment, force * arm),
        )
        scale: Array = np.stack(both)[is_rotation[self.components.starts].astype(np.int64)]
        return scale

    @cached_property
    def without_clearance(self) -> Array:
        """Forces without clearance, (n, ...), those of rounding alone set to zero."""
        loaded = self.components.length(self.found) > self.rounding * self.scale
        return self.found if loaded.all() else np.where(loaded[self.components.own], self.found, 0.0)

    @property
    def offset(self) -> Array:
        """Displacement within the clearance, (n, ...)."""
        return self._placed[0]

    @property
    def size(self) -> Array:
        """Contact force by joint, (joints, ...); rounding where there is none."""
        return self._placed[1]

    @cached_property
    def force(self) -> Array:
        """Contact force by component, (n, ...)."""
        if not self.stiffness.any():
            return self.without_clearance
        force: Array = self.without_clearance - np.einsum("ij...,j...->i...", self.stiffness, self.offset)
        return force

    @cached_property
    def state(self) -> NDArray[np.uint8]:
        """By joint: number of its state, closed, open, free or unresolved, (joints, ...)."""
        closed = self.size > UNLOADED * self.scale
        state = np.where(closed, np.uint8(CLOSED), np.uint8(OPEN))
        without_contact = ~closed & (self.radius > 0.0)
        some = np.asarray(without_contact.any(axis=0))
        if some.any():
            state[:, some] = np.where(self._free(without_contact[:, some], some), FREE, state[:, some])
        if not self.stiffness.any():
            return state
        normal = self.offset / np.where(self.radius > 0.0, self.radius, 1.0)[self.components.own]
        pressed = np.where(
            (closed & (self.radius > 0.0))[self.components.own], self.size[self.components.own] * normal, 0.0
        )
        unbalanced = np.where((self.radius > 0.0)[self.components.own], self.force - pressed, 0.0)
        # an offset is told in steps of the least number there is, each of which is a force
        step = np.abs(self.stiffness).sum(axis=1) * np.finfo(np.float64).smallest_subnormal
        wrong = ~(np.abs(unbalanced) <= _BALANCED * self.scale[self.components.own] + step).all(axis=0)
        return np.where(wrong, np.uint8(UNRESOLVED), state)

    @cached_property
    def _placed(self) -> tuple[Array, Array]:
        """Offset and size of the force: along the force where S vanishes, else where the energy is least."""
        own, radius = self.components.own, self.radius
        size = self.components.length(self.without_clearance)
        offset = radius[own] * (self.without_clearance / _or_one(size)[own])
        resisted = np.broadcast_to(np.any(self.stiffness != 0.0, axis=(0, 1)), self.without_clearance.shape[1:])
        for part in _parts(resisted):
            offset[:, part], size[:, part] = self._least(part)
        return offset, size

    def _least(self, part: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Offset (n, N) and size of the force (joints, N) of least energy, at some entries."""
        own, near, without_clearance = self.components.own, self.radius[:, part], self.without_clearance[:, part]
        stiffness = np.broadcast_to(self.stiffness, (len(own), *self.without_clearance.shape))[:, :, part]
        widest, strongest = (_or_one(np.abs(values).max(axis=0)) for values in (near, without_clearance))
        scale = (near / widest)[own]
        largest = _or_one(np.abs(stiffness).max(axis=(0, 1)))
        with np.errstate(over="ignore", under="ignore"):
            ratio = np.minimum(widest / strongest, _STIFFEST / largest)
            # a load that closes nothing, and whose share of the stiffness has no number, moves as much less
            share = strongest * (_STIFFEST / largest) / widest
        scaled = stiffness * (scale[:, None] * scale * ratio)
        members = np.broadcast_to(self.members, self.without_clearance.shape)[:, part] * (scale * scale * ratio)
        x, multiplier = minimise_in_balls(scaled, without_clearance / strongest * scale, own, members)
        x = np.where((multiplier > 0.0)[own], x, x * np.minimum(share, 1.0))
        offset = near[own] * x
        left = self.components.length(without_clearance - np.einsum("ijn,jn->in", stiffness, offset))
        return offset, np.where(near > 0.0, strongest * multiplier / _or_one(near / widest), left)

    def _free(self, without_contact: NDArray[np.bool_], some: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Which of the `without_contact` joints, (joints, N), take part in a motion that no force resists, at `some`
        entries."""
        own, count = self.components.own, len(self.components.own)
        shape = self.found.shape[1:]
        stiffness = np.broadcast_to(self.stiffness, (count, count, *shape))[:, :, some]
        members = np.broadcast_to(self.members, (count, *shape))[:, some]
        vectors, free = free_motions(stiffness, members, without_contact[own])
        part = np.where(free[:, None, :], np.abs(vectors), 0.0).max(axis=-1).T
        return (
            np.stack([(part[own == j] > _STILL).any(axis=0) for j in range(len(self.components.names))])
            & without_contact
        )


def sizes(frame: Description) -> Array:
    """Largest coordinate of a node, (...): that of each entry, so that none is judged by what others are like."""
    if math.prod(frame.shape) == 1:
        return np.asarray(frame.size)
    each = (np.abs(frame.position(node)).max(axis=-1) for node in frame.nodes)
    return aligned(reduce(np.maximum, each), len(frame.shape))


def _or_one(values: Array) -> Array:
    """`values`, one where they are zero."""
    return np.where(values > 0.0, values, 1.0)


def _parts(resisted: NDArray[np.bool_]) -> Iterator[NDArray[np.bool_]]:
    """The entries that are `resisted`, some at a time, so that their matrices do not fill the memory."""
    number = np.cumsum(resisted).reshape(resisted.shape)
    for start in range(0, int(resisted.sum()), _MOST):
        yield np.asarray(resisted & (number > start) & (number <= start + _MOST))
