"""What mechanics demands of every frame: equilibrium, reciprocity, superposition, energy, rigid motion."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from linkframe.framework import Frame, Solution
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.as_frame import as_frame
from reference.compare import allowed, stacked
from reference.random_structures import few, load, structures
from reference.structure import COMPONENTS, LOADS, Structure

Array = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)


def displacements(solution: Solution, structure: Structure) -> Array:
    """Of all nodes, (..., n, 6)."""
    return stacked({name: solution.displacement(name) for name in structure.nodes})


def loaded(structure: Structure, cases: Array) -> Frame:
    """The structure under load cases (k, n, 6) on all its nodes."""
    frame = as_frame(structure, loaded=False)
    for i, node in enumerate(structure.nodes):
        frame.load(node, **dict(zip(LOADS, cases[:, i].T, strict=True)))
    return frame


def random_cases(structure: Structure, seed: int, count: int) -> Array:
    """Loads (k, n, 6)."""
    rng = np.random.default_rng(seed)
    return np.array([[load(rng) for _ in structure.nodes] for _ in range(count)])


@few
@given(structures, seeds)
def test_reciprocity(structure: Structure, seed: int) -> None:
    """Maxwell and Betti: the work of one load case on the displacements of another is mutual."""
    cases = random_cases(structure, seed, 2)
    solution = loaded(structure, cases).solve()
    u = displacements(solution, structure)
    work = np.einsum("ani,bni->ab", cases, u)
    bound = allowed(solution.scaled_condition_number()).max()
    # The mutual work may cancel; Cauchy's bound by the two own works is its natural size.
    assert abs(work[0, 1] - work[1, 0]) <= 10 * bound * np.sqrt(work[0, 0] * work[1, 1])


@few
@given(structures, seeds)
def test_superposition(structure: Structure, seed: int) -> None:
    """Displacements of a sum of loads, and of a multiple, are those of the parts."""
    p, q = random_cases(structure, seed, 2)
    solution = loaded(structure, np.array([p, q, 2.0 * p - 3.0 * q])).solve()
    u = displacements(solution, structure)
    size = np.abs(u).max(axis=(0, 1))
    bound = 10 * allowed(solution.scaled_condition_number()).max()
    assert np.all(np.abs(2.0 * u[0] - 3.0 * u[1] - u[2]) <= bound * size.max())


@few
@given(structures, seeds)
def test_equilibrium(structure: Structure, seed: int) -> None:
    """Reactions balance nodal, line and point loads: three forces, three moments about the origin."""
    rng = np.random.default_rng(seed)
    frame = as_frame(structure)
    forces: list[tuple[Array, Array, Array]] = []
    for node, (*force, mx, my, mz) in structure.loads.items():
        forces.append((np.array(structure.nodes[node]), np.array(force), np.array([mx, my, mz])))
    for name, member in structure.members.items():
        start, end = (np.array(structure.nodes[node]) for node in (member.start, member.end))
        length = float(np.linalg.norm(end - start))
        direction = (end - start) / length
        first, last, point, couple = rng.normal(size=(4, 3)) * 100
        x1, x2, at = 0.2 * length, 0.7 * length, 0.4 * length
        axes = dict(zip(("fx", "fy", "fz"), zip(first, last, strict=True), strict=True))
        frame.line_load(name, span=(x1, x2), **{key: tuple(map(float, pair)) for key, pair in axes.items()})
        frame.point_load(name, at=at, **dict(zip(LOADS, (*point, *couple), strict=True)))
        # A trapezium is two triangles, whose resultants act at the thirds of the span.
        for value, third in ((first, 1 / 3), (last, 2 / 3)):
            forces.append((start + direction * (x1 + third * (x2 - x1)), value * (x2 - x1) / 2, np.zeros(3)))
        forces.append((start + direction * at, point, couple))
    solution = frame.solve()
    for node in structure.supports:
        reaction = solution.reaction(node)
        forces.append((np.array(structure.nodes[node]), reaction[:3], reaction[3:]))
    total = sum(force for _, force, _ in forces)
    moment = sum(couple + np.cross(place, force) for place, force, couple in forces)
    size = max(np.abs(np.concatenate(part)).max() for part in forces)
    assert_allclose(
        np.concatenate([total, moment]), 0.0, atol=float(10 * allowed(solution.scaled_condition_number()) * size)
    )


def strain_energy(frame: Frame, structure: Structure, solution: Solution) -> Array:
    """Of the members, from their internal forces, plus that of the joints; 3 Gauss points, exact for linear forces."""
    points, weights = np.polynomial.legendre.leggauss(3)
    energy = np.zeros(solution.shape)
    for name, m in structure.members.items():
        length = float(frame.length(name))
        flexibility = 1 / np.array([m.E * m.A, m.ky * m.G * m.A, m.kz * m.G * m.A, m.G * m.J, m.E * m.Iy, m.E * m.Iz])
        forces = solution.forces(name, length * (1 + points) / 2)
        energy += np.einsum("...ki,i,k->...", forces**2, flexibility, weights) * length / 4
    for name in structure.joints:
        energy += (solution.joint_force(name) * solution.joint_displacement(name)).sum(axis=-1) / 2
    return energy


@few
@given(structures, seeds)
def test_castigliano(structure: Structure, seed: int) -> None:
    """The strain energy's derivative by a load is the displacement at it: central differences, exact for a parabola."""
    rng = np.random.default_rng(seed)
    node = list(structure.nodes)[int(rng.integers(1, len(structure.nodes)))]
    component = int(rng.integers(6))
    step = np.array([-1.0, 0.0, 1.0]) * (100.0 if component < 3 else 10.0)
    frame = as_frame(structure)
    frame.load(node, **{LOADS[component]: step})
    solution = frame.solve()
    energy = strain_energy(frame, structure, solution)
    derivative = (energy[2] - energy[0]) / (step[2] - step[0])
    bound = 100 * allowed(solution.scaled_condition_number()).max()
    assert abs(derivative - solution.displacement(node)[1, component]) <= bound * energy.max() / step[2]


@few
@given(structures)
def test_clapeyron(structure: Structure) -> None:
    """The strain energy is half the work of the loads."""
    frame = as_frame(structure)
    solution = frame.solve()
    work = sum(np.dot(p, solution.displacement(node)) for node, p in structure.loads.items()) / 2
    energy = strain_energy(frame, structure, solution)
    assert abs(work - energy) <= 10 * allowed(solution.scaled_condition_number()) * energy


@few
@given(structures, seeds)
def test_rigid_motion_costs_nothing(structure: Structure, seed: int) -> None:
    """All supports moved as one rigid body: nodes follow, joints stay shut, end forces and reactions are rounding.

    Rounding of what: of the forces that each end's own displacement alone would cause, E A/L |u| and its like.
    """
    shift, turn = 1e-3 * np.random.default_rng(seed).normal(size=(2, 3))

    def motion(place: tuple[float, ...]) -> Array:
        return np.concatenate([shift + np.cross(turn, place), turn])

    supports = {
        node: dict(zip(COMPONENTS, motion(structure.nodes[node]).tolist(), strict=True)) for node in structure.supports
    }
    moved = replace(structure, supports=supports, loads={})
    frame = as_frame(moved)
    solution = frame.solve()
    expected = stacked({node: motion(place) for node, place in structure.nodes.items()})
    bound = float(10 * allowed(solution.scaled_condition_number()))
    assert_allclose(displacements(solution, structure), expected, rtol=0, atol=bound * np.abs(expected).max())
    size = 1e-3 * max(m.E * m.A / float(frame.length(name)) for name, m in structure.members.items())
    for name in structure.members:
        assert_allclose(solution.end_forces(name), 0.0, atol=bound * size)
    for node in structure.supports:
        assert_allclose(solution.reaction(node), 0.0, atol=bound * size)
    for name in structure.joints:
        assert_allclose(solution.joint_displacement(name), 0.0, atol=bound * 1e-3)


@few
@given(structures)
def test_end_forces_balance_the_nodes(structure: Structure) -> None:
    """Each member is in equilibrium, and its end forces are its internal forces at the ends, minus at the start."""
    frame = as_frame(structure)
    solution = frame.solve()
    bound = float(10 * allowed(solution.scaled_condition_number()))
    for name in structure.members:
        length = float(frame.length(name))
        forces = solution.end_forces(name)
        start, end = solution.forces(name, np.array([0.0, length]))
        size = np.abs(forces).max() * max(1.0, length)
        assert_allclose(forces, np.concatenate([-start, end]), rtol=0, atol=bound * size)
        assert_allclose(forces[:3] + forces[6:9], 0.0, atol=bound * size)
        moment = forces[3:6] + forces[9:] + np.cross([length, 0.0, 0.0], forces[6:9])
        assert_allclose(moment, 0.0, atol=bound * size)
