"""A frame in a plane, compiled: two displacements and one angle a node."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from .model import CONSTRAINED, Model, chained
from .numbers import Numbers
from .planar_links import PlanarJoint
from .planar_pieces import AXES, ENDS, TERMS, PlanarStack
from .state import DisplacedState, PlanarState


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
        out.contact_multipliers = state.contact_multipliers
        return out

    def in_plane(self, state: DisplacedState, near: PlanarState | None) -> PlanarState:
        """A state in space as one in the plane, its angles `near` those of another, as a quaternion tells no turns."""
        rotations = 2.0 * np.arctan2(state.rotations[1 + self.normal], state.rotations[0])
        if near is not None:
            rotations += 2.0 * np.pi * np.round((near.rotations - rotations) / (2.0 * np.pi))
        owns = [state.own[joint.places, number] for number, joint in enumerate(self.joints)]
        own = np.stack(owns, axis=1) if owns else np.zeros((3, 0, rotations.shape[-1]))
        return PlanarState(state.displacements[list(self.components[:2])], rotations, own, state.contact_multipliers)

    @staticmethod
    def suits(model: Model) -> bool:
        """Whether a model can be taken: in a plane, without loads between nodes or bent tension."""
        apart = all(not np.any(stack.stiffness.array[0, 1:]) for stack in model.stacks)
        plain = (
            all(stack.work is None and stack.tension is None and stack.plain for stack in model.stacks)
            and not model.loads.offset_forces
            and not model.loops
        )
        return len(model.components) == 3 and apart and plain

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
