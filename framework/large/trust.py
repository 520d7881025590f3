"""What is left of the error of an equilibrium: unbalanced forces, and the rounding in them, through the tangent."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from . import corotation, rotation
from .corotation import Response
from .elimination import ConstrainedFactor, Elimination, Factor
from .equations import Equations
from .model import Model
from .newton import Newton
from .state import State

# Roundings in a deformation, in units of the displacements and rotations that it is the difference of.
_ROUNDINGS = 16.0
_EPS = float(np.finfo(np.float64).eps)


class Trust:
    """Bounds on the numerical error, of first order, at all entries.

    Parameters
    ----------
    newton
        Iterations on the model.
    equations, state
        The whole batch and where it is, in space.
    """

    def __init__(self, newton: Newton, equations: Equations, state: State) -> None:
        self.model: Model = equations.model
        self.equations, self.state = equations, state
        self.at = equations.linearised(state)
        _, rows, columns = self.model.pattern
        elimination = Elimination(rows, columns, self.model.free)
        if newton.held:
            self.factor: Factor = ConstrainedFactor(elimination.dense(self.at.values), newton.held)
        else:
            self.factor = elimination.factor(self.at.values, symmetric=self.model.symmetric)
        self.wrong = np.abs(self.at.forces) + self._rounding()

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
            out[k] = np.einsum("im,im->m", np.abs(self.factor.solve(load)), self.wrong[: self.model.free])
        size = np.concatenate([self.state.moved[:, node], rotation.logarithm(self.state.turned[:, node])])
        return np.asarray(out + 2.0 * _EPS * np.abs(size))

    def _gripped(self) -> Array:
        """Forces (size + 1, m) that put journals in rigid contact as far off as their place is rounded."""
        model, count = self.model, self.equations.count
        out = np.zeros((model.size + 1, count))
        for number, place in model.contacts.items():
            joint = model.edges[number]
            play = list(joint.play)
            stiffness = self.state.grip.stiffness[place]
            if number < len(model.joints):
                reach = np.abs(self.state.own[play, number]).max(axis=0) + joint.clearance.at(self.equations.where)
                np.add.at(out, model.columns[play, joint.child], _ROUNDINGS * _EPS * stiffness * reach)
        return out

    def _rounding(self) -> Array:
        """Rounding in the unbalanced forces (size, m)."""
        model, count = self.model, self.equations.count
        nodal = np.zeros((6 * model.count, count))
        angle = np.abs(rotation.logarithm(self.state.turned))
        for k, (stack, pieces) in enumerate(zip(model.stacks, self.equations.pieces, strict=True)):
            at = self.equations.motions(self.state)[k]
            first, second = stack.ends.T
            apart = np.sqrt(((self.state.moved[:, second] - self.state.moved[:, first]) ** 2).sum(axis=0))
            turned = (angle[:, first] + angle[:, second]).sum(axis=0) + apart / pieces.length
            off = np.concatenate([apart[None], np.repeat(turned[None], 6, axis=0)])
            stiffness = np.abs(corotation.stiffness(pieces, at.deformation, self.at.stresses[k][0]))
            wrong = rotation.times(stiffness, off) + np.abs(self.at.stresses[k])
            change = np.abs(Response(pieces, at).global_change())
            ends = np.einsum("ji...,j...->i...", change, wrong)
            nodal += model.gather[k] @ ends.reshape(-1, count)
        forces = _ROUNDINGS * _EPS * (nodal.reshape(6, model.count, count) + np.abs(self.equations.loads))
        out = self._gripped()
        for joint in reversed(model.joints):
            jacobian = np.abs(self.at.jacobians[joint.child])
            chain = model.chains[joint.child]
            # the chain of a node holds those of its parents, so that nothing need be handed up
            np.add.at(out, chain, np.einsum("ijm,im->jm", jacobian, forces[:, joint.child]))
        plain = np.flatnonzero(model.plain)
        np.add.at(out, model.columns[:, plain].T.reshape(-1), forces[:, plain].swapaxes(0, 1).reshape(-1, count))
        return out[:-1]
