"""Sensitivities of a result, from its adjoint: closed forms, and finite differences of whole solutions."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution
from numpy.testing import assert_allclose
from reference.as_frame import as_frame
from reference.four_bar import coordinates, four_bar
from reference.random_structures import random_frame, random_linkage, random_screws
from reference.structure import COMPONENTS, LOADS, Structure

E, LENGTH, DIAMETER = 2e11, 1.5, 0.02
INERTIA, AREA = np.pi * DIAMETER**4 / 64, np.pi * DIAMETER**2 / 4
READ: dict[str, Callable[[Solution, str], np.ndarray]] = {
    "displacement": Solution.displacement,
    "reaction": Solution.reaction,
    "joint_displacement": Solution.joint_displacement,
    "joint_force": Solution.joint_force,
}


def cantilever() -> Solution:
    """A bar clamped at its root, on a torsion spring at mid-length, under a tip force that varies over a batch."""
    beam = Beam(Circle(diameter=DIAMETER), Material(E=E, nu=0.3))
    frame = Frame()
    for name, x in {"A": 0.0, "B": LENGTH / 2, "C": LENGTH / 2, "D": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", beam, "A", "B")
    frame.add("CD", beam, "C", "D")
    frame.add("hinge", Joint(stiffness=(np.inf,) * 5 + (2e3,)), "B", "C")
    frame.fix("A")
    frame.load("D", fy=[10.0, -20.0, 40.0])
    return frame.solve()


def test_a_hinged_cantilever_in_closed_form() -> None:
    """u = F L^3 / 3 E I + F (L/2)^2 / k at the tip, by each of F, k, E, a root settlement and rotation, a misfit."""
    force, k = np.array([10.0, -20.0, 40.0]), 2e3
    found = cantilever().sensitivity("D", "uy")
    per_force = LENGTH**3 / (3 * E * INERTIA) + (LENGTH / 2) ** 2 / k
    assert_allclose(found.loads["D"][:, 1], np.full(3, per_force), rtol=1e-12)
    assert_allclose(found.loads["D"][:, 5], LENGTH**2 / (2 * E * INERTIA) + LENGTH / 2 / k, rtol=1e-12)
    assert_allclose(found.joints["hinge"][:, 5], -force * (LENGTH / 2) ** 2 / k**2, rtol=1e-12)
    assert_allclose(found.joints["hinge"][:, :5], 0.0, atol=0.0)
    by_modulus = sum(found.members[name].sum(axis=-1) for name in ("AB", "CD"))
    assert_allclose(by_modulus, -force * LENGTH**3 / (3 * E * INERTIA), rtol=1e-11)
    assert_allclose(found.supports["A"], [[0.0, 1.0, 0.0, 0.0, 0.0, LENGTH]] * 3, rtol=1e-12, atol=1e-12)
    assert_allclose(found.offsets["hinge"], [[0.0, 1.0, 0.0, 0.0, 0.0, LENGTH / 2]] * 3, rtol=1e-12, atol=1e-12)


def test_of_forces_in_closed_form() -> None:
    """The moment at the root is F L whatever the stiffness."""
    found = cantilever().sensitivity("A", "mz", "reaction")
    assert_allclose(found.loads["D"], [[0.0, -LENGTH, 0.0, 0.0, 0.0, -1.0]] * 3, rtol=1e-12, atol=1e-9)
    assert_allclose(found.joints["hinge"], 0.0, atol=1e-12)
    assert_allclose(found.members["AB"].sum(axis=-1), 0.0, atol=1e-8)
    hinge = cantilever().sensitivity("hinge", "mz", "joint_force")
    assert_allclose(hinge.loads["D"][:, 1], LENGTH / 2, rtol=1e-12)
    assert_allclose(hinge.joints["hinge"], 0.0, atol=1e-12)


Made = Callable[[int], Structure]


@cache
def solved(make: Made, seed: int) -> Solution:
    """A random structure as it is."""
    return as_frame(make(seed)).solve()


@cache
def changed(make: Made, seed: int) -> dict[tuple[str, int], tuple[float, Solution, Solution]]:
    """The same with one input more and less by a step, of which each kind of result is read."""
    structure = make(seed)
    node, joint, member = (next(iter(of)) for of in (structure.loads, structure.joints, structure.members))
    support = list(structure.supports)[-1]

    def loaded(k: int, step: float) -> Structure:
        load = list(structure.loads[node])
        load[k] += step
        return replace(structure, loads={**structure.loads, node: tuple(load)})

    def softer(k: int, step: float) -> Structure:
        springs = list(structure.joints[joint].stiffness)
        springs[k] *= 1.0 + step
        other = replace(structure.joints[joint], stiffness=tuple(springs))
        return replace(structure, joints={**structure.joints, joint: other})

    def stiffer(_: int, step: float) -> Structure:
        one = structure.members[member]
        other = replace(one, E=one.E * (1.0 + step), G=one.G * (1.0 + step))
        return replace(structure, members={**structure.members, member: other})

    def settled(k: int, step: float) -> Structure:
        values = {**structure.supports[support], COMPONENTS[k]: step}
        return replace(structure, supports={**structure.supports, support: values})

    finite = [k for k, stiffness in enumerate(structure.joints[joint].stiffness) if 0.0 < stiffness < np.inf]
    changes = [(loaded, k, 1.0) for k in range(6)] + [(softer, k, 1e-3) for k in finite]
    changes += [(stiffer, 0, 1e-3), *((settled, k, 1e-3) for k in range(6))]
    return {
        (change.__name__, k): (step, *(as_frame(change(k, sign * step)).solve() for sign in (1.0, -1.0)))
        for change, k, step in changes
    }


@pytest.mark.parametrize(
    ("make", "seed", "index"),
    [(random_frame, 3, 1), (random_linkage, 3, 1), (random_screws, 7, 5)],
)
@pytest.mark.parametrize("kind", READ)
def test_finite_differences(make: Made, seed: int, index: int, kind: str) -> None:
    """By central differences of the inputs, to 1e-6 of the result, and where told to 1e-7 of the difference as well."""
    structure = make(seed)
    name = {"displacement": list(structure.loads)[-1], "reaction": next(iter(structure.supports))}.get(
        kind, next(iter(structure.joints))
    )
    component = (LOADS if kind in ("reaction", "joint_force") else COMPONENTS)[index]
    found = solved(make, seed).sensitivity(name, component, kind)
    value = abs(READ[kind](solved(make, seed), name)[index])

    def difference(change: str, k: int = 0) -> float:
        step, *both = changed(make, seed)[change, k]
        up, down = (READ[kind](solution, name)[index] for solution in both)
        return float((up - down) / (2 * step))

    node, joint, member = (next(iter(of)) for of in (structure.loads, structure.joints, structure.members))
    for k in range(6):
        assert_allclose(found.loads[node][k], difference("loaded", k), atol=1e-8 * value, rtol=1e-6)
    for k, stiffness in enumerate(structure.joints[joint].stiffness):
        if 0.0 < stiffness < np.inf:
            assert_allclose(found.joints[joint][k] * stiffness, difference("softer", k), atol=1e-6 * value, rtol=1e-7)
    assert_allclose(found.members[member].sum(), difference("stiffer"), atol=1e-6 * value, rtol=1e-7)
    support = list(structure.supports)[-1]
    for k in range(6):
        expected = difference("settled", k)
        assert_allclose(found.supports[support][k], expected, atol=1e-6 * max(value, abs(expected)))


def test_mechanisms_and_what_is_not_offered() -> None:
    solution = as_frame(four_bar(coordinates(0.0), (0.0, 100.0, 0.0, 0.0, 0.0, 0.0))).solve()
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.sensitivity("P", "uy").loads["P"]).all()
    with pytest.raises(FrameError, match="end forces"):
        solution.sensitivity("crank", "fx", "end_forces")
    with pytest.raises(FrameError, match="uw"):
        solution.sensitivity("P", "uw")


def test_of_one_component_one_adjoint_is_solved() -> None:
    """Each the same as all six together give."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Circle(diameter=0.02), Material(E=np.array([2e11, 1e11]), nu=0.3)), "A", "B")
    frame.fix("A")
    frame.load("B", fy=10.0, fz=3.0)
    solution = frame.solve()
    ((_, whole),) = solution.bounds.adjoints("B", "displacement")
    for index in range(6):
        ((_, one),) = solution.bounds.influence("B", "displacement", index)
        assert len(one.coordinates) == 1
        np.testing.assert_allclose(one.rough[0], whole.rough[index], rtol=1e-13, atol=1e-22)
