"""Least energy over a product of balls by recorded programs: the bits of arrays, and fifty digits of the truth."""

from __future__ import annotations

import tracemalloc
from typing import Any

import mpmath
import numpy as np
import pytest
from linkframe import Beam, Frame, Joint, Material, Rectangle
from linkframe.framework.cache import KERNELS
from linkframe.framework.clearances import ball_program, ball_qp, contact_search
from linkframe.framework.clearances.ball_problem import BallProblem, Groups, Minimum
from linkframe.framework.clearances.unit_offsets import Resistance
from linkframe.framework.program import machine_code
from numpy.testing import assert_allclose, assert_array_equal

GROUPINGS = [[0], [0, 0], [0, 0, 0], [0, 0, 1, 1], [0, 0, 1, 1, 2, 2], [0, 1, 1, 1, 2, 2]]
COMPILED = [False, pytest.param(True, marks=pytest.mark.skipif(not machine_code.available(), reason="needs llvmlite"))]


def problem(own: list[int], size: float, rank: int, count: int, *, varying: bool = True) -> BallProblem:
    rng, n = np.random.default_rng(0), len(own)
    roots = rng.normal(size=(n, rank, count if varying else 1))
    stiffness = size * np.einsum("irn,jrn->ijn", roots, roots)
    stiffness = 0.5 * (stiffness + np.swapaxes(stiffness, 0, 1))
    members = np.full((n, 1), size)
    radius = rng.uniform(0.5, 2.0, (own[-1] + 1, count))
    return BallProblem(Groups(np.array(own)), stiffness, rng.normal(size=(n, count)), members, radius)


def programs(own: list[int]) -> ball_program.BallPrograms:
    found = ball_program.BallPrograms.of(Groups(np.array(own)))
    assert found is not None
    return found


def by_program(given: BallProblem, *, compiled: bool) -> Minimum:
    out = Minimum.places(len(given.force), given.groups.count, given.force.shape[-1])
    programs(given.groups.own.tolist()).run(given, out, compiled=compiled)
    return out


def by_arrays(given: BallProblem) -> Minimum:
    out = Minimum.places(len(given.force), given.groups.count, given.force.shape[-1])
    ball_qp._by_arrays(given, out)
    return out


def at(found: Minimum, entry: int) -> Minimum:
    return Minimum(*(each[..., [entry]] for each in found.arrays))


def assert_same(one: Minimum, other: Minimum) -> None:
    for each, again in zip(one.arrays, other.arrays, strict=True):
        assert_array_equal(each, again)


@pytest.mark.parametrize("compiled", COMPILED)
@pytest.mark.parametrize("size", [0.0, 1e-8, 1e-2, 1.0, 1e2, 1e6])
@pytest.mark.parametrize("own", GROUPINGS)
def test_programs_give_the_bits_of_arrays(own: list[int], size: float, *, compiled: bool) -> None:
    for rank in {1, len(own)}:
        given = problem(own, size, rank, 300)
        assert_same(by_program(given, compiled=compiled), by_arrays(given))


@pytest.mark.parametrize("compiled", COMPILED)
def test_numbers_that_do_not_vary_give_the_same_bits(*, compiled: bool) -> None:
    own = [0, 0, 1, 1, 2, 2]
    given = problem(own, 1.0, 4, 200, varying=False)
    stiffness, members = (np.repeat(each, 200, axis=-1) for each in (given.stiffness, given.members))
    whole = BallProblem(given.groups, stiffness, given.force, members, given.radius)
    assert_same(by_program(given, compiled=compiled), by_arrays(whole))


@pytest.mark.parametrize("compiled", COMPILED)
@pytest.mark.parametrize("count", [1, 3, 9])
def test_few_entries_give_the_same_bits(count: int, *, compiled: bool) -> None:
    given = problem([0, 0, 1, 1, 2, 2], 1.0, 4, count)
    assert_same(by_program(given, compiled=compiled), by_arrays(given))


@pytest.mark.skipif(not machine_code.available(), reason="needs llvmlite")
def test_balls_that_are_met_often_are_compiled_for_short_batches_too() -> None:
    """Once arrays took as long as compiling takes; not at first, which would cost a single frame more than it saves."""
    groups = Groups(np.array([0, 1, 1, 2, 3, 3]))
    choices = [ball_program.chosen(groups, 10).compiled for _ in range(500)]
    assert not any(choices[:5])
    assert all(choices[200:])


@pytest.mark.parametrize("compiled", COMPILED)
def test_without_force_or_without_radius(*, compiled: bool) -> None:
    own = [0, 0, 1, 1]
    given = problem(own, 1.0, 4, 40)
    given.force[:, :10] = 0.0
    given.radius[0, 5:20] = 0.0
    assert_same(by_program(given, compiled=compiled), by_arrays(given))
    found = ball_qp.minima(given)
    assert not found.offset[:, :10].any()
    assert not found.offset[:2, 5:20].any()
    assert found.offset[2:, 10:].all()


def balanced_by_fifty_digits(stiffness: np.ndarray, force: np.ndarray, found: Minimum, own: list[int]) -> list[float]:
    """Offsets and multipliers of one entry by Newton's method on balance and active spheres, with fifty digits."""
    n, active = len(own), [ball for ball in range(own[-1] + 1) if found.pressing[ball, 0] > 0.0]

    def conditions(*values: mpmath.mpf) -> list[mpmath.mpf]:
        x, multiplier = values[:n], dict(zip(active, values[n:], strict=True))
        rest = [
            mpmath.mpf(force[i])
            - mpmath.fdot([mpmath.mpf(k) for k in stiffness[i]], x)
            - multiplier.get(own[i], mpmath.mpf(0)) * x[i]
            for i in range(n)
        ]
        return rest + [mpmath.fsum(x[i] ** 2 for i in range(n) if own[i] == ball) - 1 for ball in active]

    start = [*found.offset[:, 0].tolist(), *found.pressing[active, 0].tolist()]
    with mpmath.workdps(50):
        return [float(x) for x in mpmath.findroot(conditions, start, tol=1e-80)]


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [1e-2, 1.0, 30.0])
def test_offsets_and_forces_against_fifty_digits(size: float, seed: int) -> None:
    """The active spheres are those of the minimum, as all multipliers are positive and no offset is outside."""
    own, count = [0, 0, 1, 1, 2, 2], 600
    rng = np.random.default_rng(seed)
    roots = rng.normal(size=(6, 6))
    stiffness, force = size * (roots @ roots.T + np.eye(6)), rng.normal(size=(6, count))
    stiffness = 0.5 * (stiffness + stiffness.T)
    given = BallProblem(Groups(np.array(own)), stiffness[..., None], force, np.full((6, 1), size), np.ones((3, 1)))
    found = ball_qp.minima(given)
    for entry in (0, 599):
        one = at(found, entry)
        (*exact,) = balanced_by_fifty_digits(stiffness, force[:, entry], one, own)
        x, pressing = np.array(exact[:6]), np.array(exact[6:])
        assert (pressing > 0.0).all()
        assert np.hypot.reduceat(x, [0, 2, 4]).max() <= 1.0 + 1e-15
        scale = np.linalg.cond(stiffness) * 4e-15
        assert np.abs(one.offset[:, 0] - x).max() <= scale
        assert np.abs(one.pressing[one.pressing[:, 0] > 0.0, 0] - pressing).max(initial=0.0) <= scale * (1.0 + size)


def test_memory_is_that_of_the_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """No matrix of each entry is stored: some 19 numbers an entry, not 36 and more."""
    given = problem([0, 0, 1, 1, 2, 2], 1.0, 6, 2**17, varying=False)
    ball_qp.minima(given.at(slice(0, 2000)))
    tracemalloc.start()
    ball_qp.minima(given)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 8 * 24 * 2**17


def closed_loop(gap: np.ndarray, push: np.ndarray, modulus: float | np.ndarray = 2e11) -> Frame:
    """Two cantilevers on pins with clearance, joined by a third beam: statically indeterminate."""
    beam = Beam(Rectangle(y=0.02, z=0.01), Material(E=modulus, nu=0.3))
    frame = Frame()
    for k, tip in enumerate(("b0", "b1")):
        for node in (f"c{k}", f"a{k}"):
            frame.node(node, (0.0, 0.3 * k, 0.0))
        frame.node(tip, (1.0, 0.3 * k + 0.1, 0.0))
        frame.add(f"j{k}", Joint((2e8, 2e8, 2e8, 2e5, 2e5, 0.0), clearance=gap * (1 + k)), f"c{k}", f"a{k}")
        frame.fix(f"c{k}")
        frame.add(f"m{k}", beam, f"a{k}", tip)
    frame.add("r", beam, "b0", "b1")
    frame.load("b0", fy=-push, fx=0.3 * push)
    return frame


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_batch_equals_its_entries_bit_by_bit(size: float) -> None:
    """Two thousand entries, by machine code where it is installed, and some of them alone, by NumPy."""
    given = problem([0, 0, 1, 1, 2, 2], size, 4, 2000)
    given.force[:, :5] = 0.0
    given.radius[0, 3:8] = 0.0
    whole = ball_qp.minima(given)
    for entry in (0, 3, 5, 7, 8, 1000, 1999):
        assert_same(at(whole, entry), ball_qp.minima(given.at(np.array([entry]))))


def test_contact_of_a_long_batch_is_that_of_short_ones() -> None:
    """But for rounding of the joint forces, which are products of matrices."""
    rng = np.random.default_rng(3)
    gap, push = rng.uniform(0.0, 2e-4, 2000), rng.uniform(50.0, 150.0, 2000)
    gap[:3], push[1:5] = 0.0, 0.0
    whole = closed_loop(gap, push).solve()
    for entry in (0, 1, 2, 3, 4, 5, 1000, 1999):
        one = closed_loop(gap[[entry, 1500]], push[[entry, 1500]]).solve()
        for joint in ("j0", "j1"):
            assert_allclose(whole.contact(joint).offset[entry], one.contact(joint).offset[0], rtol=1e-13, atol=1e-18)
            assert_allclose(whole.contact(joint).force[entry], one.contact(joint).force[0], rtol=1e-13)
            assert whole.contact(joint).state[entry] == one.contact(joint).state[0]


def test_parts_of_a_batch_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    """The members' modulus varies along the first axis, clearances and loads along the second."""
    rng = np.random.default_rng(3)
    gap, push, modulus = rng.uniform(0.0, 2e-4, 7), rng.uniform(50.0, 150.0, 7), np.array([[1e11], [2e11], [3e11]])
    gap[1], push[2] = 0.0, 0.0
    whole = closed_loop(gap, push, modulus).solve()
    expected = [whole.contact(joint) for joint in ("j0", "j1")]
    monkeypatch.setattr("linkframe.framework.clearances.contact_state._MOST", 4)
    parts = closed_loop(gap, push, modulus).solve()
    for contact in expected:
        again = parts.contact(contact.joint)
        assert_array_equal(again.offset, contact.offset)
        assert_array_equal(again.force, contact.force)
        assert_array_equal(again.state, contact.state)
        assert (contact.force[:, 3:] > 0.0).all()


def test_resistance_to_offsets_is_found_once_for_all_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    """And anew where a joint, another one with clearance included, is changed."""
    asked, search = [0], contact_search.against_offsets

    def counted(*given: Any) -> Resistance:
        asked[0] += 1
        return search(*given)

    monkeypatch.setattr(contact_search, "against_offsets", counted)
    gap, push = np.array([1e-4, 2e-4]), np.array([100.0, 50.0])
    frame = closed_loop(gap, push)
    frame.solve().displacement("b0")
    frame.set_load("b0", fy=2.0 * push)
    found = frame.solve().displacement("b0")
    assert asked[0] == 1
    again = closed_loop(gap, push)
    again.set_load("b0", fy=2.0 * push)
    assert_array_equal(found, again.solve().displacement("b0"))
    for changed in (Joint((2e8, 2e8, 2e8, 2e5, 2e5, 0.0)), Joint((1e8, 1e8, 2e8, 2e5, 2e5, 0.0), clearance=3e-4)):
        before = asked[0]
        for each in (frame, again):
            each.change("j1", changed)
        assert_array_equal(frame.solve().displacement("b0"), again.solve().displacement("b0"))
        assert asked[0] == before + 2


@pytest.mark.parametrize("count", [1, 2000])
def test_explain_tells_what_the_contact_took(count: int) -> None:
    KERNELS.clear()  # how often such balls were met decides whether a short batch is compiled
    rng = np.random.default_rng(3)
    solution = closed_loop(rng.uniform(1e-4, 2e-4, count), rng.uniform(50.0, 150.0, count)).solve()
    text = solution.explain()
    assert f"found by Newton's method at {count} of {count} entries in " in text
    assert "steps on average" in text
    compiled = machine_code.available() and count > 1
    assert ("as machine code, about" in text.split("The minimum was found")[1].split("\n")[0]) == compiled
