"""Batches of matrices: terms that frames of one topology have in common, and residuals in pairs of double numbers."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import scipy
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.cache import TERMS
from linkframe.framework.solvers import band_factors
from linkframe.framework.solvers.refined_values import InLong
from linkframe.framework.solvers.stacked_refinement import refine

SECTION = Section(A=1e-3, Iy=1e-7, Iz=2e-7, J=3e-7)
LENGTH, FORCE, E = 0.5, (3.0, -2.0, 1.0), 2e11


def cantilever(members: int, modulus: np.ndarray) -> Frame:
    """Along x, with a load at its end."""
    frame, beam = Frame(), Beam(SECTION, Material(E=modulus, nu=0.3))
    for k in range(members + 1):
        frame.node(f"{k}", (LENGTH * k, 0.0, 0.0))
        if k:
            frame.add(f"m{k}", beam, f"{k - 1}", f"{k}")
    frame.fix("0")
    frame.load(f"{members}", fx=FORCE[0], fy=FORCE[1], fz=FORCE[2])
    return frame


def test_pairs_lose_nothing_of_a_motion_of_the_whole() -> None:
    """Differences of numbers that agree to sixty bits, against rational numbers, beside what is given."""
    pair_code = pytest.importorskip("linkframe.framework.program.pair_code")
    pytest.importorskip("llvmlite")
    rng = np.random.default_rng(3)
    for count in (1, 8, 19):
        shares = scipy.sparse.csr_matrix(np.array([[1.0, -1.0, 0.0], [0.0, 1.0, -1.0], [0.3, 0.0, 0.7]]))
        shares = scipy.sparse.csr_matrix(shares.astype(np.longdouble))
        values = pair_code.DoubleDouble(1.0 + np.zeros((3, count)), 2.0**-60 * rng.standard_normal((3, count)))
        stiffness, forces = rng.uniform(1.0, 2.0, (3, count)), np.zeros((3, count))
        given = pair_code.DoubleDouble(2.0**-61 * rng.standard_normal((3, count)), np.zeros((3, count)))
        rows, ones = pair_code.Rows.of(shares), np.ones((3, count))
        for known in (None, given):
            left = pair_code.unbalanced(rows, known, stiffness, forces, values, ones)
            for m in range(count):
                u = [Fraction(a) + Fraction(b) for a, b in zip(values.large[:, m], values.small[:, m], strict=True)]
                first, second = u[0] - u[1], u[1] - u[2]
                if known is not None:
                    first, second = first + Fraction(given.large[0, m]), second + Fraction(given.large[1, m])
                exact = float(Fraction(stiffness[0, m]) * first - Fraction(stiffness[1, m]) * second)
                size = abs(float(stiffness[0, m] * first)) + abs(float(stiffness[1, m] * second))
                assert abs(left[1, m] - exact) <= 1e-15 * size


def test_changes_are_added_without_loss() -> None:
    """The greatest of each column, and what is no number, come back."""
    pair_code = pytest.importorskip("linkframe.framework.program.pair_code")
    pytest.importorskip("llvmlite")
    rng = np.random.default_rng(4)
    for count, overwrite in ((1, False), (8, True), (16, False), (19, True)):
        large, change = rng.standard_normal((30, count)), 1e-9 * rng.standard_normal((30, count))
        small = 2.0**-60 * rng.standard_normal((30, count))
        change[5, 0] = np.nan
        values = pair_code.DoubleDouble(large.copy(), small.copy())
        values, found = pair_code.added(values, change, np.full_like(large, 0.5), overwrite=overwrite)
        np.testing.assert_array_equal(found, np.abs(change).max(axis=0))
        for a, b, one, rest, other in zip(*(each.flat for each in (*values, large, small, change)), strict=True):
            if np.isfinite(other):
                exact = Fraction(one) + Fraction(rest) + Fraction(other) / 2
                assert abs(Fraction(a) + Fraction(b) - exact) <= 2.0**-104


def test_what_shares_have_beyond_double_precision_counts() -> None:
    """Of a third less its rounding nothing else is left."""
    pair_code = pytest.importorskip("linkframe.framework.program.pair_code")
    pytest.importorskip("llvmlite")
    third = np.longdouble(1.0) / 3
    shares = scipy.sparse.csr_matrix(np.array([[third, -np.longdouble(float(third))]]))
    values, ones = pair_code.DoubleDouble(np.ones((2, 9)), np.zeros((2, 9))), np.ones((2, 9))
    left = pair_code.unbalanced(pair_code.Rows.of(shares), None, ones[:1], 0.0 * ones, values, ones)
    np.testing.assert_allclose(left[0], -float(third) * float(third - float(third)), rtol=1e-15)


def test_a_cantilever_in_pairs_is_as_exact_as_in_extended_precision(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against ``F L^3 / 3 E I``, though the deflection of a member is below rounding beside that of the end."""
    pytest.importorskip("llvmlite")
    members, modulus = 60, E * np.linspace(0.8, 1.25, 50)
    length = LENGTH * members
    exact = np.stack([FORCE[0] * length / SECTION.A, *(
        force * length**3 / (3.0 * inertia) for force, inertia in zip(FORCE[1:], (SECTION.Iz, SECTION.Iy), strict=True)
    )]) / modulus[:, None]  # fmt: skip
    errors = []
    for pairs in (True, False):
        monkeypatch.setattr(band_factors, "available", lambda pairs=pairs: pairs)
        found = cantilever(members, modulus).solve("banded").displacement(f"{members}")[:, :3]
        errors.append(np.abs(found / exact - 1.0).max())
    assert max(errors) < 2e-14
    assert errors[0] <= 2.0 * errors[1] + 1e-15


def framed(turned: float, *, joint: bool, held: str, loaded: int, imposed: float) -> Frame:
    """A chain of twelve members, its modulus a batch."""
    frame = Frame()
    beam = Beam(SECTION, Material(E=E * np.linspace(0.8, 1.2, 4), nu=0.3))
    for k in range(13):
        frame.node(f"{k}", (LENGTH * k, turned * k % 0.3, 0.1 * turned * k))
    if joint:
        frame.node("6'", (LENGTH * 6, turned * 6 % 0.3, 0.6 * turned))
        frame.add("joint", Joint(stiffness=(2e8, 2e8, np.inf, 2e5, 2e5, 1e4)), "6", "6'")
    for k in range(12):
        frame.add(f"m{k}", beam, "6'" if joint and k == 6 else f"{k}", f"{k + 1}")
    frame.fix("0")
    frame.fix("12", held)
    if imposed:
        frame.prescribe("12", ux=imposed)
    frame.load(f"{loaded}", fx=2.0, fy=3.0, mz=1.0)
    return frame


def test_frames_of_one_topology_do_not_know_of_each_other() -> None:
    """Bit by bit the same after others as first of all, and what broadcasting finds."""
    plain = {"joint": False, "held": "uy", "loaded": 5, "imposed": 0.0}
    cases = [
        (turned, plain | change)
        for change in ({}, {"joint": True}, {"held": "uz"}, {"loaded": 7}, {"imposed": 1e-4})
        for turned in (0.0, 0.7)
    ]
    TERMS.clear()
    warm = [framed(turned, **case).solve("banded").displacement("8") for turned, case in cases]
    assert len(TERMS) > 4  # a chain along x has fewer terms than one that turns
    for (turned, case), found in zip(cases, warm, strict=True):
        TERMS.clear()
        np.testing.assert_array_equal(framed(turned, **case).solve("banded").displacement("8"), found)
        other = framed(turned, **case).solve("broadcast").displacement("8")
        np.testing.assert_allclose(found, other, rtol=0.0, atol=1e-11 * np.abs(other).max())


def armed(arm: np.ndarray) -> Frame:
    """A chain that is loaded at the end of a rigid arm, which may have another place at each entry."""
    frame = framed(0.0, joint=False, held="uz", loaded=5, imposed=0.0)
    frame.node("X", arm)
    frame.rigid("9", "X")
    frame.load("X", fx=30.0, fy=-20.0)
    return frame


def test_an_arm_that_varies_is_not_taken_for_one_that_does_not() -> None:
    """They join the same unknowns."""
    places = np.array([LENGTH * 9, 0.2, 0.1]) + np.zeros((4, 3))
    places[:, 1] *= [1.0, 2.0, 3.0, 4.0]
    found = []
    for first, second in ((places[0], places), (places, places[0])):
        TERMS.clear()
        armed(first).solve("banded").displacement("8")
        found.append(armed(second).solve("banded").displacement("8"))
        TERMS.clear()
        np.testing.assert_array_equal(armed(second).solve("banded").displacement("8"), found[-1])
    np.testing.assert_allclose(found[0][0], found[1][0], rtol=0.0, atol=1e-11 * np.abs(found[0]).max())
    other = armed(places).solve("broadcast").displacement("8")
    np.testing.assert_allclose(found[0], other, rtol=0.0, atol=1e-11 * np.abs(other).max())


def test_an_entry_that_cannot_be_refined_keeps_what_it_has() -> None:
    """A step that is no number is none, whatever it leaves of the others."""

    class Factor:
        """Of matrices that are one."""

        count, root, rough = 3, np.ones((2, 3)), np.full(3, 1e-8)

        def solve(self, entries: np.ndarray, loads: np.ndarray) -> None:
            loads[:, entries == 1] = np.nan

    class Loads:
        """That are two."""

        def refined(self, values: np.ndarray, root: np.ndarray) -> InLong:
            return InLong(lambda found: (2.0 - found).astype(np.float64), values, root)

    values = np.full((2, 3, 1), 2.0 + 1e-8)
    refine(Loads(), Factor(), np.arange(3), values)  # type: ignore[arg-type]
    np.testing.assert_array_equal(values[:, :, 0], np.broadcast_to([2.0, 2.0 + 1e-8, 2.0], (2, 3)))
