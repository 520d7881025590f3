"""Displacements of, and forces on, the ends of the pieces into which members are divided."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from ..batch import Array
from ..program import sweep
from ..program.sweep import Sweep
from ..structure.parts import Row, Value
from .along_member import GroupedPieces
from .force_numbers import ForceNumbers
from .member_field import end_loads
from .primary import Primary


class WithoutFormula(Exception):
    """An element has no `end_force_numbers`, so that its end forces cannot be recorded."""


def refused(piece: int) -> Array:
    """No forces of a piece whose element has no formula, where those of the loads would be wrong."""
    raise WithoutFormula(piece)


class PieceEnds(GroupedPieces):
    """Displacements of and forces on the ends of all pieces.

    Parameters
    ----------
    solution
        The values of the unknowns.
    """

    def __init__(self, solution: Primary) -> None:
        super().__init__(solution.plan.topology)
        self.solution, self.plan = solution, solution.plan
        self._forces: dict[int, Array] = {}

    @property
    def long(self) -> bool:
        """Whether the batch is so long that results are recorded as a program first."""
        return math.prod(self.solution.shape) >= sweep.LONG

    def rows(self, piece: int) -> list[Row]:
        """The twelve rows of the end displacements in the nodes' axes."""
        row = self.plan.tree.row
        return [row(node, k) for node in self.topology.pieces[piece].nodes for k in range(6)]

    def displacement(self, piece: int) -> Array:
        """End displacements of a piece in its local axes, (..., 12)."""
        group, position = self.group(piece)
        nodal = self.solution.stacked(self.rows(piece))
        with np.errstate(invalid="ignore"):  # of mechanisms, whose entries are masked
            return group.local(position, nodal)

    def forces(self, piece: int) -> Array:
        """Forces on both ends of a piece in its local axes, (..., 12)."""
        if piece not in self._forces:
            with np.errstate(all="ignore"):  # of mechanisms, whose entries are masked
                found = self._by_formula(piece) if self.long else None
                self._forces[piece] = self._by_arrays(piece) if found is None else found
        return self._forces[piece]

    def _by_formula(self, piece: int) -> Array | None:
        """The forces by a program, for a long batch; None where the element has no `end_force_numbers`."""
        try:
            return self.solution.recorded(lambda once: [self.written(once, refused).ends(piece)])[0]
        except WithoutFormula:
            return None

    def _by_arrays(self, piece: int) -> Array:
        group, position = self.group(piece)
        local = group.local(position, self.solution.stacked(self.rows(piece)))
        at = np.array([position])
        found = group.end_forces(at, local[None])[0] - end_loads(self.topology, group, at)[0]
        return np.broadcast_to(found, (*self.solution.shape, 12))

    def written(self, once: Sweep, ends: Callable[[int], Array] | None = None, *, loaded: bool = True) -> ForceNumbers:
        """Forces component by component, as terms of a recording.

        Parameters
        ----------
        once
            The recording.
        ends
            Function that returns the forces on the ends of a piece whose element has no formula; `forces` where None.
        loaded
            Whether the loads act, which is so unless the recording is that of a unit offset.
        """
        values, take = once.values, once.recording.take
        return ForceNumbers(self.plan, self.group, values, take, ends or self.forces, written=True, loaded=loaded)

    def of_arrays(self) -> ForceNumbers:
        """Forces component by component, as arrays."""
        solution = self.solution

        def values(rows: Sequence[Row]) -> list[Value]:
            return list(np.moveaxis(solution.stacked(rows), -1, 0))

        return ForceNumbers(self.plan, self.group, values, lambda value: value, self.forces, written=False)
