"""Equilibrium in a plane: the same equations as in space, in two displacements and one angle a node.

In the plane rotations add up, and a piece is two directions, an elongation and two angles. What comes out equals
`equations` to rounding, for a fraction of the time. Angles are not limited to a turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from ..batch import Array
from ..tree import GROUND
from .equations import State
from .joints import Joint
from .loading import Stack
from .model import HELD, Model
from .numbers import Numbers, Where

# Elongation of the axis, its bow included, and the bow's derivatives by the end angles.
Bow = tuple[Array, Array, Array]
# The plane's two axes in the sense of positive rotation, by the axis across it.
_AXES = ((1, 2), (2, 0), (0, 1))
# Places in a piece's tangent of its ten different entries: which of (x1 y1 r1 x2 y2 r2) they join, with what sign.
_TERMS = ((0, 0), (1, 0), (1, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 2), (3, 2), (3, 3))
_ENDS = (((3, 1.0), (0, -1.0)), ((4, 1.0), (1, -1.0)), ((2, 1.0),), ((5, 1.0),))


@dataclass
class FlatState:
    """Displacements (2, nodes, m), angles (nodes, m), own displacements and angles of links (3, links, m)."""

    moved: Array
    turned: Array
    own: Array

    def taken(self, kept: NDArray[np.bool_] | NDArray[np.int64]) -> FlatState:
        """Some of the entries."""
        return FlatState(self.moved[..., kept], self.turned[..., kept], self.own[..., kept])

    def put(self, where: NDArray[np.bool_] | NDArray[np.int64], other: FlatState) -> None:
        """Replace some of the entries."""
        self.moved[..., where], self.turned[..., where], self.own[..., where] = other.moved, other.turned, other.own


@dataclass(frozen=True)
class FlatLinear:
    """What one iteration knows; see `equations.Linear`."""

    forces: Array
    values: Array
    changes: list[tuple[Array, Array, Array]]
    stresses: list[Array]
    transfers: list[Array]
    energy: Array


@dataclass(frozen=True)
class FlatStack:
    """A stack of pieces: ends (n, 2), direction at rest (2, n, ...), length; stiffness k00 k11 k12 k22 and bow g11 g12
    g22 (7, n, ...)."""

    ends: NDArray[np.int64]
    direction: Numbers
    length: Numbers
    stiffness: Numbers

    @classmethod
    def of(cls, stack: Stack, normal: int, ndim: int) -> FlatStack:
        """What of a stack in space lies in the plane."""
        level = stack.level.array
        along = level[0][list(_AXES[normal])]
        about = level[:, normal]
        k = stack.stiffness.array
        parts = [k[0, 0]]
        for whole, first in ((k, 1), (stack.bow.array, 0)):
            for i, j in ((0, 0), (0, 3), (3, 3)):
                block = whole[first + i : first + i + 3, first + j : first + j + 3]
                parts.append(sum(about[a] * block[a, b] * about[b] for a in range(3) for b in range(3)))
        return cls(stack.ends, Numbers(along, ndim), stack.length, Numbers(np.stack(np.broadcast_arrays(*parts)), ndim))


@dataclass(frozen=True)
class FlatJoint:
    """A link of the tree in the plane.

    Attributes
    ----------
    axes
        Its two translations as columns (2, 2, ...); `places` are their numbers among the six, and that of the angle.
    sense
        Sign of its angle (...).
    arm
        From first to second node at rest (2, ...).
    offset, stiffness
        Of the three coordinates (3, ...).
    """

    joint: Joint
    places: list[int]
    axes: Numbers
    sense: Numbers
    arm: Numbers
    offset: Numbers
    stiffness: Numbers

    @classmethod
    def of(cls, joint: Joint, model: Model, normal: int) -> FlatJoint:
        """What of a joint in space lies in the plane."""
        places = joint.within(model.components)
        a, b = _AXES[normal]
        ndim = model.ndim
        one = (1,) * ndim
        axes = np.eye(3).reshape(3, 3, *one) if joint.axes is None else joint.axes.array
        arm = np.zeros((3, *one)) if joint.arm is None else joint.arm.array
        return cls(
            joint,
            places,
            Numbers(np.stack([axes[a][places[:2]], axes[b][places[:2]]]), ndim),
            Numbers(axes[normal, places[2] - 3], ndim),
            Numbers(arm[[a, b]], ndim),
            Numbers(joint.offset.array[places], ndim),
            Numbers(joint.stiffness.array[places], ndim),
        )


class FlatModel:
    """A model in a plane.

    Parameters
    ----------
    model
        The compiled frame, its components three.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.normal = model.components[2] - 3
        a, b = _AXES[self.normal]
        self.components = [a, b, self.normal + 3]
        self.stacks = [FlatStack.of(stack, self.normal, model.ndim) for stack in model.stacks]
        self.joints = [FlatJoint.of(joint, model, self.normal) for joint in model.joints]
        self.loads = Numbers(model.loads.nodal.array[self.components], model.ndim)
        # columns (3, nodes) in the order of the coordinates here
        self.columns = model.columns[self.components].copy()
        for joint in self.joints:
            self.columns[:, joint.joint.child] = model.columns[joint.places, joint.joint.child]

    def space(self, state: FlatState) -> State:
        """A state as one in space."""
        out = State.start(self.model, state.turned.shape[-1])
        out.moved[self.components[:2]] = state.moved
        half = 0.5 * state.turned
        out.turned[0], out.turned[1 + self.normal] = np.cos(half), np.sin(half)
        for number, joint in enumerate(self.joints):
            out.own[joint.places, number] = state.own[:, number]
        return out

    @staticmethod
    def suits(model: Model) -> bool:
        """Whether a model can be taken: in a plane, without loads between nodes, special laws, or bent tension."""
        apart = all(not np.any(stack.stiffness.array[0, 1:]) for stack in model.stacks)
        plain = all(stack.work is None for stack in model.stacks) and not model.loads.hung and not model.loops
        return len(model.components) == 3 and apart and plain and all(joint.law is None for joint in model.joints)

    @cached_property
    def chains(self) -> list[list[int]]:
        """Columns of the coordinates that move each node; see `Model.chains`."""
        out: list[list[int]] = self.columns.T.tolist()
        for flat in self.joints:
            joint = flat.joint
            above = [] if joint.parent == GROUND else out[joint.parent]
            out[joint.child] = above + out[joint.child]
        return out

    @cached_property
    def gather(self) -> list[csr_matrix]:
        """By stack, sum of the forces Fx Fy M1 M2 (4 n) over the nodes' coordinates (3 nodes)."""
        out = []
        count = self.model.count
        for stack in self.stacks:
            n = len(stack.ends)
            first, second = stack.ends.T
            piece = np.arange(n)
            rows = np.concatenate([second, count + second, first, count + first, 2 * count + first, 2 * count + second])
            columns = np.concatenate([piece, n + piece, piece, n + piece, 2 * n + piece, 3 * n + piece])
            signs = np.repeat([1.0, 1.0, -1.0, -1.0, 1.0, 1.0], n)
            out.append(csr_matrix((signs, (rows, columns)), shape=(3 * count, 4 * n)))
        return out

    @cached_property
    def pattern(self) -> tuple[csr_matrix, NDArray[np.int64], NDArray[np.int64]]:
        """Sum of the entries of all tangents over those of the matrix's lower half; rows and columns of the latter."""
        entries: list[tuple[NDArray[np.int64], NDArray[np.int64], Array]] = []
        chains = [np.array(chain, dtype=np.int64) for chain in self.chains]
        for stack, linked in zip(self.stacks, self.model.linked, strict=True):
            if not linked.all():
                entries.append(self._terms(stack.ends[~linked]))
            for ends in stack.ends[linked].tolist():
                entries.append(_whole(np.concatenate([chains[node] for node in ends])))
        for flat in self.joints:
            entries.append(_whole(chains[flat.joint.child]))
        row, column, sign, source, total = [], [], [], [], 0
        for rows, columns, some in entries:
            width = rows.shape[0]
            row.append(rows.reshape(-1))
            column.append(columns.reshape(-1))
            sign.append(some.reshape(-1))
            source.append(total + np.broadcast_to(np.arange(width)[:, None], rows.shape).reshape(-1))
            total += width
        i, j, k = (np.concatenate(part) for part in (row, column, source))
        signs: Array = np.concatenate(sign)
        used = np.flatnonzero((i != HELD) & (j != HELD) & (i >= j))
        keys, place = np.unique(i[used] * self.model.size + j[used], return_inverse=True)
        matrix = csr_matrix((signs[used], (place, k[used])), shape=(len(keys), total))
        return matrix, keys // self.model.size, keys % self.model.size

    def _terms(self, ends: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Rows, columns and signs (10 n, 8) of the places of the different entries of plain pieces."""
        six = np.concatenate([self.columns[:, ends[:, 0]], self.columns[:, ends[:, 1]]])
        n = len(ends)
        rows = np.full((10, n, 8), HELD)
        columns, signs = np.full((10, n, 8), HELD), np.zeros((10, n, 8))
        for term, (p, q) in enumerate(_TERMS):
            pairs = [(i, j, si * sj) for i, si in _ENDS[p] for j, sj in _ENDS[q]]
            if p != q:
                pairs += [(j, i, sign) for i, j, sign in pairs]
            for place, (i, j, sign) in enumerate(pairs):
                rows[term, :, place], columns[term, :, place], signs[term, :, place] = six[i], six[j], sign
        return rows.reshape(10 * n, 8), columns.reshape(10 * n, 8), signs.reshape(10 * n, 8)


def _whole(columns: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Rows and columns of all entries of a square block, (n n, 1)."""
    pair = np.broadcast_arrays(columns[:, None], columns[None, :])
    return pair[0].reshape(-1, 1), pair[1].reshape(-1, 1), np.ones((columns.size**2, 1))


class FlatEquations:
    """A model in the plane at some entries; see `Equations`.

    Parameters
    ----------
    flat
        The model.
    where
        Indices of the entries along each batch axis.
    count
        Number of entries.
    factor
        Share of loads, offsets and prescribed displacements.
    """

    def __init__(self, flat: FlatModel, where: Where, count: int, factor: float = 1.0) -> None:
        self.flat, self.model = flat, flat.model
        self.where, self.count, self.factor = where, count, factor
        self.pieces = [
            (stack.direction.at(where), stack.length.at(where), stack.stiffness.at(where)) for stack in flat.stacks
        ]
        self.links = [_Link.of(joint, where, factor) for joint in flat.joints]
        self.loads = factor * flat.loads.at(where)

    @classmethod
    def start(cls, model: Model, count: int) -> FlatState:
        """At rest."""
        return FlatState(
            np.zeros((2, model.count, count)), np.zeros((model.count, count)), np.zeros((3, len(model.joints), count))
        )

    # -- motion -----------------------------------------------------------------------------------------------------

    @cached_property
    def targets(self) -> Array:
        """Values that the driven coordinates are to have (driven, m)."""
        out = np.zeros((len(self.model.driven), self.count))
        for row, key in enumerate(self.model.driven):
            out[row] = self.factor * self.model.targets[key].at(self.where)
        return out

    def lag(self, state: FlatState) -> Array:
        """What the driven coordinates lack of their targets (driven, m)."""
        out = self.targets.copy()
        if not len(out):
            return out
        for number, link in enumerate(self.flat.joints):
            self._reduce(out, self.flat.columns[:, link.joint.child], state.own[:, number])
        for node in np.flatnonzero(self.model.plain & (self.flat.columns >= self.model.free).any(axis=0)):
            self._reduce(out, self.flat.columns[:, node], [*state.moved[:, node], state.turned[node]])
        return out

    def _reduce(self, lag: Array, columns: NDArray[np.int64], values: Array | list[Array]) -> None:
        for column, value in zip(columns.tolist(), values, strict=True):
            if column >= self.model.free:
                lag[column - self.model.free] -= value

    def advanced(self, state: FlatState, step: Array) -> FlatState:
        """The state after a step of the coordinates (size, m)."""
        nodal = self._nodal(step)
        new = FlatState(state.moved + nodal[:2], state.turned + nodal[2], state.own)
        if self.links:
            new.own = state.own + nodal[:, [flat.joint.child for flat in self.flat.joints]]
        for number, (flat, link) in enumerate(zip(self.flat.joints, self.links, strict=True)):
            joint = flat.joint
            free = joint.parent == GROUND
            place = np.zeros((2, self.count)) if free else new.moved[:, joint.parent]
            turn = np.zeros(self.count) if free else new.turned[joint.parent]
            new.moved[:, joint.child], new.turned[joint.child] = link.child(place, turn, new.own[:, number])
        return new

    def _nodal(self, step: Array) -> Array:
        padded = np.concatenate([step, np.zeros_like(step[:1])])
        return padded[self.flat.columns]

    # -- energy -----------------------------------------------------------------------------------------------------

    def energy(self, state: FlatState) -> Array:
        """Strain energy less the work of the loads (m,)."""
        total = np.zeros(self.count)
        for stack, pieces in zip(self.flat.stacks, self.pieces, strict=True):
            _, _, deformation = _shape(stack, pieces, state)
            total += 0.5 * _strain_energy(pieces[2], deformation, _bent(pieces[2], deformation))
        for number, link in enumerate(self.links):
            total += 0.5 * np.einsum("im,im->m", *link.springs(state.own[:, number]))
        total -= np.einsum("ijm,ijm->m", np.broadcast_to(self.loads[:2], state.moved.shape), state.moved)
        total -= np.einsum("jm,jm->m", np.broadcast_to(self.loads[2], state.turned.shape), state.turned)
        return total

    def moment_work(self, old: FlatState, new: FlatState) -> Array:
        """Nothing: in a plane moments have a potential, and `energy` holds it."""
        del old, new
        return np.zeros(self.count)

    # -- derivatives ------------------------------------------------------------------------------------------------

    def linearised(self, state: FlatState, stresses: list[Array] | None = None) -> FlatLinear:
        """Forces and tangent; see `Equations.linearised`."""
        nodal = np.repeat(-self.loads, self.count, axis=-1) if self.loads.shape[-1] == 1 else -self.loads
        nodal = nodal.reshape(-1, self.count)
        assumed = nodal
        changes, true, data = [], [], []
        energy = np.zeros(self.count)
        arms = [link.turned(self._turn(state, flat), own) for flat, link, own in self._linked(state)]
        transfers = [link.transfer(*each) for link, each in zip(self.links, arms, strict=True)]
        for k, (stack, pieces) in enumerate(zip(self.flat.stacks, self.pieces, strict=True)):
            axes, chord, deformation = _shape(stack, pieces, state)
            bow = _bent(pieces[2], deformation)
            exact = _stress(pieces[2], deformation, bow)
            used = exact if stresses is None else stresses[k]
            energy += _strain_energy(pieces[2], deformation, bow)
            nodal = nodal + self.flat.gather[k] @ _forces(axes, chord, exact).reshape(-1, self.count)
            if stresses is not None:
                assumed = assumed + self.flat.gather[k] @ _forces(axes, chord, used).reshape(-1, self.count)
            stiffness = _stiffness(pieces[2], bow, used[0])
            changes.append((axes, chord, stiffness))
            true.append(exact)
            data += self._tangents(k, _terms(stiffness, axes, chord, used), transfers)
        shape = (3, self.model.count, self.count)
        nodal = nodal.reshape(shape)
        assumed = nodal.copy() if stresses is None else assumed.reshape(shape)
        forces = self._reduced(state, nodal, transfers)
        data += self._link_tangents(arms, assumed, transfers)
        for number, link in enumerate(self.links):
            energy += np.einsum("im,im->m", *link.springs(state.own[:, number]))
        values = self.flat.pattern[0] @ np.concatenate([block.reshape(-1, self.count) for block in data])
        return FlatLinear(forces, values, changes, true, transfers, energy)

    def step_stresses(self, at: FlatLinear, step: Array) -> list[Array]:
        """Forces on the deformations after a step, predicted by the linear change of the deformations."""
        nodal = self._nodal(step)
        for (flat, _), transfer in zip(zip(self.flat.joints, self.links, strict=True), at.transfers, strict=True):
            joint = flat.joint
            own = nodal[:, joint.child]
            parent = np.zeros_like(own) if joint.parent == GROUND else nodal[:, joint.parent]
            nodal[:, joint.child] = np.einsum("ijm,jm->im", transfer, np.concatenate([parent, own]))
        out = []
        for k, stack in enumerate(self.flat.stacks):
            first, second = stack.ends.T
            (c, s), chord, stiffness = at.changes[k]
            x, y = nodal[:2, second] - nodal[:2, first]
            swing = (c * y - s * x) / chord
            pull, one, two = c * x + s * y, nodal[2, first] - swing, nodal[2, second] - swing
            k00, k01, k02, k11, k12, k22 = stiffness
            change = [k00 * pull + k01 * one + k02 * two, k01 * pull + k11 * one + k12 * two]
            out.append(at.stresses[k] + np.stack([*change, k02 * pull + k12 * one + k22 * two]))
        return out

    def _linked(self, state: FlatState) -> list[tuple[FlatJoint, _Link, Array]]:
        owns = [state.own[:, number] for number in range(len(self.links))]
        return list(zip(self.flat.joints, self.links, owns, strict=True))

    def _turn(self, state: FlatState, flat: FlatJoint) -> Array:
        """Angle of a joint's first node."""
        joint = flat.joint
        first = joint.parent if joint.forward else joint.child
        return np.zeros(self.count) if first == GROUND else np.asarray(state.turned[first])

    def _tangents(self, k: int, terms: Array, transfers: list[Array]) -> list[Array]:
        """Different entries of plain pieces as they are, the others in the terms of their chains."""
        linked = self.model.linked[k]
        out = [] if linked.all() else [terms[:, ~linked]]
        for number in np.flatnonzero(linked):
            first, second = self.flat.stacks[k].ends[number].tolist()
            whole = _six(terms[:, number])
            whole = np.concatenate([self._up(whole[:3], first, transfers), self._up(whole[3:], second, transfers)])
            whole = np.swapaxes(whole, 0, 1)
            out.append(np.concatenate([self._up(whole[:3], first, transfers), self._up(whole[3:], second, transfers)]))
        return out

    @cached_property
    def _number(self) -> dict[int, int]:
        return {flat.joint.child: number for number, flat in enumerate(self.flat.joints)}

    def _up(self, rows: Array, node: int, transfers: list[Array]) -> Array:
        """Rows (3, k, m) of a node's coordinates as rows of those of its chain."""
        if node not in self._number:
            return rows
        number = self._number[node]
        transfer, parent = transfers[number], self.flat.joints[number].joint.parent
        own: Array = np.einsum("ijm,ikm->jkm", transfer[:, 3:], rows)
        if parent == GROUND:
            return own
        above = rows.copy()
        above[2] += transfer[0, 2] * rows[0] + transfer[1, 2] * rows[1]
        return np.concatenate([self._up(above, parent, transfers), own])

    def _link_tangents(self, arms: list[tuple[Array, Array]], nodal: Array, transfers: list[Array]) -> list[Array]:
        """Springs of the links, and what turning them does to the forces that they pass on."""
        out: list[Array] = []
        for number in range(len(self.links) - 1, -1, -1):
            joint, link = self.flat.joints[number].joint, self.links[number]
            force = nodal[:, joint.child]
            matrix = link.geometric(force, *arms[number])
            matrix[range(3, 6), range(3, 6)] += link.stiffness
            if joint.parent == GROUND:
                out.append(matrix[3:, 3:])
                continue
            nodal[:, joint.parent] += np.einsum("ijm,im->jm", transfers[number][:, :3], force)
            half = np.concatenate([self._up(matrix[:3], joint.parent, transfers), matrix[3:]])
            half = np.swapaxes(half, 0, 1)
            out.append(np.concatenate([self._up(half[:3], joint.parent, transfers), half[3:]]))
        return out[::-1]

    def _reduced(self, state: FlatState, nodal: Array, transfers: list[Array]) -> Array:
        """Forces on the coordinates from forces on the nodes, leaves first."""
        out = np.zeros((self.model.size + 1, self.count))
        nodal = nodal.copy()
        for number in range(len(self.links) - 1, -1, -1):
            joint = self.flat.joints[number].joint
            pushed = np.einsum("ijm,im->jm", transfers[number], nodal[:, joint.child])
            out[self.flat.columns[:, joint.child]] = pushed[3:] + self.links[number].springs(state.own[:, number])[1]
            if joint.parent != GROUND:
                nodal[:, joint.parent] += pushed[:3]
        plain = self.model.plain
        out[self.flat.columns[:, plain]] = nodal[:, plain]
        return out[:-1]


@dataclass(frozen=True)
class _Link:
    """A joint at some entries; see `links.Link`."""

    forward: bool
    follows: bool
    axes: Array
    sense: Array
    arm: Array
    offset: Array
    stiffness: Array

    @classmethod
    def of(cls, flat: FlatJoint, where: Where, factor: float) -> _Link:
        return cls(
            flat.joint.forward,
            flat.joint.edge.kind != "tie",
            flat.axes.at(where),
            flat.sense.at(where),
            flat.arm.at(where),
            factor * flat.offset.at(where),
            flat.stiffness.at(where),
        )

    def springs(self, own: Array) -> tuple[Array, Array]:
        """What of the displacement is not imposed, and the force of the springs (3, m)."""
        beyond = own - self.offset
        return beyond, self.stiffness * beyond

    def child(self, place: Array, turn: Array, own: Array) -> tuple[Array, Array]:
        """Displacement (2, m) and angle (m,) of the child."""
        angle = self.sense * own[2]
        first = turn if self.forward else turn - angle
        shift = np.einsum("ijm,jm->im", self.axes, own[:2])
        if self.follows:
            half = np.sin(0.5 * first)
            sine, less = np.sin(first), -2.0 * half * half
            x, y = shift + self.arm
            shift = shift + np.stack([less * x - sine * y, sine * x + less * y])
        return (place + shift, turn + angle) if self.forward else (place - shift, first)

    def turned(self, first: Array, own: Array) -> tuple[Array, Array]:
        """Axes of the translations (2, 2, m) and arm from the first node (2, m), both turned."""
        if not self.follows:
            return self.axes + 0.0 * first, np.zeros_like(own[:2])
        c, s = np.cos(first), np.sin(first)
        axes = np.stack([c * self.axes[0] - s * self.axes[1], s * self.axes[0] + c * self.axes[1]])
        arm = np.einsum("ijm,jm->im", axes, own[:2])
        if self.arm.any():
            arm = arm + np.stack([c * self.arm[0] - s * self.arm[1], s * self.arm[0] + c * self.arm[1]])
        return axes, arm

    def transfer(self, axes: Array, arm: Array) -> Array:
        """Motion of the child by those of the parent and the link's own (3, 6, m)."""
        sign = 1.0 if self.forward else -1.0
        out = np.zeros((3, 6, arm.shape[1]))
        out[[0, 1, 2], [0, 1, 2]] = 1.0
        out[0, 2], out[1, 2] = -sign * arm[1], sign * arm[0]
        out[:2, 3:5] = sign * axes
        out[2, 5] = sign * self.sense
        if not self.forward:
            out[:2, 5] = -self.sense * out[:2, 2]
        return out

    def geometric(self, force: Array, axes: Array, arm: Array) -> Array:
        """What turning does to the forces (6, 6, m): parent's coordinates, then the link's own."""
        out = np.zeros((6, 6, arm.shape[1]))
        if not self.follows:
            return out
        sign = 1.0 if self.forward else -1.0
        bend = -sign * (force[0] * arm[0] + force[1] * arm[1])
        slide = sign * (force[1] * axes[0] - force[0] * axes[1])
        out[2, 2], out[2, 3:5], out[3:5, 2] = bend, slide, slide
        if not self.forward:
            out[2, 5] = out[5, 2] = -self.sense * bend
            out[5, 5] = bend
            out[5, 3:5] = out[3:5, 5] = -self.sense * slide
        return out


def _shape(stack: FlatStack, pieces: tuple[Array, Array, Array], state: FlatState) -> tuple[Array, Array, Array]:
    """Direction (2, n, m) and length (n, m) of the chord, elongation and end angles (3, n, m)."""
    (c0, s0), length, _ = pieces
    first, second = stack.ends.T
    x, y = state.moved[:, second] - state.moved[:, first]
    along, across = c0 * x + s0 * y, c0 * y - s0 * x
    ahead = length + along
    chord = np.sqrt(ahead * ahead + across * across)
    swing = np.arctan2(across, ahead)
    out = np.empty((3, *chord.shape))
    out[0] = ((length + ahead) * along + across * across) / (chord + length)
    out[1], out[2] = state.turned[first] - swing, state.turned[second] - swing
    if np.abs(out[1:]).max(initial=0.0) > 3.0:
        out[1:] -= 2.0 * np.pi * np.round((out[1] + out[2]) / (4.0 * np.pi))
    c, s = ahead / chord, across / chord
    return np.stack([c0 * c - s0 * s, s0 * c + c0 * s]), chord, out


def _bent(stiffness: Array, deformation: Array) -> Bow:
    """Elongation of the axis, its bow included, and the bow's derivatives by the end angles (n, m)."""
    _, _, _, _, g11, g12, g22 = stiffness
    pull, first, second = deformation
    one, two = g11 * first + g12 * second, g12 * first + g22 * second
    return pull + 0.5 * (first * one + second * two), one, two


def _stress(stiffness: Array, deformation: Array, bow: Bow) -> Array:
    """Pull and both end moments (3, n, m)."""
    k0, k11, k12, k22, *_ = stiffness
    axis, one, two = bow
    _, first, second = deformation
    out = np.empty_like(deformation)
    pull = np.multiply(k0, axis, out=out[0])
    out[1] = k11 * first + k12 * second + pull * one
    out[2] = k12 * first + k22 * second + pull * two
    return out


def _strain_energy(stiffness: Array, deformation: Array, bow: Bow) -> Array:
    """Twice the strain energy of all pieces (m,)."""
    k0, k11, k12, k22, *_ = stiffness
    axis, _, _ = bow
    _, first, second = deformation
    each = k0 * axis * axis + (k11 * first + 2.0 * k12 * second) * first + k22 * second * second
    out: Array = each.sum(axis=0)
    return out


def _stiffness(stiffness: Array, bow: Bow, pull: Array) -> Array:
    """Derivatives of `_stress` 00 01 02 11 12 22 (6, n, m); `pull` resists further bowing."""
    k0, k11, k12, k22, g11, g12, g22 = stiffness
    _, one, two = bow
    out = np.empty((6, *pull.shape))
    out[0] = k0
    np.multiply(k0, one, out=out[1])
    np.multiply(k0, two, out=out[2])
    out[3] = k11 + pull * g11 + out[1] * one
    out[4] = k12 + pull * g12 + out[1] * two
    out[5] = k22 + pull * g22 + out[2] * two
    return out


def _forces(axes: Array, chord: Array, stress: Array) -> Array:
    """Fx Fy on the second end, and both end moments (4, n, m)."""
    c, s = axes
    shear = (stress[1] + stress[2]) / chord
    return np.stack([stress[0] * c + shear * s, stress[0] * s - shear * c, stress[1], stress[2]])


def _terms(stiffness: Array, axes: Array, chord: Array, stress: Array) -> Array:
    """The ten different entries of the tangent in (x2 - x1, y2 - y1, r1, r2), in the order of `_TERMS` (10, n, m)."""
    k00, k01, k02, k11, k12, k22 = stiffness
    c, s = axes
    bend1, bend2 = (k11 + k12) / chord, (k12 + k22) / chord
    across = (bend1 + bend2 + stress[0]) / chord
    mixed = (stress[1] + stress[2]) / (chord * chord) - (k01 + k02) / chord
    cc, ss, cs = c * c, s * s, c * s
    twice = 2.0 * cs * mixed
    out = np.empty((10, *chord.shape))
    out[0] = k00 * cc + across * ss - twice
    out[1] = (k00 - across) * cs + mixed * (cc - ss)
    out[2] = k00 * ss + across * cc + twice
    out[3], out[4] = k01 * c + bend1 * s, k01 * s - bend1 * c
    out[5], out[6] = k02 * c + bend2 * s, k02 * s - bend2 * c
    out[7], out[8], out[9] = k11, k12, k22
    return out


def _six(terms: Array) -> Array:
    """The tangent of one piece in (x1 y1 r1 x2 y2 r2), (6, 6, m), from its different entries (10, m)."""
    out = np.empty((6, 6, terms.shape[-1]))
    for term, (p, q) in zip(terms, _TERMS, strict=True):
        for i, first in _ENDS[p]:
            for j, second in _ENDS[q]:
                out[i, j] = out[j, i] = first * second * term
    return out
