"""Refinement of the entries of a batch: what solutions leave of their equations in extended precision, solved again.

Whatever is asked of a load case, how often it is refined depends on it alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..error_bounds.equilibrium import EquilibriumResidual
from ..error_bounds.kinematic_edge import Real, extended
from ..error_bounds.kinematics import FrameKinematics
from ..error_bounds.picked import PickedStatics
from ..error_bounds.resistance import resisted
from ..structure.topology import Index
from .evaluation import Picked
from .stacked_bands import StackedFactor

Mask = NDArray[np.bool_]
# Relative error that is left of a solution; steps at most.
_FINE, _STEPS = 1e-15, 5
# Share of the solution that the last step of refinement may change: else of the matrix nothing but rounding is left in
# some direction.
_LOST = 1e-6
# What the estimated error is taken to be larger.
_SAFE = 8.0
# Bytes of a member in extended precision.
_MEMBER = 3000


class Residual(Protocol):
    """Unbalanced loads of some entries."""

    def left(self, values: Real) -> Array:
        """Unbalanced load (size, m k) of the values (size, m k) of the unknowns."""
        ...


def refine(residual: Residual, factor: StackedFactor, entries: Index, values: Array) -> Mask:
    """Refine solutions until nothing but rounding is left of their error.

    A step multiplies the error by what the step before was of the solution, or of the step before it.

    Parameters
    ----------
    residual
        What they leave of their equations.
    factor
        Factors of their matrices.
    entries
        Numbers of these, (m,).
    values
        Solutions (m, k, size), which are replaced.

    Returns
    -------
    ndarray
        Whether steps do not end, so that of the matrix nothing but rounding is left in some direction, (m, k).
    """
    count, cases, size = values.shape
    root = factor.root[entries][:, None]
    found = extended(np.ascontiguousarray(values.reshape(-1, size).T))
    whole = np.abs(values / root).max(axis=-1, initial=0.0)
    contraction = np.repeat(factor.rough[entries][:, None], cases, axis=1)
    error, going = np.full((count, cases), np.inf), np.ones((count, cases), dtype=bool)
    for _ in range(_STEPS):
        change = np.ascontiguousarray(residual.left(found).T).reshape(count, cases, size)
        change *= root
        _solve(factor, entries, change, going)
        moved = np.abs(change).max(axis=-1, initial=0.0)
        sound = going.all() and np.isfinite(moved).all()
        moved = np.where(moved > 0.0, moved / whole, 0.0)  # where nothing is loaded nothing moves
        contraction = np.where(np.isinf(error), np.maximum(contraction, moved), moved / error)
        error = np.where(going, moved, error)
        change *= root
        if not sound:
            change[~(going[..., None] & np.isfinite(change))] = 0.0
        found += change.reshape(-1, size).T
        going &= ~((_SAFE * moved * contraction <= _FINE) & (moved <= _LOST))
        if not going.any():
            break
    values[:] = found.T.reshape(values.shape)
    lost: Mask = ~(error <= _LOST)
    return lost


def _solve(factor: StackedFactor, entries: Index, loads: Array, going: Mask) -> None:
    """Solve for scaled loads (m, k, size) in place, as far as these are `going` (m, k)."""
    if going.all():
        factor.solve(entries, loads)
        return
    whole = going.all(axis=1)
    some = loads[whole]
    factor.solve(entries[whole], some)
    loads[whole] = some
    for k in np.flatnonzero(going.any(axis=1) & ~whole).tolist():
        few = loads[k : k + 1, going[k]]
        factor.solve(entries[k : k + 1], few)
        loads[k, going[k]] = few[0]


class StaticsResidual:
    """Residual of entries of which each has its own geometry.

    Parameters
    ----------
    plan, kinematics
        The compiled frame, and its kinematics at the whole batch.
    picked
        The entries, (m k,).
    names
        Numbers of the unknowns, in the order of their values.
    units
        Loads (m, k, size) where units of the right-hand-side parameters are solved for; None where all that acts is.
    """

    def __init__(
        self, plan: Plan, kinematics: FrameKinematics, picked: Picked, names: Sequence[int], units: Array | None
    ) -> None:
        self.names, self.units = list(names), units
        self.statics = PickedStatics(plan, kinematics, picked)

    def left(self, values: Real) -> Array:
        """Unbalanced load (size, m k) of the values (size, m k) of the unknowns."""
        if self.units is not None:
            by_entry = values.T.reshape(self.units.shape)
            met = np.moveaxis(resisted(self.statics, self.names, np.moveaxis(by_entry, 1, 0)), 0, 1)
            return np.asarray(self.units - met, dtype=np.float64).reshape(-1, len(values)).T
        state = EquilibriumResidual(self.statics, _same, self.names, values.T, 1)
        return state.balance.astype(np.float64).T

    @staticmethod
    def bytes(plan: Plan) -> int:
        """What an entry takes."""
        return _MEMBER * max(1, len(plan.topology.ends))


def _same(array: Real, trailing: int) -> Real:
    return array
