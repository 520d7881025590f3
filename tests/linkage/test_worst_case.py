"""The worst that clearances and tolerances can do: against loops closed anew, samples, closed forms, and contact."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import FourBar, Linkage, ReachableRegion
from linkframe.models.four_bar.clearance import clearance_displacement
from numpy.testing import assert_allclose
from scipy.optimize import linprog

from ..reference.any_linkage import KINDS
from ..reference.counted import calls
from ..reference.linkages import parallel_cranks
from .test_position_sensitivity import four_bar

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3, density=7850.0))
SPECIAL = FourBar(crank=0.1, coupler=0.25, rocker=0.2, ground=0.22, point=(0.12, 0.05), beam=BAR)
THETA = np.radians(np.arange(20.0, 160.0, 20.0))
PINS = (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground"))


def drawn(four: FourBar, clearance: object = None, beam: object = None) -> Linkage:
    motion = four.move(1.0)
    linkage = Linkage({point: motion.position(point) for point in "ABPDE"})
    linkage.link("crank", "A", "B", beam=beam)  # type: ignore[arg-type]
    linkage.link("coupler", "B", "P", "D", beam=beam)  # type: ignore[arg-type]
    linkage.link("rocker", "D", "E", beam=beam)  # type: ignore[arg-type]
    linkage.revolute("A", "ground", "crank", drive=True, reference=1.0)
    for point, first, second in PINS:
        linkage.revolute(point, first, second, clearance=clearance)  # type: ignore[arg-type]
    return linkage


def around(count: int) -> np.ndarray:
    angle = 2.0 * np.pi * np.arange(count) / count
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def test_a_million_loops_closed_anew() -> None:
    """Of 10^6 offsets, random ones and those of the worst cases, no closed loop is outside; some touch the boundary.

    The loops are closed by the circles of coupler and rocker, exactly; the clearance is so small that what is of second
    order does not count.
    """
    eps, n = 1e-10, 1_000_000 // len(THETA)
    rng, directions = np.random.default_rng(0), around(16)
    worst = drawn(SPECIAL, clearance=eps).move(A=THETA).worst_case("P")
    motion, region = worst.sensitivity.motion, worst.position
    adversarial = worst.deviations(directions[:, None])
    for k, theta in enumerate(THETA):
        offsets = eps * np.sqrt(rng.uniform(0.0, 1.0, (3, n))) * np.exp(2j * np.pi * rng.uniform(0.0, 1.0, (3, n)))
        offsets[:, ::2] *= eps / np.abs(offsets[:, ::2])
        for j, own in enumerate(adversarial):
            place = own[:, k] @ motion.joint_axes(PINS[j][0])[k, :2, :2].T
            offsets[j, : len(place)] = place[:, 0] + 1j * place[:, 1]
        closed = clearance_displacement(SPECIAL.move(theta), dict(zip("BDE", offsets, strict=True)))[:, :2] / eps
        here = ReachableRegion(np.zeros(3), region.columns[k] / eps, region.sizes, region.names)
        apart = closed @ directions.T - here.support(directions)
        assert apart.max() < 1e-6
        assert np.all(np.abs(np.diagonal(apart)) < 1e-6)


def test_samples_of_many_tolerances_stay_within_and_touch() -> None:
    """Of the linear map itself, to rounding: random and adversarial deviations, planar and spatial."""
    rng = np.random.default_rng(1)
    for kind in ("six_bar", "rusp", "three_rps"):
        linkage = KINDS[kind](np.random.default_rng(3)).made()
        motion = linkage.move()
        joints = dict.fromkeys(list(linkage.joints)[:4], 1e-4)
        region = motion.worst_case(
            "P", clearances=joints, lengths={"a": 2e-4} if "a" in linkage.links else None
        ).position
        n = 20_000
        parts = []
        for size in region.sizes:
            own = rng.normal(size=(n, size))
            own *= (rng.uniform(size=n) ** 0.2 / np.linalg.norm(own, axis=1))[:, None]
            parts.append(own)
        points = np.concatenate(parts, axis=1) @ region.columns.T
        directions = rng.normal(size=(200, 3))
        directions /= np.linalg.norm(directions, axis=1)[:, None]
        reach = region.support(directions)
        assert np.all(points @ directions.T <= reach * (1.0 + 1e-12))
        worst = region.deviations(directions) @ region.columns.T
        assert_allclose(np.sum(worst * directions, axis=1), reach, rtol=1e-12)
        assert_allclose(worst, region.extreme(directions), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize(("edges", "rtol"), [(0, 2e-5), (3, 2e-3)])
def test_area_by_three_formulas(edges: int, rtol: float) -> None:
    """Closed form; 1/2 of the integral of h^2 - h'^2; the polygon of support lines.

    With intervals and a joint of rank 1 there are straight edges, whose directions the sums miss by up to a step.
    """
    columns = np.concatenate([np.random.default_rng(2).normal(size=(30, 2, 8)), np.zeros((30, 1, 8))], axis=1)
    if edges:
        columns[:, :, 1] = 2.0 * columns[:, :, 0]
    sizes = (2, 2, 2, 1, 1) if edges else (2, 2, 2, 2)
    region = ReachableRegion(np.zeros(3), columns, sizes, tuple("abcde")[: len(sizes)])
    n = 4000
    step = 2.0 * np.pi / n
    angle = step * (np.arange(n) + 0.5)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    h, point = region.support(normal[:, None]).T, np.moveaxis(region.extreme(normal[:, None]), 0, 1)
    slope = point[..., 1] * np.cos(angle) - point[..., 0] * np.sin(angle)
    assert_allclose(region.area, 0.5 * step * np.sum(h**2 - slope**2, axis=1), rtol=rtol)
    # Along each support line from the corner with the one before to that with the next.
    ahead = (np.roll(h, -1, axis=1) - h * np.cos(step)) / np.sin(step)
    behind = (h * np.cos(step) - np.roll(h, 1, axis=1)) / np.sin(step)
    assert_allclose(region.area, 0.5 * np.sum(h * (ahead - behind), axis=1), rtol=rtol)
    x, y, _ = np.moveaxis(region.boundary(2000), -1, 0)
    inside = 0.5 * np.sum(x * np.roll(y, -1, -1) - y * np.roll(x, -1, -1), axis=-1)
    assert_allclose(region.area, inside, rtol=1e-4)
    assert np.all(inside <= region.area * (1.0 + 1e-12))


def test_area_and_volume_of_what_is_known() -> None:
    """Stadium, parallelogram; ellipsoid, cylinder, zonotope: sums of |det| of all pairs and triples of edges."""
    none, rng = np.zeros(3), np.random.default_rng(3)
    stadium = ReachableRegion(none, np.array([[1.0, 0, 2], [0, 1, 0], [0, 0, 0]]), (2, 1), ("disc", "slot"))
    assert_allclose(stadium.area, np.pi + 8.0, rtol=1e-14)
    assert_allclose(stadium.boundary(400)[..., 0].max(), 3.0)
    edges = rng.normal(size=(3, 6))
    flat = ReachableRegion(none, edges * np.array([[1.0], [1.0], [0.0]]), (1,) * 6, tuple("abcdef"))
    assert_allclose(
        flat.area, 4.0 * sum(abs(np.linalg.det(edges[:2, c])) for c in combinations(range(6), 2)), rtol=1e-13
    )
    whole = ReachableRegion(none, edges, (1,) * 6, tuple("abcdef"))
    assert_allclose(
        whole.volume, 8.0 * sum(abs(np.linalg.det(edges[:, c])) for c in combinations(range(6), 3)), rtol=1e-13
    )
    assert_allclose(
        ReachableRegion(none, edges[:, :3], (3,), ("a",)).volume, 4.0 / 3.0 * np.pi * abs(np.linalg.det(edges[:, :3]))
    )
    cylinder = ReachableRegion(none, np.eye(3), (2, 1), ("disc", "height"))
    assert_allclose(cylinder.volume, 2.0 * np.pi)
    capsule = ReachableRegion(none, np.concatenate([np.eye(3), [[0], [0], [1]]], axis=1), (3, 1), ("ball", "way"))
    assert_allclose(capsule.volume, 4.0 / 3.0 * np.pi + 2.0 * np.pi, rtol=1e-3)
    with pytest.raises(FrameError, match="it has a volume, and no area"):
        whole.area  # noqa: B018


def test_farthest_point() -> None:
    """Against all corners of a zonotope, and a fine search all around."""
    rng = np.random.default_rng(4)
    edges = rng.normal(size=(20, 3, 7))
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * 7)).reshape(7, -1)
    region = ReachableRegion(np.zeros(3), edges, (1,) * 7, tuple("abcdefg"))
    assert_allclose(region.greatest, np.linalg.norm(edges @ signs, axis=1).max(axis=-1), rtol=1e-12)
    assert_allclose(region.support(region.direction), region.greatest, rtol=1e-12)
    off = ReachableRegion(np.array([0.3, 0.1, 0.0]), edges[0], (1,) * 7, tuple("abcdefg"))
    corners = (edges[0] @ signs).T + off.centre
    assert_allclose(off.greatest, np.linalg.norm(corners, axis=1).max(), rtol=1e-12)


def test_equal_clearances_of_one_loop_contribute_equally() -> None:
    """To the direction of a link (Ting, Zhu & Watkins, Mechanism and Machine Theory 35, 2000)."""
    rng = np.random.default_rng(5)
    lengths = rng.uniform([0.5, 2.0, 2.0, 2.5], [1.0, 3.0, 3.0, 3.0], (100, 4))
    linkage = four_bar(*lengths.T, rng.uniform(0.0, 6.0, 100), 1.0, 0.5)
    worst = linkage.move().worst_case("D", "coupler", clearances=dict.fromkeys("ABDE", 1e-4))
    share = worst.rotation.contributions((0, 0, 1))
    assert_allclose(share, share[:, [0, 0, 0, 0]], rtol=1e-12)
    assert_allclose(worst.angle, share.sum(axis=1), rtol=1e-12)


def test_the_extreme_point_in_the_direction_of_a_load_is_contact_in_equilibrium() -> None:
    motion = drawn(SPECIAL, clearance=1e-5, beam=BAR).move(A=THETA)
    for direction in around(5):
        found = motion.accuracy("P", fx=1e-3 * direction[0], fy=1e-3 * direction[1]).clearance[:, :2]
        assert_allclose(found, motion.worst_case("P").position.extreme(direction)[:, :2], rtol=0.0, atol=1e-11)


def test_contributors() -> None:
    """Shares add up to the whole; the variance of samples that are spread evenly is that of the table."""
    worst = (
        drawn(SPECIAL, clearance=1e-5)
        .move(A=THETA)
        .worst_case(
            "P",
            lengths={"crank": 2e-5, ("coupler", "B", "D"): (0.0, 1e-5)},
            drives={"A": 1e-4},
            places={("ground", "E"): 1e-5},
        )
    )
    table = worst.contributors()
    assert set(table.names) == {
        "joint B",
        "joint D",
        "joint E",
        "length crank",
        "length coupler B-D",
        "drive A",
        "place ground.E",
    }
    assert_allclose(table.worst.sum(axis=-1), 100.0)
    assert_allclose(table.of_variance.sum(axis=-1), 100.0)
    assert_allclose(table.reach.sum(axis=-1), worst.greatest, rtol=1e-9)
    assert table.ranked[0] == table.names[int(np.argmax(table.reach[np.argmax(table.reach.sum(axis=-1))]))]
    text = repr(worst).splitlines()
    assert len(text) == 9
    assert text[1].split() == ["contributor", "worst", "case", "%", "variance", "%"]
    rng, n = np.random.default_rng(6), 200_000
    n_dir = np.array([1.0, 0.0, 0.0])
    total = np.zeros(n)
    region, at = worst.position, 0
    for size in region.sizes:
        own = rng.normal(size=(n, size))
        own *= (rng.uniform(size=n) ** (1.0 / size) / np.linalg.norm(own, axis=1))[:, None]
        total += own @ (n_dir @ region.columns[2][:, at : at + size])
        at += size
    assert_allclose(total.std(), worst.contributors(n_dir).deviation[2], rtol=0.01)


def test_envelope_along_the_path() -> None:
    """All regions of neighbouring poses stay within the band, to second order."""
    theta = np.radians(np.linspace(20.0, 40.0, 81))
    linkage = drawn(SPECIAL, clearance=1e-6)
    motion = linkage.move(A=theta)
    worst = motion.worst_case("P")
    band = worst.envelope()
    assert band.shape == (81, 2, 3)
    tangent = motion.sensitivity("P").drives["A"][40, :3, 0]
    normal = np.cross([0, 0, 1.0], tangent / np.linalg.norm(tangent))
    nominal = motion.position("P")
    assert_allclose(np.abs((band[40] - nominal[40]) @ normal), worst.support(normal)[40], rtol=1e-12)
    with_rates = linkage.move(A=theta, rates={"A": 2.0}).worst_case("P").envelope()
    assert_allclose(with_rates, band, rtol=0.0, atol=1e-15)


def test_three_hundred_and_sixty_poses_take_few_calls_more_than_one() -> None:
    """No loop over the poses: the farthest points alone are sought some hundred poses at a time."""
    linkage = KINDS["six_bar"](np.random.default_rng(0)).made()

    def work(count: int) -> int:
        motion = linkage.move(A=np.linspace(0.0, 1.0, count))

        def ask() -> None:
            worst = motion.worst_case("P", clearances=dict.fromkeys(linkage.joints, 1e-4))
            shapes = (worst.boundary(90).shape[:1], worst.area.shape, worst.greatest.shape, worst.angle.shape)
            assert set(shapes) == {(count,)}

        return calls(ask)

    assert work(360) < 1.2 * work(1)


def meeting(one: complex, other: complex, near: complex, first: float, second: float) -> complex:
    """Where circles of these radii about two points meet, on the side of a third point."""
    chord = other - one
    along = (first**2 - second**2 + abs(chord) ** 2) / (2.0 * abs(chord))
    across = np.sqrt(first**2 - along**2) * np.sign(((near - one) / chord).imag)
    return one + chord / abs(chord) * (along + 1j * across)


def test_poses_beside_others_that_cannot_be_assembled() -> None:
    """A six-bar of Watt's that turns part of the way: the clearance of B, by the circles on which C and F lie."""
    at = {"A": 0j, "B": 0.1j, "C": 0.25 + 0.18j, "D": 0.2 + 0j, "E": 0.1 + 0.25j, "F": 0.35 + 0.3j, "G": 0.45 + 0.05j}
    linkage = Linkage({name: (z.real, z.imag) for name, z in at.items()})
    for name, points in {"crank": "AB", "coupler": "BCE", "rocker": "DC", "arm": "EF", "last": "FG"}.items():
        linkage.link(name, *points)
    linkage.revolute("A", "ground", "crank", drive=True)
    pins = "B crank coupler, C coupler rocker, D rocker ground, E coupler arm, F arm last, G last ground"
    for pin in pins.split(", "):
        linkage.revolute(*pin.split())
    theta = np.radians(np.arange(0.0, 360.0, 20.0))
    motion = linkage.move(A=theta)
    worst = motion.worst_case("F", clearances={"B": 1e-5})
    assert not motion.is_regular.all()

    def place(turned: float, offset: complex, near: dict[str, complex]) -> complex:
        b = at["B"] * np.exp(1j * turned) + offset
        length = {pair: abs(at[pair[0]] - at[pair[1]]) for pair in ("BC", "DC", "EF", "GF")}
        c = meeting(b, at["D"], near["C"], length["BC"], length["DC"])
        e = b + (c - b) * (at["E"] - at["B"]) / (at["C"] - at["B"])
        return meeting(e, at["G"], near["F"], length["EF"], length["GF"])

    for k in np.flatnonzero(motion.is_regular):
        near = {name: complex(*motion.position(name)[k, :2]) for name in "CF"}
        rates = [(place(theta[k], h, near) - place(theta[k], -h, near)) / 2e-7 for h in (1e-7, 1e-7j)]
        by = np.array([[rate.real for rate in rates], [rate.imag for rate in rates]])
        assert_allclose(worst.greatest[k], 1e-5 * np.linalg.norm(by, 2), rtol=1e-6)


def test_what_is_refused() -> None:
    motion = drawn(SPECIAL).move()
    with pytest.raises(FrameError, match="nothing that deviates"):
        motion.worst_case("P")
    with pytest.raises(FrameError, match=r"length 'coupler' is none: name a link of two points \(crank, rocker\)"):
        motion.worst_case("P", lengths={"coupler": 1e-5})
    with pytest.raises(FrameError, match="clearance of joint 'B' is -1e-05: give zero or above"):
        motion.worst_case("P", clearances={"B": -1e-5})
    with pytest.raises(FrameError, match="joint 'B' is not driven: the drives are A"):
        motion.worst_case("P", drives={"B": 1e-5})
    with pytest.raises(FrameError, match="give the lower deviation before the upper one"):
        motion.worst_case("P", lengths={"crank": (1e-5, 0.0)})
    with pytest.raises(FrameError, match="has the length of a bearing and no clearance"):
        motion.worst_case("P", journals={"B": 0.02})
    with pytest.raises(FrameError, match="is no point of a link"):
        motion.worst_case("P", places={("crank", "D"): 1e-5})
    with pytest.raises(FrameError, match=r"direction is .*: give a direction"):
        motion.worst_case("P", clearances={"B": 1e-5}).support((0, 0))


def test_a_bearing_tilts_by_twice_the_clearance_over_its_length() -> None:
    """An arm of 0.5 along x, its pin in a bearing of length 0.04 with 0.1 mm of clearance and 0.2 mm of end play."""
    arm = Linkage(A=(0, 0), B=(0.5, 0))
    arm.link("arm", "A", "B")
    arm.revolute("A", "ground", "arm", drive=True, clearance=1e-4)
    worst = arm.move(A=[0.0, 0.7]).worst_case("B", journals={"A": 0.04}, end_play={"A": 2e-4})
    assert_allclose(worst.support((0, 0, 1)), 0.5 * 2.0 * 1e-4 / 0.04 + 2e-4, rtol=1e-14)
    assert_allclose(worst.angle, 2.0 * 1e-4 / 0.04, rtol=1e-12)
    assert_allclose(worst.support((1, 0, 0)), 1e-4, rtol=1e-14)
    assert_allclose(worst.position.half_widths[:, 2], worst.support((0, 0, 1)))


def test_a_slider_tilts_in_its_slot() -> None:
    """A slider of length 0.1 along x, driven, its tip 0.3 ahead and 0.2 aside of its middle."""
    linkage = Linkage(S=(0, 0), P=(0.3, 0.2))
    linkage.link("slider", "S", "P")
    linkage.prismatic("S", "ground", "slider", axis=(1, 0), drive=True, clearance=1e-4)
    worst = linkage.move(S=0.05).worst_case("P", journals={"S": 0.1})
    # Of both ends at (d1 + d2)/2 and turned by (d1 - d2)/L in the plane.
    assert_allclose(worst.support((0, 1)), 1e-4 * (abs(0.5 + 0.3 / 0.1) + abs(0.5 - 0.3 / 0.1)), rtol=1e-14)
    assert_allclose(worst.support((1, 0)), 1e-4 * 2.0 * 0.2 / 0.1, rtol=1e-14)


def test_redundant_constraints_bind_the_clearances() -> None:
    """A plane four-bar whose bearings tilt, across its plane: a linear program with discs of 180 edges.

    In the plane the constraints across it do not bind, and the bearings' ends together do what their middles can.
    """
    motion = drawn(SPECIAL).move(A=THETA[:2])
    limits = dict.fromkeys("ABDE", 1e-4)
    region = motion.worst_case("P", clearances=limits, journals=dict.fromkeys("ABDE", 0.02), end_play=limits).position
    assert region.stress is not None
    plane = motion.worst_case("P", clearances=limits)
    assert_allclose(region.support((0.6, 0.8)), plane.support((0.6, 0.8)), rtol=1e-9)
    angle = np.pi / 90.0 * np.arange(180)
    rows, at = [], 0
    for size in region.sizes:
        for edge in np.stack([np.cos(angle), np.sin(angle)], axis=-1) if size == 2 else [[1.0], [-1.0]]:
            rows.append(np.zeros(region.columns.shape[-1]))
            rows[-1][at : at + size] = edge
        at += size
    columns, stress = region.columns[1] / 1e-4, region.stress[1] / np.abs(region.stress[1]).max()
    for n in ((0.0, 0.0, 1.0), (0.5, -0.3, 0.4)):
        n_unit = np.array(n) / np.linalg.norm(n)
        bound = np.ones(len(rows))
        found = linprog(
            -n_unit @ columns, A_ub=np.array(rows), b_ub=bound, A_eq=stress, b_eq=[0.0] * 3, bounds=(None, None)
        )
        assert_allclose(region.support(n)[1] / 1e-4, -found.fun, rtol=2e-4)
        deviations = region.deviations(n)[1]
        assert np.abs(stress @ deviations).max() < 1e-3
        assert_allclose(n_unit @ columns @ deviations, region.support(n)[1] / 1e-4, rtol=1e-4)
    assert (region.greatest >= region.support((0, 0, 1)) * (1.0 - 1e-9)).all()


def test_clearance_that_is_not_small() -> None:
    """Against a search over the contact angles of all three pins; first order is off in proportion."""
    theta, n, off = np.array([1.5, 2.0]), np.array([0.6, 0.8, 0.0]), []
    angle = 2.0 * np.pi * np.arange(24) / 24.0
    for eps in (5e-4, 4e-3):
        worst = drawn(SPECIAL, clearance=eps).move(A=theta).worst_case("P")
        found = worst.finite(n)
        for k, own in enumerate(theta):
            best = np.zeros(3)
            for width in (1.0, 0.12, 0.015, 2e-3):
                grid = np.meshgrid(*(centre + width * (angle - np.pi) for centre in best), indexing="ij", sparse=True)
                offsets = dict(zip("BDE", (eps * np.exp(1j * g) for g in grid), strict=True))
                reach = clearance_displacement(SPECIAL.move(own), offsets) @ n
                at = np.unravel_index(np.nanargmax(reach), reach.shape)
                best = np.array([np.broadcast_to(g, reach.shape)[at] for g in grid])
            assert_allclose(found.reach[k], np.nanmax(reach), rtol=1e-6)
        off.append(np.abs(found.difference).max())
    assert 5.0 < off[1] / off[0] < 12.0
    assert "first order is off by up to" in repr(found)
    with pytest.raises(FrameError, match="drive A is none that contact can take up"):
        worst.sensitivity.motion.worst_case("P", drives={"A": 1e-3}).finite()  # type: ignore[attr-defined]


def test_middles_of_tolerances_that_do_not_close_overconstrained_loops() -> None:
    """Three parallel cranks: the length of the middle one has to be the mean of the others."""
    motion = parallel_cranks().move(A=[1.0, 1.5])
    with pytest.raises(FrameError, match="middles"):
        motion.worst_case("D", lengths={"two": (0.0, 2e-4)}).support((0, 1))
    # All of them longer by the same.
    together = dict.fromkeys(("one", "two", "three"), (0.0, 2e-4))
    found, even = (
        motion.worst_case("D", lengths=together),
        motion.worst_case("D", lengths=dict.fromkeys(together, 1e-4)),
    )
    along = motion.position("D") - motion.position("C")
    along /= np.linalg.norm(along, axis=-1, keepdims=True)
    assert_allclose(found.support(along), even.support(along) + 1e-4, rtol=1e-6)
    assert_allclose(found.support(-along), even.support(-along) - 1e-4, atol=1e-10)


def test_no_poses_have_no_contributors() -> None:
    worst = drawn(SPECIAL, clearance=1e-4).move(A=np.zeros(0)).worst_case("P")
    found = worst.contributors()
    assert "no pose" in repr(found)
    assert found.deviation.shape == (0,)
    with pytest.raises(FrameError, match="the motion has no poses"):
        _ = found.ranked
