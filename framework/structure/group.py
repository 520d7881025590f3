"""Pieces of equal kind as one stack: their axes, and their matrices in the axes of their nodes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import ZERO, Array, rotated
from ..entries import Stretch
from ..examined import Examined
from ..lazily import cached_property
from ..protocol import LineElement
from .parts import Extended, Grid

Index = NDArray[np.int64]

# Stiffness matrices up to which a stack is summed in extended precision.
_EXTENDED = 4096
ALL = slice(None)
# Stiffness matrices up to which it takes longer to skip what is zero than to rotate it.
_TOGETHER = 128
# Share of what a deformation is made of that a rigid motion surely makes of it, and no rounding.
_PLAIN = 1e-6
# Members times batch entries up to which their springs are kept.
_KEPT = 2**14
# Batch entries of which springs are looked at together.
_SOME = 2**13


def resists_rigid(stiffness: NDArray[Any], rows: NDArray[Any], length: NDArray[Any], share: float) -> bool:
    """Whether any rigid motion of members deforms a spring, by more than a share of what its deformation is made of.

    Parameters
    ----------
    stiffness, rows
        Springs (..., n) and deformations (..., n, 12) of members in local axes.
    length
        Their lengths (...).
    share
        What of the deformation is rounding.
    """
    acts = (stiffness != 0.0).reshape(-1, stiffness.shape[-1]).any(axis=0)
    start, end = rows[..., acts, :6], rows[..., acts, 6:]
    arm = length[..., None]
    for k in range(6):
        parts = [start[..., k], end[..., k]]
        if k > 3:
            parts.append(-arm * end[..., 2] if k == 4 else arm * end[..., 1])
        if np.any(np.abs(sum(parts)) > share * sum(map(np.abs, parts))):
            return True
    return False


@dataclass(frozen=True, eq=False)
class Group:
    """Pieces of equal kind as one stack; what follows from their chords is computed when it is asked for.

    Attributes
    ----------
    element
        Stands for them all; where they differ in their numbers, these are arrays (n, ...).
    pieces
        Their numbers (n,).
    dofs
        Their DOF numbers (n, 12).
    chord
        From start to end of their members (n, ..., 3), in the axes of `body` where both nodes are on one.
    counts
        Number of pieces of their members, (n, 1...).
    axes
        Axes of their start and end nodes as columns (..., 3, 3) in those of the chord, None where these are the same.
    body
        Axes of their body as columns (..., 3, 3), None where there is none.
    """

    element: LineElement
    pieces: Index
    dofs: Index
    chord: Array
    counts: Array
    axes: tuple[Array | None, Array | None]
    body: Array | None

    @cached_property
    def rows(self) -> Array:
        """The local axes as rows (n, ..., 3, 3), in those of the chord."""
        return self.element.axes(self.chord)

    @cached_property
    def length(self) -> Array:
        """Their lengths (n, ...)."""
        # as np.linalg.norm has it, without its overhead, and in a third of the time of a sum along an axis of three
        square = self.chord * self.chord
        length: Array = np.sqrt(square[..., 0] + square[..., 1] + square[..., 2]) / self.counts
        return length

    @cached_property
    def springs(self) -> tuple[Array, Array] | None:
        """Stiffness of the springs (n, ..., springs) and deformations (n, ..., springs, 12) by displacements in local
        axes, each at the batch shape that it varies over; None where that is too much to be kept."""
        entries = math.prod(_widened(self.chord.shape[1:-1], self.shape))
        return self.element.springs(self.length) if len(self.pieces) * entries <= _KEPT else None

    @cached_property
    def spring_stiffness(self) -> Array | None:
        """The first of `springs`, which does not take the second."""
        if "springs" in vars(self):
            return None if self.springs is None else self.springs[0]
        entries = math.prod(_widened(self.chord.shape[1:-1], self.shape))
        return self.element.spring_stiffness(self.length) if len(self.pieces) * entries <= _KEPT else None

    @cached_property
    def end_axes(self) -> tuple[Array, Array]:
        """For start and end: the local axes as rows (n, ..., 3, 3) in the axes of that node."""
        start, end = [self.rows if axes is None else self.rows @ axes for axes in self.axes]
        return start, end

    @property
    def nodes(self) -> Index:
        """Node numbers of their ends (n, 2)."""
        return self.dofs[:, ::6] // 6

    @cached_property
    def local_axes(self) -> Array:
        """The local axes as rows (n, ..., 3, 3) in global axes."""
        return self.rows if self.body is None else self.rows @ np.swapaxes(self.body, -1, -2)

    def local(self, position: int, nodal: Array) -> Array:
        """Displacements (..., 12) of the nodes of one piece, in their axes, as local ones."""
        start, end = (
            rotated(turn[position], part) for turn, part in zip(self.end_axes, np.split(nodal, 2, -1), strict=True)
        )
        return np.concatenate([start, end], axis=-1)

    def nodal(self, positions: Index, local: Array) -> Array:
        """Local forces (n, ..., 12) of some pieces in the axes of their nodes."""
        ends = zip(self.end_axes, np.split(local, 2, -1), strict=True)
        return np.concatenate([rotated(np.swapaxes(turn[positions], -1, -2), part) for turn, part in ends], axis=-1)

    @property
    def stacked(self) -> bool:
        """Whether parameters of the element have an axis for the pieces."""
        return len(self.element.shape) > self.chord.ndim - 2

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the elements' own parameters."""
        return self.element.shape[1:] if self.stacked else self.element.shape

    def of(self, at: int | slice | Index) -> LineElement:
        """The element of some of the pieces, by their positions."""
        if not self.stacked:
            return self.element
        ndim = self.chord.ndim - 2
        return self.element.cut(lambda array, trailing: array[at] if array.ndim - trailing > ndim else array)

    @cached_property
    def stiffness_shape(self) -> tuple[int, ...]:
        """Batch shape over which the stiffness of a piece varies."""
        rotated = [axes.shape[:-2] for axes in self.axes if axes is not None]
        return _widened(self.chord.shape[1:-1], *rotated, self.shape)

    def in_node_axes(self, local: Array, end_axes: tuple[Array, Array] | None = None) -> Array:
        """Symmetric local matrices (n, ..., 12, 12) in the nodes' axes: ``T^T A T``, skipping what is zero.

        `end_axes` are those of the entries that the matrices are for, of all where None.
        """
        ends = [np.ascontiguousarray(np.moveaxis(turn, (-2, -1), (0, 1))) for turn in end_axes or self.end_axes]
        batch = np.broadcast_shapes(local.shape[:-2], *(turn.shape[2:] for turn in ends))
        if math.prod(batch) <= _TOGETHER:
            return _rotated_together(local, ends)
        out = np.zeros((12, 12, *batch))
        used = (local != 0.0).reshape(-1, 12, 12).any(axis=0)
        for i, block in zip(*np.nonzero(used.reshape(12, 4, 3).any(axis=-1)), strict=True):
            p, q = 3 * (i // 3), 3 * block
            if p <= q:
                row = sum(local[..., i, q + k] * ends[q // 6][k] for k in range(3) if used[i, q + k])
                out[p : p + 3, q : q + 3] += ends[p // 6][i - p][:, None] * row
        low, high = np.tril_indices(12, -1)
        out[low, high] = out[high, low]
        return np.moveaxis(out, (0, 1), (-2, -1))

    @cached_property
    def resists(self) -> bool:
        """Whether its pieces, by the first of them, resist rigid motion: no more than rounding where they do not."""
        if self.element.balanced is not None:
            return not self.element.balanced
        one, ndim = self.part(slice(0, 1)), self.chord.ndim - 2
        batch = np.broadcast_shapes(self.chord.shape[1:-1], self.shape)
        if math.prod(batch) <= _SOME:
            return one.resists_by_springs()
        axis, slices = Grid((1,) * (ndim - len(batch)) + batch).slices(_SOME)
        return any(one.cut(axis, indices).resists_by_springs() for indices in slices)

    def resists_by_springs(self) -> bool:
        """Whether a rigid motion deforms the springs of its pieces."""
        return resists_rigid(*self.element.springs(self.length), self.length, _PLAIN)

    @cached_property
    def has_foundation(self) -> bool:
        """Whether something outside the frame holds its pieces between their ends, as a foundation does."""
        return isinstance(self.element, Examined) and self.resists

    @property
    def strained(self) -> bool:
        """Whether its pieces strain without forces, as by heat."""
        return self.element.free_strain(ZERO) is not None

    def between(self, chord: Array, element: LineElement | None = None) -> Group:
        """The same pieces along other chords, and of another element where one is given."""
        own = self.element if element is None else element
        return Group(own, self.pieces, self.dofs, chord, self.counts, self.axes, self.body)

    def part(self, part: slice | Index) -> Group:
        """Some of the pieces as a stack of their own."""
        pieces, dofs, counts = self.pieces[part], self.dofs[part], self.counts[part]
        return Group(self.of(part), pieces, dofs, self.chord[part], counts, self.axes, self.body)

    def cut(self, axis: int, indices: slice) -> Group:
        """The pieces at some indices of a batch axis."""
        change = Stretch(ndim=self.chord.ndim - 2, axis=axis, indices=indices)
        start, end, body = (None if axes is None else change(axes, 2) for axes in (*self.axes, self.body))
        return replace(
            self, element=self.element.cut(change), chord=change(self.chord, 1), axes=(start, end), body=body
        )

    def stiffness(self, part: slice = ALL) -> Array:
        """Stiffness of the pieces, or of some of them, in the nodes' axes, (n, ..., 12, 12)."""
        some = self.part(part)
        return some.in_node_axes(some.element.stiffness_matrix(some.length))

    def mass(self, part: slice = ALL) -> Array:
        """Mass of the pieces, or of some of them, in the nodes' axes, (n, ..., 12, 12)."""
        some = self.part(part)
        return some.in_node_axes(some.element.mass_matrix(some.length))

    def extended_stiffness(self) -> NDArray[Any]:
        """Stiffness in the nodes' axes, (n, ..., 12, 12), summed in extended precision where it is not a large stack.

        As a sum of springs on deformations it keeps, to the square of rounding, that a rigid motion costs no energy.
        """
        stiffness, rows = self.element.springs(self.length)
        kind = Extended if stiffness[..., 0].size <= _EXTENDED else np.float64
        rotated: NDArray[Any] = _by_nodes(rows, *self.end_axes).astype(kind)
        weighted: NDArray[Any] = stiffness.astype(kind)[..., None] * rotated
        one, other = rotated.mT, weighted.mT
        # of numbers in extended precision row by row is a third quicker, in the same order
        extended = kind is Extended
        out: NDArray[Any] = np.vecdot(one[..., None, :], other[..., None, :, :]) if extended else one @ weighted
        return out


def _by_nodes(rows: Array, start: Array, end: Array) -> Array:
    """Deformations by displacements in the axes of the nodes, from deformations by displacements in local axes.

    Both are (..., springs, 12); `start` and `end` hold the local axes as rows, in the axes of the nodes, (..., 3, 3).
    """
    if start is not end:
        return np.concatenate([_by_nodes(rows[..., :6], start, start), _by_nodes(rows[..., 6:], end, end)], axis=-1)
    *shape, springs, dofs = rows.shape
    out: Array = rows.reshape(*shape, springs * dofs // 3, 3) @ start
    return out.reshape(*out.shape[:-2], springs, dofs)


def _rotated_together(local: Array, ends: list[Array]) -> Array:
    """``T^T A T`` of symmetric matrices (..., 12, 12), in the order of `Group.in_node_axes`, what is zero as well.

    `ends` are the rotations of start and end, (3, 3, ...).
    """
    start, end = ends
    turn = np.stack(np.broadcast_arrays(start, start, end, end))
    blocks = np.ascontiguousarray(np.moveaxis(local, (-2, -1), (0, 1)))
    blocks = blocks.reshape(4, 3, 4, 3, *blocks.shape[2:])
    right = _thrice(blocks[:, :, :, k, None] * turn[:, k] for k in range(3))
    whole = _thrice(turn[:, i, :, None, None] * right[:, None, i] for i in range(3))
    out = whole.reshape(12, 12, *whole.shape[4:])
    low, high = np.tril_indices(12, -1)
    out[low, high] = out[high, low]
    return np.moveaxis(out, (0, 1), (-2, -1))


def _thrice(terms: Iterator[Array]) -> Array:
    """A sum of three terms from zero on, one after the other."""
    out: Array = 0.0 + next(terms)
    for term in terms:
        out += term
    return out


def _widened(whole: tuple[int, ...], *others: tuple[int, ...]) -> tuple[int, ...]:
    """`np.broadcast_shapes`, which takes longer than the rest where next to nothing varies."""
    wider = {*others} - {whole, (1,) * len(whole), ()}
    if not wider:
        return whole
    if len(wider) == 1 and set(whole) == {1} and len(widest := next(iter(wider))) == len(whole):
        return widest
    return np.broadcast_shapes(whole, *wider)
