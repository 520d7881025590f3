"""Worst cases of one deviation alone, of loops that are overconstrained, and of fuzzy bearings: nothing is lost."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import FourBar, Linkage
from linkframe.models.linkage.worst_case.mixed_area import volume_within
from linkframe.models.linkage.worst_case.redundant import least_lengths
from linkframe.models.linkage.worst_case.region import ReachableRegion
from numpy.testing import assert_allclose
from reference.linkages import parallel_cranks
from scipy.spatial.transform import Rotation

FOUR = FourBar(crank=0.1, coupler=0.25, rocker=0.2, ground=0.22, point=(0.12, 0.05))


def arm() -> Linkage:
    linkage = Linkage(A=(0, 0), P=(0.2, 0))
    linkage.link("arm", "A", "P")
    linkage.revolute("A", "ground", "arm", drive=True, clearance=1e-5)
    return linkage


@pytest.mark.parametrize("angle", [0.0, 0.3, 0.5 * np.pi, 1.0, 2.0])
def test_the_band_of_a_single_deviation_is_as_wide_at_every_angle(angle: float) -> None:
    """The length of an arm alone deviates: at one pose the region is a segment, square to the path."""
    motion = arm().move(A=angle)
    band = motion.worst_case("P", clearances={"A": 0.0}, lengths={"arm": 1e-4}).envelope()
    along = motion.position("P") / 0.2
    assert_allclose(np.sort((band - motion.position("P")) @ along), [-1e-4, 1e-4], rtol=1e-9)


def test_the_shorter_a_fuzzy_bearing_the_more_it_tilts() -> None:
    """Each level is the worst case of the shortest bearing of its cut, and holds those of higher levels."""
    motion = arm().move(A=0.3)
    found = motion.fuzzy("P", levels=3, journals={"A": (0.01, 0.02, 0.03)})
    for k, shortest in enumerate((0.01, 0.015, 0.02)):
        worst = motion.worst_case("P", journals={"A": shortest})
        assert_allclose([found.worst.greatest[k], found.worst.angle[k]], [worst.greatest, worst.angle], rtol=1e-12)
    assert np.all(np.diff(found.worst.greatest) < 0.0)
    along = found.along((0, 0, 1))
    assert np.all(np.diff(along.upper) <= 0.0)


def test_each_pin_of_a_cross_may_be_fuzzy() -> None:
    linkage = Linkage(A=(0, 0, 0), P=(0.2, 0, 0))
    linkage.link("arm", "A", "P")
    linkage.universal("A", "ground", "arm", axis=(0, 0, 1), second=(0, 1, 0), drive=True, clearance=1e-5)
    motion = linkage.move(A=np.zeros((1, 2)))
    found = motion.fuzzy("P", levels=2, journals={"A": (0.02, (0.01, 0.02, 0.03))}, end_play={"A": (0.0, (0, 0, 1e-5))})
    for k, (shortest, play) in enumerate(((0.01, 1e-5), (0.02, 0.0))):
        worst = motion.worst_case("P", journals={"A": (0.02, shortest)}, end_play={"A": (0.0, play)})
        assert_allclose(found.worst.greatest[k], worst.greatest, rtol=1e-12)


@pytest.mark.parametrize("levels", [3, 4])
def test_levels_are_an_axis_of_their_own(levels: int) -> None:
    """Three clearances beside a fuzzy drive: as many levels as clearances are no reason to pair them."""
    motion, clearances = arm().move(A=0.3), np.array([1e-5, 2e-5, 3e-5])
    found = motion.fuzzy("P", levels=levels, clearances={"A": clearances}, drives={"A": (-1e-4, 0.0, 1e-4)})
    drive = 1e-4 * (1.0 - found.levels)
    assert_allclose(found.worst.greatest, clearances + 0.2 * drive[:, None], rtol=1e-9)
    own = Linkage(A=(0, 0), P=(0.2, 0))
    own.link("arm", "A", "P")
    own.revolute("A", "ground", "arm", drive=True, clearance=clearances)
    same = own.move(A=0.3).fuzzy("P", levels=levels, drives={"A": (-1e-4, 0.0, 1e-4)})
    assert_allclose(same.worst.greatest, found.worst.greatest, rtol=1e-12)


def overconstrained() -> Linkage:
    """A plane four-bar: hinges also hold it across the plane, three times too often."""
    motion = FOUR.move(1.0)
    linkage = Linkage({point: motion.position(point) for point in "ABPDE"})
    for name, points in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        linkage.link(name, *points)
    linkage.revolute("A", "ground", "crank", drive=True, reference=1.0)
    for point, first, second in (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground")):
        linkage.revolute(point, first, second, clearance=1e-4)
    return linkage


def test_bearings_that_others_hold_in_the_plane() -> None:
    """One bearing tilts and no other gives way across the plane: the region lies in the plane and has an area."""
    motion = overconstrained().move(A=[1.0, 1.5])
    plane = motion.worst_case("P")
    tilting = motion.worst_case("P", journals={"D": 0.05})
    assert tilting.position.stress is not None
    assert tilting.position.dimension == 2
    assert_allclose(tilting.volume, 0.0, atol=1e-20)
    assert_allclose(tilting.area, plane.area, rtol=5e-4)
    assert_allclose(tilting.greatest, plane.greatest, rtol=1e-5)
    assert tilting.envelope().shape == (2, 2, 3)


def test_a_flat_region_among_others_has_no_volume() -> None:
    """Wherever it lies, and however it is turned; a cube beside it has its own."""
    cube = np.stack(np.meshgrid(*[[0.0, 2.0]] * 3), axis=-1).reshape(8, 3)
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    regions = np.stack([cube, cube * (1.0, 1.0, 0.0) @ turn, 1e-5 * (cube @ turn)]) + 1e-2
    assert_allclose(volume_within(regions), [8.0, 0.0, 8e-15], rtol=1e-9)


@pytest.mark.parametrize(
    ("link", "two", "area", "greatest"),
    [
        ("coupler", 2e-4, np.pi + 4.0, 2.0),
        ("coupler", 0.25e-4, 4.0 + np.sqrt(3.0) / 2.0 + np.pi / 3.0, np.sqrt(1.5**2 + 0.75)),
        ("coupler", 0.0, 4.0, np.sqrt(2.0)),
        ("one", 2e-4, 0.0, 1.0),
    ],
)
def test_three_cranks_have_an_area_and_a_boundary(link: str, two: float, area: float, greatest: float) -> None:
    """Lengths of parallel cranks that must fit each other: nothing of the boundary lies beyond the region.

    The end of a crank is displaced along it alone. On the coupler a disc and the first crank's segment fill a stadium;
    what the second crank does not take up of the sum of the other two cuts it off across the cranks, at
    1 + two / 0.5e-4 from its middle.
    """
    motion = parallel_cranks().move(A=[1.0])
    worst = motion.worst_case("B", link, lengths={"two": two, "one": 1e-4, "three": 1e-4}, clearances={"B": 1e-4})
    angle = np.linspace(0.0, np.pi, 7)
    n = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    n = np.concatenate([n, -n])
    off = (worst.boundary() - motion.position("B", link)[:, None]) @ n.T
    assert np.all(off <= worst.support(n[:, None])[:, 0] * (1.0 + 1e-5))
    assert_allclose(worst.area, [1e-8 * area], rtol=5e-4, atol=1e-13)
    assert_allclose(worst.greatest, [1e-4 * greatest], rtol=5e-4)


def test_shares_of_tolerances_that_are_wider_to_one_side() -> None:
    """A drive that only lags and a crank that is only longer: shares add up to the worst case, to either side."""
    motion = arm().move(A=[0.0, 1.0])
    given = {"clearances": {"A": 1e-5}, "lengths": {"arm": (0.0, 2e-4)}, "drives": {"A": (-5e-4, 1e-4)}}
    worst = motion.worst_case("P", **given)
    for n in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.3)):
        assert_allclose(worst.contributors(n).reach.sum(axis=-1), worst.support(n), rtol=1e-12)
    table = worst.contributors((1.0, 0.0))
    assert_allclose(table.reach[0], [1e-5, 2e-4, 0.0], atol=1e-18)
    assert_allclose(worst.contributors().reach.sum(axis=-1), worst.greatest, rtol=1e-9)
    fitted = motion.allocate("P", 1e-3, diameters={"A": 0.01}, lengths={"arm": (0.0, 2e-4)})
    assert_allclose(fitted.shares()["length arm"], 2e-4 / fitted.greatest.max(), rtol=1e-9)


def test_each_clearance_of_a_batch_opens_redundant_constraints_by_itself() -> None:
    """Three parallel cranks: the worst case goes with the clearances, however large those beside them are."""
    linkage = Linkage(A=(0, 0), B=(0.1, 0.2), C=(0.3, 0), D=(0.4, 0.2), E=(0.6, 0), F=(0.7, 0.2), P=(0.5, 0.35))
    for name, on in {"one": "AB", "two": "CD", "three": "EF", "coupler": "BDFP"}.items():
        linkage.link(name, *on)
    linkage.revolute("A", "ground", "one", drive=True)
    for pin in ("B one coupler", "C ground two", "D two coupler", "E ground three", "F three coupler"):
        linkage.revolute(*pin.split())
    motion, sizes = linkage.move(A=[0.0, 0.3]), np.array([[1e-4], [1e-9], [1e-16]])
    alone = motion.worst_case("P", clearances=dict.fromkeys("BDF", 1.0)).greatest
    together = motion.worst_case("P", clearances=dict.fromkeys("BDF", sizes)).greatest
    assert_allclose(together / sizes, np.broadcast_to(alone, (3, 2)), rtol=1e-4)


def test_deviations_bring_the_point_to_where_it_is_outermost() -> None:
    """With tolerances that are wider to one side: each at an end of its own, and together the outermost point."""
    motion = arm().move(A=[0.5, 1.4])
    given = {"clearances": {"A": 1e-5}, "lengths": {"arm": (0.0, 2e-4)}, "drives": {"A": (-5e-4, 1e-4)}}
    worst = motion.worst_case("P", **given)
    for n in ((0.6, 0.8), (-0.8, 0.6), (-0.6, -0.8)):
        found = worst.deviations(n)
        moved = [limit.by[..., :3, :] @ own[..., None] for limit, own in zip(worst.limits, found, strict=True)]
        assert_allclose(np.sum(moved, axis=0)[..., 0], worst.position.extreme(n), atol=1e-18)
        pin, length, drive = found
        assert_allclose(np.linalg.norm(pin, axis=-1), 1e-5)
        across = np.array([[-np.sin(a), np.cos(a)] for a in (0.5, 1.4)]) @ n
        along = np.array([[np.cos(a), np.sin(a)] for a in (0.5, 1.4)]) @ n
        assert_allclose(length[:, 0], np.where(along > 0.0, 2e-4, 0.0), atol=1e-18)
        assert_allclose(drive[:, 0], np.where(across > 0.0, 1e-4, -5e-4), atol=1e-18)


@pytest.mark.parametrize("long", [(1.0, 1.0), (30.0, 1.0), (1000.0, 1.0), (100.0, 100.0)])
def test_the_boundary_in_space_is_as_close_however_thin_the_region(long: tuple[float, float]) -> None:
    """Needles and discs: an ellipsoid A of a ball reaches |A^T n|, and its points nearly as far in every direction."""
    turned = Rotation.from_rotvec([0.3, -0.5, 0.7]).as_matrix()
    columns = turned @ np.diag([*long, 1.0])
    points = ReachableRegion(np.zeros(3), columns, (3,), ("ball",)).boundary()
    normals = np.random.default_rng(0).normal(size=(2000, 3)) @ np.linalg.inv(columns)
    share = (points @ normals.T).max(axis=0) / np.linalg.norm(normals @ columns, axis=-1)
    assert points.shape == (180, 3)
    assert share.min() > 0.95
    assert share.max() < 1.0 + 1e-9


def test_lengths_along_one_line_have_no_curvature() -> None:
    """Parallel vectors, drawn along themselves by two rows: Newton's matrix is rounding, the sum is found all the same.

    It is least between the vectors: the sum of |a_k + m| is that of the greater two less the lesser two.
    """
    angle = np.linspace(0.0, 3.0, 200)[:, None]
    line = np.concatenate([np.cos(angle), np.sin(angle)], axis=-1)
    sizes = np.array([4.0, 3.0, 1.0, 0.5])
    along = (sizes[:, None] * line[:, None, :]).reshape(200, 8)
    row = np.tile(line, (1, 4))
    _, lengths = least_lengths(along, np.stack([row, 2.0 * row], axis=-2), [0, 2, 4, 6], [2, 2, 2, 2])
    assert_allclose(lengths.sum(axis=-1), 5.5, rtol=1e-6)
