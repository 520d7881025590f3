"""Whether the equilibrium of a linear solution is stable: above a buckling load it is not, however small displacements
are.

It is unstable if the stiffness plus the geometric stiffness of the solution's forces is not positive definite, which an
attempted Cholesky factorisation shows. Members are divided into their segments, as for buckling.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..entries import WHOLE, Entries, Stretch
from ..error_bounds.bounds import BatchPart, BoundedResults
from ..error_bounds.equilibrium import EquilibriumResidual
from ..solvers.rounding import zero_eigenvalue
from ..solvers.sparse import SparseSolver
from ..states import SolutionState
from . import dense
from .sparse_spectrum import SparsePencil
from .spectrum import DENSE
from .under_load import Stack, at_entry, geometric_stacks, over_dofs

Mask = NDArray[np.bool_]
# Size of the matrices over all DOFs that are in memory at a time.
_NUMBERS = 2**21


class Stability:
    """Which batch entries of a linear solution are stable.

    Parameters
    ----------
    solution
        The solution.
    """

    def __init__(self, solution: BoundedResults) -> None:
        self._asked = np.asarray(solution.own_state == SolutionState.REGULAR)
        self._found = np.zeros(solution.shape, dtype=bool)
        self._solution = solution.cut()
        plan = self._solution.plan
        self._sparse = plan.large and len(plan.unknowns) > DENSE
        self._shared, self._done = self._solution is solution and not self._sparse, not plan.unknowns

    def see(self, part: BatchPart) -> None:
        """Examine a part of the batch with its known state, if the members of the solution are divided already."""
        if self._shared and isinstance(part.state.change, Stretch):
            self._judge(part.where, part.state)
            self._done = True

    def unstable(self) -> Mask:
        """Entries whose load exceeds a buckling load, (...); False for entries that are not regular."""
        if not self._done and self._asked.any():
            with np.errstate(all="ignore"):  # of mechanisms
                if self._sparse:
                    self._found = self._asked & _sparse(self._solution)
                else:
                    for where, state in self._solution.bounds.states():
                        self._judge(where, state)
        return self._found

    def _judge(self, where: tuple[slice, ...], state: EquilibriumResidual) -> None:
        if self._asked[where].any():
            self._found[where] = _dense(self._solution.plan, where, state, self._asked[where])


def _dense(plan: Plan, where: tuple[slice, ...], state: EquilibriumResidual, asked: Mask) -> Mask:
    """Mask of the unstable ones among the `asked` entries of a part of the batch."""
    stacks = [(nodes, matrices) for nodes, matrices in geometric_stacks(state) if matrices.any()]
    found = [(nodes, _whole(matrices, asked.ndim)) for nodes, matrices in stacks]
    if not found:
        return np.zeros(asked.shape, dtype=bool)
    if not where:
        return _of(plan, found, asked, WHOLE)
    assert isinstance(state.change, Stretch)
    axis, ndim = state.change.axis, asked.ndim
    out, first, count = np.zeros(asked.shape, dtype=bool), where[axis].start, asked.shape[axis]
    step = max(1, count * _NUMBERS // (asked.size * (6 * len(plan.topology.number)) ** 2))
    for some in (slice(k, min(k + step, count)) for k in range(0, count, step)):
        here = Stretch(ndim=ndim, axis=axis, indices=some)
        there = Stretch(ndim=ndim, axis=axis, indices=slice(first + some.start, first + some.stop))
        own = [(nodes, here(matrices, 2, leading=1)) for nodes, matrices in found]
        at = (slice(None),) * axis + (some,)
        out[at] = _of(plan, own, asked[at], there)
    return out


def _whole(matrices: Array, ndim: int) -> Array:
    """Matrices (n, ..., m, m) with all batch axes."""
    missing = (1,) * (ndim + 3 - matrices.ndim)
    return matrices.reshape(len(matrices), *missing, *matrices.shape[1:])


def _of(plan: Plan, stacks: list[Stack], asked: Mask, entries: Entries) -> Mask:
    """Mask of the unstable ones among the `asked` entries, from the geometric matrices there."""
    nodal = over_dofs(plan, stacks)
    whole = dense.with_springs(plan, dense.reduced(plan, dense.of_members(plan, entries) + nodal, entries), entries)
    if _definite(dense.scaled(whole)[0], asked):
        return np.zeros(asked.shape, dtype=bool)
    stiffness = dense.stiffness(plan, entries)
    root = dense.scaled(stiffness)[1]
    whole = (stiffness + dense.reduced(plan, nodal, entries)) * root[..., :, None] * root[..., None, :]
    whole[~np.broadcast_to(asked, whole.shape[:-2])] = np.eye(whole.shape[-1])
    return np.asarray(asked & (np.linalg.eigvalsh(whole)[..., 0] < -zero_eigenvalue(whole.shape[-1])))


def _definite(whole: Array, asked: Mask) -> bool:
    """Whether all matrices (..., n, n) in the mask `asked` are positive definite."""
    if not asked.all():
        whole[~np.broadcast_to(asked, whole.shape[:-2])] = np.eye(whole.shape[-1])
    try:
        np.linalg.cholesky(whole)
    except np.linalg.LinAlgError:
        return False
    return True


def _sparse(solution: BoundedResults) -> Mask:
    """Mask of the unstable load cases of one large frame."""
    assert isinstance(solution.solver, SparseSolver)
    solver, shape = solution.solver, solution.shape
    found: list[Stack] = geometric_stacks(solution.bounds.whole())
    out = np.zeros(shape, dtype=bool)
    for entry in np.ndindex(*shape):
        added = solver.matrices.reduced([(nodes, at_entry(entry, matrices).__getitem__) for nodes, matrices in found])
        # a pivot that is not positive may be caused by rounding
        if not solver.direct(solver.stiffness + added).definite:
            out[entry] = SparsePencil(solver).greatest(-added, 1)[0][0] > 1.0
    return out
