"""Study of a linkage under tolerances: samples, worst case and contributors of its points' displacements."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.batch import Array, finite
from ....framework.errors import FrameError, SampleWarning
from ....framework.listing import text_table
from ...distributions import Uncertain
from ...intervals import ConfidenceInterval, checked_level
from ...propagation import Propagation, propagate
from ...sensitivity import SobolIndices, sobol_indices
from ..continuation.drives import by_joint
from ..derivatives.thermal import Expansion
from ..description.linkage_description import LinkageDescription
from ..motion import Motion
from ..statics.accuracy import PointAccuracy
from ..worst_case.contributors import Contributors
from ..worst_case.worst_case import WorstCase
from ..zone import driven_values
from .described import described
from .deviations import contributors, worst_cases
from .heat import displacements_by_heat, temperature_tolerances
from .parts import KINDS, TOGETHER, AccuracyParts, kind_of_tolerance
from .ranking import RankedContributors, ranked_contributors
from .sampled import DrivenPoses, SampledDisplacement, nominal_positions
from .tabulated import to_dataframe, to_xarray
from .tolerances import Tolerance

# Samples of one call, which limit the memory in use.
CHUNK = 1024
# Rows of the table of a study.
MOST_SHOWN = 12

TOLD = "mean, σ: of the displacement by samples; worst: what clearances and tolerances add at most, to first order"


@dataclass(frozen=True, eq=False, repr=False)
class AccuracyStudy:
    """Displacements of points of a linkage under tolerances, at every pose; made by `Linkage.study`.

    Arrays are (points, poses) or (points, poses, 3), in the order of `points`. Displacements are from the position with
    rigid links, no clearance and nominal numbers. Poses without a result have NaN.

    Attributes
    ----------
    motion
        Motion of the nominal linkage.
    points
        Names of the points.
    tolerances
        Tolerances by name.
    accuracy
        By point: displacement of the nominal linkage by compliance and by clearance.
    propagation
        Samples of the displacement, (samples, points, poses, 3), with statistics, failures and Sobol' indices.
    worst_case
        By point: worst case of tolerances and clearances, exact to first order. A distribution without limits counts
        with three standard deviations to either side, a clearance with its upper limit in any direction, so that a
        change of the contact by tolerances adds nothing.
    """

    motion: Motion
    points: tuple[str, ...]
    tolerances: Mapping[str, Tolerance]
    accuracy: Mapping[str, PointAccuracy]
    propagation: Propagation
    worst_case: Mapping[str, WorstCase]
    _sampled: SampledDisplacement = field(repr=False)
    _options: Mapping[str, Any] = field(repr=False)

    @property
    def _poses(self) -> int:
        return int(np.prod(self.motion.shape))

    def _each(self, part: str) -> Array:
        """One attribute of the nominal results of all points, (points, poses, 3)."""
        parts = [getattr(found, part)[..., :3] for found in self.accuracy.values()]
        return np.stack([np.broadcast_to(each, (self._poses, 3)) for each in parts])

    @cached_property
    def drives(self) -> dict[str, Array]:
        """Values of the drives by joint, for joints with one driven coordinate, (poses,)."""
        found = {name: driven_values(self.motion, name) for name in self.motion.linkage.drives}
        single = {name: each for name, each in found.items() if each.ndim == len(self.motion.shape)}
        return {name: np.array(np.broadcast_to(each, (self._poses,))) for name, each in single.items()}

    @cached_property
    def position(self) -> Array:
        """Position with rigid links, no clearance and nominal numbers, (points, poses, 3)."""
        return self._each("rigid")

    @cached_property
    def compliance(self) -> Array:
        """Displacement of the nominal linkage by compliance alone, (points, poses, 3)."""
        return self._each("compliance")

    @cached_property
    def clearance(self) -> Array:
        """Displacement of the nominal linkage added by its clearances, (points, poses, 3)."""
        return self._each("clearance")

    @property
    def mean(self) -> Array:
        """Mean displacement, (points, poses, 3)."""
        return self.propagation.mean

    @property
    def std(self) -> Array:
        """Standard deviation of the displacement, (points, poses, 3)."""
        return self.propagation.std

    @cached_property
    def greatest(self) -> Array:
        """Largest displacement in the worst case, (points, poses)."""
        return np.stack([np.broadcast_to(each.greatest, (self._poses,)) for each in self.worst_case.values()])

    @cached_property
    def contributors(self) -> dict[str, Contributors]:
        """Shares in the worst case and in the variance along the largest displacement, by point: a ranked table."""
        return {point: contributors(worst, self.tolerances) for point, worst in self.worst_case.items()}

    @cached_property
    def sobol(self) -> SobolIndices:
        """Sobol' indices of the displacement in the direction of the worst case, (points, poses, k).

        They take n (k + 2) further samples, where n is the largest power of two up to the number of samples, or with
        replicates their number times such a power.
        """
        self.propagation.require_independent_inputs("Sobol indices")
        way = np.stack([np.broadcast_to(each.direction, (self._poses, 3)) for each in self.worst_case.values()])
        sampled = self._sampled

        def along(**draws: Array) -> Array:
            return np.asarray(np.einsum("psni,psi->psn", sampled(**draws)[0], way))

        distributions = {name: each.distribution for name, each in self.tolerances.items()}
        several = self.propagation.replicates
        n = several * 2 ** int(np.log2(self.propagation.n / several))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", SampleWarning)  # indices that lack a sample are NaN
            return sobol_indices(
                along, distributions, n=n, rng=self._options.get("rng"), axis=2, chunk=CHUNK, replicates=several
            )

    def ranked(self, point: str | None = None, level: float = 0.95) -> RankedContributors:
        """Rank the contributors: shares in worst case and variance, Sobol' indices with intervals, in one table.

        Parameters
        ----------
        point
            Name of the point; the first if None.
        level
            Confidence of the intervals.

        Returns
        -------
        RankedContributors
            Shares and indices at every pose; printed as a table of the first pose.

        Raises
        ------
        FrameError
            If there is no such point in the study, or tolerances are correlated.
        """
        name = self.points[0] if point is None else point
        if name not in self.points:
            raise FrameError(f"point {point!r} is not in the study: choose of {', '.join(self.points)}")
        k, all_of = self.points.index(name), self.sobol
        own = replace(
            all_of,
            first=all_of.first[k],
            total=all_of.total[k],
            first_standard_error=all_of.first_standard_error[k],
            total_standard_error=all_of.total_standard_error[k],
        )
        return ranked_contributors(self.contributors[name], own, self.tolerances, level)

    @cached_property
    def parts(self) -> AccuracyParts[AccuracyStudy]:
        """Studies of the tolerances of ``geometry``, ``clearance``, ``compliance``, ``load`` and ``thermal`` apart.

        In each, all other numbers are nominal; ``together`` is the whole study.
        """
        kinds = {name: kind_of_tolerance(name, each) for name, each in self.tolerances.items()}
        found = {}
        for kind in (kind for kind in KINDS if kind in kinds.values()):
            own = {name: each for name, each in self.tolerances.items() if kinds[name] == kind}
            heat = {name: slope for name, slope in self._sampled.heat.items() if name in own}
            options = {**self._options, "checkpoint": None, "correlation": None}
            sampled = replace(self._sampled, tolerances=own, heat=heat)
            found[kind] = studied(self.motion, self.accuracy, sampled, options, clearances=kind == "clearance")
        return AccuracyParts({**found, TOGETHER: self})

    @cached_property
    def status(self) -> NDArray[np.str_]:
        """Why a pose has no result, or ``"regular"``, (poses,)."""
        frame = np.broadcast_to(next(iter(self.accuracy.values())).status, (self._poses,))
        motion = np.broadcast_to(self.motion.status, (self._poses,))
        return np.where(motion == "regular", frame, motion)

    # -- the zone ---------------------------------------------------------------------------------------------------

    def probability(self, limit: float) -> Array:
        """Share of the samples in which a point is farther than a limit from its nominal position.

        Parameters
        ----------
        limit
            Radius of the zone about the nominal position, a length.

        Returns
        -------
        ndarray
            Probability, (points, poses); NaN where no sample has a result. For rare failures use `Motion.reliability`.

        Raises
        ------
        FrameError
            If the limit is not a positive length.
        """
        outside, there = self._counts(limit)
        return np.asarray(np.where(there > 0, outside / np.maximum(there, 1), np.nan))

    def probability_interval(self, limit: float, level: float = 0.95) -> ConfidenceInterval:
        """Bound `probability` by the number of samples (C. J. Clopper & E. S. Pearson, Biometrika 26, 1934).

        Parameters
        ----------
        limit
            As for `probability`.
        level
            Confidence, between 0 and 1.

        Returns
        -------
        ConfidenceInterval
            Bounds, (points, poses); they hold for independent random samples.

        Raises
        ------
        FrameError
            If the limit is not a positive length, or the level not between 0 and 1.
        """
        from scipy.special import betaincinv

        outside, there = self._counts(limit)
        half, inside = 0.5 * (1.0 - checked_level(level)), there - outside
        low = betaincinv(np.maximum(outside, 1), inside + 1.0, half)
        high = betaincinv(outside + 1.0, np.maximum(inside, 1), 1.0 - half)
        return ConfidenceInterval(
            np.where(there > 0, np.where(outside > 0, low, 0.0), np.nan),
            np.where(there > 0, np.where(inside > 0, high, 1.0), np.nan),
        )

    def _counts(self, limit: float) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        """Number of samples outside the limit, and of those with a result, (points, poses) each."""
        radius = finite(limit, "limit")
        if radius.ndim or not radius > 0.0:
            raise FrameError(f"limit is {limit!r}: give the radius of the zone, a length above zero")
        off = np.linalg.norm(self.propagation.samples, axis=-1)
        return np.count_nonzero(off > radius, axis=0), np.count_nonzero(np.isfinite(off), axis=0)

    # -- tables -----------------------------------------------------------------------------------------------------

    def arrays(self) -> dict[str, Array]:
        """The numbers of the table by name, (points, poses) or (points, poses, 3).

        Returns
        -------
        dict
            ``position``, ``compliance``, ``clearance``, ``mean``, ``std`` and ``standard_error``,
            (points, poses, 3), and ``worst_case``, (points, poses); lengths.
        """
        return {
            "position": self.position,
            "compliance": self.compliance,
            "clearance": self.clearance,
            "mean": self.mean,
            "std": self.std,
            "standard_error": self.propagation.standard_error,
            "worst_case": self.greatest,
        }

    def to_dataframe(self) -> Any:
        """The table, with a row for each point and pose.

        Returns
        -------
        pandas.DataFrame
            Columns ``point``, ``pose``, one for each drive, those of `arrays`, vectors as ``mean_x``, ``mean_y``,
            ``mean_z``, and ``status``.

        Raises
        ------
        FrameError
            If pandas is not installed.
        """
        return to_dataframe(self)

    def to_xarray(self) -> Any:
        """All numbers with their dimensions named ``point``, ``pose``, ``axis``, ``sample`` and ``contributor``.

        Returns
        -------
        xarray.Dataset
            `arrays`, the samples as ``sample_displacement``, and the shares of the contributors in per cent as
            ``worst_case_share`` and ``variance_share``; values of the drives as coordinates of the poses.

        Raises
        ------
        FrameError
            If xarray is not installed.
        """
        return to_xarray(self)

    def __repr__(self) -> str:
        """Tables of the first point's displacements and contributors."""
        heads = [*self.drives, *(f"{name}{axis}" for name in ("mean u_", "σ_") for axis in "xyz"), "worst", "status"]
        columns = [*self.drives.values(), *self.mean[0].T, *self.std[0].T, self.greatest[0]]
        rows = [
            [*(f"{value:.4g}" for value in row), status]
            for row, status in zip(np.column_stack(columns).tolist(), self.status.tolist(), strict=True)
        ]
        left = len(rows) - MOST_SHOWN
        poses = "1 pose" if self._poses == 1 else f"{self._poses} poses"
        of_all = f"Study of {', '.join(self.points)}: {poses}, {self.propagation.n} samples"
        title = f"{of_all}; {self.points[0]}" if len(self.points) > 1 else of_all
        title = f"{title}\n{TOLD}"
        parts = [text_table(title, heads, rows[:MOST_SHOWN]), *([f"and {left} more poses"] if left > 0 else [])]
        if np.isfinite(self.greatest[0]).any():
            parts.append(repr(self.contributors[self.points[0]]))
        return "\n".join([*parts, repr(self.propagation.failures)])


def study(
    linkage: LinkageDescription,
    tolerances: Mapping[str, Any],
    points: str | Sequence[str],
    poses: DrivenPoses,
    *,
    inertia: bool,
    temperatures: Mapping[str, Uncertain] | None = None,
    expansion: Expansion | None = None,
    **options: Any,
) -> AccuracyStudy:
    """Study of points of a linkage under tolerances; see `Linkage.study`."""
    names = (points,) if isinstance(points, str) else tuple(points)
    warm = dict(temperatures or {})
    source, found = described(linkage, tolerances, some=not warm)
    motion = poses.move(linkage)
    if not names or len(motion.shape) > 1:
        wrong = "no point" if not names else f"a motion of shape {motion.shape}"
        raise FrameError(f"study was given {wrong}: give one point or more, and drives with one axis of poses")
    accuracy = {point: motion.accuracy(point, inertia=inertia) for point in names}
    heat = displacements_by_heat(motion, names, warm, expansion)
    found |= temperature_tolerances(warm)
    sampled = SampledDisplacement(source, found, poses, names, nominal_positions(motion, accuracy), inertia, heat)
    return studied(motion, accuracy, sampled, options)


def studied(
    motion: Motion,
    accuracy: Mapping[str, PointAccuracy],
    sampled: SampledDisplacement,
    options: Mapping[str, Any],
    *,
    clearances: bool = True,
) -> AccuracyStudy:
    """Worst case, of clearances too if `clearances`, and samples; see `study`."""
    worst = worst_cases(motion, sampled, clearances=clearances)
    distributions = {name: each.distribution for name, each in sampled.tolerances.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", SampleWarning)  # the study reports them
        propagation = propagate(sampled, distributions, axis=2, chunk=CHUNK, **options)
    return AccuracyStudy(motion, sampled.points, sampled.tolerances, accuracy, propagation, worst, sampled, options)


def driven(
    drives: Mapping[str, ArrayLike] | None,
    rates: Mapping[str, ArrayLike] | None,
    accelerations: Mapping[str, ArrayLike] | None,
    branch: str,
    tolerance: float,
) -> DrivenPoses:
    """Arguments of `Linkage.move` as arrays, checked."""
    given = {"drives": drives, "rates": rates, "accelerations": accelerations}
    values, speeds, gains = (
        {name: finite(each, f"{what} of joint {name!r}") for name, each in found.items()}
        for what, found in zip(given, by_joint(**given), strict=True)
    )
    return DrivenPoses(values, speeds, gains, branch, tolerance)
