"""The adjoint of an asked result: the displacements under the force, or the opening, that does work equal to it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import Any

import numpy as np

from ..batch import Array
from ..structure.parts import Extended
from .asked import Asked
from .compliance import Compliance
from .deformations import Springs
from .equilibrium import Equilibrium
from .kinematics import Kinematics, Real, extended

# Roundings of a scaled load on an unknown, a safe count.
_CAREFUL = 64.0
_LEAST = float(np.finfo(Extended).eps)


class Adjoint:
    """Influence of everything on an asked result.

    Parameters
    ----------
    state
        The computed solution.
    compliance
        Inverse of its stiffness.
    result
        What is asked for, m results.
    steps
        Steps of refinement at least, where the adjoint itself is wanted.

    Attributes
    ----------
    coordinates
        Displacements for unit forces, (m, ..., nodes, 6), as coordinates.
    """

    def __init__(self, state: Equilibrium, compliance: Compliance, result: Asked, steps: int = 0) -> None:
        self.state, self.compliance, self.result = state, compliance, result
        kinematics, links = state.kinematics, range(len(state.kinematics.links))
        imposed = [extended(result.imposed[k]) if k in result.imposed else None for k in links]
        none = extended(np.zeros((1,) * (state.ndim + 1) + (len(state.unknowns),)))
        self._fixed = kinematics.coordinates(state.unknowns, none, imposed).astype(np.float64)
        self.right = self._unbalanced(self._fixed, state.double, state.double_springs)
        self.answer: Real = compliance.solve(self.right)
        self.coordinates = kinematics.coordinates(state.unknowns, extended(self.answer), imposed)
        self._fine = compliance.near
        for _ in range(max(steps, compliance.steps)):
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
    def openings(self) -> list[Array]:
        """Openings by link, (m, ..., 6)."""
        return self.state.double.openings(self.rough, self.displacements)

    def held(self, index: int) -> list[Array]:
        """By link: force in its ideal components under unit force `index`, (..., 6); 0 in the others.

        It is the work done where a unit displacement is imposed on the component and nothing else moves but what must.
        """
        state, double = self.state, self.state.double
        acting = self._forces(self.rough, double, state.double_springs)[index]
        out = []
        for k, link in enumerate(double.links):
            forces = np.zeros((*acting.shape[:-2], 6))
            for each in link.edge.ideal:
                imposed = [np.eye(6)[each] if number == k else None for number in range(len(double.links))]
                fixed = double.coordinates(state.unknowns, np.zeros(len(state.unknowns)), imposed)
                forces[..., each] = np.sum(fixed * acting, axis=(-1, -2))
            out.append(forces)
        return out

    # -- error ------------------------------------------------------------------------------------------------------

    @cached_property
    def refined(self) -> Real:
        """The results without the error that the residual shows, (..., m)."""
        work = np.einsum("...nk,...nk->...", self.coordinates, self.state.residual)
        found: Real = self.result.value + np.moveaxis(work, 0, -1)
        return found

    def doubt(self) -> Real:
        """What `refined` may be off, (..., m)."""
        state, double = self.state, self.state.double
        spread = double.sizes(self.rough)
        total: Any = extended(0.0)
        kinds = zip(state.double_springs, self.deformations, self._weights(), state.member_pulls, strict=True)
        for springs, found, weight, pull in kinds:
            size = springs.sizes(spread, self.rough)
            total = total + _dot(np.abs(found) + 8.0 * state.rounding * size, weight)
            total = total + _dot(size, state.fine * np.abs(pull))
        opened = double.opening_sizes(self.rough, spread)
        for k, found, own, pull, size in zip(
            state.stiffness, self.openings, opened, state.pulls, state.opening_sizes, strict=True
        ):
            if k.any():
                total = total + np.einsum("...k,...k->...", np.abs(found), state.fine * k * size)
                total = total + np.einsum("...k,...k->...", own, state.fine * np.abs(pull))
        total = total + _dot(spread, state.loads.doubt + state.fine * np.abs(state.loads.forces))
        total = total + _dot(np.abs(self.coordinates), state.fine * np.abs(state.residual))
        out: Real = np.moveaxis(total + self._second_order(), 0, -1) + self.result.doubt
        return out + 4.0 * _LEAST * np.abs(self.refined)

    def _weights(self) -> Iterator[Real]:
        """By kind of member: what a unit deformation of the adjoint makes of rounding, (..., n, 6)."""
        state = self.state
        kinds = zip(state.springs, state.deformations, state.member_pulls, state.deformation_sizes, strict=True)
        for springs, found, pull, sizes in kinds:
            k, off = springs.stiffness, springs.roundings * state.rounding
            weight = off * np.abs(pull) + state.fine * k * sizes
            # a rounded elastic centre mixes the moment into the shear
            for shear, bend in springs.mixed:
                lean = 2.0 * off * np.abs(k[..., shear]) * springs.share(shear, bend)
                weight[..., shear] += lean * np.abs(found[..., bend])
                weight[..., bend] += lean * np.abs(found[..., shear])
            yield weight

    def _second_order(self) -> Real:
        """Bound on the product of what the solution and what the adjoint leave of their equations, (m, ...)."""
        state, compliance = self.state, self.compliance
        root = extended(compliance.root)
        kinds = zip(state.springs, state.deformation_sizes, strict=True)
        theirs = _norm(root * state.balance) + state.fine * np.sqrt(compliance.greatest * _energy(kinds))
        own = self._left()
        out: Real = np.where((own == 0.0) | (theirs == 0.0), 0.0, own * theirs / compliance.least)
        return out

    def _left(self) -> Real:
        """Scaled norm of what the adjoint leaves of its equations, (m, ...)."""
        state, compliance = self.state, self.compliance
        root, size = compliance.root, len(state.unknowns)
        load = _CAREFUL * size * _norm(root * self.right)
        if self._fine:
            left = self._unbalanced(self.coordinates, state.kinematics, state.springs)
            spread = extended(state.double.sizes(self.rough))
            kinds = ((each, each.sizes(spread, self.rough)) for each in state.springs)
            noise = state.fine * np.sqrt(compliance.greatest * _energy(kinds))
            fine: Real = _norm(extended(root) * left) + noise + _LEAST * load
            return fine
        left = self.right - compliance.apply(self.answer)
        noise = compliance.fuzz * _norm(self.answer / root)
        if self.result.imposed:
            spread = state.double.sizes(self._fixed)
            kinds = ((each, each.sizes(spread, self._fixed)) for each in state.double_springs)
            noise = noise + _CAREFUL * state.rounding * np.sqrt(compliance.greatest * _energy(kinds))
        rough: Real = _norm(root * left) + noise + state.rounding * load
        return rough

    # -- load -------------------------------------------------------------------------------------------------------

    def _unbalanced(self, coordinates: Real, kinematics: Kinematics, springs: list[Springs]) -> Real:
        """What displacements leave of the unit load on the unknowns, (m, ..., n)."""
        return kinematics.reduced(self.state.unknowns, self._forces(coordinates, kinematics, springs))

    def _forces(self, coordinates: Real, kinematics: Kinematics, springs: list[Springs]) -> Real:
        """The same on all coordinates, (m, ..., nodes, 6)."""
        state, result = self.state, self.result
        load: Any = np.zeros((kinematics.count, 6)) if result.forces is None else result.forces
        moved = kinematics.displacements(coordinates)
        for each in springs:
            load = load - each.forces(each.stiffness * each.of(moved, coordinates), kinematics.count)
        opened = kinematics.openings(coordinates, moved)
        pulls = [
            -k * opening + result.pulls.get(index, 0.0)
            for index, (k, opening) in enumerate(zip(state.stiffness, opened, strict=True))
        ]
        return kinematics.generalised(load, pulls)


def _energy(kinds: Iterable[tuple[Springs, Real]]) -> Any:
    """Twice the energy of deformations, (...)."""
    return sum((np.sum(each.stiffness * e * e, axis=(-1, -2)) for each, e in kinds), extended(0.0))


def _dot(sizes: Real, weights: Real) -> Any:
    """Sum of products over the last two axes."""
    return np.einsum("...nk,...nk->...", sizes, weights)


def _norm(array: Real) -> Real:
    norm: Real = np.sqrt(np.sum(array * array, axis=-1))
    return norm
