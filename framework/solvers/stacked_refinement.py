"""Iterative refinement of the solutions of a batch, with residuals in extended precision.

The number of steps for a load case depends on that load case alone, so that results do not depend on the batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, all_of, any_of
from ..batched.plan import Plan
from ..error_bounds.equilibrium import EquilibriumResidual
from ..error_bounds.kinematic_edge import Real
from ..error_bounds.kinematics import FrameKinematics
from ..error_bounds.picked import PickedStatics
from ..error_bounds.resistance import resisted
from ..structure.topology import Index
from .evaluation import Picked
from .refined_values import InLong, InPairs, Refined, greatest
from .spring_residual import SpringResidual
from .stacked_bands import StackedFactor

Mask = NDArray[np.bool_]
# Relative error to reach; largest number of steps.
FINE, STEPS = 1e-15, 5
# If the last step changes the solution by more than this share, the matrix is singular to rounding.
LOST = 1e-6
# Safety factor on the estimated error.
SAFE = 8.0
# Bytes that a member needs in extended precision.
_MEMBER = 3000


class Residual(Protocol):
    """Residuals of some entries."""

    def refined(self, values: Array, root: Array) -> Refined:
        """Values (size, m k) of the unknowns, with their scale `root` (size, m k), as an object that can be refined."""
        ...


def refine(residual: Residual, factor: StackedFactor, entries: Index, values: Array) -> Mask:
    """Refine solutions in place until only rounding is left of their error.

    A step multiplies the error by the ratio of the last change to the one before, or to the solution at first.

    Parameters
    ----------
    residual
        Residuals of the equations.
    factor
        Factors of the matrices.
    entries
        Numbers of the matrices in the factor, (m,).
    values
        Solutions (size, m, k), which are overwritten.

    Returns
    -------
    ndarray
        Whether the steps do not converge, so that the matrix is singular to rounding, (m, k).
    """
    size, count, cases = values.shape
    root = factor.root if count == factor.count else factor.root[:, entries]
    root = root if cases == 1 else np.repeat(root, cases, axis=1)
    flat = values.reshape(size, -1)
    whole = greatest(flat / root).reshape(count, cases)
    found = residual.refined(flat, root)
    contraction = factor.rough[entries][:, None]
    error, going = whole, np.ones((count, cases), dtype=bool)
    lacking = np.zeros((count, cases), dtype=bool)
    for step in range(STEPS):
        change = found.left().reshape(size, count, cases)
        _solve(factor, entries, change, going)
        moved = found.add(change.reshape(size, -1)).reshape(count, cases)
        lacking |= np.isnan(moved)
        moved = np.where(moved > 0.0, moved / whole, 0.0)  # where nothing is loaded nothing moves
        faster = np.maximum(contraction, moved)  # at first there is no error of the step before
        contraction = np.where(np.isinf(error), faster, moved / error) if step else faster
        error = np.where(going, moved, error) if step else moved
        going &= ~((SAFE * moved * contraction <= FINE) & (moved <= LOST))
        if not any_of(going):
            break
    rounded = found.rounded.reshape(values.shape)
    values[...] = np.where(lacking, values, rounded) if any_of(lacking) else rounded
    lost: Mask = ~(error <= LOST)
    return lost


def _solve(factor: StackedFactor, entries: Index, loads: Array, going: Mask) -> None:
    """Solve in place for scaled loads (size, m, k) that are still `going`, a mask (m, k); the others become zero."""
    if all_of(going) or (factor.bands.side_by_side and going.shape[1] == 1):  # where further ones cost nothing
        factor.solve(entries, loads)
        if not all_of(going):
            np.copyto(loads, 0.0, where=~going)
        return
    whole = going.all(axis=1)
    some = loads[:, whole]
    factor.solve(entries[whole], some)
    loads[:, whole] = some
    for k in np.flatnonzero(going.any(axis=1) & ~whole).tolist():
        few = loads[:, k : k + 1, going[k]]
        factor.solve(entries[k : k + 1], few)
        loads[:, k, going[k]] = few[:, 0]
    loads[:, ~going] = 0.0


class BySprings:
    """Residuals of entries with the same deformations.

    Parameters
    ----------
    residual
        The residual by springs.
    in_pairs
        Whether to refine in double-double precision, by machine code.
    """

    def __init__(self, residual: SpringResidual, *, in_pairs: bool) -> None:
        self._residual, self._in_pairs = residual, in_pairs

    def refined(self, values: Array, root: Array) -> Refined:
        """The values (size, m k) of the unknowns, whose scale is `root` (size, m k), ready to be refined."""
        if self._in_pairs:
            return InPairs(self._residual.left_by_pairs, values, root)
        return InLong(self._residual.left, values, root)


class StaticsResidual:
    """Residuals of entries with geometries of their own, by equilibrium in extended precision.

    Parameters
    ----------
    plan, kinematics
        The plan of the frame, and its kinematics for the whole batch.
    picked
        The entries, (m k,).
    names
        Numbers of the unknowns, in the order of their values.
    units
        Loads (size, m, k) where unit right-hand-side parameters are solved for; None for the actual loads.
    """

    def __init__(
        self, plan: Plan, kinematics: FrameKinematics, picked: Picked, names: Sequence[int], units: Array | None
    ) -> None:
        self.names, self.units = list(names), units
        self.statics = PickedStatics(plan, kinematics, picked)

    def refined(self, values: Array, root: Array) -> Refined:
        """The values (size, m k) of the unknowns, whose scale is `root` (size, m k), ready to be refined."""
        return InLong(self.left, values, root)

    def left(self, values: Real) -> Array:
        """Residual, the unbalanced loads (size, m k), of values (size, m k) of the unknowns."""
        each = np.ascontiguousarray(values.T)
        if self.units is not None:
            size, count, cases = self.units.shape
            by_entry = np.moveaxis(each.reshape(count, cases, size), 1, 0)
            met = np.moveaxis(resisted(self.statics, self.names, by_entry), 0, 1)
            units = np.moveaxis(self.units, 0, -1)
            return np.ascontiguousarray(np.asarray(units - met, dtype=np.float64).reshape(-1, size).T)
        state = EquilibriumResidual(self.statics, _same, self.names, each, 1)
        return np.ascontiguousarray(state.balance.astype(np.float64).T)

    @staticmethod
    def bytes(plan: Plan) -> int:
        """Bytes that one entry needs."""
        return _MEMBER * max(1, len(plan.topology.ends))


def _same(array: Real, trailing: int) -> Real:
    return array
