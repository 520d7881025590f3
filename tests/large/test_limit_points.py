"""Limit points of paths do not depend on the steps: shallow trusses, alone and in series, in closed form.

Two rods of stiffness k and length l0 between feet 2 apart, lowered by v from height h, carry ``2 k (l0 / l - 1)
(h - v)``; that is largest where ``l**3 = l0``, and least at the same height below the feet. Trusses in series carry the
same load: the weaker one snaps through first, while the other goes back and forth; then that comes to its own limit.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section, Spring
from linkframe.framework import Frame, PathWarning
from linkframe.framework.large import limit_points
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
HEIGHT = 0.1


def largest(height: ArrayLike, stiffness: ArrayLike) -> Array:
    """Limit load of a truss."""
    length = np.hypot(1.0, np.asarray(height))
    return 2.0 * stiffness * (length ** (2.0 / 3.0) - 1.0) ** 1.5


def turn(height: float) -> float:
    """How far it is lowered there."""
    return height - float(np.sqrt(np.hypot(1.0, height) ** (2.0 / 3.0) - 1.0))


def truss(load: ArrayLike = 1.0, height: ArrayLike = HEIGHT) -> Frame:
    """The truss, which keeps to the plane of x and y."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        rise = np.asarray(height if name == "B" else 0.0)
        frame.node(name, np.stack([np.full_like(rise, x), rise, np.zeros_like(rise)], axis=-1))
    for ends in ("AB", "BC"):
        frame.add(ends, Spring(1e4), *ends)
    frame.fix("A")
    frame.fix("C")
    frame.fix("B", "uz", "rx", "ry", "rz")
    frame.load("B", fy=-np.asarray(load))
    return frame


def in_series(stiffnesses: tuple[float, ...], spring: float | None = None) -> Frame:
    """Trusses one upon the apex of the other, the topmost loaded there, or at the end of a spring that hangs there."""
    frame = Frame()
    guided = ("ux", "uz", "rx", "ry", "rz")
    for k, stiffness in enumerate(stiffnesses):
        for name, place in {"A": (0.0, k), "B": (1.0, k + HEIGHT), "C": (2.0, k)}.items():
            frame.node(f"{name}{k}", (*place, 0.0))
        for start, end in ("AB", "BC"):
            frame.add(f"{start}{end}{k}", Spring(stiffness), f"{start}{k}", f"{end}{k}")
        frame.fix(f"B{k}", *guided)
        for foot in (f"A{k}", f"C{k}"):
            if k:
                frame.rigid(f"B{k - 1}", foot)
            else:
                frame.fix(foot)
    top = f"B{len(stiffnesses) - 1}"
    if spring is not None:
        frame.node("end", (1.0, -1.0, 0.0))
        frame.add("spring", Spring(spring), top, "end")
        frame.fix("end", *guided)
    frame.load(top if spring is None else "end", fy=-1.0)
    return frame


@pytest.mark.parametrize("first", [1e-3, 0.05, 0.5, 3.0, 20.0, 40.0])
def test_the_limits_of_a_truss_are_those_of_the_formula(first: float) -> None:
    """In 26 points or in 3, of which the first is beyond both."""
    path = truss().path("B", "uy", -2.5 * HEIGHT, first=first)
    exact = largest(HEIGHT, 1e4)
    assert_allclose(path.limits[0], [exact, -exact], rtol=1e-11)


@pytest.mark.parametrize("first", [1e-3, 0.05, 0.3])
def test_a_limit_in_the_last_step_is_told_and_one_behind_it_is_not(first: float) -> None:
    at = turn(HEIGHT)
    whole = truss().path("B", "uy", -2.0 * HEIGHT, first=first)
    lowered = -whole.displacement("B")[:, 1]
    before = int(np.flatnonzero(lowered < at)[-1])
    for last, count in ((before, 0), (before + 1, 1)):
        path = truss().path("B", "uy", -float(lowered[last]) * (1.0 - 1e-9), first=first)
        assert len(path.factor) == last + 1
        assert_allclose(path.limits[0], [largest(HEIGHT, 1e4)] * count, rtol=1e-11)


@pytest.mark.parametrize("first", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("stiffnesses", [(1e4, 1.3e4), (2.3e4, 1e4), (1e4, 1.05e4)])
def test_trusses_in_series_snap_one_after_the_other(stiffnesses: tuple[float, ...], first: float) -> None:
    path = in_series(stiffnesses).path("B1", "uy", -2.4 * HEIGHT, first=first)
    weak, strong = (largest(HEIGHT, each) for each in sorted(stiffnesses))
    lowered = -np.stack([path.displacement(name)[:, 1] for name in ("B0", "B1")])
    stronger = (lowered[0], lowered[1] - lowered[0])[int(np.argmax(stiffnesses))]
    expected = [weak, -weak, strong][: 2 + int(stronger[-1] > turn(HEIGHT))]
    assert_allclose(path.limits[0], expected, rtol=1e-10)


@pytest.mark.parametrize("first", [0.01, 0.1, 1.0])
@pytest.mark.parametrize("spring", [20.0, 60.0, 500.0])
def test_a_truss_on_a_spring_snaps_back(spring: float, first: float) -> None:
    """The end of a soft spring goes back while the truss snaps through."""
    path = in_series((1e4,), spring).path("end", "uy", -2.4 * HEIGHT - 10.0 / spring, first=first)
    exact = largest(HEIGHT, 1e4)
    assert_allclose(path.limits[0], [exact, -exact], rtol=1e-11)
    moved = np.diff(path.displacement("end")[:, 1])
    assert (moved > 0.0).any() == (spring < 100.0)


def test_limits_of_a_frame_are_the_same_in_short_and_in_long_steps() -> None:
    """Two bars clamped at their feet, which bend; the load is the reaction of an apex that is moved down."""
    section = Section(A=0.1885, Iy=1e-2, Iz=9.27e-4, J=1e-2)

    def toggle() -> Frame:
        frame = Frame()
        for name, place in {"A": (0.0, 0.0), "C": (12.94, 0.386), "B": (25.88, 0.0)}.items():
            frame.node(name, (*place, 0.0))
        for ends in ("AC", "CB"):
            frame.add(ends, Beam(section, Material(E=1e7, nu=0.3), segments=3), *ends)
        frame.fix("A")
        frame.fix("B")
        return frame

    found = []
    for first in (0.2, 2.0, 8.0):
        frame = toggle()
        frame.load("C", fy=-1.0)
        found.append(frame.path("C", "uy", -0.75, first=first, steps=300).limits[0])
    assert [len(each) for each in found] == [2, 2, 2]
    assert_allclose(found[1:], [found[0]] * 2, rtol=1e-10)
    moved = toggle()
    moved.prescribe("C", uy=-np.linspace(0.05, 0.7, 131))
    load = -moved.solve(large=True, steps=4).reaction("C")[:, 1]
    assert_allclose(found[0], [load[:80].max(), load[60:].min()], rtol=2e-3)
    assert found[0][0] >= load[:80].max()
    assert found[0][1] <= load[60:].min()


def test_a_limit_has_the_bits_that_it_has_alone() -> None:
    """Among entries of other heights and loads, with two limits, with one and with none."""
    loads, heights = np.array([1.0, 30.0, 0.2, 700.0]), np.array([[0.1], [0.07], [0.13]])
    whole = truss(loads, heights).path("B", "uy", -0.15)
    assert sorted({len(each) for each in whole.limits}) == [1, 2]
    for entry, found in enumerate(whole.limits):
        row, column = divmod(entry, len(loads))
        alone = truss(loads[column], heights[row, 0]).path("B", "uy", -0.15)
        assert_array_equal(alone.limits[0], found)
        exact = largest(heights[row, 0], 1e4) / loads[column]
        assert_allclose(found, [exact, -exact][: len(found)], rtol=1e-11)


def test_limits_of_entries_in_several_planes() -> None:
    """Those that keep to the plane, one with a load across it, on the support there, and one that is left out."""
    frame = truss()
    frame.load("B", fz=[0.0, 0.0, 5.0, 0.0])
    frame.exclude([False, True, False, False])
    limits = frame.path("B", "uy", -0.25).limits
    exact = largest(HEIGHT, 1e4)
    assert_allclose([limits[0], limits[2]], [[exact, -exact]] * 2, rtol=1e-11)
    assert limits[1].shape == (0,)
    assert_array_equal(limits[3], limits[0])


def test_reading_limits_changes_nothing() -> None:
    path = truss([1.0, 2.0]).path("B", "uy", -0.25)
    before = [path.factor.copy(), path.displacement("B"), path.stable.copy(), path.reached.copy()]
    limits = path.limits
    for old, new in zip(before, [path.factor, path.displacement("B"), path.stable, path.reached], strict=True):
        assert_array_equal(old, new)
    again = truss([1.0, 2.0]).path("B", "uy", -0.25).limits
    assert_array_equal(limits, again)


def test_a_limit_that_is_not_found_is_nan(monkeypatch: pytest.MonkeyPatch) -> None:
    path = truss([1.0, 2.0]).path("B", "uy", -0.08)
    monkeypatch.setattr(limit_points, "MOST", 0)
    with pytest.warns(PathWarning, match=r"between load factors .* \(entry \(0,\)\) was not found .* \(2 such\)"):
        limits = path.limits
    assert_array_equal(limits, [[np.nan], [np.nan]])


def test_where_one_is_not_found_the_others_of_its_step_are_not_told(monkeypatch: pytest.MonkeyPatch) -> None:
    """Such a step may have led to another path. Here the only step holds both limits."""
    path = truss().path("B", "uy", -2.0 * HEIGHT, first=40.0)
    assert len(path.factor) == 2
    values = limit_points._values

    def one_lost(*given: object) -> tuple[Array, NDArray[np.bool_]]:
        value, found = values(*given)  # type: ignore[arg-type]
        found[-1] = False
        return value, found

    monkeypatch.setattr(limit_points, "_values", one_lost)
    with pytest.warns(PathWarning, match=r"\(2 such\)"):
        assert_array_equal(path.limits[0], [np.nan, np.nan])


def test_a_limit_beside_which_the_path_is_left_is_nan(monkeypatch: pytest.MonkeyPatch) -> None:
    """Points found short of the limit, from where on they lie on another path, which falls, do not enclose a limit."""
    path = truss().path("B", "uy", -0.08)
    at, exact = limit_points._Points.at, largest(HEIGHT, 1e4)

    def beyond_on_another(points: limit_points._Points, place: Array, which: NDArray[np.bool_]) -> Array:
        found = at(points, place, which)
        other = found[1] > 0.999 * exact
        return np.where(other, np.stack([found[0], found[1] + 0.01 * exact, -np.abs(found[2])]), found)

    assert_allclose(path.limits[0], [exact], rtol=1e-11)
    again = truss().path("B", "uy", -0.08)
    monkeypatch.setattr(limit_points._Points, "at", beyond_on_another)
    with pytest.warns(PathWarning, match=r"\(1 such\)"):
        assert_array_equal(again.limits[0], [np.nan])


def test_a_path_without_limits_has_none() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Spring(10.0), "A", "B")
    frame.fix("A")
    frame.fix("B", "uy", "uz", "rx", "ry", "rz")
    frame.load("B", fx=1.0)
    assert frame.path("B", "ux", 0.5).limits[0].shape == (0,)


def test_a_limit_at_a_stop_is_the_load_at_which_it_is_met() -> None:
    """Where a journal meets its bearing the load turns at once, from falling to rising."""
    frame = truss()
    clearance = 0.06
    frame.node("stop", (1.0, HEIGHT, 0.0))
    frame.add("stop", Joint((0.0, 1e6, 0.0, 0.0, 0.0, 0.0), clearance=clearance), "stop", "B")
    frame.fix("stop")
    limits = frame.path("B", "uy", -0.07).limits[0]
    left = HEIGHT - clearance
    met = 2e4 * (np.hypot(1.0, HEIGHT) / np.hypot(1.0, left) - 1.0) * left
    assert_allclose(limits, [largest(HEIGHT, 1e4), met], rtol=1e-9)
