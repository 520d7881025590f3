"""Benchmarks of the IFToMM library of multibody problems: the spatial slider-crank and the N-four-bar."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.linkages import n_four_bar

Array = NDArray[np.float64]


def spatial_slider_crank() -> Linkage:
    """E. J. Haug, Computer Aided Kinematics and Dynamics of Mechanical Systems, Allyn and Bacon 1989, section 12.4."""
    linkage = Linkage(A=(0, 0.1, 0.12), B=(0, 0.1, 0.2), C=(0.2, 0, 0), G=(0.1, 0.05, 0.1))
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C", "G")
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank", axis=(1, 0, 0), drive=True)
    linkage.spherical("B", "crank", "rod")
    linkage.universal("C", "slider", "rod", axis=(0, 1, -0.5), second=np.cross((0, 1, -0.5), (-0.2, 0.1, 0.2)))
    linkage.prismatic("C", "ground", "slider", axis=(1, 0, 0), name="slide", reference=0.2)
    return linkage


def test_spatial_slider_crank() -> None:
    """x = √(0.3² − (0.1 − 0.08 sin θ)² − (0.12 + 0.08 cos θ)²), and the published velocities at the start, ω = 6."""
    theta = np.linspace(0.0, 2.0 * np.pi, 61)
    motion = spatial_slider_crank().move(A=theta, rates={"A": 6.0})
    across, up = 0.1 - 0.08 * np.sin(theta), 0.12 + 0.08 * np.cos(theta)
    x = np.sqrt(0.3**2 - across**2 - up**2)
    assert_allclose(motion.position("C")[:, 0], x, rtol=1e-13)
    assert_allclose(motion.coordinate("slide")[:, 0], x, rtol=1e-13)
    v = 6.0 * 0.08 * (across * np.cos(theta) + up * np.sin(theta)) / x
    assert_allclose(motion.velocity("C")[:, 0], v, rtol=0.0, atol=1e-13)
    assert_allclose(motion.velocity("C")[0], [0.24, 0.0, 0.0], atol=1e-14)
    assert_allclose(motion.velocity("G")[0], [0.12, -0.24, 0.0], atol=1e-14)


def test_spatial_slider_crank_mobility() -> None:
    found = spatial_slider_crank().mobility()
    assert (found.actual, found.kutzbach, found.idle, found.redundant) == (1, 1, (), ())


def test_rod_does_not_spin_about_itself() -> None:
    """The published angular velocity of the rod, whose part along the rod depends on the joint at the slider."""
    spin = spatial_slider_crank().move(A=0.0, rates={"A": 6.0}).angular_velocity("rod")
    rod = np.array([-0.2, 0.1, 0.2]) / 0.3
    published = np.array([1.92, -0.96, 0.48])
    assert_allclose(np.cross(spin, rod), np.cross(published, rod), atol=1e-14)


def falling(n: int, theta: Array) -> tuple[Motion, float, float]:
    """N-four-bar of rods of 1 kg, falling from the top, where its pins have 1 m/s; its weight and inertia."""
    linkage = n_four_bar(n, np.pi / 2)
    for name, link in list(linkage.links.items()):
        del linkage.links[name]
        linkage.link(name, *link.points, mass=1.0, inertia=1.0 / 12.0)
    linkage.gravity((0.0, -9.81, 0.0))
    weight, inertia = 9.81 * (0.5 * (n + 1) + n), (n + 1) / 3.0 + n
    speed = np.sqrt(1.0 + 2.0 * weight * (1.0 - np.sin(theta)) / inertia)
    return linkage.move(A0=theta, rates={"A0": -speed}), weight, inertia


THETA = np.radians([90.0, 60.0, 10.0, 0.0, -50.0])


@pytest.mark.parametrize("n", [2, 5, 40])
def test_n_four_bar_keeps_its_energy(n: int) -> None:
    """T + V is constant, through the change point where all rods lie flat; for n = 2 it is 3.5 · 9.81 + 1.5."""
    motion, weight, inertia = falling(n, THETA)
    energy = motion.kinetic_energy() + weight * np.sin(THETA)
    assert_allclose(energy, weight + 0.5 * inertia, rtol=1e-11)
    if n == 2:
        assert_allclose(energy, 3.5 * 9.81 + 1.5, rtol=1e-12)
    assert_allclose(motion.position(f"B{n}")[:, 1], np.sin(THETA), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("n", [2, 5])
def test_n_four_bar_falls(n: int) -> None:
    """dT + dV = 0. Flat, no finite force in the bars makes the outer rods fall like those between."""
    motion, weight, inertia = falling(n, THETA)
    found = motion.free_accelerations()["A0"][:, 0]
    fall = np.where(THETA == 0.0, np.nan, -weight * np.cos(THETA) / inertia)
    assert_allclose(found, fall, rtol=1e-9, atol=1e-12)
