"""A node by another name: loaded, held, joined and asked for as by its own."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, FrameError

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3, density=7850.0))


def cantilever(root: str, tip: str) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.node("C", (1.5, 0.0, 0.0))
    frame.alias("root", "A")
    frame.alias("tip", "B")
    frame.add("AB", BEAM, root, tip)
    frame.rigid(tip, "C")
    frame.fix(root)
    frame.prescribe(root, uz=1e-3)
    frame.load(tip, fy=10.0)
    return frame


def test_both_names_mean_one_node() -> None:
    named, aliased = cantilever("A", "B"), cantilever("root", "tip")
    one, other = named.solve(), aliased.solve()
    for frame, solution in ((named, one), (aliased, other)):
        np.testing.assert_array_equal(solution.displacement("tip"), solution.displacement("B"))
        np.testing.assert_array_equal(solution.reaction("root"), solution.reaction("A"))
        for of, alias, node, component in (("displacement", "tip", "B", "uy"), ("reaction", "root", "A", "fy")):
            np.testing.assert_array_equal(solution.error_bound(alias, of), solution.error_bound(node, of))
            np.testing.assert_array_equal(solution.refined(alias, of), solution.refined(node, of))
            by_alias, by_node = (solution.sensitivity(name, component, of).loads["B"] for name in (alias, node))
            np.testing.assert_array_equal(by_alias, by_node)
        np.testing.assert_array_equal(frame.position("tip"), frame.position("B"))
        np.testing.assert_array_equal(frame.modes(1).shapes("tip"), frame.modes(1).shapes("B"))
    np.testing.assert_array_equal(one.displacement("C"), other.displacement("C"))
    assert list(aliased.nodes) == ["A", "B", "C"]


def test_all_that_is_asked_by_node_takes_both_names() -> None:
    """At large displacement, along a path, and in a motion that nothing resists."""
    frame = cantilever("A", "B")
    large, path = frame.solve(large=True), frame.path("tip", "uy", 1e-6)
    for read in (large.displacement, large.error_bound, path.displacement, frame.buckling(1).shapes):
        np.testing.assert_array_equal(read("tip"), read("B"))
    np.testing.assert_array_equal(large.reaction("root"), large.reaction("A"))
    loose = Frame()
    loose.node("A", (0.0, 0.0, 0.0))
    loose.alias("end", "A")
    loose.load("end", fx=1e300, fy=1e300)
    motion = loose.solve().free_motion()
    np.testing.assert_array_equal(motion.displacement("end"), motion.displacement("A"))
    np.testing.assert_allclose(motion.displacement("end")[0, :2], [1.0, 1.0])
    with pytest.raises(FrameError, match="node 'X' is unknown"):
        large.error_bound("X")


def test_names_are_not_given_twice() -> None:
    frame = cantilever("A", "B")
    for again in ("A", "tip"):
        with pytest.raises(FrameError, match=f"node '{again}' exists already"):
            frame.alias(again, "B")
        with pytest.raises(FrameError, match=f"node '{again}' exists already"):
            frame.node(again, (0.0, 0.0, 0.0))
    with pytest.raises(FrameError, match="node 'D' is unknown"):
        frame.alias("other", "D")
    with pytest.raises(FrameError, match="'B' is tied to itself"):
        frame.rigid("tip", "B")


def test_a_copy_keeps_its_names_to_itself() -> None:
    frame = cantilever("A", "B")
    frame.copy().alias("end", "B")
    with pytest.raises(FrameError, match="node 'end' is unknown"):
        frame.load("end", fx=1.0)
