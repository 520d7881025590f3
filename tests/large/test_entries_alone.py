"""An entry at large displacement is the same alone and in any batch, also where two branches are as near."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.framework.large import newton_program
from numpy.typing import NDArray

Array = NDArray[np.float64]
INF = np.inf
BAR = Beam(Circle(diameter=0.05), Material(E=200e9, nu=0.3), up=(0.0, 0.0, 1.0))


def chain(places: Array, pin: tuple[float, ...], push: Array, fixed: bool = False) -> Frame:
    """Bars from place to place (nodes, ..., 3) on pins, held at its start, its end guided along x."""
    frame = Frame()
    for k in range(len(places) - 1):
        frame.node(f"a{k}", places[k])
        frame.node(f"b{k}", places[k + 1])
        frame.add(f"bar{k}", BAR, f"a{k}", f"b{k}")
        if k:
            frame.add(f"pin{k}", Joint(pin), f"b{k - 1}", f"a{k}")
    end = f"b{len(places) - 2}"
    frame.fix("a0", *(() if fixed else ("ux", "uy", "uz", "rx", "ry")))
    frame.fix(end, "uy", "uz")
    frame.load(end, fx=push)
    return frame


def random_chain(seed: int, entry: int | None = None) -> Frame:
    """A random one; with an `entry`, that of its three alone."""
    rng = np.random.default_rng(seed)
    straight, count = rng.random() < 0.5, int(rng.integers(2, 4))
    steps = (
        rng.normal(size=(count, 1, 3)) * [1.0, 1.0, 0.0] if not straight else np.tile([1.0, 0.0, 0.0], (count, 1, 1))
    )
    places = np.concatenate([np.zeros((1, 1, 3)), np.cumsum(steps, axis=0)]) * rng.uniform(0.5, 1.5, (1, 3, 1))
    push = -(10.0 ** rng.uniform(1.0, 4.0, 3))
    pin = (INF,) * 5 + (float(rng.choice([0.0, 10.0])),)
    fixed = bool(rng.random() < 0.5)
    if entry is not None:
        places, push = places[:, entry], push[entry]
    return chain(places, pin, push, fixed)


@pytest.mark.parametrize("seed", [2, 5, 7])
def test_a_batch_is_its_entries(seed: int) -> None:
    """To the bit: places, bounds and status, whatever the neighbours are."""
    whole = random_chain(seed).solve(large=True)
    for entry in range(3):
        alone = random_chain(seed, entry).solve(large=True)
        assert alone.status == whole.status[entry]
        for node in ("a1", "b1"):
            np.testing.assert_array_equal(alone.displacement(node), whole.displacement(node)[entry])
            np.testing.assert_array_equal(alone.error_bound(node), whole.error_bound(node)[entry])


@pytest.mark.parametrize("tilt", [1e-16, -1e-16])
def test_of_mirror_images_the_side_is_no_matter_of_rounding(tilt: float) -> None:
    """A straight chain of two bars pushed along itself bends up, and says that it might have bent down."""
    places = np.array([[0.0, 0.0, 0.0], [1.0, tilt, 0.0], [2.0, 0.0, 0.0]])
    solution = chain(places, (INF,) * 5 + (10.0,), np.array([-30.0])).solve(large=True)
    assert (solution.status == "stable beyond a saddle").all()
    assert (solution.displacement("b0")[:, 1] > 0.5).all()


def test_neutral_motions_are_told_by_arrays_and_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bars between balls spin freely: no place of theirs is determined, all others are."""
    places = np.array([[0.0, 0.0, 0.0], [1.0, 0.5, 0.2], [2.0, 0.0, 0.0]])
    pulled = chain(places, (INF,) * 3 + (0.0,) * 3, np.array([10.0, 20.0, 40.0]), fixed=True)
    found = []
    for recorded in (False, True):
        monkeypatch.setattr(newton_program._Costs, "pay_compiled", lambda *_: False)
        monkeypatch.setattr(newton_program._Costs, "pay_by_numpy", lambda *_, chosen=recorded: chosen)
        solution = pulled.solve(large=True)
        assert (solution.status == "statically consistent mechanism").all()
        assert solution.stable.all()
        assert np.isinf(solution.error_bound("b1")[:, 3]).all()
        assert (solution.error_bound("b1")[:, 0] < 1e-9).all()
        found.append(solution.displacement("b1"))
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9, atol=1e-12)


def test_a_body_on_nothing() -> None:
    """Without a load it may be anywhere, and linear mechanics says the same."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.load("B", fx=0.0)
    solution = frame.solve(large=True)
    assert np.isinf(solution.error_bound("B")[:2]).all()
    assert solution.status == frame.solve().status == "statically consistent mechanism"
