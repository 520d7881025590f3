"""Refined solutions of single frames: to rounding, however finely members are divided."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame

E, G, A, IY, J, LENGTH = 2e11, 8e10, 1e-4, 1e-9, 2e-9, 2.0


def cantilever(pieces: int, force: object = 3.0) -> Frame:
    """A clamped beam along x of so many members."""
    beam = Beam(Section(A=A, Iy=IY, Iz=2 * IY, J=J), Material(E=E, G=G))
    frame = Frame()
    frame.node("0", (0.0, 0.0, 0.0))
    for k in range(1, pieces + 1):
        frame.node(f"{k}", (LENGTH * k / pieces, 0.0, 0.0))
        frame.add(f"m{k}", beam, f"{k - 1}", f"{k}")
    frame.fix("0")
    frame.load(f"{pieces}", fx=5.0, fy=force, mz=0.5, mx=0.1)
    return frame


@pytest.mark.parametrize("method", ["banded", "sparse", None])
@pytest.mark.parametrize("pieces", [32, 256])
def test_cantilever(pieces: int, method: str | None) -> None:
    """End deflection ``F L^3 / 3 E I + M L^2 / 2 E I`` of Bernoulli's beam (condition number 1e7 to 1e11)."""
    found = cantilever(pieces).solve(method).displacement(f"{pieces}")
    bending, turning = 3.0 * LENGTH**2 / (2 * E * 2 * IY), 0.5 * LENGTH / (E * 2 * IY)
    exact = [
        5.0 * LENGTH / (E * A),
        3.0 * LENGTH**3 / (3 * E * 2 * IY) + 0.5 * LENGTH**2 / (2 * E * 2 * IY),
        0.0,
        0.1 * LENGTH / (G * J),
        0.0,
        bending + turning,
    ]
    np.testing.assert_allclose(found, exact, rtol=1e-13, atol=1e-25)


def test_load_cases() -> None:
    """Each case of a batch of loads is refined like one alone."""
    forces = np.linspace(-1.0, 2.0, 24).reshape(4, 6)
    found = cantilever(40, forces).solve("sparse").displacement("40")
    assert found.shape == (4, 6, 6)
    for entry in ((0, 0), (3, 5), (2, 1)):
        alone = cantilever(40, forces[entry]).solve("sparse").displacement("40")
        np.testing.assert_allclose(found[entry], alone, rtol=1e-14, atol=1e-25)
