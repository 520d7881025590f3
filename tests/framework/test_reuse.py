"""A plan is kept with its frame: other loads take it up, any other change does not; results are those of a new one."""

from __future__ import annotations

import gc
import weakref
from collections.abc import Callable, Sequence

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.batched import block_factor as block_module
from linkframe.framework.batched import unloaded as unloaded_module
from linkframe.framework.batched.broadcast import BroadcastSolver
from linkframe.framework.batched.partial_factorisation import PartialFactorisation
from linkframe.framework.cache import PROGRAMS, SOLVED
from linkframe.framework.solvers.lu import LUFactor
from linkframe.framework.solvers.sparse import SparseSolver

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3, density=7850.0))


def tower(levels: int, k: object = 1e6, bar: Beam = BAR) -> Frame:
    """A clamped mast with a compliant joint at its foot and an offset in it."""
    frame = Frame()
    frame.node("ground", (0.0, 0.0, 0.0))
    for i in range(levels + 1):
        frame.node(f"n{i}", (0.0, 0.1 * i * i, float(i)))
        if i:
            frame.add(f"m{i}", bar, f"n{i - 1}", f"n{i}")
    frame.add("foot", Joint(stiffness=np.stack([np.asarray(k, dtype=float)] * 6, axis=-1)), "ground", "n0")
    frame.fix("ground")
    frame.offset("foot", ux=1e-3)
    frame.load(f"n{levels}", fx=10.0)
    return frame


SIZES: dict[str, Callable[[], Frame]] = {
    "few": lambda: tower(4),
    "batch": lambda: tower(4, np.linspace(1e6, 2e6, 3)),
    "large": lambda: tower(60),
}


@pytest.mark.parametrize("size", SIZES)
def test_another_load(size: str) -> None:
    """A load added, a member loaded, gravity: the plan is taken up and the result is that of a frame never solved."""
    frame, fresh = SIZES[size](), SIZES[size]()
    first = frame.solve()
    before = first.displacement("n3").copy()
    for described in (frame, fresh):
        described.load("n3", fy=-4.0, mz=1.0)
        described.line_load("m2", fy=3.0)
        described.gravity((0.0, 0.0, -9.81))
    again, anew = frame.solve(), fresh.solve()
    assert again.plan.tree is first.plan.tree
    assert "used again" in again.explain()
    assert "used again" not in anew.explain()
    for node in ("n1", "n3"):
        np.testing.assert_array_equal(again.displacement(node), anew.displacement(node))
    np.testing.assert_array_equal(again.reaction("ground"), anew.reaction("ground"))
    np.testing.assert_array_equal(first.displacement("n3"), before)


def test_one_factor_for_many_loads(monkeypatch: pytest.MonkeyPatch) -> None:
    """A large frame is factorised once, however often it is loaded anew; compiled once, too."""
    made = {"factor": 0, "tree": 0}
    factorised, grown = LUFactor.__init__, unloaded_module.JointTree.of

    def counting(self: LUFactor, matrix: object) -> None:
        made["factor"] += 1
        factorised(self, matrix)  # type: ignore[arg-type]

    def growing(*given: object) -> object:
        made["tree"] += 1
        return grown(*given)  # type: ignore[arg-type]

    monkeypatch.setattr(LUFactor, "__init__", counting)
    monkeypatch.setattr(unloaded_module.JointTree, "of", growing)
    frame = tower(60)
    tips = []
    for _ in range(3):
        frame.load("n60", fy=1.0)
        tips.append(frame.solve("sparse").displacement("n60")[1])
    assert made == {"factor": 1, "tree": 1}
    np.testing.assert_allclose(np.diff(tips), tips[1] - tips[0], rtol=1e-9)


CHANGES: dict[str, Callable[[Frame], None]] = {
    "support": lambda frame: frame.fix("n2", "uy"),
    "settlement": lambda frame: frame.prescribe("ground", ux=1e-3),
    "offset": lambda frame: frame.offset("foot", ux=2e-3),
    "rigid link": lambda frame: frame.rigid("n1", "n3"),
    "joint": lambda frame: frame.add("more", Joint(stiffness=(1e3,) * 6), "ground", "n0"),
    "batch": lambda frame: frame.load("n1", fx=[1.0, 2.0]),
    "edited by hand": lambda frame: frame.supports.update(n4={0: np.zeros(())}),
}


@pytest.mark.parametrize("change", CHANGES)
def test_any_other_change(change: str) -> None:
    """What is not a load in the same batch is compiled anew."""
    frame, fresh = tower(4), tower(4)
    first = frame.solve()
    first.displacement("n4")
    for described in (frame, fresh):
        CHANGES[change](described)
    again = frame.solve()
    assert again.plan.tree is not first.plan.tree
    np.testing.assert_array_equal(again.displacement("n4"), fresh.solve().displacement("n4"))


READ: dict[str, Callable[[Frame], object]] = {
    "displacement": lambda frame: frame.solve().displacement("n3"),
    "forces": lambda frame: frame.solve().forces("m2", np.array([0.5])),
    "reaction": lambda frame: frame.solve().reaction("ground"),
    "joint": lambda frame: frame.solve().joint_force("foot"),
}


@pytest.mark.parametrize("read", READ)
def test_freed_at_once(read: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """A batch's numbers go with its frame, not when the collector of cycles comes round."""
    solvers: list[weakref.ref[BroadcastSolver]] = []
    made = BroadcastSolver.__init__

    def watched(self: BroadcastSolver, *given: object) -> None:
        solvers.append(weakref.ref(self))
        made(self, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(BroadcastSolver, "__init__", watched)
    frame = SIZES["batch"]()
    gc.collect()
    gc.disable()
    try:
        READ[read](frame)
        assert [solver() for solver in solvers] == [None]
        kept = weakref.ref(SOLVED.get(frame)[0])
        del frame
        assert kept() is None
    finally:
        gc.enable()


@pytest.mark.parametrize("method", ["banded", "sparse", "iterative"])
def test_factors_are_freed_at_once(method: str) -> None:
    """So do matrix and factor of a large frame; a plan taken up goes on with them when the first one is gone."""
    frame = tower(60)
    gc.collect()
    gc.disable()
    try:
        first = frame.solve(method=method)
        first.displacement("n3")
        kept = [weakref.ref(each) for each in (first.plan, first.solver, first.solver.factor)]  # type: ignore[union-attr]
        frame.load("n60", fx=1.0)
        del first
        again = frame.solve(method=method)
        again.displacement("n3")
        assert isinstance(again.solver, SparseSolver)
        assert again.solver.mass.shape == again.solver.stiffness.shape
        assert again.solver.motions().shape[1] == 0
        kept += [weakref.ref(each) for each in (again.plan, again.solver, again.solver.matrices)]
        assert kept[2]() is again.solver.factor
        del again, frame
        assert [each() for each in kept] == [None] * 6
    finally:
        gc.enable()


BATCHES: dict[str, Callable[[], Frame]] = {
    **{name: SIZES[name] for name in ("few", "batch")},
    "joints of a long batch": lambda: tower(4, np.linspace(1e6, 2e6, 3000)),
    "members of a long batch": lambda: tower(4, bar=Beam(BAR.section, Material(E=np.linspace(1, 2, 40000), nu=0.3))),
}


@pytest.mark.parametrize("batch", BATCHES)
def test_only_substitution_for_another_load(batch: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a factor is held, loads alone are carried through it; the same bits as of a frame never solved."""
    PROGRAMS.clear()  # batches met before have programs in place of factors
    done = 0
    factorised = PartialFactorisation.factorise

    def counting(self: PartialFactorisation, wanted: Sequence[bool], *, given: bool) -> None:
        nonlocal done
        done += 1
        factorised(self, wanted, given=given)

    monkeypatch.setattr(PartialFactorisation, "factorise", counting)
    frame, fresh = BATCHES[batch](), BATCHES[batch]()
    for described in (frame, fresh):
        described.load("n4", fy=2.0)
    assert frame.solve().status.all()
    first = done
    for described in (frame, fresh):
        described.load("n2", fy=-4.0, mz=1.0)
        described.line_load("m2", fy=3.0)
    again = frame.solve()
    found = again.displacement("n3"), again.displacement("n4"), again.reaction("ground"), again.status
    assert 0 < done == first
    shared = "what the entries share of " if batch.startswith("joints") else ""
    assert f"with {shared}the factor of the last solution" in again.explain()
    anew = fresh.solve()
    assert "with the factor" not in anew.explain()
    for mine, theirs in zip(
        found, (anew.displacement("n3"), anew.displacement("n4"), anew.reaction("ground"), anew.status), strict=True
    ):
        np.testing.assert_array_equal(mine, theirs)


def test_too_large_a_factor_is_not_held(monkeypatch: pytest.MonkeyPatch) -> None:
    """It goes with its solution, and the next one makes its own."""
    monkeypatch.setattr(block_module, "HOLD", 0)
    frame = tower(4)
    first = frame.solve().displacement("n3")
    assert not SOLVED.get(frame)[1].light
    frame.load("n4", fx=10.0)
    again = frame.solve()
    assert np.abs(again.displacement("n3") - first).max() > 1e-6
    assert "with the factor" not in again.explain()
