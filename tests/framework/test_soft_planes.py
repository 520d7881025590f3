"""Frames that are singular to double precision and not to extended precision, in planes that no load reaches too.

A cantilever of n beams resists the motion of its tip by 1 / n^4 of what its nodes resist; of 2400 the stiffness, which
squares what deformations know, has nothing but rounding left.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame

E, D = 2e11, 0.1
LONG = 2400


def chain(count: int, *, modulus: object = E, hinge: int | None = None, release: str = "start rz") -> Frame:
    """A cantilever along x of beams of one metre, one of which may be hinged."""
    frame = Frame()
    beam = Beam(Circle(diameter=D), Material(E=modulus, nu=0.3))
    names = [f"n{k}" for k in range(count + 1)]
    frame.add_nodes(names, np.outer(np.arange(count + 1.0), [1.0, 0.0, 0.0]))
    pairs = list(zip(names[:-1], names[1:], strict=True))
    if hinge is not None:
        frame.add("hinged", Beam(beam.section, beam.material, release=(release,)), *pairs.pop(hinge))
    frame.add_many(beam, pairs)
    frame.fix("n0")
    return frame


def deflection(count: int, modulus: object = E) -> np.ndarray:
    """F L^3 / (3 E I) for F of 1 N."""
    return count**3 / (3.0 * np.asarray(modulus) * np.pi * D**4 / 64.0)


@pytest.mark.parametrize("loads", ["fy", "fz", "fy fz", "mx"])
def test_a_soft_plane_is_no_mechanism(loads: str) -> None:
    frame = chain(LONG)
    frame.load(f"n{LONG}", **dict.fromkeys(loads.split(), 1.0))
    solution = frame.solve()
    assert solution.status == "regular"
    assert solution.free_motion().count == 0
    moved = solution.displacement(f"n{LONG}")
    for k, load in enumerate(["fy", "fz"], start=1):
        expected = deflection(LONG) if load in loads.split() else 0.0
        assert moved[k] == pytest.approx(expected, rel=1e-14, abs=1e-15)


@pytest.mark.parametrize(("hinge", "load", "status"), [(1200, "fz", "statically consistent"), (0, "fy", "")])
def test_a_hinge_beside_soft_planes_is_found_alone(hinge: int, load: str, status: str) -> None:
    frame = chain(LONG, hinge=hinge)
    frame.load(f"n{LONG}", **{load: 1.0})
    solution = frame.solve()
    assert solution.status == f"{status} mechanism".strip()
    motion = solution.free_motion()
    assert motion.count == 1
    shape = np.array([motion.displacement(f"n{k}")[0] for k in range(0, LONG + 1, 100)])
    expected = np.maximum(np.arange(0.0, LONG + 1, 100.0) - hinge, 0.0) / (LONG - hinge)
    assert np.sign(shape[-1, 1]) * shape[:, 1] == pytest.approx(expected, abs=1e-9)
    assert np.delete(shape, [1, 5], axis=1) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("release", ["start rx", "start ux"])
def test_what_turns_or_slides_along_itself(release: str) -> None:
    frame = chain(LONG, hinge=LONG // 2, release=release)
    frame.load(f"n{LONG}", fy=1.0)
    solution = frame.solve()
    assert solution.status == "statically consistent mechanism"
    motion = solution.free_motion()
    assert motion.count == 1
    component = {"ux": 0, "rx": 3}[release.split()[1]]
    ends = [motion.displacement(f"n{k}")[0, component] for k in (LONG // 2, LONG)]
    assert ends[0] == pytest.approx(0.0, abs=1e-9)
    assert abs(ends[1]) == pytest.approx(1.0, abs=1e-9)
