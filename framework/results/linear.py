"""What bounds, recovered forces, fields and clearances ask of a linear solution."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
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
from ..structure.parts import Row
from .consistent_mechanisms import ConsistentMechanisms


class LinearResults(Protocol):
    """A linear solution, as `linkframe.framework.Solution` is one."""

    @property
    def frame(self) -> Description:
        """The description as it was when solved."""
        ...

    @property
    def plan(self) -> Plan:
        """The compiled frame."""
        ...

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        ...

    @property
    def solver(self) -> BroadcastSolver | StackedSolver | SparseSolver:
        """What solves the plan."""
        ...

    @property
    def resolved(self) -> Solved | None:
        """Entries solved in extended precision."""
        ...

    @property
    def consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """Entries that can move, on whose free motions the loads do no work."""
        ...

    @property
    def known_consistent_mechanisms(self) -> ConsistentMechanisms | None:
        """`consistent_mechanisms`, once that has been asked for."""
        ...

    @property
    def own_state(self) -> States:
        """State of each entry, (...)."""
        ...

    @property
    def lost(self) -> NDArray[np.bool_]:
        """Entries without results of which that is plain: left out, or set in motion by the loads, (...)."""
        ...

    @property
    def movable(self) -> NDArray[np.bool_]:
        """Entries in which what the loads reach can move, (...)."""
        ...

    def silenced(self) -> LinearResults:
        """This solution, which from now on tells of no mechanism in a warning."""
        ...

    def part(self, node: str | None) -> LinearResults:
        """The solution of the part of the frame that a node is in."""
        ...

    def reaching(self, unknowns: Iterable[int]) -> LinearResults:
        """The same with what is coupled with these unknowns solved for too."""
        ...

    def joint_displacement(self, joint: str) -> Array:
        """Displacement of a joint's second node from its first in its axes, (..., 6)."""
        ...

    def joint_force(self, joint: str) -> Array:
        """Force and moment that a joint exerts on its first node, in the joint's axes, (..., 6)."""
        ...

    def reaction(self, node: str) -> Array:
        """Force and moment of a support on its node in global axes, (..., 6)."""
        ...

    def end_forces(self, member: str) -> Array:
        """Force and moment on each end of a member in its local axes, (..., 12)."""
        ...

    def stacked(self, rows: Sequence[Row]) -> Array:
        """Values of n combinations of unknowns and right-hand-side parameters, (..., n)."""
        ...

    def nodal(self) -> Array:
        """Displacements of all nodes in their own axes, (..., nodes, 6)."""
        ...
