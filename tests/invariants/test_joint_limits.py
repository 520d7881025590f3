"""Joints from soft to ideal: the limits that a stiffness of 0, 1e20 and inf must reach."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.as_frame import as_frame
from reference.compare import allowed, apart, stacked
from reference.random_structures import few, linkages, structures
from reference.stiffness_method import solve
from reference.structure import Structure

Array = NDArray[np.float64]


def stiffened(structure: Structure, stiffness: float) -> Structure:
    """All springs but free ones at `stiffness`."""
    joints = {
        name: replace(joint, stiffness=tuple(stiffness if k > 0 else 0.0 for k in joint.stiffness))
        for name, joint in structure.joints.items()
    }
    return replace(structure, joints=joints)


@few
@given(structures, st.sampled_from([1e20, 1e30]))
def test_inf_is_the_limit_of_a_stiff_joint(structure: Structure, stiffness: float) -> None:
    """An ideal joint and one of 1e20: springs 10^10 times stiffer than any member, so equal to 1e-9; forces too.

    No loss of digits by the large number: its result agrees with 50 digits as any other does.
    """
    stiff = stiffened(structure, stiffness)
    ideal, hard = as_frame(stiffened(structure, np.inf)).solve(), as_frame(stiff).solve()
    names = list(structure.nodes)
    ours, limit = (stacked({name: s.displacement(name) for name in names}) for s in (hard, ideal))
    assert apart(ours, limit) < 1e-9
    assert apart(ours, stacked(solve(stiff).displacement)) <= allowed(hard.scaled_condition_number())
    if structure.joints:
        forces, limits = (stacked({name: s.joint_force(name) for name in structure.joints}) for s in (hard, ideal))
        assert apart(forces, limits) < 1e-9
        shut = stacked({name: ideal.joint_displacement(name) for name in structure.joints})
        free = np.array([[k == 0 for k in joint.stiffness] for joint in structure.joints.values()])
        assert np.all(shut[~free] == 0.0)


@few
@given(linkages)
def test_a_welded_joint_is_no_joint(structure: Structure) -> None:
    """All six springs ideal: the same as members that share the node."""
    welded = replace(
        structure, joints={name: replace(j, stiffness=(np.inf,) * 6) for name, j in structure.joints.items()}
    )
    same = {j.second: j.first for j in structure.joints.values()}
    merged = Structure(
        nodes={name: place for name, place in structure.nodes.items() if name not in same},
        members={
            name: replace(m, start=same.get(m.start, m.start), end=same.get(m.end, m.end))
            for name, m in structure.members.items()
        },
        supports={same.get(node, node): held for node, held in structure.supports.items()},
        loads=structure.loads,
    )
    one, other = as_frame(welded).solve(), as_frame(merged).solve()
    ours = stacked({name: one.displacement(name) for name in merged.nodes})
    theirs = stacked({name: other.displacement(name) for name in merged.nodes})
    assert apart(ours, theirs) <= 2 * allowed(other.scaled_condition_number())


@pytest.mark.parametrize("order", ["BC CD", "CB CD", "BC DC", "CB DC", "BC BD", "CB DB"])
def test_several_links_on_one_pin(order: str) -> None:
    """Three bars on one pin, their joints chained in any order and direction: the same bars, the same forces."""
    frame = Frame()
    walls = {"B": (-1.0, 1.0, 0.0), "C": (0.2, 1.0, 0.0), "D": (1.0, 1.0, 0.3)}
    beam = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
    for name, wall in walls.items():
        frame.node(name, (0.0, 0.0, 0.0))
        frame.node(f"wall {name}", wall)
        frame.add(name, beam, f"wall {name}", name)
        frame.fix(f"wall {name}")
    for pair in order.split():
        frame.add(pair, Joint(stiffness=(np.inf,) * 5 + (0.0,)), pair[0], pair[1])
    frame.load("B", fx=100.0, fy=-200.0, fz=30.0)
    solution = frame.solve()
    reactions = np.stack([solution.reaction(f"wall {name}") for name in walls])
    assert_allclose(reactions[:, :3].sum(axis=0), [-100.0, 200.0, -30.0], rtol=1e-11)
    structure = np.stack([solution.displacement(name) for name in walls])
    assert_allclose(structure[1, :5], structure[0, :5], rtol=1e-12)
    assert_allclose(structure[2, :5], structure[0, :5], rtol=1e-12)
    assert not np.allclose(structure[:, 5], structure[0, 5])
    # The chained order carries what the star order does: compare with the first by the bars' own forces.
    known = _pin_reactions()
    assert_allclose(reactions, known, rtol=1e-10, atol=1e-9)


def _pin_reactions() -> Array:
    """The same pin by releases: bars meeting in one node, two of them released about z."""
    frame = Frame()
    frame.node("pin", (0.0, 0.0, 0.0))
    walls = {"B": (-1.0, 1.0, 0.0), "C": (0.2, 1.0, 0.0), "D": (1.0, 1.0, 0.3)}
    section, steel = Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)
    for name, wall in walls.items():
        frame.node(name, wall)
        frame.fix(name)
    # The pin's axis is global z: D leans out of the plane, so its rotation about z is kept and the others' released.
    for name in "BC":
        frame.add(name, Beam(section, steel, release=("end rz",)), name, "pin")
    frame.add("D", Beam(section, steel), "D", "pin")
    frame.load("pin", fx=100.0, fy=-200.0, fz=30.0)
    solution = frame.solve()
    return np.stack([solution.reaction(name) for name in walls])
