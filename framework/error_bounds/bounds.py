"""Bounds on the error of a linear solution, component by component.

With the solution u of the computed unknowns, its residual r in extended precision, and for each requested result the
displacements z under the unit force (or relative displacement) whose work equals it, the exact result is ::

    R* = R(u) + z . r + s . K^-1 r,    s = residual of the equations of z,

so that one adjoint solve gives the error itself, up to a product of two errors. That product is bounded in the energy
norm by ``|s| |r| / least eigenvalue``, the latter from `linkframe.framework.error_bounds.compliance`. Besides, the
stiffnesses k of members are rounded; as ``z . K u`` is a sum over springs, this changes the result by no more than
``roundings * sum_i |k_i e_i(z) e_i(u)|``, in which nothing cancels. (Adjoint error estimates: Becker & Rannacher, Acta
Numerica 10 (2001) 1-102; residuals in extended precision: Rump, Acta Numerica 19 (2010) 287-449.) With an iterative
solver, one correction serves the displacements of all nodes instead: `linkframe.framework.error_bounds.energy`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..entries import WHOLE, Stretch
from ..results.linear import LinearResults
from ..solvers.evaluation import Picked
from ..solvers.sparse import SparseSolver
from ..solvers.stacked import StackedSolver
from ..solvers.stacked_bands import Bands
from ..structure.parts import Extended
from .adjoint import Adjoint
from .bands import BandedCompliance
from .compliance import Compliance, DenseCompliance
from .energy import EnergyBound, energy_of_error, greatest_change
from .equilibrium import EquilibriumResidual, Statics
from .kinematic_edge import Real
from .requested import requested
from .resolved import MOST, excited, groups, ill_conditioned, rest
from .sparse_compliance import Roughly, SparseCompliance

# Least eigenvalue below which an entry is solved in extended precision.
ILL_CONDITIONED = 1e-10
# Batch entries handled at a time, and parts of the batch kept for the next result.
CHUNK = 1024
_KEEP = 8
# Numbers in the matrices, or vectors, of the entries handled at a time; some tens of such arrays are held at once.
_NUMBERS = 2**22
# Fraction of the error that a correction by an iterative solver leaves.
_CORRECTION = 3e-4


@dataclass(frozen=True)
class BatchPart:
    """A part of the batch: its index, the solution in it, and an inverse of its stiffness.

    With an iterative solver, `corrected` is the greatest correction of any node's translations and rotations, (..., 6),
    see `greatest_change`; None if no bound by energy is used.
    """

    where: Any
    state: EquilibriumResidual
    compliance: Compliance
    corrected: Real | None = None

    @cached_property
    def energy(self) -> Real:
        """Bound on the energy norm of the solution's error, (...)."""
        return energy_of_error(self.state, self.compliance)


class Bounds:
    """Error bounds of a solution; all that does not depend on the requested result is computed once.

    Parameters
    ----------
    solution
        The solution.
    """

    def __init__(self, solution: LinearResults) -> None:
        self.solution, self.plan = solution, solution.plan
        shape = self.plan.frame.shape
        self.axis = int(np.argmax(shape)) if shape else 0
        self._kept: dict[int, list[BatchPart]] = {}

    @cached_property
    def step(self) -> int:
        """Number of indices handled at a time along the batch axis that is cut."""
        shape = self.plan.frame.shape
        dofs, unknowns = 6 * len(self.plan.topology.number), len(self.plan.unknowns)
        # A matrix of deformations by unknowns for each entry; only vectors if one sparse factor serves all entries.
        each = min(unknowns, self.plan.graph.width) if unknowns > MOST else unknowns
        numbers = dofs * (1 if isinstance(self.solution.solver, SparseSolver) else each)
        entries = min(CHUNK, max(1, _NUMBERS // max(1, numbers)))
        return max(1, entries * max(shape, default=1) // max(1, int(np.prod(shape, dtype=np.int64))))

    def refined(self, name: str, kind: str) -> tuple[Array, Array]:
        """Results after one step of iterative refinement in extended precision, and bounds on their error, (..., m).

        Parameters
        ----------
        name
            Node, joint or member.
        kind
            Kind of result, see `linkframe.framework.error_bounds.requested`.
        """
        rounded = error_bound = np.zeros(0)
        for where, estimate in self.adjoints(name, kind):
            value = estimate.refined
            if not rounded.size:
                rounded, error_bound = (np.empty((*self.solution.shape, value.shape[-1])) for _ in range(2))
            with np.errstate(all="ignore"):
                own = value.astype(np.float64)
                rounded[where], error_bound[where] = own, _upwards(np.abs(own - value) + estimate.error_bound())
        return rounded, error_bound

    def bound(self, name: str, kind: str, computed: Array, components: Sequence[int] | None = None) -> Array:
        """Bound on the error of `computed` results or some `components` of them, (..., m); inf where none is known."""
        shape = (*self.solution.shape, computed.shape[-1])
        given, out = np.broadcast_to(computed, shape), np.empty(shape)
        for where, estimate in self._estimates(name, kind, components):
            with np.errstate(all="ignore"):
                out[where] = _upwards(np.abs(given[where] - estimate.refined) + estimate.error_bound())
        return out

    def distance(self) -> Array:
        """Least singular value of scaled deformations by the unknowns that loads reach, by all if there are none."""
        if not self._values[0] and self.plan.unknowns:
            return Bounds(self.solution.reaching(self.plan.unknowns)).distance()
        out: Array = np.ones(self.solution.shape)
        with np.errstate(all="ignore"):
            for index in range(self._count):
                where, state = self._state(index)
                out[where] = self._inverted(state).distance()
        return out

    def adjoints(self, name: str, kind: str, components: Sequence[int] | None = None) -> Iterator[tuple[Any, Adjoint]]:
        """For each part of the batch, its index and the adjoints of results there, or of some components."""
        with np.errstate(all="ignore"):
            for part in self.parts():
                result = requested(part.state, name, kind).only(components)
                yield part.where, Adjoint(part.state, part.compliance, result)

    def influence(self, name: str, kind: str, index: int) -> Iterator[tuple[Any, Adjoint]]:
        """For each part of the batch, its index and the adjoint of one component of a result, itself refined once."""
        with np.errstate(all="ignore"):
            for part in self.parts():
                result = requested(part.state, name, kind).only((index,))
                yield part.where, Adjoint(part.state, part.compliance, result, 1)

    def _estimates(
        self, name: str, kind: str, components: Sequence[int] | None
    ) -> Iterator[tuple[Any, Adjoint | EnergyBound]]:
        """As `adjoints`, but displacements bounded by energy where an adjoint takes many iterations for little gain."""
        with np.errstate(all="ignore"):
            for part in self.parts():
                result = requested(part.state, name, kind).only(components)
                if kind == "displacement" and part.corrected is not None:
                    found = EnergyBound(part.state, part.compliance, result, part.energy)
                    greatest = part.corrected if components is None else part.corrected[..., list(components)]
                    if found.is_sharp(greatest):
                        yield part.where, found
                        continue
                yield part.where, Adjoint(part.state, part.compliance, result)

    def whole(self) -> EquilibriumResidual:
        """The solution of the whole batch in its equations of equilibrium."""
        return EquilibriumResidual(self.statics, WHOLE, *self._values)

    def states(self) -> Iterator[tuple[tuple[slice, ...], EquilibriumResidual]]:
        """For each part of the batch, its index and the solution in it."""
        yield from map(self._state, range(self._count))

    # -- parts of the batch -----------------------------------------------------------------------------------------

    def parts(self) -> Iterator[BatchPart]:
        """The parts of the batch; later ones replace entries of earlier ones that are ill-conditioned."""
        for index in range(self._count):
            parts = self._kept[index] if index in self._kept else list(self._part(index))
            if self._count <= _KEEP:
                self._kept[index] = parts
            yield from parts

    @property
    def _count(self) -> int:
        """Number of parts."""
        shape = self.plan.frame.shape
        return max(1, -(-shape[self.axis] // self.step)) if shape else 1

    def _part(self, index: int) -> Iterator[BatchPart]:
        where, state = self._state(index)
        compliance, before, corrected = self._inverted(state), state, None
        if compliance.near:
            state = state.corrected(compliance)
        elif compliance.iterative:
            # of a solution that is this much better adjoints need few digits, and each takes as long as it has digits
            state = state.corrected(Roughly(compliance, _CORRECTION))
            corrected = greatest_change(before, state)
        yield BatchPart(where, state, compliance, corrected)
        if len(state.unknowns) <= MOST:
            # one factor for all entries is known to more digits than an inverse of each
            few = ILL_CONDITIONED if isinstance(compliance, DenseCompliance) else 0.0
            least = np.broadcast_to(compliance.least, state.values.shape[:-1])
            yield from self._ill_conditioned(where, (least < few) | ~(least > 0.0))

    def _state(self, index: int) -> tuple[tuple[slice, ...], EquilibriumResidual]:
        """Index of a part, and the solution in it."""
        cut = self._cut(index)
        unknowns, values = self._values
        return cut.where, EquilibriumResidual(self.statics, cut, unknowns, cut(values, 1))

    def cuts(self) -> Iterator[Stretch]:
        """Callables that take each part of the batch out of arrays."""
        yield from map(self._cut, range(self._count))

    def _cut(self, index: int) -> Stretch:
        chosen = slice(index * self.step, (index + 1) * self.step)
        return Stretch(ndim=len(self.plan.frame.shape), axis=self.axis, indices=chosen)

    def _inverted(self, state: EquilibriumResidual) -> Compliance:
        if state.unknowns and isinstance(self.solution.solver, SparseSolver):
            return self._sparse
        if len(state.unknowns) > MOST:
            return self._banded(state)
        return DenseCompliance(state.double, state.double_springs, state.stiffness, state.unknowns)

    def _banded(self, state: EquilibriumResidual) -> BandedCompliance:
        """The compliance of a part of the batch, by a banded factor for each entry."""
        bands, place, mask = self._bands
        shape = self.plan.frame.shape
        sizes = [count if mask >> axis & 1 else 1 for axis, count in enumerate(shape)]
        numbers = state.change(np.arange(math.prod(sizes)).reshape(sizes), 0)
        return BandedCompliance(bands, place, numbers, Picked.of(shape, mask, numbers.reshape(-1)), state)

    @cached_property
    def _bands(self) -> tuple[Bands, NDArray[np.int64], int]:
        """Band pattern of the stiffness, the place of each unknown in it, and a bit mask of the axes of variation."""
        unknowns = self._values[0]
        solver = StackedSolver(self.plan, {}, np.isin(self.plan.graph.unknown, unknowns))
        bands = solver.bands(solver.loaded)
        return bands, bands.place[np.searchsorted(solver.unknown, unknowns)], solver.coupling.mask

    def _ill_conditioned(self, where: tuple[slice, ...], unproved: NDArray[np.bool_]) -> Iterator[BatchPart]:
        """Entries that are almost singular to double precision, solved in extended precision."""
        mask = np.zeros(self.plan.frame.shape, dtype=bool)
        mask[where] = unproved
        for index in groups(mask & ~self.solution.movable):
            at: Any = () if index is None else index
            yield BatchPart(at, *ill_conditioned(self._statics, index, self._values[0]))
        apart = self.solution.consistent_mechanisms
        for index, unknowns in () if apart is None else apart.apart(mask):
            yield BatchPart(() if index is None else index, *ill_conditioned(self._statics, index, unknowns))

    @cached_property
    def statics(self) -> Statics:
        """The frame in extended precision."""
        solver = self.solution.solver
        return solver.statics if isinstance(solver, SparseSolver) else Statics(self.plan)

    @cached_property
    def _statics(self) -> Statics:
        return Statics(self.plan, determinate=True)

    @cached_property
    def _sparse(self) -> SparseCompliance:
        solver = self.solution.solver
        assert isinstance(solver, SparseSolver)
        return SparseCompliance(solver.factor, self.plan.graph.coupled, rest(self.statics, self._values[0]))

    @cached_property
    def _values(self) -> tuple[list[int], Real]:
        """Unknowns that the loads reach, and their values (..., n)."""
        solver = self.solution.solver
        own = solver.unknown[solver.excited].tolist() if isinstance(solver, SparseSolver) else None
        unknowns = excited(self.plan) if own is None else own
        resolved, mechanisms = self.solution.resolved, self.solution.consistent_mechanisms
        found: list[Array] = []
        if not isinstance(solver, SparseSolver):
            found = [np.asarray(each) for each in solver.values([{key: 1.0} for key in unknowns])]
        # long batches are solved in double precision, and take half of the memory so
        precise = resolved is not None or mechanisms is not None or any(each.dtype == Extended for each in found)
        values = np.zeros((*self.solution.shape, len(unknowns)), dtype=Extended if precise else np.float64)
        if isinstance(solver, SparseSolver):
            values[...] = solver.unknowns[solver.excited].T.reshape(values.shape)
        for k, value in enumerate(found):
            values[..., k] = value
        if resolved is not None:
            values[resolved.mask] = resolved.values([{key: 1.0} for key in unknowns])
        if mechanisms is not None:
            values[mechanisms.mask] = mechanisms.values([{key: 1.0} for key in unknowns])
        return unknowns, values


class BoundedResults(LinearResults, Protocol):
    """A linear solution with estimates of its error."""

    @property
    def bounds(self) -> Bounds:
        """Estimates of the error of results."""
        ...

    def reaching(self, unknowns: Iterable[int]) -> BoundedResults:
        """The same solution, with the unknowns coupled with the given ones solved for as well."""
        ...

    def cut(self) -> BoundedResults:
        """The same solution with members cut into their segments and hinges at released ends; itself if they are."""
        ...


def _upwards(bound: Real) -> Array:
    """A bound rounded upwards to double precision; inf for NaN."""
    rounded = np.where(np.isnan(bound), np.inf, bound).astype(np.float64)
    out: Array = np.where(rounded < bound, np.nextafter(rounded, np.inf), rounded)
    return out
