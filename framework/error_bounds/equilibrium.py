"""The residual of a computed solution in the equations of equilibrium, evaluated in extended precision.

The equations are those of the frame as it is described: nodes exactly at the given coordinates, joints along the given
axes, members between them, ``sum_i k_i b_i b_i^T u = f``.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import Protocol

import numpy as np

from ..batch import Array, aligned
from ..batched.plan import Plan
from ..entries import WHOLE, Change, Selected
from ..structure.parts import Extended
from .applied import AppliedLoads
from .deformations import Springs, on_nodes, springs
from .force_sizes import reduced_sizes
from .kinematic_edge import KinematicEdge, Real, extended
from .kinematics import FrameKinematics
from .plan_at import plan_at
from .sharing import LoadShare, load_shares
from .tree_members import MEMBER, tree_members

ROUNDING = float(np.finfo(np.float64).eps) / 2.0
# Roundings of extended precision in a deformation or a force, relative to its size.
_FINE = 24.0 * float(np.finfo(Extended).eps)


class Solver(Protocol):
    """An approximate solver for the unknowns; `root` has its precision."""

    root: Array

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""


class Statics:
    """A frame in extended precision, without a solution: its kinematics, springs, loads and stiffnesses.

    Parameters
    ----------
    plan
        The compiled frame.
    determinate
        Whether one end of a member carries the other where that makes a tree: the deformation of a stiff and short
        member is then a coordinate of its own, as that of a joint is.
    entries
        The entries of the batch that are needed, to which `plan` is then restricted; all if None.
    """

    def __init__(self, plan: Plan, *, determinate: bool = False, entries: Selected | None = None) -> None:
        at = WHOLE if entries is None else entries
        own = self.plan = plan if entries is None else plan_at(plan, entries, entries.shape)
        members, links = tree_members(own, springs(own)) if determinate else (springs(own), [])
        self.kinematics = FrameKinematics.of(plan, links, at)
        self.springs = members
        self.loads = AppliedLoads.of(own, self.springs)
        ndim = len(plan.frame.shape)
        links = self.kinematics.links
        self.stiffness = [at(six(link.edge.stiffness, ndim), 1) for link in links]
        imposed = [imposed_on(plan, link) for link in links]
        self.imposed = [None if each is None else at(each, 1) for each in imposed]


class EquilibriumResidual:
    """The residual of a solution, for a part of the batch; its parts are computed as they are first read.

    Parameters
    ----------
    statics
        The frame.
    change
        Function of an array and its number of trailing axes, which takes the part out of it.
    unknowns
        Numbers of the unknowns that the loads reach, (n,).
    values
        Their values, (..., n).
    ndim
        Number of batch axes that `change` leaves; that of the frame if None.
    """

    rounding = ROUNDING
    fine = _FINE

    def __init__(
        self, statics: Statics, change: Change, unknowns: Sequence[int], values: Array, ndim: int | None = None
    ) -> None:
        self.plan, self.unknowns, self.values = statics.plan, list(unknowns), extended(values)
        self.statics, self.change = statics, change
        self.ndim = len(self.plan.frame.shape) if ndim is None else ndim
        self.kinematics = statics.kinematics.mapped(change)
        self.springs = [each.mapped(change) for each in statics.springs]
        self.stiffness = [change(each, 1) for each in statics.stiffness]
        self.loads = statics.loads.mapped(change)
        self.imposed = [None if each is None else change(each, 1) for each in statics.imposed]

    @cached_property
    def coordinates(self) -> Real:
        """Coordinates of the nodes, (..., nodes, 6)."""
        return self.kinematics.coordinates(self.unknowns, self.values, self.imposed)

    @cached_property
    def displacements(self) -> Real:
        """Displacements of the nodes, global, (..., nodes, 6)."""
        return self.kinematics.displacements(self.coordinates)

    @cached_property
    def relative_displacements(self) -> list[Real]:
        """By link: relative displacement in its axes, (..., 6)."""
        return self.kinematics.relative_displacements(self.coordinates, self.displacements)

    @cached_property
    def generalised_forces(self) -> list[Real]:
        """By link: spring forces, (..., 6)."""
        links = zip(self.stiffness, self.relative_displacements, self.imposed, strict=True)
        return [k * (moved if offset is None else moved - offset) for k, moved, offset in links]

    @cached_property
    def deformations(self) -> list[Real]:
        """By kind of member: deformations of the springs, (..., n, 6)."""
        return [each.of(self.displacements, self.coordinates) for each in self.springs]

    @cached_property
    def member_forces(self) -> list[Real]:
        """By kind of member: spring forces, (..., n, 6)."""
        return [each.stiffness * e for each, e in zip(self.springs, self.deformations, strict=True)]

    @cached_property
    def residual(self) -> Real:
        """Unbalanced force on every coordinate, (..., nodes, 6); on an ideal component its constraint force."""
        acting = [each.forces(force) for each, force in zip(self.springs, self.member_forces, strict=True)]
        inner = on_nodes(extended(np.zeros((self.kinematics.count, 6))), zip(self.springs, acting, strict=True))
        return self.kinematics.generalised(self.loads.forces - inner, [-force for force in self.generalised_forces])

    def corrected(self, compliance: Solver) -> EquilibriumResidual:
        """The solution after one step of iterative refinement."""
        step = compliance.solve(self.balance.astype(compliance.root.dtype))
        better = self.values + np.where(np.isfinite(step), step, 0.0)
        return EquilibriumResidual(self.statics, self.change, self.unknowns, better, self.ndim)

    @cached_property
    def balance(self) -> Real:
        """Unbalanced force on the unknowns, (..., n)."""
        return self.kinematics.reduced(self.unknowns, self.residual)

    def absolute(self) -> Real:
        """Values of the unknowns in the coordinates of the frame's own tree (without tree members), (..., n)."""
        return self.in_own_tree(self.values, self.displacements)

    def in_own_tree(self, values: Real, displacements: Real) -> Real:
        """Values of the unknowns (..., n) in the coordinates of `absolute`, given the displacements (..., nodes, 6)."""
        out = values.copy()
        determinate = {link.child for link in self.kinematics.links if link.edge.kind == MEMBER}
        for index, unknown in enumerate(self.unknowns):
            node, component = divmod(unknown, 6)
            if node in determinate:
                out[..., index] = displacements[..., node, component]
        return out

    @cached_property
    def load_shares(self) -> list[LoadShare]:
        """How redundant ideal components share the load."""
        return load_shares(self.kinematics)

    @cached_property
    def double(self) -> FrameKinematics:
        """The kinematics in double precision."""
        return self.kinematics.mapped(rounded)

    @cached_property
    def double_springs(self) -> list[Springs]:
        """The members in double precision."""
        return [each.mapped(rounded) for each in self.springs]

    @cached_property
    def sizes(self) -> Array:
        """Sizes of the displacements, (..., nodes, 6)."""
        out: Array = extended(self.kinematics.sizes(self.coordinates))
        return out

    @cached_property
    def deformation_sizes(self) -> list[Array]:
        """Sizes of the deformations, by kind of member, (..., n, 6)."""
        return [extended(each.sizes(self.sizes, self.coordinates)) for each in self.springs]

    @cached_property
    def displacement_sizes(self) -> list[Array]:
        """Sizes of the relative displacements, by link, (..., 6)."""
        found = self.kinematics.displacement_sizes(self.coordinates, self.sizes)
        given = [0.0 if each is None else np.abs(each) for each in self.imposed]
        return [extended(size + more) for size, more in zip(found, given, strict=True)]

    @cached_property
    def force_error_bounds(self) -> list[Real]:
        """By kind of member: bound on the error of the spring forces at these displacements, (..., n, 6).

        It is the rounding of the stiffness times the deformation, plus the stiffness times the rounding of the
        deformation, which is relative to the deformation's size.
        """
        kinds = zip(self.springs, self.deformations, self.deformation_sizes, strict=True)
        return [
            each.uncertain(found, self.rounding) + self.fine * each.sizes_of_stiffness * size
            for each, found, size in kinds
        ]

    @cached_property
    def unbalanced(self) -> Real:
        """Bound on the error of `balance` by rounding of loads and of sums of forces, (..., n)."""
        forces = self.loads.error_bound + self.fine * np.abs(self.loads.forces).astype(np.float64)
        kinds = zip(self.springs, self.member_forces, strict=True)
        forces = on_nodes(forces, ((each, each.spread_forces(self.fine * np.abs(force))) for each, force in kinds))
        generalised_forces = [
            (self.fine * np.abs(generalised_force)).astype(np.float64) for generalised_force in self.generalised_forces
        ]
        return reduced_sizes(self.double, self.unknowns, forces, generalised_forces)

    @cached_property
    def force_uncertainty(self) -> Real:
        """Greatest work of the errors of spring forces on a motion of unit energy norm, (...)."""
        members = sum(
            (each.work(error_bound) for each, error_bound in zip(self.springs, self.force_error_bounds, strict=True)),
            extended(0.0),
        )
        links = zip(self.stiffness, self.displacement_sizes, strict=True)
        joints = sum((np.sum(k * (self.fine * size) ** 2, axis=-1) for k, size in links), extended(0.0))
        out: Real = np.sqrt(members + joints)
        return out

    def place(self, piece: int) -> tuple[int, int]:
        """Number of a piece's kind of member, and its position among the members of that kind."""
        for number, each in enumerate(self.springs):
            found = np.flatnonzero(each.pieces == piece)
            if found.size:
                return number, int(found[0])
        raise KeyError(piece)


def rounded(array: Real, trailing: int) -> Real:
    """An array in double precision; `trailing` is ignored (signature as `mapped` needs it)."""
    return array.astype(np.float64)


def six(stiffness: tuple[object, ...], ndim: int) -> Array:
    """Six numbers as an array (..., 6) with all batch axes."""
    values = [np.asarray(value, dtype=np.float64) for value in stiffness]
    shape = np.broadcast_shapes((1,) * ndim, *(value.shape for value in values))
    return np.stack([np.broadcast_to(value, shape) for value in values], axis=-1)


def imposed_on(plan: Plan, link: KinematicEdge) -> Real | None:
    """Displacement imposed on an edge, (..., 6) with all batch axes, None where there is none."""
    if not any(link.edge.offset):
        return None
    ndim, values = len(plan.frame.shape), plan.rhs_parameters.values
    six = []
    for row in link.edge.offset:
        terms = [np.asarray(factor) * extended(values[-1 - key]) for key, factor in row.items()]
        six.append(sum(terms, extended(0.0)))
    shape = np.broadcast_shapes((1,) * ndim, *(np.shape(value) for value in six))
    return np.stack([np.broadcast_to(aligned(np.asarray(v), ndim), shape) for v in six], axis=-1)
