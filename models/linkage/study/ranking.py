"""The contributors in one table: shares to first order, and Sobol' indices with confidence intervals."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ....framework.listing import text_table
from ...intervals import ConfidenceInterval
from ...sensitivity import SobolIndices
from ..worst_case.contributors import Contributors
from .tolerances import Tolerance


@dataclass(frozen=True, eq=False, repr=False)
class RankedContributors:
    """Effect of each tolerance on a point's displacement in its worst direction; made by `AccuracyStudy.ranked`.

    Attributes
    ----------
    names
        Names of the k contributors: tolerances, and joints whose clearance has no tolerance.
    worst, of_variance
        Share of each in the worst case and in the variance, to first order, per cent, (poses, k).
    first, total
        Sobol' indices of first order and total, (poses, k); NaN for contributors that do not vary.
    first_interval, total_interval
        Their confidence intervals, (poses, k) each.
    """

    names: tuple[str, ...]
    worst: Array
    of_variance: Array
    first: Array
    total: Array
    first_interval: ConfidenceInterval
    total_interval: ConfidenceInterval

    def order(self, pose: int) -> list[int]:
        """Indices of the contributors, sorted by their share in the worst case at a pose, then by total index."""
        shares = np.nan_to_num(np.stack([self.worst[pose], self.total[pose]]))
        return sorted(range(len(self.names)), key=lambda k: (-round(shares[0, k], 6), -shares[1, k], self.names[k]))

    def table(self, pose: int) -> str:
        """The table of one pose.

        Parameters
        ----------
        pose
            Number of the pose.

        Returns
        -------
        str
            A line for each contributor, ranked.
        """
        heads = ["contributor", "worst case %", "variance %", "first", "from", "to", "total", "from", "to"]
        columns = (self.worst, self.of_variance, self.first, *self.first_interval, self.total, *self.total_interval)
        rows = [
            [self.names[k], *(_shown(column[pose, k], digits) for column, digits in zip(columns, DIGITS, strict=True))]
            for k in self.order(pose)
        ]
        return text_table(f"Contributors at pose {pose}", heads, rows)

    def __repr__(self) -> str:
        return self.table(0) if len(self.worst) else "RankedContributors of no poses"


DIGITS = (1, 1, 3, 3, 3, 3, 3, 3)


def _shown(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else "-"


def ranked_contributors(
    shares: Contributors, indices: SobolIndices, tolerances: Mapping[str, Tolerance], level: float
) -> RankedContributors:
    """Shares (poses, k) and indices (poses, t) combined: a joint counts with the tolerance of its clearance."""
    owners = {
        f"joint {place[1]}": name
        for name, each in tolerances.items()
        for place in each.nominal
        if place[0] == "joints" and place[2] == "clearance"
    }
    named = [owners.get(name, name) for name in shares.names]
    names = tuple(dict.fromkeys([*named, *tolerances]))
    pairs = np.array([[own == name for name in names] for own in named], dtype=np.float64)
    worst, variance = (np.atleast_2d(each) @ pairs for each in (shares.worst, shares.of_variance))

    def placed(values: Array) -> Array:
        out = np.full(worst.shape, np.nan)
        for k, name in enumerate(indices.inputs):
            out[:, names.index(name)] = values[..., k]
        return out

    first, total = (indices.confidence_interval(level, of) for of in ("first", "total"))
    return RankedContributors(
        names,
        worst,
        variance,
        placed(indices.first),
        placed(indices.total),
        ConfidenceInterval(*map(placed, first)),
        ConfidenceInterval(*map(placed, total)),
    )
