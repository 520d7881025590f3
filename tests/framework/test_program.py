"""One list of operations, whoever runs it: NumPy and machine code give the same bits, and those of plain arithmetic."""

from __future__ import annotations

import gc
import threading
import weakref
from collections.abc import Callable
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batch import Array
from linkframe.framework.batched.block_factor import BlockFactor
from linkframe.framework.cache import KERNELS
from linkframe.framework.program import calculation, machine_code
from linkframe.framework.program.calculation import Calculation
from linkframe.framework.program.machine_text import PAST
from linkframe.framework.program.program import Operation
from linkframe.framework.program.recording import Recording, Term, choose
from linkframe.models import FourBar

BACK_ENDS = [
    pytest.param(False, id="NumPy"),
    pytest.param(
        True,
        id="machine code",
        marks=pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed"),
    ),
]
needs_llvm = pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed")
BINARY: list[Callable[[object, object], object]] = [
    lambda a, b: a + b,
    lambda a, b: a - b,
    lambda a, b: a * b,
    lambda a, b: a / b,
    np.minimum,
    np.maximum,
]


def run(recording: Recording, outputs: list[Term], shape: tuple[int, ...], compiled: bool, step: int) -> list[Array]:
    """The outputs, made in chunks of `step` along the first axis."""
    work = Calculation.recorded(recording, outputs, shape, compiled=compiled)
    outs = [np.full(work.of(term.mask), 9.0) for term in outputs]
    for start in range(0, shape[0], step):
        part = slice(start, start + step)
        with np.errstate(all="ignore"):
            work.run(0, part, [out[part] if out.shape[0] > 1 else out for out in outs])
    return outs


# -- any arithmetic ----------------------------------------------------------------------------------------------------


SHAPES = st.sampled_from([(5, 19), (23,), (3, 2, 16), (40, 1), (7, 3)])


@pytest.mark.parametrize("compiled", BACK_ENDS)
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), shape=SHAPES)
def test_as_plain_arithmetic(compiled: bool, seed: int, shape: tuple[int, ...]) -> None:
    """Thirty steps at random on numbers of all batch shapes, zeros, infinities and NaN among them."""
    steps_at_random(compiled, seed, shape)


@needs_llvm
@settings(max_examples=12, deadline=None)
@given(seed=st.integers(0, 10**6), shape=SHAPES)
def test_what_varies_over_fewer_axes_as_machine_code(seed: int, shape: tuple[int, ...]) -> None:
    """The same where compiling takes no time, so that what varies over fewer axes is compiled as well."""
    with patch.object(calculation, "COMPILING", 0.0), patch.object(calculation, "LEAST", 1):
        steps_at_random(True, seed, shape)


def steps_at_random(compiled: bool, seed: int, shape: tuple[int, ...]) -> None:
    rng = np.random.default_rng(seed)
    recording = Recording()
    plain: list[object] = [np.float64(value) for value in (0.0, 1.0, -1.0, 2.5)]
    for _ in range(6):
        array = rng.normal(size=tuple(n if rng.random() < 0.6 else 1 for n in shape))
        array[rng.random(array.shape) < 0.1] = rng.choice([0.0, -0.0, np.inf, np.nan])
        plain.append(array)
    terms = [recording.take(value) for value in plain]
    with np.errstate(all="ignore"):
        for _ in range(30):
            step, a, b = BINARY[rng.integers(len(BINARY))], *rng.integers(len(plain), size=2)
            if isinstance(terms[a], float) and isinstance(terms[b], float):
                continue
            plain.append(step(plain[a], plain[b]))
            terms.append(step(terms[a], terms[b]))
    wanted = [(term, value) for term, value in zip(terms, plain, strict=True) if isinstance(term, Term)]
    found = run(recording, [term for term, _ in wanted], shape, compiled, 2)
    for mine, (_, value) in zip(found, wanted, strict=True):
        value = np.asarray(value)
        # Products with a zero that is one for all time are zero, and nothing is added to them.
        safe = np.isfinite(value)
        np.testing.assert_array_equal(
            np.broadcast_to(mine, shape)[np.broadcast_to(safe, shape)],
            np.broadcast_to(value, shape)[np.broadcast_to(safe, shape)],
        )


@pytest.mark.parametrize("compiled", BACK_ENDS)
@pytest.mark.parametrize("shape", [(4, 300), (700,), (3, 8)])
def test_sums_of_products(compiled: bool, shape: tuple[int, ...]) -> None:
    """To the rounding of their terms; known numbers that are one, factors that are zero or one, and single terms."""
    rng = np.random.default_rng(2)
    recording = Recording()
    leading = (*shape[:-1], 1)
    numbers = {k: rng.normal(size=shape) for k in range(5)} | {5: 1.0}
    rows = [{k: rng.normal(size=leading) for k in range(6)}, {2: 1.0}, {0: -1.0, 3: 1.0, 5: 2.0}, {1: 3.0, 4: 0.0}]
    sums = recording.products(rows, {k: recording.take(value) for k, value in numbers.items()})
    found = run(recording, [term for term in sums if isinstance(term, Term)], shape, compiled, 3)
    for row, mine in zip(rows, found, strict=True):
        exact = sum(np.asarray(row[k], dtype=np.longdouble) * numbers[k] for k in row)
        size = sum(np.abs(row[k] * numbers[k]) for k in row)
        assert (np.abs(mine - exact) <= len(row) * 2.0**-53 * size).all()


@needs_llvm
@pytest.mark.parametrize("whole", [True, False])
def test_conditions_that_vary_over_fewer_axes(whole: bool) -> None:
    """Told by a part of its own, as machine code where that pays, and read by steps that vary over all axes."""
    rng, recording = np.random.default_rng(5), Recording()
    a, b, x, y = (rng.normal(size=(1, 50_000)) for _ in range(4))
    x, y = x * np.array([[1.0], [2.0]]), y * np.array([[3.0], [1.0]])
    A, B, X, Y = map(recording.take, (a, b, x, y))
    found = choose(np.less(A * B, A + B), X * Y, X - Y)
    out = run(recording, [found], (2, 50_000), True, 2 if whole else 1)
    np.testing.assert_array_equal(out[0], np.where(a * b < a + b, x * y, x - y))


def test_sums_that_do_not_vary_along_the_last_axis() -> None:
    """Beside others that do, by the same matrix product; asked for, and as numbers of a further step."""
    rng, recording = np.random.default_rng(4), Recording()
    numbers = {0: rng.normal(size=(6, 1)), 1: rng.normal(size=(6, 700))}
    terms = {k: recording.take(value) for k, value in numbers.items()}
    alike, other = recording.products([{0: np.full((6, 1), 3.0)}, {0: np.full((6, 1), 2.0), 1: 0.5}], terms)
    assert isinstance(alike, Term)
    assert isinstance(other, Term)
    again = alike * alike
    found = run(recording, [alike, other, again], (6, 700), False, 3)
    np.testing.assert_array_equal(found[0], 3.0 * numbers[0])
    np.testing.assert_array_equal(found[1], 2.0 * numbers[0] + 0.5 * numbers[1])
    np.testing.assert_array_equal(found[2], (3.0 * numbers[0]) ** 2)


def test_what_is_written_down() -> None:
    """Zeros and ones drop out, equal steps are taken once, and what no output needs is left away."""
    recording = Recording()
    a, b = recording.take(np.ones((3, 1))), recording.take(np.ones((1, 4)))
    assert (a * 0.0, a + 0.0, a * 1.0, 0.0 / a) == (0.0, a, a, 0.0)
    product = a * b
    assert (b * a).number == product.number
    unused = a - b
    program, given = recording.program([product + product, -a])
    assert [step.operation for step in program.steps] == [Operation.MULTIPLY, Operation.ADD, Operation.NEGATE]
    assert (program.masks, given, unused.mask) == ((1, 2, 3, 3, 1), [0, 1], 3)


# -- frames ------------------------------------------------------------------------------------------------------------

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


def four_bar(shape: tuple[int, int], lengths: float = 1.0) -> Frame:
    """Poses by samples of stiffness, clearance and load in space."""
    rng = np.random.default_rng(3)
    poses, samples = shape
    springs = 1e8 * rng.uniform(0.9, 1.1, (samples, 6))
    springs[:, 5] = 0.0
    theta = np.radians(np.linspace(15.0, 165.0, poses))[:, None]
    frame = FourBar(stiffness=springs, crank=0.1 / lengths).move(theta).frame()
    frame.load("P", fy=rng.normal(100.0, 5.0, samples), fz=10.0)
    frame.offset("B", ux=1e-4 * rng.normal(size=samples))
    return frame


def chain(samples: int) -> Frame:
    """Three members of random modulus between nodes at random, the last behind a joint of random stiffness."""
    rng = np.random.default_rng(4)
    at = np.arange(4)[:, None, None] * [1.0, 0.3, 0.2] + 0.05 * rng.normal(size=(4, samples, 3))
    bar = Beam(BAR.section, Material(E=rng.uniform(1e11, 3e11, samples), nu=0.3))
    frame = Frame()
    for k in range(4):
        frame.node(f"n{k}", at[k] if k in (1, 2) else at[k, 0])
    frame.node("m2", at[2])
    frame.add("a", bar, "n0", "n1")
    frame.add("b", bar, "n1", "n2")
    frame.add("c", bar, "m2", "n3")
    frame.add("pin", Joint(stiffness=(1e6, 1e6, 1e6, 1e4, 1e4, 1e3)), "n2", "m2")
    frame.fix("n0")
    frame.load("n3", fy=1.0, fz=rng.normal(size=samples))
    return frame


FRAMES: dict[str, Callable[[], Frame]] = {
    "joints": lambda: four_bar((7, 200)),
    "one pose": lambda: four_bar((1, 1300)),
    "all": lambda: chain(1037),
}


@needs_llvm
@pytest.mark.parametrize("name", FRAMES)
def test_both_back_ends(name: str) -> None:
    """All unknowns, margins, and what is asked a second time."""
    plan = FRAMES[name]().solve().plan
    for component in sorted(plan.excited):
        block = plan.block(component)
        rows = [{k: 1.0} for order in block.orders for k in order.pivots]
        one, other = (BlockFactor(block, 256, compiled=compiled) for compiled in (False, True))
        for asked in (rows, rows[::-1], rows[:3]):
            for mine, theirs in zip(one.values(asked), other.values(asked), strict=True):
                scale = np.abs(np.asarray(mine)).max()
                np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=0.0 if name == "all" else 1e-14 * scale)
        np.testing.assert_array_equal(one.pivot_ratio(), other.pivot_ratio())
        assert ("by NumPy" in one.ran, "machine code" in other.ran) == (True, True)


@needs_llvm
def test_two_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """The same bits as one, by rows and along a single row."""
    monkeypatch.setattr(calculation, "THREADS", 0.0)
    for make in FRAMES.values():
        plan = make().solve().plan
        found = {}
        for threads in ("1", "2"):
            monkeypatch.setenv("OMP_NUM_THREADS", threads)
            block = plan.block(min(plan.excited))
            found[threads] = BlockFactor(block, compiled=True).values([{k: 1.0} for k in block.orders[1].pivots])
        for one, two in zip(found["1"], found["2"], strict=True):
            np.testing.assert_array_equal(one, two)


@needs_llvm
def test_compiled_once_for_a_structure(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another frame with other lengths and samples compiles nothing."""
    made: list[str] = []
    compiled = machine_code.compiled_kernel
    monkeypatch.setattr(machine_code, "compiled_kernel", lambda text: made.append(text) or compiled(text))
    KERNELS.clear()
    for lengths in (1.0, 1.1):
        solution = four_bar((30, 1300), lengths).solve()
        solution.displacement("P")
        assert "as machine code" in solution.explain()
        assert len(made) == len(solution.plan.excited)


@pytest.mark.parametrize("installed", [True, False])
def test_choice_is_told(installed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the size of the batch alone; without llvmlite all is done by NumPy."""
    monkeypatch.setattr(machine_code, "available", lambda: installed)
    if installed:
        pytest.importorskip("llvmlite")
    for shape, how in (
        ((7, 200), "NumPy does it at once"),
        ((30, 1300), "as machine code" if installed else "llvmlite (extra 'fast'), which would compile them, is not"),
    ):
        solution = four_bar(shape).solve()
        assert "The last reading took" not in solution.explain()
        solution.displacement("P")
        assert how in solution.explain()


def test_short_batches_do_not_load_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither that of a formula with sines nor a large displacement of few entries looks at the processor."""
    monkeypatch.setattr(machine_code, "available", lambda: True)
    monkeypatch.setattr(machine_code, "fused", lambda: pytest.fail("the compiler is loaded"))
    recording = Recording(fixed=True)
    work = Calculation.recorded(recording, [np.sin(recording.take(np.arange(6.0)))], (6,))
    assert not work.choice.compiled
    np.testing.assert_array_equal(work.results()[0], np.sin(np.arange(6.0)))
    places = four_bar((1, 6)).solve(large=True).displacement("P")
    assert np.isfinite(places).all()


@needs_llvm
@pytest.mark.parametrize("length", [1000, 1001, 1003, 2**18 + 5])
@pytest.mark.parametrize("apart", [0, 3], ids=["lines begin together", "lines begin apart"])
def test_results_written_past_the_cache(length: int, apart: int) -> None:
    """More than it holds, wherever lines of the cache begin in a row: those of NumPy, and nothing beside them."""
    rng = np.random.default_rng(4)
    rows = 2**18 // length + 1
    given = rng.normal(size=(rows, 1)), rng.normal(size=(1, length))
    recording = Recording()
    a, b = (recording.take(value) for value in given)
    terms = [a + b, a * b, b - a, *((a + b) * float(k) for k in range(2, 8))]
    room = np.zeros((len(terms), rows * length + 8 + apart))
    outs = [each[k % 2 * apart :][: rows * length].reshape(rows, length) for k, each in enumerate(room)]
    assert 8 * sum(out.size for out in outs) > PAST
    Calculation.recorded(recording, terms, (rows, length), compiled=True).run(0, slice(None), outs)
    x, y = given
    for found, wanted in zip(outs, [x + y, x * y, y - x, *((x + y) * float(k) for k in range(2, 8))], strict=True):
        np.testing.assert_array_equal(found, wanted)
    for k, each in enumerate(room):
        assert not each[: k % 2 * apart].any()
        assert not each[k % 2 * apart + rows * length :].any()


@needs_llvm
@pytest.mark.parametrize("lead", [1, 3])
@pytest.mark.parametrize("length", [7, 17, 1000])
def test_conditions_that_are_asked_for_and_needed(lead: int, length: int) -> None:
    """Of rows, of columns and of both: what is true or false is a byte where it is asked for, a number in registers."""
    rng = np.random.default_rng(6)
    a, b = rng.normal(size=(lead, 1)), rng.normal(size=(1, length))
    recording = Recording()
    x, y = recording.take(a), recording.take(b)
    conditions = [x < 0.2, y < 0.5, x * y < 0.1]
    terms = [*conditions, *(choose(condition, x * y, x + y) for condition in conditions)]
    found = Calculation.recorded(recording, terms, (lead, length), compiled=True).results()
    wanted = [a < 0.2, b < 0.5, a * b < 0.1]
    wanted += [np.where(condition, a * b, a + b) for condition in wanted]
    for one, other in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(*np.broadcast_arrays(one, other))


@needs_llvm
def test_other_threads_hold_what_they_write_to(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where the one that asked is interrupted, and forgets all of it, while they are at work."""
    monkeypatch.setattr(calculation, "THREADS", 0.0)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    recording = Recording()
    x = recording.take(np.ones((2, 100)))
    work = Calculation.recorded(recording, [x * 3.0], (2, 100), compiled=True)
    gone, done, held = threading.Event(), threading.Event(), []

    def function(table: int, first: int, *_: int) -> None:
        if first == 0:
            raise KeyboardInterrupt
        gone.wait(10.0)
        held.append(room() is not None)
        done.set()

    monkeypatch.setattr(work._kernel, "_function", function)
    out = np.zeros((2, 100))
    room = weakref.ref(out)
    try:
        work.run(0, slice(None), [out])
    except KeyboardInterrupt:
        del out
    gc.collect()
    gone.set()
    assert done.wait(10.0)
    assert held == [True]
