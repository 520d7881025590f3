"""Equilibrium in space of some batch entries: energy, unbalanced forces and tangent at a state."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .. import rotation
from ..batch import Array, merged
from ..elementwise import added, contracted, zeros
from ..rotation import cross, dot, spin, times
from ..structure.edge import GROUND
from . import corotation
from .corotation import CorotatedPieces, Pieces
from .links import EdgeGeometry, LinkChange, LoopChange, displacement
from .model import Model
from .numbers import Numbers, Where, summed
from .response import Response
from .state import DisplacedState
from .tree_equations import Linearisation, TreeEquations


@dataclass(frozen=True)
class SpatialLinearisation(Linearisation):
    """What one iteration knows in space, and recovery after it.

    Attributes
    ----------
    responses
        By stack, how the deformations follow the ends.
    stresses
        By stack, the true forces on the deformations.
    jacobians
        By node that is attached to others, its displacement and spin by the coordinates of its chain (6, chain, m).
    nodal
        Force that holds each node with all that is attached to it (6, nodes, m).
    own
        Force of members and loads on the links' own coordinates, then on the loops' (6, links + loops, m).
    """

    responses: list[Response]
    stresses: list[Array]
    jacobians: dict[int, Array]
    nodal: Array
    own: Array


class EquilibriumEquations(TreeEquations):
    """A model in space at some entries, its energy and the derivatives of that.

    Parameters
    ----------
    model
        The compiled frame.
    where
        Indices of the entries along each batch axis (m,).
    count
        Number of entries.
    factor
        Share of loads, offsets and prescribed displacements.

    Attributes
    ----------
    symmetric
        Whether tangents are the symmetric parts of what they are else, which they are themselves in an equilibrium
        under loads that have a potential.
    """

    symmetric = False

    def __init__(self, model: Model, where: Where, count: int, factor: float = 1.0) -> None:
        super().__init__(model, model.columns, where, count, factor)

    # -- numbers ----------------------------------------------------------------------------------------------------

    @cached_property
    def pieces(self) -> list[Pieces]:
        """Stacks of pieces."""
        return [stack.at(self.where, self.factor) for stack in self.model.stacks]

    @cached_property
    def geometry(self) -> list[EdgeGeometry]:
        """Links of the tree."""
        return [joint.at(self.where) for joint in self.model.joints]

    @cached_property
    def loads(self) -> Array:
        """Forces and moments on nodes (6, nodes, m or 1)."""
        return self.factor * self.model.loads.nodal.at(self.where)

    @cached_property
    def ground(self) -> tuple[Array, Array]:
        """Displacement and quaternion of the ground."""
        still = np.zeros((4, self.count))
        still[0] = 1.0
        return np.zeros((3, self.count)), still

    # -- motion -----------------------------------------------------------------------------------------------------

    def coordinate(self, state: DisplacedState, node: int, component: int) -> Array:
        """Value of a coordinate of a node, or of the link that carries it (m,)."""
        plain = self.model.plain[node]
        out: Array = state.displacements[component, node] if plain else state.own[component, self.model.link_of[node]]
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
        new = DisplacedState(displacements, rotations, own, state.contact_force, state.contact_stiffness)
        self.follow(new)
        return new

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
        return state.own[:, number] if number < links else displacement(*self.loop(state, number - links))

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
        return joint.resistance(self.where, elastic, state.contact(self.model.contacts.get(number)))

    # -- derivatives ------------------------------------------------------------------------------------------------

    def stresses(self, state: DisplacedState) -> list[Array]:
        """By stack, the true forces on the deformations (7, n, m)."""
        pairs = zip(self.pieces, self.motions(state), strict=True)
        return [corotation.stress(pieces, at.deformation) for pieces, at in pairs]

    def linearised(
        self, state: DisplacedState, stresses: list[Array] | None = None, *, tangents: bool = True
    ) -> SpatialLinearisation:
        """Forces and tangent; the geometric stiffness of members is that of `stresses`, or of the true ones.

        Without `tangents`, which take most of the time, their values are left out, (0, m).
        """
        model = self.model
        nodal: Array = -merged(np.broadcast_to(self.loads, (6, model.count, self.count)), 0, 1)
        assumed = nodal.copy()
        responses, true, data = [], [], []
        energy = np.zeros(self.count)
        changes = self._changes(state)
        transfers = [change.jacobian for change in changes]
        jacobians = self._jacobians(transfers)
        for k, (stack, pieces) in enumerate(zip(model.stacks, self.pieces, strict=True)):
            response = Response(pieces, motion_of(stack.ends, pieces, state))
            exact = corotation.stress(pieces, response.at.deformation)
            used = exact if stresses is None else stresses[k]
            ends = response.forces(exact)
            nodal = nodal + summed(model.gather[k], merged(ends, 0, 1))
            if stresses is not None:
                ends = response.forces(used)
            assumed = assumed + summed(model.gather[k], merged(ends, 0, 1))
            responses.append(response)
            true.append(exact)
            energy = energy + 2.0 * added(corotation.strain_energy(pieces, response.at))
            if tangents:
                data += self._linked_tangent(k, response.tangent(used, symmetric=self.symmetric), jacobians)
        shape = (6, model.count, self.count)
        nodal, assumed = np.array(nodal.reshape(shape)), np.array(assumed.reshape(shape))
        data += self._offset_tangent(state, nodal, assumed, jacobians)
        closing = [self._closing(state, number, (nodal, assumed)) for number in range(len(model.loops))]
        resisted = [self.resistance(state, number, state.own[:, number]) for number in range(len(changes))]
        if tangents:
            data += self._link_tangents(assumed, changes, transfers, [each[2] for each in resisted], jacobians)
            data += [self._loop_tangent(number, matrix, jacobians) for number, (matrix, *_) in enumerate(closing)]
        forces, own = self._reduced(nodal, transfers, [each[1] for each in resisted])
        for number, (_, force, gap, stored) in enumerate(closing):
            constrained = model.multipliers[:, number]
            forces[constrained[constrained >= 0]] = gap[constrained >= 0]
            own.append(-force)
            energy = energy + 2.0 * stored
        nothing = np.zeros((0, self.count))
        blocks = [nothing, *(merged(block, 0, -2) for block in data)]
        values = summed(self.model.pattern[0], np.concatenate(blocks)) if tangents else nothing
        for stored, *_ in resisted:
            energy = energy + 2.0 * stored
        carried = np.stack(own, axis=1) if own else np.zeros((6, 0, self.count))
        return SpatialLinearisation(forces, values, energy, responses, true, jacobians, nodal, carried)

    def step_stresses(self, at: SpatialLinearisation, step: Array) -> list[Array]:
        """Forces on the deformations after a step, predicted by the linear change of the deformations."""
        nodal = self.nodal(step)
        padded = np.concatenate([step, np.zeros((1, step.shape[-1]))])
        for node, jacobian in at.jacobians.items():
            nodal[:, node] = contracted("ij...,j...->i...", jacobian, padded[self.model.chains[node]])
        out = []
        for k, stack in enumerate(self.model.stacks):
            ends = np.concatenate([nodal[:, stack.ends[:, 0]], nodal[:, stack.ends[:, 1]]])
            response, stress = at.responses[k], at.stresses[k]
            change = corotation.stress_change(
                self.pieces[k], response.at.deformation, stress[0], response.deformed(ends)
            )
            out.append(stress + change)
        return out

    def _changes(self, state: DisplacedState) -> list[LinkChange]:
        """By link of the tree, how its nodes move."""
        out = []
        for number, (joint, link) in enumerate(zip(self.model.joints, self.geometry, strict=True)):
            first = self.at(state, joint.parent)[1] if joint.forward else state.rotations[:, joint.child]
            out.append(LinkChange(link, first, state.own[:, number]))
        return out

    def _jacobians(self, transfers: list[Array]) -> dict[int, Array]:
        """Displacement and spin of nodes below others in the tree, by the coordinates of their chain (6, chain, m)."""
        out: dict[int, Array] = {}
        for joint, local in zip(self.model.joints, transfers, strict=True):
            own = local[:, 6:]
            if joint.parent == GROUND:
                out[joint.child] = own
            else:
                above = out.get(joint.parent)
                carried = local[:, :6] if above is None else times(local[:, :6], above)
                out[joint.child] = np.concatenate([carried, own], axis=1)
        return out

    def jacobian(self, node: int, jacobians: dict[int, Array]) -> Array:
        """Displacement and spin of a node by the coordinates of its chain (6, chain, m)."""
        return jacobians[node] if node in jacobians else np.broadcast_to(np.eye(6)[..., None], (6, 6, self.count))

    def _linked_tangent(self, k: int, tangent: Array, jacobians: dict[int, Array]) -> list[Array]:
        """Tangents of a stack's pieces: those between plain nodes as they are, the others in their chains' terms."""
        linked = self.model.linked[k]
        out = [tangent[:, :, ~linked]] if not linked.all() else []
        for number in np.flatnonzero(linked):
            first, second = self.model.stacks[k].ends[number].tolist()
            a, b = self.jacobian(first, jacobians), self.jacobian(second, jacobians)
            whole = tangent[:, :, number]
            wide = np.concatenate([times(whole[:, :6], a), times(whole[:, 6:], b)], axis=1)
            up = [times(rotation.transposed(part), wide[rows]) for part, rows in ((a, slice(0, 6)), (b, slice(6, 12)))]
            out.append(np.concatenate(up))
        return out

    def _offset_tangent(
        self, state: DisplacedState, nodal: Array, assumed: Array, jacobians: dict[int, Array]
    ) -> list[Array]:
        """Moments of weights on arms, added to the nodal forces, and their tangents."""
        out = []
        for node, push, arm in self.offset_forces:
            lever = arm + rotation.rotated(state.rotations[:, node], arm + np.zeros_like(state.displacements[:, 0]))
            push = push + np.zeros_like(lever)
            for forces in (nodal, assumed):
                forces[3:, node] -= cross(lever, push)
            turn = self.jacobian(node, jacobians)[3:]
            out.append(times(rotation.transposed(turn), times(-times(spin(push), spin(lever)), turn)))
        return out

    def _geometric(self, number: int, change: LinkChange, force: Array) -> Array:
        """Tangent of what a constant force on the child does: by the spin of the parent, and the link's own (9, 9)."""
        return self._part(change.geometric(force))

    def _part(self, matrix: Array) -> Array:
        """The symmetric part of a matrix where that is asked for."""
        return 0.5 * (matrix + rotation.transposed(matrix)) if self.symmetric else matrix

    def _in_chain(self, node: int, matrix: Array, moved: dict[int, Array]) -> Array:
        """That tangent in terms of the chain of the parent, whose spin it has."""
        above = self.jacobian(node, moved)[3:]
        width = above.shape[1]
        wide = zeros((9, width + 6, self.count), above)
        wide[:3, :width] = above
        wide[range(3, 9), range(width, width + 6)] = 1.0
        return times(rotation.transposed(wide), times(matrix, wide))

    def _closing(
        self, state: DisplacedState, number: int, nodal: tuple[Array, Array]
    ) -> tuple[Array, Array, Array, Array]:
        """Tangent (18, 18, m) of a loop's edge by both nodes and its multipliers, its force, gap and energy."""
        loop = self.model.loops[number]
        change = LoopChange(*self.loop(state, number))
        place = len(self.model.joints) + number
        stored, force, resistance = self.resistance(state, place, change.own)
        force = force + state.own[:, place]
        rows = change.jacobian
        ends = contracted("ji...,j...->i...", rows, force)
        for forces in nodal:
            forces[:, loop.child] += ends[6:]
            if loop.parent != GROUND:
                forces[:, loop.parent] += ends[:6]
        out = zeros((18, 18, self.count), force, rows)
        stiffness = times(rotation.transposed(rows), times(resistance + 0.0 * force[0], rows))
        out[:12, :12] = stiffness + self._part(change.geometric(force))
        out[12:, :12], out[:12, 12:] = rows, rotation.transposed(rows)
        return out, force, change.own - self.factor * loop.offset.at(self.where), stored

    def _loop_tangent(self, number: int, matrix: Array, jacobians: dict[int, Array]) -> Array:
        """A loop's tangent in the terms of its nodes' chains."""
        loop = self.model.loops[number]
        for _ in range(2):
            parts = [] if loop.parent == GROUND else [(loop.parent, matrix[:6])]
            parts.append((loop.child, matrix[6:12]))
            up = [times(rotation.transposed(self.jacobian(node, jacobians)), rows) for node, rows in parts]
            matrix = rotation.transposed(np.concatenate([*up, matrix[12:]]))
        return matrix


def motion_of(ends: NDArray[np.int64], pieces: Pieces, state: DisplacedState) -> CorotatedPieces:
    """Frames and deformations of the pieces of a stack between the nodes `ends` (n, 2)."""
    first, second = ends.T
    displacements = state.displacements[:, first], state.displacements[:, second]
    return corotation.motion(pieces, displacements, (state.rotations[:, first], state.rotations[:, second]))
