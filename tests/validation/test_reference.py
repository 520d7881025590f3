"""The reference itself: its members against virtual work, the whole against a published frame."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose
from reference.random_structures import CLAMPED, constrained, screws
from reference.stiffness_method import DECIMAL, DOUBLE, EXACT, Arithmetic, mp, solve, tip_stiffness
from reference.structure import Member, Structure

MEMBER: dict[str, Any] = {"E": 2e11, "G": 7.5e10, "A": 8e-5, "Iy": 2.5e-10, "Iz": 1.1e-9, "J": 7e-10}


@pytest.mark.parametrize(("ky", "kz"), [(np.inf, np.inf), (0.8, 0.6)])
def test_tip_stiffness_is_the_inverse_of_the_flexibility(ky: float, kz: float) -> None:
    """Unit-load theorem: f_ij = integral of N_i N_j/EA + V_i V_j/kGA + T_i T_j/GJ + M_i M_j/EI, by quadrature.

    A unit load P at the tip, with components (force, moment), makes at x the section forces P and P + (L - x) e_x x P.
    50-digit arithmetic, so 1e-40.
    """
    member = Member("start", "end", ky=ky, kz=kz, **MEMBER)
    length = mp.mpf("0.173")
    E, G, A, Iy, Iz, J = (mp.mpf(MEMBER[name]) for name in ("E", "G", "A", "Iy", "Iz", "J"))
    shear = [0 if np.isinf(k) else 1 / (mp.mpf(k) * G * A) for k in (ky, kz)]
    soft = [1 / (E * A), *shear, 1 / (G * J), 1 / (E * Iy), 1 / (E * Iz)]

    def section(load: int, arm: mpmath.mpf) -> list[mpmath.mpf]:
        forces = [mp.mpf(int(i == load)) for i in range(6)]
        forces[4] -= arm * forces[2]
        forces[5] += arm * forces[1]
        return forces

    def work(i: int, j: int) -> mpmath.mpf:
        def density(x: mpmath.mpf) -> mpmath.mpf:
            return sum(a * b * s for a, b, s in zip(section(i, length - x), section(j, length - x), soft, strict=True))

        return mp.quad(density, [0, length])

    flexibility = np.array([[work(i, j) for j in range(6)] for i in range(6)], dtype=object)
    unit = tip_stiffness(member, length, EXACT) @ flexibility - np.eye(6, dtype=int)
    assert max(abs(value) for value in unit.ravel()) < mp.mpf("1e-40")


@pytest.mark.parametrize("arithmetic", [EXACT, DECIMAL, DOUBLE], ids=["50 digits", "decimal", "double"])
def test_published_space_frame(arithmetic: Arithmetic) -> None:
    """Weaver, Computer Programs for Structural Analysis, 1967, p. 146, problem 8: half a unit of the fifth decimal."""
    numbers: dict[str, Any] = {"E": 30000.0, "G": 12000.0, "A": 11.0, "Iy": 56.0, "Iz": 56.0, "J": 83.0}
    structure = Structure(
        nodes={"1": (0.0, 120.0, 0.0), "2": (240.0, 120.0, 0.0), "3": (0.0, 0.0, 0.0), "4": (360.0, 0.0, 120.0)},
        members={start + end: Member(start, end, **numbers) for start, end in ("12", "31", "24")},
        supports={"3": CLAMPED, "4": CLAMPED},
        loads={"1": (2.0, 0.0, 0.0, 0.0, 0.0, 0.0), "2": (0.0, -1.0, 0.0, 0.0, 0.0, -120.0)},
    )
    displacement = solve(structure, arithmetic).displacement
    for node, printed in {
        "1": [0.22267, 0.00016, -0.17182, -0.00255, 0.00217, -0.00213],
        "2": [0.22202, -0.48119, -0.70161, -0.00802, 0.00101, -0.00435],
    }.items():
        assert_allclose(displacement[node].astype(float), printed, rtol=0, atol=0.51e-5)


@settings(max_examples=5)
@given(st.one_of(constrained, screws))
def test_decimal_numbers_give_what_those_of_mpmath_give(structure: Structure) -> None:
    """Two arithmetics that share nothing, of 60 and of 50 digits; springs of 1e30 lose 30 of these."""
    ours, theirs = (vars(solve(structure, arithmetic)) for arithmetic in (DECIMAL, EXACT))
    for kind in ("displacement", "reaction", "extension"):
        values = {name: np.concatenate([*of[kind].values(), [mp.mpf(0)]]) for name, of in (("a", ours), ("b", theirs))}
        assert max(abs(values["a"] - values["b"])) <= mp.mpf("1e-18") * max(abs(values["b"]))
