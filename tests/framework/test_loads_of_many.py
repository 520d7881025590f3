"""Loads on many members, which are integrated in stacks: each member carries its own, whatever stands beside it."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, FrameError
from numpy.typing import NDArray

Array = NDArray[np.float64]
BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0))
WEIGHT = 7850.0 * 9.81 * 0.03 * 0.02
Q, P = np.array([-40.0, 7.0, 300.0]), 25.0


def uniform(frame: Frame, name: str, length: float) -> tuple[Array, Array]:
    """A line load that varies over the batch: ``q L / 2`` and ``q L^2 / 12`` at either end."""
    frame.line_load(name, fy=Q)
    return np.stack([-Q * length / 2.0] * 2), np.stack([-Q * length**2 / 12.0, Q * length**2 / 12.0])


def at_a_third(frame: Frame, name: str, length: float) -> tuple[Array, Array]:
    """A force P at a: ``P b^2 (3 a + b) / L^3`` and ``P a b^2 / L^2`` at the start."""
    a = length / 3.0
    b = length - a
    frame.point_load(name, at=a, fy=P)
    force = np.array([b**2 * (3.0 * a + b), a**2 * (a + 3.0 * b)]) * P / length**3
    moment = np.array([a * b**2, -(a**2) * b]) * P / length**2
    return -force[:, None], -moment[:, None]


def nothing(frame: Frame, name: str, length: float) -> tuple[Array, Array]:
    return np.zeros((2, 1)), np.zeros((2, 1))


def both(frame: Frame, name: str, length: float) -> tuple[Array, Array]:
    first, second = uniform(frame, name, length), at_a_third(frame, name, length)
    return first[0] + second[0], first[1] + second[1]


KINDS: tuple[Callable[[Frame, str, float], tuple[Array, Array]], ...] = (uniform, at_a_third, nothing, both)


def add_clamped_beam(frame: Frame, k: int) -> float:
    """Add beam k along x, clamped at both ends, and return its length."""
    length = 1.0 + 0.1 * k
    frame.node(f"A{k}", (0.0, float(k), 0.0))
    frame.node(f"B{k}", (length, float(k), 0.0))
    frame.add(f"{k}", BEAM, f"A{k}", f"B{k}")
    frame.fix(f"A{k}")
    frame.fix(f"B{k}")
    return length


def clamped(order: list[int]) -> tuple[Frame, dict[int, tuple[Array, Array]]]:
    """Beams along x of different lengths, clamped at both ends, described in this order, and what clamps carry."""
    frame, expected = Frame(), {}
    for k in order:
        length = add_clamped_beam(frame, k)
        force, moment = KINDS[k % 4](frame, f"{k}", length)
        own = WEIGHT * length
        expected[k] = force + own / 2.0, moment + own * length / 12.0 * np.array([[1.0], [-1.0]])
    frame.gravity((0.0, -9.81, 0.0))
    return frame, expected


@pytest.mark.parametrize("method", [None, "sparse"])
def test_each_beam_carries_its_own_loads(method: str | None) -> None:
    """Clamps carry the closed forms (Roark, table 8.1), inside the error bounds."""
    frame, expected = clamped(list(range(17)))
    solution = frame.solve(method)
    all_ends = solution.all_end_forces()
    for k, (force, moment) in expected.items():
        for side, node in enumerate((f"A{k}", f"B{k}")):
            found, bound = solution.reaction(node), solution.error_bound(node, "reaction")
            for component, wanted in ((1, force[side]), (5, moment[side])):
                off = np.abs(found[:, component] - wanted)
                assert (off <= 1e-13 * np.abs(wanted).max()).all()
                assert (off <= bound[:, component] + 1e-15 * np.abs(wanted).max()).all()
        ends = solution.end_forces(f"{k}")
        np.testing.assert_allclose(all_ends[:, k], ends, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(ends[:, 1], np.broadcast_to(force[0], 3), rtol=1e-12, atol=1e-12)
        middle = solution.forces(f"{k}", [0.0])[:, 0, 5]
        np.testing.assert_allclose(middle, np.broadcast_to(-moment[0], 3), rtol=1e-12, atol=1e-12)


def test_the_order_of_description_changes_no_bit() -> None:
    """Reactions, forces and bounds, though loads are integrated in other stacks."""
    order = list(range(17))
    one = clamped(order)[0].solve()
    other = clamped(np.random.default_rng(3).permutation(order).tolist())[0].solve()
    for k in order:
        node = f"B{k}"
        np.testing.assert_array_equal(one.reaction(node), other.reaction(node))
        np.testing.assert_array_equal(one.end_forces(f"{k}"), other.end_forces(f"{k}"))
        np.testing.assert_array_equal(one.error_bound(node, "reaction"), other.error_bound(node, "reaction"))


def test_the_member_with_a_moment_is_named() -> None:
    """At large displacement a moment between the ends is refused, by the name of its member and of no other."""
    frame, _ = clamped([1, 5, 9])
    frame.point_load("1", at=0.3, fy=1.0)
    frame.point_load("9", at=0.3, fy=1.0)
    frame.point_load("5", at=0.3, mz=1.0)
    with pytest.raises(FrameError, match="point load on '5' has a moment"):
        frame.solve(large=True).reaction("B1")


def test_rounding_in_the_loads_is_within_the_bounds() -> None:
    """Against the closed forms in fractions of the numbers as given."""
    frame, exact, places = Frame(), {}, np.random.default_rng(7).uniform(0.1, 0.9, 12)
    for k, place in enumerate(places.tolist()):
        length = add_clamped_beam(frame, k)
        frame.point_load(f"{k}", at=place, fy=P)
        a, whole = Fraction(place), Fraction(length)
        b = whole - a
        exact[k] = -Fraction(P) * b**2 * (3 * a + b) / whole**3, -Fraction(P) * a * b**2 / whole**2
    solution, rounded = frame.solve(), 0
    for k, wanted in exact.items():
        found, bound = solution.reaction(f"A{k}")[[1, 5]], solution.error_bound(f"A{k}", "reaction")[[1, 5]]
        for one, most, value in zip(found.tolist(), bound.tolist(), wanted, strict=True):
            assert abs(Fraction(one) - value) <= Fraction(most) <= abs(value) * Fraction(1, 10**12)
            rounded += Fraction(one) != value
    assert rounded > 12
