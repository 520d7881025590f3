"""Mobility: linkages that move although counting says they cannot, and others that do not although it says they can."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.models import Linkage
from reference.linkages import bennett, four_bar, loop, n_four_bar, rssr
from scipy.spatial.transform import Rotation


@pytest.mark.parametrize("turn", [Rotation.identity(), Rotation.from_rotvec([0.4, -1.1, 0.7])])
def test_four_bar_in_plane_and_space(turn: Rotation) -> None:
    found = four_bar(0.1, 0.25, 0.2, 0.22, 0.7, turn=turn).mobility()
    assert (found.actual, found.instantaneous, found.kutzbach, found.kutzbach_spatial) == (1, 1, 1, -2)
    assert found.planar
    # What the plane does not need of one pin: along its axis, and the two turns out of the plane.
    assert len({joint for joint, _ in found.redundant}) == 1
    assert {component for _, component in found.redundant} == {"uz", "rx", "ry"}


def test_components_are_along_the_axes_of_their_joint() -> None:
    """A slider-crank described from its slide: the pin that closes the loop still names its own axis z."""
    linkage = Linkage(C=(0.4, 0.3, 0), B=(0, 0.3, 0), A=(0, 0, 0))
    linkage.link("piston", "C")
    linkage.link("rod", "B", "C")
    linkage.link("crank", "A", "B")
    linkage.prismatic("C", "ground", "piston", axis=(1, 1, 0), name="slide", drive=True)
    linkage.revolute("C", "rod", "piston")
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("A", "ground", "crank")
    found = linkage.mobility()
    assert (found.planar, found.actual, found.kutzbach) == (True, 1, 1)
    assert {component for _, component in found.redundant} == {"uz", "rx", "ry"}


def test_sliding_across_the_plane_is_not_planar() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B")
    linkage.link("slider", "B")
    linkage.revolute("A", "ground", "arm")
    linkage.prismatic("B", "arm", "slider", axis=(0, 0, 1))
    found = linkage.mobility()
    assert (found.planar, found.actual, found.kutzbach, found.kutzbach_spatial) == (False, 2, 2, 2)


@given(st.floats(0.2, 1.2), st.floats(0.2, 0.8), st.floats(-3.0, 3.0).filter(lambda x: abs(x) > 0.2))
@settings(max_examples=15, deadline=None)
def test_bennett_moves(alpha: float, more: float, theta: float) -> None:
    found = bennett(alpha, alpha + more, theta).mobility()
    assert (found.actual, found.instantaneous, found.kutzbach, len(found.redundant)) == (1, 1, -2, 3)


def test_bennett_with_a_wrong_angle_is_rigid() -> None:
    """tan(θ/2) tan(φ/2) is not the ratio that Bennett's linkage has: the hinges close, at that position alone."""
    a, alpha = 1.0, np.pi / 6
    angles = np.array([0.3, 0.8, -0.5, 1.1])
    linkage = loop((a, 0.7, 0.9, 1.2), (alpha, 0.9, -0.4, 0.3), angles)
    found = linkage.mobility()
    assert (found.actual, found.instantaneous, found.kutzbach) == (0, 0, -2)


def test_bricard_moves() -> None:
    quarter = np.pi / 2
    found = loop((1.0,) * 6, (quarter, -quarter) * 3, (quarter,) * 6).mobility()
    assert (found.actual, found.instantaneous, found.kutzbach, len(found.redundant)) == (1, 1, 0, 1)


def test_sarrus_moves_straight() -> None:
    """Two pairs of hinged plates, their axes square to each other: a plate goes up and down (P. F. Sarrus 1853)."""
    linkage = Linkage()
    rise = np.array([0.0, 0.0, 1.2])
    linkage.point("T", rise)
    for name, out, axis in (("x", (1.0, 0.0, 0.0), (0, 1, 0)), ("y", (0.0, 1.0, 0.0), (1, 0, 0))):
        foot = np.array(out)
        linkage.point(f"{name}0", foot)
        linkage.point(f"{name}1", 1.5 * foot + 0.5 * rise)
        linkage.point(f"{name}2", foot + rise)
        linkage.link(f"{name} lower", f"{name}0", f"{name}1")
        linkage.link(f"{name} upper", f"{name}1", f"{name}2")
        linkage.revolute(f"{name}0", "ground", f"{name} lower", axis=axis)
        linkage.revolute(f"{name}1", f"{name} lower", f"{name} upper", axis=axis)
    linkage.link("plate", "x2", "y2", "T")
    linkage.revolute("x2", "x upper", "plate", axis=(0, 1, 0))
    linkage.revolute("y2", "y upper", "plate", axis=(1, 0, 0))
    found = linkage.mobility()
    assert (found.actual, found.kutzbach, len(found.redundant)) == (1, 0, 1)
    assert not found.planar


@pytest.mark.parametrize("n", [1, 2, 5])
def test_flat_n_four_bar(n: int) -> None:
    """IFToMM benchmark A02: one freedom, and n + 1 velocities where all rods lie flat."""
    flat, upright = n_four_bar(n, 0.0).mobility(), n_four_bar(n, np.pi / 2).mobility()
    assert (flat.actual, flat.instantaneous) == (1, n + 1)
    assert (upright.actual, upright.instantaneous, upright.kutzbach) == (1, 1, 1)
    assert len(upright.redundant) == 3 * n


def test_velocity_without_motion() -> None:
    """Two bars in line between fixed pins: their common pin can start to move, but gets nowhere."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2.5, 0))
    linkage.link("a", "A", "B")
    linkage.link("b", "B", "C")
    linkage.revolute("A", "ground", "a")
    linkage.revolute("B", "a", "b")
    linkage.revolute("C", "b", "ground")
    found = linkage.mobility()
    assert (found.actual, found.instantaneous, found.kutzbach) == (0, 1, 0)
    assert "1 degree of freedom of velocity" in str(found)


def test_idle_rod() -> None:
    spinning, held = (rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3, universal).mobility() for universal in (False, True))
    assert (spinning.actual, spinning.kutzbach, spinning.idle) == (2, 2, ("rod",))
    assert (held.actual, held.kutzbach, held.idle) == (1, 1, ())


def test_open_chain_and_fixed_links() -> None:
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2, 0))
    linkage.link("a", "A", "B")
    linkage.link("b", "B", "C")
    linkage.cylindrical("A", "ground", "a")
    linkage.spherical("B", "a", "b")
    found = linkage.mobility()
    assert (found.actual, found.kutzbach, found.redundant) == (5, 5, ())
    linkage = Linkage(A=(0, 0))
    linkage.link("a", "A")
    linkage.fixed("A", "ground", "a")
    assert linkage.mobility().actual == 0


@given(st.floats(-6.0, 6.0))
@settings(max_examples=10, deadline=None)
def test_units_do_not_matter(exponent: float) -> None:
    """A spatial slider-crank, in whatever unit of length."""
    scale = 10.0**exponent
    linkage = Linkage(
        {name: scale * np.array(p) for name, p in {"A": (0, 0.1, 0.12), "B": (0, 0.1, 0.2), "C": (0.2, 0, 0)}.items()}
    )
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank", axis=(1, 0, 0))
    linkage.spherical("B", "crank", "rod")
    linkage.spherical("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0, 0))
    found = linkage.mobility()
    assert (found.actual, found.instantaneous, found.kutzbach, found.idle) == (2, 2, 2, ("rod",))
