"""Random frames and random linkages for the property tests, reproducible from one integer."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from .structure import COMPONENTS, Member, Spring, Structure, Vector

Rng = np.random.Generator
Array = NDArray[np.float64]
CLAMPED = dict.fromkeys(COMPONENTS, 0.0)


def vector(values: Array) -> Vector:
    """Three floats."""
    x, y, z = (float(value) for value in values)
    return x, y, z


def rotation(rng: Rng) -> Array:
    """A random right-handed orthonormal matrix, one in four of quarter turns."""
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    if rng.random() < 0.25:
        q = np.eye(3)[rng.permutation(3)] * np.sign(np.diag(q))
    turn: Array = q * np.sign(np.linalg.det(q))
    return turn


def member(rng: Rng, start: str, end: str, chord: Array) -> Member:
    """A steel-like bar of a tenth of its length or less, with or without shear."""
    length = float(np.linalg.norm(chord))
    y, z = length * rng.uniform(0.03, 0.1, size=2)
    up = np.cross(chord, rng.normal(size=3))
    E = 2e11 * rng.uniform(0.3, 1.2)
    ky, kz = rng.uniform(0.4, 0.9, size=2) if rng.random() < 0.5 else (np.inf, np.inf)
    return Member(
        start,
        end,
        E=E,
        G=E / 2.6,
        A=float(y * z),
        Iy=float(y * z**3 / 12),
        Iz=float(z * y**3 / 12),
        J=float(min(y, z) ** 3 * max(y, z) * 0.2),
        ky=float(ky),
        kz=float(kz),
        up=vector(up),
    )


def load(rng: Rng) -> tuple[float, ...]:
    """A random force of about 100 N and moment of about 10 N m."""
    return tuple(float(value) for value in rng.normal(size=6) * (100.0, 100.0, 100.0, 10.0, 10.0, 10.0))


def random_frame(seed: int) -> Structure:
    """A connected frame of 2 to 6 points, clamped at one or two, with some members ending in springy joints."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 7))
    # A jittered lattice keeps points apart.
    cells = rng.permutation(27)[:count]
    points = np.stack(np.unravel_index(cells, (3, 3, 3)), axis=-1) + rng.uniform(-0.3, 0.3, size=(count, 3))
    nodes = {f"n{i}": vector(point) for i, point in enumerate(points)}
    edges = {(int(rng.integers(i)), i) for i in range(1, count)}
    edges |= {(i, j) for i in range(count) for j in range(i + 1, count) if rng.random() < 0.2}
    members, joints = {}, {}
    for i, j in sorted(edges):
        end = f"n{j}"
        if rng.random() < 0.4:
            end = f"j{i}.{j}"
            nodes[end] = nodes[f"n{j}"]
            stiffness = tuple(float(10**value) for value in rng.uniform(5, 12, size=6))
            joints[f"joint{i}.{j}"] = Spring(end, f"n{j}", stiffness, columns(rotation(rng)))
        members[f"m{i}.{j}"] = member(rng, f"n{i}", end, points[j] - points[i])
    supports = {"n0": CLAMPED} | ({f"n{count - 1}": CLAMPED} if count > 2 and rng.random() < 0.4 else {})
    # Every node is loaded, so that nothing is exactly free of force and has no size to compare with.
    loads = {f"n{i}": load(rng) for i in range(count)}
    return Structure(nodes, members, joints, supports=supports, loads=loads)


def random_linkage(seed: int) -> Structure:
    """A four-bar in a random plane, no two neighbouring links in line, with compliant revolutes at B, D and E."""
    rng = np.random.default_rng(seed)
    turn = rotation(rng)
    corners = np.array([[0.0, 0.0], [0.1, 1.0], [1.1, 1.2], [1.0, 0.0]]) + rng.uniform(-0.25, 0.25, size=(4, 2))
    a, b, d, e = (vector(turn[:, :2] @ corner) for corner in corners)
    p = vector(turn @ np.array([*corners[1:3].mean(axis=0), 0.0]) + 0.2 * rng.normal(size=3))
    nodes = {"A": a, "B1": b, "B2": b, "P": p, "D1": d, "D2": d, "E1": e, "E2": e}
    ends = {"crank": ("A", "B1"), "arm1": ("B2", "P"), "arm2": ("P", "D1"), "rocker": ("D2", "E1")}
    chord = {name: np.subtract(nodes[end], nodes[start]) for name, (start, end) in ends.items()}
    members = {name: member(rng, *ends[name], chord[name]) for name in ends}
    joints = {}
    for name in "BDE":
        stiffness = (*(float(10**value) for value in rng.uniform(7, 12, size=5)), 0.0)
        joints[name] = Spring(f"{name}1", f"{name}2", stiffness, columns(turn))
    supports = {"A": CLAMPED, "E2": CLAMPED}
    return Structure(nodes, members, joints, supports=supports, loads={"P": load(rng), "D1": load(rng)})


def random_constrained(seed: int) -> Structure:
    """A random frame with rigid links, rollers on their ends, ideal joints and joints side by side, closing loops."""
    rng = np.random.default_rng(seed)
    frame = random_frame(seed)
    nodes, members, joints = dict(frame.nodes), dict(frame.members), dict(frame.joints)
    supports, loads, rigid = dict(frame.supports), dict(frame.loads), []
    for name, joint in frame.joints.items():
        ideal = tuple(np.inf if rng.random() < 0.5 else k for k in joint.stiffness)
        joints[name] = replace(joint, stiffness=ideal)
        if rng.random() < 0.3:
            second = tuple(np.inf if rng.random() < 0.3 else 1e6 for _ in range(6))
            axes = joint.axes if rng.random() < 0.5 else columns(rotation(rng))
            joints[f"{name} too"] = Spring(joint.second, joint.first, second, axes)
    for i in range(int(rng.integers(1, 4))):
        master, other = rng.choice(list(frame.nodes), size=2, replace=False)
        slave = f"s{i}"
        nodes[slave] = vector(np.array(nodes[master]) + rng.uniform(-0.4, 0.4, size=3))
        rigid.append((str(master), slave))
        loads[slave] = load(rng)
        kind = rng.random()
        if kind < 0.4:
            members[f"strut{i}"] = member(rng, slave, str(other), np.subtract(nodes[other], nodes[slave]))
        elif kind < 0.8 and master not in supports:
            held = rng.choice(COMPONENTS[:3], size=int(rng.integers(1, 3)), replace=False)
            # At a clamped master a roller would be redundant, and how they share the reaction would be undetermined.
            supports[slave] = {str(name): 0.0 for name in held}
        elif i:
            rigid.append((f"s{i - 1}", slave))
    return Structure(nodes, members, joints, tuple(rigid), supports, loads)


def columns(matrix: Array) -> tuple[Vector, Vector, Vector]:
    """A matrix as nested tuples, row by row."""
    first, second, third = (vector(row) for row in matrix)
    return first, second, third


def random_screws(seed: int) -> Structure:
    """A random frame whose joints are screws, some ideal but for their turning, some side by side with another."""
    rng = np.random.default_rng(seed)
    frame = random_frame(seed)
    joints = {}
    for name, joint in frame.joints.items():
        held = tuple(np.inf if k < 5 and rng.random() < 0.3 else value for k, value in enumerate(joint.stiffness))
        joints[name] = replace(joint, stiffness=held, pitch=float(rng.normal()))
        if rng.random() < 0.4:
            axes = joint.axes if rng.random() < 0.5 else columns(rotation(rng))
            second = tuple(np.inf if k == 2 and rng.random() < 0.3 else 1e6 for k in range(6))
            joints[f"{name} too"] = Spring(joint.second, joint.first, second, axes, float(rng.normal()))
    return replace(frame, joints=joints)


frames = st.integers(0, 2**32 - 1).map(random_frame)
linkages = st.integers(0, 2**32 - 1).map(random_linkage)
structures = frames | linkages
constrained = st.integers(0, 2**32 - 1).map(random_constrained)
screws = st.integers(0, 2**32 - 1).map(random_screws)

# Each example is a whole frame, solved two or three times.
few = settings(max_examples=25)
