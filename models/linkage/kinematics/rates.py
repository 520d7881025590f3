"""Velocities and accelerations of the links, from the ground outwards."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..description.parts import GROUND
from .moving_links import Column, MovingLink
from .terms import Scalar, Vector, cross, minus, plus, times
from .tree import Tree

NOTHING: Vector = [0.0, 0.0, 0.0]


@dataclass(frozen=True, eq=False)
class Rates:
    """Angular velocity and acceleration of a link, velocity and acceleration of its reference point `origin`."""

    origin: Vector
    omega: Vector
    v: Vector
    alpha: Vector
    a: Vector

    def velocity(self, point: Vector) -> list[Scalar]:
        """Velocity of the link at the position `point`."""
        return plus(self.v, cross(self.omega, minus(point, self.origin)))

    def acceleration(self, point: Vector) -> list[Scalar]:
        """Acceleration of the link at the position `point`."""
        arm = minus(point, self.origin)
        return plus(self.a, plus(cross(self.alpha, arm), cross(self.omega, cross(self.omega, arm))))


def rates_of(
    tree: Tree,
    bodies: Mapping[str, MovingLink],
    frames: Mapping[str, tuple[list[Vector], Vector, list[Vector], Vector]],
    columns: Sequence[Column],
    velocities: Mapping[str, slice],
    v: Sequence[Scalar],
    w: Sequence[Scalar],
) -> dict[str, Rates]:
    """Rates of all links at velocity coordinates `v` with derivatives `w`.

    Across a joint whose second point is shifted by s in the axes of its first link,

        v2 = v1 + ω1 × s + s',    a2 = a1 + α1 × s + ω1 × (ω1 × s) + 2 ω1 × s' + s''

    and the axis of each rotation turns with the link to which it is fixed.
    """
    out = {GROUND: Rates(NOTHING, NOTHING, NOTHING, NOTHING, NOTHING)}
    for branch in tree.branches:
        pair, base = branch.edge, out[branch.parent]
        _, here, _, there = frames[pair.name]
        own = list(range(len(columns)))[velocities[pair.name]]
        sign = branch.sign
        spin: Vector = combine_many([(v[k], columns[k].angular) for k in own])
        omega = plus(base.omega, times(sign, spin))
        first, second = (omega, base.omega) if branch.is_reversed else (base.omega, omega)
        # the second axis of a universal joint turns with its second link, all others with the first
        carried = [cross(second if columns[k].carrier else first, columns[k].angular) for k in own]
        spin_up = combine_many(
            [(w[k], columns[k].angular) for k in own] + [(v[k], c) for k, c in zip(own, carried, strict=True)]
        )
        alpha = plus(base.alpha, times(sign, spin_up))
        alpha_first = alpha if branch.is_reversed else base.alpha
        shift = minus(there, here)
        slide = combine_many([(v[k], columns[k].linear) for k in own])
        slide_up = combine_many([(w[k], columns[k].linear) for k in own])
        moves = plus(cross(first, shift), slide)
        speeds_up = plus(cross(alpha_first, shift), cross(first, cross(first, shift)))
        speeds_up = plus(speeds_up, plus(times(2.0, cross(first, slide)), slide_up))
        point = there if branch.is_reversed else here
        out[branch.child] = Rates(
            bodies[branch.child].origin,
            omega,
            plus(base.velocity(point), times(sign, moves)),
            alpha,
            plus(base.acceleration(point), times(sign, speeds_up)),
        )
    return out


def combine_many(parts: Sequence[tuple[Scalar, Vector]]) -> list[Scalar]:
    """Sum of factors times vectors."""
    total: list[Scalar] = [0.0, 0.0, 0.0]
    for factor, vector in parts:
        total = plus(total, times(factor, vector))
    return total
