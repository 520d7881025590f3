"""Bounds of batches of frames with many unknowns: a banded factor for each entry tells what a dense inverse would."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.error_bounds import bounds
from linkframe.framework.error_bounds.bands import BandedCompliance
from linkframe.framework.error_bounds.compliance import DenseCompliance
from numpy.typing import NDArray

Array = NDArray[np.float64]
AREA, INERTIA, FORCE = 1e-2, 1e-5, 1e3


def cantilever(count: int, modulus: Array, share: Array) -> Frame:
    """So many beams of half a metre in line, held at the start and loaded at the end."""
    section = Section(A=AREA, Iy=INERTIA, Iz=2.0 * INERTIA, J=INERTIA)
    frame = Frame()
    names = [f"{k}" for k in range(count + 1)]
    frame.add_nodes(names, 0.5 * np.arange(count + 1)[:, None] * np.array([1.0, 0.0, 0.0]))
    beam = Beam(section, Material(E=modulus, nu=0.25))
    for start, end in pairwise(names):
        frame.add(f"{start}-{end}", beam, start, end)
    frame.fix("0")
    frame.load(names[-1], fx=FORCE * share, fy=FORCE * share)
    return frame


def exact(count: int, modulus: float, share: float) -> tuple[Fraction, Fraction, Fraction]:
    """Elongation, deflection and rotation of the end, in fractions."""
    force, length = Fraction(FORCE * share), Fraction(count) / 2
    stiff = Fraction(modulus) * 2 * Fraction(INERTIA)
    return (
        force * length / (Fraction(modulus) * Fraction(AREA)),
        force * length**3 / (3 * stiff),
        force * length**2 / (2 * stiff),
    )


@pytest.mark.parametrize(("count", "sharp"), [(100, 1e-14), (300, 2e-14)])
def test_long_chains_have_bounds_that_hold(count: int, sharp: float) -> None:
    """Their condition number grows with the fourth power of their length; moduli vary one way, loads the other."""
    modulus, share = np.array([[1.0], [1.7], [3.1]]) * 1e11, np.array([1.0, -0.3])
    solution = cantilever(count, modulus, share).solve()
    found, bound = solution.displacement(f"{count}")[..., [0, 1, 5]], solution.error_bound(f"{count}")[..., [0, 1, 5]]
    for at in np.ndindex(3, 2):
        truth = exact(count, float(modulus[at[0], 0]), float(share[at[1]]))
        for value, most, each in zip(found[at], bound[at], truth, strict=True):
            assert abs(Fraction(float(value)) - each) <= Fraction(float(most))
    assert (bound <= sharp * np.abs(found)).all()


@pytest.mark.parametrize("method", ["banded", "broadcast"])
def test_bands_tell_what_a_dense_inverse_does(method: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a frame with a joint, loops and parts that do not vary, whichever way it is solved."""
    solution = portal().solve(method)
    asked = [("displacement", "top"), ("reaction", "0"), ("joint_force", "pin"), ("end_forces", "2")]
    dense = [solution.error_bound(name, of) for of, name in asked]
    near = solution.distance_to_singularity()
    assert isinstance(next(solution.bounds.parts()).compliance, DenseCompliance)
    monkeypatch.setattr(bounds, "MOST", 0)
    again = portal().solve(method)
    banded = [again.error_bound(name, of) for of, name in asked]
    assert isinstance(next(again.bounds.parts()).compliance, BandedCompliance)
    for one, other in zip(dense, banded, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-2, atol=1e-4 * float(one.max()))
    np.testing.assert_allclose(near, again.distance_to_singularity(), rtol=1e-2)


def portal() -> Frame:
    frame, rng = Frame(), np.random.default_rng(0)
    points = np.array([[x, 0.0, z] for z in range(4) for x in range(2)]) + 0.1 * rng.random((8, 3))
    frame.add_nodes([f"{k}" for k in range(8)], points)
    frame.node("top", points[7])
    pairs = np.array([(0, 2), (1, 3), (2, 3), (2, 4), (3, 5), (4, 5), (4, 6), (5, 7), (6, 7)])
    section = Section(A=AREA, Iy=INERTIA, Iz=2.0 * INERTIA, J=INERTIA)
    for number, (start, end) in enumerate(pairs.tolist()):
        modulus = 2e11 * (np.array([1.0, 1.5, 0.4])[:, None] if number % 2 else 1.0)
        frame.add(f"{number}", Beam(section, Material(E=modulus, nu=0.3)), f"{start}", f"{end}")
    frame.add("pin", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 50.0)), "7", "top")
    frame.fix("0")
    frame.fix("1")
    frame.load("top", fx=FORCE * np.array([1.0, 2.0]), fy=300.0, mz=20.0)
    return frame
