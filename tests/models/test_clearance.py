"""Clearance: Eq. (11), the contact that a force makes, and the loop closed again."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from linkframe.models import FourBar
from linkframe.models.clearance import offset, pressed
from linkframe.models.four_bar.clearance import clearance_displacement
from linkframe.models.planar import dyad
from numpy.testing import assert_allclose, assert_array_equal

FOUR_BAR = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open")
OFFSETS = {"B": 2e-3 - 1e-3j, "D": -1e-3 + 3e-3j, "E": 1e-3 + 1e-3j}


def first_order(motion, offsets):
    """Rigid-body velocities with the offsets as sliding: i φ₃ u − i φ₄ w = −(δ_B + δ_D + δ_E)."""
    b, d, e, p = (motion.position(name)[..., 0] + 1j * motion.position(name)[..., 1] for name in "BDEP")
    u, w = d - b, d - e
    slide = sum(offsets.values())
    turn = -(slide * np.conj(w)).real / (1j * u * np.conj(w)).real
    return offsets["B"] + 1j * turn * (p - b)


def test_offset_is_equation_11():
    assert_allclose(offset(2.0, np.radians([0.0, 90.0, 210.0])), [2.0, 2.0j, -np.sqrt(3.0) - 1j], atol=1e-15)


def test_pressed_along_the_force_and_centred_without():
    force = np.array([3.0 - 4.0j, 1e-20 + 0j, 0.0 + 0j])
    assert_allclose(pressed(0.5, force, 5.0), [0.3 - 0.4j, 0.0, 0.0], atol=1e-16)
    assert_array_equal(pressed(0.5, np.zeros(2), np.zeros(2)), [0.0, 0.0])


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_dyad_closes_on_its_side(side):
    chord = np.array([0.7 - 0.1j, 0.2 + 0.6j, -1.0 + 0.3j])
    pin = dyad(chord, 0.9, 0.8, side)
    assert_allclose(np.abs(pin), 0.9, rtol=1e-15)
    assert_allclose(np.abs(pin - chord), 0.8, rtol=1e-15)
    assert np.all(np.sign((np.conj(chord) * pin).imag) == side)
    assert np.isnan(dyad(2.0 + 0j, 0.9, 0.8, side))


def test_exact_displacement_against_50_digits():
    """Two circles about B + δ_B and E − δ_E − δ_D, in mpmath; P carried along by the coupler."""
    motion = FOUR_BAR.move(0.8)
    found = clearance_displacement(motion, OFFSETS)
    with mp.workdps(50):
        b, c = mp.mpf(0.9), mp.mpf(0.8)
        pin = mp.mpf(0.3) * mp.expj(mp.mpf(0.8))

        def point(first, second):
            chord = second - first
            along = (abs(chord) ** 2 + b**2 - c**2) / (2 * abs(chord))
            end = chord / abs(chord) * (along + 1j * mp.sqrt(b**2 - along**2))
            return first + mp.mpc(0.5, 0.2) * end / b

        gaps = {name: mp.mpc(gap) for name, gap in OFFSETS.items()}
        moved = point(pin + gaps["B"], mp.mpf(0.7) - gaps["E"] - gaps["D"]) - point(pin, mp.mpf(0.7))
    assert_allclose(found, [float(moved.real), float(moved.imag), 0.0], rtol=1e-13)


def test_first_order_error_falls_with_the_square_of_the_clearance():
    motion = FOUR_BAR.move(np.radians(np.arange(0, 360, 10)))
    scale = 2.0 ** -np.arange(8)
    errors = []
    for s in scale:
        offsets = {joint: s * gap for joint, gap in OFFSETS.items()}
        linear = first_order(motion, offsets)
        exact = clearance_displacement(motion, offsets)
        errors.append(np.hypot(exact[:, 0] - linear.real, exact[:, 1] - linear.imag))
    rates = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert_allclose(rates[-1], 2.0, atol=0.02)


def test_only_the_sum_of_the_offsets_turns_the_coupler():
    """What D and E share is immaterial: the loop sees their sum."""
    motion = FOUR_BAR.move([0.4, 2.0])
    swapped = {"B": OFFSETS["B"], "D": OFFSETS["E"], "E": OFFSETS["D"]}
    assert_allclose(clearance_displacement(motion, swapped), clearance_displacement(motion, OFFSETS), atol=1e-17)


def test_no_number_where_the_loop_stays_open_or_the_pose_is_singular():
    """At 180° the offset loop would close, on either side: nothing tells which."""
    parallelogram = FourBar().move(np.radians([0.0, 2.0, 60.0, 180.0]))
    gap = np.array(1e-3 + 0j)
    found = clearance_displacement(parallelogram, {"B": gap, "D": gap, "E": gap})
    assert_array_equal(np.isnan(found[:, 0]), [True, True, False, True])


def test_beside_a_singular_pose_contact_is_still_along_the_forces() -> None:
    """Offsets move links by thousands of times as much there, and rounding with them, but meet no stiffness."""
    rng = np.random.default_rng(0)
    pin = np.full((64, 6), 2e11) * rng.uniform(0.8, 1.2, (64, 1)) * [1.0, 1.0, 1.0, 1.0, 1.0, 0.0]
    turn = np.pi + np.radians(np.linspace(-0.05, 0.05, 40))[:, None]
    frame = FourBar(stiffness=dict.fromkeys("BDE", pin)).move(turn).frame(dict.fromkeys("BDE", 1e-3))
    frame.load("P", fy=rng.normal(100.0, 5.0, 64))
    solution = frame.solve()
    assert solution.pressed is not None
    assert (solution.contact("D").status == "closed").all()
