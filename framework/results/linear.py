"""The interface of a linear solution that error bounds, force recovery and clearances need."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..batched.broadcast import BroadcastSolver
from ..batched.plan import Plan
from ..description import Description
from ..error_bounds.resolved import Solved
from ..solvers.sparse import SparseSolver
from ..solvers.stacked import StackedSolver
from ..states import States
from ..structure.parts import Row, Value
from .consistent_mechanisms import ConsistentMechanisms

# A function that returns numbers, given a function that returns the values of rows.
OfRows = Callable[[Callable[[Sequence[Row]], Sequence[Value]]], Sequence[Value]]


class LinearResults(Protocol):
    """A linear solution, as `linkframe.framework.Solution` is one."""

    @property
    def frame(self) -> Description:
        """The description as it was when solved."""
        ...

    @property
    def plan(self) -> Plan:
        """The plan of the frame."""
        ...

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        ...

    @property
    def solver(self) -> BroadcastSolver | StackedSolver | SparseSolver:
        """The solver of the plan."""
        ...

    @property
    def by_chunks(self) -> bool:
        """Whether results that are asked for together take much less than one by one, as each pass eliminates anew."""
        ...

    @property
    def resolved(self) -> Solved | None:
        """Results of entries that were solved in extended precision; None for none."""
        ...

    @property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries with free motions on which the loads do no work; None for none."""
        ...

    @property
    def known_consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """`consistent_mechanisms` if it has been computed already, else None."""
        ...

    @property
    def own_state(self) -> States:
        """State of each entry, (...)."""
        ...

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Entries that certainly have no results, (...): left out, or kinematically unstable under the loads."""
        ...

    @property
    def movable(self) -> NDArray[np.bool_]:
        """Entries at which a loaded part of the frame has a free motion, (...)."""
        ...

    def silenced(self) -> LinearResults:
        """This solution, with warnings of mechanisms switched off."""
        ...

    def part(self, node: str | None) -> LinearResults:
        """The solution of the connected part of the frame that contains a node."""
        ...

    def reaching(self, unknowns: Iterable[int]) -> LinearResults:
        """The solution in which these unknowns, and those coupled with them, are solved for as well."""
        ...

    def joint_displacement(self, joint: str) -> Array:
        """Displacement of a joint's second node relative to its first, in the joint's axes, (..., 6)."""
        ...

    def joint_force(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first node, in the joint's axes, (..., 6)."""
        ...

    def joint_components(self, pairs: Sequence[tuple[str, int]]) -> Array:
        """Single components of joint forces in which offsets are possible, (n, ...), in a single pass."""
        ...

    def against_offsets(
        self,
        pairs: Sequence[tuple[str, int]],
        others: Sequence[OfRows],
        parameters: Sequence[int],
        *,
        loads: bool = False,
    ) -> list[Array] | None:
        """Stiffness against n offsets, (n, n, ...), and other numbers per unit of each, (n, ..., m) each.

        If asked for, the forces in these components under the loads, (n, ...), as well. None where they do not hold.
        """
        ...

    def reaction(self, node: str) -> Array:
        """Force and moment of a support on its node in global axes, (..., 6)."""
        ...

    def end_forces(self, member: str) -> Array:
        """Force and moment on each end of a member in its local axes, (..., 12)."""
        ...

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Values of n rows over unknowns and right-hand-side parameters, (..., n)."""
        ...

    def nodal(self) -> Array:
        """Displacements of all nodes in their own axes, (..., nodes, 6)."""
        ...
