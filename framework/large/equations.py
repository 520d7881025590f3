"""Equilibrium of some batch entries: energy, unbalanced forces and tangent at a state."""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array, merged
from ..elementwise import added, contracted, zeros
from ..rotation import cross, dot, spin, times
from ..structure.edge import GROUND
from . import corotation
from .configuration import Configuration, motion_of
from .links import LinkChange
from .loops import LoopChange
from .numbers import summed
from .response import Response
from .state import DisplacedState, SpatialLinearisation


class EquilibriumEquations(Configuration):
    """A model at some entries, with the derivatives of its energy.

    Attributes
    ----------
    symmetric
        Whether tangents are the symmetric parts of what they are else, which they are themselves in an equilibrium
        under loads that have a potential.
    """

    symmetric = False

    def work(self, old: DisplacedState, new: DisplacedState, share: float) -> Array:
        """Work done on the frame between two equilibria (m,), by the trapezoidal rule.

        `share` is the factor of the old one over that of the new one.
        """
        work_of_loads = (
            self.load_work(new, self.motions(new)) - self.load_work(old, self.motions(old)) + self.moment_work(old, new)
        )
        total: Array = 0.5 * (1.0 + share) * work_of_loads
        before = EquilibriumEquations(self.model, self.where, self.count, share * self.factor)
        forces = [part.linearised(state, tangents=False).forces for part, state in ((before, old), (self, new))]
        prescribed = slice(self.model.free, None)
        mean = 0.5 * (forces[0][prescribed] + forces[1][prescribed])
        total += contracted("im,im->m", mean, (1.0 - share) * self.prescribed_values)
        for stack, pair in zip(self.model.stacks, zip(before.pieces, self.pieces, strict=True), strict=True):
            if stack.free is not None:
                ways = zip(pair, (old, new), strict=True)
                at = [corotation.strain_forces(part, motion_of(stack.ends, part, s).deformation) for part, s in ways]
                free = (1.0 - share) * self.factor * stack.free.at(self.where)
                total -= 0.5 * dot(at[0] + at[1], free + np.zeros_like(at[0])).sum(axis=0)
        for number, joint in enumerate(self.model.joints):
            generalised_forces = [
                part.resistance(s, number, s.own[:, number])[1] for part, s in ((before, old), (self, new))
            ]
            offset = (1.0 - share) * self.factor * joint.offset.at(self.where)
            total -= 0.5 * dot(
                generalised_forces[0] + generalised_forces[1], offset + np.zeros_like(generalised_forces[0])
            )
        return total

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
        jacobians = self._jacobians(state)
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
        if tangents:
            data += self._link_tangent(state, assumed, jacobians)
        data += [self._in_chains(number, matrix, jacobians) for number, (matrix, *_) in enumerate(closing)]
        forces, own = self._reduced(state, nodal)
        for number, (_, force, gap, stored) in enumerate(closing):
            constrained = model.multipliers[:, number]
            forces[constrained[constrained >= 0]] = gap[constrained >= 0]
            own = np.concatenate([own, -force[:, None]], axis=1)
            energy = energy + 2.0 * stored
        nothing = np.zeros((0, self.count))
        blocks = [nothing, *(merged(block, 0, -2) for block in data)]
        values = summed(self.model.pattern[0], np.concatenate(blocks)) if tangents else nothing
        for number in range(len(model.joints)):
            energy = energy + 2.0 * self.resistance(state, number, state.own[:, number])[0]
        return SpatialLinearisation(forces, values, responses, true, jacobians, energy, nodal, own)

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
        out = []
        for number, (joint, link) in enumerate(zip(self.model.joints, self.links, strict=True)):
            first = self.at(state, joint.parent)[1] if joint.forward else state.rotations[:, joint.child]
            out.append(LinkChange(link, first, state.own[:, number]))
        return out

    def _jacobians(self, state: DisplacedState) -> dict[int, Array]:
        """Displacement and spin of nodes below others in the tree, by the coordinates of their chain (6, chain, m)."""
        out: dict[int, Array] = {}
        self._now = self._changes(state)
        for joint, change in zip(self.model.joints, self._now, strict=True):
            local = change.jacobian()
            own = local[:, 6:]
            if joint.parent == GROUND:
                out[joint.child] = own
            else:
                above = out.get(joint.parent)
                carried = local[:, :6] if above is None else times(local[:, :6], above)
                out[joint.child] = np.concatenate([carried, own], axis=1)
        return out

    def _jacobian(self, node: int, jacobians: dict[int, Array]) -> Array:
        return jacobians[node] if node in jacobians else np.broadcast_to(np.eye(6)[..., None], (6, 6, self.count))

    def _linked_tangent(self, k: int, tangent: Array, jacobians: dict[int, Array]) -> list[Array]:
        """Tangents of a stack's pieces: those between plain nodes as they are, the others in their chains' terms."""
        linked = self.model.linked[k]
        out = [tangent[:, :, ~linked]] if not linked.all() else []
        for number in np.flatnonzero(linked):
            first, second = self.model.stacks[k].ends[number].tolist()
            a, b = self._jacobian(first, jacobians), self._jacobian(second, jacobians)
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
            turn = self._jacobian(node, jacobians)[3:]
            out.append(times(rotation.transposed(turn), times(-times(spin(push), spin(lever)), turn)))
        return out

    def _link_tangent(self, state: DisplacedState, nodal: Array, jacobians: dict[int, Array]) -> list[Array]:
        """Springs of the links, and what turning them does to the forces that they pass on; leaves first."""
        out: list[Array] = []
        joints = self.model.joints
        for number in range(len(joints) - 1, -1, -1):
            joint, change = joints[number], self._now[number]
            force = nodal[:, joint.child]
            matrix = change.geometric(force)
            matrix = 0.5 * (matrix + rotation.transposed(matrix)) if self.symmetric else matrix
            matrix[3:, 3:] += self.resistance(state, number, state.own[:, number])[2]
            if joint.parent == GROUND:
                out.insert(0, matrix[3:, 3:])
            else:
                nodal[:, joint.parent] += change.forces(force)[0]
                above = self._jacobian(joint.parent, jacobians)[3:]
                width = above.shape[1]
                wide = zeros((9, width + 6, self.count), above)
                wide[:3, :width] = above
                wide[range(3, 9), range(width, width + 6)] = 1.0
                out.insert(0, times(rotation.transposed(wide), times(matrix, wide)))
        return out

    def _closing(
        self, state: DisplacedState, number: int, nodal: tuple[Array, Array]
    ) -> tuple[Array, Array, Array, Array]:
        """Tangent (18, 18, m) of a loop's edge by both nodes and its multipliers, its force, gap and energy."""
        loop = self.model.loops[number]
        change = LoopChange(*self.loop(state, number))
        place = len(self.model.joints) + number
        stored, force, resistance = self.resistance(state, place, change.own)
        force = force + state.own[:, place]
        rows = change.jacobian()
        ends = contracted("ji...,j...->i...", rows, force)
        for forces in nodal:
            forces[:, loop.child] += ends[6:]
            if loop.parent != GROUND:
                forces[:, loop.parent] += ends[:6]
        out = zeros((18, 18, self.count), force, rows)
        geometric = change.geometric(force)
        geometric = 0.5 * (geometric + rotation.transposed(geometric)) if self.symmetric else geometric
        out[:12, :12] = times(rotation.transposed(rows), times(resistance + 0.0 * force[0], rows)) + geometric
        out[12:, :12], out[:12, 12:] = rows, rotation.transposed(rows)
        return out, force, change.own - self.factor * loop.offset.at(self.where), stored

    def _in_chains(self, number: int, matrix: Array, jacobians: dict[int, Array]) -> Array:
        """A loop's tangent in the terms of its nodes' chains."""
        loop = self.model.loops[number]
        for _ in range(2):
            parts = [] if loop.parent == GROUND else [(loop.parent, matrix[:6])]
            parts.append((loop.child, matrix[6:12]))
            up = [times(rotation.transposed(self._jacobian(node, jacobians)), rows) for node, rows in parts]
            matrix = rotation.transposed(np.concatenate([*up, matrix[12:]]))
        return matrix

    def _reduced(self, state: DisplacedState, nodal: Array) -> tuple[Array, Array]:
        """Forces on the coordinates from forces on the nodes, leaves first; and those of members and loads alone."""
        model = self.model
        out = zeros((model.size + 1, self.count), nodal)
        carried = zeros((6, len(model.joints), self.count), nodal)
        for number in range(len(model.joints) - 1, -1, -1):
            joint = model.joints[number]
            above, own = self._now[number].forces(nodal[:, joint.child])
            carried[:, number] = own
            own = own + self.resistance(state, number, state.own[:, number])[1]
            out[model.columns[:, joint.child]] = own
            if joint.parent != GROUND:
                nodal[:, joint.parent] += above
        plain = model.plain
        out[model.columns[:, plain]] = nodal[:, plain]
        return out[:-1], carried
