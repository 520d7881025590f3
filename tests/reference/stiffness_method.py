"""The displacement method as in any textbook, in numbers of 50 digits and more or in double precision.

Independent of linkframe: members by the flexibility of a cantilever, joints as springs between
duplicate nodes, everything added into one dense matrix. One code in several arithmetics, so that the
difference of their results is rounding and nothing else.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, localcontext
from math import isinf, sqrt
from typing import Any

import mpmath
import numpy as np

from .structure import COMPONENTS, Member, Number, Spring, Structure

Array = np.ndarray[Any, np.dtype[Any]]

mp = mpmath.MPContext()
mp.dps = 50

# Digits of decimal numbers, which are ten times as fast as those of mpmath.
DIGITS = 60


@dataclass(frozen=True)
class Arithmetic:
    """The numbers to calculate with."""

    number: Callable[[Any], Number]
    sqrt: Callable[[Number], Number]
    dtype: type
    solve: Callable[[Array, Array], Array]

    def array(self, values: Any) -> Array:
        """Convert nested floats exactly."""
        values = np.asarray(values, dtype=object)
        return np.array([self.number(value) for value in values.ravel()], dtype=self.dtype).reshape(values.shape)


def eliminate(matrix: Array, right: Array) -> Array:
    """Solve by Gauss with partial pivoting; object arrays keep their numbers' own precision."""
    a: Array = matrix.copy()
    b: Array = right.copy()
    size = len(b)
    for k in range(size):
        pivot = k + int(np.argmax(np.abs(a[k:, k])))
        a[[k, pivot]], b[[k, pivot]] = a[[pivot, k]], b[[pivot, k]]
        for i in k + 1 + np.flatnonzero(a[k + 1 :, k] != 0):
            # the array first: mpmath's numbers would write the whole of it down before they let the array multiply
            factor = a[i, k] / a[k, k]
            a[i, k:] -= a[k, k:] * factor
            b[i] -= factor * b[k]
    for k in reversed(range(size)):
        b[k] = (b[k] - a[k, k + 1 :] @ b[k + 1 :]) / a[k, k]
    return b


# What stands for ideal: 10^20 times stiffer than anything else: 50 digits lose 30, and the limit is reached to 20.
IDEAL = 1e30


def decimal(value: Number) -> Decimal:
    """A float as it is, a number of mpmath to as many digits as are calculated with."""
    return Decimal(value) if isinstance(value, (int, float)) else Decimal(mp.nstr(mp.mpf(value), DIGITS))


EXACT = Arithmetic(mp.mpf, mp.sqrt, object, eliminate)
DECIMAL = Arithmetic(decimal, Decimal.sqrt, object, eliminate)
DOUBLE = Arithmetic(float, sqrt, float, np.linalg.solve)


def cross(a: Array, b: Array) -> Array:
    """Vector product; numpy's own refuses object arrays of some lengths."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=a.dtype)


def member_axes(chord: Array, up: Array, arithmetic: Arithmetic) -> Array:
    """Rows x along the chord, z nearest to `up`, y = z cross x; y is global y where `up` is along the chord."""

    def unit(v: Array) -> Array:
        scaled: Array = v / arithmetic.sqrt(v @ v)
        return scaled

    x = unit(chord)
    side = cross(up, x)
    if side @ side == 0:
        side = arithmetic.array((0.0, 1.0, 0.0))
    y = unit(side)
    return np.array([x, y, cross(x, y)])


def tip_stiffness(member: Member, length: Number, arithmetic: Arithmetic) -> Array:
    """Forces on the free end of the clamped member for its unit displacements, local axes, (6, 6).

    The inverse of the cantilever's flexibility: a transverse tip force bends by L^3/3EI + L/kGA and
    turns by L^2/2EI, a tip moment bends by L^2/2EI and turns by L/EI.
    """
    E, G, A, Iy, Iz, J = arithmetic.array((member.E, member.G, member.A, member.Iy, member.Iz, member.J))
    k = arithmetic.array(np.zeros((6, 6)))
    k[0, 0] = E * A / length
    k[3, 3] = G * J / length
    # Deflection y turns about +z, deflection z about -y.
    for v, r, sign, inertia, factor in ((1, 5, 1, Iz, member.ky), (2, 4, -1, Iy, member.kz)):
        phi = 0 if isinf(factor) else 12 * E * inertia / (arithmetic.number(factor) * G * A * length * length)
        k[v, v] = 12 * E * inertia / (length * length * length * (1 + phi))
        k[r, r] = (4 + phi) * E * inertia / (length * (1 + phi))
        k[v, r] = k[r, v] = -sign * 6 * E * inertia / (length * length * (1 + phi))
    return k


def deformation(member: Member, structure: Structure, arithmetic: Arithmetic) -> tuple[Array, Array]:
    """Tip stiffness (6, 6) and the map (6, 12) from global end displacements to those of the tip."""
    chord = arithmetic.array(structure.nodes[member.end]) - arithmetic.array(structure.nodes[member.start])
    axes = member_axes(chord, arithmetic.array(member.up), arithmetic)
    length = arithmetic.sqrt(chord @ chord)
    relative = arithmetic.array(np.hstack([-np.eye(6), np.eye(6)]))
    relative[1, 5], relative[2, 4] = -length, length  # the start turns the tip by r x L
    turn = arithmetic.array(np.zeros((12, 12)))
    for block in range(0, 12, 3):
        turn[block : block + 3, block : block + 3] = axes
    return tip_stiffness(member, length, arithmetic), relative @ turn


def gap(spring: Spring, arithmetic: Arithmetic) -> tuple[Array, Array]:
    """Stiffness (6, 6) and the map (6, 12) from global end displacements to the displacement in the joint."""
    axes = arithmetic.array(spring.axes)
    opening = arithmetic.array(np.zeros((6, 12)))
    for block in (0, 3):
        opening[block : block + 3, block : block + 3] = -axes.T
        opening[block : block + 3, block + 6 : block + 9] = axes.T
    constants = arithmetic.array(np.zeros((6, 6)))
    for i, value in enumerate(spring.stiffness):
        constants[i, i] = arithmetic.number(min(value, IDEAL))
    advance = arithmetic.array(np.eye(6))  # the spring along z acts on what the screw's advance leaves
    advance[2, 5] = -arithmetic.number(spring.pitch) / (2 * arithmetic.number(mp.pi))
    return advance.T @ constants @ advance, opening


def rigid_link(master: str, slave: str, structure: Structure, arithmetic: Arithmetic) -> tuple[Array, Array]:
    """Six springs of IDEAL and the map (6, 12) to what they stretch: slave - (master + rotation x arm)."""
    arm = arithmetic.array(structure.nodes[slave]) - arithmetic.array(structure.nodes[master])
    apart = arithmetic.array(np.hstack([-np.eye(6), np.eye(6)]))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        apart[i, 3 + j], apart[i, 3 + k] = -arm[k], arm[j]
    return arithmetic.array(IDEAL * np.eye(6)), apart


@dataclass(frozen=True)
class Result:
    """Displacements and reactions (6,) of nodes, extensions and forces (6,) of joints, in joint axes."""

    displacement: dict[str, Array]
    reaction: dict[str, Array]
    extension: dict[str, Array]
    force: dict[str, Array]


def solve(structure: Structure, arithmetic: Arithmetic = DECIMAL) -> Result:
    """Assemble, support, solve; results of decimal numbers are told as those of mpmath."""
    with localcontext(prec=DIGITS):
        found = _solved(structure, arithmetic)
    if arithmetic is not DECIMAL:
        return found
    return Result(*({name: _told(each) for name, each in kind.items()} for kind in vars(found).values()))


def _told(values: Array) -> Array:
    return np.array([mp.mpf(str(value)) for value in values], dtype=object)


def _solved(structure: Structure, arithmetic: Arithmetic) -> Result:
    start = {name: 6 * i for i, name in enumerate(structure.nodes)}
    size = 6 * len(start)
    stiffness = arithmetic.array(np.zeros((size, size)))
    pieces = [(m.start, m.end, *deformation(m, structure, arithmetic)) for m in structure.members.values()]
    pieces += [(j.first, j.second, *gap(j, arithmetic)) for j in structure.joints.values()]
    pieces += [(*pair, *rigid_link(*pair, structure, arithmetic)) for pair in structure.rigid]
    for first, second, k, map_ in pieces:
        rows = [*range(start[first], start[first] + 6), *range(start[second], start[second] + 6)]
        stiffness[np.ix_(rows, rows)] += map_.T @ (k @ map_)

    load, u = arithmetic.array(np.zeros(size)), arithmetic.array(np.zeros(size))
    for node, values in structure.loads.items():
        load[start[node] : start[node] + 6] += arithmetic.array(values)
    held: list[int] = []
    for node, prescribed in structure.supports.items():
        for component, value in prescribed.items():
            held.append(start[node] + COMPONENTS.index(component))
            u[held[-1]] = arithmetic.number(value)
    free = np.setdiff1d(np.arange(size), held)
    known = stiffness[free][:, held] @ u[held]
    u[free] = arithmetic.solve(stiffness[np.ix_(free, free)], load[free] - known)

    reaction = stiffness @ u - load
    displacement = {name: u[i : i + 6] for name, i in start.items()}
    extension, force = {}, {}
    for name, joint in structure.joints.items():
        k, opening = gap(joint, arithmetic)
        extension[name] = opening @ np.concatenate([displacement[joint.first], displacement[joint.second]])
        force[name] = k @ extension[name]
    reactions = {name: reaction[start[name] : start[name] + 6] for name in structure.supports}
    return Result(displacement, reactions, extension, force)
