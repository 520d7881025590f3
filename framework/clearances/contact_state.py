"""The contact state of all journals, from the joint forces without clearance and the stiffness against offsets."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from ..description import Description
from ..states import ClearanceState, States, put, states_of
from .ball_qp import minimise_in_balls
from .middle import free_motions

# A force below this share of the largest load or joint force is rounding.
UNLOADED = 1e-12
# A joint with less than this part in a free motion does not take part.
_STILL = 1e-6
# Between these squares have full precision.
_LEAST, _LARGEST = 1e-280, 1e280
# Largest stiffness for loads of size one: squares and cubes of the resulting displacements must not underflow.
_STIFFEST = 1e100
# Number of entries whose matrices are in memory at a time.
_MOST = 2**16
# If the residual in the joints, relative to the largest load or joint force, exceeds this, the contact is unresolved.
_BALANCED = 1e-6


@dataclass(frozen=True)
class ClearanceComponents:
    """The n components with clearance of all joints, one joint after the other.

    Attributes
    ----------
    names
        Names of the joints.
    own
        Index of the joint of each component, (n,).
    component
        Component of the joint, 0 to 5, of each.
    """

    names: list[str]
    own: NDArray[np.int64]
    component: list[int]

    @property
    def starts(self) -> NDArray[np.int64]:
        """Index of the first component of each joint, (joints,)."""
        return np.searchsorted(self.own, np.arange(len(self.names)))

    @property
    def is_rotation(self) -> NDArray[np.bool_]:
        """Whether components are rotations, whose forces are moments, (n,)."""
        return np.asarray(self.component) >= 3

    @property
    def pairs(self) -> list[tuple[str, int]]:
        """Name of the joint and component of the joint, for each component."""
        return [(self.names[j], k) for j, k in zip(self.own, self.component, strict=True)]

    def length(self, vectors: Array) -> Array:
        """Length of the vector in each joint, (joints, ...), of vectors (n, ...)."""
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
    """The contact state of all journals.

    Attributes
    ----------
    components
        The components with clearance.
    stiffness
        S, decrease of the forces per unit offset, (n, n, ...); batch axes over which it does not vary may be missing.
    members
        Stiffness of the members, (n, ...), with which S is compared to see whether it is zero.
    found
        Joint forces without clearance, (n, ...).
    radius
        Clearance of each joint, (joints, ...).
    load
        Largest force and largest moment on a node, (2, ...).
    length_scale
        Length by which moments are compared with forces, see `sizes`, (...).
    rounding
        Share of the largest force below which a force without clearance is rounding: one number, or (joints, ...).
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
        """Largest load or joint force, or moment for joints with clearance in rotations, (joints, ...)."""
        is_rotation, found = self.components.is_rotation, np.abs(self.found)
        force, moment = (
            np.maximum(load, found[which].max(axis=0, initial=0.0))
            for load, which in zip(self.load, (~is_rotation, is_rotation), strict=True)
        )
        # if all nodes are at the origin there are no arms, and forces cause no moments
        arm = self.length_scale
        both = (
            np.maximum(force, np.where(arm > 0.0, moment, 0.0) / _or_one(arm)),
            np.maximum(moment, force * arm),
        )
        scale: Array = np.stack(both)[is_rotation[self.components.starts].astype(np.int64)]
        return scale

    @cached_property
    def without_clearance(self) -> Array:
        """Joint forces without clearance, (n, ...), with rounding set to zero."""
        loaded = self.components.length(self.found) > self.rounding * self.scale
        return self.found if loaded.all() else np.where(loaded[self.components.own], self.found, 0.0)

    @property
    def offset(self) -> Array:
        """Displacement within the clearance, (n, ...)."""
        return self._placed[0]

    @property
    def size(self) -> Array:
        """Magnitude of the contact force in each joint, (joints, ...); rounding where there is none."""
        return self._placed[1]

    @cached_property
    def force(self) -> Array:
        """Contact force by component, (n, ...)."""
        if not self.stiffness.any():
            return self.without_clearance
        force: Array = self.without_clearance - np.einsum("ij...,j...->i...", self.stiffness, self.offset)
        return force

    @cached_property
    def state(self) -> States:
        """State of each joint, a `ClearanceState`: closed, open, free or unresolved, (joints, ...)."""
        closed = self.size > UNLOADED * self.scale
        state = put(states_of(closed.shape, ClearanceState.OPEN), closed, ClearanceState.CLOSED)
        without_contact = ~closed & (self.radius > 0.0)
        some = np.asarray(without_contact.any(axis=0))
        if some.any():
            free = self._free(without_contact[:, some], some)
            state[:, some] = put(state[:, some], free, ClearanceState.FREE)
        if not self.stiffness.any():
            return state
        normal = self.offset / np.where(self.radius > 0.0, self.radius, 1.0)[self.components.own]
        pressed = np.where(
            (closed & (self.radius > 0.0))[self.components.own], self.size[self.components.own] * normal, 0.0
        )
        unbalanced = np.where((self.radius > 0.0)[self.components.own], self.force - pressed, 0.0)
        # near the smallest representable offset, a step of the offset changes the force
        step = np.abs(self.stiffness).sum(axis=1) * np.finfo(np.float64).smallest_subnormal
        wrong = ~(np.abs(unbalanced) <= _BALANCED * self.scale[self.components.own] + step).all(axis=0)
        return put(state, wrong, ClearanceState.UNRESOLVED)

    @cached_property
    def _placed(self) -> tuple[Array, Array]:
        """Offset (n, ...) and magnitude of the force (joints, ...): along it if S vanishes, else of least energy."""
        own, radius = self.components.own, self.radius
        size = self.components.length(self.without_clearance)
        offset = radius[own] * (self.without_clearance / _or_one(size)[own])
        resisted = np.broadcast_to(np.any(self.stiffness != 0.0, axis=(0, 1)), self.without_clearance.shape[1:])
        for part in _parts(resisted):
            offset[:, part], size[:, part] = self._least(part)
        return offset, size

    def _least(self, part: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Offset (n, N) of least energy, and magnitude of the force (joints, N), at the N entries in a mask."""
        own, near, without_clearance = self.components.own, self.radius[:, part], self.without_clearance[:, part]
        stiffness = np.broadcast_to(self.stiffness, (len(own), *self.without_clearance.shape))[:, :, part]
        widest, strongest = (_or_one(np.abs(values).max(axis=0)) for values in (near, without_clearance))
        scale = (near / widest)[own]
        largest = _or_one(np.abs(stiffness).max(axis=(0, 1)))
        with np.errstate(over="ignore", under="ignore"):
            ratio = np.minimum(widest / strongest, _STIFFEST / largest)
            # a load so small that its ratio to the stiffness underflows is scaled up, as it closes no clearance
            share = strongest * (_STIFFEST / largest) / widest
        scaled = stiffness * (scale[:, None] * scale * ratio)
        members = np.broadcast_to(self.members, self.without_clearance.shape)[:, part] * (scale * scale * ratio)
        x, multiplier = minimise_in_balls(scaled, without_clearance / strongest * scale, own, members)
        x = np.where((multiplier > 0.0)[own], x, x * np.minimum(share, 1.0))
        offset = near[own] * x
        left = self.components.length(without_clearance - np.einsum("ijn,jn->in", stiffness, offset))
        return offset, np.where(near > 0.0, strongest * multiplier / _or_one(near / widest), left)

    def _free(self, without_contact: NDArray[np.bool_], some: NDArray[np.bool_]) -> NDArray[np.bool_]:
        """Whether joints `without_contact` (joints, N) move in a mechanism, at the entries in the mask `some`."""
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
    """Largest absolute coordinate of a node at each entry, (...), so that entries do not affect each other."""
    if math.prod(frame.shape) == 1:
        return np.asarray(frame.size)
    each = (np.abs(frame.position(node)).max(axis=-1) for node in frame.nodes)
    return aligned(reduce(np.maximum, each), len(frame.shape))


def _or_one(values: Array) -> Array:
    """`values`, with one in place of zeros."""
    return np.where(values > 0.0, values, 1.0)


def _parts(resisted: NDArray[np.bool_]) -> Iterator[NDArray[np.bool_]]:
    """Masks of some of the entries in `resisted` at a time, which limits the memory for their matrices."""
    number = np.cumsum(resisted).reshape(resisted.shape)
    for start in range(0, int(resisted.sum()), _MOST):
        yield np.asarray(resisted & (number > start) & (number <= start + _MOST))
