"""Open chains of 2 to 2000 links: their tip displacement link by link in 50 digits, without any matrix."""

from __future__ import annotations

from typing import Any

import numpy as np
from reference.random_structures import CLAMPED, columns, member, rotation, vector
from reference.stiffness_method import EXACT, cross, member_axes, tip_stiffness
from reference.structure import Spring, Structure

Array = np.ndarray[Any, np.dtype[Any]]


def chain(links: float) -> Structure:
    """A clamped chain of so many links in space, a compliant joint before each but the first, loaded at its tip."""
    rng = np.random.default_rng(int(links))
    place = np.zeros(3)
    nodes, members, joints = {"s0": vector(place)}, {}, {}
    for k in range(int(links)):
        step = rng.normal(size=3)
        start, place = f"s{k}", place + step / np.linalg.norm(step)
        if k:
            nodes[start] = nodes[f"e{k - 1}"]
            stiffness = tuple(float(10**value) for value in rng.uniform(4, 12, size=6))
            joints[f"j{k}"] = Spring(f"e{k - 1}", start, stiffness, columns(rotation(rng)))
        nodes[f"e{k}"] = vector(place)
        members[f"m{k}"] = member(rng, start, f"e{k}", np.subtract(nodes[f"e{k}"], nodes[start]))
    tip = f"e{int(links) - 1}"
    return Structure(nodes, members, joints, supports={"s0": CLAMPED}, loads={tip: (1.0, -2.0, 3.0, 4.0, 5.0, -6.0)})


def tip(structure: Structure) -> Array:
    """Displacement of the tip (6,): each link and joint bends under the load carried to it, and moves all beyond."""
    (name,) = structure.loads
    load = EXACT.array(structure.loads[name])
    end = EXACT.array(structure.nodes[name])
    total: Array = EXACT.array(np.zeros(6))
    for link in structure.members.values():
        start, stop = (EXACT.array(structure.nodes[node]) for node in (link.start, link.end))
        chord = stop - start
        axes = member_axes(chord, EXACT.array(link.up), EXACT)
        length = EXACT.sqrt(chord @ chord)
        local = _turned(axes, _carried(load, end - stop))
        bent = EXACT.solve(tip_stiffness(link, length, EXACT), local)
        total = total + _moved(_turned(axes.T, bent), end - stop)
    for joint in structure.joints.values():
        at = EXACT.array(structure.nodes[joint.first])
        axes = EXACT.array(joint.axes)
        opened = _turned(axes.T, _carried(load, end - at)) / EXACT.array(joint.stiffness)
        total = total + _moved(_turned(axes, opened), end - at)
    return total


def _turned(axes: Array, vector: Array) -> Array:
    return np.concatenate([axes @ vector[:3], axes @ vector[3:]])


def _carried(load: Array, arm: Array) -> Array:
    """A load at the end of an arm as felt at its root."""
    return np.concatenate([load[:3], load[3:] + cross(arm, load[:3])])


def _moved(motion: Array, arm: Array) -> Array:
    """A motion of the root as it shows at the end of the arm."""
    return np.concatenate([motion[:3] + cross(motion[3:], arm), motion[3:]])
