"""A frame in a plane, compiled: two displacements and one angle a node, two translations and one angle a joint."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..elementwise import contracted, cosine, sine, zeros
from .joints import TreeJoint
from .model import CONSTRAINED, Model, chained
from .numbers import Numbers, Where
from .planar_pieces import AXES, ENDS, TERMS, PlanarStack
from .state import DisplacedState, PlanarState


@dataclass(frozen=True)
class PlanarJoint:
    """A joint, rigid link, tie or support of the tree in the plane.

    Attributes
    ----------
    joint
        The same in space.
    places
        Numbers of its two translations and of its angle among the six coordinates in space.
    axes
        Its two translations as columns (2, 2, ...).
    sense
        Sign of its angle (...).
    arm
        From first to second node at rest (2, ...).
    offset, stiffness
        Of the three coordinates (3, ...).
    """

    joint: TreeJoint
    places: list[int]
    axes: Numbers
    sense: Numbers
    arm: Numbers
    offset: Numbers
    stiffness: Numbers

    @classmethod
    def of(cls, joint: TreeJoint, model: Model, normal: int) -> PlanarJoint:
        """What of a joint in space lies in the plane."""
        places = joint.within(model.components)
        a, b = AXES[normal]
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

    def at(self, where: Where, factor: float) -> PlanarLink:
        """The joint at some entries, its offset multiplied by `factor`."""
        return PlanarLink(
            self.joint.forward,
            self.joint.edge.kind != "tie",
            self.axes.at(where),
            self.sense.at(where),
            self.arm.at(where),
            factor * self.offset.at(where),
            self.stiffness.at(where),
        )

    def law_response(
        self, where: Where, elastic: Array, contact: tuple[Array, Array] | None
    ) -> tuple[Array, Array, Array]:
        """Energy (m,), force (3, m) and tangent (3, 3, m) of its own law at a displacement (3, m) within the plane."""
        whole = zeros((6, elastic.shape[-1]), elastic)
        whole[self.places] = elastic
        energy, force, tangent = self.joint.resistance(where, whole, contact)
        return energy, force[self.places], tangent[np.ix_(self.places, self.places)]


@dataclass(frozen=True)
class PlanarLink:
    """A joint at some entries of the batch, as `links.EdgeGeometry` and `links.LinkChange` in space.

    Attributes
    ----------
    forward
        Whether the child is the second node.
    follows
        Whether the translation's axes turn with the first node (not for ties).
    axes, sense, arm, offset, stiffness
        As in `PlanarJoint`, (..., m or 1); the offset under the share of the loads.
    """

    forward: bool
    follows: bool
    axes: Array
    sense: Array
    arm: Array
    offset: Array
    stiffness: Array

    def springs(self, elastic: Array) -> tuple[Array, Array, Array]:
        """Energy (m,), force (3, m) and tangent (3, 3, m) of the springs."""
        force, tangent = self.stiffness * elastic, zeros((3, 3, self.stiffness.shape[-1]), elastic)
        tangent[range(3), range(3)] = self.stiffness
        return 0.5 * contracted("im,im->m", force, elastic), force, tangent

    def child(self, place: Array, turn: Array, own: Array) -> tuple[Array, Array]:
        """Displacement (2, m) and angle (m,) of the child."""
        angle = self.sense * own[2]
        first = turn if self.forward else turn - angle
        shift = contracted("ijm,jm->im", self.axes, own[:2])
        if self.follows:
            half = sine(0.5 * first)
            across, less = sine(first), -2.0 * half * half
            x, y = shift + self.arm
            shift = shift + np.stack([less * x - across * y, across * x + less * y])
        return (place + shift, turn + angle) if self.forward else (place - shift, first)

    def rotated_arm(self, first: Array, own: Array) -> tuple[Array, Array]:
        """Axes of the translations (2, 2, m) and arm from the first node (2, m), both turned."""
        if not self.follows:
            return self.axes + 0.0 * first, np.zeros_like(own[:2])
        c, s = cosine(first), sine(first)
        axes = np.stack([c * self.axes[0] - s * self.axes[1], s * self.axes[0] + c * self.axes[1]])
        arm = contracted("ijm,jm->im", axes, own[:2])
        if self.arm.any():
            arm = arm + np.stack([c * self.arm[0] - s * self.arm[1], s * self.arm[0] + c * self.arm[1]])
        return axes, arm

    def transfer(self, axes: Array, arm: Array) -> Array:
        """Motion of the child by those of the parent and the link's own (3, 6, m)."""
        sign = 1.0 if self.forward else -1.0
        out = zeros((3, 6, arm.shape[1]), axes, arm)
        out[[0, 1, 2], [0, 1, 2]] = 1.0
        out[0, 2], out[1, 2] = -sign * arm[1], sign * arm[0]
        out[:2, 3:5] = sign * axes
        out[2, 5] = sign * self.sense
        if not self.forward:
            out[:2, 5] = -self.sense * out[:2, 2]
        return out

    def geometric(self, force: Array, axes: Array, arm: Array) -> Array:
        """What turning does to the forces (6, 6, m): parent's coordinates, then the link's own."""
        out = zeros((6, 6, arm.shape[1]), force, axes, arm)
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


class PlanarModel:
    """A model in a plane.

    Parameters
    ----------
    model
        The compiled frame, its components three.
    """

    def __init__(self, model: Model) -> None:
        self.model = model
        self.normal = model.components[2] - 3
        a, b = AXES[self.normal]
        self.components = [a, b, self.normal + 3]
        each = [PlanarStack.of(stack, self.normal, model.ndim) for stack in model.stacks]
        # Few long operations take less time than many short ones: what varies alike is one stack.
        alike: dict[object, list[int]] = {}
        for number, stack in enumerate(each):
            alike.setdefault(stack.batch, []).append(number)
        self.stacks = [PlanarStack.joined([each[number] for number in same]) for same in alike.values()]
        self.linked = [np.concatenate([model.linked[number] for number in same]) for same in alike.values()]
        self.joints = [PlanarJoint.of(joint, model, self.normal) for joint in model.joints]
        self.loads = Numbers(model.loads.nodal.array[self.components], model.ndim)
        # columns (3, nodes) in the order of the coordinates here
        self.columns = model.columns[self.components].copy()
        for joint in self.joints:
            self.columns[:, joint.joint.child] = model.columns[joint.places, joint.joint.child]

    def space(self, state: PlanarState) -> DisplacedState:
        """A state as one in space."""
        out = DisplacedState.start(self.model, state.rotations.shape[-1])
        out.displacements[self.components[:2]] = state.displacements
        half = 0.5 * state.rotations
        out.rotations[0], out.rotations[1 + self.normal] = np.cos(half), np.sin(half)
        for number, joint in enumerate(self.joints):
            out.own[joint.places, number] = state.own[:, number]
        out.contact_force, out.contact_stiffness = state.contact_force, state.contact_stiffness
        return out

    def in_plane(self, state: DisplacedState, near: PlanarState | None) -> PlanarState:
        """A state in space as one in the plane, its angles `near` those of another, as a quaternion counts no turns."""
        rotations = 2.0 * np.arctan2(state.rotations[1 + self.normal], state.rotations[0])
        if near is not None:
            rotations += 2.0 * np.pi * np.round((near.rotations - rotations) / (2.0 * np.pi))
        owns = [state.own[joint.places, number] for number, joint in enumerate(self.joints)]
        own = np.stack(owns, axis=1) if owns else np.zeros((3, 0, rotations.shape[-1]))
        displacements = state.displacements[list(self.components[:2])]
        return PlanarState(displacements, rotations, own, state.contact_force, state.contact_stiffness)

    @staticmethod
    def suits(model: Model) -> bool:
        """Whether a model can be taken: in a plane, without loops, loads between nodes, or bending that elongates."""
        apart = all(not np.any(stack.stiffness.array[0, 1:]) for stack in model.stacks)
        return len(model.components) == 3 and apart and model.plain_members and not model.loops

    @cached_property
    def chains(self) -> list[list[int]]:
        """Columns of the coordinates that move each node; see `Model.chains`."""
        return chained(self.columns, (planar_joint.joint for planar_joint in self.joints))

    @cached_property
    def gather(self) -> list[scipy.sparse.csr_matrix]:
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
            out.append(scipy.sparse.csr_matrix((signs, (rows, columns)), shape=(3 * count, 4 * n)))
        return out

    @cached_property
    def pattern(self) -> tuple[scipy.sparse.csr_matrix, NDArray[np.int64], NDArray[np.int64]]:
        """Sum of the entries of all tangents over those of the matrix's lower half; rows and columns of the latter."""
        entries = [_whole(np.zeros(0, dtype=np.int64))]  # which a frame without members and joints has alone
        chains = [np.array(chain, dtype=np.int64) for chain in self.chains]
        for stack, linked in zip(self.stacks, self.linked, strict=True):
            if not linked.all():
                entries.append(self._terms(stack.ends[~linked]))
            for ends in stack.ends[linked].tolist():
                entries.append(_whole(np.concatenate([chains[node] for node in ends])))
        for planar_joint in self.joints:
            entries.append(_whole(chains[planar_joint.joint.child]))
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
        used = np.flatnonzero((i != CONSTRAINED) & (j != CONSTRAINED) & (i >= j))
        keys, place = np.unique(i[used] * self.model.size + j[used], return_inverse=True)
        matrix = scipy.sparse.csr_matrix((signs[used], (place, k[used])), shape=(len(keys), total))
        return matrix, keys // self.model.size, keys % self.model.size

    def _terms(self, ends: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
        """Rows, columns and signs (10 n, 8) of the places of the different entries of plain pieces."""
        six = np.concatenate([self.columns[:, ends[:, 0]], self.columns[:, ends[:, 1]]])
        n = len(ends)
        rows = np.full((10, n, 8), CONSTRAINED)
        columns, signs = np.full((10, n, 8), CONSTRAINED), np.zeros((10, n, 8))
        for term, (p, q) in enumerate(TERMS):
            pairs = [(i, j, si * sj) for i, si in ENDS[p] for j, sj in ENDS[q]]
            if p != q:
                pairs += [(j, i, sign) for i, j, sign in pairs]
            for place, (i, j, sign) in enumerate(pairs):
                rows[term, :, place], columns[term, :, place], signs[term, :, place] = six[i], six[j], sign
        return rows.reshape(10 * n, 8), columns.reshape(10 * n, 8), signs.reshape(10 * n, 8)


def _whole(columns: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64], Array]:
    """Rows and columns of all entries of a square block, (n n, 1)."""
    pair = np.broadcast_arrays(columns[:, None], columns[None, :])
    return pair[0].reshape(-1, 1), pair[1].reshape(-1, 1), np.ones((columns.size**2, 1))
