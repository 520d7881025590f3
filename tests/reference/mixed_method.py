"""The mixed method in 64-digit numbers: forces of all members and joints beside the displacements of all nodes.

A member is a cantilever with its flexibility, integrated along it; a joint is six flexibilities; what is ideal has
none, and what is free carries no force. So nothing is held by a penalty, and no stiffness is ever formed::

    [ -F  B ] [q]   [e0]
    [ B^T 0 ] [u] = [f ]

with the forces q, the displacements u, the maps B from these to deformations, and what loads on members do to the tip
of a cantilever, e0. Independent of linkframe and of `reference.stiffness_method`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from math import isinf
from typing import Any

import numpy as np

from .many_digits import Row, eliminated, gauss, mp
from .structure import COMPONENTS, Member, PointLoad, Spring, Structure

Array = np.ndarray[Any, np.dtype[Any]]

# Gauss points on a stretch where the section varies, by up to eight times; elsewhere all is a polynomial.
_TAPERED, _UNIFORM = 80, 4


@dataclass(frozen=True)
class Exact:
    """Displacements and reactions (6,) of nodes, those and forces of joints (6,), end forces of members (12,)."""

    displacement: dict[str, Array]
    reaction: dict[str, Array]
    joint_displacement: dict[str, Array]
    joint_force: dict[str, Array]
    end_forces: dict[str, Array]


def solve(structure: Structure) -> Exact:
    """All results of a structure.

    Raises
    ------
    ZeroDivisionError
        Where it is a mechanism, or what holds it is redundant.
    """
    return _Mixed(structure).solved()


class _Mixed:
    """The equations row by row, and what is read from their solution."""

    def __init__(self, structure: Structure) -> None:
        self.structure = structure
        self.size = 6 * len(structure.nodes)
        self.at = {name: 6 * k for k, name in enumerate(structure.nodes)}
        self.rows: dict[int, Row] = {k: {} for k in range(self.size)}
        self.right: dict[int, Any] = dict.fromkeys(self.rows, mp.mpf(0))
        self.bars = {name: _Bar(member, name, structure) for name, member in structure.members.items()}
        self.joints = {name: _axes(joint) for name, joint in structure.joints.items()}
        self.forces: dict[str, list[int | None]] = {}
        for name, bar in self.bars.items():
            self._member(name, bar)
        for name, joint in structure.joints.items():
            self._joint(name, joint)
        for master, slave in structure.rigid:
            self._hold(_arm(structure, master, slave), (master, slave), range(6))
        for master, slave, names in structure.ties:
            self._hold(_apart(), (master, slave), [COMPONENTS.index(each) for each in names])
        for node, load in structure.loads.items():
            for k, value in enumerate(load):
                self.right[self.at[node] + k] += mp.mpf(value)

    def solved(self) -> Exact:
        """Supports put in, the equations solved, the results read."""
        structure = self.structure
        held = {
            self.at[node] + COMPONENTS.index(name): mp.mpf(value)
            for node, given in structure.supports.items()
            for name, value in given.items()
        }
        found = eliminated(self.rows, self.right, held)
        u = {name: np.array([found[k + c] for c in range(6)], dtype=object) for name, k in self.at.items()}
        q = {name: _numbers([0 if k is None else found[k] for k in keys]) for name, keys in self.forces.items()}
        reaction = {}
        for node, given in structure.supports.items():
            reaction[node] = _numbers([0] * 6)
            for name in given:
                k = COMPONENTS.index(name)
                row = self.at[node] + k
                reaction[node][k] = sum((f * found[i] for i, f in self.rows[row].items()), -self.right[row])
        moved, force = {}, {}
        for name, joint in structure.joints.items():
            axes = self.joints[name]
            moved[name] = _six(axes.T, u[joint.second] - u[joint.first])
            force[name] = _pitched(joint).T @ q[name]
        ends = {name: np.concatenate([bar.start(q[name]), q[name]]) for name, bar in self.bars.items()}
        return Exact(u, reaction, moved, force, ends)

    # -- equations --------------------------------------------------------------------------------------------------

    def _member(self, name: str, bar: _Bar) -> None:
        member = self.structure.members[name]
        own = [self._new() for _ in range(6)]
        self.forces[name] = list(own)
        maps = {member.start: bar.by_start, member.end: bar.by_end}
        for i in range(6):
            self.right[own[i]] = bar.bent[i]
            for j in range(6):
                self._put(own[i], own[j], -bar.flexibility[i, j])
                for node, map_ in maps.items():
                    self._couple(own[i], self.at[node] + j, map_[i, j])
        for j in range(6):  # what acts along the member stands on its start, its tip being free of it
            self.right[self.at[member.start] + j] += (bar.turn.T @ bar.carried)[j]
        for end, component in member.releases:
            slip = self._new()
            column = bar.lever[:, component] if end == 0 else _numbers(np.eye(6)[component])
            for i in range(6):
                self._couple(own[i], slip, column[i])
            if end == 0:
                self.right[slip] = bar.carried[component]

    def _joint(self, name: str, joint: Spring) -> None:
        axes = self.joints[name]
        opened = _six(axes.T, _numbers(np.eye(6)))
        offset = _numbers(self.structure.offsets.get(name, (0.0,) * 6))
        pitched = _pitched(joint)
        keys: list[int | None] = []
        for k, stiffness in enumerate(joint.stiffness):
            if stiffness == 0.0:
                keys.append(None)
                continue
            own = self._new()
            keys.append(own)
            row = pitched[k] @ opened
            self.right[own] = offset[k]
            if not isinf(stiffness):
                self._put(own, own, -1 / mp.mpf(stiffness))
            for j in range(6):
                self._couple(own, self.at[joint.second] + j, row[j])
                self._couple(own, self.at[joint.first] + j, -row[j])
        self.forces[name] = keys

    def _hold(self, map_: Array, nodes: tuple[str, str], components: Any) -> None:
        for k in components:
            own = self._new()
            for side, node in enumerate(nodes):
                for j in range(6):
                    self._couple(own, self.at[node] + j, map_[k, 6 * side + j])

    def _new(self) -> int:
        key = len(self.rows)
        self.rows[key], self.right[key] = {}, mp.mpf(0)
        return key

    def _put(self, i: int, j: int, value: Any) -> None:
        if value != 0:
            self.rows[i][j] = self.rows[i].get(j, mp.mpf(0)) + value

    def _couple(self, i: int, j: int, value: Any) -> None:
        self._put(i, j, value)
        self._put(j, i, value)


class _Bar:
    """A member as a cantilever: flexibility of its tip, maps of end displacements, what loads on it do."""

    def __init__(self, member: Member, name: str, structure: Structure) -> None:
        chord = _numbers(structure.nodes[member.end]) - _numbers(structure.nodes[member.start])
        self.length = mp.sqrt(chord @ chord)
        self.axes = _along(chord / self.length, _numbers(member.up))
        self.turn = _numbers(np.zeros((6, 6)))
        self.turn[:3, :3] = self.turn[3:, 3:] = self.axes
        self.lever = _numbers(-np.eye(6))
        self.lever[1, 5], self.lever[2, 4] = -self.length, self.length
        self.by_start, self.by_end = self.lever @ self.turn, self.turn
        self.member = member
        self.loads = [*_lines(structure, name, self), *_points(structure, name, self)]
        self.flexibility = _numbers(np.zeros((6, 6)))
        self.bent = _numbers(np.zeros(6))
        self.carried = self._beyond(mp.mpf(0))
        self._integrate()

    def start(self, tip: Array) -> Array:
        """Force on the start, local, from that on the tip."""
        out: Array = self.lever.T @ tip - self.carried
        return out

    def _integrate(self) -> None:
        """Integrals of the unit forces' and the loads' section forces by the flexibility, by Gauss's rule."""
        breaks = sorted({mp.mpf(0), self.length, *(x for load in self.loads for x in load.breaks)})
        f, bent = self.flexibility, self.bent
        for a, b in pairwise(breaks):
            for point, weight in gauss(_UNIFORM if self.member.taper is None else _TAPERED):
                x = a + (b - a) * point
                arm, w = self.length - x, (b - a) * weight
                axial, y, z, twist, about_y, about_z = (w * part for part in self._section(x))
                f[0, 0] += axial
                f[3, 3] += twist
                f[1, 1] += y + about_z * arm * arm
                f[2, 2] += z + about_y * arm * arm
                f[1, 5] += about_z * arm
                f[2, 4] -= about_y * arm
                f[4, 4] += about_y
                f[5, 5] += about_z
                if self.loads:
                    inner = self._beyond(x)
                    bent[0] += axial * inner[0]
                    bent[3] += twist * inner[3]
                    bent[1] += y * inner[1] + about_z * arm * inner[5]
                    bent[2] += z * inner[2] - about_y * arm * inner[4]
                    bent[4] += about_y * inner[4]
                    bent[5] += about_z * inner[5]
        f[5, 1], f[4, 2] = f[1, 5], f[2, 4]

    def _beyond(self, x: Any) -> Array:
        """Section forces at x by what acts on the member beyond."""
        return sum((load.beyond(x) for load in self.loads), _numbers(np.zeros(6)))

    def _section(self, x: Any) -> Array:
        """Strain and curvature by section forces at x."""
        m, share = self.member, x / self.length
        E, G = mp.mpf(m.E), mp.mpf(m.G)
        first = [mp.mpf(v) for v in (m.A, m.Iy, m.Iz, m.J)]
        if m.taper is not None:
            last = [mp.mpf(v) for v in m.taper]
            first = [a + (b - a) * share for a, b in zip(first, last, strict=True)]
        A, Iy, Iz, J = first
        y, z = (0 if isinf(k) else 1 / (mp.mpf(k) * G * A) for k in (m.ky, m.kz))
        return np.array([1 / (E * A), y, z, 1 / (G * J), 1 / (E * Iy), 1 / (E * Iz)], dtype=object)


@dataclass(frozen=True)
class _Line:
    """Force per length from `start` at x1 to `end` at x2, local."""

    x1: Any
    x2: Any
    first: Array
    last: Array

    @property
    def breaks(self) -> tuple[Any, Any]:
        return self.x1, self.x2

    def beyond(self, x: Any) -> Array:
        a = max(x, self.x1)
        if a >= self.x2:
            return _numbers(np.zeros(6))
        span = self.x2 - self.x1
        slope = (self.last - self.first) / span
        here, w = self.first + slope * (a - self.x1), self.x2 - a
        # of a force here + slope (xi - a) over the width w, at the distance xi - x
        whole = here * w + slope * w * w / 2
        about = (a - x) * whole + here * w * w / 2 + slope * w * w * w / 3
        return np.array([*whole, mp.mpf(0), -about[2], about[1]], dtype=object)


@dataclass(frozen=True)
class _Point:
    """Force and moment at x1, local."""

    x1: Any
    force: Array

    @property
    def breaks(self) -> tuple[Any]:
        return (self.x1,)

    def beyond(self, x: Any) -> Array:
        if x >= self.x1 and x > 0:
            return _numbers(np.zeros(6))
        arm, f = self.x1 - x, self.force
        return np.array([f[0], f[1], f[2], f[3], f[4] - arm * f[2], f[5] + arm * f[1]], dtype=object)


def _lines(structure: Structure, name: str, bar: _Bar) -> Iterator[_Line]:
    for load in structure.line_loads:
        if load.member == name:
            x1, x2 = (0, bar.length) if load.span is None else load.span
            first, last = (_numbers(side) for side in (load.start, load.end))
            if not load.local:
                first, last = bar.axes @ first, bar.axes @ last
            yield _Line(mp.mpf(x1), mp.mpf(x2), first, last)


def _points(structure: Structure, name: str, bar: _Bar) -> Iterator[_Point]:
    load: PointLoad
    for load in structure.point_loads:
        if load.member == name:
            force = _numbers(load.force)
            yield _Point(mp.mpf(load.at), force if load.local else bar.turn @ force)


# -- geometry ---------------------------------------------------------------------------------------------------------


def _numbers(values: Any) -> Array:
    values = np.asarray(values, dtype=object)
    return np.array([mp.mpf(v) for v in values.ravel()], dtype=object).reshape(values.shape)


def _cross(a: Array, b: Array) -> Array:
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]], dtype=object)


def _along(x: Array, up: Array) -> Array:
    """Rows x, y, z with z nearest to `up`; y is global y where that is along x."""
    side = _cross(up, x)
    if side @ side == 0:
        side = _numbers([0, 1, 0])
    y = side / mp.sqrt(side @ side)
    return np.array([x, y, _cross(x, y)], dtype=object)


def _axes(joint: Spring) -> Array:
    return _numbers(joint.axes)


def _six(axes: Array, vector: Array) -> Array:
    return np.concatenate([axes @ vector[:3], axes @ vector[3:]])


def _pitched(joint: Spring) -> Array:
    """What the springs act on, by the displacement in the joint's axes: along z what a screw's advance leaves."""
    out = _numbers(np.eye(6))
    out[2, 5] = -mp.mpf(joint.pitch) / (2 * mp.pi)
    return out


def _apart() -> Array:
    return _numbers(np.hstack([-np.eye(6), np.eye(6)]))


def _arm(structure: Structure, master: str, slave: str) -> Array:
    """Slave - (master + rotation x arm), (6, 12)."""
    arm, out = _numbers(structure.nodes[slave]) - _numbers(structure.nodes[master]), _apart()
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[i, 3 + j], out[i, 3 + k] = -arm[k], arm[j]
    return out
