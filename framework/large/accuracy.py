"""What rounding leaves of an equilibrium: whether it is stable, and bounds on its displacements.

Forces in stiff members are small differences of large terms, and rounded in units of these. Such an error in a force
that turns with its member changes the stiffness across it; as an unbalanced force it moves the nodes.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from .. import rotation
from ..batch import Array, merged
from ..elementwise import contracted
from ..structure.edge import GROUND
from . import corotation
from .elimination import LARGE, SymbolicFactorisation
from .equations import EquilibriumEquations, SpatialLinearisation
from .links import LoopChange
from .model import Model
from .numbers import at_index
from .state import DisplacedState, Index, Mask

# Roundings in a deformation, in units of the displacements and rotations that it is the difference of.
_ROUNDINGS = 16.0
_EPS = float(np.finfo(np.float64).eps)
# Share of a free motion below which a displacement takes no part in it.
_STILL = 1e-6


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
        if self.model.has_clearance:
            # forces far below the rounding of others close a clearance, and decide there
            return np.zeros((free, self.equations.count))
        return np.asarray((self.forces(all_round=True) * self.equations.scale)[:free])

    def forces(self, *, all_round: bool = False) -> Array:
        """Rounding in the unbalanced forces (size, m); where `all_round`, as if they acted in all directions."""
        model, count = self.model, self.equations.count
        nodal = np.zeros((6 * model.count, count))
        angle = np.abs(rotation.logarithm(self.state.rotations))
        arms = self._arms()
        for k, (stack, pieces) in enumerate(zip(model.stacks, self.equations.pieces, strict=True)):
            response = self.at.responses[k]
            first, second = stack.ends.T
            distance = np.sqrt(
                ((self.state.displacements[:, second] - self.state.displacements[:, first]) ** 2).sum(axis=0)
            )
            distance = distance + arms[first] + arms[second]
            rotations = (angle[:, first] + angle[:, second]).sum(axis=0) + distance / pieces.length
            off = np.concatenate([distance[None], np.repeat(rotations[None], 6, axis=0)])
            stiffness = np.abs(corotation.stiffness(pieces, response.at.deformation, self.at.stresses[k][0]))
            wrong = rotation.times(stiffness, off) + np.abs(self.at.stresses[k])
            change = np.abs(response.global_change())
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
            # the chain of a node contains those of its parents, so that nothing is handed up
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
        ends = rotation.times(rotation.transposed(np.abs(LoopChange(*equations.loop(state, loop)).jacobian)), wrong)
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


def judged_in_space(model: Model, state: DisplacedState, parts: Iterable[Index]) -> tuple[Mask, Mask]:
    """Whether the tangent in space of a model kept to a plane has no negative eigenvalue beyond rounding, and whether
    it then has one that is rounding, (entries,) each.

    Parameters
    ----------
    model
        The model in its plane.
    state
        Where all entries are.
    parts
        Entries of the flattened batch, those that are looked at side by side; it is not so for those left out.
    """
    whole = Model(model.plan, in_plane=False, clearance=model.clearance)
    elimination = SymbolicFactorisation.of_model(whole)
    definite, neutral = np.zeros((2, len(model.present)), dtype=bool)
    for index in parts:
        where = model.where(index)
        there = in_space(whole, EquilibriumEquations(model, where, len(index)), state.taken(index))
        at = EquilibriumEquations(whole, where, len(index)).linearised(there)
        definite[index] = elimination.clearly_definite(at.values)
        unclear = np.flatnonzero(~definite[index])
        if len(unclear):
            some, place = at_index(where, unclear), there.taken(unclear)
            equations = EquilibriumEquations(whole, some, len(unclear))
            at = equations.linearised(place)
            sure = elimination.definite(at.values, ForceRounding(equations, place, at).tangents())
            definite[index[unclear]] = sure
            if whole.symmetric:
                neutral[index[unclear]] = sure & elimination.neutral(at.values)
    return definite, neutral


def in_space(model: Model, inside: EquilibriumEquations, state: DisplacedState) -> DisplacedState:
    """A state with the links and loops of `model`, which has more supports: those against motion out of the plane."""
    planar_model = inside.model
    place = {joint.edge: number for number, joint in enumerate(planar_model.edges)}
    forces = inside.linearised(state, tangents=False).own
    own = np.zeros((6, len(model.edges), inside.count))
    for number, joint in enumerate(model.edges):
        known, links = place.get(joint.edge), len(model.joints)
        if number >= links and known is not None:
            constrained = model.multipliers[:, number - links] >= 0
            own[constrained, number] = -forces[constrained, known]
        elif number < links and known is not None:
            own[:, number] = joint.shortest(inside.own(state, known))
        elif number < links:
            own[:, number] = state.moved(joint.child)
    those = [planar_model.contacts[place[model.edges[number].edge]] for number in model.contacts]
    contacts = state.contact_force[:, those], state.contact_stiffness[those]
    return DisplacedState(state.displacements, state.rotations, own, *contacts)


class ErrorBounds:
    """Bounds on the numerical error of displacements, of first order, at all entries.

    Parameters
    ----------
    equations, state
        The whole batch and where it is, in space.
    neutral
        Entries at which some motion is free (m,).
    """

    def __init__(self, equations: EquilibriumEquations, state: DisplacedState, neutral: Mask) -> None:
        self.model, self.equations, self.state = equations.model, equations, state
        self.at = equations.linearised(state)
        elimination = SymbolicFactorisation.of_model(self.model)
        self.factor = elimination.factor(self.at.values, symmetric=self.model.symmetric)
        self.wrong = np.abs(self.at.forces) + ForceRounding(equations, state, self.at).forces()
        self.neutral: Index = np.flatnonzero(neutral)
        self.known = self.model.free <= LARGE and not self.model.constraints
        if len(self.neutral) and self.known:
            self.spectrum = elimination.spectrum(self.at.values[:, self.neutral])
            size = np.abs(self.spectrum.values)
            # the least counts as free, as no factor could tell it from rounding
            self.free: Mask = np.asarray(size <= np.maximum(elimination.free, size.min(axis=1, keepdims=True)))

    def bound(self, node: int) -> Array:
        """Bound on displacement and spin of a node (6, m): what the wrong forces do at their worst."""
        chain = np.array(self.model.chains[node])
        rows = self.equations.jacobian(node, self.at.jacobians)
        out = np.zeros((6, self.equations.count))
        inside = np.flatnonzero((chain >= 0) & (chain < self.model.free))
        for k in range(6):
            load = np.zeros((self.model.free, self.equations.count))
            load[chain[inside]] = rows[k, inside]
            worst = contracted("im,im->m", np.abs(self.factor.solve(load)), self.wrong[: self.model.free])
            out[k] = np.where(np.isnan(worst), np.inf, worst)  # nothing is known where something moves freely
            if len(self.neutral):
                out[k, self.neutral] = self._beside(load[:, self.neutral])
        return np.asarray(out + 2.0 * _EPS * np.abs(self.state.moved(node)))

    def _beside(self, load: Array) -> Array:
        """The same for a displacement of neutral entries that is the work of `load` (free, n): inf where it is free."""
        if not self.known:
            return np.where(load.any(axis=0), np.inf, 0.0)
        wrong = self.wrong[: self.model.free, self.neutral]
        worst = contracted("im,im->m", np.abs(self.spectrum.solve(load, self.free)), wrong)
        share = np.abs(self.spectrum.share(load))
        size = np.sqrt((share * share).sum(axis=1, keepdims=True))
        return np.where((self.free & (share > _STILL * size)).any(axis=1), np.inf, worst)


def bounds_in_space(model: Model, state: DisplacedState, index: Index) -> ErrorBounds:
    """Bounds in space on some entries of a model kept to a plane, in which some motion out of it is free.

    Parameters
    ----------
    model
        The model in its plane.
    state
        Where all entries are.
    index
        Those entries of the flattened batch.
    """
    whole = Model(model.plan, in_plane=False, clearance=model.clearance)
    where = model.where(index)
    there = in_space(whole, EquilibriumEquations(model, where, len(index)), state.taken(index))
    return ErrorBounds(EquilibriumEquations(whole, where, len(index)), there, np.ones(len(index), dtype=bool))
