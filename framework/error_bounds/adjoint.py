"""Adjoint of a requested result: displacements under the unit force, or relative displacement, whose work equals it."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ..batch import Array
from ..structure.parts import Extended
from .compliance import Compliance
from .deformations import Springs, on_nodes
from .energy import CAREFUL, CARRIED, energy_of_error
from .equilibrium import EquilibriumResidual
from .force_sizes import reduced_sizes
from .kinematic_edge import Real, extended, norm
from .kinematics import FrameKinematics
from .requested import RequestedResults
from .sharing import shared

# Roundings in a deformation in double precision, relative to its size.
_STRETCH = 8.0
_LEAST = float(np.finfo(Extended).eps)
# For an adjoint by iterations: error that its residual may cause, in roundings of the result; fraction of the greatest
# result of the same kind below which others need not be resolved; largest relative residual.
_PART, _FELLOWS, _ROUGH = 0.5, 1e-2, 1e-2


class Adjoint:
    """Displacements under the unit loads of m requested results, and the error bounds that follow from them.

    Parameters
    ----------
    state
        The computed solution.
    compliance
        Inverse of its stiffness.
    result
        The m requested results.
    steps
        Least number of refinement steps, where the adjoint itself is wanted.

    Attributes
    ----------
    coordinates
        Coordinates of the nodes under the unit loads, (m, ..., nodes, 6).
    """

    def __init__(
        self, state: EquilibriumResidual, compliance: Compliance, result: RequestedResults, steps: int = 0
    ) -> None:
        self.state, self.compliance, self.result = state, compliance, result
        kinematics, imposed = state.kinematics, _relative_displacements(state, result)
        self._fixed = _imposed(state, result).astype(np.float64)
        self.right = self._unbalanced(self._fixed, state.double, state.double_springs)
        refinements = max(steps, compliance.steps)
        rough = compliance.iterative and not refinements
        self.answer: Real = compliance.solve_to(self.right, self._enough()) if rough else compliance.solve(self.right)
        self.coordinates = kinematics.coordinates(state.unknowns, extended(self.answer), imposed)
        self._fine = compliance.near
        for _ in range(refinements):
            left = self._unbalanced(self.coordinates, kinematics, state.springs)
            self.answer = extended(self.answer) + compliance.solve(left.astype(compliance.root.dtype))
            self.coordinates = kinematics.coordinates(state.unknowns, self.answer, imposed)

    @cached_property
    def rough(self) -> Array:
        """Coordinates in double precision."""
        found: Array = self.coordinates.astype(np.float64)
        return found

    @cached_property
    def displacements(self) -> Array:
        """Displacements of the nodes, global, (m, ..., nodes, 6)."""
        return self.state.double.displacements(self.rough)

    @cached_property
    def deformations(self) -> list[Array]:
        """Deformations by kind of member, (m, ..., n, 6)."""
        return [each.of(self.displacements, self.rough) for each in self.state.double_springs]

    @cached_property
    def relative_displacements(self) -> list[Array]:
        """Relative displacements by link, (m, ..., 6)."""
        return self.state.double.relative_displacements(self.rough, self.displacements)

    def constrained(self, index: int) -> list[Array]:
        """By link: force in its ideal components under unit force `index`, (..., 6); 0 in the others.

        It is the work done if a unit displacement is imposed on the component while all other unknowns stay zero.
        """
        state, double = self.state, self.state.double
        acting = _forces(state, self.result, self.rough, double, state.double_springs)[index]
        out = []
        for k, link in enumerate(double.links):
            forces = np.zeros((*acting.shape[:-2], 6))
            for each in link.edge.ideal:
                imposed = [np.eye(6)[each] if number == k else None for number in range(len(double.links))]
                fixed = double.coordinates(state.unknowns, np.zeros(len(state.unknowns)), imposed)
                forces[..., each] = np.sum(fixed * acting, axis=(-1, -2))
            out.append(forces)
        return [np.asarray(forces, np.float64) for forces in shared(state.load_shares, out)]

    # -- error ------------------------------------------------------------------------------------------------------

    @cached_property
    def refined(self) -> Real:
        """The results corrected by the work of the residual on the adjoint, (..., m)."""
        work = np.einsum("...nk,...nk->...", self.coordinates, self.state.residual)
        found: Real = self.result.value + np.moveaxis(work, 0, -1)
        return found

    def error_bound(self) -> Real:
        """Bound on the error of `refined`, (..., m)."""
        state, double = self.state, self.state.double
        spread = double.sizes(self.rough)
        total: Any = extended(0.0)
        kinds = zip(state.double_springs, self._stretches, state.force_error_bounds, state.member_forces, strict=True)
        for springs, found, error_bound, generalised_force in kinds:
            total = total + _dot(found, error_bound)
            total = total + _dot(springs.sizes(spread, self.rough), state.fine * np.abs(generalised_force))
        opened = double.displacement_sizes(self.rough, spread)
        for k, found, own, generalised_force, size in zip(
            state.stiffness,
            self.relative_displacements,
            opened,
            state.generalised_forces,
            state.displacement_sizes,
            strict=True,
        ):
            if k.any():
                here = np.abs(found) + _STRETCH * state.rounding * own
                total = total + np.einsum("...k,...k->...", here, state.fine * k * size)
                total = total + np.einsum("...k,...k->...", own, state.fine * np.abs(generalised_force))
        total = total + _dot(spread, state.loads.error_bound + state.fine * np.abs(state.loads.forces))
        total = total + _dot(np.abs(self.coordinates), state.fine * np.abs(state.residual))
        out: Real = np.moveaxis(total + self._second_order(), 0, -1) + self.result.error_bound
        return out + 4.0 * _LEAST * np.abs(self.refined)

    @cached_property
    def _stretches(self) -> list[Array]:
        """Magnitudes of the deformations by kind of member with their rounding in double precision, (m, ..., n, 6)."""
        spread, kinds = self.state.double.sizes(self.rough), self.state.double_springs
        parts = zip(kinds, self.deformations, strict=True)
        return [
            np.abs(found) + _STRETCH * self.state.rounding * each.sizes(spread, self.rough) for each, found in parts
        ]

    def _second_order(self) -> Real:
        """Bound on the products of two errors, (m, ...).

        The exact solution differs from the computed one by a motion w, of which only the energy norm is known. It does
        the work ``s . w`` on the residual s of the adjoint z and, as stiffnesses are off by dk, ``dk e(z) . e(w)`` on
        the adjoint, and ``dk a . e(w)`` on a requested force with the rows a. With S the stiffness scaled to unit
        diagonal by D, forces g on the unknowns do no more work than ``|D g| / sqrt(least)`` on a motion of unit energy
        norm, and forces p on the deformations no more than ``|k^-1/2 p|``, times the root of
        `Compliance.amplification` if springs have negative stiffness. The energy norm of w is bounded alike, from the
        residual and its own rounding, and the rounding of the stiffness at the computed deformations.
        """
        state, energy = self.state, self._energy
        members = zip(state.double_springs, self._stretches, strict=True)
        force_uncertainty = np.sqrt(
            sum((each.work(each.uncertain(e, state.rounding)) for each, e in members), np.zeros(()))
        )
        unresolved = (
            np.moveaxis(self.result.unresolved, -1, 0) if isinstance(self.result.unresolved, np.ndarray) else 0.0
        )
        work = self._left() + np.sqrt(self.compliance.amplification) * (force_uncertainty + unresolved)
        out: Real = np.where((work == 0.0) | (energy == 0.0), 0.0, work * energy)
        return out

    @cached_property
    def _energy(self) -> Real:
        return energy_of_error(self.state, self.compliance)

    def _enough(self) -> Array:
        """Fraction of each scaled unit load that may be left unbalanced: its work is then less than a rounding of the
        result, (m, ...)."""
        size = norm(self.compliance.root * self.right)
        result = np.abs(np.moveaxis(self.result.value, -1, 0))
        least_stiffness = np.sqrt(self.compliance.least)
        # a result that is zero, or almost, need only be as accurate as the others of its kind
        natural = np.where(size > 0.0, result / np.where(size > 0.0, size, 1.0), 0.0)
        natural = np.maximum(natural, _FELLOWS * natural.max(axis=0))
        work = self._energy / least_stiffness
        share = _PART * self.state.rounding * natural / np.where(work > 0.0, work, 1.0)
        found: Array = np.minimum(np.where(work > 0.0, share, _ROUGH), _ROUGH).astype(np.float64)
        alike = tuple(axis for axis, n in enumerate(self.right.shape[:-1]) if n == 1 < found.shape[axis])
        least: Array = found.min(axis=alike, keepdims=True)
        return least

    def _left(self) -> Real:
        """Greatest work of the adjoint's residual on a motion of unit energy norm, (m, ...)."""
        state, compliance, double = self.state, self.compliance, self.state.double
        root, least_stiffness, kinds = compliance.root, np.sqrt(compliance.least), state.double_springs
        if self._fine:
            left = self._unbalanced(self.coordinates, state.kinematics, state.springs)
            noise = state.fine * self._load_sizes(
                self._stretches, [np.abs(opened) for opened in self.relative_displacements]
            )
            spread = double.sizes(self.rough)
            members = sum(
                (each.work(each.sizes_of_stiffness * each.sizes(spread, self.rough)) for each in kinds), np.zeros(())
            )
            opened = zip(state.stiffness, double.displacement_sizes(self.rough, spread), strict=True)
            joints = sum((np.sum(k * size * size, axis=-1) for k, size in opened), np.zeros(()))
            rounded = state.fine * np.sqrt((members + joints) * compliance.amplification)
            fine: Real = (norm(extended(root) * left) + norm(root * noise)) / least_stiffness + rounded
            return fine
        left = self.right - compliance.apply(self.answer)
        sizes = self._load_sizes([], [])
        if self.result.imposed:
            spread = double.sizes(self._fixed)
            imposed = [each.sizes(spread, self._fixed) for each in kinds]
            sizes = self._load_sizes(imposed, double.displacement_sizes(self._fixed, spread))
        careful = CAREFUL + CARRIED * len(state.kinematics.links)
        noise = compliance.backward_error * norm(self.answer / root) + careful * state.rounding * norm(root * sizes)
        rough: Real = (norm(root * left) + noise) / least_stiffness
        return rough

    def _load_sizes(self, stretches: list[Array], relative_displacements: list[Array]) -> Real:
        """Size of the unit load's residual on the unknowns at such deformations and relative displacements, (m, ...,
        n)."""
        state, result, double = self.state, self.result, self.state.double
        load: Any = np.zeros((double.count, 6))
        if result.forces is not None:
            load = (np.abs(result.forces) if result.sizes is None else result.sizes).astype(np.float64)
        generalised_forces: list[Any] = [
            np.abs(result.generalised_forces.get(k, np.zeros(6))) for k in range(len(double.links))
        ]
        if stretches or relative_displacements:
            kinds = zip(state.double_springs, stretches, strict=True)
            load = on_nodes(load, ((each, each.spread_forces(each.sizes_of_stiffness * size)) for each, size in kinds))
            generalised_forces = [
                generalised_force + k * size
                for generalised_force, k, size in zip(
                    generalised_forces, state.stiffness, relative_displacements, strict=True
                )
            ]
        return reduced_sizes(
            double,
            state.unknowns,
            load,
            [generalised_force.astype(np.float64) for generalised_force in generalised_forces],
        )

    # -- load -------------------------------------------------------------------------------------------------------

    def _unbalanced(self, coordinates: Real, kinematics: FrameKinematics, springs: list[Springs]) -> Real:
        """Residual of the unit load at given displacements, on the unknowns, (m, ..., n)."""
        acting = _forces(self.state, self.result, coordinates, kinematics, springs)
        return kinematics.reduced(self.state.unknowns, acting)


def unit_forces(state: EquilibriumResidual, result: RequestedResults) -> Real:
    """Forces on the unknowns whose work equals a result, (m, ..., n), in double precision."""
    fixed = _imposed(state, result).astype(np.float64)
    acting = _forces(state, result, fixed, state.double, state.double_springs)
    return state.double.reduced(state.unknowns, acting)


def _imposed(state: EquilibriumResidual, result: RequestedResults) -> Real:
    """Coordinates at the unit relative displacements of a result, all unknowns being zero, (m, ..., nodes, 6)."""
    none = extended(np.zeros((1,) * (state.ndim + 1) + (len(state.unknowns),)))
    return state.kinematics.coordinates(state.unknowns, none, _relative_displacements(state, result))


def _relative_displacements(state: EquilibriumResidual, result: RequestedResults) -> list[Real | None]:
    links = range(len(state.kinematics.links))
    return [extended(result.imposed[k]) if k in result.imposed else None for k in links]


def _forces(
    state: EquilibriumResidual,
    result: RequestedResults,
    coordinates: Real,
    kinematics: FrameKinematics,
    springs: list[Springs],
) -> Real:
    """Residual of the unit load at given displacements, on all coordinates, (m, ..., nodes, 6)."""
    load: Any = np.zeros((kinematics.count, 6)) if result.forces is None else result.forces
    moved = kinematics.displacements(coordinates)
    load = on_nodes(load, ((each, -each.forces(each.stiffness * each.of(moved, coordinates))) for each in springs))
    opened = kinematics.relative_displacements(coordinates, moved)
    generalised_forces = [
        -k * relative_displacement + result.generalised_forces.get(index, 0.0)
        for index, (k, relative_displacement) in enumerate(zip(state.stiffness, opened, strict=True))
    ]
    return kinematics.generalised(load, generalised_forces)


def _dot(sizes: Real, weights: Real) -> Any:
    """Sum of products over the last two axes."""
    return np.einsum("...nk,...nk->...", sizes, weights)
