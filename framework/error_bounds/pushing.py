"""Springs of negative stiffness (preloaded in compression): by how much they amplify displacements under forces."""

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
    """Kinematics and springs of a frame, for `resisted`."""

    kinematics: FrameKinematics
    springs: list[Springs]
    stiffness: list[Real]


def in_double(state: EquilibriumResidual) -> SpringModel:
    """The frame of a solution in double precision."""
    return SpringModel(state.double, state.double_springs, state.stiffness)


def amplification(state: EquilibriumResidual, root: Array, solve: Callable[[Array], Array], margin: float) -> Array:
    """Estimated amplification of displacements under forces on deformations by springs of negative stiffness, (...).

    With the part S' by which these springs lower the stiffness S, the magnitudes of all stiffnesses give
    ``|S| = S + 2 S'``. The displacements under forces p on the deformations have a norm in |S| of at most
    ``|k^-1/2 p|`` times the greatest eigenvalue of ``S^-1 |S| = 1 + 2 S^-1 S'``, which is found by iteration from
    motions of these springs.

    Parameters
    ----------
    state
        A solution of the frame, with n unknowns.
    root
        Inverse square root of the diagonal of its stiffness, (..., n).
    solve
        Function that returns displacements (m, ..., n) for loads (m, ..., n).
    margin
        Factor by which the eigenvalue of ``S^-1 S'`` may exceed the estimate of the iteration.
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
        # displacements that do not deform these springs have no part in the iteration
        motion = solve(load.astype(np.float64) / np.where(growth == 0.0, 1.0, growth)[..., None])
    found = growth.max(axis=0)
    out: Array = 1.0 + 2.0 * margin * np.where(np.isfinite(found), found, np.inf)
    return out
