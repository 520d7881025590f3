"""What `explain` claims is what is done: unknowns, batch shapes, skipped components, operations."""

from __future__ import annotations

import re

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batched import stage
from linkframe.framework.structure.parts import Parts, Value
from linkframe.models import FourBar

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
THETA = np.radians([[20.0], [50.0], [80.0]])
STIFFNESS = np.stack([np.linspace(1e8, 2e8, 5)] * 5 + [np.zeros(5)], axis=-1)


def four_bar(**load: float) -> Frame:
    """Three poses by five stiffnesses."""
    frame = FourBar(stiffness=STIFFNESS).move(THETA).frame()
    frame.load("P", **load)
    return frame


def numbers(text: str, pattern: str) -> list[int]:
    """All integers that `pattern` finds."""
    return [int(found) for found in re.findall(pattern, text)]


def test_plane_load_solves_half() -> None:
    """A load in the plane reaches ux, uy, rz; across it the other half; both loads, all. Skipping changes no result."""
    plane, across, both = (four_bar(**load) for load in ({"fy": 1.0}, {"fz": 1.0}, {"fy": 1.0, "fz": 1.0}))
    half = numbers(plane.explain(), r"Solved: (\d+) unknowns \(ux uy rz\)")
    rest = numbers(across.explain(), r"Solved: (\d+) unknowns \(uz rx ry\)")
    assert half == numbers(across.explain(), r"Skipped: (\d+) unknowns \(ux uy rz\)")
    assert rest == numbers(plane.explain(), r"Skipped: (\d+) unknowns \(uz rx ry\)")
    assert "Skipped" not in both.explain()
    assert half[0] + rest[0] == len(both.solve().plan.unknowns)
    one, other = plane.solve(), both.solve()
    np.testing.assert_array_equal(one.displacement("P")[..., [0, 1, 5]], other.displacement("P")[..., [0, 1, 5]])
    assert list(one.solver._factors) == sorted(one.plan.excited)  # type: ignore[union-attr]


def test_batch_shapes() -> None:
    """What varies with nothing, the pose, the sample: the interior of the links once, the springs last."""
    text = four_bar(fy=1.0).explain()
    assert "batch shape (3, 5), 15 entries" in text
    assert numbers(text, r"condensed: pivots (\d+) at \(1, 1\)") == [3]
    assert numbers(text, r"at the joints: pivots (\d+) at \(3, 1\), \d+ at \(3, 5\)") == [9]
    assert numbers(text, r"(\d+) at \(3, 5\)") == [6]


def test_operations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Operations are counted as they are done: in each column its products, then a product and a difference a pair."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", np.stack([np.linspace(1.0, 2.0, 7), np.ones(7), np.zeros(7)], axis=-1))
    frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3), segments=6), "A", "B")
    frame.fix("A")
    frame.load("B", fy=1.0)
    plan = frame.solve().plan
    (name,) = plan.excited
    block = plan.block(name)
    order = block.orders[0]
    counted = 0
    kept = stage.subtract

    def counting(parts: Parts, mask: int, value: Value) -> None:
        nonlocal counted
        counted += 2 * int(np.size(value))
        kept(parts, mask, value)

    monkeypatch.setattr(stage, "subtract", counting)
    scale = {i: dict(row[i]) for i, row in block.matrix.items()}
    stage.Stage(block.matrix, scale=scale).mapped(lambda value: value).eliminate(order, [True] * len(plan.grid.sizes))
    columns = sum(plan.grid.sizes[order.masks[k]] * len(order.below[k]) for k in order.pivots)
    assert order.operations(plan.grid) == counted + columns
    assert str(order.operations(plan.grid)) in frame.explain()


def test_times() -> None:
    """Before anything is read nothing is timed but the description; afterwards each stage is."""
    solution = four_bar(fy=1.0).solve()
    before = solution.explain()
    assert "solution" not in before.splitlines()[-1]
    solution.displacement("P")
    after = solution.explain().splitlines()[-1]
    for told in ("numbering", "assembly", "elimination order", "factorisation", "solution"):
        assert told in after


def test_closed_loops_are_told() -> None:
    """Two ideal pins in a row of supports: held components that close a loop are eliminated, and said to be."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.rigid("B", "C")
    frame.fix("A")
    frame.fix("C", "uy")
    frame.load("B", fy=1.0)
    text = frame.explain()
    assert numbers(text, r"(\d+) held components are absent") != []
    assert "batch shape (), 1 entries" in text
