"""Refinement of the entries of a batch: what solutions leave of their equations in extended precision, solved again.

Whatever is asked of a load case, how often it is refined depends on it alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

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
from .spring_residual import Long
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

    def begun(self, values: Array) -> Refined:
        """The values (size, m k) of the unknowns, ready to be refined."""
        ...

    def left(self, values: Any) -> Array:
        """Unbalanced load (size, m k) of the values (size, m k) of the unknowns."""
        ...


class Refined(Protocol):
    """Numbers with more digits than those of double precision."""

    @property
    def rounded(self) -> Array:
        """In double precision."""
        ...

    def plus(self, change: Array) -> Refined:
        """The sum with other numbers."""
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
        Solutions (size, m, k), which are replaced.

    Returns
    -------
    ndarray
        Whether steps do not end, so that of the matrix nothing but rounding is left in some direction, (m, k).
    """
    size, count, cases = values.shape
    root = factor.root[:, entries, None] if count < factor.root.shape[1] else factor.root[..., None]
    found = residual.begun(values.reshape(size, -1))
    whole = _greatest(values / root)
    contraction = np.repeat(factor.rough[entries][:, None], cases, axis=1)
    error, going = np.full((count, cases), np.inf), np.ones((count, cases), dtype=bool)
    for _ in range(_STEPS):
        change = residual.left(found).reshape(size, count, cases)
        change *= root
        _solve(factor, entries, change, going)
        moved = _greatest(change)
        sound = going.all() and np.isfinite(moved).all()
        moved = np.where(moved > 0.0, moved / whole, 0.0)  # where nothing is loaded nothing moves
        contraction = np.where(np.isinf(error), np.maximum(contraction, moved), moved / error)
        error = np.where(going, moved, error)
        change *= root
        if not sound:
            change[~(going & np.isfinite(change))] = 0.0
        found = found.plus(change.reshape(size, -1))
        going &= ~((_SAFE * moved * contraction <= _FINE) & (moved <= _LOST))
        if not going.any():
            break
    values[...] = found.rounded.reshape(values.shape)
    lost: Mask = ~(error <= _LOST)
    return lost


def _greatest(values: Array) -> Array:
    """Greatest size (m, k) of values (size, m, k)."""
    found: Array = np.maximum(values.max(axis=0, initial=0.0), -values.min(axis=0, initial=0.0))
    return found


def _solve(factor: StackedFactor, entries: Index, loads: Array, going: Mask) -> None:
    """Solve for scaled loads (size, m, k) in place, as far as these are `going` (m, k)."""
    if going.all():
        factor.solve(entries, loads)
        return
    whole = going.all(axis=1)
    some = loads[:, whole]
    factor.solve(entries[whole], some)
    loads[:, whole] = some
    for k in np.flatnonzero(going.any(axis=1) & ~whole).tolist():
        few = loads[:, k : k + 1, going[k]]
        factor.solve(entries[k : k + 1], few)
        loads[:, k, going[k]] = few[:, 0]


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
        Loads (size, m, k) where units of the right-hand-side parameters are solved for; None where all that acts is.
    """

    def __init__(
        self, plan: Plan, kinematics: FrameKinematics, picked: Picked, names: Sequence[int], units: Array | None
    ) -> None:
        self.names, self.units = list(names), units
        self.statics = PickedStatics(plan, kinematics, picked)

    def begun(self, values: Array) -> Long:
        """The values (size, m k) of the unknowns in extended precision."""
        return Long(extended(values))

    def left(self, values: Long) -> Array:
        """Unbalanced load (size, m k) of the values (size, m k) of the unknowns."""
        each = np.ascontiguousarray(values.numbers.T)
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
        """What an entry takes."""
        return _MEMBER * max(1, len(plan.topology.ends))


def _same(array: Real, trailing: int) -> Real:
    return array
