"""Natural frequencies of very different size, beside 90 digits."""

from __future__ import annotations

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, PointMass
from linkframe.framework import Frame, FrameError

Table = list[np.ndarray]


def chain(stiffness: Table, mass: Table) -> Frame:
    """Masses one after the other from the ground, between which joints are springs."""
    frame = Frame()
    frame.node("0", (0.0, 0.0, 0.0))
    frame.fix("0")
    for k, (springs, own) in enumerate(zip(stiffness, mass, strict=True), 1):
        frame.node(str(k), (0.0, 0.0, 0.0))
        frame.add(f"joint {k}", Joint(springs), str(k - 1), str(k))
        frame.add(f"mass {k}", PointMass(float(own[0]), inertia=own[3:]), str(k))
    return frame


def in_many_digits(stiffness: Table, mass: Table) -> np.ndarray:
    """Hz, in order: each component moves by itself."""
    found = []
    with mp.workdps(90):
        for c in range(6):
            springs = [mp.mpf(float(row[c])) for row in stiffness] + [mp.mpf(0)]
            roots = [mp.sqrt(float(row[c])) for row in mass]
            matrix = mp.zeros(len(mass))
            for i, root in enumerate(roots):
                matrix[i, i] = (springs[i] + springs[i + 1]) / root**2
                if i:
                    matrix[i, i - 1] = matrix[i - 1, i] = -springs[i] / (root * roots[i - 1])
            found += [mp.sqrt(value) / (2 * mp.pi) for value in mp.eigsy(matrix, eigvals_only=True)]
        return np.array(sorted(float(value) for value in found))


@pytest.mark.parametrize(
    "scales",
    [
        (1.0, 1e6, 1e12),
        (1e12, 1e6, 1.0),
        (1.0, 1e4, 1e8, 1e12),
        (1e12, 1.0, 1e6),
        (1.0, 1e8, 1e16),
        (1e24, 1e12, 1.0),
        (1e20, 1.0, 1e40),
    ],
)
def test_frequencies_of_several_scales_keep_their_digits(scales: tuple[float, ...]) -> None:
    rng = np.random.default_rng(1)
    stiffness = [scale * rng.uniform(0.5, 2.0, 6) for scale in scales]
    mass = [np.concatenate([np.full(3, rng.uniform(0.5, 2.0)), rng.uniform(0.5, 2.0, 3)]) for _ in scales]
    exact = in_many_digits(stiffness, mass)
    for count in (7, 13, len(exact)):
        np.testing.assert_allclose(chain(stiffness, mass).modes(count).frequencies, exact[:count], rtol=2e-12)


@pytest.mark.parametrize("held", [True, False])
def test_what_has_no_mass_is_no_mode(held: bool) -> None:
    """A mass on bars without mass moves in three ways."""
    frame = Frame()
    bar = Beam(Circle(diameter=0.01), Material(E=2e11, nu=0.3))
    for k in range(5):
        frame.node(str(k), (0.1 * k, 0.02 * (k % 2), 0.0))
        if k:
            frame.add(f"bar {k}", bar, str(k - 1), str(k))
    frame.add("mass", PointMass(2.0), "4")
    if held:
        frame.fix("0")
    assert np.isfinite(frame.modes(3).frequencies).all()
    for count in (4, 5, 6):
        with pytest.raises(FrameError, match="fewer modes with mass"):
            frame.modes(count)


def test_one_mass_on_many_bars_without_mass() -> None:
    """Seventy bars, which go the sparse way: it moves by what unit forces on it move."""
    frame, mass = Frame(), 2.0
    bar = Beam(Circle(diameter=0.01), Material(E=2e11, nu=0.3))
    nodes = frame.add_nodes(71, [(0.1 * k, 0.02 * (k % 2), 0.0) for k in range(71)])
    frame.add_many(bar, list(pairwise(nodes)))
    frame.add("mass", PointMass(mass), nodes[-1])
    frame.fix(nodes[0])
    frequencies = frame.modes(3).frequencies
    with pytest.raises(FrameError, match="fewer modes with mass"):
        frame.modes(5)
    unit = np.eye(3)
    frame.load(nodes[-1], fx=unit[0], fy=unit[1], fz=unit[2])
    moved = np.linalg.eigvalsh(frame.solve().displacement(nodes[-1])[:, :3])[::-1]
    np.testing.assert_allclose(frequencies, 1.0 / np.sqrt(mass * moved) / (2.0 * np.pi), rtol=1e-7)
