"""Accuracy over a motion: closed forms of compliance, clearance, stiffness, vibration and stress; one plan for all."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import FourBar, Linkage, accuracy
from numpy.testing import assert_allclose

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), STEEL)
PIN = (2e11,) * 5 + (0.0,)
THETA = np.radians(np.arange(20.0, 160.0, 20.0))


def arm(length: float = 0.5, **link: object) -> Linkage:
    linkage = Linkage(A=(0, 0), B=(length, 0))
    linkage.link("arm", "A", "B", **{"beam": BAR} | link)  # type: ignore[arg-type]
    linkage.revolute("A", "ground", "arm", drive=True)
    return linkage


def drawn(special: FourBar, clearance: object = None) -> Linkage:
    motion = special.move(1.0)
    linkage = Linkage({point: motion.position(point) for point in "ABPDE"})
    linkage.link("crank", "A", "B", beam=special.link_beam("crank"))
    linkage.link("coupler", "B", "P", "D", beam=special.link_beam("coupler"))
    linkage.link("rocker", "D", "E", beam=special.link_beam("rocker"))
    linkage.revolute("A", "ground", "crank", drive=True, reference=1.0)
    for point, first, second in (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground")):
        linkage.revolute(point, first, second, stiffness=PIN, clearance=clearance)  # type: ignore[arg-type]
    return linkage


SPECIAL = FourBar(crank=0.1, coupler=0.25, rocker=0.2, ground=0.22, point=(0.12, 0.05), beam=BAR)


def test_parts_add_up_and_agree_with_the_four_bar() -> None:
    """The four-bar's own way: contact by the joint's force, then offsets in the frame to first order."""
    found = drawn(SPECIAL, clearance=1e-5).move(A=THETA).accuracy("P", fy=100.0)
    theirs = accuracy(SPECIAL, THETA, load=(0.0, 100.0, 0.0), clearance=1e-5, contact="reaction")
    assert_allclose(found.rigid, theirs.rigid, rtol=0.0, atol=1e-14)
    assert_allclose(found.compliance[:, :3], theirs.compliance, rtol=0.0, atol=1e-12 * np.abs(theirs.compliance).max())
    # In equilibrium the journal also turns with the forces that its own displacement brings about; here hardly.
    assert_allclose(
        found.clearance[:, :2], theirs.clearance[:, :2], rtol=0.0, atol=2e-3 * np.abs(theirs.clearance).max()
    )
    assert_allclose(found.total, found.compliance + found.clearance, rtol=0.0, atol=1e-18)
    assert set(found.status) == {"regular"}


def test_without_clearance_there_is_one_solution() -> None:
    found = drawn(SPECIAL).move(A=THETA).accuracy("P", fy=100.0)
    assert found.total is found.compliance
    assert not found.clearance.any()


def test_a_cantilever_that_turns() -> None:
    """F L^3 / 3EI across and F L^2 / 2EI of rotation, whichever way it points."""
    motion = arm().move(A=THETA)
    across = np.stack([-np.sin(THETA), np.cos(THETA)])
    found = motion.accuracy("B", fx=10.0 * across[0], fy=10.0 * across[1])
    EI = 200e9 * BAR.section.Iz
    assert_allclose(found.compliance[:, :2], 10.0 * 0.5**3 / (3 * EI) * across.T, rtol=1e-11, atol=1e-18)
    assert_allclose(found.compliance[:, 5], 10.0 * 0.5**2 / (2 * EI), rtol=1e-11)


def test_stiffness_is_the_inverse_of_unit_loads() -> None:
    """Column by column against frames with one unit load each; and symmetric."""
    motion = drawn(SPECIAL).move(A=THETA)
    flexibility, stiffness = motion.compliance_matrix("P"), motion.stiffness("P")
    assert stiffness.shape == (len(THETA), 6, 6)
    for k, name in enumerate(("fx", "fy", "fz", "mx", "my", "mz")):
        frame = motion.frame(loads=False)
        frame.load("P", **{name: 1.0})
        size = np.abs(flexibility[..., k]).max()
        assert_allclose(flexibility[..., k], frame.solve().displacement("P"), rtol=0.0, atol=1e-13 * size)
    size = np.sqrt(np.diagonal(flexibility, axis1=-2, axis2=-1))
    scaled = flexibility / size[..., :, None] / size[..., None, :]
    assert_allclose(scaled, np.swapaxes(scaled, -1, -2), rtol=0.0, atol=1e-12)
    assert_allclose(stiffness, np.swapaxes(stiffness, -1, -2), rtol=0.0, atol=1e-12 * np.abs(stiffness).max())
    assert_allclose(stiffness @ flexibility, np.broadcast_to(np.eye(6), stiffness.shape), atol=1e-9)


def test_stiffness_of_a_cantilever_in_the_book() -> None:
    """EA/L, 12EI/L^3, -6EI/L^2, 4EI/L, GJ/L at the end of a bar along x (Przemieniecki, 1968, Eq. 5.116)."""
    stiffness = arm().move(A=0.0).stiffness("B")
    section, L = BAR.section, 0.5
    EA, GJ, EIy, EIz = 200e9 * section.A, STEEL.G * section.J, 200e9 * section.Iy, 200e9 * section.Iz
    wanted = np.diag([EA / L, 12 * EIz / L**3, 12 * EIy / L**3, GJ / L, 4 * EIy / L, 4 * EIz / L])
    wanted[1, 5] = wanted[5, 1] = -6 * EIz / L**2
    wanted[2, 4] = wanted[4, 2] = 6 * EIy / L**2
    assert_allclose(stiffness, wanted, rtol=1e-10, atol=1e-6)


def test_what_is_rigid_has_no_stiffness_matrix_and_what_is_loose_none_either() -> None:
    with pytest.raises(FrameError, match="'B' cannot deflect in every direction"):
        arm(beam=None).move(A=0.3).stiffness("B")
    assert not arm(beam=None).move(A=0.3).compliance_matrix("B").any()
    loose = Linkage(A=(0, 0), B=(0.5, 0))
    loose.link("arm", "A", "B", beam=BAR)
    loose.revolute("A", "ground", "arm", drive=True, stiffness=(1e9, 1e9, 0.0, 1e9, 1e9, 0.0))
    with pytest.warns(UserWarning, match="kinematically unstable|statically consistent mechanism"):
        assert np.isnan(loose.move(A=0.3).stiffness("B")).all()


def test_natural_frequencies_of_an_arm() -> None:
    """First bending mode of a cantilever, (1.8751/L)^2 sqrt(EI / rho A) / 2 pi, weak axis before strong (Blevins)."""
    linkage = arm(beam=Beam(Rectangle(y=12.7e-3, z=6.35e-3), STEEL, segments=8))
    found = linkage.move(A=THETA).frequencies(2)
    bending = 200e9 * np.array([BAR.section.Iy, BAR.section.Iz]) / (7850.0 * BAR.section.A)
    wanted = (1.87510407 / 0.5) ** 2 * np.sqrt(bending) / (2 * np.pi)
    assert_allclose(found, np.broadcast_to(wanted, found.shape), rtol=1e-3)


def test_stress_of_a_spinning_arm() -> None:
    """rho w^2 L^2 / 2 at the hub, nothing at the tip (Timoshenko), the same at every pose."""
    motion = arm().move(A=THETA, rates={"A": 300.0})
    found = motion.stress("arm")
    wanted = 7850.0 * 300.0**2 * 0.5**2 / 2
    assert found.members == ("arm",)
    assert_allclose(found.greatest, wanted, rtol=1e-9)
    assert_allclose(found.von_mises, wanted, rtol=1e-9)
    assert_allclose(found.least, 0.0, atol=1e-6 * wanted)
    x = found.fractions
    assert_allclose(found.envelope[0, :, 1], wanted * (1 - x**2), rtol=0.0, atol=1e-9 * wanted)
    with pytest.raises(FrameError, match="link 'arm' is rigid"):
        arm(beam=None).move(A=0.0).stress("arm")
    with pytest.raises(FrameError, match="no link 'leg'"):
        motion.stress("leg")


def test_stress_envelope_is_the_worst_of_the_cycle() -> None:
    linkage = drawn(SPECIAL)
    linkage.load("P", fy=100.0)
    found = linkage.move(A=np.radians(np.arange(0, 360, 15.0)), rates={"A": 20.0}).stress("coupler")
    assert found.members == ("coupler.1", "coupler.2")
    assert_allclose(found.envelope[..., 2].max(), found.von_mises.max())
    assert_allclose(found.envelope[..., 0].min(), found.least.min())
    worst = np.abs(found.values[..., :2]).max()
    assert found.von_mises.max() >= worst * (1 - 1e-12)


def test_inertia_adds_to_the_compliance() -> None:
    """A tip mass swung at rate w pulls with m w^2 L: elongation m w^2 L^2 / EA."""
    linkage = arm(beam=Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3)))
    linkage.link("ball", "B", mass=3.0)
    linkage.fixed("B", "arm", "ball")
    motion = linkage.move(A=0.0, rates={"A": 20.0})
    moved = motion.accuracy("B", inertia=True).compliance
    assert_allclose(moved[0], 3.0 * 20.0**2 * 0.5**2 / (200e9 * BAR.section.A), rtol=1e-10)
    assert not motion.accuracy("B").compliance.any()


def test_load_cases_share_a_plan() -> None:
    motion = drawn(SPECIAL).move(A=THETA)
    first = motion.accuracy("P", fy=100.0)
    _ = first.compliance
    second = motion.accuracy("D", fx=1.0)
    _ = second.compliance
    assert second.solution.plan.again
    assert second.solution.plan.tree is first.solution.plan.tree
    assert motion.bare.solve(motion.frame(inertia=True)).plan.tree is first.solution.plan.tree


def test_bad_questions_are_refused() -> None:
    motion = drawn(SPECIAL).move(A=THETA)
    with pytest.raises(FrameError, match="no point 'Q'"):
        motion.accuracy("Q", fy=1.0)
    with pytest.raises(FrameError, match="link 'rocker' has no point 'B'"):
        motion.stiffness("B", "rocker")
    with pytest.raises(FrameError, match="component 'ux' is unknown: use one of fx"):
        motion.accuracy("P", ux=1.0)


def test_beams_of_samples_and_poses_broadcast() -> None:
    """Young's modulus (3,) beside poses (7, 1): a cantilever's compliance goes with one over it."""
    young = np.array([1e11, 2e11, 4e11])
    soft = Beam(Circle(diameter=0.01), Material(E=young, nu=0.3))
    found = arm(beam=soft).move(A=THETA[:, None]).accuracy("B", fz=1.0)
    assert found.compliance.shape == (len(THETA), 3, 6)
    wanted = 0.5**3 / (3 * young * np.pi * 0.01**4 / 64)
    assert_allclose(found.compliance[..., 2], np.broadcast_to(wanted, (len(THETA), 3)), rtol=1e-11)
