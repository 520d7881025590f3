"""What `explain` claims is what is done: unknowns, batch shapes, skipped components, operations."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, Solution, ldl
from linkframe.framework.batched import stage
from linkframe.framework.batched.block import Block
from linkframe.framework.batched.block_factor import BlockFactor
from linkframe.framework.cache import PROGRAMS
from linkframe.framework.structure.parts import Value
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
    kept = ldl.mul

    def counting(low: Value, other: Value) -> Value:
        nonlocal counted
        product: Value = kept(low, other)
        counted += 2 * int(np.size(product))
        return product

    monkeypatch.setattr(ldl, "mul", counting)
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
    assert numbers(text, r"(\d+) constrained components are absent") != []
    assert "batch shape (), 1 entries" in text


def apart(both: bool = True) -> Frame:
    """Two cantilevers that nothing connects, both loaded."""
    frame = Frame()
    for name, y in (("a", 0.0), ("p", 5.0))[: 1 + both]:
        for i in range(4):
            frame.node(f"{name}{i}", (float(i), y + 0.3 * (i % 2), 0.2 * i))
        for i in range(3):
            frame.add(f"{name}m{i}", BAR, f"{name}{i}", f"{name}{i + 1}")
        frame.fix(f"{name}0")
        frame.load(f"{name}3", fy=1.0)
    return frame


READS: dict[str, Callable[[Solution], object]] = {
    "displacement": lambda solution: solution.displacement("a3"),
    "along": lambda solution: solution.displacement_along("am1", [0.1]),
    "end forces": lambda solution: solution.end_forces("am0"),
    "forces": lambda solution: solution.forces("am0", [0.1]),
    "stress": lambda solution: solution.stress(at=[0.1], member="am0"),
    "reaction": lambda solution: solution.reaction("a0"),
}


@pytest.mark.parametrize("read", READS)
def test_only_what_is_read_is_solved(read: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A part of the frame that nothing connects with what is read is not factorised, and is said not to be."""
    made: list[int] = []
    factorised = BlockFactor.__init__

    def counting(self: BlockFactor, block: Block, *rest: int) -> None:
        made.append(len(block.orders[0].pivots) + len(block.orders[1].pivots))
        factorised(self, block, *rest)

    monkeypatch.setattr(BlockFactor, "__init__", counting)
    PROGRAMS.clear()
    solution, alone = apart().solve(), apart(both=False).solve()
    np.testing.assert_array_equal(READS[read](solution), READS[read](alone))
    assert made == [18, 18]
    text = solution.explain()
    assert numbers(text, r"Solved: (\d+) unknowns") == [18]
    assert "Skipped: 18 unknowns (ux uy uz rx ry rz) at p1, p2, p3: nothing that was read depends on them." in text
    solution.displacement("p3")
    assert made == [18] * 3
    assert "Skipped" not in solution.explain()
    assert str(solution.status) == "regular"
    assert made == [18] * 3


def test_a_part_beside_a_mechanism_keeps_its_results() -> None:
    """Status tells of the whole frame; what hangs together with the mechanism is NaN, the rest is not."""
    frame = apart()
    frame.node("hinge", (3.0, 5.3, 0.6))
    frame.add("free", Joint(stiffness=(1e6, 1e6, 1e6, 0.0, 0.0, 0.0)), "p3", "hinge")
    frame.load("hinge", mz=1.0)
    solution = frame.solve()
    np.testing.assert_array_equal(solution.displacement("a3"), apart().solve().displacement("a3"))
    assert np.isfinite(solution.reaction("a0")).all()
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.displacement("p3")).all()
    assert str(solution.status) == "mechanism"
    assert np.isfinite(solution.displacement("a2")).all()


def test_the_reason_is_told() -> None:
    """Why the batch is solved so; that it was asked for where it was."""
    frame = apart()
    assert "Method: broadcasting LDL^T, as 36 unknowns are no more than 100." in frame.explain()
    assert "Method: broadcast, as asked for." in frame.solve("broadcast").explain()
    assert "as the stiffness varies over the batch" in four_bar(fy=1.0).explain()


def test_equal_lines_are_one() -> None:
    """Members of six kinds but one batch shape make one line; so do unknowns that nothing moves."""
    frame = apart()
    for k in range(6):
        frame.node(f"s{k}", (float(k), 9.0, 0.0))
        if k:
            bar = Beam(Rectangle(y=0.02, z=0.01 * k), Material(E=200e9, nu=0.3))
            frame.add(f"sm{k}", bar, f"s{k - 1}", f"s{k}")
    text = frame.explain()
    assert numbers(text, r"  (\d+) pieces, stiffness at batch shape \(\)\n") == [11]
    assert numbers(text, r"Skipped: (\d+) unknowns \(ux uy uz rx ry rz\) at s0, s1, s2, s3 and 2 more nodes") == [36]
    assert text.count("Skipped") == 1


def test_a_first_solution_takes_nothing_up() -> None:
    """Neither an empty frame nor one that was only explained has a last solution."""
    for frame in (Frame(), apart()):
        frame.explain()
        assert "last solution" not in frame.solve().explain()
    frame.solve().displacement("a3")
    assert "Nothing but loads has changed since the last solution" in frame.explain()


@pytest.mark.parametrize("method", ["banded", "iterative", "sparse", "broadcast"])
def test_a_frame_explains_the_method_that_is_asked_for(method: str) -> None:
    """As the solution by it does, before anything is computed; and clearances that are left out."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A")
    frame.load("B", fy=[1.0, 2.0])
    found = frame.explain(method)
    assert f"{method}, as asked for" in found
    assert f"{method}, as asked for" in frame.solve(method).explain()
    assert "as asked for" not in frame.explain()


def test_a_frame_explains_which_clearances_are_left_out() -> None:
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint((1e8, 1e8, 1e8, 1e6, 1e6, 1e6), clearance=1e-4), "B", "C")
    frame.fix("A")
    frame.load("C", fy=[1.0, 2.0])
    assert "Clearances of 1 joints are left out: pin" in frame.explain(clearance=False)
    assert "are left out" not in frame.explain()
