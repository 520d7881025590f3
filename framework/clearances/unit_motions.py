"""Motions and joint forces of a frame without loads for a unit offset in each component with clearance."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property, reduce
from typing import NamedTuple

import numpy as np

from ..batch import Array
from ..description import Description
from ..dofs import DISPLACEMENTS
from ..results.linear import LinearResults
from ..structure.parts import Row, add_row, is_zero

# The deformation of a spring by a unit offset is rounding up to this: an angle, or a length over the size of the frame.
_UNSTRAINED = 1e-9
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

    @cached_property
    def forces(self) -> Array:
        """Joint forces by unit offsets, (n, n, ...): the first axis counts forces, the second offsets."""
        return self.solution.joint_components(self._pairs)

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

    def nodal(self) -> Array:
        """Displacement of every node in its own axes, (n, ..., nodes, 6)."""
        return self.solution.nodal()

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


class _Motion(NamedTuple):
    """Forces (..., n), largest deformation of a spring (..., 1) and loaded displacements (..., m) by a unit offset."""

    forces: Array
    deformed: Array
    moved: Array


class UnitMotionsPerEntry(UnitMotions):
    """The solution for unit offsets of a long batch that is factorised anew in each pass: all offsets in one pass.

    What virtual works need is computed together with the forces.

    Parameters
    ----------
    solution
        The solution of the unloaded frame, of batch shape (...), each offset being a right-hand-side parameter.
    pairs
        Name of the joint, and component of the joint, for each of the n components with clearance.
    loaded
        DOF numbers of the loads on the frame, whose motions are its virtual displacements; None if no virtual work is
        asked for.
    """

    def __init__(self, solution: LinearResults, pairs: Pairs, loaded: Sequence[int] | None) -> None:
        super().__init__(solution, pairs)
        self._loaded = None if loaded is None else list(loaded)

    @classmethod
    def of(
        cls,
        bare: Description,
        pairs: Pairs,
        solve: Callable[[Description], LinearResults],
        loaded: Sequence[int] | None,
    ) -> UnitMotionsPerEntry | None:
        """The motions of a frame without offsets; None where the passes would not take less time, or not all hold."""
        longest = int(np.argmax(bare.shape))
        shape = tuple(size if axis == longest else 1 for axis, size in enumerate(bare.shape))
        for number, (name, component) in enumerate(pairs, 1):
            bare.offset(name, **{DISPLACEMENTS[component]: np.full(shape, float(number))})
        found = cls(solve(bare).silenced(), pairs, loaded)
        return found if found.solution.by_chunks and found._found is not None else None

    @property
    def entries(self) -> int:
        return super().entries * len(self._pairs)

    @cached_property
    def forces(self) -> Array:
        assert self._found is not None
        return np.stack([np.moveaxis(each.forces, -1, 0) for each in self._found], axis=1)

    @cached_property
    def strained(self) -> bool:
        if self._loaded is None or self._found is None:
            return super().strained
        return any(self._strained(self._kept(each.deformed)) for each in self._found)

    def moved(self, dofs: Sequence[int]) -> Array:
        if self._found is None or list(dofs) != self._loaded:
            return super().moved(dofs)
        return np.stack([self._kept(each.moved) for each in self._found])

    def rows(self, rows: Sequence[Row]) -> Array:
        found = self.solution.joint_components_per_unit([], [lambda values: values(rows)], self._parameters)
        assert found is not None
        return np.stack([self._kept(values) for _, values in found])

    def nodal(self) -> Array:
        count = len(self.plan.topology.number)
        found = self.rows(self._rows(range(6 * count)))
        return found.reshape(*found.shape[:-1], count, 6)

    @cached_property
    def _found(self) -> list[_Motion] | None:
        """What each offset does; None where entries are singular."""
        rows = [] if self._loaded is None else self._rows(self._loaded)
        springs = [] if self._loaded is None else self._springs
        others = [
            lambda values: [reduce(np.maximum, map(abs, values(springs)), 0.0)],
            lambda values: values(rows),
        ]
        found = self.solution.joint_components_per_unit(self._pairs, others, self._parameters)
        return None if found is None else [_Motion(*each) for each in found]

    @cached_property
    def _parameters(self) -> list[int]:
        """Index of each offset among the right-hand-side parameters: its value is its number."""
        self.plan.tree  # noqa: B018  # which adds them
        values = self.plan.rhs_parameters.values
        places = {float(value.flat[0]): k for k, value in enumerate(values) if isinstance(value, np.ndarray)}
        return [places[float(number)] for number in range(1, len(self._pairs) + 1)]
