"""Paths past limit points: Lee's frame and Williams' toggle, against elasticas met by shooting.

Lee, Manuel & Rossow (J. Eng. Mech. Div. ASCE 94 (1968) 521-547); Williams (Q. J. Mech. Appl. Math. 17 (1964) 451-469).
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame, FrameError
from reference.rod import PlaneRod, solved

SIDE, AT, E, A, INERTIA = 120.0, 24.0, 720.0, 6.0, 2.0
SPAN, RISE, STRETCH, BEND = 12.94, 0.386, 1.885e6, 9.27e3


def lee(pieces: int) -> Frame:
    """Column and beam of length 120, pinned at both ends; unit load down on the beam at 24 from the corner."""
    section, material = Section(A=A, Iy=1e3 * INERTIA, Iz=INERTIA, J=1e3 * INERTIA), Material(E=E, nu=0.3)
    frame = Frame()
    for name, place in {"A": (0, 0), "B": (0, SIDE), "P": (AT, SIDE), "C": (SIDE, SIDE)}.items():
        frame.node(name, (*place, 0.0))
    for name, count in {"AB": 5, "BP": 1, "PC": 4}.items():
        frame.add(name, Beam(section, material, segments=count * pieces), *name)
    for name in "AC":
        frame.fix(name, "ux", "uy", "uz", "rx", "ry")
    frame.load("P", fy=-1.0)
    return frame


def lee_load(drop: float, guess: np.ndarray) -> np.ndarray:
    """Reaction at A (2), angle there and load at a given drop of P."""
    rod = PlaneRod(E * A, E * INERTIA)

    def excess(x: np.ndarray) -> np.ndarray:
        corner = rod.shot(np.array([0.0, 0.0, x[2] + np.pi / 2, 0.0]), x[:2], SIDE)
        loaded = rod.shot(corner - np.array([0.0, 0.0, np.pi / 2, 0.0]), x[:2], AT)
        end = rod.shot(loaded, x[:2] + np.array([0.0, x[3]]), SIDE - AT)
        lack = np.array([end[0] - SIDE, end[1] - SIDE, loaded[1] - SIDE + drop])
        return np.array([*(lack / SIDE), end[3] / (E * INERTIA / SIDE)])

    return solved(excess, guess)


def toggle(pieces: int, **held: float) -> Frame:
    """Two bars clamped at their feet, loaded or moved down at the apex."""
    section = Section(A=STRETCH / 1e7, Iy=10.0 * BEND / 1e7, Iz=BEND / 1e7, J=BEND / 1e7)
    frame = Frame()
    for name, place in {"A": (0.0, 0.0), "C": (SPAN, RISE), "B": (2.0 * SPAN, 0.0)}.items():
        frame.node(name, (*place, 0.0))
    for ends in ("AC", "CB"):
        frame.add(ends, Beam(section, Material(E=1e7, nu=0.3), segments=pieces), *ends)
    frame.fix("A")
    frame.fix("B")
    if held:
        frame.prescribe("C", **held)
    else:
        frame.load("C", fy=-1.0)
    return frame


def toggle_load(drop: float, guess: np.ndarray) -> np.ndarray:
    """Force (2) and moment at the foot of one bar at a given drop of the apex, in units of 1, 1 and the span."""
    rod, slope = PlaneRod(STRETCH, BEND), np.arctan2(RISE, SPAN)

    def excess(x: np.ndarray) -> np.ndarray:
        start = np.array([0.0, 0.0, slope, x[2] * SPAN])
        end = rod.shot(start, np.array([x[0], x[1]]), np.hypot(SPAN, RISE))
        return np.array([(end[0] - SPAN) / RISE, (end[1] - RISE + drop) / RISE, end[2] - slope])

    return solved(excess, guess, 1e-8)


def test_lees_frame_under_a_prescribed_drop() -> None:
    """The load at three drops, by the reaction of the loaded point, converges to that of the elasticas."""
    drops = np.array([15.0, 40.0, 55.0])
    guess, exact = np.array([-0.1, -0.5, 0.2, 0.8]), []
    for drop in np.linspace(5.0, 55.0, 11):
        guess = lee_load(drop, guess)
        if drop in drops:
            exact.append(guess[3])
    error = []
    for pieces in (1, 2):
        frame = lee(pieces)
        frame.loads.clear()
        frame.prescribe("P", uy=-drops)
        solution = frame.solve(large=True, steps=8)
        assert solution.stable.all()
        error.append(np.abs(-solution.reaction("P")[:, 1] - exact))
    assert (error[0] / error[1]).min() > 8.0
    assert error[1].max() < 1e-3


def test_lees_frame_along_its_path() -> None:
    """The limit load 1.855 (Lee et al.) and the return through zero; unstable between the limits."""
    path = lee(2).path("P", "uy", -80.0, steps=400, first=0.01)
    drop = -path.displacement("P")[:, 1]
    upper, lower = path.limits[0][:2]
    assert upper == pytest.approx(1.855, abs=0.01)
    assert lower < -0.9
    at_limit = drop[np.argmax(path.factor[drop < 60.0])]
    assert at_limit == pytest.approx(48.8, abs=2.0)
    assert path.stable[drop < 45.0].all()
    assert not path.stable[(drop > 52.0) & (drop < 57.0)].any()


def test_toggle_under_a_prescribed_drop() -> None:
    """The load at five drops, by the reaction of the apex, converges to that of the elastica."""
    drops = np.array([0.1, 0.2, 0.35, 0.5, 0.65])
    guess, exact = np.array([-10.0, -2.0, 0.0]), []
    for drop in np.linspace(0.025, 0.65, 26):
        guess = toggle_load(drop, guess)
        if np.any(np.isclose(drop, drops)):
            exact.append(-2.0 * guess[1])
    error = []
    for pieces in (2, 4):
        frame = toggle(pieces)
        frame.loads.clear()
        frame.prescribe("C", uy=-drops)
        solution = frame.solve(large=True, steps=5)
        error.append(np.abs(-solution.reaction("C")[:, 1] - exact))
    assert (error[0] / error[1]).min() > 8.0
    assert error[1].max() < 1e-3 * np.abs(exact).max()


def test_toggle_snaps_where_its_limit_is_exceeded() -> None:
    path = toggle(4).path("C", "uy", -0.7, first=0.5, steps=300)
    upper, lower = path.limits[0][:2]
    assert upper == pytest.approx(34.0, abs=0.7)  # Williams' experiment and theory
    assert lower < upper
    frame = toggle(4)
    frame.loads.clear()
    frame.load("C", fy=-upper * np.array([0.97, 1.03]))
    solution = frame.solve(large=True, steps=8)
    assert (solution.status != "not converged").all()
    assert solution.stable.all()
    apex = solution.displacement("C")[:, 1]
    assert apex[0] > -0.5 * RISE
    assert apex[1] < -1.2 * RISE


def test_paths_refuse_what_they_cannot_follow() -> None:
    with pytest.raises(FrameError, match="'Q' is unknown"):
        lee(1).path("Q", "uy", -1.0)
    with pytest.raises(FrameError, match="not zero"):
        lee(1).path("P", "uy", 0.0)
