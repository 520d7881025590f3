"""What is known already is not done again."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle, Section
from linkframe.framework import Frame
from linkframe.framework.solvers.iterative import Iterative
from linkframe.framework.solvers.sparse import SparseSolver
from linkframe.framework.structure.topology import Topology

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


def bracket(tip: object = (1.0, 0.5, 0.2), load: object = 3.0, body: bool = False) -> Frame:
    """Two bars at a joint, and a third between places of their own; in a batch where `load` or `tip` is one."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    if body:
        frame.body("arm", origin=(1.0, 0.0, 0.0), axes=np.eye(3)[[1, 2, 0]])
        frame.node("C", (0.0, 0.0, 0.0), body="arm")
    else:
        frame.node("C", (1.0, 0.0, 0.0))
    frame.node("D", tip)
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e5, 1e5, 50.0)), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.add("AD", BAR, "A", "D")
    frame.fix("A")
    frame.load("D", fy=load)
    return frame


PLACES = [(1.1, 0.5, 0.2), (1.0, 0.7, 0.0), (0.9, 0.4, -0.3)]


@pytest.mark.parametrize("body", [False, True])
@pytest.mark.parametrize("load", [3.0, [1.0, 2.0]])
def test_nodes_that_move_give_the_bits_of_a_new_frame(body: bool, load: object) -> None:
    frame = bracket(load=load, body=body)
    frame.solve().displacement("D")
    for place in [*PLACES, np.array([(1.0, 0.5, 0.2), (1.2, 0.5, 0.1)])]:
        if np.ndim(place) == 2 and np.ndim(load) == 0:
            continue  # the batch widens, and with it what is gathered
        frame.change("D", place)
        anew = bracket(place, load, body)
        for name in ("displacement", "reaction"):
            asked = "D" if name == "displacement" else "A"
            np.testing.assert_array_equal(getattr(frame.solve(), name)(asked), getattr(anew.solve(), name)(asked))
        np.testing.assert_array_equal(frame.solve().end_forces("AD"), anew.solve().end_forces("AD"))


def test_nodes_that_move_leave_members_gathered_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    frame = bracket()
    frame.solve().displacement("D")

    def anew(*_: object, **__: object) -> Topology:
        raise AssertionError("members were numbered again")

    monkeypatch.setattr(Topology, "of", anew)
    for place in PLACES:
        frame.change("D", place)
        assert np.isfinite(frame.solve().displacement("D")).all()
    frame.change("AD", Beam(Rectangle(y=0.03, z=0.01), Material(E=200e9, nu=0.3)))
    with pytest.raises(AssertionError, match="numbered again"):
        frame.solve()


def test_least_eigenvalue_is_confirmed_from_the_motion_that_was_found() -> None:
    """Of a load along the softest motion the answer is that motion by its eigenvalue: fewer steps are left."""
    size = 6
    frame = Frame()
    grid = np.stack(np.meshgrid(*[np.arange(size)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    numbers = np.arange(size**3).reshape((size,) * 3)
    frame.add_nodes(len(grid), grid + 0.1 * np.random.default_rng(0).random(grid.shape))
    beam = Beam(Section(A=1e-2, Iy=1e-5, Iz=2e-5, J=2e-5), Material(E=2e11, nu=0.3))
    for k in range(3):
        first, last = np.take(numbers, range(size - 1), k), np.take(numbers, range(1, size), k)
        frame.add_many(beam, np.stack([first.ravel(), last.ravel()], axis=-1), [f"{k}.{j}" for j in range(first.size)])
    frame.fix_many([str(k) for k in numbers[:, :, 0].ravel()])
    frame.load("215", fx=1e3)
    solution = frame.solve("iterative")
    solution.displacement("215")
    assert isinstance(solution.solver, SparseSolver)
    (factor,) = [each for each in solution.solver.matrix.factors.values() if isinstance(each, Iterative)]
    soft = factor.soft()[0][:, :1]
    before = factor.iterations
    found = factor.roughly(soft)
    assert found is not None
    assert np.linalg.norm(soft - factor.scaled @ found) <= 1e-2 * np.linalg.norm(soft)
    between = factor.iterations
    factor._descend(soft[:, 0], lambda _: 1e-2 * float(np.linalg.norm(soft)))
    assert between - before < 0.8 * (factor.iterations - between)
