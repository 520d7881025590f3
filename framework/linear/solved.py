"""A frame, its plan and its unknowns: what a linear solution is read from."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.broadcast import BroadcastSolver
from ..batched.plan import Plan
from ..clearances.clearance import Clearances
from ..clearances.determinate import DeterminateContact
from ..description import Description
from ..error_bounds.resolved import Solved
from ..factor_cache import Factors
from ..joint_examination import require_springs
from ..lazily import cached_property
from ..results.consistent_mechanisms import ConsistentMechanisms
from ..results.primary import Primary
from ..results.recovery import Recovery
from ..results.saved import SavedResults
from ..solvers.sparse import SparseSolver
from ..solvers.stacked import StackedSolver
from ..structure.parts import Row


class SolvedFrame(SavedResults):
    """A frame with what solves for its unknowns; nothing is computed before it is read.

    `linkframe.framework.Solution` tells of the attributes.
    """

    def __init__(
        self,
        frame: Description,
        plan: Plan | None,
        clearances: Clearances | None = None,
        primary: Primary | None = None,
    ) -> None:
        require_springs({name: joint.element for name, joint in frame.joints.items()})
        self.frame, self.clearances = frame, clearances
        if plan is not None:
            self.plan = plan
        if primary is not None:
            self.primary = primary
        self._known: dict[object, Array] = {}
        self._parts: dict[int, Self] = {}
        self._warned = False

    def __getstate__(self) -> dict[str, object]:
        """What a copy or another process needs: description, plan, what has been read. The rest it computes again."""
        kept = ("frame", "clearances", "_known", "_warned")
        out = {name: getattr(self, name) for name in kept} | {"_parts": {}}
        return out if self.determinate is not None else out | {"plan": self.plan}

    @cached_property
    def plan(self) -> Plan:
        """The compiled frame; where contact is known in closed form, with journals there, once it is asked for."""
        assert self.clearances is not None
        assert self.determinate is not None
        return self.clearances.plan(self.determinate.without_clearance.plan)

    @cached_property
    def primary(self) -> Primary:
        """Its unknowns, and what solves for them."""
        if self.clearances is None:
            return Primary(self.plan, Factors(), contact=False)
        return Primary(self.plan, Factors(), contact=True, driven=self.clearances.lost)

    @property
    def determinate(self) -> DeterminateContact | None:
        """Contact in closed form, which may turn out not to hold; None where there is none or it takes a search."""
        return None if self.clearances is None else self.clearances.determinate

    @property
    def pressed(self) -> DeterminateContact | None:
        """Contact in closed form where that holds; None elsewhere."""
        found = self.determinate
        return found if found is not None and found.pressed else None

    @property
    def journals(self) -> list[str]:
        """Names of the joints whose clearance is taken into account."""
        return [] if self.clearances is None else self.clearances.names

    @property
    def solver(self) -> BroadcastSolver | StackedSolver | SparseSolver:
        """What solves this plan: by broadcasting, by a band for each entry, or by one sparse factorisation for all."""
        return self.primary.solver

    @property
    def resolved(self) -> Solved | None:
        """Entries singular, or almost, to double precision only, solved in extended precision; None for none."""
        return self.primary.resolved

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Entries without results of which that is plain: left out, or set in motion by the loads, (...)."""
        return self.primary.lost

    @property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries that the loads reach and that can move, but on whose free motions they do no work; None for none."""
        return None if self.pressed is not None else self.primary.consistent_mechanisms

    @property
    def known_consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """`consistent_mechanisms`, once that has been asked for."""
        return self.primary.known_consistent_mechanisms

    def reaching(self, unknowns: Iterable[int]) -> Self:
        """The solution with what is coupled with these unknowns solved for too, though no load reaches it.

        Parameters
        ----------
        unknowns
            Numbers of unknowns.

        Returns
        -------
        Solution
            This one where these unknowns were solved for.
        """
        asked = list(unknowns)
        solver = self.solver.reaching(asked)
        known = solver is self.solver
        if known and not self.primary.at_rest.any():
            return self
        plan = self.plan.asking(asked) if known or not isinstance(solver, BroadcastSolver) else solver.plan
        return type(self)(self.frame, plan, self.clearances, self.primary.under(plan, solver))

    def cut(self) -> Self:
        """The solution of the frame with its members cut into their segments; this one where they are.

        Returns
        -------
        Solution
            Of the same frame, with a node between any two segments.
        """
        plan = self.plan
        counts = [member.element.segments for member in plan.frame.members.values()]
        if np.array_equal(plan.topology.counts, counts):
            return self
        return type(self)(self.frame, Plan(plan.frame, cut=True, method=plan.asked), self.clearances)

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Value of each combination of unknowns and prescribed numbers, as one array of the batch shape.

        Parameters
        ----------
        rows
            The n combinations, coefficient by number of the unknown (below zero: of the prescribed number).

        Returns
        -------
        ndarray
            Their values, (..., n).
        """
        return self.primary.stacked(rows)

    def nodal(self) -> Array:
        """Displacement of every node in its own axes, those inside members included.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., nodes, 6), in the order of the plan's numbers.
        """
        return self.primary.nodal()

    @cached_property
    def _recovery(self) -> Recovery:
        return Recovery(self.primary)
