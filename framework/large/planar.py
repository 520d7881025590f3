"""Equilibrium in a plane: the same equations as in space, in two displacements and one angle a node.

In the plane rotations add up, and a piece is two directions, an elongation and two angles. What comes out equals
`equations` to rounding, for a fraction of the time. Angles are not limited to a turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, merged
from ..elementwise import contracted, zeros
from ..structure.edge import GROUND
from . import planar_pieces
from .configuration import LoadedEntries
from .joint_law import ContactMultipliers
from .model import Model
from .numbers import Where, summed
from .planar_links import PlanarJoint, PlanarLink
from .planar_model import PlanarModel
from .state import PlanarState


@dataclass(frozen=True)
class PlanarLinearisation:
    """What one iteration knows; see `equations.Linear`."""

    forces: Array
    values: Array
    changes: list[tuple[Array, Array, Array]]
    stresses: list[Array]
    transfers: list[Array]
    energy: Array


class PlanarEquations(LoadedEntries):
    """A model in the plane at some entries; see `Equations`.

    Parameters
    ----------
    planar_joint
        The model.
    where
        Indices of the entries along each batch axis.
    count
        Number of entries.
    factor
        Share of loads, offsets and prescribed displacements.
    """

    def __init__(self, planar_model: PlanarModel, where: Where, count: int, factor: float = 1.0) -> None:
        self.planar_model, self.model = planar_model, planar_model.model
        self.where, self.count, self.factor = where, count, factor
        self.pieces = [
            (stack.direction.at(where), stack.length.at(where), stack.stiffness.at(where))
            for stack in planar_model.stacks
        ]
        self.links = [PlanarLink.of(joint, where, factor) for joint in planar_model.joints]
        self.loads = factor * planar_model.loads.at(where)

    @classmethod
    def start(cls, model: Model, count: int) -> PlanarState:
        """At rest."""
        own, contact_multipliers = (
            np.zeros((3, len(model.joints), count)),
            ContactMultipliers.none(len(model.contacts), count),
        )
        return PlanarState(np.zeros((2, model.count, count)), np.zeros((model.count, count)), own, contact_multipliers)

    # -- motion -----------------------------------------------------------------------------------------------------

    def prescribed_residual(self, state: PlanarState) -> Array:
        """Difference of the prescribed coordinates from their values (prescribed, m)."""
        out = self.prescribed_values.copy()
        if not len(out):
            return out
        for number, link in enumerate(self.planar_model.joints):
            self._reduce(out, self.planar_model.columns[:, link.joint.child], state.own[:, number])
        for node in np.flatnonzero(self.model.plain & (self.planar_model.columns >= self.model.free).any(axis=0)):
            self._reduce(
                out, self.planar_model.columns[:, node], [*state.displacements[:, node], state.rotations[node]]
            )
        return out

    def _reduce(self, prescribed_residual: Array, columns: NDArray[np.int64], values: Array | list[Array]) -> None:
        for column, value in zip(columns.tolist(), values, strict=True):
            if column >= self.model.free:
                prescribed_residual[column - self.model.free] -= value

    def advanced(self, state: PlanarState, step: Array) -> PlanarState:
        """The state after a step of the coordinates (size, m)."""
        nodal = self._nodal(step)
        new = PlanarState(
            state.displacements + nodal[:2], state.rotations + nodal[2], state.own, state.contact_multipliers
        )
        if self.links:
            new.own = state.own + nodal[:, [planar_joint.joint.child for planar_joint in self.planar_model.joints]]
        self.follow(new)
        return new

    def follow(self, state: PlanarState) -> None:
        """Place the nodes that are attached to others."""
        for number, (planar_joint, link) in enumerate(zip(self.planar_model.joints, self.links, strict=True)):
            joint = planar_joint.joint
            free = joint.parent == GROUND
            place = np.zeros((2, self.count)) if free else state.displacements[:, joint.parent]
            turn = np.zeros(self.count) if free else state.rotations[joint.parent]
            state.displacements[:, joint.child], state.rotations[joint.child] = link.child(
                place, turn, state.own[:, number]
            )

    def _nodal(self, step: Array) -> Array:
        padded = np.concatenate([step, np.zeros((1, step.shape[-1]))])
        return padded[self.planar_model.columns]

    # -- energy -----------------------------------------------------------------------------------------------------

    def energy(self, state: PlanarState) -> Array:
        """Strain energy less the work of the loads (m,)."""
        total = np.zeros(self.count)
        for stack, pieces in zip(self.planar_model.stacks, self.pieces, strict=True):
            _, _, deformation = planar_pieces.shape(stack, pieces, state)
            total += 0.5 * planar_pieces.strain_energy(
                pieces[2], deformation, planar_pieces.bent(pieces[2], deformation)
            )
        for number in range(len(self.links)):
            total += self.resistance(state, number)[0]
        total -= contracted(
            "ijm,ijm->m", np.broadcast_to(self.loads[:2], state.displacements.shape), state.displacements
        )
        total -= contracted("jm,jm->m", np.broadcast_to(self.loads[2], state.rotations.shape), state.rotations)
        return total

    def resistance(self, state: PlanarState, number: int) -> tuple[Array, Array, Array]:
        """Energy (m,), force (3, m) and tangent (3, 3, m) of the springs of a link, or of its own law."""
        elastic, joint = self.links[number].elastic(state.own[:, number]), self.planar_model.joints[number]
        if joint.joint.law is not None:
            return joint.law_response(self.where, elastic, state.contact_multipliers, self.model.contacts.get(number))
        return self.links[number].springs(elastic)

    def moment_work(self, old: PlanarState, new: PlanarState) -> Array:
        """Nothing: in a plane moments have a potential, and `energy` holds it."""
        del old, new
        return np.zeros(self.count)

    # -- derivatives ------------------------------------------------------------------------------------------------

    def linearised(self, state: PlanarState, stresses: list[Array] | None = None) -> PlanarLinearisation:
        """Forces and tangent; see `Equations.linearised`."""
        nodal = np.repeat(-self.loads, self.count, axis=-1) if self.loads.shape[-1] == 1 else -self.loads
        nodal = merged(nodal, 0, 1)
        assumed = nodal
        changes, true, data = [], [], []
        energy = np.zeros(self.count)
        arms = [
            link.rotated_arm(self._turn(state, planar_joint), own) for planar_joint, link, own in self._linked(state)
        ]
        transfers = [link.transfer(*each) for link, each in zip(self.links, arms, strict=True)]
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
        nodal = nodal.reshape(shape)
        assumed = nodal.copy() if stresses is None else assumed.reshape(shape)
        resisted = [self.resistance(state, number) for number in range(len(self.links))]
        forces = self._reduced(nodal, transfers, [force for _, force, _ in resisted])
        data += self._link_tangents(arms, assumed, transfers, [tangent for *_, tangent in resisted])
        for stored, _, _ in resisted:
            energy = energy + 2.0 * stored
        blocks = [np.zeros((0, self.count)), *(merged(block, 0, -2) for block in data)]
        values = summed(self.planar_model.pattern[0], np.concatenate(blocks))
        return PlanarLinearisation(forces, values, changes, true, transfers, energy)

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
        nodal = self._nodal(step)
        for (planar_joint, _), transfer in zip(
            zip(self.planar_model.joints, self.links, strict=True), at.transfers, strict=True
        ):
            joint = planar_joint.joint
            own = nodal[:, joint.child]
            parent = np.zeros_like(own) if joint.parent == GROUND else nodal[:, joint.parent]
            nodal[:, joint.child] = contracted("ijm,jm->im", transfer, np.concatenate([parent, own]))
        out = []
        for k, stack in enumerate(self.planar_model.stacks):
            first, second = stack.ends.T
            (c, s), chord, stiffness = at.changes[k]
            x, y = nodal[:2, second] - nodal[:2, first]
            chord_rotation = (c * y - s * x) / chord
            stretch, one, two = (
                c * x + s * y,
                nodal[2, first] - chord_rotation,
                nodal[2, second] - chord_rotation,
            )
            k00, k01, k02, k11, k12, k22 = stiffness
            change = [k00 * stretch + k01 * one + k02 * two, k01 * stretch + k11 * one + k12 * two]
            out.append(at.stresses[k] + np.stack([*change, k02 * stretch + k12 * one + k22 * two]))
        return out

    def _linked(self, state: PlanarState) -> list[tuple[PlanarJoint, PlanarLink, Array]]:
        owns = [state.own[:, number] for number in range(len(self.links))]
        return list(zip(self.planar_model.joints, self.links, owns, strict=True))

    def _turn(self, state: PlanarState, planar_joint: PlanarJoint) -> Array:
        """Angle of a joint's first node."""
        joint = planar_joint.joint
        first = joint.parent if joint.forward else joint.child
        return np.zeros(self.count) if first == GROUND else np.asarray(state.rotations[first])

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

    @cached_property
    def _number(self) -> dict[int, int]:
        return {planar_joint.joint.child: number for number, planar_joint in enumerate(self.planar_model.joints)}

    def _up(self, rows: Array, node: int, transfers: list[Array]) -> Array:
        """Rows (3, k, m) of a node's coordinates as rows of those of its chain."""
        if node not in self._number:
            return rows
        number = self._number[node]
        transfer, parent = transfers[number], self.planar_model.joints[number].joint.parent
        own: Array = contracted("ijm,ikm->jkm", transfer[:, 3:], rows)
        if parent == GROUND:
            return own
        above = rows.copy()
        above[2] += transfer[0, 2] * rows[0] + transfer[1, 2] * rows[1]
        return np.concatenate([self._up(above, parent, transfers), own])

    def _link_tangents(
        self, arms: list[tuple[Array, Array]], nodal: Array, transfers: list[Array], tangents: list[Array]
    ) -> list[Array]:
        """Springs of the links, and what turning them does to the forces that they pass on."""
        out: list[Array] = []
        for number in range(len(self.links) - 1, -1, -1):
            joint, link = self.planar_model.joints[number].joint, self.links[number]
            force = nodal[:, joint.child]
            matrix = link.geometric(force, *arms[number])
            matrix[3:, 3:] += tangents[number]
            if joint.parent == GROUND:
                out.append(matrix[3:, 3:])
                continue
            nodal[:, joint.parent] += contracted("ijm,im->jm", transfers[number][:, :3], force)
            half = np.concatenate([self._up(matrix[:3], joint.parent, transfers), matrix[3:]])
            half = np.swapaxes(half, 0, 1)
            out.append(np.concatenate([self._up(half[:3], joint.parent, transfers), half[3:]]))
        return out[::-1]

    def _reduced(self, nodal: Array, transfers: list[Array], resisted: list[Array]) -> Array:
        """Forces on the coordinates from forces on the nodes, leaves first."""
        out = zeros((self.model.size + 1, self.count), nodal)
        nodal = nodal.copy()
        for number in range(len(self.links) - 1, -1, -1):
            joint = self.planar_model.joints[number].joint
            pushed = contracted("ijm,im->jm", transfers[number], nodal[:, joint.child])
            out[self.planar_model.columns[:, joint.child]] = pushed[3:] + resisted[number]
            if joint.parent != GROUND:
                nodal[:, joint.parent] += pushed[:3]
        plain = self.model.plain
        out[self.planar_model.columns[:, plain]] = nodal[:, plain]
        return out[:-1]
