"""Numbering of nodes and of pieces of members, and the scikit-fem mesh of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from ..batch import Array, aligned, distinct
from ..described.parts import Node
from ..description import Description
from ..lazily import cached_property
from .group import Index
from .mesh import line_mesh, numbered


@dataclass(eq=False)
class NumberedPieces:
    """Numbered nodes and pieces; a piece is a whole member or one of its segments.

    Attributes
    ----------
    number
        Node number by name; interior nodes of members are named ``member.1``, ``member.2``, ...
    bodies
        Name of the body of each node; None for global coordinates.
    counts
        Number of pieces of each member, (members,); the pieces of a member have consecutive numbers.
    ends
        Node numbers of all pieces, (pieces, 2).
    """

    frame: Description
    number: dict[str, int]
    bodies: list[str | None]
    counts: Index
    ends: Index

    @classmethod
    def of(cls, frame: Description, *, cut: bool) -> Self:
        """Number the nodes of a frame, and divide members into their segments.

        With `cut` False members are divided only if a single piece is not exact in statics.
        """
        number = {name: index for index, name in enumerate(frame.nodes)}
        bodies = [node.body for node in frame.nodes.values()]
        members = frame.members
        elements = [member.element for member in members.values()]
        leaders, which = found = distinct(elements)
        segments = [e.segments if cut or not e.exact else 1 for e in (elements[k] for k in leaders)]
        counts = np.array(segments, dtype=np.int64)[which]
        if all(segment == 1 for segment in segments):
            pairs = [(number[member.start], number[member.end]) for member in members.values()]
            whole = cls(frame, number, bodies, counts, _pairs(pairs))
            whole.distinct_elements = found
            return whole
        first, last = ([number[node] for node in side] for side in _sides(frame))
        # Interior nodes come after all others, member by member.
        inner = np.cumsum(counts - 1) - (counts - 1) + len(number)
        index = index_in_member(counts)
        begin, end, inner, count = (np.repeat(part, counts) for part in (first, last, inner, counts))
        ends = np.stack([np.where(index == 0, begin, inner + index - 1),
                         np.where(index == count - 1, end, inner + index)], axis=1)  # fmt: skip
        for (name, member), parts in zip(members.items(), counts.tolist(), strict=True):
            shared = _shared(frame.nodes[member.start], frame.nodes[member.end])
            for k in range(1, parts):
                number[f"{name}.{k}"] = len(number)
                bodies.append(shared)
        return cls(frame, number, bodies, counts, ends.astype(np.int64))

    @cached_property
    def distinct_elements(self) -> tuple[list[int], Index]:
        """The first member with each distinct element, and for each member the index of its element among these."""
        return distinct([member.element for member in self.frame.members.values()])

    @cached_property
    def pieces_of(self) -> dict[str, range]:
        """Range of piece numbers of each member, by name."""
        last = np.cumsum(self.counts)
        ranges = map(range, (last - self.counts).tolist(), last.tolist())
        return dict(zip(self.frame.members, ranges, strict=True))

    @cached_property
    def members(self) -> Index:
        """Member number of each piece, (pieces,)."""
        each = np.arange(len(self.counts))
        return each if len(self.ends) == len(each) else np.repeat(each, self.counts)

    @cached_property
    def plain_positions(self) -> Array | None:
        """Positions of the described nodes, (nodes, 3); None where one is on a body or varies over the batch."""
        nodes = self.frame.nodes.values()
        plain = [node.coordinates for node in nodes if node.body is None and node.coordinates.ndim == 1]
        if len(plain) < len(nodes):
            return None
        return np.concatenate(plain).reshape(-1, 3) if plain else np.zeros((0, 3))

    def plain_chords(self, kind: type[np.floating[Any]]) -> Array | None:
        """Chord of each piece's member in a given precision, (pieces, 3); None where `plain_positions` is None."""
        if self.plain_positions is None:
            return None
        plain = self.plain_positions.astype(kind, copy=False)
        if len(self.ends) == len(self.counts):
            both = plain.take(self.ends, axis=0)
            return both[:, 1] - both[:, 0]
        first, last = ([self.number[node] for node in side] for side in _sides(self.frame))
        return (plain[last] - plain[first])[self.members]

    def axes(self, node: int) -> Array | None:
        """Axes of a node as columns in global components, (..., 3, 3); None for the global axes."""
        return self.axes_of[self.bodies[node]]

    @cached_property
    def axes_of(self) -> dict[str | None, Array | None]:
        """Axes of the bodies by name, as columns (..., 3, 3); None for the global axes, those of nodes on no body."""
        bodies, ndim = self.frame.bodies.items(), len(self.frame.shape)
        return {None: None} | {name: aligned(body.axes, ndim, 2) for name, body in bodies}

    def position(self, node: int) -> Array:
        """Global position of a described node, (..., 3), with all batch axes."""
        return aligned(self.frame.position(self.names[node]), len(self.frame.shape), 1)

    @cached_property
    def names(self) -> list[str]:
        """Names of all nodes by number, those of the description first."""
        return list(self.number)

    @cached_property
    def points(self) -> Array:
        """Positions of all nodes at the first batch entry, (nodes, 3)."""
        described = self.plain_positions
        if described is None:
            described = np.stack([self.frame.position(name).reshape(-1, 3)[0] for name in self.frame.nodes])
        first, last = ([self.number[node] for node in side] for side in _sides(self.frame))
        index = index_in_member(self.counts)
        inner = index > 0
        member, share = self.members[inner], index[inner] / self.counts[self.members[inner]]
        start, end = described[first][member], described[last][member]
        return np.concatenate([described, start + (end - start) * share[:, None]])

    @cached_property
    def mesh(self) -> Any:
        """The first batch entry as a scikit-fem ``MeshLine1``.

        Pieces of members, joints and, where there are any, rigid links are its subdomains ``beam``, ``joint`` and
        ``rigid``; so are each member and joint by its name and, unless a member or joint has that name, each body with
        the members on it. Supported nodes are its boundaries.
        """
        frame, number = self.frame, self.number
        joints = [(number[joint.first], number[joint.second]) for joint in frame.joints.values()]
        rigid = [(number[tie.master], number[tie.slave]) for tie in frame.ties if tie.rigid]
        kinds = {"beam": self.ends, "joint": _pairs(joints)} | ({"rigid": _pairs(rigid)} if rigid else {})
        names = {name: np.arange(pieces.start, pieces.stop) for name, pieces in self.pieces_of.items()}
        names |= {name: np.array([len(self.ends) + k]) for k, name in enumerate(frame.joints)}
        for body in frame.bodies:
            on = [self.bodies[a] == body == self.bodies[b] for a, b in self.ends.tolist()]
            names.setdefault(body, np.flatnonzero(on))
        return line_mesh(self.points, kinds, names, {node: number[node] for node in frame.supports})

    @cached_property
    def numbering(self) -> Any:
        """scikit-fem ``Dofs`` of the mesh, six named ones a node: ``numbering.get_vertex_dofs(...).all(['ux'])``."""
        return numbered(self.mesh)


def _pairs(ends: list[tuple[int, int]]) -> Index:
    return np.array(ends, dtype=np.int64).reshape(-1, 2)


def _shared(start: Node, end: Node) -> str | None:
    return start.body if start.body == end.body else None


def _sides(frame: Description) -> tuple[list[str], list[str]]:
    """Names of the start nodes and of the end nodes of the members."""
    members = frame.members.values()
    return [member.start for member in members], [member.end for member in members]


def index_in_member(counts: Index) -> Index:
    """Index of each piece within its member, (pieces,), for the numbers of pieces of the members."""
    return np.arange(counts.sum()) - np.repeat(np.cumsum(counts) - counts, counts)
