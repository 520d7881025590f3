"""A group of similar members, evaluated as one stack: their axes, springs and matrices.

A piece is a whole member, or one of its segments where members are divided.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import ZERO, Array, rotated
from ..entries import Stretch
from ..examined import Examined
from ..lazily import cached_property
from ..protocol import LineElement
from ..shape_rules import spring_forces
from .parts import Extended, Grid

Index = NDArray[np.int64]

# Stacks of up to this many stiffness matrices are summed in extended precision.
EXTENDED = 4096
ALL = slice(None)
# Up to this many matrices it is faster to rotate all entries than to skip those that are zero.
_TOGETHER = 128
# A deformation by a rigid motion that exceeds this share of the sum of its terms' magnitudes is not rounding.
_PLAIN = 1e-6
# The springs of a group are kept for up to this number of members times batch entries.
_KEPT = 2**14
# Springs are examined for this many batch entries at a time.
_SOME = 2**13


def resists_rigid(stiffness: NDArray[Any], rows: NDArray[Any], length: NDArray[Any], share: float) -> bool:
    """Whether any rigid motion of members deforms a spring by more than rounding.

    Parameters
    ----------
    stiffness, rows
        Spring stiffnesses (..., n) and deformations per unit end displacement (..., n, 12) in local axes.
    length
        Lengths of the members (...).
    share
        A deformation up to this share of the sum of its terms' magnitudes is rounding.
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
    """A stack of n pieces with similar elements; properties are computed when they are first read.

    Attributes
    ----------
    element
        One element for all pieces; where pieces differ in numbers, its parameters are arrays (n, ...).
    pieces
        Numbers of the pieces, (n,).
    dofs
        DOF numbers of the pieces, (n, 12).
    chord
        Vectors from start to end of the whole members, (n, ..., 3), in the axes of `body` if both nodes are on one.
    counts
        Numbers of pieces of the members, (n, 1...).
    axes
        Axes of the start and end nodes as columns (..., 3, 3), in those of the chord; None where they are the same.
    body
        Axes of the body that carries both nodes, as columns (..., 3, 3); None where there is none.
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
        """Local axes as rows (n, ..., 3, 3), in the axes of the chord."""
        return self.element.axes(self.chord)

    @cached_property
    def length(self) -> Array:
        """Lengths of the pieces, (n, ...)."""
        # equals np.linalg.norm, in a third of the time
        square = self.chord * self.chord
        length: Array = np.sqrt(square[..., 0] + square[..., 1] + square[..., 2]) / self.counts
        return length

    @cached_property
    def along_x(self) -> bool:
        """Whether all members lie along the x axis of the axes of the chord, as those of a body often do."""
        return bool(np.all(self.chord[..., 0] > 0.0)) and not self.chord[..., 1:].any()

    @cached_property
    def springs(self) -> tuple[Array, Array] | None:
        """Spring stiffnesses (n, ..., springs) and deformations (n, ..., springs, 12) per unit local end displacement.

        Each has the batch shape over which it varies; None where the arrays are too large to be kept.
        """
        entries = math.prod(_widened(self.chord.shape[1:-1], self.shape))
        return self.element.springs(self.length) if len(self.pieces) * entries <= _KEPT else None

    @cached_property
    def spring_numbers(self) -> tuple[Sequence[Array | float], Mapping[tuple[int, int], Array | float]]:
        """The values of `springs` one by one, see `LineElement.spring_numbers`."""
        return self.element.spring_numbers(self.length)

    @cached_property
    def deformation_numbers(self) -> Mapping[tuple[int, int], Array | float] | None:
        """Deformations of the springs one by one, see `LineElement.deformation_numbers`.

        None unless each displacement or rotation of an end, a vector, deforms a spring by one of its local components
        alone: then deformations in the nodes' axes are products of one of these numbers with one of the axes'.
        """
        found = self.element.deformation_numbers(self.length)
        vectors = {(spring, dof // 3) for spring, dof in found}
        return found if len(vectors) == len(found) else None

    @cached_property
    def spring_stiffness(self) -> Array | None:
        """Spring stiffnesses as in `springs`, computed without the deformations."""
        if "springs" in vars(self):
            return None if self.springs is None else self.springs[0]
        entries = math.prod(_widened(self.chord.shape[1:-1], self.shape))
        return self.element.spring_stiffness(self.length) if len(self.pieces) * entries <= _KEPT else None

    @cached_property
    def end_axes(self) -> tuple[Array, Array]:
        """Local axes as rows, in the axes of the start node and in those of the end node, (n, ..., 3, 3) each."""
        rows, (start, end) = self.rows, self.axes
        return rows if start is None else rows @ start, rows if end is None else rows @ end

    @property
    def axis_components(self) -> list[Array]:
        """The components of `end_axes`, row by row, (9, n, ...); those of the end only where they differ."""
        if all(axes is None for axes in self.axes) and "rows" not in vars(self):
            out = np.empty((9, *self.chord.shape[:-1]))
            for k, number in enumerate(self.element.axis_numbers(self.chord)):
                out[k] = number
            return [out]
        start, end = self.end_axes
        each = [start] if end is start else [start, end]
        return [axes.reshape(*axes.shape[:-2], 9).transpose(-1, *range(axes.ndim - 2)) for axes in each]

    @property
    def nodes(self) -> Index:
        """Node numbers of the ends, (n, 2)."""
        return self.dofs[:, ::6] // 6

    @cached_property
    def local_axes(self) -> Array:
        """Local axes as rows (n, ..., 3, 3), in global axes."""
        return self.rows if self.body is None else self.rows @ np.swapaxes(self.body, -1, -2)

    def local(self, position: int, nodal: Array) -> Array:
        """Displacements (..., 12) of the nodes of one piece, given in the nodes' axes, in local axes."""
        start, end = (
            rotated(turn[position], part) for turn, part in zip(self.end_axes, np.split(nodal, 2, -1), strict=True)
        )
        return np.concatenate([start, end], axis=-1)

    def nodal(self, positions: Index, local: Array) -> Array:
        """Forces (n, ..., 12) on the ends of some pieces, given in local axes, in the axes of the nodes."""
        ends = zip(self.end_axes, np.split(local, 2, -1), strict=True)
        return np.concatenate([rotated(np.swapaxes(turn[positions], -1, -2), part) for turn, part in ends], axis=-1)

    @property
    def stacked(self) -> bool:
        """Whether parameters of the element have a leading axis for the pieces."""
        return len(self.element.shape) > self.chord.ndim - 2

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape of the elements' parameters, without the axis for the pieces."""
        return self.element.shape[1:] if self.stacked else self.element.shape

    def of(self, at: int | slice | Index) -> LineElement:
        """The element of some of the pieces, by their positions."""
        if not self.stacked:
            return self.element
        ndim = self.chord.ndim - 2
        return self.element.cut(lambda array, trailing: array[at] if array.ndim - trailing > ndim else array)

    def end_forces(self, at: Index, displacement: Array) -> Array:
        """Forces (n, ..., 12) on the ends of some pieces, by those ends' displacements (n, ..., 12), in local axes.

        By springs where the element has no closed form: its scikit-fem form takes ten to eighty times as long.
        """
        element, length = self.of(at), self.length[at]
        if element.has_end_forces:
            return element.end_forces(length, displacement)
        return spring_forces(*element.springs(length), displacement)

    @cached_property
    def stiffness_shape(self) -> tuple[int, ...]:
        """Batch shape over which the stiffness of a piece varies."""
        rotated = [axes.shape[:-2] for axes in self.axes if axes is not None]
        return _widened(self.chord.shape[1:-1], *rotated, self.shape)

    def in_node_axes(self, local: Array, end_axes: tuple[Array, Array] | None = None) -> Array:
        """Symmetric local matrices (n, ..., 12, 12) in the nodes' axes: ``T^T A T``, skipping zero entries.

        `end_axes` are the axes at the batch entries of the matrices; None for those of all entries.
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
        """Whether the pieces resist rigid motion by more than rounding, judged by the first of them."""
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
        """Whether something outside the frame supports the pieces between their ends, such as an elastic foundation."""
        return isinstance(self.element, Examined) and self.resists

    @property
    def strained(self) -> bool:
        """Whether the pieces have a free strain, such as by heat."""
        return self.element.free_strain(ZERO) is not None

    def between(self, chord: Array, element: LineElement | None = None) -> Group:
        """The same pieces with other chords, and with another element where one is given."""
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

    def turned_springs(self) -> tuple[Array, Array, bool]:
        """Spring stiffnesses (n, ..., springs), their deformations (n, ..., springs, 12) per unit displacement in the
        nodes' axes, and whether the stiffness of the pieces is summed in extended precision.
        """
        stiffness, rows = self.element.springs(self.length)
        return stiffness, _by_nodes(rows, *self.end_axes), precise(stiffness)

    def extended_stiffness(self) -> NDArray[Any]:
        """Stiffness in the nodes' axes, (n, ..., 12, 12), summed in extended precision unless the stack is large.

        As a sum over springs it preserves, to the square of rounding, that a rigid motion costs no energy.
        """
        stiffness, deformations, precise = self.turned_springs()
        kind = Extended if precise else np.float64
        rotated: NDArray[Any] = deformations.astype(kind)
        weighted: NDArray[Any] = stiffness.astype(kind)[..., None] * rotated
        one, other = rotated.mT, weighted.mT
        # in extended precision products of rows are a third faster, and sum in the same order
        extended = kind is Extended
        out: NDArray[Any] = np.vecdot(one[..., None, :], other[..., None, :, :]) if extended else one @ weighted
        return out


def precise(stiffness: Array) -> bool:
    """Whether matrices of springs of a stiffness (n, ..., springs) are summed in extended precision."""
    return stiffness[..., 0].size <= EXTENDED


def _by_nodes(rows: Array, start: Array, end: Array) -> Array:
    """Deformations per unit displacement in the nodes' axes, from `rows` per unit displacement in local axes.

    Both are (..., springs, 12); `start` and `end` hold the local axes as rows, in the axes of the nodes, (..., 3, 3).
    """
    if start is not end:
        return np.concatenate([_by_nodes(rows[..., :6], start, start), _by_nodes(rows[..., 6:], end, end)], axis=-1)
    *shape, springs, dofs = rows.shape
    out: Array = rows.reshape(*shape, springs * dofs // 3, 3) @ start
    return out.reshape(*out.shape[:-2], springs, dofs)


def _rotated_together(local: Array, ends: list[Array]) -> Array:
    """``T^T A T`` of symmetric matrices (..., 12, 12), summed in the order of `Group.in_node_axes`, zeros included.

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
    """The sum of three terms, added to zero one after the other."""
    out: Array = 0.0 + next(terms)
    for term in terms:
        out += term
    return out


def _widened(whole: tuple[int, ...], *others: tuple[int, ...]) -> tuple[int, ...]:
    """`numpy.broadcast_shapes`, with fast paths for the usual cases in which little varies."""
    wider = {*others} - {whole, (1,) * len(whole), ()}
    if not wider:
        return whole
    if len(wider) == 1 and set(whole) == {1} and len(widest := next(iter(wider))) == len(whole):
        return widest
    return np.broadcast_shapes(whole, *wider)
