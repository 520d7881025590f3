"""Journals that no force presses: rounding, which differs from batch to batch, does not tell where they rest."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, Solution
from linkframe.framework.clearances.ball_qp import minimise_in_balls
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
FORCE = [3.0, 0.0, 10.0]

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


def two_links(seed: int, force: ArrayLike) -> Frame:
    """A loaded cantilever with a link on its end that bears nothing, behind a rigid joint with clearance."""
    axes = Rotation.random(random_state=seed).as_matrix()
    places = np.array([(0.0, 0.0, 0.0), (1.0, 0.2, 0.0), (1.5, -0.5, 0.3)]) @ axes.T
    frame = Frame()
    for name, k in {"A": 0, "B": 1, "C": 1, "D": 2}.items():
        frame.node(name, places[k])
    frame.add("AB", BAR, "A", "B")
    frame.add("CD", BAR, "C", "D")
    frame.add("pin", Joint((np.inf,) * 6, clearance=1e-4, axes=axes), "B", "C")
    frame.fix("A")
    frame.load("B", fx=force, fy=0.3 * np.asarray(force), fz=force)
    return frame


@pytest.mark.parametrize("seed", range(4))
def test_what_bears_nothing_is_free_alone_and_in_a_batch(seed: int) -> None:
    """Statics: behind the load nothing acts."""
    whole, backwards = two_links(seed, FORCE).solve(), two_links(seed, FORCE[::-1]).solve()
    alone = [two_links(seed, force).solve() for force in FORCE]
    for solution in (whole, backwards, *alone):
        assert np.all(solution.contact("pin").status == "free")
        assert np.all(solution.status == "free")
        assert_array_equal(solution.contact("pin").force, 0.0)
    for k, each in enumerate(alone):
        assert_allclose(each.displacement("D"), whole.displacement("D")[k], rtol=1e-9, atol=1e-18)


def test_a_support_that_is_displaced_presses_nothing() -> None:
    """Nothing strains what hangs on one support alone, however far that is moved."""
    frame = two_links(0, 0.0)
    frame.prescribe("A", ux=1e-3, rz=1e-3)
    assert frame.solve().contact("pin").status == "free"


@pytest.mark.parametrize("seed", range(3))
def test_the_middle_is_found_beside_members_that_are_stiffer_by_far(seed: int) -> None:
    """One direction is resisted, and by the rounding of the members all are: the middle is that of the others."""
    rng = np.random.default_rng(seed)
    own, members = np.array([0, 0, 0, 1, 1]), 4e8
    along = np.array([0.1, -0.27, -0.21, -0.03, 1.4])
    rounding = np.sqrt(members * 1e-16) * rng.normal(size=(5, 5))
    stiffness = 500.0 * np.outer(along, along) + rounding @ rounding.T
    force = 0.6 * along
    found, multiplier = minimise_in_balls(stiffness[..., None], force[:, None], own, np.full((5, 1), members))

    def distance(x: np.ndarray) -> float:
        return -float(sum(np.log1p(-np.sum(x[own == ball] ** 2)) for ball in (0, 1)))

    resting = {"type": "eq", "fun": lambda x: along @ x - 0.6 / 500.0}
    expected = minimize(distance, np.zeros(5), constraints=resting, tol=1e-15).x
    assert_allclose(found[:, 0], expected, rtol=0.0, atol=1e-7)
    assert_array_equal(multiplier, 0.0)


@pytest.mark.parametrize("stiffness", [1e8, np.inf])
def test_a_frame_is_not_judged_by_the_size_of_others(stiffness: float) -> None:
    """A moment on the end of two links in turned axes presses nothing in the pin between them."""
    axes = Rotation.from_rotvec((0.3, -0.8, 0.5)).as_matrix()

    def under_moment(length: ArrayLike) -> Solution:
        size, frame = np.asarray(length)[..., None], Frame()
        for name, (x, y) in {"A": (0.0, 0.0), "B": (1.0, 0.0), "C": (1.0, 0.0), "D": (1.5, 0.4)}.items():
            frame.node(name, size * (x * axes[:, 0] + y * axes[:, 1]))
        frame.add("AB", BAR, "A", "B")
        frame.add("CD", BAR, "C", "D")
        frame.add("pin", Joint((stiffness,) * 3 + (1e5,) * 3, clearance=1e-4), "B", "C")
        frame.fix("A")
        frame.load("D", mx=1.0, my=0.3, mz=-0.7)
        return frame.solve()

    whole = under_moment([0.01, 1.0, 1000.0]).contact("pin").status
    assert_array_equal(whole[:2], "free")
    assert_array_equal(whole, [under_moment(length).contact("pin").status for length in (0.01, 1.0, 1000.0)])


def test_a_soft_spring_that_is_stretched_presses_what_no_load_does() -> None:
    """Its stiffness against an offset is lost in the rounding of the members', its force is not."""
    frame = two_links(0, 0.0)
    frame.node("G", frame.position("D"))
    frame.add("spring", Joint((1e-7,) * 3 + (0.0,) * 3), "D", "G")
    frame.fix("G", "rx", "ry", "rz")
    frame.prescribe("G", ux=1.0, uy=0.0, uz=0.0)
    contact = frame.solve().contact("pin")
    assert contact.status == "closed"
    assert_allclose(contact.force, 1e-7, rtol=1e-3)
