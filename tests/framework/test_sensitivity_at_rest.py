"""Sensitivities where nothing is loaded: those by loads, offsets and supports are what they are under any load."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, MechanismWarning, Solution
from numpy.testing import assert_allclose
from reference.as_frame import as_frame
from reference.random_structures import random_frame, random_linkage, random_screws
from reference.structure import COMPONENTS, LOADS, Structure

Array = np.ndarray[Any, np.dtype[Any]]
METHODS = ("broadcast", "banded", "sparse", "iterative")
READ: dict[str, Callable[[Solution, str], Array]] = {
    "displacement": Solution.displacement,
    "reaction": Solution.reaction,
    "joint_displacement": Solution.joint_displacement,
    "joint_force": Solution.joint_force,
}
ROD = Beam(Circle(diameter=0.02), Material(E=210e9, nu=0.3))


def hinge(**load: Any) -> Frame:
    """Two rods at a right angle with a joint between them, clamped at one end."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0.4, 0, 0), "C": (0.4, 0, 0), "D": (0.4, 0.3, 0)}.items():
        frame.node(name, np.array(place, dtype=float))
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", ROD, "C", "D")
    frame.add("hinge", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 50.0)), "B", "C")
    frame.fix("A")
    if load:
        frame.load("D", **load)
    return frame


@pytest.mark.parametrize("load", [{}, {"fx": 0.0}, {"fx": 1.0}, {"fz": 1.0}, {"fx": [0.0, 1.0, 0.0]}])
@pytest.mark.parametrize("method", METHODS)
def test_an_offset_moves_the_tip_whatever_the_load(load: dict[str, Any], method: str) -> None:
    """By one across the joint, by the arm where it turns; out of the plane too, where a load in it does not reach."""
    solution = hinge(**load).solve(method)
    for component, expected in {"ux": [1, 0, 0, 0, 0, -0.3], "uz": [0, 0, 1, 0.3, 0, 0]}.items():
        found = solution.sensitivity("D", component)
        assert_allclose(found.offsets["hinge"], np.broadcast_to(expected, (*solution.shape, 6)), atol=1e-9)
    assert_allclose(found.supports["A"][..., 2], 1.0, rtol=1e-9)
    bending = 0.4**3 / (3 * ROD.material.E * ROD.section.Iy)
    assert np.all(found.loads["D"][..., 2] > bending)
    assert not found.members["AB"].any() or "fz" in load


@settings(max_examples=6)
@given(
    st.sampled_from([random_frame, random_linkage, random_screws]),
    st.integers(0, 10_000),
    st.sampled_from(METHODS),
    st.sampled_from(sorted(READ)),
    st.integers(0, 5),
)
def test_at_rest_they_are_those_under_load(
    make: Callable[[int], Structure], seed: int, method: str, kind: str, index: int
) -> None:
    """And differences of the result itself, which is linear in loads, offsets and prescribed displacements."""
    loaded = make(seed)
    name = {"displacement": list(loaded.loads)[-1], "reaction": next(iter(loaded.supports))}.get(
        kind, next(iter(loaded.joints), "")
    )
    if not name:
        kind, name = "displacement", list(loaded.loads)[-1]
    what = (LOADS if kind in ("reaction", "joint_force") else COMPONENTS)[index]
    rest = replace(loaded, loads={})
    zero = replace(loaded, loads=dict.fromkeys(loaded.loads, (0.0,) * 6))
    some = replace(loaded, loads={n: tuple(np.array([0.0, v]) for v in load) for n, load in loaded.loads.items()})
    truth = as_frame(loaded).solve().sensitivity(name, what, kind)
    forces = kind in ("reaction", "joint_force")
    natural = {"loads": 1.0 if forces else 0.0, "offsets": 1.0, "supports": 1.0}
    if forces:  # what does not depend on a displacement is zero to the rounding of the stiffnesses that it is made of
        natural |= dict.fromkeys(("offsets", "supports"), stiffest(loaded))
    unit = {group: max(least, size(getattr(truth, group))) for group, least in natural.items()}
    for structure in (rest, zero, some):
        found = as_frame(structure).solve(method).sensitivity(name, what, kind)
        for group in unit:
            for key, value in getattr(truth, group).items():
                scale = unit[group]
                assert_allclose(getattr(found, group)[key] / scale, np.broadcast_to(
                    value / scale, getattr(found, group)[key].shape), atol=1e-7)  # fmt: skip
    found = as_frame(rest).solve(method).sensitivity(name, what, kind)

    def difference(change: Callable[[Frame, float], None]) -> float:
        values = []
        for step in (1.0, -1.0):
            frame = as_frame(rest)
            change(frame, step)
            values.append(READ[kind](frame.solve(), name)[index])
        return float(values[0] - values[1]) / 2.0

    node, support = next(iter(loaded.loads)), next(iter(loaded.supports))
    by_load = difference(lambda frame, step: frame.load(node, **{LOADS[index]: step}))
    assert_allclose(found.loads[node][index] / unit["loads"], by_load / unit["loads"], atol=1e-7)
    by_support = difference(lambda frame, step: frame.prescribe(support, **{COMPONENTS[index]: step}))
    assert_allclose(found.supports[support][index] / unit["supports"], by_support / unit["supports"], atol=1e-7)
    for joint in list(loaded.joints)[:1]:
        by_offset = difference(lambda frame, step, joint=joint: frame.offset(joint, **{COMPONENTS[index]: step}))
        assert_allclose(found.offsets[joint][index] / unit["offsets"], by_offset / unit["offsets"], atol=1e-7)


def stiffest(structure: Structure) -> float:
    """Greatest stiffness of a joint or member."""
    joints = [k for joint in structure.joints.values() for k in joint.stiffness if np.isfinite(k)]
    return max(joints + [member.E * member.A for member in structure.members.values()])


def size(group: dict[str, Array]) -> float:
    """Greatest derivative of a group."""
    return max((float(np.abs(value).max()) for value in group.values()), default=0.0) or 1.0


@pytest.mark.parametrize("method", ["broadcast", "sparse"])
def test_what_can_move_without_a_load_has_none(method: str) -> None:
    """A pin that is free to turn: across it NaN with a warning, along the rods the derivative that there is."""
    frame = hinge()
    frame.joints.pop("hinge")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 0.0)), "B", "C")
    solution = frame.solve(method)
    assert solution.status == "statically consistent mechanism"
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.sensitivity("D", "ux").loads["D"]).all()
    assert_allclose(solution.sensitivity("D", "uz").offsets["pin"][2], 1.0, rtol=1e-9)


def test_what_can_move_without_a_load_has_none_beside_loaded_entries() -> None:
    """The entry at rest as alone: NaN across the pin, along the rods the derivative that there is."""
    frame = hinge()
    frame.joints.pop("hinge")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 0.0)), "B", "C")
    frame.load("D", fz=[3.0, 0.0])
    solution = frame.solve("broadcast")
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.sensitivity("D", "ux").loads["D"]).all()
    assert_allclose(solution.sensitivity("D", "uz").offsets["pin"][:, 2], 1.0, rtol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_other_readers_at_rest(method: str) -> None:
    """Nothing moves, exactly; how regular the frame is does not depend on its load."""
    rest, loaded = hinge(fx=0.0).solve(method), hinge(fx=1.0, fz=1.0, mz=1.0).solve(method)
    assert rest.status == "regular"
    for name, kind in (("D", "displacement"), ("A", "reaction"), ("hinge", "joint_force"), ("AB", "end_forces")):
        refined, left = rest.refined(name, kind)
        assert not refined.any()
        assert not left.any()
        assert not rest.error_bound(name, kind).any()
    assert_allclose(rest.condition_number(), loaded.condition_number(), rtol=1e-6)
    assert_allclose(rest.scaled_condition_number(), loaded.scaled_condition_number(), rtol=1e-6)
    assert rest.distance_to_singularity() == pytest.approx(float(loaded.distance_to_singularity()), rel=0.1)
    assert rest.linear
    assert rest.nonlinearity() == 0.0
