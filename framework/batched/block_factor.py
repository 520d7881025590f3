"""Broadcasting LDL^T of a block, in two stages and by chunks.

The first stage eliminates the unknowns of nodes without joints, in the axes of their link, so that the interior of a
link is condensed once for all poses. The second stage, after the substitution ``u = T q + G s`` at the nodes of joints
with right-hand-side parameters s, eliminates the joint-relative coordinates q. Loads are carried per unit of each
right-hand-side parameter.

Steps that vary over few batch entries are done once for the whole batch; the others chunk by chunk, so that arrays stay
in the processor's cache. The operations on a chunk are recorded once, as a program, unless there are few chunks.
The terms of every sum are added in the same order whatever the chunks, so that results are the same to the last bit for
every chunk size and number of threads.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from itertools import zip_longest

import numpy as np

from ..batch import Array, Shape
from ..program.calculation import Calculation, empty, worth_compiling
from ..program.direct import Arithmetic, Direct
from ..program.recording import Recording, Term
from ..structure.parts import Row, Value
from .block import Block
from .chunks import large_masks, steps, storage
from .partial_factorisation import PartialFactorisation, Wanted
from .replay import RecordedElimination
from .schur_complement import TrailingSchurComplement
from .stage import Stage, mapped_forces, mapped_row

# From the second request on, the factors of all chunks are kept if they take less than this many bytes. At the first
# request it is faster to reuse one piece of memory, which the processor's cache holds, for every chunk.
KEEP = 2**28
# Up to this many chunks are computed directly, without recording a program; and the reason that `explain` then gives.
FEW, SHORT = 3, "no program: the batch is short, and NumPy does it at once"
# Machine code, which stores no intermediate arrays, does this many chunks in one call.
LONGER = 64
# A factor of fewer bytes stays with its frame for the next load.
HOLD = 2**26


@dataclass(frozen=True)
class WrittenBlock:
    """The solution of a block as terms of a recording.

    Attributes
    ----------
    values
        Function that returns the values of rows for the given right-hand-side parameters; for its own where None.
    least
        The least pivot ratio of the chunks where it is not known; else None.
    """

    values: Callable[[Sequence[Row], Sequence[Value] | None], list[Value]]
    least: Value | None = None


class BlockFactor:
    """LDL^T of a block, and the values of rows over its unknowns.

    Parameters
    ----------
    block
        The assembled equations.
    chunk
        Number of batch entries handled at a time; chosen by memory where None.
    workers
        Number of threads for NumPy. One is the default: operations on a chunk that fits the cache take some ten
        microseconds, less than passing on Python's lock, so that two threads on two cores took 0.95 to 1.9 times as
        long as one for 361000 entries, whatever the chunk. Machine code has threads of its own.
    compiled
        Whether the program for the chunks is run as machine code (True) or by NumPy (False); None chooses the one that
        is expected to be faster.
    shared
        The steps that vary over few batch entries, if they are done already; else None.

    Attributes
    ----------
    ran
        How the chunks were computed and why, in words; empty before.
    """

    def __init__(
        self,
        block: Block,
        chunk: int | None = None,
        workers: int = 1,
        *,
        compiled: bool | None = None,
        shared: PartialFactorisation | None = None,
    ) -> None:
        self.block, self.workers = block, workers
        self.large: Wanted = large_masks(block.grid)
        self.small: Wanted = [not large for large in self.large]
        self.axis, self.step = steps(block.grid, block.orders, chunk)
        self.compiled = compiled
        with np.errstate(all="ignore"):
            self.shared = self._shared() if shared is None else shared
        # Kept for later results and other loads: values of the trailing unknowns and right-hand-side parameters, and
        # the factors of chunks.
        self._numbers: dict[int, Value] | None = None
        self._kept: dict[int, PartialFactorisation] = {}
        self._former: dict[int, PartialFactorisation] = {}
        self._least: Array | None = None
        self._again = False
        self.origin, self.ran = "", ""

    def loaded(self, block: Block) -> BlockFactor:
        """The same factor for another block that differs in its loads alone."""
        clone = object.__new__(type(self))
        clone.block, clone.workers, clone.large, clone.small = block, self.workers, self.large, self.small
        clone.compiled, clone.ran = self.compiled, ""
        clone.axis, clone.step, clone._again = self.axis, self.step, True
        clone._numbers, clone._kept, clone._former, clone._least = None, {}, self._former | self._kept, self._least
        forces = mapped_forces(block.forces, lambda value: value)
        clone.shared = self.shared.loaded(forces, {}, block.rhs_parameters)
        with np.errstate(all="ignore"):
            clone.shared.load(self.small)
        whole = not any(self.large) or (len(clone._former) == self.chunks and not clone.only_trailing)
        clone.origin = "the factor" if whole else "what the entries share of the factor"
        return clone

    @property
    def light(self) -> bool:
        """Whether the factor is small enough to be kept for the next load."""
        grid, orders = self.block.grid, self.block.orders
        return 8 * sum(grid.sizes[o.masks[k]] * (len(o.below[k]) + 2) for o in orders for k in o.pivots) < HOLD

    @property
    def chunks(self) -> int:
        """Number of chunks; 1 where the whole batch is done at once."""
        return -(-self.block.grid.shape[self.axis] // self.step) if any(self.large) else 1

    @functools.cached_property
    def only_trailing(self) -> bool:
        """Whether only the trailing joint-relative unknowns are left to the chunks."""
        inner, _ = self.block.orders
        if self.block.varying:
            return False
        done = self.shared.inner.complete and self.shared.outer.complete
        return done and not any(self.large[mask] for mask in inner.masks.values())

    @property
    def by_chunks(self) -> bool:
        """Whether each pass over the batch eliminates more than the trailing unknowns."""
        return any(self.large) and not self.only_trailing

    @property
    def negligible(self) -> int:
        """Number of couplings that the chunks neglect because they are below rounding."""
        return self._rest.negligible if any(self.large) and self.only_trailing else 0

    def values(self, rows: Sequence[Row], places: Sequence[Array | None] = ()) -> list[Value]:
        """Values of rows over the whole batch, each of a shape that broadcasts to it.

        Parameters
        ----------
        rows
            Linear combinations of the unknowns.
        places
            For each row an array of the batch shape into which its value may be written, or None.
        """
        with np.errstate(all="ignore"):
            if not any(self.large):
                return self.shared.values(rows)
            if not self.only_trailing:
                return self._from_stages(rows, places)
            return self._from_trailing([self.shared.carried(row) for row in rows], places)

    def from_trailing(self, carried: Sequence[Row], places: Sequence[Array | None] = ()) -> list[Value]:
        """`values` of rows that are expressed in the trailing unknowns already, where only these are left."""
        with np.errstate(all="ignore"):
            return self._from_trailing(carried, places)

    def written(self, recording: Recording, *, anew: bool = False) -> WrittenBlock | None:
        """The solution as terms of a recording.

        None where the factors of chunks are kept, or are to be kept now; unless `anew`, which never keeps them.
        """
        if not any(self.large):
            return WrittenBlock(lambda rows, given: [recording.take(v) for v in self.shared.values(rows, given)])
        if self.only_trailing:
            own = self._unknowns(recording) or self._rest.recorded(recording).numbers

            def products(rows: Sequence[Row], given: Sequence[Value] | None) -> list[Value]:
                # what is eliminated is recorded once, whatever the parameters
                numbers = own if given is None else self._rest.under(given).recorded(recording).numbers
                return recording.products([self.shared.carried(row) for row in rows], numbers)

            return WrittenBlock(products)
        if not anew and (self._again or self._known):
            return None
        progress, self._again = self._recorded(recording), self._again if anew else self._holdable

        def values(rows: Sequence[Row], given: Sequence[Value] | None) -> list[Value]:
            return progress.values([mapped_row(row, recording.take) for row in rows], given)

        return WrittenBlock(values, None if self._least is not None else progress.least)

    def learn(self, least: Array) -> None:
        """Take over the least pivot ratio of the chunks, which a recording has computed."""
        self._least = least

    def pivot_ratio(self) -> Array:
        """Least ratio of a pivot to its scale, (...) of the batch shape."""
        return np.broadcast_to(self.least(), self.block.grid.shape)

    def least(self) -> Array:
        """The least pivot ratio, of the batch shape over which it varies."""
        shared = [np.asarray(value, dtype=np.float64) for value in self.shared.pivot_ratios]
        small: Array = functools.reduce(np.minimum, sorted(shared, key=np.size), np.asarray(np.inf))
        return np.asarray(np.minimum(small, self.trailing_least())) if any(self.large) else small

    def trailing_least(self) -> Array:
        """The least pivot ratio of what the shared steps leave to the chunks."""
        if self._least is None:
            if self.only_trailing and self._rest.pivot_ratio:  # known before anything is solved
                self._least = np.asarray(self._rest.pivot_ratio)
            else:
                self.values([])
        assert self._least is not None
        return self._least

    # -- one run ----------------------------------------------------------------------------------------------------

    def _shared(self) -> PartialFactorisation:
        """The steps that vary over few batch entries, done for the whole batch."""
        block = self.block
        if block.grid.sizes[-1] == 1 and not block.varying:
            given = block.matrix, block.forces, block.scale, block.rows, block.springs
            return RecordedElimination(block.orders, *given).carried_out(block.masks, block.rhs_parameters)
        stage = Stage(block.matrix, block.forces, block.scale)
        linked = block.rows, block.springs, block.rhs_parameters
        return PartialFactorisation.begun(block.orders, stage, *linked, block.masks, self.small)

    # -- chunks -----------------------------------------------------------------------------------------------------

    @functools.cached_property
    def _rest(self) -> TrailingSchurComplement:
        """The Schur complement that the shared steps leave to the chunks."""
        stage = self.shared.outer
        left = [k for k in self.block.orders[1].pivots if k not in stage.pivots]
        done = {step.mask for each in (self.shared.inner, stage) for step in each.pivots.values()}
        return TrailingSchurComplement.of(stage, left, self.shared.rhs_parameters, self.block.grid, done)

    def _from_trailing(self, asked: Sequence[Row], places: Sequence[Array | None]) -> list[Value]:
        """Values of carried rows from the trailing unknowns, which are kept from the second request on."""
        shape, rest = self.block.grid.shape, self._rest
        alone = not self._written(1)
        self.ran = SHORT if alone else self.ran
        recording: Arithmetic = Direct(shape) if alone else Recording()
        keep = self._numbers is None and (self._again or self.chunks == 1)
        watched: list[Value] = []
        numbers = self._unknowns(recording)
        if not numbers:
            recorded = rest.recorded(recording)
            numbers = recorded.numbers
            watched = [recorded.pivot_ratio] if recorded.pivot_ratio is not None and self._least is None else []
        results = recording.products(asked, numbers)
        unknowns = [numbers[k] for k in rest.pivots] if keep else []
        found = [*results, *watched, *unknowns]
        if isinstance(recording, Recording):
            found = self._run(recording, found, places)
        if keep:
            known = {-1 - s: value for s, value in enumerate(rest.rhs_parameters)}
            self._numbers = dict(zip(rest.pivots, found[len(found) - len(unknowns) :], strict=True)) | known
        if self._least is None:
            self._least = np.asarray(found[len(asked)] if watched else rest.pivot_ratio)
        if asked:  # without rows only the pivot ratio was requested, which does not count as a first request
            self._again = 8 * self.block.grid.sizes[-1] * len(rest.pivots) < KEEP
        return found[: len(asked)]

    def _unknowns(self, recording: Arithmetic) -> dict[int, Value]:
        """Trailing unknowns and right-hand-side parameters that were kept, by number; empty if none were."""
        return {k: recording.take(value) for k, value in (self._numbers or {}).items()}

    def _from_stages(self, rows: Sequence[Row], places: Sequence[Array | None]) -> list[Value]:
        """Values of rows by elimination, chunk by chunk, of all steps that vary over many entries; reuses factors."""
        if self._known or not self._written(FEW):
            return self._one_by_one(rows)
        recording = Recording()
        progress = self._recorded(recording)
        results = progress.values([mapped_row(row, recording.take) for row in rows])
        least = [progress.least] if self._least is None else []
        found = self._run(recording, [*results, *least], places, progress if self._keeps else None)
        if least:
            self._least = np.asarray(found[-1])
        if rows:  # a request for the pivot ratio alone does not count
            self._again = self._holdable
        return found[: len(rows)]

    def _one_by_one(self, rows: Sequence[Row]) -> list[Value]:
        """Values of rows, and the least pivot ratio, chunk by chunk without a program; kept factors are reused."""
        results: list[Value] = [0.0] * (len(rows) + 1)

        def gather(index: int) -> None:
            part = (slice(None),) * self.axis + (slice(index * self.step, (index + 1) * self.step),)
            cut = functools.partial(self._cut, part=part)
            progress = self._chunk(index, cut)
            least = [progress.least] if self._least is None else []
            for k, value in enumerate([*progress.values([mapped_row(row, cut) for row in rows]), *least]):
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
        if self._least is None:
            self._least = np.asarray(results[-1])
        self._again = self._holdable
        return results[: len(rows)]

    def _chunk(self, index: int, cut: Callable[[Value], Value]) -> PartialFactorisation:
        """The factorisation of a chunk: a kept one, one of other loads with these loads, or a new one."""
        if index in self._kept:
            return self._kept[index]
        if index in self._former:
            shared = self.shared
            inner, outer = (mapped_forces(stage.forces, cut) for stage in (shared.inner, shared.outer))
            progress = self._former.pop(index).loaded(inner, outer, [cut(v) for v in shared.rhs_parameters])
            progress.load(self.large)
        else:
            indices, varying = slice(index * self.step, (index + 1) * self.step), self.block.varying
            self.ran = SHORT
            progress = self._done_again(cut, varying.numbers(self.axis, indices) if varying else [])
        if self._keeps:
            self._kept[index] = progress
        return progress

    def _done_again(self, take: Callable[[Value], Value], varying: Sequence[Value]) -> PartialFactorisation:
        """Elimination of all steps that vary over many entries, each shared number being ``take(number)``."""
        progress = self.shared.anew(take)
        if self.block.varying:
            for entry, value in self.block.varying.values(varying):
                progress.inner.put(*entry.at, entry.mask, value)
        progress.factorise(self.large, given=False)
        progress.forget()
        progress.load(self.large)
        return progress

    def _recorded(self, recording: Recording) -> PartialFactorisation:
        """That elimination recorded: the factorisation whose numbers are terms, those of `varying` left open."""
        varying = self.block.varying
        later = [recording.later(mask) for mask in varying.masks] if varying else []
        return self._done_again(recording.take, later)

    @property
    def _known(self) -> bool:
        """Whether the factors of all chunks are kept."""
        return len(self._kept.keys() | self._former.keys()) == self.chunks

    def _written(self, few: int) -> bool:
        """Whether to record a program: if there are more than `few` chunks, or machine code will run it."""
        return self.compiled is not None or self.chunks > few or worth_compiling(self.block.grid.sizes[-1])

    @property
    def _keeps(self) -> bool:
        """Whether to keep the factors of chunks that are computed now."""
        return self._again or self.chunks == 1 or self.light

    @property
    def _holdable(self) -> bool:
        """Whether the factors of all chunks take little enough memory to be kept."""
        return 8 * self.block.grid.sizes[-1] * storage(self.block.grid, self.block.orders) < KEEP

    def _run(
        self,
        recording: Recording,
        asked: Sequence[Value],
        places: Sequence[Array | None],
        state: PartialFactorisation | None = None,
    ) -> list[Value]:
        """Values of the terms `asked`, chunk by chunk; if `state` is given, its numbers are kept for each chunk."""
        grid, varying = self.block.grid, self.block.varying
        terms = [value for value in asked if isinstance(value, Term)]
        inside = state.terms if state else []
        if not (terms or inside):
            return list(asked)
        calculation = Calculation.recorded(recording, [*terms, *inside], grid.shape, compiled=self.compiled)
        self.ran = calculation.choice.reason
        given = [place for value, place in zip_longest(asked, places) if isinstance(value, Term)]
        outputs = empty([calculation.of(term.mask) for term in terms], given)
        longer = LONGER if calculation.choice.compiled and not (varying or state) else 1

        def one(index: int) -> None:
            indices = slice(index * self.step, (index + longer) * self.step)
            part = (slice(None),) * self.axis + (indices,)
            later = varying.numbers(self.axis, indices) if varying else []
            temporary = [np.empty(calculation.of(term.mask, self._shape(indices))) for term in inside]
            mine = [out[part] if term.mask >> self.axis & 1 else out for term, out in zip(terms, outputs, strict=True)]
            calculation.run(self.axis, indices, [*mine, *temporary], later)
            if state:
                found = {term.number: value for term, value in zip(inside, temporary, strict=True)}
                self._kept[index] = state.mapped(functools.partial(_numbered, found=found))

        self._each(one, longer)
        found = iter(outputs)
        return [next(found) if isinstance(value, Term) else value for value in asked]

    def _each(self, work: Callable[[int], None], longer: int = 1) -> None:
        """Call `work` with the index of every chunk, or of every `longer`-th.

        The first call creates what all share, so it is finished before threads start.
        """

        def one(index: int) -> None:
            with np.errstate(all="ignore"):
                work(index)

        alone = self.chunks if self.workers == 1 else 1
        for index in range(0, alone, longer):
            one(index)
        if alone < self.chunks:
            with ThreadPoolExecutor(self.workers) as pool:
                for _ in pool.map(one, range(longer, self.chunks, longer)):
                    pass

    def _shape(self, indices: slice) -> Shape:
        """Batch shape of the chunk with these indices along the axis."""
        shape = self.block.grid.shape
        return (*shape[: self.axis], len(range(shape[self.axis])[indices]), *shape[self.axis + 1 :])

    def _cut(self, value: Value, part: tuple[slice, ...]) -> Value:
        """The values of a number in one chunk, in double precision."""
        if not isinstance(value, np.ndarray):
            return float(value)
        mine = value[part] if value.shape[self.axis] == self.block.grid.shape[self.axis] else value
        return mine.astype(np.float64, copy=False)


def _numbered(value: Value, found: dict[int, Array]) -> Value:
    return found[value.number] if isinstance(value, Term) else value
