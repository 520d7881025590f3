"""Loops of springs: whichever is the stiffest at an entry, it has the digits that it has alone."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
ROD = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3, density=7850.0))
JOINTS = {"j1": ("A", "B"), "j2": ("B", "C"), "j3": ("C", "A")}
STIFFNESSES = np.array(list(itertools.permutations([1e3, 1e6, 1e15])))


def triangle(stiffness: Numbers, *, apart: bool = False, shares: tuple[float, ...] = (1.0,) * 6) -> Frame:
    """Three rods that meet in a loop of three joints, of the stiffness (..., 3); some imposed on, turned and apart.

    `shares` are those of the components of the first joint; of the others one place further each.
    """
    frame = Frame()
    places = {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.0, 0.0), "C": (0.0, 0.0, 0.0), "E": (0.1, 0.2, 0.3)}
    for name, place in {**places, "P": (1.0, 0.0, 0.0), "Q": (0.0, 1.0, 0.0), "R": (0.3, 0.0, 1.0)}.items():
        frame.node(name, place)
    for start, end in ("PA", "QB", "RC"):
        frame.add(start + end, ROD, start, end)
    frame.fix("P")
    frame.fix("Q")
    for k, (name, (first, second)) in enumerate(JOINTS.items()):
        springs = stiffness[..., k, None] * np.roll(shares, k)
        turned = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]]) if apart and k == 1 else None
        frame.add(name, Joint(stiffness=springs, axes=turned), first, second)
    if apart:
        frame.offset("j3", ux=1e-3, rz=2e-3)
    frame.rigid("C", "E")
    frame.load("R", fx=1.0, fy=2.0, mz=0.3)
    frame.load("E", fz=1.0)
    return frame


@pytest.mark.parametrize("apart", [False, True])
def test_a_loop_of_springs_in_any_order_of_stiffness(apart: bool) -> None:
    batch = triangle(STIFFNESSES, apart=apart).solve()
    for entry, stiffness in enumerate(STIFFNESSES):
        alone = triangle(stiffness, apart=apart).solve()
        force = np.abs(alone.joint_force("j1")).max()
        for name in JOINTS:
            found, bound = batch.refined(name, "joint_force")
            assert_allclose(batch.joint_force(name)[entry], alone.joint_force(name), rtol=0.0, atol=3e-14 * force)
            assert_allclose(found[entry], alone.refined(name, "joint_force")[0], rtol=0.0, atol=1e-15 * force)
            assert (bound[entry] < 8.0 * alone.refined(name, "joint_force")[1] + 1e-16 * force).all()
        for node in "ACE":
            assert_allclose(batch.displacement(node)[entry], alone.displacement(node), rtol=1e-12, atol=1e-20)
            assert batch.error_bound(node)[entry].max() < 3.0 * alone.error_bound(node).max()


def test_scaling_goes_by_the_springs_that_an_entry_has_in_its_tree() -> None:
    """Each joint has springs of its own proportions, by which its coordinates have units."""
    shares = (1.0, 2.0, 1.0, 3.0, 1.0, 1.0)
    batch = triangle(STIFFNESSES, apart=True, shares=shares).solve().scaled_condition_number()
    alone = [triangle(each, apart=True, shares=shares).solve().scaled_condition_number() for each in STIFFNESSES]
    assert_allclose(batch, alone, rtol=1e-6)
