"""What must not change a frame: turning, mirroring, units, order, names, direction of members and joints."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, Solution
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.as_frame import as_frame
from reference.compare import FORCES, allowed, apart, stacked
from reference.random_structures import columns, rotation, structures, vector
from reference.structure import Member, Spring, Structure

Array = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
# Each of seven invariances at as many structures.
some = settings(max_examples=15)


def results(solution: Solution, structure: Structure) -> list[Array]:
    """Displacements of nodes, reactions; displacements and forces of joints; (n, 6) each."""
    found = [
        stacked({name: solution.displacement(name) for name in structure.nodes}),
        stacked({name: solution.reaction(name) for name in structure.supports}),
    ]
    if structure.joints:
        found.append(stacked({name: solution.joint_displacement(name) for name in structure.joints}))
        found.append(stacked({name: solution.joint_force(name) for name in structure.joints}))
    return found


def assert_same(changed: list[Array], original: list[Array], bound: Array) -> None:
    """Displacements to the numerical contract, forces to FORCES times it; both sides carry their error."""
    for one, other, factor in zip(changed, original, (1.0, FORCES, FORCES, FORCES), strict=False):
        assert apart(one, other) <= 2 * factor * bound


def solved(structure: Structure) -> tuple[Solution, list[Array], Array]:
    """Solution, its results, and the error that the contract allows."""
    solution = as_frame(structure).solve()
    return solution, results(solution, structure), allowed(solution.scaled_condition_number())


def moved(structure: Structure, matrix: Array, shift: Array) -> Structure:
    """The structure turned or mirrored by an orthogonal matrix, and shifted; polar and axial vectors as they should."""
    hand = float(np.linalg.det(matrix))

    def both(load: tuple[float, ...]) -> tuple[float, ...]:
        return (*vector(matrix @ load[:3]), *vector(hand * (matrix @ load[3:])))

    def member(m: Member) -> Member:
        return replace(m, up=vector(matrix @ np.array(m.up)))

    def joint(j: Spring) -> Spring:
        return replace(j, axes=columns(hand * matrix @ np.array(j.axes)))

    return Structure(
        nodes={name: vector(matrix @ np.array(place) + shift) for name, place in structure.nodes.items()},
        members={name: member(m) for name, m in structure.members.items()},
        joints={name: joint(j) for name, j in structure.joints.items()},
        supports=structure.supports,
        loads={name: both(load) for name, load in structure.loads.items()},
    )


def assert_moves_along(structure: Structure, matrix: Array, shift: Array) -> None:
    """Global results turn with the structure; those in joint axes do not, but that a mirror flips the axes' sense."""
    hand = float(np.linalg.det(matrix))
    _, original, bound = solved(structure)
    solution, changed, _ = solved(moved(structure, matrix, shift))
    assert solution.status == "regular"
    turn = np.zeros((6, 6))
    turn[:3, :3], turn[3:, 3:] = matrix, hand * matrix
    flip = np.array([hand, hand, hand, 1.0, 1.0, 1.0])
    expected = [found @ turn.T for found in original[:2]] + [found * flip for found in original[2:]]
    # The axes of members and joints are turned in floats too: some eps, amplified like any other rounding.
    assert_same(changed, expected, 4 * bound)


@some
@given(structures, seeds)
def test_turning_and_shifting(structure: Structure, seed: int) -> None:
    """A rigid motion of the whole model turns its results and changes nothing else."""
    rng = np.random.default_rng(seed)
    assert_moves_along(structure, rotation(rng), rng.normal(size=3))


@some
@given(structures, seeds)
def test_mirroring(structure: Structure, seed: int) -> None:
    """A mirror image has mirrored displacements (polar) and rotations (axial)."""
    normal = rotation(np.random.default_rng(seed))[0]
    assert_moves_along(structure, np.eye(3) - 2 * np.outer(normal, normal), np.zeros(3))


@some
@given(structures, st.sampled_from([1e3, 1e-3, 39.37]), st.sampled_from([1e-3, 1e6, 0.2248]))
def test_units(structure: Structure, length: float, force: float) -> None:
    """Millimetres and kilonewtons in place of metres and newtons: the same mechanics, the same status."""
    pressure = force / length**2
    moment = force * length

    def member(m: Member) -> Member:
        area, inertia = length**2, length**4
        return replace(
            m, E=m.E * pressure, G=m.G * pressure, A=m.A * area, Iy=m.Iy * inertia, Iz=m.Iz * inertia, J=m.J * inertia
        )

    springs = [force / length] * 3 + [moment] * 3
    loads = [force] * 3 + [moment] * 3
    scaled = Structure(
        nodes={name: vector(length * np.array(place)) for name, place in structure.nodes.items()},
        members={name: member(m) for name, m in structure.members.items()},
        joints={
            name: replace(j, stiffness=tuple(float(k * f) for k, f in zip(j.stiffness, springs, strict=True)))
            for name, j in structure.joints.items()
        },
        supports=structure.supports,
        loads={
            name: tuple(float(p * f) for p, f in zip(p6, loads, strict=True)) for name, p6 in structure.loads.items()
        },
    )
    _, original, bound = solved(structure)
    solution, changed, _ = solved(scaled)
    assert solution.status == "regular"
    displacement, reaction = np.array([length] * 3 + [1.0] * 3), np.array(loads)
    factors = (displacement, reaction, displacement, reaction)
    assert_same(changed, [found * factor for found, factor in zip(original, factors, strict=False)], 2 * bound)


@some
@given(structures, seeds)
def test_order_of_description(structure: Structure, seed: int) -> None:
    """Nodes, members, joints, supports and loads given in another order."""
    rng = np.random.default_rng(seed)

    def shuffled(field: str) -> dict[str, Any]:
        things = list(getattr(structure, field).items())
        return dict(things[i] for i in rng.permutation(len(things)))

    nodes, members, joints = shuffled("nodes"), shuffled("members"), shuffled("joints")
    other = Structure(nodes, members, joints, supports=shuffled("supports"), loads=shuffled("loads"))
    _, original, bound = solved(structure)
    solution = as_frame(other).solve()
    assert_same(results(solution, structure), original, bound)


@some
@given(structures)
def test_members_from_end_to_start(structure: Structure) -> None:
    """A member described from its other end: same displacements, reactions and joints."""
    turned = {name: replace(m, start=m.end, end=m.start) for name, m in structure.members.items()}
    _, original, bound = solved(structure)
    _, changed, _ = solved(replace(structure, members=turned))
    assert_same(changed, original, bound)


@some
@given(structures)
def test_joints_from_second_to_first(structure: Structure) -> None:
    """A joint (C, B) in place of (B, C): its displacement and force change sign, nothing else changes."""
    turned = {name: replace(j, first=j.second, second=j.first) for name, j in structure.joints.items()}
    _, original, bound = solved(structure)
    _, changed, _ = solved(replace(structure, joints=turned))
    assert_same(changed, original[:2] + [-found for found in original[2:]], bound)


@some
@given(structures, st.integers(2, 5))
def test_segments(structure: Structure, segments: int) -> None:
    """Cutting members into segments changes nothing: the elements are exact.

    The finer frame's condition is worse (a segment is stiffer by the cube of their number), so its bound counts.
    """
    original = results(as_frame(structure).solve(), structure)
    solution = as_frame(structure, segments=segments).solve()
    assert_same(results(solution, structure), original, allowed(solution.scaled_condition_number()))


def test_segments_of_a_portal() -> None:
    """Plainly 1e-12: end forces, forces along a member and displacement of a portal under line and point loads."""

    def portal(segments: int) -> Solution:
        frame = Frame()
        for name, place in {"a": (0, 0, 0), "b": (0, 3, 0), "c": (4, 3, 0.5), "d": (4, 0, 0.5)}.items():
            frame.node(name, place)
        beam = Beam(Rectangle(y=0.2, z=0.1), Material(E=200e9, nu=0.3, density=7850.0), shear=True, segments=segments)
        for start, end in ("ab", "bc", "cd"):
            frame.add(start + end, beam, start, end)
        frame.fix("a")
        frame.fix("d")
        frame.gravity((0.0, -9.81, 0.0))
        frame.line_load("bc", fy=(-1e3, -4e3), span=(0.3, 2.9))
        frame.point_load("ab", at=1.7, fx=5e3, mz=200.0)
        return frame.solve()

    one, many = portal(1), portal(7)
    x = np.array([0.0, 0.2, 1.0, 1.69, 1.71, 2.9])
    for member in ("ab", "bc", "cd"):
        for what in ("forces", "displacement_along"):
            a, b = getattr(one, what)(member, x), getattr(many, what)(member, x)
            assert_allclose(b, a, rtol=0, atol=1e-11 * np.abs(a).max(axis=0).max())
        assert_allclose(
            many.end_forces(member), one.end_forces(member), rtol=0, atol=1e-11 * np.abs(one.end_forces(member)).max()
        )
    ours, theirs = (np.stack([s.displacement(name) for name in "bc"]) for s in (many, one))
    assert apart(ours, theirs) < 1e-12
