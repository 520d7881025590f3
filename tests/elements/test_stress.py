"""Stresses: single forces by textbook formulas, combinations by a search over the whole contour."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Circle, CrossSection, ISection, Rectangle, Section, Tube
from linkframe.framework.errors import FrameError
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
N, VY, VZ, T, MY, MZ = np.eye(6)
ROOT3 = np.sqrt(3.0)
RECTANGLE, CIRCLE, TUBE = Rectangle(y=0.06, z=0.04), Circle(diameter=0.05), Tube(outer=0.05, thickness=0.004)
I_SECTION = ISection(height=0.3, width=0.15, web=0.007, flange=0.011)
ANY = Section(A=1e-3, Iy=2e-6, Iz=1e-6, J=3e-6, ky=0.8, kz=0.5, cy=0.03, cz=0.05, Wt=2e-5)
SHAPES = [RECTANGLE, CIRCLE, TUBE, I_SECTION, ANY]
# As it is, turned half round about x, and mirrored in either plane.
TURNED = np.array([[1] * 6, [1, -1, -1, 1, -1, -1], [1, -1, 1, -1, 1, -1], [1, 1, -1, -1, -1, 1]])
FORCES = st.tuples(*[st.integers(-100, 100)] * 6).map(
    lambda six: np.array(six) / 100 * [1e4, 5e3, 5e3, 200.0, 200.0, 200.0]
)


def extremes(section: CrossSection) -> tuple[float, float]:
    """Distances of the extreme fibres."""
    sizes = section.sizes()
    if isinstance(section, Section):
        return float(sizes["cy"]), float(sizes["cz"])
    y, z = {
        Rectangle: ("y", "z"),
        Circle: ("diameter", "diameter"),
        Tube: ("outer", "outer"),
        ISection: ("width", "height"),
    }[type(section)]
    return float(sizes[y]) / 2, float(sizes[z]) / 2


@pytest.mark.parametrize("section", SHAPES, ids=lambda s: type(s).__name__)
def test_tension_and_bending(section: CrossSection) -> None:
    """N / A and M c / I."""
    cy, cz = extremes(section)
    assert_allclose(section.stress(-2.0 * N), np.array([-1.0, -1.0, 1.0]) * 2.0 / section.A, rtol=1e-14)
    assert_allclose(section.stress(3.0 * MY), np.array([-1.0, 1.0, 1.0]) * 3.0 * cz / section.Iy, rtol=1e-14)
    assert_allclose(section.stress(3.0 * MZ), np.array([-1.0, 1.0, 1.0]) * 3.0 * cy / section.Iz, rtol=1e-14)


@pytest.mark.parametrize(
    ("section", "forces", "shear"),
    [
        (RECTANGLE, VY, 1.5 / (0.06 * 0.04)),  # Gere & Goodno, 7th ed., art. 5.8
        (RECTANGLE, VZ, 1.5 / (0.06 * 0.04)),
        (Rectangle(y=0.03, z=0.02), T, 1.0 / (0.231 * 0.02**2 * 0.03)),  # Timoshenko & Goodier, p. 312
        (Rectangle(y=0.02, z=0.03), T, 1.0 / (0.231 * 0.02**2 * 0.03)),
        (CIRCLE, VY, 4 / 3 / (np.pi * 0.025**2)),  # Gere & Goodno, art. 5.9
        (CIRCLE, VZ, 4 / 3 / (np.pi * 0.025**2)),
        (CIRCLE, T, 2 / (np.pi * 0.025**3)),  # Gere & Goodno, art. 3.3
        (TUBE, T, 16 * 0.05 / (np.pi * (0.05**4 - 0.042**4))),  # Gere & Goodno, art. 3.3
        # Gere & Goodno, art. 5.9: 4/3 V/A (r2^2 + r2 r1 + r1^2)/(r2^2 + r1^2)
        (
            TUBE,
            VZ,
            4 / 3 / (np.pi * (0.025**2 - 0.021**2)) * (0.025**2 + 0.025 * 0.021 + 0.021**2) / (0.025**2 + 0.021**2),
        ),
        # Gere & Goodno, art. 5.10: V/(8 I t) (b h^2 - b h1^2 + t h1^2)
        (I_SECTION, VZ, (0.15 * 0.3**2 - 0.15 * 0.278**2 + 0.007 * 0.278**2) / (8 * I_SECTION.Iy * 0.007)),
        (I_SECTION, T, 0.011 / I_SECTION.J),  # thickest wall of a thin open section, Timoshenko & Goodier, art. 108
        (ANY, T, 1 / 2e-5),
        (ANY, VY, 1 / 0.8e-3),
        (ANY, VZ, 1 / 0.5e-3),
    ],
)
def test_single_shear(section: CrossSection, forces: Array, shear: float) -> None:
    """The torsion of a rectangle is a printed three-digit number."""
    printed = isinstance(section, Rectangle) and forces is not VY and forces is not VZ and bool(forces[3])
    assert section.stress(forces)[2] == pytest.approx(ROOT3 * shear, rel=2e-3 if printed else 1e-12)


def test_shear_along_the_flanges_of_an_i() -> None:
    """V Q / (I t) at the middle of a flange: 3/2 V / (2 b tf), but for the little that the web carries."""
    assert I_SECTION.stress(VY)[2] == pytest.approx(ROOT3 * 1.5 / (2 * 0.15 * 0.011), rel=0.01)


@given(forces=FORCES, wall=st.sampled_from([0.001, 0.01, 0.025]))
def test_rim(forces: Array, wall: float) -> None:
    """The search over the angle finds what a fine sweep of the stresses finds; sum of y and z parts, one by one."""
    section = Tube(outer=0.05, thickness=wall)
    inner = 0.05 - 2 * wall
    angle = np.linspace(0.0, 2 * np.pi, 20001)
    y, z = 0.025 * np.cos(angle), 0.025 * np.sin(angle)
    n, vy, vz, t, my, mz = forces
    normal = n / section.A - mz * y / section.Iz + my * z / section.Iy
    peak = 4 / 3 * (0.05**2 + 0.05 * inner + inner**2) / (0.05**2 + inner**2) / section.A
    tangent = t * 0.025 / section.J - vy * peak * np.sin(angle) + vz * peak * np.cos(angle)
    mises = np.sqrt(normal**2 + 3 * tangent**2)
    found = section.stress(forces)
    scale = max(float(mises.max()), 1e-300)
    # the sweep misses a peak by less than (pi / 20000)^2 of the stress's size
    assert_allclose(found, [normal.min(), normal.max(), mises.max()], atol=2e-7 * scale)
    assert found[2] >= mises.max() * (1 - 1e-14)


def test_rim_with_two_peaks_almost_alike() -> None:
    """The best of the samples need not be next to the greatest stress: a fine sweep with parabolas finds the same."""
    forces = np.random.default_rng(10).normal(size=(5000, 6)) * [1e4, 5e3, 5e3, 200.0, 200.0, 200.0]
    forces[0] = 1108.3, 816.8, -5139.9, 69.31, 188.24, -20.32
    angle = 2 * np.pi * np.arange(720) / 720
    c, s = np.cos(angle), np.sin(angle)
    n, vy, vz, t, my, mz = (force[:, None] for force in forces.T)
    normal = n / CIRCLE.A + (my * s - mz * c) * 0.025 / CIRCLE.Iy
    square = normal**2 + 3 * (t * 0.025 / CIRCLE.J + 4 / 3 * (vz * c - vy * s) / CIRCLE.A) ** 2
    before, after = np.roll(square, 1, axis=1), np.roll(square, -1, axis=1)
    bow = np.where(before + after - 2 * square < 0, 2 * square - before - after, np.inf)
    greatest = np.sqrt(
        (square + (after - before) ** 2 / (8 * bow)).max(
            axis=1, where=(square >= before) & (square >= after), initial=0.0
        )
    )
    assert_allclose(CIRCLE.stress(forces)[:, 2], greatest, rtol=1e-7)


def test_rim_where_the_greatest_stress_is_flat() -> None:
    """Where Newton's steps have least to go by."""
    area, radius = float(CIRCLE.A), 0.025
    # normal stress cos, tangential stress s sin with 3 s^2 = 1: constant along the rim
    moment, shear = float(CIRCLE.Iz) / radius, area * 3 / 4 / ROOT3
    assert CIRCLE.stress(moment * MZ + shear * VY)[2] == pytest.approx(1.0, rel=1e-14)
    # with a little tension, e, the maximum of 1 + 2 e cos + e^2 sits at one point
    assert CIRCLE.stress(moment * MZ + shear * VY + 1e-3 * area * N)[2] == pytest.approx(1.001, rel=1e-12)


@given(forces=FORCES)
def test_rectangle_at_every_point_that_is_known(forces: Array) -> None:
    """Not below stresses at corners, mid-sides and centre one by one, torsion turning y towards z."""
    b, h = 0.04, 0.06
    n, vy, vz, t, my, mz = forces
    modulus = dict(zip("yz", RECTANGLE.torsion_moduli, strict=True))
    worst = 0.0
    sizes = np.zeros(2)
    for y in (-1, 0, 1):
        for z in (-1, 0, 1):
            normal = n / RECTANGLE.A - mz * y * h / 2 / RECTANGLE.Iz + my * z * b / 2 / RECTANGLE.Iy
            xy = 1.5 * vy / (b * h) * (1 - y**2) - (z * t / modulus["z"] if y == 0 else 0.0)
            xz = 1.5 * vz / (b * h) * (1 - z**2) + (y * t / modulus["y"] if z == 0 else 0.0)
            if y == 0 and z != 0:
                xz = 0.0
            if z == 0 and y != 0:
                xy = 0.0
            worst = max(worst, np.sqrt(normal**2 + 3 * (xy**2 + xz**2)))
            sizes = np.maximum(sizes, [abs(normal), np.hypot(xy, xz)])
    found = RECTANGLE.stress(forces)[2]
    assert worst * (1 - 1e-12) <= found <= np.hypot(sizes[0], ROOT3 * sizes[1]) * (1 + 1e-12)
    if (not forces[4:].any() and not (forces[1:3].any() and forces[3])) or not forces[1:4].any():
        assert found == pytest.approx(worst, rel=1e-12)


@pytest.mark.parametrize(
    ("forces", "point"),
    [
        (2e5 * MY + 1e5 * MZ, "tip"),
        (3e5 * VY + 2e4 * MY, "flange"),
        (2e3 * T, "flange"),
        (4e5 * MY + 5e5 * VZ, "root"),
        (4e5 * MY + 5e5 * VZ - 20.0 * T, "root"),
        (8e5 * VZ + 1e5 * N, "middle"),
        (8e5 * VZ - 1e2 * T, "middle"),
    ],
)
def test_i_section_at_each_of_its_points(forces: Array, point: str) -> None:
    """V S / (I t) with the first moment S of what lies beyond the cut, T t / J on the face where both agree."""
    h, b, tw, tf = 0.3, 0.15, 0.007, 0.011
    n, vy, vz, t, my, mz = np.abs(forces)
    A, Iy, Iz, J = I_SECTION.A, I_SECTION.Iy, I_SECTION.Iz, I_SECTION.J

    def mises(y: float, z: float, shear: float) -> float:
        return float(np.sqrt((n / A + my * z / Iy + mz * y / Iz) ** 2 + 3 * shear**2))

    outstand = (b - tw) / 2
    across = vy * outstand * tf * (b + tw) / 4 / (Iz * tf) + vz * outstand * tf * (h - tf) / 2 / (Iy * tf)
    flange, above = b * tf * (h - tf) / 2, (h / 2 - tf) ** 2 / 2 * tw
    stresses = {
        "tip": mises(b / 2, h / 2, 0.0),
        "flange": mises(tw / 2, h / 2, across + t * tf / J),
        "root": mises(tw / 2, h / 2 - tf, vz * flange / (Iy * tw) + t * tw / J),
        "middle": mises(tw / 2, 0.0, vz * (flange + above) / (Iy * tw) + t * tw / J),
    }
    assert max(stresses, key=lambda name: stresses[name]) == point
    assert I_SECTION.stress(forces)[2] == pytest.approx(stresses[point], rel=1e-13)


def test_bounds_of_a_section_without_a_form() -> None:
    """Torsion adds to bending at the fibres, and to both shear forces at the centroid."""
    shear = np.hypot(3.0 / 0.8e-3, 4.0 / 0.5e-3) + 0.5 / 2e-5
    assert ANY.stress(3.0 * VY + 4.0 * VZ - 0.5 * T)[2] == pytest.approx(ROOT3 * shear, rel=1e-14)
    bending = 2.0 * 0.05 / 2e-6 + 7.0 / 1e-3
    assert ANY.stress(2.0 * MY - 7.0 * N + 0.5 * T)[2] == pytest.approx(
        np.hypot(bending, ROOT3 * 0.5 / 2e-5), rel=1e-14
    )


@pytest.mark.parametrize("section", SHAPES, ids=lambda s: type(s).__name__)
@given(forces=FORCES)
def test_turned_round_or_mirrored(section: CrossSection, forces: Array) -> None:
    """Half a turn about x, and the mirror images of the section, leave von Mises stress alone."""
    found, *others = section.stress(forces * TURNED)
    for other in others:
        assert_allclose(other, found, atol=1e-12 * found[2])


@pytest.mark.parametrize("section", SHAPES, ids=lambda s: type(s).__name__)
@given(forces=FORCES, factor=st.floats(0.1, 10.0))
def test_size_of_the_stress(section: CrossSection, forces: Array, factor: float) -> None:
    """Von Mises stress is of first degree, and not below the normal stress."""
    found, larger = section.stress(np.stack([forces, factor * forces]))
    assert_allclose(larger, factor * found, atol=1e-12 * factor * found[2])
    assert found[0] <= found[1]
    assert found[2] >= np.abs(found[:2]).max() * (1 - 1e-14)


@pytest.mark.parametrize("section", SHAPES, ids=lambda s: type(s).__name__)
def test_a_batch_is_its_members(section: CrossSection) -> None:
    forces = np.random.default_rng(0).normal(size=(4, 3, 6)) * [1e4, 5e3, 5e3, 200.0, 200.0, 200.0]
    bigger = section.between(
        type(section)(**{name: 2 * size for name, size in section.sizes().items()}), np.linspace(0, 1, 3)
    )
    found = bigger.stress(forces)
    assert found.shape == (4, 3, 3)
    for j, fraction in enumerate(np.linspace(0, 1, 3)):
        double = type(section)(**{name: 2 * size for name, size in section.sizes().items()})
        one = section.between(double, float(fraction))
        for i in range(4):
            assert_allclose(found[i, j], one.stress(forces[i, j]), rtol=1e-13)


def test_stress_of_a_section_without_its_fibres_is_refused() -> None:
    section = Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0, cy=1.0, kz=1.0)
    with pytest.raises(FrameError, match="stress needs ky, kz, cy, cz, Wt; give ky, cz, Wt"):
        section.stress(N)
