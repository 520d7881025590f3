"""Rods between two balls, which can spin: what they carry, and on what springs they stand."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.models import Linkage
from numpy.testing import assert_allclose

RODS = range(7)
ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
LOAD = {"fx": 10.0, "fy": -3.0, "fz": 5.0, "mx": 1.0}


def platform(springs: tuple[float, ...] | None) -> Linkage:
    """On one rod more than hold it, their lower balls on springs along axes of their own."""
    rng = np.random.default_rng(1)
    linkage = Linkage(O=(0, 0, 1))
    for k in RODS:
        linkage.point(f"A{k}", rng.uniform(-1.0, 1.0, 3) * (1.0, 1.0, 0.1))
        linkage.point(f"B{k}", rng.uniform(-0.5, 0.5, 3) * (1.0, 1.0, 0.2) + (0.0, 0.0, 1.0))
    linkage.link("platform", "O", *(f"B{k}" for k in RODS), beam={("O", f"B{k}"): ROD for k in RODS})
    for k in RODS:
        linkage.link(f"rod {k}", f"A{k}", f"B{k}", beam=ROD)
        linkage.spherical(f"A{k}", "ground", f"rod {k}", axis=rng.normal(size=3), stiffness=springs)
        linkage.spherical(f"B{k}", f"rod {k}", "platform", axis=rng.normal(size=3))
    linkage.load("O", **LOAD)
    return linkage


def as_springs(linkage: Linkage, springs: tuple[float, ...] | None) -> Frame:
    """Each rod with its ball as one spring along its line."""
    frame = Frame()
    frame.node("O", linkage.points["O"])
    for k in RODS:
        low, high = linkage.points[f"A{k}"], linkage.points[f"B{k}"]
        length = float(np.linalg.norm(high - low))
        along = (high - low) / length
        soft = length / (200e9 * np.pi * 0.01**2)
        if springs is not None:
            soft += float(np.sum((along @ linkage.joint(f"A{k}").axes) ** 2 / springs[:3]))
        across = np.cross(along, (1.0, 0.0, 0.0)) / np.linalg.norm(np.cross(along, (1.0, 0.0, 0.0)))
        axes = np.column_stack([along, across, np.cross(along, across)])
        frame.node(f"B{k}", high)
        frame.node(f"G{k}", high)
        frame.fix(f"G{k}")
        frame.add(f"arm {k}", ROD, "O", f"B{k}")
        frame.add(f"rod {k}", Joint((1.0 / soft, 0, 0, 0, 0, 0), axes), f"G{k}", f"B{k}")
    frame.load("O", **LOAD)
    return frame


@pytest.mark.parametrize("springs", [None, (1e6,) * 3 + (0.0,) * 3, (1e5, 2e6, 3e7, 0.0, 0.0, 0.0)])
def test_a_platform_on_seven_rods(springs: tuple[float, ...] | None) -> None:
    linkage = platform(springs)
    motion, alone = linkage.move(), as_springs(linkage, springs).solve()
    assert_allclose(motion.accuracy("O").compliance, alone.displacement("O"), rtol=1e-9)
    found = motion.reactions()
    assert found.method == "compliance"
    for k in RODS:
        along = linkage.points[f"B{k}"] - linkage.points[f"A{k}"]
        pushed = -alone.joint_force(f"rod {k}")[0] * along / np.linalg.norm(along)
        for ball in "AB":
            assert_allclose(found.force(f"{ball}{k}")[:3], pushed, atol=1e-8)
