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
from .protocol import LineElement

if TYPE_CHECKING:
    from .frame import Frame, Node

Index = NDArray[np.int64]


@dataclass(frozen=True)
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

    @cached_property
    def transform(self) -> Array:
        """From displacements in the nodes' axes to local ones, (n, ..., 12, 12)."""
        start, end = self.turns
        return block_diagonal((start, start, end, end))

    @property
    def stiffness_shape(self) -> tuple[int, ...]:
        """Batch shape over which the stiffness of a piece varies."""
        return np.broadcast_shapes(self.transform.shape[1:-2], self.length.shape[1:], self.element.shape)

    def turned(self, local: Array) -> Array:
        """Local matrices (n, ..., 12, 12) in the nodes' axes."""
        return np.swapaxes(self.transform, -1, -2) @ local @ self.transform

    def stiffness(self) -> Array:
        """Stiffness in the nodes' axes, (n, ..., 12, 12)."""
        return self.turned(self.element.stiffness_matrix(self.length))

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
            start, end = frame.nodes[member.start], frame.nodes[member.end]
            chain = [number[member.start]]
            for index in range(1, count):
                chain.append(len(number))
                number[f"{name}.{index}"] = len(number)
                bodies.append(_shared(start, end))
            chain.append(number[member.end])
            pieces_of[name] = range(len(pieces), len(pieces) + count)
            pieces += [
                Piece(name, i, count, member.element.part(i, count) if count > 1 else member.element, nodes)
                for i, nodes in enumerate(pairwise(chain))
            ]
        return cls(frame, number, bodies, pieces, pieces_of)

    @cached_property
    def groups(self) -> list[Group]:
        """Pieces gathered by kind, geometry shape and bodies."""
        kinds: dict[Hashable, list[int]] = {}
        chords: dict[str, Array] = {name: self.frame.chord(name) for name in self.frame.members}
        for index, piece in enumerate(self.pieces):
            first, second = (self.bodies[node] for node in piece.nodes)
            key = (piece.element.kind, chords[piece.member].shape, first, second)
            kinds.setdefault(key, []).append(index)
        return [self._group(np.array(members), chords) for members in kinds.values()]

    def _group(self, numbers: Index, chords: dict[str, Array]) -> Group:
        pieces = [self.pieces[k] for k in numbers]
        ndim = len(self.frame.shape)
        chord = np.stack([aligned(chords[p.member], ndim, 1) for p in pieces])
        rows = pieces[0].element.axes(chord)
        counts = np.array([float(p.count) for p in pieces]).reshape(-1, *(1,) * ndim)
        length = np.linalg.norm(chord, axis=-1) / counts
        first, second = (self.bodies[node] for node in pieces[0].nodes)
        if first == second:
            turns, level = (rows, rows), self._in_body(rows, first, back=True)
        else:
            turns, level = (self._in_body(rows, first), self._in_body(rows, second)), rows
        nodes = np.array([p.nodes for p in pieces])
        dofs = (6 * nodes[:, :, None] + np.arange(6)).reshape(-1, 12)
        return Group(pieces[0].element, numbers, dofs, length, turns, level)

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
        return aligned(self.frame.position(list(self.number)[node]), len(self.frame.shape), 1)

    @cached_property
    def mesh(self) -> Any:
        """The first batch entry as a scikit-fem ``MeshLine1`` with subdomains ``beam`` and ``joint``."""
        from skfem import MeshLine1

        points = np.zeros((3, len(self.number)))
        for name in self.frame.nodes:
            points[:, self.number[name]] = self.frame.position(name).reshape(-1, 3)[0]
        for piece in self.pieces:
            ends = self.frame.members[piece.member]
            a, b = (points[:, self.number[node]] for node in (ends.start, ends.end))
            points[:, piece.nodes[0]] = a + (b - a) * (piece.index / piece.count)
        joints = [(self.number[j.first], self.number[j.second]) for j in self.frame.joints.values()]
        cells = np.array([p.nodes for p in self.pieces] + joints, dtype=np.int64).reshape(-1, 2).T
        beam = np.arange(len(self.pieces))
        parts = {"beam": beam, "joint": np.arange(len(self.pieces), cells.shape[1])}
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
