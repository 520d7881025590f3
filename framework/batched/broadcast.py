"""The solver for batches: a broadcasting LDL^T of each connected component that loads reach."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..clock import timed
from ..lazily import cached_property
from ..program.recording import Recording
from ..results.status import is_singular
from ..structure.parts import Row, Value, sums
from ..structure.varying import Varying
from .block_factor import BlockFactor, WrittenBlock
from .condensation import retained
from .plan import Plan
from .stage import SUSPECT
from .unloaded import Chained


@dataclass(frozen=True)
class WrittenSolution:
    """The solution of a frame as terms of a recording.

    Attributes
    ----------
    values
        Function that returns the values of rows; for other right-hand-side parameters if these are given.
    least
        By component, its least pivot ratio where that is not known yet.
    varying
        Members of which the recording leaves the numbers open.
    """

    values: Callable[..., list[Value]]
    least: dict[int, Value]
    varying: list[Varying]

    def later(self, axis: int, indices: slice) -> list[Value]:
        """The numbers that are left open, at some indices of a batch axis."""
        return [number for each in self.varying for number in each.numbers(axis, indices)]


class BroadcastSolver:
    """Broadcasting solver; components are assembled and factorised when they are first needed.

    Parameters
    ----------
    plan
        The plan of the frame.
    former
        Factors of the same frame under other loads, to be reused; small factors are added to it for the next solution.
    """

    def __init__(self, plan: Plan, former: dict[tuple[Chained, int], BlockFactor] | None = None) -> None:
        self.plan, self.former = plan, {} if former is None else former
        self._factors: dict[int, BlockFactor] = {}
        self._small: dict[int, NDArray[np.bool_]] = {}

    def only(self, plan: Plan) -> BroadcastSolver:
        """The solver for another plan of the frame, in which other parts count as loaded, with the same factors."""
        clone = BroadcastSolver(plan, self.former)
        clone._factors, clone._small = self._factors, self._small
        return clone

    def part(self, node: int) -> BroadcastSolver:
        """The solver in which only the part of the frame that contains a node counts as loaded."""
        plan = self.plan.part(node)
        return self if plan.excited == self.plan.excited else self.only(plan)

    @cached_property
    def parts(self) -> int:
        """Number of loaded parts of the frame; parts that share only supports are not connected."""
        excited = self.plan.excited
        return (
            len(excited)
            if len(excited) < 2
            else len({int(self.plan.connected_components[name // 6]) for name in excited})
        )

    def reaching(self, unknowns: Iterable[int]) -> BroadcastSolver:
        """The solver in which the components of these unknowns count as loaded, too; itself where they do already."""
        plan = self.plan.reaching(unknowns)
        return self if plan is self.plan else self.only(plan)

    def values(self, rows: Sequence[Row], places: Sequence[Array] = ()) -> list[Value]:
        """Values of rows over the unknowns, each of a shape that broadcasts to the batch.

        `places` may hold an array of the batch shape for each, into which its value may be written.
        """
        plan = self.plan
        if plan.entry is not None:
            return plan.entry.values(rows)
        split, terms = self._split(rows)
        factors = {name: self.factor(name) for name in split}
        with timed(plan.times, "solution"):
            for name, parts in split.items():
                # a row over several components is a sum, which is not written in place
                alone = [bool(places) and len(terms[k]) + sum(k in each for each in split.values()) == 1 for k in parts]
                mine = [places[k] if single else None for k, single in zip(parts, alone, strict=True)]
                for index, value in zip(parts, factors[name].values(list(parts.values()), mine), strict=True):
                    terms[index].append((1.0, value))
            return sums(terms)

    def written(self, recording: Recording, *, anew: bool = False) -> WrittenSolution | None:
        """The solution as terms of a recording; None where factors are kept, unless `anew`, or there is one entry."""
        if self.plan.entry is not None:
            return None
        blocks: dict[int, WrittenBlock] = {}
        for name in self.plan.excited:
            block = self.factor(name).written(recording, anew=anew)
            if block is None:
                return None
            blocks[name] = block

        def values(rows: Sequence[Row], parameters: Sequence[Value] | None = None) -> list[Value]:
            split, given = self._split(rows, parameters)
            terms = [[(recording.take(a), recording.take(b)) for a, b in each] for each in given]
            for name, parts in split.items():
                for index, value in zip(parts, blocks[name].values(list(parts.values()), parameters), strict=True):
                    terms[index].append((1.0, value))
            return sums(terms)

        varying = [self.factor(name).block.varying for name in blocks]
        least = {name: block.least for name, block in blocks.items() if block.least is not None}
        return WrittenSolution(values, least, [each for each in varying if each])

    @property
    def by_chunks(self) -> bool:
        """Whether each pass over the batch eliminates more than the trailing unknowns of a loaded component."""
        return self.plan.entry is None and any(self.factor(name).by_chunks for name in self.plan.excited)

    def learn(self, least: Mapping[int, Array]) -> None:
        """Take over the least pivot ratio of components, which a recording has computed."""
        for name, ratio in least.items():
            self.factor(name).learn(ratio)

    def _split(
        self, rows: Sequence[Row], parameters: Sequence[Value] | None = None
    ) -> tuple[dict[int, dict[int, Row]], list[list[tuple[Value, Value]]]]:
        """The part of each row in each loaded component, and the terms of each row in right-hand-side parameters."""
        plan = self.plan
        condensed = plan.condensed
        if condensed.chains:
            of_nodes = plan.tree.rows
            rows = [retained(row, condensed, of_nodes) for row in rows]
        component, excited = plan.component, plan.excited
        split: dict[int, dict[int, Row]] = {}
        for index, row in enumerate(rows):
            for k in row:
                name = component[k] if k >= 0 else None
                if name is not None and name in excited:
                    split.setdefault(name, {}).setdefault(index, {})[k] = row[k]
        rhs_parameters = plan.rhs_parameters.values if parameters is None else parameters
        return split, [[(value, rhs_parameters[-1 - k]) for k, value in row.items() if k < 0] for row in rows]

    def singular(self, *, excited: bool, known: NDArray[np.bool_] | None = None) -> NDArray[np.bool_]:
        """Whether the loaded (`excited`) components, or the others, are singular, (...) of the batch shape.

        Suspects are entries with pivots no larger than rounding; eigenvalues confirm them. Entries that are `known` to
        be singular, (...), need no confirmation.
        """
        out = np.zeros(self.plan.frame.shape, dtype=bool)
        if excited and self.plan.entry is not None:
            return out
        names = self.plan.excited if excited else self.plan.components - self.plan.excited
        for name in names:
            suspects = self._suspicious(name)
            if suspects.any():
                out |= self._confirmed(suspects, self.plan.members_of(name), known)
        return out

    def _confirmed(
        self, suspects: NDArray[np.bool_], members: set[int], known: NDArray[np.bool_] | None
    ) -> NDArray[np.bool_]:
        """Which suspects are singular, of the shape of `suspects`; of the batch shape where `known` is given."""
        shape = self.plan.frame.shape
        suspects = np.asarray(suspects).reshape((1,) * (len(shape) - np.ndim(suspects)) + np.shape(suspects))
        asked = suspects
        if known is not None:
            along = tuple(axis for axis, size in enumerate(suspects.shape) if size == 1)
            asked = suspects & ~np.asarray(known.all(axis=along, keepdims=True))
        # one entry is examined for all entries with the same matrix
        first = tuple(slice(0, size) for size in suspects.shape)
        where = np.zeros(shape, dtype=bool)
        where[first] = asked
        found = is_singular(self.plan, where, members)[first]
        return found if known is None else found | (suspects & known)

    def suspects(self) -> NDArray[np.bool_]:
        """Entries at which small pivots of loaded components show a loss of digits, (...) of the batch shape."""
        out = np.zeros(self.plan.frame.shape, dtype=bool)
        if self.plan.entry is not None:
            return out
        for name in self.plan.excited:
            suspects = self._suspicious(name)
            if suspects.any():
                out |= suspects
        return out

    def _suspicious(self, component: int) -> NDArray[np.bool_]:
        """Where a component has pivots close to rounding, of the batch shape over which that varies."""
        if component not in self._small:
            self._small[component] = np.asarray(~(self.factor(component).least() > SUSPECT))
        return self._small[component]

    def solved(self, component: int) -> bool:
        """Whether a component has been factorised."""
        return component in self._factors

    def negligible(self, component: int) -> int:
        """Number of couplings that the factorisation of a component neglects; 0 before it is made."""
        return self._factors[component].negligible if component in self._factors else 0

    def ran(self, component: int) -> str:
        """How a component was last computed and why, in words; empty where it was not, or by no program."""
        if self.plan.known_entry is not None:
            return self.plan.known_entry.ran
        return self._factors[component].ran if component in self._factors else ""

    def origin(self, component: int) -> str:
        """What was reused of the last solution's factor of a component, in words; empty for nothing."""
        if self.plan.known_entry is not None and self.plan.known_entry.again:
            return "the factor"
        return self._factors[component].origin if component in self._factors else ""

    def factor(self, component: int) -> BlockFactor:
        """Factorisation of a component."""
        if component not in self._factors:
            block, key = self.plan.block(component), (self.plan.chained, component)
            kept = self.former.get(key)
            with timed(self.plan.times, "factorisation"):
                factor = BlockFactor(block) if kept is None else kept.loaded(block)
            self._factors[component] = factor
            if factor.light:
                for other in [old for old in list(self.former) if old[0] is not key[0]]:
                    self.former.pop(other, None)
                self.former[key] = factor
        return self._factors[component]
