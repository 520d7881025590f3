"""A frame with its plan, its solver and its unknowns, from which the results of a linear solution are computed."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.broadcast import BroadcastSolver
from ..batched.plan import Plan
from ..described.released_ends import with_hinges
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

if TYPE_CHECKING:
    from ..clearances.clearance import Clearances
    from ..clearances.determinate import DeterminateContact


class SolvedFrame(SavedResults):
    """A frame with its plan, unknowns and solver, each built when it is first needed.

    `linkframe.framework.Solution` lists the attributes.
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
        """The fields to copy or pickle: description, plan and results read so far; the rest is computed again."""
        kept = ("frame", "clearances", "_known", "_warned")
        out = {name: getattr(self, name) for name in kept} | {"_parts": {}}
        return out if self.determinate is not None else out | {"plan": self.plan}

    @cached_property
    def plan(self) -> Plan:
        """Numbering, joint tree and order of elimination, the journals being at their points of contact."""
        assert self.clearances is not None
        assert self.determinate is not None
        without_clearance = self.determinate.without_clearance.plan
        return self.clearances.plan_with_offsets(without_clearance.asked, without_clearance)

    @cached_property
    def primary(self) -> Primary:
        """The unknowns and the solver that computes them."""
        if self.clearances is None:
            return Primary(self.plan, Factors())
        return Primary(self.plan, Factors(), driven=self.clearances.lost)

    @property
    def determinate(self) -> DeterminateContact | None:
        """Contact in closed form, still to be checked; None where there is none, or only a search can find it."""
        return None if self.clearances is None else self.clearances.determinate

    @property
    def pressed(self) -> DeterminateContact | None:
        """Contact in closed form where it has been checked and holds; else None."""
        found = self.determinate
        return found if found is not None and found.pressed else None

    @property
    def journals(self) -> list[str]:
        """Names of the joints whose clearance is taken into account."""
        return [] if self.clearances is None else self.clearances.names

    @property
    def solver(self) -> BroadcastSolver | StackedSolver | SparseSolver:
        """The solver: broadcast elimination, one banded factor for each entry, or one sparse factor for all."""
        return self.primary.solver

    @property
    def by_chunks(self) -> bool:
        """Whether results that are asked for together take much less than one by one, as each pass eliminates anew."""
        return self.primary.by_chunks

    @property
    def resolved(self) -> Solved | None:
        """Results in extended precision of entries that are almost singular in double precision; None for none."""
        return self.primary.resolved

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Entries that certainly have no results, (...): left out, or kinematically unstable under the loads."""
        return self.primary.lost

    @property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries at which a loaded part has a free motion on which the loads do no work; None for none."""
        return None if self.pressed is not None else self.primary.consistent_mechanisms

    @property
    def known_consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """`consistent_mechanisms` if it has been computed already, else None."""
        return self.primary.known_consistent_mechanisms

    def reaching(self, unknowns: Iterable[int]) -> Self:
        """The solution in which these unknowns are solved for even if no load reaches them.

        Parameters
        ----------
        unknowns
            Numbers of the unknowns; those coupled with them are solved for as well.

        Returns
        -------
        Solution
            This one where they are solved for already.
        """
        asked = list(unknowns)
        solver = self.solver.reaching(asked)
        known = solver is self.solver
        if known and not self.primary.at_rest.any():
            return self
        plan = self.plan.asking(asked) if known or not isinstance(solver, BroadcastSolver) else solver.plan
        return type(self)(self.frame, plan, self.clearances, self.primary.under(plan, solver))

    def cut(self) -> Self:
        """The solution of the same frame with its members divided into their segments.

        Returns
        -------
        Solution
            Solution with a node between any two segments, and one at either side of a released end; this one where its
            members are divided already and have no releases.
        """
        plan, hinged = self.plan, with_hinges(self.plan.frame)
        counts = [member.element.segments for member in plan.frame.members.values()]
        if hinged is plan.frame and np.array_equal(plan.topology.counts, counts):
            return self
        return type(self)(self.frame, Plan(hinged, cut=True, method=plan.asked), self.clearances)

    def stacked(self, rows: Sequence[Row]) -> Array:
        """The values of linear combinations of unknowns and prescribed values, as one array of the batch shape.

        Parameters
        ----------
        rows
            The n combinations, each as coefficients by number of the unknown (negative: of the prescribed value).

        Returns
        -------
        ndarray
            Their values, (..., n).
        """
        return self.primary.stacked(rows)

    def nodal(self) -> Array:
        """Displacement of every node in its own axes, nodes inside members included.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz``, (..., nodes, 6), length and radians, in the order of the plan's numbering.
        """
        return self.primary.nodal()

    @cached_property
    def _recovery(self) -> Recovery:
        return Recovery(self.primary)
