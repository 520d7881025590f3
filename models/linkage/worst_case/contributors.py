"""The contributors to a worst case, ranked by their shares."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ....framework.batch import Array, one_entry
from ....framework.errors import FrameError
from ....framework.graphics.shares import draw_shares, height_of_shares
from ....framework.graphics.style import new_axes, set_title, styled
from ....framework.graphics.units import quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Number of rows in the table.
MOST = 12


@dataclass(frozen=True, eq=False, repr=False)
class Contributors:
    """What each contributor adds to a displacement, to first order; made by `WorstCase.contributors`.

    Attributes
    ----------
    names
        Names of the k contributors.
    reach
        Displacement by each in the direction of the worst case, length, (..., k); their sum is the worst case.
    variance
        Variance by each, for a uniform distribution over its interval, disc or ball, (..., k); their sum is the
        variance for independent deviations.
    """

    names: tuple[str, ...]
    reach: Array
    variance: Array

    @property
    def worst(self) -> Array:
        """Share of each contributor in the worst case, per cent, (..., k)."""
        return _per_cent(self.reach)

    @property
    def of_variance(self) -> Array:
        """Share of each contributor in the variance, per cent, (..., k)."""
        return _per_cent(self.variance)

    @property
    def deviation(self) -> Array:
        """Standard deviation of all together, (...)."""
        return np.asarray(np.sqrt(np.sum(self.variance, axis=-1)))

    @property
    def ranked(self) -> tuple[str, ...]:
        """Names by their share in the worst case, the largest first, at the pose with the largest worst case."""
        return tuple(self.names[k] for k in self._order())

    @styled
    def plot(
        self,
        ax: Axes | None = None,
        *,
        entry: int | tuple[int, ...] | None = None,
        most: int = MOST,
        units: tuple[str, str] = ("m", "N"),
    ) -> Axes:
        """Draw the shares of the contributors in the worst case and in the variance as bars, the largest on top.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on; new ones if None.
        entry
            Index of the pose; that with the largest worst case if None.
        most
            Number of contributors shown by name; the others are summed in one bar.
        units
            Units of length and force, for the title.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        FrameError
            If there is no such pose, or it has no results to first order, as a dead point.
        """
        shape = self.reach.shape[:-1]
        pose = self._pose() if entry is None else one_entry(shape, entry, "the figure of the contributors")
        total = float(np.sum(self.reach[pose]))
        if not np.isfinite(total):
            raise FrameError(f"pose {pose} has no contributors to draw: nothing is known there to first order")
        found = new_axes(5.2, height_of_shares(len(self.names), most)) if ax is None else ax
        shares = {"worst case": self.worst[pose], "variance": self.of_variance[pose]}
        draw_shares(found, self.names, shares, most)
        told = f"worst case {quantity(total, units[0])}, σ = {quantity(float(self.deviation[pose]), units[0])}"
        set_title(found, f"pose {', '.join(map(str, pose))}: {told}" if pose else told, 0.75)
        return found

    def _pose(self) -> tuple[int, ...]:
        """The pose with the largest worst case."""
        total = np.nan_to_num(np.sum(self.reach, axis=-1), nan=-1.0)
        if not total.size:
            raise FrameError(f"the motion has no poses, its shape is {total.shape}: give the drives values")
        return tuple(int(k) for k in np.unravel_index(np.argmax(total), total.shape))

    def _order(self) -> list[int]:
        reach = np.nan_to_num(self.reach[self._pose()])
        return sorted(range(len(self.names)), key=lambda k: (-reach[k], self.names[k]))

    def __repr__(self) -> str:
        if not self.reach.size:
            return f"<Contributors of shape {self.reach.shape[:-1]}: no pose is there>"
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
