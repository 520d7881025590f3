"""A pose has the same bits alone, in a batch of any size, and wherever it stands in it."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from benchmarks.kinematics import delta, stewart
from linkframe.models import Linkage, Motion
from reference.any_linkage import KINDS

Drives = dict[str, np.ndarray]


def drawn(kind: str, count: int) -> tuple[Linkage, Drives]:
    """A linkage of a kind, and poses within the reach of its drives; in some of them a drive or all of them stand."""
    rng = np.random.default_rng(7)
    recipe = KINDS[kind](rng)
    linkage = recipe.made()
    drives = {}
    for name, reach in recipe.reach.items():
        home = float(linkage.joint(name).reference[0])
        drives[name] = home + rng.uniform(-reach, reach, count) * (rng.uniform(size=count) > 0.2)
    return linkage, drives


def at_home(robot: Callable[[int], tuple[Linkage, Drives]], count: int) -> tuple[Linkage, Drives]:
    """Poses of a robot, of which some are the reference configuration and in some only one drive has moved."""
    linkage, drives = robot(count)
    rng = np.random.default_rng(3)
    for name, given in drives.items():
        home = float(linkage.joint(name).reference[0])
        given[rng.uniform(size=count) < 0.1] = home
        given[:2] = home
        given[2] = home if name != "M1" else given[2]
    return linkage, drives


def numbers(motion: Motion) -> np.ndarray:
    """Everything that a motion says of its poses, (poses, n)."""
    told = [motion.position("P"), motion.gap[..., None], motion.axes(next(iter(motion.linkage.links))).reshape(-1, 9)]
    told += [motion.coordinate(name).reshape(motion.position("P")[..., 0].size, -1) for name in motion.linkage.joints]
    return np.concatenate([x.reshape(told[0].reshape(-1, 3).shape[0], -1) for x in told], axis=1)


CASES: dict[str, Callable[[int], tuple[Linkage, Drives]]] = {
    "delta robot": delta,
    "delta robot, some arms at home": lambda count: at_home(delta, count),
    "Stewart platform": stewart,
    "Stewart platform, some legs at home": lambda count: at_home(stewart, count),
    **{kind: lambda count, kind=kind: drawn(kind, count) for kind in KINDS},
}


@pytest.mark.parametrize("name", CASES)
def test_a_pose_alone_is_that_of_any_batch(name: str) -> None:
    linkage, drives = CASES[name](40)
    whole = linkage.move(drives)
    expected, states = numbers(whole), whole.state
    order = np.append(np.random.default_rng(0).permutation(40), range(3))
    for first, size in ((0, 11), (11, 2), (13, 1), (40, 3), (0, 43)):
        chosen = order[first : first + size]
        part = linkage.move({joint: values[chosen] for joint, values in drives.items()})
        np.testing.assert_array_equal(numbers(part), expected[chosen])
        assert part.state.tolist() == states[chosen].tolist()
    for k in order[-9:]:
        alone = linkage.move({joint: float(values[k]) for joint, values in drives.items()})
        np.testing.assert_array_equal(numbers(alone)[0], expected[k])
    fresh = CASES[name](40)[0].move({joint: float(values[k]) for joint, values in drives.items()})
    np.testing.assert_array_equal(numbers(fresh)[0], expected[k])
