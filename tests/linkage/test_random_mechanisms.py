"""Mechanisms of any joints drawn by chance, loops through loops: they obey the laws of motion and equilibrium."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models.linkage import KINDS, Linkage
from linkframe.models.linkage.poses.configuration import Configurations
from numpy.typing import NDArray
from reference.audit import audit

Array = NDArray[np.float64]
JOINTS = [name for name in KINDS if name != "fixed"]
# Seeds of mechanisms with five or six links and seven to nine joints, of as many freedoms as they count, none idle.
SEEDS = (575, 1022, 1066, 1149, 1688, 1957, 2026, 2077, 2283, 2597)


def mechanism(seed: int) -> tuple[Linkage, list[tuple[str, str]]]:
    """A tree of two to six links, and joints that close loops until few freedoms are left; what may drive it."""
    rng = np.random.default_rng(seed)
    names = [f"link {k}" for k in range(rng.integers(2, 7))]
    joints = []
    for k, name in enumerate(names):
        before = "ground" if k == 0 or rng.random() < 0.3 else names[rng.integers(0, k)]
        joints.append((str(rng.choice(JOINTS)), before, name))
    freedom, wanted = sum(KINDS[kind].freedom for kind, _, _ in joints), rng.integers(1, 4)
    for _ in range(30):
        kind, (first, second) = str(rng.choice(JOINTS)), rng.choice(["ground", *names], 2, replace=False)
        if freedom > wanted and freedom - KINDS[kind].rows >= 1:
            joints.append((kind, str(first), str(second)))
            freedom -= KINDS[kind].rows
    linkage = Linkage({f"P{k}": rng.uniform(-1.0, 1.0, 3) for k in range(len(joints))})
    for name in names:
        points = (f"P{k}" for k, joint in enumerate(joints) if name in joint)
        inertia = (0.2, 0.3, 0.25, 0.01, 0.02, -0.01)
        linkage.link(name, *points, mass=rng.uniform(0.5, 2.0), centre=rng.uniform(-1.0, 1.0, 3), inertia=inertia)
    for k, (kind, first, second) in enumerate(joints):
        axis, count = rng.normal(size=3), KINDS[kind].freedom
        at = rng.uniform(-0.5, 0.5, count)
        more = {
            "universal": {"second": np.cross(axis, rng.normal(size=3))},
            "screw": {"pitch": rng.uniform(0.2, 1.0)},
        }.get(kind, {})
        getattr(linkage, kind)(f"P{k}", first, second, axis=axis, reference=at if count > 1 else at[0], **more)
    linkage.gravity(5.0 * rng.normal(size=3))
    single = (pair for pair in linkage.joints.values() if pair.kind.name != "spherical")
    free = [(pair.name, component) for pair in single for component in pair.kind.coordinates]
    return linkage, [free[k] for k in rng.permutation(len(free))]


def drive(linkage: Linkage, free: list[tuple[str, str]]) -> int:
    """Drive coordinates one by one, as long as each takes a freedom away; how many freedoms are left."""
    left = linkage.mobility().actual
    for name, coordinate in free:
        before = dict(linkage.drives)
        linkage.drive(name, *before.get(name, ()), coordinate)
        space = Configurations(linkage)
        now = space.free(space.reference_state, tuple(space.mechanism.driven)).shape[1]
        if now < left:
            left = now
        else:
            linkage.drives = before
    return left


@pytest.mark.parametrize("seed", SEEDS)
def test_laws_hold(seed: int) -> None:
    linkage, free = mechanism(seed)
    found = linkage.mobility()
    assert (found.actual, found.idle, found.redundant) == (found.kutzbach, (), ())
    assert drive(linkage, free) == 0

    def path(t: Array) -> dict[str, Array]:
        out = {}
        for k, (name, those) in enumerate(linkage.drives.items()):
            pair = linkage.joint(name)
            start = [pair.reference[pair.kind.coordinates.index(component)] for component in those]
            moved = [at + 0.05 * (np.sin(t + k + i) - np.sin(k + i)) for i, at in enumerate(start)]
            out[name] = np.stack(moved, axis=-1) if len(those) > 1 else moved[0]
        return out

    audit(linkage, path)
