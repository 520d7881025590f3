"""Broadcasting LDL^T of one connected component, in two stages and by chunks.

The unknowns of nodes that no joint touches come first, in the axes of their link, so that the interior of a link is
condensed once however it moves. After the substitution ``u = T q + G s`` at the nodes of joints, with known numbers s,
follow the joint-relative coordinates q. Loads are carried for a unit of each known number. Steps whose result is small
are done once for the whole batch; the others chunk by chunk along the longest axis, so that they stay in the cache. The
terms of every sum are added in the same order whatever the chunks: the same bits for every chunk size and number of
threads.
"""

from __future__ import annotations

import copy
import functools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..structure.parts import Grid, Parts, Row, Value
from ..structure.varying import Varying
from .chunks import held, large_masks, steps
from .combination import Combination
from .order import Order
from .progress import Masks, PartialFactorisation, Springs, Wanted
from .stage import Forces, Matrix, Stage
from .tail import Remainder, Tail

# Asked a second time, the factors of all chunks are kept for later while they take less than this many bytes: the first
# time it is faster to work in the same memory, which the cache holds, over and over.
KEEP = 2**28
# Up to so many bytes a factor stays with its frame for the next load.
HOLD = 2**26


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


class BlockFactor:
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
        self._masks = Masks.of(block.grid, block.rows, block.springs)
        with np.errstate(all="ignore"):
            self.shared = self._shared()
        self._kept: dict[int, PartialFactorisation | Tail] = {}
        self._former: dict[int, PartialFactorisation | Tail] = {}
        self._margins: dict[int, Array] = {}
        self._again = False
        self.origin = ""

    def loaded(self, block: Block) -> BlockFactor:
        """The same factor under the loads of another block, which differs in nothing else."""
        twin = copy.copy(self)
        for name in ("_only_tail", "_rest"):
            vars(twin).pop(name, None)
        twin.block, twin._again = block, True
        twin._kept, twin._former = {}, dict(self._former | self._kept)
        stage = Stage(forces=block.forces).mapped(_same)
        twin.shared = self.shared.loaded(stage.forces, {}, block.knowns)
        with np.errstate(all="ignore"):
            twin.shared.load(self.small)
        whole = not any(self.large) or (len(twin._former) == self.chunks and not twin._only_tail)
        twin.origin = "the factor" if whole else "what the entries share of the factor"
        return twin

    @property
    def light(self) -> bool:
        """Whether its numbers are few enough to be held for another load."""
        grid, orders = self.block.grid, self.block.orders
        return 8 * sum(grid.sizes[o.masks[k]] * (len(o.below[k]) + 2) for o in orders for k in o.pivots) < HOLD

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
            return self._gathered(rows) if any(self.large) else self.shared.values(rows)

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

    def _shared(self) -> PartialFactorisation:
        """All that is small, of the whole batch."""
        block = self.block
        stage = Stage(block.matrix, block.forces, block.scale).mapped(_same)
        progress = PartialFactorisation(
            block.orders, stage, Stage(), block.rows, block.springs, block.knowns, self._masks
        )
        progress.factorise(self.small, given=True)
        progress.load(self.small)
        return progress

    # -- chunks -----------------------------------------------------------------------------------------------------

    def _gathered(self, rows: Sequence[Row]) -> list[Value]:
        return self._from_tails(rows) if self._only_tail else self._from_stages(rows)

    def _from_tails(self, rows: Sequence[Row]) -> list[Value]:
        shape = self.block.grid.shape
        asked = Combination.of([self.shared.carried(row) for row in rows], self._rest.columns, shape)
        out = np.empty((*shape[:-1], len(rows), shape[-1]))

        def gather(index: int, tail: PartialFactorisation | Tail) -> None:
            indices, part = self._indices(index), self._part(index)
            last = self.axis == len(shape) - 1
            assert isinstance(tail, Tail)
            tail.values(asked.cut(self.axis, indices), out[..., indices] if last else out[part])

        self._each(gather)
        return [out[..., k, :] for k in range(len(rows))]

    def _from_stages(self, rows: Sequence[Row]) -> list[Value]:
        results: list[Value] = [0.0] * len(rows)

        def gather(index: int, progress: PartialFactorisation | Tail) -> None:
            part = self._part(index)
            assert isinstance(progress, PartialFactorisation)
            cut = [_mapped(row, functools.partial(self._cut, part=part)) for row in rows]
            for k, value in enumerate(progress.values(cut)):
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

    def _each(self, work: Callable[[int, PartialFactorisation | Tail], None]) -> None:
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

    def _chunk(self, index: int) -> PartialFactorisation | Tail:
        if index in self._kept:
            return self._kept[index]
        progress: PartialFactorisation | Tail = self._finished(index) if self._only_tail else self._redone(index)
        self._margins[index] = functools.reduce(np.minimum, _margins(progress), np.asarray(np.inf))
        if self._again or self.chunks == 1 or (self.light and not self._only_tail):
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

    def _redone(self, index: int) -> PartialFactorisation:
        """The whole way once more for the terms that are large."""
        shared, cut = self.shared, functools.partial(self._cut, part=self._part(index))
        inner, outer, knowns = shared.inner.mapped(cut), shared.outer.mapped(cut), [cut(v) for v in shared.knowns]
        former = self._former.pop(index, None)
        if isinstance(former, PartialFactorisation):
            progress = former.loaded(inner.forces, outer.forces, knowns)
        else:
            rows = {a: _mapped(row, cut) for a, row in shared.rows.items()}
            springs = [(_mapped(row, cut), cut(stiffness)) for row, stiffness in shared.springs]
            progress = PartialFactorisation(self.block.orders, inner, outer, rows, springs, knowns, self._masks)
            if self.block.varying:
                for entry, value in self.block.varying.values(self.axis, self._indices(index)):
                    inner.put(*entry.at, entry.mask, value)
            progress.factorise(self.large, given=False)
            progress.forget()
        progress.load(self.large)
        return progress

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


def _margins(progress: PartialFactorisation | Tail) -> list[Array]:
    """Least pivot ratios found, by mask, in what was done on the way."""
    if isinstance(progress, Tail):
        return [np.asarray(progress.margin)]
    return [np.asarray(value) for stage in (progress.inner, progress.outer) for value in stage.margin.values()]
