"""The broadcasting elimination: the same bits however it is cut, shared work done once, nothing computed unasked."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batched.block_factor import BlockFactor
from linkframe.framework.batched.broadcast import BroadcastSolver
from linkframe.framework.solution import Solution
from linkframe.models import FourBar

SAMPLES = 137
RNG = np.random.default_rng(5)
THETA = np.radians(np.linspace(15.0, 165.0, 11))[:, None]
SPRINGS = 1e8 * (1.0 + 0.05 * RNG.standard_normal(SAMPLES))
FORCE = 100.0 + 5.0 * RNG.standard_normal(SAMPLES)
SECTION = Rectangle(y=12.7e-3, z=6.35e-3)


def joints_vary() -> Frame:
    """Poses by samples of joint stiffness, clearance and load: only the joints vary with the sample."""
    frame = FourBar(stiffness=np.stack([SPRINGS] * 5 + [0.0 * SPRINGS], axis=-1)).move(THETA).frame()
    frame.load("P", fy=FORCE, fz=1.0)
    frame.offset("B", ux=1e-3 * np.cos(FORCE), uy=1e-3 * np.sin(FORCE))
    return frame


def links_vary() -> Frame:
    """The links' modulus varies with the sample: their interior does too."""
    beam = Beam(SECTION, Material(E=2e9 * SPRINGS / 1e8, nu=0.3))
    frame = FourBar(beam=beam).move(THETA).frame()
    frame.load("P", fy=FORCE)
    frame.offset("D", ux=1e-4)
    return frame


def loads_vary() -> Frame:
    """One stiffness a pose, a load a sample and a pose."""
    frame = FourBar().move(THETA).frame()
    frame.load("P", fy=FORCE * np.cos(THETA), mz=FORCE)
    frame.gravity((0.0, -9.81, 0.0))
    return frame


def one_axis() -> Frame:
    """One pose: the only axis is both the one that is cut and the one along which products are made."""
    k = 1e8 * (1.0 + 0.05 * np.random.default_rng(6).standard_normal(1500))
    frame = FourBar(stiffness=np.stack([k] * 5 + [0.0 * k], axis=-1)).move(0.7).frame()
    frame.load("P", fy=k / 1e6, fz=1.0)
    frame.offset("B", ux=1e-12 * k)
    return frame


def samples_first() -> Frame:
    """Samples by poses: factors vary along the last axis."""
    frame = FourBar(stiffness=np.stack([SPRINGS] * 5 + [0.0 * SPRINGS], axis=-1)[:, None]).move(THETA[:, 0]).frame()
    frame.load("P", fy=FORCE[:, None], fz=1.0)
    frame.offset("B", ux=1e-6 * FORCE[:, None])
    return frame


CASES = {
    "joints": joints_vary,
    "links": links_vary,
    "loads": loads_vary,
    "one axis": one_axis,
    "samples first": samples_first,
}


def factors(solution: Solution, chunk: int, workers: int) -> list[BlockFactor]:
    """The excited components of a solution, factorised with this chunk and number of threads."""
    return [BlockFactor(solution.plan.block(name), chunk, workers) for name in sorted(solution.plan.excited)]


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize(("chunk", "workers"), [(1, 1), (50, 1), (64, 2), (10**6, 3)])
def test_same_bits(case: str, chunk: int, workers: int) -> None:
    """Displacements and margins do not depend on chunk size or threads, not in the last bit."""
    solution = CASES[case]().solve()
    for one, other in zip(factors(solution, 100, 1), factors(solution, chunk, workers), strict=True):
        rows = [{k: 1.0} for order in one.block.orders for k in order.pivots]
        for mine, theirs in zip(one.values(rows), other.values(rows), strict=True):
            np.testing.assert_array_equal(np.asarray(mine), np.asarray(theirs))
        np.testing.assert_array_equal(one.pivot_ratio(), other.pivot_ratio())


@pytest.mark.parametrize("case", CASES)
def test_again(case: str) -> None:
    """Asked again, the kept factors give the same."""
    solution = CASES[case]().solve()
    for factor in factors(solution, 64, 2):
        row = {factor.block.orders[1].pivots[0]: 1.0}
        first, second, third = (np.asarray(factor.values([row])[0]) for _ in range(3))
        np.testing.assert_array_equal(first, second)
        np.testing.assert_array_equal(first, third)


def test_only_the_joints_are_left_to_the_chunks() -> None:
    """Where only springs vary with the sample, all but their own unknowns are eliminated before the chunks."""
    solution = joints_vary().solve()
    for factor in factors(solution, 64, 1):
        left = set(factor.block.orders[1].pivots) - set(factor.shared.outer.pivots)
        sprung = {k for row, _ in factor.block.springs for k in row}
        assert left == sprung
        assert factor.shared.inner.complete
        assert factor.shared.outer.complete


def test_nothing_before_it_is_read() -> None:
    """Solving factorises nothing; a displacement only the components that its load reaches."""
    frame = FourBar().move(THETA).frame()
    frame.load("P", fy=1.0)
    solution = frame.solve()
    assert "solver" not in vars(solution.primary)
    assert "matrix" not in vars(solution.plan)
    solution.displacement("P")
    assert isinstance(solution.solver, BroadcastSolver)
    assert set(solution.solver._factors) == solution.plan.excited != solution.plan.components
