"""Equilibrium in a plane: the same equations as in space, in two displacements and one angle a node.

In the plane rotations add up, and a piece is two directions, an elongation and two angles. What comes out equals
`equations` to rounding, for a fraction of the time. Angles are not limited to a turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..batch import Array, merged
from ..elementwise import contracted
from ..structure.edge import GROUND
from . import planar_pieces
from .numbers import Where, summed
from .planar_model import PlanarLink, PlanarModel
from .state import PlanarState
from .tree_equations import Linearisation, TreeEquations


@dataclass(frozen=True)
class PlanarLinearisation(Linearisation):
    """What one iteration knows in the plane.

    Attributes
    ----------
    changes
        By stack direction and length of the chords, and the stiffness against elongation and both angles.
    stresses
        By stack, the true forces on the deformations.
    transfers
        By link, motion of the child by those of the parent and the link's own (3, 6, m).
    """

    changes: list[tuple[Array, Array, Array]]
    stresses: list[Array]
    transfers: list[Array]


class PlanarEquations(TreeEquations):
    """A model in the plane at some entries; see `EquilibriumEquations`.

    Parameters
    ----------
    planar_model
        The model.
    where
        Indices of the entries along each batch axis.
    count
        Number of entries.
    factor
        Share of loads, offsets and prescribed displacements.
    """

    def __init__(self, planar_model: PlanarModel, where: Where, count: int, factor: float = 1.0) -> None:
        super().__init__(planar_model.model, planar_model.columns, where, count, factor)
        self.planar_model = planar_model
        self.pieces = [
            (stack.direction.at(where), stack.length.at(where), stack.stiffness.at(where))
            for stack in planar_model.stacks
        ]
        self.loads = factor * planar_model.loads.at(where)

    @cached_property
    def geometry(self) -> list[PlanarLink]:
        """Links of the tree."""
        return [joint.at(self.where, self.factor) for joint in self.planar_model.joints]

    @cached_property
    def ground(self) -> tuple[Array, Array]:
        """Displacement and angle of the ground."""
        return np.zeros((2, self.count)), np.zeros(self.count)

    # -- motion -----------------------------------------------------------------------------------------------------

    def coordinate(self, state: PlanarState, node: int, component: int) -> Array:
        """Value of a coordinate of a node, or of the link that carries it, by its number in space (m,)."""
        if self.model.plain[node]:  # which has no prescribed rotation
            out: Array = state.displacements[self.planar_model.components.index(component), node]
        else:
            number = self.model.link_of[node]
            out = state.own[self.planar_model.joints[number].places.index(component), number]
        return out

    def advanced(self, state: PlanarState, step: Array) -> PlanarState:
        """The state after a step of the coordinates (size, m)."""
        nodal = self.nodal(step)
        own = state.own + nodal[:, [joint.child for joint in self.model.joints]] if self.geometry else state.own
        moved = state.displacements + nodal[:2], state.rotations + nodal[2], own
        new = PlanarState(*moved, state.contact_force, state.contact_stiffness)
        self.follow(new)
        return new

    # -- energy -----------------------------------------------------------------------------------------------------

    def energy(self, state: PlanarState) -> Array:
        """Strain energy less the work of the loads (m,)."""
        total = np.zeros(self.count)
        for stack, pieces in zip(self.planar_model.stacks, self.pieces, strict=True):
            _, _, deformation = planar_pieces.shape(stack, pieces, state)
            bow = planar_pieces.bent(pieces[2], deformation)
            total += 0.5 * planar_pieces.strain_energy(pieces[2], deformation, bow)
        for number in range(len(self.geometry)):
            total += self.resistance(state, number)[0]
        total -= contracted(
            "ijm,ijm->m", np.broadcast_to(self.loads[:2], state.displacements.shape), state.displacements
        )
        total -= contracted("jm,jm->m", np.broadcast_to(self.loads[2], state.rotations.shape), state.rotations)
        return total

    def resistance(self, state: PlanarState, number: int) -> tuple[Array, Array, Array]:
        """Energy (m,), force (3, m) and tangent (3, 3, m) of the springs of a link, or of its own law."""
        link, joint = self.geometry[number], self.planar_model.joints[number]
        elastic = state.own[:, number] - link.offset
        if joint.joint.law is not None:
            return joint.law_response(self.where, elastic, state.contact(self.model.contacts.get(number)))
        return link.springs(elastic)

    def moment_work(self, old: PlanarState, new: PlanarState) -> Array:
        """Nothing: in a plane moments have a potential, and `energy` holds it."""
        del old, new
        return np.zeros(self.count)

    # -- derivatives ------------------------------------------------------------------------------------------------

    def linearised(self, state: PlanarState, stresses: list[Array] | None = None) -> PlanarLinearisation:
        """Forces and tangent; the geometric stiffness of members is that of `stresses`, or of the true ones."""
        nodal = np.repeat(-self.loads, self.count, axis=-1) if self.loads.shape[-1] == 1 else -self.loads
        nodal = merged(nodal, 0, 1)
        assumed = nodal
        changes, true, data = [], [], []
        energy = np.zeros(self.count)
        arms = [self._arm(state, number) for number in range(len(self.geometry))]
        transfers = [link.transfer(*arm) for link, arm in zip(self.geometry, arms, strict=True)]
        for k, (stack, pieces) in enumerate(zip(self.planar_model.stacks, self.pieces, strict=True)):
            axes, chord, deformation = planar_pieces.shape(stack, pieces, state)
            bow = planar_pieces.bent(pieces[2], deformation)
            exact = planar_pieces.stress(pieces[2], deformation, bow)
            used = exact if stresses is None else stresses[k]
            energy = energy + planar_pieces.strain_energy(pieces[2], deformation, bow)
            nodal = nodal + summed(self.planar_model.gather[k], merged(planar_pieces.forces(axes, chord, exact), 0, 1))
            if stresses is not None:
                assumed = assumed + summed(
                    self.planar_model.gather[k], merged(planar_pieces.forces(axes, chord, used), 0, 1)
                )
            stiffness = planar_pieces.stiffness(pieces[2], bow, used[0])
            changes.append((axes, chord, stiffness))
            true.append(exact)
            data += self._tangents(k, planar_pieces.terms(stiffness, axes, chord, used), transfers)
        shape = (3, self.model.count, self.count)
        assumed = (nodal if stresses is None else assumed).reshape(shape).copy()
        nodal = nodal.reshape(shape)
        resisted = [self.resistance(state, number) for number in range(len(self.geometry))]
        forces, _ = self._reduced(nodal, transfers, [force for _, force, _ in resisted])
        data += self._link_tangents(assumed, arms, transfers, [tangent for *_, tangent in resisted], transfers)
        for stored, _, _ in resisted:
            energy = energy + 2.0 * stored
        blocks = [np.zeros((0, self.count)), *(merged(block, 0, -2) for block in data)]
        values = summed(self.planar_model.pattern[0], np.concatenate(blocks))
        return PlanarLinearisation(forces, values, energy, changes, true, transfers)

    def stresses(self, state: PlanarState) -> list[Array]:
        """By stack, the true forces on the deformations (3, n, m)."""
        out = []
        for stack, pieces in zip(self.planar_model.stacks, self.pieces, strict=True):
            _, _, deformation = planar_pieces.shape(stack, pieces, state)
            bow = planar_pieces.bent(pieces[2], deformation)
            out.append(planar_pieces.stress(pieces[2], deformation, bow))
        return out

    def step_stresses(self, at: PlanarLinearisation, step: Array) -> list[Array]:
        """Forces on the deformations after a step, predicted by the linear change of the deformations."""
        nodal = self.nodal(step)
        for joint, transfer in zip(self.model.joints, at.transfers, strict=True):
            own = nodal[:, joint.child]
            parent = np.zeros_like(own) if joint.parent == GROUND else nodal[:, joint.parent]
            nodal[:, joint.child] = contracted("ijm,jm->im", transfer, np.concatenate([parent, own]))
        out = []
        for k, stack in enumerate(self.planar_model.stacks):
            first, second = stack.ends.T
            (c, s), chord, stiffness = at.changes[k]
            x, y = nodal[:2, second] - nodal[:2, first]
            chord_rotation = (c * y - s * x) / chord
            stretch = c * x + s * y
            one, two = nodal[2, first] - chord_rotation, nodal[2, second] - chord_rotation
            k00, k01, k02, k11, k12, k22 = stiffness
            change = [k00 * stretch + k01 * one + k02 * two, k01 * stretch + k11 * one + k12 * two]
            out.append(at.stresses[k] + np.stack([*change, k02 * stretch + k12 * one + k22 * two]))
        return out

    def _arm(self, state: PlanarState, number: int) -> tuple[Array, Array]:
        """Axes of a link's translations, and its arm, both turned with its first node."""
        joint = self.model.joints[number]
        _, angle = self.at(state, joint.parent if joint.forward else joint.child)
        return self.geometry[number].rotated_arm(angle, state.own[:, number])

    def _tangents(self, k: int, terms: Array, transfers: list[Array]) -> list[Array]:
        """Different entries of plain pieces as they are, the others in the terms of their chains."""
        linked = self.planar_model.linked[k]
        out = [] if linked.all() else [terms[:, ~linked]]
        for number in np.flatnonzero(linked):
            first, second = self.planar_model.stacks[k].ends[number].tolist()
            whole = planar_pieces.six(terms[:, number])
            whole = np.concatenate([self._up(whole[:3], first, transfers), self._up(whole[3:], second, transfers)])
            whole = np.swapaxes(whole, 0, 1)
            out.append(np.concatenate([self._up(whole[:3], first, transfers), self._up(whole[3:], second, transfers)]))
        return out

    def _up(self, rows: Array, node: int, transfers: list[Array]) -> Array:
        """Rows (3, k, m) of a node's coordinates as rows of those of its chain."""
        number = self.model.link_of.get(node)
        if number is None:
            return rows
        transfer, parent = transfers[number], self.model.joints[number].parent
        own: Array = contracted("ijm,ikm->jkm", transfer[:, 3:], rows)
        if parent == GROUND:
            return own
        above = rows.copy()
        above[2] += transfer[0, 2] * rows[0] + transfer[1, 2] * rows[1]
        return np.concatenate([self._up(above, parent, transfers), own])

    def _geometric(self, number: int, change: tuple[Array, Array], force: Array) -> Array:
        """Tangent of what a constant force on the child does: by the parent, and by the link's own (6, 6, m)."""
        return self.geometry[number].geometric(force, *change)

    def _in_chain(self, node: int, matrix: Array, moved: list[Array]) -> Array:
        """That tangent in terms of the chain of the parent."""
        for _ in range(2):
            matrix = np.swapaxes(np.concatenate([self._up(matrix[:3], node, moved), matrix[3:]]), 0, 1)
        return matrix
