"""The unknowns of a linear solution: their solver, and the methods that replace it where double precision fails."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, any_of
from ..batched.broadcast import BroadcastSolver
from ..batched.plan import Plan
from ..description import Description
from ..error_bounds.resolved import MOST, Resolved, ResolvedByBands, ResolvedLarge, Solved
from ..factor_cache import Factors
from ..lazily import cached_property
from ..program.recording import Recording
from ..program.sweep import Sweep, zeros
from ..solvers.method import BROADCAST
from ..solvers.sparse import SparseSolver
from ..solvers.stacked import StackedSolver
from ..structure.parts import Row, Value
from .consistent_mechanisms import ConsistentMechanisms, consistent_mechanisms, loaded
from .driven_mechanisms import at_rest, plain_mechanisms

Solver = BroadcastSolver | StackedSolver | SparseSolver
# Up to this many loaded parts of a frame are solved separately, each when it is first read, if a matrix is factorised;
# many small parts take less time together.
PARTS = 16
# Results of up to this size need no aligned memory, unless machine code writes them.
_PLAIN = 2**12


class Primary:
    """The unknowns of a plan, and the values of rows over them.

    Parameters
    ----------
    plan
        The plan of the frame.
    factors
        Factors that solutions of the same frame share.
    solver
        The solver; made when first needed where None.
    driven
        Mask of the entries known to be kinematically unstable under the loads, (...); None if nothing is known.

    Attributes
    ----------
    known_consistent_mechanisms
        `consistent_mechanisms` if it has been computed already, else None.
    """

    def __init__(
        self,
        plan: Plan,
        factors: Factors,
        *,
        solver: Solver | None = None,
        driven: NDArray[np.bool_] | None = None,
    ) -> None:
        self.plan, self.factors, self._driven = plan, factors, driven
        self.known_consistent_mechanisms: ConsistentMechanisms | None = None
        if solver is not None:
            self.solver = solver

    def under(self, plan: Plan, solver: Solver) -> Primary:
        """The unknowns of another plan of the frame, in which other parts count as loaded."""
        return Primary(plan, self.factors, solver=solver)

    def part(self, node: int, movable: Callable[[], NDArray[np.bool_]]) -> Primary:
        """The unknowns of the part of the frame that contains a node; itself where all parts are solved together.

        Parameters
        ----------
        node
            Number of the node.
        movable
            Function that returns a mask of the entries with free motions, (...): there parts are solved separately, so
            that only the moving one loses its results.
        """
        solver = self.solver
        together = not isinstance(solver, BroadcastSolver) and solver.parts > PARTS and not movable().any()
        if solver.parts < 2 or together:
            return self
        alone = solver.part(node)
        if alone is solver:
            return self
        plan = alone.plan if isinstance(alone, BroadcastSolver) else self.plan.part(node)
        return self.under(plan, alone)

    @property
    def frame(self) -> Description:
        """The description that is solved."""
        return self.plan.frame

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.plan.frame.shape

    @cached_property
    def solver(self) -> Solver:
        """The solver: broadcast elimination, one banded factor for each entry, or one sparse factor for all."""
        if self.plan.method.name == BROADCAST:
            return BroadcastSolver(self.plan, self.factors.light)
        if not self.plan.constant:
            return StackedSolver(self.plan, self.factors.stacked)
        return SparseSolver(self.plan, self.factors.sparse(self.plan.unloaded, self.plan.method.name))

    @property
    def by_chunks(self) -> bool:
        """Whether results that are asked for together take much less than one by one, as each pass eliminates anew."""
        return isinstance(self.solver, BroadcastSolver) and self.solver.by_chunks

    @cached_property
    def sound(self) -> bool:
        """Whether pivots show at all entries that there are no free motions, so that no further test is needed."""
        solver = self.solver
        return solver.surely_regular if isinstance(solver, SparseSolver) else not any_of(solver.suspects())

    @cached_property
    def lost(self) -> NDArray[np.bool_]:
        """Entries that certainly have no results, (...): left out, or kinematically unstable under the loads."""
        frame = self.frame
        absent = False if frame.absent is None else frame.absent
        left = np.array(np.broadcast_to(absent, self.shape))
        # a program has results at all entries, which is known without its solver
        program = self.plan.entry is not None and self._driven is None
        if program or isinstance(self.solver, SparseSolver):
            return left
        return left | (self._plain[1] if self._driven is None else self._driven)

    @cached_property
    def _plain(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Masks of the entries with certain free motions, and of those that loads certainly set in motion, (...) each.

        Entries that are known to be unstable are not examined.
        """
        none = np.zeros(self.shape, dtype=bool)
        if isinstance(self.solver, SparseSolver) or self.plan.entry is not None:
            return none, none
        suspects = self.solver.suspects() & ~(none if self.frame.absent is None else self.frame.absent)
        suspects = suspects if self._driven is None else suspects & ~self._driven
        return plain_mechanisms(self.plan, suspects, loaded(self.plan, self.solver)) if suspects.any() else (none, none)

    @cached_property
    def singular(self) -> NDArray[np.bool_]:
        """Entries at which the loaded components are singular in double precision, (...)."""
        if self.sound:
            return np.zeros(self.shape, dtype=bool)
        if isinstance(self.solver, BroadcastSolver):
            return self.solver.singular(excited=True, known=self.lost | self._plain[0])
        return self.solver.singular(excited=True)

    @cached_property
    def resolved(self) -> Solved | None:
        """Results in extended precision of entries that are almost singular in double precision; None for none."""
        if self.sound:
            return None
        found: Solved
        if isinstance(self.solver, SparseSolver):
            if self.solver.unsupported_motions(self.solver.excited).size or not self.singular.any():
                return None
            found = (
                Resolved(self.plan, self.singular, loaded(self.plan, self.solver))
                if len(self.plan.unknowns) <= MOST
                else ResolvedLarge(self.plan, self.solver)
            )
        else:
            suspects = self.solver.suspects() & ~(self.lost | self._plain[0])
            if not suspects.any():
                return None
            if len(self.plan.unknowns) <= MOST:
                found = Resolved(self.plan, suspects, loaded(self.plan, self.solver))
            elif isinstance(self.solver, StackedSolver) or not (lost := self.singular & ~self.lost).any():
                return None
            else:
                found = ResolvedByBands(self.plan, lost)
        return found if found.mask.any() else None

    @cached_property
    def _undetermined(self) -> NDArray[np.bool_]:
        """Entries with free motions for which it is not yet known whether the loads do work on them, (...)."""
        found = self.singular & ~self.lost
        return found if self.resolved is None else found & ~self.resolved.mask

    @cached_property
    def at_rest(self) -> NDArray[np.bool_]:
        """Entries with free motions on which nothing acts, unlike on others: all displacements are zero, (...).

        All False where unloaded unknowns are solved for.
        """
        none = self.sound or bool(self.plan.asked_unknowns)
        return np.zeros(self.shape, dtype=bool) if none else at_rest(self.plan, self._undetermined)

    @cached_property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries at which a loaded part has a free motion on which the loads do no work; None for none."""
        if self.sound:
            return None
        found = self._undetermined & ~self.at_rest
        self.known_consistent_mechanisms = consistent_mechanisms(self.plan, self.solver, found) if found.any() else None
        return self.known_consistent_mechanisms

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Values of rows over unknowns and right-hand-side parameters, as one array of the batch shape.

        Parameters
        ----------
        rows
            The n rows.

        Returns
        -------
        ndarray
            Values, (..., n).
        """
        # Row by row in memory, as they are computed: nothing is copied, and memory of zeros is never touched.
        solver = self.solver
        plain = math.prod(self.shape) <= _PLAIN and not isinstance(solver, BroadcastSolver)
        whole = np.zeros((len(rows), *self.shape)) if plain else zeros(len(rows), self.shape)
        places = [whole[k, ...] for k in range(len(rows))]
        found = solver.values(rows, places) if isinstance(solver, BroadcastSolver) else solver.values(rows)
        for place, value in zip(places, found, strict=True):
            if value is not place and (isinstance(value, np.ndarray) or value != 0.0):
                place[...] = value
        out: Array = whole.transpose(*range(1, whole.ndim), 0)
        if self.sound:
            return out
        if self.resolved is not None:
            out[self.resolved.mask] = self.resolved.values(rows)
        if self.consistent_mechanisms is not None:
            out[self.consistent_mechanisms.mask] = self.consistent_mechanisms.values(rows)
        if self.at_rest.any():
            out[self.at_rest] = 0.0
        return out

    def recorded(self, results: Callable[[Sweep], Sequence[Sequence[Value]]]) -> list[Array]:
        """Some results, each (..., n), in one pass over a long batch.

        Parameters
        ----------
        results
            Function that adds results, each of n numbers, to a recording.
        """
        recording, solver = Recording(), self.solver
        if isinstance(solver, BroadcastSolver) and self._may_hold and (written := solver.written(recording)):
            once = Sweep(self.plan.grid, recording, written.values, written.later)
            found, least = once.run(results(once), [*written.least.values()])
            solver.learn(dict(zip(written.least, least, strict=True)))
            if self._all_hold:
                return found
            recording = Recording()

        def values(rows: Sequence[Row]) -> list[Value]:
            found = np.moveaxis(self.stacked(rows), -1, 0)
            return [recording.take(value) if row else 0.0 for row, value in zip(rows, found, strict=True)]

        once = Sweep(self.plan.grid, recording, values)
        return once.run(results(once))[0]

    def per_unit(
        self, parameters: Sequence[int], results: Callable[[Callable[[int | None], Sweep]], Sequence[Sequence[Value]]]
    ) -> list[Array] | None:
        """Some results, each (..., n), that follow from the effects of unit right-hand-side parameters, in one pass.

        Parameters
        ----------
        parameters
            Indices of these parameters.
        results
            Function that adds results, each of n numbers, to a recording, given a function of the index of a parameter:
            the recording of the unknowns where that parameter is one, and no other acts; of None, the one where all
            parameters but these act.

        Returns
        -------
        list of ndarray or None
            The results; None where they do not hold at all entries.
        """
        recording, solver, grid = Recording(), self.solver, self.plan.grid
        if not isinstance(solver, BroadcastSolver) or (written := solver.written(recording, anew=True)) is None:
            return None
        every = self.plan.rhs_parameters.values

        def under(parameter: int | None) -> Sweep:
            acting: list[Value] = [float(k == parameter) for k in range(len(every))]
            if parameter is None:
                acting = [0.0 if k in parameters else value for k, value in enumerate(every)]
            return Sweep(grid, recording, partial(written.values, parameters=acting))

        once = Sweep(grid, recording, written.values, written.later)
        found, least = once.run(results(under), [*written.least.values()])
        solver.learn(dict(zip(written.least, least, strict=True)))
        return found if self._all_hold else None

    @property
    def _may_hold(self) -> bool:
        """Whether results of the elimination hold at all entries, as far as that is known."""
        return "sound" not in vars(self) or self._all_hold

    @property
    def _all_hold(self) -> bool:
        """Whether results of the elimination hold at all entries."""
        return self.sound or (
            self.resolved is None and self.consistent_mechanisms is None and not bool(self.at_rest.any())
        )

    def nodal(self) -> Array:
        """Displacements of all nodes in their own axes, nodes inside members included, (..., nodes, 6)."""
        count = len(self.plan.topology.number)
        better = self.resolved
        if (
            isinstance(self.solver, SparseSolver)
            and self.consistent_mechanisms is None
            and (better is None or isinstance(better, ResolvedLarge))
        ):
            unknowns = self.solver.unknowns if better is None else better.whole(self.solver)
            return self.solver.nodal(unknowns).reshape(*self.shape, count, 6)
        rows = [self.plan.tree.row(node, k) for node in range(count) for k in range(6)]
        return self.stacked(rows).reshape(*self.shape, count, 6)
