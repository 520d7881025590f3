"""Sines, conditions, tables and rounds of a program: as machine code what they are by NumPy and to fifty digits."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from linkframe.framework.program import machine_code
from linkframe.framework.program.calculation import Calculation
from linkframe.framework.program.program import Operation
from linkframe.framework.program.recording import Recording, Term, choose
from linkframe.framework.program.sines import FARTHEST
from linkframe.framework.program.source import Functions

needs_llvm = pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed")
# In units of the last place.
SINE_ERROR = 0.8


def results(recording: Recording, outputs: list[Term], given: list[object], count: int) -> list[np.ndarray]:
    program, places = recording.program(outputs)
    masks = [0 if k in program.tables else int(np.ndim(given[p]) > 0) for k, p in enumerate(places)]
    found: list[np.ndarray] = Calculation(
        program.over(masks), [given[p] for p in places], (count,), compiled=True
    ).results()
    return found


@needs_llvm
@pytest.mark.parametrize("scale", [1e-9, 1.0, 30.0, 1e4, 1e7, 1e11])
def test_sines_against_fifty_digits(scale: float) -> None:
    """At random, and at multiples of a quarter turn, where digits cancel; NaN where there are no digits left."""
    rng = np.random.default_rng(0)
    x = np.concatenate([scale * rng.normal(size=150), np.arange(-40, 40) * np.pi / 2, [0.0, 2.0 * FARTHEST, np.inf]])
    recording = Recording(fixed=True)
    term = recording.later(0)
    made = results(recording, [np.sin(term), np.cos(term)], [x], len(x))
    with mpmath.workprec(300):
        for found, exact in zip(made, (mpmath.sin, mpmath.cos), strict=True):
            for value, at in zip(found[:-2].tolist(), x.tolist(), strict=False):
                true = exact(mpmath.mpf(at))
                assert abs(mpmath.mpf(value) - true) <= SINE_ERROR * float(np.spacing(abs(float(true))))
    assert np.isnan([each[-2:] for each in made]).all()


@needs_llvm
def test_tables_conditions_and_rounds() -> None:
    """Places in a table, and square roots by Newton's method, each entry as many rounds as it takes."""
    x = np.random.default_rng(1).uniform(0.1, 9.0, 1003)
    nodes, values = np.array([-np.inf, 1.0, 2.0, 3.0, 5.0, np.inf]), 10.0 * np.arange(5.0)
    recording = Recording(fixed=True)
    at, table, column = (recording.later(0) for _ in range(3))
    place = recording.search(table, at) - 1.0

    def one(begins: list[Term]) -> tuple[list[Term], Term]:
        root, moving, rounds = begins
        better = 0.5 * (root + at / root)
        again = moving & (abs(better - root) > 1e-12)
        return [choose(moving, better, root), again, choose(moving, rounds + 1.0, rounds)], again

    yes = recording.write(Operation.LESS, 0.0, 1.0)
    _, (root, moving, rounds) = recording.rounds([at, yes, 0.0], one, 30)
    low = (at < 3.0) | ~(at <= 4.0)
    outputs = [place, recording.look_up(column, place), root, moving, rounds, low, np.sqrt(at)]
    found = results(recording, outputs, [x, nodes, values], len(x))
    where = np.searchsorted(nodes, x, side="right") - 1
    np.testing.assert_array_equal(found[0], where)
    np.testing.assert_array_equal(found[1], values[where])
    np.testing.assert_allclose(found[2], np.sqrt(x), rtol=1e-15)
    assert not found[3].any()
    assert found[4].min() < found[4].max()
    np.testing.assert_array_equal(found[5], (x < 3.0) | ~(x <= 4.0))
    np.testing.assert_array_equal(found[6], np.sqrt(x))


@needs_llvm
def test_tables_after_results() -> None:
    """Without rounds results are written as soon as they are made, and what follows goes on from there."""
    x = np.random.default_rng(1).uniform(0.1, 9.0, 1003)
    nodes, values = np.array([-np.inf, 1.0, 2.0, 3.0, 5.0, np.inf]), 10.0 * np.arange(5.0)
    recording = Recording(fixed=True)
    at, table, column = (recording.later(0) for _ in range(3))
    twice = at * 2.0
    found = results(
        recording, [twice, recording.look_up(column, recording.search(table, twice) - 1.0)], [x, nodes, values], len(x)
    )
    np.testing.assert_array_equal(found[0], 2.0 * x)
    np.testing.assert_array_equal(found[1], values[np.searchsorted(nodes, 2.0 * x, side="right") - 1])


def test_functions_of_floats_and_of_arrays_are_kept_by_their_steps() -> None:
    made = []
    for _ in range(2):
        recording = Recording(fixed=True)
        a, b = recording.later(0), recording.later(0)
        program, places = recording.program([0.5 * np.sin(a) / b - a, a - a + b, recording.constant(2.0)])
        made.append(Functions.of(program, tuple((0, k) for k in places)))
    assert made[0] is made[1]
    one = made[0][0]([0.3, 2.0])
    both = made[0][1]([np.array([0.3, 0.3]), 2.0])
    assert one == (both[0][1], both[1], both[2]) == (0.5 * np.sin(0.3) / 2.0 - 0.3, 2.0, 2.0)
