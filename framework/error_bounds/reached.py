"""What an asked result depends on, where no load reaches it: derivatives are there all the same."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from ..batched.broadcast import BroadcastSolver
from .adjoint import unit_forces
from .asked import asked
from .equilibrium import Equilibrium
from .kinematics import extended

if TYPE_CHECKING:
    from ..solution import Solution


def reaching(solution: Solution, unknowns: Iterable[int]) -> Solution:
    """The solution with what is coupled with these unknowns solved for too, though no load reaches it.

    Parameters
    ----------
    solution
        A linear solution, which leaves out what rests.
    unknowns
        Numbers of unknowns.
    """
    solver = solution.solver.reaching(unknowns)
    if solver is solution.solver:
        return solution
    plan = solver.plan if isinstance(solver, BroadcastSolver) else solution.plan
    twin = type(solution)(solution.frame, plan, solution.clearances)
    twin.solver = solver
    return twin


def worked_on(solution: Solution, name: str, kind: str, index: int) -> list[int]:
    """Unknowns on which the force acts that does work equal to one component of a result.

    Parameters
    ----------
    solution
        A linear solution.
    name, kind, index
        The result and its component, see `linkframe.framework.error_bounds.asked`.
    """
    unknowns = solution.plan.unknowns
    if not unknowns:
        return []
    found = np.zeros(len(unknowns), dtype=bool)
    none = extended(np.zeros((*(1,) * len(solution.shape), len(unknowns))))
    for cut in solution.bounds.cuts():
        state = Equilibrium(solution.bounds.statics, cut, unknowns, none)
        forces = unit_forces(state, asked(state, name, kind))[index]
        found |= (forces != 0.0).reshape(-1, len(unknowns)).any(axis=0)
    return [unknown for unknown, acting in zip(unknowns, found.tolist(), strict=True) if acting]
