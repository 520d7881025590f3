"""Broadcasting LDL^T of one connected component, in two stages and by chunks.

The unknowns of nodes that no joint touches come first, in the axes of their link, so that the interior of a link is
condensed once however it moves. After the substitution ``u = T q + g`` at the nodes of joints follow the
joint-relative coordinates. Steps whose result is small are done once for the whole batch; the others chunk by chunk
along the longest axis, so that they stay in the cache. The terms of every sum are added in the same order whatever
the chunks: the same bits for every chunk size and number of threads.
"""

from __future__ import annotations

import functools
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from .batch import Array
from .order import Order
from .parts import Grid, Row, Value, add, combine, is_zero
from .stage import Forces, Matrix, Stage, closure, subtract

# Batch entries handled at a time: some dozens of arrays of this length fit the second-level cache.
CHUNK = 4096
# Factors of all chunks are kept for later questions while they take less than this many bytes.
KEEP = 2**28

Wanted = Sequence[bool]


@dataclass(frozen=True)
class Block:
    """A connected component, assembled.

    Attributes
    ----------
    grid
        The batch.
    orders
        Elimination order of the interior unknowns and of the joint-relative ones.
    matrix, forces
        Stiffness and load of the members in the nodes' axes.
    rows, shifts
        Joint-relative substitution of the displacements of nodes that have one.
    springs
        Row, stiffness and gap of each spring on the joint-relative unknowns.
    """

    grid: Grid
    orders: tuple[Order, Order]
    matrix: Matrix
    forces: Forces
    rows: dict[int, Row]
    shifts: dict[int, Value]
    springs: list[tuple[Row, Value, Value]]


@dataclass
class _Progress:
    """Both stages and what turns the first into the second, whole or cut to a chunk."""

    inner: Stage
    outer: Stage
    rows: dict[int, Row]
    shifts: dict[int, Value]
    springs: list[tuple[Row, Value, Value]]


class Factor:
    """LDL^T of a block; it answers for rows over the unknowns.

    Parameters
    ----------
    block
        What is factorised.
    chunk
        Batch entries handled at a time.
    workers
        Threads.
    """

    def __init__(self, block: Block, chunk: int = CHUNK, workers: int | None = None) -> None:
        self.block, self.workers = block, workers or min(4, os.cpu_count() or 1)
        grid = block.grid
        self.small: Wanted = [size <= chunk for size in grid.sizes]
        self.large: Wanted = [size > chunk for size in grid.sizes]
        self.axis = int(np.argmax(grid.shape)) if grid.shape else 0
        self.step = max(1, chunk * grid.shape[self.axis] // max(1, grid.sizes[-1])) if grid.shape else 1
        self._masks = _Masks(block)
        with np.errstate(all="ignore"):
            self.shared = self._run(self._start(), self.small)
        self._kept: dict[int, _Progress] = {}
        self._margins: dict[int, Array] = {}

    @property
    def chunks(self) -> int:
        """Number of chunks; 1 where all is done at once."""
        return -(-self.block.grid.shape[self.axis] // self.step) if any(self.large) else 1

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns, at the whole batch."""
        with np.errstate(all="ignore"):
            if not any(self.large):
                return self._answer(self.shared, rows)
            return self._gathered(rows)

    def margin(self) -> Array:
        """Least ratio of a pivot to its assembled diagonal, (...) of the batch shape."""
        out = np.full(self.block.grid.shape, np.inf)
        for value in _margins(self.shared):
            out = np.minimum(out, value)
        if any(self.large):
            if len(self._margins) < self.chunks:
                self._each(lambda index, progress: None)
            for index, least in self._margins.items():
                part = self._part(index)
                out[part] = np.minimum(out[part], least)
        return out

    # -- one run ----------------------------------------------------------------------------------------------------

    def _start(self) -> _Progress:
        block = self.block
        inner = Stage(block.matrix, block.forces, {i: dict(row[i]) for i, row in block.matrix.items()})
        return _Progress(inner.mapped(lambda value: value), Stage(), block.rows, block.shifts, block.springs)

    def _run(self, progress: _Progress, wanted: Wanted) -> _Progress:
        inner, outer = self.block.orders
        progress.inner.eliminate(inner, wanted)
        progress.inner.forward(inner, wanted)
        self._substitute(progress, wanted)
        self._add_springs(progress, wanted)
        progress.outer.eliminate(outer, wanted)
        progress.outer.forward(outer, wanted)
        return progress

    def _substitute(self, progress: _Progress, wanted: Wanted) -> None:
        """Add T^T K T, T^T (f - K g) and the diagonal's scale to the second stage."""
        inner, outer, masks = progress.inner, progress.outer, self._masks
        for a, row in progress.rows.items():
            for b, parts in inner.matrix.get(a, {}).items():
                shift = progress.shifts.get(b, 0.0)
                for mask, value in parts.items():
                    if not is_zero(shift) and wanted[mask | masks.shifts[b]]:
                        subtract(inner.forces.setdefault(a, {}), mask | masks.shifts[b], value * shift)
                    if b >= a and b in progress.rows:
                        self._congruence(outer, (a, row), (b, progress.rows[b]), (mask, value), wanted)
            for mask, value in inner.forces.get(a, {}).items():
                for i, factor in row.items():
                    if wanted[mask | masks.rows[a][i]]:
                        add(outer.forces.setdefault(i, {}), mask | masks.rows[a][i], combine([(factor, value)]))
            for mask, value in inner.scale.get(a, {}).items():
                for i, factor in row.items():
                    if wanted[mask | masks.rows[a][i]]:
                        term = combine([(factor, combine([(factor, value)]))])
                        add(outer.scale.setdefault(i, {}), mask | masks.rows[a][i], term)

    def _congruence(
        self, outer: Stage, left: tuple[int, Row], right: tuple[int, Row], part: tuple[int, Value], wanted: Wanted
    ) -> None:
        (a, row), (b, other), (mask, value) = left, right, part
        first, second = self._masks.rows[a], self._masks.rows[b]
        for i, factor in row.items():
            if not any(wanted[mask | first[i] | second[j]] for j in other):
                continue
            half = combine([(factor, value)])
            for j, onto in other.items():
                over = mask | first[i] | second[j]
                if wanted[over] and (a != b or j >= i):
                    term = combine([(onto, half)])
                    add(outer.entry(i, j), over, 2.0 * term if a != b and i == j else term)

    def _add_springs(self, progress: _Progress, wanted: Wanted) -> None:
        """Add k r r^T and -k r gap of every spring to the second stage."""
        outer = progress.outer
        for (row, stiffness, gap), masks in zip(progress.springs, self._masks.springs, strict=True):
            for i, first in row.items():
                half = combine([(first, stiffness)])
                over = masks.stiffness | masks.row[i]
                for j, second in row.items():
                    if j >= i and wanted[over | masks.row[j]]:
                        term = combine([(second, half)])
                        add(outer.entry(i, j), over | masks.row[j], term)
                        if i == j:
                            add(outer.scale.setdefault(i, {}), over, term)
                if not is_zero(gap) and wanted[over | masks.gap]:
                    subtract(outer.forces.setdefault(i, {}), over | masks.gap, half * gap)

    # -- answers ----------------------------------------------------------------------------------------------------

    def _answer(self, progress: _Progress, rows: Sequence[Row]) -> list[Value]:
        inner, outer = self.block.orders
        asked = {k for row in rows for k in row}
        inside = closure(inner, asked & set(inner.below))
        ends = {a for a in inside if a not in inner.below}
        wanted = (asked - inside) | {k for a in ends for k in progress.rows[a]}
        known: dict[int, Value] = {}
        progress.outer.backward(outer, closure(outer, wanted), known)
        at_ends = {
            a: combine([(1.0, progress.shifts.get(a, 0.0)), *((f, known[k]) for k, f in progress.rows[a].items())])
            for a in ends
        }
        progress.inner.backward(inner, inside, at_ends)
        known.update({k: at_ends[k] for k in inside & set(inner.below)})
        return [combine([(factor, known[k]) for k, factor in row.items()]) for row in rows]

    def _gathered(self, rows: Sequence[Row]) -> list[Value]:
        results: list[Value] = [0.0] * len(rows)

        def gather(index: int, progress: _Progress) -> None:
            part = self._part(index)
            cut = [{k: self._cut(value, part) for k, value in row.items()} for row in rows]
            for k, value in enumerate(self._answer(progress, cut)):
                if isinstance(value, float):
                    results[k] = value
                    continue
                target = results[k]
                if isinstance(target, float):
                    shape = list(value.shape)
                    shape[self.axis] = self.block.grid.shape[self.axis]
                    target = results[k] = np.empty(shape)
                target[part] = value

        self._each(gather)
        return results

    # -- chunks -----------------------------------------------------------------------------------------------------

    def _each(self, work: Callable[[int, _Progress], None]) -> None:
        """Do `work` with the index and progress of every chunk, the first before the others."""

        def one(index: int) -> None:
            with np.errstate(all="ignore"):
                work(index, self._chunk(index))

        one(0)
        with ThreadPoolExecutor(self.workers) as pool:
            for _ in pool.map(one, range(1, self.chunks)):
                pass

    def _chunk(self, index: int) -> _Progress:
        if index in self._kept:
            return self._kept[index]
        part = self._part(index)

        def cut(value: Value) -> Value:
            return self._cut(value, part)

        shared = self.shared
        progress = _Progress(
            shared.inner.mapped(cut),
            shared.outer.mapped(cut),
            {a: {i: cut(v) for i, v in row.items()} for a, row in shared.rows.items()},
            {a: cut(v) for a, v in shared.shifts.items()},
            [({i: cut(v) for i, v in row.items()}, cut(k), cut(gap)) for row, k, gap in shared.springs],
        )
        progress.inner.margin, progress.outer.margin = {}, {}
        self._run(progress, self.large)
        self._margins[index] = functools.reduce(np.minimum, _margins(progress), np.asarray(np.inf))
        if self._bytes() < KEEP:
            self._kept[index] = progress
        return progress

    def _part(self, index: int) -> tuple[slice, ...]:
        return (slice(None),) * self.axis + (slice(index * self.step, (index + 1) * self.step),)

    def _cut(self, value: Value, part: tuple[slice, ...]) -> Value:
        return value if isinstance(value, float) or value.shape[self.axis] == 1 else value[part]

    def _bytes(self) -> int:
        sizes = self.block.grid.sizes
        return sum(
            8 * sizes[order.masks[k]] * (len(order.below[k]) + 2)
            for order in self.block.orders
            for k in order.pivots
            if self.large[order.masks[k]]
        )


def _margins(progress: _Progress) -> list[Array]:
    """Least pivot ratios found so far, by mask."""
    return [np.asarray(value) for stage in (progress.inner, progress.outer) for value in stage.margin.values()]


@dataclass(frozen=True)
class _SpringMasks:
    row: dict[int, int]
    stiffness: int
    gap: int


class _Masks:
    """Batch axes over which the substitution and the springs of a block vary."""

    def __init__(self, block: Block) -> None:
        mask = block.grid.mask
        self.rows = {a: {i: mask(v) for i, v in row.items()} for a, row in block.rows.items()}
        self.shifts = {a: mask(v) for a, v in block.shifts.items()}
        self.springs = [
            _SpringMasks({i: mask(v) for i, v in row.items()}, mask(k), mask(gap)) for row, k, gap in block.springs
        ]
