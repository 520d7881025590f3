"""Which way a large frame is solved: by what a factor would cost, and by how many load cases share it."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batched.plan import Plan
from linkframe.framework.solvers.load_cases import varying

BEAM = Beam(Rectangle(y=0.1, z=0.1), Material(E=200e9, nu=0.3))


def grid(nx: int, ny: int, nz: int, load: float | np.ndarray = 1e3) -> Frame:
    """A space frame on a cubic grid, fixed at its foot."""
    frame = Frame()
    places = [(i, j, k) for k in range(nz) for j in range(ny) for i in range(nx)]
    known = set(places)
    for i, j, k in places:
        frame.node(f"{i} {j} {k}", (i, j, k))
        if k == 0:
            frame.fix(f"{i} {j} {k}")
    for i, j, k in places:
        for ahead in ((i + 1, j, k), (i, j + 1, k), (i, j, k + 1)):
            if ahead in known:
                frame.add(f"{i} {j} {k} to {ahead}", BEAM, f"{i} {j} {k}", "{} {} {}".format(*ahead))
    frame.load(f"{nx - 1} {ny - 1} {nz - 1}", fx=load)
    return frame


def chosen(frame: Frame) -> tuple[str, str]:
    """Name of the method, and its reason, without solving."""
    method = frame.solve().plan.method
    return method.name, method.reason


def test_slender() -> None:
    """A tower has a narrow band."""
    name, reason = chosen(grid(3, 3, 60))
    assert name == "banded"
    assert "slender" in reason


def test_nothing_better_is_looked_for_where_a_band_is_narrow() -> None:
    """Nested dissection of a tower takes a share of what its band does, and is not better."""
    plan = grid(6, 6, 40).solve().plan
    assert plan.method.name == "banded"
    assert "dissection" not in vars(plan.graph)
    factor = plan.graph.dissection
    assert factor.operations > len(plan.unknowns) * plan.graph.width**2


def test_cube() -> None:
    """A factor of a cube fills up: a few load cases are iterated."""
    name, reason = chosen(grid(16, 16, 16))
    assert name == "iterative"
    assert "operations" in reason


def test_cube_of_many_load_cases(monkeypatch: pytest.MonkeyPatch) -> None:
    """A factor serves them all, with or without CHOLMOD; those of one load in many sizes are one or two."""
    assert chosen(grid(16, 16, 16, np.arange(100.0)))[0] == "iterative"
    many = grid(16, 16, 16)
    for k in range(100):
        many.load(f"{k % 16} {k // 16} 15", fz=np.sin(k + np.arange(120.0)))
    assert chosen(many)[0] in {"cholesky", "banded"}
    monkeypatch.setattr("linkframe.framework.solvers.method.find_spec", lambda name: None)
    assert chosen(many.copy())[0] == "banded"


def test_varying_stiffness() -> None:
    """A few entries of a frame of some size have a band each; many of a small one that moves are broadcast."""
    frame = grid(3, 3, 4)
    frame.node("end", (2.0, 2.0, 3.0))
    frame.add("joint", Joint(stiffness=np.array([[1e3] * 6, [1e4] * 6])), "2 2 3", "end")
    frame.load("end", fx=1.0)
    name, reason = chosen(frame)
    assert name == "banded"
    assert "varies" in reason
    small = Frame()
    small.node("0", (0.0, 0.0, 0.0))
    beam = Beam(Rectangle(y=0.1, z=0.1), Material(E=np.linspace(1e11, 2e11, 5000), nu=0.3))
    for k in range(1, 11):
        small.node(f"{k}", np.linspace(0.9, 1.1, 5000)[:, None] * [float(k), 0.1 * k * k, 0.0])
        small.add(f"m{k}", beam, f"{k - 1}", f"{k}")
    small.fix("0")
    small.load("10", fy=1.0)
    name, reason = chosen(small)
    assert name == "broadcast"
    assert "varies" in reason


@pytest.mark.parametrize("method", ["broadcast", "banded", "sparse", "iterative"])
def test_smallest(method: str) -> None:
    """No unknown, or no load, is no special case."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BEAM, "A", "B")
    frame.fix("A")
    free = frame.copy()
    frame.fix("B")
    frame.load("B", fx=1.0)
    np.testing.assert_array_equal(frame.solve(method).displacement("B"), np.zeros(6))
    np.testing.assert_array_equal(frame.solve(method).reaction("B"), [-1.0, 0.0, 0.0, 0.0, 0.0, 0.0])
    np.testing.assert_array_equal(free.solve(method).displacement("B"), np.zeros(6))


@pytest.mark.parametrize("varying", ["modulus", "load"])
@pytest.mark.parametrize("method", ["broadcast", "banded", None])
def test_smallest_batch(method: str | None, varying: str) -> None:
    """Nor is it in a batch."""
    modulus, load = ([1e11, 2e11], 1.0) if varying == "modulus" else (1e11, [1.0, 2.0])
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=0.1, z=0.1), Material(E=modulus, nu=0.3)), "A", "B")
    frame.fix("A")
    frame.fix("B")
    frame.load("B", fx=load)
    np.testing.assert_array_equal(frame.solve(method).displacement("B"), np.zeros((2, 6)))
    np.testing.assert_array_equal(frame.solve(method).reaction("B")[:, 0], -np.broadcast_to(load, 2))


def test_loads_that_vary_alike_are_one_load_case() -> None:
    """Wherever they act: the solution is linear in each different array once."""
    along, across = np.linspace(1.0, 2.0, 50), np.linspace(3.0, 7.0, 50) ** 2

    def cases(*loads: np.ndarray) -> int:
        frame = grid(3, 3, 4)
        for node, load in zip(("2 2 3", "1 1 3", "0 1 3"), loads, strict=False):
            frame.load(node, fx=load)
        return len(varying(Plan(frame)))

    assert cases(along, across) == cases(along) + 1
    assert cases(along, across, along) == cases(along, across)
