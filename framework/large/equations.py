"""Equilibrium of some batch entries: energy, unbalanced forces and tangent at a state."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..tree import GROUND
from . import corotation, rotation
from .corotation import Motion, Pieces, Response
from .joints import Joint
from .links import Link, LinkChange
from .loops import LoopChange, displacement
from .model import Model
from .numbers import Numbers, Where
from .rotation import cross, dot, spin, times


@dataclass
class State:
    """Where a frame is at m entries: displacements (3, nodes, m), quaternions (4, nodes, m), own displacements of the
    tree's links and then forces in the ideal components of loops (6, links + loops, m)."""

    moved: Array
    turned: Array
    own: Array

    @classmethod
    def start(cls, model: Model, count: int) -> State:
        """At rest."""
        turned = np.zeros((4, model.count, count))
        turned[0] = 1.0
        own = np.zeros((6, len(model.joints) + len(model.loops), count))
        return cls(np.zeros((3, model.count, count)), turned, own)

    def taken(self, kept: NDArray[np.bool_] | NDArray[np.int64]) -> State:
        """Some of the entries."""
        return State(self.moved[..., kept], self.turned[..., kept], self.own[..., kept])

    def put(self, where: NDArray[np.bool_] | NDArray[np.int64], other: State) -> None:
        """Replace some of the entries."""
        self.moved[..., where], self.turned[..., where], self.own[..., where] = other.moved, other.turned, other.own


@dataclass(frozen=True)
class SpaceLinear:
    """What one iteration knows.

    Attributes
    ----------
    forces
        Unbalanced force on all coordinates, unknown and driven (size, m): inner less outer.
    values
        Tangent on the pattern of `Equations.pattern`.
    changes
        By stack, deformations by the ends' displacements and spins (7, 12, n, m).
    deformations
        By stack, the deformations (7, n, m).
    stresses
        By stack, the true forces on the deformations.
    jacobians
        By node that hangs on others, its displacement and spin by the coordinates of its chain (6, chain, m).
    energy
        Twice the strain energy, in members and joints (m,).
    nodal
        Force that holds each node with all that hangs on it (6, nodes, m).
    own
        Force of members and loads on the links' own coordinates (6, links, m).
    """

    forces: Array
    values: Array
    changes: list[Array]
    deformations: list[Array]
    stresses: list[Array]
    jacobians: dict[int, Array]
    energy: Array
    nodal: Array
    own: Array


class Equations:
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
    def links(self) -> list[Link]:
        """Links of the tree."""
        return [joint.at(self.where) for joint in self.model.joints]

    @cached_property
    def loads(self) -> Array:
        """Forces and moments on nodes (6, nodes, m or 1)."""
        return self.factor * self.model.loads.nodal.at(self.where)

    @cached_property
    def targets(self) -> Array:
        """Values that the driven coordinates are to have (driven, m)."""
        out = np.zeros((len(self.model.driven), self.count))
        for row, key in enumerate(self.model.driven):
            out[row] = self.factor * self.model.targets[key].at(self.where)
        return out

    # -- motion -----------------------------------------------------------------------------------------------------

    def lag(self, state: State) -> Array:
        """What the driven coordinates lack of their targets (driven, m)."""
        out = self.targets.copy()
        for row, (node, k) in enumerate(self.model.driven):
            out[row] -= state.moved[k, node] if self.model.plain[node] else state.own[k, self._link[node]]
        return out

    def advanced(self, state: State, step: Array) -> State:
        """The state after a step of the coordinates (size, m)."""
        model = self.model
        nodal = self._nodal(step)
        plain = model.plain
        moved, turned, own = state.moved.copy(), state.turned.copy(), state.own.copy()
        moved[:, plain] += nodal[:3, plain]
        turned[:, plain] = rotation.normalised(
            rotation.product(rotation.exponential(nodal[3:, plain]), state.turned[:, plain])
        )
        for number, joint in enumerate(model.joints):
            own[:, number] += nodal[:, joint.child]
        if model.loops:
            own[:, len(model.joints) :] += np.concatenate([step, np.zeros_like(step[:1])])[model.multipliers]
        new = State(moved, turned, own)
        self.follow(new)
        return new

    def follow(self, state: State) -> None:
        """Place the nodes that hang on others."""
        for number, (joint, link) in enumerate(zip(self.model.joints, self.links, strict=True)):
            place, turn = self._at(state, joint.parent)
            own = state.own[:, number]
            state.moved[:, joint.child], state.turned[:, joint.child] = link.child(place, turn, own)

    def _at(self, state: State, node: int) -> tuple[Array, Array]:
        if node != GROUND:
            return state.moved[:, node], state.turned[:, node]
        still = np.zeros((4, self.count))
        still[0] = 1.0
        return np.zeros((3, self.count)), still

    def _nodal(self, step: Array) -> Array:
        """Steps of the coordinates by node (6, nodes, m)."""
        padded = np.concatenate([step, np.zeros_like(step[:1])])
        return padded[self.model.columns]

    @cached_property
    def _link(self) -> dict[int, int]:
        return {joint.child: number for number, joint in enumerate(self.model.joints)}

    # -- energy -----------------------------------------------------------------------------------------------------

    def energy(self, state: State) -> Array:
        """Strain energy less the work of forces (m,); moments apart, see `moment_work`."""
        motions = self.motions(state)
        return self.strain_energy(state, motions) - self._work(state, motions)

    def strain_energy(self, state: State, motions: list[Motion] | None = None) -> Array:
        """Energy in members and joints (m,)."""
        total = np.zeros(self.count)
        for pieces, motion in zip(self.pieces, motions or self.motions(state), strict=True):
            total += corotation.strain_energy(pieces, motion).sum(axis=0)
        for number, joint in enumerate(self.model.joints):
            total += self._resistance(joint, state.own[:, number])[0]
        for number, loop in enumerate(self.model.loops):
            total += self._resistance(loop, self.loop_displacement(state, number))[0]
        return total

    def loop_displacement(self, state: State, number: int) -> Array:
        """Displacement (6, m) in an edge that closes a loop."""
        return displacement(*self._loop(state, number))

    def _loop(self, state: State, number: int) -> tuple[Link, tuple[Array, Array], tuple[Array, Array]]:
        loop = self.model.loops[number]
        (first, turn), (second, other) = self._at(state, loop.parent), self._at(state, loop.child)
        return loop.at(self.where), (first, second), (turn, other)

    def work(self, old: State, new: State, share: float) -> Array:
        """Work done on the frame between two equilibria (m,), by the trapezoidal rule.

        `share` is the factor of the old one over that of the new one.
        """
        moved = self._work(new, self.motions(new)) - self._work(old, self.motions(old)) + self.moment_work(old, new)
        total: Array = 0.5 * (1.0 + share) * moved
        before = Equations(self.model, self.where, self.count, share * self.factor)
        forces = [part.linearised(state).forces for part, state in ((before, old), (self, new))]
        driven = slice(self.model.free, None)
        mean = 0.5 * (forces[0][driven] + forces[1][driven])
        total += np.einsum("im,im->m", mean, (1.0 - share) * self.targets)
        for number, joint in enumerate(self.model.joints):
            pulls = [part._resistance(joint, s.own[:, number])[1] for part, s in ((before, old), (self, new))]
            offset = (1.0 - share) * self.factor * joint.offset.at(self.where)
            total -= 0.5 * dot(pulls[0] + pulls[1], offset + np.zeros_like(pulls[0]))
        return total

    def _work(self, state: State, motions: list[Motion]) -> Array:
        loads = np.broadcast_to(self.loads[:3], state.moved.shape)
        total: Array = np.einsum("ij...,ij...->...", loads, state.moved)
        for pieces, motion in zip(self.pieces, motions, strict=True):
            total = total + corotation.work(pieces, motion).sum(axis=0)
        for node, push, arm in self._hung:
            total = total + dot(push, rotation.rotated(state.turned[:, node], arm + np.zeros_like(state.moved[:, 0])))
        return total

    def motions(self, state: State) -> list[Motion]:
        """Frames and deformations of all pieces."""
        pairs = zip(self.model.stacks, self.pieces, strict=True)
        return [_motion(stack.ends, pieces, state) for stack, pieces in pairs]

    def moment_work(self, old: State, new: State) -> Array:
        """Work of the moments on the way from one state to another (m,)."""
        total = np.zeros(self.count)
        for node in self._twisted:
            turn = rotation.product(new.turned[:, node], rotation.conjugate(old.turned[:, node]))
            total += dot(self.loads[3:, node] + 0.0 * turn[1:], rotation.logarithm(turn))
        return total

    @cached_property
    def _twisted(self) -> list[int]:
        return [node for node in range(self.model.count) if np.any(self.loads[3:, node])]

    @cached_property
    def _hung(self) -> list[tuple[int, Array, Array]]:
        """Weights on arms: node, force and arm at rest (3, m or 1)."""
        ndim, given = self.model.ndim, self.model.loads.hung
        forces = [self.factor * Numbers.of(hung.force, ndim, 1).at(self.where) for hung in given]
        arms = [Numbers.of(hung.arm, ndim, 1).at(self.where) for hung in given]
        return [(hung.node, force, arm) for hung, force, arm in zip(given, forces, arms, strict=True)]

    def _resistance(self, joint: Joint, own: Array) -> tuple[Array, Array, Array]:
        """Energy (m,), force (6, m) and tangent (6, 6, m) of a link's springs."""
        beyond = own - self.factor * joint.offset.at(self.where)
        if joint.law is not None:
            energy, force, tangent = joint.law.resistance(beyond.T, self._pick)
            return energy, force.T, np.moveaxis(tangent, 0, -1)
        stiffness = joint.stiffness.at(self.where)
        tangent = np.zeros((6, 6, stiffness.shape[-1]))
        tangent[range(6), range(6)] = stiffness
        return 0.5 * dot(stiffness * beyond, beyond), stiffness * beyond, tangent

    def _pick(self, array: Array, trailing: int) -> Array:
        return np.moveaxis(Numbers.of(array, self.model.ndim, trailing).at(self.where), -1, 0)

    # -- derivatives ------------------------------------------------------------------------------------------------

    def linearised(self, state: State, stresses: list[Array] | None = None) -> SpaceLinear:
        """Forces and tangent; the geometric stiffness of members is that of `stresses`, or of the true ones."""
        model = self.model
        nodal: Array = -np.broadcast_to(self.loads, (6, model.count, self.count)).reshape(-1, self.count)
        assumed = nodal.copy()
        changes, deformations, true, data = [], [], [], []
        energy = np.zeros(self.count)
        jacobians = self._jacobians(state)
        for k, (stack, pieces) in enumerate(zip(model.stacks, self.pieces, strict=True)):
            response = Response(pieces, _motion(stack.ends, pieces, state))
            exact = corotation.stress(pieces, response.at.deformation)
            used = exact if stresses is None else stresses[k]
            ends = response.forces(exact)
            nodal = nodal + model.gather[k] @ ends.reshape(-1, self.count)
            if stresses is not None:
                ends = response.forces(used)
            assumed = assumed + model.gather[k] @ ends.reshape(-1, self.count)
            changes.append(response.global_change())
            deformations.append(response.at.deformation)
            true.append(exact)
            energy = energy + 2.0 * corotation.strain_energy(pieces, response.at).sum(axis=0)
            data += self._linked_tangent(k, response.tangent(used), jacobians)
        shape = (6, model.count, self.count)
        nodal, assumed = np.array(nodal.reshape(shape)), np.array(assumed.reshape(shape))
        data += self._hung_tangent(state, nodal, assumed, jacobians)
        closing = [self._closing(state, number, (nodal, assumed)) for number in range(len(model.loops))]
        data += self._link_tangent(state, assumed, jacobians)
        data += [self._in_chains(number, matrix, jacobians) for number, (matrix, *_) in enumerate(closing)]
        forces, own = self._reduced(state, nodal)
        for number, (_, force, gap, stored) in enumerate(closing):
            held = model.multipliers[:, number]
            forces[held[held >= 0]] = gap[held >= 0]
            own = np.concatenate([own, -force[:, None]], axis=1)
            energy = energy + 2.0 * stored
        values = self.model.pattern[0] @ np.concatenate([block.reshape(-1, self.count) for block in data])
        for number, joint in enumerate(model.joints):
            energy = energy + 2.0 * self._resistance(joint, state.own[:, number])[0]
        return SpaceLinear(forces, values, changes, deformations, true, jacobians, energy, nodal, own)

    def step_stresses(self, at: SpaceLinear, step: Array) -> list[Array]:
        """Forces on the deformations after a step, predicted by the linear change of the deformations."""
        nodal = self._nodal(step)
        padded = np.concatenate([step, np.zeros_like(step[:1])])
        for node, jacobian in at.jacobians.items():
            nodal[:, node] = np.einsum("ij...,j...->i...", jacobian, padded[self.model.chains[node]])
        out = []
        for k, stack in enumerate(self.model.stacks):
            ends = np.concatenate([nodal[:, stack.ends[:, 0]], nodal[:, stack.ends[:, 1]]])
            change = times(at.changes[k], ends)
            stiffness = corotation.stiffness(self.pieces[k], at.deformations[k], at.stresses[k][0])
            out.append(at.stresses[k] + times(stiffness, change))
        return out

    def _changes(self, state: State) -> list[LinkChange]:
        out = []
        for number, (joint, link) in enumerate(zip(self.model.joints, self.links, strict=True)):
            first = self._at(state, joint.parent)[1] if joint.forward else state.turned[:, joint.child]
            out.append(LinkChange(link, first, state.own[:, number]))
        return out

    def _jacobians(self, state: State) -> dict[int, Array]:
        """For nodes that hang on others, displacement and spin by the coordinates of their chain (6, chain, m)."""
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

    def _hung_tangent(self, state: State, nodal: Array, assumed: Array, jacobians: dict[int, Array]) -> list[Array]:
        """Moments of weights on arms, added to the nodal forces, and their tangents."""
        out = []
        for node, push, arm in self._hung:
            lever = arm + rotation.rotated(state.turned[:, node], arm + np.zeros_like(state.moved[:, 0]))
            push = push + np.zeros_like(lever)
            for forces in (nodal, assumed):
                forces[3:, node] -= cross(lever, push)
            turn = self._jacobian(node, jacobians)[3:]
            out.append(times(rotation.transposed(turn), times(-times(spin(push), spin(lever)), turn)))
        return out

    def _link_tangent(self, state: State, nodal: Array, jacobians: dict[int, Array]) -> list[Array]:
        """Springs of the links, and what turning them does to the forces that they pass on; leaves first."""
        out: list[Array] = []
        joints = self.model.joints
        for number in range(len(joints) - 1, -1, -1):
            joint, change = joints[number], self._now[number]
            force = nodal[:, joint.child]
            matrix = change.geometric(force)
            matrix[3:, 3:] += self._resistance(joint, state.own[:, number])[2]
            if joint.parent == GROUND:
                out.insert(0, matrix[3:, 3:])
            else:
                nodal[:, joint.parent] += change.forces(force)[0]
                above = self._jacobian(joint.parent, jacobians)[3:]
                width = above.shape[1]
                wide = np.zeros((9, width + 6, self.count))
                wide[:3, :width] = above
                wide[range(3, 9), range(width, width + 6)] = 1.0
                out.insert(0, times(rotation.transposed(wide), times(matrix, wide)))
        return out

    def _closing(self, state: State, number: int, nodal: tuple[Array, Array]) -> tuple[Array, Array, Array, Array]:
        """Tangent (18, 18, m) of a loop's edge by both nodes and its multipliers, its force, gap and energy."""
        loop = self.model.loops[number]
        change = LoopChange(*self._loop(state, number))
        stored, force, resistance = self._resistance(loop, change.own)
        force = force + state.own[:, len(self.model.joints) + number]
        rows = change.jacobian()
        ends = np.einsum("ji...,j...->i...", rows, force)
        for forces in nodal:
            forces[:, loop.child] += ends[6:]
            if loop.parent != GROUND:
                forces[:, loop.parent] += ends[:6]
        out = np.zeros((18, 18, self.count))
        out[:12, :12] = times(rotation.transposed(rows), times(resistance + 0.0 * force[0], rows)) + change.geometric(
            force
        )
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

    def _reduced(self, state: State, nodal: Array) -> tuple[Array, Array]:
        """Forces on the coordinates from forces on the nodes, leaves first; and those of members and loads alone."""
        model = self.model
        out = np.zeros((model.size + 1, self.count))
        carried = np.zeros((6, len(model.joints), self.count))
        for number in range(len(model.joints) - 1, -1, -1):
            joint = model.joints[number]
            above, own = self._now[number].forces(nodal[:, joint.child])
            carried[:, number] = own
            own = own + self._resistance(joint, state.own[:, number])[1]
            out[model.columns[:, joint.child]] = own
            if joint.parent != GROUND:
                nodal[:, joint.parent] += above
        plain = model.plain
        out[model.columns[:, plain]] = nodal[:, plain]
        return out[:-1], carried


def _motion(ends: NDArray[np.int64], pieces: Pieces, state: State) -> Motion:
    first, second = ends.T
    moved = state.moved[:, first], state.moved[:, second]
    return corotation.motion(pieces, moved, (state.turned[:, first], state.turned[:, second]))
