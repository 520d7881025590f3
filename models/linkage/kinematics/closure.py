"""The equations by which a joint closes a loop, their Jacobian, and their second time derivative."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..description.parts import Pair
from .moving_links import Column
from .rates import Rates
from .terms import Scalar, Vector, cross, dot, minus, plus, times

Joined = tuple[list[Vector], Vector, list[Vector], Vector]
GLOBAL: list[Vector] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
NOTHING: Vector = [0.0, 0.0, 0.0]


@dataclass(frozen=True, eq=False)
class Row:
    """One closing equation: its component, its residual, and its Jacobian entry for each velocity coordinate."""

    component: str
    residual: Scalar
    entries: list[Scalar]


@dataclass(frozen=True, eq=False)
class ComponentConstraint:
    """A component that a joint constrains: direction of its reaction force or moment, and the residual `off`."""

    component: str
    direction: Vector
    off: Scalar


def constraints(pair: Pair, joined: Joined) -> Iterator[ComponentConstraint]:
    """Components that a joint constrains: those of position, then those of rotation.

    Three constrained components of position are taken along the axes of the ground, fewer along the joint's axes on its
    first link; rotations are about those axes.
    """
    first, here, second, there = joined
    gap = minus(there, here)
    kind = pair.kind
    places = [name for name in kind.constrained if name[0] == "u"]
    for name in places:
        axis = (GLOBAL if len(places) == 3 else first)["xyz".index(name[1])]
        yield ComponentConstraint(name, axis, dot(axis, gap))
    turns = [name for name in kind.constrained if name[0] == "r"]
    if kind.name == "universal":
        yield ComponentConstraint("ry", cross(first[2], second[0]), -dot(first[2], second[0]))
    elif len(turns) == 2:
        yield ComponentConstraint("rx", first[0], -dot(first[1], second[2]))
        yield ComponentConstraint("ry", first[1], dot(first[0], second[2]))
    elif len(turns) == 3:
        for k, name in enumerate(turns):
            a, b = (k + 1) % 3, (k + 2) % 3
            yield ComponentConstraint(name, first[k], 0.5 * (dot(first[b], second[a]) - dot(first[a], second[b])))


def closing_rows(
    pair: Pair, joined: Joined, columns: Sequence[Column], first: frozenset[int], second: frozenset[int]
) -> Iterator[Row]:
    """Equations of a joint that closes a loop; `first` and `second` are the columns that move its links.

    The entries are those of the geometric Jacobian, exact for a closed loop. In an open loop they differ from the
    derivatives of the residual in proportion to the gap, so that Newton's method keeps its order.
    """
    there = joined[3]
    for one in constraints(pair, joined):
        entries: list[Scalar] = [0.0] * len(columns)
        for k in first ^ second:
            column = columns[k]
            if one.component[0] == "u":
                arm = minus(there, column.point)
                entry = dot(one.direction, plus(column.linear, cross(column.angular, arm)))
            else:
                entry = dot(one.direction, column.angular)
            entries[k] = (column.sign if k in second else -column.sign) * entry
        yield Row(one.component, one.off, entries)


def closing_bias(pair: Pair, joined: Joined, first: Rates, second: Rates) -> Iterator[Scalar]:
    """Second time derivatives of the residuals of a joint, at given rates of its links."""
    axes, _, others, there = joined
    away = minus(second.velocity(there), first.velocity(there))
    difference = minus(second.acceleration(there), first.acceleration(there))
    relative = minus(difference, times(2.0, cross(first.omega, away)))
    spin = minus(second.omega, first.omega)
    spin_up = minus(second.alpha, first.alpha)
    for one in constraints(pair, joined):
        if one.component[0] == "u":
            yield dot(one.direction, relative)
            continue
        if pair.kind.name == "universal":
            turning = plus(
                cross(cross(first.omega, axes[2]), others[0]), cross(axes[2], cross(second.omega, others[0]))
            )
        else:
            turning = cross(first.omega, one.direction)
        yield dot(one.direction, spin_up) + dot(turning, spin)
