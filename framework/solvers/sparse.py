"""The solver for one large frame of constant stiffness: a single matrix, factorised or iterated as the plan chose."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, any_of, rotated
from ..batched.plan import Plan
from ..clock import timed
from ..error_bounds.equilibrium import Statics
from ..lazily import cached_property
from ..structure.assembly import component_loads, mass_loads, member_loads
from ..structure.matrices import Matrices
from ..structure.parts import Row, Value, combine
from ..structure.topology import Index
from .factor import Factor
from .freedom import Freedom, freedom
from .iterative import Iterative
from .load_cases import by_units
from .method import ITERATIVE
from .patterns import labelled
from .refinement import REFINED, refined, refined_by_springs
from .spring_residual import SpringResidual, by_springs
from .stiffness import SparseStiffness

# Up to this many unknowns large pivots also exclude a loss of digits: the softest frame is a chain.
_LONG = 2**10


class SparseSolver:
    """Solver for one matrix and any number of load cases.

    Parameters
    ----------
    plan
        The plan of the frame, whose stiffness is constant over the batch.
    matrix
        Its matrix with the factors known so far; a new one where None.
    """

    def __init__(self, plan: Plan, matrix: SparseStiffness | None = None) -> None:
        self.plan = plan
        self.matrix = SparseStiffness(plan.unloaded, plan.method.name) if matrix is None else matrix
        self.unknown: Index = self.matrix.unknown
        # Mask of the unknowns that count as loaded, (n,); None for those that loads reach.
        self._reached: NDArray[np.bool_] | None = None
        self._statics: list[Statics] = []  # shared by all parts, filled when first needed

    @property
    def matrices(self) -> Matrices:
        """Stiffness and mass in joint-relative coordinates."""
        return self.matrix.matrices

    @property
    def statics(self) -> Statics:
        """The equilibrium equations in extended precision, shared by all parts of the frame."""
        if not self._statics:
            self._statics.append(Statics(self.plan))
        return self._statics[0]

    @property
    def reason(self) -> str:
        """Method by which the matrix is solved, and why, in words."""
        factors = list(self.matrix.factors.values())
        gave_up = any(isinstance(factor, Iterative) and factor.instead is not None for factor in factors)
        return self.plan.method.reason + ("; it did not converge, so a factor served instead" if gave_up else "")

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Values of rows over the unknowns, each of a shape that broadcasts to the batch."""
        if self.units is not None:
            # Rows are evaluated for the unit loads, and then combined for all load cases.
            solver, sizes = self.units
            return [combine(zip(np.ravel(each).tolist(), sizes, strict=True)) for each in solver.values(rows)]
        shape = self.plan.frame.shape
        # most rows are a single unknown
        alone = [len(row) == 1 and next(iter(row)) >= 0 for row in rows]
        each = [pair for row, own in zip(rows, alone, strict=True) if own for pair in row.items()]
        keys, factors = np.array([key for key, _ in each], np.int64), np.array([float(factor) for _, factor in each])
        found = factors[:, None] * self.unknowns[self.unknown.searchsorted(keys)]
        numbers = iter(found[:, 0].tolist() if self._cases == 1 else found.reshape(len(each), *shape))
        return [
            next(numbers) if own else self.plan.grid.value(self._value(row).reshape(shape))
            for row, own in zip(rows, alone, strict=True)
        ]

    def _value(self, row: Row) -> Array:
        """Value of a row, (load cases,)."""
        keys = np.array(list(row), dtype=np.int64)
        index = np.where(keys >= 0, np.searchsorted(self.unknown, keys), len(self.unknown) - 1 - keys)
        found: Array = np.array([float(factor) for factor in row.values()]) @ self._numbers[index]
        return found

    def nodal(self, unknowns: Array) -> Array:
        """Displacements of all nodes in their own axes, (load cases, nodes, 6), from the unknowns (n, load cases)."""
        found = self.matrices.substitution @ unknowns + self._shifts()
        return np.moveaxis(found.reshape(-1, 6, self._cases), -1, 0)

    def reaching(self, unknowns: Iterable[int]) -> SparseSolver:
        """The solver in which the components of these unknowns count as loaded, too; itself where they do already."""
        asked = np.searchsorted(self.unknown, np.array(list(unknowns), dtype=np.int64))
        return self._with(self.excited | labelled(self.matrix.label, self.matrix.label[asked]))

    def part(self, node: int) -> SparseSolver:
        """The solver in which only the part of the frame that contains a node counts as loaded."""
        connected_components = self.plan.connected_components
        return self._with(self.excited & (connected_components[self.unknown // 6] == connected_components[node]))

    @cached_property
    def parts(self) -> int:
        """Number of loaded parts of the frame; parts that share only supports are not connected."""
        if self.plan.graph.links.count_of_components < 2:
            return int(any_of(self.excited))
        return len(np.unique(self.plan.connected_components[self.unknown[self.excited] // 6]))

    def _with(self, excited: NDArray[np.bool_]) -> SparseSolver:
        """The solver with another mask of loaded unknowns, (n,); itself where it is the same."""
        if np.array_equal(excited, self.excited):
            return self
        clone = SparseSolver(self.plan, self.matrix)
        clone._reached, clone._statics = excited, self._statics
        if self.units is None:
            clone.units, clone.load = None, self.load
        else:
            solver, numbers = self.units
            clone.units = solver._with(excited), numbers
        return clone

    def singular(self, *, excited: bool) -> NDArray[np.bool_]:
        """Whether the loaded (`excited`) components, or the others, are singular, (...) of the batch shape."""
        return np.full(self.plan.frame.shape, self._singular(excited=excited))

    def _singular(self, *, excited: bool) -> bool:
        where = self.excited if excited else ~self.excited
        if not any_of(where) or self._unsupported(where):
            return any_of(where)
        if excited:
            regular = self._solver._surely_regular is not None
        else:
            regular = self.matrix.direct_factor(where, self.plan.times).surely_definite
        return not regular and self._factor(where).singular

    @cached_property
    def surely_regular(self) -> bool:
        """Whether pivots show that the loaded components are regular, so that no further test is needed."""
        where = self.excited
        if self._unsupported(where) or not any_of(where):
            return False
        return self._solver._surely_regular is not None

    @property
    def _solver(self) -> SparseSolver:
        """The solver for the loads, or the one for unit loads where there is one."""
        return self if self.units is None else self.units[0]

    def _unsupported(self, where: NDArray[np.bool_]) -> bool:
        """Whether the unknowns in the mask `where` (n,) include some of an unsupported part."""
        motions = self.matrix.unsupported_motions
        return motions.size > 0 and any_of(motions[where])

    def unsupported_motions(self, where: NDArray[np.bool_]) -> Array:
        """Rigid motions (n, m) of the unsupported parts among the n unknowns in the mask `where`."""
        motions = self.matrix.unsupported_motions
        if not motions.size:
            return np.zeros((np.count_nonzero(where), 0))
        found: Array = motions[where][:, motions[where].any(axis=0)]
        return found

    @cached_property
    def unknowns(self) -> Array:
        """Values of the unknowns, (n, load cases)."""
        if self.units is not None:
            found: Array = self.units[0].unknowns @ self.sizes
            return found
        out = np.zeros_like(self.load)
        where = self.excited
        if any_of(where) and not self._unsupported(where):
            known = self._surely_regular
            out[where] = self._solved(where) if known is None else known
        return out

    @cached_property
    def _surely_regular(self) -> Array | None:
        """Values of the loaded unknowns if pivots show that their matrix is regular; else None.

        If it is singular in double precision nevertheless, as for long chains, forces are summed in extended precision;
        the values have enough digits if the steps of refinement converge.
        """
        where = self.excited
        factor = self.matrix.direct_factor(where, self.plan.times)
        if not factor.surely_definite:
            return None
        soft = len(factor.root) > _LONG and factor.singular
        residual = self._fine_residual if soft else self.spring_residual
        if residual is None:
            return None
        with timed(self.plan.times, "solution"):
            found = factor.solve(self.load[where])
        with timed(self.plan.times, "refinement"):
            better, ended = refined_by_springs(residual, found, factor.solve)
        return better if ended else None

    @property
    def _fine_residual(self) -> SpringResidual | None:
        """`spring_residual` with forces summed in extended precision, however large the frame."""
        deformations = self.matrix.telling_deformations(self.excited)
        if deformations is None or self.matrix.unloaded.graph.transformation.imposed:
            return None
        found = by_springs(self.plan, deformations, self.load[self.excited])
        return None if found is None else found.finely()

    def _solved(self, where: NDArray[np.bool_]) -> Array:
        """Values (n, load cases) of the n unknowns in the mask `where`."""
        factor = self._factor(where)
        with timed(self.plan.times, "solution"):
            values = factor.solve(self.load[where])
        if self.plan.method.name == ITERATIVE or factor.precise or where.sum() > REFINED or factor.singular:
            return values
        with timed(self.plan.times, "refinement"):
            if self.spring_residual is not None:
                return refined_by_springs(self.spring_residual, values, factor.solve)[0]
            return refined(self.statics, self.unknown[where], values, factor.solve)

    @cached_property
    def spring_residual(self) -> SpringResidual | None:
        """Residual of the loaded unknowns by springs; None where it needs the equilibrium of whole members."""
        deformations = self.matrix.deformations_of(self.excited)
        if deformations is None:
            return None
        return by_springs(self.plan, deformations, self.load[self.excited])

    # -- matrices ---------------------------------------------------------------------------------------------------

    @cached_property
    def stiffness(self) -> scipy.sparse.csr_matrix:
        """``T^T K T`` of the members, plus the joint springs, (n, n)."""
        with timed(self.plan.times, "assembly"):
            return self.matrices.stiffness

    @property
    def mass(self) -> scipy.sparse.csr_matrix:
        """``T^T M T`` of members and point masses, (n, n)."""
        return self.matrices.mass

    def motions(self) -> Array:
        """Free motions as values of the unknowns, (n, motions); only a few are searched for.

        If parts are unsupported, only their rigid motions are returned, which need no search.
        """
        if self.matrix.unsupported_motions.size:
            return self.matrix.unsupported_motions
        parts = [(self.excited, self.freedom), (~self.excited, self._freedom(~self.excited))]
        out = []
        for where, free in parts:
            motions = np.zeros((len(where), free.motions.shape[1]))
            motions[where] = free.motions
            out.append(motions)
        return np.hstack(out)

    @cached_property
    def freedom(self) -> Freedom:
        """Free motions of the loaded components."""
        return self._freedom(self.excited)

    # -- loads ------------------------------------------------------------------------------------------------------

    @cached_property
    def load(self) -> Array:
        """Load on the unknowns, (n, load cases)."""
        with timed(self.plan.times, "assembly"):
            nodal = self._nodal_load()
            if self.plan.tree.rows:
                shifts = self._shifts()
                if any_of(shifts):
                    nodal -= self.matrices.members @ shifts
            out: Array = self.matrices.gathered(nodal)
            springs = self.plan.tree.springs
            if springs:
                rows = [spring.row for spring in springs]
                stiffness = np.array(self.matrices.springs)
                out -= self.matrices.spread(rows).T @ (stiffness[:, None] * self._known(rows))
            return out

    @cached_property
    def units(self) -> tuple[SparseSolver, list[Value]] | None:
        """Solver for unit loads, and the sizes of the loads; None if that is no less work."""
        found = by_units(self.plan)
        if found is None:
            return None
        frame, grid, rhs_parameters, numbers = found
        solver = SparseSolver(self.plan.under(frame, grid, rhs_parameters), self.matrix)
        solver._reached, solver.units = self._reached, None  # its load cases are the units themselves
        return solver, numbers

    @property
    def sizes(self) -> Array:
        """The sizes of the varying loads, (units, load cases)."""
        assert self.units is not None
        return np.array([np.broadcast_to(number, self.plan.frame.shape).reshape(-1) for number in self.units[1]])

    def _nodal_load(self) -> Array:
        topology = self.plan.topology
        out: Array = np.zeros((self._size, self._cases))
        for node, k, value in component_loads(topology):
            axes = topology.axes(node)
            if axes is None:
                plain = value.size in (1, self._cases)
                out[6 * node + k] += value.reshape(-1) if plain else self._flat(value[None, ..., None])[0, :, 0]
            else:
                local = axes[..., k % 3, :] * value[..., None]
                half = 6 * node + k - k % 3
                out[half : half + 3] += self._flat(local[None])[0].T
        for node, vector in mass_loads(topology):
            axes = topology.axes(node)
            local = vector if axes is None else rotated(np.swapaxes(axes, -1, -2), vector)
            out[6 * node : 6 * node + 6] += self._flat(local[None])[0].T
        for group, positions, local in member_loads(topology):
            nodal = self._flat(group.nodal(positions, local))
            np.add.at(out, group.dofs[positions], np.swapaxes(nodal, -1, -2))
        return out

    def _shifts(self) -> Array:
        """The vectors g of ``u = T q + g``, (DOFs, load cases)."""
        out = np.zeros((self._size, self._cases))
        for node, six in self.plan.tree.rows.items():
            if any(six):
                out[6 * node : 6 * node + 6] = self._known(six)
        return out

    # -- inside -----------------------------------------------------------------------------------------------------

    @property
    def _size(self) -> int:
        return 6 * len(self.plan.topology.number)

    @cached_property
    def _cases(self) -> int:
        return math.prod(self.plan.frame.shape)

    def _freedom(self, where: NDArray[np.bool_]) -> Freedom:
        def among(kept: NDArray[np.bool_]) -> NDArray[np.bool_]:
            out = where.copy()
            out[where] = kept
            return out

        return freedom(
            self.unsupported_motions(where),
            lambda kept: self._factor(among(kept)),
            lambda kept: self.matrix.direct(among(kept)),
        )

    @property
    def factor(self) -> Factor:
        """Factor of the stiffness of the loaded unknowns."""
        return self._factor(self.excited)

    @cached_property
    def excited(self) -> NDArray[np.bool_]:
        """Mask of the unknowns in components that loads reach, (n,)."""
        if self._reached is not None:
            return self._reached
        label = self.matrix.label
        load = self.load if self.units is None else self.units[0].load
        return labelled(label, label[load.any(axis=1)])

    def _factor(self, where: NDArray[np.bool_]) -> Factor:
        return self.matrix.factor(where, self.plan.times)

    def direct(self, matrix: scipy.sparse.csr_matrix) -> Factor:
        """Factor of another matrix (n, n) of the same pattern."""
        return self.matrix.direct(np.ones(len(self.unknown), dtype=bool))(matrix)

    @cached_property
    def _numbers(self) -> Array:
        """Unknowns and right-hand-side parameters, (n + parameters, load cases)."""
        shape = self.plan.frame.shape
        rhs_parameters = [np.broadcast_to(value, shape).reshape(-1) for value in self.plan.rhs_parameters.values]
        return np.concatenate([self.unknowns, np.stack(rhs_parameters)])

    def _known(self, rows: Sequence[Row]) -> Array:
        """The part of rows in right-hand-side parameters, (rows, load cases)."""
        out = np.zeros((len(rows), self._cases))
        values = self.plan.rhs_parameters.values
        for r, row in enumerate(rows):
            for k, factor in row.items():
                if k < 0:
                    out[r] += np.broadcast_to(factor * values[-1 - k], self.plan.frame.shape).reshape(-1)
        return out

    def _flat(self, stack: Array) -> Array:
        """An array (n, ..., m) with its batch axes flattened, (n, load cases, m)."""
        n, m = stack.shape[0], stack.shape[-1]
        return np.broadcast_to(stack, (n, *self.plan.frame.shape, m)).reshape(n, self._cases, m)
