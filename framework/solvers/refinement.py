"""Iterative refinement of a solution in double precision, with residuals in extended precision.

With a factor of a matrix of condition number kappa, a solution has a relative error of about eps kappa; a step with the
residual by springs, in which rigid motion costs no energy, multiplies the error by eps kappa once more (Higham,
*Accuracy and Stability of Numerical Algorithms*, 2nd ed., 2002, ch. 12).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..batch import Array, all_of, any_of
from ..entries import Stretch
from ..error_bounds.equilibrium import EquilibriumResidual, Statics
from ..structure.topology import Index
from .band_factors import in_pairs
from .refined_values import InLong, InPairs, Refined, greatest
from .spring_residual import SpringResidual

# Up to this many unknowns solutions are refined, which takes some tenths of a second; ill-conditioned frames, such as
# finely divided links, are of that size.
REFINED = 20_000
# Size of the part of a solution that is refined at a time.
_ROOM = 2**20
# Relative error to reach, and largest number of steps: close to singular each step removes little of the error.
_FINE, _STEPS = 1e-15, 12


def refined_by_springs(residual: SpringResidual, values: Array, solve: Callable[[Array], Array]) -> tuple[Array, bool]:
    """A solution refined until only rounding is left.

    Parameters
    ----------
    residual
        Residual of the equations.
    values
        The values of the unknowns, (n, load cases).
    solve
        Function that returns the solution (n, k) for loads (n, k), by a factor in double precision.

    Returns
    -------
    tuple
        The refined values, (n, load cases), and whether the steps converged.
    """
    pairs = in_pairs(values.shape[1], len(values)) and not residual.summed_finely
    step = max(1, _ROOM // max(1, len(values)))
    if values.shape[1] <= step:
        return _refined(residual, values, solve, pairs=pairs)
    out, ended = np.empty_like(values), True
    for start in range(0, values.shape[1], step):
        part = slice(start, start + step)
        out[:, part], each = _refined(residual.of(part), values[:, part], solve, pairs=pairs)
        ended &= each
    return out, ended


def _refined(
    residual: SpringResidual, values: Array, solve: Callable[[Array], Array], *, pairs: bool
) -> tuple[Array, bool]:
    found: Refined = InPairs(residual.left_by_pairs, values) if pairs else InLong(residual.left, values)
    sizes = greatest(values)
    going, before = sizes > 0.0, sizes
    for _ in range(_STEPS):
        change = solve(found.left())
        finite = np.isfinite(change)
        if not (all_of(finite) and all_of(going)):
            change[~(finite & going)] = 0.0
        moved = found.add(change)
        # the error shrinks in each step by the ratio of this change to the one before, or to the solution at first
        going &= moved**2 > _FINE * sizes * before
        before = moved
        if not any_of(going):
            break
    return found.rounded, not any_of(going)


def refined(statics: Statics, unknowns: Index, values: Array, solve: Callable[[Array], Array]) -> Array:
    """A solution after one step of refinement.

    Parameters
    ----------
    statics
        The frame in extended precision; no stiffness in it varies over the batch.
    unknowns
        Numbers of the unknowns (n,).
    values
        Values of the unknowns, (n, load cases).
    solve
        Function that returns the solution (n, k) for loads (n, k), by a factor in double precision.

    Returns
    -------
    ndarray
        The refined values, (n, load cases).
    """
    shape, keys = statics.plan.frame.shape, unknowns.tolist()
    axis = int(np.argmax(shape)) if shape else 0
    whole = values.T.reshape(*shape, len(keys))
    better = np.empty_like(whole)
    step = max(1, _ROOM * max(shape, default=1) // values.size)
    for start in range(0, max(shape, default=1), step):
        part = Stretch(ndim=len(shape), axis=axis, indices=slice(start, start + step))
        balance = EquilibriumResidual(statics, part, keys, whole[part.where]).balance.astype(np.float64)
        change = solve(balance.reshape(-1, len(keys)).T).T.reshape(balance.shape)
        better[part.where] = whole[part.where] + np.where(np.isfinite(change), change, 0.0)
    return better.reshape(-1, len(keys)).T
