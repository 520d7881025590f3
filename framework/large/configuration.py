"""A frame at some batch entries: its numbers, how it moves, and its energy."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import rotation
from ..batch import Array
from ..elementwise import added, contracted
from ..rotation import dot
from ..structure.edge import GROUND
from . import corotation
from .corotation import CorotatedPieces, Pieces
from .links import EdgeGeometry
from .loops import displacement
from .model import Model
from .numbers import Numbers, Where
from .state import DisplacedState


class LoadedEntries:
    """Some batch entries of a model under a share of its loads, in space or in the plane."""

    model: Model
    where: Where
    count: int
    factor: float

    @cached_property
    def lengths(self) -> Array:
        """Length that displacements are compared with (m,) or (1,)."""
        return self.model.lengths.at(self.where)

    @cached_property
    def scale(self) -> Array:
        """Makes steps of coordinates radians or lengths of the frame, (size, m or 1)."""
        return self.model.scale(self.where)

    @cached_property
    def prescribed_values(self) -> Array:
        """Values that the prescribed coordinates are to have (prescribed, m)."""
        return self.model.driven_values(self.where, self.count, self.factor)


class Configuration(LoadedEntries):
    """A model at some entries.

    Parameters
    ----------
    model
        The compiled frame.
    where
        Indices of the entries along each batch axis (m,).
    factor
        Share of loads, offsets and prescribed displacements.
    """

    def __init__(self, model: Model, where: Where, count: int, factor: float = 1.0) -> None:
        self.model, self.where, self.count = model, where, count
        self.factor = factor

    # -- numbers ----------------------------------------------------------------------------------------------------

    @cached_property
    def pieces(self) -> list[Pieces]:
        """Stacks of pieces."""
        return [stack.at(self.where, self.factor) for stack in self.model.stacks]

    @cached_property
    def links(self) -> list[EdgeGeometry]:
        """Links of the tree."""
        return [joint.at(self.where) for joint in self.model.joints]

    @cached_property
    def loads(self) -> Array:
        """Forces and moments on nodes (6, nodes, m or 1)."""
        return self.factor * self.model.loads.nodal.at(self.where)

    # -- motion -----------------------------------------------------------------------------------------------------

    def prescribed_residual(self, state: DisplacedState) -> Array:
        """Difference of the prescribed coordinates from their values (prescribed, m)."""
        out = self.prescribed_values.copy()
        for row, (node, k) in enumerate(self.model.prescribed):
            out[row] -= state.displacements[k, node] if self.model.plain[node] else state.own[k, self._link[node]]
        return out

    def advanced(self, state: DisplacedState, step: Array) -> DisplacedState:
        """The state after a step of the coordinates (size, m)."""
        model = self.model
        nodal = self.nodal(step)
        plain = model.plain
        displacements, rotations, own = state.displacements.copy(), state.rotations.copy(), state.own.copy()
        displacements[:, plain] += nodal[:3, plain]
        rotations[:, plain] = rotation.normalised(
            rotation.product(rotation.exponential(nodal[3:, plain]), state.rotations[:, plain])
        )
        for number, joint in enumerate(model.joints):
            own[:, number] = joint.shortest(own[:, number] + nodal[:, joint.child])
        if model.loops:
            own[:, len(model.joints) :] += np.concatenate([step, np.zeros((1, step.shape[-1]))])[model.multipliers]
        new = DisplacedState(displacements, rotations, own, state.contact_multipliers)
        self.follow(new)
        return new

    def follow(self, state: DisplacedState) -> None:
        """Place the nodes below others in the joint tree."""
        for number, (joint, link) in enumerate(zip(self.model.joints, self.links, strict=True)):
            place, turn = self.at(state, joint.parent)
            own = state.own[:, number]
            state.displacements[:, joint.child], state.rotations[:, joint.child] = link.child(place, turn, own)

    def at(self, state: DisplacedState, node: int) -> tuple[Array, Array]:
        """Displacement and quaternion of a node, or of the ground."""
        if node != GROUND:
            return state.displacements[:, node], state.rotations[:, node]
        still = np.zeros((4, self.count))
        still[0] = 1.0
        return np.zeros((3, self.count)), still

    def nodal(self, step: Array) -> Array:
        """Steps of the coordinates by node (6, nodes, m)."""
        padded = np.concatenate([step, np.zeros((1, step.shape[-1]))])
        return padded[self.model.columns]

    @cached_property
    def _link(self) -> dict[int, int]:
        return {joint.child: number for number, joint in enumerate(self.model.joints)}

    # -- energy -----------------------------------------------------------------------------------------------------

    def energy(self, state: DisplacedState) -> Array:
        """Strain energy less the work of forces (m,); moments apart, see `moment_work`."""
        motions = self.motions(state)
        return self.strain_energy(state, motions) - self.load_work(state, motions)

    def strain_energy(self, state: DisplacedState, motions: list[CorotatedPieces] | None = None) -> Array:
        """Energy in members and joints (m,)."""
        total = np.zeros(self.count)
        for pieces, motion in zip(self.pieces, motions or self.motions(state), strict=True):
            total += added(corotation.strain_energy(pieces, motion))
        for number in range(len(self.model.edges)):
            total += self.resistance(state, number, self.own(state, number))[0]
        return total

    def own(self, state: DisplacedState, number: int) -> Array:
        """Displacement (6, m) in a link or, counted on, loop."""
        links = len(self.model.joints)
        return state.own[:, number] if number < links else self.loop_displacement(state, number - links)

    def loop_displacement(self, state: DisplacedState, number: int) -> Array:
        """Displacement (6, m) in an edge that closes a loop."""
        return displacement(*self.loop(state, number))

    def loop(self, state: DisplacedState, number: int) -> tuple[EdgeGeometry, tuple[Array, Array], tuple[Array, Array]]:
        """Geometry of an edge that closes a loop, displacements and quaternions of its nodes."""
        loop = self.model.loops[number]
        (first, turn), (second, other) = self.at(state, loop.parent), self.at(state, loop.child)
        return loop.at(self.where), (first, second), (turn, other)

    def load_work(self, state: DisplacedState, motions: list[CorotatedPieces]) -> Array:
        """Work of forces from rest on, if they had acted whole (m,)."""
        loads = np.broadcast_to(self.loads[:3], state.displacements.shape)
        total: Array = contracted("ij...,ij...->...", loads, state.displacements)
        for pieces, motion in zip(self.pieces, motions, strict=True):
            total = total + added(corotation.work(pieces, motion))
        for node, push, arm in self.offset_forces:
            total = total + dot(
                push, rotation.rotated(state.rotations[:, node], arm + np.zeros_like(state.displacements[:, 0]))
            )
        return total

    def motions(self, state: DisplacedState) -> list[CorotatedPieces]:
        """Frames and deformations of all pieces."""
        pairs = zip(self.model.stacks, self.pieces, strict=True)
        return [motion_of(stack.ends, pieces, state) for stack, pieces in pairs]

    def moment_work(self, old: DisplacedState, new: DisplacedState) -> Array:
        """Work of the moments on the way from one state to another (m,)."""
        total = np.zeros(self.count)
        for node in self._twisted:
            turn = rotation.product(new.rotations[:, node], rotation.conjugate(old.rotations[:, node]))
            total += dot(self.loads[3:, node] + 0.0 * turn[1:], rotation.logarithm(turn))
        return total

    @cached_property
    def _twisted(self) -> list[int]:
        return [node for node in range(self.model.count) if np.any(self.loads[3:, node])]

    @cached_property
    def offset_forces(self) -> list[tuple[int, Array, Array]]:
        """Weights on arms: node, force and arm at rest (3, m or 1)."""
        ndim, given = self.model.ndim, self.model.loads.offset_forces
        forces = [self.factor * Numbers.of(each.force, ndim, 1).at(self.where) for each in given]
        arms = [Numbers.of(each.arm, ndim, 1).at(self.where) for each in given]
        return [(each.node, force, arm) for each, force, arm in zip(given, forces, arms, strict=True)]

    def resistance(self, state: DisplacedState, number: int, own: Array) -> tuple[Array, Array, Array]:
        """Energy (m,), force (6, m) and tangent (6, 6, m) of the springs of a link or, counted on, loop."""
        joint = self.model.edges[number]
        elastic = own - self.factor * joint.offset.at(self.where)
        return joint.resistance(self.where, elastic, state.contact_multipliers, self.model.contacts.get(number))


def motion_of(ends: NDArray[np.int64], pieces: Pieces, state: DisplacedState) -> CorotatedPieces:
    """Frames and deformations of the pieces of a stack between the nodes `ends` (n, 2)."""
    first, second = ends.T
    displacements = state.displacements[:, first], state.displacements[:, second]
    return corotation.motion(pieces, displacements, (state.rotations[:, first], state.rotations[:, second]))
