"""Outcome of a job for a point at all poses, as its tables show it."""

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

# Names of the kinds of samples in progress messages.
LINEAR_WAY, LARGE_WAY = "samples at a pose", "at large displacement"

# Error of linear means and deviations, as a share of the spread at large displacement, above which a pose is marked.
APART = 0.1
# Least spread for that comparison, as a share of the whole displacement.
SHARE = 0.02
# Largest number of samples at large displacement, each of which takes as long as hundreds by linear mechanics.
MOST = 2000
# Largest number of samples whose condition numbers are computed.
SPECTRA = 200


@dataclass(frozen=True, eq=False)
class LargeSpread(Spread):
    """Large displacement of a point from its nominal position, (poses, m, 3), NaN where it is not known.

    Attributes
    ----------
    passed
        Samples that passed a singular pose on the way, and are now near another branch, (poses, m).
    """

    passed: Mask = field(kw_only=True)


def taken(samples: int) -> int:
    """Number of samples, the first ones, that are computed at large displacement."""
    return min(samples, MOST)


class Outcome(ABC):
    """Position of a point at all poses, its spread over the samples, and measures of their accuracy.

    Poses without a result have NaN. Arrays are (poses,) or (poses, 3).
    """

    @property
    @abstractmethod
    def drives(self) -> list[str]:
        """The poses in short, such as ``"30°"``."""

    @property
    @abstractmethod
    def heading(self) -> str:
        """Name of the quantity whose values name the poses, such as ``"θ"``."""

    @property
    @abstractmethod
    def point(self) -> str:
        """Name of the point."""

    @property
    @abstractmethod
    def singular_place(self) -> str:
        """Description of the singular configuration through which samples may pass to another branch."""

    @property
    @abstractmethod
    def axes(self) -> tuple[int, ...]:
        """Components that are shown."""

    @property
    @abstractmethod
    def count(self) -> int:
        """Number of samples; 1 if nothing is uncertain."""

    @property
    @abstractmethod
    def nan_policy(self) -> str:
        """Treatment of samples without a result."""

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
        """Estimated relative error of linear mechanics for the nominal displacement."""

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
        """Bound on the numerical error of the displacement over all samples."""

    @property
    @abstractmethod
    def place_error(self) -> float:
        """Bound on the numerical error of `rigid`; NaN if it is not known."""

    @property
    @abstractmethod
    def kappa(self) -> Array:
        """Condition number of the stiffness matrix as usually assembled, at the mean inputs; NaN if there is none."""

    @property
    @abstractmethod
    def planar_kappa(self) -> Array:
        """Condition number of the same matrix's rows and columns in the plane, at the mean inputs."""

    @property
    @abstractmethod
    def sampled_kappa(self) -> tuple[Array, Array]:
        """Condition numbers of the first samples, of the whole matrix and of its planar part, (poses, some).

        They are of the first samples only, as spectra take far more time than solutions; at the regular poses, or at
        all poses with NaN at others.
        """

    @property
    @abstractmethod
    def kappa_scaled(self) -> Array:
        """Scaled condition number of the matrix that is solved, at the mean inputs."""

    @property
    @abstractmethod
    def unknowns(self) -> int:
        """Number of nodal displacements of the frame: the size of the matrix of `kappa`."""

    @property
    @abstractmethod
    def large(self) -> LargeSpread:
        """Large displacement, at singular poses too; of the first samples only if there are very many."""

    @property
    @abstractmethod
    def closes(self) -> Mask:
        """Poses at which large displacement is computed: those at which all samples can be assembled."""

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
        """Largest error of the linear mean plus deviation, in standard deviations at large displacements.

        NaN where a pose has no result. A deviation that is less than a small share of the whole displacement, as that
        perpendicular to the path of a point, is replaced by that share.
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
        """`status`, marked at poses outside the linear range.

        ``"outside the linear range: estimated error 20 %"`` if the nominal displacement is outside it, and ``"outside
        the linear range: estimated error 20 % of the spread"`` if the samples' mean and standard deviation differ from
        those at large displacement.
        """
        by_load = self.regular & ~(self.nonlinearity < LINEAR)
        by_spread = self.regular & (self.apart > APART)
        loads = [beyond_linear(each) for each in self.nonlinearity]
        spreads = [f"outside the linear range: estimated error {100 * each:.2g} % of the spread" for each in self.apart]
        return np.where(by_load, loads, np.where(by_spread, spreads, self.status))


def magnification(displacement: Array, size: float) -> float:
    """Factor on drawn displacements that makes them visible compared with a size: 1, 2 or 5 times a power of ten.

    With it most displacements are within that size; if a few are huge, as near singular poses, typical ones are.
    """
    middle, most = np.nanquantile(displacement, (0.5, 0.9)) if np.isfinite(displacement).any() else (0.0, 0.0)
    largest = float(min(3.0 * middle, most) or most)
    if largest == 0.0:
        return 1.0
    factor = size / largest
    decade = 10.0 ** np.floor(np.log10(factor))
    return float(max(1.0, decade * max(step for step in (1.0, 2.0, 5.0) if step * decade <= factor)))
