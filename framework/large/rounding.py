"""Rounding in the forces of an equilibrium, and in the tangent that holds them."""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array, merged
from ..elementwise import contracted
from ..structure.edge import GROUND
from . import corotation
from .equations import EquilibriumEquations
from .loops import LoopChange
from .response import Response
from .state import DisplacedState, SpatialLinearisation

# Roundings in a deformation, in units of the displacements and rotations that it is the difference of.
_ROUNDINGS = 16.0
_EPS = float(np.finfo(np.float64).eps)


class ForceRounding:
    """Rounding in what is unbalanced at some entries.

    Parameters
    ----------
    equations, state
        The entries and where they are, in space.
    at
        Forces and tangent there.
    """

    def __init__(self, equations: EquilibriumEquations, state: DisplacedState, at: SpatialLinearisation) -> None:
        self.model, self.equations, self.state, self.at = equations.model, equations, state, at

    def tangents(self) -> Array:
        """Rounding in the diagonal of the tangent, of the unknowns (free, m): of forces that turn with the members.

        The force in a stiff member is rounded in units of its stiffness, which may be far above what resists the
        softest motion; where it turns, it resists across itself.
        """
        free = self.model.free
        if any(joint.clearance_directions for joint in self.model.edges):
            # forces far below the rounding of others close a clearance, and are told apart by these alone
            return np.zeros((free, self.equations.count))
        return np.asarray((self.forces(all_round=True) * self.equations.scale)[:free])

    def forces(self, *, all_round: bool = False) -> Array:
        """Rounding in the unbalanced forces (size, m); where `all_round`, as if they acted in all directions."""
        model, count = self.model, self.equations.count
        nodal = np.zeros((6 * model.count, count))
        angle = np.abs(rotation.logarithm(self.state.rotations))
        arms = self._arms()
        for k, (stack, pieces) in enumerate(zip(model.stacks, self.equations.pieces, strict=True)):
            at = self.equations.motions(self.state)[k]
            first, second = stack.ends.T
            distance = np.sqrt(
                ((self.state.displacements[:, second] - self.state.displacements[:, first]) ** 2).sum(axis=0)
            )
            distance = distance + arms[first] + arms[second]
            rotations = (angle[:, first] + angle[:, second]).sum(axis=0) + distance / pieces.length
            off = np.concatenate([distance[None], np.repeat(rotations[None], 6, axis=0)])
            stiffness = np.abs(corotation.stiffness(pieces, at.deformation, self.at.stresses[k][0]))
            wrong = rotation.times(stiffness, off) + np.abs(self.at.stresses[k])
            change = np.abs(Response(pieces, at).global_change())
            ends = contracted("ji...,j...->i...", change, wrong)
            nodal += model.gather[k] @ merged(ends, 0, 1)
        forces = _ROUNDINGS * _EPS * (nodal.reshape(6, model.count, count) + np.abs(self.equations.loads))
        out = np.zeros((model.size + 1, count))
        for number in range(len(model.edges)):
            self._add_edge(number, forces, out)
        if all_round:
            out[:] = 0.0  # what springs lack resists along themselves, and turns nothing
            forces[:3], forces[3:] = (np.sqrt((part * part).sum(axis=0)) for part in (forces[:3], forces[3:]))
        for joint in reversed(model.joints):
            jacobian = np.abs(self.at.jacobians[joint.child])
            chain = model.chains[joint.child]
            # the chain of a node holds those of its parents, so that nothing need be handed up
            np.add.at(out, chain, contracted("ijm,im->jm", jacobian, forces[:, joint.child]))
        plain = np.flatnonzero(model.plain)
        np.add.at(out, model.columns[:, plain].T.reshape(-1), merged(forces[:, plain].swapaxes(0, 1), 0, 1))
        return out[:-1]

    def _arms(self) -> Array:
        """Size of what displacements of nodes below others in the tree are the sum of (nodes, m); zero for others."""
        state, out = self.state, np.zeros((self.model.count, self.equations.count))
        for number, joint in enumerate(self.model.joints):
            out[joint.child] = np.abs(state.own[:3, number]).sum(axis=0)
            if joint.parent != GROUND:
                out[joint.child] += out[joint.parent] + np.abs(state.displacements[:, joint.parent]).sum(axis=0)
        return out

    def _add_edge(self, number: int, nodal: Array, out: Array) -> None:
        """Rounding in the force of a link, on its coordinates, or of a loop, on its nodes and multipliers."""
        model, equations, state = self.model, self.equations, self.state
        joint, loop = model.edges[number], number - len(model.joints)
        own = equations.own(state, number)
        distance = np.abs(own) + np.abs(joint.offset.at(equations.where))
        distance[list(joint.clearance_directions)] += joint.clearance.at(equations.where)
        if loop >= 0:
            distance = distance + self._apart(loop)
        tangent = np.abs(equations.resistance(state, number, own)[2])
        wrong = _ROUNDINGS * _EPS * rotation.times(tangent + 0.0 * distance[0], distance)
        if loop < 0:
            np.add.at(out, model.columns[:, joint.child], wrong)
            return
        ends = rotation.times(rotation.transposed(np.abs(LoopChange(*equations.loop(state, loop)).jacobian())), wrong)
        nodal[:, joint.child] += ends[6:]
        if joint.parent != GROUND:
            nodal[:, joint.parent] += ends[:6]
        np.add.at(out, model.multipliers[:, loop], _ROUNDINGS * _EPS * distance)

    def _apart(self, loop: int) -> Array:
        """Size of the displacements (6, m) of which that in a loop is the difference."""
        link, displacements, rotations = self.equations.loop(self.state, loop)
        shift = np.abs(displacements[0]).max(axis=0) + np.abs(displacements[1]).max(axis=0)
        if link.arm is not None:
            shift = shift + np.abs(link.arm).max(axis=0)
        angle = sum(np.abs(rotation.logarithm(each)).max(axis=0) for each in rotations)
        return np.concatenate([np.repeat(shift[None], 3, axis=0), np.repeat(np.asarray(angle)[None], 3, axis=0)])
