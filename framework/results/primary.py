"""The unknowns of a linear solution: what solves for them, and what stands in where double precision does not do."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

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
# Loaded parts of a frame up to which each is solved by itself, when it is first read, where a matrix is factorised: of
# many that are small all take less time together.
PARTS = 16
# Numbers of a result up to which it lies anywhere in memory, but where machine code writes it.
_PLAIN = 2**12


class Primary:
    """Values of combinations of the unknowns and the right-hand-side parameters of a plan.

    Parameters
    ----------
    plan
        The compiled frame.
    factors
        What other solutions of it leave for this one, and this one for others.
    contact
        Whether journals were moved to where they rest in their clearances.
    solver
        What solves the plan; made when it is first asked for where None.
    driven
        Entries that are known to be mechanisms which the loads set in motion, (...); None where nothing is known.

    Attributes
    ----------
    known_consistent_mechanisms
        `consistent_mechanisms`, once that has been asked for.
    """

    def __init__(
        self,
        plan: Plan,
        factors: Factors,
        *,
        contact: bool,
        solver: Solver | None = None,
        driven: NDArray[np.bool_] | None = None,
    ) -> None:
        self.plan, self.factors, self.contact, self._driven = plan, factors, contact, driven
        self.known_consistent_mechanisms: ConsistentMechanisms | None = None
        if solver is not None:
            self.solver = solver

    def under(self, plan: Plan, solver: Solver) -> Primary:
        """The same for another plan of the frame, of which other parts count as loaded."""
        return Primary(plan, self.factors, contact=self.contact, solver=solver)

    def part(self, node: int, movable: Callable[[], NDArray[np.bool_]]) -> Primary:
        """The same for that part of the frame alone which a node is in; itself where all are solved together.

        Parameters
        ----------
        node
            Number of the node.
        movable
            Gives the entries of the batch at which something can move: only what does loses its results.
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
        """What solves the plan: by broadcasting, by a band for each entry, or by one sparse factorisation for all."""
        if self.plan.method.name == BROADCAST:
            return BroadcastSolver(self.plan, self.factors.light)
        if not self.plan.constant:
            return StackedSolver(self.plan, self.factors.stacked)
        return SparseSolver(self.plan, self.factors.sparse(self.plan.unloaded, self.plan.method.name))

    @cached_property
    def sound(self) -> bool:
        """Whether no pivot raises the suspicion that something can move, so that nothing is to be looked at again."""
        solver = self.solver
        return solver.surely_regular if isinstance(solver, SparseSolver) else not any_of(solver.suspects())

    @cached_property
    def lost(self) -> NDArray[np.bool_]:
        """Entries without results of which that is plain: left out, or set in motion by the loads, (...)."""
        frame = self.frame
        absent = False if frame.absent is None else frame.absent
        left = np.array(np.broadcast_to(absent, self.shape))
        if isinstance(self.solver, SparseSolver):
            return left
        return left | (self._plain[1] if self._driven is None else self._driven)

    @cached_property
    def _plain(self) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Entries that can plainly move, and those of these which the loads set in motion, (...); of such as are known
        to be nothing is asked."""
        none = np.zeros(self.shape, dtype=bool)
        if isinstance(self.solver, SparseSolver) or self.plan.entry is not None:
            return none, none
        suspects = self.solver.suspects() & ~(none if self.frame.absent is None else self.frame.absent)
        suspects = suspects if self._driven is None else suspects & ~self._driven
        return plain_mechanisms(self.plan, suspects, loaded(self.plan, self.solver)) if suspects.any() else (none, none)

    @cached_property
    def singular(self) -> NDArray[np.bool_]:
        """Entries in which what the loads reach is singular to double precision, (...)."""
        if self.sound:
            return np.zeros(self.shape, dtype=bool)
        if isinstance(self.solver, BroadcastSolver):
            return self.solver.singular(excited=True, known=self.lost | self._plain[0])
        return self.solver.singular(excited=True)

    @cached_property
    def resolved(self) -> Solved | None:
        """Entries singular, or almost, to double precision only, solved in extended precision; None for none."""
        if self.contact or self.sound:
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
        """Entries that can move, where it is still to be found out whether the loads do work on that motion, (...)."""
        found = self.singular & ~self.lost
        return found if self.resolved is None else found & ~self.resolved.mask

    @cached_property
    def at_rest(self) -> NDArray[np.bool_]:
        """Entries that can move, and on which nothing acts, though something does on others: nothing is displaced.

        None where it is asked what loads would do.
        """
        none = self.sound or bool(self.plan.asked_unknowns)
        return np.zeros(self.shape, dtype=bool) if none else at_rest(self.plan, self._undetermined)

    @cached_property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries that the loads reach and that can move, but on whose free motions they do no work; None for none."""
        if self.sound:
            return None
        found = self._undetermined & ~self.at_rest
        self.known_consistent_mechanisms = consistent_mechanisms(self.plan, self.solver, found) if found.any() else None
        return self.known_consistent_mechanisms

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Values of combinations of unknowns and right-hand-side parameters as one array of the batch shape.

        Parameters
        ----------
        rows
            n combinations.

        Returns
        -------
        ndarray
            (..., n).
        """
        # Row by row in memory, as they are computed: nothing is copied, and what is zero is never touched.
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

    def sweep(self) -> Sweep:
        """What results of a long batch are written down in: from the elimination on, or from `stacked`."""
        recording, grid = Recording(), self.plan.grid
        if isinstance(self.solver, BroadcastSolver) and (
            self.sound or (self.resolved is None and self.consistent_mechanisms is None and not self.at_rest.any())
        ):
            written = self.solver.written(recording)
            if written is not None:
                return Sweep(grid, recording, written)

        def values(rows: Sequence[Row]) -> list[Value]:
            found = np.moveaxis(self.stacked(rows), -1, 0)
            return [recording.take(value) if row else 0.0 for row, value in zip(rows, found, strict=True)]

        return Sweep(grid, recording, values)

    def nodal(self) -> Array:
        """Displacements of all nodes in their own axes, those inside members included, (..., nodes, 6)."""
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
