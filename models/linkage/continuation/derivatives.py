"""Derivatives of a pose by its drives, to predict the poses to which it leads."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....framework.batch import Array
from ..kinematics.closed_poses import Pose
from ..kinematics.loops import Loops
from ..kinematics.terms import Value


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives of a pose by the drives.

    Attributes
    ----------
    follow, determinants
        As in `Pose`.
    rate, bend
        First and second derivatives of the state by the driven states, (n, f) and (n, f, f).
    pairs
        Places of those that something in the state follows together, the second at most the first.
    """

    follow: Array
    determinants: Array
    rate: Array
    bend: Array
    pairs: list[tuple[int, int]]

    def along(self, change: Array) -> tuple[Array, Array]:
        """First and second derivatives of the state (n, poses) along changes of the driven states (f, poses).

        Summed term by term, so that the result of a pose has the same bits for any number of poses; a matrix product
        sums in another order at the edges of its blocks.
        """
        first, second = (np.zeros((len(self.rate), change.shape[1])) for _ in range(2))
        part = np.empty_like(first)
        for factor, x in zip(self.rate.T, change, strict=True):
            first += np.multiply(factor[:, None], x, out=part)
        for (i, j), factor in zip(self.pairs, self._second, strict=True):
            if factor.any():
                second += np.multiply(factor[:, None], change[i] * change[j], out=part)
        return first, second

    def along_one(self, change: Array) -> tuple[Array, Array]:
        """`along` for one change (f,), by the same sums."""
        i, j = np.array(self.pairs).T
        first = np.add.accumulate(self.rate.T * change[:, None])[-1]
        second = np.add.accumulate(self._second * (change[i] * change[j])[:, None])[-1]
        return first, second

    @cached_property
    def _second(self) -> Array:
        """What each of the `pairs` adds to the second derivative of the state, (pairs, n)."""
        i, j = np.array(self.pairs, dtype=np.intp).reshape(-1, 2).T
        factors: Array = np.where(i == j, 1.0, 2.0)[:, None] * self.bend[:, i, j].T
        return factors

    @classmethod
    def of(cls, loops: Loops, parameters: Sequence[float], pose: Pose) -> Derivatives:
        """Derivatives at a pose; spherical joints must not be driven."""
        f, state, pairs = len(loops.driven_states), [np.array(x) for x in pose.state], loops.equations.driven_together
        i, j = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        # By polarisation: 2 B(u, v) = B(u + v, u + v) - B(u, u) - B(v, v).
        combinations = np.concatenate([np.eye(f), np.eye(f)[:, i] + np.eye(f)[:, j]], axis=1)
        spread: list[Value] = [np.broadcast_to(x, combinations.shape[1:]) for x in state]
        velocities = loops.velocities(spread, parameters, list(combinations))
        changes = loops.accelerations(spread, parameters, velocities, None)
        rate, bend = (
            np.stack([np.broadcast_to(x, combinations.shape[1:]) for x in each])
            for each in (
                loops.state_rate(spread, [velocities[k] for k in loops.mechanism.unknown]),
                loops.state_bend(spread, velocities, changes),
            )
        )
        rate[loops.driven_states] = combinations
        mixed = np.zeros((len(bend), f, f))
        mixed[:, i, j] = mixed[:, j, i] = 0.5 * (bend[:, f:] - bend[:, i] - bend[:, j])
        determinants = np.array(pose.determinants, dtype=np.float64)
        mixed = np.nan_to_num(mixed, copy=False, posinf=0.0, neginf=0.0)
        return cls(np.array(pose.follow), determinants, rate[:, :f], mixed, pairs)
