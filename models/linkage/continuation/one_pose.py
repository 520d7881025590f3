"""One regular pose of one linkage in floats, with the same operations as for a batch and so the same bits."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..kinematics.closed_poses import Pose
from ..kinematics.loop_coordinates import LAST_STEP
from ..kinematics.loops import Loops
from ..kinematics.nearest import open_by_one
from .change_point import WITHIN
from .guess import NEAR
from .rays import at_once, begins
from .single_drive import MANY, SingleDrive

# Change of a drive, in radians and mechanism sizes, below which it counts as standing still.
STILL = 1e-14
# Distance from a change point within which a pose is left to the closer search of a batch.
ASIDE = 2.0 * max(NEAR, WITHIN)


class OnePose(NamedTuple):
    """A closed pose: its state and its closure error."""

    state: list[float]
    error: float


def one_pose(
    loops: Loops, parameters: Sequence[float], start: Pose, driven: Sequence[float], closed: float
) -> OnePose | None:
    """The pose at driven states, with the bits that a batch gives; None where it must be sought along the path.

    That is so in and beside a change point, in a dead point and beyond, many turns away, where the drives turn balls,
    and where Newton's method does not lead from the path's nodes to a pose that closes better than `closed`.
    """
    if loops.driven_spherical or not driven:
        return None
    if not loops.unknown_states:
        state = [value for _, value in sorted(zip(loops.driven_states, driven, strict=True))]
        return _closed(loops, parameters, state, closed)
    origin = [start.state[place] for place in loops.driven_states]
    moving = [k for k, (x, y) in enumerate(zip(driven, origin, strict=True)) if abs(x - y) > STILL]
    signs: list[float] = []
    if not moving and len(driven) > 1:
        # the reference configuration, on whichever path it lies
        return _closed(loops, parameters, _placed(loops, start.state, driven), closed)
    if len(moving) > 1:
        pose = at_once(loops, parameters, start, begins(loops, parameters, start), np.array(driven))
        if pose is not None and pose.last_step <= LAST_STEP:
            return _closed(loops, parameters, pose.state, closed)
        guess = None if pose is None else pose.state
    else:
        guess, signs = _on_path(loops, parameters, start, moving[0] if moving else 0, driven)
    if guess is None:
        return None
    found = loops.close_one(_placed(loops, guess, driven), parameters)
    if found is None or not all(x * y >= 0.0 for x, y in zip(found.determinants, signs, strict=False)):
        return None
    return _closed(loops, parameters, found.state, closed)


def _placed(loops: Loops, state: Sequence[float], driven: Sequence[float]) -> list[float]:
    """A state with these values of the driven entries."""
    out = list(state)
    for place, value in zip(loops.driven_states, driven, strict=True):
        out[place] = value
    return out


def _closed(loops: Loops, parameters: Sequence[float], state: list[float], closed: float) -> OnePose | None:
    """A state with its closure error; None if the loops are not closed."""
    error = open_by_one(loops, state, parameters)
    return OnePose(state, error) if error < closed else None


def _on_path(
    loops: Loops, parameters: Sequence[float], start: Pose, drive: int, driven: Sequence[float]
) -> tuple[list[float] | None, list[float]]:
    """Interpolated state and signs of the determinants on the path of the only drive that moves."""
    s = driven[drive] - start.state[loops.driven_states[drive]]
    if abs(s) > MANY:
        return None, []
    guide = SingleDrive(loops, parameters, start, drive, switch=False).guide_over(s, s)
    if len(guide.s) == 1 or not guide.low <= s <= guide.high:
        return None, []
    if guide.crossings.size and any(abs(s - where) < ASIDE for where in guide.crossings.tolist()):
        return None, []
    state, signs = guide.one(s)
    return loops.unit(state), signs  # type: ignore[arg-type, return-value]
