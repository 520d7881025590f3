"""The axes along which results are tried, from easy to hopeless: structures of plain floats by position on the axis."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf

import numpy as np
from reference.four_bar import coordinates, four_bar
from reference.random_structures import CLAMPED, columns, member, rotation, vector
from reference.structure import Member, Spring, Structure

Build = Callable[[float], Structure]


@dataclass(frozen=True)
class Axis:
    """What varies, what it is called in a figure, and where it is tried in the short and in the long form."""

    name: str
    label: str
    build: Build
    short: tuple[float, ...]
    long: tuple[float, ...]


def bar(start: str, end: str, **given: float) -> Member:
    """A steel bar of 20 by 10 mm, with what is given instead."""
    of: dict[str, float] = {"E": 2e11, "G": 8e10, "A": 2e-4, "Iy": 1.7e-9, "Iz": 6.7e-9, "J": 4.6e-9} | given
    return Member(start, end, **of)


def jointed(stiffness: float) -> Structure:
    """Two bars at an angle, clamped at their far ends, with six equal springs between them."""
    nodes = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.3, 0.0), "C": (1.0, 0.3, 0.0), "D": (1.4, -0.5, 0.7)}
    members = {"AB": bar("A", "B"), "CD": bar("C", "D")}
    joints = {"joint": Spring("B", "C", (stiffness,) * 6)}
    loads = {"B": (10.0, -20.0, 5.0, 1.0, 2.0, 3.0)}
    return Structure(nodes, members, joints, supports={"A": CLAMPED, "D": CLAMPED}, loads=loads)


def near_singular(degrees: float) -> Structure:
    """The paper's four-bar at so many degrees from the pose in which coupler and rocker lie in line."""
    return four_bar(coordinates(degrees), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))


def slender(ratio: float) -> Structure:
    """A bent cantilever on a prop, with members so many times as long as thick."""
    h = 1.0 / ratio
    section = {"A": h * h, "Iy": h**4 / 12, "Iz": h**4 / 12, "J": 0.14 * h**4, "ky": 5 / 6, "kz": 5 / 6}
    nodes = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.2), "C": (1.0, 1.0, 0.0)}
    members = {"AB": bar("A", "B", **section), "BC": bar("B", "C", **section)}
    supports = {"A": CLAMPED, "C": {"ux": 0.0, "uy": 0.0, "uz": 0.0}}
    return Structure(nodes, members, supports=supports, loads={"B": (10.0, -20.0, 5.0, 1.0, 2.0, 3.0)})


def short_stiff(length: float) -> Structure:
    """A short stiff bar between two long flexible ones."""
    nodes = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "C": (1.0, length, 0.0), "D": (2.0, length, 0.5)}
    stout = {"A": 2e-2, "Iy": 1.7e-5, "Iz": 6.7e-5, "J": 4.6e-5}
    members = {"AB": bar("A", "B"), "BC": bar("B", "C", **stout), "CD": bar("C", "D")}
    loads = {"C": (10.0, -20.0, 5.0, 1.0, 2.0, 3.0)}
    return Structure(nodes, members, supports={"A": CLAMPED, "D": CLAMPED}, loads=loads)


def moduli(ratio: float) -> Structure:
    """Two bars of which the second is so many times as stiff."""
    nodes = {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.1), "C": (1.0, 1.0, 0.0)}
    members = {"AB": bar("A", "B"), "BC": bar("B", "C", E=2e11 * ratio, G=8e10 * ratio)}
    loads = {"B": (10.0, -20.0, 5.0, 1.0, 2.0, 3.0)}
    return Structure(nodes, members, supports={"A": CLAMPED, "C": CLAMPED}, loads=loads)


def loaded(size: float) -> Structure:
    """Two bars under a load of this size."""
    forces = tuple(size * part for part in (10.0, -20.0, 5.0, 1.0, 2.0, 3.0))
    return replace(moduli(1.0), loads={"B": forces})


def coincident(distance: float) -> Structure:
    """A bar so long between two others: its nodes almost coincide."""
    nodes = {"A": (0.3, 0.0, 0.0), "B": (1.3, 0.2, 0.0), "C": (1.3 + distance, 0.2, 0.0), "D": (2.0, 0.4, 0.5)}
    members = {"AB": bar("A", "B"), "BC": bar("B", "C"), "CD": bar("C", "D")}
    loads = {"C": (10.0, -20.0, 5.0, 1.0, 2.0, 3.0)}
    return Structure(nodes, members, supports={"A": CLAMPED, "D": CLAMPED}, loads=loads)


def loop(links: float) -> Structure:
    """A spatial loop of so many links with compliant joints of random axes between them, clamped where it closes."""
    count = int(links)
    rng = np.random.default_rng(count)
    turn = 2 * np.pi * np.arange(count + 1) / (count + 1)
    corners = np.stack([np.cos(turn), np.sin(turn), 0.0 * turn], axis=1) + rng.uniform(-0.3, 0.3, (count + 1, 3))
    nodes, members, joints = {}, {}, {}
    for k in range(count):
        start, end = f"s{k}", f"e{k}"
        nodes[start], nodes[end] = vector(corners[k]), vector(corners[k + 1])
        members[f"m{k}"] = member(rng, start, end, corners[k + 1] - corners[k])
        if k:
            stiffness = (*(float(10**value) for value in rng.uniform(4, 12, size=5)), 10.0)
            joints[f"j{k}"] = Spring(f"e{k - 1}", start, stiffness, columns(rotation(rng)))
    loads = {f"e{k}": tuple(float(v) for v in rng.normal(size=6) * (100.0,) * 6) for k in range(count - 1)}
    return Structure(nodes, members, joints, supports={"s0": CLAMPED, f"e{count - 1}": CLAMPED}, loads=loads)


# Lengths and forces of one metre and one newton in other units.
UNITS = {
    f"{length}, {force}": (a, b)
    for length, a in {"m": 1.0, "mm": 1e3, "µm": 1e6, "in": 1 / 0.0254}.items()
    for force, b in {"N": 1.0, "kN": 1e-3, "lbf": 1 / 4.4482216152605}.items()
}


def in_units(structure: Structure, a: float, b: float) -> Structure:
    """The structure with lengths multiplied by `a` and forces by `b`, each number rounded once."""
    pressure, rotational = b / (a * a), b * a
    members = {
        name: replace(
            m,
            E=m.E * pressure,
            G=m.G * pressure,
            A=m.A * (a * a),
            Iy=m.Iy * a**4,
            Iz=m.Iz * a**4,
            J=m.J * a**4,
        )
        for name, m in structure.members.items()
    }
    units = (b / a,) * 3 + (rotational,) * 3
    joints = {
        name: replace(j, stiffness=tuple(k * unit for k, unit in zip(j.stiffness, units, strict=True)))
        for name, j in structure.joints.items()
    }
    nodes = {name: tuple(x * a for x in place) for name, place in structure.nodes.items()}
    forces = (b,) * 3 + (rotational,) * 3
    loads = {
        name: tuple(f * unit for f, unit in zip(load, forces, strict=True)) for name, load in structure.loads.items()
    }
    return replace(structure, nodes=nodes, members=members, joints=joints, loads=loads)


def units(number: float) -> Structure:
    """The four-bar at 30 degrees in one of the systems of units."""
    linkage = four_bar(coordinates(30.0), (10.0, 100.0, 5.0, 1.0, 2.0, 3.0))
    return in_units(linkage, *list(UNITS.values())[int(number)])


def _decades(low: int, high: int, step: float = 1.0) -> tuple[float, ...]:
    return tuple(float(f"{10.0**power:.3g}") for power in np.arange(low, high + step / 2, step))


AXES = (
    Axis(
        "joint stiffness",
        "stiffness of the joint [N/m, N m/rad]",
        jointed,
        (1e-6, 1.0, 1e10, 1e20, inf),
        (*_decades(-6, 20), inf),
    ),
    Axis(
        "distance to singularity",
        "degrees from the singular pose",
        near_singular,
        (10.0, 0.1, 1e-4, 1e-6, 1e-9),
        _decades(-9, 1, 0.5),
    ),
    Axis("slenderness", "length over thickness", slender, (0.1, 10.0, 1e4), _decades(-1, 4, 0.25)),
    Axis("short stiff member", "length of the stiff member [m]", short_stiff, (1.0, 1e-3, 1e-6), _decades(-9, 0, 0.5)),
    Axis("units", "number of the system of units", units, (0, 4, 11), tuple(range(len(UNITS)))),
    Axis("closed loop", "links in the loop", loop, (3, 6), (3, 4, 5, 6, 8, 10, 12)),
    Axis("ratio of moduli", "E of one member over that of the other", moduli, (1.0, 1e6, 1e12), _decades(0, 12, 0.5)),
    Axis("load", "decimal logarithm of the load [N, N m]", loaded, (1e-300, 1.0, 1e300), _decades(-300, 300, 25)),
    Axis("coincident nodes", "distance of two nodes [m]", coincident, (1e-1, 1e-6, 1e-12), _decades(-12, 0, 0.5)),
)
