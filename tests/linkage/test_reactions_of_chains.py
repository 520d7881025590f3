"""Reactions of many links: those that each link's equilibrium tells alone, at a cost that grows with the links."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.results.force_numbers import ForceNumbers
from linkframe.models import Linkage, Motion
from linkframe.models.linkage.statics import coefficients
from linkframe.models.linkage.statics.equilibrium import Equilibrium
from numpy.testing import assert_allclose, assert_array_equal
from numpy.typing import NDArray
from reference.linkages import rockers

from .test_long_chains import arm

Array = NDArray[np.float64]


def tree(links: int, seed: int, order: Array | None = None) -> tuple[Linkage, list[int], Array]:
    """Links in space, each but the first on an earlier one, with loads on their ends; those before them, and loads."""
    rng = np.random.default_rng(seed)
    before = [int(rng.integers(max(0, k - 4), k)) if k else -1 for k in range(links)]
    starts, ends = np.zeros((links, 3)), np.zeros((links, 3))
    for k in range(links):
        starts[k] = ends[before[k]] if before[k] >= 0 else rng.normal(size=3)
        ends[k] = starts[k] + rng.normal(size=3)
    axes, loads = rng.normal(size=(links, 3)), rng.normal(size=(links, 6))
    linkage = Linkage({f"A{k}": starts[k] for k in range(links)} | {f"B{k}": ends[k] for k in range(links)})
    for k in range(links) if order is None else order:
        # the base of a link is a point of the one that it stands on
        carried = [f"A{j}" for j in range(links) if before[j] == k]
        linkage.link(f"L{k}", f"A{k}", f"B{k}", *carried)
        names = ("fx", "fy", "fz", "mx", "my", "mz")
        linkage.load(f"B{k}", **dict(zip(names, loads[k], strict=True)))
    for k in range(links) if order is None else order:
        first = f"L{before[k]}" if before[k] >= 0 else "ground"
        linkage.revolute(f"A{k}", first, f"L{k}", axis=axes[k], drive=True)
    return linkage, before, loads


def drives(links: int, poses: int) -> dict[str, Array]:
    return {f"A{k}": np.linspace(0.0, 0.3 + 0.1 * (k % 7), poses) for k in range(links)}


@pytest.mark.parametrize("seed", [0, 1])
def test_a_joint_of_a_tree_carries_all_loads_beyond_it(seed: int) -> None:
    links = 30
    linkage, before, loads = tree(links, seed)
    motion = linkage.move(drives(links, 4))
    found = motion.reactions()
    assert set(found.method.tolist()) == {"determinate"}
    for k in range(links):
        place, force, moment = motion.position(f"A{k}"), np.zeros((4, 3)), np.zeros((4, 3))
        for j in range(k, links):
            at = j
            while at > k:
                at = before[at]
            if at == k:
                force += loads[j, :3]
                moment += loads[j, 3:] + np.cross(motion.position(f"B{j}") - place, loads[j, :3])
        expected = -np.concatenate([force, moment], axis=-1)
        scale = np.abs(expected).max()
        assert_allclose(found.force(f"A{k}"), expected, rtol=0.0, atol=1e-12 * scale)
        axis = motion.joint_axes(f"A{k}")[..., 2]
        torque = np.sum(axis * expected[:, 3:], axis=-1)
        assert_allclose(found.drive(f"A{k}")[:, 0], torque, rtol=0.0, atol=1e-12 * scale)


def test_poses_of_a_tree_do_not_depend_on_their_neighbours_nor_on_the_order_of_description() -> None:
    links = 24
    linkage, _, _ = tree(links, 3)
    given = drives(links, 150)
    whole = linkage.move(given).reactions()
    mixed, _, _ = tree(links, 3, np.random.default_rng(0).permutation(links))
    other = mixed.move(given).reactions()
    for pose in (0, 1, 149):
        one = linkage.move({name: value[pose] for name, value in given.items()}).reactions()
        for k in range(links):
            assert_array_equal(one.force(f"A{k}"), whole.force(f"A{k}")[pose])
    for k in range(links):
        size = np.abs(whole.force(f"A{k}")).max()
        assert_allclose(other.force(f"A{k}"), whole.force(f"A{k}"), rtol=0.0, atol=1e-12 * size)


def test_links_of_many_loops_are_in_equilibrium() -> None:
    """Each by itself; and the drive does the work of all weights."""
    motion = rockers(12).move(D0=np.array([-0.1, 0.0, 0.05]))
    found = motion.reactions()
    equations = Equilibrium(motion)
    wrenches = {name: found.force(name) for name in motion.linkage.joints}
    for link, centre in equations.centres.items():
        total, size = np.zeros((3, 6)), 0.0
        for name, pair in motion.linkage.joints.items():
            if link in (pair.first, pair.second):
                sign, own = (1.0 if link == pair.second else -1.0), wrenches[name]
                turning = np.cross(motion.position(pair.point, pair.second) - centre, own[:, :3])
                total += sign * np.concatenate([own[:, :3], own[:, 3:] + turning], axis=-1)
                size = max(size, float(np.abs(own).max()))
        total[:, 1] -= 9.81 * np.asarray(motion.linkage.links[link].mass)
        assert_allclose(total, 0.0, atol=1e-12 * size)
    rates = rockers(12).move(D0=np.array([-0.1, 0.0, 0.05]), rates={"D0": 1.0})
    fall = np.zeros(3)
    for name, link in rates.linkage.links.items():
        middle = np.mean([rates.linkage.points[point] for point in link.points], axis=0)
        fall += 9.81 * np.asarray(link.mass) * rates.velocity_on(name, middle)[:, 1]
    assert_allclose(found.drive("D0")[:, 0], fall, rtol=1e-10)


@pytest.mark.parametrize("make", [lambda: rockers(12), lambda: arm(20)])
def test_part_by_part_is_as_good_as_whole(make: object, monkeypatch: pytest.MonkeyPatch) -> None:
    """At poses next to a dead point and in it, too."""

    def moved() -> Motion:
        linkage: Linkage = make()  # type: ignore[operator]
        if "D0" in linkage.drives:
            ends = linkage.drive_range("D0")
            return linkage.move(D0=np.array([0.0, ends.upper - 1e-6, ends.upper]))
        return linkage.move({name: np.array([0.1, 0.0]) for name in linkage.drives})

    parts = moved().reactions()
    monkeypatch.setattr(coefficients, "MANY", 10**6)
    coefficients.PATTERNS.clear()
    whole = moved().reactions()
    coefficients.PATTERNS.clear()
    assert_array_equal(parts.method, whole.method)
    for name, force in parts.wrenches.items():
        size = np.nanmax(np.abs(whole.wrenches[name]))
        assert_allclose(force[0], whole.wrenches[name][0], rtol=0.0, atol=1e-12 * size)


def test_work_grows_with_the_links(monkeypatch: pytest.MonkeyPatch) -> None:
    """Twice the links take twice the numbers in the equations that are solved, none larger than those of a link."""
    solve, sizes = np.linalg.solve, []

    def counted(matrix: Array, *given: object) -> object:
        sizes.append(matrix.shape)
        return solve(matrix, *given)

    monkeypatch.setattr(np.linalg, "solve", counted)
    work = []
    for links in (30, 60):
        linkage, _, _ = tree(links, 5)
        motion = linkage.move(drives(links, 3))
        sizes.clear()
        motion.reactions()
        assert max(shape[-1] for shape in sizes) <= 6
        work.append(sum(int(np.prod(shape)) for shape in sizes))
    assert work[1] == 2 * work[0]


@pytest.mark.parametrize("poses", [1, 5])
def test_joints_of_a_rigid_chain_do_not_each_begin_at_its_tip(poses: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In its frame: each joint carries the loads beyond it, and each node is looked at once."""
    count, residual = 0, ForceNumbers._residual

    def counted(numbers: ForceNumbers, node: int, *, closed: bool) -> object:
        nonlocal count
        count += 1
        return residual(numbers, node, closed=closed)

    monkeypatch.setattr(ForceNumbers, "_residual", counted)
    links = 16
    linkage = Linkage({f"A{k}": (0.1 * k, 0.03 * (k % 3), 0.02 * (k % 2)) for k in range(links + 1)})
    for k in range(links):
        linkage.link(f"L{k}", f"A{k}", f"A{k + 1}")
        springs = (1e9,) * 5 + (1e6,) if k % 2 else None
        linkage.revolute(f"A{k}", f"L{k - 1}" if k else "ground", f"L{k}", drive=True, stiffness=springs)
        linkage.load(f"A{k + 1}", fx=1.0 + k, fy=-2.0, fz=0.1 * k)
    motion = linkage.move(drives(links, poses))
    solution = motion.frame().solve()
    found = {k: solution.joint_global(f"A{k}", solution.joint_force(f"A{k}")) for k in range(links)}
    assert 0 < count <= 2 * links + 1
    loads = np.array([[1.0 + k, -2.0, 0.1 * k] for k in range(links)])
    for k, wrench in found.items():
        arms = np.stack([motion.position(f"A{j + 1}", f"L{j}") - motion.position(f"A{k}") for j in range(k, links)])
        moment = np.cross(arms, loads[k:, None]).sum(axis=0)
        expected = np.concatenate([np.broadcast_to(loads[k:].sum(axis=0), (poses, 3)), moment], axis=-1)
        assert_allclose(wrench, expected, rtol=0.0, atol=1e-12 * np.abs(expected).max())
