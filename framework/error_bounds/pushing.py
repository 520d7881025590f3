"""Springs with a stiffness below zero, as they push at rest: by how much they amplify what forces do elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ..batch import Array
from .deformations import Springs
from .equilibrium import EquilibriumResidual
from .kinematic_edge import Real
from .kinematics import FrameKinematics
from .resistance import resisted

# Steps of the iteration, from random motions.
_STEPS, _RANDOM = 8, 2


@dataclass(frozen=True)
class SpringModel:
    """A frame as its springs, for `resisted`."""

    kinematics: FrameKinematics
    springs: list[Springs]
    stiffness: list[Real]


def in_double(state: EquilibriumResidual) -> SpringModel:
    """The frame of a solution in double precision."""
    return SpringModel(state.double, state.double_springs, state.stiffness)


def amplification(state: EquilibriumResidual, root: Array, solve: Callable[[Array], Array], margin: float) -> Array:
    """By how much springs that push amplify what forces on the deformations do, estimated, (...).

    With the part S' of the stiffness S that these springs take off, the sizes of all stiffnesses together are
    ``|S| = S + 2 S'``. What forces p on the deformations bring about has, by the norm of |S|, no more than
    ``|k^-1/2 p|`` times the greatest eigenvalue of ``S^-1 |S| = 1 + 2 S^-1 S'``, which is found by iteration from
    motions of these springs alone.

    Parameters
    ----------
    state
        A solution of the frame, with n unknowns.
    root
        One over the square root of the diagonal of its stiffness, (..., n).
    solve
        Displacements (m, ..., n) for loads (m, ..., n).
    margin
        The factor by which the eigenvalue of ``S^-1 S'`` may be above what the iteration finds.
    """
    if not any((each.stiffness < 0.0).any() for each in state.springs):
        return np.ones(())
    frame, unknowns = in_double(state), state.unknowns
    pushing = [replace(each, stiffness=np.where(each.stiffness < 0.0, -each.stiffness, 0.0)) for each in frame.springs]
    part = SpringModel(frame.kinematics, pushing, [np.zeros_like(each) for each in frame.stiffness])
    start = np.random.default_rng(0).standard_normal((_RANDOM, *(1,) * (root.ndim - 1), len(unknowns)))
    motion, growth = root * start, np.zeros(())
    for _ in range(_STEPS):
        load = resisted(part, unknowns, motion)
        growth = np.asarray(np.sqrt(np.maximum(np.sum(motion * load, axis=-1), 0.0)), np.float64)
        # of what does not move these springs nothing comes
        motion = solve(load.astype(np.float64) / np.where(growth == 0.0, 1.0, growth)[..., None])
    found = growth.max(axis=0)
    out: Array = 1.0 + 2.0 * margin * np.where(np.isfinite(found), found, np.inf)
    return out
