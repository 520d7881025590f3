"""The status of an equilibrium is the same whatever solved it, alone and in a batch, in any order of description."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, rotation
from linkframe.framework.large import newton_program
from linkframe.framework.large.elimination import GeneralFactor
from linkframe.framework.large.solution import LargeSolution
from numpy.typing import NDArray

Array = NDArray[np.float64]
INF = np.inf
STEEL = Material(E=200e9, nu=0.3)


def chain(seed: int, *, reverse: bool = False, entry: int | None = None) -> Frame:
    """Bars on balls and pins, perhaps free to turn about its first node, its end held, guided or free."""
    rng = np.random.default_rng(seed)
    entries, count = int(rng.integers(2, 9)), int(rng.integers(2, 5))
    steps = rng.normal(size=(count, 1, 3)) * (1.0, 1.0, 0.0)
    if rng.random() < 0.4:
        steps = np.tile((1.0, 0.0, 0.0), (count, 1, 1))
    places = np.concatenate([np.zeros((1, 1, 3)), np.cumsum(steps, axis=0)]) * rng.uniform(0.5, 1.5, (1, entries, 1))
    bar = Beam(Circle(diameter=10.0 ** rng.uniform(-2.3, -1.0)), STEEL, up=(0.0, 0.0, 1.0))
    kinds = [(INF,) * 5 + (0.0,), (INF,) * 5 + (10.0,), (INF,) * 3 + (0.0,) * 3, (1e8,) * 5 + (0.0,)]
    pins = [kinds[rng.integers(0, 4)] for _ in range(count)]
    whole, held, end = rng.random() < 0.5, rng.random(), f"b{count - 1}"
    loads = {}
    for node in sorted({end, "b0", "a1"}):
        size = 10.0 ** rng.uniform(0.0, 4.0, (3, entries)) * rng.choice([-1, 1], (3, entries))
        loads[node] = size * (rng.random((3, 1)) < 0.5)
    some = slice(None) if entry is None else entry
    frame = Frame()
    order = range(count)[::-1] if reverse else range(count)
    for k in order:
        frame.node(f"a{k}", places[k, some])
        frame.node(f"b{k}", places[k + 1, some])
    for k in order:
        frame.add(f"bar{k}", bar, f"a{k}", f"b{k}")
        if k:
            frame.add(f"pin{k}", Joint(pins[k]), f"b{k - 1}", f"a{k}")
    frame.fix("a0", *(() if whole else ("ux", "uy", "uz", "rx", "ry")))
    if held < 0.75:
        frame.fix(end, *(("uy", "uz") if held < 0.5 else ("ux", "uy", "uz")))
    for node, (fx, fy, _) in loads.items():
        frame.load(node, fx=fx[some], fy=fy[some])
    return frame


def solved(frame: Frame, recorded: bool) -> LargeSolution:
    """Solution by arrays, or step by step by NumPy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton_program._Costs, "pay_compiled", lambda *_: False)
        patch.setattr(newton_program._Costs, "pay_by_numpy", lambda *_: recorded)
        solution = frame.solve(large=True)
        assert (solution._load_stepping.newton.program is not None) == recorded
        assert solution.status.shape == frame.shape
    return solution


@pytest.mark.parametrize("seed", [10, 18])
def test_chains_that_may_be_free(seed: int) -> None:
    """A motion that nothing resists is told where the last step has led, and none is judged beside a whole turn."""
    arrays = solved(chain(seed), False)
    for other in (solved(chain(seed), True), solved(chain(seed, reverse=True), False)):
        assert other.status.tolist() == arrays.status.tolist()
    alone = [str(solved(chain(seed, entry=k), False).status) for k in range(2)]
    assert alone == arrays.status[:2].tolist()


def test_rotations_of_more_than_half_a_turn_go_the_short_way() -> None:
    """A rotation vector of nearly a whole turn hardly turns anything as it changes: a ball takes the short way."""
    for turns in (0.2, 0.8, 1.0, 1.3):
        along = 2.0 * np.pi * turns * np.array([2.0, -3.0, 6.0])[:, None] / 7.0
        short = rotation.shortest(along)
        assert np.linalg.norm(short) <= np.pi
        assert (
            np.abs(rotation.matrix(rotation.exponential(short)) - rotation.matrix(rotation.exponential(along))).max()
            < 1e-14
        )
        assert turns > 0.5 or (short == along).all()


def test_a_singular_neighbour_changes_nothing() -> None:
    """Matrices that are not symmetric are solved one by one where one of them is singular: the others to the bit."""
    rng = np.random.default_rng(4)
    matrix, load = rng.normal(size=(3, 5, 5)), rng.normal(size=(5, 3))
    wanted = GeneralFactor(matrix, np.ones((5, 3))).solve(load)
    matrix[1] = 0.0
    found = GeneralFactor(matrix, np.ones((5, 3))).solve(load)
    assert (found[:, [0, 2]] == wanted[:, [0, 2]]).all()
    assert (found[:, 1] == 0.0).all()
