"""Members of a batch, each at its own change or dead point: status and position are those of its own closed form."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.linkages import four_bar

DEAD = "singular (direct-kinematic, type II"


def kinds(status: NDArray[np.str_]) -> list[str]:
    return [str(text).partition(";")[0] for text in status.ravel()]


def stretched_bars(length: NDArray[np.float64], start: NDArray[np.float64], pitch: NDArray[np.float64]) -> Linkage:
    """Two bars of one length, the far end of which slides along x and turns a spindle."""
    x, y = length * np.cos(start), length * np.sin(start)
    linkage = Linkage(A=(0, 0), B=np.stack([x, y], -1), C=np.stack([2.0 * x, 0.0 * x], -1))
    for link, points in {"ab": "AB", "bc": "BC", "nut": "C", "spindle": "C"}.items():
        linkage.link(link, *points)
    linkage.revolute("A", "ground", "ab", drive=True)
    linkage.revolute("B", "ab", "bc")
    linkage.revolute("C", "bc", "nut")
    linkage.prismatic("C", "ground", "nut", axis=(1, 0), name="slide")
    linkage.screw("C", "ground", "spindle", axis=(1, 0, 0), pitch=pitch, name="screw")
    linkage.revolute("C", "spindle", "nut", axis=(1, 0, 0), name="bearing")
    return linkage


def test_fine_and_coarse_screws_in_a_change_point():
    """C is at twice the bars' cosine from A, and on A where they stand upright."""
    pitch = np.array([1e-2, 1e-6, -1e-4, 3e-5])
    start = np.full(4, 0.25 * np.pi)
    upright = 0.5 * np.pi - start
    motion = stretched_bars(np.full(4, np.sqrt(2.0)), start, pitch).move(A=upright + np.array([[0.0], [0.3], [-0.2]]))
    assert kinds(motion.status) == [DEAD] * 4 + ["regular"] * 8
    place = np.sqrt(8.0) * np.cos(0.5 * np.pi + np.array([0.0, 0.3, -0.2]))
    assert_allclose(motion.position("C")[..., 0], np.repeat(place[:, None], 4, axis=1), atol=1e-11)


def test_bars_that_stand_upright_at_other_angles():
    """Each member meets its change point at an angle of its own, before and after that of the leading one."""
    start, length = np.array([0.3, 0.7, 1.1, 0.7]), np.array([0.4, 1.0, 2.5, 1.0])
    upright = 0.5 * np.pi - start
    beside = np.array([0.0, 1e-9, -1e-6, 1e-3, 0.5, np.pi])[:, None]
    motion = stretched_bars(length, start, np.full(4, 0.02)).move(A=upright + beside)
    assert kinds(motion.status) == [DEAD] * 8 + ["near dead point"] * 8 + ["regular"] * 4 + [DEAD] * 4
    assert_allclose(motion.position("C")[..., 0], -2.0 * length * np.sin(beside), atol=1e-11)


@pytest.mark.parametrize("count", [1, 2])
def test_parallelograms_drawn_at_other_angles(count):
    """B and D stay a base apart. With two parallelograms in a row, two loops meet their change point at once."""
    crank, start = np.array([0.5, 0.8, 1.2]), np.array([0.4, 1.0, 1.9])
    base = np.array([1.4, 1.1, 0.9])
    b = np.stack([crank * np.cos(start), crank * np.sin(start)], -1)
    along = np.stack([base, 0.0 * base], -1)
    linkage = Linkage(A=(0, 0), B=b, D=b + along, E=along, F=b + 2.5 * along, G=2.5 * along)
    linkage.link("crank", "A", "B")
    linkage.revolute("A", "ground", "crank", drive=True)
    first = "crank", "B"
    for k, (top, bottom) in enumerate((("D", "E"), ("F", "G"))[:count]):
        linkage.link(f"coupler {k}", first[1], top)
        linkage.link(f"rocker {k}", top, bottom)
        linkage.revolute(first[1], first[0], f"coupler {k}", name=f"pin {k}")
        linkage.revolute(top, f"coupler {k}", f"rocker {k}")
        linkage.revolute(bottom, f"rocker {k}", "ground")
        first = f"rocker {k}", top
    flat = np.array([0.0, -1e-7, 0.02, 0.9, np.pi])[:, None] - start
    motion = linkage.move(A=flat)
    assert kinds(motion.status[[0, 4]]) == [DEAD] * 6
    assert kinds(motion.status[3]) == ["regular"] * 3
    reach = 1.0 if count == 1 else 2.5
    off = motion.position("D" if count == 1 else "F") - motion.position("B")
    assert_allclose(off[..., :2], np.broadcast_to(reach * along, off[..., :2].shape), atol=1e-11)


def test_members_in_their_own_dead_points():
    """Coupler and rocker in line: the crank's angle by the law of cosines."""
    crank, coupler, rocker, ground = 0.2, np.array([0.22, 0.2, 0.25]), 0.18, 0.3
    end = np.arccos((crank**2 + ground**2 - (coupler + rocker) ** 2) / (2.0 * crank * ground))
    entries = [four_bar(crank, each, rocker, ground, 0.9) for each in coupler]
    places = {p: np.stack([linkage.points[p] for linkage in entries]) for p in "ABDE"}
    linkage = Linkage(**places)
    linkage.link("crank", "A", "B")
    linkage.link("coupler", "B", "D")
    linkage.link("rocker", "D", "E")
    linkage.revolute("A", "ground", "crank", drive=True, reference=0.9)
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    motion = linkage.move(A=np.stack([end, end - 0.3]))
    assert kinds(motion.status) == [DEAD] * 3 + ["regular"] * 3
    share = rocker / (coupler + rocker)
    b = np.stack([crank * np.cos(end), crank * np.sin(end), 0.0 * end], -1)
    d = share[:, None] * b + (1.0 - share[:, None]) * np.array([ground, 0.0, 0.0])
    assert_allclose(motion.position("D")[0], d, atol=1e-7)


def test_conditioning_does_not_depend_on_the_size_of_neighbours():
    """A linkage that is a hundred times as large is as near to its dead point."""
    scale = np.array([1.0, 100.0, 0.03])
    motion = stretched_bars(scale, np.full(3, 0.8), 0.02 * scale).move(A=np.array([[0.2], [0.75], [0.766]]))
    assert_allclose(motion.conditioning, np.repeat(motion.conditioning[:, :1], 3, axis=1), rtol=1e-9)
    assert kinds(motion.status) == ["regular"] * 6 + ["near dead point"] * 3
