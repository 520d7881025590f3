"""An entry of a batch has the modes, buckling factors and refined results that it has alone."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution
from linkframe.models import FourBar, Linkage
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Numbers = NDArray[np.float64]
ROD = Beam(Circle(diameter=0.02), Material(E=2e11, nu=0.3, density=7850.0))


def column(turning: Numbers, foot: float = 1e9) -> Frame:
    """A bent column with a joint at half its height, pressed and twisted."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0, 0, 1), "C": (0, 0, 1), "D": (0, 0.3, 2)}.items():
        frame.node(name, place)
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", ROD, "C", "D")
    stiffness = np.concatenate([np.full((*turning.shape[:-1], 3), foot), turning], axis=-1)
    frame.add("joint", Joint(stiffness=stiffness), "B", "C")
    frame.fix("A")
    frame.load("D", fz=-100.0, mx=20.0, my=80.0, mz=50.0)
    return frame


def test_what_turns_first_in_a_joint_is_its_own_at_each_entry() -> None:
    turning = np.array([[100.0, 200.0, 400.0], [400.0, 100.0, 200.0], [200.0, 200.0, 100.0]])
    found = column(turning).buckling(2).factors
    assert_allclose(found, [column(own).buckling(2).factors for own in turning], rtol=1e-10)


def test_modes_beside_a_mechanism_and_its_refined_results() -> None:
    """The frequencies of an entry that cannot move have all digits; a mechanism has no refined force."""
    turning = np.array([[0.0, 1e3, 1e3], [1e12, 1e3, 1e3]])
    frame = column(turning, foot=1e12)
    alone = column(turning[1], foot=1e12).modes(3).frequencies
    assert_allclose(frame.modes(3).frequencies[1], alone, rtol=1e-12)
    solution = frame.solve()
    with pytest.warns(MechanismWarning):
        force, bound = solution.refined("joint", "joint_force")
    assert solution.status.tolist() == ["mechanism", "regular"]
    assert np.isnan(force[0]).all()
    assert np.isinf(bound[0]).all()
    assert np.isfinite(force[1]).all()


def pendulum(length: float | Numbers) -> Frame:
    """A rod that hangs from a hinge and has a mass at a fixed place beside it."""
    frame = Frame()
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.0, 0.0), "D": (0.01, 0.0, 0.0)}.items():
        frame.node(name, place)
    frame.node("C", np.asarray(length)[..., None] * np.array([1.0, 0.0, 0.0]))
    frame.add("rod", ROD, "B", "C")
    frame.add("hinge", Joint(stiffness=(np.inf,) * 5 + (0.0,)), "A", "B")
    frame.rigid("B", "D")
    frame.fix("A")
    frame.load("D", fy=1.0)
    return frame


def test_the_size_of_a_free_motion_is_that_of_the_entry() -> None:
    """The largest displacement is one, where a rotation counts as what it moves at the end of the entry's rod."""
    lengths = np.array([0.5, 40.0])
    whole = pendulum(lengths).solve()
    for entry, length in enumerate(lengths):
        alone = pendulum(length).solve()
        assert whole.mechanism(entry) == alone.mechanism()
        assert_allclose(whole.free_motion(entry).displacement("C"), alone.free_motion().displacement("C"), rtol=1e-9)


def parallel(size: float | Numbers, load: tuple[str, ...] = ("fx",)) -> Linkage:
    """A plate on three equal cranks, of which two would do."""
    unit = np.asarray(size)[..., None]
    places = {"A": (0, 0), "B": (0, 0.1), "D": (0.3, 0.1), "E": (0.3, 0), "F": (0.15, 0.1), "G": (0.15, 0)}
    linkage = Linkage(**{name: unit * np.array(place) for name, place in places.items()})
    linkage.link("crank", "A", "B")
    linkage.link("plate", "B", "F", "D")
    linkage.link("rocker", "D", "E")
    linkage.link("third", "F", "G")
    linkage.revolute("A", "ground", "crank", drive=True)
    for point, links in {"B": ("crank", "plate"), "D": ("plate", "rocker"), "F": ("plate", "third")}.items():
        linkage.revolute(point, *links)
    linkage.revolute("E", "rocker", "ground")
    linkage.revolute("G", "third", "ground")
    linkage.load("D", **dict.fromkeys(load, 1.0))
    return linkage


def test_reactions_and_their_method_are_those_of_the_pose_alone() -> None:
    """Upright, the cranks need not hold the plate up."""
    linkage, angles = parallel(1.0), np.array([0.0, 0.4, np.pi, 1.9])
    whole = linkage.move(A=angles).reactions()
    for k, angle in enumerate(angles):
        alone = linkage.move(A=[angle]).reactions()
        assert alone.method[0] == whole.method[k]
        for joint in linkage.joints:
            assert_allclose(whole.force(joint)[k], alone.force(joint)[0], rtol=1e-9, atol=1e-12)
    assert whole.method[:2].tolist() == ["determinate", "minimum norm"]


def test_the_least_reactions_of_a_sample_do_not_depend_on_larger_ones() -> None:
    """Moments are compared with forces by the size of the linkage, which is that of the sample."""
    whole = parallel(np.array([1.0, 1000.0]), ("fy", "fz", "mx")).move(A=0.4).reactions()
    alone = parallel(1.0, ("fy", "fz", "mx")).move(A=0.4).reactions()
    for joint in "ABDEFG":
        assert_allclose(whole.force(joint)[0], alone.force(joint), rtol=1e-7, atol=1e-9)


def test_a_joint_ideal_at_some_entries_is_refused_where_it_is_described() -> None:
    stiffness = np.full((3, 6), 1e8)
    stiffness[1, 4] = np.inf
    linkage = parallel(1.0)
    with pytest.raises(FrameError, match=r"joint 'B' is ideal .* ry at \[1\] and not at \[0\]: describe those entries"):
        linkage.revolute("B", "crank", "plate", stiffness=stiffness, replace=True)


def in_line(angles: list[float]) -> Solution:
    """A four-bar that at 0 degrees lies in line, with a load along it."""
    motion = FourBar(crank=0.1, coupler=0.2, rocker=0.1, ground=0.2, point=(0.1, 0.0)).move(np.array(angles))
    frame = motion.frame()
    frame.load("P", fx=100.0)
    return frame.solve()


def test_a_load_along_the_dead_line_does_not_reach_the_motion_across_it() -> None:
    """Exact zeros part them at that entry, whatever couples them at others; its results have their bounds."""
    alone, whole = in_line([0.0]), in_line([1.0, 0.0])
    assert whole.status.tolist() == ["regular", "statically consistent mechanism"]
    assert_allclose(whole.displacement("P")[1], alone.displacement("P")[0], rtol=1e-12)
    assert whole.displacement("P")[1, 1] == 0.0
    for kind in ("displacement", "joint_force"):
        name = "P" if kind == "displacement" else "D"
        ratio = (1e-30 + whole.error_bound(name, kind)[1]) / (1e-30 + alone.error_bound(name, kind)[0])
        assert (ratio > 0.3).all()
        assert (ratio < 3.0).all()
