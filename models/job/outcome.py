"""What a job found of a point at all poses, as its tables show it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ...framework.results.validity import LINEAR, beyond_linear
from ..spread import Spread

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# What is counted while samples are computed.
LINEAR_WAY, LARGE_WAY = "samples at a pose", "at large displacement"

# Share of the true spread by which linear means and spreads may be off before a pose is marked.
APART = 0.1
# A spread below this share of the whole displacement is none to be measured by.
SHARE = 0.02
# Samples that are taken to large displacement, each of which takes as long as hundreds by linear mechanics.
MOST = 2000
# Samples whose condition numbers are told.
SPECTRA = 200


@dataclass(frozen=True, eq=False)
class LargeSpread(Spread):
    """Displacement of a point from its nominal position at large displacement, (poses, m, 3), NaN where it has none.

    Attributes
    ----------
    passed
        Samples that passed a singular pose on the way, so that they stand near another branch, (poses, m).
    """

    passed: Mask = field(kw_only=True)


def taken(samples: int) -> int:
    """How many of the samples are taken to large displacement, the first ones."""
    return min(samples, MOST)


class Outcome(ABC):
    """Position of a point at all poses, its spread over the samples, and how far both can be trusted.

    Poses without a result hold NaN. Arrays are (poses,) or (poses, 3).
    """

    @property
    @abstractmethod
    def drives(self) -> list[str]:
        """The poses in short, such as ``"30°"``."""

    @property
    @abstractmethod
    def heading(self) -> str:
        """What the poses are values of, such as ``"θ"``."""

    @property
    @abstractmethod
    def point(self) -> str:
        """Name of the point."""

    @property
    @abstractmethod
    def singular_place(self) -> str:
        """In words, where the linkage is singular and samples may pass to another branch."""

    @property
    @abstractmethod
    def axes(self) -> tuple[int, ...]:
        """Components that are shown."""

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of samples; 1 where nothing is uncertain."""

    @property
    @abstractmethod
    def nan_policy(self) -> str:
        """What is done with samples without a result."""

    @property
    @abstractmethod
    def assembled(self) -> Mask:
        """Poses that can be assembled."""

    @property
    @abstractmethod
    def regular(self) -> Mask:
        """Poses that have a linear result."""

    @property
    @abstractmethod
    def status(self) -> NDArray[np.str_]:
        """Why a pose has no result, or ``"regular"``."""

    @property
    @abstractmethod
    def nonlinearity(self) -> Array:
        """Estimated relative error of the nominal displacement by its being linear."""

    @property
    @abstractmethod
    def rigid(self) -> Array:
        """Position with rigid links and no clearance."""

    @property
    @abstractmethod
    def compliance(self) -> Array:
        """Nominal displacement by the load, without clearance."""

    @property
    @abstractmethod
    def spread(self) -> Spread:
        """Displacement of the samples from `rigid`, (poses, samples, 3)."""

    @property
    @abstractmethod
    def error_bound(self) -> Array:
        """Bound on the numerical error of the displacement of every sample."""

    @property
    @abstractmethod
    def place_error(self) -> float:
        """Bound on the numerical error of `rigid`; NaN where it has none."""

    @property
    @abstractmethod
    def kappa(self) -> Array:
        """Condition number of the stiffness matrix as usually assembled, at the mean inputs; NaN where it has none."""

    @property
    @abstractmethod
    def planar_kappa(self) -> Array:
        """Condition number of the same matrix's rows and columns in the plane, at the mean inputs."""

    @property
    @abstractmethod
    def sampled_kappa(self) -> tuple[Array, Array]:
        """Condition numbers of the first samples, of the whole matrix and in the plane, (poses, some).

        Of the first alone, as spectra cost far more than solutions; of the regular poses, or of all with NaN.
        """

    @property
    @abstractmethod
    def kappa_scaled(self) -> Array:
        """Scaled condition number of the matrix that is solved, at the mean inputs."""

    @property
    @abstractmethod
    def unknowns(self) -> int:
        """Displacements of the frame's nodes: the size of the matrix that the condition number is of."""

    @property
    @abstractmethod
    def large(self) -> LargeSpread:
        """Displacement at large displacement, also where singular; of the first samples, where there are very many."""

    @property
    @abstractmethod
    def closes(self) -> Mask:
        """Poses that are taken to large displacement: all samples of them can be assembled."""

    @property
    def samples(self) -> Array:
        """Displacement from `rigid`, (poses, samples, 3)."""
        return self.spread.samples

    @cached_property
    def mean(self) -> Array:
        """Mean position."""
        mean: Array = self.rigid + self.spread.mean
        return mean

    @property
    def std(self) -> Array:
        """Standard deviation of the position."""
        return self.spread.std

    @property
    def standard_error(self) -> Array:
        """Standard error of `mean`."""
        return self.spread.standard_error

    @property
    def std_standard_error(self) -> Array:
        """Standard error of `std`."""
        return self.spread.std_standard_error

    @cached_property
    def apart(self) -> Array:
        """By how many true standard deviations mean and deviation are off for being linear, the greatest component.

        What is true is large displacement; NaN where a pose has no result. A deviation that is less than a small
        share of the whole displacement, as that across the way of a point, counts as that share.
        """
        shown = list(self.axes)
        moved, spread = self.large.mean[:, shown], self.large.std[:, shown]
        same = Spread(self.samples[:, : self.large.n], self.nan_policy)
        off = np.abs(same.mean[:, shown] - moved) + np.abs(same.std[:, shown] - spread)
        whole = np.hypot(np.linalg.norm(moved, axis=1), np.linalg.norm(spread, axis=1))[:, None]
        seen = np.maximum(spread, SHARE * whole)
        apart: Array = np.divide(off, seen, out=np.zeros_like(off), where=seen > 0.0).max(axis=1)
        return np.where(self.regular, apart, np.nan)

    @property
    def marked_status(self) -> NDArray[np.str_]:
        """`status`, marked where what linear mechanics says does not hold.

        ``"outside the linear range: estimated error 20 %"`` where that goes for the nominal displacements already, and
        ``"outside the linear range: estimated error
        off by 20 % of the spread"`` where the samples' mean and standard deviation differ from those at large
        displacement.
        """
        by_load = self.regular & ~(self.nonlinearity < LINEAR)
        by_spread = self.regular & (self.apart > APART)
        loads = [beyond_linear(each) for each in self.nonlinearity]
        spreads = [f"outside the linear range: estimated error {100 * each:.2g} % of the spread" for each in self.apart]
        return np.where(by_load, loads, np.where(by_spread, spreads, self.status))


def magnification(displacement: Array, size: float) -> float:
    """Factor on drawn displacements that makes them visible beside a size: 1, 2 or 5 times a power of ten.

    Most are to stay within that size; where a few are huge, as near singular poses, what is typical is to be seen.
    """
    middle, most = np.nanquantile(displacement, (0.5, 0.9)) if np.isfinite(displacement).any() else (0.0, 0.0)
    largest = float(min(3.0 * middle, most) or most)
    if largest == 0.0:
        return 1.0
    factor = size / largest
    decade = 10.0 ** np.floor(np.log10(factor))
    return float(max(1.0, decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= factor)))
