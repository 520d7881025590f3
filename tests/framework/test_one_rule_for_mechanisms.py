"""What is told of frames that can move does not depend on the solver, nor on the size of the load."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, Solution
from numpy.testing import assert_allclose, assert_array_equal

INF = float("inf")
PLACES = np.array([(0.3, -0.2, 0.1), (1.1, 0.6, -0.4), (1.7, -0.3, 0.8), (0.4, 1.2, 0.9), (-0.8, 0.2, 1.5)])
CONSISTENT = "statically consistent mechanism"


def chain(joints: list[tuple[float, ...]], force: object, *, both_ends: bool, at: str = "b0") -> Frame:
    """Bars from place to place with a joint between each and the next, loaded at a node."""
    frame, bar = Frame(), Beam(Rectangle(y=0.02, z=0.02), Material(E=200e9, nu=0.3))
    for k in range(len(joints) + 1):
        for name, place in ((f"a{k}", PLACES[k]), (f"b{k}", PLACES[k + 1])):
            frame.node(name, place)
        frame.add(f"bar {k}", bar, f"a{k}", f"b{k}")
    for k, stiffness in enumerate(joints):
        frame.add(f"joint {k}", Joint(stiffness=stiffness), f"b{k}", f"a{k + 1}")
    frame.fix("a0")
    if both_ends:
        frame.fix(f"b{len(joints)}")
    size = np.asarray(force)
    frame.load(at, fx=0.57 * size, fy=1.18 * size, fz=0.13 * size)
    return frame


def told(frame: Frame, method: str | None) -> Solution:
    """The solution by a method, without what it warns of."""
    return frame.solve().silenced() if method is None else frame.solve(method=method).silenced()


SOFT_IN_A_TREE = [(0.0, 1e9, 1e-20, INF, 1e9, 0.0)]


def test_every_method_tells_the_same_of_a_soft_spring() -> None:
    """A soft spring that bears nothing, beside a free component: status, NaN and numbers."""
    first = told(chain(SOFT_IN_A_TREE, 1.0, both_ends=False), None)
    for method in ("banded", "broadcast"):
        other = told(chain(SOFT_IN_A_TREE, 1.0, both_ends=False), method)
        assert other.status == first.status == CONSISTENT
        for node in ("b0", "a1"):
            assert_allclose(other.displacement(node), first.displacement(node), rtol=1e-10, atol=1e-15)
        assert_allclose(other.joint_force("joint 0"), first.joint_force("joint 0"), atol=1e-12)
    assert_array_equal(np.isnan(first.displacement("a1")), [True, False, False, False, False, True])


@pytest.mark.parametrize("soft", [1e-20, 1e-12, 1e-10])
def test_what_is_all_but_free_and_not_driven_leaves_forces_that_hold(soft: float) -> None:
    """A loop that one soft spring closes: forces as with a firmer one, displacements but along that spring."""

    def loop(closing: float) -> Solution:
        joints = [(1e9, 0.0, INF, INF, 1e9, 1e4), (INF,) * 5 + (0.0,), (1e5, closing, INF, INF, INF, 1e4)]
        return told(chain(joints, 1.0, both_ends=True), "broadcast")

    almost, firm = loop(soft), loop(1.0)
    assert (almost.status, firm.status) == (CONSISTENT, "regular")
    for joint in ("joint 0", "joint 1", "joint 2"):
        assert_allclose(almost.joint_force(joint), firm.joint_force(joint), atol=1e-11)
    found, along = almost.displacement("a1"), np.arange(6) == 1
    assert_array_equal(np.isnan(found), along)
    assert_allclose(found[~along], firm.displacement("a1")[~along], rtol=1e-9, atol=1e-14)


@pytest.mark.parametrize("method", [None, "banded", "broadcast"])
def test_load_cases_of_a_mechanism(method: str | None) -> None:
    """A load case of zero leaves all at rest, beside others and alone; one of 1e-289 is told as one of one newton."""
    joints = [(1e9, 1e5, 1e9, 1e5, INF, 1e4), (INF, INF, INF, 1e9, INF, 0.0)]
    sizes = np.array([1.0, 0.0, 2.0**-960])
    both = told(chain(joints, sizes, both_ends=False, at="b1"), method)
    alone = [told(chain(joints, size, both_ends=False, at="b1"), method) for size in sizes]
    assert_array_equal(both.status, [each.status for each in alone])
    assert both.status[2] == both.status[0]
    for node in ("b0", "b1", "b2"):
        found = both.displacement(node)
        assert_array_equal(np.isnan(found[1]), False)
        assert_allclose(found[2] / sizes[2], found[0], rtol=1e-9, atol=1e-15)
