"""Stiffness of the prismatic beam: closed forms, invariants, textbook deflections."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Material, Rectangle, Section
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
BAR = Rectangle(y=0.12, z=0.05)
FRACTIONS = np.linspace(0.0, 1.0, 5)

sizes = st.floats(0.05, 0.5)
beams = st.builds(
    lambda y, z, y2, z2, taper, shear: Beam(
        Rectangle(y=y, z=z), STEEL, end=Rectangle(y=y2, z=z2) if taper else None, shear=shear
    ),
    sizes, sizes, sizes, sizes, st.booleans(), st.booleans(),
)  # fmt: skip
lengths = st.floats(0.5, 5.0)


def przemieniecki(EA: float, GJ: float, EIy: float, EIz: float, phi_y: float, phi_z: float, L: float) -> Array:
    """Przemieniecki, Theory of Matrix Structural Analysis (1968), Eq. 5.116, row by row; phi_y goes with Iz."""
    K = np.zeros((12, 12))
    K[0, 0], K[3, 3] = EA / L, GJ / L
    K[1, 1] = 12 * EIz / (L**3 * (1 + phi_y))
    K[2, 2] = 12 * EIy / (L**3 * (1 + phi_z))
    K[4, 2], K[4, 4] = -6 * EIy / (L**2 * (1 + phi_z)), (4 + phi_z) * EIy / (L * (1 + phi_z))
    K[5, 1], K[5, 5] = 6 * EIz / (L**2 * (1 + phi_y)), (4 + phi_y) * EIz / (L * (1 + phi_y))
    K[6, 0], K[6, 6] = -EA / L, EA / L
    K[7, 1], K[7, 5], K[7, 7] = -K[1, 1], -K[5, 1], K[1, 1]
    K[8, 2], K[8, 4], K[8, 8] = -K[2, 2], -K[4, 2], K[2, 2]
    K[9, 3], K[9, 9] = -GJ / L, GJ / L
    K[10, 2], K[10, 4] = K[4, 2], (2 - phi_z) * EIy / (L * (1 + phi_z))
    K[10, 8], K[10, 10] = -K[4, 2], K[4, 4]
    K[11, 1], K[11, 5] = K[5, 1], (2 - phi_y) * EIz / (L * (1 + phi_y))
    K[11, 7], K[11, 11] = -K[5, 1], K[5, 5]
    return K + np.tril(K, -1).T


@pytest.mark.parametrize("shear", [False, True])
def test_springs_are_those_of_the_closed_form(shear: bool) -> None:
    """Of beams of many lengths, second moments that vary along another axis, and both planes apart."""
    section = Section(A=1.1e-3, Iy=2e-7, Iz=np.array([3e-7, 9e-7]), J=1e-7, ky=0.83, kz=0.7)
    L = np.array([[0.2], [1.7], [12.0]])
    stiffness, rows = Beam(section, STEEL, shear=shear).springs(L)
    found = np.einsum("...s,...si,...sj->...ij", stiffness, rows, rows)
    E, G = 200e9, STEEL.G
    for at in np.ndindex(3, 2):
        Iz, length = section.Iz[at[1]], float(L[at[0], 0])
        by, bz = (12 * E / (G * 1.1e-3 * length**2) * (ratio if shear else 0.0) for ratio in (Iz / 0.83, 2e-7 / 0.7))
        wanted = przemieniecki(E * 1.1e-3, G * 1e-7, E * 2e-7, E * Iz, by, bz, length)
        least = np.abs(wanted).min(where=wanted != 0.0, initial=np.inf)
        assert_allclose(found[at], wanted, rtol=1e-14, atol=1e-14 * least)


@pytest.mark.parametrize("shear", [False, True])
@given(y=sizes, z=sizes, length=lengths)
def test_closed_form(shear: bool, y: float, z: float, length: float) -> None:
    beam = Beam(Rectangle(y=y, z=z), STEEL, shear=shear)
    A, Iy, Iz = y * z, y * z**3 / 12, z * y**3 / 12
    E, G = 200e9, 200e9 / 2.6
    phi = [12 * E * inertia / (5 / 6 * G * A * length**2) if shear else 0.0 for inertia in (Iz, Iy)]
    expected = przemieniecki(E * A, G * beam.section.J, E * Iy, E * Iz, *phi, length)
    K = beam.stiffness_matrix(length)
    # 2 - phi may vanish: each entry to rounding of the diagonal ones that it couples
    size = np.sqrt(np.diag(expected))
    assert_allclose(K / np.outer(size, size), expected / np.outer(size, size), atol=2e-14)
    if not shear:
        assert np.array_equal(K != 0.0, expected != 0.0)


def rigid_motions(length: float) -> Array:
    """Six motions of the member as a whole, as columns: three translations, three turns about the start."""
    motions = np.zeros((12, 6))
    motions[:6], motions[6:] = np.eye(6), np.eye(6)
    motions[8, 4], motions[7, 5] = -length, length
    return motions


@given(beam=beams, length=lengths)
def test_rigid_motion_costs_no_energy(beam: Beam, length: float) -> None:
    K = beam.stiffness_matrix(length)
    rigid = rigid_motions(length)
    scale = np.sqrt(np.outer(np.diag(K), np.ones(6)) * np.abs(np.diag(K)).max()) * (1 + length)
    assert np.all(np.abs(K @ rigid) <= 1e-14 * scale)
    assert_allclose(beam.shape_functions(length, 0.3 * length) @ rigid, [
        [1, 0, 0, 0, 0, 0],
        [0, 1, 0, 0, 0, 0.3 * length],
        [0, 0, 1, 0, -0.3 * length, 0],
        [0, 0, 0, 1, 0, 0],
        [0, 0, 0, 0, 1, 0],
        [0, 0, 0, 0, 0, 1],
    ], atol=1e-12)  # fmt: skip


@given(beam=beams, length=lengths)
def test_symmetric_to_the_last_bit_and_of_rank_six(beam: Beam, length: float) -> None:
    K = beam.stiffness_matrix(length)
    assert np.array_equal(K, K.T)
    scale = 1 / np.sqrt(np.diag(K))
    eigenvalues = np.linalg.eigvalsh(scale[:, None] * K * scale)
    assert np.all(np.abs(eigenvalues[:6]) < 1e-13)
    assert eigenvalues[6] > 1e-4
    # axial, torsion and the two planes of bending do not meet
    meets = np.zeros((12, 12), dtype=bool)
    for group in ((0, 6), (3, 9), (1, 5, 7, 11), (2, 4, 8, 10)):
        meets[np.ix_(group, group)] = True
    assert np.array_equal(K != 0.0, meets)


@given(beam=beams, length=lengths, seed=st.integers(0, 100))
def test_end_forces_are_the_slope_of_the_strain_energy(beam: Beam, length: float, seed: int) -> None:
    """Central differences of 1/2 int strain^2 / flexibility dx, quadratic and so without error but rounding."""
    u = np.random.default_rng(seed).normal(size=12)
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = (x + 1) / 2 * length, w / 2 * length
    gradient, value = beam.shape_gradients(length, x), beam.shape_functions(length, x)
    flexibility = beam.section_flexibility(x / length)

    def energy(u: Array) -> float:
        strain = gradient @ u
        strain[:, 1] -= value[:, 5] @ u
        strain[:, 2] += value[:, 4] @ u
        rigid = flexibility == 0.0
        assert_allclose(strain[rigid], 0.0, atol=1e-10)
        return float(np.sum(w[:, None] * np.where(rigid, 0.0, strain**2 / np.where(rigid, 1.0, flexibility))) / 2)

    slope = np.array([(energy(u + step) - energy(u - step)) / 2 for step in np.eye(12)])
    forces = beam.end_forces(length, u)
    assert_allclose(slope, forces, atol=1e-9 * np.abs(beam.stiffness_matrix(length) @ np.diag(u)).max())


@given(beam=beams, length=lengths, seed=st.integers(0, 100))
def test_end_forces_are_stiffness_times_displacement(beam: Beam, length: float, seed: int) -> None:
    u = np.random.default_rng(seed).normal(size=(3, 12))
    K = beam.stiffness_matrix(length)
    assert_allclose(beam.end_forces(length, u), u @ K, atol=1e-13 * np.abs(K).max() * 12)


@given(shift=st.floats(1.0, 1e6))
def test_a_large_motion_of_the_whole_costs_end_forces_no_digits(shift: float) -> None:
    """Small strain on a large translation: K u leaves its rounding, the deformations do not."""
    beam, u = Beam(BAR, STEEL), np.zeros(12)
    u[[1, 7]] = shift
    assert not np.any(beam.end_forces(2.0, u))
    moved = u.copy()
    moved[6] = 2.0**-30
    assert_allclose(beam.end_forces(2.0, moved), beam.end_forces(2.0, moved - u), rtol=1e-15)


@given(beam=beams, length=lengths)
def test_seen_from_the_other_end(beam: Beam, length: float) -> None:
    """Half a turn about z swaps the ends: x and y are reversed, z stays."""
    other = beam if beam.end is None else replace(beam, section=beam.end, end=beam.section)
    signs = np.array([-1.0, -1.0, 1.0] * 4)
    turn = np.zeros((12, 12))
    turn[np.arange(12), (np.arange(12) + 6) % 12] = signs
    K = beam.stiffness_matrix(length)
    for mine, theirs in (
        (K, other.stiffness_matrix(length)),
        (beam.mass_matrix(length), other.mass_matrix(length)),
        (beam.geometric_matrix(length, 1.0), other.geometric_matrix(length, 1.0)),
    ):
        assert_allclose(turn @ theirs @ turn.T, mine, atol=1e-12 * np.abs(mine).max())


def test_cantilever_in_six_loads() -> None:
    """Gere & Goodno, Mechanics of Materials, 7th ed., Table G-1, cases 4 and 6; Timoshenko: P L^3/3EI + P L/kGA."""
    L, E, G = 1.5, 200e9, 200e9 / 2.6
    A, Iy, Iz = 0.12 * 0.05, 0.12 * 0.05**3 / 12, 0.05 * 0.12**3 / 12
    for shear in (False, True):
        beam = Beam(BAR, STEEL, shear=shear)
        F = np.linalg.inv(beam.stiffness_matrix(L)[6:, 6:])
        sway = L / (5 / 6 * G * A) if shear else 0.0
        expected = np.diag([
            L / (E * A), L**3 / (3 * E * Iz) + sway, L**3 / (3 * E * Iy) + sway,
            L / (G * BAR.J), L / (E * Iy), L / (E * Iz),
        ])  # fmt: skip
        expected[1, 5] = expected[5, 1] = L**2 / (2 * E * Iz)
        expected[2, 4] = expected[4, 2] = -(L**2) / (2 * E * Iy)
        assert_allclose(F, expected, rtol=1e-12, atol=1e-24)


def test_each_shear_area_in_its_own_plane() -> None:
    """P L / (ky G A) is what Timoshenko's beam adds to uy, P L / (kz G A) to uz."""
    section, L = Section(A=0.02, Iy=3e-5, Iz=7e-5, J=4e-5, ky=0.8, kz=0.3), 0.9
    soft, stiff = (Beam(section, STEEL, shear=shear).stiffness_matrix(L)[6:, 6:] for shear in (True, False))
    added = np.diag(np.linalg.inv(soft) - np.linalg.inv(stiff))
    assert_allclose(added[[1, 2]] * STEEL.G * 0.02 / L, [1 / 0.8, 1 / 0.3], rtol=1e-10)


@given(y=sizes, length=lengths)
def test_parts_make_the_whole(y: float, length: float) -> None:
    """Condensing the inner node of two parts gives the one element, for a taper and with releases as well."""
    beam = Beam(
        Rectangle(y=y, z=0.1), STEEL, end=Rectangle(y=0.3, z=0.2), shear=True, release=("start rz", "end ry", "end uy")
    )
    K = np.zeros((18, 18))
    for i in range(2):
        K[6 * i : 6 * i + 12, 6 * i : 6 * i + 12] += beam.part(i, 2).stiffness_matrix(length / 2)
    outer, inner = np.r_[0:6, 12:18], np.r_[6:12]
    # the inner node is free about z between a hinge and a slide: no moment reaches it
    condensed = (
        K[np.ix_(outer, outer)]
        - K[np.ix_(outer, inner)] @ np.linalg.pinv(K[np.ix_(inner, inner)]) @ K[np.ix_(inner, outer)]
    )
    whole = beam.stiffness_matrix(length)
    assert_allclose(condensed, whole, atol=1e-9 * np.abs(whole).max())


def test_parts_keep_what_falls_to_them() -> None:
    beam = Beam(BAR, STEEL, segments=4, release=("start rz", "end ry"))
    parts = [beam.part(i, 4) for i in range(4)]
    assert [part.releases for part in parts] == [((0, 5),), (), (), ((1, 4),)]
    assert all(part.segments == 1 for part in parts)
    assert parts[1].kind == parts[2].kind == Beam(BAR, STEEL).kind
    assert len({beam.kind, parts[0].kind, parts[1].kind, parts[3].kind}) == 4


def test_kind_tells_beams_apart() -> None:
    other = Rectangle(y=0.1, z=0.1)
    beams = [
        Beam(BAR, STEEL),
        Beam(other, STEEL),
        Beam(BAR, Material(E=1.0, nu=0.0)),
        Beam(BAR, STEEL, end=other),
        Beam(BAR, STEEL, shear=True),
        Beam(BAR, STEEL, up=(0.0, 1.0, 0.0)),
        Beam(BAR, STEEL, release=("start rx",)),
    ]
    assert len({beam.kind for beam in beams}) == len(beams)
    assert Beam(BAR, STEEL, up=(0.0, 1.0, 0.0)).kind == beams[5].kind


@pytest.mark.parametrize("end", [None, Rectangle(y=0.05, z=0.08)])
@pytest.mark.parametrize("shear", [False, True])
@pytest.mark.parametrize("release", [(), ("start rz", "end ry")])
def test_a_batch_is_its_members(end: Rectangle | None, shear: bool, release: tuple[str, ...]) -> None:
    """Lengths (3, 1) with moduli (4,): every stack is (3, 4, ...) and equal to the members one by one."""
    E, L = np.linspace(1e11, 2e11, 4), np.array([[1.0], [2.0], [3.0]])
    batch = Beam(BAR, Material(E=E, nu=0.3, density=7850.0), end=end, shear=shear, release=release)
    u, axial = np.random.default_rng(1).normal(size=(3, 4, 12)), np.linspace(-1.0, 1.0, 4)
    stacks = (
        batch.stiffness_matrix(L),
        batch.mass_matrix(L),
        batch.geometric_matrix(L, axial),
        batch.end_forces(L, u),
        batch.shape_functions(L, 0.3 * L),
        batch.shape_gradients(L, 0.3 * L),
        batch.section_flexibility(np.full((3, 1), 0.3)),
    )
    assert batch.shape == (4,)
    for i, j in np.ndindex(3, 4):
        one = Beam(BAR, Material(E=E[j], nu=0.3, density=7850.0), end=end, shear=shear, release=release)
        length = float(L[i, 0])
        members = (
            one.stiffness_matrix(length),
            one.mass_matrix(length),
            one.geometric_matrix(length, axial[j]),
            one.end_forces(length, u[i, j]),
            one.shape_functions(length, 0.3 * length),
            one.shape_gradients(length, 0.3 * length),
            one.section_flexibility(0.3),
        )
        for stack, member in zip(stacks, members, strict=True):
            found = np.broadcast_to(stack, (3, 4, *member.shape))[i, j]
            assert_allclose(found, member, rtol=1e-12, atol=1e-14 * np.abs(member).max())
            assert np.array_equal(found == 0.0, member == 0.0)


def test_order_in_the_batch_does_not_change_a_bit() -> None:
    L = np.random.default_rng(2).uniform(1.0, 3.0, 1001)
    for beam in (Beam(BAR, STEEL, shear=True), Beam(BAR, STEEL, end=Rectangle(y=0.05, z=0.08))):
        K = beam.stiffness_matrix(L)
        assert np.array_equal(beam.stiffness_matrix(L[::-1].copy()), K[::-1])
        assert np.array_equal(beam.stiffness_matrix(L[:7]), K[:7])


@pytest.mark.parametrize(
    ("given_", "told"),
    [
        ({"section": STEEL}, "section is a Material; give a CrossSection"),
        ({"material": BAR}, "material is a Rectangle; give a Material"),
        ({"end": Circle(diameter=1.0)}, "end is a Circle and section a Rectangle; give two of one type"),
        ({"up": (0.0, 1.0)}, r"up has shape \(2,\)"),
        ({"up": (0.0, 0.0, 0.0)}, "up = 0 must be a direction"),
        ({"up": (0.0, float("nan"), 1.0)}, "up = nan must be a direction"),
        ({"segments": 0}, "segments = 0 must be a whole number above zero"),
        ({"segments": 2.5}, "segments = 2.5 must be"),
        ({"material": Material(E=np.ones(2), nu=0.3), "section": Rectangle(y=np.ones(3), z=1.0)}, "do not broadcast"),
        ({"section": Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0), "shear": True}, "shear deformation needs ky, kz"),
    ],
)
def test_what_cannot_be_is_refused(given_: dict[str, object], told: str) -> None:
    with pytest.raises(FrameError, match=told):
        Beam(**{"section": BAR, "material": STEEL, **given_})  # type: ignore[arg-type]
