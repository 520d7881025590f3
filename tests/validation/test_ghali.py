"""Ghali and Neville's cantilever with three masses, Timoshenko's mass on a sprung beam."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Beam, Joint, Material, PointMass, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose


def test_cantilever_with_three_masses() -> None:
    """Ghali, Neville, Structural Analysis, example 24.2 (7th ed.): 0.1609, 1.7604, 5.0886 sqrt(EI/(m l^3)).

    A light column of three lengths l with masses 4m at the top, m and m below. Printed with four decimals: half a unit.
    The beam's own mass is 1e-9 of the masses, which changes the frequencies by less than 1e-8 of themselves.
    """
    length, modulus, inertia, mass = 2.0, 2e11, 4.32e-6, 3.0
    column = Material(E=modulus, nu=0.3, density=mass / length * 1e-9 / 3.6e-3)
    frame = Frame()
    for i in range(4):
        frame.node(f"{i}", (0.0, i * length, 0.0))
        if i:
            frame.add(f"{i}", Beam(Section(A=3.6e-3, Iy=inertia, Iz=inertia, J=1e-6), column), f"{i - 1}", f"{i}")
            frame.fix(f"{i}", "uy", "uz", "rx", "ry")
            frame.add(f"mass {i}", PointMass(mass * (4 if i == 3 else 1)), f"{i}")
    frame.fix("0")
    factors = 2 * np.pi * frame.modes(3).frequencies / np.sqrt(modulus * inertia / (mass * length**3))
    assert_allclose(factors, [0.1609, 1.7604, 5.0886], rtol=0, atol=0.51e-4)


def test_mass_on_a_beam_on_two_springs() -> None:
    """Timoshenko, Young, Weaver, Vibration Problems in Engineering, 4th ed., p. 11, problem 1.1-3: f = 1.876 Hz.

    W = 1000 lb at 7 ft of a light 10 ft beam, EI = 3e7 lb in2, on springs of 300 lb/in. Printed T = 0.533 s; to all
    digits the compliance under W is (0.3^2 + 0.7^2)/k + a^2 b^2/(3 EI L).
    """
    weight, spring, g = 1000.0, 300.0, 12 * 32.174
    beam = Beam(Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0), Material(E=3e7, nu=0.3, density=1e-12))
    frame = Frame()
    for name, x in {"left": 0.0, "mass": 84.0, "right": 120.0}.items():
        frame.node(name, (x, 0.0, 0.0))
        frame.fix(name, *(("ux",) if name == "left" else ()), "uz", "rx", "ry")
    frame.add("long", beam, "left", "mass")
    frame.add("short", beam, "mass", "right")
    for name, x in {"left": 0.0, "right": 120.0}.items():
        frame.node(f"{name} ground", (x, 0.0, 0.0))
        frame.fix(f"{name} ground")
        frame.add(f"{name} spring", Joint(stiffness=(0.0, spring, 0.0, 0.0, 0.0, 0.0)), f"{name} ground", name)
    frame.add("weight", PointMass(weight / g), "mass")
    frequency = frame.modes(1).frequencies[0]
    assert_allclose(frequency, 1.876, rtol=0, atol=0.5e-3)
    assert_allclose(1 / frequency, 0.533, rtol=0, atol=0.5e-3)
    compliance = 0.58 / spring + 84.0**2 * 36.0**2 / (3 * 3e7 * 120.0)
    assert_allclose(frequency, np.sqrt(g / (weight * compliance)) / (2 * np.pi), rtol=1e-9)
