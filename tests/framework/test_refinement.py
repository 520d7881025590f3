"""Refined solutions of single frames: to rounding, however finely members are divided."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from linkframe.framework.solvers import sparse, stiffness
from linkframe.framework.solvers.banded import BandedFactor

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


def chain(members: int, *, downwards: bool = False) -> Frame:
    """A mast of so many members of length one, its foot described first or last."""
    beam, frame = Beam(Section(A=A, Iy=IY, Iz=2 * IY, J=J), Material(E=E, G=G)), Frame()
    places = np.arange(members + 1)[:: -1 if downwards else 1]
    names = [f"{k}" for k in places]
    frame.add_nodes(names, np.stack([0.0 * places, 0.0 * places, places], axis=1))
    frame.add_many(beam, list(pairwise(names)))
    frame.fix("0")
    frame.load(f"{members}", fx=2.0, fz=5.0)
    return frame


@pytest.mark.parametrize(("downwards", "refined"), [(False, 20_000), (True, 20_000), (False, 1000)])
def test_long_chains_are_told_by_their_pivots(downwards: bool, refined: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Singular to double precision, and yet pivots tell that nothing moves: F L^3 / 3 E I without another factor.

    Whichever end is described first, elimination ends at the foot; larger frames are refined where they are soft.
    """
    monkeypatch.setattr(stiffness, "TensionFactor", None)
    monkeypatch.setattr(stiffness, "REFINED", refined)
    monkeypatch.setattr(sparse, "REFINED", refined)
    count = 1800
    solution = chain(count, downwards=downwards).solve()
    found = solution.displacement(f"{count}")[[0, 2]]
    assert solution.plan.method.name == "banded"
    assert solution.status == "regular"
    exact = [2.0 * count**3 / (3.0 * E * IY), 5.0 * count / (E * A)]
    np.testing.assert_allclose(found, exact, rtol=2e-15)


def test_pivots_that_tell_are_not_enough_where_refinement_does_not_end(monkeypatch: pytest.MonkeyPatch) -> None:
    """Then the factor by tensions solves, as if pivots had told nothing."""
    count, asked = 1800, []
    made = stiffness.TensionFactor
    monkeypatch.setattr(stiffness, "TensionFactor", lambda *given: asked.append(1) or made(*given))
    monkeypatch.setattr(sparse, "refined_by_springs", lambda residual, values, solve: (values, False))
    solution = chain(count).solve()
    assert abs(solution.displacement(f"{count}")[2] / (5.0 * count / (E * A)) - 1.0) < 1e-14
    assert solution.status == "regular"
    assert asked == [1]


def test_where_neither_pivots_nor_tensions_tell(monkeypatch: pytest.MonkeyPatch) -> None:
    """Extended precision tells that what is singular to double precision is no mechanism, and solves it."""
    monkeypatch.setattr(stiffness, "affordable", lambda *given: False)
    monkeypatch.setattr(BandedFactor, "surely_definite", False)
    count = 1400
    solution = chain(count).solve()
    found = solution.displacement(f"{count}")[[0, 2]]
    assert solution.status == "regular"
    np.testing.assert_allclose(found, [2.0 * count**3 / (3.0 * E * IY), 5.0 * count / (E * A)], rtol=1e-14)


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.MechanismWarning")
@pytest.mark.parametrize("count", [40, 400])
def test_chains_that_swing_about_their_foot_are_mechanisms(count: int) -> None:
    """Whose load does no work as it is along them: no pivot may tell that nothing moves."""
    frame = chain(count)
    frame.supports.clear()
    frame.fix("0", "ux", "uy", "uz", "rx", "rz")
    frame.loads.clear()
    frame.load(f"{count}", fz=5.0)
    solution = frame.solve("banded")
    assert solution.status == "statically consistent mechanism"
