"""Newton's method as machine code, against the same with arrays, and what it is recorded with."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.elementwise import angle, cosine, rounded, sinc
from linkframe.framework.large import newton_program
from linkframe.framework.large.solution import LargeSolution
from linkframe.framework.program import machine_code
from linkframe.framework.program.calculation import Calculation
from linkframe.framework.program.recording import Recording
from linkframe.models import FourBar
from numpy.typing import NDArray

Array = NDArray[np.float64]
needs_llvm = pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed")

STEEL = Material(E=200e9, nu=0.3)
BAR = Rectangle(y=4e-3, z=6e-3)
EPS = float(np.finfo(np.float64).eps)


def solved(frame: Frame, compiled: bool, steps: int = 1) -> LargeSolution:
    """Solution by machine code wherever that is possible, or by arrays alone."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton_program, "LEAST", 1)
        for name in ("_TIMES", "_OFTEN"):
            patch.setattr(newton_program, name, np.inf if compiled else 0.0)
        solution = frame.solve(large=True, steps=steps)
        assert (solution._load_stepping.newton.program is not None) == compiled
        assert solution.iterations.shape == frame.shape
    return solution


def assert_alike(frame: Frame, node: str, *, steps: int = 1, rounding: float = 1e-12) -> LargeSolution:
    """Both ways find the same in the same number of steps; the solution."""
    one, other = solved(frame, True, steps), solved(frame, False, steps)
    assert (one.status == other.status).all()
    assert (one.iterations == other.iterations).all()
    found, wanted = one.displacement(node), other.displacement(node)
    size = np.abs(wanted).max(axis=-1, keepdims=True)
    assert np.nanmax(np.abs(found - wanted) / size) < rounding
    return one


def four_bar(theta: Array, pin: Array, force: Array, across: float = 0.0) -> Frame:
    """The four-bar with stiff pins at some poses, its load at P."""
    stiffness = np.append(np.ones(5), 0.0) * pin[:, None]
    frame = FourBar(beam=Beam(BAR, STEEL), stiffness=stiffness).move(theta).frame()
    frame.load("P", fy=force)
    if across:
        frame.load("P", fz=across)
    return frame


@needs_llvm
@settings(max_examples=10, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(1.0, 300.0))
def test_a_linkage_in_the_plane(seed: int, load: float) -> None:
    rng = np.random.default_rng(seed)
    theta, pin = np.radians(rng.uniform(2.0, 170.0, 11)), 10.0 ** rng.uniform(7.0, 11.0, 11)
    assert_alike(four_bar(theta, pin, load * rng.uniform(-1.0, 1.0, 11)), "P")


@needs_llvm
def test_a_batch_is_its_entries_one_by_one() -> None:
    rng = np.random.default_rng(3)
    theta, pin, force = np.radians([20.0, 40.0, 110.0]), 10.0 ** rng.uniform(8.0, 11.0, 3), np.array([-40.0, 90.0, 5.0])
    whole = assert_alike(four_bar(theta, pin, force), "P").displacement("P")
    for k in range(3):
        some = [k, (k + 1) % 3]
        alone = solved(four_bar(theta[some], pin[some], force[some]), True).displacement("P")
        assert (alone == whole[some]).all()


def cantilever(segments: int) -> Frame:
    """A cantilever along x of length 1."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(BAR, STEEL, segments=segments), "A", "B")
    frame.fix("A")
    return frame


@needs_llvm
def test_angles_of_more_than_a_turn() -> None:
    """A moment rolls a cantilever up, nearly one turn and a half: its end comes to where the circle says."""
    frame = cantilever(8)
    turns = np.array([-1.4, -0.25, 0.3, 0.9, 1.4])
    frame.load("B", mz=2.0 * np.pi * turns * STEEL.E * BAR.Iz)
    solution = assert_alike(frame, "B", steps=6)
    radius = 1.0 / (2.0 * np.pi * turns)
    exact = np.stack([radius * np.sin(1.0 / radius) - 1.0, radius * (1.0 - np.cos(1.0 / radius))], axis=-1)
    assert np.abs(solution.displacement("B")[:, :2] - exact).max() < 0.02


@needs_llvm
def test_saddles_are_left_alike() -> None:
    """Columns below and beyond their buckling load, which are left along their free mode."""
    frame = cantilever(3)
    critical = STEEL.E * min(BAR.Iy, BAR.Iz) * np.pi**2 / 4.0
    frame.prescribe("B", uz=0.0)
    frame.load("B", fx=-critical * np.array([0.2, 0.9, 3.0, 5.0]))
    solution = assert_alike(frame, "B", rounding=1e-9)
    assert set(solution.status.tolist()) == {"stable", "stable beyond a saddle"}


@needs_llvm
@pytest.mark.parametrize("across", [0.0, 2.0])
def test_links_ties_and_prescribed_displacements(across: float) -> None:
    """What hangs on other nodes in all ways, in the plane and out of it."""
    frame = Frame()
    for name, x, y in (("A", 0.0, 0.0), ("B", 0.3, 0.1), ("C", 0.3, 0.1), ("D", 0.5, 0.0)):
        frame.node(name, (x, y, 0.0))
    frame.add("AB", Beam(BAR, STEEL), "A", "B")
    frame.add("pin", Joint(stiffness=(1e6, 1e6, 1e6, 1e3, 1e3, 3.0)), "B", "C")
    frame.rigid("C", "D")
    frame.fix("A")
    frame.prescribe("A", uy=np.linspace(-0.02, 0.03, 9))
    frame.load("D", fy=np.linspace(3.0, -8.0, 9))
    if across:
        frame.load("D", fz=across)
    solution = assert_alike(frame, "D")
    assert solution.converged.all()


@needs_llvm
def test_what_is_not_written_down_is_left_to_the_arrays() -> None:
    frame = cantilever(1)
    frame.line_load("AB", fy=np.linspace(1.0, 2.0, 9))
    frame.load("B", fz=1.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton_program, "LEAST", 1)
        patch.setattr(newton_program, "_OFTEN", np.inf)
        solution = frame.solve(large=True)
        assert solution._load_stepping.newton.program is None
        assert solution.converged.all()


def recorded(function: Callable[..., Array], values: list[Array], compiled: bool) -> Array:
    """What a program makes of the function."""
    recording = Recording(fixed=True, signless=True)
    terms = [np.array([recording.later(1)], dtype=object) for _ in values]
    program, places = recording.program([function(*terms)[0]])
    work = Calculation(program, [values[k] for k in places], values[0].shape, compiled=compiled)
    with np.errstate(all="ignore"):
        return np.asarray(work.results()[0])


@pytest.mark.parametrize("compiled", [False, pytest.param(True, marks=needs_llvm)])
def test_functions_recorded(compiled: bool) -> None:
    rng = np.random.default_rng(8)
    size = 10.0 ** rng.uniform(-12.0, 6.0, (2, 500))
    y, x = size * rng.choice([-1.0, 1.0], size.shape)
    y[:8], x[:8] = [0.0, 1.0, -1.0, 0.0, 1e-30, 1.0, -1.0, 2.0], [1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, -2.0]
    wanted = np.arctan2(y, x)
    assert np.abs(recorded(angle, [y, x], compiled) - wanted).max() <= 4.0 * EPS * np.pi
    assert (np.abs(recorded(angle, [y, x], compiled) - wanted) <= 4.0 * EPS * np.abs(wanted)).all()
    some = rng.uniform(-9.0, 9.0, 500)
    some[:4] = [0.0, 0.5, -1.5, 2.5]
    assert (recorded(rounded, [some], compiled) == np.round(some)).all()
    for function, exact in ((cosine, np.cos(some)), (sinc, np.sinc(some / np.pi))):
        assert recorded(function, [some], compiled) == pytest.approx(exact, rel=1e-13, abs=1e-15)


def test_signless_recordings_calculate_what_others_do() -> None:
    """Random expressions of sums, differences and products, with and without their signs."""
    rng = np.random.default_rng(1)
    made = []
    for signless in (False, True):
        recording = Recording(fixed=True, signless=signless)
        values = [recording.later(1) for _ in range(4)]
        choice = np.random.default_rng(7)
        for _ in range(60):
            a, b = (values[k] for k in choice.integers(0, len(values), 2))
            values.append([a + b, a - b, a * b, -a, b - a, -a * b, -a - b][choice.integers(0, 7)])
        terms = [value for value in values[-20:] if not isinstance(value, float)]
        made.append(recording.program(terms))
    numbers = [rng.standard_normal(5) for _ in range(4)]
    results = [Calculation(p, [numbers[k] for k in q], (5,), compiled=False).results() for p, q in made]
    for one, other in zip(*results, strict=True):
        assert (np.asarray(one) == np.asarray(other)).all()


@needs_llvm
@pytest.mark.parametrize(("count", "across", "told"), [(40, 0.0, "as machine code"), (2, 0.0, "so few entries"),
                                                       (40, 1.0, "so few entries")])  # fmt: skip
def test_explained(count: int, across: float, told: str) -> None:
    theta = np.radians(np.linspace(20.0, 110.0, count))
    frame = four_bar(theta, np.full(count, 1e9), np.linspace(1.0, 2.0, count), across)
    text = str(frame.solve(large=True).explain())
    assert told in text
    found = re.search(r"arrays take about (\S+) ms, compiling about (\d+) steps takes (\S+) ms once", text)
    assert found
    arrays, steps, compiling = (float(each) for each in found.groups())
    assert arrays > 0.0
    assert compiling > 0.01 * steps  # some tens of microseconds a step
