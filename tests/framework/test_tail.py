"""What is left to the chunks: couplings that are nothing, products over blocks, chunks that fit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from linkframe.elements import Joint
from linkframe.framework import Frame
from linkframe.framework.batch import Array
from linkframe.framework.batched.block_factor import BlockFactor
from linkframe.framework.batched.chunks import CHUNK, FEWEST, steps
from linkframe.framework.batched.order import Order
from linkframe.framework.program.combination import BLOCK, Combination
from linkframe.framework.structure.parts import Grid
from linkframe.models import FourBar

THETA = np.radians(np.linspace(15.0, 165.0, 11))[:, None]
SPRINGS = np.linspace(1e8, 3e8, 200)
RNG = np.random.default_rng(4)


def linkage(stay: float, theta: Array = THETA, springs: Array = SPRINGS) -> Frame:
    """The four-bar loaded in its plane; a second, elastic ground joint makes its forces depend on the stiffness."""
    frame = FourBar(stiffness=np.stack([springs] * 5 + [0.0 * springs], axis=-1)).move(theta).frame()
    if stay:
        frame.node("held", frame.position("P"))
        frame.add("stay", Joint(stiffness=(stay, stay, 0.0, 0.0, 0.0, 0.0)), "held", "P")
        frame.fix("held")
    frame.load("P", fy=100.0)
    return frame


def couplings(frame: Frame) -> int:
    """Entries off the diagonal that are left to the chunks."""
    plan = frame.solve().plan
    return sum(len(row) - 1 for name in plan.excited for row in BlockFactor(plan.block(name))._rest.matrix)


def test_springs_of_a_determinate_linkage_do_not_meet() -> None:
    """Forces follow from equilibrium alone, so springs stand for themselves; not so where P is held too."""
    assert couplings(linkage(0.0)) == 0
    assert couplings(linkage(1.0)) > 0
    solution = linkage(0.0).solve()
    assert "less than rounding" not in solution.explain()
    solution.displacement("P")
    assert "15 couplings turned out to be less than rounding" in solution.explain()


@pytest.mark.parametrize("stay", [0.0, 1.0, 1e6, 1e12])
def test_as_one_by_one(stay: float) -> None:
    """Entries of the batch are the same frames solved alone, where nothing is left out."""
    whole = linkage(stay).solve().displacement("P")
    for pose, sample in ((0, 0), (4, 77), (10, 199)):
        alone = linkage(stay, THETA[pose, 0], SPRINGS[sample]).solve().displacement("P")
        np.testing.assert_allclose(whole[pose, sample], alone, rtol=0.0, atol=1e-13 * np.abs(alone).max())


def watched(frame: Frame) -> tuple[float, float]:
    """Least ratio of a pivot to its scale: as it is bounded beforehand, and as it comes out where it is watched."""
    plan = frame.solve().plan
    factors = [BlockFactor(plan.block(name)) for name in plan.excited]
    before = min(factor._rest.pivot_ratio for factor in factors)
    for factor in factors:
        factor.__dict__["_rest"] = replace(factor._rest, pivot_ratio=0.0)
        factor.pivot_ratio()
    return before, float(min(np.min(np.asarray(factor._least)) for factor in factors))


def test_margin_beforehand() -> None:
    """Where stiff springs stand alone on the diagonal, pivots are bounded without being watched, from below."""
    before, found = watched(linkage(1.0))
    assert 0.0 < before <= found
    before, found = watched(linkage(1.0, springs=1e-9 * SPRINGS))
    assert before == 0.0
    assert found < 0.5


@pytest.mark.parametrize("shape", [(3, 700), (700,), (2, 3, 20), (5, 4)])
@pytest.mark.parametrize("share", [0.1, 0.9])
def test_combination(shape: tuple[int, ...], share: float) -> None:
    """Sums of products as NumPy's einsum has them, with and without the matrix; in parts the same bits."""
    leading = (*shape[:-1], 1)
    rows = [{k: RNG.normal(size=leading) for k in range(7) if RNG.random() < share} for _ in range(4)]
    numbers = RNG.normal(size=(*shape[:-1], 7, shape[-1]))
    combination = Combination.of(rows, {k: k for k in range(7)}, shape)
    full = np.zeros((*shape[:-1], 4, 7))
    for i, row in enumerate(rows):
        for k, factor in row.items():
            full[..., i, k] = factor[..., 0]
    out = np.empty((*shape[:-1], 4, shape[-1]))
    combination.times(numbers, out)
    np.testing.assert_allclose(out, np.einsum("...ik,...kn->...in", full, numbers), rtol=1e-13, atol=1e-14)
    for axis, n in enumerate(shape):
        step = BLOCK if axis == len(shape) - 1 else 1
        for start in range(0, n, step):
            indices = slice(start, start + step)
            at = (..., indices) if axis == len(shape) - 1 else (slice(None),) * axis + (indices,)
            part = np.empty_like(out[at])
            combination.cut(axis, indices).times(numbers[at], part)
            np.testing.assert_array_equal(part, out[at])


def test_long_eliminations_take_short_chunks() -> None:
    """What is held for a chunk stays below a bound, whatever the size of the mechanism."""

    def chunk(unknowns: int) -> int:
        order = Order(list(range(unknowns)), {k: [0] * 12 for k in range(unknowns)}, dict.fromkeys(range(unknowns), 3))
        axis, step = steps(Grid((300, 1000)), (order,))
        return step * (1000 if axis == 0 else 300)

    assert CHUNK // 2 < chunk(10) <= CHUNK
    assert FEWEST // 2 <= chunk(1000) < 2 * FEWEST
