"""What is left of the error of an equilibrium: unbalanced forces, and the rounding in them, through the tangent."""

from __future__ import annotations

import numpy as np

from .. import rotation
from ..batch import Array, merged
from ..elementwise import contracted
from ..structure.edge import GROUND
from . import corotation
from .elimination import LARGE, ConstrainedFactor, StackFactor, SymbolicFactorisation
from .equations import EquilibriumEquations
from .loops import LoopChange
from .model import Model
from .newton import Newton
from .protocols import Index, Mask
from .response import Response
from .state import DisplacedState

# Roundings in a deformation, in units of the displacements and rotations that it is the difference of.
_ROUNDINGS = 16.0
# Share of a free motion below which a displacement takes no part in it.
_STILL = 1e-6
_EPS = float(np.finfo(np.float64).eps)


class SingularTangents:
    """Tangents of which some eigenvalues are rounding.

    Parameters
    ----------
    elimination
        Their pattern.
    values
        The tangents (entries, m).
    zero
        Eigenvalue that is rounding.
    """

    def __init__(self, elimination: SymbolicFactorisation, values: Array, zero: float) -> None:
        self.root, self.values, self.vectors = elimination.spectrum(values)
        # the least is, as no factor told it from rounding
        self.free = np.abs(self.values) <= np.maximum(zero, np.abs(self.values).min(axis=1, keepdims=True))

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, m), free motions left out."""
        share = np.where(self.free, 0.0, self._share(load) / np.where(self.free, 1.0, self.values))
        return np.asarray(np.einsum("mij,mj,mi->im", self.vectors, share, self.root))

    def moves(self, load: Array) -> Mask:
        """Whether a load does work on a free motion (m,)."""
        share = np.abs(self._share(load))
        size = np.sqrt((share * share).sum(axis=1, keepdims=True))
        return np.asarray((self.free & (share > _STILL * size)).any(axis=1))

    def _share(self, load: Array) -> Array:
        out: Array = np.einsum("mji,mj,jm->mi", self.vectors, self.root, load)
        return out


class Trust:
    """Bounds on the numerical error, of first order, at all entries.

    Parameters
    ----------
    newton
        Iterations on the model.
    equations, state
        The whole batch and where it is, in space.
    neutral
        Entries at which some motion is free (m,).
    """

    def __init__(
        self, newton: Newton, equations: EquilibriumEquations, state: DisplacedState, neutral: Mask | None = None
    ) -> None:
        self.model: Model = equations.model
        self.equations, self.state = equations, state
        self.at = equations.linearised(state)
        _, rows, columns = self.model.pattern
        elimination = SymbolicFactorisation(rows, columns, self.model.free)
        if newton.multiplier_count:
            self.factor: StackFactor = ConstrainedFactor(elimination.dense(self.at.values), newton.multiplier_count)
        else:
            self.factor = elimination.factor(self.at.values, symmetric=self.model.symmetric)
        self.wrong = np.abs(self.at.forces) + self._rounding()
        some = np.zeros(0, dtype=np.int64) if neutral is None else np.flatnonzero(neutral)
        self.neutral: Index = some
        if len(some) and self.model.free <= LARGE and not newton.multiplier_count:
            self.free_motion: SingularTangents | None = SingularTangents(
                elimination, self.at.values[:, some], newton.free
            )
        else:
            self.free_motion = None

    def bound(self, node: int) -> Array:
        """Bound on displacement and spin of a node (6, m): what the wrong forces do at their worst."""
        chain = np.array(self.model.chains[node])
        jacobian = self.at.jacobians.get(node)
        rows = np.broadcast_to(np.eye(6)[..., None], (6, 6, self.equations.count)) if jacobian is None else jacobian
        out = np.zeros((6, self.equations.count))
        inside = np.flatnonzero((chain >= 0) & (chain < self.model.free))
        for k in range(6):
            load = np.zeros((self.model.free, self.equations.count))
            load[chain[inside]] = rows[k, inside]
            worst = contracted("im,im->m", np.abs(self.factor.solve(load)), self.wrong[: self.model.free])
            out[k] = np.where(np.isnan(worst), np.inf, worst)  # nothing is known where something moves freely
            if len(self.neutral):
                out[k, self.neutral] = self._beside(load[:, self.neutral])
        size = np.concatenate([self.state.displacements[:, node], rotation.logarithm(self.state.rotations[:, node])])
        return np.asarray(out + 2.0 * _EPS * np.abs(size))

    def _beside(self, load: Array) -> Array:
        """The same for a displacement of neutral entries that is the work of `load` (free, n): inf where it is free."""
        if self.free_motion is None:
            return np.where(load.any(axis=0), np.inf, 0.0)
        wrong = self.wrong[: self.model.free, self.neutral]
        worst = contracted("im,im->m", np.abs(self.free_motion.solve(load)), wrong)
        return np.where(self.free_motion.moves(load), np.inf, worst)

    def _rounding(self) -> Array:
        """Rounding in the unbalanced forces (size, m)."""
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
