"""What equilibrium in space and in a plane have in common: coordinates of a joint tree, and forces handed up in it.

A node below another in the tree moves with its parent and by its link's own coordinates, ``dx = J (dx_parent, dq)``; so
a force on it acts as ``J^T f`` on these, leaves first.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..batch import Array
from ..elementwise import contracted, zeros
from ..structure.edge import GROUND
from .model import Model
from .numbers import Where
from .state import Index


@dataclass(frozen=True)
class Linearisation:
    """What one iteration of Newton's method takes.

    Attributes
    ----------
    forces
        Unbalanced force on all coordinates, unknown and prescribed (size, m): inner less outer.
    values
        Tangent on the pattern of the model (entries, m).
    energy
        Twice the strain energy, in members and joints (m,).
    """

    forces: Array
    values: Array
    energy: Array


class TreeEquations(ABC):
    """Equations of equilibrium of some batch entries of a model under a share of its loads.

    Parameters
    ----------
    model
        The compiled frame.
    columns
        Number of each coordinate of the nodes (k, nodes).
    where
        Indices of the entries along each batch axis.
    count
        Number of entries.
    factor
        Share of loads, offsets and prescribed displacements.
    """

    def __init__(self, model: Model, columns: Index, where: Where, count: int, factor: float) -> None:
        self.model, self.columns = model, columns
        self.where, self.count, self.factor = where, count, factor

    @cached_property
    def lengths(self) -> Array:
        """Length that displacements are compared with (m,) or (1,)."""
        return self.model.lengths.at(self.where)

    @cached_property
    def scale(self) -> Array:
        """Makes steps of coordinates radians or lengths of the frame (size, m or 1); zero for multipliers."""
        out = np.zeros((self.model.size + 1, *self.lengths.shape))
        out[self.model.columns[:3]], out[self.model.columns[3:]] = 1.0 / self.lengths, 1.0
        return out[:-1]

    @cached_property
    def prescribed_values(self) -> Array:
        """Values that the prescribed coordinates are to have (prescribed, m)."""
        out = np.zeros((len(self.model.prescribed), self.count))
        for row, key in enumerate(self.model.prescribed):
            out[row] = self.factor * self.model.prescribed_values[key].at(self.where)
        return out

    # -- what space and plane say each in its own way ---------------------------------------------------------------

    @property
    @abstractmethod
    def geometry(self) -> list[Any]:
        """By link of the tree where it puts the child, at these entries."""

    @property
    @abstractmethod
    def ground(self) -> tuple[Array, Array]:
        """Displacement and rotation of the ground."""

    @abstractmethod
    def coordinate(self, state: Any, node: int, component: int) -> Array:
        """Value of a coordinate of a node or of the link that carries it, by its number in space (m,)."""

    @abstractmethod
    def advanced(self, state: Any, step: Array) -> Any:
        """The state after a step of the coordinates (size, m)."""

    @abstractmethod
    def energy(self, state: Any) -> Array:
        """Strain energy less the work of the loads (m,); in space moments apart, see `moment_work`."""

    @abstractmethod
    def moment_work(self, old: Any, new: Any) -> Array:
        """Work of the moments on the way from one state to another, where `energy` does not hold it (m,)."""

    @abstractmethod
    def stresses(self, state: Any) -> list[Array]:
        """By stack of members, the true forces on their deformations."""

    @abstractmethod
    def step_stresses(self, at: Any, step: Array) -> list[Array]:
        """Forces on the deformations after a step, predicted by the linear change of the deformations."""

    @abstractmethod
    def linearised(self, state: Any, stresses: list[Array] | None = None) -> Any:
        """Forces and tangent; the geometric stiffness of members is that of `stresses`, or of the true ones."""

    @abstractmethod
    def _geometric(self, number: int, change: Any, force: Array) -> Array:
        """Tangent of what a constant force on the child of a link does: by the parent, and by the link's own (3)."""

    @abstractmethod
    def _in_chain(self, node: int, matrix: Array, moved: Any) -> Array:
        """That tangent with the parent's coordinates in terms of those of its chain."""

    # -- motion -----------------------------------------------------------------------------------------------------

    def prescribed_residual(self, state: Any) -> Array:
        """Difference of the prescribed coordinates from their values (prescribed, m)."""
        out = self.prescribed_values.copy()
        for row, (node, component) in enumerate(self.model.prescribed):
            out[row] -= self.coordinate(state, node, component)
        return out

    def at(self, state: Any, node: int) -> tuple[Array, Array]:
        """Displacement and rotation of a node, or of the ground."""
        return self.ground if node == GROUND else (state.displacements[:, node], state.rotations[..., node, :])

    def follow(self, state: Any) -> None:
        """Place the nodes below others in the joint tree."""
        for number, (joint, link) in enumerate(zip(self.model.joints, self.geometry, strict=True)):
            place, rotation = link.child(*self.at(state, joint.parent), state.own[:, number])
            state.displacements[:, joint.child], state.rotations[..., joint.child, :] = place, rotation

    def nodal(self, step: Array) -> Array:
        """Steps of the coordinates by node (k, nodes, m)."""
        padded = np.concatenate([step, np.zeros((1, step.shape[-1]))])
        return padded[self.columns]

    # -- forces -----------------------------------------------------------------------------------------------------

    def _reduced(self, nodal: Array, transfers: list[Array], resisted: list[Array]) -> tuple[Array, list[Array]]:
        """Forces on the coordinates from those on the nodes, leaves first; and by link those of members and loads.

        Parameters
        ----------
        nodal
            Forces on the nodes (k, nodes, m); what hangs on a node is added to it.
        transfers
            By link motion of the child by that of its parent and its own coordinates, (k, 2 k, m).
        resisted
            By link the force of its springs.
        """
        model, own = self.model, len(nodal)
        out = zeros((model.size + 1, self.count), nodal)
        carried: list[Array] = []
        for number in range(len(model.joints) - 1, -1, -1):
            joint = model.joints[number]
            pushed = contracted("ji...,j...->i...", transfers[number], nodal[:, joint.child])
            carried.insert(0, pushed[own:])
            out[self.columns[:, joint.child]] = pushed[own:] + resisted[number]
            if joint.parent != GROUND:
                nodal[:, joint.parent] += pushed[:own]
        plain = model.plain
        out[self.columns[:, plain]] = nodal[:, plain]
        return out[:-1], carried

    def _link_tangents(
        self, nodal: Array, changes: list[Any], transfers: list[Array], resisted: list[Array], moved: Any
    ) -> list[Array]:
        """Springs of the links, and what turning them does to the forces that they pass on; leaves first.

        Parameters
        ----------
        nodal
            Forces on the nodes, handed up.
        changes
            By link what its geometric stiffness is made of.
        transfers
            As in `_reduced`.
        resisted
            By link the stiffness of its springs.
        moved
            How nodes move by the coordinates of their chains, as `_in_chain` takes it.
        """
        out: list[Array] = []
        for number in range(len(changes) - 1, -1, -1):
            joint = self.model.joints[number]
            force = nodal[:, joint.child]
            matrix = self._geometric(number, changes[number], force)
            matrix[3:, 3:] += resisted[number]
            if joint.parent == GROUND:
                out.insert(0, matrix[3:, 3:])
                continue
            above = transfers[number][:, : len(nodal)]
            nodal[:, joint.parent] += contracted("ji...,j...->i...", above, force)
            out.insert(0, self._in_chain(joint.parent, matrix, moved))
        return out
