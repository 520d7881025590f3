"""What an asked result depends on, where no load reaches it: derivatives are there all the same."""

from __future__ import annotations

import numpy as np

from .adjoint import unit_forces
from .bounds import BoundedResults
from .equilibrium import EquilibriumResidual
from .kinematic_edge import extended
from .requested import requested


def unknowns_of_result(solution: BoundedResults, name: str, kind: str, index: int) -> list[int]:
    """Unknowns on which the force acts that does work equal to one component of a result.

    Parameters
    ----------
    solution
        A linear solution.
    name, kind, index
        The result and its component, see `linkframe.framework.error_bounds.requested`.
    """
    unknowns = solution.plan.unknowns
    if not unknowns:
        return []
    found = np.zeros(len(unknowns), dtype=bool)
    none = extended(np.zeros((*(1,) * len(solution.shape), len(unknowns))))
    for cut in solution.bounds.cuts():
        state = EquilibriumResidual(solution.bounds.statics, cut, unknowns, none)
        forces = unit_forces(state, requested(state, name, kind).only((index,)))
        found |= (forces != 0.0).reshape(-1, len(unknowns)).any(axis=0)
    return [unknown for unknown, acting in zip(unknowns, found.tolist(), strict=True) if acting]
