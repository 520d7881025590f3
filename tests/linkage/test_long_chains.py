"""Long chains: a stage is as far from its dead point as it is alone, and links are evaluated together."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage, Motion, PoseState
from linkframe.models.linkage import KINDS
from linkframe.models.linkage.continuation import assemble, one_pose
from linkframe.models.linkage.poses import singular
from linkframe.models.linkage.poses.kinematics import Kinematics
from numpy.typing import NDArray
from reference.linkages import rockers, scissor
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]


@pytest.mark.parametrize("stages", [8, 16])
def test_a_scissor_of_many_stages_is_as_good_as_one(stages: int) -> None:
    foot = np.array([-0.6, -0.4, 0.0, 0.1, 0.19, 0.19999])
    one, two, many = (scissor(count).move(slide=foot) for count in (1, 2, stages))
    assert one.state.tolist() == [PoseState.REGULAR] * 5 + [PoseState.NEAR_DEAD_POINT]
    np.testing.assert_array_equal(many.state, one.state)
    np.testing.assert_array_equal(two.state, one.state)
    np.testing.assert_allclose(many.conditioning, two.conditioning, rtol=1e-6)


def arm(links: int) -> Linkage:
    """Links one on the other, each with a mass at its end, and each with a drive of its own."""
    linkage = Linkage({f"P{k}": (0.1 * k, 0.02 * (k % 2)) for k in range(links + 1)})
    for k in range(links):
        linkage.link(f"L{k}", f"P{k}", f"P{k + 1}", mass=2.0, centre=(0.1 * (k + 1), 0.02 * ((k + 1) % 2)), inertia=0.0)
        linkage.revolute(f"P{k}", f"L{k - 1}" if k else "ground", f"L{k}", drive=True)
    linkage.gravity((0.0, -9.81))
    return linkage


@pytest.mark.parametrize("shape", [(), (40,)])
def test_links_of_a_chain_are_evaluated_together(shape: tuple[int, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    """Not each with all those before it; the drives carry what hangs on them, by the lever of each mass."""
    count, run = 0, Motion._run

    def counted(motion: Motion, *given: object) -> object:
        nonlocal count
        count += 1
        return run(motion, *given)  # type: ignore[arg-type]

    monkeypatch.setattr(Motion, "_run", counted)
    angles = {f"P{k}": np.full(shape, 0.03 * k) for k in range(12)}
    motion = arm(12).move(angles)
    found = motion.reactions()
    motion.frame()
    assert count == 2  # poses, and their motions
    places = np.stack([motion.position(f"P{k}") for k in range(13)])
    for k in range(12):
        lever = (places[k + 1 :, ..., 0] - places[k, ..., 0]).sum(axis=0)
        np.testing.assert_allclose(found.drive(f"P{k}")[..., 0], 2.0 * 9.81 * lever, rtol=1e-12)


def along_chain(kinds: list[str], axes: Array, places: Array, values: list[Array]) -> Array:
    """End of a chain drawn with its joints at places along x, by the product of what its joints do."""
    reached = places[-1]
    for kind, axis, place, value in reversed(list(zip(kinds, axes, places[:-1], values, strict=True))):
        z = axis / np.linalg.norm(axis)
        x = np.cross(np.cross(z, [1.0, 0.0, 0.0]), z)
        along = {"x": x / np.linalg.norm(x), "z": z}
        along["y"] = np.cross(along["z"], along["x"])
        arm, coordinates = reached - place, KINDS[kind].coordinates
        for k in np.argsort([name == "rz" for name in coordinates], kind="stable"):
            vector = value[..., k, None] * along[coordinates[k][1]]
            arm = Rotation.from_rotvec(vector).apply(arm) if coordinates[k][0] == "r" else arm
        shifts = [k for k, name in enumerate(coordinates) if name[0] == "u"]
        reached = place + arm + sum(value[..., k, None] * along[coordinates[k][1]] for k in shifts)
    return np.asarray(reached)


@pytest.mark.parametrize("count", [1, 7])
def test_an_open_chain_is_where_its_drives_say(count: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """However far they go, in whatever order they were described: no path is followed there."""

    def refuse(*_: object) -> None:
        raise AssertionError("a path is followed on an open chain")

    for module, name in ((assemble, "from_one"), (assemble, "Along"), (one_pose, "at_once"), (one_pose, "_on_path")):
        monkeypatch.setattr(module, name, refuse)
    rng = np.random.default_rng(5)
    kinds = ["planar", "revolute", "universal", "prismatic", "cylindrical", "planar", "universal"] * 3
    axes = np.array([0.3, 0.5, 1.0]) + 0.2 * rng.normal(size=(len(kinds), 3))
    places = np.stack([np.arange(len(kinds) + 1.0), *rng.uniform(-1.0, 1.0, (2, len(kinds) + 1))], axis=-1)
    linkage = Linkage({f"P{k}": place for k, place in enumerate(places)})
    values = [rng.uniform(-20.0, 20.0, (count, KINDS[kind].freedom)) for kind in kinds]
    for k in range(len(kinds)):
        linkage.link(f"L{k}", f"P{k}", f"P{k + 1}")
    for k in rng.permutation(len(kinds)):
        along_x = np.array([1.0, 0.0, 0.0]) - axes[k, 0] * axes[k] / (axes[k] @ axes[k])
        more = {"second": along_x} if kinds[k] == "universal" else {}
        first = f"L{k - 1}" if k else "ground"
        getattr(linkage, kinds[k])(f"P{k}", first, f"L{k}", axis=axes[k], **more)
    for k in rng.permutation(len(kinds)):
        linkage.drive(f"P{k}")
    drives = {f"P{k}": value if value.shape[-1] > 1 else value[..., 0] for k, value in enumerate(values)}
    if count == 1:
        drives = {name: value[0] for name, value in drives.items()}
        values = [value[0] for value in values]
    motion = linkage.move(drives)
    assert np.all(motion.is_regular)
    np.testing.assert_allclose(
        motion.position(f"P{len(kinds)}"), along_chain(kinds, axes, places, values), rtol=0.0, atol=1e-10
    )


def test_states_of_many_loops_take_numbers_in_proportion_to_the_loops(monkeypatch: pytest.MonkeyPatch) -> None:
    """No matrix of all equations stands for any pose, and links are evaluated together: poses and their motions, here
    and around the reference configuration."""
    stood, count, made, run = [], 0, singular.matrices, Motion._run

    def matrices(entries: list[list[object]]) -> Array:
        found = made(entries)  # type: ignore[arg-type]
        stood.append(found.size)
        return found

    def counted(motion: Motion, *given: object) -> object:
        nonlocal count
        count += 1
        return run(motion, *given)  # type: ignore[arg-type]

    numbers = []
    for loops in (8, 16):
        motion = rockers(loops).move(D0=np.linspace(-0.1, 0.1, 7))
        monkeypatch.setattr(singular, "matrices", matrices)
        monkeypatch.setattr(Kinematics, "_run", counted)
        assert (motion.state == PoseState.REGULAR).all()
        monkeypatch.undo()
        numbers.append(sum(stood))
        assert count == 4
        stood.clear()
        count = 0
    assert numbers[1] == 2 * numbers[0] > 0


def test_a_row_of_loops_is_in_the_state_of_the_worst() -> None:
    """At the dead point of the last rocker its pin moves with the drive locked, and none before it."""
    linkage = rockers(5)
    linkage.point("E", (16.0, 1.2))
    linkage.point("F", (16.2, 0.0))
    linkage.link("short", "B5", "E")
    linkage.link("last", "E", "F")
    linkage.revolute("B5", "l5", "short")
    linkage.revolute("E", "short", "last")
    linkage.revolute("F", "last", "ground")
    end = linkage.drive_range("D0").upper
    motion = linkage.move(D0=np.array([0.0, end]))
    assert motion.state.tolist() == [PoseState.REGULAR, PoseState.SINGULAR_DIRECT]
    assert "dead point of E" in str(motion.status[1])
    assert np.abs(motion.free_velocity("E")[1]).max() > 0.1
    np.testing.assert_allclose(motion.free_velocity("C3")[1], 0.0, atol=1e-7)
