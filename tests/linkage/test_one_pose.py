"""One pose of a linkage: what a batch has there, whatever was asked before, in few calls."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from benchmarks.kinematics import delta, stewart
from linkframe.models import Linkage
from linkframe.models.linkage.continuation.assemble import FEW
from linkframe.models.linkage.continuation.follow import Guide
from linkframe.models.linkage.kinematics.loop_coordinates import LAST_STEP
from linkframe.models.linkage.kinematics.loops import Loops
from reference.any_linkage import KINDS
from reference.counted import calls


def four_bar(crank: float, coupler: float, rocker: float, ground: float) -> Linkage:
    """Drawn with the crank at 60 degrees, open."""
    b = crank * np.exp(1j * np.pi / 3)
    to = ground - b
    along = (coupler**2 - rocker**2 + abs(to) ** 2) / (2.0 * abs(to))
    d = b + to / abs(to) * (along + 1j * np.sqrt(coupler**2 - along**2))
    linkage = Linkage(A=(0, 0), B=(b.real, b.imag), D=(d.real, d.imag), E=(ground, 0))
    for name, ends in {"crank": "AB", "coupler": "BD", "rocker": "DE"}.items():
        linkage.link(name, *ends)
    links = ("ground", "crank", "coupler", "rocker", "ground")
    for k, pin in enumerate("ABDE"):
        linkage.revolute(pin, links[k], links[k + 1], drive=pin == "A")
    return linkage


CASES: dict[str, Callable[[], Linkage]] = {
    "turns": lambda: four_bar(1.0, 2.5, 2.0, 3.0),
    "ends in dead points": lambda: four_bar(2.0, 1.6, 1.7, 3.1),
    "passes change points": lambda: four_bar(1.0, 3.0, 1.0, 3.0),
    "nearly passes them": lambda: four_bar(1.0, 3.0, 1.0 + 1e-9, 3.0),
}


@pytest.mark.parametrize("name", CASES)
def test_it_is_the_pose_of_a_batch_in_any_order(name: str) -> None:
    special = np.arange(-3, 4) * np.pi / 3
    angles = np.concatenate([special, special - 1e-9, special - 0.02, special[::3] + 0.06, [-40.0, -8.0, 9.0, 45.0]])
    many = CASES[name]().move(A=angles)
    place, coordinate = many.position("D"), many.coordinate("D")
    used, order = CASES[name](), np.random.default_rng(0).permutation(len(angles))
    for k in order[:18]:
        one = used.move(A=float(angles[k]))
        assert one.state == many.state[k]
        # Beside a change point some digits are lost.
        np.testing.assert_allclose(one.position("D"), place[k], rtol=0.0, atol=1e-12)
        np.testing.assert_allclose(one.coordinate("D"), coordinate[k], rtol=0.0, atol=1e-11)
    for k in order[:2]:
        np.testing.assert_array_equal(
            CASES[name]().move(A=angles[k]).position("D"), used.move(A=angles[k]).position("D")
        )


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("shape", [(1,), (2, 1), (3,), (FEW,), (FEW + 1,), (FEW + 2,), (40,)])
def test_a_short_batch_has_the_bits_of_its_poses_and_of_a_long_batch(name: str, shape: tuple[int, ...]) -> None:
    angles = np.random.default_rng(3).uniform(-7.0, 7.0, 41)
    many = CASES[name]().move(A=angles)
    count = int(np.prod(shape))
    few = CASES[name]().move(A=angles[:count].reshape(shape))
    assert few.position("D").shape == (*shape, 3)
    assert few.state.ravel().tolist() == many.state[:count].tolist()
    for told in (lambda motion: motion.position("D"), lambda motion: motion.coordinate("D"), lambda motion: motion.gap):
        np.testing.assert_array_equal(told(few).reshape(count, -1), told(many)[:count].reshape(count, -1))
    for k in range(min(count, 3)):
        alone = CASES[name]().move(A=float(angles[k]))
        np.testing.assert_array_equal(alone.position("D"), many.position("D")[k])


@pytest.mark.parametrize("robot", [delta, stewart])
def test_robots_forget_where_they_were(robot: Callable[[int], tuple[Linkage, dict[str, np.ndarray]]]) -> None:
    linkage, drives = robot(24)
    many = linkage.move(drives)
    places = many.position("P")
    order = np.random.default_rng(1).permutation(24)
    alone = {k: linkage.move({name: float(x[k]) for name, x in drives.items()}) for k in order}
    np.testing.assert_array_equal([alone[k].position("P") for k in range(24)], places)
    fresh = robot(24)[0].move({name: float(x[7]) for name, x in drives.items()})
    np.testing.assert_array_equal(fresh.position("P"), alone[7].position("P"))
    assert fresh.closure_status == many.closure_status[7] == "regular"


@pytest.mark.parametrize("robot", [delta, stewart])
@pytest.mark.parametrize("shape", [(2,), (5, 2), (1, 16), (21,)])
def test_a_few_poses_of_a_robot_are_those_of_a_long_batch(
    robot: Callable[[int], tuple[Linkage, dict[str, np.ndarray]]], shape: tuple[int, ...]
) -> None:
    linkage, drives = robot(40)
    many = linkage.move(drives, rates=dict.fromkeys(drives, 1.0))
    count = int(np.prod(shape))
    few = linkage.move({name: x[:count].reshape(shape) for name, x in drives.items()}, rates=dict.fromkeys(drives, 1.0))
    for told in ("position", "velocity", "acceleration"):
        found, expected = getattr(few, told)("P"), getattr(many, told)("P")[:count]
        assert found.shape == (*shape, 3)
        np.testing.assert_array_equal(found.reshape(count, 3), expected)


def test_drives_that_move_one_after_the_other_forget_each_other() -> None:
    """The path of the one that moved last is kept, and is not taken for that of the other."""

    def drawn() -> Linkage:
        return KINDS["two_drives"](np.random.default_rng(2)).made()

    used, poses = drawn(), [{"A": 1.0}, {"S": 0.5}, {"A": -0.8}]
    for pose in poses:
        place = used.move(pose).position("P")
        np.testing.assert_array_equal(place, drawn().move(pose).position("P"))
        assert place[0] != used.points["P"][0]


def test_rates_of_one_pose_are_those_of_a_batch() -> None:
    linkage = four_bar(1.0, 2.5, 2.0, 3.0)
    angles = np.linspace(0.0, 6.0, 7)
    many = linkage.move(A=angles, rates={"A": 3.0}, accelerations={"A": -2.0})
    for k, angle in enumerate(angles):
        one = linkage.move(A=angle, rates={"A": 3.0}, accelerations={"A": -2.0})
        for told in ("velocity", "acceleration"):
            np.testing.assert_allclose(getattr(one, told)("D"), getattr(many, told)("D")[k], rtol=1e-13)


def test_it_takes_few_calls() -> None:
    linkage = four_bar(1.0, 2.5, 2.0, 3.0)
    assert calls(lambda: linkage.move(A=2.0).position("D")) < 215


@pytest.mark.parametrize(("poses", "most"), [(1, 310), (2, 345), (360, 460)])
def test_a_batch_takes_few_calls(poses: int, most: int) -> None:
    linkage, angles = four_bar(1.0, 2.5, 2.0, 3.0), np.linspace(0.0, 6.0, poses)
    assert calls(lambda: linkage.move(A=angles).position("D")) < most


@pytest.mark.parametrize("robot", [delta, stewart])
def test_what_one_step_has_closed_is_not_closed_again(robot: Callable[[int], Any], monkeypatch: Any) -> None:
    """Where the last Newton step was below that at which the iteration ends; then the loops are closed to rounding."""
    linkage, drives = robot(24)
    linkage.move({name: float(x[0]) for name, x in drives.items()})
    steps: list[float] = []
    advance = Loops.advance

    def counted(self: Loops, state: Any, step: Any, **sign: float) -> Any:
        steps.append(max(map(abs, step)))
        return advance(self, state, step, **sign)

    monkeypatch.setattr(Loops, "advance", counted)
    ended = 0
    for k in range(1, 24):
        steps.clear()
        one = linkage.move({name: float(x[k]) for name, x in drives.items()})
        assert float(one.gap) < 2e-15
        # the Stewart platform's sweep ends in the reference configuration, which takes no step
        assert steps or (robot is stewart and k == 23)
        assert not steps or min(steps[:-1], default=1.0) > LAST_STEP >= steps[-1]
        ended += bool(steps) and steps[-1] > 1e-13
    assert ended > 6


@pytest.mark.parametrize("order", [1, -1])
def test_a_few_poses_follow_the_path_once(order: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In whatever order they are given, and with the bits of each alone."""
    count, of = 0, Guide.of

    def counted(*paths: object) -> Guide:
        nonlocal count
        count += 1
        return of(*paths)  # type: ignore[arg-type]

    monkeypatch.setattr(Guide, "of", counted)
    angles = np.linspace(-2.0, 3.0, 10)[::order]
    found = CASES["turns"]().move(A=angles).position("D")
    assert 0 < count <= 3
    alone = [CASES["turns"]().move(A=float(angle)).position("D") for angle in angles]
    np.testing.assert_array_equal(found, alone)
