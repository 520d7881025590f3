"""Entries whose stiffness is singular to double precision though the frame is not, solved in extended precision.

A matrix whose least eigenvalue is of the size of rounding may belong to a frame that is not singular: the stiffness
``S = A^T A`` with ``A = sqrt(k) B D`` squares the condition number of A. So the rank is found from the singular values
of A, and entries of full rank are solved with S in extended precision, if that suffices.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape, aligned
from ..batched.plan import Plan
from ..entries import WHOLE, Entries, Selected
from ..solvers.refinement import refined_by_springs
from ..solvers.sparse import SparseSolver
from ..solvers.spring_residual import SpringResidual
from ..solvers.stacked import StackedSolver
from ..structure.parts import Extended, Row
from ..structure.topology import Index
from .compliance import DenseCompliance
from .equilibrium import EquilibriumResidual, Statics
from .kinematic_edge import Real, extended
from .resistance import resisted
from .sparse_compliance import SparseCompliance, softest

# Indices of entries by batch axis; None for the only entry of a batch without axes.
At = tuple[NDArray[np.int64], ...] | None
# Number of unknowns up to which singular values are affordable.
MOST = 400
# Least singular value of A at which S can be solved in extended precision.
_LEAST = 4.0 * float(np.sqrt(np.finfo(Extended).eps))
# Greatest ratio of a spring's stiffnesses at two entries at which the free motions of one hold for the other.
_ALIKE = 1e6
# Entries handled at a time.
_CHUNK = 256
# Steps of refinement: each leaves a tenth of the error or less if a matrix is not singular to its precision.
_STEPS = 12
# Steps of inverse iteration to the softest motion of a matrix that is singular to rounding; the first almost finds it.
_SOFT = 3
# Relative residual below which these refinement steps have converged for a load in the shape of the softest motion.
_BALANCED = 1e-3


class Solved(Protocol):
    """Entries that are singular to double precision only, with their solution.

    Attributes
    ----------
    mask
        Mask of the entries that are solved, (...).
    """

    mask: NDArray[np.bool_]

    def values(self, rows: Sequence[Row]) -> Real:
        """Values of `rows` over the unknowns and the right-hand-side parameters at the solved entries, (m, rows)."""


class Resolved:
    """Entries of a batch that are singular to double precision, and are not.

    Parameters
    ----------
    plan
        The compiled frame.
    suspects
        Entries to look at, (...) of the batch shape.
    unknowns
        Numbers of the unknowns that count as loaded.

    Attributes
    ----------
    mask
        Those that are solved, (...).
    """

    def __init__(self, plan: Plan, suspects: NDArray[np.bool_], unknowns: Sequence[int]) -> None:
        self.plan, self.unknowns = plan, list(unknowns)
        self.mask = np.zeros(plan.frame.shape, dtype=bool)
        entries = Selected.around(suspects)
        self._values = extended(np.zeros((*entries.shape, len(self.unknowns))))
        statics = Statics(plan, determinate=True, entries=entries)
        own, found = entries.of_all(suspects), np.zeros(entries.shape, dtype=bool)
        with np.errstate(all="ignore"):
            for index, first, which in grouped(own, matrix_shape(statics)):
                self._solve(statics, index, first, which, found)
        self.mask[entries.where], self._values = found, self._values[found]

    def values(self, rows: Sequence[Row]) -> Real:
        """Values of `rows` over the unknowns and the right-hand-side parameters at the solved entries, (m, rows)."""
        return combined(self.plan, self.unknowns, self._values, rows, self.mask)

    def _solve(self, statics: Statics, index: At, first: At, which: Index, found: NDArray[np.bool_]) -> None:
        start = ill_conditioned_state(statics, first, self.unknowns)
        rough = DenseCompliance(start.double, start.double_springs, start.stiffness, self.unknowns)
        # One for all entries where the stiffness does not vary over them.
        near = np.broadcast_to(rough.distance() > _LEAST, (1 if first is None else len(first[0]),))[which]
        if not near.any():
            return
        kept = index if index is None else tuple(each[near] for each in index)
        state, compliance = ill_conditioned(statics, kept, self.unknowns)
        where: Any = () if kept is None else kept
        found[where] = compliance.least > 0.0
        self._values[where] = state.absolute()


class ResolvedByBands:
    """Entries of a batch of frames with many unknowns, solved once more by banded factors in tension form.

    Parameters
    ----------
    plan
        The compiled frame.
    suspects
        Entries to look at, (...) of the batch shape.

    Attributes
    ----------
    mask
        Those that are solved, (...).
    """

    def __init__(self, plan: Plan, suspects: NDArray[np.bool_]) -> None:
        self.plan, self._solver = plan, banded(plan)
        self.mask = np.asarray(suspects & ~self._solver.singular(excited=True))

    def values(self, rows: Sequence[Row]) -> Real:
        """Values of `rows` over the unknowns and the right-hand-side parameters at the solved entries, (m, rows)."""
        out = extended(np.zeros((int(self.mask.sum()), len(rows))))
        shape = self.mask.shape or (1,)
        for number, value in enumerate(self._solver.values(rows)):
            out[:, number] = np.broadcast_to(value, shape)[self.mask.reshape(shape)]
        return out


def banded(plan: Plan) -> StackedSolver:
    """A banded solver for the batch, whichever solver is used otherwise."""
    return StackedSolver(plan, {}, np.isin(plan.graph.unknown, excited(plan)))


class ResolvedLarge:
    """One large frame whose matrix is singular to double precision, solved by steps of refinement.

    For a load in the shape of the softest motion they converge only if the frame is not singular.

    Parameters
    ----------
    plan
        The compiled frame.
    solver
        Its solver, with the factor.

    Attributes
    ----------
    mask
        Whether they converge, (...).
    """

    def __init__(self, plan: Plan, solver: SparseSolver) -> None:
        self.plan = plan
        self.unknowns = solver.unknown[solver.excited].tolist()
        units, sizes = (solver, None) if solver.units is None else (solver.units[0], solver.sizes)
        with np.errstate(all="ignore"):
            residual = units.spring_residual
            regular, self._values = (
                self._by_statics(solver) if residual is None else self._by_springs(units, residual.finely(), sizes)
            )
        self.mask = np.full(plan.frame.shape, regular)

    def _by_springs(self, solver: SparseSolver, residual: SpringResidual, sizes: Array | None) -> tuple[bool, Real]:
        """Whether the frame is regular, and its unknowns (..., n), if the deformations are the same at all entries.

        If `solver` is that of unit loads, `sizes` (units, load cases) are the amounts of these in the load cases.
        """
        factor = solver.factor
        probe = softest(factor, _SOFT)[0] / factor.root
        left = residual.under(probe[:, None])
        found, size = extended(np.zeros((len(probe), 1))), np.inf
        for _ in range(_STEPS):
            found = found + factor.solve(left.left(found))
            size = float(np.linalg.norm(left.left(found)[:, 0] * factor.root))
            if size < _BALANCED:
                break
        regular, values = bool(size < _BALANCED), solver.unknowns[solver.excited]
        if regular:
            values, _ = refined_by_springs(residual, values, factor.solve)
        values = values if sizes is None else values @ sizes
        return regular, extended(values.T.reshape(*self.plan.frame.shape, len(probe)))

    def _by_statics(self, solver: SparseSolver) -> tuple[bool, Real]:
        """The same for any frame."""
        state = rest(Statics(self.plan), self.unknowns)
        compliance = SparseCompliance(solver.factor, self.plan.graph.coupled, state)
        regular = _regular(state, compliance)
        for _ in range(_STEPS if regular else 0):
            state = state.corrected(compliance)
        return regular, state.values

    def values(self, rows: Sequence[Row]) -> Real:
        """Values of `rows` over the unknowns and the right-hand-side parameters, (m, rows)."""
        return combined(self.plan, self.unknowns, self._values[self.mask], rows, self.mask)

    def whole(self, solver: SparseSolver) -> Array:
        """All unknowns of the solver, (n, load cases); those that the loads reach have their resolved values."""
        out = solver.unknowns.copy()
        out[solver.excited] = self._values.reshape(-1, len(self.unknowns)).T
        return out


def rest(statics: Statics, unknowns: Sequence[int]) -> EquilibriumResidual:
    """The state of the whole batch with all unknowns zero."""
    none = extended(np.zeros((*statics.plan.frame.shape, len(unknowns))))
    return EquilibriumResidual(statics, WHOLE, unknowns, none)


def _regular(state: EquilibriumResidual, compliance: SparseCompliance) -> bool:
    """Whether refinement converges for a load in the shape of the matrix's softest motion."""
    probe = compliance.softest / compliance.root
    found = extended(np.zeros(state.values.shape))
    left = extended(np.broadcast_to(probe, found.shape))
    for _ in range(_STEPS):
        found = found + compliance.solve(left)
        left = probe - resisted(state, state.unknowns, found)
    size = np.sqrt(np.max(np.sum((left * compliance.root) ** 2, axis=-1)))
    return bool(size < _BALANCED)


def combined(plan: Plan, unknowns: Sequence[int], values: Real, rows: Sequence[Row], mask: NDArray[np.bool_]) -> Real:
    """Values of `rows` over the unknowns (m, n) and the right-hand-side parameters at the m entries in a mask,
    (m, rows)."""
    change, ndim = Entries(np.nonzero(mask) if mask.ndim else ()), mask.ndim
    at = {k: number for number, k in enumerate(unknowns)}
    out = extended(np.zeros((len(values), len(rows))))
    for number, row in enumerate(rows):
        for k, factor in row.items():
            own = change(aligned(np.asarray(factor), ndim), 0)
            if k < 0:
                given = change(aligned(np.asarray(plan.rhs_parameters.values[-1 - k]), ndim), 0)
                out[:, number] += own * extended(given)
            elif k in at:
                out[:, number] += own * values[:, at[k]]
    return out


def ill_conditioned_state(
    statics: Statics, index: tuple[NDArray[np.int64], ...] | None, unknowns: Sequence[int]
) -> EquilibriumResidual:
    """The state of some entries (m,) of a batch with all unknowns zero."""
    shape = statics.plan.frame.shape
    count = () if index is None else (len(index[0]),)
    start = extended(np.zeros((*count, len(unknowns))))
    return EquilibriumResidual(statics, Entries(index), unknowns, start, len(shape) if index is None else 1)


def ill_conditioned(
    statics: Statics, index: tuple[NDArray[np.int64], ...] | None, unknowns: Sequence[int]
) -> tuple[EquilibriumResidual, DenseCompliance]:
    """The solved state of some entries of a batch, and the inverse of their stiffness, in extended precision."""
    state = ill_conditioned_state(statics, index, unknowns)
    compliance = DenseCompliance(state.kinematics, state.springs, state.stiffness, unknowns, Extended)
    for _ in range(_STEPS):
        state = state.corrected(compliance)
    return state, compliance


def excited(plan: Plan) -> list[int]:
    """Unknowns that the loads reach."""
    return [k for k in plan.unknowns if plan.component[k] in plan.excited]


def kinematically_stable(plan: Plan, suspects: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mask of the `suspects` without free motion of the unknowns that no load reaches, (...) of the batch shape.

    Judged by the singular values of the deformations, which resolve twice as many digits as the stiffness.
    """
    unknowns = sorted(set(plan.unknowns) - set(excited(plan)))
    out = np.zeros(plan.frame.shape, dtype=bool)
    if not suspects.any():
        return out
    if len(unknowns) > MOST:
        return suspects & ~banded(plan).singular(excited=False)
    entries = Selected.around(suspects)
    statics = Statics(plan, determinate=True, entries=entries)
    with np.errstate(all="ignore"):
        for index, first, which in grouped(entries.of_all(suspects), matrix_shape(statics)):
            state = ill_conditioned_state(statics, first, unknowns)
            found = DenseCompliance(state.double, state.double_springs, state.stiffness, unknowns)
            stable = np.broadcast_to(found.distance() > _LEAST, (1 if first is None else len(first[0]),))[which]
            out[... if index is None else entries.among_all(index)] = stable if out.ndim else stable[0]
    return out


def geometry_shape(statics: Statics) -> Shape:
    """Batch shape over which the geometry varies, with all axes of the batch."""
    kinematics = statics.kinematics
    dependents = [np.shape(v) for row, by in kinematics.dependents.values() for v in (*row.values(), *by.values())]
    idle = [np.shape(where) for where in kinematics.idle.values()]
    members = [each.rows.shape[:-3] for each in statics.springs]
    whole = (1,) * len(statics.plan.frame.shape)
    return np.broadcast_shapes(whole, kinematics.shape, *dependents, *idle, *members)


def matrix_shape(statics: Statics) -> Shape:
    """Batch shape over which geometry or stiffness varies, with all axes of the batch."""
    members = [each.stiffness.shape[:-2] for each in statics.springs]
    return np.broadcast_shapes(geometry_shape(statics), *members, *(each.shape[:-1] for each in statics.stiffness))


def grouped(mask: NDArray[np.bool_], shape: Shape, most: int = _CHUNK) -> Iterator[tuple[At, At, Index]]:
    """Entries in a mask, at most `most` at a time, and which of them are distinct within a batch of `shape`.

    Yields their indices; the indices of the distinct ones (m,); and for each entry the number of its distinct one.
    Indices are None for the only entry of a batch without axes.
    """
    if not mask.ndim:
        if mask:
            yield None, None, np.zeros(1, dtype=np.int64)
        return
    index = np.nonzero(mask)
    order = np.argsort(_numbered(index, shape), kind="stable")
    for k in range(0, len(order), most):
        part = tuple(each[order[k : k + most]] for each in index)
        yield part, *distinct(part, shape)


def distinct(index: tuple[Index, ...], shape: Shape) -> tuple[tuple[Index, ...], Index]:
    """Indices of the entries that are distinct within a batch of `shape`, and for each entry the number of its distinct
    one."""
    if not index:
        return (), np.zeros(1, dtype=np.int64)
    _, first, which = np.unique(_numbered(index, shape), return_index=True, return_inverse=True)
    return tuple(each[first] for each in index), which


def _numbered(index: tuple[Index, ...], shape: Shape) -> Index:
    """Numbers of entries within a batch of `shape`, (m,); entries of the same number do not differ there."""
    own = tuple(each if size > 1 else np.zeros_like(each) for each, size in zip(index, shape, strict=True))
    return np.ravel_multi_index(own, shape)


def alike(statics: Statics) -> bool:
    """Whether no spring is far stiffer at one entry of the batch than at another, or zero at some only."""
    for k, last in [*((each.stiffness, 2) for each in statics.springs), *((each, 1) for each in statics.stiffness)]:
        if k.size:
            batch = tuple(range(k.ndim - last))
            least, most = k.min(axis=batch), k.max(axis=batch)
            if not ((most <= _ALIKE * least) & np.isfinite(most)).all():
                return False
    return True


def groups(mask: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], ...] | None]:
    """Indices of the entries in a mask, some at a time; None for the only entry of a batch without axes."""
    if not mask.ndim:
        return [None] if mask else []
    index = np.nonzero(mask)
    return [tuple(each[k : k + _CHUNK] for each in index) for k in range(0, len(index[0]), _CHUNK)]
