"""Broadcasting LDL^T of one connected component, in two stages and by chunks.

The unknowns of nodes that no joint touches come first, in the axes of their link, so that the interior of a link is
condensed once however it moves. After the substitution ``u = T q + G s`` at the nodes of joints, with known numbers s,
follow the joint-relative coordinates q. Loads are carried for a unit of each known number. Steps whose result is small
are done once for the whole batch; the others chunk by chunk along the longest axis, so that they stay in the cache. The
terms of every sum are added in the same order whatever the chunks: the same bits for every chunk size and number of
threads.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..structure.parts import Grid, Parts, Row, Value, add, add_row, combine, unknowns
from ..structure.varying import Varying
from .chunks import held, large_masks, steps
from .combination import Combination
from .order import Order
from .stage import Forces, Matrix, Stage, backward, carried, closure, subtract
from .tail import Remainder, Tail

# Asked a second time, the factors of all chunks are kept for later while they take less than this many bytes: the first
# time it is faster to work in the same memory, which the cache holds, over and over.
KEEP = 2**28

Wanted = Sequence[bool]
Springs = list[tuple[Row, Value]]


@dataclass(frozen=True)
class Block:
    """A connected component, assembled.

    Attributes
    ----------
    grid
        The batch.
    orders
        Elimination order of the interior unknowns and of the joint-relative ones.
    matrix, scale, forces
        Stiffness, that whose rounding its diagonal carries, and load of the members in the nodes' axes.
    rows
        Displacements of nodes on joints, over the joint-relative unknowns and the known numbers.
    springs
        Row and stiffness of each spring on them.
    knowns
        The known numbers.
    varying
        Stiffness that is left to the chunks, None where there is none.
    """

    grid: Grid
    orders: tuple[Order, Order]
    matrix: Matrix
    scale: dict[int, Parts]
    forces: Forces
    rows: dict[int, Row]
    springs: Springs
    knowns: list[Value]
    varying: Varying | None = None


@dataclass
class _Progress:
    """Both stages and what turns the first into the second, whole or cut to a chunk."""

    inner: Stage
    outer: Stage
    rows: dict[int, Row]
    springs: Springs
    knowns: list[Value]

    def values(self, block: Block, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows`, by back substitution of what they ask for."""
        inner, outer = block.orders
        asked = {k for row in rows for k in unknowns(row)}
        inside = closure(inner, asked & set(inner.below))
        ends = {a for a in inside if a not in inner.below}
        wanted = (asked - inside) | {k for a in ends for k in unknowns(self.rows[a])}
        known = {-1 - s: value for s, value in enumerate(self.knowns)}
        backward(outer, closure(outer, wanted), known, self.outer, self.knowns)
        at_ends = {a: _sum(self.rows[a], known) for a in ends}
        backward(inner, inside, at_ends, self.inner, self.knowns)
        known.update({k: at_ends[k] for k in inside & set(inner.below)})
        return [_sum(row, known) for row in rows]

    def carried(self, block: Block, row: Row) -> Row:
        """`row` over the unknowns that are not eliminated yet and the known numbers."""
        inner, outer = block.orders
        at_ends = carried(inner, row, self.inner)
        out: Row = {}
        for k, factor in at_ends.items():
            add_row(out, self.rows[k] if k not in row and k in self.rows else {k: 1.0}, factor)
        return carried(outer, out, self.outer)


class Factor:
    """LDL^T of a block; it answers for rows over the unknowns.

    Parameters
    ----------
    block
        What is factorised.
    chunk
        Batch entries handled at a time.
    workers
        Threads. One is the default: operations on a chunk that fits the cache take some ten microseconds, less than
        it takes to pass NumPy's lock on, so that two threads on two cores took 0.95 to 1.9 times the time of one for
        361000 entries, whatever the chunk.
    """

    def __init__(self, block: Block, chunk: int | None = None, workers: int = 1) -> None:
        self.block, self.workers = block, workers
        self.large: Wanted = large_masks(block.grid)
        self.small: Wanted = [not large for large in self.large]
        self.axis, self.step = steps(block.grid, block.orders, chunk)
        self._masks = _Masks(block)
        with np.errstate(all="ignore"):
            self.shared = self._run(self._start(), self.small)
        self._kept: dict[int, _Progress | Tail] = {}
        self._margins: dict[int, Array] = {}
        self._again = False

    @property
    def chunks(self) -> int:
        """Number of chunks; 1 where all is done at once."""
        return -(-self.block.grid.shape[self.axis] // self.step) if any(self.large) else 1

    @property
    def negligible(self) -> int:
        """Couplings left out of what the chunks do, because they are less than rounding."""
        return self._rest.negligible if any(self.large) and self._only_tail else 0

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns, at the whole batch."""
        with np.errstate(all="ignore"):
            return self._gathered(rows) if any(self.large) else self.shared.values(self.block, rows)

    def margin(self) -> Array:
        """Least ratio of a pivot to the stiffness whose rounding it carries, (...) of the batch shape."""
        shape = self.block.grid.shape
        shared = [value.astype(np.float64) for value in _margins(self.shared)]
        small: Array = functools.reduce(np.minimum, sorted(shared, key=np.size), np.asarray(np.inf))
        if not any(self.large):
            return np.broadcast_to(small, shape)
        if len(self._margins) < self.chunks:
            self._each(lambda index, progress: None)
        if all(least.ndim == 0 for least in self._margins.values()):
            # Nothing was watched, and the same is known of all chunks.
            return np.broadcast_to(np.minimum(small, self._margins[0]), shape)
        out = np.array(np.broadcast_to(small, shape))
        for index, least in self._margins.items():
            part = self._part(index)
            out[part] = np.minimum(out[part], least)
        return out

    # -- one run ----------------------------------------------------------------------------------------------------

    def _start(self) -> _Progress:
        block = self.block
        inner = Stage(block.matrix, block.forces, block.scale)
        return _Progress(inner.mapped(_same), Stage(), block.rows, block.springs, block.knowns)

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
        """Add T^T K T, T^T (f - K G) and the diagonal's scale to the second stage."""
        inner, outer, masks = progress.inner, progress.outer, self._masks
        for a, row in progress.rows.items():
            for b, parts in inner.matrix.get(a, {}).items():
                if b >= a and b in progress.rows:
                    for mask, value in parts.items():
                        self._congruence(outer, (a, row), (b, progress.rows[b]), (mask, value), wanted)
            for i in unknowns(row):
                over, factor = masks.rows[a][i], row[i]
                for source, pushed in inner.forces.get(a, {}).items():
                    for mask, value in pushed.items():
                        if self._is(outer, wanted, mask | over):
                            add(outer.force(i, source), mask | over, combine([(factor, value)]))
                for mask, value in inner.scale.get(a, {}).items():
                    if self._is(outer, wanted, mask | over):
                        term = combine([(factor, combine([(factor, value)]))])
                        add(outer.scale.setdefault(i, {}), mask | over, term)

    def _congruence(
        self, outer: Stage, left: tuple[int, Row], right: tuple[int, Row], part: tuple[int, Value], wanted: Wanted
    ) -> None:
        (a, row), (b, other), (mask, value) = left, right, part
        first, second = self._masks.rows[a], self._masks.rows[b]
        for i, factor in row.items():
            met = {j: mask | first[i] | second[j] for j in other if a != b or (i >= 0 and (j >= i or j < 0))}
            met = {j: over for j, over in met.items() if self._is(outer, wanted, over)}
            half = combine([(factor, value)]) if met else 0.0
            for j, over in met.items():
                self._put(outer, (i, j), over, combine([(other[j], half)]), twice=a != b)

    def _add_springs(self, progress: _Progress, wanted: Wanted) -> None:
        """Add k r r^T and -k r times the known part of every spring to the second stage."""
        outer = progress.outer
        for (row, stiffness), (masks, mask) in zip(progress.springs, self._masks.springs, strict=True):
            for i in unknowns(row):
                half = combine([(row[i], stiffness)])
                for j, second in row.items():
                    over = mask | masks[i] | masks[j]
                    # A stiffness as it was given is added whole, whatever its size: that costs nothing.
                    given = not masks[i] | masks[j]
                    now = wanted is self.small if given else self._is(outer, wanted, over)
                    if now and (j >= i or j < 0):
                        term = combine([(second, half)])
                        self._put(outer, (i, j), over, term, twice=False)
                        if i == j:
                            add(outer.scale.setdefault(i, {}), over, term)

    @staticmethod
    def _put(outer: Stage, at: tuple[int, int], mask: int, term: Value, *, twice: bool) -> None:
        """Add a term of the stiffness to the matrix or, where it meets a known number, to the load."""
        i, j = at
        if i >= 0 and j >= 0:
            add(outer.entry(i, j), mask, 2.0 * term if twice and i == j else term)
        elif i >= 0 or j >= 0:
            subtract(outer.force(max(i, j), -1 - min(i, j)), mask, term)

    @staticmethod
    def _is(stage: Stage, wanted: Wanted, mask: int) -> bool:
        """Whether a term is wanted now; a stage that leaves some out is not complete."""
        if not wanted[mask]:
            stage.complete = False
        return wanted[mask]

    # -- chunks -----------------------------------------------------------------------------------------------------

    def _gathered(self, rows: Sequence[Row]) -> list[Value]:
        return self._from_tails(rows) if self._only_tail else self._from_stages(rows)

    def _from_tails(self, rows: Sequence[Row]) -> list[Value]:
        shape = self.block.grid.shape
        asked = Combination.of([self.shared.carried(self.block, row) for row in rows], self._rest.columns, shape)
        out = np.empty((*shape[:-1], len(rows), shape[-1]))

        def gather(index: int, tail: _Progress | Tail) -> None:
            indices, part = self._indices(index), self._part(index)
            last = self.axis == len(shape) - 1
            assert isinstance(tail, Tail)
            tail.values(asked.cut(self.axis, indices), out[..., indices] if last else out[part])

        self._each(gather)
        return [out[..., k, :] for k in range(len(rows))]

    def _from_stages(self, rows: Sequence[Row]) -> list[Value]:
        results: list[Value] = [0.0] * len(rows)

        def gather(index: int, progress: _Progress | Tail) -> None:
            part = self._part(index)
            assert isinstance(progress, _Progress)
            cut = [_mapped(row, functools.partial(self._cut, part=part)) for row in rows]
            for k, value in enumerate(progress.values(self.block, cut)):
                if not isinstance(value, np.ndarray):
                    results[k] = value
                    continue
                target = results[k]
                if not isinstance(target, np.ndarray):
                    shape = list(value.shape)
                    shape[self.axis] = self.block.grid.shape[self.axis]
                    target = results[k] = np.empty(shape)
                target[part] = value

        self._each(gather)
        return results

    def _each(self, work: Callable[[int, _Progress | Tail], None]) -> None:
        """Do `work` with the index and progress of every chunk.

        Results of stages are laid out as the first comes out, so that goes before the others.
        """

        def one(index: int) -> None:
            with np.errstate(all="ignore"):
                work(index, self._chunk(index))

        alone = self.chunks if self.workers == 1 else 1 if self.chunks == 1 or not self._only_tail else 0
        keep = self._bytes() < KEEP
        for index in range(alone):
            one(index)
        if alone < self.chunks:
            with ThreadPoolExecutor(self.workers) as pool:
                for _ in pool.map(one, range(alone, self.chunks)):
                    pass
        self._again = keep

    def _chunk(self, index: int) -> _Progress | Tail:
        if index in self._kept:
            return self._kept[index]
        progress: _Progress | Tail = self._finished(index) if self._only_tail else self._redone(index)
        self._margins[index] = functools.reduce(np.minimum, _margins(progress), np.asarray(np.inf))
        if self._again or self.chunks == 1:
            self._kept[index] = progress
        return progress

    @functools.cached_property
    def _only_tail(self) -> bool:
        """Whether nothing but the last joint-relative unknowns is left to the chunks."""
        inner, _ = self.block.orders
        if self.block.varying:
            return False
        done = self.shared.inner.complete and self.shared.outer.complete
        return done and not any(self.large[mask] for mask in inner.masks.values())

    @functools.cached_property
    def _rest(self) -> Remainder:
        """What the shared steps leave to the chunks."""
        stage = self.shared.outer
        left = [k for k in self.block.orders[1].pivots if k not in stage.pivots]
        done = {step.mask for each in (self.shared.inner, stage) for step in each.pivots.values()}
        return Remainder.of(stage, left, self.shared.knowns, self.block.grid, done)

    def _finished(self, index: int) -> Tail:
        cut = functools.partial(self._cut, part=self._part(index))
        shape = list(self.block.grid.shape)
        shape[self.axis] = len(range(shape[self.axis])[self._indices(index)])
        return Tail(self._rest.cut(cut, self.axis, self._indices(index)), tuple(shape))

    def _redone(self, index: int) -> _Progress:
        """The whole way once more for the terms that are large."""
        shared, cut = self.shared, functools.partial(self._cut, part=self._part(index))
        progress = _Progress(
            shared.inner.mapped(cut),
            shared.outer.mapped(cut),
            {a: _mapped(row, cut) for a, row in shared.rows.items()},
            [(_mapped(row, cut), cut(stiffness)) for row, stiffness in shared.springs],
            [cut(value) for value in shared.knowns],
        )
        if self.block.varying:
            for entry, value in self.block.varying.values(self.axis, self._indices(index)):
                i, j = entry.at
                add(progress.inner.entry(i, j), entry.mask, value)
                if i == j:
                    add(progress.inner.scale.setdefault(i, {}), entry.mask, value)
        return self._run(progress, self.large)

    def _part(self, index: int) -> tuple[slice, ...]:
        return (slice(None),) * self.axis + (self._indices(index),)

    def _indices(self, index: int) -> slice:
        return slice(index * self.step, (index + 1) * self.step)

    def _cut(self, value: Value, part: tuple[slice, ...]) -> Value:
        """The part of a number that belongs to a chunk, in double precision."""
        if not isinstance(value, np.ndarray):
            return float(value)
        mine = value[part] if value.shape[self.axis] == self.block.grid.shape[self.axis] else value
        return mine.astype(np.float64, copy=False)

    def _bytes(self) -> int:
        """What all chunks would hold for later."""
        if self._only_tail:
            return 8 * self.block.grid.sizes[-1] * len(self._rest.columns)
        return 8 * self.block.grid.sizes[-1] * held(self.block.grid, self.block.orders)


def _same(value: Value) -> Value:
    return value


def _mapped(row: Row, change: Callable[[Value], Value]) -> Row:
    return {k: change(value) for k, value in row.items()}


def _sum(row: Row, known: dict[int, Value]) -> Value:
    return combine([(factor, known[k]) for k, factor in row.items()])


def _margins(progress: _Progress | Tail) -> list[Array]:
    """Least pivot ratios found, by mask, in what was done on the way."""
    if isinstance(progress, Tail):
        return [np.asarray(progress.margin)]
    return [np.asarray(value) for stage in (progress.inner, progress.outer) for value in stage.margin.values()]


class _Masks:
    """Batch axes over which the substitution and the springs of a block vary."""

    def __init__(self, block: Block) -> None:
        mask = block.grid.mask
        self.rows = {a: {i: mask(v) for i, v in row.items()} for a, row in block.rows.items()}
        self.springs = [({i: mask(v) for i, v in row.items()}, mask(k)) for row, k in block.springs]
