"""What is special about each pose of a motion: singular, of which kind and at which joint, or near a dead point."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.states import States, words
from ..description.parts import GROUND
from ..kinematics.linear import matrices
from .configuration import extent
from .held import MOVES, moving_joints
from .states import PoseState, closure_states, singular_states

if TYPE_CHECKING:
    from ..motion import Motion

Bools = NDArray[np.bool_]
# A pose is singular below this conditioning: a pose next to a dead point is good to half the digits at best.
SINGULAR = 1e-7
# Below this rounding does not tell one branch from the other.
ONE_BRANCH = 1e-5
# Below this it is near a dead point; for a four-bar with bars of like length, some 2° from it.
NEAR = 1e-2
# A velocity below this share of what it is elsewhere is none.
STILL = 1e-9


def conditioning(motion: Motion) -> tuple[Array, Array]:
    """How firmly the drives hold each pose, (...), and the motion (..., n) of the unknowns that they hold least.

    The least singular value of the closing equations by the unknown coordinates over the greatest, lengths in units of
    the linkage's extent: 0 where something moves with the drives held. Those that always vanish, of a rod that can turn
    about itself, do not count. Where loops can be closed one after the other, each has its own, in units of its own
    extent, and the least of these counts: a chain is not near a dead point for being long.
    """
    mechanism, loops = motion.mechanism, motion.assembly.loops
    shape, n, rank = motion.assembly.shape, loops.columns, loops.linear.rank
    if not rank:
        return np.ones(shape), np.zeros((*shape, n))
    with np.errstate(all="ignore"):
        entries = mechanism.newton[1](motion.assembly.state, mechanism.parameters)[loops.rows :]
    matrix = matrices([list(entries[i * n : i * n + n]) for i in range(loops.rows)])
    share = mechanism.size / extent(mechanism.linkage)
    rows = [share if mechanism.rows[i][1][0] == "u" else 1.0 for i in mechanism.active]
    columns = [share if mechanism.columns[k][1][0] == "u" else 1.0 for k in mechanism.unknown]
    there = motion.assembly.closed[..., None, None]
    matrix = np.where(there, matrix, 1.0) * np.array(rows)[:, None] / np.array(columns)
    margin = np.where(motion.assembly.closed, _firmness(motion, matrix), np.nan)
    least = np.zeros((*shape, n))
    bad = np.broadcast_to(margin < SINGULAR, shape)
    if bad.any():
        least[bad] = np.linalg.svd(np.broadcast_to(matrix, (*shape, *matrix.shape[-2:]))[bad])[2][:, rank - 1]
    return np.broadcast_to(margin, shape), least / np.array(columns)


def _firmness(motion: Motion, matrix: Array) -> Array:
    """Least over greatest singular value of the closing equations (..., m, n), the least of those of sets of loops that
    close one after the other, (...)."""
    mechanism, linear = motion.mechanism, motion.assembly.loops.linear
    if not linear.square or len(linear.blocks) < 2:
        values = np.linalg.svd(matrix, compute_uv=False)
        return np.asarray(values[..., linear.rank - 1] / values[..., 0])
    whole = extent(motion.linkage)
    found = []
    for rows, columns in linear.blocks:
        names = [mechanism.unknown[k] for k in columns]
        joints = {mechanism.rows[mechanism.active[i]][0] for i in rows} | {mechanism.columns[k][0] for k in names}
        share = whole / (_span(motion, joints) or whole)
        turns = [share if mechanism.rows[mechanism.active[i]][1][0] == "u" else 1.0 for i in rows]
        lengths = [share if mechanism.columns[k][1][0] == "u" else 1.0 for k in names]
        own = matrix[..., rows, :][..., columns] * np.array(turns)[:, None] / np.array(lengths)
        values = np.linalg.svd(own, compute_uv=False)
        # Of one equation alone its size tells: it is a cosine, or an arm in units of the extent.
        found.append(values[..., -1] / (values[..., 0] if len(rows) > 1 else 1.0))
    return np.asarray(np.min(found, axis=0))


def _span(motion: Motion, joints: Iterable[str]) -> float:
    """Extent of the places of some joints as drawn."""
    linkage = motion.linkage
    places = np.concatenate([linkage.points[linkage.joints[name].point].reshape(-1, 3) for name in joints])
    return float(np.ptp(places, axis=0).max())


def pose_states(motion: Motion) -> tuple[States, NDArray[np.str_]]:
    """State of each pose and its words, (...) of the assembly; see `PoseState` and `Motion.status`."""
    margin, least = motion.held
    still = standing_still(motion)
    none = np.zeros(motion.assembly.shape, dtype=bool)
    state = singular_states(margin, NEAR, SINGULAR, np.any([none, *still.values()], axis=0))
    status = words(state, PoseState).astype("<U200")
    for joint, where in reversed(still.items()):
        lost = "stands still" if len(motion.drives.rates) == 1 else "has lost a direction"
        status[where & (state == PoseState.SINGULAR_INVERSE)] = f"singular: input, joint {joint} {lost}"
    loose = state == PoseState.SINGULAR_DIRECT
    if loose.any():
        status[loose] = [
            f"singular: output, joint {joint} moves with the drives held"
            for joint in loose_joints(motion, loose, least)
        ]
    closure = closure_states(motion.assembly.closed, motion.assembly.verified)
    # So near a dead point its two branches are one.
    told = (closure == PoseState.REGULAR) | ((closure == PoseState.OTHER_MODE) & (margin < ONE_BRANCH))
    return np.where(told, state, closure), np.where(told, status, motion.closure_status)


def loose_joints(motion: Motion, chosen: Bools, least: Array) -> NDArray[np.str_]:
    """The joint that moves with the drives held at each of the chosen poses, (k,)."""
    mechanism, shape = motion.mechanism, motion.assembly.shape
    state, parameters = (
        [np.broadcast_to(x, shape)[chosen] for x in entries]
        for entries in (motion.assembly.state, mechanism.parameters)
    )
    velocities = np.zeros((int(chosen.sum()), len(mechanism.columns)))
    velocities[:, mechanism.unknown] = least[chosen]
    return moving_joints(mechanism, state, parameters, list(velocities.T))


def standing_still(motion: Motion) -> dict[str, Bools]:
    """By joint: where its point has lost a direction in which the drives move it at other poses, (...)."""
    if not motion.drives.rates:
        return {}
    motions = [list(unit_motions(each)) for each in (motion, motion.linkage.move(tolerance=motion.tolerance))]
    size = extent(motion.linkage)
    found = {}
    for name, joint in motion.linkage.joints.items():
        link = joint.first if joint.second == GROUND else joint.second
        point = None if joint.pitch is not None or "u" in "".join(joint.kind.coordinates) else joint.point
        here, drawn = (singular_speeds(each, point, link, size) for each in motions)
        most = np.nanmax(here.reshape(-1, here.shape[-1]), axis=0, initial=0.0)
        usual = np.maximum(most, drawn.reshape(-1, here.shape[-1]).max(axis=0, initial=0.0))
        lost = np.any((here < STILL * usual) & (usual > MOVES), axis=-1)
        if lost.any():
            found[name] = lost
    return found


def unit_motions(motion: Motion) -> Iterator[Motion]:
    """The motion with each drive at a rate of one, the others standing still."""
    count = len(motion.drives.rates)
    for drive in range(count):
        rates = [np.asarray(float(k == drive)) for k in range(count)]
        still = [np.zeros(())] * count
        drives = replace(motion.drives, rates=rates, accelerations=still, full_shape=motion.drives.shape)
        yield replace(motion, drives=drives)


def singular_speeds(motions: Sequence[Motion], point: str | None, link: str, size: float) -> Array:
    """Singular values (..., k) of the velocity, in units of `size`, of a point by the rates of the drives.

    Without a point, those of the velocity and angular velocity of the link: a slider has no point that tells of it.
    """
    speeds = np.stack([_speed(motion, point, link, size) for motion in motions], axis=-1)
    there = np.asarray(np.isfinite(speeds).all(axis=(-2, -1), keepdims=True))
    values = np.linalg.svd(np.where(there, speeds, 0.0), compute_uv=False)
    return np.where(there[..., 0], values, np.nan)


def _speed(motion: Motion, point: str | None, link: str, size: float) -> Array:
    if point is not None:
        return motion.velocity(point, link) / size
    first = motion.velocity(motion.linkage.links[link].points[0], link) / size
    return np.concatenate([first, motion.angular_velocity(link)], axis=-1)
