"""Batches in bands in which no load reaches anything that moves."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material
from linkframe.framework import Frame


@pytest.mark.parametrize("method", [None, "banded", "broadcast"])
@pytest.mark.parametrize("force", [0.0, 3.0])
def test_what_no_load_reaches_rests(method: str | None, force: float) -> None:
    frame = Frame()
    rod = Beam(Circle(diameter=0.02), Material(E=np.linspace(1e11, 2e11, 1000), nu=0.3))
    for k in range(3):
        frame.node(f"N{k}", (k, 0.1 * (k % 2), 0.0))
    for k in range(2):
        frame.add(f"M{k}", rod, f"N{k}", f"N{k + 1}")
    frame.fix("N0")
    if force:
        frame.load("N0", fx=force)
    solution = frame.solve(method)
    assert (solution.status == "regular").all()
    assert (solution.displacement("N2") == 0.0).all()
    assert (solution.error_bound("N2") == 0.0).all()
    assert (solution.end_forces("M1") == 0.0).all()
    assert (solution.reaction("N0") == np.array([-force, 0.0, 0.0, 0.0, 0.0, 0.0])).all()


def test_what_no_load_reaches_may_be_singular() -> None:
    """What stands loose beside it is a mechanism for itself."""
    frame = Frame()
    rod = Beam(Circle(diameter=0.02), Material(E=np.linspace(1e11, 2e11, 50), nu=0.3))
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (0, 1, 0), "D": (1, 1, 0)}.items():
        frame.node(name, place)
    frame.add("AB", rod, "A", "B")
    frame.add("CD", rod, "C", "D")
    frame.fix("A")
    each = [frame.solve(method) for method in ("banded", "broadcast")]
    assert (each[0].status == each[1].status).all()
    assert np.array_equal(each[0].displacement("D"), each[1].displacement("D"), equal_nan=True)
