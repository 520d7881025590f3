"""Eigenvalues that are not there: no compression, no resistance."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle, Section
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose
from scipy.linalg import eigh

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0), segments=4)
TURN = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]


def bracket(turn: np.ndarray[tuple[int, int], np.dtype[np.float64]], force: tuple[float, float, float]) -> Frame:
    """A cantilever with a branch at its end that carries nothing, turned in space."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0.5, 0)}.items():
        frame.node(name, turn @ place)
    frame.add("AB", BEAM, "A", "B")
    frame.add("BC", BEAM, "B", "C")
    frame.fix("A")
    frame.load("B", **dict(zip(("fx", "fy", "fz"), turn @ force, strict=True)))
    return frame


@pytest.mark.parametrize("turn", [np.eye(3), TURN], ids=["level", "turned"])
@pytest.mark.parametrize("force", [1e3, 1e-3, 0.0])
def test_what_is_pulled_does_not_buckle(turn: np.ndarray[tuple[int, int], np.dtype[np.float64]], force: float) -> None:
    """Pulled, and not loaded at all: no factor, however large, is made of rounding."""
    assert np.isinf(bracket(turn, (force, 0.0, 0.0)).buckling(4).factors).all()
    pressed = bracket(turn, (-1e3, 0.0, 0.0)).buckling(1).factors
    assert_allclose(pressed, np.pi**2 * 200e9 * 0.03 * 0.02**3 / 12 / 4.0 / 1e3, rtol=2e-3)


def test_what_nothing_holds_has_frequency_zero() -> None:
    """Six motions of a free frame, to the last bit; elastic ones come after them."""
    frame = bracket(np.eye(3), (0.0, 0.0, 0.0))
    frame.supports.clear()
    found = frame.modes(9).frequencies
    assert found[:6].tolist() == [0.0] * 6
    assert np.all(found[6:] > 10.0)


def test_the_motion_of_a_regular_frame_is_none_in_words() -> None:
    assert bracket(np.eye(3), (1.0, 0.0, 0.0)).solve().mechanism() == ""


def column(count: int, held: str = "") -> Frame:
    """A round column of `count` members in a direction of no axis, clamped at its foot and pressed at its top.

    `held` says what holds its top: nothing, a ``pin`` on a slide, or a ``clamp`` on a slide.
    """
    frame = Frame()
    rod = Beam(Circle(diameter=0.01), Material(E=200e9, nu=0.3, density=7850.0))
    frame.body("column", axes=TURN)
    for i in range(count + 1):
        frame.node(f"n{i}", (2.0 * i / count, 0.0, 0.0), body="column")
    for i in range(count):
        frame.add(f"m{i}", rod, f"n{i}", f"n{i + 1}")
    frame.fix("n0")
    springs = {"": None, "pin": (0.0, np.inf, np.inf, np.inf, 0.0, 0.0), "clamp": (0.0, *[np.inf] * 5)}[held]
    if springs is not None:
        frame.node("slide", (2.0, 0.0, 0.0), body="column")
        frame.fix("slide")
        frame.add("top", Joint(stiffness=springs, axes=TURN), f"n{count}", "slide")
    frame.load(f"n{count}", **dict(zip(("fx", "fy", "fz"), TURN @ [-1.0, 0.0, 0.0], strict=True)))
    return frame


# Half the wave length of the shape over the length: Timoshenko & Gere, Theory of Elastic Stability, 1961, pp. 48-54.
EULER = {"": 0.5, "pin": 4.493409457909064 / np.pi, "clamp": 2.0}
INERTIA = np.pi * 0.01**4 / 64.0


@pytest.mark.parametrize("held", EULER)
def test_eulers_columns(held: str) -> None:
    """The error falls with the fourth power of the length of members, down to 1e-11, and pairs are equal to 1e-9."""
    counts = np.array([10, 20, 40, 100, 400])
    found = np.array([column(count, held).buckling(2).factors for count in counts])
    exact = EULER[held] ** 2 * np.pi**2 * 200e9 * INERTIA / 2.0**2
    assert_allclose(found[:, 1], found[:, 0], rtol=1e-9)
    error = np.abs(found[:, 0] / exact - 1.0)
    assert_allclose(np.diff(np.log(error[:3])) / np.diff(np.log(counts[:3])), -4.0, atol=0.15)
    assert error[0] < 3e-4
    assert np.all(error < 1.1 * error[0] * (10.0 / counts) ** 4 + 1e-11)


def test_load_cases_of_a_large_column() -> None:
    """Pressed, pressed twice as much, pulled, and not at all: each for itself."""
    frame = column(100)
    frame.loads.clear()
    push = TURN @ [-1.0, 0.0, 0.0]
    for name, part in zip(("fx", "fy", "fz"), push, strict=True):
        frame.load("n100", **{name: part * np.array([[1.0, 2.0], [-1.0, 0.0]])})
    factors = frame.buckling(2).factors
    euler = np.pi**2 * 200e9 * INERTIA / 16.0
    assert_allclose(factors[0], [[euler, euler], [euler / 2.0, euler / 2.0]], rtol=1e-9)
    assert np.isinf(factors[1]).all()
    assert frame.buckling(2).shapes("n100").shape == (2, 2, 2, 6)


def test_what_is_pressed_less_than_something_is_pulled() -> None:
    """A stay pulled a million times as hard as the column is pressed does not hide that it buckles."""
    frame = column(100)
    frame.node("stay", TURN @ np.array([0.0, 1.0, 0.0]))
    frame.add("stay", Beam(Circle(diameter=0.01), Material(E=200e9, nu=0.3)), "n0", "stay")
    frame.supports.pop("n0")
    frame.fix("n0")
    frame.load("stay", **dict(zip(("fx", "fy", "fz"), TURN @ [0.0, 1e6, 0.0], strict=True)))
    assert_allclose(frame.buckling(1).factors, np.pi**2 * 200e9 * INERTIA / 16.0, rtol=1e-6)


@pytest.mark.parametrize("count", [10, 60, 100, 400])
def test_frequencies_of_a_fine_cantilever_come_in_pairs(count: int) -> None:
    """A round rod bends in both planes alike; the first frequency is Bernoulli's but for the inertia of rotation."""
    frequencies = column(count).modes(6).frequencies
    assert_allclose(frequencies[1::2], frequencies[::2], rtol=1e-9)
    bernoulli = 1.8751040687119611**2 / (2.0 * np.pi * 4.0) * np.sqrt(200e9 * 0.01**2 / 16.0 / 7850.0)
    assert_allclose(frequencies[0], bernoulli * (1.0 - 3.6e-6), rtol=2e-6)


def test_frequencies_of_a_large_frame_that_floats() -> None:
    """Six zeros, then pairs: bending between free ends, Blevins, Formulas for Natural Frequency, 1979, p. 108."""
    frame = column(100)
    frame.supports.clear()
    found = frame.modes(10).frequencies
    assert found[:6].tolist() == [0.0] * 6
    assert_allclose(found[7::2], found[6::2], rtol=1e-8)
    roots = np.array([4.730040744862704, 7.853204624095838])
    assert_allclose(found[6::2], roots**2 / (8.0 * np.pi) * np.sqrt(200e9 * 0.01**2 / 16.0 / 7850.0), rtol=1e-4)


def test_buckling_of_a_mechanism_in_segments_is_refused() -> None:
    """A free beam whose load accelerates it, with nodes within."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3), segments=3), "A", "B")
    frame.load("B", fy=1.0)
    with pytest.raises(FrameError, match="buckling: the frame is a mechanism"):
        frame.buckling(1)


def test_soft_hinges_keep_their_frequencies_and_those_of_the_rod() -> None:
    """A rod on a hinge of 1e-14 to 1 N m/rad: as a pendulum ``sqrt(k / J)``, and in bending by two matrices by hand."""
    length, area, inertia, modulus, density = 0.7, 1e-3, 1e-7, 2e11, 7800.0
    springs = np.zeros((8, 6)) + np.inf
    springs[:, 5] = 10.0 ** np.arange(-14, 2, 2)
    frame = Frame()
    for name, x in {"G": 0.0, "A": 0.0, "B": length}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("hinge", Joint(springs), "G", "A")
    section = Section(A=area, Iy=inertia, Iz=inertia, J=2.0 * inertia)
    frame.add("AB", Beam(section, Material(E=modulus, nu=0.3, density=density), shear=False), "A", "B")
    frame.fix("G")
    frame.fix("B", "ux", "uz", "rx", "ry")
    modes = frame.modes(3)
    h = length
    bend = np.array([[4 * h**2, -6 * h, 2 * h**2], [-6 * h, 12, -6 * h], [2 * h**2, -6 * h, 4 * h**2]]) / h**3
    mass = np.array([[4 * h**2, 13 * h, -3 * h**2], [13 * h, 156, -22 * h], [-3 * h**2, -22 * h, 4 * h**2]])
    turn = np.array([[4 * h**2, -3 * h, -(h**2)], [-3 * h, 36, -3 * h], [-(h**2), -3 * h, 4 * h**2]])
    heavy = density * (area * h / 420.0 * mass + inertia / (30.0 * h) * turn)
    about = density * (area * h**3 / 3.0 + inertia * h)
    for k, found in zip(springs[:, 5], modes.frequencies, strict=True):
        bending = np.sqrt(eigh(modulus * inertia * bend + k * np.diag([1.0, 0, 0]), heavy, eigvals_only=True)[1:])
        assert_allclose(found, [np.sqrt(k / about) / (2 * np.pi), *bending / (2 * np.pi)], rtol=1e-4 * k + 1e-10)
    tips = modes.shapes("B")[..., [1, 5]]
    assert_allclose(np.abs(tips[:, 0]), np.array([[h, 1.0]] * 8) / np.sqrt(about), rtol=1e-4)


def test_shapes_have_the_batch_of_the_frequencies() -> None:
    """Loads vary and modes do not: the shapes are there at each entry all the same."""
    frame = bracket(np.eye(3), (1.0, 0.0, 0.0))
    frame.load("C", fy=[1.0, 2.0, 3.0])
    modes = frame.modes(2)
    assert modes.frequencies.shape == (3, 2)
    assert modes.shapes("C").shape == (3, 2, 6)


@pytest.mark.parametrize("what", ["modes", "buckling"])
def test_a_frame_of_which_all_is_held_says_so(what):
    frame = Frame()
    frame.add_nodes(["A", "B"], [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0)])
    frame.add("AB", Beam(Circle(diameter=0.1), Material(E=2e11, nu=0.3, density=7850.0)), "A", "B")
    frame.fix("A")
    frame.fix("B")
    with pytest.raises(FrameError, match=rf"^{what}\(2\): the frame has no unknowns, nothing in it can move"):
        getattr(frame, what)(2)


# Blevins, Formulas for Natural Frequency, 1979, p. 108: clamped and sliding, clamped and pinned.
@pytest.mark.parametrize(("released", "root"), [("end uy", 2.36502037), ("end rz", 3.92660231)])
def test_frequency_of_a_rod_with_a_released_end(released: str, root: float) -> None:
    """One segment has the frequency of its consistent mass: 12 over 13/35, and 4 over 1/105."""
    found = []
    for segments in (1, 2, 8):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0, 0.0, 0.0))
        material = Material(E=200e9, nu=0.3, density=7850.0)
        frame.add("AB", Beam(Rectangle(y=0.001, z=0.002), material, segments=segments, release=released), "A", "B")
        frame.fix("A")
        frame.fix("B", "uy", "uz", "rx", "ry", "rz")
        found.append(2.0 * np.pi * frame.modes(1).frequencies[0] / np.sqrt(200e9 * 0.001**2 / 12.0 / 7850.0) / root**2)
    cubic = {"end uy": 12.0 * 35.0 / 13.0, "end rz": 420.0}[released]
    assert_allclose(found[0], np.sqrt(cubic) / root**2, rtol=1e-5)
    assert_allclose(found[1:], [1.0, 1.0], rtol=0.01)
    assert found[-1] == pytest.approx(1.0, abs=1e-4)
