"""Static solution of a batch: nothing is computed before it is read."""

from __future__ import annotations

from .batched.idle import released
from .clearances.clearance import Clearances, joints_with_clearance
from .description import Description
from .explain import explain
from .factor_cache import planned
from .linear.trust import ResultsWithBounds
from .results.primary import Primary
from .solvers.method import checked


class Solution(ResultsWithBounds):
    """Displacements, reactions and forces of a solved frame, each of the frame's batch shape.

    Obtained from ``frame.solve()``. Entries that are kinematically unstable hold NaN and say so in `status`; a
    `MechanismWarning` tells so when they are first read. Where no load does work on a free motion, only displacements
    that it has a part in are NaN. A part of the frame that no member, joint or tie
    connects with what moves keeps its results.

    Attributes
    ----------
    frame
        The description as it was when solved; a `Frame` where that was solved.
    plan
        The compiled frame.
    clearances
        Contact of its joints with clearance; None where there are none, or they were left out.
    primary
        Its unknowns, and what solves for them.

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
        """Solution of a frame; later changes of the frame do not reach it.

        Parameters
        ----------
        frame
            The description.
        method
            The way in which it is solved, see `Frame.solve`.
        clearance
            Whether to find where joints with clearance are in contact, see `Frame.solve`.

        Returns
        -------
        Solution
            Nothing is solved yet: each result is computed when it is first read.

        Raises
        ------
        FrameError
            If the method is unknown, not installed, or not for this batch.
        """
        described = frame.copy()
        plan, factors = planned(frame, described, checked(method))
        if described.idle and (free := released(described, plan.topology)) is not described:
            return cls.of(free, method, clearance=clearance)
        without_clearance = cls(described, plan, primary=Primary(plan, factors, contact=False))
        if not (clearance and joints_with_clearance(described)):
            return without_clearance
        contact = Clearances(described, without_clearance, cls.of)
        return cls(described, contact.plan(plan) if contact.determinate is None else None, contact)

    def explain(self) -> str:
        """What is built at which batch shapes, what is skipped, and why, in plain words.

        Returns
        -------
        str
            Lines for a reader.
        """
        found = self.pressed
        return explain(self if found is None else found.without_clearance, self.clearances)
