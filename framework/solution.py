"""The class `Solution`: the linear static solution of a frame, computed as its results are read."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

from .batched.idle import released
from .batched.plan import Plan
from .clearances import clearance as contact_in_clearance
from .clearances import contact_search
from .clearances.joints import joints_with_clearance
from .description import Description, alone
from .explain import explain
from .factor_cache import Factors, beside, planned
from .linear.trust import ResultsWithBounds
from .results.primary import Primary
from .solvers.method import BROADCAST, checked

if TYPE_CHECKING:
    from .clearances.contact_state import ClearanceComponents


class Solution(ResultsWithBounds):
    """Displacements, reactions and forces of a solved frame, each of the frame's batch shape.

    Obtained from ``frame.solve()``. Batch entries at which the frame is kinematically unstable have the `status`
    ``mechanism`` and NaN for results; a `MechanismWarning` says so when they are first read. Where the loads do no work
    on the free motion, only displacements that are part of that motion are NaN. Parts of the frame that are not
    connected with the moving one keep their results.

    Attributes
    ----------
    frame
        Copy of the description at the time of ``solve``; a `Frame` if that was one.
    plan
        What depends on the topology alone: numbering, joint tree, order of elimination.
    clearances
        Contact states of the joints with clearance; None where there are none, or they were left out.
    primary
        The unknowns and the solver that computes them.

    Examples
    --------
    >>> from linkframe.elements import Beam, Circle, Material
    >>> from linkframe.framework import Frame
    >>> frame = Frame()
    >>> for name, x in {"A": 0.0, "B": 1.0}.items():
    ...     frame.node(name, (x, 0.0, 0.0))
    >>> frame.add("AB", Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3)), "A", "B")
    >>> frame.fix("A"); frame.load("B", fy=-10.0)
    >>> solution = frame.solve()
    >>> solution.reaction("A").round(9).tolist()
    [0.0, 10.0, 0.0, 0.0, 0.0, 10.0]
    >>> solution.forces("AB", [0.0, 0.5])[:, 5].round(9).tolist()
    [-10.0, -5.0]
    >>> bool((abs(solution.error_bound("B")) < 1e-15).all()), str(solution.status), bool(solution.linear)
    (True, 'regular', True)
    """

    @classmethod
    def of(cls, frame: Description, method: str | None = None, *, clearance: bool = False) -> Solution:
        """Solution of a frame, independent of later changes of the frame.

        Parameters
        ----------
        frame
            The description.
        method
            Name of the method, see `Frame.solve`; None to choose it by expected time.
        clearance
            Whether to take the joints' clearances into account; unlike in `Frame.solve`, not by default.

        Returns
        -------
        Solution
            The solution, of which nothing is computed yet.

        Raises
        ------
        FrameError
            If the method is unknown, not installed, or not for this batch.
        """
        described, asked = frame.copy(), checked(method)
        between = clearance and bool(joints_with_clearance(described))
        if not (described.idle or between):  # as most often: nothing needs the plan a second time
            plan, factors = planned(frame, described, asked)
            return cls(described, plan, primary=Primary(plan, factors))

        @cache
        def whole() -> tuple[Plan, Factors]:
            return planned(frame, described, asked)

        if described.idle and (free := released(described, whole()[0].topology)) is not described:
            return cls.of(free, method, clearance=clearance)
        if not between:
            plan, factors = whole()
            return cls(described, plan, primary=Primary(plan, factors))

        def search(
            some: Description, components: ClearanceComponents, resists: bool | None
        ) -> contact_search.ContactSearch:
            part = some is not described

            def loaded() -> tuple[Solution, Factors]:
                plan, factors = (Plan(alone(some), method=asked), Factors()) if part else whole()
                return cls(some, plan, primary=Primary(plan, factors)), factors

            def with_offsets(given: Description) -> Solution:
                plan, factors = (
                    (Plan(alone(given), method=asked, apart=True), Factors())
                    if part
                    else planned(frame, given, asked, apart=True)
                )
                return cls(given, plan, primary=Primary(plan, factors))

            solvers = contact_search.FrameSolvers(cls.of, cls._per_unit, loaded, with_offsets)
            return contact_search.ContactSearch(some, components, solvers, resists)

        contact = contact_in_clearance.Clearances(described, search, asked)
        return cls(described, contact.plan, contact)

    @classmethod
    def _per_unit(cls, known: Plan, frame: Description) -> Solution:
        """A solution from which results per unit of each offset that varies are found, by broadcasting elimination.

        The plan of the same members under other loads is `known`.
        """
        plan = Plan(alone(frame), method=BROADCAST, former=beside(known, frame), apart=True)
        return cls(frame, plan, primary=Primary(plan, Factors()))

    def explain(self) -> str:
        """Report in words of what is computed at which batch shapes, what is skipped, and why.

        Returns
        -------
        str
            Lines of text.
        """
        found = self.pressed
        return explain(self if found is None else found.without_clearance, self.clearances)
