"""The contact state of all journals, from the joint forces without clearance and the stiffness against offsets."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, reduce
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, aligned, norms
from ..description import Description
from ..states import ClearanceState, States, put, states_of
from .ball_problem import BallProblem, Groups, Minimum, or_one, times
from .ball_qp import minima
from .joints import UNLOADED
from .middle import free_motions

# A joint with less than this part in a free motion does not take part.
_STILL = 1e-6
# Between these squares have full precision.
_LEAST, _LARGEST = 1e-280, 1e280
# Number of entries whose contact is found at a time.
_MOST = 2**16
# If the residual in the joints, relative to the largest load or joint force, exceeds this, the contact is unresolved.
_BALANCED = 1e-6
# Some entries of a batch, counted through.
Entries = slice | NDArray[np.intp]


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
        with np.errstate(over="ignore", under="ignore", invalid="ignore"):
            square = Groups(self.own).dot(vectors, vectors)
            length: Array = np.sqrt(square)
            if not (square.min(initial=np.inf) > _LEAST and square.max(initial=0.0) < _LARGEST):
                unsafe = np.asarray(~((square > _LEAST) & (square < _LARGEST)).all(axis=0))
                length[:, unsafe] = np.hypot.reduceat(np.abs(vectors[:, unsafe]), self.starts, axis=0)
        return length


class Tally(NamedTuple):
    """How minima of energy were found.

    Attributes
    ----------
    entries
        Number of batch entries.
    newton
        Number of those at which Newton's method found the minimum.
    steps
        Sum of its steps there.
    others
        Number of entries at which interior points found it.
    how
        How the steps were done, and why, in words; empty where no stiffness resists offsets.
    """

    entries: int = 0
    newton: int = 0
    steps: float = 0.0
    others: int = 0
    how: str = ""

    def and_of(self, other: Tally) -> Tally:
        """That of these entries and of others together."""
        entries, newton = self.entries + other.entries, self.newton + other.newton
        how = other.how or self.how
        return Tally(entries, newton, self.steps + other.steps, self.others + other.others, how)

    def __str__(self) -> str:
        mean = f" in {self.steps / self.newton:.2g} steps on average" if self.newton else ""
        text = f"The minimum was found by Newton's method at {self.newton} of {self.entries} entries{mean}"
        if self.others:
            text += f", and by interior points at {self.others} where that failed or there are many minima"
        return f"{text}: {self.how}."


class _Found(NamedTuple):
    """Offsets (n, ...), magnitudes of forces and states (joints, ...), and how they were found."""

    offset: Array
    size: Array
    state: States
    tally: Tally


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
        rotations = self.components.is_rotation
        force, moment = self.load
        for value, is_rotation in zip(self.found, rotations, strict=True):
            if is_rotation:
                moment = np.maximum(moment, np.abs(value))
            else:
                force = np.maximum(force, np.abs(value))
        # if all nodes are at the origin there are no arms, and forces cause no moments
        arm, kinds = self.length_scale, rotations[self.components.starts]
        as_force = np.maximum(force, np.where(arm > 0.0, moment, 0.0) / or_one(arm))
        if not kinds.any():
            return np.broadcast_to(as_force, (len(kinds), *as_force.shape))
        as_moment = np.maximum(moment, force * arm)
        return np.stack([as_moment if kind else as_force for kind in kinds])

    @cached_property
    def without_clearance(self) -> Array:
        """Joint forces without clearance, (n, ...), with rounding set to zero."""
        loaded = self.components.length(self.found) > self.rounding * self.scale
        return self.found if loaded.all() else np.where(loaded[self.components.own], self.found, 0.0)

    @property
    def offset(self) -> Array:
        """Displacement within the clearance, (n, ...)."""
        return self._found.offset

    @property
    def size(self) -> Array:
        """Magnitude of the contact force in each joint, (joints, ...); rounding where there is none."""
        return self._found.size

    @property
    def state(self) -> States:
        """State of each joint, a `ClearanceState`: closed, open, free or unresolved, (joints, ...)."""
        return self._found.state

    @property
    def tally(self) -> Tally:
        """How the offsets of least energy were found."""
        return self._found.tally

    @cached_property
    def force(self) -> Array:
        """Contact force by component, (n, ...)."""
        if not self.stiffness.any():
            return self.without_clearance
        force: Array = self.without_clearance - np.einsum("ij...,j...->i...", self.stiffness, self.offset)
        return force

    @cached_property
    def _found(self) -> _Found:
        """What is found, of long batches in parts that stay in the processor's cache."""
        shape = self.found.shape[1:]
        count, balls = math.prod(shape), len(self.components.names)
        if count <= _MOST:
            placed = self._placed
            return _Found(placed.offset, placed.pressing, self._states(placed), self._tally(placed))
        offset, size = np.empty((len(self.found), count)), np.empty((balls, count))
        states, tally = np.empty((balls, count), dtype=np.int8), Tally()
        for start in range(0, count, _MOST):
            part = slice(start, min(start + _MOST, count))
            offset[:, part], size[:, part], states[:, part], told = self._at(part)._found
            tally = tally.and_of(told)
        states = states.reshape(balls, *shape)
        return _Found(offset.reshape(len(offset), *shape), size.reshape(balls, *shape), states, tally)

    def _tally(self, placed: Minimum) -> Tally:
        if not self.stiffness.any():
            return Tally(placed.steps.size)
        some = placed.found & (placed.steps > 0.0)
        steps = float(placed.steps[some].sum())
        return Tally(placed.steps.size, int(some.sum()), steps, int((~placed.found).sum()), placed.how)

    def _at(self, part: slice) -> ContactState:
        """The contact state of some entries of the batch, counted through."""
        shape = self.found.shape[1:]
        stiffness, members, found, radius, load, length_scale = (
            _flat(values, shape, part)
            for values in (self.stiffness, self.members, self.found, self.radius, self.load, self.length_scale)
        )
        rounding = _flat(self.rounding, shape, part) if isinstance(self.rounding, np.ndarray) else self.rounding
        return ContactState(self.components, stiffness, members, found, radius, load, length_scale, rounding)

    def _states(self, placed: Minimum) -> States:
        closed = placed.pressing > UNLOADED * self.scale
        state = put(states_of(closed.shape, ClearanceState.OPEN), closed, ClearanceState.CLOSED)
        without_contact = ~closed & (self.radius > 0.0)
        some = np.asarray(without_contact.any(axis=0))
        if some.any():
            free = self._free(without_contact[:, some], some)
            state[:, some] = put(state[:, some], free, ClearanceState.FREE)
        if not self.stiffness.any():
            return state
        allowed = _BALANCED * self.scale
        wrong = np.asarray(~(placed.unbalanced <= allowed).all(axis=0))
        if wrong.any():
            # near the smallest representable offset, a step of the offset changes the force
            step = np.abs(self.stiffness).sum(axis=1) * np.finfo(np.float64).smallest_subnormal
            allowed = allowed + np.maximum.reduceat(step, self.components.starts)
            wrong = np.asarray(~(placed.unbalanced <= allowed).all(axis=0))
        return put(state, wrong, ClearanceState.UNRESOLVED)

    @cached_property
    def _placed(self) -> Minimum:
        """The offsets, along the forces if S vanishes, else of least energy; `pressing` where there is no clearance."""
        shape, own = self.without_clearance.shape[1:], self.components.own
        resisted, count = np.any(self.stiffness != 0.0, axis=(0, 1)), math.prod(shape)
        if resisted.all():
            found = self._least(slice(0, count))
            return found.shaped(shape, found.how)
        out, how = Minimum.places(len(own), len(self.components.names), count), ""
        length = self.components.length(self.without_clearance)
        along = self.radius[own] * (self.without_clearance / or_one(length)[own])
        out.offset[:], out.pressing[:] = along.reshape(len(own), -1), length.reshape(len(length), -1)
        out.unbalanced[:], out.found[:], out.steps[:] = 0.0, True, 0.0
        places = np.flatnonzero(np.broadcast_to(resisted, shape))
        if len(places):
            found = self._least(places)
            out.put(places, found)
            how = found.how
        return out.shaped(shape, how)

    def _least(self, part: Entries) -> Minimum:
        """The minima of energy at some entries; where there is no clearance `pressing` is the force in the joint."""
        groups, shape = Groups(self.components.own), self.without_clearance.shape[1:]
        stiffness, force, members, radius = (
            _flat(values, shape, part) for values in (self.stiffness, self.without_clearance, self.members, self.radius)
        )
        found = minima(BallProblem(groups, stiffness, force, members, radius))
        tight = np.broadcast_to(radius == 0.0, found.pressing.shape)
        some = np.asarray(tight.any(axis=0))
        if some.any():
            whole = BallProblem(groups, stiffness, force, members, radius).at(some)
            left = self.components.length(whole.force - times(whole.stiffness, found.offset[:, some]))
            found.pressing[:, some] = np.where(tight[:, some], left, found.pressing[:, some])
        return found

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
    """The size of a frame at each entry, (...), so that entries do not affect each other.

    It is the largest absolute coordinate of a node in global axes, or of a body's origin plus the distance of its
    farthest node from there.
    """
    if math.prod(frame.shape) == 1 and not frame.bodies:
        return np.asarray(frame.size)
    far: dict[str, list[Array]] = {}
    for node in frame.nodes.values():
        if node.body is not None:
            far.setdefault(node.body, []).append(norms(node.coordinates))
    each = [_largest(node.coordinates) for node in frame.nodes.values() if node.body is None]
    each += [_largest(frame.bodies[name].origin) + reduce(np.maximum, own) for name, own in far.items()]
    return aligned(reduce(np.maximum, sorted(each, key=np.size)), len(frame.shape))


def _largest(vectors: Array) -> Array:
    """Largest absolute component of vectors (..., 3)."""
    x, y, z = (np.abs(vectors[..., k]) for k in range(3))
    return np.maximum(np.maximum(x, y), z)


def _flat(values: Array, shape: Shape, part: Entries) -> Array:
    """Values of some entries of a batch, which is counted through, along the last axis: of size one if none varies."""
    if values.ndim < len(shape):  # one number for all
        return values.reshape(-1)
    lead, own = values.shape[: values.ndim - len(shape)], values.shape[values.ndim - len(shape) :]
    if math.prod(own) == 1:
        return values.reshape(*lead, 1)
    if own == shape:
        return values.reshape(*lead, -1)[..., part]
    places = np.unravel_index(np.arange(math.prod(shape))[part], shape)
    at = tuple(place if n > 1 else 0 * place for place, n in zip(places, own, strict=True))
    return np.asarray(values[(slice(None),) * len(lead) + at])
