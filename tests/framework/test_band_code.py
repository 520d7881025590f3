"""Factors of bands side by side: the same matrices, lane by lane, whatever stands beside them."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from linkframe.framework.cache import PATTERNS
from linkframe.framework.solvers import band_factors
from linkframe.framework.solvers.band_factors import AllAtOnce, OneByOne, SideBySide
from linkframe.framework.solvers.stacked import StackedSolver

SECTION = Section(A=0.01, Iy=1e-5, Iz=2e-5, J=2e-5)


def matrices(count: int, size: int, width: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Diagonally dominant ones in bands: what is not zero (entries, count), where it lies, and each as a whole."""
    rng = np.random.default_rng(1)
    column, below = np.divmod(np.arange(size * width), width)
    position = np.flatnonzero(column + below < size)
    values = rng.uniform(-1.0, 1.0, (len(position), count))
    values[below[position] == 0] = 2.0 * width
    whole = np.zeros((count, size, size))
    row, column = (column + below)[position], column[position]
    whole[:, row, column] = whole[:, column, row] = values.T
    return values, position, whole


@pytest.mark.parametrize(("count", "size", "width"), [(1, 5, 1), (8, 7, 3), (11, 40, 12), (19, 6, 6)])
def test_solutions_are_those_of_dense_matrices(count: int, size: int, width: int) -> None:
    """Of all entries, and of some in any order; the least pivot is that of Cholesky's factor."""
    pytest.importorskip("llvmlite")
    values, position, whole = matrices(count, size, width)
    factors = SideBySide(values, position, size, width)
    diagonal = np.diagonal(np.linalg.cholesky(whole), axis1=1, axis2=2)
    np.testing.assert_allclose(factors.least, np.minimum(diagonal.min(axis=1), 1.0), rtol=1e-14)
    loads = np.random.default_rng(2).standard_normal((size, count, 3))
    for entries in (np.arange(count), np.arange(count)[::-2]):
        found = loads[:, entries].copy()
        factors.solve(entries, found)
        exact = np.linalg.solve(whole[entries], np.swapaxes(loads[:, entries], 0, 1))
        np.testing.assert_allclose(np.swapaxes(found, 0, 1), exact, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(("count", "size", "width"), [(1, 5, 1), (8, 7, 3), (11, 40, 12)])
def test_numpy_gives_the_bits_of_machine_code(count: int, size: int, width: int) -> None:
    """Factors, and solutions for all entries and for some, also of a band that is narrower at its end."""
    pytest.importorskip("llvmlite")
    values, position, _ = matrices(count, size, width)
    thin = position // width < size // 2
    for inside in (slice(None), thin | (position % width == 0)):
        one, other = (kind(values[inside], position[inside], size, width) for kind in (SideBySide, AllAtOnce))
        np.testing.assert_array_equal(one.least, other.least)
        loads = np.random.default_rng(2).standard_normal((size, count, 2))
        for entries in (np.arange(count), np.arange(count)[::-2]):
            found = [loads[:, entries].copy() for _ in range(2)]
            one.solve(entries, found[0])
            other.solve(entries, found[1])
            np.testing.assert_array_equal(*found)


def test_numpy_finds_what_is_not_definite() -> None:
    """Beside others, which it does not change."""
    values, position, whole = matrices(9, 20, 4)
    values[0, 3] = -1.0
    factors = AllAtOnce(values, position, 20, 4)
    assert np.flatnonzero(~(factors.least > 0.0)).tolist() == [3]
    loads = np.ones((20, 9, 1))
    factors.solve(np.arange(9), loads)
    rest = np.arange(9) != 3
    exact = np.linalg.solve(whole[rest], np.ones((8, 20, 1)))
    np.testing.assert_allclose(np.swapaxes(loads, 0, 1)[rest], exact, rtol=1e-12)


def test_lanes_know_nothing_of_each_other() -> None:
    """The same bits beside others, beside one that is not definite, and alone; that one alone has no pivot."""
    pytest.importorskip("llvmlite")
    values, position, _ = matrices(10, 20, 4)
    values[0, 3] = -1.0
    loads = np.random.default_rng(2).standard_normal((20, 10, 1))
    together = loads.copy()
    factors = SideBySide(values, position, 20, 4)
    factors.solve(np.arange(10), together)
    definite = factors.least > 0.0
    assert np.flatnonzero(~definite).tolist() == [3]
    for k in np.flatnonzero(definite).tolist():
        alone = loads[:, k : k + 1].copy()
        SideBySide(values[:, k : k + 1], position, 20, 4).solve(np.zeros(1, dtype=np.int64), alone)
        np.testing.assert_array_equal(alone[:, 0], together[:, k])


def test_the_same_by_either(monkeypatch: pytest.MonkeyPatch) -> None:
    """Displacements by LAPACK and side by side agree to the last bits of the largest of an entry."""
    pytest.importorskip("llvmlite")
    modulus = 2e11 * np.linspace(0.9, 1.1, 13)
    modulus[5] = 2e-3

    def solved() -> tuple[np.ndarray, type]:
        frame, beam = Frame(), Beam(SECTION, Material(E=modulus, nu=0.3))
        for k in range(13):
            frame.node(f"{k}", (float(k), 0.1 * k * k, 0.0))
            if k:
                frame.add(f"m{k}", beam, f"{k - 1}", f"{k}")
        frame.fix("0")
        frame.load("12", fx=1.0, fy=2.0, fz=3.0)
        solution = frame.solve("banded")
        found, solver = solution.displacement("12"), solution.solver
        assert isinstance(solver, StackedSolver)
        assert (solution.status == "regular").all()
        factor = next(solver.factors(solver.bands(solver.loaded)))[1]
        return found, type(factor._factors)

    monkeypatch.setattr(band_factors, "_MANY", 10**6)
    one, kind = solved()
    assert kind is OneByOne
    monkeypatch.setattr(band_factors, "_MANY", 0)
    other, kind = solved()
    assert kind is SideBySide
    least = np.finfo(float).eps * np.abs(one).max(axis=1, keepdims=True)
    assert (np.abs(other - one) <= 4.0 * least).all()
    assert (np.abs(other * modulus[:, None] - other[0] * modulus[0]) <= 16.0 * least * modulus[:, None]).all()


def test_what_is_kept_of_another_frame_changes_nothing() -> None:
    """Bit by bit, a frame after others of its topology, of which patterns are kept, and one that comes first."""

    def tip(length: float, turned: float) -> np.ndarray:
        frame, beam = Frame(), Beam(SECTION, Material(E=2e11, nu=0.3))
        for k in range(30):
            frame.node(f"{k}", (length * k, turned * k, 0.0))
            if k:
                frame.add(f"m{k}", beam, f"{k - 1}", f"{k}")
        frame.fix("0")
        frame.load("29", fx=1.0, fy=2.0, fz=3.0 * np.linspace(0.0, 1.0, 3))
        return frame.solve("banded").displacement("29")

    cases = [(1.0, 0.0), (1.0, 0.3), (0.2, 0.3), (1.0, 0.0)]
    PATTERNS.clear()
    warm = [tip(*case) for case in cases]
    for case, found in zip(cases, warm, strict=True):
        PATTERNS.clear()
        np.testing.assert_array_equal(tip(*case), found)
