"""The solver for batches of middle-sized frames: one banded matrix for each entry, all of the same pattern.

Pattern and order of elimination are found once for the batch; many matrices are assembled at a time. Where loads vary
over more axes than the stiffness, unit right-hand-side parameters are solved for, if these are fewer than the entries
that share a factor. Each load case is refined until only rounding is left.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from typing import TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, any_of
from ..batched.plan import Plan
from ..clock import timed
from ..error_bounds.kinematics import FrameKinematics
from ..lazily import cached_property
from ..structure.parts import Row, Value, combine, product
from ..structure.topology import Index
from . import stacked_pass
from .band_factors import TOGETHER, AllAtOnce, Room, in_lanes, in_one_pass, in_pairs
from .deformation_table import Deformations
from .evaluation import Picked
from .rounding import zero_eigenvalue
from .spring_residual import SpringResidual, are_described
from .stacked_bands import Bands, StackedFactor
from .stacked_loads import StackedLoads
from .stacked_pass import SpringBands
from .stacked_refinement import BySprings, Residual, StaticsResidual, refine

Mask = NDArray[np.bool_]
_Kind = TypeVar("_Kind", np.bool_, np.float64)
# Bytes that are assembled and factorised (_ROOM) or refined (_REFINED) at a time; results (_KEEP), and factors or small
# results (_HOLD), of up to so many bytes are kept.
_ROOM, _REFINED, _KEEP, _HOLD = 2**23, 2**26, 2**28, 2**26
# At a time, however, so many bytes for each kind of member at least: each takes calls of its own, which would be made
# the more often the more kinds there are. The links of a linkage are a kind each.
_ROOM_OF_KIND, _REFINED_OF_KIND = 2**17, 2**18


def _deformations(plan: Plan, place: Index) -> Deformations | None:
    """Deformations per unknown, these at their `place` in the order; None where they vary over the batch."""
    coupling = plan.coupling
    constant = all(block.rows is not None for block in coupling.blocks if block.group is not None)
    rows = coupling.transformation
    return Deformations(plan, rows, place) if constant and are_described(plan, rows) else None


def deformed(plan: Plan, place: Index) -> tuple[scipy.sparse.csr_matrix, Index] | None:
    """The deformations as a matrix (springs, unknowns), and the numbers of the springs; None where they vary."""
    found = _deformations(plan, place)
    return None if found is None else (found.by_unknowns, found.acting)


class StackedSolver:
    """Solver for any number of matrices of one pattern, each with its load cases.

    Parameters
    ----------
    plan
        The plan of the frame.
    factors
        Factors of earlier solutions, to which new ones are added, by mask of the stiffness, set of unknowns, and number
        of the first matrix.
    loaded
        Mask of the unknowns that count as loaded, (n,); None for those that loads reach.
    """

    def __init__(
        self, plan: Plan, factors: dict[tuple[int, bytes, int], StackedFactor], loaded: Mask | None = None
    ) -> None:
        self.plan = plan
        self.unknown: Index = plan.graph.unknown
        self.coupling = plan.coupling
        self.loaded = self.coupling.loaded if loaded is None else loaded
        self._factors = factors

    def reaching(self, unknowns: Iterable[int]) -> StackedSolver:
        """The solver in which the components of these unknowns count as loaded, too; itself where they do already."""
        asked = np.searchsorted(self.unknown, np.array(list(unknowns), dtype=np.int64))
        label = self.coupling.label
        return self._with(self.loaded | np.isin(label, label[asked]))

    def part(self, node: int) -> StackedSolver:
        """The solver in which only the part of the frame that contains a node counts as loaded."""
        connected_components = self.plan.connected_components
        return self._with(self.loaded & (connected_components[self.unknown // 6] == connected_components[node]))

    @cached_property
    def parts(self) -> int:
        """Number of loaded parts of the frame; parts that share only supports are not connected."""
        if self.plan.graph.links.count_of_components < 2:
            return int(any_of(self.loaded))
        return len(np.unique(self.plan.connected_components[self.unknown[self.loaded] // 6]))

    def _with(self, loaded: Mask) -> StackedSolver:
        """The solver with another mask of loaded unknowns, (n,); itself where it is the same."""
        return self if np.array_equal(loaded, self.loaded) else StackedSolver(self.plan, self._factors, loaded)

    @property
    def reason(self) -> str:
        """Method by which the batch is solved, and why, in words."""
        return self.plan.method.reason

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Values of rows over the unknowns, each of a shape that broadcasts to the batch."""
        rhs_parameters = self.plan.rhs_parameters.values
        keys = np.array(sorted({key for row in rows for key in row if key >= 0}), dtype=np.int64)
        places = np.searchsorted(self.unknown, keys)
        reached = self.loaded[places]
        with np.errstate(all="ignore"):
            found = self._solved.of(places[reached]) if any_of(reached) else []
        value = dict(zip(keys[reached].tolist(), map(self._value, found), strict=True))

        def number(key: int) -> Value:
            return rhs_parameters[-1 - key] if key < 0 else value.get(key, 0.0)

        def total(row: Row) -> Value:
            if len(row) == 1:  # as most often
                ((key, factor),) = row.items()
                return product(factor, number(key))
            return combine([(factor, number(key)) for key, factor in row.items()])

        return [total(row) for row in rows]

    def singular(self, *, excited: bool) -> Mask:
        """Whether the loaded (`excited`) components, or the others, are singular, (...) of the batch shape."""
        found = self._solved.singular if excited else self._unloaded
        spread, shape = self._spread(found), self.plan.frame.shape
        return spread if spread.shape == shape else np.broadcast_to(spread, shape)

    def suspects(self) -> Mask:
        """Entries that may have lost their digits, here those that are singular, (...) of the batch shape."""
        return self.singular(excited=True)

    # -- the batch as two axes ----------------------------------------------------------------------------------------

    @cached_property
    def _axes(self) -> tuple[list[int], list[int]]:
        """Batch axes over which the stiffness varies, and the others."""
        axes = range(len(self.plan.frame.shape))
        varies = [axis for axis in axes if self.coupling.mask >> axis & 1]
        return varies, [axis for axis in axes if axis not in varies]

    @cached_property
    def count(self) -> int:
        """Number of matrices."""
        return self.plan.grid.sizes[self.coupling.mask]

    @cached_property
    def cases(self) -> int:
        """Number of load cases of each matrix."""
        return self.plan.grid.sizes[-1] // max(1, self.count)

    @cached_property
    def by_units(self) -> bool:
        """Whether to solve for unit right-hand-side parameters rather than for each load case."""
        loads = self.coupling.blocks[-1].mask
        few = len(self.sources) < self.cases
        return few and not loads & ~self.coupling.mask and not self.coupling.imposed

    @cached_property
    def sources(self) -> Index:
        """Numbers of the right-hand-side parameters that act on the loaded unknowns."""
        return self.coupling.pattern.sources(self.loaded)

    @property
    def columns(self) -> int:
        """Number of right-hand sides of each matrix."""
        return len(self.sources) if self.by_units else self.cases

    def slices(self, numbers: int) -> Iterator[Index]:
        """Indices of right-hand sides, some at a time, by memory; each has so many `numbers`."""
        step = max(1, _ROOM // max(1, numbers))
        for start in range(0, self.columns, step):
            yield np.arange(start, min(start + step, self.columns))

    def _spread(self, found: NDArray[_Kind]) -> NDArray[_Kind]:
        """An array (matrices,) or (matrices, load cases) reshaped to the axes of the batch."""
        shape, (varies, others) = self.plan.frame.shape, self._axes
        if found.ndim == 1:
            return found.reshape([n if axis in varies else 1 for axis, n in enumerate(shape)])
        if not others or not varies:  # the axes are in order
            return found.reshape(shape)
        split = found.reshape([shape[axis] for axis in varies + others])
        return np.moveaxis(split, range(len(shape)), varies + others)

    def entries(self, matrices: Index, columns: Index) -> Picked:
        """Batch entries of matrices and load cases, the latter running fastest; of matrices alone if `by_units`."""
        shape, (varies, others) = self.plan.frame.shape, self._axes
        if self.by_units or self.cases == 1:
            return Picked.of(shape, self.coupling.mask, matrices)
        mine = np.unravel_index(np.repeat(matrices, len(columns)), [shape[axis] for axis in varies] or (1,))
        cases = np.unravel_index(np.tile(columns, len(matrices)), [shape[axis] for axis in others] or (1,))
        by_axis = dict(zip(varies, mine, strict=False)) | dict(zip(others, cases, strict=False))
        return Picked(shape, tuple(by_axis[axis].astype(np.int64) for axis in range(len(shape))))

    # -- solution -----------------------------------------------------------------------------------------------------

    def _value(self, found: Array) -> Value:
        """The value of an unknown, from its solutions (matrices, right-hand sides)."""
        if not self.by_units:
            return np.ascontiguousarray(self._spread(found))
        rhs_parameters = self.plan.rhs_parameters.values
        each = zip(np.moveaxis(found, 1, 0), self.sources.tolist(), strict=True)
        return combine([(self._spread(unit), rhs_parameters[source]) for unit, source in each])

    @cached_property
    def _solved(self) -> _Solved:
        with np.errstate(all="ignore"):
            # with a copy of this solver: a reference cycle would be freed late, by the garbage collector alone
            self.columns  # noqa: B018  # cached, so that the copy has it as well
            twin = object.__new__(type(self))
            vars(twin).update(vars(self))
            return _Solved(twin)

    @cached_property
    def _unloaded(self) -> Mask:
        """Whether the unloaded components are singular, (matrices,)."""
        out = np.zeros(self.count, dtype=bool)
        if self.loaded.all():
            return out
        bands = self.bands(~self.loaded)
        with np.errstate(all="ignore"):
            for matrices, factor in self.factors(bands):
                growth = factor.probed(np.arange(len(matrices)))
                out[matrices] = ~(1.0 / growth > zero_eigenvalue(bands.size))
        return out

    def bands(self, where: Mask) -> Bands:
        """The banded matrices of the unknowns in a mask (n,)."""
        graph = self.plan.graph
        with timed(self.plan.times, "elimination order"):
            return Bands(self.coupling, where, graph.order(graph.band, where), partial(deformed, self.plan))

    def step(self, bands: Bands) -> int:
        """How many matrices are factorised at a time."""
        turned = sum(block.count for block in self.coupling.blocks if block.rows is None)
        numbers = turned + len(bands.position) + bands.size * (bands.width + 1)
        room = max(_ROOM, _ROOM_OF_KIND * len(self.plan.topology.groups))
        step = max(1, room // (8 * numbers))
        if bands.kind is AllAtOnce:
            return max(step, TOGETHER)
        return in_lanes(step) if bands.side_by_side else step

    def factors(self, bands: Bands) -> Iterator[tuple[Index, StackedFactor]]:
        """Numbers of matrices, and their factors, some at a time; nothing if there are no unknowns."""
        if not bands.size:
            return
        step = self.step(bands)
        hold = 8 * self.count * bands.size * (bands.width + 1) < _HOLD
        room: Room | None = None
        for start in range(0, self.count, step):
            matrices = np.arange(start, min(start + step, self.count))
            key = self.coupling.mask, bands.where.tobytes(), start
            if key not in self._factors or self._factors[key].count != len(matrices):
                with timed(self.plan.times, "factorisation"):
                    if room is None and hold and step < self.count:
                        room = bands.room(self.count)
                    shape, mask = self.plan.frame.shape, self.coupling.mask
                    factor = bands.factorised(Picked.of(shape, mask, matrices), room)
                if not hold:
                    yield matrices, factor
                    continue
                self._factors[key] = factor
            yield matrices, self._factors[key]


class _Solved:
    """Solutions of the loaded unknowns.

    Parameters
    ----------
    solver
        The solver of the batch.
    """

    def __init__(self, solver: StackedSolver) -> None:
        self.solver = solver
        self.coupling, self.plan = solver.coupling, solver.plan
        self.bands = solver.bands(solver.loaded)
        self._loads = StackedLoads(self.plan, solver.loaded, self.bands, solver.sources, by_units=solver.by_units)
        self._singular = np.zeros(solver.count, dtype=bool)
        self._known = False
        # Solutions that are kept, (unknowns kept, matrices, right-hand sides), and the index of each unknown among
        # them, in the order of elimination, or -1.
        self._found = np.zeros((0, solver.count, solver.columns))
        self._at = np.full(self.bands.size, -1)
        self._bytes_in_all = 8 * self.bands.size * solver.count * solver.columns
        if self._bytes_in_all < _HOLD:
            self._run(np.arange(self.bands.size))

    @property
    def singular(self) -> Mask:
        """Whether a matrix is singular, (matrices,)."""
        if not self._known:
            if self._band_pass is not None:
                self._run(np.arange(0))
            else:
                for matrices, factor in self.solver.factors(self.bands):
                    self._examine(matrices, factor)
            self._known = True
        return self._singular

    def of(self, places: Index) -> list[Array]:
        """Solutions of some unknowns, (matrices, right-hand sides) each."""
        rows = self.bands.place[places]
        if any_of(self._at[rows] < 0):
            # From the second request on, the solutions of all unknowns are kept if they take few enough bytes.
            again = len(self._found) and self._bytes_in_all < _KEEP
            wanted = np.concatenate([rows, np.flatnonzero(self._at >= 0)])
            self._run(np.arange(self.bands.size) if again else np.unique(wanted))
        return [self._found[at] for at in self._at[rows].tolist()]

    def _run(self, rows: Index) -> None:
        """Solve, and keep the solutions of some of the unknowns."""
        out = self._in_turn(rows) if self._band_pass is None else self._in_one_pass(rows, self._band_pass)
        self._known = True
        if len(rows) or not self.bands.size:
            self._found, self._at = out, np.full(self.bands.size, -1)
            self._at[rows] = np.arange(len(rows))

    @cached_property
    def _band_pass(self) -> SpringBands | None:
        """The solution in one pass; None where it has to be found step by step."""
        possible = self.bands.side_by_side and in_one_pass(self.solver.count) and self.solver.columns == 1
        return stacked_pass.of(self.bands, self._deformations) if possible and not self.coupling.imposed else None

    def _in_one_pass(self, rows: Index, solution: SpringBands) -> Array:
        """Solutions of some of the unknowns; matrices that leave a doubt are factorised and refined by themselves."""
        count, shape, mask = self.solver.count, self.plan.frame.shape, self.coupling.mask
        out: Array = np.empty((len(rows), count, 1))
        sound = np.zeros(count, dtype=bool)
        with timed(self.plan.times, "solution"):
            for part in solution.slices(count, len(rows)):
                picked = Picked.of(shape, mask, np.arange(part.start, part.stop))
                forces = self._loads.acting(picked)
                sound[part] = solution.run(picked, forces, rows, out[:, part, 0])
        doubtful, step = np.flatnonzero(~sound), self.solver.step(self.bands)
        for start in range(0, len(doubtful), step):
            some = doubtful[start : start + step]
            factor = self.bands.factorised(Picked.of(shape, mask, some))
            self._examine(some, factor)
            out[:, some] = self._part(some, np.arange(1), factor)[rows]
        return out

    def _in_turn(self, rows: Index) -> Array:
        """Solutions of some of the unknowns by factors, which are kept, and refinement."""
        solver = self.solver
        out: Array = np.empty((len(rows), solver.count, solver.columns))
        for matrices, factor in solver.factors(self.bands):
            self._examine(matrices, factor)
            for columns in solver.slices(self.bands.size * len(matrices)):
                part = slice(matrices[0], matrices[-1] + 1), slice(columns[0], columns[-1] + 1)
                values = self._part(matrices, columns, factor)
                if values.shape == out.shape:  # it is the whole result
                    out = values
                else:
                    out[:, *part] = values if len(rows) == len(values) else values[rows]
        return out

    def _examine(self, matrices: Index, factor: StackedFactor) -> None:
        self._singular[matrices] = factor.singular

    def _part(self, matrices: Index, columns: Index, factor: StackedFactor) -> Array:
        """Solutions (size, m, right-hand sides) of m matrices for some of their right-hand sides."""
        with timed(self.plan.times, "solution"):
            right = self._loads.of(matrices, columns, self._entries(matrices, columns, factor))
            values = right * factor.root[..., None]
            factor.solve(np.arange(len(matrices)), values)
            values *= factor.root[..., None]
            singular = self._singular[matrices]
            if any_of(singular):
                values[:, singular] = np.nan
        # pivots show which matrices are singular, but not which have lost digits: refinement does
        hard = np.flatnonzero(~(singular | factor.precise))
        if len(hard) and len(columns):
            with timed(self.plan.times, "refinement"):
                self._refine(matrices, columns, hard, factor, right, values)
        return values

    def _entries(self, matrices: Index, columns: Index, factor: StackedFactor) -> Picked:
        """Batch entries of matrices and columns; those of the factor if they are the same, being evaluated already."""
        alike = len(matrices) == factor.count and (self.solver.by_units or self.solver.cases == 1)
        return factor.picked if alike else self.solver.entries(matrices, columns)

    # -- refinement ---------------------------------------------------------------------------------------------------

    def _refine(
        self, matrices: Index, columns: Index, hard: Index, factor: StackedFactor, right: Array, values: Array
    ) -> None:
        """Refine in place the `values` (size, m, right-hand sides) of the matrices with indices `hard`."""
        cases = 1 if self.solver.by_units else len(columns)
        room = max(_REFINED, _REFINED_OF_KIND * len(self.plan.topology.groups))
        step = max(1, room // (cases * self._bytes))
        for start in range(0, len(hard), step):
            some = hard[start : start + step]
            every = len(some) == values.shape[1]
            better, loads = (values, right) if every else (values[:, some], right[:, some])
            lost = refine(self._residual(matrices[some], columns, loads, factor, some), factor, some, better)
            better[:, lost.any(axis=1)] = np.nan
            self._singular[matrices[some]] = lost.any(axis=1)
            if not every:
                values[:, some] = better

    @cached_property
    def names(self) -> list[int]:
        """Numbers of the unknowns in the order of elimination."""
        found: list[int] = self.solver.unknown[np.argsort(self.bands.place)][-self.bands.size :].tolist()
        return found

    @cached_property
    def _deformations(self) -> Deformations | None:
        return _deformations(self.plan, self.bands.place)

    @property
    def _bytes(self) -> int:
        """Bytes that the refinement of one entry needs."""
        if self._deformations is None:
            return StaticsResidual.bytes(self.plan)
        return 32 * (len(self._deformations.acting) + self.bands.size)

    def _residual(
        self, matrices: Index, columns: Index, right: Array, factor: StackedFactor, entries: Index
    ) -> Residual:
        """The residual of some `entries` of a factor, which are the given `matrices` of the batch."""
        solver, deformations = self.solver, self._deformations
        if deformations is None:
            picked, units = solver.entries(matrices, columns), right if solver.by_units else None
            return StaticsResidual(self.plan, self._kinematics, picked, self.names, units)
        stiffness = factor.numbers(deformations.acting, entries)
        given, forces = None, right
        if self.coupling.imposed:
            picked = solver.entries(matrices, columns)
            given = picked.of_values(self._loads.given)
            forces = self._loads.of(matrices, columns, picked, imposed=False)
        residual = SpringResidual(deformations, stiffness, forces.reshape(self.bands.size, -1), given)
        return BySprings(residual, in_pairs=in_pairs(solver.count * solver.columns, self.bands.size))

    @cached_property
    def _kinematics(self) -> FrameKinematics:
        """The frame's kinematics in extended precision, at the whole batch."""
        return FrameKinematics.of(self.plan)
