"""Cantilevers at large displacement against closed forms: a circle, the elastica, the buckled column.

Mattiasson (Int. J. Numer. Methods Eng. 17 (1981) 145-153) tabulates the elastica; the elliptic integrals are computed
here (Timoshenko & Gere, Theory of Elastic Stability, 2nd ed., art. 2.7) and compared with two rows of his table.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from linkframe.framework.large.solution import LargeSolution
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

EI = 200.0


def cantilever(segments: int, thin: float = 1e-6, **load: object) -> LargeSolution:
    """A clamped rod of length 1, almost inextensible where `thin` (EI / EA, length squared) is small."""
    section = Section(A=1e-9 / thin, Iy=3e-9, Iz=1e-9, J=1e-9)
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(section, Material(E=200e9, nu=0.3), segments=segments), "A", "B")
    frame.fix("A")
    frame.load("B", **load)
    return frame.solve(large=True)


def tip(load: float) -> tuple[float, float]:
    """Shortening and deflection of an inextensible cantilever of length 1 under P L^2 / EI across its end."""
    root = np.sqrt(load)

    def modulus(angle: float) -> tuple[float, float]:
        m = (1.0 + np.sin(angle)) / 2.0
        return m, float(np.arcsin(1.0 / np.sqrt(2.0 * m)))

    def excess(angle: float) -> float:
        m, phi = modulus(angle)
        return float(ellipk(m) - ellipkinc(phi, m) - root)

    end = brentq(excess, 1e-9, np.pi / 2 - 1e-9, xtol=1e-15)
    m, phi = modulus(end)
    down = 1.0 - 2.0 / root * (ellipe(m) - ellipeinc(phi, m))
    along = np.sqrt(2.0 * np.sin(end)) / root
    return 1.0 - along, float(down)


@pytest.mark.parametrize(("load", "shortening", "deflection"), [(1.0, 0.05643, 0.30172), (10.0, 0.55500, 0.81061)])
def test_elliptic_integrals_are_those_of_the_table(load: float, shortening: float, deflection: float) -> None:
    assert tip(load) == pytest.approx((shortening, deflection), abs=5.1e-6)


@pytest.mark.parametrize("load", [1.0, 4.0, 10.0])
def test_elastica(load: float) -> None:
    error = []
    for segments in (4, 8, 16):
        solution = cantilever(segments, thin=1e-9, fy=load * EI)
        moved = solution.displacement("B")
        assert solution.status == "stable"
        error.append(np.array([-moved[0], moved[1]]) - tip(load))
    size = np.abs(error).max(axis=1)
    assert size[2] < 4e-8 * load**3
    assert np.log2(size[:-1] / size[1:]) == pytest.approx(4.0, abs=0.4)


def test_batch_of_loads_at_once() -> None:
    loads = np.array([0.5, 2.0, 6.0])
    moved = cantilever(16, fy=loads * EI).displacement("B")
    for load, row in zip(loads, moved, strict=True):
        assert row == pytest.approx(cantilever(16, fy=load * EI).displacement("B"), rel=1e-12, abs=1e-14)


@pytest.mark.parametrize("turns", [0.25, 1.0, 2.0])
def test_rolled_into_a_circle(turns: float) -> None:
    """Every piece bends alike: an arc of turn 2 b, whose chord is shorter by b^2 / 6 (exactly: sin(b) / b)."""
    count = 12
    solution = cantilever(count, mz=2.0 * np.pi * turns * EI)
    moved = solution.displacement("B")
    bend = np.pi * turns / count
    chord = (1.0 - bend**2 / 6.0) / count
    # a chain of equal chords, each turned by 2 bend against the last
    angle = bend * (2.0 * np.arange(count) + 1.0)
    expected = chord * np.cos(angle).sum() - 1.0, chord * np.sin(angle).sum()
    assert moved[:2] == pytest.approx(expected, abs=1e-12)
    assert np.remainder(moved[5] - 2.0 * np.pi * turns + 1.0, 2.0 * np.pi) == pytest.approx(1.0, abs=1e-12)
    assert solution.reaction("A")[5] == pytest.approx(-2.0 * np.pi * turns * EI, rel=1e-12)


def test_column_beyond_buckling_leaves_the_straight_line() -> None:
    """Post-buckling of a clamped column (Timoshenko & Gere, table 2-4): 60 degrees at 1.152 times Euler's load."""

    def angle(m: float) -> float:
        return (2.0 * ellipk(m) / np.pi) ** 2

    m = brentq(lambda m: angle(m) - 1.152, 1e-6, 0.99)
    assert np.degrees(2.0 * np.arcsin(np.sqrt(m))) == pytest.approx(60.0, abs=0.1)
    solution = cantilever(16, thin=1e-8, fx=-1.152 * np.pi**2 / 4.0 * EI)
    moved = solution.displacement("B")
    assert solution.status == "stable beyond a saddle"
    assert abs(moved[5]) == pytest.approx(2.0 * np.arcsin(np.sqrt(m)), rel=1e-4)
    below = cantilever(16, thin=1e-8, fx=-0.9999 * np.pi**2 / 4.0 * EI)
    assert below.status == "stable"
    assert below.displacement("B")[1] == 0.0
