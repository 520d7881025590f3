"""Who is to blame for how much: a ranked table."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array

# Rows that the table shows.
MOST = 12


@dataclass(frozen=True, eq=False, repr=False)
class Contributors:
    """What each contributor adds to a displacement, to first order; made by `WorstCase.contributors`.

    Attributes
    ----------
    names
        Names of the k contributors.
    reach
        How far each lets the point go, (..., k); their sum is the worst case.
    variance
        Variance of each, spread evenly over its interval, disc or ball, (..., k); their sum is that of independent
        deviations.
    """

    names: tuple[str, ...]
    reach: Array
    variance: Array

    @property
    def worst(self) -> Array:
        """Share of each in the worst case, per cent, (..., k)."""
        return _per_cent(self.reach)

    @property
    def of_variance(self) -> Array:
        """Share of each in the variance, per cent, (..., k)."""
        return _per_cent(self.variance)

    @property
    def deviation(self) -> Array:
        """Standard deviation of all together, (...)."""
        return np.asarray(np.sqrt(np.sum(self.variance, axis=-1)))

    @property
    def ranked(self) -> tuple[str, ...]:
        """Names by their greatest share in the worst case, of the pose that `repr` shows."""
        return tuple(self.names[k] for k in self._order())

    def _pose(self) -> tuple[int, ...]:
        """The pose with the largest worst case."""
        total = np.nan_to_num(np.sum(self.reach, axis=-1), nan=-1.0)
        return tuple(int(k) for k in np.unravel_index(np.argmax(total), total.shape))

    def _order(self) -> list[int]:
        reach = np.nan_to_num(self.reach[self._pose()])
        return sorted(range(len(self.names)), key=lambda k: (-reach[k], self.names[k]))

    def __repr__(self) -> str:
        pose, order = self._pose(), self._order()
        wide = max(11, *(len(name) for name in self.names))
        lines = [f"{'contributor':<{wide}} {'worst case':>12} {'%':>12} {'variance %':>12}"]
        for k in order[:MOST]:
            reach, share, variance = (each[(*pose, k)] for each in (self.reach, self.worst, self.of_variance))
            lines.append(f"{self.names[k]:<{wide}} {reach:12.4g} {share:12.1f} {variance:12.1f}")
        if len(order) > MOST:
            lines.append(f"and {len(order) - MOST} more")
        return "\n".join(lines)


def _per_cent(values: Array) -> Array:
    total = np.sum(values, axis=-1, keepdims=True)
    return np.asarray(100.0 * values / np.where(total == 0.0, 1.0, total))
