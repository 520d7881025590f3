"""Springs that push at rest amplify what rounding of the other stiffnesses does: bounds tell by how much."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section, Spring
from linkframe.framework import Frame
from linkframe.framework.error_bounds import bounds
from linkframe.framework.error_bounds.bands import BandedCompliance
from linkframe.framework.error_bounds.compliance import Compliance, DenseCompliance
from linkframe.framework.error_bounds.energy import EnergyBound
from linkframe.framework.error_bounds.requested import requested
from linkframe.framework.error_bounds.sparse_compliance import SparseCompliance
from numpy.typing import NDArray

E, TIP, APART, MARGIN = 2e11, "(0, 0, 3)", 0.7, 4.0
SECTION = Section(A=1e-2, Iy=1e-5, Iz=2e-5, J=2e-5)
ROUNDING = 2.0**-53


def tower(force: float, modulus: float = E) -> Frame:
    """Beams, clamped below, with a spring in line on a corner of the top that carries a force."""
    rng, frame, shape = np.random.default_rng(0), Frame(), (2, 2, 4)
    for place in np.ndindex(*shape):
        frame.node(f"{place}", np.array(place) + 0.1 * rng.random(3))
        if place[2] == 0:
            frame.fix(f"{place}")
    for place in np.ndindex(*shape):
        for axis in range(3):
            other = tuple(int(k) for k in np.array(place) + np.eye(3, dtype=int)[axis])
            if other[axis] < shape[axis]:
                frame.add(f"{place}{axis}", Beam(SECTION, Material(E=modulus, nu=0.3)), f"{place}", f"{other}")
    frame.node("G", np.array(frame.nodes[TIP].coordinates) + np.array([0.0, 0.0, APART]))
    frame.fix("G")
    frame.add("spring", Spring(stiffness=1e4, force=force), TIP, "G")
    return frame


def critical() -> float:
    """Force of the spring that pushes the tower over: that of a string S / L takes off what the tip has across it."""
    columns = []
    for name in ("fx", "fy"):
        frame = tower(0.0)
        frame.load(TIP, **{name: 1.0})
        columns.append(frame.solve("sparse").displacement(TIP)[:2])
    return -APART / float(np.linalg.eigvalsh(np.array(columns)).max())


def test_energy_covers_the_rounding_of_members_close_to_being_pushed_over() -> None:
    """All beams softer by a share h let the tip deflect by ten thousand times that share more."""
    force, step = 0.9999 * critical(), 1e-9
    frames = [tower(force, E * (1.0 + h)) for h in (0.0, step)]
    for frame in frames:
        frame.load(TIP, fx=1e3, fy=300.0)
    solution, other = frames[0].solve("iterative"), frames[1].solve("sparse")
    part = next(solution.bounds.parts())
    assert part.compliance.iterative
    by_energy = EnergyBound(part.state, part.compliance, requested(part.state, TIP, "displacement"), part.energy)
    change = np.abs(other.displacement(TIP) - solution.displacement(TIP)) / step
    assert (change > 9000.0 * np.abs(solution.displacement(TIP)))[[0, 1]].all()
    # beams are rounded by some units in the last place
    roundings = part.state.springs[0].roundings
    assert (roundings * ROUNDING * change <= by_energy.error_bound()).all()


def cantilever(shares: NDArray[np.float64], loads: NDArray[np.float64]) -> Frame:
    """A beam with a spring in line that carries shares of the force that pushes it over."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "G": 1.0 + APART}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Section(A=1e-2, Iy=1e-5, Iz=1e-5, J=2e-5), Material(E=E, nu=0.3)), "A", "B")
    frame.add("BG", Spring(stiffness=1e4, force=-shares * 3.0 * E * 1e-5 * APART), "B", "G")
    frame.fix("A")
    frame.fix("G")
    frame.load("B", fy=3.0 * loads, fz=1.0, fx=2.0, mx=1.0)
    return frame


SHARES = np.array([0.0, 0.01, 0.5, 0.99, 3.0])


@pytest.mark.parametrize("kind", [DenseCompliance, BandedCompliance, SparseCompliance])
def test_what_a_pushing_spring_amplifies(kind: type[Compliance], monkeypatch: pytest.MonkeyPatch) -> None:
    """At the tip the string takes off a share s of 1: the sizes together come to ``(1 + s) / |1 - s|``.

    The least eigenvalue is that of [[4 - s, -2], [-2, 4 / 3]], scaled to unit diagonal.
    """
    loads, found, least = np.array([1.0, -2.0]), [], []
    if kind is BandedCompliance:
        monkeypatch.setattr(bounds, "MOST", 0)
    if kind is SparseCompliance:
        parts = [next(cantilever(share, loads).solve("sparse").bounds.parts()) for share in SHARES]
    else:
        parts = [next(cantilever(SHARES[:, None], loads).solve("banded").bounds.parts())]
    for part in parts:
        assert isinstance(part.compliance, kind)
        least += np.ravel(part.compliance.least).tolist()
        found += np.ravel(part.compliance.amplification).tolist()
    exact = (1.0 + SHARES) / np.abs(1.0 - SHARES)
    assert (np.array(found) >= exact * (1.0 - 1e-9)).all()
    assert found[0] == 1.0
    eigenvalue = np.abs(1.0 - 2.0 / np.sqrt((4.0 - SHARES) * 4.0 / 3.0))
    assert (np.array(least) <= eigenvalue * (1.0 + 1e-9)).all()
    assert (np.array(least) >= eigenvalue / 100.0).all()
    if kind is not DenseCompliance:
        assert found[:4] == pytest.approx(1.0 + MARGIN * (exact[:4] - 1.0), rel=1e-6)


def test_a_batch_without_entries_by_bands(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bounds, "MOST", 0)
    solution = cantilever(np.zeros((0, 1)), np.array([1.0, -2.0])).solve("banded")
    assert solution.displacement("B").shape == solution.error_bound("B").shape == (0, 2, 6)
