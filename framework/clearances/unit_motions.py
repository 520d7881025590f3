"""Motions and joint forces of a frame without loads for a unit offset in each component with clearance."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cached_property, reduce
from typing import Any, NamedTuple

import numpy as np

from ..batch import Array, Shape
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..results.linear import LinearResults, OfRows
from ..structure.parts import Row, Value, add_row, is_zero

# The deformation of a spring by a unit offset is rounding up to this: an angle, or a length over the size of the frame.
_UNSTRAINED = 1e-9
# Largest number of nodal displacements that are looked at.
_MOST = 2**24
# An offset whose effect is found per unit has its number times this as its value, which is that of no load.
_MARK = 2.0**-1000
Pairs = Sequence[tuple[str, int]]


class Solvers(NamedTuple):
    """Functions that return the linear solution of a description, without clearances.

    Attributes
    ----------
    of
        As the description says.
    per_unit
        With each offset that varies as a right-hand-side parameter of its own, per unit of which results are found, by
        broadcasting elimination; None where that would not take less time.
    """

    of: Callable[[Description], LinearResults]
    per_unit: Callable[[Description], LinearResults] | None


class UnitMotions:
    """The solution for unit offsets, each of them being an entry of a batch.

    Parameters
    ----------
    solution
        The solution of the unloaded frame for a unit offset in each component, of batch shape (n, ...).
    pairs
        Name of the joint, and component of the joint, for each of the n components with clearance.
    """

    def __init__(self, solution: LinearResults, pairs: Pairs) -> None:
        self.solution, self.plan, self._pairs = solution, solution.plan, list(pairs)

    @property
    def entries(self) -> int:
        """Number of batch entries, each unit offset being one."""
        return self.plan.grid.sizes[-1]

    @property
    def shape(self) -> Shape:
        """Batch shape for one of the unit offsets."""
        return self.plan.frame.shape[1:]

    @cached_property
    def forces(self) -> Array:
        """Joint forces by unit offsets, (n, n, ...): the first axis counts forces, the second offsets."""
        return self.solution.joint_components(self._pairs)

    @cached_property
    def stiffness(self) -> Array:
        """Decrease of the force in each component per unit offset in each, (n, n, ...), symmetric.

        It is the mean of both decreases that are equal by Betti's theorem; NaN where offsets move a mechanism.
        """
        found: Array = self.forces + np.swapaxes(self.forces, 0, 1)
        found *= -0.5
        return found

    @cached_property
    def strained(self) -> bool:
        """Whether a unit offset deforms a spring, so that its motion depends on the stiffness."""
        return bool(self._springs) and self._strained(np.abs(self.rows(self._springs)))

    def moved(self, dofs: Sequence[int]) -> Array:
        """Displacements of nodes in their own axes by unit offsets, given by DOF numbers, (n, ..., dofs)."""
        return self.rows(self._rows(dofs))

    def rows(self, rows: Sequence[Row]) -> Array:
        """Values of rows over the unknowns, (n, ..., rows), zero at entries that are left out."""
        return self._kept(self.solution.stacked(rows))

    def largest(self) -> tuple[Array, Array] | None:
        """Largest displacement and largest rotation of a node by unit offsets, (n, ...) each.

        None where that would take too much memory.
        """
        if 6 * len(self.solution.frame.nodes) * math.prod(self.forces.shape[1:]) > _MOST:
            return None
        moved = np.abs(self.solution.nodal())
        return moved[..., :3].max(axis=(-1, -2)), moved[..., 3:].max(axis=(-1, -2))

    def _kept(self, found: Array) -> Array:
        solution = self.solution
        return found if solution.frame.absent is None else np.where(solution.lost[..., None], 0.0, found)

    def _strained(self, deformed: Array) -> bool:
        # not a number is a deformation, too
        return not bool(deformed.max(initial=0.0) <= _UNSTRAINED * min(1.0, self.solution.frame.size))

    def _rows(self, dofs: Sequence[int]) -> list[Row]:
        return [self.plan.tree.row(*divmod(dof, 6)) for dof in dofs]

    @cached_property
    def _springs(self) -> list[Row]:
        """Rows of the deformations of the springs in joints, angles times the size of the frame."""
        tree, size = self.plan.tree, self.solution.frame.size
        edges = [(branch.edge, [tree.joint_row(branch, k) for k in range(6)]) for branch in tree.branches]
        rows: list[Row] = []
        for edge, moved in [*edges, *tree.closing]:
            for k, row in enumerate(edge.elastic(moved)):
                if k not in edge.ideal and not is_zero(edge.stiffness[k]):
                    rows.append({})
                    add_row(rows[-1], row, 1.0 if k < 3 else size)
        return rows


class UnitMotionsPerEntry(UnitMotions):
    """The solution for unit offsets of a long batch that is factorised anew in each pass: all offsets in one pass.

    What virtual works need is computed together with the forces, and so are the forces under the loads.

    Parameters
    ----------
    solution
        The solution of the frame, of batch shape (...), each offset being a right-hand-side parameter.
    pairs
        Name of the joint, and component of the joint, for each of the n components with clearance.
    loaded
        DOF numbers of the loads on the frame, whose motions are its virtual displacements; None if no virtual work is
        asked for.
    loads
        Whether loads act on the frame, and the forces under them are asked for.
    """

    def __init__(
        self, solution: LinearResults, pairs: Pairs, loaded: Sequence[int] | None, *, loads: bool = False
    ) -> None:
        super().__init__(solution, pairs)
        self._loaded, self._loads = None if loaded is None else list(loaded), loads

    @classmethod
    def of(
        cls,
        bare: Description,
        pairs: Pairs,
        solve: Callable[[Description], LinearResults],
        loaded: Sequence[int] | None,
    ) -> UnitMotionsPerEntry | None:
        """The motions of a frame without offsets; None where the passes would not take less time, or not all hold."""
        return cls(_with_marks(bare, pairs, solve), pairs, loaded)._if_found

    @classmethod
    def with_loads(
        cls, frame: Description, pairs: Pairs, solve: Callable[[Description], LinearResults], *, works: bool
    ) -> UnitMotionsPerEntry | None:
        """The motions of a loaded frame, together with its joint forces, and with what virtual `works` need.

        None as for `of`, and if loads set entries in motion. In these components the frame has no offsets.
        """
        solution = _with_marks(frame, pairs, solve)
        found = cls(solution, pairs, [*solution.plan.forces] if works else None, loads=True)._if_found
        absent = solution.frame.absent
        moving = found is not None and (solution.lost if absent is None else solution.lost & ~absent).any()
        return None if moving else found

    @property
    def _if_found(self) -> UnitMotionsPerEntry | None:
        return self if self.solution.by_chunks and self._found is not None else None

    @property
    def under_loads(self) -> Array:
        """Joint forces under the loads, (n, ...), NaN at entries that are left out."""
        assert self._found is not None
        found, absent = self._found[-1], self.solution.frame.absent
        return found if absent is None else np.where(absent, np.nan, found)

    @property
    def entries(self) -> int:
        return super().entries * len(self._pairs)

    @property
    def shape(self) -> Shape:
        return self.plan.frame.shape

    @property
    def forces(self) -> Array:
        return -self.stiffness

    @property
    def stiffness(self) -> Array:
        assert self._found is not None
        return self._found[0]

    @cached_property
    def strained(self) -> bool:
        if self._loaded is None or self._found is None:
            return super().strained
        return self._strained(self._kept(self._found[1]))

    def moved(self, dofs: Sequence[int]) -> Array:
        if self._found is None or list(dofs) != self._loaded:
            return super().moved(dofs)
        return self._kept(self._found[2])

    def rows(self, rows: Sequence[Row]) -> Array:
        return self._per_unit(lambda values: values(rows))

    def largest(self) -> tuple[Array, Array]:
        kinds = [self._rows(range(start, 6 * len(self.plan.topology.number), 6)) for start in range(6)]

        def most(values: Callable[[Sequence[Row]], Sequence[Value]]) -> list[Value]:
            return [_most([value for rows in three for value in values(rows)]) for three in (kinds[:3], kinds[3:])]

        found = self._per_unit(most)
        return found[..., 0], found[..., 1]

    def _per_unit(self, numbers: OfRows) -> Array:
        found = self.solution.against_offsets([], [numbers], self._parameters)
        assert found is not None
        return self._kept(found[1])

    @cached_property
    def _found(self) -> list[Array] | None:
        """Stiffness (n, n, ...), by unit offsets the largest deformation of a spring (n, ..., 1) and displacements at
        the loads (n, ..., m), and if asked for the forces under the loads (n, ...); None where entries are singular.
        """
        rows = [] if self._loaded is None else self._rows(self._loaded)
        springs = [] if self._loaded is None else self._springs
        others: list[OfRows] = [
            lambda values: [_most(values(springs))],
            lambda values: list(values(rows)),
        ]
        return self.solution.against_offsets(self._pairs, others, self._parameters, loads=self._loads)

    @cached_property
    def _parameters(self) -> list[int]:
        """Index of each offset among the right-hand-side parameters, by its mark."""
        self.plan.tree  # noqa: B018  # which adds them
        values = self.plan.rhs_parameters.values
        places = {float(value.flat[0]): k for k, value in enumerate(values) if isinstance(value, np.ndarray)}
        return [places[number * _MARK] for number in range(1, len(self._pairs) + 1)]


def _with_marks(frame: Description, pairs: Pairs, solve: Callable[[Description], LinearResults]) -> LinearResults:
    """The solution of a frame to which an offset is added in each component, known by its mark."""
    longest = int(np.argmax(frame.shape))
    shape = tuple(size if axis == longest else 1 for axis, size in enumerate(frame.shape))
    for number, (name, component) in enumerate(pairs, 1):
        frame.offset(name, **{DISPLACEMENTS[component]: np.full(shape, number * _MARK)})
    return solve(frame).silenced()


def _most(values: Sequence[Any]) -> Any:
    """Largest absolute value."""
    return reduce(np.maximum, map(abs, values), 0.0)
