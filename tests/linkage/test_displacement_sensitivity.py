"""Displacements of loaded linkages by their dimensions, through frame and loop closure: differences of solutions."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import FrameError
from linkframe.models import Linkage, PointAccuracy
from numpy.testing import assert_allclose

from ..reference.any_linkage import KINDS, Recipe

STEPS = np.array([1.0, -1.0, 2.0, -2.0])
LOAD = {"fx": 1e3, "fy": 2e3, "fz": 500.0}
ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7800.0))


def accuracy(recipe: Recipe, drives: np.ndarray, *, weight: bool = False) -> PointAccuracy:
    linkage = recipe.made()
    if weight:
        linkage.gravity((0.0, -9.81, 0.0))
    values = {}
    for name, reach in recipe.reach.items():
        pair = linkage.joint(name)
        chosen = [pair.kind.coordinates.index(own) for own in linkage.drives[name]]
        values[name] = np.squeeze(pair.reference[..., chosen]) + 0.2 * reach + drives
    return linkage.move(values).accuracy("P", **LOAD)


@pytest.mark.parametrize("kind", ["six_bar", "two_drives", "rssr", "rusp"])
def test_differences_of_solutions(kind: str) -> None:
    """All neighbours in one batch: some points in the drawing, and the drives together."""
    recipe, step = KINDS[kind](np.random.default_rng(2)), 1e-4
    inputs = [(point, k) for point in list(recipe.points)[1:4] for k in range(2)]
    count = 1 + 4 * (len(inputs) + 1)
    base = {name: np.asarray(place) for name, place in recipe.points.items()}
    recipe.points = {name: np.tile(place, (count, 1)) for name, place in base.items()}
    for at, (name, k) in enumerate(inputs):
        recipe.points[name][1 + 4 * at : 5 + 4 * at, k] += step * STEPS
    drives = np.zeros(count)
    drives[-4:] += step * STEPS
    found = accuracy(recipe, drives)
    by, moved = found.sensitivity("ux", "uy"), found.compliance[:, :2]
    size = np.abs(moved[0]).max()
    expected = [by.points[name][0, :, k] for name, k in inputs]
    expected.append(sum(value[0].sum(axis=-1) for value in by.drives.values()))
    for at, own in enumerate(expected):
        a, b, c, d = moved[1 + 4 * at : 5 + 4 * at]
        assert_allclose(own, (8.0 * (a - b) - (c - d)) / (12.0 * step), rtol=1e-6, atol=1e-7 * size)


def test_a_cantilever_that_turns_under_its_weight() -> None:
    """u = (F L^3 / 3 + w L^4 / 8) / EI across, and the axial strain along, of an arm at an angle."""
    arm = Linkage(A=(0, 0), B=(1.2, 0))
    arm.link("arm", "A", "B", beam=ROD)
    arm.revolute("A", "ground", "arm", drive=True)
    arm.gravity((0.0, -10.0))
    theta, F, L = np.array([0.3, 1.0, 2.0]), 50.0, 1.2
    by = arm.move(A=theta).accuracy("B", fy=-F).sensitivity("ux", "uy")
    assert repr(by) == "<Sensitivity of the displacement ux, uy to A, shape (3,)>"
    area, inertia = np.pi * 0.01**2, np.pi / 64.0 * 0.02**4
    w, EI, EA = 10.0 * 7800.0 * area, 200e9 * inertia, 200e9 * area
    along = np.stack([np.cos(theta), np.sin(theta)], axis=-1)
    across = np.stack([-np.sin(theta), np.cos(theta)], axis=-1)
    bend, stretch = (F * L**3 / 3 + w * L**4 / 8) / EI, (F * L + w * L**2 / 2) / EA
    # u = -cos(theta) bend across - sin(theta) stretch along
    by_angle = bend * (np.sin(theta)[:, None] * across + np.cos(theta)[:, None] * along)
    by_angle -= stretch * (np.cos(theta)[:, None] * along + np.sin(theta)[:, None] * across)
    assert_allclose(by.drives["A"][..., 0], by_angle, rtol=0.0, atol=1e-11 * bend)
    by_length = -np.cos(theta)[:, None] * across * (F * L**2 + w * L**3 / 2) / EI
    by_length -= np.sin(theta)[:, None] * along * (F + w * L) / EA
    assert_allclose(by.lengths["arm"], by_length, rtol=0.0, atol=1e-11 * bend)
    uy = -(np.cos(theta) ** 2 * bend + np.sin(theta) ** 2 * stretch)
    assert_allclose(by.frame["uy"].moduli["arm"], -uy / 200e9, rtol=1e-11)


def test_axes_of_a_cross_turn_with_both_links() -> None:
    """A universal joint that is elastic in its axes, of which x goes with the angle about z."""
    arm = Linkage(A=(0, 0), B=(1.2, 0.3))
    arm.link("arm", "A", "B", beam=ROD)
    springs = (1e6, 2e6, 4e6, 1e5, 3e4, 2e5)
    arm.universal("A", "ground", "arm", axis=(0.2, 0.3, 1), second=(1, 0, -0.2), drive=True, stiffness=springs)
    base, step = np.array([0.4, -0.7]), 1e-4
    by = arm.move(A=base).accuracy("B", **LOAD).sensitivity("ux", "uy", "uz").drives["A"]
    moved = arm.move(A=base + step * np.multiply.outer(np.eye(2), STEPS).swapaxes(1, 2)).accuracy("B", **LOAD)
    a, b, c, d = np.moveaxis(moved.compliance[..., :3], 1, 0)
    assert_allclose(by.T, (8.0 * (a - b) - (c - d)) / (12.0 * step), rtol=1e-6, atol=1e-10)


def test_a_coarser_thread() -> None:
    """The pitch moves the nut, and makes the thread's springs act on its turn."""

    def nut(pitch: np.ndarray) -> PointAccuracy:
        linkage = Linkage(A=(0, 0), B=(0.5, 0.1))
        linkage.link("nut", "A", "B", beam=ROD)
        springs = (1e6, 2e6, 4e6, 1e5, 3e4, 2e4)
        linkage.screw("A", "ground", "nut", axis=(0.2, 1, 0.4), pitch=pitch, stiffness=springs, drive=True)
        return linkage.move(A=np.full(len(pitch), 2.0)).accuracy("B", **LOAD)

    step = 1e-4
    by = nut(np.array([0.3])).sensitivity("ux", "uy", "uz").pitches["A"][0]
    a, b, c, d = nut(0.3 + step * STEPS).compliance[..., :3]
    assert_allclose(by, (8.0 * (a - b) - (c - d)) / (12.0 * step), rtol=1e-7)


def test_what_is_not_offered() -> None:
    def arm() -> Linkage:
        linkage = Linkage(A=(0, 0), B=(1, 0), C=(1, 1))
        linkage.link("arm", "A", "B", beam=ROD)
        linkage.revolute("A", "ground", "arm", drive=True)
        return linkage

    linkage = arm()
    linkage.spring("B", ("ground", "C"), stiffness=100.0, length=0.5)
    with pytest.raises(FrameError, match="the linkage has springs"):
        linkage.move().accuracy("B", fy=1.0).sensitivity("uy")
    linkage = arm()
    linkage.load("B", fy=1.0, follower=True)
    with pytest.raises(FrameError, match="a load turns with its link"):
        linkage.move().accuracy("B").sensitivity("uy")
    with pytest.raises(FrameError, match="inertia forces change with the pose"):
        arm().move().accuracy("B", inertia=True, fy=1.0).sensitivity("uy")
    with pytest.raises(FrameError, match="axes of joints is not offered"):
        arm().move().accuracy("B", fy=1.0).sensitivity("uy").axes  # noqa: B018
