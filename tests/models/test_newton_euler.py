"""Equations of equilibrium of bodies from arrays: statics by hand, the plane against space, a four-bar as a linkage."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import FourBar, Link, Linkage
from linkframe.models.newton_euler import Action, NewtonEuler, Transmitted
from numpy.testing import assert_allclose

GRAVITY = (0.3, -9.81)


def test_a_beam_on_two_supports() -> None:
    """Load F at a of a span l: F (l - a) / l on the pin, F a / l on the roller, about a centre that lies anywhere."""
    span, at, force = 2.0, 0.5, 12.0
    joints = [
        Transmitted("ground", "beam", np.array([0.0, 0.0]), np.eye(3)[:2]),
        Transmitted("beam", "ground", np.array([span, 0.0]), np.array([[0.0, -1.0, 0.0]])),
    ]
    for size in (1.0, 0.1):
        equations = NewtonEuler({"beam": np.array([1.7, 0.3])}, joints, size)
        side = equations.balanced([Action("beam", np.array([at, 0.0]), np.array([0.0, -force, 0.0]))])
        found = np.linalg.solve(equations.matrix, side)
        assert_allclose(found, [0.0, force * (span - at) / span, force * at / span], atol=1e-13)


def test_the_plane_is_that_of_space() -> None:
    """Two bodies, a joint between them and one to the ground, over a batch of places, sizes and loads."""
    rng = np.random.default_rng(0)
    plane, space = [0, 1, 5], np.array([1.0, 1.0, 0.0])
    centres = {"one": rng.normal(size=(4, 1, 3)) * space, "two": rng.normal(size=3) * space}
    places = rng.normal(size=(3, 4, 1, 3)) * space
    wrenches, load = rng.normal(size=(2, 6)), rng.normal(size=(5, 6))
    wrenches[:, 2:5] = load[:, 2:5] = 0.0
    size = rng.uniform(0.5, 2.0, (4, 1))
    ends = (("ground", "one"), ("one", "two"))

    def equations(d: int, components: list[int]) -> tuple[NewtonEuler, np.ndarray]:
        joints = [
            Transmitted(*pair, place[..., :d], wrenches[:, components])
            for pair, place in zip(ends, places[:2], strict=True)
        ]
        made = NewtonEuler({name: centre[..., :d] for name, centre in centres.items()}, joints, size)
        acting = [Action(name, places[2][..., :d], load[:, components]) for name in ("one", "two", "one")]
        return made, made.balanced(acting)

    (flat, flat_side), (full, full_side) = equations(2, plane), equations(3, list(range(6)))
    rows = [*plane, *(6 + k for k in plane)]
    assert_allclose(flat.matrix, full.matrix[..., rows, :], atol=1e-15)
    assert_allclose(flat_side, full_side[..., rows], atol=1e-15)
    assert not np.delete(full.matrix, rows, axis=-2).any()
    some = np.zeros((3, *flat.matrix.shape[-2:]))
    some[:, *flat.places] = flat.numbers((4, 5), np.array([0, 7, 19]))
    assert_allclose(some, flat.matrix[[0, 1, 3], 0], atol=0.0)


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_random_four_bars_carry_what_linkages_carry(branch: str) -> None:
    """Reactions and drive torque with masses, inertia, loads and gravity, as shares of the greatest."""
    rng = np.random.default_rng(0)
    lengths, theta = rng.uniform(0.05, 0.3, (4, 400)), rng.uniform(0.0, 2.0 * np.pi, 400)
    four_bar = FourBar(*lengths, branch=branch)
    good = four_bar.assembles(theta)
    good[good] = np.sin(FourBar(*lengths[:, good], branch=branch).move(theta[good]).transmission_angle) > 0.05
    motion = FourBar(*lengths[:, good], branch=branch).move(theta[good], 3.0, -2.0)
    links = {
        name: Link(mass, (0.06, 0.02), 0.01, force=(3.0, -7.0), at=(0.05, 0.1), torque=0.4)
        for name, mass in (("crank", 2.0), ("coupler", 3.0), ("rocker", 1.0))
    }
    linkage = Linkage({point: motion.position(point) for point in "ABDE"})
    for name, ends in (("crank", "AB"), ("coupler", "BD"), ("rocker", "DE")):
        link = links[name]
        linkage.point(name, motion.position_on(name, *link.at))
        centre = motion.position_on(name, *link.centre)
        linkage.link(name, *ends, name, mass=link.mass, centre=centre, inertia=link.inertia)
        linkage.load(name, fx=link.force[0], fy=link.force[1])
        linkage.torque(name, mz=link.torque)
    linkage.gravity((*GRAVITY, 0.0))
    linkage.revolute("A", "ground", "crank", drive=True, reference=motion.theta)
    for joint, pair in (("B", ("coupler", "crank")), ("D", ("rocker", "coupler")), ("E", ("ground", "rocker"))):
        linkage.revolute(joint, *pair)
    theirs = linkage.move(A=motion.theta, rates={"A": 3.0}, accelerations={"A": -2.0}).reactions()
    ours = motion.reactions(**links, gravity=GRAVITY)
    size = np.abs(ours.unknowns).max(axis=-1)
    assert size.size > 100
    for joint in "ABDE":
        apart = np.abs(theirs.force(joint)[:, :3] - ours.reaction(joint)).max(axis=-1)
        assert_allclose(apart / size, 0.0, atol=1e-11)
    assert_allclose((theirs.drive("A")[:, 0] - ours.drive_torque) / size, 0.0, atol=1e-11)


def test_linkages_of_a_single_point_and_of_none() -> None:
    """A wheel about its centre, with no length at all: the drive bears the torque, the pin the weight."""
    wheel = Linkage(A=(0.0, 0.0))
    with pytest.raises(FrameError, match=r"the linkage has no links that could be in equilibrium: describe them"):
        wheel.move().reactions()
    wheel.link("wheel", "A", mass=2.0, inertia=0.1)
    wheel.revolute("A", "ground", "wheel", drive=True)
    wheel.torque("wheel", mz=3.0)
    wheel.gravity((0.0, -10.0, 0.0))
    found = wheel.move(A=[0.0, 1.0], accelerations={"A": 5.0}).reactions()
    assert_allclose(found.drive("A"), np.full((2, 1), 0.1 * 5.0 - 3.0), rtol=1e-15)
    assert_allclose(found.force("A")[:, :3], [[0.0, 20.0, 0.0]] * 2, atol=1e-14)
