"""Condition numbers of loaded linkages, and whether large displacement passes a singular configuration, by hand."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.models import FourBar, Linkage, accuracy
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.optional_tables import sections
from linkframe.models.linkage.job.result import compute
from linkframe.models.linkage.job.sampled import drawn
from linkframe.models.linkage.statics.passing import _displaced
from numpy.testing import assert_allclose

STEEL = Material(E=2e11, nu=0.3)
FILE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
# Global axes of planes, as columns in which x y z of a drawing are meant.
PLANES = {"xy": np.eye(3), "xz": np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])}


def slider_crank(plane: str = "xy", rod: float = 0.25, spring: float = 1e8) -> Linkage:
    """Crank A-B, rod B-C and a slider at C along the line through A, drawn in a plane."""
    axes = PLANES[plane]
    reach = 0.08 + np.sqrt(rod**2 - 0.06**2)
    places = {"A": (0.0, 0.0, 0.0), "B": (0.08, 0.06, 0.0), "C": (reach, 0.0, 0.0), "S": (reach + 0.05, 0.0, 0.0)}
    found = Linkage({name: axes @ np.array(place) for name, place in places.items()})
    bar = Beam(Rectangle(y=0.012, z=0.02), STEEL, up=tuple(axes[:, 2]))
    for link, ends in {"crank": "AB", "rod": "BC", "slider": "CS"}.items():
        found.link(link, *ends, beam=bar)
    stiff = (spring,) * 5 + (0.0,)
    found.revolute("A", "ground", "crank", axis=tuple(axes[:, 2]), drive=True)
    found.revolute("B", "crank", "rod", axis=tuple(axes[:, 2]), stiffness=stiff)
    found.revolute("C", "rod", "slider", axis=tuple(axes[:, 2]), stiffness=stiff)
    found.prismatic("S", "ground", "slider", axis=tuple(axes[:, 0]), stiffness=(spring, spring, 0.0, 1e6, 1e6, 1e6))
    return found


def by_hand(frame: Frame, entry: int, kept: tuple[int, ...] = tuple(range(6))) -> float:
    """NumPy's condition number of K over what is free, of some components of every node."""
    found = frame.matrices(entry)
    free = np.flatnonzero(abs(found.T).sum(axis=1))
    chosen = free[np.isin(free % 6, kept)]
    return float(np.linalg.cond(found.K.toarray()[np.ix_(chosen, chosen)]))


@pytest.mark.parametrize(("plane", "kept"), [("xy", (0, 1, 5)), ("xz", (0, 2, 4))])
def test_whole_and_plane_against_numpy(plane: str, kept: tuple[int, ...]) -> None:
    motion = slider_crank(plane).move(A=np.radians([40.0, 70.0]))
    found = motion.accuracy("C", fx=-100.0)
    frame = motion.frame()
    for entry in range(2):
        assert_allclose(found.condition_number()[entry], by_hand(frame, entry), rtol=1e-5)
        assert_allclose(found.planar_condition_number()[entry], by_hand(frame, entry, kept), rtol=1e-5)


def test_there_is_no_plane_for_a_linkage_in_space() -> None:
    linkage = Linkage(A=(0.0, 0.0, 0.0), B=(1.0, 0.0, 0.0), C=(1.0, 1.0, 0.0))
    linkage.link("one", "A", "B", beam=Beam(Rectangle(y=0.02, z=0.01), STEEL))
    linkage.link("two", "B", "C", beam=Beam(Rectangle(y=0.02, z=0.01), STEEL))
    linkage.revolute("A", "ground", "one", drive=True)
    linkage.revolute("B", "one", "two", axis=(1.0, 0.0, 0.0), drive=True)
    found = linkage.move(A=[0.2, 0.4], B=[0.1, 0.7]).accuracy("C", fz=1.0)
    with pytest.raises(FrameError, match="no plane of two axes"):
        found.planar_condition_number()


def test_scaled_does_not_depend_on_the_drawing() -> None:
    """The paper's four-bar, and as a linkage drawn at other angles and turned: 953 and 1402 at 30 degrees once."""
    theta, turned = np.radians([30.0, 60.0, 80.0]), np.radians(25.0)
    own = accuracy(FourBar(), theta, load=(0.0, 100.0, 0.0)).scaled_condition_number()
    for reference in np.radians([30.0, 60.0, 110.0]):
        linkage = FourBar().linkage(reference)
        assert_allclose(linkage.move(A=theta).accuracy("P", fy=100.0).scaled_condition_number(), own, rtol=1e-8)
    turn = np.array([[np.cos(turned), -np.sin(turned)], [np.sin(turned), np.cos(turned)]])
    drawn_at = FourBar().move(theta[1])
    other = Linkage({name: (*(turn @ drawn_at.position(name)[:2]), 0.0) for name in "ABPDE"})
    for link, points in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        other.link(link, *points, beam=FourBar().link_beam(link))
    other.revolute("A", "ground", "crank", drive=True, reference=theta[1])
    for joint, pair in {"B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}.items():
        other.revolute(joint, *pair, stiffness=FourBar().joint_stiffness(joint))
    assert_allclose(other.move(A=theta).accuracy("P", fy=100.0).scaled_condition_number(), own, rtol=1e-8)


def test_a_slider_crank_passes_where_its_rod_stands_across_the_slide() -> None:
    """The side of the rod's end is told from the displaced nodes; a stiff one stays on its side."""
    push = np.array([0.0, -100.0, -2e4])
    for spring, passed in ((3e6, [False, False, True]), (1e12, [False] * 3)):
        motion = slider_crank(rod=0.1005, spring=spring).move(A=np.radians(88.0))
        found = motion.accuracy("C", fx=push)
        large = found._large
        ends = [large.frame.position(node) + large.displacement(node)[..., :3] for node in ("B.rod", "C.rod")]
        assert large.converged.all()
        assert (ends[1][:, 0] < ends[0][:, 0]).tolist() == passed
        assert found.large_passes.tolist() == passed


def test_a_spatial_linkage_passes_where_its_rod_points_at_the_axis_of_the_rocker() -> None:
    """Crank, rod between two balls and rocker about x, just before its dead point: (C - B) . (x X (C - D)) = 0."""
    places = {"A": (0.0, 0.0, 0.0), "B": (0.1, 0.0, 0.0), "C": (0.3, 0.2, 0.15), "D": (0.3, 0.0, 0.1)}
    linkage = Linkage(places)
    for link, ends in {"crank": "AB", "rod": "BC", "rocker": "CD"}.items():
        linkage.link(link, *ends, beam=Beam(Rectangle(y=0.01, z=0.01), STEEL))
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.spherical("B", "crank", "rod", stiffness=(1e5,) * 3 + (0.0,) * 3)
    linkage.spherical("C", "rod", "rocker", stiffness=(1e5,) * 3 + (0.0,) * 3)
    linkage.revolute("D", "ground", "rocker", axis=(1.0, 0.0, 0.0), stiffness=(1e5,) * 5 + (0.0,))
    motion = linkage.move(A=np.radians(97.6))  # dead point at 97.707
    found = motion.accuracy("C", "rocker", fy=np.array([-10.0, -0.05]))
    large = found._large

    def side(moves: float) -> np.ndarray:
        b, c, c_rocker, d = (
            large.frame.position(node) + moves * large.displacement(node)[..., :3]
            for node in ("B.rod", "C.rod", "C.rocker", "D.rocker")
        )
        return np.vecdot(c - b, np.cross([1.0, 0.0, 0.0], c_rocker - d))

    assert large.converged.all()
    assert found.large_passes.tolist() == (side(0.0) * side(1.0) < 0.0).tolist() == [True, False]


def test_samples_of_a_four_bar_pass_where_its_closed_form_says() -> None:
    """The area between coupler and rocker, from their displaced ends."""
    theta, gap, load = np.radians(5.0), 1e-3, np.array([-99.0, 99.0])
    four_bar = FourBar(stiffness=(1e7,) * 5 + (0.0,))
    linkage = four_bar.linkage(np.radians(60.0), clearance=dict.fromkeys("BDE", gap))
    found = linkage.move(A=theta).accuracy("P", fy=load)
    closed = accuracy(four_bar, theta, load=(0.0, load, 0.0), clearance=gap, contact="equilibrium")
    assert found.large_passes.tolist() == closed.large_passes.tolist()
    assert 0 < np.count_nonzero(found.large_passes) < found.large_passes.size


def test_from_a_dead_point_none_passes() -> None:
    """It stands on neither side, whatever the sign of rounding is there."""
    found = FourBar().linkage(np.radians(60.0)).move(A=np.pi).accuracy("P", fy=np.array([-99.0, 99.0]))
    assert np.ptp(found.large[:, 1]) > 1e-3
    assert not found.large_passes.any()


def test_the_job_tells_the_ranges_over_the_samples(tmp_path: Path) -> None:
    """At the pose of the figures, against NumPy's condition number of each sample's matrix."""
    text = FILE.read_text(encoding="utf-8").replace(
        'points = ["P"]\npose', 'points = ["P"]\nalso = ["condition"]\npose'
    )
    text = text.replace("start = 0.0\nstop = 360.0\nsteps = 37", "start = 20.0\nstop = 80.0\nsteps = 3")
    path = tmp_path / "four_bar.toml"
    path.write_text(text.replace("pose = 30.0\nsamples = 100", "pose = 50.0\nsamples = 6"), encoding="utf-8")
    result = compute(read_inputs(path))
    frame = result.inputs.varied(drawn(result.inputs)).move(A=np.radians(50.0)).frame()
    whole, plane = ([by_hand(frame, sample, kept) for sample in range(6)] for kept in (tuple(range(6)), (0, 1, 5)))
    told = "\n".join(sections(result))
    assert f"κ lies between {min(whole):.3e} and {max(whole):.3e}" in told
    assert f"κ in the plane lies between {min(plane):.3e} and {max(plane):.3e}" in told


def test_joints_that_deflect_by_nothing_are_where_they_were() -> None:
    """Of every kind, a screw after several turns: the state that the displaced frame tells is that of the pose."""
    kinds = ("screw", "revolute", "universal", "cylindrical", "planar", "prismatic", "spherical")
    linkage = Linkage({name: (0.1 * k, 0.02 * (k % 2), 0.03 * (k % 3)) for k, name in enumerate("ABCDEFGH")})
    links = ["ground", *kinds]
    for k, (kind, point, end) in enumerate(zip(kinds, "ABCDEFG", "BCDEFGH", strict=True)):
        linkage.link(kind, point, end, beam=Beam(Rectangle(y=0.02, z=0.03), STEEL))
        given: dict[str, object] = {} if kind == "spherical" else {"axis": (0.0, 0.6, 0.8)}
        given |= {"screw": {"pitch": 0.01}, "universal": {"second": (1.0, 0.0, 0.0)}}.get(kind, {})
        getattr(linkage, kind)(point, links[k], links[k + 1], drive=True, **given)
    drives = {"A": 20.0, "B": 1.4, "C": [0.4, -0.7], "D": [0.02, 1.1], "E": [0.01, -0.02, 3.0], "F": 0.03}
    motion = linkage.move(**drives, G=[0.3, -0.5, 0.8])
    frame = motion.frame()
    frame.load("H", fy=1e-6)
    found = _displaced(motion, frame.solve(large=True))
    assert_allclose(np.array(found, dtype=float), np.array(motion.assembly.state, dtype=float), atol=1e-7)
