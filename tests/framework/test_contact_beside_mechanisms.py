"""Contact in batches in which some entries are mechanisms, or nothing acts: each entry is as it is alone."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, Solution, SolutionState
from linkframe.framework.error_bounds.equilibrium import Statics
from linkframe.framework.results import consistent_mechanisms, constrained_batch
from linkframe.framework.results.constrained import ConstrainedSolution
from linkframe.models import FourBar
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import ArrayLike

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
RNG = np.random.default_rng(1)
MANY, SAMPLES = 40, 3
STIFFNESS = 2e8 * RNG.uniform(0.8, 1.2, MANY)
CLEARANCE = 1e-4 * RNG.uniform(0.5, 1.5, MANY)
# Two of these are dead points to the last digit, and one to double precision.
DEGREES = np.array([0.0, 20.0, 110.0, 180.0, 180.0 + 1e-9, 340.0])

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


def four_bar(degrees: ArrayLike, k: ArrayLike, clearance: ArrayLike, force: ArrayLike) -> Frame:
    free = np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 0.0])
    stiffness = dict.fromkeys("BDE", np.asarray(k)[..., None] * free)
    motion = FourBar(beam=BAR, stiffness=stiffness).move(np.radians(degrees))
    frame = motion.frame(dict.fromkeys("BDE", clearance))
    frame.load("P", fy=force)
    return frame


def results(solution: Solution) -> list[np.ndarray]:
    contact = solution.contact("D")
    forces = solution.joint_force("D"), solution.reaction("E"), solution.end_forces("rocker")
    return [solution.displacement("P"), *forces, contact.normal, contact.offset, contact.force]


def test_entries_are_as_they_are_alone() -> None:
    """Where the load is reversed from sample to sample, by way of none."""
    force = np.linspace(-80.0, 80.0, SAMPLES)
    whole = four_bar(DEGREES[:, None], STIFFNESS[:SAMPLES], CLEARANCE[:SAMPLES], force).solve()
    found, states = results(whole), whole.contact("D").state
    for pose, degrees in enumerate(DEGREES):
        for sample in range(SAMPLES):
            alone = four_bar(degrees, STIFFNESS[sample], CLEARANCE[sample], force[sample]).solve()
            assert alone.status == whole.status[pose, sample]
            assert alone.contact("D").state == states[pose, sample]
            for one, all_of_them in zip(results(alone), found, strict=True):
                size = np.nan_to_num(np.abs(one)).max()
                assert_allclose(all_of_them[pose, sample], one, rtol=0.0, atol=1e-7 * size)
    assert (whole.status[[0, 3]] == "mechanism").sum() == 2 * (force != 0.0).sum()


@pytest.mark.parametrize("imposed", [0.0, 1e-5])
def test_regular_entries_go_the_quick_way_beside_mechanisms(imposed: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is looked at more closely that geometry and loads tell, and contact is in closed form."""

    def refused(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr(consistent_mechanisms, "small", refused)
    degrees, force = np.delete(DEGREES, 4), np.linspace(80.0, 120.0, MANY)

    def frame_at(degrees: ArrayLike) -> Frame:
        frame = four_bar(np.asarray(degrees)[:, None], STIFFNESS, CLEARANCE, force)
        frame.prescribe("E", ux=imposed)
        frame.offset("D", uy=-imposed)
        return frame

    whole, regular = frame_at(degrees).solve(), frame_at(degrees[[1, 2, 4]]).solve()
    assert whole.pressed is not None
    for some, all_of_them in zip(results(regular), results(whole), strict=True):
        assert_allclose(all_of_them[[1, 2, 4]], some, rtol=1e-9, atol=1e-9 * np.abs(some).max())
    assert np.isnan(whole.displacement("P")[[0, 3]]).all()
    assert np.isnan(whole.joint_force("D")[[0, 3]]).all()
    assert_array_equal(whole.contact("B").state[:, 0], ["mechanism", "closed", "closed", "mechanism", "closed"])
    with pytest.warns(MechanismWarning, match=r"80 of 200 .* free motion 1: "):
        frame_at(degrees).solve().displacement("P")


@pytest.mark.parametrize("degrees", [0.0, 180.0, 180.0 + 1e-9])
@pytest.mark.parametrize("clearance", [None, 1e-4])
def test_without_load_nothing_is_displaced(degrees: float, clearance: float | None) -> None:
    """Even at a dead point, and beside an entry that a load sets in motion."""
    frame = four_bar(degrees, 2e8, 0.0 if clearance is None else clearance, [0.0, 5.0])
    solution = frame.solve()
    rest, state = solution.displacement("P")[0], solution.state[0]
    assert_array_equal(rest, 0.0)
    assert_array_equal(solution.joint_force("D")[0], 0.0)
    assert state == (SolutionState.STATICALLY_CONSISTENT_MECHANISM if clearance is None else SolutionState.FREE)


def test_what_is_left_out_leaves_the_others_the_quick_way() -> None:
    degrees = np.array([20.0, 110.0, 340.0])
    frame = four_bar(degrees[:, None], STIFFNESS, CLEARANCE, 100.0)
    expected = frame.copy().solve().displacement("P")
    frame.exclude(np.array([[False], [True], [False]]))
    solution = frame.solve()
    assert solution.pressed is not None
    assert_allclose(solution.displacement("P")[[0, 2]], expected[[0, 2]], rtol=1e-12)
    assert np.isnan(solution.displacement("P")[1]).all()
    assert (solution.contact("B").state[1] == "absent").all()


def test_a_joint_without_force_at_some_entries_alone() -> None:
    """A stop of the crank at a dead point to double precision, at which offsets drive the linkage by a rounding."""
    along, across = np.array([80.0, 0.0, 60.0]), np.array([0.0, 50.0, 30.0])

    def solved(along: ArrayLike, across: ArrayLike, sample: ArrayLike) -> Solution:
        frame = four_bar(np.array([180.0, 20.0])[:, None], STIFFNESS[sample], CLEARANCE[sample], 0.0)
        frame.node("ground", frame.nodes["B.crank"].coordinates, frame.nodes["B.crank"].body)
        frame.add("stop", Joint((0.0, 1e7, 0.0, 0.0, 0.0, 0.0), clearance=1e-5), "B.crank", "ground")
        frame.fix("ground")
        frame.load("P", fx=along)
        frame.load("B.crank", fy=across)
        return frame.solve()

    whole = solved(along, across, np.arange(3))
    for sample in range(3):
        alone = solved(along[sample, None], across[sample, None], np.array([sample]))
        assert_array_equal(whole.status[:, sample], alone.status[:, 0])
        found, expected = whole.contact("stop"), alone.contact("stop")
        assert_array_equal(found.state[:, sample], expected.state[:, 0])
        assert_allclose(found.offset[:, sample], expected.offset[:, 0], rtol=0.0, atol=1e-12)
        assert_allclose(whole.displacement("P")[:, sample], alone.displacement("P")[:, 0], rtol=0.0, atol=1e-12)
    assert whole.contact("stop").state[0, 1] == "closed"


def test_unit_offsets_at_poses_that_are_singular_by_rounding_go_together(monkeypatch: pytest.MonkeyPatch) -> None:
    """At half a turn the sine of the angle is 1e-16, by which a joint that is opened works on the free motion."""
    looked_at: list[int] = []

    def small(statics: Statics, suspects: np.ndarray, unknowns: list[int]) -> Iterator[ConstrainedSolution]:
        looked_at.append(int(suspects.sum()))
        return constrained_batch.small(statics, suspects, unknowns)

    def in_line(degrees: ArrayLike, sample: ArrayLike) -> Frame:
        """Loaded in line where the links are so: there the load does no work."""
        frame = four_bar(degrees, STIFFNESS[sample], CLEARANCE[sample], 0.0)
        frame.load("P", fx=80.0)
        return frame

    monkeypatch.setattr(consistent_mechanisms, "small", small)
    whole = in_line(np.array([0.0, 180.0])[:, None], np.arange(MANY)).solve()
    found = whole.displacement("P"), whole.joint_force("B"), whole.contact("B").offset
    assert max(looked_at, default=0) == 0
    alone = in_line(180.0, 7).solve()
    expected = alone.displacement("P"), alone.joint_force("B"), alone.contact("B").offset
    for one, all_of_them in zip(expected, found, strict=True):
        assert_allclose(all_of_them[1, 7], one, rtol=0.0, atol=1e-9 * np.nan_to_num(np.abs(one)).max())
