"""The elimination order: linear in the length of chains, by batch shape where that is cheaper."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batched import order as module
from linkframe.framework.batched.order import Masks, Order, Pattern, in_turn, link, order, two_stages
from linkframe.framework.cache import ORDERS
from linkframe.framework.structure.parts import Grid

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
POSE, SAMPLE = 1, 2


def chain(links: int, samples: int) -> Frame:
    """A clamped zigzag of links, all its joints' stiffness varying with the sample."""
    frame = Frame()
    joint = Joint(stiffness=1e6 * np.linspace(1.0, 2.0, samples)[:, None] * np.ones(6))
    for k in range(links):
        for end in (0, 1):
            frame.node(f"{k}.{end}", (float(k + end), 0.3 * ((k + end) % 2), 0.0))
        frame.add(f"link {k}", BAR, f"{k}.0", f"{k}.1")
        if k:
            frame.add(f"joint {k}", joint, f"{k - 1}.1", f"{k}.0")
    frame.fix("0.0")
    frame.load(f"{links - 1}.1", fy=1.0, fz=1.0)
    return frame


def orders(frame: Frame) -> list[Order]:
    """Orders of all that the load reaches."""
    plan = frame.solve().plan
    return [each for name in plan.excited for each in plan.block(name).orders]


@pytest.mark.parametrize("samples", [1, 3, 1000])
def test_chain_is_linear(samples: int) -> None:
    """Operations a link hardly grow with the number of links, however many samples share it, nor does any column."""
    grid = Grid((samples,))
    each = {n: orders(chain(n, samples)) for n in (20, 40, 80)}
    operations = {n: sum(one.operations(grid) for one in found) / n for n, found in each.items()}
    assert operations[80] < 1.1 * operations[40] < 1.1**2 * operations[20]
    assert max(len(below) for one in each[80] for below in one.below.values()) <= 18


def test_batch_shape_first_where_that_is_cheaper() -> None:
    """A star whose centre varies with nothing, its arms with the sample: the centre goes first, and fills the arms."""
    grid = Grid((1, 50))
    pattern: Pattern = {}
    link(pattern, 0, 0, 0)
    for arm in (1, 2):
        link(pattern, 0, arm, 0)
        link(pattern, arm, arm, SAMPLE)
    found = order(pattern, [0, 1, 2], grid)
    assert [found.masks[k] for k in found.pivots] == [0, SAMPLE, SAMPLE]
    assert found.operations(grid) == 8 + 50 * 3


def test_cheapest_of_all_orders() -> None:
    """Of random small patterns the order is never dearer than by batch shape, and near the best of many at random."""
    rng = np.random.default_rng(3)
    grid = Grid((4, 50))
    for _ in range(20):
        pairs = [(i, j) for i in range(8) for j in range(i) if rng.random() < 0.35]
        kinds = {i: int(rng.choice([0, POSE, SAMPLE, POSE | SAMPLE])) for i in range(8)}

        def pattern(pairs: list[tuple[int, int]] = pairs, kinds: dict[int, int] = kinds) -> Pattern:
            made: Pattern = {}
            for k, mask in kinds.items():
                link(made, k, k, mask)
            for i, j in pairs:
                link(made, i, j, 0)
            return made

        best = min(_operations(pattern(), rng.permutation(8).tolist(), grid) for _ in range(200))
        assert order(pattern(), range(8), grid).operations(grid) <= 1.15 * best


def _operations(pattern: Pattern, pivots: list[int], grid: Grid) -> int:
    """Operations of the elimination in a given order."""
    return sum(order(pattern, [k], grid).operations(grid) for k in pivots)


def test_orders_are_kept_apart_by_all_that_they_depend_on() -> None:
    """What was found for one batch, pattern, choice of unknowns, substitution or spring is not taken for another."""

    def chained(count: int, mask: int) -> Pattern:
        pattern: Pattern = {}
        for k in range(count):
            link(pattern, k, k, POSE if k % 2 else SAMPLE)
            link(pattern, k, max(k - 1, 0), mask)
        return pattern

    rows = {0: {7: 0}, 1: {7: 0, 8: 0}, 2: {8: 0}, 3: {8: 0, 9: 0}}
    given = {
        "first": ((3, 50), 4, 0, [0, 1], [7, 8, 9], rows, [({9: 0}, 0)]),
        "batch": ((50, 3), 4, 0, [0, 1], [7, 8, 9], rows, [({9: 0}, 0)]),
        "pattern": ((3, 50), 4, SAMPLE, [0, 1], [7, 8, 9], rows, [({9: 0}, 0)]),
        "inner": ((3, 50), 4, 0, [1], [7, 8, 9], rows, [({9: 0}, 0)]),
        "left": ((3, 50), 4, 0, [0, 1], [7, 8, 9, 10], rows, [({9: 0}, 0)]),
        "substitution": ((3, 50), 4, 0, [0, 1], [7, 8, 9], rows | {3: {7: POSE, 9: 0}}, [({9: 0}, 0)]),
        "spring": ((3, 50), 4, 0, [0, 1], [7, 8, 9], rows, [({7: SAMPLE, 9: 0}, SAMPLE)]),
        "what the spring varies over": ((3, 50), 4, 0, [0, 1], [7, 8, 9], rows, [({9: 0}, SAMPLE)]),
    }

    def found(name: str) -> list[tuple[object, ...]]:
        sizes, count, mask, inner, left, of_rows, springs = given[name]
        both = two_stages(Grid(sizes), chained(count, mask), inner, left, Masks(of_rows, springs))
        return [(each.pivots, each.below, each.masks) for each in both]

    alone = {}
    for name in given:
        ORDERS.clear()
        alone[name] = found(name)
    ORDERS.clear()
    for name, expected in alone.items():
        assert found(name) == expected, name
    assert len({str(each) for each in alone.values()}) == len(given)


def test_fill_varies_as_what_it_comes_from() -> None:
    """The entry between the neighbours of an unknown that couples one of them constantly and one by the pose."""
    pattern: Pattern = {}
    for i, j, mask in ((0, 0, 0), (1, 1, 0), (2, 2, 0), (0, 1, 0), (0, 2, POSE)):
        link(pattern, i, j, mask)
    assert in_turn(pattern, range(3)) == Order([0, 1, 2], {0: [1, 2], 1: [2], 2: []}, dict.fromkeys(range(3), POSE))
    assert not any(pattern.values())


@pytest.mark.parametrize("bits", [0, module._BITS])
def test_cost_of_a_pivot_by_counting(bits: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Operations on its column over the entries of its masks, and two over all for each pair that it couples anew."""
    monkeypatch.setattr(module, "_BITS", bits)
    rng, grid = np.random.default_rng(0), Grid((3, 4))
    pattern: Pattern = {}
    for k in range(12):
        link(pattern, 5 * k, 5 * k, int(rng.integers(4)))
    for i, j in rng.integers(12, size=(20, 2)).tolist():
        link(pattern, 5 * i, 5 * j, int(rng.integers(4)))
    of_pivot, counted = module._ByCost.key, 0

    def key(by: module._ByCost, k: int) -> tuple[int, int, int]:
        nonlocal counted
        row, found = pattern[k], of_pivot(by, k)
        others, size = [i for i in row if i != k], max(grid.sizes[m | n] for m in row.values() for n in row.values())
        apart = sum(j not in pattern[i] for a, i in enumerate(others) for j in others[:a])
        assert found == (size * len(others) * (len(others) + 3) + 24 * apart, len(others), k)
        counted += apart
        return found

    monkeypatch.setattr(module._ByCost, "key", key)
    order(pattern, list(pattern), grid)
    assert counted > 20
