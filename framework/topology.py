"""Members cut into pieces, numbered on a scikit-fem mesh, and gathered into stacks that are evaluated together."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .batch import Array, aligned, block_diagonal
from .dofs import DISPLACEMENTS
from .parts import Extended
from .protocol import LineElement

if TYPE_CHECKING:
    from .frame import Frame, Node

Index = NDArray[np.int64]

# Stiffness matrices up to which a stack is summed in extended precision.
_EXTENDED = 4096


@dataclass(slots=True)
class Piece:
    """One of the equal parts of a member, between two node numbers."""

    member: str
    index: int
    count: int
    element: LineElement
    nodes: tuple[int, int]


@dataclass(frozen=True)
class Group:
    """Pieces of equal kind as one stack.

    Attributes
    ----------
    element
        Stands for them all.
    pieces
        Their numbers (n,).
    dofs
        Their DOF numbers (n, 12).
    length
        (n, ...).
    turns
        For start and end: the local axes as rows (n, ..., 3, 3) in the axes of that node.
    level
        The local axes as rows (n, ..., 3, 3) in global axes.
    """

    element: LineElement
    pieces: Index
    dofs: Index
    length: Array
    turns: tuple[Array, Array]
    level: Array

    @property
    def nodes(self) -> Index:
        """Node numbers of their ends (n, 2)."""
        return self.dofs[:, ::6] // 6

    @cached_property
    def transform(self) -> Array:
        """From displacements in the nodes' axes to local ones, (n, ..., 12, 12)."""
        start, end = self.turns
        return block_diagonal((start, start, end, end))

    @property
    def stiffness_shape(self) -> tuple[int, ...]:
        """Batch shape over which the stiffness of a piece varies."""
        turns = (turn.shape[1:-2] for turn in self.turns)
        return np.broadcast_shapes(*turns, self.length.shape[1:], self.element.shape)

    def turned(self, local: Array) -> Array:
        """Symmetric local matrices (n, ..., 12, 12) in the nodes' axes: ``T^T A T``, skipping what is zero."""
        turns = [np.ascontiguousarray(np.moveaxis(turn, (-2, -1), (0, 1))) for turn in self.turns]
        batch = np.broadcast_shapes(local.shape[:-2], *(turn.shape[2:] for turn in turns))
        out = np.zeros((12, 12, *batch))
        used = (local != 0.0).reshape(-1, 12, 12).any(axis=0)
        for i, j in zip(*np.nonzero(used), strict=True):
            p, q = 3 * (i // 3), 3 * (j // 3)
            if p <= q:
                pair = turns[p // 6][i - p][:, None] * turns[q // 6][j - q][None, :]
                out[p : p + 3, q : q + 3] += local[..., i, j] * pair
        low, high = np.tril_indices(12, -1)
        out[low, high] = out[high, low]
        return np.moveaxis(out, (0, 1), (-2, -1))

    def part(self, part: slice) -> Group:
        """Some of the pieces as a stack of their own."""
        start, end = self.turns
        turns = start[part], end[part]
        return Group(self.element, self.pieces[part], self.dofs[part], self.length[part], turns, self.level[part])

    def stiffness(self) -> Array:
        """Stiffness in the nodes' axes, (n, ..., 12, 12)."""
        return self.turned(self.element.stiffness_matrix(self.length))

    def extended_stiffness(self) -> NDArray[Any]:
        """Stiffness in the nodes' axes, (n, ..., 12, 12), summed in extended precision where it is not a large stack.

        As a sum of springs on deformations it keeps, to the square of rounding, that a rigid motion costs no energy.
        """
        stiffness, rows = self.element.springs(self.length)
        kind = Extended if stiffness[..., 0].size <= _EXTENDED else np.float64
        turned: NDArray[Any] = (rows @ self.transform).astype(kind)
        weighed: NDArray[Any] = stiffness.astype(kind)[..., None] * turned
        out: NDArray[Any] = np.swapaxes(turned, -1, -2) @ weighed
        return out

    def mass(self) -> Array:
        """Mass in the nodes' axes, (n, ..., 12, 12)."""
        return self.turned(self.element.mass_matrix(self.length))


@dataclass(frozen=True)
class Topology:
    """Numbered nodes and pieces.

    Attributes
    ----------
    number
        Node number by name; interior nodes of members are named ``member.1``, ``member.2``, ...
    bodies
        Body of each node.
    pieces
        All pieces, those of one member in a row.
    pieces_of
        Piece numbers of each member.
    """

    frame: Frame
    number: dict[str, int]
    bodies: list[str | None]
    pieces: list[Piece]
    pieces_of: dict[str, range]

    @classmethod
    def of(cls, frame: Frame, *, cut: bool) -> Topology:
        """Number the nodes of a frame and, for what needs it, `cut` its members into their segments.

        Statics needs no cut where one piece is exact.
        """
        number = {name: index for index, name in enumerate(frame.nodes)}
        bodies = [node.body for node in frame.nodes.values()]
        pieces: list[Piece] = []
        pieces_of: dict[str, range] = {}
        for name, member in frame.members.items():
            count = member.element.segments if cut or not member.element.exact else 1
            pieces_of[name] = range(len(pieces), len(pieces) + count)
            if count == 1:
                pieces.append(Piece(name, 0, 1, member.element, (number[member.start], number[member.end])))
                continue
            start, end = frame.nodes[member.start], frame.nodes[member.end]
            chain = [number[member.start]]
            for index in range(1, count):
                chain.append(len(number))
                number[f"{name}.{index}"] = len(number)
                bodies.append(_shared(start, end))
            chain.append(number[member.end])
            pieces += [
                Piece(name, i, count, member.element.part(i, count), nodes) for i, nodes in enumerate(pairwise(chain))
            ]
        return cls(frame, number, bodies, pieces, pieces_of)

    @cached_property
    def groups(self) -> list[Group]:
        """Pieces gathered by kind, geometry shape and bodies."""
        kinds: dict[Hashable, int] = {}
        kind = {key: kinds.setdefault(element.kind, len(kinds)) for key, element in self._elements.items()}
        codes = np.array([kind[id(piece.element)] for piece in self.pieces], dtype=np.int64)
        chords = self._chords
        if not isinstance(chords, np.ndarray):
            keys: dict[Hashable, int] = {}
            ends = ((self.bodies[a], self.bodies[b]) for a, b in self.ends.tolist())
            where = zip(codes.tolist(), (chord.shape for chord in chords), ends, strict=True)
            codes = np.array([keys.setdefault(key, len(keys)) for key in where], dtype=np.int64)
        members = np.split(np.argsort(codes, kind="stable"), np.cumsum(np.bincount(codes))[:-1])
        return [self._group(numbers, chords) for numbers in members if len(numbers)]

    @property
    def _elements(self) -> dict[int, LineElement]:
        return {id(piece.element): piece.element for piece in self.pieces}

    @cached_property
    def _chords(self) -> Array | list[Array]:
        """Chord of each piece's member, (..., 3)."""
        nodes = self.frame.nodes.values()
        if any(node.body is not None or node.coordinates.ndim > 1 for node in nodes):
            chords = {name: self.frame.chord(name) for name in self.frame.members}
            return [chords[piece.member] for piece in self.pieces]
        coordinates = np.array([node.coordinates for node in nodes]).reshape(-1, 3)
        members = self.frame.members.values()
        ends = np.array([(self.number[m.start], self.number[m.end]) for m in members], dtype=np.int64).reshape(-1, 2)
        chord = coordinates[ends[:, 1]] - coordinates[ends[:, 0]]
        return np.repeat(chord, [len(pieces) for pieces in self.pieces_of.values()], axis=0)

    def _group(self, numbers: Index, chords: Array | list[Array]) -> Group:
        ndim = len(self.frame.shape)
        standing = self.pieces[numbers[0]]
        if isinstance(chords, np.ndarray):
            chord = chords[numbers].reshape(-1, *(1,) * ndim, 3)
        else:
            chord = np.stack([aligned(chords[k], ndim, 1) for k in numbers])
        rows = standing.element.axes(chord)
        counts = np.array([float(self.pieces[k].count) for k in numbers]).reshape(-1, *(1,) * ndim)
        length = np.linalg.norm(chord, axis=-1) / counts
        first, second = (self.bodies[node] for node in standing.nodes)
        if first == second:
            turns, level = (rows, rows), self._in_body(rows, first, back=True)
        else:
            turns, level = (self._in_body(rows, first), self._in_body(rows, second)), rows
        nodes = self.ends[numbers]
        dofs = (6 * nodes[:, :, None] + np.arange(6)).reshape(-1, 12)
        return Group(standing.element, numbers, dofs, length, turns, level)

    def _in_body(self, rows: Array, body: str | None, *, back: bool = False) -> Array:
        """Axes given as rows in global components, in those of `body`; the other way round for `back`."""
        if body is None:
            return rows
        axes = aligned(self.frame.bodies[body].axes, len(self.frame.shape), 2)
        return rows @ (np.swapaxes(axes, -1, -2) if back else axes)

    def axes(self, node: int) -> Array | None:
        """Axes of a node as columns (..., 3, 3), None where they are the global ones."""
        body = self.bodies[node]
        return None if body is None else aligned(self.frame.bodies[body].axes, len(self.frame.shape), 2)

    def position(self, node: int) -> Array:
        """Global position of a described node, (..., 3), with all batch axes."""
        return aligned(self.frame.position(self.names[node]), len(self.frame.shape), 1)

    @cached_property
    def names(self) -> list[str]:
        """Names of all nodes, those of the frame first."""
        return list(self.number)

    @cached_property
    def ends(self) -> Index:
        """Node numbers of all pieces, (pieces, 2)."""
        return np.array([piece.nodes for piece in self.pieces], dtype=np.int64).reshape(-1, 2)

    @cached_property
    def points(self) -> Array:
        """Positions of all nodes at the first batch entry, (nodes, 3)."""
        points = np.zeros((len(self.number), 3))
        for index, name in enumerate(self.frame.nodes):
            points[index] = self.frame.position(name).reshape(-1, 3)[0]
        for piece in self.pieces:
            if piece.count > 1:
                ends = self.frame.members[piece.member]
                a, b = (points[self.number[node]] for node in (ends.start, ends.end))
                points[piece.nodes[0]] = a + (b - a) * (piece.index / piece.count)
        return points

    @cached_property
    def mesh(self) -> Any:
        """The first batch entry as a scikit-fem ``MeshLine1`` with subdomains ``beam`` and ``joint``."""
        from skfem import MeshLine1

        joints = [(self.number[j.first], self.number[j.second]) for j in self.frame.joints.values()]
        cells = np.concatenate([self.ends, np.array(joints, dtype=np.int64).reshape(-1, 2)]).T
        beam = np.arange(len(self.pieces))
        parts = {"beam": beam, "joint": np.arange(len(self.pieces), cells.shape[1])}
        points = np.ascontiguousarray(self.points.T)
        return MeshLine1(points, np.ascontiguousarray(cells), sort_t=False, validate=False).with_subdomains(parts)

    @cached_property
    def numbering(self) -> Any:
        """scikit-fem ``Dofs`` of the mesh, six named DOFs a node: ``numbering.get_vertex_dofs(...).all(['ux'])``."""
        from skfem import Dofs, ElementLineP1, ElementVector

        element = ElementVector(ElementLineP1(), 6)
        element.dofnames = list(DISPLACEMENTS)
        return Dofs(self.mesh, element)


def _shared(start: Node, end: Node) -> str | None:
    return start.body if start.body == end.body else None
